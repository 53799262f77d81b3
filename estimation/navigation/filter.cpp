// SPDX-License-Identifier: MIT
#include "filter.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::navigation {
namespace {

using earth::array;
using earth::vector;
using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kEarthRate{0, 0, earth::wgs84::kEarthRate};

double gate_limit(double false_alarm, int rows) {
  if (false_alarm == 0) return std::numeric_limits<double>::infinity();
  return quantile(complement(boost::math::chi_squared(rows), false_alarm));
}

void check(const Filter::Options& options, int states, const StateMatrix& P0) {
  if (P0.rows() != states || P0.cols() != states)
    throw std::invalid_argument(fmt::format("initial covariance of {} x {}, expected {} x {} for the model's states",
                                            P0.rows(), P0.cols(), states, states));
  if (!(options.gate_false_alarm >= 0 && options.gate_false_alarm < 1))
    throw SetupError(fmt::format("gate's false alarm is {}, expected 0 to below 1", options.gate_false_alarm));
  if (!(options.covariance_interval >= 0) || !std::isfinite(options.covariance_interval))
    throw SetupError(fmt::format("covariance interval is {} s, expected 0 or more", options.covariance_interval));
  const Robust& robust = options.robust;
  if (robust.kind != Robust::Kind::none && !(robust.parameter > 0 && std::isfinite(robust.parameter)))
    throw SetupError(fmt::format("parameter of robust updates is {}, expected above 0", robust.parameter));
}

bool multiplies(const ErrorTerm& term) { return term.carrier != Carrier::aid && term.effect != Effect::bias; }

}  // namespace

double Robust::weight(int rows, double nis) const {
  switch (kind) {
    case Kind::huber:
      return std::min(1.0, parameter / std::sqrt(nis / rows));
    case Kind::student:
      return (parameter + rows) / (parameter + nis);
    case Kind::none:
      break;
  }
  return 1;
}

Filter::Filter(const earth::Pose& start, ErrorStateModel model, const StateMatrix& P0)
    : Filter(start, std::move(model), P0, Options{}) {}

Filter::Filter(const earth::Pose& start, ErrorStateModel model, const StateMatrix& P0, const Options& options)
    : options_(options),
      lineariser_(std::move(model)),
      covariance_(P0, options.form),
      strapdown_(start, options.strapdown),
      terms_(StateVector::Zero(lineariser_.states() - kCoreStates)) {
  check(options, lineariser_.states(), P0);
  decay_ = mean_decay_ = StateVector::Ones(terms_.size());
  for (std::size_t k = 0; k < this->model().terms.size(); ++k) {
    considered_[kCoreStates + k] = this->model().terms[k].considered;
    scaled_ |= multiplies(this->model().terms[k]);
  }
  for (int rows = 1; rows <= 3; ++rows)
    gate_[static_cast<std::size_t>(rows)] = gate_limit(options.gate_false_alarm, rows);
}

void Filter::set_step(double dt) {
  if (dt == step_dt_) return;
  for (Eigen::Index k = 0; k < terms_.size(); ++k) {
    const ErrorTerm& term = model().terms[static_cast<std::size_t>(k)];
    decay_[k] = decay(term, dt);
    mean_decay_[k] = mean_decay(term, dt);
  }
  step_dt_ = dt;
}

// Less what the terms add. Those that multiply do so with the true signal: one repetition takes the error of
// using the measured one from the square of a term to its cube.
noise::ImuIncrement Filter::corrected(const noise::ImuIncrement& imu, double dt) const {
  if (terms_.size() == 0) return imu;
  const StateVector mean = terms_.cwiseProduct(mean_decay_);
  const Vector3d w = vector(imu.angle) / dt, f = vector(imu.velocity) / dt;
  SensorCorrection errors = sensor_errors(model().terms, mean.data(), w, f);
  if (scaled_) errors = sensor_errors(model().terms, mean.data(), w - errors.gyro, f - errors.accelerometer);
  return {.angle = array(vector(imu.angle) - dt * errors.gyro),
          .velocity = array(vector(imu.velocity) - dt * errors.accelerometer)};
}

void Filter::propagate(const noise::ImuIncrement& measured, double dt) {
  if (dt == 0) return;
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("step of {} s at {} s: time must run forwards and be finite", dt, time_));
  if (!vector(measured.angle).allFinite() || !vector(measured.velocity).allFinite())
    throw std::invalid_argument(fmt::format("IMU increment at {} s is not finite", time_));
  set_step(dt);
  const noise::ImuIncrement imu = corrected(measured, dt);
  if (!vector(imu.angle).allFinite() || !vector(imu.velocity).allFinite())
    throw Diverged(fmt::format("what is estimated of the IMU's errors at {} s leaves no finite increment", time_));
  const Eigen::Quaterniond before = strapdown_.state().q_eb;
  if (pending_.dt == 0) {
    pending_.q_start = before;
    pending_.p_start = strapdown_.state().p_eb_e;
  }
  strapdown_.step(imu, dt);
  terms_ = terms_.cwiseProduct(decay_);
  time_ += dt;

  pending_.dt += dt;
  if (motion_unknown_) pending_.unknown += dt * unknown_;
  pending_.velocity_e += dt * strapdown_.last_specific_force_e();
  pending_.angle_b += vector(imu.angle);
  w_eb_b_ = vector(imu.angle) / dt - strapdown_.state().q_eb.conjugate() * kEarthRate;
  // Half a step early rather than half a step late, where steps do not divide the interval.
  if (pending_.dt + dt / 2 >= options_.covariance_interval) catch_up();
}

void Filter::catch_up() {
  if (pending_.dt == 0) return;
  const double dt = pending_.dt;
  Eigen::Quaterniond middle = strapdown_.state().q_eb;
  const double sign = middle.dot(pending_.q_start) < 0 ? -1 : 1;
  middle.coeffs() = (middle.coeffs() + sign * pending_.q_start.coeffs()).normalized();
  StepInput step;
  step.dt = dt;
  step.p_eb_e = (pending_.p_start + strapdown_.state().p_eb_e) / 2;
  step.C_eb = middle.toRotationMatrix();
  step.w_ib_b = pending_.angle_b / dt;
  step.f_ib_b = step.C_eb.transpose() * pending_.velocity_e / dt;
  step.unknown = pending_.unknown / dt;
  const Transition& transition = lineariser_(step);
  covariance_.propagate(transition);
  if (record_ != nullptr) record_->moved(transition);
  pending_ = {};
}

Estimate Filter::estimate() const {
  Estimate estimate;
  earth::Motion& motion = estimate.motion;
  motion.pose = strapdown_.state();
  motion.w_eb_b = w_eb_b_;
  if (time_ > 0)
    motion.a_eb_e = strapdown_.last_specific_force_e() + earth::normal_gravity(motion.pose.p_eb_e) -
                    2 * kEarthRate.cross(motion.pose.v_eb_e);
  estimate.model = &model();
  estimate.terms = terms_.data();
  return estimate;
}

// Joint covariance of the innovations, before any row is used.
void Filter::expect(const Measurement& measurement, Innovation& innovation) const {
  const int rows = measurement.rows;
  Matrix3d S = Matrix3d::Identity();
  for (int i = 0; i < rows; ++i) {
    const StateVector ph = covariance_.times(measurement.row[static_cast<std::size_t>(i)].h);
    for (int j = 0; j < rows; ++j) S(j, i) = measurement.row[static_cast<std::size_t>(j)].h.dot(ph);
    S(i, i) += measurement.row[static_cast<std::size_t>(i)].variance;
  }
  innovation.sigma.head(rows) = S.diagonal().head(rows).cwiseSqrt();
  Vector3d residual = Vector3d::Zero();
  residual.head(rows) = measurement.residual.head(rows);
  const Eigen::LDLT<Matrix3d> factors = S.ldlt();  // the rows that there are not are those of the identity
  innovation.nis = residual.dot(factors.solve(residual));
  innovation.log_det = factors.vectorD().array().log().sum();
}

Innovation Filter::update(const Measurement& measurement) {
  Innovation innovation;
  innovation.rows = measurement.rows;
  innovation.residual = measurement.residual;
  bool finite = measurement.residual.head(measurement.rows).allFinite();
  for (int i = 0; i < measurement.rows; ++i)
    finite &= measurement.row[static_cast<std::size_t>(i)].h.allFinite() &&
              std::isfinite(measurement.row[static_cast<std::size_t>(i)].variance);
  if (!finite) {
    innovation.status = Innovation::Status::not_finite;
    return innovation;
  }
  catch_up();
  expect(measurement, innovation);
  if (!(innovation.nis <= gate_[static_cast<std::size_t>(measurement.rows)])) {
    innovation.status = Innovation::Status::gated;
    return innovation;
  }
  StateVector x = StateVector::Zero(covariance_.size());
  const std::span<const bool> considered(considered_.data(), static_cast<std::size_t>(covariance_.size()));
  innovation.weight = options_.robust.weight(measurement.rows, innovation.nis);
  for (int i = 0; i < measurement.rows; ++i) {
    MeasurementRow row = measurement.row[static_cast<std::size_t>(i)];
    row.variance /= innovation.weight;
    const double residual = measurement.residual[i] - row.h.dot(x);
    const double S = record_ != nullptr ? row.h.dot(covariance_.times(row.h)) + row.variance : 0;
    const StateVector gain = covariance_.update(row, considered);
    if (record_ != nullptr) record_->updated(row, S, residual, gain);
    x += residual * gain;
  }
  correct(x);
  return innovation;
}

void Filter::set_unknown_motion(const Vector3d& rate, const Vector3d& force) {
  unknown_ << rate.array().square(), force.array().square();
  motion_unknown_ = (unknown_.array() > 0).any();
}

void Filter::restart(const StateMatrix& P) {
  catch_up();
  check(options_, lineariser_.states(), P);
  covariance_ = Covariance(P, options_.form);
  record_ = nullptr;
}

void Filter::record(FilterHistory* record) {
  if (record != nullptr && record->states() != covariance_.size())
    throw std::invalid_argument(
        fmt::format("record of {} states for a filter of {}", record->states(), covariance_.size()));
  if (record != nullptr && std::find(considered_.begin(), considered_.end(), true) != considered_.end())
    throw SetupError("a filter with considered states cannot be smoothed: its gains are not optimal");
  catch_up();
  record_ = record;
}

void Filter::keep_epoch() {
  if (record_ == nullptr) throw std::logic_error("an epoch is kept in a record, and the filter has none");
  catch_up();
  record_->keep(time_, strapdown_.state(), terms_, covariance_.matrix());
}

void Filter::correct(const StateVector& x) {
  earth::Pose state = strapdown_.state();
  state.p_eb_e += x.segment<3>(kPosition);
  state.v_eb_e += x.segment<3>(kVelocity);
  state.q_eb = (earth::exp_rotation(x.segment<3>(kAttitude)) * state.q_eb).normalized();
  if (!state.v_eb_e.allFinite() || !state.q_eb.coeffs().allFinite() || !x.allFinite())
    throw Diverged(fmt::format("the correction at {} s is not finite", time_));
  strapdown_.set_state(state);
  terms_ += x.tail(terms_.size());
}

}  // namespace gyrobudget::inline v0::navigation

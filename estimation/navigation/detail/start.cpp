// SPDX-License-Identifier: MIT
#include "start.h"

#include "gyrobudget/earth/attitude.h"
#include "gyrobudget/earth/frames.h"
#include "gyrobudget/earth/gravity.h"
#include "gyrobudget/navigation/alignment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace gyrobudget::inline v0::navigation::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kNanosecond = 1e-9;

double log_start(const ImuLog& imu, std::int64_t origin) {
  return static_cast<double>(imu.stamps.front() - origin) * kNanosecond;
}
double log_end(const ImuLog& imu, std::int64_t origin) {
  return static_cast<double>(imu.stamps.back() - origin) * kNanosecond;
}

template <class Variant>
const FromAid* from_aid(const Variant& v) {
  return std::get_if<FromAid>(&v);
}

// What a fix says where an aid gives the quantity, else what the scene says.
template <class Variant>
const Fix* fix_at(const Variant& v, const std::vector<FixTrack>& tracks, double t, std::optional<Fix>& kept) {
  const FromAid* from = from_aid(v);
  if (from == nullptr) return nullptr;
  kept = tracks[from->aid].at(t);
  return kept ? &*kept : nullptr;
}

// --- The IMU at rest -----------------------------------------------------------------------------------------

struct AtRest {
  Quaterniond q_nb;
  Matrix3d covariance;                             ///< of psi, east, north, up
  Eigen::Matrix<double, 3, Eigen::Dynamic> cross;  ///< of psi with the model's terms
  std::string message;
};

struct Piece {
  std::span<const earth::ImuIncrement> increments;
  double seconds = 0;
};

// The samples whose middle lies in the span.
Piece piece_of(const Recording& recording, const Span& span) {
  const ImuLog& imu = recording.imu;
  std::size_t first = imu.increments.size(), last = 0;
  for (std::size_t k = 0; k < imu.increments.size(); ++k) {
    const double middle =
        static_cast<double>(imu.stamps[k] - recording.origin + (imu.stamps[k + 1] - imu.stamps[k]) / 2) *
        kNanosecond;
    if (middle < span.from || middle > span.to) continue;
    first = std::min(first, k);
    last = k + 1;
  }
  if (first >= last) return {};
  return {std::span(imu.increments).subspan(first, last - first),
          static_cast<double>(imu.stamps[last] - imu.stamps[first]) * kNanosecond};
}

// psi of the alignment is J times the biases it assumed, plus the rest. The model's terms are these biases where the
// alignment ends, with a variance that may differ: psi then moves with them by the same J. What the alignment assumed
// beyond them, how the bias moved in its course, stays.
void correlate(const Alignment& alignment, Carrier carrier, const ErrorStateModel& model,
               const StateMatrix& terms, AtRest& result) {
  const bool gyro = carrier == Carrier::gyro;
  const Matrix3d& with = gyro ? alignment.gyro_bias_covariance : alignment.accelerometer_bias_covariance;
  const Vector3d& assumed = gyro ? alignment.gyro_bias_variance : alignment.accelerometer_bias_variance;
  for (int axis = 0; axis < 3; ++axis) {
    if (assumed[axis] == 0) continue;
    const Vector3d J = with.col(axis) / assumed[axis];
    StateVector pick = StateVector::Zero(terms.cols());
    for (std::size_t k = 0; k < model.terms.size(); ++k) {
      const ErrorTerm& term = model.terms[k];
      if (term.carrier == carrier && term.effect == Effect::bias && term.axis == axis)
        pick[static_cast<Eigen::Index>(k)] = 1;
    }
    const StateVector covariance = terms * pick;
    result.cross += J * covariance.transpose();
    result.covariance += J * J.transpose() * std::max(0.0, pick.dot(covariance) - assumed[axis]);
  }
}

// By which an accelerometer that senses gravity may be off, one sigma.
double sigma_of_force(const noise::SensorModel& sensor, double gravity) {
  if (!sensor.accelerometer) return 0;
  const auto largest = [](const std::optional<noise::PerAxis>& value) {
    return value ? std::max({(*value)[0], (*value)[1], (*value)[2]}) : 0;
  };
  return std::hypot(largest(sensor.accelerometer->turn_on_bias),
                    gravity * largest(sensor.accelerometer->scale_factor));
}

std::variant<NoStart, AtRest> align_at_rest(const Scenario& scenario, const Recording& recording,
                                            const Span& span, const Vector3d& p_eb_e,
                                            const ErrorStateModel& model, const StateMatrix& terms) {
  const auto& self = std::get<SelfAlignment>(scenario.alignment.attitude);
  const Piece piece = piece_of(recording, span);
  constexpr std::size_t kFewest = 12;
  if (piece.increments.size() < kFewest)
    return NoStart{Run::Status::no_start,
                   fmt::format("{} IMU samples from {:g} s to {:g} s, the alignment needs {}",
                               piece.increments.size(), span.from, span.to, kFewest)};
  AlignmentOptions options;
  options.sensor = scenario.sensor;
  options.latitude = earth::to_geodetic(p_eb_e).latitude;
  const double dt = piece.seconds / static_cast<double>(piece.increments.size());
  Alignment found = align(piece.increments, dt, options);
  if (self.heading) {
    constexpr double kNearlyUp = 0.9;
    const bool nose_up = std::abs(found.up_b.x()) > kNearlyUp;
    options.heading = GivenHeading{*self.heading, scenario.alignment.heading_sigma.value_or(0),
                                   nose_up ? Vector3d::UnitZ() : Vector3d::UnitX()};
    found = align(piece.increments, dt, options);
  }
  const double force = found.means.f_ib_b.norm(), gravity = earth::normal_gravity(p_eb_e).norm();
  // Gravity's anomalies, and what the sensor may read wrong.
  constexpr double kAnomaly = 1e-3, kSigmas = 5;
  const double may_err = kAnomaly * gravity + kSigmas * sigma_of_force(scenario.sensor, gravity);
  if (!(std::abs(force - gravity) < may_err)) {
    return NoStart{
        Run::Status::not_at_rest,
        fmt::format(
            "over the {:g} s of the alignment the mean specific force is {:.5f} m/s^2 and gravity {:.5f}, "
            "more apart than the {:.2g} m/s^2 that this sensor may be off at rest; look at units and "
            "axes of the log, or align where the body stands",
            piece.seconds, force, gravity, may_err)};
  }
  if (!found.q_nb)
    return NoStart{
        Run::Status::heading_not_observable,
        found.message + " The alignment takes heading and heading_sigma, or the attitude of an aid."};
  AtRest result{*found.q_nb, found.covariance, decltype(AtRest::cross)::Zero(3, terms.cols()), found.message};
  correlate(found, Carrier::gyro, model, terms, result);
  correlate(found, Carrier::accelerometer, model, terms, result);
  return result;
}

// --- Putting it together -------------------------------------------------------------------------------------

Matrix3d squares(const Vector3d& sigma, const Matrix3d& axes) {
  return axes * sigma.cwiseAbs2().asDiagonal() * axes.transpose();
}

struct Place {
  Matrix3d C_enu, C_ned;
};

Place axes_at(const Vector3d& p_eb_e) {
  const earth::Geodetic at = earth::to_geodetic(p_eb_e);
  return {earth::C_e_enu(at.latitude, at.longitude), earth::C_e_ned(at.latitude, at.longitude)};
}

// Attitude from an aid or as given, with the covariance of psi in ECEF axes.
Quaterniond given_attitude(const Scenario& scenario, const std::vector<FixTrack>& tracks, double t,
                           const Vector3d& p_eb_e, Matrix3d& covariance) {
  const AlignmentPlan& a = scenario.alignment;
  const Place axes = axes_at(p_eb_e);
  std::optional<Fix> kept;
  double level = 0, heading = 0;
  Quaterniond q_nb = Quaterniond::Identity();
  if (const Fix* fix = fix_at(a.attitude, tracks, t, kept)) {
    q_nb = fix->q_nb;
    level = heading = total_sigma(scenario.aids[from_aid(a.attitude)->aid]).maxCoeff();
  } else if (const auto* euler = std::get_if<earth::Euler>(&a.attitude)) {
    q_nb = earth::from_euler(*euler);
  }
  level = a.level_sigma.value_or(level);
  heading = a.heading_sigma.value_or(heading);
  covariance = squares({level, level, heading}, axes.C_enu);
  return to_ecef_axes(q_nb, p_eb_e);
}

void say_attitude(AlignmentResult& result, const Quaterniond& q_nb, const Matrix3d& covariance_enu) {
  const earth::Euler euler = earth::to_euler(q_nb);
  result.words.push_back(
      fmt::format("heading {:.3f} deg, pitch {:.3f} deg, roll {:.3f} deg at {:g} s; one sigma {:.3g} deg in "
                  "heading, {:.3g} deg "
                  "in level",
                  euler.yaw / earth::kDegree, euler.pitch / earth::kDegree, euler.roll / earth::kDegree,
                  result.to, std::sqrt(covariance_enu(2, 2)) / earth::kDegree,
                  std::sqrt(std::max(covariance_enu(0, 0), covariance_enu(1, 1))) / earth::kDegree));
}

}  // namespace

std::variant<NoStart, Span> start_span(const Scenario& scenario, const ImuLog& imu,
                                       const std::vector<FixTrack>& tracks, std::int64_t origin) {
  const AlignmentPlan& a = scenario.alignment;
  double from = std::max(a.start, log_start(imu, origin));
  std::string missing;
  const auto wait_for = [&](const FromAid* aid) {
    if (aid == nullptr) return;
    const FixTrack& track = tracks[aid->aid];
    const std::size_t first = track.first_from(from);
    if (first == track.size())
      missing = scenario.aids[aid->aid].name;
    else
      from = track.time(first);
  };
  wait_for(from_aid(a.attitude));
  wait_for(from_aid(a.velocity));
  wait_for(from_aid(a.position));
  if (!missing.empty())
    return NoStart{Run::Status::no_start,
                   fmt::format("{} has no fix from {:g} s on, which the alignment needs", missing, from)};
  const auto* self = std::get_if<SelfAlignment>(&a.attitude);
  const double end = std::min(scenario.until, log_end(imu, origin));
  if (from >= end)
    return NoStart{Run::Status::no_start,
                   fmt::format("the alignment starts at {:g} s, where the log ends at {:g} s", from, end)};
  const Span span{from, self != nullptr ? std::min(from + self->duration, end) : from};
  return span;
}

std::variant<NoStart, Start> start(const Scenario& scenario, const Recording& recording,
                                   const std::vector<FixTrack>& tracks, const Span& span,
                                   const ErrorStateModel& model, const StateMatrix& terms) {
  const AlignmentPlan& a = scenario.alignment;
  Start result;
  AlignmentResult& r = result.result;
  r.from = span.from;
  r.to = span.to;
  std::optional<Fix> kept;
  Vector3d position_sigma = Vector3d::Zero(), velocity_sigma = Vector3d::Zero();
  if (const Fix* fix = fix_at(a.position, tracks, span.to, kept)) {
    r.state.p_eb_e = fix->value;
    position_sigma = total_sigma(scenario.aids[from_aid(a.position)->aid]);
  } else if (const auto* place = std::get_if<earth::Geodetic>(&a.position)) {
    r.state.p_eb_e = earth::to_ecef(*place);
  } else {
    return NoStart{Run::Status::no_start,
                   "the aid that gives the position has no fix where the alignment ends"};
  }
  const Place axes = axes_at(r.state.p_eb_e);
  if (const Fix* fix = fix_at(a.velocity, tracks, span.to, kept)) {
    r.state.v_eb_e = axes.C_ned * fix->value;
    velocity_sigma = total_sigma(scenario.aids[from_aid(a.velocity)->aid]);
  } else if (const auto* v_n = std::get_if<Vector3d>(&a.velocity)) {
    r.state.v_eb_e = axes.C_ned * *v_n;
  } else {
    return NoStart{Run::Status::no_start,
                   "the aid that gives the velocity has no fix where the alignment ends"};
  }
  CoreMatrix& P = r.covariance;
  P.block<3, 3>(kPosition, kPosition) = squares(a.position_sigma.value_or(position_sigma), axes.C_enu);
  P.block<3, 3>(kVelocity, kVelocity) = squares(a.velocity_sigma.value_or(velocity_sigma), axes.C_enu);

  Eigen::Matrix<double, 3, Eigen::Dynamic> cross = decltype(cross)::Zero(3, terms.cols());
  Matrix3d psi;
  if (std::holds_alternative<SelfAlignment>(a.attitude)) {
    auto aligned = align_at_rest(scenario, recording, span, r.state.p_eb_e, model, terms);
    if (auto* no = std::get_if<NoStart>(&aligned)) return *no;
    const auto& at_rest = std::get<AtRest>(aligned);
    r.state.q_eb = to_ecef_axes(at_rest.q_nb, r.state.p_eb_e);
    psi = axes.C_enu * at_rest.covariance * axes.C_enu.transpose();
    cross = axes.C_enu * at_rest.cross;
    if (!at_rest.message.empty()) r.words.push_back(at_rest.message);
  } else {
    r.state.q_eb = given_attitude(scenario, tracks, span.to, r.state.p_eb_e, psi);
  }
  P.block<3, 3>(kAttitude, kAttitude) = psi;
  result.P0 = initial_covariance(P, terms);
  result.P0.block(kAttitude, kCoreStates, 3, terms.cols()) = cross;
  result.P0.block(kCoreStates, kAttitude, terms.rows(), 3) = cross.transpose();
  if (std::min(scenario.until, log_end(recording.imu, recording.origin)) <= span.to)
    r.words.emplace_back("the log ends with the alignment: there is nothing to navigate");
  say_attitude(r, Quaterniond(axes.C_ned).conjugate() * r.state.q_eb,
               axes.C_enu.transpose() * psi * axes.C_enu);
  return result;
}

}  // namespace gyrobudget::inline v0::navigation::detail

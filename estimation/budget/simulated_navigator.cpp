// SPDX-License-Identifier: MIT
#include "simulated_navigator.h"

#include "gyrobudget/estimation/navigation/alignment.h"
#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::budget {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Streams of random numbers beside the IMU's own: 'M', what it is for, the run.
constexpr std::uint64_t kStart = 1, kAids = 2;
constexpr double kAnyHeading = 1e3;  // [rad] limit that no alignment reaches: the filter judges
noise::StreamKey key(std::uint64_t seed, std::uint64_t what, std::uint64_t run) {
  return {seed, (std::uint64_t{'M'} << 56) | (what << 48) | run};
}

std::vector<noise::ImuIncrement> exact_increments(const Timeline& timeline, double interval) {
  const earth::Pose start = timeline.at(timeline.start()).pose;
  const Matrix3d C_be = start.q_eb.toRotationMatrix().transpose();
  const noise::ImuIncrement rest{.angle = earth::array(interval * (C_be * Vector3d(0, 0, earth::wgs84::kEarthRate))),
                                 .velocity = earth::array(-interval * (C_be * earth::normal_gravity(start.p_eb_e)))};
  const auto pad = static_cast<std::size_t>(std::llround(-timeline.start() / interval));
  std::vector<noise::ImuIncrement> all(pad, rest);
  const auto flown = timeline.trajectory().increments(interval);
  all.insert(all.end(), flown.begin(), flown.end());
  return all;
}

// The same fix with the true values of another instant.
struct AtTruth {
  const earth::Motion& at;

  navigation::PositionFix operator()(navigation::PositionFix fix) const {
    fix.p_eb_e = at.pose.p_eb_e + at.pose.q_eb * fix.lever_arm;
    return fix;
  }
  navigation::VelocityFix operator()(navigation::VelocityFix fix) const {
    fix.v_eb_e = at.pose.v_eb_e + at.pose.q_eb * at.w_eb_b.cross(fix.lever_arm);
    return fix;
  }
  navigation::HeightFix operator()(navigation::HeightFix fix) const {
    fix.height = earth::to_geodetic(at.pose.p_eb_e).height;
    return fix;
  }
  navigation::AttitudeFix operator()(navigation::AttitudeFix fix) const {
    fix.q_eb = at.pose.q_eb;
    return fix;
  }
};

Eigen::MatrixXd root(const Eigen::MatrixXd& covariance) {
  const Eigen::LDLT<Eigen::MatrixXd> factors{covariance};
  return factors.transpositionsP().transpose() * Eigen::MatrixXd(factors.matrixL()) *
         factors.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal().toDenseMatrix();
}

void check(const Timeline& timeline, const MonteCarlo::Options& options) {
  if (options.runs < 1) throw navigation::SetupError(fmt::format("{} runs, expected 1 or more", options.runs));
  if (!(options.imu_interval > 0))
    throw navigation::SetupError(fmt::format("IMU interval of {} s, expected above 0", options.imu_interval));
  if (!(options.imu_interval <= timeline.end()))
    throw navigation::SetupError(fmt::format("IMU interval of {} s, expected at most the {} s of the trajectory",
                                             options.imu_interval, timeline.end()));
}

}  // namespace

SimulatedScene::SimulatedScene(Timeline timeline, noise::SensorModel sensor, const InitialErrors& initial,
                               const Matrix3d& C_el, std::optional<Design> design, MonteCarlo::AidErrors aids,
                               MonteCarlo::Options options) {
  check(timeline, options);
  auto parts = std::make_shared<Parts>(Parts{.timeline = std::move(timeline),
                                             .sensor = std::move(sensor),
                                             .initial = initial,
                                             .C_el = C_el,
                                             .design = std::move(design),
                                             .aids = std::move(aids),
                                             .options = std::move(options)});
  const Timeline& flown = parts->timeline;
  parts->increments = exact_increments(flown, parts->options.imu_interval);
  for (const Source& source : parts->options.world) parts->add_world(source);
  parts->aid_root = root(parts->aids.initial);
  for (const navigation::PlannedFix& fix : parts->aids.starts) {
    navigation::StartFromFix from = navigation::start_from(fix, flown.at(flown.start()), parts->aids.model);
    Eigen::MatrixXd white = root(from.white);
    parts->taken.push_back({std::move(from), std::move(white), navigation::aid_of(fix)});
  }
  parts_ = std::move(parts);
}

std::size_t SimulatedScene::sample(double time) const {
  const auto nearest = std::llround((time - parts_->timeline.start()) / parts_->options.imu_interval);
  return std::min(static_cast<std::size_t>(nearest), parts_->increments.size());
}

double SimulatedScene::time(std::size_t sample) const {
  const auto pad = std::llround(-parts_->timeline.start() / parts_->options.imu_interval);
  const double t = static_cast<double>(static_cast<std::int64_t>(sample) - pad) * parts_->options.imu_interval;
  return std::min(t, parts_->timeline.end());
}

// The vectors of a source of the world along all samples.
void SimulatedScene::Parts::add_world(const Source& source) {
  const double dt = options.imu_interval;
  const std::size_t vectors = source.model.terms.size() / 3;
  for (std::size_t v = 0; v < vectors; ++v) world.push_back({source.model.terms[3 * v].carrier, {}});
  for (std::size_t k = 0; k < increments.size(); ++k) {
    const double t = timeline.start() + (static_cast<double>(k) + 0.5) * dt;
    const earth::Motion at = timeline.at(std::min(t, timeline.end()));
    navigation::StepInput input;
    input.t = t - timeline.start();
    input.p_eb_e = at.pose.p_eb_e;
    input.C_eb = at.pose.q_eb.toRotationMatrix();
    for (std::size_t v = 0; v < vectors; ++v)
      world[world.size() - vectors + v].unit.emplace_back(
          dt * Vector3d(source.shape(input, 3 * v), source.shape(input, 3 * v + 1), source.shape(input, 3 * v + 2)));
  }
}

SimulatedNavigator::SimulatedNavigator(SimulatedScene scene, std::uint64_t run)
    : scene_(std::move(scene)),
      start_(key(parts().options.seed, kStart, run)),
      aids_(key(parts().options.seed, kAids, run)),
      imu_(parts().sensor, parts().options.imu_interval, {parts().options.seed, run}, parts().options.imu) {
  const SimulatedScene::Parts& all = parts();
  earth::Pose start = wrong_start();
  for (std::size_t v = 0; v < all.world.size(); ++v) world_.push_back(start_());
  Eigen::VectorXd draw(all.aid_root.rows());
  for (auto& x : draw) x = aids_();
  aid_terms_ = all.aid_root * draw;
  take_start(start);
  if (all.options.self_alignment) {
    const auto found = coarse_alignment();
    aligned_ = found.has_value();
    start.q_eb = found.value_or(start.q_eb);
  }
  if (all.design)
    filter_.emplace(start, all.design->model, all.design->initial, all.options.filter);
  else
    strapdown_.emplace(start, all.options.filter.strapdown);
}

double SimulatedNavigator::Normals::operator()() {
  if (next_ == buffer_.size()) {
    noise::fill_normal(stream_, drawn_, buffer_);
    drawn_ += buffer_.size();
    next_ = 0;
  }
  return buffer_[next_++];
}

noise::ImuIncrement SimulatedNavigator::measure_imu(const noise::ImuIncrement& truth, std::size_t sample) {
  noise::ImuIncrement measured = imu_.next(truth);
  sample = std::min(sample, parts().increments.size() - 1);  // a flight may outlive its plan
  for (std::size_t v = 0; v < parts().world.size(); ++v)
    earth::vector(parts().world[v].carrier == navigation::Carrier::gyro ? measured.angle : measured.velocity) +=
        world_[v] * parts().world[v].unit[sample];
  return measured;
}

// Coarse alignment on what is read on the pad, which is kept for the filter.
// None where heading is neither observable nor given.
std::optional<Eigen::Quaterniond> SimulatedNavigator::coarse_alignment() {
  const std::size_t samples = scene_.pad_samples();
  pad_.reserve(samples);
  for (std::size_t k = 0; k < samples; ++k) pad_.push_back(measure_imu(parts().increments[k], k));
  const earth::Pose truth = parts().timeline.at(parts().timeline.start()).pose;
  const earth::Geodetic at = earth::to_geodetic(truth.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
  navigation::AlignmentOptions options;
  options.sensor = parts().sensor;
  options.latitude = at.latitude;
  options.heading_limit = kAnyHeading;
  if (parts().options.heading_sigma) {
    navigation::GivenHeading& given = options.heading.emplace(
        navigation::heading_of(Eigen::Quaterniond(C_en).conjugate() * truth.q_eb, *parts().options.heading_sigma));
    given.azimuth += parts().initial.heading * start_();
  }
  const navigation::Alignment found = navigation::align(pad_, parts().options.imu_interval, options);
  if (!found.q_nb) return std::nullopt;
  return Eigen::Quaterniond(C_en) * *found.q_nb;
}

earth::Pose SimulatedNavigator::wrong_start() {
  earth::Pose state = parts().timeline.at(parts().timeline.start()).pose;
  const auto draw = [&](const Vector3d& sigma) -> Vector3d {
    Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = sigma[i] * start_();
    return parts().C_el * v;
  };
  const InitialErrors& e = parts().initial;
  const Vector3d p = draw(e.position), v = draw(e.velocity), psi = draw({e.level, e.level, e.heading});
  state.p_eb_e -= p;  // errors are truth minus estimate
  state.v_eb_e -= v;
  state.q_eb = earth::exp_rotation(-psi) * state.q_eb;
  return state;
}

// What the fixes that the start is taken from have wrong, it has.
void SimulatedNavigator::take_start(earth::Pose& state) {
  for (const auto& [from, white, aid] : parts().taken) {
    Eigen::VectorXd draw(white.cols());
    for (auto& x : draw) x = aids_();
    if (!noisy(aid)) draw.setZero();
    const Eigen::VectorXd error = from.by_terms * aid_terms_ + white * draw;
    state.p_eb_e -= error.segment<3>(navigation::kPosition);
    state.v_eb_e -= error.segment<3>(navigation::kVelocity);
    state.q_eb = earth::exp_rotation(-error.segment<3>(navigation::kAttitude)) * state.q_eb;
  }
}

void SimulatedNavigator::step(const noise::ImuIncrement& exact) {
  sensed_ = samples_ < pad_.size() ? pad_[samples_] : measure_imu(exact, samples_);
  const double dt = parts().options.imu_interval;
  filter_ ? filter_->propagate(sensed_, dt) : strapdown_->step(sensed_, dt);
  move_aids();
  ++samples_;
}

void SimulatedNavigator::pass_pad() {
  const auto rest = parts().timeline.at(parts().timeline.start());
  for (; samples_ < scene_.pad_samples(); step(parts().increments[samples_]))
    if (fix_due()) use_fixes(rest);
  if (fix_due()) use_fixes(rest);
}

bool SimulatedNavigator::fix_due() const {
  const auto& fixes = parts().timeline.fixes();
  return next_fix_ < fixes.size() && scene_.sample(fixes[next_fix_].time) <= samples_;
}

void SimulatedNavigator::use_fixes(const earth::Motion& truth) {
  for (; fix_due(); ++next_fix_)
    if (filter_) use(parts().timeline.fixes()[next_fix_], truth);
}

// The fix as the aid gives it: truth, its own errors by what they do to it, and white noise.
void SimulatedNavigator::use(const navigation::PlannedFix& planned, const earth::Motion& truth) {
  navigation::Measurement measurement = std::visit(
      [&](const auto& fix) { return navigation::measure(AtTruth{truth}(fix), filter_->estimate()); }, planned.fix);
  const navigation::Measurement of_errors = navigation::linearise(planned, truth, parts().aids.model);
  for (int i = 0; i < measurement.rows; ++i) {
    const auto& row = of_errors.row[static_cast<std::size_t>(i)];
    const double white = std::sqrt(row.variance) * aids_();
    if (noisy(navigation::aid_of(planned))) measurement.residual[i] += white;
    measurement.residual[i] += row.h.tail(aid_terms_.size()).dot(aid_terms_);
  }
  ++fixes_.given;
  if (filter_->update(measurement).status != navigation::Innovation::Status::used) ++fixes_.refused;
}

void SimulatedNavigator::move_aids() {
  const double dt = parts().options.imu_interval;
  for (Eigen::Index k = 0; k < aid_terms_.size(); ++k) {
    const navigation::ErrorTerm& term = parts().aids.model.terms[static_cast<std::size_t>(k)];
    if (term.walk == 0) continue;
    const double phi = navigation::decay(term, dt), h2 = navigation::mean_decay(term, 2 * dt);
    aid_terms_[k] = phi * aid_terms_[k] + term.walk * std::sqrt(dt * h2) * aids_();
  }
}

Saturated SimulatedNavigator::saturated() const { return {imu_.gyro_saturated(), imu_.accelerometer_saturated()}; }

}  // namespace gyrobudget::inline v0::budget

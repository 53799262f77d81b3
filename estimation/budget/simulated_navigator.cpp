// SPDX-License-Identifier: MIT
#include "simulated_navigator.h"

#include "gyrobudget/estimation/navigation/alignment.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
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
  if (options.runs < 1) throw std::invalid_argument(fmt::format("{} runs, expected 1 or more", options.runs));
  if (!(options.imu_interval > 0))
    throw std::invalid_argument(fmt::format("IMU interval of {} s, expected above 0", options.imu_interval));
  if (!(options.imu_interval <= timeline.end()))
    throw std::invalid_argument(fmt::format("IMU interval of {} s, expected at most the {} s of the trajectory",
                                            options.imu_interval, timeline.end()));
}

}  // namespace

SimulatedScene::SimulatedScene(const Timeline& timeline, const noise::SensorModel& sensor, const InitialErrors& initial,
                               const Matrix3d& C_el, const std::optional<Design>& design,
                               const MonteCarlo::AidErrors& aids, const MonteCarlo::Options& options)
    : timeline_(timeline),
      sensor_(sensor),
      initial_(initial),
      C_el_(C_el),
      design_(design),
      aids_(aids),
      options_(options) {
  check(timeline, options);
  increments_ = exact_increments(timeline, options.imu_interval);
  for (const Source& source : options.world) add_world(source);
  aid_root_ = root(aids.initial);
  for (const navigation::PlannedFix& fix : aids.starts) {
    navigation::StartFromFix from = navigation::start_from(fix, timeline.at(timeline.start()), aids.model);
    Eigen::MatrixXd white = root(from.white);
    taken_.push_back({std::move(from), std::move(white), navigation::aid_of(fix)});
  }
}

std::size_t SimulatedScene::sample(double time) const {
  const auto nearest = std::llround((time - timeline_.start()) / options_.imu_interval);
  return std::min(static_cast<std::size_t>(nearest), increments_.size());
}

double SimulatedScene::time(std::size_t sample) const {
  const auto pad = std::llround(-timeline_.start() / options_.imu_interval);
  const double t = static_cast<double>(static_cast<std::int64_t>(sample) - pad) * options_.imu_interval;
  return std::min(t, timeline_.end());
}

// The vectors of a source of the world along all samples.
void SimulatedScene::add_world(const Source& source) {
  const double dt = options_.imu_interval;
  const std::size_t vectors = source.model.terms.size() / 3;
  for (std::size_t v = 0; v < vectors; ++v) world_.push_back({source.model.terms[3 * v].carrier, {}});
  for (std::size_t k = 0; k < increments_.size(); ++k) {
    const double t = timeline_.start() + (static_cast<double>(k) + 0.5) * dt;
    const earth::Motion at = timeline_.at(std::min(t, timeline_.end()));
    navigation::StepInput input;
    input.p_eb_e = at.pose.p_eb_e;
    input.C_eb = at.pose.q_eb.toRotationMatrix();
    for (std::size_t v = 0; v < vectors; ++v)
      world_[world_.size() - vectors + v].unit.emplace_back(
          dt * Vector3d(source.shape(input, 3 * v), source.shape(input, 3 * v + 1), source.shape(input, 3 * v + 2)));
  }
}

SimulatedNavigator::SimulatedNavigator(const SimulatedScene& scene, std::uint64_t run)
    : scene_(scene),
      start_(key(scene.options_.seed, kStart, run)),
      aids_(key(scene.options_.seed, kAids, run)),
      imu_(scene.sensor_, scene.options_.imu_interval, {scene.options_.seed, run}, scene.options_.imu) {
  earth::Pose start = wrong_start();
  for (std::size_t v = 0; v < scene.world_.size(); ++v) world_.push_back(start_());
  Eigen::VectorXd draw(scene.aid_root_.rows());
  for (auto& x : draw) x = aids_();
  aid_terms_ = scene.aid_root_ * draw;
  take_start(start);
  if (scene.options_.self_alignment) {
    const auto found = coarse_alignment();
    aligned_ = found.has_value();
    start.q_eb = found.value_or(start.q_eb);
  }
  if (scene.design_)
    filter_.emplace(start, scene.design_->model, scene.design_->initial, scene.options_.filter);
  else
    strapdown_.emplace(start, scene.options_.filter.strapdown);
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
  sample = std::min(sample, scene_.increments_.size() - 1);  // a flight may outlive its plan
  for (std::size_t v = 0; v < scene_.world_.size(); ++v)
    earth::vector(scene_.world_[v].carrier == navigation::Carrier::gyro ? measured.angle : measured.velocity) +=
        world_[v] * scene_.world_[v].unit[sample];
  return measured;
}

// Coarse alignment on what is read on the pad, which is kept for the filter.
// None where heading is neither observable nor given.
std::optional<Eigen::Quaterniond> SimulatedNavigator::coarse_alignment() {
  const std::size_t samples = scene_.pad_samples();
  pad_.reserve(samples);
  for (std::size_t k = 0; k < samples; ++k) pad_.push_back(measure_imu(scene_.increments_[k], k));
  const earth::Pose truth = scene_.timeline_.at(scene_.timeline_.start()).pose;
  const earth::Geodetic at = earth::to_geodetic(truth.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
  navigation::AlignmentOptions options;
  options.sensor = scene_.sensor_;
  options.latitude = at.latitude;
  options.heading_limit = kAnyHeading;
  if (scene_.options_.heading_sigma) {
    navigation::GivenHeading& given = options.heading.emplace(
        navigation::heading_of(Eigen::Quaterniond(C_en).conjugate() * truth.q_eb, *scene_.options_.heading_sigma));
    given.azimuth += scene_.initial_.heading * start_();
  }
  const navigation::Alignment found = navigation::align(pad_, scene_.options_.imu_interval, options);
  if (!found.q_nb) return std::nullopt;
  return Eigen::Quaterniond(C_en) * *found.q_nb;
}

earth::Pose SimulatedNavigator::wrong_start() {
  earth::Pose state = scene_.timeline_.at(scene_.timeline_.start()).pose;
  const auto draw = [&](const Vector3d& sigma) -> Vector3d {
    Vector3d v;
    for (int i = 0; i < 3; ++i) v[i] = sigma[i] * start_();
    return scene_.C_el_ * v;
  };
  const InitialErrors& e = scene_.initial_;
  const Vector3d p = draw(e.position), v = draw(e.velocity), psi = draw({e.level, e.level, e.heading});
  state.p_eb_e -= p;  // errors are truth minus estimate
  state.v_eb_e -= v;
  state.q_eb = earth::exp_rotation(-psi) * state.q_eb;
  return state;
}

// What the fixes that the start is taken from have wrong, it has.
void SimulatedNavigator::take_start(earth::Pose& state) {
  for (const auto& [from, white, aid] : scene_.taken_) {
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
  const double dt = scene_.options_.imu_interval;
  filter_ ? filter_->propagate(sensed_, dt) : strapdown_->step(sensed_, dt);
  move_aids();
  ++samples_;
}

void SimulatedNavigator::pass_pad() {
  const auto rest = scene_.timeline_.at(scene_.timeline_.start());
  for (; samples_ < scene_.pad_samples(); step(scene_.increments_[samples_]))
    if (fix_due()) use_fixes(rest);
  if (fix_due()) use_fixes(rest);
}

bool SimulatedNavigator::fix_due() const {
  const auto& fixes = scene_.timeline_.fixes();
  return next_fix_ < fixes.size() && scene_.sample(fixes[next_fix_].time) <= samples_;
}

void SimulatedNavigator::use_fixes(const earth::Motion& truth) {
  for (; fix_due(); ++next_fix_)
    if (filter_) use(scene_.timeline_.fixes()[next_fix_], truth);
}

// The fix as the aid gives it: truth, its own errors by what they do to it, and white noise.
void SimulatedNavigator::use(const navigation::PlannedFix& planned, const earth::Motion& truth) {
  navigation::Measurement measurement = std::visit(
      [&](const auto& fix) { return navigation::measure(AtTruth{truth}(fix), filter_->estimate()); }, planned.fix);
  const navigation::Measurement of_errors = navigation::linearise(planned, truth, scene_.aids_.model);
  for (int i = 0; i < measurement.rows; ++i) {
    const auto& row = of_errors.row[static_cast<std::size_t>(i)];
    const double white = std::sqrt(row.variance) * aids_();
    if (noisy(navigation::aid_of(planned))) measurement.residual[i] += white;
    measurement.residual[i] += row.h.tail(aid_terms_.size()).dot(aid_terms_);
  }
  ++fixes_;
  if (filter_->update(measurement).status != navigation::Innovation::Status::used) ++refused_;
}

void SimulatedNavigator::move_aids() {
  const double dt = scene_.options_.imu_interval;
  for (Eigen::Index k = 0; k < aid_terms_.size(); ++k) {
    const navigation::ErrorTerm& term = scene_.aids_.model.terms[static_cast<std::size_t>(k)];
    if (term.walk == 0) continue;
    const double phi = navigation::decay(term, dt), h2 = navigation::mean_decay(term, 2 * dt);
    aid_terms_[k] = phi * aid_terms_[k] + term.walk * std::sqrt(dt * h2) * aids_();
  }
}

Saturated SimulatedNavigator::saturated() const { return {imu_.gyro_saturated(), imu_.accelerometer_saturated()}; }

}  // namespace gyrobudget::inline v0::budget

// SPDX-License-Identifier: MIT
#include "monte_carlo.h"

#include "gyrobudget/earth/attitude.h"
#include "gyrobudget/earth/ellipsoid.h"
#include "gyrobudget/earth/frames.h"
#include "gyrobudget/earth/gravity.h"
#include "gyrobudget/navigation/alignment.h"
#include "gyrobudget/noise/normal.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Vector3d;
using CoreVector = Eigen::Matrix<double, kCoreStates, 1>;

// Streams of random numbers beside the IMU's own: 'M', what it is for, the run.
constexpr std::uint64_t kStart = 1, kAids = 2;
constexpr double kAnyHeading = 1e3;  // [rad] limit that no alignment reaches: the filter judges
noise::StreamKey key(std::uint64_t seed, std::uint64_t what, std::uint64_t run) {
  return {seed, (std::uint64_t{'M'} << 56) | (what << 48) | run};
}

// Standard normal numbers one after the other.
class Normals {
 public:
  explicit Normals(noise::StreamKey stream) : stream_(stream) {}
  double operator()() {
    if (next_ == buffer_.size()) {
      noise::fill_normal(stream_, drawn_, buffer_);
      drawn_ += buffer_.size();
      next_ = 0;
    }
    return buffer_[next_++];
  }

 private:
  noise::StreamKey stream_;
  std::array<double, 64> buffer_{};
  std::size_t next_ = buffer_.size();
  std::uint64_t drawn_ = 0;
};

noise::Vector3 array(const Vector3d& v) { return {v[0], v[1], v[2]}; }
Vector3d vector(const noise::Vector3& v) { return {v[0], v[1], v[2]}; }

// What all runs share.
struct Scene {
  const Timeline& timeline;
  const noise::SensorModel& sensor;
  const InitialErrors& initial;
  const Eigen::Matrix3d& C_el;
  const std::optional<Design>& design;
  const MonteCarlo::AidErrors& aids;
  const MonteCarlo::Options& options;
  std::vector<earth::ImuIncrement> increments;  // from the scene's start
  Eigen::MatrixXd aid_root;                     // of aids.initial
  struct Vectors {
    Carrier carrier;
    std::vector<Vector3d> unit;  // what a unit adds to the increment of each sample
  };
  std::vector<Vectors> world;

  // The sample whose end is nearest to a time of the scene, and when that is.
  [[nodiscard]] std::size_t sample(double time) const {
    const auto nearest = std::llround((time - timeline.start()) / options.imu_interval);
    return std::min(static_cast<std::size_t>(nearest), increments.size());
  }
  [[nodiscard]] double time(std::size_t sample) const {
    const auto pad = std::llround(-timeline.start() / options.imu_interval);
    const double t = static_cast<double>(static_cast<std::int64_t>(sample) - pad) * options.imu_interval;
    return std::min(t, timeline.end());
  }
};

std::vector<earth::ImuIncrement> increments(const Timeline& timeline, double interval) {
  const auto at = timeline.at(timeline.start());
  const Eigen::Matrix3d C_be = at.state.q_eb.toRotationMatrix().transpose();
  const auto pad = static_cast<std::size_t>(std::llround(-timeline.start() / interval));
  const earth::ImuIncrement rest{-interval * (C_be * earth::normal_gravity(at.state.p_eb_e)),
                                 interval * (C_be * Vector3d(0, 0, earth::wgs84::kEarthRate))};
  std::vector<earth::ImuIncrement> all(pad, rest);
  const auto flown = timeline.trajectory().increments(interval);
  all.insert(all.end(), flown.begin(), flown.end());
  return all;
}

// The vectors of a source of the world along all samples.
void add_world(Scene& scene, const Source& source) {
  const double dt = scene.options.imu_interval;
  const std::size_t vectors = source.model.terms.size() / 3;
  for (std::size_t v = 0; v < vectors; ++v) scene.world.push_back({source.model.terms[3 * v].carrier, {}});
  for (std::size_t k = 0; k < scene.increments.size(); ++k) {
    const double t = scene.timeline.start() + (static_cast<double>(k) + 0.5) * dt;
    const Timeline::Instant at = scene.timeline.at(std::min(t, scene.timeline.end()));
    StepInput input;
    input.p_eb_e = at.state.p_eb_e;
    input.C_eb = at.state.q_eb.toRotationMatrix();
    for (std::size_t v = 0; v < vectors; ++v)
      scene.world[scene.world.size() - vectors + v].unit.emplace_back(
          dt * Vector3d(source.shape(input, 3 * v), source.shape(input, 3 * v + 1),
                        source.shape(input, 3 * v + 2)));
  }
}

class OneRun {
 public:
  OneRun(const Scene& scene, std::uint64_t run)
      : scene_(scene),
        start_(key(scene.options.seed, kStart, run)),
        aids_(key(scene.options.seed, kAids, run)),
        imu_(scene.sensor, scene.options.imu_interval, {scene.options.seed, run}, scene.options.imu) {
    NavigationState start = wrong_start();
    for (std::size_t v = 0; v < scene.world.size(); ++v) world_.push_back(start_());
    if (scene.options.self_alignment) {
      const auto found = aligned();
      unaligned_ = !found;
      start.q_eb = found.value_or(start.q_eb);
    }
    if (scene.design)
      filter_.emplace(start, scene.design->model, scene.design->initial, scene.options.filter);
    else
      strapdown_.emplace(start, scene.options.filter.strapdown);
    const auto m = scene.aid_root.rows();
    Eigen::VectorXd draw(m);
    for (auto& x : draw) x = aids_();
    aid_terms_ = scene.aid_root * draw;
  }

  std::vector<CoreVector> operator()() {
    if (unaligned_) return {};
    const double dt = scene_.options.imu_interval;
    for (std::size_t k = 0; k <= scene_.increments.size(); ++k) {
      at_sample(k);
      if (k == scene_.increments.size()) break;
      const earth::ImuIncrement measured = k < pad_.size() ? pad_[k] : measure_imu(k);
      filter_ ? filter_->propagate(measured, dt) : strapdown_->step(measured, dt);
      move_aids(dt);
    }
    return std::move(errors_);
  }

  [[nodiscard]] bool unaligned() const { return unaligned_; }
  [[nodiscard]] std::uint64_t saturated() const {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < 3; ++i) sum += imu_.gyro_saturated()[i] + imu_.accelerometer_saturated()[i];
    return sum;
  }

 private:
  earth::ImuIncrement measure_imu(std::size_t k) {
    const auto& truth = scene_.increments[k];
    const noise::ImuReading read = imu_.next({array(truth.angle), array(truth.velocity)});
    earth::ImuIncrement measured{vector(read.velocity), vector(read.angle)};
    for (std::size_t v = 0; v < scene_.world.size(); ++v)
      (scene_.world[v].carrier == Carrier::gyro ? measured.angle : measured.velocity) +=
          world_[v] * scene_.world[v].unit[k];
    return measured;
  }

  // Coarse alignment on what is read on the pad, which is kept for the filter.
  // None where heading is neither observable nor given.
  std::optional<Eigen::Quaterniond> aligned() {
    const std::size_t samples = scene_.sample(0);
    pad_.reserve(samples);
    for (std::size_t k = 0; k < samples; ++k) pad_.push_back(measure_imu(k));
    const NavigationState truth = scene_.timeline.at(scene_.timeline.start()).state;
    const earth::Geodetic at = earth::to_geodetic(truth.p_eb_e);
    const Eigen::Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
    AlignmentOptions options;
    options.sensor = scene_.sensor;
    options.latitude = at.latitude;
    options.heading_limit = kAnyHeading;
    if (scene_.options.heading_sigma) {
      // The body axis that lies most nearly level.
      const Eigen::Matrix3d C_nb = C_en.transpose() * truth.q_eb.toRotationMatrix();
      Eigen::Index axis = 0;
      C_nb.row(2).cwiseAbs().minCoeff(&axis);
      const double azimuth = std::atan2(C_nb(1, axis), C_nb(0, axis));
      options.heading = {azimuth + *scene_.options.heading_sigma * start_(), *scene_.options.heading_sigma,
                         Vector3d::Unit(axis)};
    }
    const Alignment found = align(pad_, scene_.options.imu_interval, options);
    if (!found.q_nb) return std::nullopt;
    return Eigen::Quaterniond(C_en) * *found.q_nb;
  }

  NavigationState wrong_start() {
    NavigationState state = scene_.timeline.at(scene_.timeline.start()).state;
    const auto draw = [&](const Vector3d& sigma) -> Vector3d {
      Vector3d v;
      for (int i = 0; i < 3; ++i) v[i] = sigma[i] * start_();
      return scene_.C_el * v;
    };
    const InitialErrors& e = scene_.initial;
    const Vector3d p = draw(e.position), v = draw(e.velocity), psi = draw({e.level, e.level, e.heading});
    if (!scene_.options.initial_errors) return state;
    state.p_eb_e -= p;  // errors are truth minus estimate
    state.v_eb_e -= v;
    state.q_eb = earth::exp_rotation(-psi) * state.q_eb;
    return state;
  }

  void at_sample(std::size_t k) {
    const auto& fixes = scene_.timeline.fixes();
    for (; next_fix_ < fixes.size() && scene_.sample(fixes[next_fix_].time) <= k; ++next_fix_)
      if (filter_) use(fixes[next_fix_], k);
    const auto& report = scene_.timeline.report();
    if (errors_.size() < report.size() && scene_.sample(report[errors_.size()]) <= k) record(k);
  }

  // The fix as the aid gives it: truth, its own errors by what they do to it, and white noise. Truth is that of
  // the sample: what it moves until the planned time, which may lie between two, is the residual of truth itself.
  void use(const PlannedFix& planned, std::size_t k) {
    Measurement measurement =
        std::visit([&](const auto& fix) { return measure(fix, filter_->estimate()); }, planned.fix);
    const Measurement of_errors = linearise(planned, scene_.timeline.at(scene_.time(k)), scene_.aids.model);
    for (int i = 0; i < measurement.rows; ++i) {
      const auto& row = of_errors.row[static_cast<std::size_t>(i)];
      const double white = std::sqrt(row.variance) * aids_();
      measurement.residual[i] -= of_errors.residual[i];
      if (scene_.options.fix_noise)
        measurement.residual[i] += white + row.h.tail(aid_terms_.size()).dot(aid_terms_);
    }
    filter_->update(measurement);
  }

  void move_aids(double dt) {
    for (Eigen::Index k = 0; k < aid_terms_.size(); ++k) {
      const ErrorTerm& term = scene_.aids.model.terms[static_cast<std::size_t>(k)];
      if (term.walk == 0) continue;
      const double phi = decay(term, dt), h2 = mean_decay(term, 2 * dt);
      aid_terms_[k] = phi * aid_terms_[k] + term.walk * std::sqrt(dt * h2) * aids_();
    }
  }

  void record(std::size_t k) {
    const NavigationState truth = scene_.timeline.at(scene_.time(k)).state;
    const NavigationState& state = filter_ ? filter_->state() : strapdown_->state();
    CoreVector error;
    error << truth.p_eb_e - state.p_eb_e, truth.v_eb_e - state.v_eb_e,
        earth::log_rotation(truth.q_eb * state.q_eb.conjugate());
    errors_.push_back(error);
  }

  const Scene& scene_;
  Normals start_, aids_;
  noise::Imu imu_;
  std::vector<earth::ImuIncrement> pad_;  ///< as measured, where it served the alignment
  std::optional<Filter> filter_;
  std::optional<Strapdown> strapdown_;
  Eigen::VectorXd aid_terms_;
  std::vector<double> world_;  ///< sizes of the scene's vectors
  bool unaligned_ = false;
  std::size_t next_fix_ = 0;
  std::vector<CoreVector> errors_;
};

}  // namespace

CoreMatrix MonteCarlo::covariance(std::size_t i) const {
  CoreMatrix sum = CoreMatrix::Zero();
  for (const auto& run : errors) sum += run[i] * run[i].transpose();
  return sum / runs;
}

double MonteCarlo::mean_nees(std::size_t i, const CoreMatrix& P) const {
  double sum = 0;
  for (const auto& run : errors) sum += nees(run[i], P);
  return sum / runs;
}

MonteCarlo monte_carlo(const Timeline& timeline, const noise::SensorModel& sensor,
                       const InitialErrors& initial, const Eigen::Matrix3d& C_el,
                       const std::optional<Design>& design, const MonteCarlo::AidErrors& aids,
                       const MonteCarlo::Options& options) {
  if (options.runs < 1) throw std::invalid_argument(fmt::format("{} runs, expected 1 or more", options.runs));
  if (!(options.imu_interval > 0))
    throw std::invalid_argument(fmt::format("IMU interval of {} s, expected above 0", options.imu_interval));
  if (!(options.imu_interval <= timeline.end()))
    throw std::invalid_argument(
        fmt::format("IMU interval of {} s, expected at most the {} s of the trajectory", options.imu_interval,
                    timeline.end()));
  Scene scene{
      timeline, sensor, initial, C_el, design, aids, options, increments(timeline, options.imu_interval), {}};
  for (const Source& source : options.world) add_world(scene, source);
  const Eigen::LDLT<Eigen::MatrixXd> factors{Eigen::MatrixXd(aids.initial)};
  scene.aid_root = factors.transpositionsP().transpose() * Eigen::MatrixXd(factors.matrixL()) *
                   factors.vectorD().cwiseMax(0).cwiseSqrt().asDiagonal().toDenseMatrix();

  MonteCarlo result;
  result.times = timeline.report();
  std::vector<std::vector<CoreVector>> errors(static_cast<std::size_t>(options.runs));
  std::atomic<std::uint64_t> saturated = 0;
  std::atomic<int> unaligned = 0;
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  int done = 0;
  tbb::parallel_for(0, options.runs, [&](int run) {
    if (stopped) return;
    OneRun one(scene, static_cast<std::uint64_t>(run));
    errors[static_cast<std::size_t>(run)] = one();
    saturated += one.saturated();
    unaligned += one.unaligned() ? 1 : 0;
    const std::lock_guard lock(mutex);
    ++done;
    if (options.progress && !options.progress(done)) stopped = true;
  });
  std::erase_if(errors, [](const auto& run) { return run.empty(); });
  result.errors = std::move(errors);
  result.runs = static_cast<int>(result.errors.size());
  result.saturated = saturated;
  result.unaligned = unaligned;
  return result;
}

}  // namespace gyrobudget::inline v0::navigation

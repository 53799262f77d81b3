// SPDX-License-Identifier: MIT
#include "consistent_runs.h"

#include "gyrobudget/estimation/navigation/filter.h"
#include "gyrobudget/estimation/navigation/sensor_states.h"
#include "gyrobudget/noise/imu.h"
#include "gyrobudget/noise/normal.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <oneapi/tbb/parallel_for.h>

#include <cmath>
#include <numeric>

namespace gyrobudget::consistency {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::CoreMatrix;

constexpr double kDegreePerHour = earth::kDegree / 3600;
constexpr double kMicroG = 9.80665e-6;
constexpr double kPositionSigma = 2, kVelocitySigma = 0.05;                    // of GNSS [m, m/s]
constexpr double kStartPosition = 3, kStartVelocity = 0.1, kStartTilt = 2e-3;  // [m, m/s, rad]

struct Sums {
  std::vector<double> navigation, bias, nis;
};

struct Shared {
  const Scene& scene;
  earth::Trajectory path;
  std::vector<noise::ImuIncrement> increments;
  std::vector<earth::TrajectoryPoint> truth;  // each second, from 0
  Matrix3d axes;
  navigation::SensorStates states;
  navigation::StateMatrix P0;
};

earth::Trajectory turns(double duration) {
  earth::Cruise cruise;
  cruise.turn_acceleration = 4;
  cruise.duration = duration;
  return earth::cruise(cruise);
}

// Row of a unit on every bias term of one gyro.
navigation::StateVector total_bias(const navigation::ErrorStateModel& model, int axis) {
  navigation::StateVector h = navigation::StateVector::Zero(model.states());
  for (std::size_t k = 0; k < model.terms.size(); ++k)
    if (model.terms[k].carrier == navigation::Carrier::gyro && model.terms[k].effect == navigation::Effect::bias &&
        model.terms[k].axis == axis)
      h[navigation::kCoreStates + static_cast<int>(k)] = 1;
  return h;
}

class OneRun {
 public:
  OneRun(const Shared& shared, std::uint64_t seed, std::uint64_t run)
      : shared_(shared),
        numbers_{seed, (std::uint64_t{'T'} << 56) | run},
        imu_(shared.scene.sensor, shared.scene.imu_interval, {seed, run}, imu_options(shared)),
        filter_(start(), shared.states.model, shared.P0, filter_options()) {
    for (int i = 0; i < 3; ++i) rows_.push_back(total_bias(filter_.model(), i));
  }

  Sums operator()() {
    const auto per_second = static_cast<std::size_t>(std::lround(1 / shared_.scene.imu_interval));
    Vector3d true_bias = Vector3d::Zero(), estimate = Vector3d::Zero();
    for (std::size_t k = 0; k < shared_.increments.size(); ++k) {
      filter_.propagate(imu_.next(shared_.increments[k]), shared_.scene.imu_interval);
      for (int i = 0; i < 3; ++i) {
        true_bias[i] += imu_.gyro_bias()[static_cast<std::size_t>(i)] / static_cast<double>(per_second);
        estimate[i] += estimated_bias(i) / static_cast<double>(per_second);
      }
      if ((k + 1) % per_second != 0) continue;
      const std::size_t second = (k + 1) / per_second;
      judge(second, true_bias - estimate);
      true_bias.setZero();
      estimate.setZero();
      aid(second);
    }
    return std::move(sums_);
  }

 private:
  static noise::Imu::Options imu_options(const Shared& shared) {
    noise::Imu::Options options;
    options.duration = shared.scene.duration;
    return options;
  }
  static navigation::Filter::Options filter_options() {
    navigation::Filter::Options options;
    options.covariance_interval = 0.1;
    options.gate_false_alarm = 0;
    return options;
  }

  double normal() {
    double x = 0;
    noise::fill_normal(numbers_, drawn_++, {&x, 1});
    return x;
  }
  Vector3d normals(double sigma) {
    const double x = normal(), y = normal(), z = normal();
    return sigma * Vector3d(x, y, z);
  }

  earth::Pose start() {
    const auto& truth = shared_.truth[0];
    earth::Pose state = truth.pose;
    state.p_eb_e += normals(kStartPosition);
    state.v_eb_e += normals(kStartVelocity);
    state.q_eb = earth::exp_rotation(normals(kStartTilt)) * state.q_eb;
    return state;
  }

  [[nodiscard]] double estimated_bias(int axis) const {
    double sum = 0;
    const auto& terms = filter_.model().terms;
    for (std::size_t k = 0; k < terms.size(); ++k)
      if (rows_[static_cast<std::size_t>(axis)][navigation::kCoreStates + static_cast<int>(k)] != 0)
        sum += filter_.term(static_cast<int>(k));
    return sum;
  }

  void judge(std::size_t second, const Vector3d& bias_error) {
    filter_.catch_up();
    const auto& truth = shared_.truth[second];
    const auto& state = filter_.state();
    Eigen::Matrix<double, 9, 1> error;
    error << truth.pose.p_eb_e - state.p_eb_e, truth.pose.v_eb_e - state.v_eb_e,
        earth::log_rotation(truth.pose.q_eb * state.q_eb.conjugate());
    const CoreMatrix P = filter_.covariance().matrix().topLeftCorner<9, 9>();
    sums_.navigation.push_back(navigation::nees(error, P));
    double bias = 0;
    for (int i = 0; i < 3; ++i) {
      const auto& h = rows_[static_cast<std::size_t>(i)];
      bias += bias_error[i] * bias_error[i] / h.dot(filter_.covariance().times(h)) / 3;
    }
    sums_.bias.push_back(bias);
  }

  void aid(std::size_t second) {
    const auto t = static_cast<double>(second);
    if (t >= shared_.scene.outage_from && t < shared_.scene.outage_to) return;
    const auto& truth = shared_.truth[second];
    const Vector3d p = truth.pose.p_eb_e + shared_.axes * normals(kPositionSigma);
    const Vector3d v = truth.pose.v_eb_e + shared_.axes * normals(kVelocitySigma);
    const auto position = filter_.update(
        measure(navigation::PositionFix{.p_eb_e = p, .sigma = Vector3d::Constant(kPositionSigma), .axes = shared_.axes},
                filter_.estimate()));
    const auto velocity = filter_.update(
        measure(navigation::VelocityFix{.v_eb_e = v, .sigma = Vector3d::Constant(kVelocitySigma), .axes = shared_.axes},
                filter_.estimate()));
    sums_.nis.push_back(position.nis + velocity.nis);
  }

  const Shared& shared_;
  noise::StreamKey numbers_;
  std::uint64_t drawn_ = 0;
  noise::Imu imu_;
  navigation::Filter filter_;
  std::vector<navigation::StateVector> rows_;
  Sums sums_;
};

void add(std::vector<double>& sum, const std::vector<double>& one, int runs) {
  sum.resize(one.size());
  for (std::size_t i = 0; i < one.size(); ++i) sum[i] += one[i] / runs;
}

}  // namespace

double Verdict::mean(const std::vector<double>& x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / static_cast<double>(x.size());
}

double Verdict::inside(const std::vector<double>& mean_nees, double dof, double count) {
  const auto band = navigation::chi_square_mean_band(dof, count);
  double in = 0;
  for (const double x : mean_nees) in += band.holds(x);
  return in / static_cast<double>(mean_nees.size());
}

Verdict fly(const Scene& scene, std::uint64_t seed) {
  Shared shared{
      scene, turns(scene.duration), {}, {}, earth::LocalFrame::east_north_up(earth::Cruise{}.start).C_el(), {}, {}};
  shared.increments = shared.path.increments(scene.imu_interval);
  for (double t = 0; t <= scene.duration; t += 1) shared.truth.push_back(shared.path.at(t));
  navigation::SensorStates::Options options;
  options.scene_length = scene.band;
  options.step = scene.imu_interval;
  options.flicker_states = scene.flicker_states;
  options.shortest = scene.shortest;
  shared.states = sensor_states(scene.sensor, options);
  CoreMatrix core = CoreMatrix::Zero();
  core.diagonal() << Vector3d::Constant(kStartPosition * kStartPosition),
      Vector3d::Constant(kStartVelocity * kStartVelocity), Vector3d::Constant(kStartTilt * kStartTilt);
  shared.P0 = navigation::initial_covariance(core, shared.states.initial);

  std::vector<Sums> sums(static_cast<std::size_t>(scene.runs));
  tbb::parallel_for(0, scene.runs, [&](int run) {
    sums[static_cast<std::size_t>(run)] = OneRun(shared, seed, static_cast<std::uint64_t>(run))();
  });
  Verdict verdict;
  verdict.runs = scene.runs;
  for (const auto& one : sums) {
    verdict.of_run.push_back(Verdict::mean(one.navigation));
    add(verdict.navigation, one.navigation, scene.runs);
    add(verdict.bias, one.bias, scene.runs);
    add(verdict.nis, one.nis, scene.runs);
  }
  return verdict;
}

noise::SensorModel fibre_optic() {
  noise::SensorModel sensor;
  sensor.gyro.white = 5.4e-4 * earth::kDegree / 60;
  sensor.gyro.bias_instability = 1.7e-3 * kDegreePerHour;
  sensor.gyro.rate_random_walk = 4.32e-2 * kDegreePerHour / 60;
  sensor.gyro.turn_on_bias = 0.01 * kDegreePerHour;
  sensor.accelerometer.emplace();
  sensor.accelerometer->white = 20 * kMicroG;
  sensor.accelerometer->turn_on_bias = 50 * kMicroG;
  return sensor;
}

noise::SensorModel mems() {
  noise::SensorModel sensor;
  sensor.gyro.white = 0.15 * earth::kDegree / 60;
  sensor.gyro.bias_instability = 0.70 * kDegreePerHour;
  sensor.gyro.rate_random_walk = 4.32 * kDegreePerHour / 60;
  sensor.gyro.turn_on_bias = 10 * kDegreePerHour;
  sensor.accelerometer.emplace();
  sensor.accelerometer->white = 100 * kMicroG;
  sensor.accelerometer->turn_on_bias = 1000 * kMicroG;
  return sensor;
}

}  // namespace gyrobudget::consistency

// SPDX-License-Identifier: MIT
// Truth is earth's trajectory of a body that stands, the closed forms of theory, Monte Carlo at stated
// false alarm, and a ring laser's record in a parked vehicle.
#include "gyrobudget/estimation/navigation/alignment.h"

#include "gyrobudget/noise/imu.h"
#include "gyrobudget/noise/normal.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "../../allan/logs.h"

namespace {

using namespace gyrobudget;
using earth::array;
using earth::kDegree;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using navigation::align;
using navigation::Alignment;
using navigation::AlignmentOptions;
using navigation::StaticMeans;
using std::numbers::pi;

constexpr double kDegreePerHour = kDegree / 3600;
constexpr double kMicroG = 9.80665e-6;
constexpr double kLatitude = 34 * kDegree;
constexpr double kStands = 5.0;  // standard errors of a Monte Carlo: false alarm 6e-7

/// Navigation grade, in SI.
noise::SensorModel ring_laser() {
  return {.name = "ring laser",
          .gyro = {.white = 0.003 * kDegree / 60, .turn_on_bias = 0.01 * kDegreePerHour},
          .accelerometer = noise::ErrorModel{.white = 20 * kMicroG, .turn_on_bias = 50 * kMicroG}};
}

noise::SensorModel ideal() { return {.name = "ideal", .gyro = {.turn_on_bias = 0.0}, .accelerometer = {}}; }

Quaterniond attitude(double yaw, double pitch, double roll) {
  return earth::from_euler({yaw * kDegree, pitch * kDegree, roll * kDegree});
}

StaticMeans standing(const Quaterniond& q_nb, double latitude, double duration) {
  const double g = earth::somigliana(latitude);
  return {q_nb.conjugate() * Vector3d(0, 0, -g), q_nb.conjugate() * earth::earth_rate_ned(latitude), duration};
}

/// psi in east, north, up with q_true = exp(psi) q^.
Vector3d error_of(const Alignment& alignment, const Quaterniond& q_nb) {
  const Vector3d ned = earth::log_rotation(q_nb * alignment.q_nb->conjugate());
  return {ned.y(), ned.x(), -ned.z()};
}

TEST(Alignment, IsExactForExactIncrementsAtAnyAttitudeAndPlace) {
  for (const double latitude : {-60.0, -2.373, 0.0, 45.0, 80.0})
    for (const auto& [yaw, pitch, roll] : {std::tuple{0.0, 0.0, 0.0},
                                           {123.0, 20.0, -50.0},
                                           {30.0, 90.0, 0.0},
                                           {-70.0, -90.0, 0.0},
                                           {200.0, 5.0, 180.0}}) {
      earth::Stand stand;
      stand.position = earth::Geodetic::from_degrees(latitude, -44, 0);
      stand.q_nb = attitude(yaw, pitch, roll);
      stand.duration = 2;
      const auto imu = earth::stand(stand).increments(0.01);
      AlignmentOptions options{.sensor = ideal(), .latitude = latitude * kDegree};
      const Alignment a = align(imu, 0.01, options);
      ASSERT_TRUE(a.heading_observable) << a.message;
      EXPECT_LT(error_of(a, stand.q_nb).norm(), 1e-10) << latitude << ' ' << pitch;
      EXPECT_NEAR(a.latitude, latitude * kDegree, 1e-10);
      options.latitude.reset();
      EXPECT_LT(error_of(align(imu, 0.01, options), stand.q_nb).norm(), 1e-10);
    }
}

TEST(Alignment, SigmasAreTheClosedForms) {
  constexpr double T = 600;
  const auto sensor = ring_laser();
  const auto q_nb = attitude(40, 10, 5);
  const Alignment a = align(standing(q_nb, kLatitude, T), {.sensor = sensor, .latitude = kLatitude});
  const double g = earth::somigliana(kLatitude);
  const double c = earth::wgs84::kEarthRate * std::cos(kLatitude);
  const double level = (*sensor.accelerometer->turn_on_bias)[0] / g;
  EXPECT_NEAR(a.parts.bias.x() / level, 1, 1e-12);
  EXPECT_NEAR(a.parts.bias.y() / level, 1, 1e-12);
  EXPECT_NEAR(a.parts.bias.z() / std::hypot((*sensor.gyro.turn_on_bias)[0] / c, level * std::tan(kLatitude)), 1, 1e-12);
  EXPECT_NEAR(a.parts.noise.z() / std::hypot(sensor.gyro.white[0] / (c * std::sqrt(T)),
                                             sensor.accelerometer->white[0] / (g * std::sqrt(T)) * std::tan(kLatitude)),
              1, 1e-12);
  EXPECT_NEAR(a.parts.noise.x() / (sensor.accelerometer->white[0] / (g * std::sqrt(T))), 1, 1e-12);
  EXPECT_EQ(a.parts.motion, Vector3d::Zero());
  EXPECT_NEAR(a.sigma().z(), std::hypot(a.parts.bias.z(), a.parts.noise.z()), 1e-15);
  // 0.01 deg/h at 34 degrees are 2.8 arc minutes of heading, 50 ug are 10 arc seconds of level.
  EXPECT_NEAR(a.parts.bias.z() / kDegree * 60, 2.76, 0.02);
  EXPECT_NEAR(a.parts.bias.x() / kDegree * 3600, 10.3, 0.05);
}

// Nose to the north and level, y points to the east: it finds the heading, and x and z do not.
TEST(Alignment, EachAxisHasItsOwnNoise) {
  constexpr double T = 600;
  const auto heading = [](const noise::ErrorModel& gyro) {
    const noise::SensorModel sensor{.name = "one axis", .gyro = gyro, .accelerometer = {}};
    const Alignment a = align(standing(attitude(0, 0, 0), kLatitude, T), {.sensor = sensor, .latitude = kLatitude});
    return std::hypot(a.parts.bias.z(), a.parts.noise.z());
  };
  const auto each = [&](noise::ErrorModel whole, const std::function<noise::PerAxis&(noise::ErrorModel&)>& size) {
    const double all = heading(whole);
    EXPECT_GT(all, 0);
    for (const std::size_t axis : {0U, 1U, 2U}) {
      noise::ErrorModel one = whole;
      size(one) = 0;
      size(one)[axis] = size(whole)[axis];
      // A rotation to rounding mixes axes by 1e-16.
      if (axis == 1)
        EXPECT_NEAR(heading(one) / all, 1, 1e-12);
      else
        EXPECT_LT(heading(one), 1e-12 * all);
    }
  };
  for (const auto term : {noise::Term::white, noise::Term::flicker, noise::Term::rate_random_walk,
                          noise::Term::quantization, noise::Term::rate_ramp}) {
    noise::ErrorModel gyro{.turn_on_bias = 0.0};
    gyro[term] = 1e-9;
    each(gyro, [term](noise::ErrorModel& m) -> noise::PerAxis& { return m[term]; });
  }
  each({.gauss_markov = {{1e-9, 100}}, .turn_on_bias = 0.0},
       [](noise::ErrorModel& m) -> noise::PerAxis& { return m.gauss_markov[0].sigma; });
}

TEST(Alignment, CorrelationWithEachBiasIsItsDerivative) {
  constexpr double T = 600;
  const auto q_nb = attitude(40, 70, 5);
  const StaticMeans truth = standing(q_nb, kLatitude, T);
  const AlignmentOptions compassed{.sensor = ring_laser(), .latitude = kLatitude};
  AlignmentOptions told = compassed;
  told.heading = {.azimuth = 0, .sigma = 1e-3, .axis = Vector3d(0.3, 0.2, 1)};
  const Vector3d axis = Quaterniond(q_nb) * told.heading->axis;
  told.heading->azimuth = std::atan2(axis.y(), axis.x());
  for (const AlignmentOptions& options : {compassed, told}) {
    const Alignment a = align(truth, options);
    EXPECT_LT(error_of(a, q_nb).norm(), 1e-12);
    for (int k = 0; k < 3; ++k) {
      constexpr double kForce = 1e-4;
      constexpr double kRate = 1e-9;
      StaticMeans off = truth;
      off.f_ib_b[k] += kForce;
      const Vector3d by_force = error_of(align(off, options), q_nb) / kForce;
      EXPECT_LT((by_force * a.accelerometer_bias_variance[k] - a.accelerometer_bias_covariance.col(k)).norm(),
                1e-4 * a.accelerometer_bias_covariance.norm());
      off = truth;
      off.w_ib_b[k] += kRate;
      const Vector3d by_rate = error_of(align(off, options), q_nb) / kRate;
      EXPECT_LT((by_rate * a.gyro_bias_variance[k] - a.gyro_bias_covariance.col(k)).norm(),
                1e-4 * a.gyro_bias_covariance.norm() + 1e-20);
    }
  }
}

TEST(Alignment, AttitudeAndBiasesAreConsistentTogether) {
  // 2000 runs of biases and white noise: the normalised square of psi and both biases is chi-square with 9
  // degrees.
  constexpr int kRuns = 2000;
  constexpr double T = 300;
  const auto sensor = ring_laser();
  const auto q_nb = attitude(-130, 88, 20);
  const StaticMeans truth = standing(q_nb, kLatitude, T);
  std::vector<double> normal(12 * kRuns);
  noise::fill_normal({.seed = 5}, 0, normal);
  auto next = normal.begin();
  const auto vector = [&](double sigma) {
    const double x = *next++, y = *next++, z = *next++;
    return Vector3d(sigma * Vector3d(x, y, z));
  };
  double sum = 0;
  for (int run = 0; run < kRuns; ++run) {
    const Vector3d gyro = vector((*sensor.gyro.turn_on_bias)[0]);
    const Vector3d accelerometer = vector((*sensor.accelerometer->turn_on_bias)[0]);
    StaticMeans means = truth;
    means.w_ib_b += gyro + vector(sensor.gyro.white[0] / std::sqrt(T));
    means.f_ib_b += accelerometer + vector(sensor.accelerometer->white[0] / std::sqrt(T));
    const Alignment a = align(means, {.sensor = sensor, .latitude = kLatitude});
    Eigen::Matrix<double, 9, 9> P = Eigen::Matrix<double, 9, 9>::Zero();
    P.topLeftCorner<3, 3>() = a.covariance;
    P.block<3, 3>(0, 3) = a.gyro_bias_covariance;
    P.block<3, 3>(0, 6) = a.accelerometer_bias_covariance;
    P.block<3, 3>(3, 0) = a.gyro_bias_covariance.transpose();
    P.block<3, 3>(6, 0) = a.accelerometer_bias_covariance.transpose();
    P.block<3, 3>(3, 3) = a.gyro_bias_variance.asDiagonal();
    P.block<3, 3>(6, 6) = a.accelerometer_bias_variance.asDiagonal();
    Eigen::Matrix<double, 9, 1> x;
    x << error_of(a, q_nb), gyro, accelerometer;
    // Scaled to one sigma each, for the solver's sake.
    const Eigen::Matrix<double, 9, 1> scale = P.diagonal().cwiseSqrt().cwiseInverse();
    sum += (scale.asDiagonal() * x)
               .dot((scale.asDiagonal() * P * scale.asDiagonal()).ldlt().solve(scale.asDiagonal() * x));
  }
  EXPECT_NEAR(sum / kRuns, 9, kStands * std::sqrt(2.0 * 9 / kRuns));
}

TEST(Alignment, IntervalHoldsMotionThatTheModelDoesNotKnow) {
  // Slow wander of the rates, correlated over 2 s, and a model that knows nothing of it: the interval of
  // six parts holds heading in 95 % of 2000 records of 120 s.
  constexpr int kRuns = 2000;
  constexpr int kSamples = 1200;
  constexpr double dt = 0.1;
  const auto q_nb = attitude(75, 0, 0);
  const StaticMeans truth = standing(q_nb, kLatitude, 1);
  const double phi = std::exp(-dt / 2);
  std::vector<double> normal(3 * kSamples);
  std::vector<noise::ImuIncrement> imu(kSamples);
  int inside = 0;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    noise::fill_normal({.seed = 3, .stream = run}, 0, normal);
    Vector3d wander = Vector3d::Zero();
    for (std::size_t k = 0; k < kSamples; ++k) {
      wander = phi * wander + 1e-6 * Vector3d(normal[3 * k], normal[3 * k + 1], normal[3 * k + 2]);
      imu[k] = {.angle = array((truth.w_ib_b + wander) * dt), .velocity = array(truth.f_ib_b * dt)};
    }
    const Alignment a = align(imu, dt, {.sensor = ideal(), .latitude = kLatitude});
    ASSERT_TRUE(a.heading_observable) << a.message;
    inside += std::abs(error_of(a, q_nb).z()) < 1.96 * a.parts.motion.z();
  }
  constexpr double kCorrelated = 0.01;  // what the correlation of neighbouring parts costs
  EXPECT_NEAR(inside / double{kRuns}, 0.95, kStands * std::sqrt(0.05 * 0.95 / kRuns) + kCorrelated);
}

TEST(Alignment, SwayLeavesTheMean) {
  earth::Stand stand;
  stand.position = earth::Geodetic{kLatitude, 0, 0};
  stand.q_nb = attitude(10, 90, 0);
  stand.vibration = {.coning_angle = 0.2 * kDegree, .coning_frequency = 0.5};
  stand.duration = 120;
  const Alignment a = align(earth::stand(stand).increments(0.02), 0.02, {.sensor = ideal(), .latitude = kLatitude});
  ASSERT_TRUE(a.heading_observable) << a.message;
  // The cone's axis is the mean pose; its rectified turn, 2 sin^2(a/2) w about x, is not at rest.
  EXPECT_LT(error_of(a, stand.q_nb).head<2>().norm(), 1e-5);
}

TEST(Alignment, HeadingOfAMemsIsNotObservableAndIsAskedFor) {
  noise::SensorModel mems{.name = "MEMS",
                          .gyro = {.white = 0.15 * kDegree / 60,
                                   .bias_instability = 0.7 * kDegreePerHour,
                                   .turn_on_bias = 50 * kDegreePerHour},
                          .accelerometer = noise::ErrorModel{.turn_on_bias = 1000 * kMicroG}};
  const auto on_pad = attitude(90, 90, 0);
  const StaticMeans means = standing(on_pad, -2.373 * kDegree, 600);
  AlignmentOptions options{.sensor = mems, .latitude = -2.373 * kDegree};
  Alignment a = align(means, options);
  EXPECT_FALSE(a.heading_observable);
  EXPECT_FALSE(a.q_nb.has_value());
  EXPECT_NE(a.message.find("Give the heading"), std::string::npos) << a.message;
  EXPECT_NEAR(a.sigma().z(), pi / std::sqrt(3), 1e-12);
  EXPECT_LT((a.up_b - Vector3d(1, 0, 0)).norm(), 1e-12);

  // On the pad the nose is vertical; the belly looks to the azimuth of the launch.
  options.heading = {.azimuth = 90 * kDegree, .sigma = 0.5 * kDegree, .axis = Vector3d(0, 0, 1)};
  a = align(means, options);
  ASSERT_TRUE(a.q_nb.has_value()) << a.message;
  EXPECT_FALSE(a.heading_observable);
  EXPECT_LT(error_of(a, on_pad).norm(), 1e-12);
  EXPECT_NEAR(a.sigma().z(), 0.5 * kDegree, 1e-6);
  EXPECT_EQ(a.gyro_bias_covariance, Matrix3d::Zero());

  options.heading->axis = Vector3d(1, 0, 0);
  a = align(means, options);
  EXPECT_FALSE(a.q_nb.has_value());
  EXPECT_NE(a.message.find("vertical"), std::string::npos) << a.message;
}

TEST(Alignment, SaysWhereEarthsRateIsNotSeen) {
  const auto q_nb = attitude(0, 0, 0);
  EXPECT_FALSE(align(standing(q_nb, 89.99 * kDegree, 60), {.sensor = ring_laser(), .latitude = 89.99 * kDegree})
                   .heading_observable);
  StaticMeans turning = standing(q_nb, kLatitude, 60);
  turning.w_ib_b.x() += 0.01;
  const Alignment a = align(turning, {.sensor = ring_laser(), .latitude = kLatitude});
  EXPECT_FALSE(a.heading_observable);
  EXPECT_NE(a.message.find("turns"), std::string::npos) << a.message;
  StaticMeans nothing = turning;
  nothing.w_ib_b.setZero();
  EXPECT_FALSE(align(nothing, {.sensor = ring_laser()}).heading_observable);
}

TEST(Alignment, AnUnstatedTurnOnBiasIsSaid) {
  auto sensor = ring_laser();
  sensor.gyro.turn_on_bias.reset();
  const Alignment a = align(standing(attitude(0, 0, 0), kLatitude, 60), {.sensor = sensor, .latitude = kLatitude});
  EXPECT_NE(a.message.find("turn-on bias"), std::string::npos) << a.message;
}

TEST(Alignment, RingLaserInAParkedVehicle) {
  using allan::path;
  SKIP_WITHOUT("static/rlg_vehicle_counts.csv.gz");
  const allan::Columns counts = allan::read_columns("static/rlg_vehicle_counts.csv.gz");
  constexpr double kRate = 100;
  constexpr double kAngle = 0.1 / 3600 * kDegree;  // a count
  constexpr double kVelocity = 125 * kMicroG;
  std::vector<noise::ImuIncrement> imu(counts[0].size());
  for (std::size_t k = 0; k < imu.size(); ++k)  // from right, forward, up
    imu[k] = {.angle = array(kAngle * Vector3d(counts[1][k], counts[0][k], -counts[2][k])),
              .velocity = array(kVelocity * Vector3d(counts[4][k], counts[3][k], -counts[5][k]))};
  AlignmentOptions options{.sensor = ring_laser(), .latitude = 34.246048 * kDegree};
  const Alignment a = align(imu, 1 / kRate, options);
  ASSERT_TRUE(a.heading_observable) << a.message;
  // -88.6 degrees counter-clockwise from north, by an independent look; published about -90.6.
  const double heading = earth::to_euler(*a.q_nb).yaw / kDegree;
  EXPECT_NEAR(heading, 88.6, 0.05);
  // 5-minute segments scatter from 84.6 to 94.2: the interval is that motion's, about 3 degrees at 95 %,
  // and not the few arc minutes of noise and bias.
  const double interval = 1.96 * a.sigma().z() / kDegree;
  EXPECT_GT(interval, 2.5);
  EXPECT_LT(interval, 4.5);
  EXPECT_LT(1.96 * a.parts.noise.z() / kDegree, 0.2);
  EXPECT_NEAR(heading, 90.6, interval);
  // Latitude from the record agrees with the site.
  EXPECT_NEAR(a.latitude, *options.latitude, 1.96 * a.latitude_sigma);
  EXPECT_LT(a.latitude_sigma, 2 * kDegree);
}

// Variance that the alignment counts with for the mean bias of a gyro axis over T.
double assumed_variance(const noise::ErrorModel& gyro, double T, double dt) {
  noise::SensorModel sensor;
  sensor.gyro = gyro;
  return align(standing(attitude(0, 0, 0), kLatitude, T), {.sensor = sensor, .interval = dt, .latitude = kLatitude})
      .gyro_bias_variance[0];
}

TEST(Alignment, SlowErrorsCountFromTheirEpoch) {
  constexpr double T = 60, before = 1000;
  constexpr double k = 1e-9, b = 1e-8;
  const auto variance = [](const noise::ErrorModel& gyro) { return assumed_variance(gyro, T, 0.01); };
  EXPECT_NEAR(variance({.rate_random_walk = k}) / (k * k * T / 3), 1, 1e-12);
  EXPECT_NEAR(variance({.rate_random_walk = k, .powered_on_before = before}) / (k * k * (before + T / 3)), 1, 1e-12);
  EXPECT_NEAR(variance({.rate_random_walk = k, .calibrated_over = before}) / (k * k * (before + T) / 3), 1, 1e-12);
  // The difference of two neighbouring means is twice the Allan variance, 2 ln2/pi B^2, whatever their length.
  EXPECT_NEAR(variance({.bias_instability = b, .calibrated_over = T}) / (4 * std::numbers::ln2 / pi * b * b), 1, 1e-12);
  // A calibration takes off what does not change, to the white noise in it.
  EXPECT_NEAR(variance({.white = k, .gauss_markov = {{b, 1e9}}, .turn_on_bias = 1.0, .calibrated_over = before}) /
                  (k * k / before + 2 * b * b * (before + T) / 3 / 1e9),
              1, 1e-5);
}

// Means of simulated IMUs over a record of 60 s, for the epochs that a sensor file can state.
TEST(Alignment, MeansOfASimulatedImuScatterAsAssumed) {
  constexpr int kRuns = 500, kAxes = 6, kSamples = 600;
  constexpr double dt = 0.1, T = kSamples * dt;
  constexpr double kSampled = 0.01;  // what half a sample in the record's length and the poles of flicker cost
  const double tolerance = kStands * std::sqrt(2.0 / (kRuns * kAxes)) + kSampled;  // 0.14
  for (const noise::ErrorModel& process :
       {noise::ErrorModel{.bias_instability = 1}, noise::ErrorModel{.rate_random_walk = 1},
        noise::ErrorModel{.gauss_markov = {{1, 40}}}})
    for (const auto& [before, calibrated] : {std::pair<double, double>{0, 0}, {10, 0}, {600, 0}, {0, 30}, {0, 300}}) {
      noise::SensorModel sensor;
      sensor.gyro = process;
      if (before > 0) sensor.gyro.powered_on_before = before;
      if (calibrated > 0) sensor.gyro.calibrated_over = calibrated;
      sensor.accelerometer = sensor.gyro;
      double sum = 0;
      for (std::uint64_t run = 0; run < kRuns; ++run) {
        noise::Imu imu(sensor, dt, {.seed = 20261122, .run = run}, {.duration = T});
        Vector3d angle = Vector3d::Zero(), velocity = Vector3d::Zero();
        for (int k = 0; k < kSamples; ++k) {
          const noise::ImuIncrement read = imu.next({});
          angle += earth::vector(read.angle);
          velocity += earth::vector(read.velocity);
        }
        sum += (angle / T).squaredNorm() + (velocity / T).squaredNorm();
      }
      EXPECT_NEAR(sum / (kRuns * kAxes) / assumed_variance(sensor.gyro, T, dt), 1, tolerance)
          << "flicker " << process.bias_instability[0] << ", walk " << process.rate_random_walk[0] << ", on for "
          << before << " s, calibrated over " << calibrated << " s";
    }
}

TEST(Alignment, RefusesMisuse) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const StaticMeans good = standing(attitude(0, 0, 0), kLatitude, 60);
  const AlignmentOptions options{.sensor = ring_laser(), .latitude = kLatitude};
  const noise::ImuIncrement one{.angle = array(good.w_ib_b), .velocity = array(good.f_ib_b)};
  const std::vector<noise::ImuIncrement> imu(11, one);
  EXPECT_THROW((void)align(imu, 1, options), std::invalid_argument);
  const std::vector<noise::ImuIncrement> enough(12, one);
  EXPECT_NO_THROW((void)align(enough, 1, options));
  EXPECT_THROW((void)align(enough, 0, options), std::invalid_argument);
  StaticMeans bad = good;
  bad.f_ib_b.setZero();
  EXPECT_THROW((void)align(bad, options), std::invalid_argument);
  bad.f_ib_b.x() = nan;
  EXPECT_THROW((void)align(bad, options), std::invalid_argument);
  bad = good;
  bad.duration = 0;
  EXPECT_THROW((void)align(bad, options), std::invalid_argument);
  AlignmentOptions wrong = options;
  wrong.latitude = 2;
  EXPECT_THROW((void)align(good, wrong), std::invalid_argument);
  wrong = options;
  wrong.heading_limit = 0;
  EXPECT_THROW((void)align(good, wrong), std::invalid_argument);
  wrong = options;
  wrong.heading = {.azimuth = nan};
  EXPECT_THROW((void)align(good, wrong), std::invalid_argument);
  wrong.heading = {.azimuth = 0, .sigma = 0, .axis = Vector3d::Zero()};
  EXPECT_THROW((void)align(good, wrong), std::invalid_argument);
  wrong = options;
  wrong.interval = 0;
  EXPECT_THROW((void)align(good, wrong), std::invalid_argument);
  wrong = options;
  wrong.sensor.gyro.powered_on_before = -1;
  EXPECT_THROW((void)align(good, wrong), std::invalid_argument);
  wrong = options;
  wrong.sensor.accelerometer->calibrated_over = 0;
  EXPECT_THROW((void)align(good, wrong), std::invalid_argument);
}

}  // namespace

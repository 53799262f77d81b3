// SPDX-License-Identifier: MIT
// Splines through samples: through every one, smooth to the second derivative, exact for cubics, of fourth
// order.
#include "gyrobudget/vehicle/earth/sampled.h"

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <vector>

namespace gyrobudget::earth {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Trajectory truth() {
  return cruise({.azimuth = 0.5, .speed = 200, .turn_acceleration = 3, .turn_period = 20, .duration = 60});
}

struct Samples {
  std::vector<double> times;
  std::vector<Vector3d> p_eb_e;
  std::vector<Quaterniond> q_eb;
};

/// Of the truth, unevenly spaced around h, each second attitude with the other sign.
Samples sampled(const Trajectory& path, double h) {
  Samples s;
  const int count = static_cast<int>(std::lround(path.duration() / h));
  for (int k = 0; k <= count; ++k) {
    const double t = std::min(path.duration(), k * h + (k % count == 0 ? 0 : 0.2 * h * std::sin(5.0 * k)));
    const TrajectoryPoint p = path.at(t);
    s.times.push_back(1000 + t);
    s.p_eb_e.push_back(p.pose.p_eb_e);
    s.q_eb.push_back(k % 2 == 0 ? p.pose.q_eb : Quaterniond(-p.pose.q_eb.coeffs()));
  }
  return s;
}

double turn_between(const Quaterniond& a, const Quaterniond& b) { return log_rotation(a.conjugate() * b).norm(); }

TEST(Sampled, PassesThroughEverySample) {
  const Samples s = sampled(truth(), 0.1);
  const Trajectory spline = through_samples(s.times, s.p_eb_e, s.q_eb);
  for (std::size_t k = 0; k < s.times.size(); ++k) {
    const TrajectoryPoint p = spline.at(s.times[k] - s.times[0]);
    ASSERT_LE((p.pose.p_eb_e - s.p_eb_e[k]).norm(), 4e-9);
    ASSERT_LE(turn_between(p.pose.q_eb, s.q_eb[k]), 1e-14);
  }
}

TEST(Sampled, IsOfFourthOrderAndItsForceOfSecond) {
  const Trajectory path = truth();
  const auto errors = [&](double h) {
    const Samples s = sampled(path, h);
    const Trajectory spline = through_samples(s.times, s.p_eb_e, s.q_eb);
    Eigen::Vector4d worst = Eigen::Vector4d::Zero();
    for (double t = 5; t < 55; t += 0.0137) {
      const TrajectoryPoint a = spline.at(t);
      const TrajectoryPoint b = path.at(t);
      worst = worst.cwiseMax(
          Eigen::Vector4d((a.pose.p_eb_e - b.pose.p_eb_e).norm(), turn_between(a.pose.q_eb, b.pose.q_eb),
                          (a.sensed.w_ib_b - b.sensed.w_ib_b).norm(), (a.sensed.f_ib_b - b.sensed.f_ib_b).norm()));
    }
    return worst;
  };
  const Eigen::Vector4d ratio = errors(1.0).cwiseQuotient(errors(0.25));
  // 4^4, 4^4, 4^3 and 4^2, each less a third for what is not yet asymptotic.
  EXPECT_GT(ratio(0), 256 / 1.5);
  EXPECT_GT(ratio(1), 256 / 1.5);
  EXPECT_GT(ratio(2), 64 / 1.5);
  EXPECT_GT(ratio(3), 16 / 1.5);
  EXPECT_LT(errors(0.25)(0), 1e-3);
}

TEST(Sampled, MeetsCubicsExactly) {
  const Vector3d p0(7e6, 1e5, -2e5);
  const auto p = [&](double t) -> Vector3d {
    return p0 + Vector3d(100, 5, -3) * t + Vector3d(1, 2, 3) * t * t + Vector3d(0.1, -0.2, 0.05) * t * t * t;
  };
  std::vector<double> times{0, 0.7, 1.1, 3, 3.4, 6};
  std::vector<Vector3d> positions;
  for (const double t : times) positions.push_back(p(t));
  for (const std::size_t count : {std::size_t{4}, times.size()}) {
    const std::vector<Quaterniond> level(count, Quaterniond::Identity());
    const Trajectory spline = through_samples(std::span(times).first(count), std::span(positions).first(count), level);
    for (double t = 0; t <= times[count - 1]; t += 0.05) {
      EXPECT_LE((spline.at(t).pose.p_eb_e - p(t)).norm(), 1e-8);
      EXPECT_LE((spline.at(t).pose.v_eb_e -
                 (Vector3d(100, 5, -3) + Vector3d(2, 4, 6) * t + Vector3d(0.3, -0.6, 0.15) * t * t))
                    .norm(),
                1e-7);
    }
  }
}

TEST(Sampled, ForceAndRateAreContinuousAtSamples) {
  const Samples s = sampled(truth(), 1);
  const Trajectory spline = through_samples(s.times, s.p_eb_e, s.q_eb);
  for (std::size_t k = 1; k + 1 < s.times.size(); ++k) {
    const double t = s.times[k] - s.times[0];
    const TrajectoryPoint before = spline.at(t - 1e-9);
    const TrajectoryPoint after = spline.at(t + 1e-9);
    ASSERT_LE((before.sensed.f_ib_b - after.sensed.f_ib_b).norm(), 1e-6);
    ASSERT_LE((before.sensed.w_ib_b - after.sensed.w_ib_b).norm(), 1e-8);
  }
}

TEST(Sampled, GeodeticSamplesAreTheSame) {
  const Samples s = sampled(truth(), 0.5);
  std::vector<Geodetic> places;
  std::vector<Quaterniond> q_nb;
  for (std::size_t k = 0; k < s.times.size(); ++k) {
    places.push_back(to_geodetic(s.p_eb_e[k]));
    q_nb.push_back(Quaterniond(C_e_ned(places[k].latitude, places[k].longitude)).conjugate() * s.q_eb[k]);
  }
  const Trajectory a = through_samples(s.times, s.p_eb_e, s.q_eb);
  const Trajectory b = through_samples(s.times, places, q_nb);
  for (double t = 0; t <= 60; t += 0.31) {
    ASSERT_LE((a.at(t).pose.p_eb_e - b.at(t).pose.p_eb_e).norm(), 2e-8);
    ASSERT_LE(turn_between(a.at(t).pose.q_eb, b.at(t).pose.q_eb), 1e-13);
  }
}

TEST(Sampled, IncrementsAreTheIntegralsOfTheSpline) {
  const Samples s = sampled(truth(), 1);
  const Trajectory spline = through_samples(s.times, s.p_eb_e, s.q_eb);
  // Midpoint sums with Richardson's extrapolation, per piece between samples, where the integrand is smooth.
  for (std::size_t k = 3; k < 8; ++k) {
    const double a = s.times[k] - s.times[0];
    const double b = s.times[k + 1] - s.times[0];
    const auto sum = [&](int n) {
      noise::ImuIncrement total;
      for (int j = 0; j < n; ++j) {
        const TrajectoryPoint p = spline.at(a + (b - a) * (j + 0.5) / n);
        vector(total.velocity) += p.sensed.f_ib_b * (b - a) / n;
        vector(total.angle) += p.sensed.w_ib_b * (b - a) / n;
      }
      return total;
    };
    const noise::ImuIncrement coarse = sum(500);
    const noise::ImuIncrement fine = sum(1000);
    const noise::ImuIncrement ours = spline.increment(a, b);
    EXPECT_LE((vector(ours.velocity) - (4 * vector(fine.velocity) - vector(coarse.velocity)) / 3).norm(), 1e-11);
    EXPECT_LE((vector(ours.angle) - (4 * vector(fine.angle) - vector(coarse.angle)) / 3).norm(), 1e-12);
  }
}

TEST(Sampled, RefusesWhatIsNoTrajectory) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> times{0, 1, 2, 3};
  const std::vector<Vector3d> here(4, Vector3d(6.4e6, 0, 0));
  const std::vector<Quaterniond> level(4, Quaterniond::Identity());
  EXPECT_NO_THROW(static_cast<void>(through_samples(times, here, level)));
  const auto refuses = [&](std::vector<double> t, std::vector<Vector3d> p, std::vector<Quaterniond> q) {
    EXPECT_THROW(static_cast<void>(through_samples(t, p, q)), std::invalid_argument);
  };
  refuses({0, 1, 2}, here, level);
  refuses({0, 1, 1, 3}, here, level);
  refuses({0, 1, nan, 3}, here, level);
  refuses({0, 1, 2}, {3, here[0]}, {3, level[0]});
  auto bad_place = here;
  bad_place[2].y() = nan;
  refuses(times, bad_place, level);
  auto long_one = level;
  long_one[1] = Quaterniond(1.1, 0, 0, 0);
  refuses(times, here, long_one);
  auto far_turn = level;
  far_turn[2] = exp_rotation({0, 1.6, 0});
  refuses(times, here, far_turn);
}

}  // namespace
}  // namespace gyrobudget::earth

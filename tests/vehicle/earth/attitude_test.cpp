// SPDX-License-Identifier: MIT
// Attitude tools against Eigen's general ones, long double and hand-derived values; round trips at many
// points.
#include "gyrobudget/vehicle/earth/attitude.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "points.h"
#include <Eigen/LU>

namespace gyrobudget::earth {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

Vector3d direction(Uniform& uniform) {
  for (;;) {
    const Vector3d v = uniform.vector(1);
    if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
  }
}

Quaterniond attitude(Uniform& uniform) { return exp_rotation(direction(uniform) * uniform(0, pi)); }

TEST(Attitude, ExponentialIsTheAxisAndAngle) {
  Uniform uniform(1);
  for (int k = 0; k < 5000; ++k) {
    const Vector3d axis = direction(uniform);
    const double angle = std::pow(10, uniform(-320, 1));
    const Quaterniond q = exp_rotation(axis * angle);
    const Quaterniond truth(Eigen::AngleAxisd(angle, axis));
    ASSERT_NEAR(q.w(), truth.w(), 4 * kEpsilon * (1 + angle));
    ASSERT_LE((q.vec() - truth.vec()).norm(), 4 * kEpsilon * angle + 1e-323);
    ASSERT_NEAR(q.norm(), 1, 4 * kEpsilon);
  }
  EXPECT_EQ(exp_rotation(Vector3d::Zero()).coeffs(), Quaterniond::Identity().coeffs());
  EXPECT_NEAR(exp_rotation({0, 0, pi}).z(), 1, kEpsilon);
}

TEST(Attitude, LogarithmUndoesItFromZeroToPi) {
  Uniform uniform(2);
  for (int k = 0; k < 10000; ++k) {
    const double small = std::pow(10, uniform(-300, 0));
    const double angle = k % 3 == 0 ? small : k % 3 == 1 ? pi - small : uniform(0, pi);
    const Vector3d phi = direction(uniform) * angle;
    const Quaterniond q = exp_rotation(phi);
    const Vector3d back = log_rotation(q);
    ASSERT_LE(back.norm(), pi * (1 + 4 * kEpsilon));
    if (angle < pi - 8 * kEpsilon) {  // at pi itself both signs are right
      ASSERT_LE((back - phi).norm(), 8 * kEpsilon * std::max(angle, 1e-300)) << angle;
    }
    const Vector3d other = log_rotation(Quaterniond(-q.coeffs()));
    if (q.w() != 0) {
      ASSERT_EQ(other, back);
    }
  }
  EXPECT_EQ(log_rotation(Quaterniond::Identity()), Vector3d::Zero());
  EXPECT_EQ(log_rotation(Quaterniond(-1, 0, 0, 0)), Vector3d::Zero());
  EXPECT_LE((log_rotation(Quaterniond(0, 0, 1, 0)) - Vector3d(0, pi, 0)).norm(), kEpsilon * pi);
}

TEST(Attitude, IncrementsActOnTheRight) {
  // A body at yaw 90 degrees that rolls about its own forward axis, which points east.
  const Quaterniond q_nb = from_euler({pi / 2, 0, 0}) * exp_rotation({0.1, 0, 0});
  const Euler e = to_euler(q_nb);
  EXPECT_NEAR(e.yaw, pi / 2, 4 * kEpsilon);
  EXPECT_NEAR(e.pitch, 0, 4 * kEpsilon);
  EXPECT_NEAR(e.roll, 0.1, 4 * kEpsilon);
  EXPECT_LE((q_nb * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 4 * kEpsilon);
  // Nose up: forward points against down.
  EXPECT_LE((from_euler({0, pi / 2, 0}) * Vector3d::UnitX() + Vector3d::UnitZ()).norm(), 4 * kEpsilon);
}

TEST(Attitude, SkewIsTheCrossProduct) {
  Uniform uniform(3);
  for (int k = 0; k < 100; ++k) {
    const Vector3d a = uniform.vector(10);
    const Vector3d b = uniform.vector(10);
    ASSERT_LE((skew(a) * b - a.cross(b)).norm(), 1e-13);
  }
}

TEST(Attitude, EulerRoundTripOfTheRotation) {
  Uniform uniform(4);
  for (int k = 0; k < 10000; ++k) {
    const double off = std::pow(10, uniform(-18, 0));
    const Quaterniond q =
        k % 2 == 0 ? attitude(uniform)
                   : from_euler({uniform(-pi, pi), std::copysign(pi / 2 - off, uniform(-1, 1)), uniform(-pi, pi)});
    const Euler e = to_euler(q);
    ASSERT_LE(std::abs(e.pitch), pi / 2);
    ASSERT_LE(std::abs(e.yaw), pi * (1 + kEpsilon));
    ASSERT_LE(std::abs(e.roll), pi * (1 + kEpsilon));
    // Inside the lock yaw and roll are told as one angle, which moves the attitude by up to 2e-10.
    const double tolerance = pi / 2 - std::abs(e.pitch) < 1e-10 ? 2.1e-10 : 16 * kEpsilon;
    ASSERT_LE(log_rotation(q.conjugate() * from_euler(e)).norm(), tolerance) << e.pitch;
  }
}

TEST(Attitude, EulerAnglesComeBack) {
  Uniform uniform(5);
  for (int k = 0; k < 10000; ++k) {
    const Euler e{uniform(-3.1, 3.1), uniform(-1.57, 1.57), uniform(-3.1, 3.1)};
    const Euler back = to_euler(from_euler(e));
    const double lock = 8 * kEpsilon / std::cos(e.pitch);
    ASSERT_NEAR(back.pitch, e.pitch, 8 * kEpsilon);
    ASSERT_NEAR(back.yaw, e.yaw, lock + 8 * kEpsilon);
    ASSERT_NEAR(back.roll, e.roll, lock + 8 * kEpsilon);
  }
}

TEST(Attitude, OnThePadYawIsZero) {
  for (const double roll : {-3.0, -0.5, 0.0, 1.0, 3.0}) {
    const Euler up = to_euler(from_euler({0, pi / 2, roll}));
    EXPECT_EQ(up.yaw, 0);
    EXPECT_NEAR(up.pitch, pi / 2, 4 * kEpsilon);
    EXPECT_NEAR(up.roll, roll, 8 * kEpsilon);
    const Euler down = to_euler(from_euler({0.2, -pi / 2, roll}));
    EXPECT_EQ(down.yaw, 0);
    EXPECT_NEAR(std::remainder(down.roll - (0.2 + roll), 2 * pi), 0, 8 * kEpsilon);
  }
}

TEST(Attitude, OrthonormalisedIsTheNearestRotation) {
  Uniform uniform(6);
  for (int k = 0; k < 500; ++k) {
    const Matrix3d R = attitude(uniform).toRotationMatrix();
    ASSERT_LE((orthonormalised(R) - R).norm(), 16 * kEpsilon);
    // A rotation times a symmetric positive matrix has that rotation as its polar factor.
    Matrix3d S = Matrix3d::Identity();
    const Vector3d off = uniform.vector(0.2);
    S(0, 1) = S(1, 0) = off.x();
    S(0, 2) = S(2, 0) = off.y();
    S(1, 2) = S(2, 1) = off.z();
    ASSERT_LE((orthonormalised(R * S) - R).norm(), 64 * kEpsilon);
    const double distance = (orthonormalised(R * S) - R * S).norm();
    const Matrix3d other = R * exp_rotation(direction(uniform) * 1e-3).toRotationMatrix();
    ASSERT_GT((other - R * S).norm(), distance);
  }
  Matrix3d mirror = Matrix3d::Identity();
  mirror(2, 2) = -1;
  EXPECT_THROW(static_cast<void>(orthonormalised(mirror)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(orthonormalised(Matrix3d::Zero())), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(orthonormalised(Matrix3d::Constant(std::nan("")))), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::earth

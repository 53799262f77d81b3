// SPDX-License-Identifier: MIT
// What aids measure, linearised about the filter's estimate: residual z - z^ and rows H with
// residual = H x + v. Sources: Groves (2013), sections 14.3 (GNSS, with lever arm) and 15 (zero velocity).
#pragma once

#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include "covariance.h"
#include "errors.h"
#include "strapdown.h"
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::navigation {

/// One to three scalars whose errors are independent.
struct Measurement {
  int rows = 0;
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();
  std::array<MeasurementRow, 3> row;
};

/// The estimate that a measurement is compared with.
struct Estimate {
  earth::Motion motion;
  const ErrorStateModel* model = nullptr;
  const double* terms = nullptr;  ///< estimates of model->terms
};

// Every fix has the number of its aid, to which the aid's error terms refer (-1: none), and one-sigma errors that
// are white from fix to fix along `axes`: columns are directions in ECEF, C_el of a site for east, north, up.

/// Position of an antenna at lever_arm [m, body axes] from the IMU, p + C_eb l:
///   H = [I, 0, -[C_eb l x]],  lever arm: C_eb e_i,  time tag: dp/dt of the antenna,  bias: axes e_i.
struct PositionFix {
  Eigen::Vector3d p_eb_e;
  Eigen::Vector3d sigma;  ///< [m]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  int aid = -1;
};

/// Velocity of the antenna, v + C_eb (w_eb_b x l); zero of all on the pad (zero-velocity update):
///   H = [0, I, -[C_eb (w x l) x]],  gyro bias: C_eb (-e_i x l),  lever arm: C_eb (w x e_i),  time tag: a_eb_e.
struct VelocityFix {
  Eigen::Vector3d v_eb_e;
  Eigen::Vector3d sigma;  ///< [m/s]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  int aid = -1;
};

/// Height above the ellipsoid, of a barometer or radar: H = up^T; bias: axis 0; time tag: up . v.
struct HeightFix {
  double height = 0;  ///< [m]
  double sigma = 1;   ///< [m]
  int aid = -1;
};

/// Attitude of a star tracker or of a master: residual is log(q_eb q^_eb^-1), seen in body axes.
///   H = C_be on psi,  bias: e_i, the mounting of the aid on the body,  time tag: w_eb_b.
struct AttitudeFix {
  Eigen::Quaterniond q_eb;
  Eigen::Vector3d sigma;  ///< about the body axes [rad]
  int aid = -1;
};

/// @throws SetupError for a sigma that is not positive and finite.
[[nodiscard]] Measurement measure(const PositionFix& fix, const Estimate& estimate);
[[nodiscard]] Measurement measure(const VelocityFix& fix, const Estimate& estimate);
[[nodiscard]] Measurement measure(const HeightFix& fix, const Estimate& estimate);
[[nodiscard]] Measurement measure(const AttitudeFix& fix, const Estimate& estimate);

}  // namespace gyrobudget::inline v0::navigation

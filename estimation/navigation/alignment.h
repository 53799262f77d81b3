// SPDX-License-Identifier: MIT
// Attitude of a body that stands, from what its IMU senses: weight gives the level, Earth's rate the heading.
// Sources: Titterton & Weston, Strapdown Inertial Navigation Technology (2004), chapter 10; Groves (2013),
// section 5.6; Britting, Inertial Navigation Systems Analysis (1971), section 9.2.
#pragma once

#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <optional>
#include <span>
#include <string>

#include "errors.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::navigation {

/// Means over a record of a body at rest.
struct StaticMeans {
  Eigen::Vector3d f_ib_b;  ///< [m/s^2]
  Eigen::Vector3d w_ib_b;  ///< [rad/s]
  double duration = 0;     ///< [s]
};

/// Heading from outside: a sighting, a compass, a survey of the pad.
struct GivenHeading {
  double azimuth = 0;  ///< of `axis`, or of its horizontal part, clockwise from north [rad]
  double sigma = 0;    ///< [rad]
  /// A body axis that is not vertical: forward, or on a launch pad the belly (0, 0, 1).
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
};
/// Of the body axis that lies most nearly level, for a body that stands like q_nb.
[[nodiscard]] GivenHeading heading_of(const Eigen::Quaterniond& q_nb, double sigma);

struct AlignmentOptions {
  /// One sigma of what the record cannot show. Its epoch is where the record starts: slow errors have moved since the
  /// sensor was switched on or calibrated before that.
  noise::SensorModel sensor;
  /// Of the IMU [s], that of the increments where these are given: after power-on flicker holds all of its band.
  double interval = 0.01;
  std::optional<double> latitude;              ///< [rad]; not given: found from the record
  std::optional<GivenHeading> heading;         ///< not given: by Earth's rate
  double heading_limit = 10 * earth::kDegree;  ///< sigma of heading above which it counts as not observable [rad]
};

/// Attitude of the mean pose over the record, with q_nb against north, east, down. A heading that is given
/// replaces the one by Earth's rate.
///
/// Its error is psi in east, north, up, q = exp(psi) q^ as error_state.h has it (psi_e = C_e_enu psi). With
/// errors df, dw of the means in these axes, c = Omega cos L,
///   psi_E = -df_N/g,  psi_N = df_E/g,  psi_U = psi_N tan L - dw_E/c:
/// accelerometer bias b costs b/g of level; gyro bias e costs e/c of heading, white noise N/(c sqrt(T)).
/// Tilt and accelerometer bias, heading and gyro bias are then correlated, and a filter that starts without
/// it starts wrong.
struct Alignment {
  /// One sigma of the parts of psi [rad]: east, north, up (heading).
  struct Parts {
    /// Turn-on bias, or what a calibration left of it, and the mean since the epoch of flicker, random walk, ramp and
    /// Gauss-Markov.
    Eigen::Vector3d bias = Eigen::Vector3d::Zero();
    Eigen::Vector3d calibration = Eigen::Vector3d::Zero();  ///< scale, misalignment, g-sensitivity
    Eigen::Vector3d noise = Eigen::Vector3d::Zero();        ///< white noise and quantization
    /// What the record itself shows beyond that: sway, people, thermal creep. From the scatter of the means
    /// of six equal parts beyond what the sensor's own errors make of it, widened by Student's t so that 1.96 sigma
    /// hold 95 %. Zero where only means were
    /// given.
    Eigen::Vector3d motion = Eigen::Vector3d::Zero();
    Eigen::Vector3d heading = Eigen::Vector3d::Zero();  ///< of a heading from outside
  };

  std::optional<Eigen::Quaterniond> q_nb;  ///< none where heading is neither observable nor given
  Eigen::Vector3d up_b;                    ///< the vertical in body axes; always there
  bool heading_observable = false;         ///< by Earth's rate, from this record
  std::string message;                     ///< for people: why not, what to do, what the sigmas leave out
  Parts parts;
  Eigen::Matrix3d covariance;  ///< of psi [rad^2]; the heading of one that is not known counts pi/sqrt(3)
  /// psi by errors of the means, as in "reads true + b", of gyro x, y, z and accelerometer x, y, z in body axes
  /// [rad per rad/s, rad per m/s^2]: to first order all of psi but for a given heading's own error. A heading that
  /// is not known has a row of zeros.
  Eigen::Matrix<double, 3, 6> by_means;
  /// What bias and calibration are assumed to add to the means, in the order of by_means.
  Eigen::Matrix<double, 6, 1> mean_error_variance;
  /// E[psi b'] with the mean biases of the sensors in body axes, as in "reads true + b".
  Eigen::Matrix3d gyro_bias_covariance;           ///< [rad rad/s]
  Eigen::Matrix3d accelerometer_bias_covariance;  ///< [rad m/s^2]
  Eigen::Vector3d gyro_bias_variance;             ///< per axis, as the covariances assume [rad^2/s^2]
  Eigen::Vector3d accelerometer_bias_variance;    ///< [m^2/s^4]
  /// The record's own answer, for a check on the site: arcsin of the vertical part of Earth's rate.
  double latitude = 0;        ///< [rad]
  double latitude_sigma = 0;  ///< [rad]
  StaticMeans means;

  /// psi's one sigma: level about east, level about north, heading [rad].
  [[nodiscard]] Eigen::Vector3d sigma() const { return covariance.diagonal().cwiseSqrt(); }
};

/// Coarse alignment in closed form, from increments of `dt` seconds each. Sway may be any that leaves the
/// mean: means are taken over the whole record. Linear in the errors: good where sigmas are below 10 degrees.
/// At a pitch of 90 degrees, as on a launch pad, nothing changes.
/// @throws SetupError for fewer than 12 increments, a latitude beyond 90 degrees, a limit or sigma out of range, a
/// heading's axis of zero, an interval of the IMU or an epoch of the sensor out of range; std::invalid_argument for dt
/// not positive, numbers that are not finite and a mean specific force of zero.
[[nodiscard]] Alignment align(std::span<const noise::ImuIncrement> imu, double dt, const AlignmentOptions& options);
/// The same from means alone: what the body did in the meantime is not seen.
[[nodiscard]] Alignment align(const StaticMeans& means, const AlignmentOptions& options);

}  // namespace gyrobudget::inline v0::navigation

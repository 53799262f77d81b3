// SPDX-License-Identifier: MIT
// What flies in the paper's figures 8 to 10, and on what navigation.
#pragma once

#include "gyrobudget/estimation/closed_loop/study.h"
#include "gyrobudget/estimation/closed_loop/tilt.h"
#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/flight/plan.h"

#include <array>
#include <cstddef>
#include <cstdint>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::paper {

inline constexpr std::size_t kPaperGyros = 3;  ///< ideal, IFOG, MEMS
inline constexpr double kKm = 1000;
inline constexpr std::array kPublishedKm{0.20, 4.66, 5.92};
/// Errors of each; of the ideal gyro none.
using PaperGyroErrors = std::array<noise::ErrorModel, kPaperGyros>;
[[nodiscard]] bool noisy(const noise::ErrorModel&);

/// The vehicle at the paper's scale; its attitude loop damps the rate's error, so that it does not lag.
[[nodiscard]] flight::Plan prompt_plan();
/// It damps the rate itself.
[[nodiscard]] flight::Plan lagging(flight::Plan);
[[nodiscard]] flight::Plan towards(flight::Plan, double azimuth);
/// By how much a lagging loop is late, 2 damping/frequency [s].
[[nodiscard]] double lag_of(const flight::Plan&);

[[nodiscard]] const Eigen::Vector3d& end_of(const flight::FlightRecord&);                 ///< p_eb_e of the IMU
[[nodiscard]] double distance(const flight::FlightRecord&, const flight::FlightRecord&);  ///< of the ends [m]
/// The end of a flight with its nose on the program and its nozzle straight: p_eb_e of the IMU.
[[nodiscard]] Eigen::Vector3d exact_end(const flight::Plan&);
/// Rotation vector from one attitude to another, body axes: roll, pitch, yaw.
[[nodiscard]] Eigen::Vector3d body_turn(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to);

/// What is flown, from what its distance is taken, and on what navigation.
struct PaperSetting {
  flight::Plan plan, reference;
  navigation::Strapdown::Options strapdown;
};

/// With one gyro; the study's dispersion is of `runs` flights.
[[nodiscard]] closed_loop::Study fly_many(const PaperSetting&, const noise::ErrorModel& gyro, int runs,
                                          std::uint64_t seed);
/// Of all that came to the end, from the reference's; 0 for none [m].
[[nodiscard]] double rms_distance(const closed_loop::Study&, const flight::FlightRecord& reference);

/// Pitch gyro and first attitude that are wrong by a constant.
struct WrongPitch {
  double angle = 0;  ///< [rad]
  double rate = 0;   ///< [rad/s]
};
[[nodiscard]] flight::FlightRecord fly_wrong(const PaperSetting&, const WrongPitch& = {});

/// To first order, where the setting alone takes the flight from its reference: lag and Earth's rate [m, e axes].
[[nodiscard]] Eigen::Vector3d expected_place(const PaperSetting&, const closed_loop::TiltResponse& reference);

}  // namespace gyrobudget::inline v0::paper

// SPDX-License-Identifier: MIT
// Why a filter is lost: what could be wrong with a scene is tried, not guessed.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "recording.h"
#include "scenario.h"

namespace gyrobudget::inline v0::navigation {

/// One thing that may be wrong with a scene, and how much of the misfit it explains.
struct Suspect {
  enum class Kind {
    clock,      ///< `value` is to be added to the stamps of an aid [s]
    lever_arm,  ///< `lever_arm` of an aid [m]
    axes,       ///< of the IMU: `axes` are the scene's axes that point forward, right, down
    unit,       ///< of `sensor`: its numbers times `value` are right
    heading,    ///< of the start: `value` is to be added [rad]
    sigma,      ///< of an aid, to be `value` times as large
  };
  Kind kind = Kind::clock;
  std::vector<std::size_t> aids;  ///< those it is of
  double value = 0;
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();
  std::string axes;       ///< "y, x, -z"
  bool mirrored = false;  ///< left-handed axes: no turn makes them right
  bool gyro = false;      ///< of a unit: of the gyro; else of the accelerometer
  /// Share of the misfit that is gone with it, 0 to 1. With n the NIS of a fix and m its rows, n' the smaller of n and
  /// the point that a right fix passes once in a million, the misfit is the mean of max(0, n' - m)/m over the watched
  /// fixes (position, velocity, height) of the part of the log that is tried.
  double explained = 0;
};

/// What is tried, each by itself, by a run of the navigator without recovery:
///   clocks of each device: 18 s (GPS time and UTC) and every whole second up to 20 s, then around the best in steps of
///   0.2 s and 0.04 s; the device's lever arm, estimated with a sigma of 3 m and ten times the aids' sigmas, then again
///   about the estimate with the sigmas as they are; the 47 other ways in which the axes can be permuted and turned,
///   mirrors too; gyro in deg/s for rad/s or the reverse, accelerometer in g for m/s^2 or the reverse; the heading
///   turned by 180 and 90 degrees; each device's sigmas times 3 and 10.
/// Those that explain at least a fifth, one of each kind and device, no more than kMostSuspects; the best first, and
/// sigmas last: larger ones explain any misfit. Empty where the misfit of the scene as it is is below 1; right sigmas
/// give about a half.
///
/// Runs are over the first 200 s after the alignment began, or 40 000 intervals of the IMU if these are
/// fewer, with the covariance moved ten times a second: about 150 runs, 0.1 s each of a processor at 100 Hz; those of
/// one kind run in parallel. The same result for any number of threads.
/// @throws as navigate().
[[nodiscard]] std::vector<Suspect> suspects(const Scenario& scenario, const Recording& recording);

inline constexpr std::size_t kMostSuspects = 5;

}  // namespace gyrobudget::inline v0::navigation

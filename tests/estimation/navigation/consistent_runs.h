// SPDX-License-Identifier: MIT
// Runs of the whole filter against a truth with exact 1/f noise, for the test and the study of consistency.
#pragma once

#include "gyrobudget/estimation/navigation/consistency.h"
#include "gyrobudget/noise/sensor.h"

#include <optional>
#include <vector>

namespace gyrobudget::consistency {

struct Scene {
  noise::SensorModel sensor;
  double duration = 600;                      ///< [s]
  double outage_from = 300, outage_to = 360;  ///< of GNSS [s]
  int flicker_states = 3;                     ///< of each axis
  double band = 600;                          ///< scene length that the states are made for [s]
  std::optional<double> shortest;             ///< start of their band [s]
  double imu_interval = 0.02;                 ///< [s]
  int runs = 100;
};

/// Means over the runs, each second.
struct Verdict {
  std::vector<double> navigation;  ///< NEES of position, velocity and attitude: 9 when right
  std::vector<double> bias;        ///< NEES of each gyro's total bias over the last second, mean of axes: 1 when right
  std::vector<double> nis;         ///< of position and velocity together: 6 when right; one a fix
  std::vector<double> of_run;      ///< mean over time of each run's NEES of navigation
  int runs = 0;

  [[nodiscard]] static double mean(const std::vector<double>&);
  /// Share of epochs at which the mean of `count` chi-square numbers of `dof` is inside its 95 % band.
  [[nodiscard]] static double inside(const std::vector<double>& mean_nees, double dof, double count);
};

[[nodiscard]] Verdict fly(const Scene&, std::uint64_t seed);

[[nodiscard]] noise::SensorModel fibre_optic();  ///< of the paper, beside a good accelerometer
[[nodiscard]] noise::SensorModel mems();         ///< of the paper, beside a fair one

}  // namespace gyrobudget::consistency

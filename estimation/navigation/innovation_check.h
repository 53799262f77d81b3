// SPDX-License-Identifier: MIT
// What innovations say of the sigmas that a scene tells: which are wrong, and by how much.
#pragma once

#include <optional>
#include <vector>

#include "navigate.h"

namespace gyrobudget::inline v0::navigation {

/// Of one aid whose mean NIS over its degrees of freedom is below 1/2 or above 2.
struct InnovationVerdict {
  std::size_t aid = 0;
  double nis_per_dof = 1;
  /// From one fix to the next: sum x_k . x_(k+1)/sum x_k^2 of the residuals x that were used. Right ones are white:
  /// within 5/sqrt(n) of 0 for n of them. Above 1/2 they are taken for correlated:
  double correlation = 0;
  struct Correlated {
    double sigma = 0;  ///< rms of a component: of the slow error no more than what the filter did not follow, SI
    double time = 0;   ///< in which the correlation falls to 1/e [s]; the longest lag looked at where it does not
    double white = 0;  ///< rms of the change from fix to fix over sqrt(2), SI
  };
  std::optional<Correlated> correlated;
};
/// In the order of the aids; those with fewer than 100 fixes used are not judged.
[[nodiscard]] std::vector<InnovationVerdict> innovation_verdicts(const Navigation& run);

/// Factors that make the innovations likeliest, ln L = -1/2 sum (n' + ln det S), n' the NIS of a fix up to the point
/// that a right one passes once in a million, over the watched fixes of the first 200 s. Each is found with the other
/// as it is, among powers of the root of 2 from 1/16 to 64.
struct NoiseFactors {
  double imu = 1;       ///< of the white noise of gyro and accelerometer: above 1 under vibration, say
  double imu_gain = 0;  ///< of ln L over the scene as it is
  double aids = 1;      ///< of the white sigmas of positions, velocities and heights
  double aids_gain = 0;
};
/// Some 40 runs, as long as those of suspects(). @throws as navigate().
[[nodiscard]] NoiseFactors noise_factors(const Scenario& scenario, const Recording& recording);

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>

#include "sensors.h"

namespace gyrobudget::tests {

/// What simulated records of known truth say of the fit, for one coefficient.
struct CoefficientStudy {
  double bias = 0;                ///< mean of value/truth - 1
  double rmse = 0;                ///< root mean square of value/truth - 1
  double bound = 0;               ///< Cramer-Rao bound on it
  double coverage = 0;            ///< part of the two-sided 95 % intervals that hold the truth
  double coverage_by_status = 0;  ///< the same with the one-sided limit where zero is not excluded
  double identified = 0;          ///< part of the records in which zero is excluded
};

struct Study {
  int records = 0;
  std::array<CoefficientStudy, 3> coefficients;  ///< N, B, K
  double p_below_5_percent = 0;                  ///< part of the records with p < 0.05 over all taus
  double p_below_1_percent = 0;
  double cut = 0;  ///< part of the records in which short taus were cut
  double not_described = 0;
  double unconverged = 0;
  double seconds_per_fit = 0;
};

/// Simulates `records` logs of the gyro (exact generator) and fits N, B and K to each.
[[nodiscard]] Study run_study(const Gyro&, int records, std::int64_t samples, double dt, std::uint64_t seed);

}  // namespace gyrobudget::tests

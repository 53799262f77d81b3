// SPDX-License-Identifier: MIT
#include "findings.h"

namespace gyrobudget::inline v0::calibration {

bool Findings::outliers_spoil() const {
  constexpr double kSpoils = 0.01;  // of the variance, in squares of sigma
  double squares = 0;
  for (const auto& outlier : outliers) squares += outlier.sigmas * outlier.sigmas;
  return !outliers_masked && squares > kSpoils * static_cast<double>(samples);
}

}  // namespace gyrobudget::inline v0::calibration

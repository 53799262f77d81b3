// SPDX-License-Identifier: MIT
#include "findings.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrobudget::inline v0::calibration {

bool Findings::any() const {
  return held || rounded_above_noise() || !saturation.empty() || turns || !outliers.empty() || !motion.empty() ||
         !steps.empty() || departure || !humps.empty() || !lines.empty();
}

double Findings::outlier_share() const { return static_cast<double>(outliers.size()) / static_cast<double>(samples); }

bool Findings::has_heavy_tail() const {
  constexpr double kShare = 0.005;
  constexpr std::size_t kParts = 64, kMost = 3 * kParts / 4;  // parts of equal length, and how many must have one
  if (outlier_share() < kShare) return false;
  std::array<bool, kParts> has{};
  for (const auto& outlier : outliers) {
    const std::int64_t part = (outlier.index - first) * static_cast<std::int64_t>(kParts) / samples;
    if (part >= 0 && part < static_cast<std::int64_t>(kParts)) has[static_cast<std::size_t>(part)] = true;
  }
  std::size_t count = 0;
  for (const bool one : has) count += one ? 1 : 0;
  return count >= kMost;
}

fit::WhiteShift Findings::shift_by_outliers(double white, double dt) const {
  if (!tail || !(white > 0)) return {};
  const double part = tail->sigma * tail->sigma * dt / (white * white);  // of N^2: below 1 behind a low pass
  if (outliers_masked) {
    const double left = std::max(tail->left * part, -0.5);
    return {-0.5 * std::log1p(left), 0.5 * tail->left_sigma * part / (1 + left)};
  }
  const double raised = 1 - tail->share + tail->share * tail->sigmas * tail->sigmas;
  const double excess = std::max(0., kurtosis(*tail) - 3) / static_cast<double>(samples);
  return {0, 0.5 * std::sqrt(excess) * std::min(1., part * raised)};
}

double Findings::saturated_share() const {
  std::int64_t count = 0;
  for (const auto& end : saturation) count += end.count;
  return static_cast<double>(count) / static_cast<double>(samples);
}

bool Findings::outliers_spoil() const {
  constexpr double kSpoils = 0.01;  // of the variance, in squares of sigma
  double squares = 0;
  for (const auto& outlier : outliers) squares += outlier.sigmas * outlier.sigmas;
  return !outliers_masked && squares > kSpoils * static_cast<double>(samples);
}

bool Findings::saturation_spoils() const {
  constexpr double kSpoils = 0.001;
  return saturated_share() > kSpoils;
}

bool Findings::spoil() const {
  return outliers_spoil() || steps_spoil() || departure_spoils() || saturation_spoils() || not_at_rest() ||
         not_of_one_sensor() || rounded_above_noise();
}

}  // namespace gyrobudget::inline v0::calibration

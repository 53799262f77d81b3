// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>

namespace gyrobudget::inline v0::allan {

/// The steps in which a record is written.
struct Rounding {
  double step = 0;            ///< q [signal]
  std::int64_t distinct = 0;  ///< different values; kMostDistinct where there are more
  double scatter = 0;         ///< of samples about their neighbours, one sigma, rounding included [signal]
  double wander = 0;          ///< range of the means of 32 samples, in steps
  bool of_angle = false;      ///< rounded is what the samples are increments of: the errors of neighbours cancel

  /// A step of twice the noise and more: what is written is no longer noise plus an error of its own.
  [[nodiscard]] bool is_above_noise() const { return !of_angle && step > kMostStep * scatter; }
  /// The mean passes over several steps, which does for long averaging times what noise does for all.
  [[nodiscard]] bool is_dithered_by_wander() const { return wander > kFewestSteps; }
  /// White noise that the rounding is, as a share of all the noise of a sample; only where the step is not above it.
  [[nodiscard]] double share() const { return step * step / 12 / (scatter * scatter); }

  static constexpr double kMostStep = 1.7;  ///< a step of 2 sigma is 1.71 to 1.75 of the scatter, wherever the mean is
  static constexpr double kFewestSteps = 3;
  static constexpr std::int64_t kMostDistinct = 4096;
};

/// The steps of a record, if it has any that matter.
///
/// q is the smallest difference of neighbouring samples above zero; it is a step where all differences are whole
/// multiples of it, to 1 % of q and the rounding of double. The scatter is the root of the median variance of windows
/// of 32 samples. Rounding to q far below the noise adds white noise of variance q^2/12 to each sample and nothing
/// else; for Gaussian noise of sigma the error of that is below 4 (sigma^2 + q^2/(4 pi^2)) exp(-2 pi^2 sigma^2/q^2):
/// 1e-8 of sigma^2 at q = sigma, 3 % at 2 sigma, 60 % at 3 sigma, with a sign that depends on where the mean lies
/// between two steps. An angle that is rounded before it is differenced makes neighbouring errors cancel
/// (autocorrelation below
/// -1/4 at one sample): that is quantization, which the model has.
/// Records without steps have a q that no other difference is a multiple of: of 3000 records of Gaussian noise without
/// rounding (64 to 4096 samples) none showed a step (tests).
/// @return nothing where samples have no steps, where q is below 1/20 of the scatter (0.02 % of the variance), and for
///         fewer than 64 samples.
[[nodiscard]] std::optional<Rounding> find_rounding(std::span<const double> rate);

}  // namespace gyrobudget::inline v0::allan

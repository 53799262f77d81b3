// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// The estimators of frequency (here: rate) stability, by the names that Stable32 and AllanTools use.
/// Equations: see family.h. All but the time deviations are in the unit of the signal, those in signal x s
/// (rad for a gyro).
enum class Estimator {
  adev,     ///< Allan deviation of adjacent clusters
  oadev,    ///< overlapped Allan deviation
  mdev,     ///< modified Allan deviation: tells white from flicker phase noise
  tdev,     ///< time deviation, tau/sqrt(3) times mdev
  hdev,     ///< Hadamard deviation of adjacent clusters: blind to a rate ramp
  ohdev,    ///< overlapped Hadamard deviation
  totdev,   ///< total deviation: the record is continued by reflection, for more confidence at long tau
  mtotdev,  ///< modified total deviation
  ttotdev,  ///< time total deviation, tau/sqrt(3) times mtotdev
  htotdev,  ///< Hadamard total deviation
  theo1,    ///< Theo1: reaches tau = 0.75 T
};

inline constexpr Estimator kEstimators[] = {Estimator::adev,    Estimator::oadev,   Estimator::mdev,
                                            Estimator::tdev,    Estimator::hdev,    Estimator::ohdev,
                                            Estimator::totdev,  Estimator::mtotdev, Estimator::ttotdev,
                                            Estimator::htotdev, Estimator::theo1};

[[nodiscard]] std::string_view name(Estimator);
[[nodiscard]] std::optional<Estimator> estimator_named(std::string_view);

/// Averaging time tau [s] of a factor m: m dt, but 0.75 m dt for Theo1.
[[nodiscard]] constexpr double averaging_time(Estimator estimator, std::int64_t m, double dt) {
  return (estimator == Estimator::theo1 ? 0.75 : 1.0) * static_cast<double>(m) * dt;
}

/// The factors that an estimator has at least one term for: from `least` to `most` in steps of `step`. None
/// where most < least.
struct FactorRange {
  std::int64_t least, most, step;
};
/// For a record of n samples: 1 .. n/2 (Allan), (n+1)/3 (modified), n/3 (Hadamard), n-1 (total); even numbers
/// 10 .. n for Theo1.
[[nodiscard]] FactorRange factor_range(Estimator, std::int64_t samples);

/// 1, 2, 4, ... within the range; for Theo1 the m of averaging times 0.75 m nearest to those: 10, 22, 42, 86,
/// ...
[[nodiscard]] std::vector<std::int64_t> octave_factors(Estimator, std::int64_t samples);
/// What an estimator can do of a list of factors made for `tau = m dt`: those in range; for Theo1 4m/3 to the
/// nearest even number. Ascending, without repeats.
[[nodiscard]] std::vector<std::int64_t> usable_factors(Estimator, std::int64_t samples,
                                                       std::span<const std::int64_t> factors);

}  // namespace gyrobudget::inline v0::allan

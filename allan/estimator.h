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
  theobr,   ///< Theo1, its bias removed by the record's own ratio of Allan to Theo1 at short tau
  theoh,    ///< overlapped Allan deviation to a fifth of the record, TheoBR beyond
  pdev,     ///< parabolic deviation: of the slopes of lines fitted to the phases of neighbouring clusters
};

inline constexpr Estimator kEstimators[] = {
    Estimator::adev,  Estimator::oadev,  Estimator::mdev,    Estimator::tdev,    Estimator::hdev,
    Estimator::ohdev, Estimator::totdev, Estimator::mtotdev, Estimator::ttotdev, Estimator::htotdev,
    Estimator::theo1, Estimator::theobr, Estimator::theoh,   Estimator::pdev};

[[nodiscard]] std::string_view name(Estimator estimator);
[[nodiscard]] std::optional<Estimator> estimator_named(std::string_view wanted);

/// Averaging time tau [s] of a factor m: m dt, but 0.75 m dt for Theo1 and TheoBR.
[[nodiscard]] constexpr double averaging_time(Estimator estimator, std::int64_t m, double dt) {
  const bool stretched = estimator == Estimator::theo1 || estimator == Estimator::theobr;
  return (stretched ? 0.75 : 1.0) * static_cast<double>(m) * dt;
}

/// What the terms of an estimator at factor m are: its own, but those of Theo1 for TheoBR, and for TheoH those of the
/// oadev where 5 m <= n and of Theo1 at 4m/3 beyond.
struct Basis {
  Estimator estimator;
  std::int64_t m;
};
[[nodiscard]] constexpr Basis basis_of(Estimator estimator, std::int64_t samples, std::int64_t m) {
  if (estimator == Estimator::theobr) return {Estimator::theo1, m};
  if (estimator != Estimator::theoh) return {estimator, m};
  if (5 * m <= samples) return {Estimator::oadev, m};
  return {Estimator::theo1, 4 * m / 3};
}

/// The factors that an estimator has at least one term for: from `least` to `most` in steps of `step`. None
/// where most < least.
struct FactorRange {
  std::int64_t least, most, step;
};
/// For a record of n samples: 1 .. n/2 (Allan), (n+1)/3 (modified), n/3 (Hadamard), n-1 (total); even numbers
/// 10 .. n for Theo1, 12 .. n for TheoBR; for TheoH 1 .. 3n/4, beyond n/5 multiples of 3 that have terms of Theo1.
[[nodiscard]] FactorRange factor_range(Estimator estimator, std::int64_t samples);

/// Whether an estimator has terms at factor m: within the range, in its steps.
[[nodiscard]] bool has_terms(Estimator estimator, std::int64_t samples, std::int64_t m);

/// 1, 2, 4, ... within the range; for Theo1 the m of averaging times 0.75 m nearest to those: 10, 22, 42, 86,
/// ...
[[nodiscard]] std::vector<std::int64_t> octave_factors(Estimator estimator, std::int64_t samples);
/// What an estimator can do of a list of factors made for `tau = m dt`: those in range; for Theo1 and TheoBR 4m/3 to
/// the nearest even number, for TheoH multiples of 3 beyond n/5. Ascending, without repeats.
[[nodiscard]] std::vector<std::int64_t> usable_factors(Estimator estimator, std::int64_t samples,
                                                       std::span<const std::int64_t> factors);

}  // namespace gyrobudget::inline v0::allan

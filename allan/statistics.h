// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>
#include <vector>

#include "confidence.h"
#include "deviation.h"
#include "identify.h"

namespace gyrobudget::inline v0::allan {

/// An estimate, as the bias and the scatter of its estimator depend on it.
struct Estimation {
  Estimator estimator = Estimator::oadev;
  std::int64_t samples = 0;  ///< n
  std::int64_t m = 1;        ///< averaging factor
  double dt = 1;             ///< [s]
  std::int64_t stride = 1;   ///< from one term to the next; see stride_of
};

/// Equivalent degrees of freedom 2 E[s]^2 / var(s) of an estimate s for a Gaussian sum of processes. (A sinusoid
/// of many cycles counts roughly only, as if it were noise: for the oadev see confidence.h.)
///
/// - adev, oadev, hdev, ohdev at any stride: exact, from the sum over all lags, to 1e-8.
/// - mdev, tdev: exact to m = 64, within 0.5 % above.
/// - The totals and Theo1: exact from the estimate's quadratic form in the phases for at least m <= 16
///   (Theo1: 48) with n <= 13 m (5 m). For longer clusters the form of a record with fewer samples a cluster
///   and the same n/m stands in, for longer records the straight line in n/m through two such: within 2 %,
///   Theo1 of white noise 3 %. So is the pdev; TheoBR and TheoH count as what they are made of (the scatter of the
///   ratio in TheoBR is left out). Quantization is the exception: its degrees of freedom grow with n, not n/m,
///   where phases are not averaged, and this gives too few for totdev, htotdev and Theo1 at large m:
///   intervals err on the safe side.
///
/// Tested against the full form and by Monte Carlo. The published approximations (SP 1065 section 5.4) differ
/// from this by up to 15 % in the ranges where they are given.
///
/// A stride of m/16 costs white noise 0.5 % of the degrees of freedom of the oadev, flicker and random walk
/// nothing measurable; m/8: 1.9 %; m/4: 7.8, 0.3 and 0 %; m: 125, 32 and 4 %. For quantization the full
/// overlap is worth all: its degrees of freedom go as n/stride.
/// @throws std::invalid_argument for a factor that the estimator has no terms for, a stride below 1, or no
/// noise.
[[nodiscard]] double equivalent_dof(const Estimation& estimation, std::span<const noise::Process> mix);

/// E[s] over the variance that the estimator is named for (total: Allan, modified total: modified Allan,
/// Hadamard total: Hadamard, Theo1: Allan at 0.75 m dt); 1 for the others. Divide by it. Exact for totdev to
/// m = 512 and Theo1 to 2048, within 1 % of its distance from 1 above; the others from the quadratic forms,
/// within 0.5 %.
///
/// For long clusters: totdev 1 - a m/n with a = 0, 0.481, 0.750 for white, flicker, random walk, as
/// published; mtotdev 0.995, 0.771, 0.717, 0.679 for quantization to random walk (published, from simulation:
/// 0.94, 0.73, 0.70, 0.69); htotdev 0.995, 0.851, 0.771 for white to random walk, as published; Theo1 of
/// white noise 1.
[[nodiscard]] double expectation_ratio(const Estimation& estimation, std::span<const noise::Process> mix);

/// What is known of one point of a curve.
struct PointStatistics {
  double bias = 1;      ///< expectation_ratio
  double variance = 0;  ///< the curve's divided by it
  double edf = 0;       ///< with gaps in proportion to the terms that are left; oadev exactly (see Mask)
  Interval interval;    ///< of the variance
};

/// Of every point of a curve for a mix of processes, as `calibrate` fits one. NaN where no term counts.
/// @throws std::invalid_argument as above.
[[nodiscard]] std::vector<PointStatistics> statistics(const Curve& curve, std::span<const noise::Process> mix,
                                                      double confidence = 0.95);
/// The same for the noise that was identified at each point. Where it changes along the curve, the bias goes over from
/// one noise's to the other's within two octaves either way (the mean over the points there, weights falling linearly
/// in log tau), so that curves whose bias is divided out do not jump. So do relative variances, 2 over the degrees of
/// freedom; where a share p of the variance may be of Identified::widest the relative variance is at least
/// (1 - p)^2 of the noise's own and p^2 of the widest's.
[[nodiscard]] std::vector<PointStatistics> statistics(const Curve& curve, std::span<const Identified> noises,
                                                      double confidence = 0.95);
/// Noise at each point's averaging time (at n/2 beyond that), as held_noise has it; beyond n/30, where lag-1
/// autocorrelations tell nothing, and for angle noise, from the variance there over that at half the factor, with what
/// is plausible besides in Identified::widest and share. At n/2 anything is.
[[nodiscard]] std::vector<Identified> identify_noise(const Series& record, const Curve& curve);

/// The same from the overlapped Allan curve alone, where the samples are gone (streams): the power law at each octave
/// from the slope over its two neighbours, as the Allan variance goes as tau^-2, -1, 0, 1 for quantization, white,
/// flicker, random walk. Where the next point has fewer than 30 clusters it is that of the point before, unless the
/// ratio of its variance to the one an octave before denies that, and `widest` and `share` are as above.
/// @param curve at ascending factors. @throws std::invalid_argument for another estimator.
[[nodiscard]] std::vector<Identified> identify_noise(const Curve& curve);

/// One point of several curves: segments of a log between power-ups or dropped data, or sensors of one kind.
struct PooledPoint {
  double tau = 0;             ///< [s]
  double variance = 0;        ///< mean of the segments' (bias removed), weighted by their degrees of freedom
  double edf = 0;             ///< sum of theirs
  std::int64_t terms = 0;     ///< sum of theirs
  std::int64_t segments = 0;  ///< that had terms at this tau
  Interval interval;
};

/// A curve and its statistics.
struct Segment {
  const Curve* curve;
  std::span<const PointStatistics> statistics;
};

/// Pools the curves of segments of one estimator and sample interval into one. Segments count as independent:
/// right for white noise and quantization, and where power was cycled; flicker and random walk that run on
/// across a gap correlate neighbours at tau near their length by a few per cent.
///
/// Weights in proportion to the degrees of freedom have the least variance, and degrees of freedom then add.
/// @return ascending in tau; taus that no segment has a term for are left out.
/// @throws std::invalid_argument for curves of different estimators or dt, or statistics of another size.
[[nodiscard]] std::vector<PooledPoint> pool(std::span<const Segment> segments, double confidence = 0.95);

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "confidence.h"

namespace gyrobudget::inline v0::allan {

/// Estimate of a two-sided power spectral density, the convention of the whole project: white noise reads
/// N^2, its root [rad/s/sqrt(Hz) = rad/sqrt(s)] is the angle random walk, and the integral from -fs/2 to fs/2
/// is the variance. Double the density for a one-sided one.
struct Spectrum {
  double dt = 1;                  ///< sample interval [s]
  double bandwidth = 0;           ///< distance beyond which points are as good as independent [Hz]
  std::vector<double> frequency;  ///< [Hz], ascending, above 0
  std::vector<double> density;    ///< two-sided [signal^2/Hz]
  std::vector<double> dof;        ///< equivalent degrees of freedom of each density, about chi-square
  /// Of the expectation of point i, for a spectrum that is smooth over its bandwidth.
  [[nodiscard]] Interval interval(std::size_t i, double confidence = 0.95) const {
    return chi_square_interval(density[i], dof[i], confidence);
  }
};

/// Averaged periodograms of overlapping Hann-windowed segments (P. Welch, IEEE Trans. Audio Electroacoust. 15
/// (1967) 70).
///
/// Each segment loses its mean. Degrees of freedom: with K segments half a segment apart 2 K / (1 + 2 (1 -
/// 1/K) / 36), exact for white noise; half of it at fs/2. Bins 0 and 1 hold the mean and are left out.
/// Bandwidth 1.94 bins (neighbours correlate by 4/9 and 1/36). NaN and infinite samples count as the
/// segment's mean, and the density is raised for them by the part that exists; segments of which less than
/// half exists are left out.
///
/// @param segment length of a segment, rounded down to the next 2^a 3^b 5^c that is a multiple of 4; 0: the
/// length that leaves at least 16 of them, at most 2^16.
/// @throws std::invalid_argument for dt [s] that is not positive and finite, a segment below 8 samples or
/// longer than the record, or a record shorter than 8. Empty where nothing is left.
///
/// Cost: O(n log segment), both cores, 40 bytes per sample of a segment and thread.
[[nodiscard]] Spectrum welch(std::span<const double> rate, double dt, std::int64_t segment = 0);

/// Sine multitaper estimate (K. Riedel, A. Sidorenko, IEEE Trans. Signal Process. 43 (1995) 188): the mean of
/// the periodograms with tapers sqrt(2/(n+1)) sin(pi k j/(n+1)), k = 1 .. K, which are orthogonal and whose
/// bias is the least of all for smooth spectra. Resolution at the lowest frequencies, where Welch has none:
/// points every 1/((n+1) dt), bandwidth K of them, 2 K degrees of freedom but within half the bandwidth of 0
/// and fs/2, where there are K.
///
/// All tapers come from one Fourier transform of 2(n+1) points. The record loses its mean, and samples at its
/// end (under 4 %, of 10^6 under 1 %) so that 2(n+1) = 2^a 3^b 5^c. NaN and infinite samples count as the mean, the
/// density is raised by the part that exists. Leakage falls off as f^-4: random walks read right from four bandwidths
/// on (below, their curvature shows).
///
/// @throws std::invalid_argument for dt that is not positive and finite, fewer than 1 taper or more than n/4,
/// or a record shorter than 8. Empty where nothing exists.
///
/// Cost: O(n log n); about 60 bytes a sample while it runs.
[[nodiscard]] Spectrum multitaper(std::span<const double> rate, double dt, std::int64_t tapers = 8);

/// A spectrum for drawing: means over bins evenly spaced in log f, `per_decade` of them; a bin with one point
/// keeps it. Degrees of freedom are those of as many points as lie a bandwidth apart.
[[nodiscard]] Spectrum log_binned(const Spectrum& fine, int per_decade = 20);

}  // namespace gyrobudget::inline v0::allan

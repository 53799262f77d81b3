// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// A narrow peak that stands out of a record's spectrum: vibration, a fan, mains, a control loop.
struct SpectralLine {
  double frequency_hz = 0;  ///< centroid of the peak; known to about one bin, `resolution_hz`
  double resolution_hz = 0;
  double amplitude = 0;  ///< of the sinusoid A sin(2 pi f t) with this power [signal]; of a wandering line, about
  double ratio = 0;      ///< peak over the local median of the spectrum
};

struct LineOptions {
  double false_alarm = 1e-4;  ///< probability that a record of noise with a smooth spectrum shows any line at all
  std::size_t most = 5;       ///< strongest lines to return
};

/// Lines of a record, strongest first.
///
/// Averaged Hann-windowed periodograms at three segment lengths (a quarter of the record up to 2^17 samples, 1/8 and
/// 1/64 of that; four segments of the longest, 2^18 samples in the shorter ones, spread over the record), for lines
/// that hold their frequency and lines that wander. A bin is a line where it exceeds the level of the spectrum around
/// it (medians of blocks 10 % and at least 60 bins wide) by what chance would exceed with probability
/// false_alarm / (bins tested), from the chi-square law of the average. Bins below 50 cycles a segment are not tested:
/// there the 1/f slope is no flat neighbourhood. Missing samples (NaN) count as the mean.
/// @param rate  at least 1024 samples, else nothing is found; dt > 0 [s].
/// @throws std::invalid_argument for dt that is not above zero.
/// Source: Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70; window's noise bandwidth 1.5 bins.
[[nodiscard]] std::vector<SpectralLine> find_lines(std::span<const double> rate, double dt,
                                                   const LineOptions& options = {});

}  // namespace gyrobudget::inline v0::allan

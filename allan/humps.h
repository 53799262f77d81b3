// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// A broad rise of a record's spectrum: a resonance of a support, sway, a control loop, what a body does that moves.
struct Hump {
  double frequency_hz = 0;         ///< of its top
  double low_hz = 0, high_hz = 0;  ///< where it is half as high, in logarithms
  double ratio = 1;                ///< top over the higher of the lowest levels to its left and its right
  double amplitude = 0;            ///< root of its variance between low_hz and high_hz [signal]
};

/// Humps of a record, highest first.
///
/// Welch's spectrum with segments of at most 8192 samples, 32 of them at least, is put into bands of 1/8 octave with
/// the median of their bins, which lines do not move. A hump is where a band stands above the lowest band to its left
/// and the lowest to its right by a factor of 1.5 and by six standard deviations of such a band, and where it is wider
/// than a fifth of its frequency: what is narrower is a line (lines.h). A spectrum that falls all the way, as noise's
/// does, has none, behind a low pass or not: of 600 records of white noise, flicker and walk (32768 samples) none had
/// (tests).
/// @param rate  at least 8192 samples, else nothing is found; NaN counts as the mean
/// @param dt    sample interval [s]
/// @throws std::invalid_argument for dt that is not above zero and finite.
[[nodiscard]] std::vector<Hump> find_humps(std::span<const double> rate, double dt);

}  // namespace gyrobudget::inline v0::allan

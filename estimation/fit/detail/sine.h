// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "likelihood.h"
#include "transformed.h"

namespace gyrobudget::inline v0::fit {

/// A line A cos(w j) + B sin(w j) of a record, j its samples.
struct Sine {
  double w = 0;                       ///< radians a sample
  std::array<double, 2> parts{0, 0};  ///< of cos and sin
  double deviation = 0;               ///< of the amplitude
  double test = 0;                    ///< drop of -2 ln L
  [[nodiscard]] double amplitude() const { return std::hypot(parts[0], parts[1]); }
};

/// The line that explains most of the coefficients c over the spectrum and the ramp of a fit: near its highest peak
/// from 8 cycles in the record on (within 4 cycles in the record of `near_w`, where that is given), or at the frequency
/// asked for. No line (all zero) where the band is shorter.
[[nodiscard]] Sine find_sine(const SineLikelihood&, const SineLikelihood::Point&, std::span<const double> c,
                             std::optional<double> asked_w, std::optional<double> near_w = {});

/// The record less the line; in stretches other than the longest less what they have at its frequency.
[[nodiscard]] Transformed without_sine(const Transformed&, const Sine&);

}  // namespace gyrobudget::inline v0::fit

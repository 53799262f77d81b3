// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>

namespace gyrobudget::inline v0::fit {

/// Missing samples of a stretch as the others say they could have been: a draw from what the stretch's own spectrum
/// says of them, given the rest. Spectrum and power of the whole are then those of a complete record, where a smooth
/// bridge would take power off the high frequencies. White noise is then estimated with a variance of 1/(1 - f)^2 of
/// the complete record's, f being the share that is missing: 1/(1 - f) for what is lost, the rest for the draw.
///
/// By turns the smoothed spectrum of the sine coefficients (dst.h), in bands of 32 coefficients or 10 %, and the draw:
/// a record z with that spectrum, and the conditional mean of what the existing samples have beyond z (Matheron),
/// found with the spectrum's inverse over 256 samples either way, about the mean over 1024. What one turn leaves of an
/// error is the share f of it, so two to eight are made. No model of the noise is used, so that all models may be
/// weighed on what comes out. The same numbers always: the draws are keyed by `stream`.
/// @param rate     a length of noise::fft_length_within; what is missing may hold anything
/// @param missing  indices, ascending; neither all samples nor none
void fill_gaps(std::span<double> rate, std::span<const std::int64_t> missing, std::uint64_t stream);

/// Part of the information on white noise that a stretch with a share f of samples filled in has: (1 - f)^2.
[[nodiscard]] double information_left(double missing_share);

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::noise {

/// The smallest 2^a 3^b 5^c that is >= n; the only lengths for which the FFT is fast.
[[nodiscard]] std::int64_t fft_length(std::int64_t n);
/// In-place complex FFT (forward, no scaling).
void fft(std::vector<std::complex<double>>& data);

}  // namespace gyrobudget::inline v0::noise

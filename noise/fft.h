// SPDX-License-Identifier: MIT
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::noise {

// Discrete Fourier transforms X_k = sum_j x_j exp(-2 pi i j k / n) in double (Eigen's), relative error in the
// rms sense a few 1e-16 log2(n). Time is O(n log n) for lengths that fft_length gives and up to O(n^2) for
// others. Safe to call from many threads. All throw std::invalid_argument for more than 2^31 - 1 points.

/// The smallest 2^a 3^b 5^c that is >= n; the only lengths for which the FFT is fast.
/// @throws std::invalid_argument for n < 1 or n > 2^60.
[[nodiscard]] std::int64_t fft_length(std::int64_t n);
/// The longest length 2^a 3^b 5^c <= n with a >= 2, as real_spectrum takes; 0 for n < 4. Trimming a record to it loses
/// below 6 % from 64 samples on, below 2 % from 10^5 on.
[[nodiscard]] std::int64_t fft_length_within(std::int64_t n);

/// In-place complex transform (forward, no scaling).
void fft(std::vector<std::complex<double>>& data);

/// Bins 0 to n/2 of the transform of a real signal of n points, n a multiple of 4; the others are their
/// conjugates.
[[nodiscard]] std::vector<std::complex<double>> real_spectrum(std::span<const double> signal);

/// sum_k X_k exp(2 pi i j k / n) for j = 0 ... n-1 with X_{n-k} = conj(X_k): the inverse of real_spectrum but
/// for a factor of n. The spectrum holds n/2 + 1 bins, n a multiple of 4, of which the first and last count
/// as real.
[[nodiscard]] std::vector<double> real_signal(std::span<const std::complex<double>> spectrum);

}  // namespace gyrobudget::inline v0::noise

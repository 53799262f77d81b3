// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace gyrobudget::inline v0::noise {

/// The noise terms of IEEE Std 952, by the letters that options and files use.
enum class Term : char {
  quantization = 'Q',
  white = 'N',  ///< angle random walk
  flicker = 'B',  ///< bias instability
  rate_random_walk = 'K',
  rate_ramp = 'R',
  gauss_markov = 'G',
  sinusoid = 'S',
};

// Each process as a value. Units are those of the sensor's signal; for a gyro rad and s. All spectral densities are
// two-sided (IEEE Std 952).
struct Quantization { double q = 0; };       ///< Q [rad], angle noise of std Q per sample: least significant bit / sqrt(12)
struct White { double n = 0; };              ///< N [rad/sqrt(s)], S(f) = N^2
struct Flicker { double b = 0; };            ///< B [rad/s], S(f) = B^2/(2 pi f)
struct RateRandomWalk { double k = 0; };     ///< K [rad/s/sqrt(s)], S(f) = K^2/(2 pi f)^2
struct RateRamp { double r = 0; };           ///< R [rad/s^2], y = R t
struct GaussMarkov { double sigma = 0; double correlation_time = 1; };  ///< std [rad/s], time constant [s]
struct Sinusoid { double amplitude = 0; double frequency = 1; double phase = 0; };  ///< A sin(2 pi f0 t + phase)

using Process = std::variant<Quantization, White, Flicker, RateRandomWalk, RateRamp, GaussMarkov, Sinusoid>;

[[nodiscard]] Term term(const Process&);
/// The coefficient that scales the process (Q, N, B, K, R, sigma or A); the Allan variance goes with its square.
[[nodiscard]] double coefficient(const Process&);
/// The same process with another coefficient.
[[nodiscard]] Process with_coefficient(Process, double);
/// The process of a term with unit coefficient (Gauss-Markov: correlation time 1 s; sinusoid: 1 Hz).
[[nodiscard]] Process unit_process(Term);

/// Two-sided power spectral density of the sampled process at frequency f in (0, 1/(2 dt)].
[[nodiscard]] double psd(const Process&, double frequency_hz, double dt);

/// Exact Allan variance of the sampled process at averaging factor m >= 1 (theory: discrete forms, not asymptotes).
[[nodiscard]] double allan_variance(const Process&, std::int64_t m, double dt);
[[nodiscard]] double allan_variance(std::span<const Process>, std::int64_t m, double dt);

/// D(h) = E[(y_{k+h} - y_k)^2] of the rate at lag h >= 0 samples.
[[nodiscard]] double structure_function(const Process&, std::int64_t lag, double dt);

/// Generalised covariance R(h) of the phase (angle) at real lag h samples, defined up to an even quadratic: every
/// combination of phases whose weights annihilate second-order polynomials has covariance sum c_i c_j R(t_i - t_j).
/// Units rad^2. Zero for RateRamp, which is a mean and not a covariance.
[[nodiscard]] double phase_covariance(const Process&, double lag, double dt);

}  // namespace gyrobudget::inline v0::noise

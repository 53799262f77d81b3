// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <variant>

#include "front_end.h"

namespace gyrobudget::inline v0::noise {

/// The noise terms of IEEE Std 952, by the letters that options and files use.
enum class Term : char {
  quantization = 'Q',
  white = 'N',    ///< angle random walk
  flicker = 'B',  ///< bias instability
  rate_random_walk = 'K',
  rate_ramp = 'R',
  gauss_markov = 'G',
  sinusoid = 'S',
};

// Each process as a value. Units are those of the sensor's signal; for a gyro rad and s. The spectral
// densities beside them are the continuous-time ones of IEEE Std 952, two-sided: they define the
// coefficients.

/// Q [rad]: every angle reading carries an independent Gaussian error of standard deviation Q (a least
/// significant bit divided by sqrt(12)), the rate is their difference over dt. S(f) = (2 pi f)^2 Q^2 dt.
struct Quantization {
  double q = 0;
};
/// N [rad/sqrt(s)], angle random walk. S(f) = N^2.
struct White {
  double n = 0;
};
/// White noise behind a sensor's low pass: N^2 is the density at frequencies that pass. S(f) = N^2 |H(f)|^2.
struct FilteredWhite {
  double n = 0;
  FrontEnd front_end;
};
/// B [rad/s], bias instability. S(f) = B^2 / (2 pi f). The flat of the Allan deviation is sqrt(2 ln2 / pi) B
/// = 0.664 B.
struct Flicker {
  double b = 0;
};
/// K [rad/s/sqrt(s)], rate random walk. S(f) = K^2 / (2 pi f)^2.
struct RateRandomWalk {
  double k = 0;
};
/// R [rad/s^2], y = R t: a trend, not a random process.
struct RateRamp {
  double r = 0;
};
/// Stationary first-order Gauss-Markov process: standard deviation [rad/s], correlation time Tc > 0 [s].
/// S(f) = 2 sigma^2 Tc / (1 + (2 pi f Tc)^2).
struct GaussMarkov {
  double sigma = 0;
  double correlation_time = 1;
};
/// A sin(2 pi f0 t + phase): A [rad/s], f0 [Hz], phase [rad].
struct Sinusoid {
  double amplitude = 0;
  double frequency = 1;
  double phase = 0;
};

using Process =
    std::variant<Quantization, White, Flicker, RateRandomWalk, RateRamp, GaussMarkov, Sinusoid, FilteredWhite>;

[[nodiscard]] Term term(const Process& process);  ///< of filtered white noise N
/// The coefficient that scales the process (Q, N, B, K, R, sigma or A); all second moments go with its
/// square.
[[nodiscard]] double coefficient(const Process& process);
/// The same process with another coefficient.
[[nodiscard]] Process with_coefficient(Process process, double value);
/// The process of a term with unit coefficient (Gauss-Markov: correlation time 1 s; sinusoid: 1 Hz).
/// @throws std::invalid_argument for a value that is no Term.
[[nodiscard]] Process unit_process(Term wanted);

// Second moments of a process *as it is sampled every dt* [s], which is what the generators make and a record
// holds:
//
//   term  samples y_k (u, w: independent standard normal)   S(f) sampled, s = sin(pi f dt)
//   Q     Q (u_k - u_{k-1}) / dt                            4 Q^2 s^2 / dt
//   N     N u_k / sqrt(dt)                                  N^2, filtered N^2 |H(f)|^2 (front_end.h)
//   B     (1 - z^-1)^(-1/2) B w_k  (Kasdin 1995)            B^2 dt / (2 s)
//   K     y_{k-1} + K sqrt(dt) u_k                          K^2 dt^2 / (4 s^2)
//   R     R k dt                                            0
//   G     phi y_{k-1} + sigma sqrt(1 - phi^2) u_k           sigma^2 (1 - phi^2) dt / ((1 - phi)^2 + 4 phi s^2)
//         with phi = exp(-dt/Tc)
//   S     A sin(2 pi f0 k dt + phase)                       line of power A^2/4 at +-f0
//
// They go to the IEEE densities as f dt -> 0. The differences at small averaging factors m: B reads +44 % in
// variance at m = 1, +1 % at m = 10; K +50 % at m = 1, +0.5 % at m = 10.
//
// Accuracy: relative error below 1e-14 for m and lags up to 1e9, the sinusoid's but for the rounding of f0 dt.
// Coefficients whose square leaves the range of double give 0 or infinity. All throw std::invalid_argument for
// dt or a correlation time that is not positive and finite, for m < 1, a lag < 0 (not finite, of the phase
// covariance) and a frequency outside (0, 1/(2 dt)].

/// Two-sided power spectral density [signal^2/Hz] at a frequency in (0, 1/(2 dt)]. RateRamp: 0, a trend has
/// no density. Sinusoid: 0, and infinity at exactly f0 or its alias.
[[nodiscard]] double psd(const Process& process, double frequency_hz, double dt);

/// Exact Allan variance [signal^2] at averaging factor m >= 1: the discrete forms, not the asymptotes. With
/// h_n = 1 + 1/3 + ... + 1/(2n-1) flicker is B^2/(4 pi m^2) [(16 m^2 - 1) h_2m - 4 (4 m^2 - 1) h_m].
/// RateRamp and Sinusoid, which are means, give the expectation of the estimator over a long record.
[[nodiscard]] double allan_variance(const Process& process, std::int64_t m, double dt);
/// Of the sum of independent processes.
[[nodiscard]] double allan_variance(std::span<const Process> processes, std::int64_t m, double dt);

/// D(h) = E[(y_{k+h} - y_k)^2] of the rate [signal^2] at lag h >= 0 samples; flicker (4 B^2 / pi) h_h.
/// RateRamp is (R h dt)^2; Sinusoid is averaged over its phase.
[[nodiscard]] double structure_function(const Process& process, std::int64_t lag, double dt);

/// Generalised covariance R(h) of the phase (angle) x_k = dt (y_1 + ... + y_k) at real lag h samples, an even
/// function, defined up to an even quadratic: a combination of phases whose weights c annihilate polynomials
/// of second order in time has covariance sum_ij c_i c_j R(t_i - t_j). Units rad^2. With dt = 1:
///
///   Q  Q^2 where |h| < 1/2, else 0
///   N  -N^2 |h| / 2, filtered N^2 (memory(|h|) - |h| / 2)
///   B  B^2/(4 pi) (4 h^2 - 1) h_|h|,  h_n = (psi(n + 1/2) - psi(1/2)) / 2
///   K  K^2 (|h|^3 - |h|) / 12
///   R  0: a trend is a mean, not a covariance
///   G  half the variance of x_h - x_0, negated
///   S  -A^2/4 (sin(pi f0 h) / sin(pi f0))^2, phase uniformly random
///
/// At whole lags this is the sampled process exactly; between them it is the smooth continuation that
/// quadrature over lags needs. Quantization has no such continuation: ask for it at whole lags only.
[[nodiscard]] double phase_covariance(const Process& process, double lag, double dt);

}  // namespace gyrobudget::inline v0::noise

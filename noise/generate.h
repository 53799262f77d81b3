// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "filter.h"
#include "normal.h"
#include "process.h"

namespace gyrobudget::inline v0::noise {

// Samples of sums of processes, as process.h defines them sampled. Epoch: flicker and rate random walk are
// zero at sample 0 and run on from there; ramp and sinusoid count time from sample 0; Gauss-Markov starts in
// its stationary state.
//
// Every process draws from a stream of its own, key.stream | term letter << 48 | occurrence << 56, the
// occurrence being how many of its term stand before it. So the record of a sum is the sum of the records (to
// rounding), and adding or removing a process leaves the numbers of the others alone. Both generators give
// the same bytes for everything but flicker. Bytes depend on the machine only through the last digit of the
// library's exp, sin and cos, which set the Gauss-Markov step, the sinusoid and flicker's transform; white,
// quantization, random walk and ramp do not depend on it.
//
// All throw std::invalid_argument for a sample interval or correlation time that is not positive and finite,
// a coefficient that is not finite, a stream of 2^48 or more, and more than 256 processes of one term.

/// Makes whole records, exact in distribution, each from its own key. What depends on length only (the
/// spectrum of flicker's increments) is worked out once; calls are const and safe from many threads, with the
/// same bytes.
///
/// Flicker: its increments are stationary with autocovariance (4 B^2/pi)/(1 - 4 h^2). The terms with h != 0 are
/// negative and sum to less than the one with h = 0, so a circulant matrix of them has positive eigenvalues at
/// any length, and a Fourier transform of twice the record makes the increments exactly (Davies & Harte 1987,
/// Wood & Chan 1994). Time O(n log n), memory about 11 numbers a sample while a call runs, 1 between calls.
class RecordGenerator {
 public:
  /// Records of `samples` rates, dt [s] apart.
  /// @throws std::invalid_argument also for samples < 1, or above 5e8 where there is flicker.
  RecordGenerator(std::span<const Process> processes, std::int64_t samples, double dt);
  ~RecordGenerator();
  RecordGenerator(RecordGenerator&&) noexcept;
  RecordGenerator& operator=(RecordGenerator&&) noexcept;

  [[nodiscard]] std::vector<double> operator()(StreamKey key) const;

 private:
  struct Plan;
  std::unique_ptr<const Plan> plan_;
};

/// One whole record of the sum of `processes`, every dt [s], exact in distribution.
[[nodiscard]] std::vector<double> generate_record(std::span<const Process> processes, std::int64_t samples, double dt,
                                                  StreamKey key);

/// Flicker as a sum of Gauss-Markov processes and one rate random walk, for clusters from dt to longest_tau [s].
///
/// Flicker's structure function is a mixture of exponentials: with a = dt/Tc,
///     D(h) = (2 B^2/pi) int_0^inf (1 - e^(-a h)) (a/2)/sinh(a/2) dln(a),
/// and a Gauss-Markov process has D(h) = 2 sigma^2 (1 - e^(-a h)). The trapezoidal rule in ln(a) with ratio
/// r = 10^(1/poles_per_decade) gives sigma_i^2 = (B^2/pi) ln(r) (a_i/2)/sinh(a_i/2) at a_i = 2 r^i. Poles
/// slower than 30 longest_tau act together as a rate random walk, the last of the result. Largest relative
/// error of the Allan deviation over tau = dt ... longest_tau, wherever longest_tau falls:
///
///     poles per decade   0.5    1     1.5     2        3 to 10
///     error              32 %   4 %   0.65 %  0.016 %  0.008 %
///
/// @throws std::invalid_argument unless dt <= longest_tau <= 1e15 dt and 0.5 <= poles_per_decade <= 10.
[[nodiscard]] std::vector<Process> flicker_approximation(const Flicker& flicker, double dt, double longest_tau,
                                                         double poles_per_decade);

/// Endless record in constant memory; all exact in distribution but flicker, which is flicker_approximation
/// less its value at sample 0. noise_benchmark has the table of its error against its run time.
/// @throws std::invalid_argument also what flicker_approximation refuses, where there is flicker.
class Generator {
 public:
  struct Options {
    StreamKey key = {};
    double longest_tau = 1e5;     ///< [s] end of the band of the 1/f approximation
    double poles_per_decade = 2;  ///< see flicker_approximation
  };
  /// Rates every dt [s].
  Generator(std::span<const Process> processes, double dt, const Options& options);
  /// Filtered noise besides, at rest before sample 0, each from a stream of letter F. More than 128 taps run by
  /// Fourier transforms of blocks: 50 ns a sample at 1000 taps, 100 ns at 1e5.
  /// @throws std::invalid_argument also what psd refuses of a filter.
  Generator(std::span<const Process> processes, std::span<const FilteredNoise> filters, double dt,
            const Options& options);
  ~Generator();
  Generator(Generator&&) noexcept;
  Generator& operator=(Generator&&) noexcept;

  /// The next out.size() samples; the bytes do not depend on how the record is cut into calls.
  void next(std::span<double> out);
  /// Leaves out `samples` samples: what follows is what would have followed them. White noise, quantization,
  /// ramp and sinusoid jump; the others take the time to run there, all in constant memory.
  void skip(std::uint64_t samples);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gyrobudget::inline v0::noise

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/normal.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::noise {

/// A whole record of the sum of `processes`, exact in distribution (flicker through circulant embedding of its
/// stationary increments, O(n log n)).
[[nodiscard]] std::vector<double> generate_record(std::span<const Process> processes, std::int64_t samples, double dt,
                                                  StreamKey key);

/// Endless record in constant memory; flicker is a sum of Gauss-Markov processes with a stated bound.
class Generator {
 public:
  struct Options {
    StreamKey key;
    double longest_tau = 1e5;   ///< [s] band of the 1/f approximation
    double poles_per_decade = 2;
  };
  Generator(std::span<const Process> processes, double dt, const Options&);
  ~Generator();
  Generator(Generator&&) noexcept;
  Generator& operator=(Generator&&) noexcept;
  /// The next out.size() samples; the bytes do not depend on how the record is cut into calls.
  void next(std::span<double> out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gyrobudget::inline v0::noise

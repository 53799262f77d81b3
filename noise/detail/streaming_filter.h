// SPDX-License-Identifier: MIT
#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::noise::detail {

/// A rational filter that runs on block after block of its own size, at rest before the first. Both ways of
/// running it are the same filter to rounding.
class StreamingFilter {
 public:
  virtual ~StreamingFilter() = default;
  [[nodiscard]] virtual std::size_t block_size() const = 0;
  /// The next block_size() samples, in place.
  virtual void run(std::span<double> block) = 0;
};

/// Time O(taps) a sample.
[[nodiscard]] std::unique_ptr<StreamingFilter> make_direct_filter(std::span<const double> numerator,
                                                                  std::span<const double> denominator);
/// Time O(log(block) + taps / block) a sample, by Fourier transforms of blocks.
[[nodiscard]] std::unique_ptr<StreamingFilter> make_block_filter(std::span<const double> numerator,
                                                                 std::span<const double> denominator);
/// The faster of the two for this number of taps.
[[nodiscard]] std::unique_ptr<StreamingFilter> make_filter(std::span<const double> numerator,
                                                           std::span<const double> denominator);

}  // namespace gyrobudget::inline v0::noise::detail

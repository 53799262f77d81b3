// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/detail/phase.h"

#include <cstdint>
#include <span>
#include <vector>

#include "deviation.h"

namespace gyrobudget::inline v0::allan {

struct StreamingOptions {
  /// Terms of factor m begin every max(1, m / overlap) samples; a power of two. 16 costs white noise 0.5 % of
  /// the degrees of freedom, 32 0.1 %; flicker and random walk nothing (see statistics.h).
  std::int64_t overlap = 16;
  double minimum_fill = kMinimumFill;  ///< of a cluster, in (0, 1]
  /// Place in the log of the first sample pushed. Terms begin at whole multiples of their stride in the log,
  /// so that parts of a log that are taken in apart can be joined.
  std::int64_t first_sample = 0;
};

/// Share of the degrees of freedom of white noise that terms at every m/r samples cost, for r = overlap, m >> r and
/// n >> m. Terms d m apart correlate by 1 - 3d/2 up to d = 1 and (d - 2)/2 up to 2; the sum of squares over d = k/r
/// exceeds their integral 2/3 by 5/(6 r^2), so that the loss is 1.25 / (r^2 + 1.25).
[[nodiscard]] double white_noise_loss(std::int64_t overlap);

/// Overlapped Allan variance at m = 1, 2, 4, ... of a stream of rates without end, in memory that grows with
/// the logarithm of its length: about 2 KB per octave, 60 KB for 10^9 samples.
///
/// Samples are summed into blocks of 2^r, each of two of the row before, as means are in the recursion of
/// FAVAR (Maddipatla et al. 2021); a term is the difference of two neighbouring clusters of `overlap` blocks.
/// No sum is longer than a cluster, so neither a large mean nor 10^12 samples cost digits. NaN and infinite
/// samples are missing: blocks count what exists, and a cluster counts where the minimum fill does, as in
/// overlapped_variance.
///
/// With a stride of 1 (m <= overlap) the terms are exactly those of overlapped_variance; above, every
/// m/overlap-th of them. Error 1e-12 of the variance. The same bytes however the samples are cut into pushes.
/// One thread; about 6 ns a sample (join parts for more threads).
///
///     StreamingDeviation stream(0.01);
///     while (read(samples)) stream.push(samples);
///     const Curve curve = stream.curve();  // at any time; statistics(curve, mix) has its degrees of freedom
class StreamingDeviation {
 public:
  /// @throws std::invalid_argument for dt [s] that is not positive and finite, an overlap that is no power of
  /// two from 1 to 4096, a minimum fill outside (0, 1], or a negative first sample.
  explicit StreamingDeviation(double dt, const StreamingOptions& options = {});

  /// Takes in the next samples.
  void push(std::span<const double> rate);

  /// Joins what was taken in of the part of the log that follows this one, as if all had been pushed here:
  /// the terms are the same, their sum differs by its rounding.
  /// @throws std::invalid_argument where `following` does not begin at this one's end, or has another dt, overlap
  /// or fill.
  void append(const StreamingDeviation& following);

  /// Number of samples so far, missing ones included.
  [[nodiscard]] std::int64_t samples() const { return samples_; }

  /// What is known so far: all octaves that have a term, with their strides. The curve has no mask;
  /// statistics() then reckons degrees of freedom with gaps in proportion to the terms that are left.
  [[nodiscard]] Curve curve() const;

 private:
  /// Sum of the samples of a block that exist, less offset_ each, and how many they are.
  struct Block {
    double sum = 0;
    std::int64_t count = 0;
    friend Block operator+(const Block& a, const Block& b) { return {a.sum + b.sum, a.count + b.count}; }
  };
  struct Accumulator {
    detail::CompensatedSum squares;
    std::int64_t terms = 0;
  };
  /// The blocks of one length. Its ends are kept: as many as a term may need from beyond a join.
  struct Row {
    std::int64_t next = 0;   ///< place of the next block, in blocks
    std::int64_t total = 0;  ///< blocks so far
    std::vector<Block> head, tail;
  };

  class PrefixSums;

  void process(std::span<const double> rate);
  void flush();
  void extend(std::size_t index, const std::vector<Block>& blocks);
  void add_terms(std::size_t row, std::span<const Block> blocks, std::size_t reach, std::size_t end);
  [[nodiscard]] Row& row_at(std::size_t index);
  [[nodiscard]] std::size_t ends_kept() const { return static_cast<std::size_t>(2 * options_.overlap - 1); }

  double dt_;
  StreamingOptions options_;
  std::int64_t samples_ = 0, existing_ = 0;
  bool has_offset_ = false;
  double offset_ = 0;  ///< near the samples: what is left of them is summed
  detail::CompensatedSum sum_;
  std::vector<double> buffer_;  ///< samples that do not fill a tile yet
  std::vector<Row> rows_;       ///< blocks of 1, 2, 4, ... samples
  std::vector<Accumulator> octaves_;
};

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "streaming.h"

#include "gyrobudget/allan/detail/second_difference.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kTile = 4096;

std::size_t log2_of(std::int64_t power) {
  return static_cast<std::size_t>(std::bit_width(static_cast<std::uint64_t>(power)) - 1);
}

void check(double dt, const StreamingOptions& options) {
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("sample interval dt is {}; it must be positive and finite (s)", dt));
  constexpr std::int64_t kMostOverlap = 4096;
  if (options.overlap < 1 || options.overlap > kMostOverlap ||
      !std::has_single_bit(static_cast<std::uint64_t>(options.overlap))) {
    throw std::invalid_argument(
        fmt::format("overlap is {}; it must be a power of two from 1 to {}", options.overlap, kMostOverlap));
  }
  if (!(options.minimum_fill > 0 && options.minimum_fill <= 1)) {
    throw std::invalid_argument(
        fmt::format("minimum fill of a cluster is {}; it must be in (0, 1]", options.minimum_fill));
  }
  if (options.first_sample < 0)
    throw std::invalid_argument(fmt::format("first sample is {}; it must be 0 or more", options.first_sample));
}

template <typename T>
std::vector<T> joined(std::vector<T> sequence, const std::vector<T>& more) {
  sequence.insert(sequence.end(), more.begin(), more.end());
  return sequence;
}
/// At most so many of the first or last of two sequences in a row.
template <typename T>
std::vector<T> first_of(const std::vector<T>& sequence, const std::vector<T>& more, std::size_t most) {
  std::vector<T> all = joined(sequence, more);
  if (all.size() > most) all.erase(all.begin() + static_cast<std::ptrdiff_t>(most), all.end());
  return all;
}
template <typename T>
std::vector<T> last_of(const std::vector<T>& sequence, const std::vector<T>& more, std::size_t most) {
  std::vector<T> all = joined(sequence, more);
  if (all.size() > most) all.erase(all.begin(), all.end() - static_cast<std::ptrdiff_t>(most));
  return all;
}

}  // namespace

/// Prefix sums of a few thousand blocks, so that a term of clusters of any number of them takes a few
/// additions.
class StreamingDeviation::PrefixSums {
 public:
  PrefixSums(std::span<const Block> blocks, std::int64_t block_length)
      : block_length_(block_length), x_(blocks.size() + 1) {
    const bool complete =
        std::all_of(blocks.begin(), blocks.end(), [&](const Block& block) { return block.count == block_length; });
    const double level = complete && !blocks.empty() ? blocks.front().sum : 0;  // near the others where they drift
    for (std::size_t i = 0; i < blocks.size(); ++i) x_[i + 1] = x_[i] + (blocks[i].sum - level);
    if (complete) return;
    counts_.resize(x_.size());
    for (std::size_t i = 0; i < blocks.size(); ++i) counts_[i + 1] = counts_[i] + blocks[i].count;
  }

  /// Terms that begin at blocks first .. end-1.
  void add_terms(Accumulator& sum, std::size_t first, std::size_t end, std::size_t cluster, double minimum_fill) const {
    const double m = static_cast<double>(cluster) * static_cast<double>(block_length_);
    if (counts_.empty()) {
      const auto terms = static_cast<std::int64_t>(end - first), c = static_cast<std::int64_t>(cluster);
      sum.squares.add(detail::second_difference().complete(x_.data() + first, terms, c) / (m * m));
      sum.terms += terms;
      return;
    }
    constexpr double kRounding = 1e-9;  // of the product: 95 % of 20 is 19
    const auto least = std::max<std::int64_t>(1, std::llround(std::ceil(minimum_fill * m - kRounding)));
    double squares = 0;
    for (std::size_t a = first, b = a + cluster, c = b + cluster; a < end; ++a, ++b, ++c) {
      const std::int64_t one = counts_[b] - counts_[a], two = counts_[c] - counts_[b];
      if (std::min(one, two) < least) continue;
      const double d = (x_[c] - x_[b]) / static_cast<double>(two) - (x_[b] - x_[a]) / static_cast<double>(one);
      squares += d * d;
      ++sum.terms;
    }
    sum.squares.add(squares);
  }

 private:
  std::int64_t block_length_;
  std::vector<double> x_;
  std::vector<std::int64_t> counts_;  ///< empty where nothing is missing
};

double white_noise_loss(std::int64_t overlap) {
  constexpr double kAdjacent = 1.25;
  return kAdjacent / (static_cast<double>(overlap * overlap) + kAdjacent);
}

StreamingDeviation::StreamingDeviation(double dt, const StreamingOptions& options) : dt_(dt), options_(options) {
  check(dt, options);
  buffer_.reserve(kTile);
}

void StreamingDeviation::push(std::span<const double> rate) {
  samples_ += static_cast<std::int64_t>(rate.size());
  while (!rate.empty()) {
    if (buffer_.empty() && rate.size() >= kTile) {
      process(rate.first(kTile));
      rate = rate.subspan(kTile);
      continue;
    }
    const auto part = rate.first(std::min(rate.size(), kTile - buffer_.size()));
    buffer_.insert(buffer_.end(), part.begin(), part.end());
    rate = rate.subspan(part.size());
    if (buffer_.size() == kTile) flush();
  }
}

void StreamingDeviation::flush() {
  process(buffer_);
  buffer_.clear();
}

void StreamingDeviation::process(std::span<const double> rate) {
  if (rate.empty()) return;
  if (!has_offset_) {
    const auto first = std::find_if(rate.begin(), rate.end(), [](double y) { return std::isfinite(y); });
    if (first != rate.end()) has_offset_ = true, offset_ = *first;
  }
  std::vector<Block> blocks(rate.size());
  double sum = 0;
  for (std::size_t k = 0; k < rate.size(); ++k) {
    const double left = rate[k] - offset_;
    if (left - left == 0) blocks[k] = {left, 1}, sum += left, ++existing_;
  }
  sum_.add(sum);
  extend(0, blocks);
}

StreamingDeviation::Row& StreamingDeviation::row_at(std::size_t index) {
  if (index == rows_.size()) {
    const std::int64_t length = std::int64_t{1} << index;
    rows_.push_back({(options_.first_sample + length - 1) / length, 0, {}, {}});
  }
  return rows_[index];
}

/// New blocks of a row: their terms, the ends kept, and the blocks of twice their length that they complete.
void StreamingDeviation::extend(std::size_t index, const std::vector<Block>& blocks) {
  if (blocks.empty()) return;
  Row& row = row_at(index);
  std::vector<Block> all(row.tail);
  const std::size_t before = all.size(), kept = ends_kept();
  all.insert(all.end(), blocks.begin(), blocks.end());
  add_terms(index, all, before, all.size());

  // Blocks at even places are first halves. One that still waits for its second half is the last of the tail.
  std::size_t first_half = before;
  if (row.next % 2 != 0) first_half = row.total > 0 ? before - 1 : before + 1;
  std::vector<Block> doubled;
  doubled.reserve(blocks.size() / 2 + 1);
  for (std::size_t i = first_half; i + 1 < all.size(); i += 2) doubled.push_back(all[i] + all[i + 1]);

  if (row.head.size() < kept) row.head = first_of(row.head, blocks, kept);
  row.tail.assign(all.end() - static_cast<std::ptrdiff_t>(std::min(kept, all.size())), all.end());
  row.next += static_cast<std::int64_t>(blocks.size());
  row.total += static_cast<std::int64_t>(blocks.size());
  extend(index + 1, doubled);
}

/// Terms that need a block at or behind `reach` and begin before `end`.
void StreamingDeviation::add_terms(std::size_t row, std::span<const Block> blocks, std::size_t reach, std::size_t end) {
  const PrefixSums sums(blocks, std::int64_t{1} << row);
  // Single samples serve the factors 1 to overlap, each other row one factor.
  const std::size_t last = log2_of(options_.overlap);
  octaves_.resize(std::max(octaves_.size(), last + row + 1));
  for (std::size_t octave = row == 0 ? 0 : last + row; octave <= last + row; ++octave) {
    const std::size_t cluster = std::size_t{1} << std::min(octave, last);  // in blocks
    const std::size_t first = reach < 2 * cluster ? 0 : reach - 2 * cluster + 1;
    const std::size_t behind = std::min(end, blocks.size() < 2 * cluster ? 0 : blocks.size() - 2 * cluster + 1);
    if (first < behind) sums.add_terms(octaves_[octave], first, behind, cluster, options_.minimum_fill);
  }
}

void StreamingDeviation::append(const StreamingDeviation& following) {
  const auto& theirs = following.options_;
  if (following.dt_ != dt_ || theirs.overlap != options_.overlap || theirs.minimum_fill != options_.minimum_fill)
    throw std::invalid_argument("streams to join have different sample intervals, overlaps or minimum fills");
  if (theirs.first_sample != options_.first_sample + samples_) {
    throw std::invalid_argument(fmt::format("the stream to join begins at sample {} of the log; this one ends at {}",
                                            theirs.first_sample, options_.first_sample + samples_));
  }
  StreamingDeviation next = following;
  next.flush();
  flush();
  if (!has_offset_) has_offset_ = next.has_offset_, offset_ = next.offset_;
  const double shift = next.offset_ - offset_;
  const auto shifted = [shift](std::vector<Block> blocks) {
    for (Block& block : blocks) block.sum += shift * static_cast<double>(block.count);
    return blocks;
  };

  const std::size_t kept = ends_kept();
  std::vector<Block> joint;  // the block of the row at hand that the end of one and the beginning of the other make
  for (std::size_t index = 0; index < std::max(rows_.size(), next.rows_.size()) || !joint.empty(); ++index) {
    Row& row = row_at(index);
    const Row other = index < next.rows_.size() ? next.rows_[index] : Row{};
    const std::vector<Block> head = shifted(other.head), tail = shifted(other.tail);
    const std::size_t ours = row.tail.size();
    const std::vector<Block> seam = joined(joined(row.tail, joint), head);
    const std::size_t end = ours + joint.size();  // where theirs begin
    add_terms(index, seam, ours, end);            // terms in one part only were counted there

    // The pair across the seam, or with the block on it.
    std::vector<Block> doubled;
    for (std::size_t i = ours > 0 ? ours - 1 : 0; i < end && i + 1 < seam.size(); ++i) {
      const bool first_half = (row.next + static_cast<std::int64_t>(i) - static_cast<std::int64_t>(ours)) % 2 == 0;
      if (first_half) doubled.push_back(seam[i] + seam[i + 1]);
    }

    if (row.head.size() < kept) row.head = first_of(joined(row.head, joint), head, kept);
    row.tail = last_of(joined(row.tail, joint), tail, kept);
    row.total += static_cast<std::int64_t>(joint.size()) + other.total;
    row.next += static_cast<std::int64_t>(joint.size()) + other.total;
    joint = doubled;
  }
  for (std::size_t octave = 0; octave < next.octaves_.size(); ++octave) {
    if (octave >= octaves_.size()) octaves_.resize(octave + 1);
    octaves_[octave].squares.add(next.octaves_[octave].squares);
    octaves_[octave].terms += next.octaves_[octave].terms;
  }
  samples_ += next.samples_;
  existing_ += next.existing_;
  sum_.add(next.sum_);
  sum_.add(shift * static_cast<double>(next.existing_));
}

Curve StreamingDeviation::curve() const {
  if (!buffer_.empty()) {
    StreamingDeviation whole = *this;
    whole.flush();
    return whole.curve();
  }
  Curve curve{dt_, samples_, std::nan("")};
  if (existing_ > 0) curve.mean = offset_ + sum_.value() / static_cast<double>(existing_);
  for (std::size_t octave = 0; octave < octaves_.size(); ++octave) {
    const Accumulator& sum = octaves_[octave];
    if (sum.terms == 0) continue;
    const std::int64_t m = std::int64_t{1} << octave;
    curve.points.push_back({m, sum.squares.value() / (2 * static_cast<double>(sum.terms)), sum.terms,
                            std::max<std::int64_t>(1, m / options_.overlap)});
  }
  return curve;
}

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "triples.h"

#include <algorithm>
#include <limits>

namespace gyrobudget::inline v0::allan::detail {

void Ranges::append(std::int64_t first, std::int64_t end) {
  if (!ranges_.empty() && ranges_.back().end == first) {
    ranges_.back().end = end;
  } else {
    ranges_.push_back({first, end, size_});
  }
  size_ += end - first;
}

std::int64_t Ranges::at(std::int64_t rank) const {
  const auto after = std::upper_bound(ranges_.begin(), ranges_.end(), rank,
                                      [](std::int64_t r, const Range& range) { return r < range.before; });
  const Range& range = *(after - 1);
  return range.first + (rank - range.before);
}

Ranges Ranges::sample(std::size_t most) const {
  if (ranges_.size() <= most) return *this;
  constexpr std::size_t kStretches = 64;
  const std::size_t length = std::max<std::size_t>(1, most / kStretches);
  Ranges part;
  for (std::size_t i = 0; i < kStretches; ++i) {
    const std::size_t first = i * (ranges_.size() - length) / (kStretches - 1);
    for (std::size_t r = first; r < first + length; ++r) part.append(ranges_[r].first, ranges_[r].end);
  }
  return part;
}

namespace {

/// Counts the members below ascending bounds, each found by doubling steps from the one before.
class Counter {
 public:
  explicit Counter(const std::vector<Ranges::Range>& ranges) : at_(ranges.data()), end_(at_ + ranges.size()) {}
  std::int64_t below(std::int64_t bound) {
    std::ptrdiff_t step = 1;  // at_ stays on the last range that begins below the bound
    while (end_ - at_ > step && at_[step].first < bound) {
      at_ += step;
      step *= 2;
    }
    const Ranges::Range* limit = at_ + std::min<std::ptrdiff_t>(step, end_ - at_);
    at_ = std::partition_point(at_, limit, [&](const Ranges::Range& range) { return range.first < bound; });
    if (at_ != begin_) --at_;
    return at_->first < bound ? at_->before + std::min(bound, at_->end) - at_->first : 0;
  }

 private:
  const Ranges::Range *at_, *end_, *begin_ = at_;
};

}  // namespace

std::int64_t count_pairs(const Ranges& a, const Ranges& b, std::int64_t h) {
  const bool first_is_few = a.ranges().size() <= b.ranges().size();
  const Ranges &few = first_is_few ? a : b, &many = first_is_few ? b : a;
  const std::int64_t shift = first_is_few ? h : -h;
  if (few.size() == 0) return 0;
  Counter counter(many.ranges());
  std::int64_t count = 0;
  for (const Ranges::Range& range : few.ranges()) {
    const std::int64_t before = counter.below(range.first + shift);
    count += counter.below(range.end + shift) - before;
  }
  return count;
}

namespace {

/// Whether sample k + shift exists, while k walks upwards.
class Existence {
 public:
  Existence(const std::vector<Mask::Gap>& runs, std::int64_t k, std::int64_t shift)
      : shift_(shift), end_(runs.data() + runs.size()) {
    run_ = std::partition_point(runs.data(), end_,
                                [&](const Mask::Gap& run) { return run.first + run.count <= k + shift; });
    move_to(k);
  }
  [[nodiscard]] std::int64_t exists() const { return exists_; }
  /// The next k at which exists() changes.
  [[nodiscard]] std::int64_t next() const { return next_; }
  void move_to(std::int64_t k) {
    while (run_ != end_ && run_->first + run_->count <= k + shift_) ++run_;
    if (run_ == end_) {
      exists_ = 1;
      next_ = std::numeric_limits<std::int64_t>::max();
    } else {
      exists_ = k + shift_ < run_->first ? 1 : 0;
      next_ = run_->first + (exists_ != 0 ? 0 : run_->count) - shift_;
    }
  }

 private:
  std::int64_t shift_, exists_ = 1, next_ = 0;
  const Mask::Gap *run_ = nullptr, *end_;
};

std::int64_t existing_between(const std::vector<Mask::Gap>& runs, std::int64_t first, std::int64_t end) {
  std::int64_t count = end - first;
  for (const Mask::Gap& run : runs) {
    count -= std::max<std::int64_t>(0, std::min(end, run.first + run.count) - std::max(first, run.first));
  }
  return count;
}

/// The samples that exist in a cluster, as its first sample steps through a stretch: count + slope * step.
struct Cluster {
  std::int64_t count, slope;
  [[nodiscard]] std::int64_t after(std::int64_t steps) const { return count + slope * steps; }
};

/// Cuts [low, high) to the steps at which the cluster has at least `least` samples.
void keep_filled(const Cluster& cluster, std::int64_t least, std::int64_t& low, std::int64_t& high) {
  if (cluster.slope > 0) {
    low = std::max(low, least - cluster.count);
  } else if (cluster.slope < 0) {
    high = std::min(high, cluster.count - least + 1);
  } else if (cluster.count < least) {
    high = low;
  }
}

class Sweep {
 public:
  Sweep(std::int64_t m, std::int64_t least) : m_(m), least_(least) { triples_.m = m; }

  /// A stretch of `steps` first samples from k on, over which both clusters change evenly.
  void stretch(std::int64_t k, std::int64_t steps, const Cluster& one, const Cluster& two) {
    std::int64_t low = 0, high = steps;
    keep_filled(one, least_, low, high);
    keep_filled(two, least_, low, high);
    if (low >= high) return;
    triples_.valid.append(k + low, k + high);
    if (one.slope == 0 && two.slope == 0) {
      add(k + low, k + high, one.count, two.count);
    } else {
      for (std::int64_t i = low; i < high; ++i) add(k + i, k + i + 1, one.after(i), two.after(i));
    }
  }
  Triples take() {
    const auto touched = static_cast<double>(triples_.touched.size());
    if (touched > 0) triples_.white_ratio = 1 + excess_ / static_cast<double>(triples_.valid.size());
    return std::move(triples_);
  }

 private:
  void add(std::int64_t first, std::int64_t end, std::int64_t count1, std::int64_t count2) {
    if (count1 == m_ && count2 == m_) return;
    triples_.touched.append(first, end);
    const double more1 = static_cast<double>(m_ - count1) / static_cast<double>(count1);  // m/c - 1
    const double more2 = static_cast<double>(m_ - count2) / static_cast<double>(count2);
    excess_ += static_cast<double>(end - first) * (more1 + more2) / 2;
  }

  std::int64_t m_, least_;
  Triples triples_;
  double excess_ = 0;
};

}  // namespace

Triples find_triples(const Mask& mask, std::int64_t m, Form form) {
  const std::vector<Mask::Gap>& runs = mask.runs();
  std::int64_t k = first_triple(form);
  const std::int64_t end = k + complete_terms(mask.samples(), m, form);
  std::int64_t count1 = existing_between(runs, k, k + m), count2 = existing_between(runs, k + m, k + 2 * m);
  Existence leaving(runs, k, 0), crossing(runs, k, m), entering(runs, k, 2 * m);

  Sweep sweep(m, mask.minimum_count(m));
  while (k < end) {
    const std::int64_t next = std::min({end, leaving.next(), crossing.next(), entering.next()});
    const Cluster one{count1, crossing.exists() - leaving.exists()};
    const Cluster two{count2, entering.exists() - crossing.exists()};
    sweep.stretch(k, next - k, one, two);
    count1 = one.after(next - k);
    count2 = two.after(next - k);
    k = next;
    leaving.move_to(k);
    crossing.move_to(k);
    entering.move_to(k);
  }
  return sweep.take();
}

}  // namespace gyrobudget::inline v0::allan::detail

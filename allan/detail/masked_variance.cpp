// SPDX-License-Identifier: MIT
// What gaps do to the expectation of one triple, process by process, averaged over a sample of the triples that miss
// samples. A triple estimates d = (mean over the samples that exist in cluster 2) - (same in cluster 1).
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <variant>

#include "triples.h"

namespace gyrobudget::inline v0::allan::detail {
namespace {

constexpr double square(double x) { return x * x; }

/// Gaps within one cluster, positions from the triple's first sample.
struct ClusterGaps {
  std::vector<Mask::Gap> missing;
  double existing = 0;
};
using TripleGaps = std::array<ClusterGaps, 2>;

TripleGaps gaps_of(const Mask& mask, std::int64_t k, std::int64_t m) {
  TripleGaps gaps;
  for (std::int64_t i = 0; i < 2; ++i) {
    const std::int64_t first = k + i * m, end = first + m;
    ClusterGaps& cluster = gaps[static_cast<std::size_t>(i)];
    std::int64_t existing = m;
    auto run = std::partition_point(mask.runs().begin(), mask.runs().end(),
                                    [&](const Mask::Gap& r) { return r.first + r.count <= first; });
    for (; run != mask.runs().end() && run->first < end; ++run) {
      const std::int64_t from = std::max(first, run->first), to = std::min(end, run->first + run->count);
      cluster.missing.push_back({from - k, to - from});
      existing -= to - from;
    }
    cluster.existing = static_cast<double>(existing);
  }
  return gaps;
}

// --- Processes whose expectation is exact in O(gaps of the triple). Each returns E[d^2]. ---

/// Neighbours share one reading, so a run of samples carries the errors of its two ends.
double expected_square(const noise::Quantization& p, const TripleGaps& gaps, double m, double dt) {
  double weights = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const ClusterGaps& cluster = gaps[i];
    const double first = static_cast<double>(i) * m, last = first + m;
    double runs = 1 + static_cast<double>(cluster.missing.size());
    for (const Mask::Gap& run : cluster.missing) {
      const auto from = static_cast<double>(run.first), to = static_cast<double>(run.first + run.count);
      if (from == first) --runs;
      if (to == last) --runs;
    }
    weights += 2 * runs / square(cluster.existing);
  }
  const auto& before = gaps[0].missing;
  const auto& after = gaps[1].missing;
  const bool ends_missing = !before.empty() && static_cast<double>(before.back().first + before.back().count) == m;
  const bool starts_missing = !after.empty() && static_cast<double>(after.front().first) == m;
  if (!ends_missing && !starts_missing) weights += 2 / (gaps[0].existing * gaps[1].existing);
  return square(p.q / dt) * weights;
}

double expected_square(const noise::RateRamp& p, const TripleGaps& gaps, double m, double dt) {
  double middle[2];
  for (std::size_t i = 0; i < 2; ++i) {
    double moment = m * (static_cast<double>(i) * m + (m - 1) / 2);
    for (const Mask::Gap& run : gaps[i].missing) {
      const auto count = static_cast<double>(run.count);
      moment -= count * (static_cast<double>(run.first) + (count - 1) / 2);
    }
    middle[i] = moment / gaps[i].existing;
  }
  return square(p.r * dt * (middle[1] - middle[0]));
}

double expected_square(const noise::Sinusoid& p, const TripleGaps& gaps, double m, double dt) {
  const double cycles = std::remainder(p.frequency * dt, 1.0);
  if (cycles == 0) return 0;
  const auto turn = [&](double samples) { return std::numbers::pi * std::remainder(cycles * samples, 2.0); };
  const auto sum = [&](double first, double count) {  // of exp(2 pi i cycles k) over the samples
    return std::sin(turn(count)) / std::sin(turn(1)) * std::polar(1., turn(2 * first + count - 1));
  };
  std::complex<double> mean[2];
  for (std::size_t i = 0; i < 2; ++i) {
    mean[i] = sum(static_cast<double>(i) * m, m);
    for (const Mask::Gap& run : gaps[i].missing) {
      mean[i] -= sum(static_cast<double>(run.first), static_cast<double>(run.count));
    }
    mean[i] /= gaps[i].existing;
  }
  return square(p.amplitude) / 2 * std::norm(mean[1] - mean[0]);
}

// --- Flicker, random walk, Gauss-Markov: blocks. Samples count as spread evenly over the block they are in, which
// leaves a small matrix of phase covariances between the ends of blocks, the same for all triples; what the gaps do
// within a block is added for each gap by itself. Exact up to m = kBlocks, where a block is one sample. ---

class Blocks {
 public:
  Blocks(const noise::Process& process, std::int64_t m, double dt)
      : process_(process), dt_(dt), m_(m), length_((m + kBlocks - 1) / kBlocks), blocks_((m + length_ - 1) / length_) {
    for (std::int64_t cluster = 0; cluster < 2; ++cluster) {
      for (std::int64_t b = 0; b < blocks_; ++b) edges_.push_back(cluster * m + b * length_);
    }
    edges_.push_back(2 * m);
    covariance_.reserve(edges_.size() * edges_.size());
    for (const std::int64_t a : edges_) {
      for (const std::int64_t b : edges_) covariance_.push_back(covariance(static_cast<double>(a - b)));
    }
    if (length_ > 1) {
      for (std::int64_t count = 1; count <= std::min(length_, kTabulated); ++count) within_.push_back(within(count));
    }
  }

  [[nodiscard]] double expected_square(const TripleGaps& gaps) {
    density_.assign(edges_.size() + 1, 0);  // weight of a sample in block b at b + 1, nothing outside
    double inside = 0;
    for (std::size_t i = 0; i < 2; ++i) inside += spread(gaps[i], static_cast<std::int64_t>(i));
    double sum = 0;
    for (std::size_t a = 0; a < edges_.size(); ++a) {
      double row = 0;
      for (std::size_t b = 0; b < edges_.size(); ++b) {
        row += covariance_[a * edges_.size() + b] * (density_[b] - density_[b + 1]);
      }
      sum += row * (density_[a] - density_[a + 1]);
    }
    return sum + inside;
  }

 private:
  static constexpr std::int64_t kBlocks = 32;
  static constexpr std::int64_t kTabulated = 64;

  [[nodiscard]] double covariance(double lag) const {
    return noise::phase_covariance(process_, lag, dt_) / square(dt_);
  }

  /// Fills the densities of one cluster and returns what its gaps do within blocks.
  double spread(const ClusterGaps& cluster, std::int64_t index) {
    const double weight = (index == 0 ? -1 : 1) / cluster.existing;
    const std::int64_t base = index * m_;
    double* density = density_.data() + 1 + index * blocks_;
    std::fill_n(density, blocks_, weight);
    double inside = 0;
    for (const Mask::Gap& run : cluster.missing) {
      for (std::int64_t from = run.first - base, end = from + run.count; from < end;) {
        const std::int64_t b = from / length_, block_end = std::min(m_, (b + 1) * length_);
        const std::int64_t count = std::min(end, block_end) - from;
        density[b] -= weight * static_cast<double>(count) / static_cast<double>(block_end - b * length_);
        if (length_ > 1) inside += count <= kTabulated ? within_[static_cast<std::size_t>(count - 1)] : within(count);
        from += count;
      }
    }
    return inside * square(weight);
  }

  /// E of the square of (sum of `count` samples in the middle of a block) - count (mean of the block).
  [[nodiscard]] double within(std::int64_t count) const {
    const auto length = static_cast<double>(length_), part = static_cast<double>(count) / length;
    const double lead = (length - static_cast<double>(count)) / 2;
    const double at[] = {0, lead, length - lead, length}, weight[] = {part, -1, 1, -part};
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) sum += weight[i] * weight[j] * covariance(at[i] - at[j]);
    }
    return sum;
  }

  const noise::Process& process_;
  double dt_;
  std::int64_t m_, length_, blocks_;
  std::vector<std::int64_t> edges_;
  std::vector<double> covariance_, within_, density_;
};

/// Mean of `square_of(gaps)` over at most `most` triples, spread evenly over those that miss samples.
template <typename SquareOf>
double mean_of_touched(const Mask& mask, const Triples& triples, std::int64_t most, SquareOf square_of) {
  const std::int64_t all = triples.touched.size(), taken = std::min(all, most);
  double sum = 0;
  for (std::int64_t i = 0; i < taken; ++i) {
    // Midpoints of equal parts; all < 2^32 keeps the product in range.
    const std::int64_t rank = (2 * i + 1) * all / (2 * taken);
    sum += square_of(gaps_of(mask, triples.touched.at(rank), triples.m));
  }
  return sum / static_cast<double>(taken);
}

}  // namespace

double masked_variance(const Mask& mask, const Triples& triples, const noise::Process& process, double dt) {
  if (triples.valid.size() == 0) return std::numeric_limits<double>::quiet_NaN();
  const double complete = noise::allan_variance(process, triples.m, dt);
  if (triples.touched.size() == 0) return complete;
  if (std::holds_alternative<noise::White>(process)) return complete * triples.white_ratio;

  // Long clusters hold many gaps, but each is then more like the next: fewer do.
  constexpr std::int64_t kMostExact = 512, kMostBlocks = 128, kFewest = 32, kGaps = 100'000;
  const std::int64_t gaps_each = 1 + static_cast<std::int64_t>(mask.runs().size()) * 2 * triples.m / mask.samples();
  const auto taken = [&](std::int64_t most) { return std::clamp(kGaps / gaps_each, kFewest, most); };
  const auto m = static_cast<double>(triples.m);
  const double expected = std::visit(
      [&](const auto& p) {
        if constexpr (requires(const TripleGaps& gaps) { expected_square(p, gaps, m, dt); }) {
          return mean_of_touched(mask, triples, taken(kMostExact),
                                 [&](const TripleGaps& gaps) { return expected_square(p, gaps, m, dt); });
        } else {
          Blocks blocks(process, triples.m, dt);
          return mean_of_touched(mask, triples, taken(kMostBlocks),
                                 [&](const TripleGaps& gaps) { return blocks.expected_square(gaps); });
        }
      },
      process);
  const double touched = static_cast<double>(triples.touched.size()) / static_cast<double>(triples.valid.size());
  return complete + touched * (expected / 2 - complete);
}

}  // namespace gyrobudget::inline v0::allan::detail

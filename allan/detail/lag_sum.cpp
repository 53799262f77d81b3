// SPDX-License-Identifier: MIT
#include "lag_sum.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>

namespace gyrobudget::inline v0::allan::detail {
namespace {

constexpr int kNodes = 6;
constexpr int kLongest = 48;  // log2 of the longest panel

struct Rule {
  std::array<double, kNodes> node{};  ///< in [0, L-1]
  std::array<double, kNodes> weight{};
};

/// Gauss rule for sums over 0, 1, .. L-1: its orthogonal polynomials are the discrete Chebyshev (Gram) ones, with
/// p_{k+1} = (x - (L-1)/2) p_k - beta_k p_{k-1}, beta_k = k^2 (L^2 - k^2) / (4 (4 k^2 - 1)).
Rule gauss_for_sums(double length) {
  // In z = (2x - L + 1) / L the recurrence has coefficients near Legendre's, and nodes near those to start from.
  const auto beta = [&](int k) {
    const double k2 = static_cast<double>(k) * k;
    return k2 * (1 - k2 / (length * length)) / (4 * k2 - 1);
  };
  Rule rule;
  for (int i = 0; i < kNodes; ++i) {
    double z = -std::cos(std::numbers::pi * (i + 0.75) / (kNodes + 0.5));
    double step = 1, norm = 0;
    constexpr double kConverged = 1e-15;
    for (int iteration = 0; iteration < 50 && std::abs(step) > kConverged; ++iteration) {
      double before = 0, p = 1, slope_before = 0, slope = 0, square_norm = 1;
      norm = 0;
      for (int k = 0; k < kNodes; ++k) {
        norm += p * p / square_norm;
        const double b = k > 0 ? beta(k) : 0;
        const double next = z * p - b * before, slope_next = p + z * slope - b * slope_before;
        before = p, p = next, slope_before = slope, slope = slope_next;
        square_norm *= beta(k + 1);
      }
      step = p / slope;
      z -= step;
    }
    const auto at = static_cast<std::size_t>(i);
    rule.node[at] = (length * (z + 1) - 1) / 2;
    rule.weight[at] = length / norm;
  }
  return rule;
}

/// The rule for 2^k lags.
const Rule& rule(int log2_length) {
  static const std::array<Rule, kLongest + 1> rules = [] {
    std::array<Rule, kLongest + 1> made{};
    for (int k = std::bit_width(static_cast<std::uint64_t>(kSmooth)) - 1; k <= kLongest; ++k) {
      made[static_cast<std::size_t>(k)] = gauss_for_sums(std::ldexp(1., k));
    }
    return made;
  }();
  return rules[static_cast<std::size_t>(log2_length)];
}

class Builder {
 public:
  explicit Builder(std::int64_t longest_panel) : longest_panel_(longest_panel) {}

  /// Lags knot + 1, knot + 2, .. knot + count (direction 1) or those below the knot (-1): panels grow away from it.
  void grade(std::int64_t knot, int direction, std::int64_t count) {
    std::int64_t done = std::min(count, kSmooth);
    for (std::int64_t i = 1; i <= done; ++i) single(knot + direction * i);
    while (done < count) {
      const std::int64_t room = std::min({count - done, done, longest_panel_});
      const std::int64_t length = std::bit_floor(static_cast<std::uint64_t>(room));
      if (length < kSmooth) {
        single(knot + direction * ++done);
        continue;
      }
      const std::int64_t nearest = knot + direction * (done + 1), farthest = knot + direction * (done + length);
      panel(std::min(nearest, farthest), length);
      done += length;
    }
  }
  void single(std::int64_t lag) {
    nodes_.u.push_back(static_cast<double>(lag));
    nodes_.w.push_back(1);
  }
  LagNodes take() { return std::move(nodes_); }

 private:
  void panel(std::int64_t first, std::int64_t length) {
    const Rule& r = rule(std::bit_width(static_cast<std::uint64_t>(length)) - 1);
    for (std::size_t i = 0; i < kNodes; ++i) {
      nodes_.u.push_back(static_cast<double>(first) + r.node[i]);
      nodes_.w.push_back(r.weight[i]);
    }
  }

  std::int64_t longest_panel_;
  LagNodes nodes_;
};

}  // namespace

LagNodes lag_nodes(const Pair& pair, std::int64_t end, std::int64_t longest_panel) {
  std::array<std::int64_t, 5> knots{0, pair.m1, pair.m2 - pair.m1, pair.m2, pair.m1 + pair.m2};
  std::sort(knots.begin(), knots.end());
  const auto last = std::unique(knots.begin(), knots.end());

  Builder builder(std::min(longest_panel, std::int64_t{1} << kLongest));
  for (auto knot = knots.begin(); knot != last && *knot < end; ++knot) {
    builder.single(*knot);
    const auto next = knot + 1;
    if (next == last) {
      builder.grade(*knot, 1, end - 1 - *knot);
    } else {
      const std::int64_t inside = *next - *knot - 1, right = inside / 2;
      builder.grade(*knot, 1, std::min(inside - right, end - 1 - *knot));
      // The half before the next knot, from its far side, as far as `end` lets it reach.
      const std::int64_t cut = std::max<std::int64_t>(0, *next - end);
      if (right > cut) builder.grade(*next - cut, -1, right - cut);
    }
  }
  return builder.take();
}

}  // namespace gyrobudget::inline v0::allan::detail

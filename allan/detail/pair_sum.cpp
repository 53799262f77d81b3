// SPDX-License-Identifier: MIT
#include "pair_sum.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "lag_kernel.h"
#include "lag_sum.h"

namespace gyrobudget::inline v0::allan::detail {
namespace {

/// How many pairs of triples, one at each factor, have their middles u apart to either side.
class PairCount {
 public:
  PairCount(const Setting& setting, const FactorFacts& one, const FactorFacts& two)
      : offset_(two.m - one.m), plateau_(complete_terms(setting.samples, two.m, setting.form)) {
    if (setting.mask) sample(one, two);
  }

  /// Number of lags u = 0, 1, .. with any pair in a complete record.
  [[nodiscard]] std::int64_t end() const { return plateau_ + offset_; }

  [[nodiscard]] double operator()(double u) const {
    if (knots_.empty()) {
      const double count = static_cast<double>(plateau_) - std::max(0., u - static_cast<double>(offset_));
      return u > 0 ? 2 * count : count;
    }
    const auto above = std::upper_bound(knots_.begin(), knots_.end() - 1, u,
                                        [](double value, const Knot& knot) { return value < knot.u; });
    const Knot &right = *above, &left = *(above - 1);
    const double count = left.count + (right.count - left.count) * (u - left.u) / (right.u - left.u);
    return u > 0 ? 2 * count : count;
  }

 private:
  struct Knot {
    double u, count;  // count: mean of both sides
  };

  /// With gaps the count is taken at the kinks of the kernels and at lags that grow geometrically, as fast as losing
  /// single samples makes triples come and go near u = 0; linear between. Where there are very many gaps it is taken
  /// on part of the triples, as the chance that a triple of the first factor has its partner.
  void sample(const FactorFacts& one, const FactorFacts& two) {
    constexpr std::size_t kMostRanges = 4096;
    const bool first_is_few = one.triples.valid.ranges().size() <= two.triples.valid.ranges().size();
    const Ranges &few = first_is_few ? one.triples.valid : two.triples.valid,
                 &many = first_is_few ? two.triples.valid : one.triples.valid;
    const Ranges part = few.sample(kMostRanges);
    const double scale = static_cast<double>(few.size()) / static_cast<double>(std::max<std::int64_t>(1, part.size()));

    const std::int64_t sum = one.m + two.m;
    std::vector<std::int64_t> lags{0, one.m, offset_, two.m, sum, end()};
    for (std::int64_t u = 1; u < std::min(end(), 4 * sum); u += 1 + u / 2) lags.push_back(u);
    std::sort(lags.begin(), lags.end());
    lags.erase(std::unique(lags.begin(), lags.end()), lags.end());
    lags.erase(std::upper_bound(lags.begin(), lags.end(), end()), lags.end());
    for (const std::int64_t u : lags) {
      // Middles u apart: the second triple begins u - offset behind the first, or -u - offset.
      const std::int64_t behind = first_is_few ? u - offset_ : offset_ - u;
      const std::int64_t ahead = first_is_few ? -u - offset_ : offset_ + u;
      const std::int64_t both = count_pairs(part, many, behind) + count_pairs(part, many, ahead);
      knots_.push_back({static_cast<double>(u), scale * static_cast<double>(both) / 2});
    }
  }

  std::int64_t offset_, plateau_;
  std::vector<Knot> knots_;
};

/// Kernels of all processes at the nodes, and what each node counts for.
struct Samples {
  std::vector<double> weight;
  std::vector<std::vector<double>> kernel;
};

Samples take_samples(const Setting& setting, const Pair& pair, const PairCount& count, const LagNodes& nodes) {
  Samples samples;
  samples.weight.resize(nodes.u.size());
  for (std::size_t i = 0; i < nodes.u.size(); ++i) samples.weight[i] = nodes.w[i] * count(nodes.u[i]);
  for (const noise::Process& process : setting.processes) {
    samples.kernel.emplace_back(nodes.u.size());
    lag_kernel(process, pair, nodes.u, samples.kernel.back());
  }
  return samples;
}

double product_sum(const Samples& samples, std::size_t a, std::size_t b) {
  double sum = 0;
  for (std::size_t i = 0; i < samples.weight.size(); ++i) {
    sum += samples.weight[i] * samples.kernel[a][i] * samples.kernel[b][i];
  }
  return sum;
}

/// sum_u count(u) C_line(u) C(u), whose first kernel oscillates. Few cycles in the record: panels shorter than a
/// quarter of a cycle. Many: where the line matters the count hardly changes over a cycle, and the sum of C(u) cos is
/// the cross-spectrum of the two differences at the line, |H_1| |H_2| S / dt, |H_m| = sqrt2 sin^2(pi c m)/(m sin(pi
/// c)).
double line_sum(const Setting& setting, const Pair& pair, const PairCount& count, std::size_t line, std::size_t a) {
  const auto& sinusoid = std::get<noise::Sinusoid>(setting.processes[line]);
  const double cycles = std::abs(std::remainder(sinusoid.frequency * setting.dt, 1.0));
  if (cycles == 0) return 0;
  constexpr double kManyCycles = 500;
  const auto lags = static_cast<double>(count.end());
  if (cycles * lags < kManyCycles) {
    const auto panel = static_cast<std::int64_t>(std::min(0.25 / cycles, lags));
    const Samples samples = take_samples(setting, pair, count, lag_nodes(pair, count.end(), panel));
    return product_sum(samples, line, a);
  }
  const double amplitude = std::sqrt(noise::allan_variance(sinusoid, pair.m1, setting.dt) *
                                     noise::allan_variance(sinusoid, pair.m2, setting.dt));
  const double density = noise::psd(setting.processes[a], cycles / setting.dt, setting.dt) / setting.dt;
  return count(1) / 2 * amplitude * 2 * amplitude * density;  // |H_1| |H_2| = 2 amplitude
}

}  // namespace

Setting make_setting(std::int64_t samples, double dt, std::span<const noise::Process> processes, Form form,
                     const Mask* mask) {
  if (!(dt > 0) || !std::isfinite(dt)) {
    throw std::invalid_argument(fmt::format("sample interval dt is {}; it must be positive and finite (s)", dt));
  }
  if (mask && mask->samples() != samples) {
    throw std::invalid_argument(
        fmt::format("mask is for a record of {} samples, the record has {}", mask->samples(), samples));
  }
  Setting setting{samples, dt, form, mask && mask->missing() > 0 ? mask : nullptr, {}};
  for (const noise::Process& process : processes) {
    setting.processes.push_back(noise::with_coefficient(process, 1));
  }
  return setting;
}

FactorFacts factor_facts(const Setting& setting, std::int64_t m) {
  if (m < 1 || m > setting.samples / 2) {
    throw std::invalid_argument(
        fmt::format("averaging factor is {}; for a record of {} samples it must be from 1 to {}", m, setting.samples,
                    setting.samples / 2));
  }
  FactorFacts facts{m, complete_terms(setting.samples, m, setting.form), {}, {}, {}};
  if (setting.mask) {
    facts.triples = find_triples(*setting.mask, m, setting.form);
    facts.terms = facts.triples.valid.size();
  }
  for (const noise::Process& process : setting.processes) {
    const double complete = noise::allan_variance(process, m, setting.dt);
    const double expected = facts.terms == 0 ? std::numeric_limits<double>::quiet_NaN()
                            : setting.mask   ? masked_variance(*setting.mask, facts.triples, process, setting.dt)
                                             : complete;
    facts.expectation.push_back(expected);
    facts.gain.push_back(complete > 0 ? std::sqrt(expected / complete) : 1);
  }
  return facts;
}

std::vector<double> pair_sum(const Setting& setting, const FactorFacts& first, const FactorFacts& second) {
  const FactorFacts &one = first.m <= second.m ? first : second, &two = first.m <= second.m ? second : first;
  const std::vector<noise::Process>& processes = setting.processes;
  const double terms = static_cast<double>(one.terms) * static_cast<double>(two.terms);
  const double scale = terms > 0 ? 2 / terms : std::numeric_limits<double>::quiet_NaN();
  const Pair pair{one.m, two.m, setting.dt};
  const PairCount count(setting, one, two);
  const Samples samples = take_samples(setting, pair, count, lag_nodes(pair, count.end()));

  const auto is_line = [&](std::size_t a) { return std::holds_alternative<noise::Sinusoid>(processes[a]); };
  std::vector<double> entries;
  for (std::size_t a = 0; a < processes.size(); ++a) {
    for (std::size_t b = a; b < processes.size(); ++b) {
      double sum = 0;
      if (deterministic(processes[a]) && deterministic(processes[b])) {
        // A mean by itself does not vary.
      } else if (is_line(a) || is_line(b)) {
        sum = line_sum(setting, pair, count, is_line(a) ? a : b, is_line(a) ? b : a);
      } else {
        sum = product_sum(samples, a, b);
      }
      entries.push_back(scale * sum * one.gain[a] * two.gain[a] * one.gain[b] * two.gain[b]);
    }
  }
  return entries;
}

}  // namespace gyrobudget::inline v0::allan::detail

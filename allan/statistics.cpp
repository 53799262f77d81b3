// SPDX-License-Identifier: MIT
#include "statistics.h"

#include "gyrobudget/allan/detail/family_sum.h"
#include "gyrobudget/allan/detail/lag_moments.h"
#include "gyrobudget/allan/detail/octave_ratio.h"
#include "gyrobudget/allan/detail/quadratic_form.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <variant>

namespace gyrobudget::inline v0::allan {
namespace {

using detail::Moments;
constexpr std::int64_t kFewestClusters = 30;  // that tell a noise by their lag-1 autocorrelation
using Mix = std::span<const noise::Process>;

void check(const Estimation& of) {
  if (!has_terms(of.estimator, of.samples, of.m)) {
    const FactorRange range = factor_range(of.estimator, of.samples);
    throw std::invalid_argument(
        fmt::format("averaging factor is {}; for {} of a record of {} samples it must be {}from {} to {}", of.m,
                    name(of.estimator), of.samples, range.step == 2 ? "even, " : "", range.least, range.most));
  }
  if (of.stride < 1) throw std::invalid_argument(fmt::format("stride is {} samples; it must be at least 1", of.stride));
  if (!(of.dt > 0) || !std::isfinite(of.dt))
    throw std::invalid_argument(fmt::format("sample interval dt is {}; it must be positive and finite (s)", of.dt));
}

/// The mix relative to its largest coefficient: degrees of freedom and biases know no scale.
std::vector<noise::Process> normalized(Mix mix) {
  double largest = 0;
  for (const noise::Process& process : mix) largest = std::max(largest, std::abs(noise::coefficient(process)));
  if (!(largest > 0)) throw std::invalid_argument("statistics of no noise: all coefficients of the mix are 0");
  std::vector<noise::Process> result;
  for (const noise::Process& process : mix)
    result.push_back(noise::with_coefficient(process, noise::coefficient(process) / largest));
  return result;
}

// ---- the dense form, of a record that is short enough ----

struct Resolution {
  std::int64_t samples_per_cluster;  ///< at least, where the record has them
  double low, high;  ///< clusters in a record: from `high` on statistics are straight lines through these
};
Resolution resolution(Estimator estimator) {
  if (estimator == Estimator::theo1) return {48, 3.5, 5};
  return {16, 8, 13};
}

/// The same with fewer samples a cluster and a given number of clusters in the record.
Estimation reduced(const Estimation& of, double clusters) {
  const Resolution limits = resolution(of.estimator);
  const double finest = static_cast<double>(limits.samples_per_cluster) * limits.high / clusters;
  Estimation result = of;
  result.m = std::min(of.m, static_cast<std::int64_t>(finest) / 4 * 4);  // 0.75 m of Theo1 stays whole
  const double coarser = static_cast<double>(result.m) / static_cast<double>(of.m);
  const auto samples = static_cast<std::int64_t>(std::ceil(clusters * static_cast<double>(of.m)));
  result.samples = detail::rescaled_samples(of.estimator, samples, of.m, result.m);
  result.stride = std::max<std::int64_t>(1, std::llround(static_cast<double>(of.stride) * coarser));
  result.dt = of.dt / coarser;
  return result;
}

Moments dense_moments(const Estimation& of, Mix mix) {
  return detail::moments(detail::estimator_matrix(of.estimator, of.samples, of.m, of.stride), mix, of.dt);
}

/// Degrees of freedom from dense forms. The points of a curve share most of those: it keeps them.
class DenseDof {
 public:
  double operator()(const Estimation& of, Mix mix) {
    const Resolution limits = resolution(of.estimator);
    const double clusters = static_cast<double>(of.samples) / static_cast<double>(of.m);
    if (clusters <= limits.high) return direct(reduced(of, clusters), mix);
    const Estimation high = reduced(of, limits.high);
    Estimation low = high;
    low.samples = static_cast<std::int64_t>(limits.low * static_cast<double>(high.m));
    const double at_low = direct(low, mix), at_high = direct(high, mix);
    const double slope = (at_high - at_low) / static_cast<double>(high.samples - low.samples);
    const std::int64_t samples = detail::rescaled_samples(of.estimator, of.samples, of.m, high.m);
    return at_high + slope * static_cast<double>(samples - high.samples);
  }

 private:
  double direct(Estimation of, Mix mix) {
    const bool alone = mix.size() == 1 && is_power_law(mix.front());
    if (alone) of.dt = 1;  // one power law knows no time scale
    const char kind = alone ? static_cast<char>(noise::term(mix.front())) : '\0';
    const auto key = std::make_tuple(kind, of.samples, of.m, of.stride, of.dt);
    {
      const std::lock_guard lock(mutex_);
      if (const auto found = known_.find(key); found != known_.end()) return found->second;
    }
    const double edf = dense_moments(of, mix).edf();
    const std::lock_guard lock(mutex_);
    return known_[key] = edf;
  }

  static bool is_power_law(const noise::Process& process) {
    const noise::Term term = noise::term(process);
    return term == noise::Term::quantization || term == noise::Term::white || term == noise::Term::flicker ||
           term == noise::Term::rate_random_walk;
  }

  std::mutex mutex_;
  std::map<std::tuple<char, std::int64_t, std::int64_t, std::int64_t, double>, double> known_;
};

/// @param mix normalized.
double degrees_of_freedom(Estimation of, Mix mix, DenseDof& dense) {
  const Basis basis = basis_of(of.estimator, of.samples, of.m);
  of.estimator = basis.estimator;
  of.m = basis.m;
  if (!detail::is_stationary(of.estimator)) return dense(of, mix);
  return detail::lag_moments(of.estimator, of.samples, of.m, of.stride, of.dt, mix).edf();
}

// ---- biases ----

/// Total: the terms in the middle have the Allan variance, those whose neighbours are reflected one of their
/// own each.
double total_ratio(const Estimation& of, Mix mix) {
  constexpr std::int64_t kFinest = 512;
  Estimation small = of;
  if (of.m > kFinest) {
    small.m = kFinest;
    small.samples = detail::rescaled_samples(of.estimator, of.samples, of.m, kFinest);
    small.dt = of.dt * static_cast<double>(of.m) / static_cast<double>(kFinest);
  }
  // The record's form without its middle, which is as long as the record but for the two ends of m.
  const std::int64_t n = small.samples, m = small.m;
  const double allan = noise::allan_variance(mix, m, small.dt);
  const std::int64_t inside = std::max<std::int64_t>(0, n - 2 * m + 1);
  double sum = static_cast<double>(inside) * allan;
  const auto middle = [&](std::int64_t i) { return detail::reflected_expectation(mix, n, m, i, small.dt); };
  // Time can run backwards: a term and its mirror image expect the same.
  const std::int64_t half = inside > 0 ? m - 1 : (n - 1) / 2;
  for (std::int64_t i = 1; i <= half; ++i) sum += 2 * middle(i);
  if (inside == 0 && n % 2 == 0) sum += middle(n / 2);
  return sum / static_cast<double>(n - 1) / allan;
}

/// Modified and Hadamard total: every stretch of 3m has the same expectation, so a record of one serves.
double stretch_ratio(const Estimation& of, Mix mix, Estimator plain) {
  Estimation small = reduced(of, resolution(of.estimator).high);
  small.samples = small.stride = 3 * small.m;
  const Eigen::MatrixXd form = detail::estimator_matrix(of.estimator, small.samples, small.m, small.stride);
  const Moments of_plain = detail::lag_moments(plain, small.samples, small.m, small.samples, small.dt, mix);
  return detail::expectation(form, mix, small.dt) / of_plain.expectation;
}

/// Theo1: the sum over its m/2 differences, each of four phases.
double theo1_ratio(const Estimation& of, Mix mix) {
  constexpr std::int64_t kFinest = 2048;
  const std::int64_t m = std::min(of.m, kFinest);
  const double dt = of.dt * static_cast<double>(of.m) / static_cast<double>(m);
  double expectation = 0;
  for (const noise::Process& process : mix) {
    const auto R = [&](std::int64_t lag) { return noise::phase_covariance(process, static_cast<double>(lag), dt); };
    const double ends = R(0) + R(m);
    for (std::int64_t j = 1; j <= m / 2; ++j) {
      // x_0 + x_m - x_j - x_{m-j}
      const double square = 2 * ends + 2 * (R(0) + R(m - 2 * j)) - 4 * (R(j) + R(m - j));
      expectation += square / static_cast<double>(j);
    }
    if (const auto* ramp = std::get_if<noise::RateRamp>(&process)) {
      for (std::int64_t j = 1; j <= m / 2; ++j) {
        const double d = ramp->r * dt * dt * static_cast<double>(j) * static_cast<double>(m - j);
        expectation += d * d / static_cast<double>(j);
      }
    }
  }
  const double M = static_cast<double>(m);
  expectation /= 0.75 * M * M * dt * dt;
  // The Allan variance at 0.75 m, between whole factors in proportion.
  const std::int64_t below = 3 * m / 4;
  const double share = 0.75 * M - static_cast<double>(below);
  const double allan =
      (1 - share) * noise::allan_variance(mix, below, dt) + share * noise::allan_variance(mix, below + 1, dt);
  return expectation / allan;
}

PointStatistics nothing() {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  return {1, kNaN, kNaN, {kNaN, kNaN}};
}

/// What the noise says of a point.
struct Facts {
  double bias = 0, edf = 0;
};

Facts facts_of(const Curve& curve, const Point& point, Mix mix, DenseDof& dense) {
  const Estimation of{curve.estimator, curve.samples, point.m, curve.dt, point.stride};
  const Estimator basis = basis_of(curve.estimator, curve.samples, point.m).estimator;
  const bool overlapped = basis == Estimator::oadev && point.stride == 1;
  const double edf = overlapped ? equivalent_dof(curve.samples, point.m, curve.dt, mix, curve.form, curve.mask.get())
                                : degrees_of_freedom(of, normalized(mix), dense);
  return {expectation_ratio(of, mix), edf};
}

/// Part of the terms that gaps have left; 1 where the degrees of freedom know of the gaps.
double share_left(const Curve& curve, const Point& point) {
  const auto [estimator, m] = basis_of(curve.estimator, curve.samples, point.m);
  if (estimator == Estimator::oadev && point.stride == 1 && curve.mask) return 1;
  const std::int64_t positions = curve.form == Form::ieee ? complete_terms(curve.samples, m, curve.form)
                                                          : detail::family_positions(estimator, curve.samples, m);
  const double complete = std::ceil(static_cast<double>(positions) / static_cast<double>(point.stride));
  return std::min(1., static_cast<double>(point.terms) / complete);
}

PointStatistics point_statistics(const Curve& curve, const Point& point, const Facts& facts, double confidence) {
  PointStatistics result;
  result.bias = facts.bias;
  result.edf = std::max(facts.edf * share_left(curve, point), std::min(1., facts.edf));
  result.variance = point.variance / result.bias;
  result.interval = chi_square_interval(result.variance, result.edf, confidence);
  return result;
}

/// Weights of the noises seen around a point, by term; they add up to 1.
std::map<noise::Term, double> noises_around(const Curve& curve, std::span<const Identified> noises, std::size_t i) {
  constexpr double kReach = 2;  // octaves
  std::map<noise::Term, double> weights;
  double sum = 0;
  for (std::size_t j = 0; j < noises.size(); ++j) {
    const double weight = kReach - std::abs(std::log2(curve.tau(j) / curve.tau(i)));
    if (weight <= 0) continue;
    weights[noises[j].term] += weight;
    sum += weight;
  }
  for (auto& [term, weight] : weights) weight /= sum;
  return weights;
}

/// @param facts_at gives the facts of a point by its index.
template <typename FactsAt>
std::vector<PointStatistics> each_point(const Curve& curve, double confidence, FactsAt facts_at) {
  std::vector<PointStatistics> result(curve.points.size());
  DenseDof dense;
  tbb::parallel_for(std::size_t{0}, result.size(), [&](std::size_t i) {
    const Point& point = curve.points[i];
    result[i] = point.terms == 0 ? nothing() : point_statistics(curve, point, facts_at(i, dense), confidence);
  });
  return result;
}

}  // namespace

double equivalent_dof(const Estimation& estimation, Mix mix) {
  check(estimation);
  const std::vector<noise::Process> scaled = normalized(mix);
  DenseDof dense;
  return degrees_of_freedom(estimation, scaled, dense);
}

double expectation_ratio(const Estimation& estimation, Mix mix) {
  check(estimation);
  if (detail::is_stationary(estimation.estimator)) return 1;
  const std::vector<noise::Process> scaled = normalized(mix);
  switch (estimation.estimator) {
    case Estimator::totdev:
      return total_ratio(estimation, scaled);
    case Estimator::mtotdev:
    case Estimator::ttotdev:
      return stretch_ratio(estimation, scaled, Estimator::mdev);
    case Estimator::htotdev:
      return estimation.m == 1 ? 1 : stretch_ratio(estimation, scaled, Estimator::ohdev);
    case Estimator::theo1:
      return theo1_ratio(estimation, scaled);
    default:
      return 1;
  }
}

std::vector<PointStatistics> statistics(const Curve& curve, Mix mix, double confidence) {
  return each_point(curve, confidence,
                    [&](std::size_t i, DenseDof& dense) { return facts_of(curve, curve.points[i], mix, dense); });
}

std::vector<PointStatistics> statistics(const Curve& curve, std::span<const Identified> noises, double confidence) {
  if (noises.size() != curve.points.size()) {
    throw std::invalid_argument(
        fmt::format("noise was identified at {} points; the curve has {}", noises.size(), curve.points.size()));
  }
  return each_point(curve, confidence, [&](std::size_t i, DenseDof& dense) {
    const auto facts_for = [&](noise::Term term) {
      const noise::Process process = noise::unit_process(term);
      return facts_of(curve, curve.points[i], Mix(&process, 1), dense);
    };
    Facts mean;
    double inverse = 0;  // of the degrees of freedom: half the relative variance
    for (const auto& [term, weight] : noises_around(curve, noises, i)) {
      const Facts facts = facts_for(term);
      mean.bias += weight * facts.bias;
      inverse += weight / facts.edf;
    }
    if (const Identified& here = noises[i]; here.share > 0) {
      const double own = 1 - here.share;
      inverse = std::max(inverse, own * own * inverse + here.share * here.share / facts_for(here.widest).edf);
    }
    mean.edf = 1 / inverse;
    return mean;
  });
}

std::vector<Identified> identify_noise(const Series& record, const Curve& curve) {
  std::vector<std::int64_t> factors;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const auto m = static_cast<std::int64_t>(std::llround(curve.tau(i) / curve.dt));
    factors.push_back(std::clamp<std::int64_t>(m, 1, std::max<std::int64_t>(1, record.samples() / 2)));
  }
  auto noises = held_noise(identify_noise(record, factors), record.samples());
  tbb::parallel_for(std::size_t{0}, noises.size(), [&](std::size_t i) {
    const std::int64_t m = factors[i];
    const bool few = m * kFewestClusters >= record.samples(), angle = noises[i].term == noise::Term::quantization;
    if (m < 2 || !(few || angle)) return;
    detail::tell_by_ratio(noises[i], detail::octave_ratio(record.phase(), record.samples(), m));
  });
  return noises;
}

std::vector<Identified> identify_noise(const Curve& curve) {
  if (curve.estimator != Estimator::oadev) {
    throw std::invalid_argument(
        fmt::format("noise is told from the slopes of the oadev, not of the {}", name(curve.estimator)));
  }
  std::vector<Identified> found(curve.points.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, found.size() - 1);
    const bool known = after > before && curve.points[after].m * kFewestClusters <= curve.samples;
    const double slope = std::log(curve.points[after].variance / curve.points[before].variance) /
                         std::log(curve.tau(after) / curve.tau(before));
    if (i > 0 && (!known || !std::isfinite(slope))) {
      found[i] = found[i - 1];
    } else if (known && std::isfinite(slope)) {
      constexpr std::pair<int, noise::Term> kLaws[] = {{2, noise::Term::quantization},
                                                       {0, noise::Term::white},
                                                       {-1, noise::Term::flicker},
                                                       {-2, noise::Term::rate_random_walk}};
      const auto law = static_cast<std::size_t>(std::clamp(std::lround(slope), -2L, 1L) + 2);
      found[i].alpha = kLaws[law].first;
      found[i].term = kLaws[law].second;
    }
    found[i].m = curve.points[i].m;
  }
  for (std::size_t i = 1; i < found.size(); ++i) {
    const Point &here = curve.points[i], &half = curve.points[i - 1];
    const bool few = here.m * kFewestClusters >= curve.samples;
    if (here.m != 2 * half.m || !(few || found[i].term == noise::Term::quantization)) continue;
    detail::tell_by_ratio(found[i], {.log_ratio = std::log(here.variance / half.variance),
                                     .m = here.m,
                                     .half = half.m,
                                     .clusters = static_cast<double>(curve.samples) / static_cast<double>(here.m),
                                     .terms = static_cast<double>(here.terms),
                                     .half_terms = static_cast<double>(half.terms)});
  }
  return found;
}

std::vector<PooledPoint> pool(std::span<const Segment> segments, double confidence) {
  std::map<std::int64_t, PooledPoint> by_factor;
  for (const Segment& segment : segments) {
    const Curve &curve = *segment.curve, &first = *segments.front().curve;
    if (curve.estimator != first.estimator || curve.dt != first.dt) {
      throw std::invalid_argument(
          fmt::format("segments to pool are {} every {} s and {} every {} s; they must be alike", name(first.estimator),
                      first.dt, name(curve.estimator), curve.dt));
    }
    if (segment.statistics.size() != curve.points.size()) {
      throw std::invalid_argument(
          fmt::format("a segment has {} points and statistics of {}", curve.points.size(), segment.statistics.size()));
    }
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
      if (curve.points[i].terms == 0) continue;
      PooledPoint& pooled = by_factor[curve.points[i].m];
      const PointStatistics& one = segment.statistics[i];
      pooled.tau = curve.tau(i);
      pooled.variance += one.edf * one.variance;
      pooled.edf += one.edf;
      pooled.terms += curve.points[i].terms;
      ++pooled.segments;
    }
  }
  std::vector<PooledPoint> points;
  for (auto& [m, pooled] : by_factor) {
    pooled.variance /= pooled.edf;
    pooled.interval = chi_square_interval(pooled.variance, pooled.edf, confidence);
    points.push_back(pooled);
  }
  return points;
}

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "family.h"

#include "gyrobudget/allan/detail/family_sum.h"
#include "gyrobudget/allan/detail/second_difference.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

using Factors = std::vector<std::int64_t>;
using detail::FamilyRecord;
using detail::TermSum;

void check(Estimator estimator, std::int64_t samples, std::span<const std::int64_t> factors,
           const EstimatorOptions& options) {
  for (const std::int64_t m : factors) {
    if (!has_terms(estimator, samples, m)) {
      const FactorRange range = factor_range(estimator, samples);
      throw std::invalid_argument(
          fmt::format("averaging factor is {}; for {} of a record of {} samples it must be {}from {} to {}{}", m,
                      name(estimator), samples, range.step == 2 ? "even, " : "", range.least, range.most,
                      estimator == Estimator::theoh ? ", a multiple of 3 above a fifth of them" : ""));
    }
  }
  constexpr std::int64_t kLongestStretch = INT32_MAX;  // of an even continuation
  if (detail::steps_per_term(estimator, 4) > 1 && samples >= kLongestStretch) {
    throw std::invalid_argument(
        fmt::format("{} of {} samples; it takes at most {}", name(estimator), samples, kLongestStretch - 1));
  }
  if (options.overlap < 0)
    throw std::invalid_argument(fmt::format("overlap is {} terms a cluster; it must be 0 or more", options.overlap));
}

std::int64_t ceil_ratio(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

/// Mean of the samples that exist among `count` on either side of a missing run.
double bridge_level(std::span<const double> rate, const Mask::Gap& run) {
  constexpr std::int64_t kFewest = 16;
  const std::int64_t reach = std::max(run.count, kFewest), end = run.first + run.count;
  const auto samples = static_cast<std::int64_t>(rate.size());
  double sum = 0, count = 0;
  const auto add = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t k = std::max<std::int64_t>(0, from); k < std::min(to, samples); ++k) {
      const double sample = rate[static_cast<std::size_t>(k)];
      if (std::isfinite(sample)) sum += sample, ++count;
    }
  };
  add(run.first - reach, run.first);
  add(end, end + reach);
  return count > 0 ? sum / count : 0;
}

std::vector<double> bridged(std::span<const double> rate, const Mask& mask) {
  std::vector<double> whole(rate.begin(), rate.end());
  for (const Mask::Gap& run : mask.runs()) {
    std::fill_n(whole.begin() + run.first, run.count, bridge_level(rate, run));
  }
  return whole;
}

/// Terms of one factor, in tiles that are worth a task.
struct Job {
  std::int64_t m, stride, terms, tile;
  [[nodiscard]] std::int64_t tiles() const { return ceil_ratio(terms, tile); }
};

Job make_job(Estimator estimator, std::int64_t samples, std::int64_t m, const EstimatorOptions& options) {
  Job job{m, stride_of(estimator, samples, m, options), 0, 0};
  job.terms = ceil_ratio(detail::family_positions(estimator, samples, m), job.stride);
  constexpr std::int64_t kStepsPerTile = 1 << 15;
  // A tile of the modified deviations has prefix sums of its own, which reach m or 3m beyond it.
  const bool has_sums = estimator == Estimator::mdev || estimator == Estimator::tdev || estimator == Estimator::pdev;
  const std::int64_t steps =
      has_sums ? std::max(kStepsPerTile, m) / job.stride : kStepsPerTile / detail::steps_per_term(estimator, m);
  job.tile = std::max<std::int64_t>(steps, detail::steps_per_term(estimator, m) > 1 ? 8 : 1);
  return job;
}

/// sum(job, first term, count) of every tile of every job, added up in the order of the tiles.
template <typename Sum>
std::vector<TermSum> sum_jobs(std::span<const Job> jobs, Sum sum) {
  std::vector<std::size_t> first_part{0};
  for (const Job& job : jobs) first_part.push_back(first_part.back() + static_cast<std::size_t>(job.tiles()));
  std::vector<TermSum> parts(first_part.back());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t part) {
    const auto at = std::upper_bound(first_part.begin(), first_part.end(), part) - first_part.begin() - 1;
    const Job& job = jobs[static_cast<std::size_t>(at)];
    const std::int64_t first = static_cast<std::int64_t>(part - first_part[static_cast<std::size_t>(at)]) * job.tile;
    parts[part] = sum(job, first, std::min(job.tile, job.terms - first));
  });
  std::vector<TermSum> totals(jobs.size());
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    detail::CompensatedSum squares;
    for (std::size_t part = first_part[i]; part < first_part[i + 1]; ++part) {
      squares.add(parts[part].squares);
      totals[i].terms += parts[part].terms;
    }
    totals[i].squares = squares.value();
  }
  return totals;
}

/// Differences of the means over what exists in two clusters.
TermSum masked_second_differences(const detail::Phase& phase, const Mask& mask, const Job& job, std::int64_t first,
                                  std::int64_t count) {
  const detail::SecondDifference& kernel = detail::second_difference();
  TermSum sum;
  for (std::int64_t i = first; i < first + count; ++i) {
    const std::int64_t k = i * job.stride;
    const auto term = kernel.masked(phase.x.get() + k, phase.missing.get() + k, 1, job.m, mask.minimum_count(job.m));
    sum.squares += term.squares;
    sum.terms += term.terms;
  }
  return sum;
}

std::vector<TermSum> sum_terms(const Series& record, Estimator estimator, std::span<const Job> jobs) {
  if (jobs.empty()) return {};
  const auto sum_family = [&](const FamilyRecord& view) {
    return sum_jobs(jobs, [&](const Job& job, std::int64_t first, std::int64_t count) {
      return family_sum(estimator, view, job.m, first * job.stride, job.stride, count);
    });
  };
  const Mask* mask = record.mask().get();
  if (mask == nullptr) return sum_family({record.phase().x.get(), nullptr, record.samples(), 1});
  if (estimator == Estimator::adev || estimator == Estimator::oadev) {
    const detail::Phase& phase = record.phase();
    auto sums = sum_jobs(jobs, [&](const Job& job, std::int64_t first, std::int64_t count) {
      return masked_second_differences(phase, *mask, job, first, count);
    });
    for (std::size_t i = 0; i < jobs.size(); ++i)  // of means, where family_scale expects sums
      sums[i].squares *= static_cast<double>(jobs[i].m) * static_cast<double>(jobs[i].m);
    return sums;
  }
  const std::vector<double> whole = bridged(record.rate(), *mask);
  const detail::Phase phase = detail::integrate(whole, {record.mean(), nullptr});
  std::vector<std::uint32_t> missing(whole.size() + 1);
  detail::count_missing(record.rate(), missing.data());
  return sum_family({phase.x.get(), missing.data(), record.samples(), mask->minimum_fill()});
}

}  // namespace

std::int64_t stride_of(Estimator estimator, std::int64_t samples, std::int64_t m, const EstimatorOptions& options) {
  const auto [basis, factor] = basis_of(estimator, samples, m);
  if (basis == Estimator::adev || basis == Estimator::hdev) return factor;
  if (options.overlap > 0) {
    const std::int64_t stride = factor / options.overlap;
    return stride < options.least_stride ? 1 : std::max<std::int64_t>(1, stride);
  }
  const std::int64_t steps = detail::steps_per_term(basis, factor);
  if (steps == 1) return 1;
  constexpr double kMostSteps = 1 << 26;
  // What costs nothing: a term of the totals averages over 6 m places itself.
  const std::int64_t least_overlap = basis == Estimator::theo1 ? 16 : 4;
  const double work =
      static_cast<double>(steps) * static_cast<double>(detail::family_positions(basis, samples, factor));
  const auto wanted = static_cast<std::int64_t>(std::ceil(work / kMostSteps));
  return std::max<std::int64_t>(1, std::min(wanted, factor / least_overlap));
}

namespace {

/// Mean of the record's own ratios of Allan to Theo1 variance at taus of 9, 12, 15 ... dt up to a tenth of it, as
/// TheoBR has it; of more than 64 ratios 16, evenly spread.
double bias_ratio(const Series& record) {
  constexpr std::int64_t kAll = 64, kSome = 16;
  const std::int64_t last = std::max<std::int64_t>(0, (record.samples() + 1) / 30 - 3);
  const std::int64_t ratios = last < kAll ? last + 1 : kSome;
  Factors of_theo1, of_allan;
  for (std::int64_t k = 0; k < ratios; ++k) {
    const std::int64_t i = ratios > 1 ? k * last / (ratios - 1) : 0;
    of_theo1.push_back(12 + 4 * i);
    of_allan.push_back(9 + 3 * i);
  }
  const EstimatorOptions thinned{.overlap = last < kAll ? 0 : 16};
  const Curve theo1 = deviation(record, Estimator::theo1, of_theo1, thinned);
  const Curve allan = deviation(record, Estimator::oadev, of_allan);
  double sum = 0, count = 0;
  for (std::size_t k = 0; k < theo1.points.size(); ++k) {
    const double ratio = allan.points[k].variance / theo1.points[k].variance;
    if (std::isfinite(ratio)) sum += ratio, ++count;
  }
  return count > 0 ? sum / count : 1;  // of a record without noise
}

/// TheoBR and TheoH, whose terms are those of others.
Curve composed(const Series& record, Estimator estimator, std::span<const std::int64_t> factors,
               const EstimatorOptions& options) {
  Curve curve{record.dt(), record.samples(), record.mean(), Form::full, {}, record.mask(), estimator};
  Factors of_theo1, of_allan;
  for (const std::int64_t m : factors) {
    const Basis basis = basis_of(estimator, record.samples(), m);
    (basis.estimator == Estimator::theo1 ? of_theo1 : of_allan).push_back(basis.m);
  }
  const Curve theo1 = deviation(record, Estimator::theo1, of_theo1, options);
  const Curve allan = deviation(record, Estimator::oadev, of_allan, options);
  const double ratio = of_theo1.empty() ? 1 : bias_ratio(record);
  std::size_t next_theo1 = 0, next_allan = 0;
  for (const std::int64_t m : factors) {
    const bool is_theo1 = basis_of(estimator, record.samples(), m).estimator == Estimator::theo1;
    Point point = is_theo1 ? theo1.points[next_theo1++] : allan.points[next_allan++];
    if (is_theo1) point.variance *= ratio;
    point.m = m;
    curve.points.push_back(point);
  }
  return curve;
}

}  // namespace

Curve deviation(const Series& record, Estimator estimator, std::span<const std::int64_t> factors,
                const EstimatorOptions& options) {
  check(estimator, record.samples(), factors, options);
  if (estimator == Estimator::theobr || estimator == Estimator::theoh)
    return composed(record, estimator, factors, options);
  if (estimator == Estimator::oadev && options.overlap == 0) return overlapped_variance(record, factors, options.form);

  Curve curve{record.dt(), record.samples(), record.mean(), Form::full, {}, record.mask(), estimator};
  std::vector<Job> jobs;
  std::vector<std::size_t> thinned;        // the points they are for
  std::vector<std::int64_t> every_sample;  // factors whose terms overlapped_variance sums many at a time
  for (const std::int64_t m : factors) {
    const Job job = make_job(estimator, record.samples(), m, options);
    if (estimator == Estimator::oadev && job.stride == 1) {
      every_sample.push_back(m);
    } else {
      thinned.push_back(curve.points.size());
      jobs.push_back(job);
    }
    curve.points.push_back({m, 0, 0, job.stride});
  }
  const std::vector<TermSum> sums = sum_terms(record, estimator, jobs);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const auto terms = static_cast<double>(sums[i].terms);
    Point& point = curve.points[thinned[i]];
    point.terms = sums[i].terms;
    point.variance = terms > 0 ? sums[i].squares / terms * detail::family_scale(estimator, point.m, record.dt())
                               : std::numeric_limits<double>::quiet_NaN();
  }
  if (every_sample.empty()) return curve;
  const Curve full = overlapped_variance(record, every_sample);
  std::size_t next = 0;
  for (Point& point : curve.points) {
    if (point.stride == 1) point = full.points[next++];
  }
  return curve;
}

Curve deviation(std::span<const double> rate, double dt, Estimator estimator, std::span<const std::int64_t> factors,
                const EstimatorOptions& options) {
  return deviation(Series(rate, dt), estimator, factors, options);
}

std::vector<double> rates_of_angles(std::span<const double> angles, double dt) {
  std::vector<double> rates;
  rates.reserve(angles.size());
  for (std::size_t k = 1; k < angles.size(); ++k) rates.push_back((angles[k] - angles[k - 1]) / dt);
  return rates;
}

std::vector<double> rates_of_increments(std::span<const double> increments, double dt) {
  std::vector<double> rates(increments.begin(), increments.end());
  for (double& rate : rates) rate /= dt;
  return rates;
}

}  // namespace gyrobudget::inline v0::allan

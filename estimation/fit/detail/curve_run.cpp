// SPDX-License-Identifier: MIT
#include "curve_run.h"

#include <boost/math/quadrature/gauss.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "judge.h"
#include "weighted.h"
#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr std::int64_t kTestedClusters = 16;  // goodness of fit over n/m >= 16: beyond, s is too skewed for chi-square
constexpr double kFirstTauCut = 6.63;         // 1 % cut of chi-square with 1 degree of freedom
constexpr int kSparePoints = 2;               // a start must leave this many tested taus more than terms
constexpr double kMemoryCut = 15.14;  // 1e-4 cut of chi-square with 1 degree of freedom: a filter may be looked for

// d AVAR/d ln bandwidth of filtered white noise of N = 1, with what gaps do to it.
Eigen::VectorXd bandwidth_slope(const Prepared& p, const noise::FrontEnd& front_end) {
  constexpr double kStep = 1e-3;
  const auto variance = [&](std::int64_t m, double x) {
    noise::FrontEnd moved = front_end;
    moved.bandwidth *= std::exp(x);
    return noise::allan_variance(noise::FilteredWhite{1, moved}, m, p.dt);
  };
  const auto white = std::find(p.terms.begin(), p.terms.end(), Term::white) - p.terms.begin();
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(p.m.size()));
  if (white == static_cast<std::ptrdiff_t>(p.terms.size())) return slope;
  for (std::size_t i = 0; i < p.m.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double gaps = p.covariance->expectation()(row, white) / variance(p.m[i], 0);
    slope(row) = gaps * (variance(p.m[i], kStep) - variance(p.m[i], -kStep)) / (2 * kStep);
  }
  return slope;
}

// What a front end takes off the Allan variance of a process of coefficient 1: the integral over frequencies of the
// part of its density that is stopped, by ten-point Gauss-Legendre panels that shrink towards 0 and hold a third of a
// period.
double stopped_variance(const noise::Process& process, const noise::SampledFrontEnd& filter, std::int64_t m,
                        double dt) {
  const auto clusters = static_cast<double>(m);
  const auto integrand = [&](double u) {
    const double gain = 4 * std::pow(std::sin(std::numbers::pi * clusters * u), 4) /
                        std::pow(clusters * std::sin(std::numbers::pi * u), 2);
    return noise::psd(process, u / dt, dt) * (1 - filter.power_gain(u)) * gain / dt;
  };
  constexpr double kLowest = 1e-6;  // of the rate: what is stopped below adds nothing
  double sum = 0;
  for (double lower = kLowest; lower < 0.5;) {
    const double upper = std::min({2 * lower, lower + 1 / (3 * clusters), 0.5});
    sum += boost::math::quadrature::gauss<double, 10>::integrate(integrand, lower, upper);
    lower = upper;
  }
  return sum;
}

// Slow processes pass a front end but for their quick part, which short taus behind a deep stop band would show.
void stop_slow_processes(const Prepared& p, const noise::FrontEnd& front_end, Eigen::MatrixXd& expectation) {
  constexpr double kFaded = 8;  // over bandwidth * tau: at longer taus nothing is missed
  const noise::SampledFrontEnd filter(front_end, p.dt);
  for (std::size_t i = 0; i < p.m.size(); ++i) {
    if (static_cast<double>(p.m[i]) * p.dt * front_end.bandwidth > kFaded) return;
    for (std::size_t j = 0; j < p.terms.size(); ++j) {
      if (p.terms[j] != Term::flicker && p.terms[j] != Term::rate_random_walk) continue;
      expectation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) -=
          stopped_variance(p.covariance->processes()[j], filter, p.m[i], p.dt);
    }
  }
}

Eigen::MatrixXd free_column(const Prepared& p, Eigen::Index first, Free free) {
  const Eigen::Index count = p.s.size() - first;
  if (free == Free::nothing) return {count, 0};
  if (free == Free::bandwidth) return p.bandwidth_slope.tail(count);
  Eigen::VectorXd memory(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto m = static_cast<double>(p.m[static_cast<std::size_t>(first + i)]);
    memory(i) = -1.5 / (m * m * p.dt);
  }
  return memory;
}

}  // namespace

Eigen::Index Prepared::tested_until() const {
  return std::partition_point(m.begin(), m.end(), [&](auto x) { return x * kTestedClusters <= samples; }) - m.begin();
}

Free free_of(const Options& options) {
  if (options.front_end) return options.fit_bandwidth ? Free::bandwidth : Free::nothing;
  return options.unknown_front_end ? Free::memory : Free::nothing;
}

Prepared prepare(const allan::Curve& curve, const allan::CurveCovariance& covariance, const Options& options) {
  Prepared p;
  p.terms = in_order(options.terms);
  p.dt = curve.dt;
  p.samples = curve.samples;
  if (covariance.factors().size() != curve.points.size()) {
    throw std::invalid_argument(fmt::format("the covariance has {} factors, the curve {} points",
                                            covariance.factors().size(), curve.points.size()));
  }
  for (const Term t : p.terms) {
    const auto& have = covariance.processes();
    const auto at = std::find_if(have.begin(), have.end(), [&](const auto& x) { return noise::term(x) == t; });
    if (at == have.end()) {
      throw std::invalid_argument(fmt::format("the covariance lacks term {}", static_cast<char>(t)));
    }
    p.columns.push_back(static_cast<std::size_t>(at - have.begin()));
  }
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const auto& point = curve.points[i];
    if (point.m != covariance.factors()[i]) {
      throw std::invalid_argument(
          fmt::format("the covariance is of factor {} where the curve has {}", covariance.factors()[i], point.m));
    }
    const bool late = options.tau_max_s && curve.tau(i) > *options.tau_max_s * (1 + 1e-9);
    if (point.terms < 1 || !std::isfinite(point.variance) || late) continue;
    p.rows.push_back(i);
    p.m.push_back(point.m);
  }
  if (p.rows.size() <= p.terms.size()) {
    throw std::invalid_argument(fmt::format("{} taus are too few to fit {} terms; at least {} are needed",
                                            p.rows.size(), p.terms.size(), p.terms.size() + 1));
  }
  p.s.resize(static_cast<Eigen::Index>(p.rows.size()));
  for (std::size_t i = 0; i < p.rows.size(); ++i) p.s(static_cast<Eigen::Index>(i)) = curve.points[p.rows[i]].variance;
  if (p.s.maxCoeff() > 0) p.scale = std::exp2(std::floor(std::log2(p.s.maxCoeff())));
  p.s /= p.scale;
  p.covariance = covariance.subset(p.rows, p.columns);
  p.expectation = p.covariance->expectation();
  if (options.front_end) stop_slow_processes(p, *options.front_end, p.expectation);
  if (free_of(options) == Free::bandwidth) p.bandwidth_slope = bandwidth_slope(p, *options.front_end);
  return p;
}

LinearModel linear_model(const Prepared& p, Eigen::Index first, std::span<const std::size_t> columns, Free free) {
  std::vector<std::size_t> rows(p.rows.size() - static_cast<std::size_t>(first));
  std::iota(rows.begin(), rows.end(), static_cast<std::size_t>(first));
  auto covariance = std::make_shared<allan::CurveCovariance>(p.covariance->subset(rows, columns));
  LinearModel model;
  model.A.resize(p.s.size() - first, static_cast<Eigen::Index>(columns.size()));
  for (std::size_t j = 0; j < columns.size(); ++j)
    model.A.col(static_cast<Eigen::Index>(j)) =
        p.expectation.col(static_cast<Eigen::Index>(columns[j])).tail(model.A.rows());
  model.D = free_column(p, first, free);
  model.s = p.s.tail(p.s.size() - first);
  model.covariance = [covariance](const Eigen::VectorXd& theta) { return (*covariance)(theta); };
  return model;
}

void test_fit(const Prepared& p, TestedFit& run) {
  const Eigen::Index count = p.tested_until() - run.first;
  run.dof = static_cast<int>(count - (run.solution.theta.array() > 0).count() - run.model.D.cols());
  if (run.dof < 1 || run.solution.S.size() == 0) return;
  Eigen::VectorXd r = run.model.s - run.model.A * run.solution.theta;
  run.gamma = free_part(run.model, run.solution.theta, run.solution.S);
  if (run.gamma.size() > 0) r -= run.model.D * run.gamma;
  r.conservativeResize(count);
  const Eigen::LLT<Eigen::MatrixXd> factor(run.solution.S.topLeftCorner(count, count));
  if (factor.info() != Eigen::Success) return;
  run.chi2 = factor.matrixL().solve(r).squaredNorm();
  run.p_value = chi_square_tail(run.chi2, run.dof);
}

namespace {

void solve(TestedFit& run, Method method) {
  if (method == Method::gls) {
    run.solution = iterate_gls(run.model);
    return;
  }
  WeightedSolution weighted = method == Method::edf ? weigh_by_variance(run.model) : fit_logarithms(run.model);
  run.solution = std::move(weighted.solution);
  run.covariance = std::move(weighted.covariance);
}

}  // namespace

TestedFit fit_from(const Prepared& p, Eigen::Index first, bool drop_quantization, Free free, Method method) {
  TestedFit run;
  run.first = first;
  run.free = method == Method::gls ? free : Free::nothing;
  std::vector<std::size_t> columns;
  for (std::size_t j = 0; j < p.terms.size(); ++j) {
    if (drop_quantization && p.terms[j] == Term::quantization) continue;
    run.terms.push_back(p.terms[j]);
    columns.push_back(j);
  }
  if (columns.empty()) return run;
  run.model = linear_model(p, first, columns, run.free);
  solve(run, method);
  test_fit(p, run);
  return run;
}

namespace {

// The first tau asked for.
TestedFit run_from_tau(const Prepared& p, double tau_min_s, Free free, Method method) {
  const auto first = std::partition_point(
      p.m.begin(), p.m.end(), [&](auto m) { return static_cast<double>(m) * p.dt < tau_min_s * (1 - 1e-9); });
  if (p.m.end() - first <= static_cast<std::ptrdiff_t>(p.terms.size())) {
    throw std::invalid_argument(fmt::format("only {} taus from {} s on: too few to fit {} terms", p.m.end() - first,
                                            tau_min_s, p.terms.size()));
  }
  return fit_from(p, first - p.m.begin(), free != Free::nothing, free, method);
}

// The run that the model describes with a front end beside it: the one that was found or given, or the memory of an
// unknown one. (Short taus may deny a front end that stands: behind a deep stop band they hold what it lets through.)
// Its first tau is one octave behind the first that passes: the p-value reaches the limit and fitting without that tau
// does not lower chi-square by more than chance. What a test cannot see is as large as an interval, so a start where
// the test happens to pass would bias N by that much. Quantization is strongest at the first tau: a run that must cut
// that tau cannot hold it.
std::optional<TestedFit> described_run(const Prepared& p, Free free, const Options& options) {
  const Eigen::Index tested = p.tested_until();
  const auto fewest = static_cast<Eigen::Index>(p.terms.size()) + kSparePoints;
  std::vector<TestedFit> runs;
  for (Eigen::Index first = 1; first <= tested / 2 + 1 && tested - first >= fewest; ++first) {
    runs.push_back(fit_from(p, first, true, free));
    if (runs.back().terms.empty()) return {};
  }
  // One true model in a hundred misses the limit at any start: it is then held to what the whole curve is held to.
  for (const double limit : {options.p_value_limit, kCutBelow}) {
    for (std::size_t i = 0; i < runs.size() && runs[i].first <= tested / 2; ++i) {
      const bool last = i + 1 == runs.size();
      const bool belongs = last || runs[i].chi2 - runs[i + 1].chi2 < kFirstTauCut;
      if (!belongs || runs[i].p_value < limit) continue;
      return last || runs[i + 1].p_value < limit ? runs[i] : runs[i + 1];
    }
  }
  return {};
}

// How much better the whole curve is explained with a filter's memory: T of one more column, with one covariance.
// Zero where it would be that of a filter that amplifies.
double memory_test(const Prepared& p, const TestedFit& whole) {
  if (whole.solution.S.size() == 0) return 0;
  LinearModel with = whole.model;
  with.D = free_column(p, whole.first, Free::memory);
  const Whitened without = whiten(whole.model, whole.solution.S), beside = whiten(with, whole.solution.S);
  const Eigen::VectorXd best = nonnegative_least_squares(beside.A, beside.s);
  if (!(free_part(with, best, whole.solution.S)(0) > 0)) return 0;
  return (without.s - without.A * whole.solution.theta).squaredNorm() - (beside.s - beside.A * best).squaredNorm();
}

}  // namespace

TestedFit choose_run(const Prepared& p, const Options& options) {
  const Free free = free_of(options);
  if (options.tau_min_s) return run_from_tau(p, *options.tau_min_s, free, options.method);
  TestedFit whole = fit_from(p, 0, options.front_end.has_value(), free, options.method);
  if (whole.p_value >= kCutBelow || options.method != Method::gls) return whole;
  return described_run(p, options.front_end ? free : Free::memory, options).value_or(std::move(whole));
}

bool may_be_filtered(const allan::Curve& curve, const allan::CurveCovariance& covariance, const Options& options) {
  const Prepared p = prepare(curve, covariance, options);
  if (p.s.maxCoeff() <= 0) return false;
  const TestedFit whole = fit_from(p, 0, false, Free::nothing);
  return whole.p_value < kCutBelow || memory_test(p, whole) > kMemoryCut;
}

}  // namespace gyrobudget::inline v0::fit

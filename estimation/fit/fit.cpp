// SPDX-License-Identifier: MIT
#include "fit.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/estimation/fit/detail/gls.h"
#include "gyrobudget/estimation/fit/detail/judge.h"
#include "gyrobudget/estimation/fit/detail/refine.h"
#include "gyrobudget/estimation/fit/detail/weighted.h"

#include <boost/math/quadrature/gauss.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

#include "visual.h"
#include "whittle.h"
#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kTestedClusters = 16;  // goodness of fit over n/m >= 16: beyond, s is too skewed for chi-square
constexpr double kScatter95 = 1.96;
constexpr double kNegligible = 0.01;   // of the deviation
constexpr double kCutBelow = 1e-4;     // p-value of the whole curve below which short taus may be cut
constexpr double kFirstTauCut = 6.63;  // 1 % cut of chi-square with 1 degree of freedom
constexpr int kSparePoints = 2;        // a start must leave this many tested taus more than terms
constexpr double kMemoryCut = 15.14;   // 1e-4 cut of chi-square with 1 degree of freedom: a filter may be looked for

// What a front end adds to the terms, as a column of the linear model that may have any sign.
enum class Free {
  nothing,
  memory,     // all that any filter leaves beyond its memory: -3/2 S1/S0 N^2/dt/m^2
  bandwidth,  // N^2 d AVAR/d ln bandwidth of Options::front_end
};

Free free_of(const Options& options) {
  if (options.front_end) return options.fit_bandwidth ? Free::bandwidth : Free::nothing;
  return options.unknown_front_end ? Free::memory : Free::nothing;
}

// A curve ready to fit: points with terms, terms in the order Q N B K R, variances scaled by a power of two so that
// neither unit nor size of the signal matters.
struct Prepared {
  std::vector<std::size_t> rows;     // of the curve
  std::vector<std::size_t> columns;  // of the covariance's processes
  std::vector<Term> terms;
  std::vector<std::int64_t> m;
  double dt = 1;
  std::int64_t samples = 0;
  double scale = 1;                                  // variance = scaled * scale
  Eigen::VectorXd s;                                 // scaled
  Eigen::VectorXd bandwidth_slope;                   // of white noise of N = 1, where Options::front_end is fitted
  std::optional<allan::CurveCovariance> covariance;  // of rows x columns
  Eigen::MatrixXd expectation;                       // likewise; behind the front end

  [[nodiscard]] Eigen::Index tested_until() const {  // rows with n/m >= 16 come first
    return std::partition_point(m.begin(), m.end(), [&](auto x) { return x * kTestedClusters <= samples; }) - m.begin();
  }
};

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

// The rows [first, end) and columns of a prepared curve as a linear model.
struct TestedFit {
  Eigen::Index first = 0;
  std::vector<Term> terms;
  LinearModel model;
  Free free = Free::nothing;
  GlsSolution solution;
  Eigen::VectorXd gamma;       // of the model's free column
  Eigen::MatrixXd covariance;  // of theta, where the method has its own
  double chi2 = 0;
  int dof = 0;
  double p_value = 0;
};

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

// Goodness of fit over the rows of the run with n/m >= 16.
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

void solve(TestedFit& run, Method method) {
  if (method == Method::gls) {
    run.solution = iterate_gls(run.model);
    return;
  }
  WeightedSolution weighted = method == Method::edf ? weigh_by_variance(run.model) : fit_logarithms(run.model);
  run.solution = std::move(weighted.solution);
  run.covariance = std::move(weighted.covariance);
}

TestedFit fit_from(const Prepared& p, Eigen::Index first, bool drop_quantization, Free free,
                   Method method = Method::gls) {
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

TestedFit choose_run(const Prepared& p, const Options& options) {
  const Free free = free_of(options);
  if (options.tau_min_s) return run_from_tau(p, *options.tau_min_s, free, options.method);
  TestedFit whole = fit_from(p, 0, options.front_end.has_value(), free, options.method);
  if (whole.p_value >= kCutBelow || options.method != Method::gls) return whole;
  return described_run(p, options.front_end ? free : Free::memory, options).value_or(std::move(whole));
}

Eigen::VectorXd standard_deviations(const TestedFit& run) {
  if (run.covariance.size() > 0) return run.covariance.diagonal().cwiseSqrt();
  const Eigen::MatrixXd WA = whiten(run.model, run.solution.S).A;
  const Eigen::VectorXd length = WA.colwise().norm();
  const Eigen::MatrixXd unit = WA * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse =
      (unit.transpose() * unit).llt().solve(Eigen::MatrixXd::Identity(WA.cols(), WA.cols()));
  return inverse.diagonal().cwiseSqrt().cwiseQuotient(length);
}

Eigen::ArrayX<Eigen::Index> above_zero(const Eigen::VectorXd& theta) {
  Eigen::ArrayX<Eigen::Index> free((theta.array() > 0).count());
  for (Eigen::Index j = 0, i = 0; j < theta.size(); ++j) {
    if (theta(j) > 0) free(i++) = j;
  }
  return free;
}

// Ceres' step over the coefficients above zero; updates the solution and its test, and fills the result's covariance.
void refine_run(const Prepared& p, TestedFit& run, Result& result) {
  const auto free = above_zero(run.solution.theta);
  const Whitened whitened = whiten(run.model, run.solution.S);
  const WhitenedResidual residual(whitened.A(Eigen::all, free), whitened.s);
  const Refined refined = refine(residual, run.solution.theta(free).cwiseSqrt());
  run.solution.theta(free) = refined.coefficients.cwiseAbs2();
  test_fit(p, run);
  result.covariance(free, free) = refined.covariance * p.scale;
  result.iterations += refined.iterations;
  result.converged = refined.converged;
}

// Covariance of the coefficients c from that of theta = c^2.
void spread_covariance(const Prepared& p, const TestedFit& run, Result& result) {
  const auto free = above_zero(run.solution.theta);
  const Eigen::VectorXd slope = 0.5 * run.solution.theta(free).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd of_theta = run.covariance(free, free);
  result.covariance(free, free) = slope.asDiagonal() * of_theta * slope.asDiagonal() * p.scale;
}

void finish(const Prepared& p, TestedFit& run, Result& result) {
  const Eigen::Index size = run.solution.theta.size();
  result.covariance = Eigen::MatrixXd::Constant(size, size, kNaN);
  result.iterations = run.solution.iterations;
  result.converged = run.solution.converged;
  if (!run.solution.converged || run.solution.theta.maxCoeff() <= 0) return;
  if (run.covariance.size() > 0) {
    spread_covariance(p, run, result);
  } else {
    refine_run(p, run, result);
  }
}

// Zero, and even its limit adds less than 1 % to the deviation anywhere.
bool negligible(const TestedFit& run, Eigen::Index j, double upper_theta) {
  if (run.solution.theta(j) > 0) return false;
  const Eigen::ArrayXd model = run.model.A * run.solution.theta;
  const Eigen::ArrayXd added = run.model.A.col(j).array() * upper_theta;
  return ((1 + added / model.max(1e-300)).sqrt() - 1 < kNegligible).all();
}

HeldTest held_test(const TestedFit& run, Eigen::Index j, double deviation) {
  if (run.covariance.size() == 0)
    return [&run, j](double v) { return profile_test(run.model, {j, v}, run.solution.theta); };
  const double theta = run.solution.theta(j);
  return [=](double v) { return std::pow((v - theta) / deviation, 2); };
}

void add_coefficients(Result& result, const TestedFit& run, double scale, const Options& options) {
  const Cuts cuts = cuts_of(run.p_value, run.chi2, run.dof, options);
  const bool settled = run.solution.converged && (run.solution.S.size() > 0 || run.covariance.size() > 0);
  const Eigen::VectorXd deviation = settled ? standard_deviations(run) : Eigen::VectorXd();
  for (std::size_t i = 0; i < run.terms.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const double theta = run.solution.theta(j);
    Coefficient c = settled ? judge(run.terms[i], theta, deviation(j), scale, cuts, held_test(run, j, deviation(j)),
                                    options.intervals)
                            : without_answer(run.terms[i], theta, scale);
    if (settled && options.intervals && negligible(run, j, c.upper * (c.upper / scale))) c.status = Status::left_out;
    const noise::Process process = shaped_process(c.term, options);
    if (const auto* g = std::get_if<noise::GaussMarkov>(&process)) c.shape = g->correlation_time;
    if (const auto* line = std::get_if<noise::Sinusoid>(&process)) c.shape = line->frequency;
    c.shape_lower = c.shape_upper = c.shape;
    result.coefficients.push_back(c);
  }
  for (const Term t : options.terms) {  // quantization that a cut run could not hold; G, S are listed when asked for
    const bool listed =
        std::any_of(result.coefficients.begin(), result.coefficients.end(), [=](const auto& c) { return c.term == t; });
    if (!listed) result.coefficients.push_back({.term = t});
  }
  complete(result.coefficients);
}

// Every tau of the curve beside the model, the cut ones too.
void add_residuals(Result& result, const Prepared& p, const TestedFit& run, const allan::Curve& curve) {
  std::vector<std::size_t> columns;
  for (const Term t : run.terms) {
    columns.push_back(static_cast<std::size_t>(std::find(p.terms.begin(), p.terms.end(), t) - p.terms.begin()));
  }
  const LinearModel all = linear_model(p, 0, columns, run.free);
  Eigen::VectorXd model = all.A * run.solution.theta;
  // Shorter taus, where a filter's memory is not all there is of it, have what the terms alone would give.
  const Eigen::Index used = model.size() - run.first;
  if (run.gamma.size() > 0) model.tail(used) += all.D.bottomRows(used) * run.gamma;
  const Eigen::MatrixXd S = all.covariance(run.solution.theta);
  for (std::size_t i = 0; i < p.rows.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    Residual r;
    r.m = p.m[i];
    r.tau_s = curve.tau(p.rows[i]);
    r.measured = std::sqrt(p.s(row) * p.scale);
    r.model = std::sqrt(model(row) * p.scale);
    // A model of nothing has no scatter, and misses whatever was measured without limit.
    r.relative_std = r.model > 0 ? 0.5 * std::sqrt(S(row, row)) / model(row) : 0;
    r.misfit = r.model > 0 ? r.measured / r.model - 1 : r.measured > 0 ? kInfinity : 0;
    r.used = row >= run.first;
    result.residuals.push_back(r);
  }
}

void judge_fit(Result& result, const Prepared& p, const TestedFit& run, const Options& options) {
  result.chi2 = run.chi2;
  result.dof = run.dof;
  result.p_value = run.p_value;
  for (Eigen::Index i = run.first; i < p.tested_until(); ++i) {
    const Residual& r = result.residuals[static_cast<std::size_t>(i)];
    const double beyond = std::abs(r.misfit) - kScatter95 * r.relative_std;
    if (beyond > result.worst_misfit) result.worst_misfit = beyond, result.worst_misfit_tau_s = r.tau_s;
  }
  result.verdict = verdict_of(result, options);
}

void add_moves(Result& result, const Prepared& p, const TestedFit& run) {
  if (run.first == 0 || run.free != Free::memory) return;
  const TestedFit whole = fit_from(p, 0, false, Free::nothing);
  for (std::size_t j = 0; j < whole.terms.size(); ++j) {
    const double from = std::sqrt(whole.solution.theta(static_cast<Eigen::Index>(j)) * p.scale);
    const Coefficient& now = result[whole.terms[j]];
    result.moved.push_back({whole.terms[j], from, now.fitted ? now.value : 0});
  }
}

// What the free column says of the filter: its bandwidth, or of which bandwidth it may be where only its memory
// T = S1/(S0 fs) is seen. The product fc T is 0.159 of the first order, 0.148 of a moving average, 0.113 and 0.104 of
// Butterworth's second and fourth.
void add_front_end(Result& result, const Prepared& p, const TestedFit& run, const Options& options) {
  constexpr double kUsual = 0.13, kLeast = 0.104, kMost = 0.159;
  if (options.front_end) {
    const noise::FrontEnd& f = *options.front_end;
    result.front_end = {
        f.kind, f.bandwidth, f.bandwidth, f.bandwidth, f.sampling, f.floor, run.free == Free::bandwidth};
  }
  const auto white = std::find(run.terms.begin(), run.terms.end(), Term::white) - run.terms.begin();
  if (run.gamma.size() == 0 || white == static_cast<std::ptrdiff_t>(run.terms.size())) return;
  const double theta = run.solution.theta(white);
  if (!(theta > 0)) return;
  LinearModel turned = run.model;  // the column's own scatter, the coefficients free
  turned.A = run.model.D, turned.D = run.model.A;
  const double deviation = 1 / whiten(turned, run.solution.S).A.norm() / theta, value = run.gamma(0) / theta;
  if (run.free == Free::bandwidth) {
    FittedFrontEnd& f = *result.front_end;
    f.bandwidth = noise::in_range(f.bandwidth * std::exp(value), p.dt);
    f.lower = f.bandwidth * std::exp(-kScatter95 * deviation);
    f.upper = f.bandwidth * std::exp(kScatter95 * deviation);
  } else if (value > kScatter95 * deviation) {
    const double shortest = (value - kScatter95 * deviation) * p.dt, longest = (value + kScatter95 * deviation) * p.dt;
    // A memory beyond the first tau of the run is none that the term could stand for.
    if (!(value < static_cast<double>(p.m[static_cast<std::size_t>(run.first)]))) return;
    result.front_end = {{}, kUsual / (value * p.dt), kLeast / longest, kMost / shortest, {}, 0, true};
  }
}

void add_curve_facts(Result& result, const allan::Curve& curve) {
  double least = kInfinity;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const auto& point = curve.points[i];
    const bool short_enough = point.m * 10 <= curve.samples || i == 0;
    if (point.terms > 0 && short_enough && point.variance < least) {
      least = point.variance;
      result.minimum_deviation = std::sqrt(least);
      result.minimum_tau_s = curve.tau(i);
    }
  }
}

// Nothing varies: no model is needed. Not an error, but no answer either.
Result silent_record(const Prepared& p, const allan::Curve& curve, Method method) {
  Result result = no_answer(method, p.terms);
  result.tau_min_s = curve.tau(p.rows.front());
  result.tau_max_s = curve.tau(p.rows.back());
  return result;
}

// Whether a front end may stand before the samples: the terms do not describe every tau, or a filter's memory beside
// them explains the curve better than chance would in one record of ten thousand.
bool may_be_filtered(const allan::Curve& curve, const allan::CurveCovariance& covariance, const Options& options) {
  const Prepared p = prepare(curve, covariance, options);
  if (p.s.maxCoeff() <= 0) return false;
  const TestedFit whole = fit_from(p, 0, false, Free::nothing);
  return whole.p_value < kCutBelow || memory_test(p, whole) > kMemoryCut;
}

void require_shapes(const Options& options) {
  for (const Term t : options.terms) {
    if (t == Term::gauss_markov && !options.correlation_time_s)
      throw std::invalid_argument("a curve's fit of term G needs its correlation time");
    if (t == Term::sinusoid && !options.frequency_hz)
      throw std::invalid_argument("a curve's fit of term S needs its frequency");
  }
}

// A ramp and a line are means: by themselves they have no scatter to weigh a curve with.
void require_scatter(const Options& options) {
  if (options.method != Method::gls && options.method != Method::edf) return;
  const bool none = std::all_of(options.terms.begin(), options.terms.end(),
                                [](Term t) { return t == Term::rate_ramp || t == Term::sinusoid; });
  if (none && !options.terms.empty())
    throw std::invalid_argument("a ramp or a line alone has no scatter to fit with: add a random term, such as N");
}

allan::CurveCovariance covariance_of(const allan::Curve& curve, const Options& options) {
  std::vector<std::int64_t> factors;
  for (const auto& point : curve.points) factors.push_back(point.m);
  std::vector<noise::Process> processes;
  for (const Term t : in_order(options.terms)) processes.push_back(shaped_process(t, options));
  return {curve.samples, std::move(factors), curve.dt, std::move(processes), curve.form, curve.mask.get()};
}

}  // namespace

const Coefficient& Result::operator[](Term t) const {
  const auto at = std::find_if(coefficients.begin(), coefficients.end(), [&](const auto& c) { return c.term == t; });
  if (at == coefficients.end())
    throw std::invalid_argument(fmt::format("term {} is no coefficient of this fit", static_cast<char>(t)));
  return *at;
}

std::vector<noise::Process> Result::processes() const {
  std::vector<noise::Process> list;
  for (const auto& c : coefficients) {
    if (!c.fitted || !(c.value > 0)) continue;
    Options shape;
    shape.correlation_time_s = shape.frequency_hz = c.shape;
    if (front_end && front_end->kind) shape.front_end = front_end->value();
    list.push_back(noise::with_coefficient(shaped_process(c.term, shape), c.value));
  }
  return list;
}

noise::FrontEnd FittedFrontEnd::value() const {
  if (!kind) throw std::logic_error("a front end of unknown kind has no value");
  return {*kind, bandwidth, sampling, floor};
}

std::string_view name(Method method) {
  switch (method) {
    case Method::gls:
      return "gls";
    case Method::edf:
      return "edf";
    case Method::loglog:
      return "loglog";
    case Method::slope:
      return "slope";
    case Method::visual:
      return "visual";
    case Method::whittle:
      return "whittle";
  }
  throw std::invalid_argument("a value that is no Method");
}

Result fit(const allan::Curve& curve, const allan::CurveCovariance& covariance, const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  if (options.method == Method::whittle)
    throw std::invalid_argument("the likelihood needs the samples, a curve does not hold them");
  require_shapes(options);
  require_scatter(options);
  const Prepared p = prepare(curve, covariance, options);
  if (p.s.maxCoeff() <= 0) return silent_record(p, curve, options.method);
  if (options.method == Method::visual) return read_visually(curve, options);
  if (options.method == Method::slope) return read_slopes(curve, options);

  TestedFit run = choose_run(p, options);
  Result result;
  result.method = options.method;
  result.fitted_terms = run.terms;
  finish(p, run, result);
  add_coefficients(result, run, p.scale, options);
  result.tau_min_s = static_cast<double>(p.m[static_cast<std::size_t>(run.first)]) * p.dt;
  result.tau_max_s = static_cast<double>(p.m.back()) * p.dt;
  add_residuals(result, p, run, curve);
  judge_fit(result, p, run, options);
  if (options.method == Method::gls) add_moves(result, p, run);
  add_front_end(result, p, run, options);
  add_curve_facts(result, curve);
  add_beta(result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

Result fit(const allan::Curve& curve, const Options& options) {
  require_shapes(options);
  return fit(curve, covariance_of(curve, options), options);
}

namespace {

// Exponent of two that brings the record's variation to 1 where its squares would leave double; else 0.
int extreme_exponent(std::span<const double> rate) {
  double low = kInfinity, high = -kInfinity;
  for (const double y : rate) {
    if (std::isfinite(y)) low = std::min(low, y), high = std::max(high, y);
  }
  const double range = 0.5 * high - 0.5 * low;
  constexpr double kSafe = 1e120;
  const bool extreme = range > 0 && (range > kSafe || range < 1 / kSafe);
  return extreme ? std::ilogb(range) : 0;
}

Result fit_scaled(const Data& record, const Options& options, int exponent) {
  std::vector<double> scaled(record.rate.begin(), record.rate.end());
  for (double& y : scaled) y = std::ldexp(y, -exponent);
  Result result = fit(Data{.rate = scaled, .dt = record.dt, .covariance = record.covariance}, options);
  rescale(result, std::ldexp(1.0, exponent));
  return result;
}

bool is_open(Term t, const Options& options) {
  return (t == Term::gauss_markov && !options.correlation_time_s) || (t == Term::sinusoid && !options.frequency_hz);
}

// The likelihood's correlation time and frequency, where the options leave them open; a term for which it has none
// cannot be fitted to the curve either, and leaves the options.
std::vector<Coefficient> take_shapes(const Data& record, Options& options) {
  std::vector<Coefficient> shaped;
  if (std::none_of(options.terms.begin(), options.terms.end(), [&](Term t) { return is_open(t, options); }))
    return shaped;
  Options search = options;
  // What was seen before may lie where a fit of its own choice would cut the band.
  if ((options.near_correlation_time_s || options.near_frequency_hz) && !search.tau_min_s) search.tau_min_s = record.dt;
  const Result found = fit_likelihood(record.rate, record.dt, search);
  for (const auto& c : found.coefficients) {
    if (is_open(c.term, options)) shaped.push_back(c);
  }
  for (const auto& c : shaped) {
    if (!c.fitted || !(c.shape > 0))  // too few samples to place it in
      std::erase(options.terms, c.term);
    else if (c.term == Term::gauss_markov)
      options.correlation_time_s = c.shape;
    else
      options.frequency_hz = c.shape;
  }
  return shaped;
}

// The limits of the shapes that the likelihood gave, and the terms that it could not place.
void give_shapes(Result& result, const std::vector<Coefficient>& shaped) {
  for (const auto& s : shaped) {
    const auto at = std::find_if(result.coefficients.begin(), result.coefficients.end(),
                                 [&](const auto& c) { return c.term == s.term; });
    if (at == result.coefficients.end())
      result.coefficients.push_back({.term = s.term});
    else
      at->shape_lower = s.shape_lower, at->shape_upper = s.shape_upper;
  }
}

bool looks_for_front_end(const Data& record, const Options& options) {
  return options.method == Method::gls && !record.rate.empty() && !options.tau_min_s &&
         (options.find_front_end || options.front_end_kind) && (!options.front_end || options.fit_bandwidth);
}

// The bandwidth enters the curve's model by its slope: fitted again from where that led, until it leads nowhere. No
// result where it leads far away: then the curve is not that of such a filter.
std::optional<Result> fit_bandwidth(const allan::Curve& curve, Options options) {
  constexpr int kMostRounds = 6;
  constexpr double kSettled = 0.1;  // of a standard deviation of its logarithm
  constexpr double kFar = 0.7;      // change of its logarithm in all
  const double start = options.front_end->bandwidth;
  Result result = fit(curve, options);
  for (int i = 0; i < kMostRounds && result.front_end && result.front_end->kind; ++i) {
    const FittedFrontEnd& f = *result.front_end;
    const double deviation = std::log(f.upper / f.lower) / (2 * kScatter95);
    if (!(std::abs(std::log(f.bandwidth / start)) < kFar) || !std::isfinite(deviation)) return {};
    if (!(std::abs(std::log(f.bandwidth / options.front_end->bandwidth)) > kSettled * deviation)) break;
    options.front_end->bandwidth = f.bandwidth;
    result = fit(curve, options);
  }
  return result;
}

// The fit behind a front end, where the curve's short taus ask for one and the likelihood finds one that describes
// them: it sees single frequencies, where a curve has octaves only.
std::optional<Result> behind_front_end(const Data& record, const allan::Curve& curve,
                                       const allan::CurveCovariance& covariance, Options options) {
  if (!looks_for_front_end(record, options)) return {};
  if (!options.front_end) {
    if (!options.front_end_kind && !may_be_filtered(curve, covariance, options)) return {};
    options.front_end = find_front_end(record.rate, record.dt, options);
    if (!options.front_end) return {};
    options.fit_bandwidth = true;
  }
  std::optional<Result> result = fit_bandwidth(curve, options);
  if (!result || !result->front_end || result->p_value < kCutBelow) return {};
  return result;
}

}  // namespace

Result fit(const Data& record, const Options& asked) {
  if (record.rate.empty() && !record.curve) throw std::invalid_argument("a fit needs samples or their curve");
  if (const int exponent = record.curve ? 0 : extreme_exponent(record.rate)) return fit_scaled(record, asked, exponent);
  if (asked.method == Method::whittle) return fit_likelihood(record.rate, record.dt, asked);
  Options options = asked;
  const auto shaped = take_shapes(record, options);
  if (options.terms.empty()) return no_answer(asked.method, asked.terms);
  allan::Curve made;
  if (!record.curve) {
    const auto factors = allan::octave_factors(static_cast<std::int64_t>(record.rate.size()));
    made = allan::overlapped_variance(record.rate, record.dt, factors);
  }
  const allan::Curve& curve = record.curve ? *record.curve : made;
  const bool usable = record.covariance && !options.front_end;
  std::optional<allan::CurveCovariance> own;
  if (!usable) own = covariance_of(curve, options);
  const allan::CurveCovariance& covariance = usable ? *record.covariance : *own;
  std::optional<Result> filtered = behind_front_end(record, curve, covariance, options);
  Result result = filtered ? std::move(*filtered) : fit(curve, covariance, options);
  give_shapes(result, shaped);
  return result;
}

}  // namespace gyrobudget::inline v0::fit

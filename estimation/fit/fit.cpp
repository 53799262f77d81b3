// SPDX-License-Identifier: MIT
#include "fit.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/estimation/fit/detail/gls.h"
#include "gyrobudget/estimation/fit/detail/judge.h"
#include "gyrobudget/estimation/fit/detail/refine.h"
#include "gyrobudget/estimation/fit/detail/weighted.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
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
  std::optional<allan::CurveCovariance> covariance;  // of rows x columns

  [[nodiscard]] Eigen::Index tested_until() const {  // rows with n/m >= 16 come first
    return std::partition_point(m.begin(), m.end(), [&](auto x) { return x * kTestedClusters <= samples; }) - m.begin();
  }
};

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
  return p;
}

// The rows [first, end) and columns of a prepared curve as a linear model.
struct TestedFit {
  Eigen::Index first = 0;
  std::vector<Term> terms;
  LinearModel model;
  GlsSolution solution;
  Eigen::MatrixXd covariance;  // of theta, where the method has its own
  double chi2 = 0;
  int dof = 0;
  double p_value = 0;
};

LinearModel linear_model(const Prepared& p, Eigen::Index first, std::span<const std::size_t> columns) {
  std::vector<std::size_t> rows(p.rows.size() - static_cast<std::size_t>(first));
  std::iota(rows.begin(), rows.end(), static_cast<std::size_t>(first));
  auto covariance = std::make_shared<allan::CurveCovariance>(p.covariance->subset(rows, columns));
  LinearModel model;
  model.A = covariance->expectation();
  model.s = p.s.tail(p.s.size() - first);
  model.covariance = [covariance](const Eigen::VectorXd& theta) { return (*covariance)(theta); };
  return model;
}

// Goodness of fit over the rows of the run with n/m >= 16.
void test_fit(const Prepared& p, TestedFit& run) {
  const Eigen::Index count = p.tested_until() - run.first;
  run.dof = static_cast<int>(count - (run.solution.theta.array() > 0).count());
  if (run.dof < 1 || run.solution.S.size() == 0) return;
  const Eigen::VectorXd r = (run.model.s - run.model.A * run.solution.theta).head(count);
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

TestedFit fit_from(const Prepared& p, Eigen::Index first, bool drop_quantization, Method method = Method::gls) {
  TestedFit run;
  run.first = first;
  std::vector<std::size_t> columns;
  for (std::size_t j = 0; j < p.terms.size(); ++j) {
    if (drop_quantization && p.terms[j] == Term::quantization) continue;
    run.terms.push_back(p.terms[j]);
    columns.push_back(j);
  }
  if (columns.empty()) return run;
  run.model = linear_model(p, first, columns);
  solve(run, method);
  test_fit(p, run);
  return run;
}

// The first tau asked for.
TestedFit run_from_tau(const Prepared& p, double tau_min_s, Method method) {
  const auto first = std::partition_point(
      p.m.begin(), p.m.end(), [&](auto m) { return static_cast<double>(m) * p.dt < tau_min_s * (1 - 1e-9); });
  if (p.m.end() - first <= static_cast<std::ptrdiff_t>(p.terms.size())) {
    throw std::invalid_argument(fmt::format("only {} taus from {} s on: too few to fit {} terms", p.m.end() - first,
                                            tau_min_s, p.terms.size()));
  }
  return fit_from(p, first - p.m.begin(), false, method);
}

// The runs that the model describes, longest first: the p-value reaches the limit and the first tau belongs, that is,
// fitting without that tau does not lower chi-square by more than chance. Quantization is strongest at the first tau:
// a run that must cut that tau cannot hold it.
std::vector<TestedFit> described_runs(const Prepared& p, const Options& options) {
  const Eigen::Index tested = p.tested_until();
  const auto fewest = static_cast<Eigen::Index>(p.terms.size()) + kSparePoints;
  std::vector<TestedFit> runs;
  for (Eigen::Index first = 1; first <= tested / 2 + 1 && tested - first >= fewest; ++first) {
    runs.push_back(fit_from(p, first, true));
    if (runs.back().terms.empty()) return {};
  }
  std::vector<TestedFit> described;
  for (std::size_t i = 0; i < runs.size() && runs[i].first <= tested / 2; ++i) {
    const bool belongs = i + 1 == runs.size() || runs[i].chi2 - runs[i + 1].chi2 < kFirstTauCut;
    if (belongs && runs[i].p_value >= options.p_value_limit) described.push_back(runs[i]);
  }
  return described;
}

TestedFit choose_run(const Prepared& p, const Options& options) {
  if (options.tau_min_s) return run_from_tau(p, *options.tau_min_s, options.method);
  TestedFit whole = fit_from(p, 0, false, options.method);
  if (whole.p_value >= kCutBelow || options.method != Method::gls) return whole;
  const auto described = described_runs(p, options);
  return described.empty() ? whole : described.front();
}

Eigen::VectorXd standard_deviations(const TestedFit& run) {
  if (run.covariance.size() > 0) return run.covariance.diagonal().cwiseSqrt();
  const Eigen::LLT<Eigen::MatrixXd> factor(run.solution.S);
  const Eigen::MatrixXd WA = factor.matrixL().solve(run.model.A);
  const Eigen::VectorXd length = WA.colwise().norm();
  const Eigen::MatrixXd unit = WA * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse =
      (unit.transpose() * unit).llt().solve(Eigen::MatrixXd::Identity(WA.cols(), WA.cols()));
  return inverse.diagonal().cwiseSqrt().cwiseQuotient(length);
}

std::vector<Eigen::Index> above_zero(const Eigen::VectorXd& theta) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index j = 0; j < theta.size(); ++j) {
    if (theta(j) > 0) free.push_back(j);
  }
  return free;
}

// Ceres' step over the coefficients above zero; updates the solution and its test, and fills the result's covariance.
void refine_run(const Prepared& p, TestedFit& run, Result& result) {
  const auto free = above_zero(run.solution.theta);
  const Eigen::MatrixXd A = run.model.A(Eigen::all, free);
  const WhitenedResidual residual(A, run.model.s, run.solution.S);
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
  const LinearModel all = linear_model(p, 0, columns);
  const Eigen::VectorXd model = all.A * run.solution.theta;
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
  if (run.first == 0) return;
  const TestedFit whole = fit_from(p, 0, false);
  for (std::size_t j = 0; j < whole.terms.size(); ++j) {
    const double from = std::sqrt(whole.solution.theta(static_cast<Eigen::Index>(j)) * p.scale);
    const Coefficient& now = result[whole.terms[j]];
    result.moved.push_back({whole.terms[j], from, now.fitted ? now.value : 0});
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
    const Options shape{.correlation_time_s = c.shape, .frequency_hz = c.shape};
    list.push_back(noise::with_coefficient(shaped_process(c.term, shape), c.value));
  }
  return list;
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
    if (!c.fitted)
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
  Result result = record.covariance ? fit(curve, *record.covariance, options) : fit(curve, options);
  give_shapes(result, shaped);
  return result;
}

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#include "gyrobudget/fit/fit.h"

#include "gyrobudget/fit/detail/gls.h"
#include "gyrobudget/fit/detail/refine.h"
#include "gyrobudget/fit/visual.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr std::array kLinearTerms{Term::quantization, Term::white, Term::flicker, Term::rate_random_walk,
                                  Term::rate_ramp};
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kTestedClusters =
    16;  // goodness of fit over n/m >= 16: beyond, s is too skewed for chi-square
constexpr double kScatter95 = 1.96;
constexpr double kNegligible = 0.01;   // of the deviation
constexpr double kCutBelow = 1e-4;     // p-value of the whole curve below which short taus may be cut
constexpr double kFirstTauCut = 6.63;  // 1 % cut of chi-square with 1 degree of freedom
constexpr double kFailedModelLevel =
    1e-3;                        // of the F test that a term must pass where the model fails its own
constexpr int kSparePoints = 2;  // a start must leave this many tested taus more than terms

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
    return std::partition_point(m.begin(), m.end(), [&](auto x) { return x * kTestedClusters <= samples; }) -
           m.begin();
  }
};

std::vector<Term> in_order(const std::vector<Term>& asked) {
  std::vector<Term> terms;
  for (const Term t : kLinearTerms) {
    const auto count = std::count(asked.begin(), asked.end(), t);
    if (count > 1)
      throw std::invalid_argument(fmt::format("term {} is asked for twice", static_cast<char>(t)));
    if (count == 1) terms.push_back(t);
  }
  if (terms.size() != asked.size() || terms.empty()) {
    throw std::invalid_argument("the terms to fit must be one or more of Q, N, B, K, R");
  }
  return terms;
}

Prepared prepare(const allan::Curve& curve, const allan::CurveCovariance& covariance,
                 const Options& options) {
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
    const auto at =
        std::find_if(have.begin(), have.end(), [&](const auto& x) { return noise::term(x) == t; });
    if (at == have.end()) {
      throw std::invalid_argument(fmt::format("the covariance lacks term {}", static_cast<char>(t)));
    }
    p.columns.push_back(static_cast<std::size_t>(at - have.begin()));
  }
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const auto& point = curve.points[i];
    if (point.m != covariance.factors()[i]) {
      throw std::invalid_argument(fmt::format("the covariance is of factor {} where the curve has {}",
                                              covariance.factors()[i], point.m));
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
  for (std::size_t i = 0; i < p.rows.size(); ++i)
    p.s(static_cast<Eigen::Index>(i)) = curve.points[p.rows[i]].variance;
  if (p.s.maxCoeff() > 0) p.scale = std::exp2(std::floor(std::log2(p.s.maxCoeff())));
  p.s /= p.scale;
  p.covariance = covariance.subset(p.rows, p.columns);
  return p;
}

// The rows [first, end) and columns of a prepared curve as a linear model.
struct Run {
  Eigen::Index first = 0;
  std::vector<Term> terms;
  LinearModel model;
  GlsSolution solution;
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
void test_fit(const Prepared& p, Run& run) {
  const Eigen::Index count = p.tested_until() - run.first;
  run.dof = static_cast<int>(count - (run.solution.theta.array() > 0).count());
  if (run.dof < 1 || run.solution.S.size() == 0) return;
  const Eigen::VectorXd r = (run.model.s - run.model.A * run.solution.theta).head(count);
  const Eigen::LLT<Eigen::MatrixXd> factor(run.solution.S.topLeftCorner(count, count));
  if (factor.info() != Eigen::Success) return;
  run.chi2 = factor.matrixL().solve(r).squaredNorm();
  const double hopeless = 2000 + 100.0 * run.dof;  // p below 1e-300, where the series of gamma_q fail
  run.p_value = run.chi2 < hopeless ? boost::math::gamma_q(0.5 * run.dof, 0.5 * run.chi2) : 0;
}

Run fit_from(const Prepared& p, Eigen::Index first, bool drop_quantization) {
  Run run;
  run.first = first;
  std::vector<std::size_t> columns;
  for (std::size_t j = 0; j < p.terms.size(); ++j) {
    if (drop_quantization && p.terms[j] == Term::quantization) continue;
    run.terms.push_back(p.terms[j]);
    columns.push_back(j);
  }
  if (columns.empty()) return run;
  run.model = linear_model(p, first, columns);
  run.solution = iterate_gls(run.model);
  test_fit(p, run);
  return run;
}

// The first tau asked for.
Run run_from_tau(const Prepared& p, double tau_min_s) {
  const auto first = std::partition_point(
      p.m.begin(), p.m.end(), [&](auto m) { return static_cast<double>(m) * p.dt < tau_min_s * (1 - 1e-9); });
  if (p.m.end() - first <= static_cast<std::ptrdiff_t>(p.terms.size())) {
    throw std::invalid_argument(fmt::format("only {} taus from {} s on: too few to fit {} terms",
                                            p.m.end() - first, tau_min_s, p.terms.size()));
  }
  return fit_from(p, first - p.m.begin(), false);
}

// The runs that the model describes, longest first: the p-value reaches the limit and the first tau belongs, that is,
// fitting without that tau does not lower chi-square by more than chance. Quantization is strongest at the first tau:
// a run that must cut that tau cannot hold it.
std::vector<Run> described_runs(const Prepared& p, const Options& options) {
  const Eigen::Index tested = p.tested_until();
  const auto fewest = static_cast<Eigen::Index>(p.terms.size()) + kSparePoints;
  std::vector<Run> runs;
  for (Eigen::Index first = 1; first <= tested / 2 + 1 && tested - first >= fewest; ++first) {
    runs.push_back(fit_from(p, first, true));
    if (runs.back().terms.empty()) return {};
  }
  std::vector<Run> described;
  for (std::size_t i = 0; i < runs.size() && runs[i].first <= tested / 2; ++i) {
    const bool belongs = i + 1 == runs.size() || runs[i].chi2 - runs[i + 1].chi2 < kFirstTauCut;
    if (belongs && runs[i].p_value >= options.p_value_limit) described.push_back(runs[i]);
  }
  return described;
}

Run choose_run(const Prepared& p, const Options& options) {
  if (options.tau_min_s) return run_from_tau(p, *options.tau_min_s);
  Run whole = fit_from(p, 0, false);
  if (whole.p_value >= kCutBelow) return whole;
  const auto described = described_runs(p, options);
  return described.empty() ? whole : described.front();
}

Eigen::VectorXd standard_deviations(const Run& run) {
  const Eigen::LLT<Eigen::MatrixXd> factor(run.solution.S);
  const Eigen::MatrixXd WA = factor.matrixL().solve(run.model.A);
  const Eigen::VectorXd length = WA.colwise().norm();
  const Eigen::MatrixXd unit = WA * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse =
      (unit.transpose() * unit).llt().solve(Eigen::MatrixXd::Identity(WA.cols(), WA.cols()));
  return inverse.diagonal().cwiseSqrt().cwiseQuotient(length);
}

// Ceres' step over the coefficients above zero; updates the solution and fills `result.covariance`.
void refine_run(Run& run, double scale, Result& result) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index j = 0; j < run.solution.theta.size(); ++j) {
    if (run.solution.theta(j) > 0) free.push_back(j);
  }
  const auto p = run.solution.theta.size();
  result.covariance = Eigen::MatrixXd::Constant(p, p, kNaN);
  if (free.empty() || !run.solution.converged) return;
  const Eigen::MatrixXd A = run.model.A(Eigen::all, free);
  const WhitenedResidual residual(A, run.model.s, run.solution.S);
  const Refined refined = refine(residual, run.solution.theta(free).cwiseSqrt());
  run.solution.theta(free) = refined.coefficients.cwiseAbs2();
  result.covariance(free, free) = refined.covariance * scale;
  result.iterations = run.solution.iterations + refined.iterations;
  result.converged = run.solution.converged && refined.converged;
}

// Zero, and even its limit adds less than 1 % to the deviation anywhere.
bool negligible(const Run& run, Eigen::Index j, double upper_theta) {
  if (run.solution.theta(j) > 0) return false;
  const Eigen::ArrayXd model = run.model.A * run.solution.theta;
  const Eigen::ArrayXd added = run.model.A.col(j).array() * upper_theta;
  return ((1 + added / model.max(1e-300)).sqrt() - 1 < kNegligible).all();
}

// What the tests of coefficients are held against. Where the model fails its own test, chi-square per degree of
// freedom measures how much worse than chance it misses, and a term must be seen above that (F test, 0.1 %): a wrong
// model must not lend significance to its smallest parts.
struct Cuts {
  double boundary = kBoundaryCut;
  double one_sided = kBoundaryCut;
  double two_sided = kIntervalCut;
};

Cuts cuts_of(const Run& run, const Options& options) {
  if (run.p_value >= options.p_value_limit || run.dof < 1) return {};
  const double excess = std::max(1.0, run.chi2 / run.dof);
  const boost::math::fisher_f_distribution<> F(1, run.dof);
  return {excess * boost::math::quantile(complement(F, kFailedModelLevel)), excess * kBoundaryCut,
          excess * kIntervalCut};
}

Coefficient judge(const Run& run, Eigen::Index j, double deviation, double scale, const Cuts& cuts,
                  bool intervals) {
  Coefficient c;
  c.term = run.terms[static_cast<std::size_t>(j)];
  c.fitted = true;
  const double theta = run.solution.theta(j);
  c.value = std::sqrt(theta * scale);
  c.relative_std = theta > 0 ? 0.5 * deviation / theta : kInfinity;
  c.lower = c.upper = c.upper_two_sided = c.value;
  c.status = theta > 0 ? Status::identified : Status::upper_bound;
  if (!intervals) return c;
  c.boundary_test = theta > 0 ? profile_test(run.model, {j, 0.0}, run.solution.theta) : 0;
  const bool identified = c.boundary_test > cuts.boundary;
  c.status = identified ? Status::identified : Status::upper_bound;
  const ProfileInterval interval = profile_interval(run.model, j, run.solution, deviation, cuts.two_sided);
  c.lower = identified ? std::sqrt(interval.lower * scale) : 0;
  c.upper = c.upper_two_sided = std::sqrt(interval.upper * scale);
  if (identified) return c;
  const double limit = profile_interval(run.model, j, run.solution, deviation, cuts.one_sided).upper;
  c.upper = std::sqrt(limit * scale);
  if (negligible(run, j, limit)) c.status = Status::left_out;
  return c;
}

// The weights never settled: a value for what it is worth, and no limit.
Coefficient without_answer(const Run& run, Eigen::Index j, double scale) {
  Coefficient c;
  c.term = run.terms[static_cast<std::size_t>(j)];
  c.fitted = true;
  c.value = std::sqrt(run.solution.theta(j) * scale);
  c.upper = c.upper_two_sided = c.relative_std = kInfinity;
  c.status = Status::upper_bound;
  return c;
}

void add_coefficients(Result& result, const Run& run, double scale, const Options& options) {
  const Cuts cuts = cuts_of(run, options);
  const Eigen::VectorXd deviation = run.solution.converged ? standard_deviations(run) : Eigen::VectorXd();
  for (const Term t : kLinearTerms) {
    const auto at = std::find(run.terms.begin(), run.terms.end(), t);
    if (at == run.terms.end()) {
      result.coefficients.push_back({.term = t});
    } else {
      const Eigen::Index j = at - run.terms.begin();
      result.coefficients.push_back(run.solution.converged
                                        ? judge(run, j, deviation(j), scale, cuts, options.intervals)
                                        : without_answer(run, j, scale));
    }
  }
}

// Every tau of the curve beside the model, the cut ones too.
void add_residuals(Result& result, const Prepared& p, const Run& run, const allan::Curve& curve) {
  std::vector<std::size_t> columns;
  for (const Term t : run.terms) {
    columns.push_back(
        static_cast<std::size_t>(std::find(p.terms.begin(), p.terms.end(), t) - p.terms.begin()));
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
    r.relative_std = 0.5 * std::sqrt(S(row, row)) / model(row);
    r.misfit = r.measured / r.model - 1;
    r.used = row >= run.first;
    result.residuals.push_back(r);
  }
}

void judge_fit(Result& result, const Prepared& p, const Run& run, const Options& options) {
  result.chi2 = run.chi2;
  result.dof = run.dof;
  result.p_value = run.p_value;
  for (Eigen::Index i = run.first; i < p.tested_until(); ++i) {
    const Residual& r = result.residuals[static_cast<std::size_t>(i)];
    const double beyond = std::abs(r.misfit) - kScatter95 * r.relative_std;
    if (beyond > result.worst_misfit) result.worst_misfit = beyond, result.worst_misfit_tau_s = r.tau_s;
  }
  if (run.p_value >= options.p_value_limit) {
    result.verdict = Verdict::described;
  } else if (run.dof >= 1 && result.worst_misfit <= options.misfit_limit) {
    result.verdict = Verdict::described_within;
  }
}

void add_moves(Result& result, const Prepared& p, const Run& run) {
  if (run.first == 0) return;
  const Run whole = fit_from(p, 0, false);
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
  const double N = result[Term::white].value, B = result[Term::flicker].value,
               K = result[Term::rate_random_walk].value;
  result.beta = N > 0 && K > 0 ? (B / N) * (B / K) : 0;
}

// Nothing varies: every coefficient is zero and no model is needed. Not an error, but no answer either.
Result silent_record(const Prepared& p, const allan::Curve& curve) {
  Result result;
  for (const Term t : kLinearTerms) {
    const bool fitted = std::find(p.terms.begin(), p.terms.end(), t) != p.terms.end();
    result.coefficients.push_back({.term = t, .relative_std = kInfinity, .fitted = fitted});
  }
  result.fitted_terms = p.terms;
  const auto size = static_cast<Eigen::Index>(p.terms.size());
  result.covariance = Eigen::MatrixXd::Constant(size, size, kNaN);
  result.tau_min_s = curve.tau(p.rows.front());
  result.tau_max_s = curve.tau(p.rows.back());
  return result;
}

}  // namespace

const Coefficient& Result::operator[](Term t) const {
  const auto at =
      std::find_if(coefficients.begin(), coefficients.end(), [&](const auto& c) { return c.term == t; });
  if (at == coefficients.end())
    throw std::invalid_argument("only Q, N, B, K and R are coefficients of a fit");
  return *at;
}

std::vector<noise::Process> Result::processes() const {
  std::vector<noise::Process> list;
  for (const auto& c : coefficients) {
    if (c.fitted && c.value > 0)
      list.push_back(noise::with_coefficient(noise::unit_process(c.term), c.value));
  }
  return list;
}

Result fit(const allan::Curve& curve, const allan::CurveCovariance& covariance, const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  const Prepared p = prepare(curve, covariance, options);
  if (p.s.maxCoeff() <= 0) return silent_record(p, curve);
  if (options.method == Method::visual) return read_visually(curve, options);

  Run run = choose_run(p, options);
  Result result;
  result.fitted_terms = run.terms;
  refine_run(run, p.scale, result);
  add_coefficients(result, run, p.scale, options);
  result.tau_min_s = static_cast<double>(p.m[static_cast<std::size_t>(run.first)]) * p.dt;
  result.tau_max_s = static_cast<double>(p.m.back()) * p.dt;
  add_residuals(result, p, run, curve);
  judge_fit(result, p, run, options);
  add_moves(result, p, run);
  add_curve_facts(result, curve);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

Result fit(const allan::Curve& curve, const Options& options) {
  std::vector<std::int64_t> factors;
  for (const auto& point : curve.points) factors.push_back(point.m);
  std::vector<noise::Process> processes;
  for (const Term t : in_order(options.terms)) processes.push_back(noise::unit_process(t));
  return fit(curve,
             allan::CurveCovariance(curve.samples, std::move(factors), curve.dt, std::move(processes),
                                    curve.form, curve.mask.get()),
             options);
}

}  // namespace gyrobudget::inline v0::fit

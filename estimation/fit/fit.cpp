// SPDX-License-Identifier: MIT
#include "fit.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/estimation/fit/detail/curve_run.h"
#include "gyrobudget/estimation/fit/detail/gls.h"
#include "gyrobudget/estimation/fit/detail/judge.h"
#include "gyrobudget/estimation/fit/detail/refine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "visual.h"
#include "whittle.h"
#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kScatter95 = 1.96;
constexpr double kNegligible = 0.01;  // of the deviation

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
    result.front_end = {f.kind,
                        f.bandwidth,
                        f.bandwidth,
                        f.bandwidth,
                        f.sampling,
                        f.oversampling,
                        run.free == Free::bandwidth,
                        options.front_end_choice};
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
    result.front_end = {{}, kUsual / (value * p.dt), kLeast / longest, kMost / shortest, {}, 1, true};
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
    Options shape;
    shape.correlation_time_s = shape.frequency_hz = c.shape;
    if (front_end && front_end->kind) shape.front_end = front_end->value();
    list.push_back(noise::with_coefficient(shaped_process(c.term, shape), c.value));
  }
  return list;
}

noise::FrontEnd FittedFrontEnd::value() const {
  if (!kind) throw std::logic_error("a front end of unknown kind has no value");
  return {*kind, bandwidth, sampling, oversampling};
}

void shift_white(Result& result, const WhiteShift& by) {
  if (by.shift == 0 && !(by.sigma > 0)) return;
  constexpr double kSigmas95 = 1.96, kSigmasOneSided = 1.645;
  const double factor = std::exp(by.shift);
  for (Coefficient& c : result.coefficients) {
    if (c.term != Term::white || !c.fitted || !(c.value > 0)) continue;
    const auto further = [&](double limit, double sigmas) {
      if (!(limit > 0)) return limit;
      const double away = std::log(limit / c.value);
      return c.value * std::exp(by.shift + std::copysign(std::hypot(away, sigmas * by.sigma), away));
    };
    const bool identified = c.status == Status::identified;
    c.lower = further(c.lower, kSigmas95);
    c.upper = further(c.upper, identified ? kSigmas95 : kSigmasOneSided);
    c.upper_two_sided = further(c.upper_two_sided, kSigmas95);
    c.value *= factor;
    c.relative_std = std::hypot(c.relative_std, by.sigma);
    const auto at = std::ranges::find(result.fitted_terms, Term::white) - result.fitted_terms.begin();
    if (at >= result.covariance.rows()) continue;
    result.covariance.row(at) *= factor, result.covariance.col(at) *= factor;
    result.covariance(at, at) += std::pow(c.value * by.sigma, 2);
  }
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
  shift_white(result, options.front_end_choice);
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
  if (options.method != Method::gls || record.rate.empty()) return false;
  if (options.front_end) return options.fit_bandwidth;
  return options.front_end_kind || (options.find_front_end && !options.tau_min_s);
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
  const auto start = std::chrono::steady_clock::now();
  const bool asked = options.front_end || options.front_end_kind;
  if (!options.front_end) {
    if (!asked && !may_be_filtered(curve, covariance, options)) return {};
    const auto found = find_front_end(record.rate, record.dt, options);
    if (!found) return {};
    options.front_end = found->front_end;
    options.front_end_choice = found->choice;
    options.fit_bandwidth = true;
  }
  std::optional<Result> result = fit_bandwidth(curve, options);
  if (!result || !result->front_end || (!asked && result->p_value < kCutBelow)) return {};
  result->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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

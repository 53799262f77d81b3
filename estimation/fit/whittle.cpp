// SPDX-License-Identifier: MIT
#include "whittle.h"

#include "gyrobudget/estimation/fit/detail/fill.h"
#include "gyrobudget/estimation/fit/detail/judge.h"
#include "gyrobudget/estimation/fit/detail/likelihood.h"
#include "gyrobudget/estimation/fit/detail/sine.h"
#include "gyrobudget/estimation/fit/detail/tilt.h"
#include "gyrobudget/estimation/fit/detail/transformed.h"

#include <boost/math/special_functions/erf.hpp>
#include <boost/math/special_functions/gamma.hpp>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kBands = 33;
constexpr double kCutBelow = 1e-4;  // p-value of the whole band below which it may be cut
constexpr double kTimesPerDecade = 4;
constexpr double kNegligible = 0.01;  // of the deviation, that is 2 % of the variance
constexpr double kScatter95 = 1.96;
constexpr double kVague = 0.35;  // one sigma of a bandwidth's logarithm from which on nothing is known of it

// --- The model ----------------------------------------------------------------------------------------------

struct Model {
  std::vector<Term> terms;                // asked for, all
  std::vector<noise::Process> processes;  // the random ones among them
  bool ramp = false, line = false, search_time = false;
  std::optional<noise::FrontEnd> front_end;
  WhiteShift front_end_choice;
};

/// What stands between the noise and the samples, as far as a fit knows it.
enum class Filter {
  none,
  given,     ///< Options::front_end, its bandwidth held
  fitted,    ///< Options::front_end, its bandwidth fitted
  searched,  ///< one of the kinds that Options names
  unknown,   ///< one whose gain at the band's frequencies has a quadratic logarithm
};

Filter filter_of(const Options& options) {
  if (!options.front_end) return options.unknown_front_end ? Filter::unknown : Filter::none;
  return options.fit_bandwidth ? Filter::fitted : Filter::given;
}

Model model_of(const Options& options, bool drop_quantization) {
  Model m;
  m.terms = in_order(options.terms);
  if (drop_quantization) std::erase(m.terms, Term::quantization);
  for (const Term t : m.terms) {
    if (t == Term::rate_ramp) {
      m.ramp = true;
    } else if (t == Term::sinusoid) {
      m.line = true;
    } else {
      m.processes.push_back(shaped_process(t, options));
    }
  }
  m.search_time =
      !m.processes.empty() && noise::term(m.processes.back()) == Term::gauss_markov && !options.correlation_time_s;
  return m;
}

struct Band {
  std::int64_t first = 1, last = 1;
};

// A fit of the band k = 1 .. last.
struct Fitted {
  Model model;
  std::int64_t last = 0;
  std::optional<SineLikelihood> flat;        // before any filter
  std::optional<SineLikelihood> likelihood;  // behind it
  SineLikelihood::Point point;
  Filter filter = Filter::none;
  std::optional<Tilt> tilt;  // where a filter has an unknown
  double tilt_deviation = 0;
  Sine line;
  double time_lower = 0, time_upper = 0;  // of the correlation time
  double chi2 = 0, p_value = 0;
  int dof = 0;
  std::vector<SpectralResidual> spectrum;
};

// With what filled samples know less of, counted as fewer coefficients.
SineBins bins_of(const Transformed& t, const Band& band, bool narrow) {
  const std::int64_t first = band.first;
  SineBins bins(t.coefficients, t.used.count, t.dt, band.last, narrow ? widest_bin(t.used.count) : SineBins::kAnyWidth);
  for (const TransformedStretch& other : t.others) bins.add(other.coefficients, other.used.count);
  bins.count *= information_left(t.missing_share);
  for (Eigen::Index b = 0; b < bins.count.size(); ++b) {
    if (bins.first[static_cast<std::size_t>(b)] < first) bins.count(b) = 0;
  }
  return bins;
}

double& correlation_time(Model& m) { return std::get<noise::GaussMarkov>(m.processes.back()).correlation_time; }

// Derivative of the least cost by the logarithm of the correlation time: with the rest at its best only the spectrum's
// own change counts.
double cost_slope(const Model& model, const SineBins& bins, const Eigen::ArrayXd& gain, double log_time) {
  const auto at = [&](double x) {
    Model m = model;
    correlation_time(m) = std::exp(x);
    return SineLikelihood(bins, m.processes, m.ramp).behind(gain);
  };
  constexpr double kStep = 1e-3;
  const SineLikelihood here = at(log_time);
  const auto best = here.maximise();
  const Eigen::ArrayXd lambda = here.variance(best.theta);
  const Eigen::ArrayXd change =
      (at(log_time + kStep).variance(best.theta) - at(log_time - kStep).variance(best.theta)) / (2 * kStep);
  return (bins.count / lambda * (1 - here.power(best.ramp) / lambda) * change).sum();
}

// A minimum found by values is known to the root of their rounding only; by the root of their slope to the rounding.
template <class Slope>
double polished(const Slope& slope, double minimum, double reach) {
  const double low = slope(minimum - reach), high = slope(minimum + reach);
  if (!(low < 0 && high > 0)) return minimum;
  std::uintmax_t budget = 60;
  const auto bracket = boost::math::tools::toms748_solve(slope, minimum - reach, minimum + reach, low, high,
                                                         boost::math::tools::eps_tolerance<double>(48), budget);
  return 0.5 * (bracket.first + bracket.second);
}

// The best correlation time: a grid over all that the record could show, then the least cost beside its best.
void search_time(Fitted& f, const SineBins& bins, const Eigen::ArrayXd& gain, std::optional<double> near) {
  constexpr double kNear = 4, kTie = 1e-7;
  const double n = static_cast<double>(bins.samples);
  const double low = std::log(bins.dt), high = std::log(0.5 * n * bins.dt);
  const auto cost = [&](double log_time) {
    Model m = f.model;
    correlation_time(m) = std::exp(log_time);
    return SineLikelihood(bins, m.processes, m.ramp).behind(gain).maximise().cost;
  };
  const double step = std::numbers::ln10 / kTimesPerDecade;
  const double from = near ? std::clamp(std::log(*near / kNear), low, high) : low;
  const double to = near ? std::clamp(std::log(*near * kNear), low, high) : high;
  double best = from, least = kInfinity;
  for (double x = from; x < to + step; x += step) {
    const double c = cost(std::min(x, to));
    if (c < least - kTie) least = c, best = std::min(x, to);
  }
  std::uintmax_t budget = 40;
  const auto found =
      boost::math::tools::brent_find_minima(cost, std::max(low, best - step), std::min(high, best + step), 14, budget);
  if (found.second < least - kTie) {
    constexpr double kReach = 0.01;
    best = polished([&](double x) { return cost_slope(f.model, bins, gain, x); }, found.first, kReach);
    least = cost(best);
  }
  correlation_time(f.model) = std::exp(best);
  // Interval: where the profile has risen by its 95 % cut; the ends of the grid where it never does.
  const auto end = [&](double limit) {
    double inside = best, outside = limit;
    if (cost(limit) - least < kIntervalCut) return limit;
    while (std::abs(outside - inside) > 1e-3) {
      const double middle = 0.5 * (inside + outside);
      (cost(middle) - least < kIntervalCut ? inside : outside) = middle;
    }
    return 0.5 * (inside + outside);
  };
  f.time_lower = std::exp(end(low));
  f.time_upper = std::exp(end(high));
}

// --- Goodness of fit ------------------------------------------------------------------------------------------

// Normal deviate of a chi-square x with `dof` degrees of freedom.
double deviate(double x, double dof) {
  const double below = boost::math::gamma_p(0.5 * dof, 0.5 * x);
  const double above = boost::math::gamma_q(0.5 * dof, 0.5 * x);
  constexpr double kLeast = 1e-300;
  return below < above ? -std::numbers::sqrt2 * boost::math::erfc_inv(2 * std::max(below, kLeast))
                       : std::numbers::sqrt2 * boost::math::erfc_inv(2 * std::max(above, kLeast));
}

void test_fit(Fitted& f) {
  const SineBins& bins = f.likelihood->bins();
  const Eigen::ArrayXd scaled = bins.count * f.likelihood->power(f.point.ramp) / f.likelihood->variance(f.point.theta);
  const double ratio = std::pow(static_cast<double>(f.last) + 1, 1.0 / kBands);
  f.spectrum.clear(), f.chi2 = 0;
  double edge = ratio, chi = 0, count = 0;
  std::int64_t first = 0;
  for (Eigen::Index b = 0; b < bins.count.size(); ++b) {
    const auto end = bins.first[static_cast<std::size_t>(b) + 1];
    if (first == 0) first = bins.first[static_cast<std::size_t>(b)];
    chi += scaled(b), count += bins.count(b);
    const bool last_bin = b + 1 == bins.count.size();
    if (static_cast<double>(end) < edge * (1 - 1e-9) && !last_bin) continue;
    if (count > 0) {
      f.chi2 += std::pow(deviate(chi, count), 2);
      const double k = std::sqrt(static_cast<double>(first) * static_cast<double>(end - 1));
      f.spectrum.push_back({k / (2 * static_cast<double>(bins.samples) * bins.dt), count, std::sqrt(chi / count) - 1,
                            std::sqrt(0.5 / count)});
    }
    while (edge <= static_cast<double>(end) * (1 + 1e-9)) edge *= ratio;
    chi = count = 0, first = 0;
  }
  const auto parameters = (f.point.theta.array() > 0).count() + f.model.ramp + f.model.search_time + f.tilt.has_value();
  f.dof = static_cast<int>(f.spectrum.size()) - static_cast<int>(parameters);
  f.p_value = f.dof >= 1 ? chi_square_tail(f.chi2, f.dof) : 0;
}

// --- One fit ----------------------------------------------------------------------------------------------------

// Finds the filter where it is to be found, and leaves its stop band out; the gain to begin with, ones where there is
// no filter. The high frequencies of nearly every record are white noise, flicker and a walk: enough to tell a filter
// by, whatever terms are asked for.
Eigen::ArrayXd set_filter(Fitted& f, SineBins& bins, const Options& options) {
  if (f.filter == Filter::given || f.filter == Filter::fitted) {
    f.model.front_end = options.front_end;
    f.model.front_end_choice = options.front_end_choice;
  }
  if (f.filter == Filter::searched && !f.model.front_end) {
    const std::array plain{noise::unit_process(Term::white), noise::unit_process(Term::flicker),
                           noise::unit_process(Term::rate_random_walk)};
    const ChosenFrontEnd chosen = search_front_end(bins, plain, options.front_end_kind);
    f.model.front_end = chosen.front_end;
    f.model.front_end_choice = chosen.choice;
  }
  if (f.model.front_end) leave_out_stop_band(bins, *f.model.front_end);
  if (f.filter == Filter::given) return gain_of(bins, *f.model.front_end);
  if (f.filter == Filter::unknown) f.tilt = unknown_tilt(bins, f.last);
  if (f.model.front_end) f.tilt = tilt_of(bins, *f.model.front_end);
  return f.tilt ? f.tilt->gain : Eigen::ArrayXd::Ones(bins.count.size()).eval();
}

void maximise(Fitted& f, SineBins bins, const Options& options) {
  const Eigen::ArrayXd gain = set_filter(f, bins, options);
  if (f.model.search_time) search_time(f, bins, gain, options.near_correlation_time_s);
  f.flat.emplace(std::move(bins), f.model.processes, f.model.ramp);
  if (!f.tilt) {
    f.likelihood = f.filter == Filter::given ? f.flat->behind(gain) : *f.flat;
    f.point = f.likelihood->maximise();
    return;
  }
  const TiltedPoint best = maximise_tilted(*f.flat, *f.tilt);
  f.tilt->x = best.x, f.tilt_deviation = best.deviation;
  f.likelihood = f.flat->behind((*f.tilt)(best.x));
  f.point = best.point;
}

Fitted fit_band(const Transformed& t, const Band& band, const Options& options, Filter filter, bool drop_quantization) {
  Fitted f;
  f.model = model_of(options, drop_quantization);
  f.last = band.last;
  f.filter = filter;
  if (f.model.processes.empty()) return f;
  const bool narrow = filter != Filter::none && filter != Filter::unknown;
  const SineBins all = bins_of(t, band, narrow);
  maximise(f, all, options);
  if (f.model.line && f.point.converged) {
    const auto angle = [&](std::optional<double> hz) {
      return hz ? std::optional(2 * std::numbers::pi * std::remainder(*hz * t.dt, 1.0)) : std::nullopt;
    };
    const std::optional<double> w = angle(options.frequency_hz), near = angle(options.near_frequency_hz);
    constexpr int kRounds = 2;  // a strong line raises the spectrum that it is first seen against
    for (int i = 0; i < kRounds; ++i) {
      f.line = find_sine(*f.likelihood, f.point, t.coefficients, w, near);
      SineBins rest = bins_of(without_sine(t, f.line), band, narrow);
      rest.reference = all.reference;
      maximise(f, std::move(rest), options);
    }
    f.line = find_sine(*f.likelihood, f.point, t.coefficients, f.line.w);
  }
  test_fit(f);
  return f;
}

// The front end that describes the upper end of the spectrum, if one of the kinds asked for does; slow processes and
// drifts of any kind have nothing to do with it.
std::optional<FoundFrontEnd> seen_front_end(const Transformed& t, const Options& asked) {
  constexpr std::int64_t kReach = 2000, kFewest = 1000;
  if (t.used.count < kFewest) return {};  // kinds and samplings cannot be told
  const std::int64_t last = t.used.count - 1;
  Options options;
  options.front_end_kind = asked.front_end_kind;
  const Fitted found = fit_band(t, {std::max<std::int64_t>(1, last / kReach), last}, options, Filter::searched, true);
  constexpr double kAccepted = 1e-3;  // p-value: one true front end in a thousand is missed
  const bool stands = asked.front_end_kind || found.p_value >= std::min(kAccepted, asked.p_value_limit);
  if (!found.point.converged || !stands) return {};
  noise::FrontEnd front_end = *found.model.front_end;
  front_end.bandwidth *= std::exp(found.tilt->x);
  // Slower, or known to no better than a factor of 2, it is the noise's own colour; faster, it is none.
  constexpr double kSlowest = 1e-3, kFastest = 2;
  const double corner = front_end.bandwidth * t.dt;
  if (!(corner > kSlowest && corner < kFastest && found.tilt_deviation < kVague)) return {};
  return FoundFrontEnd{front_end, found.model.front_end_choice};
}

// The band halved from above until the model describes it, with a filter of which only the curvature of the logarithm
// is seen there: what a filter takes off white noise is felt long before a test can see it. The half of that which is
// described first is taken, so that the band does not end where the data happened to pass the test.
std::optional<Fitted> cut_band(const Transformed& t, const Band& band, const Options& options) {
  const auto fewest = static_cast<std::int64_t>(options.terms.size()) + 2;
  for (auto last = band.last / 2; last >= 16 * fewest && last * last >= band.last; last /= 2) {
    Fitted cut = fit_band(t, {band.first, last}, options, Filter::unknown, true);
    if (cut.model.processes.empty()) break;
    if (cut.p_value < options.p_value_limit) continue;
    const auto half = last / 2;
    if (half < 16 * fewest || half * half < band.last) return cut;
    Fitted further = fit_band(t, {band.first, half}, options, Filter::unknown, true);
    return further.p_value >= options.p_value_limit ? further : cut;
  }
  return {};
}

// The band of the options; behind a front end or cut from above where the model does not describe all of it.
Fitted choose_band(const Transformed& t, const Options& options) {
  const double n = static_cast<double>(t.used.count);
  Band band{1, t.used.count - 1};
  if (options.tau_max_s) band.first = std::max<std::int64_t>(1, std::llround(n * t.dt / *options.tau_max_s / 2));
  if (options.tau_min_s)
    band.last = std::clamp<std::int64_t>(std::llround(n * t.dt / *options.tau_min_s), 1, band.last);
  const Filter filter = filter_of(options);
  const bool asked = options.front_end_kind && filter == Filter::none;
  Fitted whole = fit_band(t, band, options, asked ? Filter::searched : filter, filter != Filter::none || asked);
  if (options.tau_min_s || whole.p_value >= kCutBelow) return whole;
  if (filter == Filter::none && !asked && options.find_front_end) {
    Options behind = options;
    if (const auto seen = seen_front_end(t, options)) {
      behind.front_end = seen->front_end;
      behind.front_end_choice = seen->choice;
      behind.fit_bandwidth = true;
      Fitted found = fit_band(t, band, behind, Filter::fitted, true);
      if (found.point.converged && found.tilt_deviation < kVague) return found;
    }
  }
  return cut_band(t, band, options).value_or(std::move(whole));
}

// --- The answer -------------------------------------------------------------------------------------------------

double least_cost(const Fitted& f, std::optional<Held> held, std::optional<double> held_ramp) {
  if (!f.tilt) return f.likelihood->maximise(held, held_ramp, &f.point).cost;
  return maximise_tilted(*f.flat, *f.tilt, held, held_ramp, &f.point).point.cost;
}

HeldTest theta_test(const Fitted& f, Eigen::Index j) {
  return [&f, j](double v) { return std::max(0.0, least_cost(f, Held{j, v}, {}) - f.point.cost); };
}

Eigen::MatrixXd information_of(const Fitted& f) {
  return f.tilt ? information_with_tilt(*f.likelihood, f.point.theta, f.tilt->slope)
                : f.likelihood->information(f.point.theta);
}

// Zero, and its limit adds less than 1 % to the deviation at any frequency.
bool negligible(const Fitted& f, Eigen::Index j, double upper_theta) {
  if (f.point.theta(j) > 0) return false;
  Eigen::VectorXd more = f.point.theta;
  more(j) = upper_theta;
  const Eigen::ArrayXd ratio = f.likelihood->variance(more) / f.likelihood->variance(f.point.theta);
  return (ratio.sqrt() - 1 < kNegligible).all();
}

// The ramp is a mean: its test has one degree of freedom, two-sided.
Coefficient ramp_coefficient(const Fitted& f, double unit, const Cuts& cuts, bool intervals) {
  Coefficient c{.term = Term::rate_ramp};
  c.fitted = true;
  const double deviation = 1 / std::sqrt(f.likelihood->ramp_information(f.point.theta));
  const double size = std::abs(f.point.ramp), sign = f.point.ramp < 0 ? -1 : 1;
  c.value = c.lower = c.upper = c.upper_two_sided = size * unit;
  c.relative_std = size > 0 ? deviation / size : kInfinity;
  c.status = Status::identified;
  if (!intervals) return c;
  const HeldTest test = [&](double v) { return std::max(0.0, least_cost(f, {}, sign * v) - f.point.cost); };
  c.boundary_test = test(0);
  const bool identified = c.boundary_test > cuts.boundary / kBoundaryCut * kIntervalCut;
  c.status = identified ? Status::identified : Status::upper_bound;
  const auto interval = profile_interval(test, size, deviation, cuts.two_sided);
  c.lower = identified ? interval.lower * unit : 0;
  c.upper = c.upper_two_sided = interval.upper * unit;
  if (!identified) c.upper = profile_interval(test, size, deviation, cuts.one_sided).upper * unit;
  return c;
}

Coefficient line_coefficient(const Fitted& f, const Transformed& t, bool searched) {
  Coefficient c{.term = Term::sinusoid};
  c.fitted = true;
  const double size = f.line.amplitude(), deviation = f.line.deviation;
  c.value = size * t.unit;
  c.relative_std = size > 0 ? deviation / size : kInfinity;
  c.boundary_test = f.line.test;
  const double n = static_cast<double>(t.used.count);
  const double cut = searched ? 2 * std::log(20 * n) : 5.99;  // largest of n; chi-square with 2, 5 %
  c.status = f.line.test > cut ? Status::identified : Status::upper_bound;
  c.lower = c.status == Status::identified ? std::max(0.0, size - kScatter95 * deviation) * t.unit : 0;
  c.upper_two_sided = (size + kScatter95 * deviation) * t.unit;
  c.upper = c.status == Status::identified ? c.upper_two_sided : (size + 1.645 * deviation) * t.unit;
  c.shape = f.line.w / (2 * std::numbers::pi * t.dt);
  // Cramer-Rao bound of a line's frequency beside white noise of the local level: std(w) = sqrt(12)/n std(A)/A.
  const double spread =
      searched ? kScatter95 * std::sqrt(12.0) / n * c.relative_std / (2 * std::numbers::pi * t.dt) : 0;
  c.shape_lower = std::max(0.0, c.shape - spread);
  c.shape_upper = std::min(0.5 / t.dt, c.shape + spread);
  return c;
}

void add_covariance(Result& result, const Fitted& f, double unit) {
  const auto random = static_cast<Eigen::Index>(f.model.processes.size());
  const auto size = static_cast<Eigen::Index>(result.fitted_terms.size());
  result.covariance = Eigen::MatrixXd::Constant(size, size, kNaN);
  std::vector<Eigen::Index> free;
  for (Eigen::Index j = 0; j < random; ++j) {
    if (f.point.theta(j) > 0) free.push_back(j);
  }
  if (free.empty()) return;
  // In units of the coefficients themselves: information of ln theta first, its diagonal is of order 1 to n.
  const Eigen::VectorXd theta = f.point.theta(free);
  const Eigen::MatrixXd relative =
      theta.asDiagonal() * Eigen::MatrixXd(information_of(f)(free, free)) * theta.asDiagonal();
  const Eigen::VectorXd length = relative.diagonal().cwiseSqrt();
  const Eigen::MatrixXd scaled = length.cwiseInverse().asDiagonal() * relative * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse = scaled.llt().solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
  const Eigen::VectorXd c = 0.5 * unit * theta.cwiseSqrt().cwiseQuotient(length);
  std::vector<Eigen::Index> places;
  for (const auto j : free) {
    const Term t = noise::term(f.model.processes[static_cast<std::size_t>(j)]);
    places.push_back(std::find(result.fitted_terms.begin(), result.fitted_terms.end(), t) -
                     result.fitted_terms.begin());
  }
  result.covariance(places, places) = c.asDiagonal() * inverse * c.asDiagonal();
  for (Eigen::Index i = 0; i < size; ++i) {
    const Term t = result.fitted_terms[static_cast<std::size_t>(i)];
    if (t != Term::rate_ramp && t != Term::sinusoid) continue;  // means are independent of the noise
    result.covariance.row(i).setZero();
    result.covariance.col(i).setZero();
    result.covariance(i, i) = std::pow(result[t].relative_std * result[t].value, 2);
  }
}

void add_coefficients(Result& result, const Fitted& f, const Transformed& t, const Options& options) {
  const Cuts cuts = cuts_of(f.p_value, f.chi2, f.dof, options);
  const double unit = t.unit;
  const Eigen::MatrixXd information = information_of(f);
  const Eigen::VectorXd length = information.diagonal().cwiseSqrt();
  const Eigen::MatrixXd inverse =
      Eigen::MatrixXd(length.cwiseInverse().asDiagonal() * information * length.cwiseInverse().asDiagonal())
          .llt()
          .solve(Eigen::MatrixXd::Identity(length.size(), length.size()));
  for (std::size_t i = 0; i < f.model.processes.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(i);
    const Term term = noise::term(f.model.processes[i]);
    const double theta = f.point.theta(j), deviation = std::sqrt(inverse(j, j)) / length(j);
    Coefficient c = f.point.converged ? judge(term, theta, deviation, 1, cuts, theta_test(f, j), options.intervals)
                                      : without_answer(term, theta, 1);
    if (f.point.converged && options.intervals && negligible(f, j, c.upper * c.upper)) c.status = Status::left_out;
    for (double* v : {&c.value, &c.lower, &c.upper, &c.upper_two_sided}) *v *= unit;
    if (const auto* g = std::get_if<noise::GaussMarkov>(&f.model.processes[i])) {
      c.shape = c.shape_lower = c.shape_upper = g->correlation_time;
      if (f.model.search_time) c.shape_lower = f.time_lower, c.shape_upper = f.time_upper;
    }
    result.coefficients.push_back(c);
  }
  if (f.model.ramp) result.coefficients.push_back(ramp_coefficient(f, unit, cuts, options.intervals));
  if (f.model.line) result.coefficients.push_back(line_coefficient(f, t, !options.frequency_hz));
  for (const Term asked : options.terms) {
    const bool listed = std::any_of(result.coefficients.begin(), result.coefficients.end(),
                                    [=](const auto& c) { return c.term == asked; });
    if (!listed) result.coefficients.push_back({.term = asked});
  }
  complete(result.coefficients);
}

void add_front_end(Result& result, const Fitted& f) {
  if (!f.model.front_end) return;
  const noise::FrontEnd& front_end = *f.model.front_end;
  FittedFrontEnd found{.kind = front_end.kind,
                       .sampling = front_end.sampling,
                       .oversampling = front_end.oversampling,
                       .fitted = f.tilt.has_value(),
                       .choice = f.model.front_end_choice};
  found.bandwidth = front_end.bandwidth;
  if (f.tilt) found.bandwidth = noise::in_range(found.bandwidth * std::exp(f.tilt->x), f.flat->bins().dt);
  found.lower = found.bandwidth * std::exp(-kScatter95 * f.tilt_deviation);
  found.upper = found.bandwidth * std::exp(kScatter95 * f.tilt_deviation);
  result.front_end = found;
}

void judge_fit(Result& result, const Fitted& f, const Options& options) {
  result.chi2 = f.chi2;
  result.dof = f.dof;
  result.p_value = f.p_value;
  result.spectrum = f.spectrum;
  for (const SpectralResidual& r : f.spectrum) {
    const double beyond = std::abs(r.misfit) - kScatter95 * r.relative_std;
    if (beyond > result.worst_misfit) result.worst_misfit = beyond, result.worst_misfit_tau_s = 0.5 / r.frequency_hz;
  }
  result.verdict = verdict_of(result, options);
}

void add_moves(Result& result, const Fitted& f, const Transformed& t, const Options& options) {
  if (options.tau_min_s || f.last + 1 == t.used.count) return;
  Options values = options;
  values.intervals = false;
  const Fitted whole = fit_band(t, {1, t.used.count - 1}, values, filter_of(options), false);
  for (std::size_t i = 0; i < whole.model.processes.size(); ++i) {
    const Term term = noise::term(whole.model.processes[i]);
    const Coefficient& now = result[term];
    const double from = std::sqrt(whole.point.theta(static_cast<Eigen::Index>(i))) * t.unit;
    result.moved.push_back({term, from, now.fitted ? now.value : 0});
  }
}

void check(double dt, const Options& options) {
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("sample interval {} s must be positive and finite", dt));
  const auto time = options.correlation_time_s;
  if (time && (!(*time > 0) || !std::isfinite(*time)))
    throw std::invalid_argument(fmt::format("correlation time {} s must be positive and finite", *time));
  const auto frequency = options.frequency_hz;
  if (frequency && !(*frequency > 0 && *frequency < 0.5 / dt)) {
    throw std::invalid_argument(
        fmt::format("frequency {} Hz must be between 0 and {} Hz, half the rate", *frequency, 0.5 / dt));
  }
  const auto terms = in_order(options.terms);
  if (std::all_of(terms.begin(), terms.end(), [](Term t) { return t == Term::rate_ramp || t == Term::sinusoid; }))
    throw std::invalid_argument("a ramp or a line alone has no likelihood: add a random term, such as N");
}

}  // namespace

Result fit_likelihood(std::span<const double> rate, double dt, const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  check(dt, options);
  const Transformed t = transform_record(rate, dt);
  if (t.coefficients.empty()) {
    Result none = no_answer(Method::whittle, options.terms);
    none.first_sample = t.used.first, none.samples = t.used.count;
    return none;
  }
  const Fitted f = choose_band(t, options);
  Result result;
  result.method = Method::whittle;
  result.first_sample = t.others.empty() ? t.used.first : std::min(t.used.first, t.others.front().used.first);
  result.samples = t.samples();
  result.stretches = static_cast<std::int64_t>(t.others.size()) + 1;
  result.filled_share = t.missing_share;
  result.fitted_terms = f.model.terms;
  result.converged = f.point.converged;
  result.iterations = f.point.iterations;
  result.log_likelihood = -0.5 * f.point.cost;
  add_coefficients(result, f, t, options);
  add_covariance(result, f, t.unit);
  shift_white(result, f.model.front_end_choice);
  const double n = static_cast<double>(t.used.count);
  result.tau_min_s = f.last + 1 == t.used.count ? dt : n * dt / static_cast<double>(f.last);
  result.tau_max_s = options.tau_max_s.value_or(0.5 * n * dt);
  add_front_end(result, f);
  judge_fit(result, f, options);
  add_moves(result, f, t, options);
  add_beta(result);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

std::optional<FoundFrontEnd> find_front_end(std::span<const double> rate, double dt, const Options& options) {
  check(dt, options);
  const Transformed t = transform_record(rate, dt);
  return t.coefficients.empty() ? std::nullopt : seen_front_end(t, options);
}

namespace {

double agreement_limit(Term term, const Result& gls) {
  const Coefficient& K = gls[Term::rate_random_walk];
  constexpr double kWellSeen = 0.13, kMost = 4;
  const double scale = K.fitted ? std::clamp(K.relative_std / kWellSeen, 1.0, kMost) : 1;
  return scale * (term == Term::white ? 0.35 : term == Term::flicker ? 0.6 : 0.8);
}

// What gaps add: both fits lose samples, but not the same. Over 200 records of 12 000 samples, 0.5 to 8 % of them
// missing one by one, the differences scattered by 1.6 to 1.9 (N), 1.7 to 3.2 (B) and 0.8 to 1.7 (K) times the root of
// that share. Of stretches the likelihood does not see what passes from one to the next: the difference of two
// estimates of which one knows all that the other does has the difference of their variances.
double room_for_gaps(Term term, double narrow_over_wide, const Result& whittle) {
  constexpr double kLimit = 3.1;  // two-sided 0.2 %
  const double scatter = (term == Term::flicker ? 3 : 2) * std::sqrt(whittle.filled_share);
  const double lost = whittle.stretches > 1 ? std::sqrt(std::max(0.0, 1 - narrow_over_wide * narrow_over_wide)) : 0;
  return kLimit * std::hypot(scatter, lost);
}

}  // namespace

CrossCheck cross_check(const Result& gls, const Result& whittle) {
  constexpr double kWidth95 = 2 * kScatter95;
  CrossCheck result;
  const double octaves = std::abs(std::log2(gls.tau_min_s / whittle.tau_min_s));
  result.same_range = octaves < 0.5;
  for (const Coefficient& a : gls.coefficients) {
    const auto b = std::find_if(whittle.coefficients.begin(), whittle.coefficients.end(),
                                [&](const auto& c) { return c.term == a.term; });
    if (b == whittle.coefficients.end() || !a.fitted || !b->fitted) continue;
    // Ratios to the larger limit: squares of the coefficients may leave double.
    const double unit = std::max(a.upper_two_sided, b->upper_two_sided);
    if (!std::isfinite(unit)) continue;  // one of them knows no limit: nothing to compare
    const auto square = [=](double c) { return (c / unit) * (c / unit); };
    const auto width = [&](const Coefficient& c) { return square(c.upper_two_sided) - square(c.lower); };
    Agreement x{.term = a.term, .first = a.value, .second = b->value};
    x.difference = std::abs(square(a.value) - square(b->value)) * kWidth95 / std::max(width(a), width(*b));
    const auto [narrow, wide] = std::minmax(width(a), width(*b));
    x.limit = std::hypot(agreement_limit(a.term, gls), room_for_gaps(a.term, narrow / wide, whittle));
    x.agrees = x.difference <= x.limit;
    result.agrees = result.agrees && x.agrees;
    result.coefficients.push_back(x);
  }
  return result;
}

}  // namespace gyrobudget::inline v0::fit

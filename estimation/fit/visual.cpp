// SPDX-License-Identifier: MIT
#include "visual.h"

#include "gyrobudget/allan/confidence.h"
#include "gyrobudget/estimation/fit/detail/judge.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
using Clock = std::chrono::steady_clock;

struct Reading {
  std::int64_t m = 1;
  double tau = 0;
  double deviation = 0;
};

std::vector<Reading> readable_points(const allan::Curve& curve) {
  std::vector<Reading> points;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const auto& p = curve.points[i];
    if (p.terms > 0 && p.variance > 0) points.push_back({p.m, curve.tau(i), std::sqrt(p.variance)});
  }
  if (points.size() < 2) throw std::invalid_argument("a visual reading needs at least two taus with a deviation");
  return points;
}

double slope(const Reading& a, const Reading& b) {
  return std::log(b.deviation / a.deviation) / std::log(b.tau / a.tau);
}

// The deviation at 1 s by interpolation in log-log, or along -1/2 from the nearer end.
Reading read_white(const std::vector<Reading>& points) {
  const auto after = std::partition_point(points.begin(), points.end(), [](const auto& p) { return p.tau < 1; });
  if (after == points.begin() || after == points.end()) {
    const Reading& end = after == points.begin() ? points.front() : points.back();
    return {end.m, 1, end.deviation * std::sqrt(end.tau)};
  }
  const Reading& a = *(after - 1);
  const Reading& b = *after;
  return {b.m, 1, a.deviation * std::pow(1 / a.tau, slope(a, b))};
}

std::size_t minimum_index(const std::vector<Reading>& points, std::int64_t samples) {
  std::size_t best = 0;
  for (std::size_t i = 0; i < points.size() && points[i].m * 10 <= samples; ++i) {
    if (points[i].deviation < points[best].deviation) best = i;
  }
  return best;
}

// The point right of the minimum whose local slope (to both neighbours) is nearest +1/2, moved to 3 s.
Reading read_walk(const std::vector<Reading>& points, std::size_t minimum) {
  std::size_t best = points.size() - 1;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t i = minimum + 1; i + 1 < points.size(); ++i) {
    const double distance = std::abs(slope(points[i - 1], points[i + 1]) - 0.5);
    if (distance < nearest) nearest = distance, best = i;
  }
  const Reading& p = points[best];
  return {p.m, 3, p.deviation * std::sqrt(3 / p.tau)};
}

Coefficient coefficient(Term term, const Reading& reading, double value, const allan::Curve& curve) {
  const std::array mix{noise::unit_process(term)};
  const double edf = allan::equivalent_dof(curve.samples, reading.m, curve.dt, mix, curve.form, curve.mask.get());
  const auto interval = allan::chi_square_interval(value * value, edf);
  Coefficient c;
  c.term = term;
  c.fitted = true;
  c.value = value;
  c.lower = std::sqrt(interval.lower);
  c.upper = c.upper_two_sided = std::sqrt(interval.upper);
  c.relative_std = 1 / std::sqrt(2 * edf);
  c.boundary_test = std::numeric_limits<double>::quiet_NaN();
  c.status = Status::identified;
  return c;
}

void compare_with_model(Result& result, const std::vector<Reading>& points, const allan::Curve& curve,
                        const Options& options) {
  const auto mix = result.processes();
  for (const auto& p : points) {
    Residual r{.m = p.m, .tau_s = p.tau, .measured = p.deviation, .used = true};
    r.model = std::sqrt(noise::allan_variance(mix, p.m, curve.dt));
    r.relative_std =
        1 / std::sqrt(2 * allan::equivalent_dof(curve.samples, p.m, curve.dt, mix, curve.form, curve.mask.get()));
    r.misfit = r.measured / r.model - 1;
    const double beyond = std::abs(r.misfit) - 1.96 * r.relative_std;
    if (p.m * 16 <= curve.samples && beyond > result.worst_misfit) {
      result.worst_misfit = beyond, result.worst_misfit_tau_s = r.tau_s;
    }
    result.residuals.push_back(r);
  }
  result.verdict = result.worst_misfit <= options.misfit_limit ? Verdict::described_within : Verdict::not_described;
}

// The point whose slope to the next is nearest to `wanted`.
const Reading& tangent_point(const std::vector<Reading>& points, double wanted) {
  std::size_t best = 0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const auto distance = [&](std::size_t j) { return std::abs(slope(points[j], points[j + 1]) - wanted); };
    if (distance(i) < distance(best)) best = i;
  }
  return points[best];
}

Reading along(const Reading& p, double slope_of_line, double tau) {
  return {p.m, tau, p.deviation * std::pow(tau / p.tau, slope_of_line)};
}

struct Readings {
  Reading white, flat, walk;
};

Result result_of(Method method, const Readings& read, const std::vector<Reading>& points, const allan::Curve& curve,
                 const Options& options, Clock::time_point start) {
  const double flat_of_one = std::sqrt(2 * std::numbers::ln2 / std::numbers::pi);
  Result result;
  result.method = method;
  result.coefficients = {coefficient(Term::white, read.white, read.white.deviation, curve),
                         coefficient(Term::flicker, read.flat, read.flat.deviation / flat_of_one, curve),
                         coefficient(Term::rate_random_walk, read.walk, read.walk.deviation, curve)};
  complete(result.coefficients);
  result.fitted_terms = {Term::white, Term::flicker, Term::rate_random_walk};
  result.covariance = Eigen::MatrixXd::Zero(3, 3);
  for (Eigen::Index j = 0; j < 3; ++j) {
    const Coefficient& c = result[result.fitted_terms[static_cast<std::size_t>(j)]];
    result.covariance(j, j) = std::pow(c.relative_std * c.value, 2);
  }
  const Reading& minimum = points[minimum_index(points, curve.samples)];
  result.tau_min_s = points.front().tau;
  result.tau_max_s = points.back().tau;
  result.p_value = std::numeric_limits<double>::quiet_NaN();
  result.minimum_deviation = minimum.deviation;
  result.minimum_tau_s = minimum.tau;
  add_beta(result);
  result.converged = true;
  compare_with_model(result, points, curve, options);
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return result;
}

}  // namespace

Result read_visually(const allan::Curve& curve, const Options& options) {
  const auto start = Clock::now();
  const auto points = readable_points(curve);
  const std::size_t minimum = minimum_index(points, curve.samples);
  const Readings read{read_white(points), points[minimum], read_walk(points, minimum)};
  return result_of(Method::visual, read, points, curve, options, start);
}

Result read_slopes(const allan::Curve& curve, const Options& options) {
  const auto start = Clock::now();
  const auto points = readable_points(curve);
  const Readings read{along(tangent_point(points, -0.5), -0.5, 1), tangent_point(points, 0),
                      along(tangent_point(points, 0.5), 0.5, 3)};
  return result_of(Method::slope, read, points, curve, options, start);
}

}  // namespace gyrobudget::inline v0::fit

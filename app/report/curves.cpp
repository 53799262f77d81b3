// SPDX-License-Identifier: MIT
#include "curves.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/noise/process.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using fit::Coefficient;
using fit::Status;
using noise::Term;

constexpr std::int64_t kCurvePoints = 120;
/// Reading points further than this below the measured minimum would squeeze the curve; they are not shown.
constexpr double kDeepestMark = 30;
/// Top of the Allan deviation of a Gauss-Markov process, over Tc and sigma, and of a line, over 1/f and the amplitude.
constexpr double kMarkovTop = 1.8926, kMarkovHeight = 0.61736, kLineTop = 0.37101, kLineHeight = 0.72461;

/// Averaging factors of the curves: the span of the measured points, filled evenly in log m.
std::vector<std::int64_t> curve_factors(const std::vector<allan::DeviationPoint>& points) {
  const std::int64_t first = points.front().m, last = points.back().m;
  std::vector<std::int64_t> factors = allan::log_factors(2 * last, kCurvePoints);
  std::erase_if(factors, [&](std::int64_t m) { return m <= first || m >= last; });
  factors.insert(factors.begin(), first);
  if (last > first) factors.push_back(last);
  return factors;
}

bool is_limit(const Coefficient& c) { return c.status == Status::upper_bound && std::isfinite(c.upper); }

/// The coefficient whose line is drawn: the value, or the limit of one that is only bounded; 0 for none.
double drawn_value(const Coefficient& c) {
  if (!c.fitted || c.status == Status::not_quotable) return 0;
  return is_limit(c) ? c.upper : c.value;
}

std::vector<double> deviations(const Coefficient& c, double value, const std::vector<std::int64_t>& factors,
                               double dt) {
  const auto process = process_of(c, value);
  std::vector<double> result;
  result.reserve(factors.size());
  for (const std::int64_t m : factors) result.push_back(std::sqrt(noise::allan_variance(process, m, dt)));
  return result;
}

void add_model(AxisCurves& curves, const AxisResult& axis, const std::vector<std::int64_t>& factors, double dt) {
  std::vector<double> variance(factors.size(), 0.0);
  for (const Term term : reading_order()) {
    const Coefficient* c = find(*axis.fit, term);
    if (c == nullptr || !(drawn_value(*c) > 0)) continue;
    const double drawn = drawn_value(*c);
    curves.terms.push_back({term, is_limit(*c), drawn, deviations(*c, drawn, factors, dt)});
    const auto own = deviations(*c, c->value, factors, dt);
    for (std::size_t i = 0; i < own.size(); ++i) variance[i] += own[i] * own[i];
  }
  if (curves.terms.empty()) return;
  for (const double v : variance) curves.model.push_back(std::sqrt(v));
}

/// Averaging time at which the line of a term reads the coefficient in SI, as IEEE Std 952 has it; for flicker, where
/// white noise and random walk cover it least.
/// For G and S, the top of their hump.
double reading_tau(const AxisResult& axis, const Coefficient& c) {
  switch (c.term) {
    case Term::gauss_markov:
      return kMarkovTop * c.shape;
    case Term::sinusoid:
      return kLineTop / c.shape;
    case Term::white:
      return 1;
    case Term::rate_random_walk:
      return 3;
    case Term::quantization:
      return std::numbers::sqrt3;
    case Term::rate_ramp:
      return std::numbers::sqrt2;
    default:
      break;
  }
  const Coefficient* white = find(*axis.fit, Term::white);
  const Coefficient* walk = find(*axis.fit, Term::rate_random_walk);
  const bool crossing = white && walk && white->value > 0 && walk->value > 0;
  return crossing ? std::numbers::sqrt3 * white->value / walk->value : axis.fit->minimum_tau_s;
}

/// What the line of a term reads there, over its coefficient.
double reading_height(Term term) {
  if (term == Term::flicker) return kFlickerFloor;
  if (term == Term::gauss_markov) return kMarkovHeight;
  return term == Term::sinusoid ? kLineHeight : 1;
}

std::string reading_text(const AxisResult& axis, const Coefficient& c, double deviation) {
  const bool hump = c.term == Term::gauss_markov || c.term == Term::sinusoid;
  return fmt::format("{} = {}: {} reads {}", static_cast<char>(c.term),
                     in_unit(c.value, noise::datasheet_unit(axis.signal, c.term)),
                     c.term == Term::flicker ? "the floor 0.664 B"
                     : hump                  ? "the top of its hump"
                                             : "its line",
                     in_unit(deviation, noise::datasheet_unit(axis.signal)));
}

std::string minimum_mark_text(const AxisResult& axis) {
  const auto unit = noise::datasheet_unit(axis.signal);
  return fmt::format("raw minimum {}; over 0.664: {}", in_unit(axis.fit->minimum_deviation, unit),
                     in_unit(axis.fit->minimum_deviation / kFlickerFloor, unit));
}

/// Where the coefficient can be read; only those that the record gives are marked: a limit is a line without a point.
std::optional<Mark> reading_mark(const AxisCurves& curves, const AxisResult& axis, const Coefficient& c) {
  if (!c.fitted || c.status != Status::identified || !(c.value > 0)) return std::nullopt;
  const double tau = reading_tau(axis, c);
  if (!(tau >= curves.tau_low_s && tau <= curves.tau_high_s)) return std::nullopt;
  const double deviation = c.value * reading_height(c.term);
  if (deviation * kDeepestMark < axis.fit->minimum_deviation) return std::nullopt;
  return Mark{std::string(1, static_cast<char>(c.term)), tau, deviation, reading_text(axis, c, deviation)};
}

void add_marks(AxisCurves& curves, const AxisResult& axis) {
  for (const Term term : reading_order()) {
    const Coefficient* c = find(*axis.fit, term);
    if (c == nullptr || !is_quotable(*axis.fit)) continue;
    if (auto mark = reading_mark(curves, axis, *c)) curves.marks.push_back(std::move(*mark));
  }
  if (axis.fit->minimum_deviation > 0) {
    curves.marks.push_back({"min", axis.fit->minimum_tau_s, axis.fit->minimum_deviation, minimum_mark_text(axis)});
  }
}

/// The measured curve fills the picture; intervals of the last few points may run out of it.
void set_range(AxisCurves& curves, const AxisResult& axis) {
  constexpr double kMargin = 1.6, kBandMargin = 3;
  curves.tau_low_s = axis.points.front().tau_s;
  curves.tau_high_s = axis.points.back().tau_s;
  double low = std::numeric_limits<double>::infinity(), high = 0, band_low = low, band_high = 0;
  const auto take = [](double value, double& least, double& most) {
    if (!(value > 0) || !std::isfinite(value)) return;
    least = std::min(least, value);
    most = std::max(most, value);
  };
  for (const allan::DeviationPoint& p : axis.points) {
    take(p.deviation, low, high);
    take(p.lower, band_low, band_high);
    take(p.upper, band_low, band_high);
  }
  if (high == 0) return;
  curves.deviation_low = std::max(band_low, low / kBandMargin);
  curves.deviation_high = std::min(band_high, high * kBandMargin);
  curves.deviation_low = std::min(curves.deviation_low, low) / kMargin;
  curves.deviation_high = std::max(curves.deviation_high, high) * kMargin;
}

}  // namespace

std::string term_text(noise::Signal signal, const TermCurve& curve, std::string_view unit) {
  return fmt::format("{}: {} {} {}", noise::label(signal, curve.term), static_cast<char>(curve.term),
                     curve.limit ? "<" : "=", in_unit(curve.coefficient, unit, 3));
}

AxisCurves axis_curves(const AxisResult& axis, double rate_hz) {
  AxisCurves curves;
  if (axis.points.empty()) return curves;
  set_range(curves, axis);
  const auto factors = curve_factors(axis.points);
  const double dt = 1 / rate_of(axis, rate_hz);
  for (const std::int64_t m : factors) curves.tau_s.push_back(static_cast<double>(m) * dt);
  if (!axis.fit) return curves;
  add_model(curves, axis, factors, dt);
  add_marks(curves, axis);
  for (const Mark& mark : curves.marks) {
    constexpr double kMarkMargin = 1.8;
    curves.deviation_low = std::min(curves.deviation_low, mark.deviation / kMarkMargin);
    curves.deviation_high = std::max(curves.deviation_high, mark.deviation * kMarkMargin);
  }
  return curves;
}

std::vector<allan::DeviationPoint> thinned(const std::vector<allan::DeviationPoint>& points, std::size_t limit) {
  if (points.size() <= limit || limit < 3) return points;
  const double span = std::log(points.back().tau_s / points.front().tau_s);
  const double step = span / static_cast<double>(limit - 2);
  std::vector<allan::DeviationPoint> kept{points.front()};
  for (const allan::DeviationPoint& p : points) {
    if (std::log(p.tau_s / kept.back().tau_s) >= step) kept.push_back(p);
  }
  if (kept.back().m != points.back().m) kept.push_back(points.back());
  return kept;
}

}  // namespace gyrobudget::inline v0::report

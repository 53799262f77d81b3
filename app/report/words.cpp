// SPDX-License-Identifier: MIT
#include "words.h"

#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "curves.h"

namespace gyrobudget::inline v0::report {
namespace {

using fit::Coefficient;
using fit::Method;
using fit::Status;
using fit::Verdict;
using noise::Signal;
using noise::Term;

/// Below this, the crossing of white noise and rate random walk lies so far above the flicker floor that the curve
/// hardly shows it (relative std of B about 0.74/beta/sqrt(T f*)).
constexpr double kCoveredBeta = 0.3;

int leading_exponent(double value) { return static_cast<int>(std::floor(std::log10(std::abs(value)))); }

bool needs_exponent(double magnitude) { return magnitude != 0 && (magnitude < 1e-4 || magnitude >= 1e6); }

/// Where to cut the digits of a coefficient, its interval and its standard deviation.
struct Resolution {
  int exponent = 0;  ///< common power of ten, 0 for fixed notation
  int decimals = 0;  ///< after dividing by it
};

Resolution resolution(double size, double step) {
  constexpr int kMostDecimals = 12;
  constexpr double kSmallestFixed = 1e-3, kLargestFixed = 1e6;
  Resolution result;
  if (size < kSmallestFixed || size >= kLargestFixed) result.exponent = leading_exponent(size);
  result.decimals = std::clamp(result.exponent + 1 - leading_exponent(step), 0, kMostDecimals);
  return result;
}

std::string fixed(double value, const Resolution& r) {
  if (value == 0) return "0";
  return fmt::format("{:.{}f}", value / std::pow(10.0, r.exponent), r.decimals);
}

std::string with_exponent(const std::string& text, const Resolution& r) {
  return r.exponent == 0 ? text : fmt::format("({})e{:+03d}", text, r.exponent);
}

double si_per_datasheet_unit(Signal signal, Term term) {
  return noise::parse_unit(noise::datasheet_unit(signal, term)).to_si;
}

/// A deviation or bias in the datasheet unit of the signal, with it.
std::string rate_text(Signal signal, double si, int digits = 3) {
  return in_unit(si, noise::datasheet_unit(signal), digits);
}

std::string quantity(Signal signal, Term term, double si, int digits = 3) {
  return in_unit(si, noise::datasheet_unit(signal, term), digits);
}

/// Whether the coefficients say something of the sensor.
bool is_usable(const fit::Result& fit) { return has_p_value(fit.method) && is_quotable(fit); }

/// Nothing was fitted: every sample is equal, or no term was left.
bool is_empty(const fit::Result& fit) {
  return std::ranges::none_of(fit.coefficients, [](const Coefficient& c) { return c.fitted; });
}

/// The one-sided limit of a coefficient, or that the record sets none.
std::string limit_text(Signal signal, Term term, double upper) {
  if (!std::isfinite(upper)) return "no limit found";
  return fmt::format("at most {} (95 %)", quantity(signal, term, upper));
}

std::string signed_percent(double fraction) {
  return fmt::format("{}{}", fraction < 0 ? '-' : '+', percent(std::abs(fraction)));
}

/// An interval that the record does not close above.
std::string open_interval(double lower) {
  return lower > 0 ? fmt::format("above {}, no limit", number(lower, 2)) : "no limit";
}

std::string cut_range_text(const std::vector<const fit::Residual*>& cut, std::string_view side, double limit) {
  if (cut.empty()) return {};
  const auto& worst = **std::max_element(
      cut.begin(), cut.end(), [](const auto* a, const auto* b) { return std::abs(a->misfit) < std::abs(b->misfit); });
  return fmt::format("Not used: {} averaging {} {} {}, where the curve departs from the model by up to {} (at {}). ",
                     cut.size(), cut.size() == 1 ? "time" : "times", side, tau_text(limit),
                     signed_percent(worst.misfit), tau_text(worst.tau_s));
}

bool is_moved(const AxisResult& axis) { return axis.findings && axis.findings->not_at_rest(); }
bool is_mixed(const AxisResult& axis) { return axis.findings && axis.findings->not_of_one_sensor(); }
bool is_rounded(const AxisResult& axis) { return axis.findings && axis.findings->rounded_above_noise(); }

std::string move_text(Signal signal, const fit::Move& move) {
  const auto unit = noise::datasheet_unit(signal, move.term);
  std::string text = fmt::format("{} from {} to {}", noise::label(signal, move.term),
                                 number(noise::from_si(move.from, unit)), quantity(signal, move.term, move.to, 4));
  constexpr double kVisible = 5e-4;
  if (move.from > 0 && std::abs(move.to / move.from - 1) < kVisible) return text + " (unchanged)";
  return move.from > 0 ? text + fmt::format(" ({})", signed_percent(move.to / move.from - 1)) : text;
}

}  // namespace

std::string number(double value, int digits) {
  if (std::isnan(value)) return "-";
  if (std::isinf(value)) return value > 0 ? "infinite" : "-infinite";
  if (value == 0) return "0";
  if (needs_exponent(std::abs(value))) return fmt::format("{:.{}e}", value, digits - 1);
  return fmt::format("{:.{}f}", value, std::max(0, digits - 1 - leading_exponent(value)));
}

std::string in_unit(double si, std::string_view unit, int digits) {
  const std::string value = number(noise::from_si(si, unit), digits);
  return unit == "1" ? value : fmt::format("{} {}", value, unit);
}

std::string percent(double fraction) {
  const double percents = 100 * fraction;
  if (!std::isfinite(percents)) return "-";
  return std::abs(percents) >= 10 ? fmt::format("{:.0f} %", percents) : number(percents, 2) + " %";
}

std::string probability_text(double p_value) {
  if (p_value < 1e-300) return "p < 1e-300";
  return p_value < 1e-3 ? fmt::format("p = {:.1e}", p_value) : fmt::format("p = {}", number(p_value, 2));
}

std::string tau_text(double seconds) {
  constexpr double kFourDigits = 1e4;  // above, {:.4g} would switch to powers of ten
  return seconds < kFourDigits ? fmt::format("{:.4g} s", seconds) : fmt::format("{:.0f} s", seconds);
}

std::string si_unit(const noise::Dimension& dimension) {
  const auto power = [](std::string_view base, int doubled) {
    const int whole = doubled / 2;
    std::string text;
    if (whole == 1) text = base;
    if (whole > 1) text = fmt::format("{}^{}", base, whole);
    if (doubled % 2 != 0) text += fmt::format("{}sqrt({})", whole == 0 ? "" : "*", base);
    return text;
  };
  std::string text;
  const auto multiply = [&](const std::string& factor) { text += text.empty() ? factor : fmt::format("*{}", factor); };
  if (dimension.angle > 0) multiply(power("rad", dimension.angle));
  if (dimension.length > 0) multiply(power("m", dimension.length));
  if (dimension.time > 0) multiply(power("s", dimension.time));
  if (text.empty()) text.push_back('1');
  if (dimension.time < 0) {
    if (const int whole = -dimension.time / 2; whole > 0) text += fmt::format("/{}", power("s", 2 * whole));
    if (dimension.time % 2 != 0) text += "/sqrt(s)";
  }
  return text;
}

CoefficientText coefficient_text(const Coefficient& c, double si_per_unit, std::string unit) {
  if (!c.fitted) return {"-", "-", std::move(unit)};
  if (c.status == Status::not_quotable) return {"-", "-", std::move(unit)};
  const double value = c.value / si_per_unit, lower = c.lower / si_per_unit, upper = c.upper / si_per_unit;
  const double std_dev = c.relative_std * value;
  const bool has_std = std::isfinite(std_dev) && std_dev > 0;
  if (!std::isfinite(upper)) return {number(value), open_interval(lower), std::move(unit)};
  const double size = value > 0 ? value : upper;
  if (!(size > 0)) return {number(value), "-", std::move(unit)};
  const Resolution r = resolution(size, has_std ? std_dev : size / 10);
  const std::string value_text = has_std ? fmt::format("{} ± {}", fixed(value, r), fixed(std_dev, r)) : fixed(value, r);
  return {value == 0 ? "0" : with_exponent(value_text, r),
          with_exponent(fmt::format("{} to {}", fixed(lower, r), fixed(upper, r)), r), std::move(unit)};
}

CoefficientText datasheet_text(Signal signal, const Coefficient& c) {
  return coefficient_text(c, si_per_datasheet_unit(signal, c.term), std::string(noise::datasheet_unit(signal, c.term)));
}

CoefficientText si_text(Signal signal, const Coefficient& c) {
  return coefficient_text(c, 1, si_unit(noise::dimension_of(signal, c.term)));
}

ShapeText shape_text(const Coefficient& c) {
  const bool line = c.term == Term::sinusoid;
  if (!c.fitted || !(c.shape > 0) || (!line && c.term != Term::gauss_markov)) return {};
  const double width = c.shape_upper - c.shape_lower;
  const Resolution r = resolution(c.shape, width > 0 ? width / 4 : c.shape / 1000);
  const auto text = [&](double v) { return with_exponent(fixed(v, r), r); };
  return {line ? "frequency" : "correlation time", text(c.shape),
          width > 0 ? with_exponent(fmt::format("{} to {}", fixed(c.shape_lower, r), fixed(c.shape_upper, r)), r) : "-",
          line ? "Hz" : "s"};
}

CombinedText combined_text(Signal signal, const fit::Combined& c) {
  const auto unit = noise::datasheet_unit(signal, c.term);
  const auto in = [&](double si) { return noise::from_si(si, unit); };
  const double size = in(c.value > 0 ? c.value : c.upper), width = in(c.upper - c.lower);
  CombinedText text{.unit = std::string(unit)};
  const Resolution r = size > 0 ? resolution(size, width > 0 ? width / 4 : size / 1000) : Resolution{};
  const auto digits = [&](double si) { return with_exponent(fixed(in(si), r), r); };
  const auto range = [&](double low, double high) {
    return with_exponent(fmt::format("{} to {}", fixed(in(low), r), fixed(in(high), r)), r);
  };
  text.value = digits(c.value);
  text.interval = range(c.lower, c.upper);
  text.spread = c.records < 2 ? "-" : digits(c.spread);
  text.next = c.records < 3 ? "-" : range(c.next_lower, c.next_upper);
  text.agreement = fmt::format("identified in {} of {}", c.identified, c.records);
  constexpr double kUsual = 0.05;
  if (c.records > 1)
    text.agreement +=
        fmt::format("; {} ({})", c.p_value < kUsual ? "they DIFFER" : "they agree", probability_text(c.p_value));
  return text;
}

const std::vector<Term>& reading_order() {
  static const std::vector<Term> kOrder = {Term::white,        Term::flicker,   Term::rate_random_walk,
                                           Term::quantization, Term::rate_ramp, Term::gauss_markov,
                                           Term::sinusoid};
  return kOrder;
}

noise::Process process_of(const Coefficient& c, double value) {
  if (c.term == Term::gauss_markov) return noise::GaussMarkov{value, c.shape};
  if (c.term == Term::sinusoid) return noise::Sinusoid{value, c.shape};
  return noise::with_coefficient(noise::unit_process(c.term), value);
}

std::string letters(const std::vector<Term>& terms) {
  std::vector<std::string> list;
  for (const Term t : terms) list.emplace_back(1, static_cast<char>(t));
  return text::listing(list);
}

std::string file_name(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  return name.empty() ? path : name;
}

std::string status_text(Signal signal, const Coefficient& c, const fit::Result& fit) {
  if (!c.fitted) return "left out: not fitted";
  if (is_reading(fit.method)) return "read off the curve";
  if (!is_quotable(fit)) return "do not quote";
  const std::string limit = limit_text(signal, c.term, c.upper);
  switch (c.status) {
    case Status::identified:
      return "identified";
    case Status::upper_bound:
      return "upper bound: " + limit;
    case Status::not_quotable:
      return "not quotable";
    case Status::left_out:
      break;
  }
  return "left out: " + limit;
}

std::string cell_text(const AxisResult& axis, Term term) {
  const Coefficient* c = axis.fit ? find(*axis.fit, term) : nullptr;
  if (c == nullptr || !c->fitted || !is_quotable(*axis.fit) || c->status == Status::not_quotable) return "-";
  if (c->status == Status::identified || is_reading(axis.fit->method)) return datasheet_text(axis.signal, *c).value;
  if (!std::isfinite(c->upper)) return "no limit";
  return "< " + number(noise::from_si(c->upper, noise::datasheet_unit(axis.signal, term)), 2);
}

std::vector<Share> variance_shares(const fit::Result& fit, double tau_s, double rate_hz) {
  const std::int64_t m = std::max<std::int64_t>(1, std::llround(tau_s * rate_hz));
  std::vector<Share> shares;
  double total = 0;
  for (const Term term : reading_order()) {
    const Coefficient* c = find(fit, term);
    if (c == nullptr || !c->fitted || !(c->value > 0)) continue;
    shares.push_back({term, noise::allan_variance(process_of(*c, c->value), m, 1 / rate_hz)});
    total += shares.back().part;
  }
  for (Share& share : shares) share.part /= total;
  return shares;
}

std::string record_text(const LogResult& result) {
  std::string text = fmt::format("{} samples at {:.6g} Hz, {}", count_text(result.samples), result.rate_hz,
                                 duration_text(static_cast<double>(result.samples) / result.rate_hz));
  if (result.missing_samples == 0) return text + ", none missing";
  const double part = static_cast<double>(result.missing_samples) / static_cast<double>(result.samples);
  return text + fmt::format(", {} missing ({})", count_text(result.missing_samples), percent(part));
}

bool is_time_deviation(allan::Estimator estimator) {
  return estimator == allan::Estimator::tdev || estimator == allan::Estimator::ttotdev;
}

// Rate times s is what quantization has: an angle.
std::string_view deviation_unit(const AxisResult& axis) {
  return is_time_deviation(axis.estimator) ? noise::datasheet_unit(axis.signal, Term::quantization)
                                           : noise::datasheet_unit(axis.signal);
}

noise::Dimension deviation_dimension(const AxisResult& axis) {
  return is_time_deviation(axis.estimator) ? noise::dimension_of(axis.signal, Term::quantization)
                                           : noise::dimension_of(axis.signal);
}

std::string_view spectrum_unit(noise::Signal signal) {
  switch (signal) {
    case noise::Signal::angular_rate:
      return "deg/h/sqrt(Hz)";
    case noise::Signal::specific_force:
      return "ug/sqrt(Hz)";
    case noise::Signal::dimensionless:
      break;
  }
  return "1/sqrt(Hz)";
}

std::string_view deviation_name(allan::Estimator estimator) {
  using enum allan::Estimator;
  switch (estimator) {
    case mdev:
      return "modified Allan deviation";
    case tdev:
      return "time deviation";
    case hdev:
    case ohdev:
      return "Hadamard deviation";
    case totdev:
      return "total deviation";
    case mtotdev:
      return "modified total deviation";
    case ttotdev:
      return "time total deviation";
    case htotdev:
      return "Hadamard total deviation";
    case theo1:
      return "Theo1 deviation";
    case theobr:
      return "TheoBR deviation";
    case theoh:
      return "TheoH deviation";
    case pdev:
      return "parabolic deviation";
    case adev:
    case oadev:
      break;
  }
  return "Allan deviation";
}

double rate_of(const AxisResult& axis, double rate_hz) {
  return axis.findings && axis.findings->held ? axis.findings->held->rate_hz : rate_hz;
}

std::vector<allan::Estimator> estimators_of(const LogResult& result) {
  std::vector<allan::Estimator> list;
  for (const AxisResult& axis : result.axes) {
    if (std::ranges::find(list, axis.estimator) == list.end()) list.push_back(axis.estimator);
  }
  return list;
}

std::string curve_name(const AxisResult& axis, const LogResult& result) {
  return estimators_of(result).size() < 2 ? axis.name : fmt::format("{}, {}", axis.name, allan::name(axis.estimator));
}

std::string estimator_text(allan::Estimator estimator) {
  using enum allan::Estimator;
  const auto text = [&](std::string_view before, std::string_view after = "") {
    return fmt::format("{}{} ({}){}", before, deviation_name(estimator), allan::name(estimator), after);
  };
  switch (estimator) {
    case adev:
    case hdev:
      return text("", " of adjacent clusters");
    case oadev:
    case ohdev:
      return text("overlapped ");
    case totdev:
    case mtotdev:
    case ttotdev:
    case htotdev:
    case theo1:
      return text("", ", its bias divided out");
    case theobr:
      return text("", ", Theo1 times the record's own ratio to the Allan deviation");
    case theoh:
      return text("", ", Allan to a fifth of the record, TheoBR beyond");
    case mdev:
    case tdev:
    case pdev:
      break;
  }
  return text("");
}

std::string verdict_headline(const fit::Result& fit) {
  if (is_reading(fit.method)) return "read off the curve";
  if (is_empty(fit)) return "nothing to fit";
  if (!fit.converged) return "the fit did not converge";
  if (!is_tested(fit)) return "not tested";
  switch (fit.verdict) {
    case Verdict::described:
      return "described";
    case Verdict::described_within:
      return fit.worst_misfit > 0 ? "described within " + percent(fit.worst_misfit) : "described within the scatter";
    case Verdict::not_described:
      break;
  }
  return "not described";
}

std::string verdict_text(const fit::Result& fit) {
  if (is_empty(fit)) return "No averaging time holds anything that a model could explain.";
  const std::string range = fmt::format("from {} to {}", tau_text(fit.tau_min_s), tau_text(fit.tau_max_s));
  const bool spectral = fit.method == Method::whittle;
  const std::string misfit = fmt::format("{} beyond its 95 % scatter, at {}{}", percent(fit.worst_misfit),
                                         spectral ? "half a period of " : "tau = ", tau_text(fit.worst_misfit_tau_s));
  const std::string worst = fit.worst_misfit > 0 ? "Worst misfit: " + misfit + "."
                                                 : fmt::format("No {} departs by more than its 95 % scatter.",
                                                               spectral ? "band of the spectrum" : "averaging time");
  if (is_reading(fit.method)) return "Three points of the curve were read, as by eye. " + worst;
  if (!has_p_value(fit.method)) {
    return "This method ignores how averaging times are correlated, so it has no p-value. " + worst;
  }
  if (!is_tested(fit)) {
    return "Too few averaging times have the 16 clusters that a test needs; the model was fitted " + range + ".";
  }
  const std::string chance = probability_text(fit.p_value);
  switch (fit.verdict) {
    case Verdict::described:
      return fmt::format(
          "The model explains the {} {}: {}, so a record that follows it exactly would depart this much or more in {} of cases. {}",
          spectral ? "spectrum" : "curve", range, chance, percent(fit.p_value), worst);
    case Verdict::described_within:
      return fmt::format(
          "Chance alone does not explain how the curve departs from the model {} ({}), but the departure is small. {}",
          range, chance, worst);
    case Verdict::not_described:
      break;
  }
  return fmt::format("The model does not describe the curve {}: {}, and it is off by up to {}.", range, chance, misfit);
}

std::string consequence_text(const fit::Result& fit) {
  if (is_empty(fit)) return "This record gives no coefficients.";
  if (is_reading(fit.method)) {
    return "Use these numbers only beside readings of others: the intervals are those of the points read, and B so read holds N and K as well, so it comes out too large. The default fit gives a datasheet.";
  }
  if (!has_p_value(fit.method)) {
    return "Use these numbers only beside fits of others: the default fit is more exact and says whether the model holds.";
  }
  if (!fit.converged) return "Do not use these numbers: the fit stopped before it had settled.";
  if (!is_tested(fit)) return "Nothing here says whether the model fits; take a longer record.";
  switch (fit.verdict) {
    case Verdict::described:
      return fmt::format("Values and intervals can be used as they stand, for averaging times from {} on.",
                         tau_text(fit.tau_min_s));
    case Verdict::described_within:
      if (!(fit.worst_misfit > 0)) return "Use the values; the intervals are widened by the misfit.";
      return fmt::format(
          "Use the values, and allow {} of the deviation for what the model lacks; the intervals are widened by the misfit.",
          percent(fit.worst_misfit));
    case Verdict::not_described:
      break;
  }
  return "Do not quote these coefficients as a datasheet: they are the nearest curve of this kind, and their intervals mean nothing.";
}

std::vector<std::string> spoilt_by(const calibration::Findings& findings) {
  std::vector<std::string> spoilt;
  if (findings.not_at_rest()) spoilt.emplace_back("motion");
  if (findings.not_of_one_sensor()) spoilt.emplace_back("rows of several sensors");
  if (findings.saturation_spoils()) spoilt.emplace_back("cut-off samples");
  if (findings.outliers_spoil()) spoilt.emplace_back("outliers");
  if (findings.steps_spoil()) spoilt.emplace_back("steps");
  if (findings.departure_spoils()) spoilt.emplace_back("a drift");
  return spoilt;
}

std::string verdict_headline(const AxisResult& axis) {
  if (is_moved(axis)) return "not described: the sensor was moved";
  if (is_mixed(axis)) return "not described: rows of several sensors";
  if (is_rounded(axis)) return "not quotable: rounded above the noise";
  return verdict_headline(*axis.fit);
}

std::string verdict_text(const AxisResult& axis) {
  if (is_moved(axis)) return "No noise model describes what moves.";
  if (is_mixed(axis)) return "No noise model describes several sensors together.";
  if (is_rounded(axis)) return "Where the mean lies between two steps decides what is seen of the noise.";
  return verdict_text(*axis.fit);
}

std::string consequence_text(const AxisResult& axis) {
  if (is_moved(axis)) return "Do not quote these coefficients: repeat the record at rest.";
  if (is_mixed(axis)) return "Do not quote these coefficients: read the rows of one sensor.";
  if (is_rounded(axis))
    return axis.findings->rounding->is_dithered_by_wander()
               ? "Log at a finer range, or raw counts. B and K are of long averaging times, over which the mean passes many steps, and can be used."
               : "Log at a finer range, or raw counts; this log cannot give the coefficients.";
  const auto spoilt = axis.findings ? spoilt_by(*axis.findings) : std::vector<std::string>{};
  const bool disputed = axis.cross_checked && !axis.cross_checked->check.agrees;
  if (!is_usable(*axis.fit) || (spoilt.empty() && !disputed)) return consequence_text(*axis.fit);
  std::string text;
  if (!spoilt.empty()) {
    text = fmt::format("Do not use these numbers yet: the record holds {} that the fit took for noise; see below.",
                       text::listing(spoilt));
  }
  if (disputed) text += fmt::format("{}The likelihood does not confirm the fit.", text.empty() ? "" : " ");
  return text;
}

namespace {

// What the minimum is made of; terms that the record does not tell from zero have no share that could be quoted.
std::string shares_text(const AxisResult& axis, double rate_hz) {
  const fit::Result& fit = *axis.fit;
  std::vector<std::string> parts, open;
  double unresolved = 0;
  for (const Share& s : variance_shares(fit, fit.minimum_tau_s, rate_hz)) {
    if (find(fit, s.term)->status == Status::identified) {
      parts.push_back(fmt::format("{} {}", noise::label(axis.signal, s.term), percent(s.part)));
    } else {
      open.emplace_back(noise::label(axis.signal, s.term));
      unresolved += s.part;
    }
  }
  if (parts.empty()) return {};
  constexpr double kShown = 0.005;
  std::string text = fmt::format(" It is not B: the minimum holds every term; by variance, {}", text::listing(parts));
  if (unresolved > kShown) {
    text += fmt::format("; the fit puts the other {} on {}, which this record does not resolve", percent(unresolved),
                        text::listing(open));
  }
  return text + '.';
}

}  // namespace

std::vector<TemperatureRow> temperature_rows(const AxisResult& axis) {
  std::vector<TemperatureRow> rows;
  if (!axis.temperature) return rows;
  const std::string signal(noise::datasheet_unit(axis.signal));
  const auto over = [&](const char* kelvin) {
    return signal == "1" ? fmt::format("1/{}", kelvin) : signal + "/" + kelvin;
  };
  const auto add = [&](const char* key, const char* label, const calibration::TemperatureCoefficient& c,
                       const std::string& unit) {
    TemperatureRow row{.key = key, .label = label, .unit = unit, .unit_si = noise::parse_unit(unit).to_si};
    row.coefficient = &c;
    const double width = (c.upper - c.lower) / row.unit_si;
    const Resolution r =
        width > 0 ? resolution(std::max(std::abs(c.value), c.upper - c.lower) / row.unit_si, width / 4) : Resolution{};
    const auto digits = [&](double si) { return fixed(si / row.unit_si, r); };
    row.value = c.fitted ? with_exponent(digits(c.value), r) : "-";
    row.interval = c.fitted ? with_exponent(fmt::format("{} to {}", digits(c.lower), digits(c.upper)), r) : "-";
    rows.push_back(std::move(row));
  };
  const calibration::Temperature& t = *axis.temperature;
  add("bias", "bias at the reference", t.bias, signal);
  add("linear", "bias over temperature", t.linear, over("K"));
  add("quadratic", "bias over its square", t.quadratic, over("K^2"));
  add("rate", "bias over its rate", t.rate, over("(K/min)"));
  return rows;
}

std::string temperature_text(const AxisResult& axis) {
  if (!axis.temperature || !axis.temperature->bias.fitted) return {};
  const calibration::Temperature& t = *axis.temperature;
  std::string text =
      fmt::format("The temperature went from {:.1f} to {:.1f} degC; the reference is its mean, {:.2f} degC.", t.lowest,
                  t.highest, t.reference);
  if (!t.rate.fitted)
    text +=
        " The record cannot tell what the rate of the temperature does: it goes with the temperature itself, or the temperature is too coarse to have one.";
  if (!t.quadratic.fitted) text += " Nor can it tell a square.";
  if (!t.removed)
    return text + fmt::format(" No dependence is seen beside the noise ({}); nothing was taken off.",
                              probability_text(t.p_value));
  text += fmt::format(
      " It explains {} of the variance of the means of {} ({}), and was taken off: curve and fit are of what is left.",
      percent(t.explained), tau_text(t.points.size() > 1 ? t.points[1].time_s - t.points[0].time_s : 0),
      probability_text(t.p_value));
  std::vector<std::string> moves;
  for (const Term term : {Term::white, Term::flicker, Term::rate_random_walk}) {
    const Coefficient *before = find(t.before, term), *after = axis.fit ? find(*axis.fit, term) : nullptr;
    if (before == nullptr || after == nullptr || !before->fitted || !after->fitted) continue;
    if (after->status == Status::not_quotable) continue;
    moves.push_back(fmt::format("{} was {} and is {}", noise::label(axis.signal, term),
                                quantity(axis.signal, term, before->value), quantity(axis.signal, term, after->value)));
  }
  if (!moves.empty()) text += fmt::format(" By that {}.", text::listing(moves));
  return text;
}

std::string minimum_text(const AxisResult& axis, double rate_hz) {
  if (!axis.fit || !(axis.fit->minimum_deviation > 0)) return {};
  const fit::Result& fit = *axis.fit;
  std::string text = fmt::format(
      "Raw minimum of the curve up to a tenth of the record: {} at {}. Makers often quote it, or it divided by 0.664 ({}), as bias instability.",
      rate_text(axis.signal, fit.minimum_deviation), tau_text(fit.minimum_tau_s),
      rate_text(axis.signal, fit.minimum_deviation / kFlickerFloor));
  if (!is_usable(fit)) return text;
  if (is_rounded(axis)) return text;
  text += shares_text(axis, rate_of(axis, rate_hz));
  const Coefficient* flicker = find(fit, Term::flicker);
  if (flicker == nullptr || !flicker->fitted) return text;
  if (flicker->status == Status::identified) {
    return text + fmt::format(" The flicker floor alone, 0.664 B, is {}.",
                              rate_text(axis.signal, flicker->value * kFlickerFloor));
  }
  if (!std::isfinite(flicker->upper)) return text + " The record sets no limit to the flicker floor alone.";
  return text + fmt::format(" The flicker floor alone, 0.664 B, is at most {} (95 %).",
                            rate_text(axis.signal, flicker->upper * kFlickerFloor));
}

std::string beta_text(const fit::Result& fit) {
  if (!(fit.beta > 0) || !is_usable(fit)) return {};
  for (const Term t : {Term::white, Term::rate_random_walk}) {  // else there is no crossing to see B beside
    const Coefficient* c = find(fit, t);
    if (c == nullptr || c->status != Status::identified) return {};
  }
  const std::string text = fmt::format("beta = B^2/(N K) = {}: ", number(fit.beta, 3));
  const Coefficient* flicker = find(fit, Term::flicker);
  if (flicker != nullptr && flicker->status != Status::identified) {
    return text + "the flicker floor does not stand out from the crossing of N and K; quote the limit of B.";
  }
  if (fit.beta < kCoveredBeta) {
    return text + "below about 0.3, N and K cover the flicker floor; only a much longer record can tell B well.";
  }
  if (fit.beta < 1) {
    return text + "N and K cover part of the flicker floor; B can be told, with a wide interval.";
  }
  return text + "above 1 the flicker floor shows in the curve; B can be told well.";
}

std::string front_end_text(const fit::Result& fit) {
  if (!fit.front_end) return {};
  const fit::FittedFrontEnd& f = *fit.front_end;
  const std::string hides = " Quantization behind a low pass cannot be told from it and is left out.";
  if (!f.kind) {
    return fmt::format(
               "Front end: short averaging times show a low pass of a kind that cannot be told, with a bandwidth of about {} Hz (95 %: {} to {} Hz).",
               number(f.bandwidth, 2), number(f.lower, 2), number(f.upper, 2)) +
           hides;
  }
  const std::string kind = *f.kind == noise::FrontEnd::Kind::first_order    ? "a low pass of first order"
                           : *f.kind == noise::FrontEnd::Kind::second_order ? "a low pass of second order (Butterworth)"
                                                                            : "a moving average";
  if (!f.fitted) return fmt::format("Front end: {} of {} Hz, as given.", kind, number(f.bandwidth)) + hides;
  const Resolution r = resolution(f.bandwidth, (f.upper - f.lower) / 4);
  return fmt::format(
             "Front end: {} with a bandwidth of {} Hz (95 %: {} to {} Hz). N is the density of the noise at frequencies that it passes.",
             kind, fixed(f.bandwidth, r), fixed(f.lower, r), fixed(f.upper, r)) +
         hides;
}

std::string cut_text(const AxisResult& axis) {
  if (!axis.fit) return {};
  const fit::Result& fit = *axis.fit;
  std::vector<const fit::Residual*> below, above;
  for (const fit::Residual& r : fit.residuals) {
    if (!r.used && r.tau_s < fit.tau_min_s) below.push_back(&r);
    if (!r.used && r.tau_s > fit.tau_max_s) above.push_back(&r);
  }
  std::string text = cut_range_text(below, "below", fit.tau_min_s) + cut_range_text(above, "above", fit.tau_max_s);
  std::vector<std::string> moves;
  for (const fit::Move& move : fit.moved) moves.push_back(move_text(axis.signal, move));
  if (!moves.empty()) text += fmt::format("Leaving them out moved {}.", text::listing(moves));
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::string cross_check_text(const AxisResult& axis) {
  if (!axis.cross_checked) return {};
  const fit::CrossCheck& check = axis.cross_checked->check;
  std::vector<std::string> parts;
  for (const fit::Agreement& a : check.coefficients) {
    parts.push_back(fmt::format("{} {} (the squares are {:.2g} standard deviations apart, at most {:.2g} expected)",
                                noise::label(axis.signal, a.term), quantity(axis.signal, a.term, a.second),
                                a.difference, a.limit));
  }
  if (parts.empty())
    return "Cross-check: fit and likelihood have no coefficient in common that both limit, so nothing is confirmed.";
  std::string text = fmt::format("Cross-check: the likelihood of the record itself, made without the curve, gives {}.",
                                 text::listing(parts));
  text +=
      check.agrees
          ? " The two agree."
          : " THE TWO DO NOT AGREE: a filter, spectral lines or a model that lacks a term do this; look at the spectrum (gyrobudget allan --psd welch --report) before quoting either.";
  const fit::Result& likelihood = axis.cross_checked->likelihood;
  if (axis.findings && 10 * likelihood.samples < 9 * axis.findings->samples) {
    text += fmt::format(" It is of {} samples only, in stretches between gaps, so it is less exact.",
                        count_text(likelihood.samples));
  }
  if (!check.same_range) text += " They cover different ranges, so some difference is expected.";
  return text + fmt::format(" The likelihood's own test: {}.", probability_text(likelihood.p_value));
}

std::vector<std::string> weighed_texts(const AxisResult& axis) {
  std::vector<std::string> texts;
  if (!axis.chosen) return texts;
  for (const fit::Weighed& w : axis.chosen->selection.weighed) {
    texts.push_back(fmt::format("{} ({}) beside {}: adds {:.3g} to ln L, needed {:.3g}; {}",
                                noise::label(axis.signal, w.candidate), static_cast<char>(w.candidate),
                                letters(w.beside), std::max(0.0, w.gain), w.cut,
                                w.kept           ? "kept"
                                : w.gain > w.cut ? "waits"
                                                 : "not needed"));
  }
  return texts;
}

std::string selection_text(const AxisResult& axis) {
  if (!axis.chosen) return {};
  const fit::Selection& s = axis.chosen->selection;
  if (s.terms.empty()) return "No terms could be chosen: the record has no stretch of samples to weigh them on.";
  std::string text =
      fmt::format("Terms chosen by likelihood ratios: {}. Of records without any further term, 5 % would get one.",
                  letters(s.terms));
  if (!s.dropped.empty())
    text += fmt::format(" Kept at first, then made needless by a later one: {}.", letters(s.dropped));
  if (s.tau_min_s) text += fmt::format(" Weighed and fitted over averaging times from {} on.", tau_text(*s.tau_min_s));
  return text;
}

namespace {

// What a slow term means for its user: 1/f noise has no end, a Gauss-Markov process forgets.
std::string meaning(Signal signal, const fit::Result& fit) {
  std::vector<std::string> parts;
  const auto add = [&](Term t, const auto& text) {
    const Coefficient* c = find(fit, t);
    if (c != nullptr && c->fitted && c->value > 0) parts.push_back(text(*c, quantity(signal, t, c->value)));
  };
  add(Term::gauss_markov, [](const Coefficient& c, const std::string& size) {
    return fmt::format(
        "the bias wanders within {} (1 sigma) and forgets itself in {}: averages over longer times gain again, and one state of a filter describes it",
        size, tau_text(c.shape));
  });
  add(Term::flicker, [](const Coefficient&, const std::string& size) {
    return fmt::format(
        "the bias wanders on every time scale with B = {}: averaging longer gains nothing below the floor, 0.664 B, and a filter needs several states to follow it",
        size);
  });
  add(Term::rate_random_walk, [](const Coefficient&, const std::string& size) {
    return fmt::format(
        "the bias walks away without bound, by K = {}: averaging longer loses, and one state of a filter follows it",
        size);
  });
  add(Term::rate_ramp, [](const Coefficient&, const std::string& size) {
    return fmt::format("the bias drifts along a straight line, by R = {}: a line fitted to it takes it off", size);
  });
  return parts.empty() ? "the bias stays where it is" : fmt::format("{}", fmt::join(parts, "; "));
}

}  // namespace

std::string alternative_text(const AxisResult& axis) {
  if (!axis.chosen || !axis.chosen->selection.alternative || !axis.chosen->alternative_fit || !axis.fit) return {};
  const auto& alternative = *axis.chosen->selection.alternative;
  return fmt::format(
      "The record cannot tell {} from {} (ln L {:.2g} {} with the other). With {}, {}. With {}, {}. Only a longer record decides; plan with the worse of the two for your use.",
      letters(axis.chosen->selection.terms), letters(alternative.terms),
      std::abs(alternative.log_likelihood_difference), alternative.log_likelihood_difference > 0 ? "lower" : "higher",
      letters(axis.chosen->selection.terms), meaning(axis.signal, *axis.fit), letters(alternative.terms),
      meaning(axis.signal, *axis.chosen->alternative_fit));
}

}  // namespace gyrobudget::inline v0::report

// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/units.h"
#include "gyrobudget/noise/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "curves.h"
#include "findings_json.h"
#include "json_text.h"
#include "page_parts.h"
#include "report.h"
#include "scale.h"
#include "words.h"

// Numbers that are not finite become null: JSON has no others. Keys keep the order of writing.
namespace gyrobudget::inline v0::report {
namespace {

using Json = nlohmann::ordered_json;
using fit::Coefficient;
using fit::Status;
using fit::Verdict;
using noise::Signal;
using noise::Term;

constexpr std::size_t kPagePoints = 300;

std::string_view text(Status status) {
  switch (status) {
    case Status::identified:
      return "identified";
    case Status::upper_bound:
      return "upper_bound";
    case Status::not_quotable:
      return "not_quotable";
    case Status::left_out:
      break;
  }
  return "left_out";
}

std::string_view text(Verdict verdict) {
  switch (verdict) {
    case Verdict::described:
      return "described";
    case Verdict::described_within:
      return "described_within";
    case Verdict::not_described:
      break;
  }
  return "not_described";
}

std::string_view text(Signal signal) {
  switch (signal) {
    case Signal::angular_rate:
      return "angular_rate";
    case Signal::specific_force:
      return "specific_force";
    case Signal::dimensionless:
      break;
  }
  return "dimensionless";
}

allan::Estimator first_estimator(const LogResult& result) {
  return result.axes.empty() ? allan::Estimator::oadev : result.axes.front().estimator;
}

Json head(const LogResult& result, std::string_view schema) {
  return {{"schema", schema},
          {"version", kVersion},
          {"command", result.command},
          {"source", result.source},
          {"record",
           {{"samples", result.samples},
            {"rate_hz", result.rate_hz},
            {"duration_s", static_cast<double>(result.samples) / result.rate_hz},
            {"missing_samples", result.missing_samples}}},
          {"estimator", allan::name(first_estimator(result))},
          {"notes", result.notes}};
}

Json axis_head(const AxisResult& axis) {
  const Scale scale(deviation_unit(axis)), mean(axis.signal);
  return {{"name", axis.name},
          {"estimator", allan::name(axis.estimator)},
          {"signal", text(axis.signal)},
          {"unit", scale.unit()},
          {"si_unit", si_unit(deviation_dimension(axis))},
          {"si_per_unit", scale.to_si()},
          {"mean", mean(axis.mean)},
          {"mean_unit", mean.unit()}};
}

/// The root of the density, so that white noise reads N.
Json spectrum(const AxisResult& axis) {
  const Scale scale(spectrum_unit(axis.signal));
  Json points = Json::array();
  for (const SpectrumResult::Point& p : axis.psd->points) {
    points.push_back({{"frequency_hz", p.frequency_hz},
                      {"amplitude", scale(p.amplitude)},
                      {"lower", scale(p.lower)},
                      {"upper", scale(p.upper)},
                      {"dof", p.dof}});
  }
  return {{"method", axis.psd->method},
          {"sides", "two-sided"},
          {"unit", scale.unit()},
          {"si_unit", si_unit(noise::dimension_of(axis.signal, Term::white))},
          {"si_per_unit", scale.to_si()},
          {"bandwidth_hz", axis.psd->bandwidth_hz},
          {"points", points}};
}

Json surface(const AxisResult& axis) {
  const Scale scale(axis.signal);
  Json rows = Json::array();
  for (const auto& row : axis.dynamic->deviation) rows.push_back(scale(row));
  return {{"window_s", axis.dynamic->window_s},
          {"unit", scale.unit()},
          {"si_unit", si_unit(noise::dimension_of(axis.signal))},
          {"si_per_unit", scale.to_si()},
          {"time_s", axis.dynamic->time_s},
          {"tau_s", axis.dynamic->tau_s},
          {"deviation", rows}};
}

Json segments_of(const LogResult& result) {
  Json segments = Json::array();
  for (const SegmentResult& s : result.segments) {
    segments.push_back({{"source", s.source},
                        {"first_row", s.first_row},
                        {"start_s", s.start_s},
                        {"samples", s.samples},
                        {"duration_s", static_cast<double>(s.samples) / result.rate_hz},
                        {"missing_samples", s.missing_samples}});
  }
  return segments;
}

Json allan_document(const LogResult& result) {
  Json document = head(result, "gyrobudget.allan/1");
  if (!result.segments.empty()) document["record"]["segments"] = segments_of(result);
  Json& axes = document["axes"] = Json::array();
  for (const AxisResult& axis : result.axes) {
    const Scale scale(deviation_unit(axis));
    Json out = axis_head(axis);
    Json& points = out["points"] = Json::array();
    for (const allan::DeviationPoint& p : axis.points) {
      points.push_back({{"tau_s", p.tau_s},
                        {"m", p.m},
                        {"deviation", scale(p.deviation)},
                        {"lower", scale(p.lower)},
                        {"upper", scale(p.upper)},
                        {"edf", p.edf},
                        {"terms", p.terms},
                        {"alpha", p.alpha},
                        {"stride", p.stride},
                        {"bias", p.bias}});
    }
    if (axis.psd) out["psd"] = spectrum(axis);
    if (axis.dynamic) out["dynamic"] = surface(axis);
    axes.push_back(std::move(out));
  }
  return document;
}

/// Null where nothing was fitted or what was cannot be quoted, and as `upper` where the record sets no limit.
Json parameter(Signal signal, const Coefficient& c) {
  const Scale scale(signal, c.term);
  const bool quoted = c.fitted && c.status != Status::not_quotable;
  const auto known = [&](double value) { return quoted ? Json(value) : Json(nullptr); };
  const double lower = std::isfinite(c.lower) ? c.lower : 0;
  Json out = {{"value", known(scale(c.value))},
              {"unit", scale.unit()},
              {"lower", known(scale(lower))},
              {"upper", known(scale(c.upper))},
              {"relative_std", known(c.relative_std)},
              {"status", text(c.status)},
              {"symbol", std::string(1, static_cast<char>(c.term))},
              {"label", noise::label(signal, c.term)},
              {"fitted", c.fitted},
              {"boundary_test", known(c.boundary_test)},
              {"upper_two_sided", known(scale(c.upper_two_sided))},
              {"si",
               {{"value", known(c.value)},
                {"lower", known(lower)},
                {"upper", known(c.upper)},
                {"unit", si_unit(noise::dimension_of(signal, c.term))}}}};
  const auto add_shape = [&](const std::string& name, const std::string& unit) {
    out[name + unit] = known(c.shape);
    out[name + "_lower" + unit] = known(c.shape_lower);
    out[name + "_upper" + unit] = known(c.shape_upper);
  };
  if (c.status == Status::not_quotable) out["why"] = "rounded_above_noise";
  if (c.term == Term::gauss_markov) add_shape("correlation_time", "_s");
  if (c.term == Term::sinusoid) add_shape("frequency", "_hz");
  return out;
}

Json parameters(const AxisResult& axis, const fit::Result& fit) {
  Json out = Json::object();
  for (const Term term : reading_order()) {
    if (const Coefficient* c = find(fit, term)) {
      out[std::string(noise::key(axis.signal, term))] = parameter(axis.signal, *c);
    }
  }
  return out;
}

Json residuals(const AxisResult& axis) {
  const Scale scale(axis.signal);
  Json out = Json::array();
  for (const fit::Residual& r : axis.fit->residuals) {
    out.push_back({{"tau_s", r.tau_s},
                   {"m", r.m},
                   {"measured", scale(r.measured)},
                   {"model", scale(r.model)},
                   {"misfit", r.misfit},
                   {"relative_std", r.relative_std},
                   {"used", r.used}});
  }
  return out;
}

Json moves(const AxisResult& axis) {
  Json out = Json::array();
  for (const fit::Move& move : axis.fit->moved) {
    const Scale scale(axis.signal, move.term);
    out.push_back({{"parameter", noise::key(axis.signal, move.term)},
                   {"from", scale(move.from)},
                   {"to", scale(move.to)},
                   {"unit", scale.unit()}});
  }
  return out;
}

/// Of the fitted coefficients in their datasheet units.
Json covariance(const AxisResult& axis) {
  const fit::Result& fit = *axis.fit;
  Json names = Json::array(), matrix = Json::array();
  const auto size = static_cast<std::size_t>(fit.covariance.rows());
  if (size != fit.fitted_terms.size()) return nullptr;
  for (std::size_t i = 0; i < size; ++i) {
    names.push_back(noise::key(axis.signal, fit.fitted_terms[i]));
    Json row = Json::array();
    for (std::size_t j = 0; j < size; ++j) {
      const double units =
          Scale(axis.signal, fit.fitted_terms[i]).to_si() * Scale(axis.signal, fit.fitted_terms[j]).to_si();
      row.push_back(fit.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) / units);
    }
    matrix.push_back(std::move(row));
  }
  return {{"parameters", names}, {"matrix", matrix}};
}

Json keys(Signal signal, const std::vector<Term>& terms) {
  Json out = Json::array();
  for (const Term t : terms) out.push_back(noise::key(signal, t));
  return out;
}

/// What --terms auto weighed and chose, as keys of `fit`.
void add_choice(Json& fit, const AxisResult& axis) {
  if (!axis.chosen) return;
  const auto& [selection, other] = *axis.chosen;
  Json weighed = Json::array();
  for (const fit::Weighed& w : selection.weighed) {
    weighed.push_back({{"candidate", noise::key(axis.signal, w.candidate)},
                       {"beside", keys(axis.signal, w.beside)},
                       {"gain", w.gain},
                       {"cut", w.cut},
                       {"kept", w.kept}});
  }
  fit["chosen"] = keys(axis.signal, selection.terms);
  fit["weighed"] = weighed;
  fit["dropped"] = keys(axis.signal, selection.dropped);
  fit["alternative"] = nullptr;
  if (!selection.alternative || !other) return;
  fit["alternative"] = {{"terms", keys(axis.signal, selection.alternative->terms)},
                        {"log_likelihood_difference", selection.alternative->log_likelihood_difference},
                        {"p_value", is_tested(*other) ? Json(other->p_value) : Json(nullptr)},
                        {"parameters", parameters(axis, *other)},
                        {"text", alternative_text(axis)}};
}

/// The low pass between the noise and the samples; null where none is known.
Json front_end(const fit::Result& fit) {
  if (!fit.front_end) return nullptr;
  const fit::FittedFrontEnd& f = *fit.front_end;
  return {{"kind", f.kind ? Json(noise::name(*f.kind)) : Json("unknown")},
          {"bandwidth_hz", f.bandwidth},
          {"lower_hz", f.lower},
          {"upper_hz", f.upper},
          {"fitted", f.fitted},
          {"text", front_end_text(fit)}};
}

Json fit_summary(const AxisResult& axis, bool timing) {
  const fit::Result& fit = *axis.fit;
  const auto if_tested = [&](double value) { return is_tested(fit) ? Json(value) : Json(nullptr); };
  Json out = {{"method", fit::name(fit.method)},
              {"tau_min_s", fit.tau_min_s},
              {"tau_max_s", fit.tau_max_s},
              {"chi2", if_tested(fit.chi2)},
              {"dof", fit.dof},
              {"p_value", if_tested(fit.p_value)},
              {"worst_misfit", fit.worst_misfit},
              {"worst_misfit_tau_s", fit.worst_misfit_tau_s},
              {"verdict", text(fit.verdict)},
              {"verdict_text", verdict_text(axis) + " " + consequence_text(axis)},
              {"converged", fit.converged},
              {"iterations", fit.iterations},
              {"front_end", front_end(fit)},
              {"moved", moves(axis)},
              {"covariance", covariance(axis)},
              {"residuals", residuals(axis)}};
  if (timing) out["seconds"] = fit.seconds;
  add_choice(out, axis);
  return out;
}

/// The likelihood beside the fit; null where it was not asked for.
Json cross_check(const AxisResult& axis) {
  if (!axis.cross_checked) return nullptr;
  const auto& [likelihood, check] = *axis.cross_checked;
  Json coefficients = Json::array();
  for (const fit::Agreement& a : check.coefficients) {
    const Scale scale(axis.signal, a.term);
    coefficients.push_back({{"parameter", noise::key(axis.signal, a.term)},
                            {"fit", scale(a.first)},
                            {"likelihood", scale(a.second)},
                            {"unit", scale.unit()},
                            {"difference_in_std", a.difference},
                            {"limit_in_std", a.limit},
                            {"agrees", a.agrees}});
  }
  return {{"agrees", check.agrees},  {"same_range", check.same_range}, {"p_value", likelihood.p_value},
          {"chi2", likelihood.chi2}, {"dof", likelihood.dof},          {"coefficients", coefficients}};
}

/// The bias over temperature; sizes per K and per K/min.
Json temperature(const AxisResult& axis) {
  const calibration::Temperature& t = *axis.temperature;
  Json coefficients = Json::object(), points = Json::array(), before = Json::object();
  for (const TemperatureRow& row : temperature_rows(axis)) {
    const auto& c = *row.coefficient;
    const auto known = [&](double si) { return c.fitted ? Json(si / row.unit_si) : Json(nullptr); };
    coefficients[row.key] = {
        {"value", known(c.value)}, {"lower", known(c.lower)}, {"upper", known(c.upper)}, {"unit", row.unit}};
  }
  const Scale scale(axis.signal);
  for (const auto& p : t.points)
    points.push_back({{"at_s", p.time_s},
                      {"temperature", p.temperature},
                      {"measured", scale(p.measured)},
                      {"model", scale(p.model)}});
  return {{"reference_degC", t.reference},
          {"lowest_degC", t.lowest},
          {"highest_degC", t.highest},
          {"p_value", t.p_value},
          {"explained", t.explained},
          {"removed", t.removed},
          {"coefficients", coefficients},
          {"before", parameters(axis, t.before)},
          {"points", points}};
}

std::string_view text(calibration::Stage stage) {
  using enum calibration::Stage;
  switch (stage) {
    case screening:
      return "screening";
    case curve:
      return "curve";
    case choice:
      return "choice";
    case fit:
      return "fit";
    case temperature:
      return "temperature";
    case departure:
      return "departure";
    case lines:
      return "lines";
    case intervals:
      return "intervals";
    case cross_check:
      return "cross_check";
    case facts:
      break;
  }
  return "facts";
}

Json faults(const AxisResult& axis) {
  Json list = Json::array();
  for (const calibration::Fault& fault : axis.faults)
    list.push_back({{"stage", text(fault.stage)}, {"what", fault.what}});
  return list;
}

Json minimum(const AxisResult& axis) {
  if (!(axis.fit->minimum_deviation > 0)) return nullptr;
  const Scale scale(axis.signal);
  return {{"deviation", scale(axis.fit->minimum_deviation)},
          {"tau_s", axis.fit->minimum_tau_s},
          {"unit", scale.unit()},
          {"over_0.664", scale(axis.fit->minimum_deviation / kFlickerFloor)}};
}

Json calibration_document(const LogResult& result) {
  Json document = head(result, "gyrobudget.calibration/1");
  Json& axes = document["axes"] = Json::array();
  for (const AxisResult& axis : result.axes) {
    Json out = axis_head(axis);
    out["parameters"] = axis.fit ? parameters(axis, *axis.fit) : Json::object();
    out["minimum"] = axis.fit ? minimum(axis) : Json(nullptr);
    out["beta"] = axis.fit ? Json(axis.fit->beta) : Json(nullptr);
    out["fit"] = axis.fit ? fit_summary(axis, result.timing) : Json(nullptr);
    if (axis.cross_checked) out["cross_check"] = cross_check(axis);
    add_findings(out, axis, result.rate_hz);
    out["faults"] = faults(axis);
    if (axis.temperature) out["temperature"] = temperature(axis);
    out["advice"] = axis.advice;
    axes.push_back(std::move(out));
  }
  return document;
}

Json combined_parameter(Signal signal, const fit::Combined& c) {
  const Scale scale(signal, c.term);
  return {{"value", scale(c.value)},
          {"unit", scale.unit()},
          {"lower", scale(c.lower)},
          {"upper", scale(c.upper)},
          {"spread", scale(c.spread)},
          {"next_lower", c.records > 2 ? Json(scale(c.next_lower)) : Json(nullptr)},
          {"next_upper", c.records > 2 ? Json(scale(c.next_upper)) : Json(nullptr)},
          {"records", c.records},
          {"identified", c.identified},
          {"q", c.q},
          {"p_value", c.p_value},
          {"symbol", std::string(1, static_cast<char>(c.term))},
          {"label", noise::label(signal, c.term)}};
}

/// In the order of reading.
std::vector<fit::Combined> in_reading_order(const calibration::CombinedAxis& axis) {
  std::vector<fit::Combined> list;
  for (const Term term : reading_order()) {
    const auto at = std::ranges::find(axis.coefficients, term, &fit::Combined::term);
    if (at != axis.coefficients.end()) list.push_back(*at);
  }
  return list;
}

Json combined(const RunsResult& result) {
  Json axes = Json::array();
  for (const calibration::CombinedAxis& axis : result.combined) {
    Json parameters = Json::object();
    for (const auto& c : in_reading_order(axis))
      parameters[std::string(noise::key(axis.signal, c.term))] = combined_parameter(axis.signal, c);
    axes.push_back({{"name", axis.name},
                    {"signal", text(axis.signal)},
                    {"left_out", axis.left_out},
                    {"common_start_s", axis.common_start_s ? Json(*axis.common_start_s) : Json(nullptr)},
                    {"parameters", parameters}});
  }
  return axes;
}

/// What the page shows of it.
Json combined_rows(const RunsResult& result) {
  Json axes = Json::array();
  for (const calibration::CombinedAxis& axis : result.combined) {
    Json rows = Json::array();
    for (const auto& c : in_reading_order(axis)) {
      const CombinedText t = combined_text(axis.signal, c);
      rows.push_back({fmt::format("{} ({})", noise::label(axis.signal, c.term), static_cast<char>(c.term)), t.value,
                      t.interval, t.spread, t.next, t.unit, t.agreement});
    }
    axes.push_back({{"name", axis.name}, {"left_out", axis.left_out}, {"rows", rows}});
  }
  return axes;
}

Json rows(const AxisResult& axis, const fit::Result& fit) {
  const auto cells = [](const CoefficientText& t) {
    return Json{{"value", t.value}, {"interval", t.interval}, {"unit", t.unit}};
  };
  Json out = Json::array();
  for (const Term term : reading_order()) {
    const Coefficient* c = find(fit, term);
    if (c == nullptr) continue;
    const ShapeText shape = shape_text(*c);
    out.push_back(
        {{"symbol", std::string(1, static_cast<char>(term))},
         {"label", noise::label(axis.signal, term)},
         {"status", text(c->status)},
         {"status_text", status_text(axis.signal, *c, fit)},
         {"datasheet", cells(datasheet_text(axis.signal, *c))},
         {"si", cells(si_text(axis.signal, *c))},
         {"shape",
          {{"label", shape.label}, {"value", shape.value}, {"interval", shape.interval}, {"unit", shape.unit}}}});
  }
  return out;
}

Json curves(const AxisResult& axis, double rate_hz) {
  const Scale scale(deviation_unit(axis));
  const AxisCurves curves = axis_curves(axis, rate_hz);
  Json terms = Json::array(), marks = Json::array();
  for (const TermCurve& t : curves.terms) {
    terms.push_back({{"symbol", std::string(1, static_cast<char>(t.term))},
                     {"limit", t.limit},
                     {"text",
                      {{"datasheet", term_text(axis.signal, t, noise::datasheet_unit(axis.signal, t.term))},
                       {"si", term_text(axis.signal, t, si_unit(noise::dimension_of(axis.signal, t.term)))}}},
                     {"deviation", scale(t.deviation)}});
  }
  for (const Mark& m : curves.marks) {
    marks.push_back({{"name", m.name}, {"tau_s", m.tau_s}, {"deviation", scale(m.deviation)}, {"text", m.text}});
  }
  return {{"tau_s", curves.tau_s},
          {"model", scale(curves.model)},
          {"terms", terms},
          {"marks", marks},
          {"tau_range_s", {curves.tau_low_s, curves.tau_high_s}},
          {"deviation_range", {scale(curves.deviation_low), scale(curves.deviation_high)}}};
}

Json temperature_cells(const AxisResult& axis) {
  Json rows = Json::array();
  for (const TemperatureRow& row : temperature_rows(axis))
    rows.push_back({row.label, row.value, row.interval, row.unit});
  return rows;
}

Json words(const AxisResult& axis, double rate_hz) {
  const fit::Result& fit = *axis.fit;
  return {{"headline", verdict_headline(axis)},
          {"quotable", is_quotable(fit) && !(axis.findings && axis.findings->rounded_above_noise())},
          {"verdict", verdict_text(axis)},
          {"consequence", consequence_text(axis)},
          {"minimum", minimum_text(axis, rate_hz)},
          {"beta", beta_text(fit)},
          {"front_end", front_end_text(fit)},
          {"cut", cut_text(axis)},
          {"selection", selection_text(axis)},
          {"weighed", weighed_texts(axis)},
          {"alternative", alternative_text(axis)},
          {"temperature", temperature_text(axis)},
          {"temperature_rows", temperature_cells(axis)}};
}

std::string estimators_text(const LogResult& result) {
  std::string list;
  for (const allan::Estimator estimator : estimators_of(result)) {
    list += (list.empty() ? "" : "; ") + estimator_text(estimator);
  }
  return list;
}

}  // namespace

std::string allan_json(const LogResult& result) { return dense_json(allan_document(result)); }

std::string calibration_json(const LogResult& result) { return dense_json(calibration_document(result)); }

std::string runs_json(const RunsResult& result) {
  Json out = {{"schema", "gyrobudget.runs/1"}, {"version", kVersion}, {"command", result.command}};
  out["combined"] = combined(result);
  for (const LogResult& run : result.runs) out["runs"].push_back(calibration_document(run));
  return dense_json(out);
}

std::string page_data(const LogResult& result, const RunsResult* runs) {
  LogResult small = result;
  small.timing = false;  // the same command shall give the same page
  for (AxisResult& axis : small.axes) axis.points = thinned(axis.points, kPagePoints);
  Json data = {{"allan", allan_document(small)},
               {"calibration", calibration_document(small)},
               {"record_text", record_text(result)},
               {"estimator_text", estimators_text(result)}};
  Json& axes = data["axes"] = Json::array();
  for (const AxisResult& axis : small.axes) {
    axes.push_back(
        {{"name", curve_name(axis, result)},
         {"deviation_name", deviation_name(axis.estimator)},
         {"curves", curves(axis, result.rate_hz)},
         {"rows", axis.fit ? rows(axis, *axis.fit) : Json::array()},
         {"other_rows",
          axis.chosen && axis.chosen->alternative_fit ? rows(axis, *axis.chosen->alternative_fit) : Json::array()},
         {"words", axis.fit ? words(axis, result.rate_hz) : Json(nullptr)}});
  }
  if (runs != nullptr) data["combined"] = combined_rows(*runs);
  return without_markup(compact_json(data));
}

}  // namespace gyrobudget::inline v0::report

// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "layout.h"
#include "report.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using noise::Signal;
using noise::Term;

std::string paragraph(std::string_view text) { return wrapped(text, "  ", "  "); }

std::string bullets(std::string_view title, const std::vector<std::string>& items) {
  if (items.empty()) return {};
  std::string out = fmt::format("\n  {}:\n", title);
  for (const std::string& item : items) out += wrapped(printable(item), "  - ", "    ");
  return out;
}

std::string heading(const LogResult& result) {
  return fmt::format("{}: {}\n", printable(result.source), record_text(result));
}

std::string axis_heading(std::string_view name, const AxisResult& axis) {
  if (!std::isfinite(axis.mean)) return printable(name) + '\n';
  return fmt::format("{}  (mean {})\n", printable(name), in_unit(axis.mean, noise::datasheet_unit(axis.signal)));
}

std::string curve_table(const AxisResult& axis) {
  const auto unit = deviation_unit(axis);
  const auto in_unit = [&](double si) { return number(noise::from_si(si, unit)); };
  const bool strided = std::ranges::any_of(axis.points, [](const auto& p) { return p.stride > 1; });
  TextTable table(std::vector<Align>(strided ? 7 : 6, Align::right));
  const auto row = [&](std::vector<std::string> cells, std::string stride) {
    if (strided) cells.push_back(std::move(stride));
    table.row(std::move(cells));
  };
  row({"tau [s]", fmt::format("deviation [{}]", unit), "95 % from", "to", "edf", "terms"}, "stride");
  for (const allan::DeviationPoint& p : axis.points) {
    row({fmt::format("{:.6g}", p.tau_s), in_unit(p.deviation), in_unit(p.lower), in_unit(p.upper),
         fmt::format("{:.1f}", p.edf), fmt::format("{}", p.terms)},
        fmt::format("{}", p.stride));
  }
  return table.text();
}

bool is_fitted(const fit::Result& fit, Term term) {
  const auto* c = find(fit, term);
  return c != nullptr && c->fitted;
}

std::string coefficient_table(const AxisResult& axis, const fit::Result& fit) {
  TextTable table({Align::left, Align::left, Align::right, Align::right, Align::left, Align::left});
  table.row({"", "", "value ± std", "95 % interval", "unit", "status"});
  for (const Term term : reading_order()) {
    if (!is_fitted(fit, term)) continue;
    const fit::Coefficient& c = *find(fit, term);
    auto datasheet = datasheet_text(axis.signal, c), si = si_text(axis.signal, c);
    if (!is_quotable(fit) && !is_reading(fit.method)) {
      for (auto* text : {&datasheet.value, &datasheet.interval, &si.value, &si.interval})
        *text = fmt::format("[{}]", *text);
    }
    table.row({std::string(1, static_cast<char>(term)), std::string(noise::label(axis.signal, term)), datasheet.value,
               datasheet.interval, datasheet.unit, status_text(axis.signal, c, fit)});
    if (si.unit != datasheet.unit) table.row({"", "", si.value, si.interval, si.unit});
    if (const auto shape = shape_text(c); !shape.label.empty())
      table.row({"", "  " + shape.label, shape.value, shape.interval, shape.unit});
  }
  return table.text();
}

std::string left_out(const AxisResult& axis) {
  std::string names;
  for (const Term term : reading_order()) {
    if (is_fitted(*axis.fit, term) || find(*axis.fit, term) == nullptr) continue;
    names +=
        fmt::format("{}{} ({})", names.empty() ? "" : ", ", noise::label(axis.signal, term), static_cast<char>(term));
  }
  return names.empty() ? names : "Left out (not fitted): " + names + ".";
}

/// What --terms auto weighed, chose, and could not tell apart.
std::string choice(const AxisResult& axis) {
  if (!axis.chosen) return {};
  std::string out = '\n' + paragraph(selection_text(axis)) + "  weighed:\n";
  for (const std::string& text : weighed_texts(axis)) out += wrapped(text, "  - ", "    ");
  const std::string alternative = alternative_text(axis);
  if (alternative.empty()) return out;
  return out + '\n' + paragraph(alternative) +
         fmt::format("  The other model, {}:\n", letters(axis.chosen->selection.alternative->terms)) +
         coefficient_table(axis, *axis.chosen->alternative_fit);
}

std::string temperature(const AxisResult& axis) {
  const std::string words = temperature_text(axis);
  if (words.empty()) return {};
  TextTable table({Align::left, Align::right, Align::right, Align::left});
  table.row({"Temperature", "value", "95 % interval", "unit"});
  for (const TemperatureRow& row : temperature_rows(axis)) table.row({row.label, row.value, row.interval, row.unit});
  return '\n' + table.text() + paragraph(words);
}

std::string axis_sheet(const AxisResult& axis, double rate_hz) {
  std::string out = '\n' + axis_heading(axis.name, axis);
  if (!axis.fit) return out + paragraph("No coefficients were fitted.") + bullets("What to know or do", axis.advice);
  const fit::Result& fit = *axis.fit;
  out += coefficient_table(axis, fit) + paragraph(left_out(axis)) + choice(axis);
  if (const std::string text = minimum_text(axis, rate_hz); !text.empty()) out += '\n' + paragraph(text);
  out += paragraph(beta_text(fit));
  out += paragraph(front_end_text(fit));
  out += temperature(axis);
  out += '\n' + paragraph("Verdict: " + verdict_headline(axis) + ". " + verdict_text(axis));
  out += paragraph("What follows: " + consequence_text(axis));
  out += paragraph(cut_text(axis));
  out += paragraph(cross_check_text(axis));
  return out + bullets("What to know or do", axis.advice);
}

/// The coefficients of all axes of one kind beside each other.
std::string summary_of(const LogResult& result, Signal signal) {
  const std::vector<Term> terms = {Term::white, Term::flicker, Term::rate_random_walk};
  TextTable table({Align::left, Align::right, Align::right, Align::right, Align::left});
  std::vector<std::string> head = {""};
  for (const Term term : terms) {
    head.push_back(fmt::format("{} [{}]", static_cast<char>(term), noise::datasheet_unit(signal, term)));
  }
  head.emplace_back("verdict");
  table.row(std::move(head));
  for (const AxisResult& axis : result.axes) {
    if (axis.signal != signal) continue;
    std::vector<std::string> cells = {printable(axis.name)};
    for (const Term term : terms) cells.push_back(cell_text(axis, term));
    cells.push_back(axis.fit ? verdict_headline(axis) : "not fitted");
    table.row(std::move(cells));
  }
  return table.text();
}

std::string summary(const LogResult& result) {
  std::string out;
  for (const Signal signal : {Signal::angular_rate, Signal::specific_force, Signal::dimensionless}) {
    const auto axes = std::ranges::count(result.axes, signal, &AxisResult::signal);
    if (axes > 1) out += '\n' + summary_of(result, signal);
  }
  return out;
}

}  // namespace

std::string allan_table(const LogResult& result) {
  const auto estimators = estimators_of(result);
  std::string out = heading(result);
  if (estimators.size() == 1) out += paragraph(estimator_text(estimators.front()));
  for (const AxisResult& axis : result.axes) {
    out += '\n' + axis_heading(curve_name(axis, result), axis);
    if (estimators.size() > 1) out += paragraph(estimator_text(axis.estimator));
    out += curve_table(axis) + bullets("What to know or do", axis.advice);
  }
  return out + bullets("How the log was read", result.notes);
}

std::string datasheet(const LogResult& result) {
  std::string out = heading(result) + summary(result);
  for (const AxisResult& axis : result.axes) out += axis_sheet(axis, result.rate_hz);
  return out + bullets("How the log was read", result.notes);
}

}  // namespace gyrobudget::inline v0::report

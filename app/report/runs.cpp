// SPDX-License-Identifier: MIT
// Several records of one sensor type as text, and side by side.
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "layout.h"
#include "report.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using noise::Term;

/// A line for each record.
std::string table_of_runs(const RunsResult& result, std::size_t axis) {
  constexpr std::array kTerms{Term::white, Term::flicker, Term::rate_random_walk};
  const noise::Signal signal = result.combined[axis].signal;
  TextTable table({Align::left, Align::right, Align::right, Align::right, Align::right, Align::left});
  std::vector<std::string> head{"", fmt::format("mean [{}]", noise::datasheet_unit(signal))};
  for (const Term t : kTerms)
    head.push_back(fmt::format("{} [{}]", static_cast<char>(t), noise::datasheet_unit(signal, t)));
  head.emplace_back("verdict");
  table.row(std::move(head));
  for (const LogResult& run : result.runs) {
    const AxisResult& a = run.axes[axis];
    std::vector<std::string> cells{printable(run.source),
                                   number(noise::from_si(a.mean, noise::datasheet_unit(signal)))};
    for (const Term t : kTerms) cells.push_back(cell_text(a, t));
    cells.push_back(a.fit ? verdict_headline(a) : "not fitted");
    table.row(std::move(cells));
  }
  return table.text();
}

std::string combined_table(const calibration::CombinedAxis& axis) {
  if (axis.coefficients.empty()) return "  No record can be quoted, so there is nothing to combine.\n";
  TextTable table(
      {Align::left, Align::left, Align::right, Align::right, Align::right, Align::right, Align::left, Align::left});
  table.row({"", "together", "value", "95 % interval", "spread", "95 % of another", "unit", "records"});
  for (const Term term : reading_order()) {
    const auto c = std::ranges::find(axis.coefficients, term, &fit::Combined::term);
    if (c == axis.coefficients.end()) continue;
    const CombinedText t = combined_text(axis.signal, *c);
    table.row({std::string(1, static_cast<char>(term)), std::string(noise::label(axis.signal, term)), t.value,
               t.interval, t.spread, t.next, t.unit, t.agreement});
  }
  return table.text();
}

std::string left_out(const calibration::CombinedAxis& axis) {
  std::string names;
  for (const std::string& source : axis.left_out) names += (names.empty() ? "" : ", ") + printable(source);
  return names.empty() ? names : "Not taken, because the model does not describe them: " + names + ".";
}

std::string common_start(const calibration::CombinedAxis& axis) {
  if (!axis.common_start_s) return {};
  return fmt::format(
      "Compared from {} on, where the fits of all of them hold: by themselves some begin earlier, and what a filter takes off the shortest averaging times would look like a difference.",
      tau_text(*axis.common_start_s));
}

/// A record with nothing to say of itself leaves the word to the combined coefficients.
bool is_plain(const AxisResult& axis) {
  return !(axis.findings && axis.findings->any()) && axis.fit && is_quotable(*axis.fit);
}

std::string advice(const RunsResult& result, std::size_t axis) {
  std::string out;
  for (const LogResult& run : result.runs) {
    if (is_plain(run.axes[axis])) continue;
    for (const std::string& text : run.axes[axis].advice)
      out += wrapped(printable(run.source + ": " + text), "  - ", "    ");
  }
  return out.empty() ? out : "\n  What to know or do:\n" + out;
}

}  // namespace

std::string runs_datasheet(const RunsResult& result) {
  std::string out = fmt::format("{} records of one sensor type, each fitted by itself\n", result.runs.size());
  for (const LogResult& run : result.runs) out += fmt::format("  {}: {}\n", printable(run.source), record_text(run));
  for (std::size_t i = 0; i < result.combined.size(); ++i) {
    const calibration::CombinedAxis& axis = result.combined[i];
    out += fmt::format("\n{}\n", printable(axis.name)) + table_of_runs(result, i) + '\n' + combined_table(axis);
    out += wrapped(common_start(axis), "  ", "  ") + wrapped(left_out(axis), "  ", "  ") + advice(result, i);
  }
  return out + '\n' +
         wrapped(
             "Spread: standard deviation of the coefficient between records, beyond what the scatter of each explains. The interval is that of the mean over all such records; another record's coefficient lies in the wider one, which takes three records to tell.",
             "", "");
}

LogResult side_by_side(const RunsResult& result) {
  LogResult all = result.runs.front();
  all.command = result.command;
  all.source = fmt::format("{} and {} more", file_name(all.source), result.runs.size() - 1);
  all.samples = all.missing_samples = 0;
  all.notes.clear();
  all.axes.clear();
  for (const LogResult& run : result.runs) {
    all.samples += run.samples;
    all.missing_samples += run.missing_samples;
    for (const auto& note : run.notes) all.notes.push_back(run.source + ": " + note);
  }
  for (std::size_t i = 0; i < result.combined.size(); ++i) {
    for (const LogResult& run : result.runs) {
      all.axes.push_back(run.axes[i]);
      all.axes.back().name = fmt::format("{}, {}", run.axes[i].name, file_name(run.source));
    }
  }
  return all;
}

}  // namespace gyrobudget::inline v0::report

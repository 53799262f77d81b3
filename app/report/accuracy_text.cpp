// SPDX-License-Identifier: MIT
// The accuracy of fits for the terminal, and the words that the page has too.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>

#include "accuracy.h"
#include "layout.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using fit::CoefficientAccuracy;
using fit::Method;
using fit::MethodAccuracy;

// --- Cells ----------------------------------------------------------------------------------------------------------

/// "4.3 %": shares with one digit behind the point; "-" for none.
std::string share(double fraction) { return std::isfinite(fraction) ? fmt::format("{:.1f} %", 100 * fraction) : "-"; }

/// The same with its binomial standard error: "95.1 ± 1.0 %".
std::string share(double fraction, double of) {
  if (!std::isfinite(fraction) || !(of > 0)) return "-";
  const double std = std::sqrt(fraction * (1 - fraction) / of);
  return fmt::format("{:.1f} ± {:.1f} %", 100 * fraction, 100 * std);
}

std::string error(double relative) { return std::isfinite(relative) ? number(100 * relative, 3) + " %" : "-"; }

std::string signed_error(double relative) {
  if (!std::isfinite(relative)) return "-";
  return fmt::format("{}{}", relative < 0 ? '-' : '+', error(std::abs(relative)));
}

std::string ratio(double x) { return std::isfinite(x) ? fmt::format("{:.3f}", x) : "-"; }

std::string time_text(double seconds) {
  if (!(seconds > 0)) return "-";
  if (seconds < 1e-3) return number(1e6 * seconds, 2) + " us";
  if (seconds < 1) return number(1e3 * seconds, 2) + " ms";
  return number(seconds, 2) + " s";
}

std::string term_name(fit::Method method, std::optional<noise::Term> term) {
  return term ? fmt::format("{} {}", fit::name(method), static_cast<char>(*term)) : std::string(fit::name(method));
}

// --- Tables ---------------------------------------------------------------------------------------------------------

/// Whether any fit said that it has no number.
bool any_refused(const AccuracyStudy& study) {
  for (const MethodAccuracy& m : study.accuracy.methods)
    for (const CoefficientAccuracy& c : m.coefficients)
      if (c.refused > 0) return true;
  return false;
}

std::vector<std::string> coefficient_cells(const AccuracyStudy& study, const CoefficientAccuracy& c) {
  const double records = study.accuracy.records;
  std::vector<std::string> cells{fmt::format("  {}  {}", static_cast<char>(c.term),
                                             in_unit(c.truth, noise::datasheet_unit(study.signal, c.term), 3)),
                                 signed_error(c.bias),
                                 error(c.rmse),
                                 ratio(c.rmse / c.bound),
                                 ratio(c.over_likelihood),
                                 share(c.coverage, records),
                                 share(c.coverage_identified, records * c.identified),
                                 c.truth > 0 ? share(c.missed) : "-",
                                 c.truth > 0 ? "-" : share(c.identified)};
  if (any_refused(study)) {
    cells.push_back(share(c.refused));
    cells.push_back(share(c.coverage_answered, records * (1 - c.refused)));
  }
  return cells;
}

std::string coefficient_table(const AccuracyStudy& study) {
  using enum Align;
  std::vector<Align> columns{left, right, right, right, right, right, right, right, right};
  std::vector<std::string> heads{"truth",       "bias",          "RMSE",   "/ bound", "/ likelihood",
                                 "95 % covers", "if identified", "missed", "false"};
  if (any_refused(study)) {
    columns.insert(columns.end(), 2, right);
    heads.insert(heads.end(), {"refused", "if not"});
  }
  TextTable table(columns);
  table.row(heads);
  for (const auto& m : study.accuracy.methods) {
    for (const auto& c : m.coefficients) table.row(coefficient_cells(study, c));
  }
  const auto lines = table.lines();
  std::string out = lines.front() + '\n';
  std::size_t line = 1;
  for (const auto& m : study.accuracy.methods) {
    out += fmt::format("{}\n", fit::name(m.method));
    for (std::size_t i = 0; i < m.coefficients.size(); ++i) out += lines[line++] + '\n';
  }
  return out;
}

std::string method_table(const AccuracyStudy& study) {
  using enum Align;
  const double records = study.accuracy.records;
  TextTable table({left, right, right, right, right, right, right, right});
  table.row({"", "any false term", "p < 5 %", "p < 1 %", "range cut", "not described", "unconverged", "time a fit"});
  for (const auto& m : study.accuracy.methods) {
    const bool tested = std::isfinite(m.p_below_5_percent);
    table.row({std::string(fit::name(m.method)), share(m.false_terms), share(m.p_below_5_percent, records),
               share(m.p_below_1_percent, records), share(m.cut), tested ? share(m.not_described) : "-",
               share(m.unconverged), time_text(m.seconds_per_fit)});
  }
  return table.text();
}

std::string check_table(const std::vector<fit::Check>& checks) {
  if (checks.empty()) return {};
  using enum Align;
  TextTable table({left, left, right, left});
  for (const auto& c : checks) {
    const bool known = std::isfinite(c.value);
    table.row({"  " + c.text, term_name(c.method, c.term), known ? number(c.value, 4) : "not measured",
               c.met ? "held" : "BROKEN"});
  }
  return "\nLimits\n" + table.text();
}

std::string head(const AccuracyStudy& study) {
  const auto& a = study.accuracy;
  const std::string records =
      a.complete ? count_text(a.records)
                 : fmt::format("Stopped after {} of {}", count_text(a.records), count_text(study.asked));
  return fmt::format(
      "{}, {}: how wrong its fitted coefficients are\n{} records of {} samples ({} at {:g} Hz), seed {}\n\n",
      printable(study.sensor), study.signal == noise::Signal::angular_rate ? "gyro" : "accelerometer", records,
      count_text(a.samples), duration_text(static_cast<double>(a.samples) * a.dt), 1 / a.dt, a.seed);
}

// --- Words ----------------------------------------------------------------------------------------------------------

const MethodAccuracy* find(const AccuracyStudy& study, Method method) {
  const auto& all = study.accuracy.methods;
  const auto at = std::ranges::find(all, method, &MethodAccuracy::method);
  return at == all.end() ? nullptr : &*at;
}

/// The method that reads the curve best, beside the likelihood.
std::string against_likelihood(const AccuracyStudy& study) {
  const auto* gls = find(study, Method::gls);
  if (gls == nullptr || find(study, Method::whittle) == nullptr) return {};
  double worst = 0;
  for (const auto& c : gls->coefficients) worst = std::max(worst, c.truth > 0 ? c.over_likelihood : 0);
  return fmt::format(
      "gls: its RMSE is at most {:.3f} of the likelihood's (whittle) on the same records. Errors of a record are common to both, so this ratio is known far better than the RMSE itself.",
      worst);
}

/// Intervals whose coverage chance does not explain.
std::string coverage_found(const AccuracyStudy& study) {
  constexpr double kNominal = 0.95, kStds = 3;
  const double scatter = kStds * std::sqrt(kNominal * (1 - kNominal) / std::max(1, study.accuracy.records));
  std::string off;
  for (const auto& m : study.accuracy.methods) {
    for (const auto& c : m.coefficients) {
      const double covers = c.refused > 0 ? c.coverage_answered : c.coverage;
      if (c.truth > 0 && std::abs(covers - kNominal) * std::sqrt(1 - c.refused) > scatter)
        off += fmt::format("{}{} ({:.1f} %)", off.empty() ? "" : ", ", term_name(m.method, c.term), 100 * covers);
    }
  }
  const auto range =
      fmt::format("{:.1f} to {:.1f} %", 100 * (kNominal - scatter), std::min(100.0, 100 * (kNominal + scatter)));
  if (off.empty()) return fmt::format("Every interval covers the truth within {}, as it says.", range);
  return fmt::format("Chance leaves a true 95 % within {}; these intervals are not that: {}.", range, off);
}

}  // namespace

std::vector<std::string> accuracy_words(const AccuracyStudy& study) {
  const int records = study.accuracy.records;
  if (records == 0) return {"No record was finished: there is nothing to say."};
  std::vector<std::string> words{
      fmt::format(
          "Bias and RMSE are relative to the truth. The RMSE of {} records is itself uncertain by {} of its value, a bias by RMSE/{:.0f}.",
          count_text(records), percent(1 / std::sqrt(2.0 * records)), std::sqrt(records)),
      "/ bound: RMSE over the Cramer-Rao bound. 1.00 is the best there is for bounds below about 10 %; above that the bound cannot be reached, or values at zero go below it, and / likelihood tells more.",
      "95 % covers: share of records whose two-sided interval holds the truth, with its standard error. If identified: the same of the records that call the term identified; where few do, those are the ones that read it high.",
      "Missed: the term is there and the record does not show it. False: it is not there and the record calls it identified.",
      any_refused(study)
          ? "Refused: calibrate says that it has no number, as the record is rounded, spoilt, too short or not described. If not: 95 % covers of the other records."
          : "",
      "p < 5 % of a sound test in 5 % of records, p < 1 % in 1 %.",
      against_likelihood(study),
      coverage_found(study)};
  std::erase(words, "");
  return words;
}

std::string accuracy_table(const AccuracyStudy& study) {
  std::string out = head(study);
  if (study.accuracy.records > 0) {
    out += coefficient_table(study) + '\n' + method_table(study);
    out += fmt::format("\nMaking a record and its curve: {}; all: {}.\n", time_text(study.accuracy.seconds_per_record),
                       time_text(study.accuracy.seconds));
  }
  out += check_table(study.checks) + "\nHow to read it\n";
  for (const std::string& words : accuracy_words(study)) out += wrapped(words, "  - ", "    ");
  return out;
}

// --- Error against run time -----------------------------------------------------------------------------------------

namespace {

using fit::Comparison;
using fit::SweepRow;
using fit::Way;

const SweepRow* find(const fit::Sweep& sweep, Comparison group, const Way& way) {
  const auto at =
      std::ranges::find_if(sweep.rows, [&](const SweepRow& row) { return row.comparison == group && row.way == way; });
  return at == sweep.rows.end() || at->coefficients.empty() ? nullptr : &*at;
}

const SweepRow* default_of(const fit::Sweep& sweep) {
  const auto at =
      std::ranges::find_if(sweep.rows, [](const SweepRow& r) { return r.way == Way{} && !r.coefficients.empty(); });
  return at == sweep.rows.end() ? nullptr : &*at;
}

std::string covariance_text(const Way& way) {
  if (way.method == Method::edf) return "its diagonal (edf)";
  return way.method == Method::loglog ? "none (loglog)" : "exact";
}

std::string length_text(const SweepRow& row) {
  const auto power = std::lround(std::log10(static_cast<double>(row.samples)));
  return fmt::format("1e{} {}{}", power, fit::name(row.way.method),
                     row.way.overlap > 0 ? fmt::format(", stride m/{}", row.way.overlap) : "");
}

std::string ratios(const SweepRow& row) {
  std::string text;
  for (const auto& c : row.coefficients) {
    text += fmt::format("{}{} {:.3f}", text.empty() ? "" : ", ", static_cast<char>(c.term), c.over_default);
  }
  return text;
}

std::string rmse_text(const SweepRow& row) {
  std::string text;
  for (const auto& c : row.coefficients) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", static_cast<char>(c.term), error(c.rmse));
  }
  return text;
}

std::string methods_words(const fit::Sweep& sweep, const SweepRow& standard) {
  std::string text = fmt::format("gls is the default method: {} (RMSE) in {}.", rmse_text(standard),
                                 time_text(standard.curve_seconds + standard.fit_seconds));
  for (const auto& [method, what] : {std::pair{Method::whittle, "The likelihood of the whole record"},
                                     {Method::edf, "Weights without covariances"},
                                     {Method::loglog, "No weights at all"}}) {
    if (const auto* row = find(sweep, Comparison::method, {.method = method})) {
      text += fmt::format(" {} ({}): {} of that, in {}.", what, fit::name(method), ratios(*row),
                          time_text(row->curve_seconds + row->fit_seconds));
    }
  }
  return text +
         fmt::format(" The exact covariance takes {} once a log, which is all that an approximate one could save.",
                     time_text(standard.covariance_seconds));
}

std::string taus_words(const fit::Sweep& sweep, const SweepRow& standard) {
  std::string text = "One tau an octave is the default:";
  for (const int taus : {2, 4}) {
    const auto* row = find(sweep, Comparison::taus_an_octave, {.taus_an_octave = taus});
    if (row == nullptr) continue;
    text += fmt::format(" {} an octave give {} of its RMSE for {:.1f} times the fit", taus, ratios(*row),
                        row->fit_seconds / standard.fit_seconds);
    text += ".";
  }
  return text;
}

std::string stride_words(const fit::Sweep& sweep, const SweepRow& standard) {
  const auto* sixteenth = find(sweep, Comparison::stride, {.overlap = 16});
  const auto* whole = find(sweep, Comparison::stride, {.overlap = 1});
  if (sixteenth == nullptr || whole == nullptr) return {};
  std::string text = fmt::format(
      "Full overlap is the default: a stride of m/16 gives {} of its RMSE and the curve takes {} for {}; adjacent clusters (m/1) give {}.",
      ratios(*sixteenth), time_text(sixteenth->curve_seconds), time_text(standard.curve_seconds), ratios(*whole));
  constexpr double kMatters = 1.02;
  const bool cheap =
      std::ranges::all_of(sixteenth->coefficients, [](const auto& c) { return !(c.over_default > kMatters); });
  return cheap ? text + " Where the curve must be cheaper, m/16 loses nothing that matters." : text;
}

std::string length_words(const fit::Sweep& sweep) {
  const SweepRow *shortest = nullptr, *longest = nullptr;
  for (const auto& row : sweep.rows) {
    if (row.comparison != Comparison::record_length || row.way != Way{} || row.coefficients.empty()) continue;
    if (shortest == nullptr) shortest = &row;
    longest = &row;
  }
  if (shortest == longest) return {};
  return fmt::format(
      "Length is what buys accuracy: {} samples give {}, {} give {}; curve and fit of the latter take {}.",
      count_text(shortest->samples), rmse_text(*shortest), count_text(longest->samples), rmse_text(*longest),
      time_text(longest->curve_seconds + longest->fit_seconds));
}

std::vector<std::string> sweep_cells(const SweepRow& row) {
  std::vector<std::string> cells{fmt::format("  {}{}", setting_of(row), row.way == Way{} ? " (default)" : "")};
  cells.push_back(count_text(row.samples));
  cells.push_back(count_text(row.records));
  for (const auto& c : row.coefficients) {
    cells.push_back(error(c.rmse));
    cells.push_back(ratio(c.over_default));
    cells.push_back(share(c.coverage));
  }
  cells.push_back(time_text(row.curve_seconds));
  cells.push_back(time_text(row.fit_seconds));
  cells.push_back(time_text(row.covariance_seconds));
  cells.push_back(row.unconverged > 0 ? fmt::format("{} unconverged", row.unconverged) : "");
  return cells;
}

std::string sweep_rows(const fit::Sweep& sweep) {
  const auto* standard = default_of(sweep);
  if (standard == nullptr) return {};
  std::vector<Align> columns{Align::left, Align::right, Align::right};
  std::vector<std::string> names{"", "samples", "records"};
  for (const auto& c : standard->coefficients) {
    columns.insert(columns.end(), 3, Align::right);
    names.push_back(fmt::format("{} RMSE", static_cast<char>(c.term)));
    names.insert(names.end(), {"/ default", "covers"});
  }
  columns.insert(columns.end(), {Align::right, Align::right, Align::right, Align::left});
  names.insert(names.end(), {"curve", "fit", "covariance", ""});
  TextTable table(std::move(columns));
  table.row(std::move(names));
  for (const auto& row : sweep.rows) table.row(sweep_cells(row));
  const auto lines = table.lines();
  std::string out = lines.front() + '\n';
  for (std::size_t i = 0; i < sweep.rows.size(); ++i) {
    const SweepRow& row = sweep.rows[i];
    if (i == 0 || row.comparison != sweep.rows[i - 1].comparison) out += fmt::format("{}\n", group_of(row));
    out += lines[i + 1] + '\n';
  }
  return out;
}

}  // namespace

std::string_view group_of(const SweepRow& row) {
  switch (row.comparison) {
    case Comparison::method:
      return "method";
    case Comparison::covariance:
      return "covariance";
    case Comparison::taus_an_octave:
      return "taus an octave";
    case Comparison::stride:
      return "stride";
    case Comparison::record_length:
      return "record length";
  }
  throw std::invalid_argument("a row of a sweep compares none of what there is");
}

std::string setting_of(const SweepRow& row) {
  switch (row.comparison) {
    case Comparison::method:
      return std::string(fit::name(row.way.method));
    case Comparison::covariance:
      return covariance_text(row.way);
    case Comparison::taus_an_octave:
      return fmt::format("{}", row.way.taus_an_octave);
    case Comparison::stride:
      return row.way.overlap > 0 ? fmt::format("m/{}", row.way.overlap) : "1 sample";
    case Comparison::record_length:
      return length_text(row);
  }
  throw std::invalid_argument("a row of a sweep compares none of what there is");
}

std::vector<std::string> sweep_words(const SweepStudy& study) {
  const fit::Sweep& sweep = study.sweep;
  const auto* standard = default_of(sweep);
  if (standard == nullptr) return {"No record was finished: there is nothing to say."};
  std::vector<std::string> words{
      methods_words(sweep, *standard), taus_words(sweep, *standard), stride_words(sweep, *standard),
      length_words(sweep),
      "RMSE is relative to the truth; / default is over the RMSE of the default on the same records, which cancels most of the chance. Times are of one record on this machine, the first decile over all, which other programs disturb least; the covariance is made once for all axes of a log."};
  std::erase(words, "");
  return words;
}

std::string sweep_table(const SweepStudy& study) {
  std::string out =
      fmt::format("{}, {} at {:g} Hz: error of the fit against its run time, seed {}\n{}\n", printable(study.sensor),
                  study.signal == noise::Signal::angular_rate ? "gyro" : "accelerometer", study.rate_hz, study.seed,
                  study.sweep.complete ? "" : "Stopped: rows are of the records finished.\n");
  out += sweep_rows(study.sweep) + "\nWhat follows\n";
  for (const std::string& words : sweep_words(study)) out += wrapped(words, "  - ", "    ");
  return out;
}

}  // namespace gyrobudget::inline v0::report

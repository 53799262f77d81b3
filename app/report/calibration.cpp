// SPDX-License-Identifier: MIT
#include "calibration.h"

#include "gyrobudget/app/sensor_file/sensor_merge.h"
#include "gyrobudget/noise/sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <span>
#include <utility>

#include "layout.h"
#include "sensor_words.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using calibration::AxisDatasheet;
using calibration::Datasheet;
using calibration::Findings;
using calibration::TypeDatasheet;
using noise::Term;

// --- What a record holds beside noise -----------------------------------------------------------------------------

// The record that findings are of.
struct Of {
  noise::Signal signal;
  std::int64_t samples;
  double dt;
};

std::string times(const std::vector<double>& seconds) {
  constexpr std::size_t kNamed = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(seconds.size(), kNamed); ++i)
    text += fmt::format("{}{:.6g}", i > 0 ? ", " : "", seconds[i]);
  return text + (seconds.size() > kNamed ? ", ... s" : " s");
}

std::string describe_outliers(const Findings& found, const Of& of) {
  std::vector<double> at;
  bool in_use = false;
  for (const auto& outlier : found.outliers) {
    at.push_back(static_cast<double>(outlier.index) * of.dt);
    in_use |= outlier.index >= found.first && outlier.index < found.first + found.samples;
  }
  const auto& worst = *std::ranges::max_element(found.outliers, {}, &allan::Outlier::sigmas);
  return fmt::format(
      "{} of {} samples lie further from their surroundings than noise would put any (at {}), the worst at {:.6g} s by {} ({:.3g} sigma). {}",
      found.outliers.size(), of.samples, times(at), static_cast<double>(worst.index) * of.dt,
      noise::quantity_text(worst.distance, noise::datasheet_unit(of.signal), 3), worst.sigmas,
      found.outliers_masked || !in_use
          ? "They are masked: neither curve nor fit holds them."
          : "They are in curve and fit: find what knocked, and leave the samples out with --mask outliers.");
}

std::string describe_steps(const Findings& found, const Of& of) {
  std::string text;
  for (const auto& step : found.steps) {
    text += fmt::format("{}{} at {:.6g} s", text.empty() ? "" : ", ",
                        noise::quantity_text(step.size, noise::datasheet_unit(of.signal), 3),
                        static_cast<double>(step.index) * of.dt);
  }
  return fmt::format(
      "The mean jumps by {}. {}", text,
      found.steps_masked
          ? "The longest part without a jump is used."
          : "Curve and fit hold the jump, mostly as rate random walk: --mask steps uses the longest part without one.");
}

std::string describe_departure(const Findings& found, const Of& of) {
  const allan::Departure& departure = *found.departure;
  const auto size = noise::quantity_text(departure.size, noise::datasheet_unit(of.signal), 3);
  const std::string chance = "noise would do that with " + probability_text(departure.p_value);
  if (departure.kind == allan::Departure::Kind::trend) {
    return fmt::format(
        "The record drifts by {} along a straight line ({}). Where the ramp is not fitted it counts as rate random walk: --terms N,B,K,R fits it.",
        size, chance);
  }
  return fmt::format(
      "The record begins with a warm-up of {} that fades with a time constant of about {:.3g} s ({}). {}", size,
      departure.time_constant_s, chance,
      found.warm_up_masked
          ? "Its first five time constants are masked."
          : "Curve and fit hold it, mostly as rate random walk: --mask warm-up leaves out five time constants.");
}

std::string describe_fainter(std::span<const allan::SpectralLine> lines) {
  const auto [low, high] = std::ranges::minmax(lines, {}, &allan::SpectralLine::frequency_hz);
  const std::string from = fmt::format("{:.3g}", low.frequency_hz), to = fmt::format("{:.3g}", high.frequency_hz);
  const double highest = std::ranges::max(lines, {}, &allan::SpectralLine::ratio).ratio;
  if (from == to) {
    return fmt::format("{} lies near {} Hz (up to {:.0f} times the spectrum beside it).",
                       lines.size() == 1 ? "A fainter line" : fmt::format("A group of {} fainter lines", lines.size()),
                       from, highest);
  }
  return fmt::format(
      "{} fainter lines lie between {} and {} Hz (up to {:.0f} times the spectrum beside them). So many are rather a spectrum with structure, as of a sensor that moves: look at it with gyrobudget allan --psd welch --report.",
      lines.size(), from, to, highest);
}

std::vector<std::string> describe(const Findings& found, const Of& of) {
  std::vector<std::string> text;
  const bool part = found.samples < of.samples;
  if (part) {
    text.push_back(fmt::format("Curve and fit are of the samples from {:.6g} s to {:.6g} s; the others are masked.",
                               static_cast<double>(found.first) * of.dt,
                               static_cast<double>(found.first + found.samples) * of.dt));
  }
  if (!found.outliers.empty()) text.push_back(describe_outliers(found, of));
  if (!found.steps.empty()) text.push_back(describe_steps(found, of));
  if (found.departure) text.push_back(describe_departure(found, of));
  // Lines are noise that no coefficient describes: vibration, mains, a fan, a control loop.
  constexpr std::size_t kNamed = 3;  // strongest first
  for (std::size_t i = 0; i < found.lines.size() && i < kNamed; ++i) {
    const auto& line = found.lines[i];
    text.push_back(fmt::format(
        "A spectral line at {:.3g} Hz (amplitude about {}, {:.0f} times the spectrum beside it) is in the record but not in the model. It shifts the deviation at taus up to its period, {:.3g} s.",
        line.frequency_hz, noise::quantity_text(line.amplitude, noise::datasheet_unit(of.signal), 3), line.ratio,
        1 / line.frequency_hz));
  }
  if (found.lines.size() > kNamed) text.push_back(describe_fainter(std::span(found.lines).subspan(kNamed)));
  return text;
}

// --- What follows from the fit ------------------------------------------------------------------------------------

// In few digits, and not above the number: from a tau on is from its own octave on.
std::string not_above(double value) {
  constexpr int kExact = 17;
  std::string text;
  for (int digits = 3; digits <= kExact; ++digits) {
    text = fmt::format("{:.{}g}", value, digits);
    if (const double read = std::stod(text); read <= value && read > value * (1 - 1e-3)) return text;
  }
  return text;
}

std::string_view term_name(Term term) { return term == Term::flicker ? "Bias instability" : "Rate random walk"; }

std::string longer_text(const calibration::LongerRecord& longer) {
  const std::string here = duration_text(longer.duration_s, text::DurationForm::rough);
  const std::string found = longer.identified ? fmt::format("{} is known to {} here ({} of record)",
                                                            term_name(longer.term), percent(longer.relative_std), here)
                                              : fmt::format("{} is not resolved in {} of record: were it as fitted",
                                                            term_name(longer.term), here);
  const std::string_view joint = longer.identified ? ";" : ",";
  if (!std::isfinite(longer.needed_s)) return fmt::format("{}{} no length of record gives 10 %.", found, joint);
  return fmt::format("{}{} for 10 % record at least {}.", found, joint,
                     duration_text(longer.needed_s, text::DurationForm::rough));
}

// Of rate random walk that the record does not tell from none: one statement, whatever else is known of it.
std::string walk_text(const AxisDatasheet& axis) {
  if (axis.fit[Term::rate_random_walk].value > 0)
    return "Rate random walk is not resolved in this record: quote the upper limit.";
  return "No rate random walk is seen within this record: it may show in a longer one. Quote the upper limit.";
}

std::string one_line_verdict(const AxisDatasheet& axis) {
  if (!axis.is_fitted()) return "no coefficients, as an error ended its fit";
  const fit::Result& fit = axis.fit;
  if (!fit::is_tested(fit) || !fit.converged) return verdict_headline(fit);
  std::string text = fmt::format("{} by the model from {} on ({}", verdict_headline(fit), tau_text(fit.tau_min_s),
                                 probability_text(fit.p_value));
  if (fit.verdict != fit::Verdict::described && fit.worst_misfit > 0)
    text += fmt::format("; worst at {}, by {}", tau_text(fit.worst_misfit_tau_s), percent(fit.worst_misfit));
  return text + (fit.verdict == fit::Verdict::not_described ? "): do not use" : ")");
}

std::string_view stage_text(calibration::Stage stage) {
  using enum calibration::Stage;
  switch (stage) {
    case screening:
      return "The search for outliers and steps";
    case curve:
      return "The Allan curve";
    case choice:
      return "The choice of terms";
    case fit:
      return "The fit";
    case departure:
      return "The search for a warm-up and drifts";
    case lines:
      return "The search for spectral lines";
    case intervals:
      return "The curve with its intervals";
    case cross_check:
      return "The cross-check";
    case facts:
      break;
  }
  return "What to know or do";
}

std::string fault_text(const calibration::Fault& fault, const AxisDatasheet& axis) {
  std::string text = fmt::format("{} of {} ended in an error: {}", stage_text(fault.stage), axis.name, fault.what);
  if (fault.reason) text += fmt::format("; {}", mend(*fault.reason));
  text += ". ";
  if (!axis.is_fitted()) return text + "It has no coefficients; the other columns do not need it.";
  if (fault.stage == calibration::Stage::choice) text += "The default terms were fitted instead.";
  if (fault.stage != calibration::Stage::choice) text += "The coefficients stand without it.";
  return fault.reason ? text : text + " Please report this error.";
}

AxisResult axis_result(const AxisDatasheet& axis, const Datasheet& sheet) {
  return {.name = axis.name,
          .signal = axis.signal,
          .mean = axis.mean,
          .points = axis.points,
          .fit = axis.is_fitted() ? std::optional(axis.fit) : std::nullopt,
          .chosen = axis.chosen,
          .cross_checked = axis.cross_checked,
          .findings = axis.findings,
          .psd = {},
          .dynamic = {},
          .faults = axis.faults,
          .advice = advice(axis, sheet)};
}

// --- The comment of a sensor file -----------------------------------------------------------------------------------

std::string comment_line(const std::string& text) { return wrapped(text, "", "  "); }
std::string comment_item(const std::string& text) { return wrapped(text, "  - ", "    "); }

std::string head(const std::vector<std::string>& spoilt) {
  std::string text;
  for (const std::string& warning : spoilt) text += comment_line(fmt::format("WARNING: {}.", warning));
  return text;
}

std::string key_of(noise::Signal signal, Term term) {
  return fmt::format("{}.{}", signal == noise::Signal::angular_rate ? "gyro" : "accelerometer",
                     noise::key(signal, term));
}

std::string chance(double p_value) {
  constexpr double kLeast = 1e-12;  // beyond, no tail of chi-square is that exact
  return p_value < kLeast ? fmt::format("p < {:.0e}", kLeast) : fmt::format("p = {:.1g}", p_value);
}

std::string over_axes(const calibration::SensorSummary& summary, std::size_t axes) {
  std::string text;
  if (axes > 1)
    text += comment_line(
        "A single value is the root mean square over the axes of its triad; [x, y, z] are those of axes that differ.");
  std::vector<std::string> differ, partly;
  for (const auto& c : summary.coefficients) {
    if (!c.per_axis) continue;
    if (c.p_value < calibration::kAxesDiffer)
      differ.push_back(fmt::format("{} ({})", key_of(c.signal, c.term), chance(c.p_value)));
    else
      partly.push_back(key_of(c.signal, c.term));
  }
  if (!differ.empty())
    text += comment_line(fmt::format("Axes differ by more than their scatter, which chance does with this p: {}.",
                                     text::listing(differ)));
  if (!partly.empty())
    text += comment_line(fmt::format("Only some axes were fitted with: {}; the others have 0.", text::listing(partly)));
  if (!summary.borrowed.empty())
    text += comment_line(fmt::format("The record tells nothing of {}: the root mean square of the others stands there.",
                                     text::listing(summary.borrowed)));
  for (const noise::Signal signal : summary.without_places)
    text += comment_line(fmt::format(
        "Which {} axis is x, y or z is not known: the values are over all of them, whether they differ or not.",
        signal == noise::Signal::angular_rate ? "gyro" : "accelerometer"));
  return text;
}

// What the file does not tell.
std::string foot(const Provenance& of) {
  std::vector<std::string> names;
  for (const noise::Signal signal : {noise::Signal::angular_rate, noise::Signal::specific_force}) {
    const auto fitted = [&](Term term) {
      return std::ranges::any_of(of.summary.coefficients,
                                 [&](const auto& c) { return c.signal == signal && c.term == term; });
    };
    const auto& model =
        signal == noise::Signal::angular_rate ? std::optional(of.written.gyro) : of.written.accelerometer;
    if (!model || std::ranges::none_of(reading_order(), fitted)) continue;
    for (const Term term : {Term::white, Term::flicker, Term::rate_random_walk})
      if (!fitted(term) && (*model)[term] == 0) names.push_back(key_of(signal, term));
  }
  for (std::string& name : not_stated(of.written)) names.push_back(std::move(name));
  std::string text;
  if (!names.empty())
    text += comment_line(fmt::format("Not known from this record, and taken as zero until it is stated below: {}.",
                                     text::listing(names)));
  return text + std::string(sensor_file::kEndOfComment) + "\n";
}

constexpr std::string_view kUntested = "The record is too short to test whether the model describes it: record longer.";

// What the advice says that is still to be known where the numbers are used.
std::vector<std::string> warnings(const AxisDatasheet& axis, const Datasheet& sheet) {
  std::vector<std::string> texts;
  const calibration::Facts& facts = axis.facts;
  if (facts.untested) texts.emplace_back(kUntested);
  if (axis.findings)
    std::ranges::move(describe(*axis.findings, {axis.signal, sheet.samples, 1 / sheet.rate_hz}),
                      std::back_inserter(texts));
  return texts;
}

}  // namespace

std::vector<std::string> advice(const AxisDatasheet& axis, const Datasheet& sheet) {
  const calibration::Facts& facts = axis.facts;
  std::vector<std::string> texts;
  for (const auto& fault : axis.faults) texts.push_back(fault_text(fault, axis));
  if (facts.all_equal) {
    texts.push_back(fmt::format(
        "Every sample of {} is equal: the log holds no noise to measure. The sensor is not connected, or its resolution hides its noise: log raw counts or at a finer range.",
        axis.name));
    return texts;
  }
  if (facts.no_answer)
    texts.push_back(fmt::format(
        "None of angle random walk, bias instability and rate random walk is resolved{}",
        facts.only_quantization ? ": what is seen is quantization. Record at a finer resolution, or longer." : "."));
  if (facts.untested) texts.emplace_back(kUntested);
  if (facts.misfit)
    texts.emplace_back(
        "Do not use these coefficients: the curve has a shape that no sum of the fitted terms has. Look at the residuals; motion of the support, temperature, periodic disturbances and vibration bounded in angle all do this. Repeat the record on a still base at constant temperature, or fit other terms (--terms), or a range of taus (--tau-min, --tau-max).");
  if (axis.findings)
    std::ranges::move(describe(*axis.findings, {axis.signal, sheet.samples, 1 / sheet.rate_hz}),
                      std::back_inserter(texts));
  if (facts.later) {
    const std::string from = not_above(facts.later->tau_min_s);
    texts.push_back(
        fmt::format("From {0} s on the same terms describe the curve ({1}): --tau-min {0}s fits them there.", from,
                    probability_text(facts.later->p_value)));
  }
  const auto is_walk = [](const auto& longer) { return longer.term == Term::rate_random_walk; };
  if (facts.walk_unresolved && std::ranges::none_of(facts.longer, is_walk)) texts.push_back(walk_text(axis));
  for (const auto& longer : facts.longer) texts.push_back(longer_text(longer));
  return texts;
}

LogResult calibration_result(const Datasheet& sheet, std::vector<std::string> notes, std::string command) {
  LogResult result{.source = sheet.source,
                   .command = std::move(command),
                   .rate_hz = sheet.rate_hz,
                   .samples = sheet.samples,
                   .missing_samples = sheet.missing_samples,
                   .notes = std::move(notes),
                   .segments = {},
                   .axes = {}};
  for (const AxisDatasheet& axis : sheet.axes) result.axes.push_back(axis_result(axis, sheet));
  return result;
}

RunsResult runs_result(const TypeDatasheet& sheet, std::vector<std::vector<std::string>> notes, std::string command) {
  RunsResult result{.command = command, .runs = {}, .combined = sheet.axes};
  for (std::size_t i = 0; i < sheet.records.size(); ++i)
    result.runs.push_back(calibration_result(sheet.records[i], std::move(notes[i]), command));
  return result;
}

std::string_view mend(calibration::Unusable::Reason reason) {
  using enum calibration::Unusable::Reason;
  switch (reason) {
    case too_short:
      return "a datasheet needs hours of record (gyrobudget plan tells how many)";
    case too_few_taus:
      return "fit fewer terms (--terms) or use a part of the log without gaps";
    case out_of_scale:
      return "give their unit, or bring them there with --scale";
    case between_samples:
      return "give the rate of the record behind the table (--rate)";
    case other_axes:
      return "records of one sensor type have the same columns, in units of the same kinds (choose them with --column)";
    case other_rate:
      break;
  }
  return "quantization and filters depend on the rate, so records of other rates are not combined";
}

std::vector<std::string> spoilt_texts(const Datasheet& sheet) {
  std::vector<std::string> texts;
  for (const AxisDatasheet& axis : sheet.axes) {
    if (!axis.has_answer() || !axis.is_spoilt()) continue;
    texts.push_back(fmt::format("{}{} holds {} that the fit took for noise", kNotYet, printable(axis.name),
                                text::listing(spoilt_by(*axis.findings))));
  }
  return texts;
}

std::vector<std::string> spoilt_texts(const TypeDatasheet& sheet) {
  std::vector<std::string> texts;
  for (const Datasheet& record : sheet.records)
    for (const std::string& text : spoilt_texts(record))
      texts.push_back(fmt::format("{} in {}", text, printable(record.source)));
  return texts;
}

std::string provenance(const Datasheet& sheet, const Provenance& of) {
  std::string text =
      head(spoilt_texts(sheet)) + fmt::format("Fitted by: {}\nRecord: {} samples at {} Hz, {} missing\n", of.command,
                                              sheet.samples, sheet.rate_hz, sheet.missing_samples);
  text += over_axes(of.summary, sheet.axes.size());
  for (const AxisDatasheet& axis : sheet.axes) {
    text += comment_line(fmt::format("{}: {}{}", printable(axis.name), one_line_verdict(axis),
                                     axis.has_answer() ? "" : "; it is not written"));
    for (const auto& c : axis.fit.coefficients) {
      if (!axis.has_answer() || !c.fitted || c.status == fit::Status::identified) continue;
      const auto unit = noise::datasheet_unit(axis.signal, c.term);
      const std::string limit = std::isfinite(c.upper) ? fmt::format("at most {} (95 %); a cautious budget takes that",
                                                                     noise::quantity_text(c.upper, unit, 3))
                                                       : "and the record sets no limit";
      text += comment_item(fmt::format("{} is not resolved: {} is the fitted value, {}",
                                       noise::key(axis.signal, c.term), noise::quantity_text(c.value, unit, 3), limit));
    }
    if (!axis.is_confirmed()) text += comment_item("the likelihood of the record does not confirm the fit");
    for (const std::string& warning : warnings(axis, sheet)) text += comment_item(warning);
  }
  return text + foot(of);
}

std::string provenance(const TypeDatasheet& sheet, const Provenance& of) {
  std::string text =
      head(spoilt_texts(sheet)) + fmt::format("Fitted by: {}\nEach record by itself, then combined:\n", of.command);
  for (const auto& run : sheet.records) {
    text += comment_item(fmt::format("{}: {} samples at {} Hz, {} missing", printable(run.source), run.samples,
                                     run.rate_hz, run.missing_samples));
    for (const AxisDatasheet& axis : run.axes) {
      if (!axis.has_answer())
        text +=
            comment_item(fmt::format("{} of it: {}; it is not taken", printable(axis.name), one_line_verdict(axis)));
      else
        for (const std::string& warning : warnings(axis, run))
          text += comment_item(fmt::format("{} of it: {}", printable(axis.name), warning));
    }
  }
  text += over_axes(of.summary, sheet.axes.size());
  for (const auto& axis : sheet.axes) {
    for (const auto& c : axis.coefficients) {
      const auto t = combined_text(axis.signal, c);
      text += comment_line(fmt::format("{}: {} {}, {} (95 %), spread between records {} {}; {}", printable(axis.name),
                                       noise::key(axis.signal, c.term), t.value, t.interval, t.spread, t.unit,
                                       t.agreement));
    }
  }
  return text + "Gauss-Markov processes and sinusoids are left out: they are not combined.\n" + foot(of);
}

}  // namespace gyrobudget::inline v0::report

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

std::string size_text(double si, const Of& of) { return noise::quantity_text(si, noise::datasheet_unit(of.signal), 3); }

std::string at_text(std::int64_t index, const Of& of) {
  return fmt::format("{:.6g} s", static_cast<double>(index) * of.dt);
}

std::string describe_held(const calibration::Held& held) {
  std::string text = fmt::format(
      "{} of the rows repeat the row before in every axis: the sensor gives {:.4g} readings a second, fewer than the log has rows. The repeats are left out; curve and fit are of the readings at that rate.",
      percent(held.share()), held.rate_hz);
  constexpr double kVisible = 1e-3;
  if (held.raised < 1 + kVisible) return text;
  return text +
         fmt::format(
             " As readings stand for {:.3g} rows on average but not for equally many, whoever sums the rows as they are has {} more white noise than the readings at their own rate: N, its interval and the curve hold that.",
             held.rows_each, percent(held.raised - 1));
}

std::string describe_rounding(const allan::Rounding& rounding, const Of& of) {
  const std::string what = fmt::format("The samples are rounded to steps of {}", size_text(rounding.step, of));
  if (!rounding.is_above_noise())
    return fmt::format(
        "{}, {:.2g} times their scatter. That adds white noise of a twelfth of the squared step, {} of the variance of a sample, which N holds.",
        what, rounding.step / rounding.scatter, percent(rounding.share()));
  const std::string times = rounding.scatter > 0
                                ? fmt::format("{:.2g} times their scatter", rounding.step / rounding.scatter)
                                : "which most neighbours do not leave";
  return fmt::format("{} ({} different values), {}: N could be wrong by tens of percent either way{}.", what,
                     rounding.distinct, times,
                     rounding.is_dithered_by_wander() ? "" : ", and so could the other coefficients");
}

std::string describe_saturation(const allan::Saturation& end, const Findings& found, const Of& of) {
  return fmt::format(
      "{} samples ({}) stand at {}, an end of the range, the first at {}, up to {} in a row. What lies beyond is cut off: the mean is wrong, and white noise comes out too small. Use a wider range.",
      count_text(end.count), percent(static_cast<double>(end.count) / static_cast<double>(found.samples)),
      size_text(end.value, of), at_text(end.first, of), end.longest);
}

std::string describe_turns(const allan::Turns& turns, const Of& of) {
  return fmt::format(
      "The rows come by turns from {} sensors: their levels lie {} apart and their noises differ by a factor of {:.2g}. Where a column says whose row it is, --rows COLUMN=VALUE reads those of one.",
      turns.sensors, size_text(turns.levels, of), turns.noises);
}

std::string describe_motion(const Findings& found, const Of& of) {
  std::int64_t samples = 0;
  for (const auto& m : found.motion) samples += m.count;
  const auto by_peak = [](const auto& a, const auto& b) { return std::abs(a.peak) < std::abs(b.peak); };
  const auto& worst = *std::ranges::max_element(found.motion, by_peak);
  const double to_degrees = 1 / noise::parse_unit("deg").to_si;
  const std::string turned =
      of.signal == noise::Signal::angular_rate ? fmt::format(", turning by {:.3g} deg", worst.turned * to_degrees) : "";
  return fmt::format(
      "The sensor was moved {} ({} of the samples), the first time at {} and the most at {} for {}, by up to {} from its level{}. {}",
      found.motion.size() == 1 ? "once" : fmt::format("{} times", found.motion.size()),
      percent(static_cast<double>(samples) / static_cast<double>(found.samples)),
      at_text(found.motion.front().first, of), at_text(worst.first, of), at_text(worst.count, of),
      size_text(worst.peak, of), turned,
      found.motion_masked ? "These times are masked: neither curve nor fit holds them."
                          : "Noise does not do that: --mask motion leaves these times out.");
}

std::string describe_hump(const allan::Hump& hump, const Of& of) {
  return fmt::format(
      "The spectrum has a hump between {:.3g} and {:.3g} Hz with its top at {:.3g} Hz, {:.3g} times the spectrum beside it (amplitude {} rms): a resonance of the support, sway or a control loop, which the model does not have. It shifts the deviation at taus up to about {:.3g} s.",
      hump.low_hz, hump.high_hz, hump.frequency_hz, hump.ratio, size_text(hump.amplitude, of), 1 / hump.low_hz);
}

// Errors of which only the largest stand out of the noise.
std::string describe_tail(const Findings& found) {
  if (!found.tail) return {};
  const allan::OutlierTail& tail = *found.tail;
  return fmt::format(
      " They look like errors of {:.3g} sigma in {} of the samples, some of which hide in the noise: {}.", tail.sigmas,
      percent(tail.share),
      found.outliers_masked
          ? fmt::format(
                "N is without the {:+.2g} % that these and the mask would make of it, and its interval allows for it",
                50 * tail.left)
          : "N's interval allows for their scatter");
}

std::string describe_outliers(const Findings& found, const Of& of) {
  std::vector<double> at;
  bool in_use = false;
  for (const auto& outlier : found.outliers) {
    at.push_back(static_cast<double>(outlier.index) * of.dt);
    in_use |= outlier.index >= found.first && outlier.index < found.first + found.samples;
  }
  const auto& worst = *std::ranges::max_element(found.outliers, {}, &allan::Outlier::sigmas);
  const std::string worst_text = fmt::format("the worst at {} by {} ({:.3g} sigma)", at_text(worst.index, of),
                                             size_text(worst.distance, of), worst.sigmas);
  const std::string hidden_text = describe_tail(found);
  if (found.has_heavy_tail()) {
    return fmt::format(
        "{} of the samples ({} of {}) lie further from their surroundings than Gaussian noise would put any, all over the record, {}: the noise has a heavy tail. {}{}",
        percent(found.outlier_share()), count_text(std::ssize(found.outliers)), count_text(of.samples), worst_text,
        found.outliers_masked
            ? "It is masked: N is that of the core of the noise, and whoever uses the samples as they are has more."
            : fmt::format(
                  "N holds it{}: --mask outliers gives the N of the core. Look for a link that drops bits, or for vibration.",
                  found.tail ? "" : ", and its interval is too narrow for it"),
        hidden_text);
  }
  return fmt::format(
      "{} of {} samples ({}) lie further from their surroundings than noise would put any (at {}), {}. {}{}",
      found.outliers.size(), of.samples, percent(found.outlier_share()), times(at), worst_text,
      found.outliers_masked || !in_use
          ? "They are masked: neither curve nor fit holds them."
          : "They are in curve and fit: find what knocked, and leave the samples out with --mask outliers.",
      hidden_text);
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
  if (found.held) text.push_back(describe_held(*found.held));
  constexpr double kMatters = 0.02;  // of the variance: a percent of N
  if (found.rounding && (found.rounding->is_above_noise() || found.rounding->share() > kMatters))
    text.push_back(describe_rounding(*found.rounding, of));
  for (const auto& end : found.saturation) text.push_back(describe_saturation(end, found, of));
  if (found.turns) text.push_back(describe_turns(*found.turns, of));
  if (!found.outliers.empty()) text.push_back(describe_outliers(found, of));
  if (!found.motion.empty()) text.push_back(describe_motion(found, of));
  if (!found.steps.empty()) text.push_back(describe_steps(found, of));
  if (found.departure) text.push_back(describe_departure(found, of));
  for (const auto& hump : found.humps) text.push_back(describe_hump(hump, of));
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

// The record of an axis; where its rows repeat, that of its readings.
Of record_of(const AxisDatasheet& axis, const Datasheet& sheet) {
  if (axis.findings && axis.findings->held)
    return {axis.signal, axis.findings->held->readings, 1 / axis.findings->held->rate_hz};
  return {axis.signal, sheet.samples, 1 / sheet.rate_hz};
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
  if (axis.findings && axis.findings->not_at_rest()) return "not described, the sensor was moved: do not use";
  if (axis.findings && axis.findings->not_of_one_sensor())
    return "not described, the rows are of several sensors: do not use";
  if (axis.findings && axis.findings->rounded_above_noise() && !axis.has_answer())
    return "not quotable, the samples are rounded to steps above their noise: do not use";
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
      return "The search for what the record holds beside noise";
    case curve:
      return "The Allan curve";
    case choice:
      return "The choice of terms";
    case fit:
      return "The fit";
    case temperature:
      return "The fit of the bias over temperature";
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
          .temperature = axis.temperature,
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
  for (const noise::Signal signal : summary.without_filter)
    text += comment_line(fmt::format(
        "The record shows a low pass of the {0}, of a kind that cannot be told or not the same on all axes: {0}.filter is left out.",
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
  if (axis.findings) std::ranges::move(describe(*axis.findings, record_of(axis, sheet)), std::back_inserter(texts));
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
  if (axis.findings) std::ranges::move(describe(*axis.findings, record_of(axis, sheet)), std::back_inserter(texts));
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
    if (const auto by = spoilt_by(*axis.findings); !by.empty())
      texts.push_back(
          fmt::format("{}{} holds {} that the fit took for noise", kNotYet, printable(axis.name), text::listing(by)));
    if (axis.findings->rounded_above_noise())
      texts.push_back(fmt::format("{}{} is rounded to steps above its noise, so that they lack its white noise",
                                  kNotYet, printable(axis.name)));
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
      if (c.status == fit::Status::not_quotable) {
        text += comment_item(fmt::format("{} is not quotable: the samples are rounded to steps above their noise",
                                         noise::key(axis.signal, c.term)));
        continue;
      }
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

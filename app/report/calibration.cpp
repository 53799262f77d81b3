// SPDX-License-Identifier: MIT
#include "calibration.h"

#include "gyrobudget/noise/sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

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
  if (found.has_heavy_tail()) {
    return fmt::format(
        "{} of the samples ({} of {}) lie further from their surroundings than Gaussian noise would put any, all over the record, {}: the noise has a heavy tail. {}",
        percent(found.outlier_share()), count_text(std::ssize(found.outliers)), count_text(of.samples), worst_text,
        found.outliers_masked
            ? "It is masked: N is that of the core of the noise, and whoever uses the samples as they are has more."
            : "N holds it, and its interval is too narrow for it: --mask outliers gives the N of the core. Look for a link that drops bits, or for vibration.");
  }
  return fmt::format(
      "{} of {} samples ({}) lie further from their surroundings than noise would put any (at {}), {}. {}",
      found.outliers.size(), of.samples, percent(found.outlier_share()), times(at), worst_text,
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
  const std::string chance = fmt::format("noise would do that with p = {:.1g}", departure.p_value);
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
  return fmt::format(
      "{} fainter lines lie between {:.3g} and {:.3g} Hz (up to {:.0f} times the spectrum beside them). So many are rather a spectrum with structure, as of a sensor that moves: look at it with gyrobudget allan --psd welch --report.",
      lines.size(), low.frequency_hz, high.frequency_hz,
      std::ranges::max(lines, {}, &allan::SpectralLine::ratio).ratio);
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

// --- What follows from the fit ------------------------------------------------------------------------------------

std::string longer_text(const calibration::LongerRecord& longer) {
  return fmt::format("{} is known to {:.0f} % here ({} of record); for 10 % record at least {}.",
                     longer.term == Term::flicker ? "Bias instability" : "Rate random walk", 100 * longer.relative_std,
                     duration_text(longer.duration_s, text::DurationForm::rough),
                     std::isfinite(longer.needed_s) ? duration_text(longer.needed_s, text::DurationForm::rough)
                                                    : "longer than anyone would");
}

std::string one_line_verdict(const AxisDatasheet& axis) {
  const fit::Result& fit = axis.fit;
  if (axis.findings && axis.findings->not_at_rest()) return "NOT described, the sensor was moved: do not use";
  if (axis.findings && axis.findings->not_of_one_sensor())
    return "NOT described, the rows are of several sensors: do not use";
  switch (fit.verdict) {
    case fit::Verdict::described:
      return fmt::format("described by the model from {:.4g} s on (p = {:.2g})", fit.tau_min_s, fit.p_value);
    case fit::Verdict::described_within:
      return fmt::format("described within {:.1f} % (worst at {:.4g} s; p = {:.2g})", 100 * fit.worst_misfit,
                         fit.worst_misfit_tau_s, fit.p_value);
    case fit::Verdict::not_described:
      break;
  }
  return fmt::format("NOT described by the model (p = {:.2g}, off by {:.0f} % at {:.4g} s): do not use", fit.p_value,
                     100 * fit.worst_misfit, fit.worst_misfit_tau_s);
}

AxisResult axis_result(const AxisDatasheet& axis, const Datasheet& sheet) {
  return {.name = axis.name,
          .signal = axis.signal,
          .mean = axis.mean,
          .points = axis.points,
          .fit = axis.fit,
          .chosen = axis.chosen,
          .cross_checked = axis.cross_checked,
          .findings = axis.findings,
          .temperature = axis.temperature,
          .psd = {},
          .dynamic = {},
          .advice = advice(axis, sheet)};
}

}  // namespace

std::vector<std::string> advice(const AxisDatasheet& axis, const Datasheet& sheet) {
  const calibration::Facts& facts = axis.facts;
  if (facts.all_equal)
    return {fmt::format(
        "Every sample of {} is equal: the log holds no noise to measure. The sensor is not connected, or its resolution hides its noise: log raw counts or at a finer range.",
        axis.name)};
  std::vector<std::string> texts;
  if (facts.no_answer)
    texts.push_back(fmt::format(
        "None of angle random walk, bias instability and rate random walk is resolved{}",
        facts.only_quantization ? ": what is seen is quantization. Record at a finer resolution, or longer." : "."));
  if (facts.untested)
    texts.emplace_back("The record is too short to test whether the model describes it: record longer.");
  if (facts.misfit)
    texts.emplace_back(
        "Do not use these coefficients: the curve has a shape that no sum of the fitted terms has. Look at the residuals; motion of the support, temperature, periodic disturbances and vibration bounded in angle all do this. Repeat the record on a still base at constant temperature, or fit other terms (--terms), or a range of taus (--tau-min, --tau-max).");
  if (axis.findings) {
    const auto& held = axis.findings->held;
    const Of of{axis.signal, held ? held->readings : sheet.samples, 1 / (held ? held->rate_hz : sheet.rate_hz)};
    std::ranges::move(describe(*axis.findings, of), std::back_inserter(texts));
  }
  if (facts.walk_unresolved)
    texts.emplace_back(
        "No rate random walk is seen within this record: it may show in a longer one. Quote the upper limit.");
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

std::string provenance(const Datasheet& sheet, std::string_view command) {
  std::string text = fmt::format("Fitted by: {}\nRecord: {} samples at {} Hz, {} missing\n", command, sheet.samples,
                                 sheet.rate_hz, sheet.missing_samples);
  if (sheet.axes.size() > 1) text += "Each value is the root mean square over the axes of its triad.\n";
  for (const auto& axis : sheet.axes) {
    text += fmt::format("{}: {}\n", axis.name, one_line_verdict(axis));
    for (const auto& c : axis.fit.coefficients) {
      if (!c.fitted || c.status == fit::Status::identified) continue;
      const auto unit = noise::datasheet_unit(axis.signal, c.term);
      text +=
          fmt::format("  {} is not resolved: {} is the fitted value, at most {} (95 %); a cautious budget takes that\n",
                      noise::key(axis.signal, c.term), noise::quantity_text(c.value, unit, 3),
                      noise::quantity_text(c.upper, unit, 3));
    }
  }
  return text;
}

std::string provenance(const TypeDatasheet& sheet, std::string_view command) {
  std::string text = fmt::format("Fitted by: {}\nEach record by itself, then combined:\n", command);
  for (const auto& run : sheet.records) {
    text += fmt::format("  {}: {} samples at {} Hz, {} missing\n", printable(run.source), run.samples, run.rate_hz,
                        run.missing_samples);
  }
  if (sheet.axes.size() > 1) text += "Each value is the root mean square over the axes of its triad.\n";
  for (const auto& axis : sheet.axes) {
    for (const auto& c : axis.coefficients) {
      const auto t = combined_text(axis.signal, c);
      text += fmt::format("{}: {} {}, {} (95 %), spread between records {} {}; {}\n", printable(axis.name),
                          noise::key(axis.signal, c.term), t.value, t.interval, t.spread, t.unit, t.agreement);
    }
  }
  return text + "Gauss-Markov processes and sinusoids are left out: they are not combined.\n";
}

}  // namespace gyrobudget::inline v0::report

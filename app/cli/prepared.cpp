// SPDX-License-Identifier: MIT
#include "prepared.h"

#include "gyrobudget/app/report/words.h"
#include "gyrobudget/noise/sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobudget::inline v0::cli {
namespace {

constexpr double kSettled = 5;               // time constants of a warm-up: 0.7 % of it is left
constexpr double kFillBesideOutliers = 0.8;  // of a cluster

std::string times(const std::vector<double>& seconds) {
  constexpr std::size_t kNamed = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(seconds.size(), kNamed); ++i)
    text += fmt::format("{}{:.6g}", i > 0 ? ", " : "", seconds[i]);
  return text + (seconds.size() > kNamed ? ", ... s" : " s");
}

std::string describe_outliers(const report::Findings& found, const allan::Axis& axis, double dt) {
  std::vector<double> at;
  bool in_use = false;
  for (const auto& outlier : found.outliers) {
    at.push_back(static_cast<double>(outlier.index) * dt);
    in_use |= outlier.index >= found.first && outlier.index < found.first + found.samples;
  }
  const auto& worst = *std::max_element(found.outliers.begin(), found.outliers.end(),
                                        [](const auto& a, const auto& b) { return a.sigmas < b.sigmas; });
  return fmt::format(
      "{} of {} samples lie further from their surroundings than noise would put any (at {}), the worst at {:.6g} s by {} ({:.3g} sigma). {}",
      found.outliers.size(), axis.rate.size(), times(at), static_cast<double>(worst.index) * dt,
      noise::quantity_text(worst.distance, noise::datasheet_unit(axis.signal), 3), worst.sigmas,
      found.outliers_masked || !in_use
          ? "They are masked: neither curve nor fit holds them."
          : "They are in curve and fit: find what knocked, and leave the samples out with --mask outliers.");
}

std::string describe_steps(const report::Findings& found, const allan::Axis& axis, double dt) {
  std::string text;
  for (const auto& step : found.steps) {
    text += fmt::format("{}{} at {:.6g} s", text.empty() ? "" : ", ",
                        noise::quantity_text(step.size, noise::datasheet_unit(axis.signal), 3),
                        static_cast<double>(step.index) * dt);
  }
  return fmt::format(
      "The mean jumps by {}. {}", text,
      found.steps_masked
          ? "The longest part without a jump is used."
          : "Curve and fit hold the jump, mostly as rate random walk: --mask steps uses the longest part without one.");
}

std::string describe_departure(const report::Findings& found, const allan::Axis& axis) {
  const allan::Departure& departure = *found.departure;
  const auto size = noise::quantity_text(departure.size, noise::datasheet_unit(axis.signal), 3);
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

// A line that the model has is not one that it lacks.
void drop_modelled_line(std::vector<allan::SpectralLine>& lines, const fit::Result& fit, double duration_s) {
  const auto* line = report::find(fit, noise::Term::sinusoid);
  if (line == nullptr || !line->fitted || line->status != fit::Status::identified) return;
  const double width = 4 / duration_s;  // resolution of the averaged spectrum is coarser than a bin
  std::erase_if(lines,
                [&](const auto& l) { return std::abs(l.frequency_hz - line->shape) < width + 0.02 * line->shape; });
}

}  // namespace

Prepared::Prepared(const allan::Axis& axis, double dt, const CalibrateArguments& a)
    : axis_(axis), masking_(a.masking), dt_(dt), fill_(a.curve.strict_gaps ? 1 : allan::kMinimumFill) {
  look_for_outliers_and_steps();
}

std::span<const double> Prepared::part_of(std::span<const double> whole) const {
  return whole.subspan(static_cast<std::size_t>(findings_.first), static_cast<std::size_t>(findings_.samples));
}

std::span<const double> Prepared::without_outliers() const {
  return part_of(masked_.empty() ? std::span<const double>(axis_.rate) : masked_);
}

void Prepared::keep(std::int64_t first, std::int64_t count) {
  findings_.first = first;
  findings_.samples = count;
  record_.emplace(findings_.outliers_masked ? without_outliers() : part_of(axis_.rate), dt_, fill_);
}

void Prepared::keep_longest_without_step() {
  const std::int64_t end = findings_.first + findings_.samples;
  std::int64_t begin = findings_.first, first = begin, count = 0;
  for (std::size_t i = 0; i <= findings_.steps.size(); ++i) {
    const std::int64_t next = i < findings_.steps.size() ? std::clamp(findings_.steps[i].index, begin, end) : end;
    if (next - begin > count) first = begin, count = next - begin;
    begin = next;
  }
  findings_.steps_masked = true;
  keep(first, count);
}

void Prepared::look_for_outliers_and_steps() {
  const auto samples = static_cast<std::int64_t>(axis_.rate.size());
  findings_.outliers = allan::find_outliers(axis_.rate);
  findings_.outliers_masked = masking_.outliers && !findings_.outliers.empty();
  if (!findings_.outliers.empty()) {
    masked_.assign(axis_.rate.begin(), axis_.rate.end());
    for (const auto& outlier : findings_.outliers)
      masked_[static_cast<std::size_t>(outlier.index)] = std::numeric_limits<double>::quiet_NaN();
  }
  // Outliers, unlike gaps, can be as many as clusters may miss: these then must do with fewer samples.
  if (findings_.outliers_masked && !(fill_ == 1)) fill_ = kFillBesideOutliers;
  keep(0, samples);
  // A knock moves means too: it is no step.
  const bool knocks = !findings_.outliers.empty() && !findings_.outliers_masked;
  findings_.steps =
      knocks ? allan::find_steps(allan::Series(without_outliers(), dt_, fill_)) : allan::find_steps(*record_);
  if (masking_.steps && !findings_.steps.empty()) keep_longest_without_step();
}

bool Prepared::look_for_departure(std::span<const noise::Process> fitted) {
  std::optional<allan::Series> clean;
  if (!findings_.outliers.empty() && !findings_.outliers_masked) clean.emplace(without_outliers(), dt_, fill_);
  auto departure = allan::find_departure(clean ? *clean : *record_, fitted);
  if (!departure) return false;
  if (departure->kind == allan::Departure::Kind::step) {
    if (!findings_.steps.empty() && !findings_.steps_masked) return false;  // named already
    findings_.steps.push_back({.index = findings_.first + departure->index,
                               .size = departure->size,
                               .sigmas = departure->sigmas,
                               .span = findings_.samples / 128});
    std::sort(findings_.steps.begin(), findings_.steps.end(),
              [](const auto& a, const auto& b) { return a.index < b.index; });
    if (masking_.steps) keep_longest_without_step();
    return masking_.steps;
  }
  findings_.departure = departure;
  if (!masking_.warm_up || departure->kind != allan::Departure::Kind::warm_up) return false;
  const auto settling = static_cast<std::int64_t>(std::llround(kSettled * departure->time_constant_s / dt_));
  if (2 * settling > findings_.samples) return false;
  findings_.warm_up_masked = true;
  keep(findings_.first + settling, findings_.samples - settling);
  return true;
}

void Prepared::look_for_lines(const fit::Result& fit) {
  findings_.lines = allan::find_lines(without_outliers(), dt_);
  drop_modelled_line(findings_.lines, fit, static_cast<double>(findings_.samples) * dt_);
}

std::vector<std::string> describe(const report::Findings& found, const allan::Axis& axis, double dt) {
  std::vector<std::string> text;
  const bool part = found.samples < static_cast<std::int64_t>(axis.rate.size());
  if (part) {
    text.push_back(fmt::format("Curve and fit are of the samples from {:.6g} s to {:.6g} s; the others are masked.",
                               static_cast<double>(found.first) * dt,
                               static_cast<double>(found.first + found.samples) * dt));
  }
  if (!found.outliers.empty()) text.push_back(describe_outliers(found, axis, dt));
  if (!found.steps.empty()) text.push_back(describe_steps(found, axis, dt));
  if (found.departure) text.push_back(describe_departure(found, axis));
  // Lines are noise that no coefficient describes: vibration, mains, a fan, a control loop.
  constexpr std::size_t kNamed = 3;  // strongest first
  for (std::size_t i = 0; i < found.lines.size() && i < kNamed; ++i) {
    const auto& line = found.lines[i];
    text.push_back(fmt::format(
        "A spectral line at {:.3g} Hz (amplitude about {}, {:.0f} times the spectrum beside it) is in the record but not in the model. It shifts the deviation at taus up to its period, {:.3g} s.",
        line.frequency_hz, noise::quantity_text(line.amplitude, noise::datasheet_unit(axis.signal), 3), line.ratio,
        1 / line.frequency_hz));
  }
  if (found.lines.size() > kNamed) text.push_back(describe_fainter(std::span(found.lines).subspan(kNamed)));
  return text;
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
#include "prepared.h"

#include "gyrobudget/noise/sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobudget::inline v0::cli {
namespace {

constexpr double kSettled = 5;  // time constants of a warm-up: 0.7 % of it is left

std::string times(const std::vector<double>& seconds) {
  constexpr std::size_t kNamed = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(seconds.size(), kNamed); ++i)
    text += fmt::format("{}{:.6g}", i > 0 ? ", " : "", seconds[i]);
  return text + (seconds.size() > kNamed ? ", ... s" : " s");
}

std::string describe_outliers(const report::Findings& found, const io::Axis& axis, double dt) {
  std::vector<double> at;
  for (const auto& outlier : found.outliers) at.push_back(static_cast<double>(outlier.index) * dt);
  const auto& worst = *std::max_element(found.outliers.begin(), found.outliers.end(),
                                        [](const auto& a, const auto& b) { return a.sigmas < b.sigmas; });
  return fmt::format(
      "{} of {} samples lie further from their surroundings than noise would put any (at {}), the worst at "
      "{:.6g} s "
      "by {} ({:.3g} sigma). {}",
      found.outliers.size(), axis.rate.size(), times(at), static_cast<double>(worst.index) * dt,
      noise::quantity_text(worst.distance, noise::datasheet_unit(axis.signal), 3), worst.sigmas,
      found.outliers_masked
          ? "They are masked: neither curve nor fit holds them."
          : "They are in curve and fit and spoil them: find what knocked, and leave the samples "
            "out with --mask outliers.");
}

std::string describe_steps(const report::Findings& found, const io::Axis& axis, double dt, bool masked) {
  std::string text;
  for (const auto& step : found.steps) {
    text += fmt::format("{}{} at {:.6g} s", text.empty() ? "" : ", ",
                        noise::quantity_text(step.size, noise::datasheet_unit(axis.signal), 3),
                        static_cast<double>(step.index) * dt);
  }
  return fmt::format(
      "The mean jumps by {}. {}", text,
      masked ? "The longest part without a jump is used."
             : "Curve and fit hold the jump, mostly as rate random walk: --mask steps uses the longest "
               "part without one.");
}

std::string describe_drift(const report::Findings& found, const io::Axis& axis) {
  const auto size = noise::quantity_text(found.drift->size, noise::datasheet_unit(axis.signal), 3);
  if (std::isinf(found.drift->time_constant_s)) {
    return fmt::format(
        "The record drifts by {} along a straight line (chance would do that with p = {:.1g}). Where the "
        "ramp is not "
        "fitted it counts as rate random walk: --terms N,B,K,R fits it.",
        size, found.drift->p_value);
  }
  return fmt::format(
      "The record begins with a warm-up of {} that fades with a time constant of about {:.3g} s (chance "
      "would do that "
      "with p = {:.1g}). Curve and fit hold it, mostly as rate random walk: --mask warm-up leaves out five "
      "time "
      "constants.",
      size, found.drift->time_constant_s, found.drift->p_value);
}

}  // namespace

Prepared::Prepared(const io::Axis& axis, double dt, const CalibrateArguments& a)
    : masking_(a.masking), dt_(dt), fill_(a.curve.strict_gaps ? 1 : allan::kMinimumFill) {
  look_for_outliers_and_steps(axis);
}

void Prepared::use(std::span<const double> rate) {
  rate_ = rate;
  record_.emplace(rate_, dt_, fill_);
}

void Prepared::keep(std::int64_t first, std::int64_t count) {
  findings_.first += first;
  findings_.samples = count;
  use(rate_.subspan(static_cast<std::size_t>(first), static_cast<std::size_t>(count)));
}

void Prepared::look_for_outliers_and_steps(const io::Axis& axis) {
  findings_.samples = static_cast<std::int64_t>(axis.rate.size());
  findings_.outliers = allan::find_outliers(axis.rate);
  if (findings_.outliers.empty()) {
    use(axis.rate);
  } else {
    masked_.assign(axis.rate.begin(), axis.rate.end());
    for (const auto& outlier : findings_.outliers)
      masked_[static_cast<std::size_t>(outlier.index)] = std::numeric_limits<double>::quiet_NaN();
    use(masked_);  // a knock moves means too: it is no step
  }
  findings_.steps = allan::find_steps(*record_);
  findings_.outliers_masked = masking_.outliers && !findings_.outliers.empty();
  if (!findings_.outliers_masked && !findings_.outliers.empty()) use(axis.rate);
  if (!masking_.steps || findings_.steps.empty()) return;
  std::int64_t begin = 0, first = 0, count = 0;
  for (std::size_t i = 0; i <= findings_.steps.size(); ++i) {
    const std::int64_t end = i < findings_.steps.size() ? findings_.steps[i].index : findings_.samples;
    if (end - begin > count) first = begin, count = end - begin;
    begin = end;
  }
  keep(first, count);
}

bool Prepared::look_for_drift(std::span<const noise::Process> fitted) {
  const bool again = findings_.drift.has_value();  // once masked, what is left is only reported
  const auto drift = allan::find_drift(*record_, fitted);
  if (!again) findings_.drift = drift;
  if (again || !drift || !masking_.warm_up || std::isinf(drift->time_constant_s)) return false;
  const auto settling = static_cast<std::int64_t>(std::llround(kSettled * drift->time_constant_s / dt_));
  if (2 * settling > findings_.samples) return false;
  keep(settling, findings_.samples - settling);
  return true;
}

void Prepared::look_for_lines() { findings_.lines = allan::find_lines(rate_, dt_); }

std::vector<std::string> describe(const report::Findings& found, const io::Axis& axis, double dt) {
  std::vector<std::string> text;
  const bool part = found.samples < static_cast<std::int64_t>(axis.rate.size());
  if (part) {
    text.push_back(fmt::format(
        "Curve and fit are of the samples from {:.6g} s to {:.6g} s; the others are masked.",
        static_cast<double>(found.first) * dt, static_cast<double>(found.first + found.samples) * dt));
  }
  if (!found.outliers.empty()) text.push_back(describe_outliers(found, axis, dt));
  if (!found.steps.empty()) text.push_back(describe_steps(found, axis, dt, part));
  if (found.drift) text.push_back(describe_drift(found, axis));
  // Lines are noise that no coefficient describes: vibration, mains, a fan, a control loop.
  for (const auto& line : found.lines) {
    text.push_back(fmt::format(
        "A spectral line at {:.3g} Hz (amplitude about {}, {:.0f} times the spectrum beside it) is in the "
        "record but not "
        "in the model. It shifts the deviation at taus up to its period, {:.3g} s.",
        line.frequency_hz, noise::quantity_text(line.amplitude, noise::datasheet_unit(axis.signal), 3),
        line.ratio, 1 / line.frequency_hz));
  }
  return text;
}

}  // namespace gyrobudget::inline v0::cli

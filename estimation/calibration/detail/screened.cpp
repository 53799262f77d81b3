// SPDX-License-Identifier: MIT
#include "screened.h"

#include "gyrobudget/estimation/fit/judgement.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobudget::inline v0::calibration::detail {
namespace {

constexpr double kSettled = 5;               // time constants of a warm-up: 0.7 % of it is left
constexpr double kFillBesideOutliers = 0.8;  // of a cluster
constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

// A line that the model has is not one that it lacks.
void drop_modelled_line(std::vector<allan::SpectralLine>& lines, const fit::Result& fit, double duration_s) {
  const auto* line = fit::find(fit, noise::Term::sinusoid);
  if (line == nullptr || !line->fitted || line->status != fit::Status::identified) return;
  const double width = 4 / duration_s;  // resolution of the averaged spectrum is coarser than a bin
  std::erase_if(lines,
                [&](const auto& l) { return std::abs(l.frequency_hz - line->shape) < width + 0.02 * line->shape; });
}

// Samples that stand out while the sensor moved are of the motion.
void drop_outliers_of(std::vector<allan::Outlier>& outliers, const std::vector<allan::Motion>& motion) {
  std::erase_if(outliers, [&](const auto& outlier) {
    return std::ranges::any_of(
        motion, [&](const auto& m) { return outlier.index >= m.first && outlier.index < m.first + m.count; });
  });
}

// What lies in a hump is of the hump, unless it stands out of it like a line.
void drop_lines_of(std::vector<allan::SpectralLine>& lines, const std::vector<allan::Hump>& humps) {
  constexpr double kLine = 50, kBeside = 1.25;  // times the spectrum beside it; of the hump's ends
  std::erase_if(lines, [&](const auto& l) {
    return l.ratio < kLine && std::ranges::any_of(humps, [&](const auto& h) {
             return l.frequency_hz > h.low_hz / kBeside && l.frequency_hz < h.high_hz * kBeside;
           });
  });
}

}  // namespace

Screened::Screened(std::span<const double> rate, double dt, double minimum_fill, const Masking& masking)
    : rate_(rate), masking_(masking), dt_(dt), fill_(minimum_fill) {
  keep(0, static_cast<std::int64_t>(rate_.size()));
}

void Screened::look() {
  look_at_values();
  look_for_outliers();
  look_for_turns_and_motion();
  look_for_steps();
}

std::span<const double> Screened::part_of(std::span<const double> whole) const {
  return whole.subspan(static_cast<std::size_t>(findings_.first), static_cast<std::size_t>(findings_.samples));
}

std::span<const double> Screened::clean() const {
  return part_of(clean_.empty() ? rate_ : std::span<const double>(clean_));
}

std::span<const double> Screened::used() const {
  return part_of(masked_.empty() ? rate_ : std::span<const double>(masked_));
}

bool Screened::holds_knocks_or_motion() const {
  return (!findings_.outliers.empty() && !findings_.outliers_masked) || findings_.not_at_rest();
}

void Screened::keep(std::int64_t first, std::int64_t count) {
  findings_.first = first;
  findings_.samples = count;
  series_.emplace(used(), dt_, fill_);
}

void Screened::keep_longest_without_step() {
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

void Screened::look_at_values() {
  findings_.rounding = allan::find_rounding(rate_);
  findings_.saturation = allan::find_saturation(rate_);
}

void Screened::look_for_outliers() {
  findings_.outliers = allan::find_outliers(rate_);
  findings_.tail = allan::find_outlier_tail(rate_, findings_.outliers);
  findings_.outliers_masked = masking_.outliers && !findings_.outliers.empty();
  if (findings_.outliers.empty()) return;
  clean_.assign(rate_.begin(), rate_.end());
  for (const auto& outlier : findings_.outliers) clean_[static_cast<std::size_t>(outlier.index)] = kMissing;
  if (!findings_.outliers_masked) return;
  masked_ = clean_;
  // Outliers, unlike gaps, can be as many as clusters may miss: these then must do with fewer samples.
  if (!(fill_ == 1)) fill_ = kFillBesideOutliers;
  keep(findings_.first, findings_.samples);
}

void Screened::look_for_turns_and_motion() {
  // A level that is rounded to steps above its noise, or an angle that is, has patterns of its own.
  constexpr double kFine = 0.5;  // of the scatter
  const auto& rounding = findings_.rounding;
  if (!rounding || rounding->step < kFine * rounding->scatter) findings_.turns = allan::find_turns(clean());
  const double quiet = findings_.rounding ? findings_.rounding->step / 2 : 0;
  findings_.motion = allan::find_motion(clean(), dt_, quiet);
  if (findings_.motion.empty()) return;
  if (clean_.empty()) clean_.assign(rate_.begin(), rate_.end());
  findings_.motion_masked = masking_.motion;
  if (masking_.motion && masked_.empty()) masked_.assign(rate_.begin(), rate_.end());
  for (const auto& m : findings_.motion) {
    std::fill_n(clean_.begin() + m.first, m.count, kMissing);
    if (masking_.motion) std::fill_n(masked_.begin() + m.first, m.count, kMissing);
  }
  drop_outliers_of(findings_.outliers, findings_.motion);
  findings_.tail.reset();  // motion was in it
  findings_.outliers_masked = findings_.outliers_masked && !findings_.outliers.empty();
  if (masking_.motion) keep(findings_.first, findings_.samples);
}

void Screened::look_for_steps() {
  // Knocks and motion move means too: they are no steps.
  findings_.steps =
      holds_knocks_or_motion() ? allan::find_steps(allan::Series(clean(), dt_, fill_)) : allan::find_steps(*series_);
  if (masking_.steps && !findings_.steps.empty()) keep_longest_without_step();
}

bool Screened::look_for_departure(std::span<const noise::Process> fitted) {
  std::optional<allan::Series> beside;
  if (holds_knocks_or_motion()) beside.emplace(clean(), dt_, fill_);
  auto departure = allan::find_departure(beside ? *beside : *series_, fitted);
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
  // Jumps that were seen in the part left out were the warm-up.
  std::erase_if(findings_.steps, [&](const auto& step) { return step.index <= findings_.first; });
  return true;
}

void Screened::look_for_lines(const fit::Result& fit) {
  findings_.lines = allan::find_lines(clean(), dt_);
  // One line is a line; several may be the noise of one hump.
  if (findings_.lines.size() > 1) findings_.humps = allan::find_humps(clean(), dt_);
  drop_lines_of(findings_.lines, findings_.humps);
  drop_modelled_line(findings_.lines, fit, static_cast<double>(findings_.samples) * dt_);
}

}  // namespace gyrobudget::inline v0::calibration::detail

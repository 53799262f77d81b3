// SPDX-License-Identifier: MIT
#include "advice.h"

#include "gyrobudget/app/report/words.h"
#include "gyrobudget/estimation/fit/information.h"
#include "gyrobudget/noise/sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace gyrobudget::inline v0::cli {
namespace {

using fit::Status;
using noise::Term;

constexpr double kWantedAccuracy = 0.10;
constexpr double kHour = 3600;

std::string hours(double seconds) {
  if (seconds < 2 * 60) return fmt::format("{:.0f} s", seconds);
  if (seconds < 2 * kHour) return fmt::format("{:.0f} min", seconds / 60);
  if (seconds < 100 * kHour) return fmt::format("{:.1f} h", seconds / kHour);
  return fmt::format("{:.0f} h", seconds / kHour);
}

// How long a record of this sensor must be for 10 % on a term, by the Cramer-Rao bound.
void advise_duration(std::vector<std::string>& advice, const fit::Result& fit, Term term, std::string_view name,
                     const allan::Curve& curve) {
  const auto& c = fit[term];
  if (!c.fitted || c.relative_std <= kWantedAccuracy) return;
  const auto processes = fit.processes();
  const auto at =
      std::find_if(processes.begin(), processes.end(), [&](const auto& p) { return noise::term(p) == term; });
  const bool random =
      std::none_of(processes.begin(), processes.end(), [](const auto& p) { return noise::term(p) == Term::rate_ramp; });
  if (at == processes.end() || !random) return;
  const double needed =
      fit::duration_for(processes, static_cast<std::size_t>(at - processes.begin()), kWantedAccuracy, curve.dt);
  const double have = static_cast<double>(curve.samples) * curve.dt;
  if (!(needed > have)) return;
  advice.push_back(fmt::format("{} is known to {:.0f} % here ({} of record); for 10 % record at least {}.", name,
                               100 * c.relative_std, hours(have),
                               std::isfinite(needed) ? hours(needed) : "longer than anyone would"));
}

void advise_unresolved(std::vector<std::string>& advice, const fit::Result& fit) {
  const auto& walk = fit[Term::rate_random_walk];
  if (walk.fitted && walk.status != Status::identified) {
    advice.push_back(
        "No rate random walk is seen within this record: it may show in a longer one. Quote the upper limit.");
  }
}

void advise_misfit(std::vector<std::string>& advice, const fit::Result& fit) {
  if (fit.verdict != fit::Verdict::not_described || !report::has_p_value(fit.method)) return;
  if (fit.dof < 1) {
    advice.push_back("The record is too short to test whether the model describes it: record longer.");
    return;
  }
  advice.push_back(
      "Do not use these coefficients: the curve has a shape that no sum of the fitted terms has. Look at the residuals; motion of the support, temperature, periodic disturbances and vibration bounded in angle all do this. Repeat the record on a still base at constant temperature, or fit other terms (--terms), or a range of taus (--tau-min, --tau-max).");
}

bool all_equal(const allan::Curve& curve) {
  return std::all_of(curve.points.begin(), curve.points.end(), [](const auto& p) { return !(p.variance > 0); });
}

}  // namespace

bool holds_no_answer(const fit::Result& fit) {
  constexpr std::array kAnswers{Term::white, Term::flicker, Term::rate_random_walk, Term::gauss_markov};
  return std::none_of(kAnswers.begin(), kAnswers.end(), [&](Term t) {
    const auto* c = report::find(fit, t);
    return c != nullptr && c->fitted && c->status == Status::identified;
  });
}

std::string one_line_verdict(const fit::Result& fit) {
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

void note_minimum(fit::Result& fit, const allan::Curve& display) {
  for (std::size_t i = 0; i < display.points.size(); ++i) {
    const auto& p = display.points[i];
    if (p.terms < 1 || !std::isfinite(p.variance) || p.m * 10 > display.samples) continue;
    const double deviation = std::sqrt(p.variance);
    if (!(fit.minimum_deviation > 0) || deviation < fit.minimum_deviation) {
      fit.minimum_deviation = deviation;
      fit.minimum_tau_s = display.tau(i);
    }
  }
}

std::vector<std::string> advise(const fit::Result& fit, const allan::Axis& axis, const allan::Curve& octaves,
                                const std::vector<std::string>& findings) {
  std::vector<std::string> advice;
  if (all_equal(octaves)) {
    advice.push_back(fmt::format(
        "Every sample of {} is equal: the log holds no noise to measure. The sensor is not connected, or its resolution hides its noise: log raw counts or at a finer range.",
        axis.name));
    return advice;
  }
  if (holds_no_answer(fit)) {
    advice.push_back(fmt::format("None of angle random walk, bias instability and rate random walk is resolved{}",
                                 fit[Term::quantization].status == Status::identified
                                     ? ": what is seen is quantization. Record at a finer resolution, or longer."
                                     : "."));
  }
  advise_misfit(advice, fit);
  for (const auto& finding : findings) advice.push_back(finding);
  if (fit.verdict != fit::Verdict::not_described) {
    advise_unresolved(advice, fit);
    advise_duration(advice, fit, Term::flicker, "Bias instability", octaves);
    advise_duration(advice, fit, Term::rate_random_walk, "Rate random walk", octaves);
  }
  return advice;
}

}  // namespace gyrobudget::inline v0::cli

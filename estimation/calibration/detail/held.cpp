// SPDX-License-Identifier: MIT
#include "held.h"

#include "gyrobudget/estimation/fit/judgement.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace gyrobudget::inline v0::calibration::detail {
namespace {

using Sensor = std::shared_ptr<const HeldSensor>;
using Axes = std::vector<std::span<const double>>;

Sensor held_sensor(const Axes& axes) {
  const auto repeats = allan::find_repeats(axes);
  if (!repeats) return nullptr;
  auto sensor = std::make_shared<const HeldSensor>(HeldSensor{*repeats, allan::readings_of(axes)});
  // Where most of the rows are of readings that stand far longer than the others, nothing says how often there is one.
  constexpr double kLeastOfRows = 0.5;
  const auto readings = std::ranges::count_if(sensor->readings.rows, [](std::int64_t row) { return row >= 0; });
  const double rows = static_cast<double>(readings) * sensor->readings.rows_each;
  return readings < kFewestSamples || rows < kLeastOfRows * static_cast<double>(repeats->compared) ? nullptr : sensor;
}

void raise(fit::Result& fit, double ratio, double added) {
  for (auto& c : fit.coefficients) {
    if (c.term != noise::Term::white) continue;
    for (double* v : {&c.value, &c.lower, &c.upper, &c.upper_two_sided}) *v *= ratio;
  }
  const auto at = std::ranges::find(fit.fitted_terms, noise::Term::white) - fit.fitted_terms.begin();
  if (at < fit.covariance.rows()) {
    fit.covariance.row(at) *= ratio;
    fit.covariance.col(at) *= ratio;
  }
  for (auto& r : fit.residuals) {
    const double measured = std::sqrt(r.measured * r.measured + added / r.tau_s);
    const double model = std::sqrt(r.model * r.model + added / r.tau_s);
    r.relative_std *= r.model * r.model / (model * model);
    r.measured = measured;
    r.model = model;
    r.misfit = measured / model - 1;
  }
  for (auto& move : fit.moved) {
    if (move.term == noise::Term::white) move.from = std::hypot(move.from, std::sqrt(added)), move.to *= ratio;
  }
  if (fit.minimum_deviation > 0)
    fit.minimum_deviation = std::hypot(fit.minimum_deviation, std::sqrt(added / fit.minimum_tau_s));
  fit.beta /= ratio;
}

}  // namespace

std::vector<Sensor> held_sensors(const allan::Record& record) {
  std::vector<Sensor> sensors(record.axes.size());
  for (const auto signal : {noise::Signal::angular_rate, noise::Signal::specific_force}) {
    Axes axes;
    for (const auto& axis : record.axes)
      if (axis.signal == signal) axes.emplace_back(axis.rate);
    if (axes.empty()) continue;
    const Sensor together = held_sensor(axes);
    for (std::size_t i = 0; i < sensors.size(); ++i)
      if (record.axes[i].signal == signal) sensors[i] = together;
  }
  for (std::size_t i = 0; i < sensors.size(); ++i)
    if (!sensors[i]) sensors[i] = held_sensor({record.axes[i].rate});
  return sensors;
}

double raise_white_noise(AxisDatasheet& sheet, std::span<const double> readings, const HeldSensor& sensor, double dt) {
  const fit::Coefficient* white = fit::find(sheet.fit, noise::Term::white);
  const double added = dt * allan::added_by_uneven_holds(readings, sensor.readings.holds);
  if (white == nullptr || !white->fitted || !(white->value > 0) || !(added > 0)) return 1;
  const double ratio = std::hypot(white->value, std::sqrt(added)) / white->value;
  raise(sheet.fit, ratio, added);
  if (sheet.cross_checked) {
    raise(sheet.cross_checked->likelihood, ratio, added);
    for (auto& a : sheet.cross_checked->check.coefficients)
      if (a.term == noise::Term::white) a.first *= ratio, a.second *= ratio;
  }
  if (sheet.chosen && sheet.chosen->alternative_fit) raise(*sheet.chosen->alternative_fit, ratio, added);
  for (auto& p : sheet.octaves.points) p.variance += added / (static_cast<double>(p.m) * dt);
  for (auto& p : sheet.points) {
    const double by = std::sqrt(1 + added / p.tau_s / (p.deviation * p.deviation));
    p.deviation *= by, p.lower *= by, p.upper *= by;
  }
  return ratio;
}

}  // namespace gyrobudget::inline v0::calibration::detail

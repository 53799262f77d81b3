// SPDX-License-Identifier: MIT
#include "sensor_model.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::calibration {
namespace {

using noise::Term;

double to_digits(double value, int digits = 6) { return std::stod(fmt::format("{:.{}g}", value, digits)); }

double rounded(double si, noise::Signal signal, Term term) {
  const auto unit = noise::datasheet_unit(signal, term);
  return to_digits(noise::from_si(si, unit)) * noise::parse_unit(unit).to_si;
}

void add(noise::ErrorModel& model, const fit::Coefficient& c) {
  if (!(c.value > 0)) return;
  if (c.term == Term::gauss_markov) {
    model.gauss_markov.push_back({c.value, c.shape});
  } else if (c.term != Term::sinusoid) {
    model[c.term] = std::hypot(model[c.term], c.value);
  } else {
    constexpr double kSame = 1e-3;
    for (auto& line : model.sinusoids) {
      if (std::abs(line.frequency - c.shape) > kSame * c.shape) continue;
      line.amplitude = std::hypot(line.amplitude, c.value);
      return;
    }
    model.sinusoids.push_back({c.value, c.shape});
  }
}

// From sums of squares over `count` axes to their mean.
void scale_down(noise::ErrorModel& model, int count, noise::Signal signal) {
  for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp})
    model[t] = rounded(model[t] / std::sqrt(count), signal, t);
  for (auto& g : model.gauss_markov) {
    g.sigma = rounded(g.sigma / std::sqrt(count), signal, Term::gauss_markov);
    g.correlation_time = to_digits(g.correlation_time);
  }
  for (auto& line : model.sinusoids) {
    line.amplitude = rounded(line.amplitude / std::sqrt(count), signal, Term::sinusoid);
    line.frequency = to_digits(line.frequency, 9);
  }
}

// Of the axes whose temperature was taken off: each its own, where there are three in all; else that of the one.
std::optional<noise::TemperatureModel> temperature_model(const Datasheet& sheet, noise::Signal signal) {
  constexpr std::size_t kAxes = 3;
  std::vector<const Temperature*> axes;
  bool any = false;
  for (const AxisDatasheet& axis : sheet.axes) {
    if (axis.signal != signal) continue;
    const bool removed = axis.temperature && axis.temperature->removed;
    axes.push_back(removed ? &*axis.temperature : nullptr);
    any = any || removed;
  }
  if (!any || (axes.size() != 1 && axes.size() != kAxes)) return std::nullopt;
  axes.resize(kAxes, axes.front());  // one axis stands for all
  noise::TemperatureModel model;
  for (const Temperature* t : axes)
    if (t != nullptr) model.reference = to_digits(t->reference);
  const auto each = [&](TemperatureCoefficient Temperature::*member, const char* over) {
    const double unit = noise::parse_unit(std::string(noise::datasheet_unit(signal)) + over).to_si;
    const auto of = [&](std::size_t i) {
      return axes[i] != nullptr ? to_digits((axes[i]->*member).value / unit) * unit : 0;
    };
    return noise::PerAxis(of(0), of(1), of(2));
  };
  model.linear = each(&Temperature::linear, "/K");
  model.quadratic = each(&Temperature::quadratic, "/K^2");
  model.rate = each(&Temperature::rate, "/(K/min)");
  return model;
}

std::optional<noise::ErrorModel> triad(const Datasheet& sheet, noise::Signal signal) {
  noise::ErrorModel model;
  int count = 0;
  for (const AxisDatasheet& axis : sheet.axes) {
    if (axis.signal != signal || !axis.has_answer()) continue;
    ++count;
    for (const auto& c : axis.fit.coefficients)
      if (c.fitted && c.status != fit::Status::not_quotable) add(model, c);
  }
  if (count == 0) return std::nullopt;
  scale_down(model, count, signal);
  model.temperature = temperature_model(sheet, signal);
  return model;
}

std::optional<noise::ErrorModel> triad(const TypeDatasheet& sheet, noise::Signal signal) {
  noise::ErrorModel model;
  int count = 0;
  for (const CombinedAxis& axis : sheet.axes) {
    if (axis.signal != signal || axis.coefficients.empty()) continue;
    ++count;
    for (const auto& c : axis.coefficients) model[c.term] = std::hypot(model[c.term], c.value);
  }
  if (count == 0) return std::nullopt;
  scale_down(model, count, signal);
  return model;
}

template <class Sheet>
noise::SensorModel model_of(const Sheet& sheet, std::string name) {
  noise::SensorModel sensor;
  sensor.name = std::move(name);
  if (const auto gyro = triad(sheet, noise::Signal::angular_rate)) sensor.gyro = *gyro;
  sensor.accelerometer = triad(sheet, noise::Signal::specific_force);
  return sensor;
}

}  // namespace

noise::SensorModel sensor_model(const Datasheet& sheet, std::string name) { return model_of(sheet, std::move(name)); }

noise::SensorModel sensor_model(const TypeDatasheet& sheet, std::string name) {
  return model_of(sheet, std::move(name));
}

}  // namespace gyrobudget::inline v0::calibration

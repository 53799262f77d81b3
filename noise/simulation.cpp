// SPDX-License-Identifier: MIT
#include "simulation.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "imu_sensor.h"
#include "jerath.h"

namespace gyrobudget::inline v0::noise {
namespace {

using Kind = SimulationModel::Kind;

/// What models 1 to 3 know of an axis.
struct Coefficients {
  double n, b, k;
};

Model jerath(const SimulationModel& m, const Coefficients& given, double dt) {
  Jerath model{.arw = given.n, .bias_instability = given.b, .rrw = given.k};
  if (m.taps) model.taps = *m.taps;
  return model.model(dt);
}

Model imu_sensor(const SimulationModel& m, const Coefficients& given, double dt) {
  using NoiseType = ImuSensor::NoiseType;
  ImuSensor model{.noise_density = {given.n, 0, 0},
                  .bias_instability = {given.b, 0, 0},
                  .random_walk = {given.k, 0, 0},
                  .noise_type = m.single_sided ? NoiseType::single_sided : NoiseType::double_sided};
  if (m.taps) model.bias_instability_coefficients = fractal_coefficients(*m.taps);
  return model.model(0, dt);
}

Model bielas(const SimulationModel& m, const Coefficients& given, double dt) {
  const bool walks = m.rate_random_walk.value_or(m.variant != Bielas::Bias::integrated_legacy);
  return Bielas{.arw = given.n,
                .bias_instability = given.b,
                .rrw = walks ? given.k : 0,
                .bias = m.variant,
                .correlation_time = m.correlation_time_s}
      .model(dt);
}

// Of a triad, the axes asked for.
void add(std::vector<SimulatedAxis>& list, Signal signal, const ErrorModel& errors, const SimulationOptions& o) {
  const std::uint64_t first = signal == Signal::angular_rate ? 0 : 3;
  for (const int axis : o.axes) {
    const auto which = static_cast<std::size_t>(axis);
    list.push_back(
        {signal, axis, model_of(o.model, errors, which, 1 / o.rate_hz), errors.temperature, {o.seed, first + which}});
  }
}

void check(const SimulationOptions& o) {
  for (const int axis : o.axes) {
    if (axis < 0 || axis > 2) throw std::invalid_argument(fmt::format("axis {}: x, y and z are 0, 1 and 2", axis));
  }
  if (!(o.rate_hz > 0 && std::isfinite(o.rate_hz)))
    throw std::invalid_argument(fmt::format("a rate of {} Hz; it must be above 0", o.rate_hz));
  if (!(o.duration_s >= 0))
    throw std::invalid_argument(fmt::format("a duration of {} s; it must not be negative", o.duration_s));
}

}  // namespace

Model model_of(const SimulationModel& model, const ErrorModel& errors, std::size_t axis, double dt) {
  const Coefficients given{errors.white[axis], errors.bias_instability[axis], errors.rate_random_walk[axis]};
  switch (model.kind) {
    case Kind::jerath:
      return jerath(model, given, dt);
    case Kind::imu_sensor:
      return imu_sensor(model, given, dt);
    case Kind::bielas:
      return bielas(model, given, dt);
    case Kind::spectral:
    case Kind::gauss_markov:
      break;
  }
  return {errors.processes(axis), {}};
}

std::vector<Term> left_out(const SimulationModel& model, const ErrorModel& errors) {
  if (model.kind == Kind::spectral || model.kind == Kind::gauss_markov) return {};
  std::vector<Term> list;
  for (const TriadProcess& triad : errors.triad_processes()) {
    const Term t = term(triad.process);
    if (t != Term::white && t != Term::flicker && t != Term::rate_random_walk) list.push_back(t);
  }
  return list;
}

Simulation::Simulation(const SensorModel& sensor, SimulationOptions options) : options_(std::move(options)) {
  check(options_);
  add(axes_, Signal::angular_rate, sensor.gyro, options_);
  if (sensor.accelerometer) add(axes_, Signal::specific_force, *sensor.accelerometer, options_);
}

std::uint64_t Simulation::samples() const {
  if (std::isinf(options_.duration_s)) return kEndless;
  return static_cast<std::uint64_t>(std::llround(options_.duration_s * options_.rate_hz));
}

double Simulation::bytes_of_records() const {
  constexpr double kTransform = 11;  // numbers a sample while 1/f noise is made, see RecordGenerator
  const bool flicker = std::ranges::any_of(axes_, [](const SimulatedAxis& a) {
    return std::ranges::any_of(a.model.processes, [](const Process& p) { return term(p) == Term::flicker; });
  });
  const double numbers = static_cast<double>(axes_.size()) + (flicker ? kTransform : 0);
  return numbers * sizeof(double) * static_cast<double>(samples());
}

std::vector<double> Simulation::record(std::size_t index) const {
  if (streams())
    throw std::invalid_argument("only the spectral model makes whole records; the others have a generator");
  const SimulatedAxis& axis = axes_.at(index);
  auto made =
      generate_record(axis.model.processes, static_cast<std::int64_t>(samples()), 1 / options_.rate_hz, axis.key);
  add_temperature(index, 0, made);
  return made;
}

void Simulation::add_temperature(std::size_t index, std::uint64_t first, std::span<double> samples) const {
  const SimulatedAxis& axis = axes_.at(index);
  if (!axis.temperature || !options_.temperature) return;
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const double t = (static_cast<double>(first + k) + 0.5) / options_.rate_hz;
    samples[k] += axis.temperature->bias(static_cast<std::size_t>(axis.axis), options_.temperature->at(t),
                                         options_.temperature->slope(t));
  }
}

void Simulation::temperatures(std::uint64_t first, std::span<double> values) const {
  const double reference = axes_.empty() || !axes_.front().temperature ? 0 : axes_.front().temperature->reference;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double t = (static_cast<double>(first + k) + 0.5) / options_.rate_hz;
    values[k] = options_.temperature ? options_.temperature->at(t) : reference;
  }
}

Generator Simulation::generator(std::size_t index) const {
  const SimulatedAxis& axis = axes_.at(index);
  const double dt = 1 / options_.rate_hz;
  Generator::Options options{.key = axis.key};
  if (std::isfinite(options_.duration_s)) options.longest_tau = std::max(options_.duration_s, 10 * dt);
  return {axis.model.processes, axis.model.filters, dt, options};
}

}  // namespace gyrobudget::inline v0::noise

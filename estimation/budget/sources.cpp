// SPDX-License-Identifier: MIT
#include "sources.h"

#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/gravity.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace gyrobudget::inline v0::budget {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using noise::Signal;
using noise::Term;

// The model with one of its errors.
template <typename Member>
noise::ErrorModel alone(const noise::ErrorModel& all, Member member) {
  noise::ErrorModel one;
  one.*member = all.*member;
  one.powered_on_before = all.powered_on_before;
  one.calibrated_over = all.calibrated_over;
  return one;
}

struct SingleError {
  std::string name;
  noise::ErrorSource source;
  noise::ErrorModel model;
};

// Every error of a triad that has states, by the name it has in files.
std::vector<SingleError> single_errors(const noise::ErrorModel& all, Signal signal) {
  using enum noise::ErrorSource;
  std::vector<SingleError> list;
  const auto add = [&](std::string name, noise::ErrorSource source, bool has, noise::ErrorModel model) {
    if (has) list.push_back({std::move(name), source, std::move(model)});
  };
  const auto add_term = [&](Term term, noise::ErrorSource source, noise::PerAxis noise::ErrorModel::*member) {
    add(std::string(key(signal, term)), source, all.*member != 0, alone(all, member));
  };
  const auto add_constant = [&](std::string name, noise::ErrorSource source,
                                std::optional<noise::PerAxis> noise::ErrorModel::*member) {
    add(std::move(name), source, (all.*member).value_or(noise::PerAxis(0)) != noise::PerAxis(0), alone(all, member));
  };
  add_term(Term::white, white, &noise::ErrorModel::white);
  add_term(Term::flicker, flicker, &noise::ErrorModel::bias_instability);
  add_term(Term::rate_random_walk, rate_random_walk, &noise::ErrorModel::rate_random_walk);
  add("gauss_markov", gauss_markov, !all.gauss_markov.empty(), alone(all, &noise::ErrorModel::gauss_markov));
  add_constant("turn_on_bias", turn_on_bias, &noise::ErrorModel::turn_on_bias);
  add_constant("scale_factor", scale_factor, &noise::ErrorModel::scale_factor);
  add_constant("misalignment", misalignment, &noise::ErrorModel::misalignment);
  if (signal == Signal::angular_rate) add_constant("g_sensitivity", g_sensitivity, &noise::ErrorModel::g_sensitivity);
  add_constant("g2_sensitivity", g2_sensitivity, &noise::ErrorModel::g2_sensitivity);
  add_constant("vibration_rectification", vibration_rectification, &noise::ErrorModel::vibration_rectification);
  return list;
}

Source initial_source(std::string name, int row, const Vector3d& sigma, const Matrix3d& C_el) {
  Source source;
  source.name = std::move(name);
  source.core.block<3, 3>(row, row) = C_el * sigma.cwiseAbs2().asDiagonal() * C_el.transpose();
  return source;
}

// Independent error vectors of unit size that are fixed in axes other than the body's: each is three body components
// that are fully correlated.
Source vectors(std::string name, navigation::Carrier carrier, int count,
               std::function<Vector3d(const navigation::StepInput&, int vector)> error_b) {
  Source source;
  source.name = std::move(name);
  source.initial = navigation::StateMatrix::Zero(3 * count, 3 * count);
  for (int vector = 0; vector < count; ++vector) {
    source.initial.block<3, 3>(3 * vector, 3 * vector).setOnes();
    for (int axis = 0; axis < 3; ++axis)
      source.model.terms.push_back({.carrier = carrier, .effect = navigation::Effect::bias, .axis = axis});
  }
  source.shape = [error = std::move(error_b)](const navigation::StepInput& input, std::size_t term) {
    return error(input, static_cast<int>(term / 3))[static_cast<Eigen::Index>(term % 3)];
  };
  return source;
}

Source bias_over_temperature(std::string_view triad, navigation::Carrier carrier, const noise::TemperatureModel& model,
                             const noise::TemperatureProfile& profile) {
  Source source =
      vectors(fmt::format("{}.temperature", triad), carrier, 1,
              [model, profile](const navigation::StepInput& input, int) -> Vector3d {
                const double degrees = profile.at(input.t), slope = profile.slope(input.t);
                return {model.bias(0, degrees, slope), model.bias(1, degrees, slope), model.bias(2, degrees, slope)};
              });
  source.sensor = {carrier, noise::ErrorSource::temperature};
  return source;
}

Vector3d up(const navigation::StepInput& input) {
  const auto at = earth::to_geodetic(input.p_eb_e);
  return earth::up_e(at.latitude, at.longitude);
}

void require_size(double sigma, std::string_view what) {
  if (!(sigma >= 0) || !std::isfinite(sigma))
    throw navigation::SetupError(fmt::format("{} is {}, expected 0 or more and finite", what, sigma));
}

}  // namespace

SensorSources sensor_sources(const noise::SensorModel& sensor, const navigation::SensorStates::Options& options) {
  navigation::SensorStates::Options all = options;
  all.scale_factor = all.misalignment = all.g_sensitivity = navigation::Use::estimated;
  SensorSources result;
  const auto add = [&](const noise::ErrorModel& errors, Signal signal, std::string_view triad) {
    const navigation::Carrier carrier =
        signal == Signal::angular_rate ? navigation::Carrier::gyro : navigation::Carrier::accelerometer;
    for (auto& [name, error, model] : single_errors(errors, signal)) {
      noise::SensorModel one;
      Source& source = result.sources.emplace_back();
      source.name = fmt::format("{}.{}", triad, name);
      source.sensor = {carrier, error};
      if (const auto processes = model.triad_processes(); !processes.empty())
        source.slow = {carrier, processes,
                       (signal == Signal::angular_rate ? options.gyro : options.accelerometer)
                           .value_or(navigation::epoch_of(model))};
      (signal == Signal::angular_rate ? one.gyro : one.accelerometer.emplace()) = std::move(model);
      navigation::SensorStates states = navigation::sensor_states(one, all);
      source.model = std::move(states.model);
      source.initial = states.initial;
    }
    if (errors.temperature && options.temperature)
      result.sources.push_back(bias_over_temperature(triad, carrier, *errors.temperature, *options.temperature));
  };
  add(sensor.gyro, Signal::angular_rate, "gyro");
  if (sensor.accelerometer) add(*sensor.accelerometer, Signal::specific_force, "accelerometer");
  result.left_out = navigation::sensor_states(sensor, all).left_out;
  return result;
}

std::vector<Source> initial_sources(const InitialErrors& errors, const Matrix3d& C_el) {
  std::vector<Source> sources{
      initial_source("initial.position", navigation::kPosition, errors.position, C_el),
      initial_source("initial.velocity", navigation::kVelocity, errors.velocity, C_el),
      initial_source("initial.level", navigation::kAttitude, {errors.level, errors.level, 0}, C_el),
      initial_source("initial.heading", navigation::kAttitude, {0, 0, errors.heading}, C_el)};
  std::erase_if(sources, [](const Source& source) { return source.core.isZero(0); });
  return sources;
}

InitialErrors only(const InitialErrors& errors, std::string_view source) {
  InitialErrors one;
  if (source == "initial.position") one.position = errors.position;
  if (source == "initial.velocity") one.velocity = errors.velocity;
  if (source == "initial.level") one.level = errors.level;
  if (source == "initial.heading") one.heading = errors.heading;
  return one;
}

navigation::CoreMatrix initial_core(const InitialErrors& errors, const Matrix3d& C_el) {
  navigation::CoreMatrix core = navigation::CoreMatrix::Zero();
  for (const Source& source : initial_sources(errors, C_el)) core += source.core;
  return core;
}

Source uncompensated_earth_rate() {
  Source source = vectors(std::string(kUncompensatedEarthRate), navigation::Carrier::gyro, 1,
                          [](const navigation::StepInput& input, int) -> Vector3d {
                            return input.C_eb.transpose() * Vector3d(0, 0, earth::wgs84::kEarthRate);
                          });
  source.sensed = false;
  return source;
}

Source gravity_error(double sigma) {
  require_size(sigma, "error of gravity [m/s^2]");
  return vectors("gravity_model", navigation::Carrier::accelerometer, 1,
                 [sigma](const navigation::StepInput& input, int) -> Vector3d {
                   return sigma * (input.C_eb.transpose() * up(input));
                 });
}

Source deflection_of_the_vertical(double sigma) {
  require_size(sigma, "deflection of the vertical [rad]");
  return vectors("deflection", navigation::Carrier::accelerometer, 2,
                 [sigma](const navigation::StepInput& input, int direction) -> Vector3d {
                   const Vector3d z = up(input);
                   // Any horizontal direction and the one across it: equal sigmas make a circle.
                   const Vector3d level =
                       (std::abs(z.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX()).cross(z).normalized();
                   const double g = earth::normal_gravity(input.p_eb_e).norm();
                   return sigma * g * (input.C_eb.transpose() * (direction == 0 ? level : Vector3d(z.cross(level))));
                 });
}

}  // namespace gyrobudget::inline v0::budget

// SPDX-License-Identifier: MIT
#include "sensor.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <span>
#include <stdexcept>

namespace gyrobudget::inline v0::noise {
namespace {

/// What a term is called, and the unit it is quoted in, for one kind of signal.
struct Entry {
  Term term;
  std::string_view key, label, unit;
};

constexpr Entry kGyro[] = {
    {Term::quantization, "quantization", "quantization", "arcsec"},
    {Term::white, "arw", "angle random walk", "deg/sqrt(h)"},
    {Term::flicker, "bias_instability", "bias instability", "deg/h"},
    {Term::rate_random_walk, "rrw", "rate random walk", "deg/h/sqrt(h)"},
    {Term::rate_ramp, "rate_ramp", "rate ramp", "deg/h/h"},
    {Term::gauss_markov, "gauss_markov", "Gauss-Markov noise", "deg/h"},
    {Term::sinusoid, "sinusoid", "sinusoid", "deg/h"},
};
constexpr Entry kAccelerometer[] = {
    {Term::quantization, "quantization", "quantization", "m/s"},
    {Term::white, "vrw", "velocity random walk", "m/s/sqrt(h)"},
    {Term::flicker, "bias_instability", "bias instability", "ug"},
    {Term::rate_random_walk, "accel_rw", "acceleration random walk", "ug/sqrt(h)"},
    {Term::rate_ramp, "rate_ramp", "acceleration ramp", "ug/h"},
    {Term::gauss_markov, "gauss_markov", "Gauss-Markov noise", "ug"},
    {Term::sinusoid, "sinusoid", "sinusoid", "ug"},
};
constexpr Entry kNumber[] = {
    {Term::quantization, "quantization", "quantization", "s"},
    {Term::white, "arw", "white noise", "1/sqrt(Hz)"},
    {Term::flicker, "bias_instability", "flicker noise", "1"},
    {Term::rate_random_walk, "rrw", "random walk", "1/sqrt(s)"},
    {Term::rate_ramp, "rate_ramp", "drift", "1/s"},
    {Term::gauss_markov, "gauss_markov", "Gauss-Markov noise", "1"},
    {Term::sinusoid, "sinusoid", "sinusoid", "1"},
};

/// In the order of the list of processes.
constexpr std::array kCoefficients{Term::quantization, Term::white, Term::flicker, Term::rate_random_walk,
                                   Term::rate_ramp};

const Entry& entry(Signal signal, Term term) {
  const std::span<const Entry> table = signal == Signal::angular_rate     ? std::span<const Entry>(kGyro)
                                       : signal == Signal::specific_force ? std::span<const Entry>(kAccelerometer)
                                                                          : std::span<const Entry>(kNumber);
  for (const Entry& e : table) {
    if (e.term == term) return e;
  }
  throw std::invalid_argument(fmt::format("'{}' is no noise term; there are Q N B K R G S", static_cast<char>(term)));
}

template <typename Model>
auto& member(Model& model, Term term) {
  switch (term) {
    case Term::quantization:
      return model.quantization;
    case Term::white:
      return model.white;
    case Term::flicker:
      return model.bias_instability;
    case Term::rate_random_walk:
      return model.rate_random_walk;
    case Term::rate_ramp:
      return model.rate_ramp;
    default:
      break;
  }
  throw std::invalid_argument(
      fmt::format("term '{}' is a list in an error model, not one coefficient", static_cast<char>(term)));
}

}  // namespace

std::string_view datasheet_unit(Signal signal, Term term) { return entry(signal, term).unit; }
std::string_view datasheet_unit(Signal signal) { return entry(signal, Term::flicker).unit; }
Dimension dimension_of(Signal signal) { return dimension_of(signal, Term::flicker); }
Dimension dimension_of(Signal signal, Term term) { return parse_unit(datasheet_unit(signal, term)).dimension; }
std::string_view key(Signal signal, Term term) { return entry(signal, term).key; }
std::string_view label(Signal signal, Term term) { return entry(signal, term).label; }

std::vector<Process> ErrorModel::processes(std::size_t axis) const {
  std::vector<Process> result;
  for (const Term t : kCoefficients) {
    const double size = (*this)[t][axis];
    if (size == 0) continue;
    const bool is_filtered = t == Term::white && filter;
    result.push_back(is_filtered ? FilteredWhite{size, *filter} : with_coefficient(unit_process(t), size));
  }
  for (const TriadGaussMarkov& g : gauss_markov) {
    if (g.sigma[axis] != 0) result.emplace_back(g.on(axis));
  }
  for (const TriadSinusoid& s : sinusoids) {
    if (s.amplitude[axis] != 0) result.emplace_back(s.on(axis));
  }
  return result;
}

std::vector<TriadProcess> ErrorModel::triad_processes() const {
  std::vector<TriadProcess> result;
  const auto add = [&](const PerAxis& size, const Process& unit) {
    const double largest = size.largest();
    if (largest == 0) return;
    TriadProcess& added = result.emplace_back(TriadProcess{with_coefficient(unit, largest), {}});
    for (std::size_t axis = 0; axis < 3; ++axis) added.relative[axis] = size[axis] / largest;
  };
  for (const Term t : kCoefficients) add((*this)[t], unit_process(t));
  for (const TriadGaussMarkov& g : gauss_markov) add(g.sigma, g.on(0));
  for (const TriadSinusoid& s : sinusoids) add(s.amplitude, s.on(0));
  return result;
}

bool ErrorModel::axes_are_alike() const {
  return std::ranges::all_of(kCoefficients, [&](Term t) { return (*this)[t].is_uniform(); }) &&
         std::ranges::all_of(gauss_markov, [](const auto& g) { return g.sigma.is_uniform(); }) &&
         std::ranges::all_of(sinusoids, [](const auto& s) { return s.amplitude.is_uniform(); });
}

PerAxis& ErrorModel::operator[](Term t) { return member(*this, t); }
const PerAxis& ErrorModel::operator[](Term t) const { return member(*this, t); }

}  // namespace gyrobudget::inline v0::noise

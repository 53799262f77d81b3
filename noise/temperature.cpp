// SPDX-License-Identifier: MIT
#include "temperature.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::noise {

TemperatureProfile::TemperatureProfile(double from, double to, double time_constant_s)
    : from_(from), to_(to), time_constant_s_(time_constant_s) {
  if (!(time_constant_s > 0))
    throw std::invalid_argument(
        fmt::format("the time constant of a temperature is {} s, expected it above 0", time_constant_s));
}

TemperatureProfile::TemperatureProfile(std::vector<double> time_s, std::vector<double> temperature)
    : time_s_(std::move(time_s)), temperature_(std::move(temperature)) {
  if (time_s_.size() < 2 || time_s_.size() != temperature_.size())
    throw std::invalid_argument(fmt::format("a temperature has {} times and {} values, expected two or more of each",
                                            time_s_.size(), temperature_.size()));
  const auto back = std::adjacent_find(time_s_.begin(), time_s_.end(), [](double a, double b) { return !(b > a); });
  if (back != time_s_.end())
    throw std::invalid_argument(fmt::format("the times of a temperature do not ascend at {} s", *back));
}

std::size_t TemperatureProfile::line_at(double t) const {
  const auto above = std::upper_bound(time_s_.begin() + 1, time_s_.end() - 1, t);
  return static_cast<std::size_t>(above - time_s_.begin()) - 1;
}

double TemperatureProfile::at(double t) const {
  if (time_s_.empty()) return time_constant_s_ > 0 ? to_ + (from_ - to_) * std::exp(-t / time_constant_s_) : from_;
  const std::size_t i = line_at(t);
  const double part = std::clamp((t - time_s_[i]) / (time_s_[i + 1] - time_s_[i]), 0.0, 1.0);
  return std::lerp(temperature_[i], temperature_[i + 1], part);
}

double TemperatureProfile::slope(double t) const {
  if (time_s_.empty())
    return time_constant_s_ > 0 ? (to_ - from_) / time_constant_s_ * std::exp(-t / time_constant_s_) : 0;
  if (t < time_s_.front() || t >= time_s_.back()) return 0;
  const std::size_t i = line_at(t);
  return (temperature_[i + 1] - temperature_[i]) / (time_s_[i + 1] - time_s_[i]);
}

}  // namespace gyrobudget::inline v0::noise

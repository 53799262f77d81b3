// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/noise/units.h"

#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::report {

/// Converts between SI and a datasheet unit.
class Scale {
 public:
  explicit Scale(std::string_view unit) : unit_(unit), to_si_(noise::parse_unit(unit).to_si) {}
  explicit Scale(noise::Signal signal) : Scale(noise::datasheet_unit(signal)) {}
  Scale(noise::Signal signal, noise::Term term) : Scale(noise::datasheet_unit(signal, term)) {}
  [[nodiscard]] double operator()(double si) const { return si / to_si_; }
  [[nodiscard]] const std::string& unit() const { return unit_; }
  [[nodiscard]] double to_si() const { return to_si_; }
  /// Values one by one.
  [[nodiscard]] std::vector<double> operator()(const std::vector<double>& si) const {
    std::vector<double> result;
    result.reserve(si.size());
    for (const double v : si) result.push_back((*this)(v));
    return result;
  }

 private:
  std::string unit_;
  double to_si_;
};

}  // namespace gyrobudget::inline v0::report

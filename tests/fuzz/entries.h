// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::fuzz {

/// A reader of what strangers write. It takes any bytes: what the reader documents to throw is caught, anything else
/// leaves, and a result that breaks a promise of the reader throws std::logic_error.
struct Entry {
  std::string name;
  std::function<void(std::string_view bytes)> run;
  std::vector<std::string> seeds;  ///< inputs near which faults are likely
};

/// Logs (text, binary, in segments or resampled), recordings of ROS, sensor files, scenes, vehicles, tables of
/// deviations, units.
[[nodiscard]] const std::vector<Entry>& entries();

}  // namespace gyrobudget::fuzz

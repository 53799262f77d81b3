// SPDX-License-Identifier: MIT
// Logs as text for tests, with numbers that are known: sensor rows behind any clock.
#pragma once

#include "gyrobudget/app/log/log.h"

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <string_view>

#include "../temporary.h"

namespace gyrobudget::app_tests {

/// A test with a folder, which reads texts as logs.
class TextLog : public TemporaryFolder {
 protected:
  [[nodiscard]] allan::Record read(std::string_view text, log::LogOptions options = {}) const {
    options.path = file("log.csv", text);
    return log::read_log(options);
  }
  [[nodiscard]] std::string refusal(std::string_view text, const log::LogOptions& options = {}) const {
    return message_of<text::InputError>([&] { (void)read(text, options); });
  }
};

/// One line each.
inline std::string notes_of(const allan::Record& record) {
  std::string all;
  for (const std::string& note : record.notes) all += note + '\n';
  return all;
}

/// What column `axis` of the sensor holds in row `i`: no two neighbours are equal, and it never rises like a clock.
inline double reading(int i, int axis) { return ((i * 7 + axis * 3) % 11 - 5) * 0.25; }

inline std::string number_text(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.10g", value);
  return text;
}

/// Rows of `axes` readings, parted by `delimiter`, each behind (or before) what `clock` says of it.
struct SensorRows {
  int rows = 40;
  int axes = 3;
  std::string delimiter = ",";
  std::function<std::string(int row)> clock = {};
  bool clock_last = false;
  std::function<bool(int row)> is_lost = {};

  [[nodiscard]] std::string text() const {
    std::string all;
    for (int i = 0; i < rows; ++i) {
      if (is_lost && is_lost(i)) continue;
      std::string row = clock && !clock_last ? clock(i) : "";
      for (int axis = 0; axis < axes; ++axis) row += (row.empty() ? "" : delimiter) + number_text(reading(i, axis));
      if (clock && clock_last) row += delimiter + clock(i);
      all += row + "\n";
    }
    return all;
  }
};

}  // namespace gyrobudget::app_tests

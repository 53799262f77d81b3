// SPDX-License-Identifier: MIT
// From the log of a gyro at rest to its datasheet: example_calibrate imu.csv
#include <gyrobudget/app/log/log.h>
#include <gyrobudget/estimation/calibration/calibrate.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  using namespace gyrobudget;
  if (argc != 2) return std::fputs("usage: example_calibrate imu.csv\n", stderr), 2;
  const auto sheet = calibration::calibrate(log::read_log({.path = argv[1]}));
  for (const auto& axis : sheet.axes) {
    std::printf("%s%s\n", axis.name.c_str(), axis.has_answer() ? "" : ": no answer in this record");
    for (const auto& c : axis.fit.coefficients) {
      const auto text = [&](double si) {
        return noise::quantity_text(si, noise::datasheet_unit(axis.signal, c.term), 4);
      };
      if (c.fitted)
        std::printf("%c  %s  [%s, %s]\n", char(c.term), text(c.value).c_str(), text(c.lower).c_str(),
                    text(c.upper).c_str());
    }
  }
} catch (const std::exception& error) {  // says where, what was found, what was expected, and how to mend it
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}

// SPDX-License-Identifier: MIT
#include <gyrobudget/estimation/calibration/calibrate.h>
#include <gyrobudget/noise/generate.h>

#include <array>
#include <cmath>
#include <cstdio>

int main() {
  using namespace gyrobudget;
  const std::array<noise::Process, 1> white{noise::White{1e-4}};
  auto rate = noise::generate_record(white, 10000, 0.01, {.seed = 1, .stream = 0});
  const auto record = allan::make_record({{"x", noise::Signal::angular_rate, std::move(rate)}}, 100);
  const auto sheet = calibration::calibrate(record);
  const bool sane = sheet.is_complete() && std::abs(sheet.axes[0].fit[noise::Term::white].value / 1e-4 - 1) < 0.1;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

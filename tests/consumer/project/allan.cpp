// SPDX-License-Identifier: MIT
#include <gyrobudget/allan/confidence.h>
#include <gyrobudget/allan/covariance.h>
#include <gyrobudget/allan/deviation.h>
#include <gyrobudget/allan/factors.h>
#include <gyrobudget/noise/generate.h>
#include <gyrobudget/noise/version.h>

#include <array>
#include <cmath>
#include <cstdio>

int main() {
  using namespace gyrobudget;
  const std::array<noise::Process, 1> white{noise::White{1}};
  const auto record = noise::generate_record(white, 10000, 1, {.seed = 1, .stream = 0});
  const auto curve = allan::overlapped_variance(record, 1, allan::octave_factors(10000));
  const bool sane = std::abs(curve.points.front().variance - 1) < 0.1;
  std::printf("gyrobudget %s %s\n", kVersion, sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

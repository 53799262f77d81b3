// SPDX-License-Identifier: MIT
#include <gyrobudget/noise/units.h>
#include <gyrobudget/noise/version.h>

#include <cmath>
#include <cstdio>

int main() {
  using namespace gyrobudget;
  const bool sane = std::abs(noise::from_si(noise::parse_unit("deg/h").to_si * 15, "deg/h") - 15) < 1e-12;
  std::printf("gyrobudget %s %s\n", kVersion, sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

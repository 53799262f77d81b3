// SPDX-License-Identifier: MIT
#include <gyrobudget/app/log/log.h>

#include <cstdio>
#include <fstream>

int main() {
  using namespace gyrobudget;
  std::ofstream("log.csv") << "time (s),gyro_x (deg/s)\n0,1\n0.1,2\n0.2,3\n";
  const auto record = log::read_log({.path = "log.csv"});
  const bool sane = record.samples == 3 && record.axes.size() == 1 && record.rate_hz > 9.99 && record.rate_hz < 10.01;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

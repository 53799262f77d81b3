// SPDX-License-Identifier: MIT
#include <gyrobudget/app/sensor_file/sensor_file.h>

#include <cmath>
#include <cstdio>
#include <fstream>

int main() {
  using namespace gyrobudget;
  std::ofstream("sensor.yaml") << "gyro:\n  arw: 60 deg/sqrt(h)\n";  // 1 deg/sqrt(s)
  const auto sensor = sensor_file::read_sensor("sensor.yaml");
  const bool sane = std::abs(sensor.gyro.white[0] - 3.14159265358979 / 180) < 1e-15;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

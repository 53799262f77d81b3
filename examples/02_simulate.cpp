// SPDX-License-Identifier: MIT
// From a sensor file to a record of that gyro at rest, and its Allan deviation: example_simulate mems.yaml
#include <gyrobudget/allan/deviation.h>
#include <gyrobudget/allan/factors.h>
#include <gyrobudget/app/sensor_file/sensor_file.h>
#include <gyrobudget/noise/generate.h>

#include <cmath>
#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  using namespace gyrobudget;
  if (argc != 2) return std::fputs("usage: example_simulate mems.yaml\n", stderr), 2;
  const noise::SensorModel sensor = sensor_file::read_sensor(argv[1]);
  const double dt = 0.1;
  const auto rate = noise::generate_record(sensor.gyro.processes(0), 360000, dt, {.seed = 1, .stream = 0});
  const auto curve = allan::overlapped_variance(rate, dt, allan::decade_factors(360000));
  for (std::size_t i = 0; i < curve.points.size(); ++i)
    std::printf("%8g s  %.4g deg/h\n", curve.tau(i), noise::from_si(std::sqrt(curve.points[i].variance), "deg/h"));
} catch (const std::exception& error) {  // says where, what was found, what was expected, and how to mend it
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}

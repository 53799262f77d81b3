// SPDX-License-Identifier: MIT
// simulate: sensor file -> log of simulated noise at rest.
#include "gyrobudget/io/log_writer.h"
#include "gyrobudget/io/sensor_file.h"
#include "gyrobudget/noise/generate.h"

#include <fmt/format.h>

#include <cmath>

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

// Streams of random numbers: gyro axes are 0, 1, 2 whatever subset is asked for, accelerometer axes 3, 4, 5.
std::uint64_t stream_of(const std::string& axis, bool accelerometer) {
  return static_cast<std::uint64_t>(axis.front() - 'x') + (accelerometer ? 3U : 0U);
}

std::vector<double> simulate_axis(const SimulateArguments& a, const noise::ErrorModel& model,
                                  std::int64_t samples, std::uint64_t stream) {
  const auto processes = model.processes();
  const noise::StreamKey key{a.seed, stream};
  const double dt = 1 / a.rate_hz;
  if (a.model == "spectral") return noise::generate_record(processes, samples, dt, key);
  std::vector<double> rate(static_cast<std::size_t>(samples));
  noise::Generator::Options options;
  options.key = key;
  options.longest_tau = std::max(a.duration_s, 10 * dt);
  noise::Generator(processes, dt, options).next(rate);
  return rate;
}

}  // namespace

int run(const SimulateArguments& a) {
  if (a.output != "-") check_outputs(a.sensor, {{"-o", a.output}});
  const noise::SensorModel sensor = io::read_sensor(a.sensor);
  const auto samples = static_cast<std::int64_t>(std::llround(a.duration_s * a.rate_hz));
  std::vector<io::LogColumn> columns;
  const auto add = [&](const noise::ErrorModel& model, bool accelerometer, const std::string& unit) {
    for (const auto& axis : a.axes) {
      columns.push_back({fmt::format("{}_{}", accelerometer ? "accel" : "gyro", axis), unit,
                         simulate_axis(a, model, samples, stream_of(axis, accelerometer))});
    }
  };
  add(sensor.gyro, false, a.unit.empty() ? "rad/s" : a.unit);
  if (sensor.accelerometer) add(*sensor.accelerometer, true, "m/s^2");
  const std::string comment = fmt::format("gyrobudget simulate: sensor {}, model {}, seed {}, {} Hz, {} s",
                                          sensor.name, a.model, a.seed, a.rate_hz, a.duration_s);
  io::write_log(a.output, columns, a.rate_hz, comment);
  say(a.common,
      fmt::format("simulated {} samples of {} axes at {} Hz ({} model, seed {}){}", samples, columns.size(),
                  a.rate_hz, a.model, a.seed, a.output == "-" ? "" : " into " + a.output));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

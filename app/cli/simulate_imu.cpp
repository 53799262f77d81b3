// SPDX-License-Identifier: MIT
// simulate --trajectory: sensor file and trajectory -> log of a whole IMU, the truth, and what the scene's aids
// measure.
#include "gyrobudget/app/files/fixes_file.h"
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/report/sensor_words.h"
#include "gyrobudget/app/report/simulation.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/estimation/navigation/simulated_imu.h"

#include <fmt/format.h>

#include <filesystem>

#include "flown.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

void write_log(const SimulateArguments& a, const log::LogHead& head, std::uint64_t count,
               navigation::SimulatedImu& imu) {
  const double factor = a.flight->input == log::Input::increment ? 1 : a.rate_hz;
  std::uint64_t at = a.skipped;
  log::write_log(a.output, head, count, [&](std::span<const std::span<double>> columns) {
    const auto readings = imu.next(columns.front().size());
    for (std::size_t k = 0; k < readings.size(); ++k) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        columns[axis][k] = factor * readings[k].angle[axis];
        columns[axis + 3][k] = factor * readings[k].velocity[axis];
      }
      if (a.temperature) columns[6][k] = a.temperature->at((static_cast<double>(at++) + 0.5) / a.rate_hz);
    }
  });
}

void write_fixes(const SimulateArguments& a, const earth::Trajectory& trajectory) {
  if (a.flight->fixes.empty()) return;
  const navigation::Scenario scenario = files::read_scene(a.flight->trajectory).scenario;
  for (const auto& device : files::simulated_devices(scenario, trajectory, a.seed, a.flight->run)) {
    const auto path = std::filesystem::path(a.flight->fixes) / (device.device + ".csv");
    text::write_file(path.string(), files::fixes_csv(device));
    say(a.common, "fixes: " + path.string());
  }
}

}  // namespace

int run_flight(const SimulateArguments& a) {
  const FlightArguments& flight = *a.flight;
  check_flight_paths(a);
  const sensor_file::SensorFile file = sensor_file::read_sensor_file(a.sensor, {.rate_hz = a.sensor_rate_hz});
  const noise::SensorModel& sensor = file.model;
  for (const auto& note : report::sensor_notes(file.warnings, file.notes, a.sensor)) say(a.common, "note: " + note);
  const earth::Trajectory trajectory = files::scene_or_trajectory(flight.trajectory);
  const Flown flown = flown_of(a, trajectory);
  const navigation::SimulatedImuOptions options{a.rate_hz, a.seed, flight.run, flight.vibration, a.temperature};
  navigation::SimulatedImu imu(trajectory, sensor, options);
  imu.skip(a.skipped);
  const bool increments = flight.input == log::Input::increment;
  const std::string unit = !a.unit.empty() ? a.unit : increments ? "rad" : "rad/s";
  write_log(a, report::imu_head(options, sensor.name, flight.trajectory, unit, increments, a.skipped, a.format),
            flown.rows, imu);
  if (!flight.truth.empty()) {
    files::write_trajectory(flight.truth, trajectory,
                            {.rate_hz = a.rate_hz,
                             .attitude = flight.attitude,
                             .comment = "gyrobudget simulate: truth of trajectory " + flight.trajectory,
                             .duration = flown.duration_s});
  }
  write_fixes(a, trajectory);
  for (const auto& note : report::imu_notes(sensor, imu.imu())) say(a.common, note);
  say(a.common,
      fmt::format("simulated {} samples of an IMU at {} Hz along {} (seed {}, run {}){}", flown.rows, a.rate_hz,
                  flight.trajectory, a.seed, flight.run, a.output == "-" ? "" : " into " + a.output));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

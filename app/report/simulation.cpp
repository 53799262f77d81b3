// SPDX-License-Identifier: MIT
#include "simulation.h"

#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace gyrobudget::inline v0::report {
namespace {

constexpr std::array kAxes{"x", "y", "z"};

}  // namespace

log::LogHead rest_head(const noise::Simulation& simulation, const std::string& sensor, const std::string& model,
                       const std::string& gyro_unit, std::uint64_t skipped, log::Format format) {
  const noise::SimulationOptions& o = simulation.options();
  const std::string length = std::isinf(o.duration_s) ? "endless" : fmt::format("{} s", o.duration_s);
  log::LogHead head{
      {},
      o.rate_hz,
      fmt::format("gyrobudget simulate: sensor {}, model {}, seed {}, {} Hz, {}{}", sensor, model, o.seed, o.rate_hz,
                  length, skipped > 0 ? fmt::format(", without the first {} samples", skipped) : ""),
      skipped,
      format};
  for (const noise::SimulatedAxis& axis : simulation.axes()) {
    const bool gyro = axis.signal == noise::Signal::angular_rate;
    head.columns.push_back(
        {fmt::format("{}_{}", gyro ? "gyro" : "accel", kAxes.at(static_cast<std::size_t>(axis.axis))),
         gyro ? gyro_unit : "m/s^2"});
  }
  if (o.temperature) head.columns.push_back({"temperature", "degC"});
  return head;
}

log::LogHead imu_head(const navigation::SimulatedImuOptions& o, const std::string& sensor,
                      const std::string& trajectory, const std::string& gyro_unit, bool increments,
                      std::uint64_t skipped, log::Format format) {
  const std::string vibration =
      o.vibration == 0 ? "no vibration" : "vibration " + noise::quantity_text(o.vibration, "g") + " rms";
  log::LogHead head{
      {},
      o.rate_hz,
      fmt::format(
          "gyrobudget simulate: sensor {}, trajectory {}, seed {}, run {}, {} Hz, {}; each row is {} the interval that ends at its time",
          sensor, trajectory, o.seed, o.run, o.rate_hz, vibration, increments ? "the increment over" : "the mean over"),
      skipped + 1,
      format};
  for (const char* axis : kAxes) head.columns.push_back({fmt::format("gyro_{}", axis), gyro_unit});
  for (const char* axis : kAxes) head.columns.push_back({fmt::format("accel_{}", axis), increments ? "m/s" : "m/s^2"});
  if (o.temperature) head.columns.push_back({"temperature", "degC"});
  return head;
}

std::vector<std::string> left_out_notes(const noise::SimulationModel& model, const noise::SensorModel& sensor,
                                        const std::string& name) {
  std::vector<noise::Term> terms = noise::left_out(model, sensor.gyro);
  if (sensor.accelerometer) {
    for (const noise::Term t : noise::left_out(model, *sensor.accelerometer)) terms.push_back(t);
  }
  std::vector<std::string> notes;
  for (const noise::Term t : terms) {
    notes.push_back(
        fmt::format("note: model {} has no {}; it is left out", name, noise::label(noise::Signal::angular_rate, t)));
  }
  return notes;
}

std::vector<std::string> imu_notes(const noise::SensorModel& sensor, const noise::Imu& imu) {
  std::vector<std::string> notes;
  const auto add_saturated = [&](const char* triad, const std::array<std::uint64_t, 3>& counts) {
    if (counts == std::array<std::uint64_t, 3>{}) return;
    notes.push_back(fmt::format("note: {} out of range in {}, {} and {} samples of x, y and z", triad, counts[0],
                                counts[1], counts[2]));
  };
  add_saturated("gyro", imu.gyro_saturated());
  add_saturated("accelerometer", imu.accelerometer_saturated());
  if (sensor.lever_arm != std::array<double, 3>{}) {
    notes.emplace_back(
        "note: the trajectory and --truth are of the centre of mass; the IMU is at minus its lever_arm from there");
  }
  if (!sensor.accelerometer) notes.emplace_back("note: the sensor file has no accelerometer; an ideal one is written");
  return notes;
}

std::string how_to_read(const log::LogHead& head) {
  std::string columns;
  for (const auto& c : head.columns) {
    columns += fmt::format("{}{} ({})", columns.empty() ? "" : ", ", c.name, c.unit);
  }
  const bool says_columns = head.format == log::Format::npy || head.columns.size() == 1;
  return fmt::format("each sample is {}; read it with --format {} --rate {} --unit {}{}", columns,
                     log::name(head.format), head.rate_hz, head.columns.front().unit,
                     says_columns ? "" : fmt::format(" --columns {}", head.columns.size()));
}

}  // namespace gyrobudget::inline v0::report

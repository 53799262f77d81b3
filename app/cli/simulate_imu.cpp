// SPDX-License-Identifier: MIT
// simulate --trajectory: sensor file and trajectory -> log of a whole IMU, and the truth.
#include "gyrobudget/app/files/fixes_file.h"
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/trajectory_file.h"
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/estimation/navigation/simulated_fixes.h"
#include "gyrobudget/noise/imu.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

bool increments(const SimulateArguments& a) { return a.flight->input == log::Input::increment; }

std::string gyro_unit(const SimulateArguments& a) {
  if (!a.unit.empty()) return a.unit;
  return increments(a) ? "rad" : "rad/s";
}

/// How long is flown, at most the whole trajectory.
double flown(const SimulateArguments& a, const earth::Trajectory& trajectory) {
  if (a.duration_s == 0) return trajectory.duration();
  if (a.duration_s <= trajectory.duration()) return a.duration_s;
  throw std::invalid_argument(
      fmt::format("--duration {} s: the trajectory ends at {} s", a.duration_s, trajectory.duration()));
}

std::uint64_t interval_count(const SimulateArguments& a, const earth::Trajectory& trajectory) {
  const std::uint64_t count = files::whole_intervals(flown(a, trajectory), a.rate_hz);
  if (count > a.skipped) return count;
  throw std::invalid_argument(
      fmt::format("{} s at {} Hz are {} samples, of which --skip leaves none", flown(a, trajectory), a.rate_hz, count));
}

std::string comment(const SimulateArguments& a, const noise::SensorModel& sensor) {
  return fmt::format(
      "gyrobudget simulate: sensor {}, trajectory {}, seed {}, run {}, {} Hz, {}; each row is {} the interval that ends at its time",
      sensor.name, a.flight->trajectory, a.seed, a.flight->run, a.rate_hz,
      a.flight->vibration == 0 ? std::string("no vibration")
                               : "vibration " + noise::quantity_text(a.flight->vibration, "g") + " rms",
      increments(a) ? "the increment over" : "the mean over");
}

log::LogHead log_head(const SimulateArguments& a, const noise::SensorModel& sensor) {
  log::LogHead head{{}, a.rate_hz, comment(a, sensor), a.skipped + 1, a.format};
  for (const char* axis : {"x", "y", "z"}) head.columns.push_back({fmt::format("gyro_{}", axis), gyro_unit(a)});
  for (const char* axis : {"x", "y", "z"}) {
    head.columns.push_back({fmt::format("accel_{}", axis), increments(a) ? "m/s" : "m/s^2"});
  }
  return head;
}

/// What an IMU at `r` from the trajectory's point [m, body axes] senses more, w' x r + w x (w x r), over an interval:
/// the first in closed form, the second by Simpson's rule.
Eigen::Vector3d of_lever_arm(const earth::Trajectory& trajectory, const Eigen::Vector3d& r, double from, double to) {
  const auto rate = [&](double t) -> Eigen::Vector3d { return trajectory.at(t).sensed.w_ib_b; };
  const Eigen::Vector3d start = rate(from), middle = rate((from + to) / 2), end = rate(to);
  const auto inwards = [&](const Eigen::Vector3d& w) -> Eigen::Vector3d { return w.cross(w.cross(r)); };
  return (end - start).cross(r) + (to - from) / 6 * (inwards(start) + 4 * inwards(middle) + inwards(end));
}

/// What an ideal IMU delivers over `count` intervals from the one numbered `first` on.
std::vector<noise::ImuIncrement> truth(const earth::Trajectory& trajectory, const Eigen::Vector3d& imu_at,
                                       double rate_hz, std::uint64_t first, std::size_t count) {
  std::vector<noise::ImuIncrement> result(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const auto time = [&](std::uint64_t k) {
      return std::min(static_cast<double>(k) / rate_hz, trajectory.duration());
    };
    result[i] = trajectory.increment(time(first + i), time(first + i + 1));
    if (!imu_at.isZero(0))
      earth::vector(result[i].velocity) += of_lever_arm(trajectory, imu_at, time(first + i), time(first + i + 1));
  });
  return result;
}

/// The IMU fed along the trajectory, block by block.
class Feed {
 public:
  Feed(const SimulateArguments& a, const earth::Trajectory& trajectory, const noise::SensorModel& sensor,
       noise::Imu& imu)
      : trajectory_(trajectory),
        imu_at_(-sensor.lever_arm[0], -sensor.lever_arm[1], -sensor.lever_arm[2]),
        imu_(imu),
        rate_hz_(a.rate_hz),
        factor_(increments(a) ? 1 : a.rate_hz) {}

  void skip(std::uint64_t samples) {
    constexpr std::uint64_t kBlock = 1 << 14;
    for (std::uint64_t count; samples > 0; samples -= count) {
      count = std::min(samples, kBlock);
      for (const auto& ideal : block(static_cast<std::size_t>(count))) (void)imu_.next(ideal);
    }
  }

  void fill(std::span<const std::span<double>> columns) {
    const auto ideal = block(columns.front().size());
    for (std::size_t k = 0; k < ideal.size(); ++k) {
      const noise::ImuIncrement y = imu_.next(ideal[k]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        columns[axis][k] = factor_ * y.angle[axis];
        columns[axis + 3][k] = factor_ * y.velocity[axis];
      }
    }
  }

 private:
  std::vector<noise::ImuIncrement> block(std::size_t count) {
    auto result = truth(trajectory_, imu_at_, rate_hz_, at_, count);
    at_ += count;
    return result;
  }

  const earth::Trajectory& trajectory_;
  Eigen::Vector3d imu_at_;  ///< from the centre of mass, which flies the trajectory
  noise::Imu& imu_;
  double rate_hz_, factor_;
  std::uint64_t at_ = 0;
};

void say_what_is_special(const SimulateArguments& a, const noise::SensorModel& sensor, const noise::Imu& imu) {
  const auto say_saturated = [&](const char* triad, const std::array<std::uint64_t, 3>& counts) {
    if (counts == std::array<std::uint64_t, 3>{}) return;
    say(a.common, fmt::format("note: {} out of range in {}, {} and {} samples of x, y and z", triad, counts[0],
                              counts[1], counts[2]));
  };
  say_saturated("gyro", imu.gyro_saturated());
  say_saturated("accelerometer", imu.accelerometer_saturated());
  if (sensor.lever_arm != std::array<double, 3>{}) {
    say(a.common,
        "note: the trajectory and --truth are of the centre of mass; the IMU is at minus its lever_arm from there");
  }
  if (!sensor.accelerometer) say(a.common, "note: the sensor file has no accelerometer; an ideal one is written");
}

bool is_scene(const std::string& text) { return text.ends_with(".yaml") || text.ends_with(".yml"); }

void check_paths(const SimulateArguments& a) {
  if (!a.flight->fixes.empty() && !is_scene(a.flight->trajectory))
    throw std::invalid_argument("--fixes: the aids stand in a scene; give one (.yaml) as --trajectory");
  if (!a.flight->fixes.empty() && !std::filesystem::is_directory(a.flight->fixes))
    throw text::OutputError(fmt::format("{}: no such folder for --fixes", a.flight->fixes));
  const std::vector<Output> outputs{{"-o", a.output == "-" ? "" : a.output}, {"--truth", a.flight->truth}};
  check_outputs(a.sensor, outputs);
  if (std::filesystem::exists(a.flight->trajectory)) check_outputs(a.flight->trajectory, outputs);
}

// What each device of the scene measures, in the order of its aids.
std::vector<files::DeviceFixes> devices(const SimulateArguments& a, const earth::Trajectory& trajectory) {
  const navigation::Scenario scenario = files::read_scene(a.flight->trajectory).scenario;
  std::vector<files::DeviceFixes> list;
  for (std::size_t i = 0; i < scenario.aids.size(); ++i) {
    const navigation::Aid& aid = scenario.aids[i];
    if (!aid.used || aid.kind == navigation::Aid::Kind::rest) continue;
    const std::string device = aid.name.substr(0, aid.name.rfind('.'));
    if (list.empty() || list.back().device != device) list.push_back({device, {}, {}});
    list.back().kinds.push_back(aid.kind);
    list.back().fixes.push_back(simulated_fixes(aid, static_cast<int>(i), trajectory, a.seed, a.flight->run));
  }
  return list;
}

void write_fixes(const SimulateArguments& a, const earth::Trajectory& trajectory) {
  if (a.flight->fixes.empty()) return;
  for (const files::DeviceFixes& device : devices(a, trajectory)) {
    const auto path = std::filesystem::path(a.flight->fixes) / (device.device + ".csv");
    text::write_file(path.string(), files::fixes_csv(device));
    say(a.common, "fixes: " + path.string());
  }
}

// That of a scene, by its ending, or as read_trajectory has it.
earth::Trajectory trajectory_of(const std::string& text) {
  return is_scene(text) ? files::planned_trajectory(files::read_scene(text)) : files::read_trajectory(text);
}

}  // namespace

int run_flight(const SimulateArguments& a) {
  check_paths(a);
  const noise::SensorModel sensor = sensor_file::read_sensor(a.sensor);
  const earth::Trajectory trajectory = trajectory_of(a.flight->trajectory);
  const std::uint64_t count = interval_count(a, trajectory);
  noise::Imu imu(sensor, 1 / a.rate_hz, {a.seed, a.flight->run},
                 {.vibration = a.flight->vibration, .duration = trajectory.duration()});
  Feed feed(a, trajectory, sensor, imu);
  feed.skip(a.skipped);
  log::write_log(a.output, log_head(a, sensor), count - a.skipped,
                 [&](std::span<const std::span<double>> columns) { feed.fill(columns); });
  if (!a.flight->truth.empty()) {
    files::write_trajectory(a.flight->truth, trajectory,
                            {.rate_hz = a.rate_hz,
                             .attitude = a.flight->attitude,
                             .comment = "gyrobudget simulate: truth of trajectory " + a.flight->trajectory,
                             .duration = flown(a, trajectory)});
  }
  write_fixes(a, trajectory);
  say_what_is_special(a, sensor, imu);
  say(a.common,
      fmt::format("simulated {} samples of an IMU at {} Hz along {} (seed {}, run {}){}", count - a.skipped, a.rate_hz,
                  a.flight->trajectory, a.seed, a.flight->run, a.output == "-" ? "" : " into " + a.output));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

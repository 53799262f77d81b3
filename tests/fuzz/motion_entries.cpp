// SPDX-License-Identifier: MIT
// Readers of what moves: trajectories, the logs that a scene names, the flight of a scene.
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/trajectory_file.h"
#include "gyrobudget/app/files/trajectory_spec.h"
#include "gyrobudget/app/files/vehicle_file.h"
#include "gyrobudget/app/text/error.h"

#include <cmath>
#include <cstdint>
#include <optional>
#include <stdexcept>

#include "entries.h"
#include "memory_file.h"

namespace gyrobudget::fuzz {
namespace {

void read_trajectory(std::string_view bytes) {
  const MemoryFile file(bytes);
  try {
    const earth::Trajectory trajectory = files::read_trajectory(file.path());
    promise(std::isfinite(trajectory.duration()) && trajectory.duration() > 0, "a trajectory without a duration");
    for (const double part : {0., 0.25, 0.5, 1.}) {
      const earth::Pose pose = trajectory.at(part * trajectory.duration()).pose;
      promise(pose.p_eb_e.allFinite() && pose.v_eb_e.allFinite() && pose.q_eb.coeffs().allFinite(), "not a place");
    }
  } catch (const text::InputError& error) {
    promise(error.what()[0] != '\0', "an error without a message");
  }
}

/// A path by name: what stands before the first end of a line.
void name_trajectory(std::string_view bytes) {
  try {
    const std::string words(bytes.substr(0, bytes.find('\n')));
    if (!files::is_named_trajectory(words)) return;
    const earth::Pose pose = files::read_trajectory(words).at(0).pose;
    promise(pose.p_eb_e.allFinite() && pose.v_eb_e.allFinite(), "not a place");
  } catch (const std::invalid_argument&) {
  }
}

/// A second of an IMU at rest, for aids beside it.
const std::string& still_imu() {
  static const std::string kText = [] {
    std::string text =
        "time (s),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),acc_x (m/s^2),acc_y (m/s^2),acc_z (m/s^2)\n";
    for (int i = 0; i <= 100; ++i) text += std::to_string(0.01 * i) + ",0,0,0,0,0,-9.8\n";
    return text;
  }();
  return kText;
}

files::SceneFile scene_with(const std::string& imu) {
  files::SceneFile scene;
  scene.imu.emplace();
  scene.imu->path = imu;
  return scene;
}

void check(const files::SceneData& data) {
  for (const auto& fixes : data.recording.fixes) {
    for (const navigation::Fix& fix : fixes)
      promise(fix.value.allFinite() && fix.q_nb.coeffs().allFinite(), "a fix without a place");
  }
}

void read_data(const files::SceneFile& scene) {
  try {
    check(files::read_recording(scene));
  } catch (const text::InputError& error) {
    promise(error.what()[0] != '\0', "an error without a message");
  }
}

/// The first byte chooses axes, rate and what a stamp means.
void read_imu(std::string_view bytes) {
  if (bytes.empty()) return;
  const auto choice = static_cast<std::uint8_t>(bytes.front());
  const MemoryFile file(bytes.substr(1));
  files::SceneFile scene = scene_with(file.path());
  if (choice & 1) scene.imu->rate_hz = 100;
  if (choice & 2) scene.imu->axis = {1, 0, 2}, scene.imu->sign = {1, 1, -1};
  if (choice & 4) scene.imu->instants = true;
  if (choice & 8) scene.imu->stamp = navigation::StampAt::start;
  if (choice & 16) scene.imu->columns = {{"gyro_x", "a"}, {"acc_x", "b (m/s^2)"}};
  read_data(scene);
}

/// The first byte chooses the kind of aid.
void read_fixes(std::string_view bytes) {
  using Kind = navigation::Aid::Kind;
  if (bytes.empty()) return;
  constexpr Kind kKinds[] = {Kind::position, Kind::velocity, Kind::height, Kind::attitude};
  const auto choice = static_cast<std::uint8_t>(bytes.front());
  const MemoryFile imu(still_imu()), file(bytes.substr(1));
  files::SceneFile scene = scene_with(imu.path());
  navigation::Aid aid;
  aid.name = "aid";
  aid.kind = kKinds[choice & 3];
  scene.scenario.aids = {aid};
  scene.aids = {{file.path(), {}}};
  if (choice & 4) scene.aids.front().columns = {{"time", "stamp (ms)"}, {"height", "h (m)"}};
  read_data(scene);
}

/// A scene with a flight; the word VEHICLE stands for the path of a vehicle file that is there.
void read_flight(std::string_view bytes) {
  static const MemoryFile kVehicle(files::vehicle_help());
  std::string text(bytes);
  constexpr std::string_view kWord = "VEHICLE";
  if (const std::size_t at = text.find(kWord); at != std::string::npos) text.replace(at, kWord.size(), kVehicle.path());
  const MemoryFile file(text);
  try {
    const files::SceneFile scene = files::read_scene(file.path());
    if (scene.flight) scene.flight->plan.flight.vehicle.check();
  } catch (const text::InputError& error) {
    promise(error.what()[0] != '\0', "an error without a message");
  }
}

}  // namespace

std::vector<Entry> motion_entries() {
  const std::string place = "time (s),latitude (deg),longitude (deg),height (m)";
  return {
      {"trajectory",
       read_trajectory,
       {place +
            ",q_w,q_x,q_y,q_z\n0,1,2,3,1,0,0,0\n1,1.0001,2,4,1,0,0,0\n2,1.0002,2,6,1,0,0,0.001\n3,1.0003,2,8,1,0,0,0\n",
        place +
            ",yaw (deg),pitch (deg),roll (deg)\n1700000000,80,179.9999,3,0,90,0\n1700000001,80,-179.9999,4,359,89,1\n1700000003,80,-179.9997,9,1,88,2\n"}},
      {"path",
       name_trajectory,
       {"cruise:speed=900km/h,duration=600", "static:site=alcantara,yaw=90,duration=1 h", "ascent:duration=50",
        "climb:acceleration=20,azimuth=1e3,duration=3"}},
      {"imu",
       read_imu,
       {with_options(0, still_imu()), with_options(4, still_imu()),
        with_options(
            17,
            "a (deg/s),gyro_y,gyro_z (deg/s),b (m/s^2),acc_y (m/s^2),acc_z (g)\n1,2,3,4,5,1\n1,2,3,4,5,1\n1,nan,3,4,5,1\n")},
       700},
      {"fixes",
       read_fixes,
       {with_options(0, place + "\n0,1,2,3\n0.5,1,2,3\n0.9,1,2,nan\n"),
        with_options(1, "time (s),velocity_north (m/s),velocity_east (m/s),velocity_down (m/s)\n0,1,2,3\n1,1,2,3\n"),
        with_options(6, "stamp (ms),h (m)\n0,3\n500,3e9\n"),
        with_options(3, "time (s),yaw (deg),pitch (deg),roll (deg)\n0,1,2,3\n1,1,90,3\n")},
       700},
      {"flight",
       read_flight,
       {"site: alcantara\nflight:\n  vehicle: VEHICLE\n  bending: no\n  pitch: [[8 s, 90 deg], [83 s, 50 deg]]\n  control:\n    frequency: 2.5 rad/s\n    damping: 0.7\n    feedback: rate_error\n    least_thrust: 20 %\n    notch: {frequency: 7 Hz, depth: 0.05, width: 0.5}\n    rate: 100 Hz\n  guidance: {frequency: 0.1 rad/s, damping: 0.7, angle_limit: 5 deg}\n  atmosphere: yes\n",
        "site: alcantara\nflight:\n  vehicle: VEHICLE\n  wind:\n    east: 5 m/s\n    north: 0 m/s\n    shear_east: [[0 km, 0 m/s], [10 km, 30 m/s]]\n    gust: {height: 9 km, half_width: 300 m, east: 0 m/s, north: 9 m/s, up: 0 m/s}\n  dispersion:\n    impulse: 0.5 %\n    pressure_ahead: 10 cm\n    wind: 5 m/s\n  integrator: {method: fehlberg78, step: 10 ms, tolerance: 1e-9}\n",
        "site: alcantara\nflight:\n  vehicle: VEHICLE\n  faults:\n    thrust_cut: 200 s\n    nozzle_stuck: {at: 200 s, pitch: 1 deg, yaw: 0 deg}\n    thrust_misalignment: {pitch: 0 deg, yaw: 0 deg}\n    dead_gyro: {axis: y, at: 200 s}\n    navigation_delay: 0 s\n"},
       700}};
}

}  // namespace gyrobudget::fuzz

// SPDX-License-Identifier: MIT
#include <gyrobudget/estimation/batch/batch.h>
#include <gyrobudget/vehicle/earth/paths.h>

#include <cstdint>
#include <cstdio>

// A body at rest for five seconds, its position fixed once a second.
int main() {
  using namespace gyrobudget;
  constexpr int kRate = 100, kSeconds = 5;  // Hz, s
  const earth::Trajectory path = earth::stand({.duration = kSeconds});
  const auto all = path.increments(1. / kRate);

  navigation::Recording recording;
  recording.imu.increments = all;
  for (std::size_t k = 0; k <= all.size(); ++k)
    recording.imu.stamps.push_back(std::int64_t{10'000'000} * static_cast<std::int64_t>(k));
  recording.imu.bridged.assign(recording.imu.increments.size(), false);
  recording.imu.typical_interval = 1. / kRate;

  navigation::Scenario scenario;
  scenario.sensor.gyro.white = 1e-5;
  scenario.sensor.accelerometer.emplace();
  scenario.sensor.accelerometer->white = 1e-3;
  navigation::Aid gnss;
  gnss.name = "gnss";
  scenario.aids = {gnss};
  recording.fixes.resize(1);
  for (int t = 1; t <= kSeconds; ++t)
    recording.fixes[0].push_back({.stamp = std::int64_t{1'000'000'000} * t, .value = path.at(t).pose.p_eb_e});
  scenario.alignment.position = earth::alcantara().position;
  scenario.alignment.position_sigma = Eigen::Vector3d::Ones();
  scenario.alignment.velocity_sigma = Eigen::Vector3d::Constant(0.1);
  scenario.alignment.level_sigma = scenario.alignment.heading_sigma = 1e-3;

  const batch::Estimate found = batch::estimate(scenario, recording);
  const bool estimated = found.status == batch::Estimate::Status::estimated && !found.solutions.empty();
  const bool sane = estimated && (found.solutions.back().state.p_eb_e - path.at(kSeconds).pose.p_eb_e).norm() < 0.1;
  std::printf("%s\n", sane ? "ok" : found.why.c_str());
  return sane ? 0 : 1;
}

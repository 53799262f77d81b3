// SPDX-License-Identifier: MIT
#include "simulated_imu.h"

#include "gyrobudget/vehicle/earth/vector.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <utility>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Vector3d;

// What an IMU at `r` from the trajectory's point [m, body axes] senses more, w' x r + w x (w x r), over an interval.
Vector3d of_lever_arm(const earth::Trajectory& trajectory, const Vector3d& r, double from, double to) {
  const auto rate = [&](double t) -> Vector3d { return trajectory.at(t).sensed.w_ib_b; };
  const Vector3d start = rate(from), middle = rate((from + to) / 2), end = rate(to);
  const auto inwards = [&](const Vector3d& w) -> Vector3d { return w.cross(w.cross(r)); };
  return (end - start).cross(r) + (to - from) / 6 * (inwards(start) + 4 * inwards(middle) + inwards(end));
}

}  // namespace

SimulatedImu::SimulatedImu(earth::Trajectory trajectory, const noise::SensorModel& sensor,
                           const SimulatedImuOptions& options)
    : trajectory_(std::move(trajectory)),
      imu_at_(-sensor.lever_arm[0], -sensor.lever_arm[1], -sensor.lever_arm[2]),
      imu_(sensor, 1 / options.rate_hz, {options.seed, options.run},
           {.vibration = options.vibration, .temperature = options.temperature, .duration = trajectory_.duration()}),
      rate_hz_(options.rate_hz) {}

std::vector<noise::ImuIncrement> SimulatedImu::next(std::size_t count) {
  std::vector<noise::ImuIncrement> readings = ideal(count);
  for (noise::ImuIncrement& reading : readings) reading = imu_.next(reading);
  return readings;
}

void SimulatedImu::skip(std::uint64_t intervals) {
  constexpr std::uint64_t kBlock = 1 << 14;
  for (std::uint64_t count; intervals > 0; intervals -= count) {
    count = std::min(intervals, kBlock);
    (void)next(static_cast<std::size_t>(count));
  }
}

// What an ideal IMU delivers over the next intervals.
std::vector<noise::ImuIncrement> SimulatedImu::ideal(std::size_t count) {
  std::vector<noise::ImuIncrement> result(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const auto time = [&](std::uint64_t k) {
      return std::min(static_cast<double>(k) / rate_hz_, trajectory_.duration());
    };
    const double from = time(at_ + i), to = time(at_ + i + 1);
    result[i] = trajectory_.increment(from, to);
    if (!imu_at_.isZero(0)) earth::vector(result[i].velocity) += of_lever_arm(trajectory_, imu_at_, from, to);
  });
  at_ += count;
  return result;
}

}  // namespace gyrobudget::inline v0::navigation

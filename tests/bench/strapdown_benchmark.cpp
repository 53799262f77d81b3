// SPDX-License-Identifier: MIT
// Error against run time of the strapdown, over order and step: a moving profile with vibration, noise-free.
// Orders take turns, in passes over the same increments; each block of a pass counts with its fastest run,
// so that other work on the machine counts little.
#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <numeric>
#include <vector>

namespace {

using namespace gyrobudget;
using navigation::Strapdown;

constexpr double kDuration = 1000;
constexpr int kPasses = 5;
constexpr std::size_t kBlock = 1000;
constexpr std::array kOrders{1, 2, 3, 4, 5, 6, 7, 8};

/// 300 m/s, S-turns at 0.5 g banking at 5 degrees a second, 1 degree of coning and 0.2 g of sculling at 5 Hz.
earth::Trajectory profile() {
  constexpr double g = 9.80665;
  earth::Cruise cruise;
  cruise.speed = 300;
  cruise.turn_acceleration = 0.5 * g;
  cruise.turn_period = 33;
  cruise.vibration = {.coning_angle = earth::kDegree,
                      .coning_frequency = 5,
                      .sculling_angle = earth::kDegree,
                      .sculling_acceleration = 0.2 * g,
                      .sculling_frequency = 5};
  cruise.duration = kDuration;
  return earth::cruise(cruise);
}

struct Row {
  std::vector<double> block_seconds;  ///< the least so far
  double position = 0;
  double attitude = 0;
};

void pass(const earth::Trajectory& truth, const std::vector<noise::ImuIncrement>& imu, double dt, int order, Row& row) {
  const earth::Pose end = truth.at(kDuration).pose;
  row.block_seconds.resize((imu.size() + kBlock - 1) / kBlock, std::numeric_limits<double>::infinity());
  Strapdown strapdown(truth.at(0).pose, {.order = order});
  for (std::size_t block = 0; block * kBlock < imu.size(); ++block) {
    const auto before = std::chrono::steady_clock::now();
    for (std::size_t k = block * kBlock; k < std::min((block + 1) * kBlock, imu.size()); ++k)
      strapdown.step(imu[k], dt);
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - before;
    row.block_seconds[block] = std::min(row.block_seconds[block], spent.count());
  }
  const auto& state = strapdown.state();
  row.position = (state.p_eb_e - end.p_eb_e).norm();
  row.attitude = earth::log_rotation(end.q_eb.conjugate() * state.q_eb).norm();
}

}  // namespace

int main() {
  const earth::Trajectory truth = profile();
  fmt::print("{:>8} {:>6} {:>14} {:>14} {:>10} {:>12}\n", "step [s]", "order", "position [m]", "attitude [rad]",
             "ns/step", "Msteps/s");
  for (const double dt : {0.01, 0.005, 0.0025}) {
    const auto imu = truth.increments(dt);
    std::array<Row, kOrders.size()> rows;
    for (int k = 0; k < kPasses; ++k)
      for (std::size_t i = 0; i < kOrders.size(); ++i) pass(truth, imu, dt, kOrders[i], rows[i]);
    for (std::size_t i = 0; i < kOrders.size(); ++i) {
      const auto& blocks = rows[i].block_seconds;
      const double each = std::accumulate(blocks.begin(), blocks.end(), 0.0) / static_cast<double>(imu.size());
      fmt::print("{:8} {:6} {:14.2e} {:14.2e} {:10.0f} {:12.2f}\n", dt, kOrders[i], rows[i].position, rows[i].attitude,
                 1e9 * each, 1e-6 / each);
    }
  }
}

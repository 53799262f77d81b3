// SPDX-License-Identifier: MIT
// Error against run time of the strapdown, over order and step: a moving profile with vibration,
// noise-free. Run time is the least of interleaved passes over the same increments.
#include "gyrobudget/earth/attitude.h"
#include "gyrobudget/earth/paths.h"
#include "gyrobudget/navigation/strapdown.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>

namespace {

using namespace gyrobudget;
using navigation::Strapdown;

constexpr double kDuration = 1000;
constexpr int kPasses = 5;
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
  double seconds = std::numeric_limits<double>::infinity();
  double position = 0;
  double attitude = 0;
};

Row pass(const earth::Trajectory& truth, const std::vector<earth::ImuIncrement>& imu, double dt, int order) {
  const auto start = truth.at(0);
  const auto end = truth.at(kDuration);
  Strapdown strapdown({start.p_eb_e, start.v_eb_e, start.q_eb}, {.order = order});
  const auto before = std::chrono::steady_clock::now();
  for (const auto& increment : imu) strapdown.step(increment, dt);
  const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - before;
  const auto& state = strapdown.state();
  return {spent.count(), (state.p_eb_e - end.p_eb_e).norm(),
          earth::log_rotation(end.q_eb.conjugate() * state.q_eb).norm()};
}

}  // namespace

int main() {
  const earth::Trajectory truth = profile();
  fmt::print("{:>8} {:>6} {:>14} {:>14} {:>10} {:>12}\n", "step [s]", "order", "position [m]",
             "attitude [rad]", "ns/step", "Msteps/s");
  for (const double dt : {0.01, 0.005, 0.0025}) {
    const auto imu = truth.increments(dt);
    std::array<Row, kOrders.size()> rows;
    for (int k = 0; k < kPasses; ++k)
      for (std::size_t i = 0; i < kOrders.size(); ++i) {
        const double least = rows[i].seconds;
        rows[i] = pass(truth, imu, dt, kOrders[i]);
        rows[i].seconds = std::min(rows[i].seconds, least);
      }
    for (std::size_t i = 0; i < kOrders.size(); ++i) {
      const double each = rows[i].seconds / static_cast<double>(imu.size());
      fmt::print("{:8} {:6} {:14.2e} {:14.2e} {:10.0f} {:12.2f}\n", dt, kOrders[i], rows[i].position,
                 rows[i].attitude, 1e9 * each, 1e-6 / each);
    }
  }
}

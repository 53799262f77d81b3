// SPDX-License-Identifier: MIT
#include "plan.h"

#include "gyrobudget/vehicle/earth/sampled.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gyrobudget::inline v0::flight {

FlightRecord fly_nominal(const Plan& plan) {
  Plan nominal = plan;
  nominal.guidance.reset();
  nominal.navigator_faults = {};
  nominal.flight.faults = {};
  constexpr double kSmooth = 0.05;  // [s] between points
  const double periods = std::round(kSmooth / nominal.flight.period);
  nominal.flight.record_every = plan.flight.vehicle.bending ? 1 : static_cast<int>(std::clamp(periods, 1.0, 1e6));
  PerfectNavigator navigator;
  return fly(nominal, nominal.flight, {}, navigator);
}

bool makes_a_trajectory(const FlightRecord& record) {
  constexpr double kShortest = 1;  // [s]
  constexpr std::size_t kPoints = 6;
  return record.end.t >= kShortest && record.points.size() >= kPoints;
}

earth::Trajectory trajectory(const FlightRecord& record) {
  std::vector<double> times;
  std::vector<Eigen::Vector3d> positions;
  std::vector<Eigen::Quaterniond> attitudes;
  for (const FlightPoint& p : record.points) {
    if (!times.empty() && p.t <= times.back()) continue;
    times.push_back(p.t);
    positions.push_back(p.truth.p_eb_e);
    attitudes.push_back(p.truth.q_eb);
  }
  return earth::through_samples(times, positions, attitudes);
}

}  // namespace gyrobudget::inline v0::flight

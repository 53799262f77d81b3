// SPDX-License-Identifier: MIT
#include "summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace gyrobudget::inline v0::closed_loop {

using flight::FlightPoint;
using flight::FlightRecord;

LimitsUsed limits_used(const flight::Vehicle& vehicle, const FlightRecord& record) {
  LimitsUsed used{.deflection = record.largest_deflection,
                  .deflection_limit = vehicle.actuator.deflection_limit,
                  .limited = record.limited};
  const auto look = [&](const FlightPoint& p) {
    const double q = p.flow.dynamic_pressure;
    used.pressure_angle = std::max(used.pressure_angle, q * p.flow.angle_of_attack);
    if (q > used.pressure) {
      used.pressure = q;
      used.pressure_at = p.t;
      used.mach = p.flow.mach;
    }
  };
  for (const FlightPoint& p : record.points) look(p);
  look(record.end);
  return used;
}

double decibel(double factor) { return 20 * std::log10(factor); }

std::vector<LeastMargins> least_margins(const MarginsAt& margins) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<LeastMargins> list;
  for (const flight::Margins& m : margins.points) {
    auto least = std::ranges::find(list, m.mode_factor, &LeastMargins::mode_factor);
    if (least == list.end())
      least = list.insert(
          list.end(), {.mode_factor = m.mode_factor, .gain_up_db = kNone, .gain_down_db = kNone, .phase_deg = kNone});
    const auto take = [&](double& value, double& at, double found) {
      if (found >= value) return;
      value = found;
      at = m.t;
    };
    take(least->gain_up_db, least->gain_up_at, decibel(m.gain_up));
    take(least->gain_down_db, least->gain_down_at, -decibel(m.gain_down));
    take(least->phase_deg, least->phase_at, m.phase / earth::kDegree);
    least->stable = least->stable && m.stable;
  }
  return list;
}

bool margins_met(const MarginsAt& margins) {
  const std::vector<LeastMargins> least = least_margins(margins);
  return !least.empty() && std::ranges::all_of(least, &LeastMargins::met);
}

Ellipse ellipse(const Eigen::Matrix3d& covariance, double launch_azimuth) {
  constexpr double kHalfTurn = 180 * earth::kDegree;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  const Eigen::Vector2d sigma = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  const Eigen::Vector2d major = solver.eigenvectors().col(1);
  const double azimuth = launch_azimuth - std::atan2(major[1], major[0]);  // crossrange is to the left
  return {sigma[1], sigma[0], azimuth - kHalfTurn * std::floor(azimuth / kHalfTurn)};
}

std::optional<NavigationCheck> navigation_check(const Study& study) {
  const int runs = study.sensors.complete();
  if (!study.budget || runs < 2) return std::nullopt;
  const auto found = navigation::local_sigmas(study.sensors.navigation_error(), study.C_launch);
  const auto expected = navigation::local_sigmas(study.budget->total.back(), study.C_launch);
  const auto ratio = [](double a, double b) { return b > 0 ? a / b : std::numeric_limits<double>::quiet_NaN(); };
  NavigationCheck check{.runs = runs};
  for (int i = 0; i < 3; ++i) check.position_ratio[i] = ratio(found.position[i], expected.position[i]);
  check.position = ratio(found.position.norm(), expected.position.norm());
  check.velocity = ratio(found.velocity.norm(), expected.velocity.norm());
  check.attitude = ratio(found.attitude.norm(), expected.attitude.norm());
  const auto band = navigation::sigma_ratio_band(runs, kRatioBand);
  check.low = band.lower;
  check.high = band.upper;
  return check;
}

bool same_nominal(const Study& one, const Study& other) {
  const FlightPoint &a = one.nominal.end, &b = other.nominal.end;
  return a.t == b.t && a.truth.p_eb_e == b.truth.p_eb_e && a.truth.v_eb_e == b.truth.v_eb_e &&
         std::ranges::equal(one.vehicle.outcomes, other.vehicle.outcomes, {}, &Outcome::position, &Outcome::position);
}

}  // namespace gyrobudget::inline v0::closed_loop

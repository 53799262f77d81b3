// SPDX-License-Identifier: MIT
#include "trial.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <boost/math/distributions/chi_squared.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobudget::inline v0::navigation::detail {
namespace {

using Eigen::Matrix3d;

constexpr double kFastest = 100;  // m/s: sigma of a velocity that nothing tells
constexpr double kLevel = 5 * earth::kDegree, kHeading = 40 * earth::kDegree;
constexpr double kSensors = 5;  // times their sigmas

// One sigma of what is added to each triad of the core.
struct Widening {
  double position = 0, velocity = 0, level = 0, heading = 0;
};

StateMatrix widened(const Filter& lost, const Widening& by) {
  StateMatrix P = lost.covariance().matrix();
  P.block<3, 3>(kPosition, kPosition).diagonal().array() += by.position * by.position;
  P.block<3, 3>(kVelocity, kVelocity).diagonal().array() += by.velocity * by.velocity;
  const earth::Geodetic at = earth::to_geodetic(lost.state().p_eb_e);
  const Matrix3d C_enu = earth::C_e_enu(at.latitude, at.longitude);
  const Eigen::Vector3d psi(by.level, by.level, by.heading);
  P.block<3, 3>(kAttitude, kAttitude) += C_enu * psi.cwiseAbs2().asDiagonal() * C_enu.transpose();
  return P;
}

// Every state times its factor: a covariance still.
StateMatrix scaled(const Filter& lost, double core, double sensors) {
  StateVector factor = StateVector::Constant(lost.covariance().size(), core);
  for (std::size_t k = 0; k < lost.model().terms.size(); ++k)
    factor[kCoreStates + static_cast<int>(k)] = lost.model().terms[k].carrier == Carrier::aid ? 1 : sensors;
  return factor.asDiagonal() * lost.covariance().matrix() * factor.asDiagonal();
}

}  // namespace

NisLimit::NisLimit(double false_alarm) {
  for (int rows = 1; rows <= 3; ++rows)
    limit_[static_cast<std::size_t>(rows)] = quantile(complement(boost::math::chi_squared(rows), false_alarm));
}

std::vector<Trial> trials(const Filter& lost, const Refused& refused, bool recorded) {
  std::vector<Trial> result;
  const auto add = [&](std::string_view what, const StateMatrix& P) {
    Trial trial{lost, nullptr, what};
    trial.filter.record(nullptr);
    trial.filter.restart(P);
    if (recorded) {
      trial.record = std::make_unique<FilterHistory>(lost.covariance().size());
      trial.filter.record(trial.record.get());
    }
    result.push_back(std::move(trial));
  };
  const double r = refused.innovation.residual.head(refused.innovation.rows).norm();
  const bool of_velocity = refused.kind == Refused::Kind::velocity;
  Widening place{.position = 2 * r}, motion = place;
  motion.velocity = std::min(3 * r / refused.since, kFastest);
  if (of_velocity) motion = {.position = r * refused.since, .velocity = 2 * r};
  if (!of_velocity) add("position", widened(lost, place));
  add("position and velocity", widened(lost, motion));
  const double s = std::sqrt(std::max(1.0, refused.innovation.nis / refused.innovation.rows));
  add("position, velocity, attitude and sensor errors", scaled(lost, s, s));
  Filter open = lost;
  open.record(nullptr);
  open.restart(scaled(lost, 1, kSensors));
  motion.level = kLevel;
  motion.heading = kHeading;
  add("position, velocity, attitude, heading and sensor errors", widened(open, motion));
  return result;
}

}  // namespace gyrobudget::inline v0::navigation::detail

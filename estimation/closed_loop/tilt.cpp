// SPDX-License-Identifier: MIT
#include "tilt.h"

#include "gyrobudget/vehicle/earth/vector.h"
#include "gyrobudget/vehicle/flight/vehicle.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::closed_loop {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using flight::FlightPoint;

constexpr int kEvery = 10;          // periods of a step
constexpr double kLeastSpeed = 1;   // [m/s] below which there is no air to speak of
constexpr std::size_t kNoise = 10;  // steps between the instants at which noise is let in

/// As fly_nominal() does, with increments and with points that are so far apart.
flight::FlightRecord flown(flight::Plan plan) {
  plan.guidance.reset();
  plan.navigator_faults = {};
  plan.flight.record_every = kEvery;
  plan.flight.keep_increments = true;
  flight::PerfectNavigator navigator;
  return fly(plan, plan.flight, {}, navigator);
}

struct Moved {
  Vector3d p = Vector3d::Zero(), v = Vector3d::Zero();
  void by(const Vector3d& a, double dt) {
    p += dt * (v + dt / 2 * a);
    v += dt * a;
  }
};

}  // namespace

TiltResponse::TiltResponse(const flight::Plan& plan) : nominal_(flown(plan)), step_(kEvery * plan.flight.period) {
  const flight::Vehicle& vehicle = plan.flight.vehicle;
  const double w = plan.control.frequency;
  for (std::size_t i = 0; i + 1 < nominal_.points.size(); ++i) {
    const FlightPoint& p = nominal_.points[i];
    const flight::BurnState burn = burn_state(vehicle, p.t);
    Point point{.C = p.truth.q_eb.toRotationMatrix(), .v = p.truth.v_eb_e, .f = Vector3d::Zero()};
    const auto first = std::min(i * kEvery, nominal_.increments.size());
    const auto last = std::min(first + kEvery, nominal_.increments.size());
    for (std::size_t k = first; k < last; ++k)
      point.f += point.C * earth::vector(nominal_.increments[k].velocity) / step_;
    const double speed = std::max(p.flow.speed, kLeastSpeed);
    const double force = p.flow.dynamic_pressure / speed * vehicle.reference_area * vehicle.normal_force_slope;
    const double least = plan.control.least_thrust * vehicle.mean_thrust();
    const double authority = p.flow.thrust / std::max(burn.vacuum_thrust, least);
    point.lateral = force / burn.mass;
    point.trim = vehicle.pressure_ahead / burn.centre_of_mass;
    point.yielding = vehicle.pressure_ahead * force / (burn.pitch_inertia * w * w * authority);
    points_.push_back(point);
  }
}

const TiltResponse::Point& TiltResponse::point(double t) const {
  const auto i = static_cast<std::size_t>(std::max(t, 0.0) / step_);
  return points_[std::min(i, points_.size() - 1)];
}

Vector3d TiltResponse::answer(const Tilt& psi, std::size_t from) const {
  Moved moved;
  for (std::size_t i = from; i < points_.size(); ++i) {
    const Point& at = points_[i];
    const Vector3d x = at.C.col(0), wanted = psi((static_cast<double>(i) + 0.5) * step_);
    const Vector3d pressed = at.across(wanted) - at.yielding * x.cross(moved.v);
    const Vector3d phi = x.dot(wanted) * x + pressed / (1 - at.yielding * x.dot(at.v));
    const Vector3d pushed = at.lateral * at.across(phi.cross(at.v) - moved.v);
    moved.by(phi.cross(at.f) + (1 + at.trim) * pushed, step_);
  }
  return moved.p;
}

Vector3d TiltResponse::position(const Tilt& psi) const { return answer(psi); }

Vector3d TiltResponse::position_of_standing_error() const {
  Moved moved;
  for (const Point& at : points_) {
    const Vector3d phi = -at.yielding * at.C.col(0).cross(at.v);
    const Vector3d nozzle = -at.trim * at.lateral * at.across(at.v);
    moved.by(phi.cross(at.f) + nozzle + at.lateral * at.across(phi.cross(at.v) - moved.v), step_);
  }
  return moved.p;
}

Matrix3d TiltResponse::covariance(const noise::ErrorModel& gyro) const {
  Matrix3d sum = Matrix3d::Zero();
  const auto add = [&](double size, const Vector3d& effect) { sum += size * size * effect * effect.transpose(); };
  const double dt = kNoise * step_;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // What a step of the angle at each instant does, the last first; summed up, what a step of the rate does.
    Vector3d of_rate = Vector3d::Zero();
    for (std::size_t i = points_.size() / kNoise; i-- > 0;) {
      const std::size_t middle = i * kNoise + kNoise / 2;
      Vector3d u = points_[middle].C.col(static_cast<Eigen::Index>(axis));
      const Vector3d of_angle = answer([&](double) { return u; }, middle);
      of_rate += of_angle * dt;
      add(gyro.white[axis] * std::sqrt(dt), of_angle);
      add(gyro.rate_random_walk[axis] * std::sqrt(dt), of_rate);
    }
    if (gyro.turn_on_bias) add((*gyro.turn_on_bias)[axis], of_rate);
  }
  return sum;
}

}  // namespace gyrobudget::inline v0::closed_loop

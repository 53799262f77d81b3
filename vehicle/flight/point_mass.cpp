// SPDX-License-Identifier: MIT
#include "point_mass.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/flight/detail/dynamics.h"

#include <boost/numeric/odeint/algebra/vector_space_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {
namespace {

using namespace detail;
using X = Eigen::Matrix<double, 6, 1>;
namespace odeint = boost::numeric::odeint;

constexpr double kBelowPad = 0.5;  // [m]

class PointMass {
 public:
  PointMass(const Flight& flight, const AttitudeControl& program)
      : plant_(without_lever(flight.vehicle), flight.world, flight.faults), program_(program) {}

  void operator()(const X& x, X& rate, double t) const { rate << x.tail<3>(), motion_at(x, t, nullptr).acceleration_i; }
  [[nodiscard]] Motion motion_at(const X& x, double t, Stream* air) const {
    const int layer = plant_.world.atmosphere ? standard_atmosphere::layer(height_of(x.head<3>()).above_ellipsoid)
                                              : standard_atmosphere::kLayers;
    const Segment segment{piece_, layer, Vector2d::Zero(), 0};
    return motion(plant_, segment, t, {x.head<3>(), x.tail<3>(), attitude(t), Vector3d::Zero()}, Vector2d::Zero(), air);
  }
  void enter(double from, double to) { piece_ = plant_.burn.piece((from + to) / 2); }
  [[nodiscard]] std::vector<double> breaks() const { return plant_.burn.breaks(); }

  [[nodiscard]] FlightPoint point(const X& x, double t) const {
    Stream air;
    const Motion m = motion_at(x, t, &air);
    const earth::Moving here = earth::Inertial().to_ecef({x.head<3>(), x.tail<3>()}, t);
    const earth::Pose pose{.p_eb_e = here.p, .v_eb_e = here.v, .q_eb = program_.reference(t)};
    const double sound = air.air.speed_of_sound;
    return {t,
            pose,
            pose,
            {air.height, 0.5 * air.air.density * air.speed * air.speed, sound > 0 ? air.speed / sound : 0, air.speed,
             std::atan2(air.velocity_b.tail<2>().norm(), air.velocity_b.x()), m.thrust},
            {},
            Vector2d::Zero(),
            Vector2d::Zero()};
  }

 private:
  static Vehicle without_lever(Vehicle v) {
    v.centre_of_mass = v.imu_station = 0;
    return v;
  }
  [[nodiscard]] Quaterniond attitude(double t) const {
    return earth::exp_rotation({0, 0, earth::wgs84::kEarthRate * t}) * program_.reference(t);
  }

  Plant plant_;
  const AttitudeControl& program_;
  Burn::Piece piece_{};
};

}  // namespace

FlightRecord fly_point_mass(const Flight& flight, const AttitudeControl& program, double step) {
  flight.vehicle.check();
  const double duration = std::isnan(flight.duration) ? flight.vehicle.burn_time : flight.duration;
  if (!(step > 0) || !(duration > 0) || !(duration / step < 1e8))
    throw SetupError(
        fmt::format("step {} s and duration {} s must be positive, and fewer than 1e8 steps", step, duration));
  PointMass mass(flight, program);
  odeint::runge_kutta4<X, double, X, double, odeint::vector_space_algebra> stepper;
  const BodyState pad = on_pad(flight.world.site, flight.azimuth, flight.pitch);
  X x;
  x << pad.p_ib_i, pad.v_ib_i;
  FlightRecord result;
  double t = 0;
  std::vector<double> ends = mass.breaks();
  ends.push_back(duration);
  std::sort(ends.begin(), ends.end());
  result.work.method = Method::runge_kutta4;
  for (const double end : ends) {
    const double from = t, length = std::min(end, duration) - from;
    const auto steps = static_cast<int>(std::ceil(length / step - 1e-9));
    if (length <= 0 || result.ended != Ended::complete) continue;
    mass.enter(from, from + length);
    for (int k = 0; k < steps && result.ended == Ended::complete; ++k) {
      result.points.push_back(mass.point(x, t));
      stepper.do_step(std::cref(mass), x, t, length / steps);
      t = k + 1 == steps ? from + length : from + (k + 1) * (length / steps);
      if (height_of(x.head<3>()).above_ellipsoid < flight.world.site.height - kBelowPad) result.ended = Ended::impact;
    }
    result.work.steps += steps;
  }
  result.work.evaluations = 4 * result.work.steps;
  result.end = mass.point(x, t);
  result.points.push_back(result.end);
  for (const FlightPoint& p : result.points)
    result.highest_pressure = std::max(result.highest_pressure, p.flow.dynamic_pressure);
  result.account = fmt::format("a point mass {} at {:.2f} s, {:.1f} m high",
                               result.ended == Ended::complete ? "flew to the end" : "came down to the pad's height", t,
                               result.end.flow.height);
  return result;
}

}  // namespace gyrobudget::inline v0::flight

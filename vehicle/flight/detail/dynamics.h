// SPDX-License-Identifier: MIT
// The equations of motion, for body.cpp alone.
#pragma once

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"
#include "gyrobudget/vehicle/flight/body.h"

#include <cmath>
#include <cstddef>
#include <numbers>

#include "burn.h"
#include "height.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::flight::detail {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// What stays the same over a flight.
struct Plant {
  Plant(const Vehicle& v, const World& w, const Faults& f)
      : vehicle(v),
        world(w),
        faults(f),
        burn(vehicle, f.thrust_cut_at),
        windy(!w.wind.calm()),
        C_e_enu(earth::C_e_enu(w.site.latitude, w.site.longitude)) {}

  Vehicle vehicle;
  World world;
  Faults faults;
  Burn burn;
  bool windy;
  Matrix3d C_e_enu;
};

/// What stays the same over a segment, in which everything is smooth.
struct Segment {
  Burn::Piece burn;
  int layer;  ///< of the atmosphere
  Vector2d command;
  double roll_moment;
  // The actuator where it is not integrated: deflection = offset + slope (t - start).
  Vector2d offset = Vector2d::Zero();
  Vector2d slope = Vector2d::Zero();
  double start = 0;
};

struct RigidState {
  Vector3d p, v;
  Quaterniond q;  ///< of any norm near 1
  Vector3d w;
};

/// Air about the body.
struct Stream {
  double height = 0;
  Air air;
  Vector3d velocity_b = Vector3d::Zero();  ///< of the body against the air
  double speed = 0;
};

inline Stream stream(const Plant& plant, int layer, double t, const RigidState& s, const Matrix3d& C_ib) {
  const Height height = height_of(s.p);
  Stream result{height.above_ellipsoid, standard_atmosphere::at(height.above_ellipsoid, layer)};
  Vector3d relative = s.v - Vector3d(-s.p.y(), s.p.x(), 0) * earth::wgs84::kEarthRate;
  if (plant.windy) {
    const Vector3d wind_e = plant.C_e_enu * plant.world.wind.at(result.height);
    relative -= earth::Inertial().C_ie(t) * wind_e;
  }
  result.velocity_b = C_ib.transpose() * relative;
  result.speed = relative.norm();
  return result;
}

/// Everything that acts, and what comes of it.
struct Motion {
  Vector3d acceleration_i;
  Vector3d angular_acceleration;
  Vector3d f_imu_b;  ///< specific force at the IMU, in rigid body axes
  double thrust;     ///< less back-pressure
  Vector2d lateral;  ///< force of the nozzle per mass that drives bending, pitch and yaw [m/s^2]
};

inline double net_thrust(const Plant& plant, double vacuum, double pressure) {
  if (vacuum <= 0) return 0;
  const Vehicle& v = plant.vehicle;
  const double full = 1 - std::exp(-vacuum / (0.1 * v.mean_thrust()));
  return std::max(vacuum - v.exit_area * pressure * full, 0.0);
}

inline Motion motion(const Plant& plant, const Segment& segment, double t, const RigidState& s,
                     const Vector2d& deflection, Stream* seen = nullptr) {
  const Vehicle& v = plant.vehicle;
  const Matrix3d C_ib = s.q.normalized().toRotationMatrix();
  const Burn::Now now = plant.burn.at(t, segment.burn);
  Motion m;
  Vector3d force = Vector3d::Zero(), moment(segment.roll_moment, 0, 0);
  double pressure = 0;
  if (plant.world.atmosphere && segment.layer < standard_atmosphere::kLayers) {
    const Stream air = stream(plant, segment.layer, t, s, C_ib);
    pressure = air.air.pressure;
    const double axial = 0.5 * air.air.density * air.speed * air.speed * v.reference_area *
                         v.axial_drag(air.speed / air.air.speed_of_sound);
    const double lateral = 0.5 * air.air.density * air.speed * v.reference_area * v.normal_force_slope;
    const Vector3d aero(-axial, -lateral * air.velocity_b.y(), -lateral * air.velocity_b.z());
    force += aero;
    moment += Vector3d(0, -v.pressure_ahead * aero.z(), v.pressure_ahead * aero.y());
    if (seen) *seen = air;
  } else if (seen) {
    *seen = stream(plant, standard_atmosphere::kLayers, t, s, C_ib);
  }
  m.thrust = net_thrust(plant, now.thrust, pressure);
  const Vector2d& off = plant.faults.thrust_misalignment;
  const double down = std::sin(deflection[0] + off[0]), left = std::sin(deflection[1] + off[1]);
  const double along = std::sqrt(std::max(0.0, 1 - down * down - left * left));
  force += m.thrust * Vector3d(along, -left, down);
  moment += m.thrust * now.centre_of_mass * Vector3d(0, down, left);
  m.lateral = m.thrust / now.mass * Vector2d(down, left);

  const Vector3d inertia(v.roll_inertia(now.used), v.pitch_inertia(now.used), v.yaw_inertia(now.used));
  m.angular_acceleration = (moment - s.w.cross(inertia.cwiseProduct(s.w))).cwiseQuotient(inertia);
  const Vector3d gravitation = earth::normal_gravitation(s.p);  // symmetric about the axis: i as e
  const Vector3d f = force / now.mass;
  m.acceleration_i = C_ib * f + gravitation;

  const Vector3d r(v.imu_station - now.centre_of_mass, 0, 0);
  m.f_imu_b = f;
  if (r.x() != 0) {
    const Vector3d r_rate(-now.cm_velocity, 0, 0);
    m.f_imu_b += m.angular_acceleration.cross(r) + s.w.cross(s.w.cross(r)) + 2 * s.w.cross(r_rate) -
                 Vector3d(now.cm_acceleration, 0, 0) +
                 C_ib.transpose() * (gravitation - earth::normal_gravitation(s.p + C_ib * r));
  }
  return m;
}

/// Rotation vector of the IMU against the rigid body, and its rate.
inline Vector3d bent(const Vehicle& v, const Vector2d& bend) {
  return v.bending ? Vector3d(0, v.bending->slope_at_imu * bend[0], v.bending->slope_at_imu * bend[1])
                   : Vector3d(Vector3d::Zero());
}
/// Angular rate of the IMU in its own axes: R^T w + (a' - a x a'/2 + a x (a x a')/6), R = exp(a); what is
/// left out is below |a|^3 |a'|/24.
inline Vector3d bent_rate(const Vector3d& w, const Vector3d& a, const Vector3d& a_rate) {
  return earth::exp_rotation(-a) * w + a_rate - a.cross(a_rate) / 2 + a.cross(a.cross(a_rate)) / 6;
}

/// State vector: p, v, q (x y z w), w, integrals of rate and specific force of the IMU; then, as asked,
/// deflections and their rates, bending and its rates, each (pitch, yaw).
template <bool kActuator, bool kBending>
struct Dynamics {
  static constexpr int kP = 0, kV = 3, kQ = 6, kW = 10, kAngle = 13, kVelocity = 16, kDeflection = 19;
  static constexpr int kBend = kActuator ? 23 : 19;
  static constexpr int kSize = 19 + (kActuator ? 4 : 0) + (kBending ? 4 : 0);
  using X = Eigen::Matrix<double, kSize, 1>;

  const Plant& plant;
  const Segment& segment;

  [[nodiscard]] static RigidState rigid(const X& x) {
    return {x.template segment<3>(kP), x.template segment<3>(kV), Quaterniond(x.template segment<4>(kQ)),
            x.template segment<3>(kW)};
  }

  void operator()(const X& x, X& rate, double t) const {
    const RigidState s = rigid(x);
    Vector2d deflection = segment.offset + segment.slope * (t - segment.start);
    if constexpr (kActuator) deflection = x.template segment<2>(kDeflection);
    const Motion m = motion(plant, segment, t, s, deflection);
    rate.template segment<3>(kP) = s.v;
    rate.template segment<3>(kV) = m.acceleration_i;
    rate.template segment<4>(kQ) = 0.5 * (s.q * Quaterniond(0, s.w.x(), s.w.y(), s.w.z())).coeffs();
    rate.template segment<3>(kW) = m.angular_acceleration;
    rate.template segment<3>(kAngle) = s.w;
    rate.template segment<3>(kVelocity) = m.f_imu_b;
    if constexpr (kActuator) {
      const double w = 2 * std::numbers::pi * plant.vehicle.actuator.frequency;
      const Vector2d speed = x.template segment<2>(kDeflection + 2);
      rate.template segment<2>(kDeflection) = speed;
      rate.template segment<2>(kDeflection + 2) =
          w * w * (segment.command - deflection) - 2 * plant.vehicle.actuator.damping * w * speed;
    }
    if constexpr (kBending) {
      const Bending& mode = *plant.vehicle.bending;
      const double w = 2 * std::numbers::pi * mode.frequency(t / plant.vehicle.burn_time);
      const Vector2d bend = x.template segment<2>(kBend), speed = x.template segment<2>(kBend + 2);
      rate.template segment<2>(kBend) = speed;
      rate.template segment<2>(kBend + 2) =
          mode.gimbal_deflection * m.lateral - 2 * mode.damping * w * speed - w * w * bend;
      const Vector3d a = bent(plant.vehicle, bend);
      rate.template segment<3>(kAngle) = bent_rate(s.w, a, bent(plant.vehicle, speed));
      rate.template segment<3>(kVelocity) = earth::exp_rotation(-a) * m.f_imu_b;
    }
  }

  [[nodiscard]] static X pack(const BodyState& b, const noise::ImuIncrement& sum) {
    X x;
    x.template segment<3>(kP) = b.p_ib_i;
    x.template segment<3>(kV) = b.v_ib_i;
    x.template segment<4>(kQ) = b.q_ib.coeffs();
    x.template segment<3>(kW) = b.w_ib_b;
    x.template segment<3>(kAngle) = earth::vector(sum.angle);
    x.template segment<3>(kVelocity) = earth::vector(sum.velocity);
    if constexpr (kActuator) x.template segment<4>(kDeflection) << b.deflection, b.deflection_rate;
    if constexpr (kBending) x.template segment<4>(kBend) << b.bend, b.bend_rate;
    return x;
  }
  static void unpack(const X& x, BodyState& b, noise::ImuIncrement& sum) {
    b.p_ib_i = x.template segment<3>(kP);
    b.v_ib_i = x.template segment<3>(kV);
    b.q_ib = Quaterniond(x.template segment<4>(kQ)).normalized();
    b.w_ib_b = x.template segment<3>(kW);
    earth::vector(sum.angle) = x.template segment<3>(kAngle);
    earth::vector(sum.velocity) = x.template segment<3>(kVelocity);
    if constexpr (kActuator) {
      b.deflection = x.template segment<2>(kDeflection);
      b.deflection_rate = x.template segment<2>(kDeflection + 2);
    }
    if constexpr (kBending) {
      b.bend = x.template segment<2>(kBend);
      b.bend_rate = x.template segment<2>(kBend + 2);
    }
  }
  /// Typical sizes, against which errors are judged.
  [[nodiscard]] X scale() const {
    X s;
    s.template segment<6>(kP).setConstant(1e3);
    s.template segment<7>(kQ).setOnes();
    s.template segment<6>(kAngle) << 1, 1, 1, 1e3, 1e3, 1e3;
    if constexpr (kActuator) {
      const double w = 2 * std::numbers::pi * plant.vehicle.actuator.frequency;
      s.template segment<4>(kDeflection) << 0.1, 0.1, 0.1 * w, 0.1 * w;
    }
    if constexpr (kBending) s.template segment<4>(kBend) << 0.01, 0.01, 0.5, 0.5;
    return s;
  }
};

}  // namespace gyrobudget::inline v0::flight::detail

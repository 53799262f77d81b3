// SPDX-License-Identifier: MIT
// Paths are written as poses of time, p(t) and q(t), over Taylor numbers of second order: velocity,
// acceleration and angular rate are their exact derivatives (Boost's automatic differentiation), not a second
// set of formulas.
#include "paths.h"

#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/detail/check.h"

#include <boost/math/differentiation/autodiff.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "frames.h"

namespace gyrobudget::inline v0::earth {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double kSlowest = 1e-2;  // [rad/s]; faster than Earth's rate and any track along it

/// A number and its first two derivatives by time.
using Taylor = boost::math::differentiation::autodiff_fvar<double, 2>;
using TaylorVector = std::array<Taylor, 3>;

struct TaylorQuaternion {
  Taylor w, x, y, z;
};

TaylorQuaternion operator*(const TaylorQuaternion& a, const TaylorQuaternion& b) {
  return {a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
          a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

TaylorQuaternion constant(const Quaterniond& q) { return {Taylor(q.w()), Taylor(q.x()), Taylor(q.y()), Taylor(q.z())}; }

/// Rotation by `angle` about a fixed axis.
TaylorQuaternion turn(const Taylor& angle, const Vector3d& axis) {
  const Taylor half = angle / 2;
  const Taylor s = sin(half);
  return {cos(half), s * axis.x(), s * axis.y(), s * axis.z()};
}

TaylorVector y_axis(const TaylorQuaternion& q) {
  return {2 * (q.x * q.y - q.w * q.z), q.w * q.w - q.x * q.x + q.y * q.y - q.z * q.z, 2 * (q.y * q.z + q.w * q.x)};
}

TaylorVector z_axis(const TaylorQuaternion& q) {
  return {2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), q.w * q.w - q.x * q.x - q.y * q.y + q.z * q.z};
}

/// The point at that height whose down is the z axis of q_en: a D n/(n' D n)^(1/2) + h n, D = diag(1, 1, 1 -
/// e^2).
TaylorVector point_of_normal(const TaylorQuaternion& q_en, double height) {
  const TaylorVector down = z_axis(q_en);
  const Taylor norm = sqrt(down[0] * down[0] + down[1] * down[1] + wgs84::kAxisRatioSquared * down[2] * down[2]);
  const Taylor level = -wgs84::kEquatorialRadius / norm;
  return {(level - height) * down[0], (level - height) * down[1],
          (wgs84::kAxisRatioSquared * level - height) * down[2]};
}

/// Of time. p_eb_e is p_fixed + p: for bodies that stay, the large constant is kept out of the arithmetic.
struct TaylorPose {
  TaylorVector p;
  TaylorQuaternion q_eb;
};

void vibrate(const Vibration& v, const Taylor& t, TaylorPose& pose) {
  if (v.sculling_frequency > 0) {
    const double w = 2 * pi * v.sculling_frequency;
    const Taylor wave = sin(w * t);
    const TaylorVector y = y_axis(pose.q_eb);
    for (std::size_t k = 0; k < 3; ++k) pose.p[k] += v.sculling_acceleration / (w * w) * wave * y[k];
    pose.q_eb = pose.q_eb * turn(v.sculling_angle * wave, Vector3d::UnitX());
  }
  if (v.coning_frequency > 0) {
    const Taylor phase = 2 * pi * v.coning_frequency * t;
    const double s = std::sin(v.coning_angle / 2);
    pose.q_eb =
        pose.q_eb * TaylorQuaternion{Taylor(std::cos(v.coning_angle / 2)), Taylor(0.0), s * cos(phase), s * sin(phase)};
  }
}

double vibration_frequency(const Vibration& v) { return 2 * pi * (v.coning_frequency + v.sculling_frequency); }

Motion motion(const Vector3d& p_fixed, const TaylorPose& pose) {
  const auto order = [](const TaylorVector& p, std::size_t n) {
    return Vector3d(p[0].derivative(n), p[1].derivative(n), p[2].derivative(n));
  };
  const auto quaternion = [&](std::size_t n) {
    const TaylorQuaternion& q = pose.q_eb;
    return Quaterniond(q.w.derivative(n), q.x.derivative(n), q.y.derivative(n), q.z.derivative(n));
  };
  const Quaterniond q = quaternion(0).normalized();
  // dq/dt = q (0, w_eb_b)/2
  return {.pose = {.p_eb_e = p_fixed + order(pose.p, 0), .v_eb_e = order(pose.p, 1), .q_eb = q},
          .a_eb_e = order(pose.p, 2),
          .w_eb_b = 2 * (q.conjugate() * quaternion(1)).vec()};
}

/// A pose function, vibration on top.
template <typename PoseOfTime>
class PosePath final : public Path {
 public:
  PosePath(double duration, double fastest, const Vector3d& p_fixed, const Vibration& vibration, PoseOfTime pose)
      : duration_(duration), fastest_(fastest), p_fixed_(p_fixed), vibration_(vibration), pose_(std::move(pose)) {}

  [[nodiscard]] double duration() const override { return duration_; }
  [[nodiscard]] double fastest() const override { return fastest_; }
  [[nodiscard]] Motion at(double t) const override {
    const auto time = boost::math::differentiation::make_fvar<double, 2>(t);
    TaylorPose pose = pose_(time);
    vibrate(vibration_, time, pose);
    return motion(p_fixed_, pose);
  }

 private:
  double duration_;
  double fastest_;
  Vector3d p_fixed_;
  Vibration vibration_;
  PoseOfTime pose_;
};

template <typename PoseOfTime>
Trajectory trajectory(double duration, double fastest, const Vector3d& p_fixed, const Vibration& vibration,
                      PoseOfTime pose) {
  return Trajectory(std::make_shared<PosePath<PoseOfTime>>(
      duration, std::max(fastest, kSlowest) + vibration_frequency(vibration), p_fixed, vibration, std::move(pose)));
}

void check(const Vibration& v) {
  detail::check_finite(v.coning_angle, "coning angle", "rad");
  detail::check_not_negative(v.coning_frequency, "coning frequency", "Hz");
  detail::check_finite(v.sculling_angle, "sculling angle", "rad");
  detail::check_finite(v.sculling_acceleration, "sculling acceleration", "m/s^2");
  detail::check_not_negative(v.sculling_frequency, "sculling frequency", "Hz");
}

Quaterniond q_en(const Geodetic& g) { return Quaterniond(C_e_ned(g.latitude, g.longitude)); }

}  // namespace

Trajectory stand(const Stand& options) {
  detail::check_position(options.position);
  detail::check_unit(options.q_nb, "attitude q_nb");
  detail::check_finite(options.spin.squaredNorm(), "squared spin", "rad^2/s^2");
  check(options.vibration);
  const double rate = options.spin.norm();
  const Vector3d axis = rate > 0 ? Vector3d(options.spin / rate) : Vector3d::UnitX();
  const TaylorQuaternion start = constant(q_en(options.position) * options.q_nb);
  return trajectory(options.duration, rate, to_ecef(options.position), options.vibration, [=](const Taylor& t) {
    return TaylorPose{{}, start * turn(rate * t, axis)};
  });
}

Trajectory cruise(const Cruise& options) {
  detail::check_position(options.start);
  detail::check_finite(options.azimuth, "azimuth", "rad");
  detail::check_not_negative(options.speed, "speed", "m/s");
  detail::check_finite(options.turn_acceleration, "acceleration of the S-turns", "m/s^2");
  check(options.vibration);
  const bool turns = options.turn_acceleration != 0;
  if (turns) {
    detail::check_positive(options.speed, "speed of S-turns", "m/s");
    detail::check_positive(options.turn_period, "period of the S-turns", "s");
  }
  // On the unit sphere of normals the centre line runs at `rate`, and the S-turns sway by `sway` to the left
  // of it.
  const double radius =
      std::hypot((meridian_radius(options.start.latitude) + options.start.height) * std::cos(options.azimuth),
                 (transverse_radius(options.start.latitude) + options.start.height) * std::sin(options.azimuth));
  const double rate = options.speed / radius;
  const double w = turns ? 2 * pi / options.turn_period : 0;
  const double sway = turns ? -options.turn_acceleration / (w * w) / radius : 0;
  const double tangent = options.turn_acceleration / noise::kStandardGravity;
  const TaylorQuaternion start = constant(q_en(options.start) * exp_rotation({0, 0, options.azimuth}));
  return trajectory(options.duration, 4 * w, Vector3d::Zero(), options.vibration, [=](const Taylor& t) {
    TaylorQuaternion level = start * turn(-rate * t, Vector3d::UnitY());
    if (!turns) return TaylorPose{point_of_normal(level, options.start.height), level};
    const Taylor side = sway * sin(w * t);
    const Taylor heading = atan(sway * w * cos(w * t) / (rate * cos(side)));
    level = level * turn(-side, Vector3d::UnitX()) * turn(-heading, Vector3d::UnitZ());
    const Taylor bank = -atan(tangent * sin(w * t));
    return TaylorPose{point_of_normal(level, options.start.height), level * turn(bank, Vector3d::UnitX())};
  });
}

Trajectory climb(const Climb& options) {
  detail::check_position(options.site);
  detail::check_finite(options.azimuth, "azimuth", "rad");
  detail::check_finite(options.acceleration, "acceleration", "m/s^2");
  check(options.vibration);
  const Vector3d up = up_e(options.site.latitude, options.site.longitude);
  const TaylorQuaternion attitude = constant(q_en(options.site) * from_euler({options.azimuth, pi / 2, 0}));
  return trajectory(options.duration, 0, to_ecef(options.site), options.vibration, [=](const Taylor& t) {
    const Taylor height = options.acceleration / 2 * t * t;
    return TaylorPose{{height * up.x(), height * up.y(), height * up.z()}, attitude};
  });
}

}  // namespace gyrobudget::inline v0::earth

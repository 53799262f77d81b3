// SPDX-License-Identifier: MIT
// A step is made in inertial axes that are those of e at its start: there the sensors' part (attitude, velocity
// and position gained) is one exponential, Earth's part is gravitation alone, and turning back to the axes of
// e at the end is exact, so that there is no Coriolis term to approximate.
#include "gyrobudget/navigation/strapdown.h"

#include "gyrobudget/earth/gravity.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

using earth::wgs84::kEarthRate;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kSteady = 4;  // an interval this many times another is of another sampling

/// Element of the algebra whose group holds attitude, velocity and position together: with
///   X = [C v p; 0 1 t; 0 0 1],  X' = X [w x, f, s; 0 0 r; 0 0 0],
/// r = 1 and s = 0, the group's X' = X A says C' = C [w x], v' = C f, p' = v, t' = 1.
struct Twist {
  Vector3d w;  ///< turn
  Vector3d f;  ///< velocity
  Vector3d s = Vector3d::Zero();
  double r = 0;  ///< time

  friend Twist operator+(const Twist& a, const Twist& b) {
    return {a.w + b.w, a.f + b.f, a.s + b.s, a.r + b.r};
  }
  friend Twist operator-(const Twist& a, const Twist& b) {
    return {a.w - b.w, a.f - b.f, a.s - b.s, a.r - b.r};
  }
  friend Twist operator*(double k, const Twist& a) { return {k * a.w, k * a.f, k * a.s, k * a.r}; }
};

/// AB - BA: coning in w, sculling in f, scrolling in s.
Twist commutator(const Twist& a, const Twist& b) {
  return {a.w.cross(b.w), a.w.cross(b.f) - b.w.cross(a.f),
          a.w.cross(b.s) - b.w.cross(a.s) + b.r * a.f - a.r * b.f, 0};
}

/// Attitude, velocity and position gained over a step in the axes of its start.
struct Gain {
  Quaterniond q;
  Vector3d v;
  Vector3d p;
};

/// c3 = (x - sin x)/x^3, c4 = (cos x - 1 + x^2/2)/x^4, half-angle cos(x/2) and sin(x/2)/x.
struct Coefficients {
  double cos_half, sin_half, c3, c4;
};

/// 1/first! - x2/(first + 2)! + ..., nine terms: to rounding for x2 up to 1.
template <int first>
double alternating(double x2) {
  double sum = 1;
  for (int k = 8; k > 0; --k) sum = 1 - x2 / ((first + 2 * k) * (first + 2 * k - 1)) * sum;
  constexpr double factorial[] = {1, 1, 2, 6, 24};
  return sum / factorial[first];
}

Coefficients coefficients(double x2) {
  if (x2 < 1)
    return {alternating<0>(x2 / 4), alternating<1>(x2 / 4) / 2, alternating<3>(x2), alternating<4>(x2)};
  const double x = std::sqrt(x2);
  const double s = std::sin(x / 2);
  const double c = std::cos(x / 2);
  return {c, s / x, (x - 2 * s * c) / (x * x2), (x2 / 2 - 2 * s * s) / (x2 * x2)};
}

/// exp of the 5 x 5 matrix: v = J f, p = J s + r K f, with J = 1 + c2 [w x] + c3 [w x]^2 and K = 1/2 + c3 [w x] +
/// c4 [w x]^2. Exact for rates and specific forces that are constant in body axes, at any angle.
Gain exponential(const Twist& a) {
  const double x2 = a.w.squaredNorm();
  const Coefficients c = coefficients(x2);
  const double c2 = 0.5 - x2 * c.c4;
  const Vector3d wf = a.w.cross(a.f);
  const Vector3d ws = a.w.cross(a.s);
  const Vector3d wwf = a.w.cross(wf);
  Gain gain;
  gain.q.w() = c.cos_half;
  gain.q.vec() = c.sin_half * a.w;
  gain.v = a.f + c2 * wf + c.c3 * wwf;
  gain.p = a.s + c2 * ws + c.c3 * a.w.cross(ws) + a.r * (0.5 * a.f + c.c3 * wf + c.c4 * wwf);
  return gain;
}

/// Legendre coefficients over the step, times its length, of the polynomial through the history.
using Rates = Eigen::Matrix<double, 6, 1>;
struct Shape {
  Rates x1 = Rates::Zero();
  Rates x2 = Rates::Zero();
  Rates x3 = Rates::Zero();
};

Twist twist(const Rates& x) { return {x.head<3>(), x.tail<3>()}; }

/// Gauss quadrature with weight 1 - u^2 on [-1, 1], exact to degree 9: the inner nodes of Lobatto's seven.
struct Quadrature {
  std::array<double, 5> u{-0.830223896278566930, -0.468848793470714214, 0, 0.468848793470714214,
                          0.830223896278566930};
  std::array<double, 5> w1{}, w2{}, w3{};  ///< weights of 3/4, 15/4 u and 21/8 (5 u^2 - 1)
  constexpr Quadrature() {
    constexpr double lobatto[] = {0.276826047361565949, 0.431745381209862623, 0.487619047619047619,
                                  0.431745381209862623, 0.276826047361565949};
    for (std::size_t i = 0; i < 5; ++i) {
      const double w = lobatto[i] * (1 - u[i] * u[i]);
      w1[i] = 0.75 * w;
      w2[i] = 3.75 * w * u[i];
      w3[i] = 2.625 * w * (5 * u[i] * u[i] - 1);
    }
  }
};
constexpr Quadrature kQuadrature;

/// The integral F of the rates is Newton's polynomial through the ends of the intervals,
///   F(t) = sum E_m N_m(t),  N_m = (s^2 - h^2/4) prod_(i<m) (s + C_i),  s = t - h/2, C_i = h/2 + age of node i,
/// and h b_k = -(2k + 1) times the integral of F P_k' over [-1, 1] are the Legendre coefficients.
template <std::size_t n>
Shape shape(const std::array<Rates, n>& differences, const std::array<double, n>& intervals, int known) {
  Shape x;
  const double h = intervals[0];
  std::array<double, 5> product;
  product.fill(h * h);
  double age = h / 2;
  for (std::size_t m = 1; m < static_cast<std::size_t>(known); ++m) {
    double a1 = 0, a2 = 0, a3 = 0;
    for (std::size_t i = 0; i < 5; ++i) {
      a1 += kQuadrature.w1[i] * product[i];
      a2 += kQuadrature.w2[i] * product[i];
      a3 += kQuadrature.w3[i] * product[i];
    }
    x.x1 += a1 * differences[m];
    x.x2 += a2 * differences[m];
    x.x3 += a3 * differences[m];
    age += intervals[m];
    for (std::size_t i = 0; i < 5; ++i) product[i] *= h / 2 * kQuadrature.u[i] + age;
  }
  return x;
}

/// Magnus' series for X' = X A, A = x0 + x1 P_1 + x2 P_2 + x3 P_3 over a step: local error h^5 for two
/// coefficients and h^7 for all.
Twist magnus(const Twist& x0, const Shape& shape, int order) {
  if (order == 1) return x0;
  const Twist x1 = twist(shape.x1);
  const Twist y = commutator(x0, x1);
  if (order < 4) return x0 + (1 / 6.0) * y;
  const Twist x2 = twist(shape.x2);
  const Twist inner = commutator(x0, x2 - (1 / 6.0) * y);
  Twist sum = x0 + (1 / 6.0) * y + (1 / 60.0) * (commutator(x1, 2 * x2 - y) + commutator(x0, inner));
  if (order > 5) sum = sum + (1 / 70.0) * commutator(x2, twist(shape.x3));
  return sum;
}

/// Earth's turn over a step.
struct Turn {
  double cos_half, sin_half, cos, sin;
  /// exp(-i a)(1 + i a) - 1: where a point goes, as seen from Earth, that moves straight on for an angle a.
  double radial, along;
};

Turn earth_turn(double dt) {
  const double a = kEarthRate * dt;
  const double a2 = a * a;
  Turn turn{};
  turn.cos_half = std::abs(a) < 0.01 ? 1 - a2 / 8 * (1 - a2 / 48) : std::cos(a / 2);
  turn.sin_half = std::abs(a) < 0.01 ? a / 2 * (1 - a2 / 24 * (1 - a2 / 80)) : std::sin(a / 2);
  turn.cos = 1 - 2 * turn.sin_half * turn.sin_half;
  turn.sin = 2 * turn.sin_half * turn.cos_half;
  if (std::abs(a) < 0.01) {
    turn.radial = a2 / 2 * (1 - a2 / 4);
    turn.along = -a * a2 / 3 * (1 - a2 / 10);
  } else {
    turn.radial = turn.cos + a * turn.sin - 1;
    turn.along = a * turn.cos - turn.sin;
  }
  return turn;
}

/// To axes that have turned on with Earth.
Vector3d turned_back(const Turn& turn, const Vector3d& x) {
  return {turn.cos * x.x() + turn.sin * x.y(), turn.cos * x.y() - turn.sin * x.x(), x.z()};
}

Quaterniond turned_back(const Turn& turn, const Quaterniond& q) {
  const double c = turn.cos_half;
  const double s = turn.sin_half;
  return {c * q.w() + s * q.z(), c * q.x() + s * q.y(), c * q.y() - s * q.x(), c * q.z() - s * q.w()};
}

/// w_ie x x
Vector3d earth_rate_cross(const Vector3d& x) { return {-kEarthRate * x.y(), kEarthRate * x.x(), 0}; }

void check(const earth::ImuIncrement& increment) {
  if (!increment.velocity.allFinite() || !increment.angle.allFinite())
    throw std::invalid_argument(
        fmt::format("IMU increment of velocity ({}, {}, {}) m/s and angle ({}, {}, {}) rad must be finite",
                    increment.velocity.x(), increment.velocity.y(), increment.velocity.z(),
                    increment.angle.x(), increment.angle.y(), increment.angle.z()));
}

void check(const NavigationState& state) {
  if (!state.v_eb_e.allFinite())
    throw std::invalid_argument(fmt::format("velocity ({}, {}, {}) m/s must be finite", state.v_eb_e.x(),
                                            state.v_eb_e.y(), state.v_eb_e.z()));
  if (!(std::abs(state.q_eb.norm() - 1) <= 1e-6))
    throw std::invalid_argument(
        fmt::format("norm {} of the quaternion q_eb must be 1 to 1e-6", state.q_eb.norm()));
}

}  // namespace

Strapdown::Strapdown(const NavigationState& state, const Options& options) : options_(options) {
  if (options.order < 1 || options.order > kHighestOrder)
    throw std::invalid_argument(
        fmt::format("order {} of the strapdown must be from 1 to {}", options.order, kHighestOrder));
  set_state(state);
}

void Strapdown::set_state(const NavigationState& state) {
  check(state);
  gravitation_ = earth::normal_gravitation(state.p_eb_e);
  state_ = state;
  state_.q_eb.normalize();
  p_rest_.setZero();
}

void Strapdown::step(const earth::ImuIncrement& increment, double dt) {
  if (!(dt >= 0) || !std::isfinite(dt))
    throw std::invalid_argument(
        fmt::format("interval {} s of a strapdown step must be finite, not negative", dt));
  if (dt == 0) return;
  check(increment);
  const auto& [p0, v0, q0] = state_;
  remember(increment, dt);
  const Twist x0{increment.angle, increment.velocity, Vector3d::Zero(), dt};
  const Gain gain = exponential(magnus(x0, shape(differences_, intervals_, known_), known_));

  const Eigen::Matrix3d C_eb = q0.toRotationMatrix();
  const Vector3d sensed = C_eb * gain.v;
  // Gravitation amid the step, and its slope along the way as that of a point mass.
  const Vector3d v_ib = v0 + earth_rate_cross(p0);
  const Vector3d g = earth::normal_gravitation(p0 + dt / 2 * v_ib + dt / 8 * (sensed + dt * gravitation_));
  const double r2 = p0.squaredNorm();
  const Vector3d slope = -g.dot(p0) / r2 * (3 * p0.dot(v_ib) / r2 * p0 - v_ib);
  const Vector3d v_gained = sensed + dt * g;
  const Vector3d p_gained = dt * v0 + C_eb * gain.p + dt * dt / 2 * g - dt * dt * dt / 12 * slope;

  // p1 = R(-a) (p0 + dt w_ie x p0 + p_gained), v1 = R(-a) (v0 + w_ie x p0 + v_gained) - w_ie x p1, the large parts
  // taken out by hand.
  const Turn turn = earth_turn(dt);
  Vector3d p_step = turned_back(turn, p_gained);
  p_step.x() += turn.radial * p0.x() - turn.along * p0.y();
  p_step.y() += turn.radial * p0.y() + turn.along * p0.x();
  const Vector3d v1 =
      turned_back(turn, v0 + v_gained + dt * earth::centrifugal(p0) - earth_rate_cross(p_gained));
  Quaterniond q1 = q0 * gain.q;
  if (options_.earth_rate_in_attitude) q1 = turned_back(turn, q1);
  q1.coeffs() *= 1.5 - 0.5 * q1.squaredNorm();

  p_step += p_rest_;
  const Vector3d p1 = p0 + p_step;
  p_rest_ = p_step - (p1 - p0);
  state_ = {p1, v1, q1};
  gravitation_ = g;
  specific_force_e_ = sensed / dt;
}

void Strapdown::remember(const earth::ImuIncrement& increment, double dt) {
  if (known_ > 0 && (dt > kSteady * intervals_[0] || kSteady * dt < intervals_[0])) known_ = 0;
  known_ = std::min(known_ + 1, options_.order);
  std::rotate(intervals_.begin(), intervals_.end() - 1, intervals_.end());
  intervals_[0] = dt;
  Rates difference;
  difference << increment.angle / dt, increment.velocity / dt;
  double span = dt;
  for (std::size_t m = 0; m < static_cast<std::size_t>(known_); ++m) {
    std::swap(differences_[m], difference);
    if (m + 1 < intervals_.size()) span += intervals_[m + 1];
    difference = (differences_[m] - difference) / span;
  }
}

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
// A step is made in inertial axes that are those of e at its start: there the sensors' part (attitude,
// velocity and position gained) is one exponential, Earth's part is gravitation alone, and turning back to
// the axes of e at the end is exact, so that there is no Coriolis term to approximate.
#include "strapdown.h"

#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

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
constexpr double kWidest = 1;  // [rad] in a step: what is fixed in space then turns too fast for a polynomial

constexpr int kCurved = 4;   // orders from which x2 and
constexpr int kTwisted = 6;  // x3 are worth their terms

/// Element of the algebra whose group holds attitude, velocity and position together: with
///   X = [C v p; 0 1 t; 0 0 1],  X' = X [w x, f, s; 0 0 r; 0 0 0],
/// r = 1 and s = 0, the group's X' = X A says C' = C [w x], v' = C f, p' = v, t' = 1.
struct Twist {
  Vector3d w;  ///< turn
  Vector3d f;  ///< velocity
  Vector3d s = Vector3d::Zero();
  double r = 0;  ///< time

  friend Twist operator+(const Twist& a, const Twist& b) { return {a.w + b.w, a.f + b.f, a.s + b.s, a.r + b.r}; }
  friend Twist operator*(double k, const Twist& a) { return {k * a.w, k * a.f, k * a.s, k * a.r}; }
};

/// AB - BA for a.s = 0 and b.r = 0, as they are here: coning in w, sculling in f, scrolling in s.
Twist commutator(const Twist& a, const Twist& b) {
  return {a.w.cross(b.w), a.w.cross(b.f) + a.f.cross(b.w), a.w.cross(b.s) - a.r * b.f};
}

/// Attitude, velocity and position gained over a step in the axes of its start.
struct Gain {
  Quaterniond q_less_1;
  Vector3d v;
  Vector3d p;
};

/// What an exponential is made of, x being the angle: cos(x/2) - 1, sin(x/2)/x, c3 = (x - sin x)/x^3 and
/// c4 = (cos x - 1 + x^2/2)/x^4.
struct Coefficients {
  double cos_half_less_1, sin_half, c3, c4;
};

/// 1/n! - x2/(n + 2)! + x2^2/(n + 4)! - ...
template <int n, std::size_t terms>
double alternating(double x2) {
  static constexpr auto kInverse = [] {
    std::array<double, terms> inverse{};
    double factorial = 1;
    for (int k = 2; k <= n; ++k) factorial *= k;
    int next = n;
    for (double& value : inverse) {
      value = 1 / factorial;
      factorial *= -(next + 1) * (next + 2);
      next += 2;
    }
    return inverse;
  }();
  double sum = kInverse[terms - 1];
  for (std::size_t k = terms - 1; k-- > 0;) sum = kInverse[k] + x2 * sum;
  return sum;
}

template <std::size_t terms>
Coefficients series(double x2) {
  return {-x2 / 4 * alternating<2, terms>(x2 / 4), alternating<1, terms>(x2 / 4) / 2, alternating<3, terms>(x2),
          alternating<4, terms>(x2)};
}

Coefficients coefficients(double x2) {
  if (x2 < 1e-4) return series<3>(x2);  // each to rounding
  if (x2 < 0.25) return series<7>(x2);
  const double x = std::sqrt(x2);
  const double s = std::sin(x / 2);
  const double c = std::cos(x / 2);
  return {c - 1, s / x, (x - 2 * s * c) / (x * x2), (x2 / 2 - 2 * s * s) / (x2 * x2)};
}

/// exp of the 5 x 5 matrix: v = J f, p = J s + r K f, with J = 1 + c2 [w x] + c3 [w x]^2 and K = 1/2 + c3
/// [w x] + c4 [w x]^2. Exact for rates and specific forces that are constant in body axes, at any angle.
Gain exponential(const Twist& a) {
  const double x2 = a.w.squaredNorm();
  const Coefficients c = coefficients(x2);
  const double c2 = 0.5 - x2 * c.c4;
  const Vector3d wf = a.w.cross(a.f);
  const Vector3d ws = a.w.cross(a.s);
  const Vector3d wwf = a.w.cross(wf);
  Gain gain;
  gain.q_less_1.w() = c.cos_half_less_1;
  gain.q_less_1.vec() = c.sin_half * a.w;
  gain.v = a.f + c2 * wf + c.c3 * wwf;
  gain.p = a.s + c2 * ws + c.c3 * a.w.cross(ws) + a.r * (0.5 * a.f + c.c3 * wf + c.c4 * wwf);
  return gain;
}

/// Gauss quadrature with weight 1 - u^2 on [-1, 1], exact to degree 7: the inner nodes of Lobatto's six,
/// and the weights of 3/4, 15/4 u and 21/8 (5 u^2 - 1).
using Nodes = Eigen::Array4d;
struct Quadrature {
  using Values = std::array<double, 4>;
  Values u{-0.765055323929464693, -0.285231516480645096, 0.285231516480645096, 0.765055323929464693};
  Values w1{}, w2{}, w3{};
  constexpr Quadrature() {
    constexpr Values lobatto{0.378474956297846980, 0.554858377035486353, 0.554858377035486353, 0.378474956297846980};
    for (std::size_t i = 0; i < u.size(); ++i) {
      w1[i] = 0.75 * lobatto[i] * (1 - u[i] * u[i]);
      w2[i] = 5 * u[i] * w1[i];
      w3[i] = 3.5 * (5 * u[i] * u[i] - 1) * w1[i];
    }
  }
};
constexpr Quadrature kQuadrature;

Eigen::Map<const Nodes> nodes(const Quadrature::Values& values) { return Eigen::Map<const Nodes>(values.data()); }

Twist twist(const Eigen::Matrix<double, 6, 1>& x) { return {x.head<3>(), x.tail<3>()}; }

}  // namespace

/// Rates over a step as Legendre polynomials, x0 + x1 P_1 + x2 P_2 + x3 P_3 over its length; x0 is the
/// increment. The integral F of the rates is Newton's polynomial through nodes, the ends of intervals,
/// first the step's own:
///   F = sum E_m N_m,  N_m = (s^2 - h^2/4) prod_(1 < i <= m) (s + C_i),  s from the middle of the step,
/// with divided differences E_m and nodes at s = -C_i. Then x_k = -(2k + 1) times the integral over [-1, 1]
/// of F P_k'.
struct Strapdown::Polynomial {
  Rates x1 = Rates::Zero();
  Rates x2 = Rates::Zero();
  Rates x3 = Rates::Zero();

  Polynomial(double h, int order) : half_(h / 2), product_(Nodes::Constant(h * h)), order_(order) {}

  /// The next difference, and C of the node after those that it is of.
  void add(const Rates& difference, double next) {
    x1 += (nodes(kQuadrature.w1) * product_).sum() * difference;
    if (order_ >= kCurved) x2 += (nodes(kQuadrature.w2) * product_).sum() * difference;
    if (order_ >= kTwisted) x3 += (nodes(kQuadrature.w3) * product_).sum() * difference;
    product_ *= half_ * nodes(kQuadrature.u) + next;
  }

 private:
  double half_;
  Nodes product_;
  int order_;
};

namespace {

/// Magnus' series for X' = X A, A = x0 + x1 P_1 + x2 P_2 + x3 P_3 over a step: local error h^5 for two
/// coefficients and h^7 for all.
template <typename Polynomial>
Twist magnus(const Twist& x0, const Polynomial& polynomial, int order) {
  if (order == 1) return x0;
  const Twist x1 = twist(polynomial.x1);
  const Twist y = commutator(x0, x1);
  if (order < kCurved) return x0 + (1 / 6.0) * y;
  const Twist x2 = twist(polynomial.x2);
  const Twist inner = commutator(x0, x2 + (-1 / 6.0) * y);
  Twist sum = x0 + (1 / 6.0) * y + (1 / 60.0) * (commutator(x1, 2 * x2 + (-1.0) * y) + commutator(x0, inner));
  if (order >= kTwisted) sum = sum + (1 / 70.0) * commutator(x2, twist(polynomial.x3));
  return sum;
}

/// Earth's turn over a step.
struct Turn {
  double cos_half_less_1, sin_half, cos, sin;
  /// exp(-i a)(1 + i a) - 1: where a point goes, as seen from Earth, that moves straight on for an angle a.
  double radial, along;
};

Turn earth_turn(double dt) {
  const double a = kEarthRate * dt;
  const double a2 = a * a;
  const Coefficients c = coefficients(a2);
  Turn turn{};
  turn.cos_half_less_1 = c.cos_half_less_1;
  turn.sin_half = c.sin_half * a;
  turn.cos = 1 - 2 * turn.sin_half * turn.sin_half;
  turn.sin = a - a * a2 * c.c3;
  turn.radial = a2 * (0.5 - a2 * (c.c3 - c.c4));
  turn.along = a * a2 * (c.c3 - 0.5 + a2 * c.c4);
  return turn;
}

/// To axes that have turned on with Earth.
Vector3d turned_back(const Turn& turn, const Vector3d& x) {
  return {turn.cos * x.x() + turn.sin * x.y(), turn.cos * x.y() - turn.sin * x.x(), x.z()};
}

/// What that adds to a quaternion.
Quaterniond added_by(const Turn& turn, const Quaterniond& q) {
  const double c = turn.cos_half_less_1;
  const double s = turn.sin_half;
  return {c * q.w() + s * q.z(), c * q.x() + s * q.y(), c * q.y() - s * q.x(), c * q.z() - s * q.w()};
}

/// w_ie x x
Vector3d earth_rate_cross(const Vector3d& x) { return {-kEarthRate * x.y(), kEarthRate * x.x(), 0}; }

/// Velocity and position that gravitation adds over a step, and its value amid the step.
struct Pull {
  Vector3d v, p, g;
};

/// Gravitation amid the step is taken as it is, its first and second derivative along the way as those of a
/// point mass, g = -k p with k' = -3 k p.v/r^2: what remains of h^2 is 1e-3 of what it would be without them.
Pull gravitation_gained(const Vector3d& p0, const Vector3d& v0, const Vector3d& sensed,
                        const Vector3d& last_gravitation, double h) {
  const Vector3d half_gain = 0.5 * (sensed + h * last_gravitation);
  const Vector3d p = p0 + h / 2 * (v0 + 0.5 * half_gain);
  const Vector3d v = v0 + half_gain;
  const Vector3d g = earth::normal_gravitation(p);
  const Vector3d a = sensed / h + g;
  const double over_r2 = 1 / p.squaredNorm();
  const double k = -g.dot(p) * over_r2;
  const double pv = p.dot(v) * over_r2;
  const Vector3d first = k * (3 * pv * p - v);
  const Vector3d second = k * ((3 * (v.squaredNorm() + p.dot(a)) * over_r2 - 15 * pv * pv) * p + 6 * pv * v - a);
  const Vector3d v_gained = h * (g + h * h / 24 * second);
  return {v_gained, h / 2 * (v_gained - h * h / 6 * first), g};
}

/// Adds with the rest that the sum's last digit leaves, so that a billion small steps are not lost in it.
template <typename Step, typename Sum, typename Rest>
void add(const Step& step, Sum& sum, Rest& rest) {
  const Rest whole = step + rest;
  const Rest before = sum;
  sum += whole;
  rest = whole - (sum - before);
}

void check(const noise::ImuIncrement& increment) {
  const auto &v = increment.velocity, &a = increment.angle;
  if (!earth::vector(v).allFinite() || !earth::vector(a).allFinite())
    throw std::invalid_argument(
        fmt::format("IMU increment of velocity ({}, {}, {}) m/s and angle ({}, {}, {}) rad must be finite", v[0], v[1],
                    v[2], a[0], a[1], a[2]));
}

void check(const earth::Pose& state) {
  if (!state.v_eb_e.allFinite())
    throw std::invalid_argument(
        fmt::format("velocity ({}, {}, {}) m/s must be finite", state.v_eb_e.x(), state.v_eb_e.y(), state.v_eb_e.z()));
  if (!(std::abs(state.q_eb.norm() - 1) <= 1e-6))
    throw std::invalid_argument(fmt::format("norm {} of the quaternion q_eb must be 1 to 1e-6", state.q_eb.norm()));
}

}  // namespace

Strapdown::Strapdown(const earth::Pose& state, const Options& options) : options_(options) {
  if (options.order < 1 || options.order > kHighestOrder)
    throw SetupError(fmt::format("order {} of the strapdown must be from 1 to {}", options.order, kHighestOrder));
  set_state(state);
}

void Strapdown::set_state(const earth::Pose& state) {
  check(state);
  now_ = {.state = state, .gravitation = earth::normal_gravitation(state.p_eb_e)};
  now_.state.q_eb.normalize();
  may_redo_ = false;
}

void Strapdown::step(const noise::ImuIncrement& imu, double dt) {
  if (!(dt >= 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("interval {} s of a strapdown step must be finite, not negative", dt));
  if (dt == 0) return;
  check(imu);
  Increment increment{.dt = dt};
  increment.sum << earth::vector(imu.angle), earth::vector(imu.velocity);
  remember(increment);
  if (may_redo_ && known_ > 1) return redo();

  Polynomial polynomial(dt, known_);
  double age = dt / 2;
  for (std::size_t m = 1; m < static_cast<std::size_t>(known_); ++m) {
    age += intervals_[m];
    polynomial.add(differences_[m], age);
  }
  advance(now_, increment, polynomial);
}

/// Keeps the differences of F over the ends of the last intervals, the last first: each follows from two of
/// one order less.
void Strapdown::remember(const Increment& increment) {
  const double dt = increment.dt;
  if (known_ > 0 && (dt > kSteady * intervals_[0] || kSteady * dt < intervals_[0])) known_ = 0;
  if (known_ == 0) {
    start_ = now_;
    may_redo_ = true;
  } else if (known_ == options_.order) {
    may_redo_ = false;
  }
  if (may_redo_) first_[static_cast<std::size_t>(known_)] = increment;
  known_ = std::min(known_ + 1, options_.order);
  std::rotate(intervals_.begin(), intervals_.end() - 1, intervals_.end());
  intervals_[0] = dt;
  Rates difference = 1 / dt * increment.sum;
  double span = dt;
  const auto last = static_cast<std::size_t>(known_ - 1);
  for (std::size_t m = 0; m < last; ++m) {
    std::swap(differences_[m], difference);
    span += intervals_[m + 1];
    difference = 1 / span * (differences_[m] - difference);
  }
  differences_[last] = difference;
}

/// From where the history begins, each interval with the polynomial through all of it.
void Strapdown::redo() {
  const auto known = static_cast<std::size_t>(known_);
  Sum sum = start_;
  for (std::size_t j = 0; j < known; ++j) {
    // Ends of the intervals from the middle of interval j, and F there: its own two first.
    const double half = first_[j].dt / 2;
    std::array<double, kHighestOrder + 1> s{-half, half};
    std::array<Rates, kHighestOrder + 1> difference;
    difference[0].setZero();
    difference[1] = first_[j].sum;
    std::size_t node = 2;
    for (std::size_t k = j; k-- > 0; ++node) {
      s[node] = (k + 1 == j ? s[0] : s[node - 1]) - first_[k].dt;
      difference[node] = (k + 1 == j ? difference[0] : difference[node - 1]) - first_[k].sum;
    }
    for (std::size_t k = j + 1; k < known; ++k, ++node) {
      s[node] = (k == j + 1 ? s[1] : s[node - 1]) + first_[k].dt;
      difference[node] = (k == j + 1 ? difference[1] : difference[node - 1]) + first_[k].sum;
    }
    for (std::size_t m = 1; m <= known; ++m)
      for (std::size_t i = known; i >= m; --i) difference[i] = (difference[i] - difference[i - 1]) / (s[i] - s[i - m]);
    Polynomial polynomial(first_[j].dt, known_);
    for (std::size_t m = 2; m <= known; ++m) polynomial.add(difference[m], -s[m]);
    advance(sum, first_[j], polynomial);
  }
  now_ = sum;
}

void Strapdown::advance(Sum& sum, const Increment& increment, const Polynomial& polynomial) {
  const double dt = increment.dt;
  const auto& [p0, v0, q0] = sum.state;
  const Twist x0{increment.sum.head<3>(), increment.sum.tail<3>(), Vector3d::Zero(), dt};
  const int order = x0.w.squaredNorm() < kWidest * kWidest ? known_ : 1;
  const Gain gain = exponential(magnus(x0, polynomial, order));

  const Eigen::Matrix3d C_eb = q0.toRotationMatrix();
  const Vector3d sensed = C_eb * gain.v;
  const Vector3d v_ib = v0 + earth_rate_cross(p0);
  const Pull pull = gravitation_gained(p0, v_ib, sensed, sum.gravitation, dt);
  const Vector3d p_gained = dt * v0 + C_eb * gain.p + pull.p;

  // p1 = R(-a) (p0 + dt w_ie x p0 + p_gained), v1 = R(-a) (v0 + w_ie x p0 + v gained) - w_ie x p1, the large
  // parts taken out by hand.
  const Turn turn = earth_turn(dt);
  Vector3d p_step = turned_back(turn, p_gained);
  p_step.x() += turn.radial * p0.x() - turn.along * p0.y();
  p_step.y() += turn.radial * p0.y() + turn.along * p0.x();
  const Vector3d v1 =
      turned_back(turn, v0 + sensed + pull.v + dt * earth::centrifugal(p0) - earth_rate_cross(p_gained));
  Quaterniond q_step = q0 * gain.q_less_1;
  if (options_.earth_rate_in_attitude)
    q_step.coeffs() += added_by(turn, Quaterniond(q0.coeffs() + q_step.coeffs())).coeffs();
  q_step.coeffs() += 0.5 * (1 - q0.squaredNorm()) * (q0.coeffs() + q_step.coeffs());

  add(p_step, sum.state.p_eb_e, sum.p_rest);
  sum.state.v_eb_e = v1;
  add(q_step.coeffs(), sum.state.q_eb.coeffs(), sum.q_rest);
  sum.gravitation = pull.g;
  specific_force_e_ = sensed / dt;
}

}  // namespace gyrobudget::inline v0::navigation

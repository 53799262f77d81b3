// SPDX-License-Identifier: MIT
#include "sampled.h"

#include "gyrobudget/vehicle/earth/detail/check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "frames.h"
#include "gravity.h"

namespace gyrobudget::inline v0::earth {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr std::size_t kFewest = 4;  // what a cubic needs

/// A vector and its first two derivatives.
template <typename Vector>
struct Jet {
  Vector value, first, second;
};

/// Cubic spline with continuous second derivatives, not-a-knot at both ends, so that cubics are met exactly.
template <typename Vector>
class CubicSpline {
 public:
  CubicSpline() = default;
  CubicSpline(const std::vector<double>& t, std::vector<Vector> y) : y_(std::move(y)), second_(solve(t, y_)) {}

  [[nodiscard]] Jet<Vector> at(const std::vector<double>& t, std::size_t piece, double time) const {
    const double h = t[piece + 1] - t[piece];
    const double a = (t[piece + 1] - time) / h;
    const double b = (time - t[piece]) / h;
    const Vector& y0 = y_[piece];
    const Vector& m0 = second_[piece];
    const Vector& m1 = second_[piece + 1];
    const Vector rise = y_[piece + 1] - y0;
    return {y0 + b * rise - h * h / 6 * a * b * ((1 + a) * m0 + (1 + b) * m1),
            rise / h + h / 6 * ((1 - 3 * a * a) * m0 + (3 * b * b - 1) * m1), a * m0 + b * m1};
  }

 private:
  /// Second derivatives at the knots. Those of the ends are eliminated by the not-a-knot conditions
  /// m_0 = m_1 + h_0/h_1 (m_1 - m_2); what remains is tridiagonal and diagonally dominant: no pivots.
  static std::vector<Vector> solve(const std::vector<double>& t, const std::vector<Vector>& y) {
    const std::size_t n = t.size();
    const auto h = [&](std::size_t k) { return t[k + 1] - t[k]; };
    const auto slope = [&](std::size_t k) -> Vector { return (y[k + 1] - y[k]) / h(k); };
    const double start = h(0) / h(1);
    const double end = h(n - 2) / h(n - 3);
    std::vector<Vector> m(n);
    std::vector<double> upper(n);
    for (std::size_t k = 1; k + 1 < n; ++k) {
      double below = h(k - 1);
      double diagonal = 2 * (h(k - 1) + h(k));
      double above = h(k);
      if (k == 1) {
        diagonal += below * (1 + start);
        above -= below * start;
      }
      if (k + 2 == n) {
        diagonal += h(k) * (1 + end);
        below -= h(k) * end;
      }
      Vector right = 6 * (slope(k) - slope(k - 1));
      if (k > 1) {
        diagonal -= below * upper[k - 1];
        right -= below * m[k - 1];
      }
      upper[k] = above / diagonal;
      m[k] = right / diagonal;
    }
    for (std::size_t k = n - 3; k >= 1; --k) m[k] -= upper[k] * m[k + 1];
    m[0] = m[1] + start * (m[1] - m[2]);
    m[n - 1] = m[n - 2] + end * (m[n - 2] - m[n - 3]);
    return m;
  }

  std::vector<Vector> y_;
  std::vector<Vector> second_;
};

class SampledPath final : public Path {
 public:
  SampledPath(std::vector<double> times, std::span<const Vector3d> p_eb_e, std::span<const Quaterniond> q_eb)
      : times_(std::move(times)), origin_(p_eb_e.front()) {
    std::vector<Vector3d> positions(p_eb_e.begin(), p_eb_e.end());
    for (Vector3d& p : positions) p -= origin_;  // keeps digits of what moves little
    position_ = CubicSpline<Vector3d>(times_, std::move(positions));
    attitude_ = CubicSpline<Vector4d>(times_, of_one_sign(q_eb));
  }

  [[nodiscard]] double duration() const override { return times_.back(); }
  /// Samples and the middles between: over half a cubic, turned by less than 45 degrees, the quadrature is
  /// good to 1e-11 m/s, whatever the spacing.
  [[nodiscard]] std::vector<double> breaks() const override {
    std::vector<double> breaks;
    breaks.reserve(2 * times_.size());
    for (std::size_t k = 0; k + 1 < times_.size(); ++k) {
      breaks.push_back(times_[k]);
      breaks.push_back((times_[k] + times_[k + 1]) / 2);
    }
    return breaks;
  }
  [[nodiscard]] double fastest() const override { return 1 / times_.back(); }

  [[nodiscard]] Motion at(double t) const override {
    const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
    const std::size_t piece = static_cast<std::size_t>(after - times_.begin()) - 1;
    const Jet<Vector3d> p = position_.at(times_, piece, t);
    const Jet<Vector4d> s = attitude_.at(times_, piece, t);
    // q = s/|s|; what |s| changes is along q and has no part in the rate 2 q* dq/dt.
    const double norm = s.value.norm();
    const Quaterniond q(Vector4d(s.value / norm));
    const Quaterniond rate(Vector4d(s.first / norm));
    return {.pose = {.p_eb_e = origin_ + p.value, .v_eb_e = p.first, .q_eb = q},
            .a_eb_e = p.second,
            .w_eb_b = 2 * (q.conjugate() * rate).vec()};
  }

 private:
  /// q and -q are one attitude; neighbours are given the signs in which they are near.
  static std::vector<Vector4d> of_one_sign(std::span<const Quaterniond> q_eb) {
    const double least = std::sqrt(0.5);  // cosine of half the largest turn
    std::vector<Vector4d> all;
    all.reserve(q_eb.size());
    for (const Quaterniond& q : q_eb) {
      detail::check_unit(q, "a sampled attitude");
      Vector4d next = q.coeffs().normalized();
      const double cosine = all.empty() ? 1 : next.dot(all.back());
      if (!(std::abs(cosine) >= least))
        throw std::invalid_argument(
            fmt::format("samples {} and {} of the attitude are {} rad apart; a spline needs pi/2 or less",
                        all.size() - 1, all.size(), 2 * std::acos(std::abs(cosine))));
      all.push_back(cosine < 0 ? Vector4d(-next) : next);
    }
    return all;
  }

  std::vector<double> times_;
  Vector3d origin_;
  CubicSpline<Vector3d> position_;
  CubicSpline<Vector4d> attitude_;
};

void check_lengths(std::size_t times, std::size_t positions, std::size_t attitudes) {
  if (times != positions || times != attitudes || times < kFewest)
    throw std::invalid_argument(
        fmt::format("{} times, {} positions and {} attitudes must be equally many, and at least {}", times, positions,
                    attitudes, kFewest));
}

std::vector<double> from_zero(std::span<const double> times) {
  std::vector<double> shifted;
  shifted.reserve(times.size());
  for (std::size_t k = 0; k < times.size(); ++k) {
    detail::check_finite(times[k], "time of a sample", "s");
    if (k > 0 && !(times[k] > times[k - 1]))
      throw std::invalid_argument(fmt::format("time {} s of sample {} must be after {} s", times[k], k, times[k - 1]));
    shifted.push_back(times[k] - times[0]);
  }
  return shifted;
}

}  // namespace

Trajectory through_samples(std::span<const double> times, std::span<const Vector3d> p_eb_e,
                           std::span<const Quaterniond> q_eb) {
  check_lengths(times.size(), p_eb_e.size(), q_eb.size());
  for (const Vector3d& p : p_eb_e) static_cast<void>(normal_gravitation(p));  // refuses what is not a position
  return Trajectory(std::make_shared<SampledPath>(from_zero(times), p_eb_e, q_eb));
}

Trajectory through_samples(std::span<const double> times, std::span<const Geodetic> positions,
                           std::span<const Quaterniond> q_nb) {
  check_lengths(times.size(), positions.size(), q_nb.size());
  std::vector<Vector3d> p_eb_e;
  std::vector<Quaterniond> q_eb;
  for (std::size_t k = 0; k < times.size(); ++k) {
    detail::check_position(positions[k]);
    p_eb_e.push_back(to_ecef(positions[k]));
    q_eb.push_back(Quaterniond(C_e_ned(positions[k].latitude, positions[k].longitude)) * q_nb[k]);
  }
  return through_samples(times, p_eb_e, q_eb);
}

}  // namespace gyrobudget::inline v0::earth

// SPDX-License-Identifier: MIT
#include "gyrobudget/vehicle/earth/detail/check.h"

#include <boost/numeric/odeint/algebra/vector_space_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "frames.h"
#include "gravity.h"
#include "paths.h"

namespace gyrobudget::inline v0::earth {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using PositionVelocity = Eigen::Matrix<double, 6, 1>;

constexpr double kStep = 0.5;  // [s]; against the 800 s in which gravity changes along an orbit
constexpr double kFastest = 0.25;

using Stepper = boost::numeric::odeint::runge_kutta_fehlberg78<PositionVelocity, double, PositionVelocity, double,
                                                               boost::numeric::odeint::vector_space_algebra>;

class AscentPath final : public Path {
 public:
  explicit AscentPath(const Ascent& options)
      : o_(options),
        q_el_(Quaterniond(C_e_ned(o_.site.latitude, o_.site.longitude)) * exp_rotation({0, 0, o_.azimuth})) {
    integrate();
  }

  [[nodiscard]] double duration() const override { return o_.duration; }
  [[nodiscard]] double fastest() const override { return std::max(kFastest, 4 * std::abs(pitch_rate(o_.duration))); }
  [[nodiscard]] std::vector<double> breaks() const override {
    std::vector<double> breaks{o_.pitch_over_at, o_.duration - o_.tail_off};
    std::sort(breaks.begin(), breaks.end());
    return breaks;
  }

  [[nodiscard]] Motion at(double t) const override {
    const std::size_t last =
        static_cast<std::size_t>(std::upper_bound(times_.begin(), times_.end(), t) - times_.begin());
    const std::size_t node = std::max<std::size_t>(last, 1) - 1;
    PositionVelocity x = states_[node];
    if (t > times_[node]) step(x, times_[node], t - times_[node]);
    return {.pose = {.p_eb_e = x.head<3>(), .v_eb_e = x.tail<3>(), .q_eb = attitude(t)},
            .a_eb_e = acceleration(x, t),
            .w_eb_b = pitch_rate_b(t)};
  }

  [[nodiscard]] Sensed sensed(double t) const override {
    const Vector3d w_ie_e(0, 0, wgs84::kEarthRate);
    return {force(t), pitch_rate_b(t) + attitude(t).conjugate() * w_ie_e};
  }

 private:
  // The pitch program is continuous; at a break itself rates are those from there on.
  [[nodiscard]] double pitch_rate(double t) const {
    if (t < o_.pitch_over_at || o_.pitch_over_at == o_.duration) return 0;
    return (o_.pitch_end - std::numbers::pi / 2) / (o_.duration - o_.pitch_over_at);
  }
  [[nodiscard]] Vector3d pitch_rate_b(double t) const { return {0, pitch_rate(t), 0}; }
  [[nodiscard]] Quaterniond attitude(double t) const {
    return q_el_ * exp_rotation({0, std::numbers::pi / 2 + pitch_rate(t) * (t - o_.pitch_over_at), 0});
  }
  [[nodiscard]] Vector3d force(double t) const {
    const double burn = o_.duration - o_.tail_off;
    if (t < burn) return {o_.force_start + (o_.force_end - o_.force_start) * t / burn, 0, 0};
    return {o_.tail_off > 0 ? o_.force_end * (o_.duration - t) / o_.tail_off : o_.force_end, 0, 0};
  }
  [[nodiscard]] Vector3d acceleration(const PositionVelocity& x, double t) const {
    const Vector3d w_ie_e(0, 0, wgs84::kEarthRate);
    return attitude(t) * force(t) + normal_gravity(x.head<3>()) - 2 * w_ie_e.cross(x.tail<3>());
  }

  void step(PositionVelocity& x, double t, double dt) const {
    Stepper stepper;
    stepper.do_step([&](const PositionVelocity& state, PositionVelocity& rate,
                        double time) { rate << state.tail<3>(), acceleration(state, time); },
                    x, t, dt);
  }

  /// Nodes end at the breaks, so that each step is over a smooth piece.
  void integrate() {
    PositionVelocity x;
    x << to_ecef(o_.site), Vector3d::Zero();
    double from = 0;
    std::vector<double> ends = breaks();
    ends.push_back(o_.duration);
    for (const double end : ends) {
      const double steps = std::ceil((end - from) / kStep);
      for (double k = 0; k < steps; ++k) {
        const double t = from + (end - from) * (k / steps);
        times_.push_back(t);
        states_.push_back(x);
        step(x, t, (end - from) / steps);
      }
      from = end;
    }
  }

  Ascent o_;
  Quaterniond q_el_;  ///< of downrange, right, down
  std::vector<double> times_;
  std::vector<PositionVelocity> states_;
};

}  // namespace

Trajectory ascent(const Ascent& options) {
  detail::check_position(options.site);
  detail::check_finite(options.azimuth, "azimuth", "rad");
  detail::check_finite(options.pitch_end, "pitch at the end", "rad");
  detail::check_finite(options.force_start, "specific force at the start", "m/s^2");
  detail::check_finite(options.force_end, "specific force before the tail-off", "m/s^2");
  detail::check_positive(options.duration, "duration", "s");
  if (options.duration > kLongestAscent)
    throw std::invalid_argument(fmt::format("duration {} s must be at most the {} s over which an ascent is integrated",
                                            options.duration, kLongestAscent));
  detail::check_not_negative(options.pitch_over_at, "start of the pitch-over", "s");
  detail::check_not_negative(options.tail_off, "tail-off", "s");
  if (options.pitch_over_at > options.duration || options.tail_off > options.duration)
    throw std::invalid_argument(fmt::format("pitch-over at {} s and tail-off of {} s must be within the ascent's {} s",
                                            options.pitch_over_at, options.tail_off, options.duration));
  return Trajectory(std::make_shared<AscentPath>(options));
}

}  // namespace gyrobudget::inline v0::earth

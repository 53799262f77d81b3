// SPDX-License-Identifier: MIT
#include "fly.h"

#include "gyrobudget/vehicle/earth/vector.h"
#include "gyrobudget/vehicle/flight/detail/burn.h"
#include "gyrobudget/vehicle/flight/detail/height.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {
namespace detail {
namespace {

using Eigen::Vector3d;

constexpr double kBelowPad = 0.5;  // [m]

double checked_duration(const Flight& flight) {
  if (!(flight.period > 0) || !std::isfinite(flight.period))
    throw SetupError(fmt::format("control period is {} s, but must be positive", flight.period));
  const double duration = asked_duration(flight);
  if (!(duration > 0) || !(duration / flight.period < 1e8))
    throw SetupError(fmt::format("duration is {} s, but must be positive and below 1e8 periods", duration));
  return duration;
}

bool sound(const Seen& s) {
  return s.pose.p_eb_e.allFinite() && s.pose.v_eb_e.allFinite() && s.pose.q_eb.coeffs().allFinite() &&
         s.w_ib_b.allFinite();
}
bool sound(const Command& c) { return std::isfinite(c.pitch) && std::isfinite(c.yaw) && std::isfinite(c.roll_moment); }

std::string account(Ended ended, const FlightPoint& at, const Flight& flight) {
  std::string where =
      fmt::format("at {:.2f} s, {:.1f} m high, {:.1f} m/s against the air", at.t, at.flow.height, at.flow.speed);
  switch (ended) {
    case Ended::complete:
      return "flew to the end " + where;
    case Ended::impact:
      return "came down to the pad's height " + where;
    case Ended::tumbling:
      return fmt::format("turned faster than the limit of {} rad/s {}", flight.rate_limit, where);
    case Ended::overload:
      return fmt::format("dynamic pressure times angle of attack passed the limit of {} Pa rad {}",
                         flight.pressure_angle_limit, where);
    case Ended::not_finite:
      return "numbers were no longer finite after the last sound instant " + where;
  }
  return where;
}

}  // namespace

// The body is at rest on the pad, so the centre of mass, which moves forward in it from ignition on, is not.
BodyState at_ignition(const Flight& flight) {
  BodyState state = on_pad(flight.world.site, flight.azimuth, flight.pitch);
  flight.vehicle.check();
  const Burn burn(flight.vehicle, flight.faults.thrust_cut_at);
  state.v_ib_i += state.q_ib * Vector3d(burn.at(0, burn.piece(0)).cm_velocity, 0, 0);
  return state;
}

FlightInProgress::FlightInProgress(const Flight& flight)
    : flight_(flight),
      duration_(checked_duration(flight)),
      pad_height_(flight.world.site.height),
      body_(flight.vehicle, flight.world, at_ignition(flight), flight.integration, flight.faults),
      interval_(flight.period) {
  increment_ = {.angle = earth::array(body_.imu().sensed.w_ib_b * interval_)};
  const auto periods = static_cast<std::size_t>(std::ceil(duration_ / flight.period));
  if (flight.record_every > 0) result_.points.reserve(periods / static_cast<std::size_t>(flight.record_every) + 2);
  if (flight.keep_increments) result_.increments.reserve(periods);
}

void FlightInProgress::record(const Command& command, const Seen& seen) {
  const BodyState& s = body_.state();
  result_.end = {.t = s.t,
                 .truth = body_.pose(),
                 .seen = seen.pose,
                 .flow = body_.flow(),
                 .command = command,
                 .deflection = s.deflection,
                 .bend = s.bend};
  result_.highest_pressure = std::max(result_.highest_pressure, result_.end.flow.dynamic_pressure);
}

void FlightInProgress::end(Ended how) {
  result_.ended = how;
  going_ = false;
}

bool FlightInProgress::beyond_limits() {
  const BodyState& s = body_.state();
  if (!(s.w_ib_b.norm() < flight_.rate_limit)) {
    end(Ended::tumbling);
  } else if (height_of(s.p_ib_i).above_ellipsoid < pad_height_ - kBelowPad) {
    end(Ended::impact);
  } else if (std::isfinite(flight_.pressure_angle_limit)) {
    const Body::Flow flow = body_.flow();
    if (flow.dynamic_pressure * flow.angle_of_attack > flight_.pressure_angle_limit) end(Ended::overload);
  }
  return !going_;
}

void FlightInProgress::advance(const Command& command, const Seen& seen) {
  if (!sound(seen) || !sound(command)) return end(Ended::not_finite);
  if (flight_.record_every > 0 && period_ % flight_.record_every == 0) {
    record(command, seen);
    result_.points.push_back(result_.end);
  }
  const double from = t();
  const double to = std::min(duration_, static_cast<double>(period_ + 1) * flight_.period);
  if (!body_.advance(command, to)) return end(Ended::not_finite);
  command_ = command;
  interval_ = to - from;
  increment_ = body_.increment();
  ++period_;
  if (flight_.keep_increments) result_.increments.push_back(increment_);
  if (body_.limited()) ++limited_;
  result_.largest_deflection = std::max(result_.largest_deflection, body_.state().deflection.cwiseAbs().maxCoeff());
  if (!beyond_limits() && to >= duration_ - 1e-9 * flight_.period) end(Ended::complete);
}

FlightRecord FlightInProgress::finish(const Seen& seen) {
  Seen last = seen;
  if (!sound(last)) {  // what navigation told is no number: the truth stands there, and the account says so
    last = {.t = t(), .pose = body_.pose(), .w_ib_b = Vector3d::Zero()};
    result_.ended = Ended::not_finite;
  }
  record(command_, last);
  if (flight_.record_every > 0) result_.points.push_back(result_.end);
  result_.account = account(result_.ended, result_.end, flight_);
  result_.limited = period_ > 0 ? static_cast<double>(limited_) / static_cast<double>(period_) : 0;
  result_.work = body_.work();
  return std::move(result_);
}

}  // namespace detail

std::string_view to_string(Ended ended) {
  switch (ended) {
    case Ended::complete:
      return "complete";
    case Ended::impact:
      return "impact";
    case Ended::tumbling:
      return "tumbling";
    case Ended::overload:
      return "overload";
    case Ended::not_finite:
      break;
  }
  return "not_finite";
}

double asked_duration(const Flight& flight) {
  return std::isnan(flight.duration) ? flight.vehicle.burn_time : flight.duration;
}

bool ends_early(const Flight& flight, double flown) { return flown < asked_duration(flight) - flight.period; }

earth::Pose pose_on_pad(const Flight& flight) {
  return Body(flight.vehicle, flight.world, detail::at_ignition(flight), {.method = Method::exact}, flight.faults)
      .pose();
}

}  // namespace gyrobudget::inline v0::flight

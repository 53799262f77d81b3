// SPDX-License-Identifier: MIT
// The closed loop: vehicle, IMU, navigation, control.
#pragma once

#include "gyrobudget/vehicle/earth/vector.h"

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "body.h"
#include "control.h"

namespace gyrobudget::inline v0::flight {

/// What is flown, from the pad on.
struct Flight {
  Vehicle vehicle = vlm1();
  World world;
  double azimuth = 90 * earth::kDegree;  ///< the belly's on the pad
  double pitch = 90 * earth::kDegree;    ///< on the pad
  Integration integration;
  Faults faults;
  double period = 0.01;                                        ///< of control and navigation [s]
  double duration = std::numeric_limits<double>::quiet_NaN();  ///< [s]; not a number: until burnout
  /// Where a flight ends before: [rad/s], [Pa rad].
  double rate_limit = 3;
  double pressure_angle_limit = std::numeric_limits<double>::infinity();  ///< of dynamic pressure times angle
  int record_every = 10;                                                  ///< periods between points; 0 keeps none
  bool keep_increments = false;                                           ///< of the exact IMU, one a period
};

/// How long a flight is to last: its duration, or where that is not a number to burnout [s].
[[nodiscard]] double asked_duration(const Flight& flight);
/// Whether a flight that lasted `flown` [s] ended more than a period before its time.
[[nodiscard]] bool ends_early(const Flight& flight, double flown);

/// One instant of a flight.
struct FlightPoint {
  double t;
  earth::Pose truth;  ///< of the IMU
  earth::Pose seen;   ///< by navigation
  Body::Flow flow;
  Command command;
  Eigen::Vector2d deflection;  ///< of the nozzle
  Eigen::Vector2d bend;
};

enum class Ended {
  complete,   ///< the duration was flown
  impact,     ///< below the pad's height
  tumbling,   ///< rate_limit passed
  overload,   ///< pressure_angle_limit passed
  not_finite  ///< the state left what can be computed: numbers overflowed, or navigation told of nonsense
};

/// "complete", "impact", "tumbling", "overload", "not_finite".
[[nodiscard]] std::string_view to_string(Ended ended);

struct FlightRecord {
  Ended ended = Ended::complete;
  std::string account;  ///< one sentence: how it ended, when and where
  FlightPoint end;      ///< last sound instant
  std::vector<FlightPoint> points;
  std::vector<noise::ImuIncrement> increments;
  double highest_pressure = 0;    ///< dynamic, over the points [Pa]
  double largest_deflection = 0;  ///< of the nozzle, in one plane, over all periods [rad]
  double limited = 0;             ///< share of the periods in which a limit bound the nozzle's command
  Body::Work work;
};

namespace detail {

/// One flight without its controller and navigator.
class FlightInProgress {
 public:
  explicit FlightInProgress(const Flight& flight);

  [[nodiscard]] bool going() const { return going_; }
  [[nodiscard]] double t() const { return body_.state().t; }
  [[nodiscard]] earth::Pose truth() const { return body_.pose(); }
  [[nodiscard]] const noise::ImuIncrement& increment() const { return increment_; }
  [[nodiscard]] double interval() const { return interval_; }
  /// Flies one period.
  void advance(const Command& command, const Seen& seen);
  [[nodiscard]] FlightRecord finish(const Seen& seen);

 private:
  void record(const Command& command, const Seen& seen);
  void end(Ended how);
  [[nodiscard]] bool beyond_limits();

  Flight flight_;
  double duration_;
  double pad_height_;
  Body body_;
  FlightRecord result_;
  noise::ImuIncrement increment_;
  Command command_;
  double interval_;
  long period_ = 0;
  long limited_ = 0;
  bool going_ = true;
};

template <Navigator N>
Seen look(const FlightInProgress& run, N& navigator) {
  if constexpr (requires { navigator.know(run.truth()); }) navigator.know(run.truth());
  noise::Vector3 angle = run.increment().angle;
  if constexpr (requires { navigator.sensed().angle; })
    if (run.t() > 0) angle = navigator.sensed().angle;
  return {.t = run.t(), .pose = navigator.state(), .w_ib_b = earth::vector(angle) / run.interval()};
}

}  // namespace detail

/// Pose of the IMU on the pad, at time 0: where navigation begins. @throws as Body.
[[nodiscard]] earth::Pose pose_on_pad(const Flight& flight);

/// Flies to burnout, or until one of the limits ends it. Each period the navigator is asked, the controller
/// commands, the body flies, and the navigator is given what an ideal IMU summed up. Allocates in the
/// beginning and at the end only. The numbers of the record are finite, whatever happened.
///
///   flight::Flight plan;
///   flight::AttitudeControl control(plan.vehicle, plan.world.site, {});
///   flight::PerfectNavigator navigator;
///   const flight::FlightRecord record = flight::fly(plan, control, navigator);
///
/// @throws SetupError as Body does, and for a period or duration that is not positive.
template <Controller C, Navigator N>
[[nodiscard]] FlightRecord fly(const Flight& flight, C& controller, N& navigator) {
  detail::FlightInProgress run(flight);
  Seen seen = detail::look(run, navigator);
  while (run.going()) {
    run.advance(controller.command(seen), seen);
    navigator.step(run.increment(), run.interval());
    seen = detail::look(run, navigator);
  }
  return run.finish(seen);
}

}  // namespace gyrobudget::inline v0::flight

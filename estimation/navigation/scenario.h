// SPDX-License-Identifier: MIT
// A scene as a value: what the test card says, in SI. Times are seconds after Recording::origin, or after the
// start of the trajectory.
#pragma once

#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "errors.h"
#include "filter.h"
#include "sensor_states.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::navigation {

/// A part of a scene, `from` and `to` included [s].
struct Span {
  double from = 0;
  double to = std::numeric_limits<double>::infinity();
  [[nodiscard]] bool holds(double t) const { return from <= t && t <= to; }
};

/// What one aid measures, and how wrong it may be. A device that measures several things is several aids.
///
/// Components of sigma, bias and correlated error: east, north, up for positions and velocities; about body
/// x, y, z for attitudes; the first alone for heights.
struct Aid {
  enum class Kind {
    position,  ///< of an antenna
    velocity,  ///< of an antenna, against Earth
    height,    ///< above the ellipsoid: barometer, radar
    attitude,  ///< of a star tracker or a master INS mounted on the body
    rest,      ///< that the body does not move against Earth: zero velocity on the pad, `sigma` of sway
  };
  std::string name;  ///< "gnss.position"
  Kind kind = Kind::position;
  /// False: the filter never sees it; it is there to be compared with.
  bool used = true;
  Eigen::Vector3d sigma = Eigen::Vector3d::Ones();  ///< white from fix to fix, positive [m, m/s, rad]
  double sigma_factor = 1;                          ///< times sigma, and times a fix's own where it has one
  double rate = 1;                                  ///< of rest and of simulated fixes [Hz]
  Span valid;                                       ///< fixes outside it are passed over
  std::vector<Span> outages;                        ///< and those within these

  // What is estimated beside the vehicle, where its sigma is not 0.
  Eigen::Vector3d bias_sigma = Eigen::Vector3d::Zero();        ///< a constant error; mounting of an attitude
  Eigen::Vector3d correlated_sigma = Eigen::Vector3d::Zero();  ///< a Gauss-Markov error
  double correlation_time = 100;                               ///< of it [s]
  Eigen::Vector3d lever_arm = Eigen::Vector3d::Zero();         ///< from the IMU to the antenna, body axes [m]
  Eigen::Vector3d lever_arm_sigma = Eigen::Vector3d::Zero();
  double time_tag = 0;  ///< a fix holds for its stamp plus this [s]: negative where stamps are late
  double time_tag_sigma = 0;
  /// One receiver has one clock: aids that follow one another with the same name here share one error of it, with the
  /// sigma of the first. Empty: its own.
  std::string clock;
};

/// "position", "velocity", "height", "attitude", "rest".
[[nodiscard]] std::string_view name(Aid::Kind kind);
/// Scalars in one fix: 3, of heights 1.
[[nodiscard]] int rows(Aid::Kind kind);
/// @throws SetupError for a number out of range, naming the aid and the number.
void check(const Aid& aid);

/// One sigma of what a fix gives a start: white, constant and correlated error together.
[[nodiscard]] Eigen::Vector3d total_sigma(const Aid& aid);

/// What is estimated of an aid, as error terms of its number, with their variances at the start.
struct AidTerms {
  std::vector<ErrorTerm> terms;
  std::vector<double> variances;
};
[[nodiscard]] AidTerms aid_terms(const Aid& aid, int number);
/// Number of the first used aid that shares this one's clock: its own where none does.
[[nodiscard]] std::size_t clock_of(const std::vector<Aid>& aids, std::size_t number);

/// The first fix of an aid at or after the start.
struct FromAid {
  std::size_t aid = 0;  ///< number in Scenario::aids
};
/// Levelling and gyrocompassing on the IMU itself, at rest over `duration` from the start; the filter starts
/// where it ends.
struct SelfAlignment {
  double duration = 60;           ///< [s]
  std::optional<double> heading;  ///< [rad], with heading_sigma, where the gyros cannot tell it
};

/// Where navigation starts from. Sigmas are one sigma; left out where an aid gives the quantity: its own.
struct AlignmentPlan {
  double start = 0;  ///< [s]
  std::variant<earth::Geodetic, FromAid> position = earth::Geodetic{};
  std::optional<Eigen::Vector3d> position_sigma;                               ///< east, north, up [m]
  std::variant<Eigen::Vector3d, FromAid> velocity = Eigen::Vector3d(0, 0, 0);  ///< v_eb_n, north, east, down [m/s]
  std::optional<Eigen::Vector3d> velocity_sigma;                               ///< east, north, up [m/s]
  std::variant<earth::Euler, FromAid, SelfAlignment> attitude = earth::Euler{};
  std::optional<double> level_sigma, heading_sigma;  ///< [rad]
};

/// One scene. What a run does not need may stay as it is.
struct Scenario {
  std::string name;
  std::optional<earth::Geodetic> site;   ///< origin of local axes; else where navigation starts
  double azimuth = 90 * earth::kDegree;  ///< of the launch plane
  noise::SensorModel sensor;             ///< one sigma of its errors, ideal by default
  SensorStates::Options states;          ///< which of them are estimated; length and step are the run's
  AlignmentPlan alignment;
  std::vector<Aid> aids;
  Filter::Options filter;
  /// A filter that the fixes prove lost starts again from them. False: it is only said.
  bool recovery = true;
  double until = std::numeric_limits<double>::infinity();  ///< end of the scene [s]
  double solution_interval = 1;                            ///< between solutions [s], positive
  std::vector<double> at;                                  ///< solutions at these times too
  double gravity_sigma = 0;     ///< of a vertical error of normal gravity, for budgets [m/s^2]
  double deflection_sigma = 0;  ///< of the vertical, for budgets [rad]
  bool smooth = false;          ///< solutions from all fixes, later ones too (smoother.h); considered states: refused
  std::vector<std::size_t> reference;  ///< aids that the solution is compared with
};

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/site.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <string_view>

#include "atmosphere.h"
#include "vehicle.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::flight {

/// What a controller asks of a vehicle over one control period.
struct Command {
  double pitch = 0;        ///< nozzle deflection that pitches the nose up [rad]
  double yaw = 0;          ///< nozzle deflection that yaws the nose right [rad]
  double roll_moment = 0;  ///< right side down [N m]
};

/// Where it flies. The inertial axes i are Earth's axes e at time 0, the ignition.
struct World {
  earth::Geodetic site = earth::alcantara().position;
  Wind wind;
  bool atmosphere = true;  ///< false leaves out air, its drag and the back-pressure
};

/// State of the body: its centre of mass, its attitude, and what moves in it. [0] is pitch, [1] yaw.
struct BodyState {
  double t = 0;                                          ///< after ignition [s]
  Eigen::Vector3d p_ib_i;                                ///< [m]
  Eigen::Vector3d v_ib_i;                                ///< [m/s]
  Eigen::Quaterniond q_ib;                               ///< unit
  Eigen::Vector3d w_ib_b;                                ///< [rad/s]
  Eigen::Vector2d deflection = Eigen::Vector2d::Zero();  ///< of the nozzle [rad]
  Eigen::Vector2d deflection_rate = Eigen::Vector2d::Zero();
  Eigen::Vector2d bend = Eigen::Vector2d::Zero();  ///< coordinate of the bending mode [m]
  Eigen::Vector2d bend_rate = Eigen::Vector2d::Zero();
};

/// At rest on Earth with its centre of mass at the site, nose at `pitch` above the horizon towards `azimuth`.
[[nodiscard]] BodyState on_pad(const earth::Geodetic& site, double azimuth, double pitch);

/// What fails, and when [s].
struct Faults {
  double thrust_cut_at = std::numeric_limits<double>::infinity();
  /// From the first control instant at or after this on, the nozzle stays where it is then ...
  double nozzle_stuck_at = std::numeric_limits<double>::infinity();
  /// ... plus this [rad], pitch and yaw.
  Eigen::Vector2d nozzle_stuck_offset = Eigen::Vector2d::Zero();
  /// Throughout, thrust points off the nozzle's deflection by this [rad], pitch and yaw.
  Eigen::Vector2d thrust_misalignment = Eigen::Vector2d::Zero();
};

/// How the equations of motion are integrated. Steps end at control instants, at the points of the thrust's
/// table, at ends of the atmosphere's layers and where a delayed command arrives.
///
/// FlightInProgress time of 83 s of flight at 100 Hz in seconds, by how much faster than 4 Hz the actuator is, for an
/// error of the angular rate below 1e-8 rad/s (tests/bench/flight_benchmark stiffness; runge_kutta4 in steps
/// of 1.3 over the actuator's angular frequency, adaptive methods at 1e-7):
///   factor                1      10     100    1000    1e4    1e5    1e6
///   exact            0.0083  0.0082  0.0082  0.0083 0.0086 0.0085 0.0090
///   runge_kutta4     0.0083   0.015    0.15     2.5     32    340   3600    (2.6e-6 rad/s at 10)
///   dormand_prince    0.014    0.12    0.73     2.9     25    270   3100
///   fehlberg78        0.028   0.089    0.74     3.9     37    370   4800
///   rosenbrock         0.18     2.7     7.7     9.1    9.1    8.2    5.6
/// rosenbrock passes the explicit methods near 3000. exact is as fast for any actuator, since the nozzle's
/// motion enters with its exact integral and first moment over each step, whatever it does within. At the end
/// of the flight every method above is within 1 um of every other, the rounding of 6400 km summed up 8300
/// times.
enum class Method {
  automatic,       ///< `exact`, or `rosenbrock` where step times stiffness(false) is 2 or more at the start
  exact,           ///< the actuator in closed form, the rest by the classical Runge-Kutta of order 4
  runge_kutta4,    ///< classical, fixed steps, everything
  dormand_prince,  ///< 5(4), adaptive
  fehlberg78,      ///< 8(7), adaptive
  rosenbrock,      ///< RODAS 4(3), stiff, adaptive
};
[[nodiscard]] std::string_view to_string(Method method);

struct Integration {
  Method method = Method::automatic;
  /// Longest step [s].
  double step = 0.01;
  /// Of adaptive methods: estimated error of one step against 1 km, 1 km/s, 1 rad, 1 rad/s, 0.1 rad of nozzle
  /// and 1 cm of bending; 0 takes fixed steps instead.
  double tolerance = 1e-9;
};

/// A rigid vehicle of varying mass in flight over the rotating WGS84 Earth.
///   v_ib_i' = C_ib F/m + gravitation(p),  q' = q w/2,  I w' = M - w x (I w)
/// F is thrust, less back-pressure exit_area p (1 - exp(-thrust/(0.1 mean thrust))), which vanishes with the
/// thrust as the nozzle runs empty; axial drag q S C_A(Mach); normal force rho V/2 S slope times the lateral
/// velocity. Thrust and drag act at the gimbal and at the centre of pressure. Mass and moments of inertia
/// follow the propellant; what the jet carries away of the angular momentum is taken to balance I' w (jet
/// damping left out: below 1 % of the attitude control's). Aerodynamic damping is left out too.
///
/// The IMU sits at its station, not at the centre of mass, which moves: position, velocity and what is sensed
/// there follow from kinematics, with w' x r, w x (w x r), 2 w x r', r'' and the difference in gravitation.
/// Integrals of its specific force and angular rate are states of the integrator, so increments have no
/// quadrature error beside the integrator's own.
class Body {
 public:
  /// @throws SetupError where the vehicle does not pass its check, the step is not positive or the tolerance is
  /// negative; std::invalid_argument where the state is not finite or its attitude no rotation.
  Body(const Vehicle& vehicle, const World& world, const BodyState& start, const Integration& integration = {},
       const Faults& faults = {});
  Body(Body&&) noexcept;
  Body& operator=(Body&&) noexcept;
  ~Body();

  /// Flies on until `t` with one command, limited as the actuator has it. Allocates nothing. False where the
  /// state left what can be computed (numbers not finite, a step below 1e-12 s): it is then the one before.
  /// @throws std::invalid_argument where t is before the present, SetupError where more than 250 commands are delayed.
  [[nodiscard]] bool advance(const Command& command, double t);

  [[nodiscard]] const BodyState& state() const;
  /// What the IMU summed up over the last advance().
  [[nodiscard]] const noise::ImuIncrement& increment() const;
  /// Pose of the IMU and what it senses now. Where rate or force jumps: as it was just before, or at the
  /// start as it will be.
  [[nodiscard]] earth::TrajectoryPoint imu() const;

  [[nodiscard]] earth::Pose pose() const;  ///< of the IMU

  /// Where it is in the air now.
  struct Flow {
    double height;            ///< above the ellipsoid [m]
    double dynamic_pressure;  ///< [Pa]
    double mach;              ///< 0 where there is no air
    double speed;             ///< against the air [m/s]
    double angle_of_attack;   ///< total [rad]
    double thrust;            ///< less back-pressure [N]
  };
  [[nodiscard]] Flow flow() const;

  /// Whether a limit of the actuator bound the last command.
  [[nodiscard]] bool limited() const;

  /// What the integration has cost.
  struct Work {
    Method method;           ///< the one in use, never automatic
    std::int64_t steps = 0;  ///< accepted
    std::int64_t rejected = 0;
    std::int64_t evaluations = 0;  ///< of the equations of motion
  };
  [[nodiscard]] Work work() const;

  /// Stiffness: largest modulus of an eigenvalue of the linearised equations [1/s], by powers of a Jacobian
  /// from differences; with the actuator or with it taken out.
  [[nodiscard]] double stiffness(bool with_actuator) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace gyrobudget::inline v0::flight

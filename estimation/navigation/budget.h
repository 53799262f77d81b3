// SPDX-License-Identifier: MIT
// The navigation error budget: what each source of error costs along a planned scene, by linear covariance.
//
// A filter that aids the navigator has one set of gains, from its own design model. They are computed once and
// frozen: each source then passes alone, with its true model, through the same
//   x+ = (I - K H) Phi x,
// x holding the errors of position, velocity and attitude, the filter's estimates and the source's own states.
// So sources that are independent add up exactly, and the true sigma stands beside the one the filter claims.
// Running the filter again for each source would tune it anew to that source and add up to nothing.
//
// A coarse alignment on the pad is one gain more. The attitude it starts the filter with is wrong by
//   psi_0 = G mean(dw, df),
// G the alignment's, the mean that of the source's own errors over the pad, which the filter then meets again in
// the same data. With x = x' + M psi_0, x' the errors had the start been right and M what a start of psi_0 grows to,
// E[x' psi_0^T] and E[psi_0 psi_0^T] are gathered beside E[x' x'^T] and put together where the pad ends: nothing is
// left out, neither tilt that is a bias' own nor noise that is used twice.
// Sources: Gelb (ed.), Applied Optimal Estimation (1974), section 7.2; Maybeck, Stochastic Models, Estimation and
// Control, vol. 1 (1979), section 6.8.
#pragma once

#include "gyrobudget/earth/trajectory.h"
#include "gyrobudget/navigation/aiding.h"
#include "gyrobudget/navigation/covariance.h"
#include "gyrobudget/navigation/error_state.h"
#include "gyrobudget/navigation/sensor_states.h"
#include "gyrobudget/noise/imu.h"
#include "gyrobudget/noise/process.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace gyrobudget::inline v0::navigation {

/// A fix that will be taken, with its true values: residual zero.
struct PlannedFix {
  double time = 0;  ///< [s] on the scene's clock, which is below 0 on the pad
  std::variant<PositionFix, VelocityFix, HeightFix, AttitudeFix> fix;
};

/// What is flown, in steps on which the error model is linearised.
class Timeline {
 public:
  struct Options {
    double step = 0.1;           ///< longest step [s]
    double pad = 0;              ///< rest at the trajectory's first point before its start [s]
    std::vector<double> report;  ///< times of interest [s]; the trajectory's end is always one
  };
  struct Step {
    double from = 0, to = 0;  ///< [s]
    StepInput input;
  };
  /// State at the end of a step.
  struct Instant {
    NavigationState state;
    Eigen::Vector3d w_eb_b, a_eb_e;
  };

  /// Steps end at every fix and time of interest, and at breaks of the trajectory that are half a step or more behind
  /// the end before.
  /// @throws std::invalid_argument for a step or pad out of range, a step below 1e-6 of the scene, times outside the
  /// scene, a pad before a trajectory that starts faster than 1 mm/s.
  Timeline(earth::Trajectory, std::vector<PlannedFix> fixes, const Options&);

  [[nodiscard]] const earth::Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] double start() const { return -pad_; }
  [[nodiscard]] double end() const { return trajectory_.duration(); }
  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }
  [[nodiscard]] const std::vector<PlannedFix>& fixes() const { return fixes_; }  ///< by time
  [[nodiscard]] const std::vector<double>& report() const { return report_; }    ///< ascending
  [[nodiscard]] Instant at(double time) const;

 private:
  void cut(const Options&);
  [[nodiscard]] Step make_step(double from, double to) const;

  earth::Trajectory trajectory_;
  std::vector<PlannedFix> fixes_;
  double pad_ = 0;
  std::vector<double> report_;
  std::vector<Step> steps_;
};

/// psi_e at the scene's start by mean errors over the pad, true minus sensed, of gyro x, y, z and accelerometer
/// x, y, z [rad per rad/s, rad per m/s^2]: a coarse alignment to first order (alignment.h).
using AlignmentGain = Eigen::Matrix<double, 3, 6>;

/// One line of the budget: something that is wrong, with its true size, and nothing else.
struct Source {
  std::string name;                      ///< "gyro.arw", "initial.heading", "aid.gnss.position"
  ErrorStateModel model;                 ///< white noise and terms of this source
  StateMatrix initial;                   ///< covariance of model.terms at the scene's start
  CoreMatrix core = CoreMatrix::Zero();  ///< covariance of position, velocity, attitude there, axes of e
  /// Covariance of these with the terms, where both are one error; empty: none.
  Eigen::Matrix<double, kCoreStates, Eigen::Dynamic> cross;
  int aid = -1;  ///< the white noise of this aid's fixes is the source
  /// What the terms that vary stand for, on each axis of a triad: for routes without states (adjoint.h).
  struct Slow {
    Carrier carrier = Carrier::gyro;
    std::vector<noise::Process> processes;
    Epoch epoch;
  };
  std::optional<Slow> slow;
  /// The error of a sensor that it is, for Monte Carlo, which simulates the sensor.
  struct OfSensor {
    Carrier carrier = Carrier::gyro;
    noise::ErrorSource error{};
  };
  std::optional<OfSensor> sensor;
  /// Where given, each term's effect is multiplied by it [any unit]: errors that are fixed in other axes than
  /// the body's, such as Earth's rate left out or an error of gravity.
  std::function<double(const StepInput&, std::size_t term)> shape;
  bool sensed =
      true;  ///< false: the navigator makes it, no sensor: an alignment of what is sensed is free of it
};

/// The filter as it is designed: it sets the gains.
struct Design {
  ErrorStateModel model;
  StateMatrix initial;  ///< its P0, core and terms
  Form form = Form::joseph;
  std::optional<AlignmentGain> alignment;  ///< of the attitude that it starts from
};

/// Gains of every row of every fix, from the design alone.
struct FrozenGains {
  ErrorStateModel model;                             ///< of the design; empty: no filter
  std::vector<std::vector<Eigen::VectorXd>> of_fix;  ///< [fix][row], core and model.terms
  std::vector<CoreMatrix> claimed;                   ///< the design's own covariance at the times of interest
  std::optional<AlignmentGain> alignment;            ///< of the attitude at the start; none: by no sensor
};
/// @throws std::invalid_argument for fixes without a design, and what Covariance refuses.
[[nodiscard]] FrozenGains frozen_gains(const Timeline&, const std::optional<Design>&);

/// Rows of a planned fix for a model's terms; the residual is zero.
[[nodiscard]] Measurement linearise(const PlannedFix&, const Timeline::Instant&, const ErrorStateModel&);
/// A start that is taken from a fix is wrong as the fix is: x = by_terms s + v, s the errors of the aid, cov v = white.
/// A position is that of the IMU, the lever arm taken off; taken off in an attitude wrong by psi it adds
/// by_attitude psi.
struct StartFromFix {
  Eigen::Matrix<double, kCoreStates, Eigen::Dynamic> by_terms;
  Eigen::Matrix<double, kCoreStates, 3> by_attitude = Eigen::Matrix<double, kCoreStates, 3>::Zero();
  CoreMatrix white = CoreMatrix::Zero();
};
/// @throws std::invalid_argument for a height, which gives no start.
[[nodiscard]] StartFromFix start_from(const PlannedFix&, const Timeline::Instant&, const ErrorStateModel&);
/// Number of the aid that takes it.
[[nodiscard]] int aid_of(const PlannedFix&);

struct Budget {
  struct Line {
    std::string name;
    std::vector<CoreMatrix> covariance;  ///< true errors of p, v, psi at each time, axes of e
  };
  std::vector<double> times;
  std::vector<Line> lines;          ///< one a source, in their order
  std::vector<CoreMatrix> total;    ///< their sum
  std::vector<CoreMatrix> claimed;  ///< what the filter believes; empty without a design
  std::size_t steps = 0;
};

/// Each source's own states s beside p, v, psi and the filter's estimates, x -> Phi x + G eps over a step and
/// x -> (I - K H) x + K eps at each row of a fix with the frozen gain K, carry P -> F P F^T + Q; p [m], v [m/s] and
/// psi [rad] of it at the times of interest are the source's line. Time: steps x sources x states^2.
/// @throws std::invalid_argument for sources whose initial covariance does not fit their terms, more states than
/// kMaxStates together with the filter's, fixes without a design, and errors that grow beyond all numbers.
[[nodiscard]] Budget error_budget(const Timeline&, std::span<const Source>, const FrozenGains&);
[[nodiscard]] Budget error_budget(const Timeline&, std::span<const Source>,
                                  const std::optional<Design>& = {});

/// Fixes at `interval` from `first` to `last`, those in outages left out, with the truth of the trajectory.
struct FixPlan {
  double first = 0, last = 0, interval = 1;        ///< [s]
  std::vector<std::pair<double, double>> outages;  ///< from, to, both included [s]
};
/// first + k interval for k = 0, 1, ... up to `last`, which counts where rounding puts a fix up to 1e-9 of an interval
/// beyond; those within an outage are left out [s]. None where last < first.
/// @throws std::invalid_argument for an interval that is not above 0 and finite, and more than 1e8 fixes.
[[nodiscard]] std::vector<double> fix_times(const FixPlan&);

/// One sigma along each axis of a local frame: roots of the diagonal of C_el^T P C_el, block by block, P a covariance
/// of position, velocity and attitude in axes of e and C_el the frame's axes as columns.
struct LocalSigmas {
  Eigen::Vector3d position;  ///< [m]
  Eigen::Vector3d velocity;  ///< [m/s]
  Eigen::Vector3d attitude;  ///< rotation vector [rad]
};
[[nodiscard]] LocalSigmas local_sigmas(const CoreMatrix& covariance_e, const Eigen::Matrix3d& C_el);

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
#pragma once

#include <array>

#include "aiding.h"
#include "covariance.h"
#include "error_state.h"
#include "errors.h"
#include "smoother.h"
#include "strapdown.h"

namespace gyrobudget::inline v0::navigation {

/// What an update found. Nothing of the filter changes unless it was used.
struct Innovation {
  enum class Status {
    used,
    gated,       ///< NIS beyond the gate
    not_finite,  ///< a number of the measurement is NaN or infinite
  };
  Status status = Status::used;
  int rows = 0;
  Eigen::Vector3d residual = Eigen::Vector3d::Zero();  ///< in the measurement's own components
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();     ///< that the filter expected of each
  double nis = 0;                                      ///< residual^T S^-1 residual, chi-square of `rows` dof
  double log_det = 0;                                  ///< ln det S, for the likelihood -(nis + log_det)/2
  double weight = 1;                                   ///< of a robust update; 1: as an ordinary one
};

/// How an update treats a residual that is larger than its sigma lets expect. With n the NIS of m rows, the variances
/// of the measurement are divided by
///   none     w = 1
///   huber    w = min(1, k/sqrt(n/m)): beyond k sigma a residual counts by its size, not by its square
///   student  w = (v + m)/(v + n): as of a Student distribution of v degrees of freedom
/// before the gain is computed; the gate looks at n. Sources: Huber (1981), Robust Statistics, chapter 7; Lange,
/// Little & Taylor, Robust statistical modeling using the t distribution, JASA 84:881 (1989), section 3.
struct Robust {
  enum class Kind { none, huber, student };
  Kind kind = Kind::none;
  double parameter = 0;  ///< k, or v: above 0

  /// @param rows m @param nis n, 0 or more
  [[nodiscard]] double weight(int rows, double nis) const;
};

/// Extended Kalman filter of an inertial navigator: multiplicative attitude error, closed loop. Corrected
/// increments drive the strapdown, the error state of error_state.h its covariance, and each update goes at
/// once into position, velocity, attitude and the estimates of the terms.
///
///     navigation::Filter filter(start, model, P0);
///     for (const auto& imu : log) {
///       filter.propagate(imu, dt);
///       if (fix_is_due) filter.update(measure(navigation::PositionFix{...}, filter.estimate()));
///     }
///
/// After an update the attitude error is reset without turning P by half of it: of second order in it.
/// propagate and update allocate nothing. Not for use from two threads at once; copies are independent.
class Filter {
 public:
  struct Options {
    Form form = Form::automatic;
    /// Probability with which a right measurement may be refused: NIS above its chi-square limit. 0: no gate.
    double gate_false_alarm = 1e-6;
    /// The covariance moves once in so many seconds, not every step [s]; 0: every step. Estimates move every
    /// step all the same.
    double covariance_interval = 0;
    Robust robust;
    Strapdown::Options strapdown = {};
  };

  /// Terms start at zero; P0 is that of error_state.h in its order.
  /// @throws SetupError for what ErrorStateModel::check refuses, a gate outside 0 to 1 and a negative interval;
  /// std::invalid_argument for what Covariance refuses and P0 of another size.
  Filter(const earth::Pose& start, ErrorStateModel model, const StateMatrix& P0, const Options& options);
  Filter(const earth::Pose& start, ErrorStateModel model, const StateMatrix& P0);

  /// One IMU interval. dt = 0 changes nothing.
  /// @throws std::invalid_argument for dt < 0 (time runs backwards), dt or increments not finite; Diverged and
  /// earth::OutsideDomain where the estimate leaves what can be computed: the filter is of no use any more then.
  void propagate(const noise::ImuIncrement& measured, double dt);

  /// All rows of a measurement, or none: those beyond the gate and those not finite are reported and left
  /// out. @throws Diverged and earth::OutsideDomain as propagate.
  Innovation update(const Measurement& measurement);

  /// What is added to the sensors' white noise from now on, for motion that nobody measured: one sigma of rate
  /// [rad/sqrt(s)] and specific force [m/s/sqrt(s)], body axes. Zero ends it.
  void set_unknown_motion(const Eigen::Vector3d& rate, const Eigen::Vector3d& force);

  /// Another covariance of what the filter estimates, as when that has proved wrong. A record cannot follow: it ends.
  /// @throws std::invalid_argument for what Covariance refuses and P of another size.
  void restart(const StateMatrix& P);

  [[nodiscard]] double time() const { return time_; }  ///< since the start [s]
  [[nodiscard]] const earth::Pose& state() const { return strapdown_.state(); }
  [[nodiscard]] const ErrorStateModel& model() const { return lineariser_.model(); }
  /// Estimate of model().terms[k].
  [[nodiscard]] double term(int k) const { return terms_[k]; }
  /// What aids are compared with; valid until the filter changes.
  [[nodiscard]] Estimate estimate() const;

  /// From now on tells `record` what it does, for smooth(); nullptr ends that. The record must outlive it,
  /// and a copy of the filter tells the same record until it is given its own. Recording allocates.
  /// @throws std::invalid_argument for a record of other size, SetupError for a model with considered states: their
  /// gains are not optimal, which smoothing supposes.
  void record(FilterHistory* record);
  /// Keeps the present as an epoch of the record. @throws std::logic_error without one.
  void keep_epoch();

  /// Moves what covariance_interval has kept back, so that covariance() is that of time().
  void catch_up();
  [[nodiscard]] const Covariance& covariance() const { return covariance_; }

 private:
  struct Pending {
    double dt = 0;
    Eigen::Vector3d velocity_e = Eigen::Vector3d::Zero();  ///< integral of C_eb f_ib_b
    Eigen::Vector3d angle_b = Eigen::Vector3d::Zero();
    Eigen::Quaterniond q_start = Eigen::Quaterniond::Identity();
    Eigen::Vector3d p_start = Eigen::Vector3d::Zero();
    Eigen::Matrix<double, 6, 1> unknown = Eigen::Matrix<double, 6, 1>::Zero();  ///< integral of the density
  };
  [[nodiscard]] noise::ImuIncrement corrected(const noise::ImuIncrement& imu, double dt) const;
  void set_step(double dt);
  void expect(const Measurement& measurement, Innovation& innovation) const;
  void correct(const StateVector& x);

  Options options_;
  Lineariser lineariser_;
  Covariance covariance_;
  Strapdown strapdown_;
  StateVector terms_;
  StateVector decay_, mean_decay_;  ///< of the terms over a step of step_dt_
  double step_dt_ = 0;
  std::array<bool, kMaxStates> considered_{};
  bool scaled_ = false;           ///< some term multiplies the signal
  std::array<double, 4> gate_{};  ///< limit of NIS by number of rows
  Pending pending_;
  bool motion_unknown_ = false;
  Eigen::Matrix<double, 6, 1> unknown_ = Eigen::Matrix<double, 6, 1>::Zero();  ///< density, as StepInput's
  FilterHistory* record_ = nullptr;
  Eigen::Vector3d w_eb_b_ = Eigen::Vector3d::Zero();
  double time_ = 0;
};

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
// What is flown, cut into the steps of a linear covariance.
#pragma once

#include "gyrobudget/estimation/navigation/error_state.h"
#include "gyrobudget/estimation/navigation/planned_fix.h"
#include "gyrobudget/vehicle/earth/trajectory.h"

#include <vector>

namespace gyrobudget::inline v0::budget {

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
    navigation::StepInput input;
  };

  /// Steps end at every fix and time of interest, and at breaks of the trajectory that are half a step or more behind
  /// the end before.
  /// @throws navigation::SetupError for a step or pad out of range, a step below 1e-6 of the scene, times outside the
  /// scene, a pad before a trajectory that starts faster than 1 mm/s.
  Timeline(earth::Trajectory trajectory, std::vector<navigation::PlannedFix> fixes, const Options& options);

  [[nodiscard]] const earth::Trajectory& trajectory() const { return trajectory_; }
  [[nodiscard]] double start() const { return -pad_; }
  [[nodiscard]] double end() const { return trajectory_.duration(); }
  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }
  [[nodiscard]] const std::vector<navigation::PlannedFix>& fixes() const { return fixes_; }  ///< by time
  [[nodiscard]] const std::vector<double>& report() const { return report_; }                ///< ascending
  [[nodiscard]] navigation::Instant at(double time) const;

 private:
  void cut(const Options& options);
  [[nodiscard]] Step make_step(double from, double to) const;

  earth::Trajectory trajectory_;
  std::vector<navigation::PlannedFix> fixes_;
  double pad_ = 0;
  std::vector<double> report_;
  std::vector<Step> steps_;
};

}  // namespace gyrobudget::inline v0::budget

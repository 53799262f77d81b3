// SPDX-License-Identifier: MIT
#include "alignment_time.h"

#include "gyrobudget/estimation/navigation/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::budget {
namespace {

class Search {
 public:
  Search(const navigation::Scenario& scenario, const earth::Trajectory& trajectory, const BudgetQuestion& question,
         double at, const Eigen::Matrix<double, 3, Eigen::Dynamic>& axes)
      : scenario_(scenario), trajectory_(trajectory), question_(question), axes_(axes), at_(at) {
    question_.at = {at};
    question_.growth_points = 0;
  }

  double sigma(double duration) {
    std::get<navigation::SelfAlignment>(scenario_.alignment.attitude).duration = duration;
    const BudgetScene scene = budget_scene(scenario_, trajectory_, question_);
    const Adjoint back = adjoint(scene.timeline, frozen_gains(scene.timeline, scene.design), at_);
    Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
    for (const Source& source : scene.sources)
      P += state_response(back, scene.timeline, source).block<3, 3>(navigation::kPosition, navigation::kPosition);
    return std::sqrt((axes_.transpose() * P * axes_).trace());
  }

  // The limit is met at `met`, not at `missed` below it.
  AlignmentTime between(double missed, AlignmentTime met, double limit) {
    while (met.duration > (1 + kAlignmentExact) * missed) {
      const double middle = std::sqrt(missed * met.duration), found = sigma(middle);
      if (found <= limit)
        met = {true, middle, found};
      else
        missed = middle;
    }
    return met;
  }

 private:
  navigation::Scenario scenario_;
  const earth::Trajectory& trajectory_;
  BudgetQuestion question_;
  const Eigen::Matrix<double, 3, Eigen::Dynamic>& axes_;
  double at_;
};

}  // namespace

AlignmentTime alignment_time(const navigation::Scenario& scenario, const earth::Trajectory& trajectory,
                             const BudgetQuestion& question, double at,
                             const Eigen::Matrix<double, 3, Eigen::Dynamic>& axes, double limit) {
  if (!std::holds_alternative<navigation::SelfAlignment>(scenario.alignment.attitude))
    throw navigation::SetupError("the scene does not align itself: there is no duration to change");
  if (!(limit > 0)) throw navigation::SetupError(fmt::format("limit is {} m, expected above 0 m", limit));
  Search search(scenario, trajectory, question, at, axes);
  AlignmentTime best{false, 0, std::numeric_limits<double>::infinity()};
  double before = 0;
  for (double duration = kShortestAlignment;; duration = std::min(kAlignmentFactor * duration, kLongestAlignment)) {
    const double found = search.sigma(duration);
    if (found <= limit) {
      const AlignmentTime met{true, duration, found};
      return before > 0 ? search.between(before, met, limit) : met;
    }
    if (found < best.sigma) best = {false, duration, found};
    if (duration >= kLongestAlignment) return best;
    before = duration;
  }
}

}  // namespace gyrobudget::inline v0::budget

// SPDX-License-Identifier: MIT
// Inside navigation: solutions against a reference.
#pragma once

#include "gyrobudget/estimation/navigation/aiding.h"
#include "gyrobudget/estimation/navigation/navigate.h"

#include <optional>
#include <vector>

#include "fix_track.h"

namespace gyrobudget::inline v0::navigation::detail {

/// Compares solutions with the reference, each quantity as its aid sees it. Scenario and tracks must outlive it.
class Comparison {
 public:
  /// @throws SetupError for a reference that measures neither position, velocity nor attitude.
  Comparison(const Scenario& scenario, const std::vector<FixTrack>& tracks);

  /// At time t [s]; nothing where the reference does not have all it measures.
  void compare(const Estimate& estimate, const StateMatrix& P, double t);
  [[nodiscard]] std::optional<ReferenceSummary> finish();

 private:
  struct Rows {
    Eigen::MatrixXd H;
    Eigen::VectorXd residual;
  };
  [[nodiscard]] std::optional<Fix> position_at(double t) const;
  bool add(const std::optional<Fix>& fix, std::size_t aid, const Eigen::Matrix3d& turn, const Estimate& estimate,
           const StateMatrix& P, Rows& rows, Eigen::Vector3d& error, Eigen::Vector3d& sigma) const;

  const Scenario& scenario_;
  const std::vector<FixTrack>& tracks_;
  std::optional<std::size_t> position_, velocity_, attitude_;
  ReferenceSummary summary_;
};

}  // namespace gyrobudget::inline v0::navigation::detail

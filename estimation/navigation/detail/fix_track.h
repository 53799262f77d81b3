// SPDX-License-Identifier: MIT
// Inside navigation: the fixes of one aid as a function of time.
#pragma once

#include "gyrobudget/estimation/navigation/recording.h"
#include "gyrobudget/estimation/navigation/scenario.h"

#include <optional>

namespace gyrobudget::inline v0::navigation::detail {

class FixTrack {
 public:
  /// Both must outlive this. @throws std::invalid_argument where the stamps do not ascend.
  FixTrack(const Aid&, const std::vector<Fix>&, std::int64_t origin);

  [[nodiscard]] std::size_t size() const { return fixes_.size(); }
  [[nodiscard]] const Fix& fix(std::size_t i) const { return fixes_[i]; }
  /// For which instant fix i holds, in the scene's time [s].
  [[nodiscard]] double time(std::size_t i) const;
  /// Number of the first fix that holds at or after t; size() where there is none.
  [[nodiscard]] std::size_t first_from(double t) const;
  /// Straight between two fixes, attitudes along the shortest turn; empty outside them all.
  [[nodiscard]] std::optional<Fix> at(double t) const;

 private:
  const Aid& aid_;
  const std::vector<Fix>& fixes_;
  std::int64_t origin_;
};

/// Position by a cubic through two positions and velocities; empty outside them.
[[nodiscard]] std::optional<Eigen::Vector3d> position_at(const FixTrack& positions, const FixTrack& velocities,
                                                         double t);

/// v_eb_e of a velocity in north, east, down at a place.
[[nodiscard]] Eigen::Vector3d to_ecef_axes(const Eigen::Vector3d& v_n, const Eigen::Vector3d& p_eb_e);
/// q_eb of q_nb at a place.
[[nodiscard]] Eigen::Quaterniond to_ecef_axes(const Eigen::Quaterniond& q_nb, const Eigen::Vector3d& p_eb_e);

}  // namespace gyrobudget::inline v0::navigation::detail

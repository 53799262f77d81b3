// SPDX-License-Identifier: MIT
#include "comparison.h"

#include "gyrobudget/estimation/navigation/consistency.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "measure_fix.h"

namespace gyrobudget::inline v0::navigation::detail {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Comparison::Comparison(const Scenario& scenario, const std::vector<FixTrack>& tracks)
    : scenario_(scenario), tracks_(tracks) {
  for (const std::size_t i : scenario.reference) {
    if (tracks[i].size() == 0) continue;  // the reference does not measure it
    switch (scenario.aids[i].kind) {
      case Aid::Kind::position:
        position_ = i;
        break;
      case Aid::Kind::velocity:
        velocity_ = i;
        break;
      case Aid::Kind::attitude:
        attitude_ = i;
        break;
      case Aid::Kind::height:
      case Aid::Kind::rest:
        throw SetupError(fmt::format("reference: {} measures {}, expected position, velocity or attitude",
                                     scenario.aids[i].name, name(scenario.aids[i].kind)));
    }
  }
  summary_.has_position = position_.has_value();
  summary_.has_velocity = velocity_.has_value();
  summary_.has_attitude = attitude_.has_value();
  summary_.dof = 3 * (int{summary_.has_position} + int{summary_.has_velocity} + int{summary_.has_attitude});
}

void Comparison::compare(const Estimate& estimate, const StateMatrix& P, double t) {
  if (summary_.dof == 0) return;
  const earth::Geodetic at = earth::to_geodetic(estimate.motion.pose.p_eb_e);
  const Matrix3d C_enu = earth::C_e_enu(at.latitude, at.longitude);
  const Matrix3d C_lb = C_enu.transpose() * estimate.motion.pose.q_eb.toRotationMatrix();
  ReferenceError e;
  e.time = t;
  Rows rows;
  if (position_ &&
      !add(position_at(t), *position_, Matrix3d::Identity(), estimate, P, rows, e.position, e.position_sigma))
    return;
  if (velocity_ && !add(tracks_[*velocity_].at(t), *velocity_, Matrix3d::Identity(), estimate, P, rows, e.velocity,
                        e.velocity_sigma))
    return;
  if (attitude_ && !add(tracks_[*attitude_].at(t), *attitude_, C_lb, estimate, P, rows, e.attitude, e.attitude_sigma))
    return;
  e.nees = nees(rows.residual, rows.H * P * rows.H.transpose());
  summary_.errors.push_back(e);
}

std::optional<ReferenceSummary> Comparison::finish() {
  if (summary_.dof == 0) return std::nullopt;
  const auto n = static_cast<double>(summary_.errors.size());
  if (n == 0) return std::move(summary_);
  const Band band = chi_square_mean_band(summary_.dof, 1);
  summary_.nees_low = band.lower;
  summary_.nees_high = band.upper;
  double inside = 0;
  for (const ReferenceError& e : summary_.errors) {
    summary_.position_rms += e.position.squaredNorm();
    summary_.velocity_rms += e.velocity.squaredNorm();
    summary_.attitude_rms += e.attitude.squaredNorm();
    summary_.nees_mean += e.nees;
    inside += band.holds(e.nees) ? 1 : 0;
  }
  summary_.position_rms = std::sqrt(summary_.position_rms / n);
  summary_.velocity_rms = std::sqrt(summary_.velocity_rms / n);
  summary_.attitude_rms = std::sqrt(summary_.attitude_rms / n);
  summary_.nees_mean /= n;
  summary_.nees_inside_95 = inside / n;
  return std::move(summary_);
}

std::optional<Fix> Comparison::position_at(double t) const {
  const FixTrack& positions = tracks_[*position_];
  std::optional<Fix> fix = positions.at(t);
  if (!fix || !velocity_) return fix;
  if (const auto p = detail::position_at(positions, tracks_[*velocity_], t)) fix->value = *p;
  return fix;
}

// Three rows, turned to east, north, up.
bool Comparison::add(const std::optional<Fix>& fix, std::size_t aid, const Matrix3d& turn, const Estimate& estimate,
                     const StateMatrix& P, Rows& rows, Vector3d& error, Vector3d& sigma) const {
  if (!fix) return false;
  const Measurement m = measure_fix(scenario_.aids[aid], static_cast<int>(aid), *fix, estimate, Vector3d::Ones());
  Eigen::Matrix<double, 3, Eigen::Dynamic> H(3, P.cols());
  for (int i = 0; i < 3; ++i) H.row(i) = m.row[static_cast<std::size_t>(i)].h.transpose();
  H = turn * H;
  const Vector3d residual = turn * m.residual;
  error = -residual;
  sigma = (H * P * H.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::Index before = rows.residual.size();
  rows.H.conservativeResize(before + 3, P.cols());
  rows.H.bottomRows<3>() = H;
  rows.residual.conservativeResize(before + 3);
  rows.residual.tail<3>() = residual;
  return true;
}

}  // namespace gyrobudget::inline v0::navigation::detail

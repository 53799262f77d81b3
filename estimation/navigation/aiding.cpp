// SPDX-License-Identifier: MIT
#include "aiding.h"

#include "gyrobudget/vehicle/earth/attitude.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double variance(double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma))
    throw SetupError(fmt::format("sigma of an aid is {}, expected above 0 and finite", sigma));
  return sigma * sigma;
}

// Three rows along the columns of `axes` from a residual and core columns in ECEF.
class Rows {
 public:
  Rows(const Estimate& estimate, const Matrix3d& axes, const Vector3d& residual, const Vector3d& sigma) : axes_(axes) {
    result_.rows = 3;
    result_.residual = axes.transpose() * residual;
    for (int i = 0; i < 3; ++i) {
      auto& row = result_.row[static_cast<std::size_t>(i)];
      row.h = StateVector::Zero(estimate.model->states());
      row.variance = variance(sigma[i]);
    }
  }

  void block(int column, const Matrix3d& h_e) {
    const Matrix3d h = axes_.transpose() * h_e;
    for (int i = 0; i < 3; ++i) result_.row[static_cast<std::size_t>(i)].h.segment<3>(column) = h.row(i);
  }

  // A term known at `value`: its column, and what it is known to add leaves the residual.
  void term(std::size_t k, const Vector3d& column_e, double value) {
    const Vector3d column = axes_.transpose() * column_e;
    for (int i = 0; i < 3; ++i)
      result_.row[static_cast<std::size_t>(i)].h[kCoreStates + static_cast<int>(k)] = column[i];
    result_.residual -= value * column;
  }

  [[nodiscard]] const Measurement& result() const { return result_; }

 private:
  Matrix3d axes_;
  Measurement result_;
};

// Calls f(k, term) for the error terms of one aid.
template <typename Function>
void each_term(const Estimate& estimate, int aid, Function f) {
  const auto& terms = estimate.model->terms;
  for (std::size_t k = 0; k < terms.size(); ++k)
    if (terms[k].is_of_aid(aid)) f(k, terms[k]);
}

}  // namespace

Measurement measure(const PositionFix& fix, const Estimate& estimate) {
  const Matrix3d C = estimate.motion.pose.q_eb.toRotationMatrix();
  const Vector3d arm = C * fix.lever_arm;
  Rows rows(estimate, fix.axes, fix.p_eb_e - estimate.motion.pose.p_eb_e - arm, fix.sigma);
  rows.block(kPosition, Matrix3d::Identity());
  rows.block(kAttitude, -earth::skew(arm));
  const Vector3d v_antenna = estimate.motion.pose.v_eb_e + C * estimate.motion.w_eb_b.cross(fix.lever_arm);
  each_term(estimate, fix.aid, [&](std::size_t k, const ErrorTerm& term) {
    const Vector3d column = term.effect == Effect::lever_arm ? Vector3d(C.col(term.axis))
                            : term.effect == Effect::bias    ? Vector3d(fix.axes.col(term.axis))
                                                             : v_antenna;
    rows.term(k, column, estimate.terms[k]);
  });
  return rows.result();
}

Measurement measure(const VelocityFix& fix, const Estimate& estimate) {
  const Matrix3d C = estimate.motion.pose.q_eb.toRotationMatrix();
  const Vector3d swing = C * estimate.motion.w_eb_b.cross(fix.lever_arm);
  Rows rows(estimate, fix.axes, fix.v_eb_e - estimate.motion.pose.v_eb_e - swing, fix.sigma);
  rows.block(kVelocity, Matrix3d::Identity());
  rows.block(kAttitude, -earth::skew(swing));
  const auto& terms = estimate.model->terms;
  for (std::size_t k = 0; k < terms.size(); ++k)  // w_eb_b holds the estimates already: only the columns
    if (terms[k].carrier == Carrier::gyro && terms[k].effect == Effect::bias)
      rows.term(k, C * fix.lever_arm.cross(Vector3d::Unit(terms[k].axis)), 0);
  each_term(estimate, fix.aid, [&](std::size_t k, const ErrorTerm& term) {
    const Vector3d column = term.effect == Effect::lever_arm
                                ? Vector3d(C * estimate.motion.w_eb_b.cross(Vector3d::Unit(term.axis)))
                            : term.effect == Effect::bias ? Vector3d(fix.axes.col(term.axis))
                                                          : estimate.motion.a_eb_e;
    rows.term(k, column, estimate.terms[k]);
  });
  return rows.result();
}

Measurement measure(const HeightFix& fix, const Estimate& estimate) {
  const earth::Geodetic at = earth::to_geodetic(estimate.motion.pose.p_eb_e);
  const Vector3d up = earth::up_e(at.latitude, at.longitude);
  Measurement result;
  result.rows = 1;
  result.residual[0] = fix.height - at.height;
  MeasurementRow& row = result.row[0];
  row.h = StateVector::Zero(estimate.model->states());
  row.variance = variance(fix.sigma);
  row.h.segment<3>(kPosition) = up;
  each_term(estimate, fix.aid, [&](std::size_t k, const ErrorTerm& term) {
    if (term.effect == Effect::lever_arm || (term.effect == Effect::bias && term.axis != 0)) return;
    const double column = term.effect == Effect::bias ? 1 : up.dot(estimate.motion.pose.v_eb_e);
    row.h[kCoreStates + static_cast<int>(k)] = column;
    result.residual[0] -= column * estimate.terms[k];
  });
  return result;
}

Measurement measure(const AttitudeFix& fix, const Estimate& estimate) {
  const Matrix3d C = estimate.motion.pose.q_eb.toRotationMatrix();
  const Vector3d residual = earth::log_rotation(fix.q_eb * estimate.motion.pose.q_eb.conjugate());
  Rows rows(estimate, C, residual, fix.sigma);
  rows.block(kAttitude, Matrix3d::Identity());
  each_term(estimate, fix.aid, [&](std::size_t k, const ErrorTerm& term) {
    if (term.effect == Effect::lever_arm) return;
    const Vector3d column =
        term.effect == Effect::bias ? Vector3d(C.col(term.axis)) : Vector3d(C * estimate.motion.w_eb_b);
    rows.term(k, column, estimate.terms[k]);
  });
  return rows.result();
}

}  // namespace gyrobudget::inline v0::navigation

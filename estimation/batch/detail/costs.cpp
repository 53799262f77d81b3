// SPDX-License-Identifier: MIT
#include "costs.h"

#include "gyrobudget/estimation/navigation/detail/measure_fix.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/gravity.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::batch::detail {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using navigation::kAttitude;
using navigation::kCoreStates;
using navigation::kPosition;
using navigation::kVelocity;

// What numbers in double hold of a pose, one sigma: without it an ideal IMU would weigh infinitely.
constexpr double kLeastPosition = 1e-6, kLeastVelocity = 1e-7, kLeastAttitude = 1e-9;  // m, m/s, rad

void add_least(MatrixXd& P) {
  for (int i = 0; i < 3; ++i) {
    P(kPosition + i, kPosition + i) += kLeastPosition * kLeastPosition;
    P(kVelocity + i, kVelocity + i) += kLeastVelocity * kLeastVelocity;
    P(kAttitude + i, kAttitude + i) += kLeastAttitude * kLeastAttitude;
  }
}

// pose less reference as errors of the core.
Eigen::Matrix<double, kCoreStates, 1> difference(const earth::Pose& pose, const earth::Pose& reference) {
  Eigen::Matrix<double, kCoreStates, 1> d;
  d << pose.p_eb_e - reference.p_eb_e, pose.v_eb_e - reference.v_eb_e,
      earth::log_rotation(pose.q_eb * reference.q_eb.conjugate());
  return d;
}

double decay_of(const Layout& layout, int term, double dt) {
  return navigation::decay(layout.model.terms[static_cast<std::size_t>(term)], dt);
}

// Columns by all terms of the model at a time: those of chains go to a node, the others, decayed, to the globals.
void split(const Layout& layout, const MatrixXd& by_terms, double since_start, MatrixXd& node, MatrixXd& global) {
  for (std::size_t i = 0; i < layout.chained.size(); ++i)
    node.col(kCoreStates + static_cast<int>(i)) += by_terms.col(layout.chained[i]);
  for (std::size_t i = 0; i < layout.global.size(); ++i)
    global.col(static_cast<int>(i)) += decay_of(layout, layout.global[i], since_start) * by_terms.col(layout.global[i]);
}

class Prior final : public Cost {
 public:
  Prior(const Layout& layout, const earth::Pose& start, const navigation::StateMatrix& P0)
      : Cost({0}), layout_(layout), start_(start) {
    MatrixXd P = P0;
    add_least(P);
    W_ = whitening(P);
  }
  [[nodiscard]] int rows() const override { return static_cast<int>(W_.rows()); }
  [[nodiscard]] Linear linearise(const std::vector<Node>& at, const VectorXd& global) const override {
    VectorXd x(W_.cols());
    const auto core = difference(at[0].pose, start_);
    x << core, terms_at(layout_, at[0], global, at[0].time);
    MatrixXd by_core = W_.leftCols<kCoreStates>();
    by_core.middleCols<3>(kAttitude) *= inverse_left_jacobian(core.segment<3>(kAttitude));
    Linear result{W_ * x, {MatrixXd::Zero(rows(), layout_.node_size())}, MatrixXd::Zero(rows(), layout_.global_size())};
    result.nodes[0].leftCols<kCoreStates>() = by_core;
    split(layout_, W_.rightCols(W_.cols() - kCoreStates), 0, result.nodes[0], result.global);
    return result;
  }

 private:
  const Layout& layout_;
  earth::Pose start_;
  MatrixXd W_;
};

class Moved final : public Cost {
 public:
  Moved(const Layout& layout, int from, const Increment& increment, double since)
      : Cost({from, from + 1}), layout_(layout), increment_(increment), since_(since) {
    std::vector<int> rows(kCoreStates);
    for (int i = 0; i < kCoreStates; ++i) rows[static_cast<std::size_t>(i)] = i;
    for (const int k : layout.chained) rows.push_back(kCoreStates + k);
    MatrixXd Q = increment.Q(rows, rows);
    add_least(Q);
    W_ = whitening(Q);
  }
  [[nodiscard]] int rows() const override { return static_cast<int>(W_.rows()); }
  [[nodiscard]] Linear linearise(const std::vector<Node>& at, const VectorXd& global) const override {
    const int n = layout_.node_size();
    const Prediction end = predict(increment_, at[0].pose, terms_at(layout_, at[0], global, since_));
    const auto core = difference(at[1].pose, end.pose);
    const Eigen::Matrix3d left = inverse_left_jacobian(core.segment<3>(kAttitude));
    VectorXd x(n);
    x.head<kCoreStates>() = core;
    MatrixXd J0 = MatrixXd::Zero(n, n), J1 = MatrixXd::Identity(n, n), Jg = MatrixXd::Zero(n, layout_.global_size());
    J0.topLeftCorner<kCoreStates, kCoreStates>() = -end.core;
    MatrixXd by_terms = MatrixXd::Zero(n, end.terms.cols());
    by_terms.topRows<kCoreStates>() = -end.terms;
    split(layout_, by_terms, at[0].time - since_, J0, Jg);
    const Eigen::Matrix3d right = left.transpose();  // J_r^-1(e) = J_l^-1(-e)
    J0.middleRows<3>(kAttitude) = right * J0.middleRows<3>(kAttitude).eval();
    Jg.middleRows<3>(kAttitude) = right * Jg.middleRows<3>(kAttitude).eval();
    J1.block<3, 3>(kAttitude, kAttitude) = left;
    for (std::size_t i = 0; i < layout_.chained.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      const double decay = increment_.decay[layout_.chained[i]];
      x[kCoreStates + k] = at[1].chained[k] - decay * at[0].chained[k];
      J0(kCoreStates + k, kCoreStates + k) = -decay;
    }
    return {W_ * x, {W_ * J0, W_ * J1}, W_ * Jg};
  }

 private:
  const Layout& layout_;
  const Increment& increment_;
  double since_;
  MatrixXd W_;
};

class Fixed final : public Cost {
 public:
  Fixed(const Layout& layout, int node, const Sensed& sensed, const navigation::Aid& aid, int number,
        const navigation::Fix& fix, double since)
      : Cost({node}), layout_(layout), sensed_(sensed), aid_(aid), number_(number), fix_(fix), since_(since) {}
  [[nodiscard]] int rows() const override { return navigation::rows(aid_.kind); }
  [[nodiscard]] Linear linearise(const std::vector<Node>& at, const VectorXd& global) const override {
    VectorXd terms = terms_at(layout_, at[0], global, since_);
    navigation::Estimate there = estimate(at[0], terms);
    const Vector3d force = there.motion.pose.q_eb * (sensed_.f_ib_b - errors(terms).accelerometer);
    navigation::Aid aid = aid_;
    const double late = take_in(terms, aid);
    move(there.motion, late);
    const navigation::Measurement m =
        navigation::detail::measure_fix(aid, number_, fix_, there, navigation::detail::sigma_of(aid_, fix_));
    MatrixXd H(rows(), kCoreStates + terms.size());
    VectorXd r(rows());
    for (int i = 0; i < rows(); ++i) {
      const auto& row = m.row[static_cast<std::size_t>(i)];
      const double sigma = std::sqrt(row.variance);
      r[i] = m.residual[i] / sigma;
      H.row(i) = -row.h.transpose() / sigma;
    }
    const MatrixXd by_p = H.middleCols<3>(kPosition), by_v = H.middleCols<3>(kVelocity);
    const earth::Motion& at_fix = there.motion;
    for (Eigen::Index k = 0; k < terms.size(); ++k)  // aiding.h has no turn of the lever arm in a velocity's
      if (is_of_aid(k, navigation::Effect::time_tag))
        H.col(kCoreStates + k) = by_p * at_fix.pose.v_eb_e + by_v * at_fix.a_eb_e +
                                 H.middleCols<3>(kAttitude) * (at_fix.pose.q_eb.toRotationMatrix() * at_fix.w_eb_b);
    // Errors at the node, `late` before: dv moves p, psi turns the force that moves both.
    H.middleCols<3>(kVelocity) += late * by_p;
    H.middleCols<3>(kAttitude) -= (late * by_v + late * late / 2 * by_p) * earth::skew(force);
    Linear result{r, {MatrixXd::Zero(rows(), layout_.node_size())}, MatrixXd::Zero(rows(), layout_.global_size())};
    result.nodes[0].leftCols<kCoreStates>() = H.leftCols<kCoreStates>();
    split(layout_, H.rightCols(terms.size()), at[0].time - since_, result.nodes[0], result.global);
    return result;
  }

 private:
  // aiding.h is linear in an aid's terms. Lever arms and time tags may be large here: what is estimated of them becomes
  // a part of the aid, about which aiding.h linearises. Returns the time tag [s].
  double take_in(VectorXd& terms, navigation::Aid& aid) const {
    double late = 0;
    for (Eigen::Index k = 0; k < terms.size(); ++k) {
      const navigation::ErrorTerm& term = layout_.model.terms[static_cast<std::size_t>(k)];
      if (is_of_aid(k, navigation::Effect::lever_arm)) aid.lever_arm[term.axis] += std::exchange(terms[k], 0);
      if (is_of_aid(k, navigation::Effect::time_tag)) late += std::exchange(terms[k], 0);
    }
    return late;
  }

  [[nodiscard]] bool is_of_aid(Eigen::Index k, navigation::Effect effect) const {
    const navigation::ErrorTerm& term = layout_.model.terms[static_cast<std::size_t>(k)];
    return term.is_of_aid(number_) && term.effect == effect;
  }

  // With the acceleration and the rate that the IMU measured at the node.
  static void move(earth::Motion& motion, double dt) {
    motion.pose.p_eb_e += dt * motion.pose.v_eb_e + dt * dt / 2 * motion.a_eb_e;
    motion.pose.v_eb_e += dt * motion.a_eb_e;
    motion.pose.q_eb = motion.pose.q_eb * earth::exp_rotation(dt * motion.w_eb_b);
  }

  [[nodiscard]] navigation::SensorCorrection errors(const VectorXd& terms) const {
    return navigation::sensor_errors(layout_.model.terms, terms.data(), sensed_.w_ib_b, sensed_.f_ib_b);
  }

  // As Filter::estimate, from what the IMU measured there. Valid as long as `terms`.
  [[nodiscard]] navigation::Estimate estimate(const Node& node, const VectorXd& terms) const {
    const Vector3d earth_rate(0, 0, earth::wgs84::kEarthRate);
    const navigation::SensorCorrection error = errors(terms);
    navigation::Estimate estimate;
    estimate.motion.pose = node.pose;
    estimate.motion.w_eb_b = sensed_.w_ib_b - error.gyro - node.pose.q_eb.conjugate() * earth_rate;
    estimate.motion.a_eb_e = node.pose.q_eb * (sensed_.f_ib_b - error.accelerometer) +
                             earth::normal_gravity(node.pose.p_eb_e) - 2 * earth_rate.cross(node.pose.v_eb_e);
    estimate.model = &layout_.model;
    estimate.terms = terms.data();
    return estimate;
  }

  const Layout& layout_;
  Sensed sensed_;
  const navigation::Aid& aid_;
  int number_;
  const navigation::Fix& fix_;
  double since_;
};

}  // namespace

MatrixXd whitening(const MatrixXd& P) {
  constexpr double kLeast = 1e-12;
  const VectorXd scale = P.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt();
  const VectorXd inverse = scale.cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(inverse.asDiagonal() * P * inverse.asDiagonal());
  const VectorXd weight = solver.eigenvalues().cwiseMax(kLeast).cwiseSqrt().cwiseInverse();
  return weight.asDiagonal() * solver.eigenvectors().transpose() * inverse.asDiagonal();
}

std::unique_ptr<Cost> prior_cost(const Layout& layout, const earth::Pose& start, const navigation::StateMatrix& P0) {
  return std::make_unique<Prior>(layout, start, P0);
}

std::unique_ptr<Cost> increment_cost(const Layout& layout, int from, const Increment& increment, double since) {
  return std::make_unique<Moved>(layout, from, increment, since);
}

std::unique_ptr<Cost> fix_cost(const Layout& layout, int node, const Sensed& sensed, const navigation::Aid& aid,
                               int number, const navigation::Fix& fix, double since) {
  return std::make_unique<Fixed>(layout, node, sensed, aid, number, fix, since);
}

}  // namespace gyrobudget::inline v0::batch::detail

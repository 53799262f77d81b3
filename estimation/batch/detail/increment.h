// SPDX-License-Identifier: MIT
// Inside batch: what an IMU says between two instants, integrated once and then carried to any start nearby.
//
// Forster, Carlone, Dellaert & Scaramuzza, On-Manifold Preintegration, IEEE Trans. Robotics 33:1 (2017), with Earth's
// rate and gravity: in axes that stand still in inertial space and are those of e at the start, over tau seconds,
//   C' = A C^',   v' = v + w x p + G1(p) + A u_v,   p' = p + tau (v + w x p) + G2(p) + A u_p,   A = C_eb C^_eb^T,
// where ^ marks the start and end that the IMU was integrated from and to, u_v and u_p are what its specific force
// adds there, and G1, G2 are the integrals of gravitation with its gradient at the start. The end turns back into e by
// w tau. That holds for any start; for other values of the sensor's terms u and C^' change to first order.
#pragma once

#include "gyrobudget/estimation/navigation/error_state.h"
#include "gyrobudget/estimation/navigation/recording.h"
#include "gyrobudget/estimation/navigation/strapdown.h"

#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::batch::detail {

/// Which terms are one number for the whole log (no walk: constant, or decaying by a known factor) and which have a
/// value at every node, in chains.
struct Layout {
  explicit Layout(const navigation::ErrorStateModel& model);
  navigation::ErrorStateModel model;
  std::vector<int> chained, global;  ///< indices in model.terms
  [[nodiscard]] int node_size() const { return navigation::kCoreStates + static_cast<int>(chained.size()); }
  [[nodiscard]] int global_size() const { return static_cast<int>(global.size()); }
};

/// The unknowns at one instant.
struct Node {
  double time = 0;  ///< [s]
  earth::Pose pose;
  Eigen::VectorXd chained;
};

/// All terms of the model at a node; globals are given at time `since` [s] and decay from there.
[[nodiscard]] Eigen::VectorXd terms_at(const Layout& layout, const Node& node, const Eigen::VectorXd& global,
                                       double since);

/// What the IMU measures at an instant, its errors included: means of the step that ends there.
struct Sensed {
  Eigen::Vector3d w_ib_b = Eigen::Vector3d::Zero();  ///< [rad/s]
  Eigen::Vector3d f_ib_b = Eigen::Vector3d::Zero();  ///< [m/s^2]
};

/// Preintegrated IMU data from one node to the next.
struct Increment {
  double tau = 0;             ///< [s]
  earth::Pose from, to;       ///< the start and the end that were integrated
  Eigen::VectorXd terms;      ///< of the model, at the start
  Eigen::MatrixXd coupling;   ///< 9 x terms: effect on dp, dv, psi at the end
  Eigen::VectorXd decay;      ///< of each term
  navigation::StateMatrix Q;  ///< covariance of noise over the interval: dp, dv, psi, terms
  Sensed end;                 ///< at the end, the first step's at `begin`
  Sensed begin;
};

/// The end from a start.
struct Prediction {
  earth::Pose pose;
  navigation::CoreMatrix core;  ///< d(dp, dv, psi) at the end by those at the start
  Eigen::MatrixXd terms;        ///< and by the terms at the start, 9 x terms
};
[[nodiscard]] Prediction predict(const Increment& increment, const earth::Pose& from, const Eigen::VectorXd& terms);

/// J_l(phi)^-1 with log(exp(d) exp(phi)) = phi + J_l^-1 d; |phi| below 2 pi.
[[nodiscard]] Eigen::Matrix3d inverse_left_jacobian(const Eigen::Vector3d& phi);
/// J_l(phi) with exp(phi + d) = exp(J_l d) exp(phi).
[[nodiscard]] Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& phi);

/// Integrates the IMU from node to node.
class Preintegrator {
 public:
  /// All must outlive it. `order` of the strapdown, as in Strapdown::Options.
  Preintegrator(const navigation::Recording& recording, const Layout& layout,
                const navigation::Strapdown::Options& strapdown);

  /// One increment less than nodes. Work and memory go with the log's length.
  /// @throws earth::OutsideDomain and std::invalid_argument as Strapdown.
  [[nodiscard]] std::vector<Increment> operator()(const std::vector<Node>& nodes, const Eigen::VectorXd& global) const;

 private:
  const navigation::Recording& recording_;
  const Layout& layout_;
  navigation::Strapdown::Options strapdown_;
};

}  // namespace gyrobudget::inline v0::batch::detail

// SPDX-License-Identifier: MIT
// Inside batch: the terms of the sum of squares, whitened, with derivatives by errors in the order of error_state.h:
// truth is p + dp, v + dv, exp(psi) q, so Jacobians are by dp, dv, psi, chained terms of a node, and by the globals.
#pragma once

#include "gyrobudget/estimation/navigation/scenario.h"

#include <memory>
#include <vector>

#include "increment.h"

namespace gyrobudget::inline v0::batch::detail {

/// A residual and its derivatives by each node that it touches, and by the globals.
struct Linear {
  Eigen::VectorXd residual;
  std::vector<Eigen::MatrixXd> nodes;
  Eigen::MatrixXd global;
};

/// One term of the sum: half its squared residual, or a robust loss of that.
class Cost {
 public:
  virtual ~Cost() = default;
  /// @param at values of the nodes in nodes(), in its order
  [[nodiscard]] virtual Linear linearise(const std::vector<Node>& at, const Eigen::VectorXd& global) const = 0;
  [[nodiscard]] virtual int rows() const = 0;
  /// Numbers of the nodes that it touches, ascending.
  [[nodiscard]] const std::vector<int>& nodes() const { return nodes_; }

 protected:
  explicit Cost(std::vector<int> nodes) : nodes_(std::move(nodes)) {}

 private:
  std::vector<int> nodes_;
};

/// W with W P W^T = I. Directions in which P, scaled to a unit diagonal, is below 1e-12 count as 1e-12: what is certain
/// to more digits than numbers have.
[[nodiscard]] Eigen::MatrixXd whitening(const Eigen::MatrixXd& P);

/// What of the log's start is known before any fix.
[[nodiscard]] std::unique_ptr<Cost> prior_cost(const Layout& layout, const earth::Pose& start,
                                               const navigation::StateMatrix& P0);
/// The IMU between nodes `from` and from + 1, and chains of terms.
/// @param since the time at which globals are given [s]
[[nodiscard]] std::unique_ptr<Cost> increment_cost(const Layout& layout, int from, const Increment& increment,
                                                   double since);
/// A fix at a node by the models of aiding.h. `sensed`: what the IMU measured there.
/// The layout, the aid and the fix must outlive it.
[[nodiscard]] std::unique_ptr<Cost> fix_cost(const Layout& layout, int node, const Sensed& sensed,
                                             const navigation::Aid& aid, int number, const navigation::Fix& fix,
                                             double since);

}  // namespace gyrobudget::inline v0::batch::detail

// SPDX-License-Identifier: MIT
// Inside batch: the sum of squares as a problem of Ceres. Nothing of Ceres is seen outside solver.cpp.
#pragma once

#include "gyrobudget/estimation/batch/batch.h"

#include <memory>
#include <string>
#include <vector>

#include "costs.h"
#include "marginals.h"

namespace gyrobudget::inline v0::batch::detail {

struct Unknowns {
  std::vector<Node> nodes;
  Eigen::VectorXd global;
};

struct Solved {
  bool usable = false, converged = false;
  double first_cost = 0, cost = 0;
  int iterations = 0;
  std::string why;  ///< in words of Ceres, where not usable
};

/// Minimises the sum from where the unknowns are, and leaves them at its minimum. Costs from first_robust on have the
/// loss. One thread: the same bytes each time.
[[nodiscard]] Solved solve(const Layout& layout, const std::vector<std::unique_ptr<Cost>>& costs,
                           std::size_t first_robust, const Options& options, Unknowns& unknowns);

[[nodiscard]] Linear linearise(const Cost& cost, const Unknowns& unknowns);
/// Derivative of the loss by the squared residual.
[[nodiscard]] double weight(const Options& options, double squared);
/// Adds weight J^T J.
void add(const Linear& linear, const std::vector<int>& nodes, double weight, Information& information);

}  // namespace gyrobudget::inline v0::batch::detail

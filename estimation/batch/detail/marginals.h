// SPDX-License-Identifier: MIT
// Inside batch: covariances of the unknowns at each node, in work and memory that go with the number of nodes.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::batch::detail {

/// J^T J of a chain whose nodes touch their neighbours and unknowns that all share.
struct Information {
  Information(std::size_t nodes, int node_size, int shared_size);
  std::vector<Eigen::MatrixXd> own;     ///< node k by itself
  std::vector<Eigen::MatrixXd> next;    ///< node k by node k + 1; one less than nodes
  std::vector<Eigen::MatrixXd> shared;  ///< node k by the shared
  Eigen::MatrixXd among_shared;
};

/// Covariance of each node with the shared unknowns behind it: blocks of the inverse of the information. Nodes are
/// eliminated forwards by Cholesky and the inverse runs back (Takahashi, Fagan & Chen 1973, in blocks):
///   A_k = H_kk^-1 H_ks,  S_kk = H_kk^-1 + A_k S_ss A_k^T,  S_ks = -A_k S_ss,  s = (k + 1, shared).
/// Unknowns are scaled to a unit diagonal before. Empty where the information is not positive definite to rounding.
[[nodiscard]] std::vector<Eigen::MatrixXd> marginals(Information information);

}  // namespace gyrobudget::inline v0::batch::detail

// SPDX-License-Identifier: MIT
#include "marginals.h"

#include <algorithm>
#include <limits>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::batch::detail {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd scale_of(const MatrixXd& H) {
  return H.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
}

// To a unit diagonal; returns the scales, the last of which is that of the shared.
std::vector<VectorXd> scale(Information& H) {
  std::vector<VectorXd> scales;
  for (const MatrixXd& own : H.own) scales.push_back(scale_of(own));
  scales.push_back(scale_of(H.among_shared));
  const VectorXd& shared = scales.back();
  H.among_shared = shared.asDiagonal() * H.among_shared * shared.asDiagonal();
  for (std::size_t k = 0; k < H.own.size(); ++k) {
    H.own[k] = scales[k].asDiagonal() * H.own[k] * scales[k].asDiagonal();
    H.shared[k] = scales[k].asDiagonal() * H.shared[k] * shared.asDiagonal();
    if (k + 1 < H.own.size()) H.next[k] = scales[k].asDiagonal() * H.next[k] * scales[k + 1].asDiagonal();
  }
  return scales;
}

}  // namespace

Information::Information(std::size_t nodes, int node_size, int shared_size)
    : own(nodes, MatrixXd::Zero(node_size, node_size)),
      next(nodes - 1, MatrixXd::Zero(node_size, node_size)),
      shared(nodes, MatrixXd::Zero(node_size, shared_size)),
      among_shared(MatrixXd::Zero(shared_size, shared_size)) {}

std::vector<MatrixXd> marginals(Information H) {
  const std::vector<VectorXd> scales = scale(H);
  const std::size_t count = H.own.size();
  const Eigen::Index n = H.own[0].rows(), g = H.among_shared.rows();
  std::vector<MatrixXd> inverse(count), A(count);
  for (std::size_t k = 0; k < count; ++k) {
    const bool last = k + 1 == count;
    MatrixXd B(n, (last ? 0 : n) + g);
    if (last)
      B = H.shared[k];
    else
      B << H.next[k], H.shared[k];
    const Eigen::LLT<MatrixXd> factor(H.own[k]);
    if (factor.info() != Eigen::Success) return {};
    inverse[k] = factor.solve(MatrixXd::Identity(n, n));
    A[k] = factor.solve(B);
    const MatrixXd taken = B.transpose() * A[k];
    H.among_shared -= taken.bottomRightCorner(g, g);
    if (last) continue;
    H.own[k + 1] -= taken.topLeftCorner(n, n);
    H.shared[k + 1] -= taken.topRightCorner(n, g);
  }
  MatrixXd behind(g, g);  // covariance of what node k is eliminated against
  if (g > 0) {
    const Eigen::LLT<MatrixXd> factor(H.among_shared);
    if (factor.info() != Eigen::Success) return {};
    behind = factor.solve(MatrixXd::Identity(g, g));
  }
  std::vector<MatrixXd> result(count);
  const MatrixXd shared = behind;
  for (std::size_t k = count; k-- > 0;) {
    const MatrixXd with = -A[k] * behind;
    MatrixXd S(n + g, n + g);
    S.topLeftCorner(n, n) = inverse[k] - with * A[k].transpose();
    S.topRightCorner(n, g) = with.rightCols(g);
    S.bottomLeftCorner(g, n) = with.rightCols(g).transpose();
    S.bottomRightCorner(g, g) = shared;
    behind = S;
    VectorXd unit(n + g);
    unit << scales[k], scales.back();
    result[k] = unit.asDiagonal() * S * unit.asDiagonal();
  }
  return result;
}

}  // namespace gyrobudget::inline v0::batch::detail

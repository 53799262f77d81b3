// SPDX-License-Identifier: MIT
#include "solver.h"

#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <exception>

namespace gyrobudget::inline v0::batch::detail {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using navigation::kAttitude;
using navigation::kCoreStates;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A node as Ceres moves it: attitude on its manifold, position and velocity off where they began, so that steps are
// not compared with the radius of Earth.
struct Blocks {
  std::array<double, 4> q;
  std::array<double, 6> moved{};
  VectorXd chained;
};

Blocks blocks_of(const Node& node) {
  Blocks blocks;
  Eigen::Map<Eigen::Vector4d>(blocks.q.data()) = node.pose.q_eb.coeffs();
  blocks.chained = node.chained;
  return blocks;
}

Node node_of(const Node& origin, const double* q, const double* moved, const double* chained) {
  Node node = origin;
  node.pose.q_eb = Eigen::Map<const Eigen::Quaterniond>(q).normalized();
  node.pose.p_eb_e += Eigen::Map<const Eigen::Vector3d>(moved);
  node.pose.v_eb_e += Eigen::Map<const Eigen::Vector3d>(moved + 3);
  if (node.chained.size() > 0) node.chained = Eigen::Map<const VectorXd>(chained, node.chained.size());
  return node;
}

std::unique_ptr<ceres::LossFunction> loss_of(const Options& options) {
  switch (options.loss) {
    case Loss::huber:
      return std::make_unique<ceres::HuberLoss>(options.scale);
    case Loss::cauchy:
      return std::make_unique<ceres::CauchyLoss>(options.scale);
    case Loss::squares:
      break;
  }
  return nullptr;
}

// Parameters: of each node q, moved and chained where there are any; then the globals where there are any.
class CostForCeres final : public ceres::CostFunction {
 public:
  CostForCeres(const Cost& cost, const std::vector<Node>& origins, int chained, int global)
      : cost_(cost), chained_(chained), global_(global) {
    set_num_residuals(cost.rows());
    for (const int k : cost.nodes()) {
      origins_.push_back(origins[static_cast<std::size_t>(k)]);
      for (const int size : {4, 6, chained})
        if (size > 0) mutable_parameter_block_sizes()->push_back(size);
    }
    if (global > 0) mutable_parameter_block_sizes()->push_back(global);
  }

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const std::size_t each = chained_ > 0 ? 3 : 2;
    std::vector<Node> at;
    for (std::size_t i = 0; i < origins_.size(); ++i) {
      const double* const* own = parameters + i * each;
      at.push_back(node_of(origins_[i], own[0], own[1], chained_ > 0 ? own[2] : nullptr));
    }
    VectorXd global(global_);
    const std::size_t last = origins_.size() * each;
    if (global_ > 0) global = Eigen::Map<const VectorXd>(parameters[last], global_);
    Linear linear;
    try {
      linear = cost_.linearise(at, global);
    } catch (const earth::OutsideDomain&) {
      return false;  // a step too far: Ceres takes a shorter one
    }
    Eigen::Map<VectorXd>(residuals, num_residuals()) = linear.residual;
    if (jacobians == nullptr) return linear.residual.allFinite();
    for (std::size_t i = 0; i < at.size(); ++i)
      node_jacobians(linear.nodes[i], parameters[i * each], jacobians + i * each);
    if (global_ > 0 && jacobians[last] != nullptr)
      Eigen::Map<RowMajor>(jacobians[last], num_residuals(), global_) = linear.global;
    return linear.residual.allFinite();
  }

 private:
  // By the four numbers of q: Ceres' step is half of psi on the left, and the columns of its derivative of q are
  // orthonormal.
  void node_jacobians(const MatrixXd& J, const double* q, double** jacobians) const {
    if (jacobians[0] != nullptr) {
      Eigen::Matrix<double, 4, 3, Eigen::RowMajor> plus;
      ceres::EigenQuaternionManifold().PlusJacobian(q, plus.data());
      Eigen::Map<RowMajor>(jacobians[0], num_residuals(), 4) = 2 * J.middleCols<3>(kAttitude) * plus.transpose();
    }
    if (jacobians[1] != nullptr) Eigen::Map<RowMajor>(jacobians[1], num_residuals(), 6) = J.leftCols<6>();
    if (chained_ > 0 && jacobians[2] != nullptr)
      Eigen::Map<RowMajor>(jacobians[2], num_residuals(), chained_) = J.rightCols(chained_);
  }

  const Cost& cost_;
  std::vector<Node> origins_;
  int chained_, global_;
};

ceres::Solver::Options solver_options(const Options& options) {
  ceres::Solver::Options ceres;
  ceres.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres.logging_type = ceres::SILENT;
  ceres.num_threads = 1;
  ceres.initial_trust_region_radius = 1e8;  // near the minimum full steps are right
  ceres.function_tolerance = 1e-9;
  ceres.gradient_tolerance = 1e-12;
  ceres.parameter_tolerance = 1e-14;
  ceres.max_num_iterations = options.iterations;
  ceres.max_num_consecutive_invalid_steps = options.iterations + 1;
  return ceres;
}

}  // namespace

Solved solve(const Layout& layout, const std::vector<std::unique_ptr<Cost>>& costs, std::size_t first_robust,
             const Options& options, Unknowns& unknowns) {
  const int chained = static_cast<int>(layout.chained.size()), global = layout.global_size();
  std::vector<Blocks> blocks;
  for (const Node& node : unknowns.nodes) blocks.push_back(blocks_of(node));
  const std::unique_ptr<ceres::LossFunction> loss = loss_of(options);
  ceres::EigenQuaternionManifold manifold;
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ownership.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (Blocks& block : blocks) problem.AddParameterBlock(block.q.data(), 4, &manifold);
  for (std::size_t i = 0; i < costs.size(); ++i) {
    std::vector<double*> parameters;
    for (const int k : costs[i]->nodes()) {
      Blocks& block = blocks[static_cast<std::size_t>(k)];
      parameters.insert(parameters.end(), {block.q.data(), block.moved.data()});
      if (chained > 0) parameters.push_back(block.chained.data());
    }
    if (global > 0) parameters.push_back(unknowns.global.data());
    problem.AddResidualBlock(new CostForCeres(*costs[i], unknowns.nodes, chained, global),
                             i < first_robust ? nullptr : loss.get(), parameters);
  }
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(options), &problem, &summary);
  Solved solved;
  solved.usable = summary.IsSolutionUsable();
  solved.converged = summary.termination_type == ceres::CONVERGENCE;
  solved.first_cost = summary.initial_cost;
  solved.cost = summary.final_cost;
  solved.iterations = std::max(0, static_cast<int>(summary.iterations.size()) - 1);  // row 0 is the start
  solved.why = summary.message;
  for (std::size_t k = 0; k < blocks.size(); ++k)
    unknowns.nodes[k] =
        node_of(unknowns.nodes[k], blocks[k].q.data(), blocks[k].moved.data(), blocks[k].chained.data());
  return solved;
}

Linear linearise(const Cost& cost, const Unknowns& unknowns) {
  std::vector<Node> at;
  for (const int k : cost.nodes()) at.push_back(unknowns.nodes[static_cast<std::size_t>(k)]);
  return cost.linearise(at, unknowns.global);
}

double weight(const Options& options, double squared) {
  const std::unique_ptr<ceres::LossFunction> loss = loss_of(options);
  if (loss == nullptr) return 1;
  std::array<double, 3> rho{};
  loss->Evaluate(squared, rho.data());
  return rho[1];
}

void add(const Linear& linear, const std::vector<int>& nodes, double weight, Information& information) {
  const MatrixXd& G = linear.global;
  information.among_shared += weight * G.transpose() * G;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const auto k = static_cast<std::size_t>(nodes[i]);
    const MatrixXd& J = linear.nodes[i];
    information.own[k] += weight * J.transpose() * J;
    information.shared[k] += weight * J.transpose() * G;
    if (i + 1 < nodes.size()) information.next[k] += weight * J.transpose() * linear.nodes[i + 1];
  }
}

}  // namespace gyrobudget::inline v0::batch::detail

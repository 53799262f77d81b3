// SPDX-License-Identifier: MIT
#include "refine.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::fit {
namespace {

// The residual for Ceres, over u = c / start: every parameter is near 1 whatever its unit.
class RelativeCost : public ceres::CostFunction {
 public:
  RelativeCost(const WhitenedResidual& residual, Eigen::VectorXd scale)
      : residual_(residual), scale_(std::move(scale)) {
    set_num_residuals(static_cast<int>(residual.residuals()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(scale_.size()));
  }

  bool Evaluate(const double* const* parameters, double* residuals, double** jacobians) const override {
    const Eigen::VectorXd c = scale_.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(parameters[0], scale_.size()));
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = residual_.value(c);
    if (jacobians && jacobians[0]) {
      using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      Eigen::Map<RowMajor>(jacobians[0], num_residuals(), scale_.size()) = residual_.jacobian(c) * scale_.asDiagonal();
    }
    return true;
  }

 private:
  const WhitenedResidual& residual_;
  Eigen::VectorXd scale_;
};

ceres::Solver::Options solver_options() {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.initial_trust_region_radius = 1e12;  // the start is the optimum of the linear problem: take full steps
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-13;
  options.parameter_tolerance = 1e-12;
  options.max_num_iterations = 100;
  options.max_num_consecutive_invalid_steps = 100;  // fewer than iterations: Ceres would complain on stderr
  return options;
}

Eigen::MatrixXd covariance_at(ceres::Problem& problem, const double* block, const Eigen::VectorXd& scale) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.null_space_rank = -1;
  ceres::Covariance covariance(options);
  const std::vector<std::pair<const double*, const double*>> blocks{{block, block}};
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> relative(scale.size(), scale.size());
  if (!covariance.Compute(blocks, &problem) || !covariance.GetCovarianceBlock(block, block, relative.data())) {
    relative.setConstant(std::numeric_limits<double>::infinity());
  }
  return scale.asDiagonal() * relative * scale.asDiagonal();
}

}  // namespace

WhitenedResidual::WhitenedResidual(Eigen::MatrixXd whitened_A, Eigen::VectorXd whitened_s)
    : WA_(std::move(whitened_A)), Ws_(std::move(whitened_s)) {}

Eigen::VectorXd WhitenedResidual::value(const Eigen::VectorXd& c) const { return Ws_ - WA_ * c.cwiseAbs2(); }

Eigen::MatrixXd WhitenedResidual::jacobian(const Eigen::VectorXd& c) const { return -2 * WA_ * c.asDiagonal(); }

Refined refine(const WhitenedResidual& residual, const Eigen::VectorXd& start) {
  Eigen::VectorXd u = Eigen::VectorXd::Ones(start.size());
  ceres::Problem problem;
  problem.AddResidualBlock(new RelativeCost(residual, start), nullptr, u.data());
  ceres::Solver::Summary summary;
  ceres::Solve(solver_options(), &problem, &summary);
  Refined refined;
  refined.coefficients = start.cwiseProduct(u.cwiseAbs());  // c and -c are the same model
  refined.covariance = covariance_at(problem, u.data(), start);
  refined.iterations = std::max(0, static_cast<int>(summary.iterations.size()) - 1);  // row 0 is the start
  refined.converged = summary.termination_type == ceres::CONVERGENCE;
  return refined;
}

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#include "consistency.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include <Eigen/Eigenvalues>

namespace gyrobudget::inline v0::navigation {

double nees(const Eigen::Ref<const Eigen::VectorXd>& error, const Eigen::Ref<const Eigen::MatrixXd>& P) {
  if (P.rows() != P.cols() || P.rows() != error.size())
    throw std::invalid_argument(
        fmt::format("error of {}, covariance of {} x {}", error.size(), P.rows(), P.cols()));
  // Correlations, so that metres and radians meet on one scale.
  const Eigen::VectorXd sigma = P.diagonal().cwiseMax(0).cwiseSqrt();
  const Eigen::VectorXd inverse = (sigma.array() > 0).select(sigma.cwiseInverse(), 0);
  for (Eigen::Index i = 0; i < error.size(); ++i)
    if (sigma[i] == 0 && error[i] != 0) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(inverse.asDiagonal() * P * inverse.asDiagonal());
  const Eigen::VectorXd along = eigen.eigenvectors().transpose() * inverse.cwiseProduct(error);
  const double rounding = 1e-13 * static_cast<double>(error.size());
  double sum = 0;
  for (Eigen::Index i = 0; i < error.size(); ++i) {
    const double variance = eigen.eigenvalues()[i];
    if (variance > rounding)
      sum += along[i] * along[i] / variance;
    else if (along[i] * along[i] > 100 * rounding)
      return std::numeric_limits<double>::infinity();
  }
  return sum;
}

Band chi_square_mean_band(double dof, double count, double probability) {
  if (!(dof > 0) || !(count > 0) || !(probability > 0 && probability < 1))
    throw std::invalid_argument(
        fmt::format("chi-square of {} dof, mean of {}, probability {}: expected above 0, the "
                    "last below 1",
                    dof, count, probability));
  const boost::math::chi_squared distribution(dof * count);
  const double tail = (1 - probability) / 2;
  return {quantile(distribution, tail) / count, quantile(complement(distribution, tail)) / count};
}

Band sigma_ratio_band(double count, double probability) {
  const Band mean = chi_square_mean_band(1, count, probability);
  return {std::sqrt(mean.lower), std::sqrt(mean.upper)};
}

}  // namespace gyrobudget::inline v0::navigation

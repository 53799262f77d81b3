// SPDX-License-Identifier: MIT
#include "consistency.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include <Eigen/Eigenvalues>

namespace gyrobudget::inline v0::navigation {

namespace {

double rounding(Eigen::Index size) { return 1e-13 * static_cast<double>(size); }

void check_square(const Eigen::Ref<const Eigen::MatrixXd>& P, Eigen::Index size) {
  if (P.rows() != P.cols() || P.rows() != size)
    throw std::invalid_argument(fmt::format("error of {}, covariance of {} x {}", size, P.rows(), P.cols()));
}

}  // namespace

FirstOrderNees::FirstOrderNees(const Eigen::Ref<const Eigen::MatrixXd>& P, double threshold) {
  check_square(P, P.rows());
  if (!(threshold < 1))
    throw std::invalid_argument(
        fmt::format("directions of a variance below {} do not count, expected below 1", threshold));
  const Eigen::VectorXd sigma = P.diagonal().cwiseMax(0).cwiseSqrt();
  scale_ = (sigma.array() > 0).select(sigma.cwiseInverse(), 1);
  Eigen::MatrixXd correlations = scale_.asDiagonal() * P * scale_.asDiagonal();
  correlations.diagonal() -=
      (sigma.array() > 0).select(0, Eigen::VectorXd::Ones(sigma.size()));  // directions of their own
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlations);
  const double least = std::max(threshold, rounding(P.rows()));
  for (Eigen::Index k = 0; k < P.rows(); ++k) {
    const double variance = eigen.eigenvalues()[k];
    (variance > least ? counted_ : left_out_).push_back({eigen.eigenvectors().col(k), std::max(variance, 0.0)});
  }
}

double FirstOrderNees::along(const Direction& direction, const Eigen::Ref<const Eigen::VectorXd>& error) const {
  if (error.size() != scale_.size())
    throw std::invalid_argument(
        fmt::format("error of {}, covariance of {} x {}", error.size(), scale_.size(), scale_.size()));
  return direction.weights.dot(scale_.cwiseProduct(error));
}

double FirstOrderNees::operator()(const Eigen::Ref<const Eigen::VectorXd>& error) const {
  double sum = 0;
  for (const Direction& direction : counted_) {
    const double x = along(direction, error);
    sum += x * x / direction.variance;
  }
  return sum;
}

double nees(const Eigen::Ref<const Eigen::VectorXd>& error, const Eigen::Ref<const Eigen::MatrixXd>& P) {
  check_square(P, error.size());
  const FirstOrderNees directions(P, 0);
  for (const auto& direction : directions.left_out()) {
    const double x = directions.along(direction, error);
    // Of an axis without any variance the component is in its own unit: none is allowed.
    const bool of_others = (direction.weights.array() != 0 && P.diagonal().array() > 0).any();
    if (of_others ? x * x > 100 * rounding(error.size()) : x != 0) return std::numeric_limits<double>::infinity();
  }
  return directions(error);
}

Band chi_square_mean_band(double dof, double count, double probability) {
  if (!(dof > 0) || !(count > 0) || !(probability > 0 && probability < 1))
    throw std::invalid_argument(
        fmt::format("chi-square of {} dof, mean of {}, probability {}: expected above 0, the last below 1", dof, count,
                    probability));
  const boost::math::chi_squared distribution(dof * count);
  const double tail = (1 - probability) / 2;
  return {quantile(distribution, tail) / count, quantile(complement(distribution, tail)) / count};
}

Band sigma_ratio_band(double count, double probability) {
  const Band mean = chi_square_mean_band(1, count, probability);
  return {std::sqrt(mean.lower), std::sqrt(mean.upper)};
}

}  // namespace gyrobudget::inline v0::navigation

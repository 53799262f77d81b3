// SPDX-License-Identifier: MIT
#include "square.h"

#include <cmath>

namespace gyrobudget::inline v0::flight::detail {

namespace {

using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostStates, 1>;

}  // namespace

Factors::Factors(const Square& matrix) : lu_(matrix) {}

void Factors::solve(const double* f, double* x) const {
  const auto n = lu_.matrixLU().rows();
  Eigen::Map<Column>(x, n) = lu_.solve(Eigen::Map<const Column>(f, n));
}

double spectral_radius(Square power) {
  double log_norm = 0, weight = 1;
  for (int k = 0; k < 12; ++k) {  // the root of the norm of the 4096th power is the spectral radius to 1 %
    const double norm = power.norm();
    if (norm == 0) return 0;
    log_norm += weight * std::log(norm);
    power /= norm;
    power = (power * power).eval();
    weight /= 2;
  }
  return std::exp(log_norm);
}

}  // namespace gyrobudget::inline v0::flight::detail

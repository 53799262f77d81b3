// SPDX-License-Identifier: MIT
#include "quadratic_form.h"

#include <array>
#include <cmath>
#include <utility>
#include <variant>

#include "family_sum.h"
#include <Eigen/SparseCore>

namespace gyrobudget::inline v0::allan::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

struct Tap {
  Index phase;
  double weight;
};

/// Adds the squares of filters with few taps.
class Gram {
 public:
  explicit Gram(Index phases) : A_(MatrixXd::Zero(phases, phases)) {}

  template <std::size_t taps>
  void add(const std::array<Tap, taps>& filter, double weight = 1) {
    for (const auto& [i, a] : filter) {
      for (const auto& [j, b] : filter) A_(i, j) += weight * a * b;
    }
  }
  /// A form of the phases from k on.
  void add_block(Index k, const MatrixXd& squares) { A_.block(k, k, squares.rows(), squares.cols()) += squares; }

  [[nodiscard]] MatrixXd take() { return std::move(A_); }

 private:
  MatrixXd A_;
};

/// Second difference of sums over m of 3m values.
RowVectorXd modified_filter(Index m) {
  RowVectorXd filter = RowVectorXd::Ones(3 * m);
  filter.segment(m, m).setConstant(-2);
  return filter;
}

/// Mean over 6m places of the squared filter above, of 3m values that are detrended and continued evenly.
MatrixXd evenly_continued(Index m) {
  const Index length = 3 * m, half = length / 2, second = length - half;
  MatrixXd detrend = MatrixXd::Identity(length, length);
  RowVectorXd slope = RowVectorXd::Zero(length);
  slope.head(half).setConstant(-1);
  slope.tail(half).setConstant(1);
  slope /= static_cast<double>(half * second);
  for (Index j = 0; j < length; ++j) detrend.row(j) -= static_cast<double>(j) * slope;

  MatrixXd continued(3 * length, length);
  continued << detrend.colwise().reverse(), detrend, detrend.colwise().reverse();
  MatrixXd filtered(6 * m, length);
  for (Index i = 0; i < 6 * m; ++i) filtered.row(i) = modified_filter(m) * continued.middleRows(i, length);
  return filtered.transpose() * filtered / static_cast<double>(6 * m);
}

/// Terms of rates as terms of phases: y_i = x_{i+1} - x_i.
MatrixXd of_phases(const MatrixXd& of_rates) {
  const Index n = of_rates.rows();
  MatrixXd A = MatrixXd::Zero(n + 1, n + 1);
  A.topLeftCorner(n, n) += of_rates;
  A.bottomRightCorner(n, n) += of_rates;
  A.bottomLeftCorner(n, n) -= of_rates;
  A.topRightCorner(n, n) -= of_rates;
  return A;
}

/// x[i + m] - 2 x[i] + x[i - m]; a neighbour beyond an end is twice the end less its mirror image.
std::array<Tap, 5> reflected_taps(Index n, Index m, Index i) {
  const bool before = i<m, after = i + m> n;
  return {{{i, -2.},
           {before ? 0 : i - m, before ? 2. : 1.},
           {before ? m - i : i, before ? -1. : 0.},
           {after ? n : i + m, after ? 2. : 1.},
           {after ? 2 * n - i - m : i, after ? -1. : 0.}}};
}

void add_theo1(Gram& gram, Index m, Index k) {
  for (Index j = 1; j <= m / 2; ++j)
    gram.add<4>({{{k, 1.}, {k + m, 1.}, {k + j, -1.}, {k + m - j, -1.}}}, 1 / static_cast<double>(j));
}

/// Difference of the slopes of the lines through m and the next m values, times m^3 / 12 or so.
RowVectorXd parabolic_filter(Index m) {
  RowVectorXd filter(2 * m);
  for (Index j = 0; j < m; ++j) {
    filter[j] = static_cast<double>(m - 1) / 2 - static_cast<double>(j);
    filter[m + j] = -filter[j];
  }
  return filter;
}

/// The form of one term of the estimators that look at many neighbours at a time; empty for the others.
MatrixXd stretch_matrix(Estimator estimator, Index m) {
  switch (estimator) {
    case Estimator::mdev:
    case Estimator::tdev:
      return modified_filter(m).transpose() * modified_filter(m);
    case Estimator::mtotdev:
    case Estimator::ttotdev:
      return evenly_continued(m);
    case Estimator::htotdev:
      return of_phases(evenly_continued(m));
    case Estimator::pdev:
      return parabolic_filter(m).transpose() * parabolic_filter(m);
    default:
      return {};
  }
}

/// Mean and generalised covariance of the phases of a mix, in units of dt.
struct Phases {
  MatrixXd covariance;
  VectorXd mean;

  Phases(Index count, std::span<const noise::Process> mix, double dt)
      : covariance(count, count), mean(VectorXd::Zero(count)) {
    VectorXd at_lag = VectorXd::Zero(count);
    for (const noise::Process& process : mix) {
      if (const auto* ramp = std::get_if<noise::RateRamp>(&process)) {
        for (Index k = 0; k < count; ++k) mean[k] += ramp->r * dt * static_cast<double>(k * (k - 1)) / 2;
        continue;
      }
      for (Index h = 0; h < count; ++h)
        at_lag[h] += noise::phase_covariance(process, static_cast<double>(h), dt) / (dt * dt);
    }
    for (Index i = 0; i < count; ++i) {
      for (Index j = 0; j < count; ++j) covariance(i, j) = at_lag[std::abs(i - j)];
    }
  }
};

/// A R. The total deviation's form has a few diagonals only.
MatrixXd product(const MatrixXd& A, const MatrixXd& R) {
  constexpr Index kSparse = 10;  // times more zeros than numbers
  if (kSparse * (A.array() != 0).count() > A.size()) return A * R;
  const Eigen::SparseMatrix<double> sparse = A.sparseView();
  return sparse * R;
}

}  // namespace

MatrixXd estimator_matrix(Estimator estimator, std::int64_t samples, std::int64_t m, std::int64_t stride) {
  // The names of the time deviations stand for the modified ones: they differ by a constant.
  if (estimator == Estimator::tdev) estimator = Estimator::mdev;
  if (estimator == Estimator::ttotdev) estimator = Estimator::mtotdev;
  if (estimator == Estimator::htotdev && m == 1) estimator = Estimator::ohdev;
  if (estimator == Estimator::pdev && m == 1) estimator = Estimator::oadev;

  Gram gram(samples + 1);
  const MatrixXd stretch = stretch_matrix(estimator, m);

  double terms = 0;
  for (Index k = 0, end = family_positions(estimator, samples, m); k < end; k += stride, ++terms) {
    switch (estimator) {
      case Estimator::adev:
      case Estimator::oadev:
        gram.add<3>({{{k, 1.}, {k + m, -2.}, {k + 2 * m, 1.}}});
        break;
      case Estimator::hdev:
      case Estimator::ohdev:
        gram.add<4>({{{k, -1.}, {k + m, 3.}, {k + 2 * m, -3.}, {k + 3 * m, 1.}}});
        break;
      case Estimator::totdev:
        gram.add(reflected_taps(samples, m, k + 1));
        break;
      case Estimator::mdev:
      case Estimator::tdev:
      case Estimator::mtotdev:
      case Estimator::ttotdev:
      case Estimator::htotdev:
      case Estimator::pdev:
        gram.add_block(k, stretch);
        break;
      case Estimator::theo1:
        add_theo1(gram, m, k);
        break;
      case Estimator::theobr:
      case Estimator::theoh:
        break;
    }
  }
  return gram.take() * (family_scale(estimator, m, 1) / terms);
}

double reflected_expectation(std::span<const noise::Process> mix, std::int64_t samples, std::int64_t m, std::int64_t i,
                             double dt) {
  const auto taps = reflected_taps(samples, m, i);
  double sum = 0;
  for (const noise::Process& process : mix) {
    double mean = 0;
    if (const auto* ramp = std::get_if<noise::RateRamp>(&process)) {
      for (const auto& [k, a] : taps) mean += a * ramp->r * dt * dt * static_cast<double>(k * (k - 1)) / 2;
    }
    sum += mean * mean;
    for (std::size_t p = 0; p < taps.size(); ++p) {
      for (std::size_t q = 0; q < p; ++q) {
        const double weight = taps[p].weight * taps[q].weight;
        const auto lag = static_cast<double>(std::abs(taps[p].phase - taps[q].phase));
        if (weight != 0) sum += 2 * weight * noise::phase_covariance(process, lag, dt);
      }
      sum += taps[p].weight * taps[p].weight * noise::phase_covariance(process, 0, dt);
    }
  }
  return sum / (2 * static_cast<double>(m) * static_cast<double>(m) * dt * dt);
}

double expectation(const MatrixXd& A, std::span<const noise::Process> mix, double dt) {
  const Phases phases(A.rows(), mix, dt);
  return A.cwiseProduct(phases.covariance).sum() + phases.mean.dot(A * phases.mean);
}

Moments moments(const MatrixXd& A, std::span<const noise::Process> mix, double dt) {
  const Phases phases(A.rows(), mix, dt);
  const MatrixXd AR = product(A, phases.covariance);
  const VectorXd Amu = A * phases.mean;
  Moments result;
  result.expectation = AR.trace() + phases.mean.dot(Amu);
  result.variance = 2 * AR.cwiseProduct(AR.transpose()).sum() + 4 * Amu.dot(phases.covariance * Amu);
  return result;
}

}  // namespace gyrobudget::inline v0::allan::detail

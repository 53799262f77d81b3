// SPDX-License-Identifier: MIT
#include "covariance.h"

#include "gyrobudget/allan/detail/pair_sum.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::allan {
namespace {

Eigen::Index index(std::size_t i) { return static_cast<Eigen::Index>(i); }

}  // namespace

CurveCovariance::CurveCovariance(std::int64_t samples, std::vector<std::int64_t> factors, double dt,
                                 std::vector<noise::Process> processes, Form form, const Mask* mask)
    : factors_(std::move(factors)) {
  const detail::Setting setting = detail::make_setting(samples, dt, processes, form, mask);
  processes_ = setting.processes;
  const std::size_t count = factors_.size(), kinds = processes_.size();

  std::vector<detail::FactorFacts> facts(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { facts[i] = factor_facts(setting, factors_[i]); });
  expectation_.resize(index(count), index(kinds));
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t a = 0; a < kinds; ++a) expectation_(index(i), index(a)) = facts[i].expectation[a];
  }

  G_.assign(kinds * (kinds + 1) / 2, Eigen::MatrixXd(index(count), index(count)));
  tbb::parallel_for(std::size_t{0}, count * count, [&](std::size_t pair) {
    const std::size_t i = pair / count, j = pair % count;
    if (j < i) return;
    const std::vector<double> entries = pair_sum(setting, facts[i], facts[j]);
    for (std::size_t e = 0; e < entries.size(); ++e) {
      G_[e](index(i), index(j)) = G_[e](index(j), index(i)) = entries[e];
    }
  });
}

std::size_t CurveCovariance::entry(std::size_t a, std::size_t b) const {
  const auto [low, high] = std::minmax(a, b);
  return low * processes_.size() - low * (low + 1) / 2 + high;
}

Eigen::MatrixXd CurveCovariance::operator()(const Eigen::VectorXd& theta) const {
  const std::size_t kinds = processes_.size();
  if (theta.size() != index(kinds)) {
    throw std::invalid_argument(
        fmt::format("theta has {} squared coefficients; there are {} processes", theta.size(), kinds));
  }
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(expectation_.rows(), expectation_.rows());
  for (std::size_t a = 0; a < kinds; ++a) {
    for (std::size_t b = a; b < kinds; ++b) {
      S += (a == b ? 1 : 2) * theta[index(a)] * theta[index(b)] * G_[entry(a, b)];
    }
  }
  return S;
}

CurveCovariance CurveCovariance::subset(std::span<const std::size_t> factor_indices,
                                        std::span<const std::size_t> process_indices) const {
  CurveCovariance part;
  for (const std::size_t i : factor_indices) part.factors_.push_back(factors_.at(i));
  for (const std::size_t a : process_indices) part.processes_.push_back(processes_.at(a));
  const Eigen::Index rows = index(factor_indices.size());
  part.expectation_.resize(rows, index(process_indices.size()));
  for (std::size_t a = 0; a < process_indices.size(); ++a) {
    for (Eigen::Index i = 0; i < rows; ++i) {
      part.expectation_(i, index(a)) =
          expectation_(index(factor_indices[static_cast<std::size_t>(i)]), index(process_indices[a]));
    }
    for (std::size_t b = a; b < process_indices.size(); ++b) {
      const Eigen::MatrixXd& whole = G_[entry(process_indices[a], process_indices[b])];
      Eigen::MatrixXd& G = part.G_.emplace_back(rows, rows);
      for (Eigen::Index i = 0; i < rows; ++i) {
        for (Eigen::Index j = 0; j < rows; ++j) {
          G(i, j) = whole(index(factor_indices[static_cast<std::size_t>(i)]),
                          index(factor_indices[static_cast<std::size_t>(j)]));
        }
      }
    }
  }
  return part;
}

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "lag_moments.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "family_sum.h"
#include "lag_kernel.h"
#include "lag_sum.h"

namespace gyrobudget::inline v0::allan::detail {
namespace {

/// Covariances at some lags: of the noise, and of the means as if they were noise.
struct Covariances {
  std::vector<double> noise, means;
  explicit Covariances(std::size_t lags) : noise(lags), means(lags) {}
};

/// Of two second differences of phases over m, as the Allan variance has them.
Covariances allan_covariances(std::span<const noise::Process> mix, const Pair& pair, std::span<const double> u) {
  Covariances sum(u.size());
  std::vector<double> one(u.size());
  for (const noise::Process& process : mix) {
    const double theta = noise::coefficient(process) * noise::coefficient(process);
    lag_kernel(noise::with_coefficient(process, 1), pair, u, one);
    std::vector<double>& of_kind = deterministic(process) ? sum.means : sum.noise;
    for (std::size_t i = 0; i < u.size(); ++i) of_kind[i] += theta * one[i];
  }
  return sum;
}

/// A third difference is the difference of two second ones m apart; 1/6 stands where Allan has 1/2.
Covariances hadamard_covariances(std::span<const noise::Process> mix, const Pair& pair, std::span<const double> u) {
  const auto m = static_cast<double>(pair.m1);
  std::vector<double> ahead(u.begin(), u.end()), behind(ahead);
  for (double& lag : ahead) lag += m;
  for (double& lag : behind) lag = std::abs(lag - m);
  const Covariances here = allan_covariances(mix, pair, u), there = allan_covariances(mix, pair, ahead),
                    back = allan_covariances(mix, pair, behind);
  Covariances result(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) {
    result.noise[i] = (2 * here.noise[i] - there.noise[i] - back.noise[i]) / 3;
    result.means[i] = (2 * here.means[i] - there.means[i] - back.means[i]) / 3;
  }
  return result;
}

/// Mean of c(u + i - j) over i, j < m, at u = 0, 1, ..: differences of second sums.
std::vector<double> mean_over_pairs(const std::vector<double>& c, std::int64_t m, std::size_t lags) {
  const auto at = [&](std::int64_t u) { return c[static_cast<std::size_t>(std::abs(u))]; };
  std::vector<double> means(lags);
  double triangle = 0, rise = 0;  // sum_i (m - |i|) c(u + i), and what it grows by from u to u + 1
  for (std::int64_t i = -m; i <= m; ++i) triangle += static_cast<double>(m - std::abs(i)) * at(i);
  for (std::int64_t i = 1; i <= m; ++i) rise += at(i) - at(1 - i);
  const auto pairs = static_cast<double>(m) * static_cast<double>(m);
  for (std::size_t u = 0; u < lags; ++u) {
    means[u] = triangle / pairs;
    triangle += rise;
    const auto next = static_cast<std::int64_t>(u) + 1;
    rise += at(next + m) - 2 * at(next) + at(next - m);
  }
  return means;
}

Covariances modified_covariances(std::span<const noise::Process> mix, const Pair& pair, std::size_t lags) {
  std::vector<double> u(lags + static_cast<std::size_t>(pair.m1) + 1);
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = static_cast<double>(i);
  const Covariances second = allan_covariances(mix, pair, u);
  Covariances result(lags);
  result.noise = mean_over_pairs(second.noise, pair.m1, lags);
  result.means = mean_over_pairs(second.means, pair.m1, lags);
  return result;
}

Moments collect(const Covariances& c, const LagNodes& nodes, std::int64_t terms) {
  const auto M = static_cast<double>(terms);
  double squares = 0;
  for (std::size_t i = 0; i < nodes.u.size(); ++i) {
    const double count = (M - nodes.u[i]) * (nodes.u[i] > 0 ? 2 : 1);
    squares += nodes.w[i] * count * c.noise[i] * (c.noise[i] + 2 * c.means[i]);
  }
  return {c.noise[0] + c.means[0], 2 * squares / (M * M)};
}

std::int64_t term_count(Estimator estimator, std::int64_t samples, std::int64_t m, std::int64_t stride) {
  return (family_positions(estimator, samples, m) + stride - 1) / stride;
}

Moments modified_moments(std::int64_t samples, std::int64_t m, std::int64_t stride, double dt,
                         std::span<const noise::Process> mix) {
  constexpr std::int64_t kFinest = 64;
  if (m > kFinest) {
    const double coarser = static_cast<double>(kFinest) / static_cast<double>(m);
    samples = rescaled_samples(Estimator::mdev, samples, m, kFinest);
    stride = std::max<std::int64_t>(1, std::llround(static_cast<double>(stride) * coarser));
    dt /= coarser;
    m = kFinest;
  }
  const std::int64_t terms = term_count(Estimator::mdev, samples, m, stride);
  constexpr std::int64_t kReach = 40;  // clusters; C^2 falls off as u^-4, and beyond lies less than 1e-5
  const std::int64_t lags = std::min(terms, kReach * m / stride + 1);
  const Covariances all = modified_covariances(mix, {m, m, dt}, static_cast<std::size_t>((lags - 1) * stride + 1));
  Covariances c(static_cast<std::size_t>(lags));
  LagNodes nodes;
  for (std::int64_t h = 0; h < lags; ++h) {
    nodes.u.push_back(static_cast<double>(h));
    nodes.w.push_back(1);
    c.noise[static_cast<std::size_t>(h)] = all.noise[static_cast<std::size_t>(h * stride)];
    c.means[static_cast<std::size_t>(h)] = all.means[static_cast<std::size_t>(h * stride)];
  }
  return collect(c, nodes, terms);
}

}  // namespace

bool is_stationary(Estimator estimator) {
  switch (estimator) {
    case Estimator::adev:
    case Estimator::oadev:
    case Estimator::mdev:
    case Estimator::tdev:
    case Estimator::hdev:
    case Estimator::ohdev:
      return true;
    default:
      return false;
  }
}

Moments lag_moments(Estimator estimator, std::int64_t samples, std::int64_t m, std::int64_t stride, double dt,
                    std::span<const noise::Process> mix) {
  if (estimator == Estimator::mdev || estimator == Estimator::tdev)
    return modified_moments(samples, m, stride, dt, mix);
  const std::int64_t terms = term_count(estimator, samples, m, stride);
  // The kinks of C lie at 0, m, 2m and 3m, here in strides; lag_nodes takes lags one by one 16 to either
  // side.
  const std::int64_t strides = std::max<std::int64_t>(1, (m + stride / 2) / stride);
  const LagNodes nodes = lag_nodes({strides, 2 * strides, dt}, terms);
  std::vector<double> u(nodes.u);
  for (double& lag : u) lag *= static_cast<double>(stride);
  const Pair pair{m, m, dt};
  const bool hadamard = estimator == Estimator::hdev || estimator == Estimator::ohdev;
  return collect(hadamard ? hadamard_covariances(mix, pair, u) : allan_covariances(mix, pair, u), nodes, terms);
}

}  // namespace gyrobudget::inline v0::allan::detail

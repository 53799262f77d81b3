// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/drift.h"

#include "gyrobudget/allan/detail/lag_kernel.h"
#include "gyrobudget/allan/detail/means.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr Eigen::Index kBlocks = 128;
constexpr std::int64_t kFewestSamples = 512;

Eigen::VectorXd differences(const Eigen::VectorXd& means) {
  return means.tail(means.size() - 1) - means.head(means.size() - 1);
}

Eigen::VectorXd block_means(const RateRecord& record, std::int64_t m) {
  Eigen::VectorXd means(kBlocks);
  for (Eigen::Index i = 0; i < kBlocks; ++i) means(i) = detail::mean_of(record.phase(), i * m, m);
  return means;
}

/// Covariance of the differences of adjacent block means, in units of their largest process.
Eigen::MatrixXd covariance(std::span<const noise::Process> processes, std::int64_t m, double dt) {
  std::vector<double> lags(kBlocks - 1), kernel(kBlocks - 1);
  for (std::size_t i = 0; i < lags.size(); ++i) lags[i] = static_cast<double>(i) * static_cast<double>(m);
  Eigen::VectorXd at_lag = Eigen::VectorXd::Zero(kBlocks - 1);
  double largest = 0;
  for (const auto& p : processes) largest = std::max(largest, noise::coefficient(p) * noise::coefficient(p));
  for (const auto& p : processes) {
    detail::lag_kernel(noise::with_coefficient(p, 1), {m, m, dt}, lags, kernel);
    const double weight = noise::coefficient(p) * noise::coefficient(p) / largest;
    at_lag += weight * Eigen::Map<const Eigen::VectorXd>(kernel.data(), kBlocks - 1);
  }
  Eigen::MatrixXd C(kBlocks - 1, kBlocks - 1);
  for (Eigen::Index i = 0; i < kBlocks - 1; ++i) {
    for (Eigen::Index j = 0; j < kBlocks - 1; ++j) C(i, j) = at_lag(std::abs(i - j));
  }
  return C;
}

/// Means over the blocks of exp(-t/T), T in blocks; of t over the record where T is infinite.
Eigen::VectorXd shape(double time_constant) {
  Eigen::VectorXd means(kBlocks);
  for (Eigen::Index i = 0; i < kBlocks; ++i) {
    const auto t = static_cast<double>(i);
    means(i) = std::isinf(time_constant)
                   ? (t + 0.5) / kBlocks
                   : -time_constant * std::exp(-t / time_constant) * std::expm1(-1 / time_constant);
  }
  return means;
}

}  // namespace

std::optional<Drift> find_drift(const RateRecord& record, std::span<const noise::Process> processes,
                                const DriftOptions& options) {
  if (!(options.false_alarm > 0 && options.false_alarm < 1)) {
    throw std::invalid_argument(
        fmt::format("false alarm probability is {}; it must be in (0, 1)", options.false_alarm));
  }
  if (processes.empty() || record.samples() < kFewestSamples) return std::nullopt;
  const std::int64_t m = record.samples() / kBlocks;
  const Eigen::VectorXd z = differences(block_means(record, m));
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance(processes, m, record.dt()));
  if (!z.allFinite() || factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd Wz = factor.matrixL().solve(z);

  constexpr double kTrend = std::numeric_limits<double>::infinity();
  constexpr double kTimeConstants[] = {2, 4, 8, 16, 32, 64, kTrend};  // blocks
  Drift best;
  double largest = 0;
  for (const double T : kTimeConstants) {
    const Eigen::VectorXd Wg = factor.matrixL().solve(differences(shape(T)));
    const double size = Wg.dot(Wz) / Wg.squaredNorm();
    const double explained = size * size * Wg.squaredNorm();
    const double left = (Wz.squaredNorm() - explained) / static_cast<double>(z.size() - 1);
    if (!(explained > largest * left)) continue;
    largest = explained / left;
    best.size = size;
    best.time_constant_s = T * static_cast<double>(m) * record.dt();
  }
  if (!(largest > 0)) return std::nullopt;
  const boost::math::fisher_f law(1, static_cast<double>(z.size() - 1));
  best.p_value =
      std::isinf(largest) ? 0 : std::min(1., std::size(kTimeConstants) * cdf(complement(law, largest)));
  if (best.p_value > options.false_alarm) return std::nullopt;
  return best;
}

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "departure.h"

#include "gyrobudget/allan/detail/lag_kernel.h"
#include "gyrobudget/allan/detail/means.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <fmt/core.h>

#include <algorithm>
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

Eigen::VectorXd block_means(const Series& record, std::int64_t m) {
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

/// Means over the blocks of exp(-t/T), T in blocks.
Eigen::VectorXd warm_up(double time_constant) {
  Eigen::VectorXd means(kBlocks);
  for (Eigen::Index i = 0; i < kBlocks; ++i) {
    means(i) = -time_constant * std::exp(-static_cast<double>(i) / time_constant) * std::expm1(-1 / time_constant);
  }
  return means;
}

constexpr double kTimeConstants[] = {2, 4, 8, 16, 32, 64};  // blocks
constexpr Eigen::Index kWarmUps = std::size(kTimeConstants);
constexpr Eigen::Index kTrend = kWarmUps, kFirstStep = kWarmUps + 1;

/// Differences of the block means of every shape, a column each: the warm-ups, the trend, the steps.
Eigen::MatrixXd shapes() {
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(kBlocks - 1, kFirstStep + kBlocks - 1);
  for (Eigen::Index i = 0; i < kWarmUps; ++i) G.col(i) = differences(warm_up(kTimeConstants[i]));
  G.col(kTrend).setConstant(1. / kBlocks);
  G.rightCols(kBlocks - 1).setIdentity();
  return G;
}

/// Where near the border of two blocks the means of the samples around it differ most.
std::int64_t place_step(const Series& record, std::int64_t border, std::int64_t m) {
  const std::int64_t begin = std::max<std::int64_t>(0, border - 2 * m);
  const std::int64_t end = std::min(record.samples(), border + 2 * m);
  std::int64_t place = border;
  double largest = -1;
  for (std::int64_t k = border - m + 1; k < border + m; ++k) {
    const double size = detail::mean_of(record.phase(), k, end - k) - detail::mean_of(record.phase(), begin, k - begin);
    // Sum of squares between the two parts.
    const double between = size * size * static_cast<double>(k - begin) * static_cast<double>(end - k);
    if (between > largest) largest = between, place = k;
  }
  return place;
}

Departure describe(const Series& record, std::int64_t m, Eigen::Index shape) {
  Departure departure;
  if (shape < kWarmUps) {
    departure.kind = Departure::Kind::warm_up;
    departure.time_constant_s = kTimeConstants[shape] * static_cast<double>(m) * record.dt();
  } else if (shape >= kFirstStep) {
    departure.kind = Departure::Kind::step;
    departure.index = place_step(record, (shape - kFirstStep + 1) * m, m);
  }
  return departure;
}

}  // namespace

std::optional<Departure> find_departure(const Series& record, std::span<const noise::Process> processes,
                                        const DepartureOptions& options) {
  if (!(options.false_alarm > 0 && options.false_alarm < 1)) {
    throw std::invalid_argument(
        fmt::format("false alarm probability is {}; it must be in (0, 1)", options.false_alarm));
  }
  if (processes.empty() || record.samples() < kFewestSamples) return std::nullopt;
  const std::int64_t m = record.samples() / kBlocks;
  const Eigen::VectorXd z = differences(block_means(record, m));
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance(processes, m, record.dt()));
  if (!z.allFinite() || !(z.squaredNorm() > 0) || factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd Wz = factor.matrixL().solve(z);
  const Eigen::MatrixXd WG = factor.matrixL().solve(shapes());
  const Eigen::VectorXd length = WG.colwise().norm();
  const Eigen::VectorXd projection = (WG.transpose() * Wz).cwiseQuotient(length);  // of z on each shape
  Eigen::Index shape = 0;
  projection.cwiseAbs().maxCoeff(&shape);
  const double explained = projection(shape) * projection(shape);
  const double left = std::max(0., Wz.squaredNorm() - explained) / static_cast<double>(z.size() - 1);
  const boost::math::fisher_f law(1, static_cast<double>(z.size() - 1));
  const double p = left > 0 ? cdf(complement(law, explained / left)) : 0;
  const double p_value = std::min(1., static_cast<double>(WG.cols()) * p);
  if (p_value > options.false_alarm) return std::nullopt;
  Departure departure = describe(record, m, shape);
  departure.size = projection(shape) / length(shape);
  departure.sigmas = left > 0 ? std::sqrt(explained / left) : std::numeric_limits<double>::infinity();
  departure.p_value = p_value;
  return departure;
}

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "angle_error.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

/// Extremes of 2^j neighbouring phases from every place on, for j = 0, 1, ... in turn.
class Extremes {
 public:
  explicit Extremes(std::span<const double> x) : least_(x.begin(), x.end()), most_(least_) {}

  /// The greatest max - min of `count` neighbours; counts must not fall from call to call.
  double greatest_range(std::size_t count) {
    while (2 * width_ <= count) double_width();
    const std::size_t second = count - width_;  // two windows that overlap cover it
    double greatest = 0;
    for (std::size_t k = 0; k + second < least_.size(); ++k) {
      greatest = std::max(greatest, std::max(most_[k], most_[k + second]) - std::min(least_[k], least_[k + second]));
    }
    return greatest;
  }

 private:
  void double_width() {
    const std::size_t left = least_.size() - width_;
    for (std::size_t k = 0; k < left; ++k) {
      least_[k] = std::min(least_[k], least_[k + width_]);
      most_[k] = std::max(most_[k], most_[k + width_]);
    }
    least_.resize(left);
    most_.resize(left);
    width_ *= 2;
  }

  std::vector<double> least_, most_;
  std::size_t width_ = 1;
};

double rms_of_steps(std::span<const double> x, std::size_t m) {
  detail::CompensatedSum squares;
  for (std::size_t k = 0; k + m < x.size(); ++k) {
    const double d = x[k + m] - x[k];
    squares.add(d * d);
  }
  return std::sqrt(squares.value() / static_cast<double>(x.size() - m));
}

}  // namespace

std::vector<AngleError> angle_error(const Series& record, std::span<const std::int64_t> factors) {
  for (const std::int64_t m : factors) {
    if (m >= 1 && m <= record.samples()) continue;
    throw std::invalid_argument(
        fmt::format("averaging factor is {}; it must be from 1 to the {} samples of the record", m, record.samples()));
  }
  if (factors.empty()) return {};
  const std::span<const double> x(record.phase().x.get(), static_cast<std::size_t>(record.samples()) + 1);
  std::vector<std::size_t> order(factors.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return factors[i]; });
  Extremes extremes(x);
  std::vector<AngleError> result(factors.size());
  const bool nothing = std::isnan(record.mean());
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  for (const std::size_t i : order) {
    const auto m = static_cast<std::size_t>(factors[i]);
    result[i] = {factors[i], static_cast<double>(m) * record.dt(), kNone, kNone};
    if (nothing) continue;
    result[i].rms = rms_of_steps(x, m) * record.dt();
    result[i].greatest = extremes.greatest_range(m + 1) * record.dt();
  }
  return result;
}

}  // namespace gyrobudget::inline v0::allan

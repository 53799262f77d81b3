// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/detail/first_order.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::noise::detail {
namespace {

/// First `a`, then `b`.
FirstOrder in_a_row(const FirstOrder& a, const FirstOrder& b) {
  const double left = 1 - b.decay;
  return {a.decay + b.decay * (1 - a.decay), a.gain + b.gain * (1 - a.decay), left * left * a.var_end + b.var_end,
          left * (a.covariance + b.gain * a.var_end) + b.covariance,
          a.var_sum + b.gain * (b.gain * a.var_end + 2 * a.covariance) + b.var_sum};
}

}  // namespace

FirstOrder FirstOrder::gauss_markov(double sigma, double correlation_time, double dt) {
  const double a = dt / correlation_time;
  return {-std::expm1(-a), 1, sigma * sigma * -std::expm1(-2 * a), 0, 0};
}

FirstOrder FirstOrder::walk(double k, double dt) { return {0, 1, k * k * dt, 0, 0}; }

FirstOrder FirstOrder::repeated(std::uint64_t steps) const {
  FirstOrder result, power = *this;
  for (; steps > 0; steps >>= 1) {
    if ((steps & 1) != 0) result = in_a_row(result, power);
    power = in_a_row(power, power);
  }
  return result;
}

FirstOrder::Draw FirstOrder::draw(double start, double u, double v) const {
  const double end_sigma = std::sqrt(var_end);
  const double along = end_sigma > 0 ? covariance / end_sigma : 0;
  const double across = std::sqrt(std::max(var_sum - along * along, 0.0));
  return {(1 - decay) * start + end_sigma * u, gain * start + along * u + across * v};
}

}  // namespace gyrobudget::inline v0::noise::detail

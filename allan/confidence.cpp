// SPDX-License-Identifier: MIT
#include "confidence.h"

#include "gyrobudget/allan/detail/pair_sum.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {

double equivalent_dof(std::int64_t samples, std::int64_t m, double dt, std::span<const noise::Process> mix, Form form,
                      const Mask* mask) {
  // Degrees of freedom know no scale: relative to the largest coefficient nothing over- or underflows.
  double largest = 0;
  for (const noise::Process& process : mix) largest = std::max(largest, std::abs(noise::coefficient(process)));
  if (!(largest > 0)) throw std::invalid_argument("degrees of freedom of no noise: all coefficients of the mix are 0");

  const detail::Setting setting = detail::make_setting(samples, dt, mix, form, mask);
  const detail::FactorFacts facts = factor_facts(setting, m);
  const std::vector<double> entries = pair_sum(setting, facts, facts);
  std::vector<double> theta;
  for (const noise::Process& process : mix) theta.push_back(std::pow(noise::coefficient(process) / largest, 2));

  double expectation = 0, variance = 0;
  auto entry = entries.begin();
  for (std::size_t a = 0; a < mix.size(); ++a) {
    expectation += theta[a] * facts.expectation[a];
    for (std::size_t b = a; b < mix.size(); ++b) variance += (a == b ? 1 : 2) * theta[a] * theta[b] * *entry++;
  }
  return 2 * expectation * expectation / variance;
}

Interval chi_square_interval(double variance, double edf, double confidence) {
  if (edf <= 0) throw std::invalid_argument(fmt::format("degrees of freedom are {}; they must be positive", edf));
  if (!(confidence > 0 && confidence < 1)) {
    throw std::invalid_argument(fmt::format("confidence is {}; it must be in (0, 1)", confidence));
  }
  if (std::isnan(variance) || std::isnan(edf)) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    return {kNaN, kNaN};
  }
  using namespace boost::math;
  constexpr double kNormal = 1e8;  // from here on the law is normal to 1e-8 of the variance, and the series of the
  if (edf > kNormal) {             // quantiles take too long
    const double half = quantile(complement(normal_distribution<>(), (1 - confidence) / 2)) * std::sqrt(2 / edf);
    return {variance / (1 + half), variance / (1 - half)};
  }
  using Quiet = policies::policy<policies::overflow_error<policies::ignore_error>,
                                 policies::underflow_error<policies::ignore_error>>;
  const chi_squared_distribution<double, Quiet> chi_square(edf);
  const double tail = (1 - confidence) / 2;
  const double above = quantile(complement(chi_square, tail)), below = quantile(chi_square, tail);
  return {variance * (edf / above), variance * (edf / below)};
}

}  // namespace gyrobudget::inline v0::allan

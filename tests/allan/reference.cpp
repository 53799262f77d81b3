// SPDX-License-Identifier: MIT
#include "reference.h"

#include <cmath>

namespace gyrobudget::allan::reference {
namespace {

struct Mean {
  long double value = 0;
  std::int64_t count = 0;
};

Mean mean_of(std::span<const double> cluster) {
  Mean mean;
  for (const double sample : cluster) {
    if (!std::isfinite(sample)) continue;
    mean.value += sample;
    ++mean.count;
  }
  mean.value /= static_cast<long double>(mean.count);
  return mean;
}

}  // namespace

Estimate overlapped_variance(std::span<const double> rate, std::int64_t m, Form form, double minimum_fill) {
  const auto length = static_cast<std::size_t>(m);
  Estimate estimate;
  for (std::size_t k = form == Form::full ? 0 : 1; k + 2 * length <= rate.size(); ++k) {
    const Mean first = mean_of(rate.subspan(k, length)), second = mean_of(rate.subspan(k + length, length));
    const double least = minimum_fill * static_cast<double>(m) - 1e-9;
    if (static_cast<double>(first.count) < least || static_cast<double>(second.count) < least) continue;
    if (first.count == 0 || second.count == 0) continue;
    const long double d = second.value - first.value;
    estimate.variance += d * d / 2;
    ++estimate.terms;
  }
  estimate.variance /= static_cast<long double>(estimate.terms);
  return estimate;
}

long double exact_overlapped_variance(std::span<const double> rate, double step, std::int64_t m) {
  __extension__ using Wide = __int128;
  std::vector<std::uint64_t> phase(rate.size() + 1);  // modulo 2^64: it may wrap, its second difference does not
  for (std::size_t k = 0; k < rate.size(); ++k) {
    phase[k + 1] = phase[k] + static_cast<std::uint64_t>(static_cast<std::int64_t>(rate[k] / step));
  }
  const auto length = static_cast<std::size_t>(m);
  const std::size_t terms = rate.size() - 2 * length + 1;
  Wide squares = 0;
  for (std::size_t k = 0; k < terms; ++k) {
    const auto d = static_cast<std::int64_t>(phase[k + 2 * length] - 2 * phase[k + length] + phase[k]);
    squares += static_cast<Wide>(d) * d;
  }
  return static_cast<long double>(squares) * step * step / (2.0L * m * m * terms);
}

}  // namespace gyrobudget::allan::reference

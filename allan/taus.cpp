// SPDX-License-Identifier: MIT
#include "taus.h"

#include <stdexcept>

#include "factors.h"

namespace gyrobudget::inline v0::allan {

std::vector<std::int64_t> factors_of(const Taus& taus, std::int64_t samples) {
  switch (taus.kind) {
    case Taus::Kind::octave:
      return octave_factors(samples);
    case Taus::Kind::decade:
      return decade_factors(samples);
    case Taus::Kind::all:
      return all_factors(samples);
    case Taus::Kind::logarithmic:
      return log_factors(samples, taus.count);
  }
  throw std::invalid_argument("taus: the kind is none of those that exist");
}

// The lists of factors.h end at n/2; an estimator that reaches further is given the list of a longer record.
std::vector<std::int64_t> factors_of(const Taus& taus, Estimator estimator, std::int64_t samples) {
  if (estimator == Estimator::oadev) return factors_of(taus, samples);
  const double longest = averaging_time(estimator, factor_range(estimator, samples).most, 1);
  return usable_factors(estimator, samples, factors_of(taus, 2 * static_cast<std::int64_t>(longest)));
}

}  // namespace gyrobudget::inline v0::allan

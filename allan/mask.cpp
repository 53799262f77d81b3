// SPDX-License-Identifier: MIT
#include "mask.h"

#include "gyrobudget/allan/detail/pair_sum.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::allan {

Mask::Mask(std::int64_t samples, std::vector<Gap> missing, double minimum_fill)
    : samples_(samples), minimum_fill_(minimum_fill), runs_(std::move(missing)) {
  constexpr std::int64_t kLimit = std::int64_t{1} << 32;
  if (samples < 0 || samples >= kLimit) {
    throw std::invalid_argument(fmt::format("a record with gaps has {} samples; it must be fewer than 2^32", samples));
  }
  if (!(minimum_fill > 0 && minimum_fill <= 1)) {
    throw std::invalid_argument(fmt::format("minimum fill of a cluster is {}; it must be in (0, 1]", minimum_fill));
  }
  std::int64_t free_from = 0;
  for (const Gap& run : runs_) {
    if (run.count < 1 || run.first < free_from || run.first > samples - run.count) {
      throw std::invalid_argument(fmt::format(
          "run of {} missing samples at {}: runs must ascend, not touch one another, and lie in a record of {} samples",
          run.count, run.first, samples));
    }
    free_from = run.first + run.count + 1;
    missing_ += run.count;
  }
}

std::int64_t Mask::minimum_count(std::int64_t m) const {
  // 0.95 is a little less or more than 19/20 in binary: forgive the last digits before rounding up.
  constexpr double kForgive = 1e-12;
  const double least = std::ceil(minimum_fill_ * static_cast<double>(m) * (1 - kForgive));
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(least));
}

double Mask::expectation_ratio(const noise::Process& process, std::int64_t m, double dt, Form form) const {
  const noise::Process processes[] = {process};
  const detail::FactorFacts facts = factor_facts(detail::make_setting(samples_, dt, processes, form, this), m);
  return facts.gain[0] * facts.gain[0];
}

}  // namespace gyrobudget::inline v0::allan

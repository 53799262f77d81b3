// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/form.h"
#include "gyrobudget/allan/mask.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>
#include <vector>

#include "triples.h"

namespace gyrobudget::inline v0::allan::detail {

/// All that the second moments of a record's Allan variances depend on.
struct Setting {
  std::int64_t samples;
  double dt;
  Form form;
  const Mask* mask;                       ///< null for a complete record
  std::vector<noise::Process> processes;  ///< with unit coefficients
};
/// @throws std::invalid_argument for a dt that is not positive and finite or a mask of another length.
[[nodiscard]] Setting make_setting(std::int64_t samples, double dt, std::span<const noise::Process>, Form, const Mask*);

/// What one averaging factor needs to know of the record.
struct FactorFacts {
  std::int64_t m = 1;
  std::int64_t terms = 0;           ///< triples that count
  std::vector<double> expectation;  ///< of the estimate, for each process; NaN where terms is 0
  std::vector<double> gain;         ///< root of what gaps multiply each expectation by; 1 without
  Triples triples;                  ///< only where there is a mask
};
/// @throws std::invalid_argument for m outside 1 .. n/2.
[[nodiscard]] FactorFacts factor_facts(const Setting&, std::int64_t m);

/// The covariance of the estimates at two factors as a quadratic form in the squared coefficients: entries (a, b >= a),
/// row by row, of the symmetric matrix G with cov = sum_ab theta_a theta_b G(a, b). NaN where a factor has no terms.
[[nodiscard]] std::vector<double> pair_sum(const Setting&, const FactorFacts&, const FactorFacts&);

}  // namespace gyrobudget::inline v0::allan::detail

// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "accuracy.h"

namespace gyrobudget::inline v0::fit {

enum class Quantity {
  rmse,
  bias,  ///< its size
  coverage,
  coverage_identified,
  identified,
  missed,
  false_terms,  ///< of a method, as those that follow
  p05,          ///< share with p < 0.05
  p01,
  unconverged,
  seconds,  ///< per fit
};

/// One limit on a measured accuracy.
struct Requirement {
  enum class Relative { none, bound, likelihood };
  std::string text;                 ///< as written
  std::optional<Method> method;     ///< unset: the first that was measured
  std::optional<noise::Term> term;  ///< unset: every coefficient with a truth above zero
  Quantity quantity = Quantity::rmse;
  double low = 0,
         high = 0;      ///< low <= quantity <= high, in units of `relative`; infinite where there is no limit
  bool strict = false;  ///< < and > rather than <= and >=
  Relative relative = Relative::none;
};

/// Reads requirements separated by commas:
///
///   [METHOD.][COEFFICIENT.]QUANTITY < NUMBER[*crlb | *likelihood]      also <=, >, >=
///   [METHOD.][COEFFICIENT.]QUANTITY in LOW..HIGH
///
/// METHOD as fit::name gives, COEFFICIENT a key of a sensor file (arw, bias_instability, rrw, vrw, ...) or a letter
/// (Q N B K R G S), QUANTITY one of rmse, bias, coverage, coverage_identified, identified, missed, false_terms, p05,
/// p01, unconverged, seconds. Numbers are fractions, not per cent. "arw.rmse<1.1*crlb, coverage in 0.93..0.97".
/// @throws std::invalid_argument with the column, what stands there and what may.
[[nodiscard]] std::vector<Requirement> parse_requirements(std::string_view text);

/// One number held against one requirement.
struct Check {
  std::string text;  ///< of the requirement
  Method method = Method::gls;
  std::optional<noise::Term> term;
  double value = 0;          ///< in units of the requirement: over the bound where it says *crlb
  double low = 0, high = 0;  ///< its limits
  bool met = false;          ///< false for a NaN value
};

/// Every number that each requirement is about. A requirement that is about none, because its method was not measured
/// or its coefficient was not fitted, gives one check that is not met, with a NaN value.
[[nodiscard]] std::vector<Check> check(const std::vector<Requirement>& requirements, const Accuracy& accuracy);

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#include "judgement.h"

#include <algorithm>

namespace gyrobudget::inline v0::fit {

bool is_reading(Method method) { return method == Method::visual || method == Method::slope; }

bool has_p_value(Method method) { return method == Method::gls || method == Method::whittle; }

bool is_tested(const Result& result) { return has_p_value(result.method) && result.dof > 0; }

bool is_quotable(const Result& result) {
  const bool refused = is_tested(result) && result.verdict == Verdict::not_described;
  return result.converged && !refused;
}

const Coefficient* find(const Result& result, noise::Term term) {
  const auto at = std::ranges::find(result.coefficients, term, &Coefficient::term);
  return at == result.coefficients.end() ? nullptr : &*at;
}

}  // namespace gyrobudget::inline v0::fit

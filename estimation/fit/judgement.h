// SPDX-License-Identifier: MIT
// What may be made of a fit.
#pragma once

#include "fit.h"

namespace gyrobudget::inline v0::fit {

/// Read off the plot, as by eye: no fit, no test.
[[nodiscard]] bool is_reading(Method method);
/// Whether a method can tell how well its model explains the record.
[[nodiscard]] bool has_p_value(Method method);
/// Whether it did: that takes more averaging times, or bands, than terms.
[[nodiscard]] bool is_tested(const Result& result);
/// False where the model does not describe the record or the fit did not converge: its coefficients must not be quoted.
[[nodiscard]] bool is_quotable(const Result& result);
/// The coefficient of a term; null where the method has none for it.
[[nodiscard]] const Coefficient* find(const Result& result, noise::Term term);

}  // namespace gyrobudget::inline v0::fit

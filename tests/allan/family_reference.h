// SPDX-License-Identifier: MIT
// The estimators as textbooks define them (NIST SP 1065 section 5.2), term by
// term in long double from phases; nothing is shared with the library.
#pragma once

#include "gyrobudget/allan/estimator.h"

#include <cstdint>
#include <span>

namespace gyrobudget::allan::reference {

/// Variance of an estimator at factor m, terms `stride` samples apart (adev and hdev: m apart by definition).
long double family_variance(Estimator, std::span<const double> rate, double dt, std::int64_t m,
                            std::int64_t stride = 1);

}  // namespace gyrobudget::allan::reference

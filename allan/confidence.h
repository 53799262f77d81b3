// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>

namespace gyrobudget::inline v0::allan {

/// Exact equivalent degrees of freedom 2 E[s]^2 / var(s) of the overlapped Allan variance at factor m for a Gaussian
/// sum of processes.
[[nodiscard]] double equivalent_dof(std::int64_t samples, std::int64_t m, double dt,
                                    std::span<const noise::Process> mix, Form = Form::full,
                                    const Mask* = nullptr);

struct Interval {
  double lower = 0;
  double upper = 0;
};
/// Two-sided chi-square interval of a variance.
[[nodiscard]] Interval chi_square_interval(double variance, double edf, double confidence = 0.95);

}  // namespace gyrobudget::inline v0::allan

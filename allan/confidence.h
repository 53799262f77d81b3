// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>

#include "form.h"
#include "mask.h"

namespace gyrobudget::inline v0::allan {

/// Equivalent degrees of freedom 2 E[s]^2 / var(s) of the overlapped Allan variance s at factor m for a Gaussian sum of
/// processes: exact, from the sum over all lags that CurveCovariance describes, with its error bounds (relative 2e-9;
/// 2 % with gaps). Rate ramp and sinusoid raise E[s] but vary only with the noise; for a mix of nothing else the
/// answer is infinite. NaN where no term exists (all lost to gaps; m = n/2 in Form::ieee).
///
/// A mix of one process answers for its kind: the coefficient drops out. Cost: 10 to 100 us per process.
///
/// @param samples length n of the record, missing ones included.
/// @param m averaging factor, 1 <= m <= n/2.
/// @param dt sample interval [s].
/// @throws std::invalid_argument for m or dt out of range, a mask of another length, or a mix whose coefficients are
/// all zero.
[[nodiscard]] double equivalent_dof(std::int64_t samples, std::int64_t m, double dt,
                                    std::span<const noise::Process> mix, Form form = Form::full,
                                    const Mask* mask = nullptr);

struct Interval {
  double lower = 0;
  double upper = 0;
};

/// Two-sided interval [edf s / q(1 - a/2), edf s / q(a/2)], a = 1 - confidence, of the expectation of an estimate s
/// that is distributed as chi-square with edf degrees of freedom, fractional ones too (NIST SP 1065 section 5.3). The
/// Allan variance is so nearly: a 95 % interval covers 95 % for edf > 20, 96 % near 10 and 97 % below 4 (it errs on the
/// safe side). Take roots for the deviation.
/// An infinite edf gives [s, s]; a tiny one an infinite upper end. NaN for s or edf gives NaN.
/// @throws std::invalid_argument for edf <= 0 or a confidence outside (0, 1).
[[nodiscard]] Interval chi_square_interval(double variance, double edf, double confidence = 0.95);

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/estimator.h"
#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>

#include "quadratic_form.h"

namespace gyrobudget::inline v0::allan::detail {

/// Whether every term of an estimator is the same filter of the phases, moved in time.
[[nodiscard]] bool is_stationary(Estimator);

/// First two moments of the estimate of a stationary estimator, for Gaussian noise, from the covariance C(u)
/// of two terms u samples apart: E = C(0), var = 2 / M^2 sum_h (M - |h|) C(h stride)^2 over the M terms.
///
/// C of the Allan terms is lag_kernel; that of the Hadamard terms is its second difference over m, that of
/// the modified ones its mean over pairs of the m places that each averages. Error: 1e-8 of the variance but
/// for the modified ones, which above m = 64 are looked at through 64 samples a cluster, at the same tau and
/// record length: below 5e-3 there.
///
/// A ramp is a mean (see lag_kernel); so is a sinusoid, averaged over its phase.
[[nodiscard]] Moments lag_moments(Estimator, std::int64_t samples, std::int64_t m, std::int64_t stride, double dt,
                                  std::span<const noise::Process> mix);

}  // namespace gyrobudget::inline v0::allan::detail

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>

#include <Eigen/Core>

namespace gyrobudget::inline v0::fit {

/// Fisher information of the logarithms of squared coefficients, ln theta_a, in a record of `samples` rates.
///
/// The differenced record has DST-I coefficients of variance lambda_k = 4 sin^2(pi f_k dt) S(f_k)/dt at
/// f_k = k/(2 n dt), k = 1..n-1 (exactly diagonal for white noise plus random walk, nearly so for flicker), hence
///   I_ab = 1/2 sum_k g_a g_b,  g_a = theta_a S_a(f_k) / S(f_k).
/// The sum is exact for k <= 4096; beyond, it is integrated over panels of ratio 1.25, error below 1e-7 relative.
/// @param processes  random processes (Q, N, B, K, G) with coefficients above zero; samples >= 3, dt > 0.
/// @throws std::invalid_argument otherwise.
/// Source: Whittle's approximation to the Gaussian likelihood; see the project's theory of the DST likelihood.
[[nodiscard]] Eigen::MatrixXd fisher_information(std::span<const noise::Process> processes, std::int64_t samples,
                                                 double dt);

/// Cramer-Rao bound on the relative standard deviation of each coefficient, sqrt(diag(I^-1))/2.
/// Reached by the fit for bounds below about 10 %; a lower bound above that (the fit of B is 3 to 15 % worse).
[[nodiscard]] Eigen::VectorXd relative_bound(std::span<const noise::Process> processes, std::int64_t samples,
                                             double dt);

/// The same where the bandwidth of every FilteredWhite among them is unknown too: what any fit reaches that has to find
/// it. The derivative of ln S by the logarithm of a bandwidth is a central difference of step 1e-4, error below 1e-7.
[[nodiscard]] Eigen::VectorXd relative_bound_unknown_bandwidth(std::span<const noise::Process> processes,
                                                               std::int64_t samples, double dt);

/// The shortest record, in seconds, whose bound on coefficient `index` is `relative_std`.
/// Solved to 1e-6 relative in the logarithm of the length; between 16 samples and 1e15 samples.
/// @return infinity where no record of 1e15 samples would do.
[[nodiscard]] double duration_for(std::span<const noise::Process> processes, std::size_t index, double relative_std,
                                  double dt);

}  // namespace gyrobudget::inline v0::fit

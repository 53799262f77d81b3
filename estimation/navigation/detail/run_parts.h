// SPDX-License-Identifier: MIT
// What any run over a recording does, be it a filter's or a batch estimate's.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

namespace gyrobudget::inline v0::navigation::detail {

inline constexpr double kSame = 2e-8;  ///< times that are one but for rounded stamps [s]

/// Where interval k of the IMU begins, in the scene's time [s].
[[nodiscard]] double stamp(const Recording& recording, std::size_t k);

/// The part of interval k's increments from one time to another [s]: all of it, or by a straight rate through the
/// means of the neighbours that keeps the interval's own.
[[nodiscard]] noise::ImuIncrement piece(const Recording& recording, std::size_t k, double from, double to);

/// A fix of aid `number` against an estimate, by the models of aiding.h; `sigma` in the aid's components.
[[nodiscard]] Measurement measure_fix(const Aid& aid, int number, const Fix& fix, const Estimate& estimate,
                                      const Eigen::Vector3d& sigma);

/// An estimate and the covariance of its error as a solution at time t [s].
[[nodiscard]] Solution solution(const Estimate& estimate, const StateMatrix& P, double t);

}  // namespace gyrobudget::inline v0::navigation::detail

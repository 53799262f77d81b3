// SPDX-License-Identifier: MIT
// Inside navigation: what a fix of an aid tells of an estimate.
#pragma once

#include "gyrobudget/estimation/navigation/aiding.h"
#include "gyrobudget/estimation/navigation/recording.h"
#include "gyrobudget/estimation/navigation/scenario.h"

namespace gyrobudget::inline v0::navigation::detail {

/// Of the aid with this number; sigma in the aid's components, as Aid::sigma.
[[nodiscard]] Measurement measure_fix(const Aid& aid, int number, const Fix& fix, const Estimate& estimate,
                                      const Eigen::Vector3d& sigma);

/// White noise of a fix: its own, or else its aid's.
[[nodiscard]] inline Eigen::Vector3d sigma_of(const Aid& aid, const Fix& fix) {
  return aid.sigma_factor * fix.sigma.value_or(aid.sigma);
}

/// Whether the scene uses an aid's fixes at this time [s]: within its validity and outside its outages.
[[nodiscard]] bool in_use(const Aid& aid, double t);

}  // namespace gyrobudget::inline v0::navigation::detail

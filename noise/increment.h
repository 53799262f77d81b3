// SPDX-License-Identifier: MIT
// What an inertial measurement unit delivers: one type for the truth, for what is measured and for what navigation
// uses.
#pragma once

#include <array>

namespace gyrobudget::inline v0::noise {

using Vector3 = std::array<double, 3>;  ///< by body axis x, y, z

/// Integrals over a sample interval of each component in body axes, as an integrating sensor gives them. Coning and
/// sculling are in them, uncorrected: that is a strapdown's work. Fill it by name, `{.angle = w_dt, .velocity = f_dt}`.
struct ImuIncrement {
  Vector3 angle = {};     ///< integral of w_ib_b [rad]
  Vector3 velocity = {};  ///< integral of f_ib_b [m/s]
};

}  // namespace gyrobudget::inline v0::noise

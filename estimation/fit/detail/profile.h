// SPDX-License-Identifier: MIT
#pragma once

#include <functional>

namespace gyrobudget::inline v0::fit {

/// T(v): how much worse the data are explained with one squared coefficient held at v >= 0. Zero at the estimate,
/// rising on both sides of it, possibly infinite.
using HeldTest = std::function<double(double v)>;

/// {v : T(v) <= cut} as [lower, upper]; upper is infinite where the data exclude nothing.
struct ProfileInterval {
  double lower = 0;
  double upper = 0;
};

/// The interval around an estimate, its limits to about 1e-11 of their bracket. A standard deviation sets the first
/// step only.
[[nodiscard]] ProfileInterval profile_interval(const HeldTest&, double estimate, double standard_deviation, double cut);

}  // namespace gyrobudget::inline v0::fit

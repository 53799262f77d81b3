// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace gyrobudget::inline v0::noise {

/// What a datasheet gives once for all three axes, or once for each.
class PerAxis {
 public:
  constexpr PerAxis(double all = 0) : axis_{all, all, all} {}  // one number is a value for all
  constexpr PerAxis(double x, double y, double z) : axis_{x, y, z} {}
  [[nodiscard]] constexpr double operator[](std::size_t axis) const { return axis_[axis]; }
  [[nodiscard]] constexpr double& operator[](std::size_t axis) { return axis_[axis]; }
  [[nodiscard]] constexpr bool is_uniform() const { return axis_[0] == axis_[1] && axis_[1] == axis_[2]; }
  /// The largest of the three by absolute value.
  [[nodiscard]] constexpr double largest() const {
    double most = 0;
    for (const double v : axis_) most = std::max(most, v < 0 ? -v : v);
    return most;
  }
  constexpr PerAxis& operator*=(double factor) {
    for (double& v : axis_) v *= factor;
    return *this;
  }
  friend constexpr bool operator==(const PerAxis&, const PerAxis&) = default;

 private:
  std::array<double, 3> axis_;
};

}  // namespace gyrobudget::inline v0::noise

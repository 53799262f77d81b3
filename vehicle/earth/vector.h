// SPDX-License-Identifier: MIT
// The arrays of noise::ImuIncrement as vectors of Eigen, which the noise library does without.
#pragma once

#include "gyrobudget/noise/increment.h"

#include <Eigen/Core>

namespace gyrobudget::inline v0::earth {

/// The array itself seen as a vector, not a copy: it must outlive what is returned.
[[nodiscard]] inline Eigen::Map<const Eigen::Vector3d> vector(const noise::Vector3& array) {
  return Eigen::Map<const Eigen::Vector3d>(array.data());
}
[[nodiscard]] inline Eigen::Map<Eigen::Vector3d> vector(noise::Vector3& array) {
  return Eigen::Map<Eigen::Vector3d>(array.data());
}
[[nodiscard]] inline noise::Vector3 array(const Eigen::Vector3d& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

}  // namespace gyrobudget::inline v0::earth

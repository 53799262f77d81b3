// SPDX-License-Identifier: MIT
// The version of gyrobudget, of which there is this one place: CMake reads it from here.
#pragma once

#define GYROBUDGET_VERSION_MAJOR 0
#define GYROBUDGET_VERSION_MINOR 1
#define GYROBUDGET_VERSION_PATCH 0

namespace gyrobudget::inline v0 {
inline constexpr const char* kVersion = "0.1.0";
}  // namespace gyrobudget::inline v0

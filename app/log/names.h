// SPDX-License-Identifier: MIT
// What the names of columns say. Names choose the time column and word the hints; they never give a data
// column its unit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::log {

/// What a name like `time`, `timestamp_ns`, `field.header.stamp`, `TimeUS`, `t_s` or `nsecs` says about time.
struct TimeName {
  std::int64_t ns_per_unit = 0;  ///< 0: the name has no unit
  bool unit_only = false;        ///< the name is nothing but a unit: secs, nsecs
};
/// Empty where the name is not one of a time column.
[[nodiscard]] std::optional<TimeName> time_name(std::string_view name);

enum class NameKind {
  unknown,
  gyro,           ///< gyro_x, wz, angular_velocity.y
  accelerometer,  ///< accel_x, az, linear_acceleration.y
  temperature,    ///< temp, temperature_imu, t_degc; T
  other,          ///< sequence number, magnetometer, attitude
};
[[nodiscard]] NameKind kind_of_name(std::string_view name);

/// The unit that the end of a name may stand for: "deg/s" for gyro_x_dps. Empty where there is none.
[[nodiscard]] std::string_view unit_hint(std::string_view name);

}  // namespace gyrobudget::inline v0::log

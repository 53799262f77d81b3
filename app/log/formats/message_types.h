// SPDX-License-Identifier: MIT
// ROS messages whose numbers are read: what stands in them, in which order and unit.
#pragma once

#include "gyrobudget/app/log/recording.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::log {

enum class Primitive : std::uint8_t { i8, u8, u16, i32, u32, f64 };

[[nodiscard]] constexpr std::size_t bytes_of(Primitive primitive) {
  switch (primitive) {
    case Primitive::i8:
    case Primitive::u8:
      return 1;
    case Primitive::u16:
      return 2;
    case Primitive::i32:
    case Primitive::u32:
      return 4;
    case Primitive::f64:
      break;
  }
  return 8;
}

/// One number of a message.
struct Member {
  std::string name;  ///< "angular_velocity.x"; empty for one that is not offered: covariances beside the diagonal
  std::string unit;
  Primitive primitive = Primitive::f64;
  std::size_t mark = 0;  ///< place in MessageType::marks, from 1; 0 for none
};

/// By convention a message says that it has not got a part of itself: some other member then is `absent`.
struct AbsenceMark {
  std::size_t member = 0;
  double absent = 0;
  std::string words;  ///< "orientation_covariance[0] is -1"
};

/// A message that begins with std_msgs/Header and goes on with numbers.
struct MessageType {
  std::string name;    ///< "sensor_msgs/Imu"
  std::string md5sum;  ///< of ROS 1, where it is known
  StreamKind kind = StreamKind::other;
  std::vector<Member> members;
  std::vector<AbsenceMark> marks;
  bool goes_on = false;  ///< behind the members there is more, of any length
};

/// @param recorded  as ROS 1 names it, "sensor_msgs/Imu", or ROS 2, "sensor_msgs/msg/Imu"
/// @return null for a type that is not read
[[nodiscard]] const MessageType* message_type(std::string_view recorded);

}  // namespace gyrobudget::inline v0::log

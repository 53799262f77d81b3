// SPDX-License-Identifier: MIT
// Messages of ROS 1 and CDR in every byte order and alignment.
#include "gyrobudget/app/log/formats/message_decoder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "recording_writer.h"

namespace gyrobudget::app_tests {
namespace {

using namespace recording_writer;
using log::Decoded;
using log::Encoding;
using log::MessageDecoder;
using log::MessageType;

const Stamp kStamp{1'700'000'000, 123'456'789};

std::size_t member(const MessageType& type, const std::string& name) {
  for (std::size_t i = 0; i < type.members.size(); ++i) {
    if (type.members[i].name == name) return i;
  }
  ADD_FAILURE() << type.name << " has no " << name;
  return 0;
}

struct Outcome {
  Decoded decoded = Decoded::whole;
  std::int64_t stamp_ns = 0;
  std::vector<double> values;
  std::vector<std::int64_t> absent;
};

Outcome decoded(const std::string& type_name, Encoding encoding, const std::vector<std::string>& names,
                const std::string& message) {
  const MessageType& type = *log::message_type(type_name);
  std::vector<std::size_t> members;
  for (const std::string& name : names) members.push_back(member(type, name));
  Outcome outcome{.values = std::vector<double>(names.size()), .absent = std::vector<std::int64_t>(type.marks.size())};
  const MessageDecoder decoder(type, encoding, members);
  // In memory of its own and exactly as long: a sanitizer sees a read beyond it.
  const std::vector<char> bytes(message.begin(), message.end());
  outcome.decoded = decoder.decode({bytes.data(), bytes.size()}, outcome.stamp_ns, outcome.values, outcome.absent);
  return outcome;
}

const std::vector<std::string> kImuNames{"angular_velocity.x",    "angular_velocity.z",
                                         "linear_acceleration.y", "linear_acceleration.z",
                                         "orientation.w",         "angular_velocity_covariance[4]"};
const std::vector<double> kImuValues{5.1, 5.3, -4.5, 9.6, 0.5, 1e-4};

ImuNumbers oriented() {
  ImuNumbers numbers = imu_numbers(5);
  numbers[3] = 0.5;
  numbers[4] = 0;
  return numbers;
}

TEST(MessageDecoder, Ros1ImuWithNamesOfFramesOfAnyLength) {
  for (std::size_t length = 0; length < 20; ++length) {
    const Outcome imu =
        decoded("sensor_msgs/Imu", Encoding::ros1, kImuNames, ros1_imu(kStamp, oriented(), std::string(length, 'f')));
    ASSERT_EQ(imu.decoded, Decoded::whole) << length;
    EXPECT_EQ(imu.stamp_ns, 1'700'000'000'123'456'789);
    EXPECT_EQ(imu.values, kImuValues);
  }
}

TEST(MessageDecoder, CdrOfEitherByteOrderAndAlignment) {
  for (const bool big_endian : {false, true}) {
    for (const bool xcdr2 : {false, true}) {
      for (std::size_t length = 0; length < 20; ++length) {
        for (const int padding : {0, 1, 3}) {
          const Cdr cdr{big_endian, xcdr2, padding};
          const Outcome imu = decoded("sensor_msgs/msg/Imu", Encoding::cdr, kImuNames,
                                      cdr.imu(kStamp, oriented(), std::string(length, 'f')));
          ASSERT_EQ(imu.decoded, Decoded::whole) << big_endian << xcdr2 << length;
          EXPECT_EQ(imu.stamp_ns, 1'700'000'000'123'456'789);
          EXPECT_EQ(imu.values, kImuValues) << big_endian << xcdr2 << length;
        }
      }
    }
  }
}

/// formats: frame_id imu_link, L = 9, doubles start at 28, 324 bytes in all.
TEST(MessageDecoder, TheWorkedExampleOfCdr) { EXPECT_EQ(Cdr{}.imu(kStamp, oriented(), "imu_link").size(), 324U); }

TEST(MessageDecoder, CdrMayLeaveOutTheEndOfAnEmptyName) {
  Buffer b;
  b.u8(0).u8(1).u16(0).u32(kStamp.sec).u32(kStamp.nanosec).u32(0).align(8, 4);
  for (const double n : oriented()) b.number(n);
  EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::cdr, kImuNames, b.bytes).values, kImuValues);
}

TEST(MessageDecoder, FixOfEverySerialization) {
  const std::vector<std::string> names{"status.status", "status.service",         "latitude",
                                       "altitude",      "position_covariance[8]", "position_covariance_type"};
  const std::vector<double> values{2, 13, -2.3, 12.5, 16, 2};
  const Fix fix{.status = 2, .service = 13};
  EXPECT_EQ(decoded("sensor_msgs/NavSatFix", Encoding::ros1, names, ros1_fix(kStamp, fix)).values, values);
  for (const Cdr& cdr : {Cdr{false, false}, Cdr{true, false}, Cdr{false, true}, Cdr{true, true}}) {
    for (const std::string frame : {"", "g", "gp", "gps", "gps0", "gps01"}) {
      const Outcome outcome =
          decoded("sensor_msgs/msg/NavSatFix", Encoding::cdr, names, cdr_fix(cdr, kStamp, fix, frame));
      ASSERT_EQ(outcome.decoded, Decoded::whole) << frame;
      EXPECT_EQ(outcome.values, values) << frame;
    }
  }
}

TEST(MessageDecoder, WhatAMessageSaysThatItHasNotIsNaN) {
  const Outcome imu = decoded("sensor_msgs/Imu", Encoding::ros1, {"orientation.w", "angular_velocity.x"},
                              ros1_imu(kStamp, imu_numbers(5)));
  EXPECT_TRUE(std::isnan(imu.values[0]));
  EXPECT_EQ(imu.values[1], 5.1);
  EXPECT_EQ(imu.absent, (std::vector<std::int64_t>{1, 0, 0}));

  const Fix none{.status = -1, .covariance_type = 0};
  const Outcome fix = decoded("sensor_msgs/NavSatFix", Encoding::ros1,
                              {"latitude", "position_covariance[0]", "status.status"}, ros1_fix(kStamp, none));
  EXPECT_TRUE(std::isnan(fix.values[0]));
  EXPECT_TRUE(std::isnan(fix.values[1]));
  EXPECT_EQ(fix.values[2], -1);
}

TEST(MessageDecoder, WhatIsNotFiniteIsNaN) {
  ImuNumbers numbers = imu_numbers(0);
  numbers[13] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isnan(
      decoded("sensor_msgs/Imu", Encoding::ros1, {"angular_velocity.x"}, ros1_imu(kStamp, numbers)).values[0]));
}

TEST(MessageDecoder, EveryOtherLengthIsRefused) {
  for (const auto& [encoding, message] : {std::pair{Encoding::ros1, ros1_imu(kStamp, oriented())},
                                          std::pair{Encoding::cdr, Cdr{}.imu(kStamp, oriented())}}) {
    for (std::size_t size = 0; size < message.size(); ++size) {
      EXPECT_NE(decoded("sensor_msgs/Imu", encoding, kImuNames, message.substr(0, size)).decoded, Decoded::whole);
    }
    EXPECT_EQ(decoded("sensor_msgs/Imu", encoding, kImuNames, message + "1234").decoded, Decoded::other_length);
  }
  EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::ros1, kImuNames, ros1_imu(kStamp, oriented()) + "1").decoded,
            Decoded::other_length);
}

TEST(MessageDecoder, ALengthNearTheLimitOfItsNumberDoesNotWrap) {
  for (const std::uint32_t length : {0xffffffffU, 0xfffffff0U, 0x80000000U}) {
    std::string ros1 = ros1_imu(kStamp, oriented()), cdr = Cdr{}.imu(kStamp, oriented());
    std::memcpy(ros1.data() + 12, &length, sizeof length);
    std::memcpy(cdr.data() + 12, &length, sizeof length);
    EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::ros1, kImuNames, ros1).decoded, Decoded::other_length);
    EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::cdr, kImuNames, cdr).decoded, Decoded::other_length);
  }
}

TEST(MessageDecoder, OtherEncapsulationsAreRefused) {
  for (const int kind : {2, 3, 4, 5, 8, 9, 10, 11, 255}) {
    std::string message = Cdr{}.imu(kStamp, oriented());
    message[1] = static_cast<char>(kind);
    EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::cdr, kImuNames, message).decoded, Decoded::other_encoding) << kind;
  }
  EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::cdr, kImuNames, "\x01\x01").decoded, Decoded::other_encoding);
}

/// ROS 1 counts seconds without a sign to 2106, ROS 2 with one.
TEST(MessageDecoder, StampsBeyond2038AndBefore1970) {
  const Stamp late{0xfffffff0U, 5};
  EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::ros1, {}, ros1_imu(late, oriented())).stamp_ns,
            4294967280LL * 1'000'000'000 + 5);
  EXPECT_EQ(decoded("sensor_msgs/Imu", Encoding::cdr, {}, Cdr{}.imu(late, oriented())).stamp_ns,
            -16LL * 1'000'000'000 + 5);
}

TEST(MessageDecoder, OtherTypesWithAHeader) {
  Buffer b = ros1_header(kStamp, "map");
  b.number(1.5).number(2.5);
  EXPECT_EQ(decoded("sensor_msgs/FluidPressure", Encoding::ros1, {"fluid_pressure", "variance"}, b.bytes).values,
            (std::vector<double>{1.5, 2.5}));
  Buffer t = ros1_header(kStamp, "gps");
  t.u32(100).u32(7).text("a source of any length");
  EXPECT_EQ(decoded("sensor_msgs/TimeReference", Encoding::ros1, {"time_ref.sec", "time_ref.nanosec"}, t.bytes).values,
            (std::vector<double>{100, 7}));
}

TEST(MessageType, IsKnownByTheNamesOfBothGenerationsAndNoOther) {
  ASSERT_NE(log::message_type("sensor_msgs/Imu"), nullptr);
  EXPECT_EQ(log::message_type("sensor_msgs/msg/Imu"), log::message_type("sensor_msgs/Imu"));
  for (const char* other : {"", "Imu", "sensor_msgs", "sensor_msgs/", "sensor_msgs/srv/Imu", "sensor_msgs/msg/imu",
                            "sensor_msgs/msg/Imu2", "sensor_msgs/msg/msg/Imu", "xensor_msgs/msg/Imu", "/msg"}) {
    EXPECT_EQ(log::message_type(other), nullptr) << other;
  }
}

}  // namespace
}  // namespace gyrobudget::app_tests

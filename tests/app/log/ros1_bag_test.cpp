// SPDX-License-Identifier: MIT
// ROS 1 bags, whole, unfinished, cut and damaged.
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/app/text/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "../temporary.h"
#include "recording_fixture.h"
#include "recording_writer.h"

namespace gyrobudget::app_tests {
namespace {

using namespace recording_writer;
using text::InputError;

using Ros1Bag = RecordingTest;

/// Samples `first` to `last`, one each 10 ms from 1000 s on, recorded 1 ms later.
void add_samples(BagWriter& bag, std::uint32_t conn, int first, int last) {
  for (int i = first; i < last; ++i) {
    bag.message(conn, stamp_at(i, 1'000'000), ros1_imu(stamp_at(i), imu_numbers(i)));
  }
}

/// Three chunks of ten samples.
BagWriter three_chunks(const std::string& how) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2");
  for (int chunk = 0; chunk < 3; ++chunk) {
    add_samples(bag, 0, 10 * chunk, 10 * chunk + 10);
    bag.end_chunk(how);
  }
  return bag;
}

TEST_F(Ros1Bag, OfEveryPackingClosedOrKilled) {
  for (const std::string& how : packings({"none", "bz2", "lz4"})) {
    for (const bool is_closed : {true, false}) {
      const BagWriter bag = three_chunks(how);
      const auto recording = opened(is_closed ? bag.closed() : bag.killed());
      EXPECT_EQ(recording->format(), "ROS 1 bag");
      ASSERT_EQ(recording->streams().size(), 1U) << how;
      const log::StreamInfo& info = recording->streams()[0];
      EXPECT_EQ(info.name, "/imu");
      EXPECT_EQ(info.type, "sensor_msgs/Imu");
      EXPECT_EQ(info.kind, log::StreamKind::imu);
      EXPECT_EQ(info.count, 30);
      EXPECT_EQ(info.clock, "header.stamp");
      expect_samples(*recording, 0, 0, 30);
      EXPECT_EQ(notes(*recording).find("was not closed") == std::string::npos, is_closed);
    }
  }
}

TEST_F(Ros1Bag, FieldsHaveTheUnitsOfTheMessage) {
  const auto recording = opened(three_chunks("none").closed());
  const log::StreamInfo& info = recording->streams()[0];
  EXPECT_EQ(info.fields[field(info, "angular_velocity.x")].unit, "rad/s");
  EXPECT_EQ(info.fields[field(info, "linear_acceleration.z")].unit, "m/s^2");
  EXPECT_EQ(info.fields[field(info, "linear_acceleration.z")].unit_from, "sensor_msgs/Imu has it so");
  EXPECT_EQ(info.fields[field(info, "orientation.w")].unit, "");
  for (const log::Field& f : info.fields) EXPECT_FALSE(f.name.empty());
}

TEST_F(Ros1Bag, ConnectionsOfOneTopicAreOneStreamAndOfAnotherTypeAnother) {
  BagWriter bag;
  bag.connection(3, "/imu", "sensor_msgs/Imu", "*", "/before/remapping");
  add_samples(bag, 3, 0, 2);
  bag.end_chunk();
  bag.connection(70'000, "/imu", "sensor_msgs/Imu");
  bag.connection(5, "/imu", "std_msgs/String");
  add_samples(bag, 70'000, 2, 4);
  bag.message(5, stamp_at(0), "\x03\0\0\0abc");
  add_samples(bag, 3, 4, 6);
  bag.end_chunk();
  for (const std::string& bytes : {bag.closed(), bag.killed()}) {
    const auto recording = opened(bytes);
    ASSERT_EQ(recording->streams().size(), 2U);
    EXPECT_EQ(recording->streams()[0].name, "/imu");
    EXPECT_EQ(recording->streams()[0].count, 6);
    EXPECT_EQ(recording->streams()[1].name, "/imu #2");
    EXPECT_EQ(recording->streams()[1].count, 1);
    EXPECT_TRUE(recording->streams()[1].fields.empty());
    EXPECT_CONTAINS(notes(*recording),
                    "'/imu' is the name of several streams: that of type 'std_msgs/String' is called '/imu #2'");
    expect_samples(*recording, 0, 0, 6);
    EXPECT_EQ(recording->read(1, {}).stamps_ns, std::vector<std::int64_t>{ns(stamp_at(0))});
  }
}

TEST_F(Ros1Bag, MessagesOutsideChunksAndPackingsThatChange) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  add_samples(bag, 0, 0, 2);
  bag.end_chunk("none");
  for (int i = 2; i < 5; ++i) {
    bag.loose(bag_record({{"op", bag_op(2)}, {"conn", raw(0U)}, {"time", bag_time(stamp_at(i))}},
                         ros1_imu(stamp_at(i), imu_numbers(i))));
  }
  add_samples(bag, 0, 5, 7);
  bag.end_chunk(packings({"bz2", "none"}).front());
  const auto recording = opened(bag.closed());
  EXPECT_EQ(recording->streams()[0].count, 7);
  expect_samples(*recording, 0, 0, 7);
}

TEST_F(Ros1Bag, ValuesOfFieldsMayHoldAnyByte) {
  BagWriter bag;
  bag.connection('=', "/a=b\n", "sensor_msgs/Imu");
  add_samples(bag, '=', 0, 2);
  bag.end_chunk();
  const auto recording = opened(bag.killed());
  ASSERT_EQ(recording->streams().size(), 1U);
  EXPECT_EQ(recording->streams()[0].name, "/a=b ");  // fit for a line
  expect_samples(*recording, 0, 0, 2);
}

TEST_F(Ros1Bag, RecordTimesStandInForHeadersThatAreZeroOrConstant) {
  for (const Stamp constant : {Stamp{0, 0}, Stamp{5, 6}}) {
    BagWriter bag;
    bag.connection(0, "/imu", "sensor_msgs/Imu");
    for (int i = 0; i < 4; ++i) bag.message(0, stamp_at(i), ros1_imu(constant, imu_numbers(i)));
    bag.end_chunk();
    const log::Rows rows = opened(bag.closed())->read(0, {});
    EXPECT_EQ(rows.clock, "record time");
    EXPECT_EQ(rows.stamps_ns, stamps(0, 4));
    EXPECT_CONTAINS(rows.notes.at(0), constant.sec == 0 ? "is 0 in every" : "is the same in every");
  }
}

TEST_F(Ros1Bag, HeadersThatBeginConstantAreHeadersAllTheSame) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  for (const std::uint32_t sec : {9U, 9U, 9U, 8U}) bag.message(0, {100, 0}, ros1_imu({sec, 1}, imu_numbers(0)));
  bag.end_chunk();
  const log::Rows rows = opened(bag.closed())->read(0, {});
  EXPECT_EQ(rows.clock, "header.stamp");
  EXPECT_EQ(rows.stamps_ns, (std::vector<std::int64_t>{9'000'000'001, 9'000'000'001, 9'000'000'001, 8'000'000'001}));
}

TEST_F(Ros1Bag, SecondsThatComeToTheirEndAreSaid) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  for (const std::uint32_t sec : {0xfffffffeU, 0xffffffffU, 0U, 1U}) {
    bag.message(0, {100, 0}, ros1_imu({sec, 0}, imu_numbers(0)));
  }
  bag.end_chunk();
  const log::Rows rows = opened(bag.closed())->read(0, {});
  EXPECT_EQ(joined(rows.notes),
            "the stamp of row 2 is 2^32 s off the one before: its writer counted seconds in 32 bits\n");
}

TEST_F(Ros1Bag, OneMessageHasTheStampOfItsHeader) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  add_samples(bag, 0, 0, 1);
  bag.end_chunk();
  const log::Rows rows = opened(bag.closed())->read(0, {});
  EXPECT_EQ(rows.clock, "header.stamp");
  EXPECT_EQ(rows.stamps_ns, stamps(0, 1));
}

TEST_F(Ros1Bag, MessagesOfAnotherLengthAreLeftOutAndCounted) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu", "0123456789abcdef0123456789abcdef");
  bag.message(0, stamp_at(9), "short");
  add_samples(bag, 0, 0, 2);
  bag.message(0, stamp_at(9), ros1_imu(stamp_at(9), imu_numbers(9)) + "longer");
  bag.end_chunk();
  const auto recording = opened(bag.closed());
  EXPECT_CONTAINS(notes(*recording), "another definition");
  expect_samples(*recording, 0, 0, 2, "2 messages are left out: they have not the length of sensor_msgs/Imu");

  BagWriter none;
  none.connection(0, "/imu", "sensor_msgs/Imu");
  none.message(0, stamp_at(0), "short");
  none.end_chunk();
  const auto wrong = opened(none.closed());
  EXPECT_CONTAINS(message_of<InputError>([&] { static_cast<void>(wrong->read(0, {})); }),
                  "not one of 1 messages has the layout of sensor_msgs/Imu");
}

TEST_F(Ros1Bag, AbsentValuesAndDeadHalvesAreSaid) {
  BagWriter bag;
  bag.connection(0, "/gyro", "sensor_msgs/Imu");
  for (int i = 0; i < 3; ++i) {
    ImuNumbers numbers = imu_numbers(i);
    numbers[25] = numbers[26] = numbers[27] = 0;
    bag.message(0, stamp_at(i), ros1_imu(stamp_at(i), numbers));
  }
  bag.end_chunk();
  const auto recording = opened(bag.closed());
  const log::Rows rows =
      read(*recording, 0, {"orientation.w", "angular_velocity.x", "linear_acceleration.x", "linear_acceleration.z"});
  EXPECT_TRUE(std::isnan(rows.columns[0][2]));
  EXPECT_EQ(rows.columns[1][2], 2.1);
  EXPECT_CONTAINS(joined(rows.notes), "3 rows say that they have no such value (orientation_covariance[0] is -1)");
  EXPECT_CONTAINS(joined(rows.notes), "linear_acceleration is 0 in every row");
  EXPECT_EQ(joined(rows.notes).find("angular_velocity is 0"), std::string::npos);
}

TEST_F(Ros1Bag, AnIndexThatCountsTooManyIsFoundOutWhenRead) {
  BagWriter bag;
  bag.index_lie = 1;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  add_samples(bag, 0, 0, 5);
  bag.end_chunk();
  const auto recording = opened(bag.closed());
  EXPECT_EQ(recording->streams()[0].count, 6);
  expect_samples(*recording, 0, 0, 5, "the index counts 6 messages, there are 5");
}

TEST_F(Ros1Bag, AnIndexThatCannotBeIsNotBelieved) {
  BagWriter bag;
  bag.index_lie = 0xfffffff0U;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  add_samples(bag, 0, 0, 5);
  bag.end_chunk();
  const auto recording = opened(bag.closed());
  EXPECT_EQ(recording->streams()[0].count, 5);
  EXPECT_CONTAINS(notes(*recording), "the index does not fit the chunks");
}

TEST_F(Ros1Bag, MessagesThatNothingDeclaresAreSaid) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  add_samples(bag, 0, 0, 2);
  add_samples(bag, 9, 0, 3);
  bag.end_chunk();
  const auto recording = opened(bag.closed());
  EXPECT_CONTAINS(notes(*recording), "3 messages are left out: nothing declares their number 9");
  expect_samples(*recording, 0, 0, 2);
}

TEST_F(Ros1Bag, OneNumberForTwoTopicsIsSaid) {
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  bag.connection(0, "/other\x1b[2J", "sensor_msgs/Imu");
  add_samples(bag, 0, 0, 2);
  bag.end_chunk();
  const auto recording = opened(bag.killed());
  EXPECT_CONTAINS(notes(*recording), "'/other\\x1b[2J'");
  expect_samples(*recording, 0, 0, 2);
}

TEST_F(Ros1Bag, ChunksThatDoNotUnpackCostOnlyThemselves) {
  for (const std::string& how : packings({"bz2", "lz4"})) {
    for (const std::int64_t size_error : {std::int64_t{-400}, std::int64_t{400}, std::int64_t{3'999'000'000}}) {
      BagWriter bag;
      bag.connection(0, "/imu", "sensor_msgs/Imu");
      bag.end_chunk();
      add_samples(bag, 0, 100, 103);
      bag.end_chunk(how, {}, size_error);
      add_samples(bag, 0, 0, 3);
      bag.end_chunk(how);
      const auto recording = opened(bag.killed());
      EXPECT_CONTAINS(notes(*recording), "is damaged (");
      const log::Rows rows = read(*recording, 0, kGyroX);
      ASSERT_GE(rows.stamps_ns.size(), 3U) << how << size_error;
      EXPECT_EQ(rows.stamps_ns.back(), ns(stamp_at(2)));
    }
  }
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  add_samples(bag, 0, 0, 3);
  bag.end_chunk();
  add_samples(bag, 0, 3, 5);
  bag.end_chunk("none", "snappy");
  const auto recording = opened(bag.closed());
  EXPECT_CONTAINS(notes(*recording), "is packed by 'snappy', expected none, bz2 or lz4");
  expect_samples(*recording, 0, 0, 3);
}

/// What is there stays; what is lost is said with its place.
TEST_F(Ros1Bag, CutAtEveryHundredth) {
  for (const std::string& how : packings({"none", "bz2", "lz4"})) {
    const BagWriter bag = three_chunks(how);
    const std::string whole = bag.killed();
    std::size_t before = 0;
    for (std::size_t hundredth = 1; hundredth < 100; ++hundredth) {
      const std::size_t size = whole.size() * hundredth / 100;
      std::size_t count = 0;
      try {
        const auto recording = opened(whole.substr(0, size));
        if (!recording->streams().empty()) count = read(*recording, 0, kGyroX).stamps_ns.size();
        const std::string said = notes(*recording);
        EXPECT_TRUE(said.find("was not closed") != said.npos || said.find("the bag ends at byte ") != said.npos)
            << said;
      } catch (const InputError& error) {
        EXPECT_CONTAINS(std::string(error.what()), ": ");
      }
      EXPECT_GE(count, before) << how << hundredth;
      before = count;
    }
    EXPECT_GE(before, how == "none" ? 29U : 20U);
  }
}

/// Where the file ends in an uncompressed chunk, its whole messages are kept, and the byte is named.
TEST_F(Ros1Bag, CutInsideAChunk) {
  const BagWriter bag = three_chunks("none");
  const std::string whole = bag.killed();
  const std::size_t message = 46 + ros1_imu(stamp_at(0), imu_numbers(0)).size();
  const std::size_t data = whole.find("time=", bag.begin_of_last_chunk) - 8;  // behind two lengths
  const std::size_t size = data + 4 * message + 10;
  const auto recording = opened(whole.substr(0, size));
  EXPECT_CONTAINS(notes(*recording), "the bag ends at byte " + std::to_string(size) +
                                         ", inside the chunk that begins at byte " +
                                         std::to_string(bag.begin_of_last_chunk));
  expect_samples(*recording, 0, 0, 24);
}

TEST_F(Ros1Bag, ABuildWithoutALibraryNamesThePackage) {
  bool is_whole = true;
  for (const auto& [how, package] : {std::pair{"bz2", "libbz2-dev"}, std::pair{"lz4", "liblz4-dev"}}) {
    if (!packings({how}).empty()) continue;
    is_whole = false;
    BagWriter bag;
    add_samples(bag, 0, 0, 2);
    bag.end_chunk("none", how);
    EXPECT_CONTAINS(refusal(bag.closed()), package);
  }
  if (!packings({"zstd"}).empty()) {
    if (is_whole) GTEST_SKIP() << "this build has all libraries";
    return;
  }
  const std::string packed = file("log", "\x28\xb5\x2f\xfd" + std::string(20, '\0'));
  EXPECT_CONTAINS(message_of<text::InputError>([&] { (void)log::read_log({.path = packed}); }), "libzstd-dev");
}

TEST_F(Ros1Bag, ZerosThatACrashLeftAreNoRecords) {
  const auto recording = opened(three_chunks("none").killed() + std::string(5000, '\0'));
  EXPECT_CONTAINS(notes(*recording), "5000 bytes behind it are no whole record");
  expect_samples(*recording, 0, 0, 30);
}

TEST_F(Ros1Bag, EmptyAndEncryptedAndOlder) {
  EXPECT_TRUE(opened(BagWriter().closed())->streams().empty());
  EXPECT_TRUE(opened(BagWriter().closed({{"encryptor", "rosbag/NoEncryptor"}}))->streams().empty());
  EXPECT_CONTAINS(refusal(BagWriter().closed({{"encryptor", "rosbag/AesCbcEncryptor"}})),
                  "is encrypted by 'rosbag/AesCbcEncryptor'; decrypt it with rosbag decrypt");
  for (const char* old : {"#ROSBAG V1.2\n1234", "#ROSRECORD V1.1\n", "#ROSLOG V1.0\n"}) {
    EXPECT_EQ(log::recorded_format(old), "ROS 1 bag of an older version");
    EXPECT_CONTAINS(refusal(old), "rosbag fix");
  }
  EXPECT_EQ(log::recorded_format("#ROSBAG V2.0\n"), "ROS 1 bag");
  EXPECT_EQ(log::recorded_format("# a text log\n1 2 3\n"), "");
}

/// A copy that ends between two records, before the index.
TEST_F(Ros1Bag, AClosedBagWithoutItsEnd) {
  const BagWriter bag = three_chunks("none");
  const auto recording = opened(bag.closed().substr(0, bag.killed().size()));
  EXPECT_CONTAINS(notes(*recording), "the index does not fit the chunks");
  expect_samples(*recording, 0, 0, 30);
}

TEST_F(Ros1Bag, NamesThatPrintAlikeStayApart) {
  BagWriter bag;
  for (int i = 0; i < 5; ++i) {
    bag.connection(static_cast<std::uint32_t>(i), std::string("/a") + static_cast<char>(1 + i), "sensor_msgs/Imu");
    add_samples(bag, static_cast<std::uint32_t>(i), i, i + 1);
  }
  bag.connection(9, "/a  #2", "sensor_msgs/Imu");
  bag.end_chunk();
  const auto recording = opened(bag.killed());
  ASSERT_EQ(recording->streams().size(), 6U);
  std::set<std::string> names;
  for (const log::StreamInfo& info : recording->streams()) names.insert(info.name);
  EXPECT_EQ(names.size(), 6U);
}

TEST_F(Ros1Bag, StreamsAndFieldsThatAreNoneAreRefused) {
  const auto recording = opened(three_chunks("none").closed());
  EXPECT_THROW(static_cast<void>(recording->read(1, {})), std::out_of_range);
  EXPECT_THROW(static_cast<void>(recording->read(0, std::vector<std::size_t>{99})), std::out_of_range);
}

}  // namespace
}  // namespace gyrobudget::app_tests

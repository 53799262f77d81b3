// SPDX-License-Identifier: MIT
// MCAP files, with chunks and without, whole, cut and damaged.
#include "gyrobudget/app/log/formats/crc32.h"
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/app/text/error.h"

#include <gtest/gtest.h>

#include <zlib.h>

#include <limits>
#include <string>
#include <vector>

#include "../temporary.h"
#include "recording_fixture.h"
#include "recording_writer.h"

namespace gyrobudget::app_tests {
namespace {

using namespace recording_writer;
using text::InputError;

using Mcap = RecordingTest;

/// By another way than zlib's; every length around the 16 and 64 bytes that it takes at a time.
TEST(Crc32, IsThatOfZlib) {
  std::string bytes(5000, '\0');
  std::uint32_t state = 1;
  for (char& byte : bytes) byte = static_cast<char>((state = state * 1664525U + 1013904223U) >> 24U);
  std::vector<std::size_t> sizes{4096, 4999};
  for (std::size_t size = 0; size < 700; ++size) sizes.push_back(size);
  for (const std::size_t size : sizes) {
    const std::string_view part = std::string_view(bytes).substr(1, size);
    EXPECT_EQ(log::crc32_of(part), ::crc32(0, reinterpret_cast<const Bytef*>(part.data()), static_cast<uInt>(size)))
        << size;
  }
  EXPECT_EQ(log::crc32_of("123456789"), 0xcbf43926U);  // the check value in the catalogues
}

std::uint64_t log_time(int i) { return static_cast<std::uint64_t>(ns(stamp_at(i))) + 1000; }
std::string imu(int i) { return Cdr{}.imu(stamp_at(i), imu_numbers(i)); }

void declare_imu(McapWriter& mcap, unsigned id = 1, const std::string& topic = "/imu") {
  mcap.declare(mcap_schema(id, "sensor_msgs/msg/Imu"));
  mcap.declare(mcap_channel(id, id, topic, "cdr"));
}

/// Chunks of ten samples; each repeats what it needs, as some writers do.
McapWriter chunks(const std::string& how, int count = 3) {
  McapWriter mcap;
  for (int chunk = 0; chunk < count; ++chunk) {
    declare_imu(mcap);
    for (int i = 10 * chunk; i < 10 * chunk + 10; ++i) mcap.message(1, log_time(i), imu(i));
    mcap.end_chunk(how);
  }
  return mcap;
}

TEST_F(Mcap, OfEveryPackingWithAndWithoutItsIndex) {
  for (const std::string& how : packings({"", "lz4", "zstd"})) {
    for (const bool has_statistics : {true, false}) {
      for (const bool has_index : {true, false}) {
        McapWriter mcap = chunks(how, 0);
        mcap.has_index = has_index;
        mcap.has_statistics = has_statistics;
        declare_imu(mcap);
        for (int i = 0; i < 10; ++i) mcap.message(1, log_time(i), imu(i));
        mcap.end_chunk(how);
        for (int i = 10; i < 30; ++i) mcap.message(1, log_time(i), imu(i));
        mcap.end_chunk(how);
        const auto recording = opened(mcap.closed());
        EXPECT_EQ(recording->format(), "MCAP");
        ASSERT_EQ(recording->streams().size(), 1U);
        EXPECT_EQ(recording->streams()[0].name, "/imu");
        EXPECT_EQ(recording->streams()[0].type, "sensor_msgs/msg/Imu");
        EXPECT_EQ(recording->streams()[0].count, 30) << how << has_statistics << has_index;
        EXPECT_EQ(notes(*recording), "");
        expect_samples(*recording, 0, 0, 30);
      }
    }
  }
}

TEST_F(Mcap, MessagesOutsideChunksBesideThoseInside) {
  McapWriter mcap;
  mcap.loose(mcap_schema(1, "sensor_msgs/msg/Imu"));
  mcap.loose(mcap_channel(1, 1, "/imu", "cdr"));
  mcap.loose_message(1, log_time(0), imu(0));
  mcap.loose(mcap_record(0x80, "private"));
  mcap.loose_message(1, log_time(1), imu(1));
  mcap.message(1, log_time(2), imu(2));
  mcap.message(1, log_time(3), imu(3));
  mcap.end_chunk();
  mcap.loose(mcap_record(0x0c, "metadata that nobody reads"));
  mcap.loose_message(1, log_time(4), imu(4));
  for (const std::string& bytes : {mcap.closed(), mcap.cut()}) {
    const auto recording = opened(bytes);
    EXPECT_EQ(recording->streams().at(0).count, 5);
    expect_samples(*recording, 0, 0, 5);
  }
  EXPECT_CONTAINS(notes(*opened(mcap.cut())), "was not closed");
}

TEST_F(Mcap, MessagesOfRos1AndOfEncodingsThatAreNotRead) {
  McapWriter mcap;
  mcap.declare(mcap_schema(1, "sensor_msgs/Imu", "ros1msg"));
  mcap.declare(mcap_schema(2, "foxglove.Imu", "protobuf"));
  mcap.declare(mcap_schema(3, "sensor_msgs/msg/Imu"));
  mcap.declare(mcap_channel(1, 1, "/ros1", "ros1"));
  mcap.declare(mcap_channel(2, 2, "/protobuf", "protobuf"));
  mcap.declare(mcap_channel(3, 3, "/json", "json"));
  mcap.declare(mcap_channel(4, 0, "/no_schema", "json"));
  for (int i = 0; i < 3; ++i) {
    mcap.message(1, log_time(i), ros1_imu(stamp_at(i), imu_numbers(i)));
    for (unsigned channel = 2; channel < 5; ++channel) mcap.message(channel, log_time(i), "{}");
  }
  mcap.end_chunk();
  const auto recording = opened(mcap.closed());
  ASSERT_EQ(recording->streams().size(), 4U);
  expect_samples(*recording, stream(*recording, "/ros1"), 0, 3);
  for (const char* other : {"/protobuf", "/json", "/no_schema"}) {
    const log::StreamInfo& info = recording->streams()[stream(*recording, other)];
    EXPECT_TRUE(info.fields.empty()) << other;
    EXPECT_EQ(info.kind, log::StreamKind::other);
    EXPECT_EQ(info.count, 3);
    EXPECT_EQ(info.clock, "record time");
    const log::Rows rows = recording->read(stream(*recording, other), {});
    EXPECT_EQ(rows.stamps_ns.at(2), static_cast<std::int64_t>(log_time(2)));
  }
  EXPECT_EQ(recording->streams()[stream(*recording, "/protobuf")].type, "foxglove.Imu");
}

TEST_F(Mcap, ChannelsOfOneTopicAreOneStream) {
  McapWriter mcap;
  declare_imu(mcap, 1);
  declare_imu(mcap, 9);
  for (int i = 0; i < 6; ++i) mcap.message(i % 2 == 0 ? 1 : 9, log_time(i), imu(i));
  mcap.end_chunk();
  const auto recording = opened(mcap.closed());
  ASSERT_EQ(recording->streams().size(), 1U);
  expect_samples(*recording, 0, 0, 6);
}

TEST_F(Mcap, ChunksWithoutTheTopicAreNotUnpacked) {
  McapWriter mcap;
  declare_imu(mcap, 1);
  declare_imu(mcap, 2, "/other");
  for (int i = 0; i < 3; ++i) mcap.message(1, log_time(i), imu(i));
  mcap.end_chunk();
  for (int i = 0; i < 3; ++i) mcap.message(2, log_time(i), imu(i));
  mcap.end_chunk("", 12345);  // a check sum that does not fit: seen by who reads it
  const auto recording = opened(mcap.closed());
  expect_samples(*recording, stream(*recording, "/imu"), 0, 3);
  EXPECT_CONTAINS(joined(recording->read(stream(*recording, "/other"), {}).notes), "the check sum does not fit");
}

TEST_F(Mcap, CheckSumsThatFitAreNotMentioned) {
  for (const std::string& how : packings({"", "lz4", "zstd"})) {
    McapWriter mcap;
    declare_imu(mcap);
    for (int i = 0; i < 3; ++i) mcap.message(1, log_time(i), imu(i));
    const auto crc =
        ::crc32(0, reinterpret_cast<const Bytef*>(mcap.chunk().data()), static_cast<uInt>(mcap.chunk().size()));
    mcap.end_chunk(how, static_cast<std::uint32_t>(crc));
    const auto recording = opened(mcap.closed());
    expect_samples(*recording, 0, 0, 3);
  }
}

TEST_F(Mcap, ZstdMayEndWithPaddingOrGoOnWithAnotherFrame) {
  if (packings({"zstd"}).empty()) GTEST_SKIP() << "a build without zstd";
  McapWriter padded;
  declare_imu(padded);
  for (int i = 0; i < 3; ++i) padded.message(1, log_time(i), imu(i));
  padded.end_chunk("zstd", 0, std::string(16, '\0'));
  expect_samples(*opened(padded.closed()), 0, 0, 3);
  McapWriter two;
  two.has_statistics = false;
  declare_imu(two);
  two.message(1, log_time(0), imu(0));
  const std::string second = mcap_message(1, log_time(1), imu(1));
  two.end_chunk("zstd", 0, pack("zstd", second), static_cast<std::int64_t>(second.size()));
  EXPECT_EQ(opened(two.closed())->streams().at(0).count, 2);
  expect_samples(*opened(two.closed()), 0, 0, 2);
}

TEST_F(Mcap, PackedAsAWholeAndCut) {
  if (packings({"zstd"}).empty()) GTEST_SKIP() << "a build without zstd";
  for (const std::string& how : packings({"bz2", "lz4", "zstd"})) {
    SCOPED_TRACE(how);
    const auto recording = opened(pack(how, chunks("").closed()));
    EXPECT_EQ(recording->format(), "MCAP");
    EXPECT_EQ(notes(*recording), "");
    expect_samples(*recording, 0, 0, 30);
  }
  const std::string packed = pack("zstd", chunks("").closed());
  // Of a frame that is cut in its only block there is nothing that could be recognised: it is told as a text would be.
  const std::string cut = file("cut", packed.substr(0, packed.size() / 2));
  EXPECT_EQ(log::open_recording(cut), nullptr);
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)log::read_log({.path = cut}); }), "stop");
}

TEST_F(Mcap, LengthsThatCannotBeAreNotBelieved) {
  for (const std::string& how : packings({"lz4", "zstd"})) {
    for (const std::int64_t size_error :
         {std::int64_t{-100}, std::int64_t{100}, std::int64_t{1} << 40, std::int64_t{1} << 62}) {
      McapWriter mcap;
      declare_imu(mcap);
      for (int i = 0; i < 3; ++i) mcap.message(1, log_time(i), imu(i));
      mcap.end_chunk(how, 0, {}, size_error);
      for (int i = 3; i < 5; ++i) mcap.message(1, log_time(i), imu(i));
      mcap.end_chunk(how);
      const auto recording = opened(mcap.closed());
      const log::Rows rows = read(*recording, 0, kGyroX);
      EXPECT_CONTAINS(joined(rows.notes), "is damaged (");
      EXPECT_EQ(rows.stamps_ns.back(), ns(stamp_at(4)));
    }
  }
}

TEST_F(Mcap, AChunkOfUnknownPackingIsLeftOut) {
  McapWriter mcap;
  declare_imu(mcap);
  for (int i = 0; i < 3; ++i) mcap.message(1, log_time(i), imu(i));
  mcap.end_chunk();
  for (int i = 3; i < 5; ++i) mcap.message(1, log_time(i), imu(i));
  mcap.end_chunk("brotli");
  const auto recording = opened(mcap.closed());
  EXPECT_CONTAINS(notes(*recording), "is packed by 'brotli', expected none, lz4 or zstd");
  EXPECT_EQ(recording->streams()[0].count, 3);
  expect_samples(*recording, 0, 0, 3);
}

TEST_F(Mcap, OneIdForTwoChannelsIsSaid) {
  McapWriter mcap;
  declare_imu(mcap);
  mcap.declare(mcap_channel(1, 1, "/again", "cdr"));
  mcap.message(1, log_time(0), imu(0));
  mcap.end_chunk();
  const auto recording = opened(mcap.closed());
  EXPECT_CONTAINS(notes(*recording), "number 1 is declared as '/imu' and again as '/again'");
  EXPECT_EQ(recording->streams().size(), 1U);
}

TEST_F(Mcap, TimesBeyondTheirTypeAreTheLargest) {
  McapWriter mcap;
  mcap.declare(mcap_channel(1, 0, "/a", "json"));
  mcap.message(1, ~std::uint64_t{0}, "{}");
  mcap.end_chunk();
  EXPECT_EQ(opened(mcap.closed())->read(0, {}).stamps_ns.at(0), std::numeric_limits<std::int64_t>::max());
}

TEST_F(Mcap, CutAtEveryHundredth) {
  for (const std::string& how : packings({"", "lz4", "zstd"})) {
    const std::string whole = chunks(how).cut();
    std::size_t before = 0;
    for (std::size_t hundredth = 1; hundredth < 100; ++hundredth) {
      const std::size_t size = std::max<std::size_t>(whole.size() * hundredth / 100, 8);
      const auto recording = opened(whole.substr(0, size));
      const std::size_t count = recording->streams().empty() ? 0 : read(*recording, 0, kGyroX).stamps_ns.size();
      EXPECT_GE(count, before) << how << hundredth;
      before = count;
      EXPECT_FALSE(notes(*recording).empty());
    }
    EXPECT_GE(before, how.empty() ? 29U : 20U);
  }
}

TEST_F(Mcap, BytesBehindTheFooterAndOtherVersions) {
  EXPECT_CONTAINS(notes(*opened(chunks("").closed() + "more")), "behind the footer");
  EXPECT_EQ(log::recorded_format(McapWriter::kMagic), "MCAP");
  for (std::size_t size = 0; size < McapWriter::kMagic.size(); ++size) {
    EXPECT_EQ(log::recorded_format(McapWriter::kMagic.substr(0, size)), "") << size;
  }
  std::string other = McapWriter::kMagic;
  other[5] = '1';
  EXPECT_CONTAINS(refusal(other + "12345678"), "is an MCAP of version '1', expected 0");
}

TEST_F(Mcap, ARecordThatIsTooLongEndsTheFile) {
  Buffer b;
  b.u8(9).u64(~std::uint64_t{0});
  const std::string cut = chunks("").cut();
  const auto recording = opened(cut + b.bytes + "1234");
  EXPECT_CONTAINS(notes(*recording), "the file ends at byte " + std::to_string(cut.size()) + ", or is damaged there");
  expect_samples(*recording, 0, 0, 30);
}

}  // namespace
}  // namespace gyrobudget::app_tests

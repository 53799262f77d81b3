// SPDX-License-Identifier: MIT
// Logs of PX4: each part of the format, and every way in which it can be broken.
#include <gtest/gtest.h>

#include "recorded.h"
#include "ulog_writer.h"

namespace gyrobudget::app_tests {
namespace {

using U8 = std::uint8_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;

using Ulog = RecordingTest;

const std::string kCombined =
    "sensor_combined:uint64_t timestamp;float[3] gyro_rad;uint32_t gyro_integral_dt;int32_t accelerometer_timestamp_relative;float[3] accelerometer_m_s2;";

std::string combined(U64 us, float x, std::int32_t age = 0) {
  return packed(us, x, x + 1, x + 2, U32{4000}, age, -x, -x - 1, -x - 2);
}

TEST_F(Ulog, TopicsAndInstancesAreStreams) {
  UlogWriter log;
  log.flags(0).format(
      "sensor_gyro:uint64_t timestamp;uint64_t timestamp_sample;float x;float y;float z;uint8_t[4] _padding0;");
  log.subscribe(3, "sensor_gyro", 0).subscribe(4, "sensor_gyro", 1).format(kCombined).subscribe(9, "sensor_combined");
  for (int i = 0; i < 4; ++i) {
    const U64 us = 1'700'000'000'000'001 + 2500 * i;
    log.data(3, packed(us + 100, us, 1.5F * i, 2.F, 3.F, U32{}));
    log.data(4, packed(us + 200, us + 50, -1.5F * i, 2.F, 3.F));  // padding at the end may be missing
    log.data(9, combined(us, 10.F + i));
  }
  const auto recording = open(log.bytes());
  EXPECT_EQ(recording->format(), "PX4 ULog");
  EXPECT_EQ(log::recorded_format(log.bytes()), "PX4 ULog");
  ASSERT_EQ(recording->streams().size(), 3U);
  EXPECT_EQ(recording->streams()[0].name, "sensor_gyro[0]");
  EXPECT_EQ(recording->streams()[1].name, "sensor_gyro[1]");
  EXPECT_EQ(recording->streams()[2].name, "sensor_combined");
  EXPECT_EQ(info(*recording, "sensor_gyro[1]").kind, log::StreamKind::gyroscope);
  EXPECT_EQ(info(*recording, "sensor_combined").kind, log::StreamKind::imu);
  EXPECT_EQ(info(*recording, "sensor_gyro[1]").count, 4);
  EXPECT_EQ(info(*recording, "sensor_gyro[1]").fields.size(), 5U);  // no padding
  EXPECT_EQ(field(*recording, "sensor_gyro[0]", "y").unit, "rad/s");
  EXPECT_EQ(field(*recording, "sensor_combined", "gyro_integral_dt").unit, "us");
  EXPECT_EQ(field(*recording, "sensor_combined", "accelerometer_m_s2[2]").unit, "m/s^2");

  const log::Rows gyro = read(*recording, "sensor_gyro[1]", {"z", "x"});
  EXPECT_EQ(gyro.clock, "timestamp_sample");
  EXPECT_EQ(gyro.stamps_ns.front(), 1'700'000'000'000'051'000);  // no double has these digits
  EXPECT_EQ(gyro.stamps_ns.back(), 1'700'000'000'007'551'000);
  EXPECT_THAT(gyro.columns[0], testing::ElementsAre(3, 3, 3, 3));
  EXPECT_THAT(gyro.columns[1], testing::ElementsAre(0, -1.5, -3, -4.5));
  const log::Rows imu = read(*recording, "sensor_combined", {"gyro_rad[1]", "accelerometer_m_s2[2]"});
  EXPECT_THAT(imu.columns[0], testing::ElementsAre(11, 12, 13, 14));
  EXPECT_THAT(imu.columns[1], testing::ElementsAre(-12, -13, -14, -15));
  EXPECT_THROW((void)recording->read(3, {}), std::out_of_range);
  const std::vector<std::size_t> none{99};
  EXPECT_THROW((void)recording->read(0, none), std::out_of_range);
}

TEST_F(Ulog, EveryTypeArraysAndWhatIsNested) {
  UlogWriter log;
  log.format("outer:uint64_t timestamp;inner[2] part;bool flag;char[5] word;int8_t last;");
  log.format("inner:int16_t a;uint16_t b;deep c;");  // later than what holds it
  log.format("deep:double d;int64_t e;uint8_t f;int32_t g;uint32_t h;");
  log.subscribe(0, "outer");
  const auto inner = [](std::int16_t n) {
    return packed(n, std::uint16_t(n + 40000)) + packed(n + .5) +
           packed(std::int64_t{-n}, U8(n), -n * 1000, U32(4'000'000'000U));
  };
  log.data(0, packed(U64{5}) + inner(-3) + inner(7) + packed(true) + "hello" + packed(std::int8_t{-128}));
  const auto recording = open(log.bytes());
  EXPECT_EQ(info(*recording, "outer").fields.size(), 1 + 2 * 7 + 2U);  // no text
  const log::Rows rows = read(*recording, "outer",
                              {"part[0].a", "part[1].b", "part[1].c.d", "part[0].c.e", "part[0].c.f", "part[1].c.g",
                               "part[1].c.h", "flag", "last"});
  std::vector<double> values;
  for (const auto& column : rows.columns) values.push_back(column.at(0));
  EXPECT_THAT(values, testing::ElementsAre(-3, 40007, 7.5, 3, 253, -7000, 4e9, 1, -128));
}

TEST_F(Ulog, UnitsGoByTypeToo) {
  UlogWriter log;
  log.format("sensor_combined:uint64_t timestamp;float[3] gyro_rad;float gyro_integral_dt;");  // of 2017
  log.format("vehicle_gps_position:uint64_t timestamp;int32_t lat;int32_t lon;int32_t alt;");
  log.format("sensor_gps:uint64_t timestamp;double latitude_deg;double longitude_deg;");
  log.format("sensor_mag:uint64_t timestamp;float x;float y;float z;");
  log.subscribe(0, "sensor_combined")
      .subscribe(1, "vehicle_gps_position")
      .subscribe(2, "sensor_gps")
      .subscribe(3, "sensor_mag");
  log.data(0, packed(U64{1}, 1.F, 2.F, 3.F, .004F));
  log.data(1, packed(U64{1}, std::int32_t{-23'000'000}, std::int32_t{-444'000'000}, std::int32_t{-24'950}));
  log.data(2, packed(U64{1}) + packed(-2.3, -44.4));
  log.data(3, packed(U64{1}, .5F, 0.F, 0.F));
  const auto recording = open(log.bytes());
  EXPECT_EQ(field(*recording, "sensor_combined", "gyro_integral_dt").unit, "s");
  EXPECT_EQ(field(*recording, "vehicle_gps_position", "lat").unit, "deg");
  EXPECT_EQ(info(*recording, "sensor_gps").kind, log::StreamKind::gnss);
  EXPECT_EQ(info(*recording, "sensor_mag").kind, log::StreamKind::magnetometer);
  const log::Rows gps = read(*recording, "vehicle_gps_position", {"lat", "lon", "alt"});
  EXPECT_NEAR(gps.columns[0][0], -2.3, 1e-14);
  EXPECT_NEAR(gps.columns[1][0], -44.4, 1e-13);
  EXPECT_NEAR(gps.columns[2][0], -24.95, 1e-13);
  EXPECT_EQ(read(*recording, "sensor_gps", {"latitude_deg"}).columns[0][0], -2.3);
  EXPECT_NEAR(read(*recording, "sensor_mag", {"x"}).columns[0][0], 5e-5, 1e-18);  // gauss to tesla
}

TEST_F(Ulog, BurstsBecomeSamples) {
  UlogWriter log;
  log.format(
      "sensor_gyro_fifo:uint64_t timestamp;uint64_t timestamp_sample;float dt;float scale;uint8_t samples;int16_t[4] x;int16_t[4] y;int16_t[4] z;");
  log.subscribe(0, "sensor_gyro_fifo");
  const auto burst = [](U64 us, U8 samples, std::int16_t first) {
    std::string bytes = packed(us + 900, us) + packed(250.F, .5F) + packed(samples);
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 4; ++k) bytes += packed(std::int16_t(first + 10 * axis + k));
    return bytes;
  };
  log.data(0, burst(10000, 4, 0)).data(0, burst(11000, 3, 100)).data(0, burst(12000, 200, -4));
  const auto recording = open(log.bytes());
  EXPECT_EQ(recording->streams()[0].count, 4 + 3 + 4);
  EXPECT_EQ(recording->streams()[0].kind, log::StreamKind::gyroscope);
  EXPECT_EQ(field(*recording, "sensor_gyro_fifo", "y").unit, "rad/s");
  const log::Rows rows = read(*recording, "sensor_gyro_fifo", {"y", "samples"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(5, 5.5, 6, 6.5, 55, 55.5, 56, 3, 3.5, 4, 4.5));
  EXPECT_THAT(rows.stamps_ns, testing::ElementsAre(9250000, 9500000, 9750000, 10000000, 10500000, 10750000, 11000000,
                                                   11250000, 11500000, 11750000, 12000000));
  EXPECT_EQ(rows.columns[1][10], 200);
}

TEST_F(Ulog, AnAccelerometerThatIsNotThereIsNoNumber) {
  UlogWriter log;
  log.format(kCombined).subscribe(0, "sensor_combined");
  log.data(0, combined(1000, 1)).data(0, combined(5000, 2, 0x7fffffff)).data(0, combined(9000, 3));
  const log::Rows rows = read(*open(log.bytes()), "sensor_combined", {"gyro_rad[0]", "accelerometer_m_s2[0]"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(1, 2, 3));
  EXPECT_TRUE(std::isnan(rows.columns[1][1]));
  EXPECT_EQ(rows.columns[1][2], -3);
  expect_note(rows.notes, "accelerometer_m_s2[0]: 1 row without a number");
}

TEST_F(Ulog, ASampleTimeThatTellsNothingGivesWay) {
  UlogWriter log;
  log.format("a:uint64_t timestamp;uint64_t timestamp_sample;float x;").subscribe(0, "a");
  for (int i = 0; i < 3; ++i) log.data(0, packed(U64(1000 * i), U64{0}, 1.F));
  const log::Rows rows = read(*open(log.bytes()), "a", {"x"});
  EXPECT_EQ(rows.clock, "timestamp");
  EXPECT_THAT(rows.stamps_ns, testing::ElementsAre(0, 1000000, 2000000));
  expect_note(rows.notes, "timestamp_sample tells no time: timestamp stands in");
}

TEST_F(Ulog, DecimatedTopicsSaySo) {
  UlogWriter log;
  log.format("vehicle_imu:uint64_t timestamp;float[3] delta_angle;uint16_t delta_angle_dt;")
      .subscribe(0, "vehicle_imu");
  log.format(kCombined).subscribe(1, "sensor_combined");
  for (int i = 0; i < 5; ++i) {
    log.data(0, packed(U64(500'000 * i), 1e-5F, 0.F, 0.F) + packed(std::uint16_t{4900}));
    log.data(1, combined(U64(4000 * i), 1));
  }
  const auto recording = open(log.bytes());
  expect_note(read(*recording, "vehicle_imu", {"delta_angle[0]"}).notes,
              "rows are 0.5 s apart and cover 0.0049 s each");
  EXPECT_EQ(field(*recording, "vehicle_imu", "delta_angle[0]").unit, "rad");
  EXPECT_TRUE(read(*recording, "sensor_combined", {"gyro_rad[0]"}).notes.empty());
}

TEST_F(Ulog, AppendedDataGoOnWhereTheyBegin) {
  UlogWriter start;
  start.flags(1, 0).format(kCombined).subscribe(0, "sensor_combined").data(0, combined(1000, 1));
  const std::string half = packed(std::uint16_t{300}) + "D" + std::string(20, 'x');  // cut by what follows
  const std::string part = UlogWriter().data(0, combined(5000, 2)).bytes().substr(16);
  const U64 first = start.bytes().size() + half.size(), second = first + part.size() + half.size();
  UlogWriter log;
  log.flags(1, first, second).format(kCombined).subscribe(0, "sensor_combined").data(0, combined(1000, 1));
  log.raw(half + part + half + part);
  const auto recording = open(log.bytes());
  EXPECT_EQ(recording->streams()[0].count, 3);
  expect_note(recording->notes(), "2 messages cut where data were appended");
  const auto without = open(log.bytes().substr(0, second - half.size()));
  expect_note(without->notes(), "data appended at byte " + std::to_string(second) + " are not there");
  EXPECT_EQ(without->streams()[0].count, 2);
}

TEST_F(Ulog, FlagsThatForbidReadingAreObeyed) {
  EXPECT_CONTAINS(refusal(UlogWriter().flags(2).bytes()), "forbids readers which do not know it");
  UlogWriter other;
  other.message('B', std::string(8, '\x7f') + std::string(32, '\0') + "grown");  // optional features, and more of them
  EXPECT_TRUE(open(other.bytes())->notes().empty());
  expect_note(open(UlogWriter(9).bytes())->notes(), "version 9");
  EXPECT_CONTAINS(refusal(UlogWriter().bytes().substr(0, 12)),
                  "ends after 12 bytes, inside the 16 bytes of the header");
}

TEST_F(Ulog, DropoutsSelectionsStrangersAndUnknownMessages) {
  UlogWriter log;
  log.format(kCombined)
      .subscribe(0, "sensor_combined")
      .format("sensor_selection:uint64_t timestamp;uint32_t gyro_device_id;");
  log.subscribe(1, "sensor_selection").data(1, packed(U64{1}, U32{7})).data(0, combined(1000, 1));
  log.message('O', packed(std::uint16_t{30}))
      .message('O', packed(std::uint16_t{12}))
      .message('z', "of the future")
      .message('I', "x");
  log.data(77, "nobody knows").data(0, combined(5000, 2)).data(1, packed(U64{2}, U32{8}));
  log.message('R', packed(std::uint16_t{0})).data(0, combined(9000, 3)).data(0, "s");
  const auto recording = open(log.bytes());
  EXPECT_EQ(info(*recording, "sensor_combined").count, 2);
  expect_note(recording->notes(), "lost data 2 times, 42 ms in all, 30 ms at the longest");
  expect_note(recording->notes(), "3 messages of no known topic left out");
  expect_note(recording->notes(), "changed its gyroscope once");
}

TEST_F(Ulog, MessagesOfOtherLengthThanTheirFormat) {
  UlogWriter log;
  log.format(kCombined).subscribe(0, "sensor_combined");
  log.data(0, combined(1000, 1) + "longer").data(0, combined(2000, 2).substr(0, 30)).data(0, combined(3000, 3));
  const log::Rows rows = read(*open(log.bytes()), "sensor_combined", {"gyro_rad[0]"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(1, 3));
  expect_note(rows.notes, "1 message shorter than the format left out");
}

TEST_F(Ulog, DamageIsPassedToTheNextMark) {
  UlogWriter log;
  log.format(kCombined).subscribe(0, "sensor_combined").data(0, combined(1000, 1));
  const std::size_t at = log.bytes().size();
  log.raw(std::string(50, '\0')).raw(kUlogSync).data(0, combined(5000, 2));
  const auto zeros = open(log.bytes());
  EXPECT_EQ(zeros->streams()[0].count, 2);
  expect_note(zeros->notes(), "left out as damaged: 50 bytes, the first at byte " + std::to_string(at));
  // A length that is far beyond what is left is damage where a mark follows, the end of the file where none does.
  UlogWriter lost;
  lost.format(kCombined)
      .subscribe(0, "sensor_combined")
      .data(0, combined(1000, 1))
      .raw(
          "\xff\xff"
          "D0000")
      .raw(kUlogSync)
      .data(0, combined(5000, 2));
  EXPECT_EQ(open(lost.bytes())->streams()[0].count, 2);
  UlogWriter cut;
  cut.format(kCombined)
      .subscribe(0, "sensor_combined")
      .data(0, combined(1000, 1))
      .raw(
          "\xff\xff"
          "D0000");
  expect_note(open(cut.bytes())->notes(),
              "ends inside a message: 7 bytes from byte " + std::to_string(cut.bytes().size() - 7));
}

TEST_F(Ulog, FormatsOfStrangers) {
  const std::vector<std::string> formats{"a:a x;",                 // holds itself
                                         "a:float[999999999] x;",  // larger than any message
                                         "a:float[-1] x;",
                                         "a:float[3 x;",
                                         "a:quaternion q;",  // of no format
                                         "a:float;",
                                         "a:b[60000] x;",
                                         "nothing"};
  for (const std::string& format : formats) {
    UlogWriter log;
    log.format(format).format("b:c[60000] y;").format("c:").subscribe(0, "a").data(0, std::string(100, '\0'));
    const auto recording = open(log.bytes());
    ASSERT_EQ(recording->streams().size(), 1U) << format;
    EXPECT_TRUE(recording->streams()[0].fields.empty()) << format;
    expect_note(recording->notes(), "a: its format is not there or not understood");
  }
  UlogWriter odd;
  odd.format("\x1b[2J\n:float x;").subscribe(0, "\x1b[2J\n").data(0, packed(1.F));
  EXPECT_EQ(open(odd.bytes())->streams()[0].name.find('\x1b'), std::string::npos);
}

TEST_F(Ulog, StampsBeyondReasonAreLeftOut) {
  UlogWriter log;
  log.format("a:uint64_t timestamp;float x;").subscribe(0, "a");
  log.data(0, packed(U64{1}, 1.F)).data(0, packed(~U64{0}, 2.F)).data(0, packed(U64{3}, 3.F));
  const log::Rows rows = read(*open(log.bytes()), "a", {"x"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(1, 3));
  expect_note(rows.notes, "1 row with a time beyond reason left out");
}

TEST_F(Ulog, CutEverywhere) {
  UlogWriter log;
  log.flags(0).format(kCombined).subscribe(0, "sensor_combined");
  for (int i = 0; i < 30; ++i) log.data(0, combined(1000 * i, 1));
  cut_everywhere(log.bytes());
}

TEST_F(Ulog, MemoryIsThatOfTheNumbers) {
  std::string path;
  {
    UlogWriter log;
    log.format(kCombined).subscribe(0, "sensor_combined");
    for (int i = 0; i < 500'000; ++i) log.data(0, combined(4000 * i, 1));
    path = file("log.ulg", log.bytes());
  }
  expect_little_memory(path, "sensor_combined", 1.3);  // a part of the file is in memory too
}

// --- Real ones; numbers by two other readers ------------------------------------------------------------------------

TEST_F(Ulog, RealCube) {
  const std::string path = real("ulog/cube_small.ulg");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  const log::Rows imu = read(*recording, "sensor_combined",
                             {"gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]", "accelerometer_m_s2[0]",
                              "accelerometer_m_s2[1]", "accelerometer_m_s2[2]"});
  EXPECT_EQ(imu.stamps_ns.size(), 1298U);
  EXPECT_EQ(imu.stamps_ns.front(), 20326716000);
  EXPECT_EQ(imu.stamps_ns.back(), 26822868000);
  expect_statistics(imu, {0.00445785976, 0.000311703835, 0.00100957774, -0.0171233365, -0.166934577, -9.62149484},
                    {0.00290752, 0.00245983, 0.00263549, 0.0246766, 0.0282083, 0.0405712});
  expect_statistics(read(*recording, "sensor_gyro[1]", {"x"}), {0.0173746608}, {});
  expect_statistics(
      read(*recording, "vehicle_imu[0]", {"delta_angle[0]", "delta_angle[1]", "delta_angle[2]", "delta_angle_dt"}),
      {1.88778655e-05, 2.47585579e-06, -2.01072285e-06, 4893.5}, {});
  expect_note(recording->notes(), "lost data once, 30 ms in all");
}

TEST_F(Ulog, RealAppended) {
  const std::string path = real("ulog/appended_multiple.ulg");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  const log::Rows imu = read(*recording, "sensor_combined",
                             {"gyro_rad[0]", "gyro_rad[1]", "gyro_rad[2]", "accelerometer_m_s2[0]",
                              "accelerometer_m_s2[1]", "accelerometer_m_s2[2]", "gyro_integral_dt"});
  EXPECT_EQ(imu.stamps_ns.size(), 2373U);
  EXPECT_EQ(imu.stamps_ns.front(), 12262822000);
  EXPECT_EQ(imu.stamps_ns.back(), 21880422000);
  expect_statistics(
      imu, {-0.00386224107, 0.00698863805, 0.00297619243, 0.542033569, 0.313191655, -9.92120800, 0.00404787197}, {});
  EXPECT_EQ(field(*recording, "sensor_combined", "gyro_integral_dt").unit, "s");
  cut_everywhere(content(path));
}

}  // namespace
}  // namespace gyrobudget::app_tests

// SPDX-License-Identifier: MIT
// Logs of ArduPilot, binary and as text.
#include <gtest/gtest.h>

#include "recorded.h"

namespace gyrobudget::app_tests {
namespace {

using U8 = std::uint8_t;
using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;

using Dataflash = RecordingTest;

/// Writes a log byte by byte.
class Writer {
 public:
  Writer() { format(0x80, 89, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns"); }
  Writer& message(U8 type, const std::string& body) {
    bytes_ += "\xa3\x95" + std::string(1, static_cast<char>(type)) + body;
    return *this;
  }
  Writer& format(U8 type, U8 length, const std::string& name, const std::string& format, const std::string& labels) {
    return message(0x80, packed(type, length) + padded(name, 4) + padded(format, 16) + padded(labels, 64));
  }
  /// Units and multipliers of the messages of a type, and what the letters mean.
  Writer& unit(char id, const std::string& label) { return message(114, packed(U64{}, id) + padded(label, 64)); }
  Writer& multiplier(char id, double factor) { return message(115, packed(U64{}, id) + packed(factor)); }
  Writer& units_of(U8 type, const std::string& units, const std::string& multipliers) {
    return message(113, packed(U64{}, type) + padded(units, 16) + padded(multipliers, 16));
  }
  Writer& unit_formats() {
    format(114, 3 + 8 + 1 + 64, "UNIT", "QbZ", "TimeUS,Id,Label");
    format(115, 3 + 8 + 1 + 8, "MULT", "Qbd", "TimeUS,Id,Mult");
    return format(113, 3 + 8 + 1 + 32, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds");
  }
  Writer& raw(const std::string& bytes) {
    bytes_ += bytes;
    return *this;
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

constexpr U8 kImu = 130;
Writer& old_imu(Writer& log, U8 type = kImu, const std::string& name = "IMU") {
  return log.format(type, 3 + 8 + 12, name, "Qfff", "TimeUS,GyrX,AccX,T");
}
std::string imu(U64 us, float x) { return packed(us, x, 2 * x, 3 * x); }

TEST_F(Dataflash, OneNameForEachSensor) {
  Writer log;
  old_imu(log), old_imu(log, 131, "IMU2");
  for (int i = 0; i < 3; ++i)
    log.message(kImu, imu(1'000'000'000'000 + 20'000 * i, 1.F + i)).message(131, imu(20'000 * i, -1.F));
  const auto recording = open(log.bytes());
  EXPECT_EQ(recording->format(), "ArduPilot dataflash");
  EXPECT_EQ(info(*recording, "IMU").kind, log::StreamKind::imu);
  EXPECT_EQ(info(*recording, "IMU").count, 3);
  EXPECT_EQ(info(*recording, "IMU").clock, "TimeUS");
  EXPECT_EQ(field(*recording, "IMU2", "GyrX").unit, "rad/s");
  EXPECT_EQ(field(*recording, "IMU2", "AccX").unit, "m/s^2");
  EXPECT_EQ(field(*recording, "IMU", "GyrX").unit_from, "ArduPilot has it so");
  const log::Rows rows = read(*recording, "IMU", {"AccX", "TimeUS"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(2, 4, 6));
  EXPECT_THAT(rows.stamps_ns,
              testing::ElementsAre(1'000'000'000'000'000, 1'000'000'020'000'000, 1'000'000'040'000'000));
}

TEST_F(Dataflash, InstancesAreStreamsAndUnitsAreTold) {
  Writer log;
  log.format(kImu, 3 + 8 + 1 + 12 + 2 + 4, "IMU", "QBfffcL", "TimeUS,C,GyrX,GyrY,AccX,T,Lat");
  const auto row = [](U64 us, U8 core, float x) {
    return packed(us, core) + packed(x, 1.F, 2.F) + packed(std::int16_t{2150}) + packed(std::int32_t{-23'000'000});
  };
  for (int i = 0; i < 4; ++i) log.message(kImu, row(1000 * (i / 2), i % 2, 10.F * i));
  // What tells the units may come behind the data.
  log.unit_formats().units_of(kImu, "s#EkoOD", "F-00/BG");
  log.unit('E', "rad/s")
      .unit('k', "deg/s")
      .unit('o', "m/s/s")
      .unit('O', "degC")
      .unit('D', "deglatitude")
      .unit('#', "instance")
      .unit('s', "s");
  log.multiplier('F', 1e-6)
      .multiplier('0', 1)
      .multiplier('/', 3600)
      .multiplier('B', .01)
      .multiplier('G', 1e-7)
      .multiplier('-', 0);
  const auto recording = open(log.bytes());
  EXPECT_EQ(info(*recording, "IMU[1]").count, 2);
  EXPECT_EQ(info(*recording, "IMU[0]").kind, log::StreamKind::imu);
  EXPECT_EQ(field(*recording, "IMU[0]", "GyrY").unit, "deg/s");
  EXPECT_EQ(field(*recording, "IMU[0]", "AccX").unit, "m/s^2");
  EXPECT_EQ(field(*recording, "IMU[0]", "Lat").unit, "deg");
  EXPECT_EQ(field(*recording, "IMU[0]", "T").unit_from, "UNIT of the log");
  const log::Rows rows = read(*recording, "IMU[1]", {"GyrX", "AccX", "T", "Lat", "TimeUS"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(10, 30));
  EXPECT_EQ(rows.columns[1][0], 7200);
  EXPECT_EQ(rows.columns[2][0], 21.5);  // a hundredth once, not twice
  EXPECT_NEAR(rows.columns[3][0], -2.3, 1e-15);
  EXPECT_EQ(rows.columns[4][1], 1e-3);
  EXPECT_EQ(rows.stamps_ns[1], 1'000'000);
}

TEST_F(Dataflash, EveryLetter) {
  Writer log;
  log.format(200, 3 + 64 + 1 + 1 + 2 + 2 + 4 + 4 + 8 + 8, "ALL", "abBhHiIqQ", "a,b,c,d,e,f,g,h,i");
  log.format(201, 3 + 4 + 8 + 2 + 4 + 16 + 64 + 2 + 2 + 4 + 4 + 4 + 1, "MORE", "fdgnNZcCeELM", "a,b,c,d,e,f,g,h,i,j,k");
  std::string samples;
  for (int i = 0; i < 32; ++i) samples += packed(std::int16_t(i * 1000));
  log.message(200, samples + packed(std::int8_t{-1}, U8{255}, std::int16_t{-2}, U16{65535}) +
                       packed(-3, U32{4'000'000'000}) + packed(std::int64_t{-4}, U64{5}));
  log.message(201, packed(1.5F) + packed(2.5) + packed(U16{0xc500}) + "nameN234567890123456" + std::string(64, 'Z') +
                       packed(std::int16_t{-150}, U16{250}) + packed(-350, U32{450}, -10'000'000) + packed(U8{9}));
  const auto recording = open(log.bytes());
  EXPECT_EQ(info(*recording, "ALL").fields.size(), 32 + 8U);
  const auto values = [&](const std::string& stream) {
    std::vector<double> all;
    const std::size_t place = stream_named(*recording, stream);
    for (std::size_t i = 0; i < recording->streams()[place].fields.size(); ++i)
      all.push_back(recording->read(place, std::span(&i, 1)).columns[0].at(0));
    return all;
  };
  const std::vector<double> all = values("ALL");
  EXPECT_EQ(all[31], 31000);
  EXPECT_THAT(std::vector<double>(all.begin() + 32, all.end()),
              testing::ElementsAre(-1, 255, -2, 65535, -3, 4e9, -4, 5));
  EXPECT_THAT(values("MORE"), testing::ElementsAre(1.5, 2.5, -5, -1.5, 2.5, -3.5, 4.5, -1, 9));
  EXPECT_EQ(info(*recording, "MORE").fields.back().name, "column 12");
}

TEST_F(Dataflash, ClocksOfOldLogs) {
  Writer log;
  log.format(1, 3 + 4 + 4, "IMU", "If", "TimeMS,GyrX");
  log.format(2, 3 + 1 + 4 + 4 + 4, "GPS", "BILI", "Status,TimeMS,Lat,T");  // the time of week, and that of the others
  log.format(3, 3 + 8 + 8 + 4, "GYR1", "QQf", "TimeUS,SampleUS,GyrX");
  log.format(4, 3 + 4 + 4 + 4, "ACC1", "IIf", "TimeMS,TimeUS,AccX");
  log.format(5, 3 + 8 + 8 + 4, "GYR2", "QQf", "TimeUS,SampleUS,GyrX");
  for (int i = 0; i < 3; ++i) {
    log.message(1, packed(U32(100 + i), 1.F)).message(2, packed(U8{3}) + packed(U32(345'600'000), 1, U32(200 + i)));
    log.message(3, packed(U64(5000 + i), U64(4000 + i)) + packed(1.F));
    log.message(4, packed(U32(4'294'967 + i), U32(4'294'967'000U + 200U * i), 1.F));
    log.message(5, packed(U64(5000 + i), U64(0)) + packed(1.F));
  }
  const auto recording = open(log.bytes());
  EXPECT_THAT(read(*recording, "IMU", {}).stamps_ns, testing::ElementsAre(100'000'000, 101'000'000, 102'000'000));
  expect_note(read(*recording, "IMU", {}).notes, "stamps are whole milliseconds");
  EXPECT_EQ(read(*recording, "GPS", {}).stamps_ns.front(), 200'000'000);
  EXPECT_EQ(info(*recording, "GPS").kind, log::StreamKind::gnss);
  EXPECT_EQ(read(*recording, "GYR1", {}).clock, "SampleUS");
  EXPECT_EQ(read(*recording, "GYR1", {}).stamps_ns.front(), 4'000'000);
  const log::Rows wrapped = read(*recording, "ACC1", {});  // 2^32 us are 71 minutes
  EXPECT_THAT(wrapped.stamps_ns, testing::ElementsAre(4'294'967'000'000, 4'294'967'200'000, 4'294'967'400'000));
  expect_note(wrapped.notes, "began anew");
  EXPECT_EQ(read(*recording, "GYR2", {}).clock, "TimeUS");
  EXPECT_EQ(read(*recording, "GYR2", {}).stamps_ns.back(), 5'002'000);
}

TEST_F(Dataflash, BatchesOfRawSamples) {
  Writer log;
  log.format(163, 31, "ISBH", "QHBBHHQf", "TimeUS,N,type,instance,mul,smp_cnt,SampleUS,smp_rate");
  log.format(164, 207, "ISBD", "QHHaaa", "TimeUS,N,seqno,x,y,z");
  const auto head = [&](U16 n, U8 type, U8 instance, U64 us) {
    log.message(163, packed(us, n) + packed(type, instance) + packed(U16{100}, U16{40}) + packed(us) + packed(1000.F));
  };
  const auto piece = [&](U16 n, U16 sequence) {
    std::string body = packed(U64{}, n) + packed(sequence);
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < 32; ++k) body += packed(std::int16_t(1000 * axis + 32 * sequence + k));
    log.message(164, body);
  };
  head(7, 1, 2, 1'000'000), piece(7, 0), piece(7, 1), piece(7, 2);  // 40 samples: the third has none
  head(8, 0, 2, 2'000'000), piece(8, 0);
  piece(99, 0);                           // without a header
  head(9, 1, 2, 3'000'000), piece(9, 1);  // its first piece was lost
  const auto recording = open(log.bytes());
  const std::string gyro = "gyroscope batches[2]";
  EXPECT_EQ(info(*recording, gyro).count, 40 + 8);
  EXPECT_EQ(info(*recording, gyro).kind, log::StreamKind::gyroscope);
  EXPECT_EQ(info(*recording, "accelerometer batches[2]").count, 32);
  EXPECT_EQ(field(*recording, gyro, "y").unit, "rad/s");
  EXPECT_EQ(info(*recording, "ISBD").count, 6);
  const log::Rows rows = read(*recording, gyro, {"y"});
  EXPECT_EQ(rows.columns[0][39], (1000 + 39) / 100.);
  EXPECT_EQ(rows.stamps_ns[39], 1'039'000'000);
  EXPECT_EQ(rows.columns[0][40], (1000 + 32) / 100.);
  EXPECT_EQ(rows.stamps_ns[40], 3'032'000'000);
  expect_note(rows.notes, "2 pieces at 1000 Hz nominal, with gaps between them");
}

TEST_F(Dataflash, MarksWithinMessagesMeanNothing) {
  Writer log;
  old_imu(log).format(196, 3 + 64, "FILE", "Z", "Data");
  const std::string inner = Writer().message(kImu, imu(1, 1)).bytes().substr(89);
  log.message(kImu, imu(1, 1)).message(196, padded(inner + inner, 64)).message(kImu, imu(2, 2));
  const auto recording = open(log.bytes());
  EXPECT_EQ(info(*recording, "IMU").count, 2);
  EXPECT_TRUE(recording->notes().empty());
}

TEST_F(Dataflash, DamageIsSkippedToWhatIsFollowedByAMessage) {
  Writer log;
  old_imu(log).message(kImu, imu(1, 1));
  const std::size_t at = log.bytes().size();
  log.raw(
         "xx\xa3\x95\x82"
         "false")
      .raw(std::string(40, '\xa3'))
      .message(kImu, imu(2, 2))
      .message(kImu, imu(3, 3))
      .raw(
          "\xa3\x95\x82"
          "cut");
  const auto recording = open(log.bytes());
  EXPECT_THAT(read(*recording, "IMU", {"GyrX"}).columns[0], testing::ElementsAre(1, 2, 3));
  expect_note(recording->notes(), "left out as of no message: 50 bytes, the first at byte " + std::to_string(at));
  expect_note(recording->notes(), "ends inside a message: 6 bytes from byte");
}

TEST_F(Dataflash, FormatsThatChangeOrDisagree) {
  Writer log;
  log.format(10, 3, "STRT", "", "").message(10, "");  // as the oldest have it
  log.format(11, 3 + 9, "ODD", "Q", "TimeUS").message(11, std::string(9, 'x'));
  log.format(12, 3 + 4, "NEW", "w", "TimeUS").message(12, "abcd");  // a letter of the future
  old_imu(log).message(kImu, imu(1, 1));
  log.format(kImu, 3 + 8 + 4, "IMU", "Qf", "TimeUS,GyrX").message(kImu, packed(U64{2}, 5.F));
  const auto recording = open(log.bytes());
  EXPECT_EQ(info(*recording, "STRT").count, 1);
  EXPECT_TRUE(info(*recording, "ODD").fields.empty());
  expect_note(recording->notes(), "ODD: its format does not agree with its length");
  expect_note(recording->notes(), "NEW: its format does not agree with its length");
  EXPECT_EQ(info(*recording, "IMU").fields.size(), 4U);
  EXPECT_EQ(info(*recording, "IMU (2)").fields.size(), 2U);
  EXPECT_EQ(read(*recording, "IMU (2)", {"GyrX"}).columns[0][0], 5);
}

TEST_F(Dataflash, AsText) {
  const std::string text =
      "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\r\n"
      "FMT, 130, 30, IMU, QBfffc, TimeUS,I,GyrX,GyrY,AccX,T\r\n"
      "FMT, 134, 75, MSG, QZ, TimeUS,Message\r\n"
      "MSG, 1, a text, with commas\r\n"
      "IMU, 1700000000000001, 0, 0.5, 1, 2, 21.50\r\n"
      "IMU, 1700000000000001, 1, 0.25, 1, 2, -1\r\n"
      "IMU, 1700000000002501, 0, nan, 1\r\n"  // too few
      "IMU, 1700000000002501, 0, -1.5e-3, 1, 2, 3\r\n"
      "WHAT, 1\r\n";
  const auto recording = open(text);
  EXPECT_EQ(recording->format(), "ArduPilot dataflash, as text");
  const log::Rows rows = read(*recording, "IMU[0]", {"GyrX", "T"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(.5, -1.5e-3));
  EXPECT_THAT(rows.columns[1], testing::ElementsAre(21.5, 3));  // the text has the hundredth in it
  EXPECT_THAT(rows.stamps_ns, testing::ElementsAre(1'700'000'000'000'001'000, 1'700'000'000'002'501'000));
  EXPECT_EQ(info(*recording, "IMU[1]").count, 1);
  EXPECT_EQ(info(*recording, "MSG").count, 1);
  // A number that may be cut is none.
  const auto cut = open(text.substr(0, text.find(", 3\r\n") + 3));
  EXPECT_EQ(info(*cut, "IMU[0]").count, 1);
  expect_note(cut->notes(), "the file ends inside a line");
  EXPECT_EQ(field(*recording, "IMU[1]", "GyrX").unit, "rad/s");
  expect_note(recording->notes(), "1 line with too few values");
  expect_note(recording->notes(), "left out as of no message: 1 line, the first at byte ");
  cut_everywhere(text);
}

TEST_F(Dataflash, CutEverywhere) {
  Writer log;
  old_imu(log);
  for (int i = 0; i < 50; ++i) log.message(kImu, imu(1000 * i, 1));
  cut_everywhere(log.bytes());
}

// --- Real ones; numbers by two other readers ------------------------------------------------------------------------

const std::vector<std::string> kAxes{"GyrX", "GyrY", "GyrZ", "AccX", "AccY", "AccZ"};

std::int64_t messages(const log::Recording& recording) {
  std::int64_t sum = 0;
  for (const log::StreamInfo& stream : recording.streams()) sum += stream.count;
  return sum;
}

TEST_F(Dataflash, RealPlane) {
  const std::string path = real("ardupilot/plane_382.BIN");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  EXPECT_EQ(messages(*recording), 1731);
  expect_note(recording->notes(), "ends inside a message: 24 bytes");
  const log::Rows imu = read(*recording, "IMU", kAxes);
  EXPECT_EQ(imu.stamps_ns.front(), 81'794'643'000);
  EXPECT_EQ(imu.stamps_ns.back(), 82'769'489'000);
  expect_statistics(imu, {-0.00629605649, 0.000317134156, -0.000467941235, 0.354664479, 0.772576176, -9.89369278},
                    {0.0522702, 0.0249428, 0.00600098, 0.062217, 0.143931, 0.101278});
  expect_statistics(read(*recording, "IMU2", kAxes),
                    {-0.0047787485, 0.000795428699, 0.0006233937, 0.321209573, 0.831720951, -9.78782842},
                    {0.0517337, 0.0248762, 0.0061385, 0.0640195, 0.146335, 0.103556});
  EXPECT_EQ(imu.stamps_ns.size(), 45U);
  cut_everywhere(content(path));
}

TEST_F(Dataflash, RealSimulatedCopterOfTwoSensors) {
  const std::string path = real("ardupilot/copter_444_sitl.bin");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  EXPECT_EQ(messages(*recording), 33936);
  EXPECT_TRUE(recording->notes().empty());
  const log::Rows imu = read(*recording, "IMU[0]", kAxes);
  EXPECT_EQ(imu.stamps_ns.size(), 624U);
  EXPECT_EQ(imu.stamps_ns.front(), 100'121'602'000);
  EXPECT_EQ(imu.stamps_ns.back(), 125'041'630'000);
  EXPECT_EQ(field(*recording, "IMU[0]", "GyrX").unit_from, "UNIT of the log");
  EXPECT_EQ(field(*recording, "IMU[0]", "AccX").unit, "m/s^2");
  expect_statistics(imu, {0.00161491198, 0.00162023105, 0.00161121496, -0.00100635212, -0.0010022076, -9.81747622},
                    {0.000113377, 0.00011021, 0.000114405, 0.000616882, 0.000617299, 0.000584013});
  expect_statistics(read(*recording, "IMU[1]", kAxes),
                    {0.00159071171, 0.00159788655, 0.00160972857, -0.00103115327, -0.00103353116, -9.81745948},
                    {0.00017576, 0.00017038, 0.000177086, 0.00135027, 0.00142748, 0.00133217});
}

TEST_F(Dataflash, RealCopterOfThreeSensors) {
  const std::string path = real("ardupilot/copter_33_cut.bin");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  EXPECT_EQ(messages(*recording), 45976);
  expect_note(recording->notes(), "ends inside a message: 16 bytes");
  const log::Rows imu = read(*recording, "IMU", kAxes);
  EXPECT_EQ(imu.clock, "TimeMS");
  EXPECT_EQ(imu.stamps_ns.size(), 5925U);
  EXPECT_EQ(imu.stamps_ns.front(), 11'460'000'000);
  EXPECT_EQ(imu.stamps_ns.back(), 133'239'000'000);
  expect_statistics(imu, {-0.00476575107, -0.000283679877, -0.000886521017, 0.0937970825, -0.402514288, -9.69113764},
                    {0.218746, 0.322, 0.209252, 0.651138, 0.266527, 0.679749});
  expect_statistics(read(*recording, "IMU3", kAxes),
                    {-0.00509666795, 0.00237233027, 9.33161628e-05, 0.162954471, -0.183721706, -9.17252046},
                    {0.142842, 0.317381, 0.208661, 0.604588, 0.210571, 0.754669});
}

}  // namespace
}  // namespace gyrobudget::app_tests

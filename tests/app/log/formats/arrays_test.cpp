// SPDX-License-Identifier: MIT
// What NumPy saves, written byte by byte, and what is refused with advice.
#include <gtest/gtest.h>

#include "../../packing.h"
#include "recorded.h"

namespace gyrobudget::app_tests {
namespace {

using U16 = std::uint16_t;
using U32 = std::uint32_t;
using U64 = std::uint64_t;
using Arrays = RecordingTest;

std::string npy(const std::string& descr, const std::string& shape, const std::string& body, bool fortran = false) {
  std::string header =
      "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape + ", }";
  header.resize((10 + header.size() + 64) / 64 * 64 - 11, ' ');
  header += '\n';
  return "\x93NUMPY" + std::string("\x01\0", 2) + packed(static_cast<U16>(header.size())) + header + body;
}

template <class Number>
std::string row(std::initializer_list<Number> values) {
  std::string bytes;
  for (const Number v : values) bytes += packed(v);
  return bytes;
}

U32 checksum(const std::string& text) {
  return static_cast<U32>(::crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size())));
}

/// An archive with its directory.
class Zip {
 public:
  Zip& add(const std::string& name, const std::string& content, bool deflate = true, bool zip64 = false) {
    const std::string data = deflate ? deflated(content, -15) : content;
    const U16 method = deflate ? 8 : 0;
    const std::string extra = zip64 ? packed(U16{1}, U16{16}) + packed(U64{content.size()}, U64{data.size()}) : "";
    const U32 packed_size = zip64 ? 0xffffffff : static_cast<U32>(data.size());
    const U32 size = zip64 ? 0xffffffff : static_cast<U32>(content.size());
    const std::string common = packed(U16{20}, U16{0}) + packed(method) +
                               packed(U32{0}, checksum(content), packed_size, size) +
                               packed(static_cast<U16>(name.size()), static_cast<U16>(extra.size()));
    directory_ += "PK\x01\x02" + packed(U16{20}) + common + packed(U16{0}, U16{0}, U16{0}) +
                  packed(U32{0}, static_cast<U32>(bytes_.size())) + name + extra;
    bytes_ += "PK\x03\x04" + common + name + extra + data;
    ++count_;
    return *this;
  }
  [[nodiscard]] std::string bytes(bool zip64 = false) const {
    std::string end;
    const U32 at = static_cast<U32>(bytes_.size());
    if (zip64) {
      end = "PK\x06\x06" + packed(U64{44}) + packed(U16{45}, U16{45}) + packed(U32{0}, U32{0}) +
            packed(U64{count_}, U64{count_}, U64{directory_.size()}, U64{at});
      end += "PK\x06\x07" + packed(U32{0}) + packed(U64{at + directory_.size()}) + packed(U32{1});
    }
    return bytes_ + directory_ + end + "PK\x05\x06" + packed(U16{0}, U16{0}, count_, count_) +
           packed(static_cast<U32>(directory_.size()), zip64 ? U32{0xffffffff} : at) + packed(U16{0});
  }
  [[nodiscard]] std::string without_directory() const { return bytes_; }

 private:
  std::string bytes_, directory_;
  U16 count_ = 0;
};

const std::string kGyro = row<double>({1, 11, 21, 2, 12, 22, 3, 13, 23, 4, 14, 24});
const std::string kTime = row<float>({0, .5F, 1, 1.5F});

TEST_F(Arrays, AnArchiveStoredDeflatedAndOf64Bits) {
  for (const bool deflate : {false, true}) {
    for (const bool zip64 : {false, true}) {
      const std::string bytes = Zip()
                                    .add("t.npy", npy("<f4", "(4,)", kTime), deflate, zip64)
                                    .add("gyro.npy", npy("<f8", "(4, 3)", kGyro), deflate, zip64)
                                    .bytes(zip64);
      const auto recording = open(bytes);
      EXPECT_EQ(recording->format(), "NumPy npz");
      ASSERT_EQ(recording->streams().size(), 1U);
      EXPECT_EQ(recording->streams()[0].name, "arrays");
      EXPECT_TRUE(recording->notes().empty());
      const log::Rows rows = read(*recording, "arrays", {"gyro[2]", "t", "gyro[0]"});
      EXPECT_THAT(rows.columns[0], testing::ElementsAre(21, 22, 23, 24));
      EXPECT_THAT(rows.columns[1], testing::ElementsAre(0, .5, 1, 1.5));
      EXPECT_THAT(rows.columns[2], testing::ElementsAre(1, 2, 3, 4));
    }
  }
}

TEST_F(Arrays, EveryTypeAndOrder) {
  const std::string big_double = "\x3f\xf8" + std::string(6, '\0') + "\xc0" + std::string(7, '\0');  // 1.5 and -2
  struct Case {
    std::string descr, body;
    double first, second;
  };
  const std::vector<Case> cases{{"|i1", row<std::int8_t>({-1, 2}), -1, 2},
                                {"|u1", row<std::uint8_t>({255, 2}), 255, 2},
                                {"|b1", row<std::uint8_t>({1, 0}), 1, 0},
                                {"<i2", row<std::int16_t>({-300, 2}), -300, 2},
                                {">i2", std::string("\xff\xfe\x01\x02", 4), -2, 258},
                                {"<u4", row<U32>({4'000'000'000, 2}), 4e9, 2},
                                {"<i8", row<std::int64_t>({-5, 2}), -5, 2},
                                {"<f2", std::string("\x00\x3e\x00\xc0", 4), 1.5, -2},
                                {"<f4", row<float>({1.5F, -2}), 1.5, -2},
                                {">f4", std::string("\x3f\xc0\0\0\xc0\0\0\0", 8), 1.5, -2},
                                {">f8", big_double, 1.5, -2}};
  for (const Case& c : cases) {
    const auto recording = open(Zip().add("x.npy", npy(c.descr, "(2,)", c.body)).bytes());
    EXPECT_THAT(read(*recording, "x", {"x"}).columns[0], testing::ElementsAre(c.first, c.second)) << c.descr;
  }
  const std::string by_columns = row<double>({1, 2, 3, 4, 11, 12, 13, 14, 21, 22, 23, 24});
  for (const bool fortran : {false, true}) {
    // 4 x 3 in either order; and 3 x 4, whose longer dimension is the samples.
    const auto tall = open(Zip().add("x.npy", npy("<f8", "(4, 3)", fortran ? by_columns : kGyro, fortran)).bytes());
    EXPECT_THAT(read(*tall, "x", {"x[1]"}).columns[0], testing::ElementsAre(11, 12, 13, 14)) << fortran;
    const auto flat = open(Zip().add("x.npy", npy("<f8", "(3, 4)", fortran ? kGyro : by_columns, fortran)).bytes());
    EXPECT_THAT(read(*flat, "x", {"x[1]"}).columns[0], testing::ElementsAre(11, 12, 13, 14)) << fortran;
    expect_note(flat->notes(), "3 x 4 is taken as 4 rows of 3: x");
  }
}

TEST_F(Arrays, LengthsAndWhatIsNoArray) {
  const std::string bytes =
      Zip()
          .add("t.npy", npy("<f4", "(4,)", kTime))
          .add("w.npy", npy("<f8", "(4, 3)", kGyro))
          .add("a.npy", npy("<f4", "(2,)", row<float>({1, 2})))
          .add("b.npy", npy("<f4", "(2, 1, 1)", row<float>({3, 4})))
          .add("rate.npy", npy("<f8", "()", row<double>({100})))
          .add("o.npy", npy("|O", "(2,)", "pickle"))
          .add("s.npy", npy("<U3", "(2,)", std::string(24, 'x')))
          .add("z.npy", npy("<c16", "(2,)", std::string(32, 'x')))
          .add("cube.npy", npy("<f4", "(2, 2, 2)", std::string(32, 'x')))
          .add("records.npy", "\x93NUMPY" + std::string("\x01\0\x20\0", 4) + padded("{'descr': [('a','<f8')], ", 32))
          .add("short.npy", npy("<f8", "(1000000000,)", "x"))
          .add("readme.txt", "x")
          .bytes();
  const auto recording = open(bytes);
  ASSERT_EQ(recording->streams().size(), 2U);
  EXPECT_EQ(recording->streams()[0].name, "arrays");
  EXPECT_EQ(recording->streams()[0].fields.size(), 4U);
  EXPECT_THAT(read(*recording, "arrays (2 rows)", {"b"}).columns[0], testing::ElementsAre(3, 4));
  const auto& notes = recording->notes();
  expect_note(notes, "rate = 100");
  expect_note(notes, "left out, Python objects: o");
  expect_note(notes, "left out, no real numbers: s and z");
  expect_note(notes, "left out, empty, of more than two dimensions, or wide: cube");
  expect_note(notes, "left out, records of several fields, or damaged: records");
  expect_note(notes, "left out, cut: short");
  expect_note(notes, "left out, no arrays: readme.txt");
}

TEST_F(Arrays, AnArchiveWithoutItsEndGivesWholeArrays) {
  const Zip zip =
      Zip().add("t.npy", npy("<f4", "(4,)", kTime), false, true).add("gyro.npy", npy("<f8", "(4, 3)", kGyro));
  const auto recording = open(zip.without_directory());
  EXPECT_EQ(info(*recording, "arrays").fields.size(), 4U);
  expect_note(recording->notes(), "the archive has no end: 2 arrays were found whole");
  const auto cut = open(zip.without_directory().substr(0, zip.without_directory().size() - 4));
  EXPECT_EQ(info(*cut, "t").count, 4);
  cut_everywhere(zip.bytes());
}

TEST_F(Arrays, DamagedDataAreAnErrorWhenTheyAreRead) {
  std::string body;
  for (int i = 0; i < 1000; ++i) body += packed(std::sin(i * i));
  for (const bool deflate : {false, true}) {
    std::string bytes = Zip().add("t.npy", npy("<f8", "(1000,)", body), deflate).bytes();
    bytes[bytes.size() / 2] ^= 0x20;
    EXPECT_CONTAINS(refusal(bytes), "the data of t stop in the middle or are damaged");
  }
}

TEST_F(Arrays, DirectoriesOfStrangers) {
  const std::string whole = Zip().add("t.npy", npy("<f4", "(4,)", kTime), false).bytes();
  for (std::size_t at = whole.size() - 22 - 46 - 5; at < whole.size(); ++at) {  // each byte of the directory
    for (const char value : {'\0', '\x7f', '\xff'}) {
      std::string bytes = whole;
      bytes[at] = value;
      try {
        read_all(*open(bytes));
      } catch (const text::InputError& error) {
        EXPECT_FALSE(std::string(error.what()).empty());
      }
    }
  }
}

TEST_F(Arrays, OneArrayThatReadLogRefuses) {
  const auto fortran =
      open(npy("<f8", "(4, 3)", row<double>({1, 2, 3, 4, 11, 12, 13, 14, 21, 22, 23, 24}), true), "log.npy");
  EXPECT_EQ(fortran->format(), "NumPy array");
  EXPECT_THAT(read(*fortran, "array", {"array[1]"}).columns[0], testing::ElementsAre(11, 12, 13, 14));
  EXPECT_THAT(read(*open(npy("<i2", "(3,)", row<std::int16_t>({5, 6, 7}))), "array", {"array"}).columns[0],
              testing::ElementsAre(5, 6, 7));
  EXPECT_CONTAINS(refusal(npy("<i2", "(30,)", row<std::int16_t>({5, 6, 7}))), "an array that is cut");
  // What read_log reads stays its own.
  EXPECT_EQ(log::open_recording(file("plain.npy", npy("<f8", "(4, 3)", kGyro))), nullptr);
  EXPECT_EQ(log::recorded_format(npy("<f8", "(4, 3)", kGyro)), "");
  EXPECT_EQ(log::recorded_format(npy(">f8", "(4, 3)", kGyro)), "NumPy array");
}

TEST_F(Arrays, MemoryIsThatOfTheNumbers) {
  constexpr int kRows = 5'000'000;
  for (const bool deflate : {false, true}) {
    std::string path;
    {
      const std::string shape = "(" + std::to_string(kRows) + ", 1)";
      const std::string body(8 * kRows, 'x');
      path = file("log.npz",
                  Zip().add("a.npy", npy("<f8", shape, body), deflate).add("b.npy", npy(">f8", shape, body)).bytes());
    }
    expect_little_memory(path, "arrays");
  }
}

TEST_F(Arrays, RealNumPy) {
  const std::vector<double> means{0.301787157, 0.263545729, -0.105215530, -0.518938411, 1.81944909, 2.38339583};
  const std::vector<double> deviations{2.89680, 6.66490, 1.66369, 6.68042, 5.34805, 7.59485};
  const std::string npz = real("mat/imu.npz"), one = real("mat/imu_fortran.npy");
  SKIP_WITHOUT(npz);
  const auto recording = log::open_recording(npz);
  expect_statistics(read(*recording, "arrays", {"gyro[0]", "gyro[1]", "gyro[2]", "accel[0]", "accel[1]", "accel[2]"}),
                    means, deviations);
  expect_statistics(read(*log::open_recording(one), "array",
                         {"array[1]", "array[2]", "array[3]", "array[4]", "array[5]", "array[6]"}),
                    means, deviations);
  cut_everywhere(content(npz));
}

// --- What is no log of ours -----------------------------------------------------------------------------------------

TEST_F(Arrays, OtherToolsAreNamed) {
  const std::string blackbox = "H Product:Blackbox flight data recorder by Nicholas Sherlock\nH Data version:2\n";
  EXPECT_EQ(log::recorded_format(blackbox), "Betaflight blackbox");
  EXPECT_CONTAINS(refusal(blackbox), "blackbox_decode");
  const std::string stamp("\x00\x05\xf0\x00\x00\x00\x00\x00", 8);
  const std::string tlog = stamp + "\xfe\x09" + std::string(15, 'x') + stamp + "\xfd\x02" + std::string(30, '\0');
  EXPECT_EQ(log::recorded_format(stamp + "\xfe\x09" + std::string(60, 'x')), "");  // no message follows
  EXPECT_EQ(log::recorded_format(tlog), "MAVLink telemetry");
  EXPECT_CONTAINS(refusal(tlog), "mavlogdump.py");
  const std::string zip = Zip().add("Gyroscope.csv", "t,x\n").bytes();
  EXPECT_EQ(log::recorded_format(zip), "zip archive");
  EXPECT_CONTAINS(refusal(zip), "unpack it");
  for (const std::string& other :
       {std::string("time,gyro\n1,2\n"), std::string(600, '\0'), std::string("FMT,1"), std::string("PK")}) {
    EXPECT_EQ(log::recorded_format(other), "");
    EXPECT_EQ(log::open_recording(file("log", other)), nullptr);
  }
  EXPECT_EQ(log::open_recording(path("nothing")), nullptr);
}

}  // namespace
}  // namespace gyrobudget::app_tests

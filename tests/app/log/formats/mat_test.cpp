// SPDX-License-Identifier: MIT
// MAT-files of versions 5 to 7, written element by element.
#include <gtest/gtest.h>

#include "../../packing.h"
#include "recorded.h"

namespace gyrobudget::app_tests {
namespace {

using U32 = std::uint32_t;
using Mat = RecordingTest;

/// Numbers of the file's byte order.
template <class Number>
std::string number(Number value, bool big) {
  std::string bytes = packed(value);
  if (big) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

/// Builds elements and variables.
struct MatFile {
  bool big = false;

  [[nodiscard]] std::string head() const {
    return "MATLAB 5.0 MAT-file, written by a test" + std::string(116 - 38, ' ') + std::string(8, '\0') +
           (big ? std::string("\x01\0MI", 4) : std::string("\0\x01IM", 4));
  }
  [[nodiscard]] std::string element(U32 type, const std::string& data) const {
    if (!data.empty() && data.size() <= 4) {  // the small form
      const U32 word = static_cast<U32>(data.size()) << 16 | type;
      return number(word, big) + padded(data, 4);
    }
    const std::size_t whole = type == 15 ? data.size() : (data.size() + 7) / 8 * 8;
    return number(type, big) + number(static_cast<U32>(data.size()), big) + padded(data, whole);
  }
  template <class Number>
  [[nodiscard]] std::string numbers(U32 type, const std::vector<Number>& values) const {
    std::string data;
    for (const Number v : values) data += number(v, big);
    return element(type, data);
  }
  [[nodiscard]] std::string array(U32 class_and_flags, const std::vector<std::int32_t>& dimensions,
                                  const std::string& name, const std::string& data) const {
    return element(14, numbers<U32>(6, {class_and_flags, 0}) + numbers(5, dimensions) + element(1, name) + data);
  }
  [[nodiscard]] std::string doubles(const std::vector<std::int32_t>& dimensions, const std::string& name,
                                    const std::vector<double>& values) const {
    return array(6, dimensions, name, numbers(9, values));
  }
  /// @param fields  matrices without names
  [[nodiscard]] std::string structure(const std::string& name, const std::vector<std::string>& names,
                                      const std::string& fields,
                                      const std::vector<std::int32_t>& dimensions = {1, 1}) const {
    std::string table;
    for (const std::string& n : names) table += padded(n, 8);
    return array(2, dimensions, name, numbers<std::int32_t>(5, {8}) + element(1, table) + fields);
  }
  [[nodiscard]] std::string opaque(const std::string& name, const std::string& class_name) const {
    return element(14, numbers<U32>(6, {17, 0}) + element(1, name) + element(1, "MCOS") + element(1, class_name) +
                           array(13, {6, 1}, "", numbers<U32>(6, {1, 2, 3, 4, 5, 6})));
  }
  [[nodiscard]] std::string compressed(const std::string& variable) const {
    return element(15, deflated(variable, 15));
  }
};

/// The struct that NaveGo has, of four samples.
std::string imu(const MatFile& m) {
  return m.structure("imu", {"t", "wb", "freq"},
                     m.doubles({4, 1}, "", {0, 1, 2, 3}) +
                         m.doubles({4, 3}, "", {1, 2, 3, 4, 11, 12, 13, 14, 21, 22, 23, 24}) +
                         m.doubles({1, 1}, "", {66.894}));
}

TEST_F(Mat, StructsOfEitherByteOrderAndPacking) {
  for (const bool big : {false, true}) {
    for (const bool packs : {false, true}) {
      const MatFile m{big};
      const auto recording = open(m.head() + (packs ? m.compressed(imu(m)) : imu(m)));
      EXPECT_EQ(recording->format(), "MATLAB 5 to 7");
      ASSERT_EQ(recording->streams().size(), 1U);
      EXPECT_EQ(recording->streams()[0].name, "imu");
      EXPECT_EQ(recording->streams()[0].clock, "");
      const log::Rows rows = read(*recording, "imu", {"wb[2]", "t", "wb[0]", "wb[2]"});
      EXPECT_TRUE(rows.stamps_ns.empty());
      EXPECT_THAT(rows.columns[0], testing::ElementsAre(21, 22, 23, 24));
      EXPECT_THAT(rows.columns[1], testing::ElementsAre(0, 1, 2, 3));
      EXPECT_THAT(rows.columns[2], testing::ElementsAre(1, 2, 3, 4));
      EXPECT_EQ(rows.columns[3], rows.columns[0]);
      expect_note(recording->notes(), "imu.freq = 66.894");
    }
  }
}

TEST_F(Mat, ArraysOfTheTopLevelOfEveryType) {
  const MatFile m;
  const std::string file =
      m.head() +
      m.array(6, {5, 1}, "a", m.numbers<std::int8_t>(1, {-1, 2, 3, 4, 5})) +  // stored smaller than its class
      m.array(7, {1, 5}, "b", m.numbers<float>(7, {1.5F, 2, 3, 4, 5})) +
      m.array(12, {5, 1}, "c", m.numbers<std::int32_t>(5, {-7, 2, 3, 4, 5})) +
      m.array(15, {5, 1}, "d", m.numbers<std::uint64_t>(13, {(1ULL << 53) + 3, 2, 3, 4, 5})) +
      m.array(8, {3, 1}, "e", m.numbers<std::int8_t>(1, {1, 2, 3})) +  // all of it in a tag
      m.array(6, {2, 5}, "f", m.numbers<std::uint16_t>(4, {1, 10, 2, 20, 3, 30, 4, 40, 5, 50})) +
      m.array(0x209, {5, 1}, "g", m.numbers<std::uint8_t>(2, {1, 0, 1, 0, 1}));  // logical
  const auto recording = open(file);
  const log::Rows rows = read(*recording, "arrays", {"a", "b", "c", "d", "f[0]", "f[1]", "g"});
  EXPECT_THAT(rows.columns[0], testing::ElementsAre(-1, 2, 3, 4, 5));
  EXPECT_THAT(rows.columns[1], testing::ElementsAre(1.5, 2, 3, 4, 5));
  EXPECT_EQ(rows.columns[2][0], -7);
  EXPECT_EQ(rows.columns[3][0], 9007199254740996.);
  expect_note(rows.notes, "d: whole numbers beyond 2^53 are rounded");
  EXPECT_THAT(rows.columns[4], testing::ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(rows.columns[5], testing::ElementsAre(10, 20, 30, 40, 50));
  EXPECT_EQ(rows.columns[6][1], 0);
  EXPECT_THAT(read(*recording, "e", {"e"}).columns[0], testing::ElementsAre(1, 2, 3));
  expect_note(recording->notes(), "2 x 5 is taken as 5 rows of 2: f");
}

TEST_F(Mat, WhatIsNoMatrixOfRealNumbersIsSaid) {
  const MatFile m;
  const std::string file =
      m.head() + m.opaque("TT", "timetable") + m.opaque("when", "datetime") + m.opaque("odd", "Stranger") +
      m.array(6 | 0x800, {2, 1}, "z", m.numbers<double>(9, {1, 2}) + m.numbers<double>(9, {3, 4})) +
      m.array(1, {1, 1}, "c", m.doubles({1, 1}, "", {1})) + m.array(4, {1, 2}, "s", m.element(2, "hi")) +
      m.array(5, {2, 2}, "sp", m.numbers<std::int32_t>(5, {0, 1})) +
      m.doubles({2, 2, 2}, "cube", {1, 2, 3, 4, 5, 6, 7, 8}) + m.doubles({0, 3}, "none", {}) +
      m.structure("many", {"a"}, "", {2, 1}) + m.array(16, {1, 1}, "f", "") + imu(m);
  const auto recording = open(file);
  EXPECT_EQ(recording->streams().size(), 1U);  // and is found behind all of that
  const auto& notes = recording->notes();
  expect_note(notes,
              "TT: of MATLAB's class timetable, which only MATLAB can read; export it there: S.t = seconds(x.Time");
  expect_note(notes, "when: of MATLAB's class datetime");
  expect_note(notes, "odd: of MATLAB's class Stranger");
  expect_note(notes, "left out, complex: z");
  expect_note(notes, "left out, cells: c");
  expect_note(notes, "left out, text: s");
  expect_note(notes, "left out, sparse matrices: sp");
  expect_note(notes, "left out, of more than two dimensions: cube");
  expect_note(notes, "left out, empty or wide: none");
  expect_note(notes, "left out, arrays of structs: many");
  expect_note(notes, "left out, functions: f");
}

TEST_F(Mat, StructsInStructsAndNoDeeper) {
  const MatFile m;
  std::string inner = m.structure("", {"x"}, m.doubles({3, 1}, "", {1, 2, 3}));
  for (int i = 0; i < 3; ++i) inner = m.structure("", {"s"}, inner);
  EXPECT_EQ(open(m.head() + m.structure("top", {"s"}, inner))->streams().at(0).name, "top.s.s.s.s");
  for (int i = 0; i < 300; ++i) inner = m.structure("", {"s"}, inner);
  expect_note(open(m.head() + m.structure("top", {"s"}, inner))->notes(),
              "left out, structs too deep: top.s.s.s.s.s.s.s.s");
}

TEST_F(Mat, LengthsOfStrangers) {
  const MatFile m;
  const std::string good = m.doubles({2, 1}, "good", {1, 2});
  const std::vector<std::string> bad{
      m.doubles({1 << 30, 1 << 10}, "x", {1, 2}),  // more than there is
      m.doubles({-1, 1}, "x", {1, 2}),
      m.array(6, {2, 1}, "x", m.element(99, "12345678")),  // of no type
      m.array(6, {2, 1}, "x", number(U32{9}, false) + number(U32{0xfffffff0}, false)),
      m.element(14, "short"),
      m.compressed(m.doubles({1 << 28, 1}, "x", {1, 2})),
      m.element(15, "no zlib data"),
      m.compressed(m.doubles({2, 1}, "x", {1, 2}).substr(0, 40)),
      m.array(2, {1, 1}, "x", m.numbers<std::int32_t>(5, {0}) + m.element(1, "abc")),
  };
  for (const std::string& variable : bad) {
    const auto recording = open(m.head() + variable + good);
    ASSERT_EQ(recording->streams().size(), 1U);
    EXPECT_EQ(recording->streams()[0].name, "good");
    EXPECT_FALSE(recording->notes().empty());
  }
}

TEST_F(Mat, DamagedDataAreAnErrorWhenTheyAreRead) {
  const MatFile m;
  std::vector<double> values(20000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = std::sin(static_cast<double>(i * i));
  std::string bytes = m.head() + m.compressed(m.doubles({20000, 1}, "x", values));
  bytes[bytes.size() / 2] ^= 0x55;
  EXPECT_CONTAINS(refusal(bytes), "the data of x are damaged");
}

TEST_F(Mat, CutEverywhere) {
  const MatFile m;
  std::string bytes = m.head();
  for (int i = 0; i < 9; ++i)
    bytes += m.compressed(m.doubles({40 + i, 1}, "v" + std::to_string(i), std::vector<double>(40 + i, i)));
  cut_everywhere(bytes + imu(m));
  expect_note(open((bytes + imu(m)).substr(0, bytes.size() + 30))->notes(),
              "ends inside a variable that begins at byte " + std::to_string(bytes.size()));
}

TEST_F(Mat, MemoryIsThatOfTheNumbers) {
  constexpr int kRows = 1'000'000;
  for (const bool packs : {false, true}) {
    const MatFile m;
    std::string path;
    {
      std::vector<double> values(3 * kRows);
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i % 1000);
      const std::string variable = m.doubles({kRows, 3}, "w", values);
      path = file("log.mat", m.head() + (packs ? m.compressed(variable) : variable));
    }
    expect_little_memory(path, "w");
  }
}

// --- Real ones ------------------------------------------------------------------------------------------------------

const std::vector<std::string> kImu{"wb[0]", "wb[1]", "wb[2]", "fb[0]", "fb[1]", "fb[2]"};
const std::vector<double> kMeans{0.301787157, 0.263545729, -0.105215530, -0.518938411, 1.81944909, 2.38339583};
const std::vector<double> kDeviations{2.89680, 6.66490, 1.66369, 6.68042, 5.34805, 7.59485};

TEST_F(Mat, RealStruct) {
  const std::string path = real("mat/imu_struct_v7.mat");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  const log::Rows rows = read(*recording, "imu", kImu);
  EXPECT_EQ(rows.columns[0].size(), 600U);
  EXPECT_NEAR(rows.columns[0][0], -0.150553619, 5e-10);
  EXPECT_NEAR(rows.columns[0][1], -0.01456970506, 5e-12);
  expect_statistics(rows, kMeans, kDeviations);
  cut_everywhere(content(path));
}

TEST_F(Mat, RealIncrements) {
  const std::string path = real("mat/imu_increments.mat");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  const log::Rows rows =
      read(*recording, "arrays", {"imu[0]", "imu[1]", "imu[2]", "imu[3]", "imu[4]", "imu[5]", "imu[6]", "thetak[1]"});
  EXPECT_EQ(rows.columns[6].front(), .01);
  EXPECT_EQ(rows.columns[6].back(), 23.02);
  EXPECT_EQ(rows.columns[6].size(), 2302U);
  EXPECT_THAT(rows.columns[7], testing::Each(0));
  constexpr double kTime = 11.515;  // middle of .01 to 23.02
  expect_statistics(
      rows, {2.20384988e-07, 1.14914054e-06, 7.94247568e-07, -6.15838939e-04, 3.83130246e-04, 9.76708884e-02, kTime, 0},
      {});
  EXPECT_NEAR(read(*recording, "imuerr (3 rows)", {"eb"}).columns[0][0], 4.848137e-05, 5e-12);
}

TEST_F(Mat, RealObjects) {
  const std::string path = real("mat/mcos_then_struct.mat");
  SKIP_WITHOUT(path);
  const auto recording = log::open_recording(path);
  EXPECT_EQ(info(*recording, "imu").count, 50);
  expect_note(recording->notes(), "of MATLAB's class timetable");
  expect_note(recording->notes(), "of MATLAB's class table,");
  const auto none = log::open_recording(real("mat/mcos_time_v7.mat"));
  EXPECT_TRUE(none->streams().empty());
  expect_note(none->notes(), "of MATLAB's class datetime");
}

TEST_F(Mat, RealOfEveryType) {
  for (const char* name : {"mat/types_le.mat", "mat/types_le_v6.mat"}) {
    const std::string path = real(name);
    SKIP_WITHOUT(path);
    const auto recording = log::open_recording(path);
    for (const char* field : {"d[0]", "s[0]", "i32[0]", "i16[0]", "i8[0]"})  // 5 x 10, whole numbers column by column
      EXPECT_THAT(read(*recording, "arrays", {field}).columns[0],
                  testing::ElementsAre(1, 6, 11, 16, 21, 26, 31, 36, 41, 46))
          << field;
    EXPECT_GT(read_all(*recording), 0);
  }
}

}  // namespace
}  // namespace gyrobudget::app_tests

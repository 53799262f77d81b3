// SPDX-License-Identifier: MIT
// Texts of known programs: columns, units and clocks that their headers, or only their form, tell.
#include "gyrobudget/app/log/dialects.h"

#include <fmt/format.h>

#include <numbers>

#include "text_writer.h"

namespace gyrobudget::app_tests {
namespace {

using allan::Record;

using Dialects = TextLog;

constexpr int kRows = 40;
constexpr double kRate = 100;  // [Hz]

/// Rows of what `row` says of each.
template <class Row>
std::string rows_of(Row row) {
  std::string all;
  for (int i = 0; i < kRows; ++i) all += row(i) + "\n";
  return all;
}

/// Axes 0 to 2 are gyroscopes and 3 to 5 accelerometers, all with the readings of the writer.
void expect_imu(const Record& record, double rate = kRate) {
  ASSERT_EQ(record.axes.size(), 6U);
  EXPECT_EQ(record.samples, kRows);
  constexpr double kPrinted = 1e-6;  // of stamps in whole units, relative
  EXPECT_NEAR(record.rate_hz, rate, kPrinted * rate);
  int gyros = 0, accelerometers = 0;
  for (const auto& axis : record.axes) {
    const bool turns = axis.signal == noise::Signal::angular_rate;
    const int column = turns ? gyros++ : 3 + accelerometers++;
    for (int i = 0; i < kRows; ++i) ASSERT_DOUBLE_EQ(axis.rate[static_cast<std::size_t>(i)], reading(i, column));
  }
  EXPECT_EQ(gyros, 3);
}

std::string readings(int i, const char* delimiter, int first, int count) {
  std::string text;
  for (int axis = first; axis < first + count; ++axis)
    text += (axis == first ? "" : delimiter) + number_text(reading(i, axis));
  return text;
}

TEST_F(Dialects, EurocHasItsUnitsInACommentAndNanoseconds) {
  expect_imu(read(
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n" +
      rows_of([](int i) {
        return fmt::format("{},{}", 1'709'629'801'123'456'000 + 10'000'000LL * i, readings(i, ",", 0, 6));
      })));
}

TEST_F(Dialects, SbgHasASecondHeaderRowOfUnits) {
  for (const bool dated : {true, false}) {
    expect_imu(read(
        "timestamp\tstatus\taccelX\taccelY\taccelZ\tgyroX\tgyroY\tgyroZ\ttemp\n"
        "(us)\t(na)\t(m.s^-2)\t(m.s^-2)\t(m.s^-2)\t(rad.s^-1)\t(rad.s^-1)\t(rad.s^-1)\t(degC)\n" +
            rows_of([&](int i) {
              const std::string stamp = dated ? fmt::format("2024-03-05T09:14:22.{:06}Z", 5000 + 10'000 * i)
                                              : std::to_string(81'005'000 + 10'000 * i);
              return fmt::format("{}\t0x1ff\t{}\t{}\t34.2", stamp, readings(i, "\t", 3, 3), readings(i, "\t", 0, 3));
            }),
        dated ? log::LogOptions{.time = log::TimeOf{"timestamp", "iso"}} : log::LogOptions{}));
  }
}

TEST_F(Dialects, XsensCountsTenthsOfMillisecondsBesideACounterThatWraps) {
  const std::string header =
      "PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\n" + rows_of([](int i) {
        return fmt::format("{:05}\t{}\t{}\t{}\t0.4121", (65'520 + i) % 65'536, 121'003'345 + 100 * i,
                           readings(i, "\t", 3, 3), readings(i, "\t", 0, 3));
      });
  const Record r = read("// Start Time: 1709629801\n// Update Rate: 100.0Hz\n" + header);
  expect_imu(r);
  EXPECT_CONTAINS(notes_of(r), "this is Xsens' MT Manager");
  // Other programs of the maker write the same names, in other units: nothing is guessed.
  EXPECT_CONTAINS(refusal(header), "has no unit");
}

std::string oxts(int i, double gravity) {
  return fmt::format(
      "-2.3731 -44.3964 41.2 0.0121 -0.0043 0.7712 1.21 0.87 1.49 0.02 -0.01 {} {} {} 0.33 0.11 9.78 {} 0.004 -0.006 0.031 0.07 0.03 4 9 4 4 {}",
      number_text(reading(i, 3)), number_text(reading(i, 4)), number_text(gravity), readings(i, " ", 0, 3), i % 5 - 1);
}

TEST_F(Dialects, KittisRowsAreKnownByTheirForm) {
  constexpr double kGravity = 9.75;
  const Record r = read(rows_of([](int i) { return oxts(i, kGravity); }), {.rate_hz = kRate});
  ASSERT_EQ(r.axes.size(), 6U);
  EXPECT_CONTAINS(notes_of(r), "by their form the rows are KITTI's oxts");
  for (const auto& axis : r.axes) {
    if (axis.name == "wy") {
      EXPECT_DOUBLE_EQ(axis.rate[7], reading(7, 1));
    }
    if (axis.name == "az") {
      EXPECT_DOUBLE_EQ(axis.rate[7], kGravity);
    }
  }
  // The same numbers without gravity are those of somebody else.
  EXPECT_CONTAINS(refusal(rows_of([](int i) { return oxts(i, 98.1); }), {.rate_hz = kRate}), "column 1 has no unit");
}

TEST_F(Dialects, KfGinsIncrementsAreReadAsTheDocumentationSays) {
  const Record r =
      read(rows_of([](int i) { return fmt::format("{:.3f}  {}", 302'400.005 + i / kRate, readings(i, "  ", 0, 6)); }),
           {.unit = "rad", .input = log::Input::increment, .columns = {"2", "3", "4"}, .time = log::TimeOf{"1", "s"}});
  ASSERT_EQ(r.axes.size(), 3U);
  EXPECT_NEAR(r.rate_hz, kRate, 1e-6 * kRate);
  EXPECT_NEAR(r.axes[1].rate[9], reading(9, 1) * kRate, 1e-6 * kRate);
}

}  // namespace
}  // namespace gyrobudget::app_tests

// SPDX-License-Identifier: MIT
// What inspect says of texts and arrays; recordings have theirs beside their readers.
#include "gyrobudget/app/log/inspect.h"

#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/text/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "../temporary.h"

namespace gyrobudget::log {
namespace {

using testing::Contains;
using testing::HasSubstr;

using Inspect = app_tests::TemporaryFolder;

// 10 rows at 100 Hz, of which the sixth and seventh are left out, and the last has no gyro.
std::string log_with_a_gap() {
  std::string text = "t (s),gyro_x (deg/s),acc_z (g),still (1)\n";
  for (int k = 0; k < 10; ++k)
    if (k != 5 && k != 6)
      text += fmt::format("{:.2f},{},{},7\n", 100 + 0.01 * k, k == 9 ? "" : std::to_string(k), k % 2);
  return text;
}

TEST_F(Inspect, ATextHasItsClockGapsAndColumns) {
  const Inspection log = inspect(file("log.csv", log_with_a_gap()));
  EXPECT_EQ(log.format, "text");
  ASSERT_EQ(log.streams.size(), 1U);
  const InspectedStream& s = log.streams[0];
  EXPECT_EQ(s.kind, StreamKind::imu);
  EXPECT_EQ(s.samples, 8);
  EXPECT_EQ(s.first_ns, 100'000'000'000);
  EXPECT_EQ(s.last_ns, 100'090'000'000);
  EXPECT_NEAR(s.rate_hz.value(), 100, 1e-9);
  EXPECT_NEAR(s.mean_rate_hz.value(), 7 / 0.09, 1e-9);
  EXPECT_EQ(s.gaps, 1);
  EXPECT_NEAR(s.largest_gap_s.value(), 0.03, 1e-12);
  ASSERT_EQ(s.columns.size(), 4U);
  EXPECT_EQ(s.columns[1].unit, "deg/s");
  EXPECT_EQ(s.columns[1].numbers, 7);
  EXPECT_NEAR(s.columns[1].mean.value(), (0 + 1 + 2 + 3 + 4 + 7 + 8) / 7., 1e-12);
  EXPECT_EQ(s.columns[1].most, 8);
  EXPECT_NEAR(s.columns[2].std.value(), std::sqrt(8 * 0.25 / 7), 1e-12);  // four of eight are 1
  EXPECT_THAT(s.odd, Contains(HasSubstr("1 gap, the longest of 0.03 s")));
  EXPECT_THAT(s.odd, Contains(HasSubstr("'gyro_x' lacks 1 number")));
  EXPECT_THAT(s.odd, Contains(HasSubstr("'still' is 7 throughout")));
  ASSERT_EQ(log.calibrate.size(), 1U);
  EXPECT_THAT(log.calibrate[0], testing::EndsWith("/log.csv"));
}

TEST_F(Inspect, ATextWithoutUnitsSaysWhatCalibrateNeeds) {
  const Inspection log = inspect(file("my log.csv", "gx,gy\n1,2\n3,4\n5,6\n"));
  EXPECT_EQ(log.streams[0].kind, StreamKind::other);
  EXPECT_THAT(log.streams[0].odd, Contains(HasSubstr("calibrate needs more")));
  EXPECT_THAT(log.calibrate[0], HasSubstr("my log.csv' --unit UNIT --rate HZ"));
}

TEST_F(Inspect, AnArrayHasItsColumns) {
  const std::vector<double> x{1, 2, 3}, y{4, 4, 4};
  const std::vector<LogColumn> columns{{.name = "x", .unit = "1", .values = x}, {.name = "y", .unit = "1", .values = y}};
  write_log(path("a.npy"), columns, 100, {}, Format::npy);
  const Inspection log = inspect(path("a.npy"));
  EXPECT_EQ(log.streams[0].samples, 3);
  EXPECT_EQ(log.streams[0].columns[0].mean, 2);
  EXPECT_THAT(log.streams[0].odd, Contains(HasSubstr("'column 2' is 4 throughout")));
}

TEST_F(Inspect, WhatCannotBeReadIsAnError) {
  EXPECT_THROW((void)inspect("no such file.csv"), text::InputError);
  EXPECT_THROW((void)inspect(file("empty.csv", "")), text::InputError);
}

}  // namespace
}  // namespace gyrobudget::log

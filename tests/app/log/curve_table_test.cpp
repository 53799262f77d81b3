// SPDX-License-Identifier: MIT
#include "gyrobudget/app/log/curve_table.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace gyrobudget::log {
namespace {

class CurveTables : public testing::Test {
 protected:
  allan::DeviationTable read(const std::string& text, std::optional<std::string> unit = {},
                             std::vector<std::string> columns = {}) {
    std::ofstream(path_) << text;
    return read_curve({path_.string(), std::move(unit), std::move(columns)});
  }
  std::string refusal(const std::string& text, std::optional<std::string> unit = {}) {
    try {
      (void)read(text, std::move(unit));
    } catch (const text::InputError& error) {
      return error.what();
    }
    return "";
  }
  void TearDown() override { std::filesystem::remove(path_); }
  std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("gyrobudget-curve-" + std::to_string(::getpid()) + ".csv");
};

constexpr double kDegPerHour = 3.14159265358979323846 / 180 / 3600;

TEST_F(CurveTables, UnitsComeFromTheHeader) {
  const allan::DeviationTable table =
      read("tau (ms),adev (deg/h),lower (deg/h),upper (deg/h),other (ug)\n10,2,1,3,5\n20,1,0.5,2,4\n");
  EXPECT_EQ(table.tau_s, (std::vector<double>{0.01, 0.02}));
  ASSERT_EQ(table.columns.size(), 2U);
  EXPECT_EQ(table.columns[0].name, "adev");
  EXPECT_DOUBLE_EQ(table.columns[0].deviation[1], kDegPerHour);
  EXPECT_EQ(table.columns[1].signal, noise::Signal::specific_force);
}

TEST_F(CurveTables, UnitFromTheOption) {
  const allan::DeviationTable table = read("tau_s,x,y\n1,2,3\n", "rad/s", {"y"});
  ASSERT_EQ(table.columns.size(), 1U);
  EXPECT_EQ(table.columns[0].name, "y");
  EXPECT_EQ(table.columns[0].deviation[0], 3);
}

TEST_F(CurveTables, BadTablesAreRefusedByPlace) {
  EXPECT_NE(refusal("time of day,adev (deg/h)\n1,2\n").find("averaging times"), std::string::npos);
  EXPECT_NE(refusal("tau (s),adev\n1,2\n").find("deviations"), std::string::npos);
  EXPECT_NE(refusal("tau (s),adev (deg/h)\n1,2\n1,3\n").find(":3: found a tau"), std::string::npos);
  EXPECT_NE(refusal("tau (s),adev (deg/h)\n1,2\n2,0\n").find(":3: found a deviation"), std::string::npos);
  EXPECT_NE(refusal("tau (s),adev (deg/h)\n1,2\n2,nan\n").find(":3"), std::string::npos);
}

}  // namespace
}  // namespace gyrobudget::log

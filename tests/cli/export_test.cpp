// SPDX-License-Identifier: MIT
// inspect and export on the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using testing::HasSubstr;

constexpr const char* kSensor =
    "name: s\ngyro:\n  arw: 0.15 deg/sqrt(h)\n  bias_instability: 0.7 deg/h\n  rrw: 4 deg/h/sqrt(h)\n";

TEST(InspectVerb, SaysWhatATextHolds) {
  const Scratch scratch;
  std::string rows = "time (s),gyro_x (deg/s)\n";
  for (int k = 0; k < 50; ++k) rows += std::to_string(k) + "," + std::to_string(k % 3) + "\n";
  const std::string log = scratch.file("log.csv", rows);
  const auto text = gyrobudget_run("inspect " + log);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("median rate 1 Hz"));
  EXPECT_THAT(text.out, HasSubstr("gyrobudget calibrate " + log));
  const auto object = parsed<nlohmann::json>(gyrobudget_run("inspect " + log + " --json").out);  // schema checked there
  EXPECT_EQ(object["streams"][0]["kind"], "gyroscope");
  EXPECT_EQ(object["streams"][0]["samples"], 50);
  const auto missing = gyrobudget_run("inspect " + scratch.path("none.bag"));
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_THAT(missing.err, HasSubstr("none.bag"));
}

TEST(InspectVerb, ATopicOfATextIsRefused) {
  const Scratch scratch;
  const auto run =
      gyrobudget_run("calibrate " + scratch.file("log.csv", "gx (deg/s)\n1\n2\n") + " --rate 1 --topic /imu");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("no recording with topics"));
}

TEST(ExportVerb, WritesTheFormOfATool) {
  const Scratch scratch;
  const std::string sensor = scratch.file("s.yaml", kSensor);
  const auto run = gyrobudget_run("export " + sensor + " --form vins --rate 200");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("\ngyr_n: 0.000617"));  // 0.15 deg/sqrt(h) sqrt(200 Hz)
  EXPECT_THAT(run.out, HasSubstr("acc_n [m/s^2 a sample] is not known"));
  const std::string to = scratch.path("imu.yaml");
  EXPECT_EQ(gyrobudget_run("export " + sensor + " --form kf_gins --rate 200 -o " + to).exit_code, 0);
  std::stringstream text;
  text << std::ifstream(to).rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("  arw: [0.15, 0.15, 0.15]"));
}

TEST(ExportVerb, RefusesWhatItDoesNotKnow) {
  const Scratch scratch;
  const std::string sensor = scratch.file("s.yaml", kSensor);
  const auto form = gyrobudget_run("export " + sensor + " --form vinz --rate 200");
  EXPECT_EQ(form.exit_code, 2);
  EXPECT_THAT(form.err, HasSubstr("did you mean 'vins'?"));
  EXPECT_EQ(gyrobudget_run("export " + sensor + " --form vins").exit_code, 2);
  EXPECT_EQ(gyrobudget_run("export " + scratch.path("none.yaml") + " --form vins --rate 200").exit_code, 3);
  // The sensor file itself is not overwritten.
  EXPECT_EQ(gyrobudget_run("export " + sensor + " --form vins --rate 200 -o " + sensor).exit_code, 2);
}

}  // namespace
}  // namespace gyrobudget::tests

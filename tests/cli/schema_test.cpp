// SPDX-License-Identifier: MIT
// Every JSON that a test of this folder gets is checked against its schema (program.h). Here are variants that no other
// test asks for, above all those that make parts null.
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using Json = nlohmann::json;

const std::string kSensors = GYROBUDGET_EXAMPLES "/sensors/";

Json json_of(const Outcome& run, int exit_code = 0) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  return parsed<Json>(run.out);
}

TEST(SchemaOfOutputs, IsCheckedInEveryRun) {
  EXPECT_NONFATAL_FAILURE((void)shell("echo '{\"schema\": \"gyrobudget.plan/1\", \"rate_hz\": 0}'"),
                          "/rate_hz: exclusiveMinimum is 0");
  EXPECT_NONFATAL_FAILURE((void)shell("echo '{\"schema\": \"gyrobudget.plan/2\"}'"), "no schema is published");
  (void)shell("echo '{\"schema\": \"of another program\"}'");  // no failure
}

TEST(SchemaOfOutputs, HoldsForEveryViewOfACurve) {
  const Scratch scratch;
  const std::string log = scratch.path("log.csv"), other = scratch.path("other.csv");
  for (const std::string& path : {log, other})
    ASSERT_EQ(gyrobudget_run("simulate " + kSensors + "ifog-imu.yaml --duration 30s --rate 20 -o " + path).exit_code,
              0);
  const Json views = json_of(gyrobudget_run("allan " + log + " --json --taus octave --psd multitaper --dynamic 5s " +
                                            "--estimator oadev,tdev,theo1"));
  ASSERT_EQ(views["axes"].size(), 18U);  // three gyros and three accelerometers
  EXPECT_TRUE(views["axes"][0].contains("psd") && views["axes"][0].contains("dynamic"));
  EXPECT_EQ(views["axes"][1]["unit"], "arcsec");
  EXPECT_EQ(views["axes"][10]["unit"], "m/s");
  EXPECT_EQ(json_of(gyrobudget_run("allan " + log + " " + other + " --json"))["record"]["segments"].size(), 2U);
}

TEST(SchemaOfOutputs, HoldsWhereARecordHasNoAnswer) {
  const Scratch scratch;
  std::string silent = "time (s),x (deg/s),f (m/s^2),u (1)\n", gaps = "time (s),x (deg/s)\n";
  for (int i = 0; i < 400; ++i) {
    silent += std::to_string(0.1 * i) + ",0,1,2\n";
    gaps += std::to_string(0.1 * i) + (i % 40 < 10 ? ",nan\n" : i % 3 == 0 ? ",1\n" : ",0\n");
  }
  for (const std::string method : {"gls", "whittle", "slope", "visual"}) {
    const Json axis = json_of(
        gyrobudget_run("calibrate --json --cross-check --method " + method + " " + scratch.file("silent.csv", silent)),
        1)["axes"][0];
    EXPECT_TRUE(axis["parameters"]["arw"]["value"].is_null()) << method;
    EXPECT_TRUE(axis["minimum"].is_null()) << method;
  }
  (void)gyrobudget_run("calibrate --json --cross-check --terms N,B,K,R,G,S " + scratch.file("gaps.csv", gaps));
  (void)gyrobudget_run("allan --json --dynamic 10s --taus all " + scratch.path("gaps.csv"));
  (void)gyrobudget_run("allan --json " + scratch.path("silent.csv"));
}

TEST(SchemaOfOutputs, HoldsWhereNoRecordWouldDo) {
  const Json plan = json_of(gyrobudget_run("plan " + kSensors + "mems.yaml --json --want B=1e-9% --duration 1s"));
  EXPECT_TRUE(plan["answers"][0]["duration_s"].is_null());
}

TEST(SchemaOfOutputs, HoldsForABudgetOfNothing) {
  const Scratch scratch;
  const Json budget =
      json_of(gyrobudget_run("budget --json --limit 'rss < 1 m' " + scratch.file("none.yaml", "trajectory: ascent\n")));
  EXPECT_EQ(budget["limit"]["allowed_factor"], Json::object());
}

TEST(SchemaOfOutputs, HoldsForAFlightThatCannotStart) {
  const Scratch scratch;
  (void)scratch.file("coarse.yaml", "gyro: {turn_on_bias: 1000 deg/h, quantization: 1 arcsec}\n");
  const Json flight = json_of(
      gyrobudget_run(
          "fly --json --runs 1 " +
          scratch.file("scene.yaml",
                       "site: alcantara\nsensor: coarse.yaml\nuntil: 2 s\nflight: {vehicle: " GYROBUDGET_EXAMPLES
                       "/vehicles/vlm1.yaml}\nalignment: {attitude: self, duration: 60 s}\n")),
      1);
  EXPECT_EQ(flight["ended"], "not_flown");
  EXPECT_TRUE(flight["trajectory"].is_null());
}

// The IMU at rest on the equator; fixes come after its end.
TEST(SchemaOfOutputs, HoldsForANavigationWithoutFixes) {
  const Scratch scratch;
  std::string log =
      "time (s),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (m/s^2),accel_y (m/s^2),accel_z (m/s^2)\n";
  for (int i = 0; i <= 20; ++i) log += std::to_string(0.1 * i) + ",7.292115e-5,0,0,0,0,-9.7803253359\n";
  (void)scratch.file("imu.csv", log);
  (void)scratch.file("sensor.yaml", "gyro: {arw: 0.1 deg/sqrt(h), quantization: 1 arcsec}\n");
  (void)scratch.file("gnss.csv", "time (s),latitude (deg),longitude (deg),height (m)\n90,0,0,0\n95,0,0,0\n");
  const Json found = json_of(gyrobudget_run(
      "navigate --json " +
      scratch.file(
          "scene.yaml",
          "site: {latitude: 0 deg, longitude: 0 deg, height: 0 m}\nimu: {file: imu.csv}\nsensor: sensor.yaml\n"
          "alignment: {position_sigma: 1 m, velocity_sigma: 1 cm/s, attitude: {heading: 0 deg}, level_sigma: 0.1 deg, heading_sigma: 1 deg}\n"
          "aids: {gnss: {file: gnss.csv, position: 1 m}}\nreference: gnss\n")));
  EXPECT_TRUE(found["nis"]["mean"].is_null());
  EXPECT_TRUE(found["nis"]["aids"][0]["residual_rms"].is_null());
  EXPECT_TRUE(found["reference"].is_null());
  EXPECT_FALSE(found["left_out"].empty());
}

}  // namespace
}  // namespace gyrobudget::tests

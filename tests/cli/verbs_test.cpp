// SPDX-License-Identifier: MIT
// The verbs as a person or a script uses them.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

const std::string kMems = GYROBUDGET_EXAMPLES "/sensors/mems.yaml";
const std::string kIfog = GYROBUDGET_EXAMPLES "/sensors/ifog.yaml";

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

nlohmann::json json_of(const Outcome& run, int exit_code = 0) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  return parsed<nlohmann::json>(run.out);
}

TEST(Verbs, HelpOpensWithTwoLinesToCopy) {
  for (const std::string verb : {"", "simulate ", "allan ", "calibrate ", "plan ", "paper ", "navigate "}) {
    const Outcome run = gyrobudget_run(verb + "--help");
    EXPECT_EQ(run.exit_code, 0);
    const std::string head = run.out.substr(0, run.out.find("Usage:"));
    std::size_t examples = 0;
    for (std::size_t at = 0; (at = head.find("\n  gyrobudget ", at)) != std::string::npos; ++at) ++examples;
    EXPECT_EQ(examples, 2U) << run.out;
  }
  EXPECT_NE(gyrobudget_run("--version").out.find("gyrobudget 0."), std::string::npos);
}

TEST(Verbs, SimulateGivesTheSameBytesAtAnyThreadCount) {
  const std::string line = "simulate " + kMems + " --duration 200s --rate 100 --seed 5 ";
  const Outcome one = gyrobudget_run(line + "--threads 1"), two = gyrobudget_run(line + "--threads 2");
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_GT(one.out.size(), 1000U);
  EXPECT_EQ(one.out, two.out);
  EXPECT_NE(one.out, gyrobudget_run("simulate " + kMems + " --duration 200s --rate 100 --seed 6").out);
  EXPECT_NE(one.out.find("seed 5"), std::string::npos);
}

TEST(Verbs, AxesDoNotDependOnWhichOthersAreSimulated) {
  const std::string line = "simulate " + kMems + " --duration 50s --axes ";
  const Outcome all = shell("%P " + line + "x,y,z | grep -v '#' | cut -d, -f3");
  const Outcome one = shell("%P " + line + "y | grep -v '#' | cut -d, -f2");
  EXPECT_EQ(all.out, one.out);
  EXPECT_GT(one.out.size(), 1000U);
}

TEST(Verbs, FromSensorToLogToSensor) {
  const Scratch scratch;
  const std::string log = scratch.path("log.csv"), sensor = scratch.path("sensor.yaml");
  ASSERT_EQ(gyrobudget_run("simulate " + kMems + " --duration 10h --rate 10 --axes x -o " + log).exit_code, 0);
  const Outcome run =
      gyrobudget_run("calibrate " + log + " --json -o " + sensor + " --kalibr " + scratch.path("imu.yaml") +
                     " --report " + scratch.path("page.html") + " --plot " + scratch.path("plot.svg"));
  const auto json = json_of(run);
  ASSERT_EQ(json["schema"], "gyrobudget.calibration/1");
  const auto& axis = json["axes"][0];
  const auto& arw = axis["parameters"]["arw"];
  // 5 standard deviations of ARW at 10 Hz and 10 h (0.13 %).
  EXPECT_NEAR(arw["value"].get<double>() / 0.15, 1, 5 * 0.0013);
  EXPECT_EQ(arw["unit"], "deg/sqrt(h)");
  EXPECT_EQ(arw["status"], "identified");
  EXPECT_LT(arw["lower"].get<double>(), arw["value"].get<double>());
  EXPECT_EQ(axis["parameters"]["rate_ramp"]["value"], nullptr);
  EXPECT_EQ(axis["parameters"]["rate_ramp"]["status"], "left_out");
  EXPECT_EQ(axis["fit"]["verdict"], "described");
  EXPECT_EQ(json["record"]["missing_samples"], 0);

  EXPECT_NE(read(sensor).find("arw:"), std::string::npos);
  EXPECT_NE(read(scratch.path("imu.yaml")).find("gyroscope_noise_density"), std::string::npos);
  EXPECT_NE(read(scratch.path("page.html")).find("</html>"), std::string::npos);
  EXPECT_NE(read(scratch.path("plot.svg")).find("<svg"), std::string::npos);
  EXPECT_EQ(scratch.files(), 5U);
  EXPECT_EQ(gyrobudget_run("plan " + sensor + " --duration 2h").exit_code,
            0);  // what calibrate writes, plan reads
}

TEST(Verbs, CalibrateGivesTheSameBytesAtAnyThreadCount) {
  const Scratch scratch;
  const std::string log = scratch.path("log.csv");
  ASSERT_EQ(gyrobudget_run("simulate " + kIfog + " --duration 2h --rate 10 -o " + log).exit_code, 0);
  const std::string filter = " | sed -E 's/\"seconds\": *[^,}]*//; s/--threads [12]//'";
  const Outcome one = shell("%P calibrate " + log + " --json --threads 1" + filter);
  const Outcome two = shell("%P calibrate " + log + " --json --threads 2" + filter);
  EXPECT_GT(one.out.size(), 1000U);
  EXPECT_EQ(one.out, two.out);
}

TEST(Verbs, AllanReadsStdinAndWritesJson) {
  const auto json =
      json_of(shell("%P simulate " + kMems + " --duration 100s --axes x,y | %P allan - --json --taus octave"));
  EXPECT_EQ(json["schema"], "gyrobudget.allan/1");
  EXPECT_EQ(json["record"]["samples"], 10000);
  EXPECT_EQ(json["record"]["rate_hz"], 100);
  ASSERT_EQ(json["axes"].size(), 2U);
  const auto& points = json["axes"][0]["points"];
  ASSERT_EQ(points.size(), 13U);  // 1 ... 4096
  EXPECT_EQ(points[3]["m"], 8);
  EXPECT_EQ(points[3]["terms"], 10000 - 2 * 8 + 1);
  EXPECT_DOUBLE_EQ(points[3]["tau_s"], 0.08);
  const double deviation = points[0]["deviation"];
  EXPECT_LT(points[0]["lower"].get<double>(), deviation);
  EXPECT_GT(points[0]["upper"].get<double>(), deviation);
  // 9 deg/h/sqrt(Hz) at 100 Hz: 90 deg/h; 5 sigma of 10000 samples.
  EXPECT_NEAR(deviation / 90, 1, 5 * 0.009);
}

TEST(Verbs, IeeeFormHasOneTermLess) {
  const auto json =
      json_of(shell("%P simulate " + kMems + " --duration 10s --axes x | %P allan - --json --taus octave --ieee"));
  EXPECT_EQ(json["axes"][0]["points"][3]["terms"], 1000 - 2 * 8);
}

TEST(Verbs, PlanKnowsThePapersGyros) {
  const auto ifog = json_of(gyrobudget_run("plan " + kIfog + " --want B=10% --json"));
  EXPECT_NEAR(ifog["answers"][0]["duration_s"].get<double>() / 3600, 293, 3);
  const auto mems = json_of(gyrobudget_run("plan " + kMems + " --want B=10% --want K=10% --json"));
  EXPECT_NEAR(mems["answers"][0]["duration_s"].get<double>() / 3600, 27.4, 0.3);
  EXPECT_NEAR(mems["answers"][1]["duration_s"].get<double>() / 3600, 15.8, 0.2);
  const auto buys = json_of(gyrobudget_run("plan " + kMems + " --duration 10h --json"));
  EXPECT_NEAR(buys["durations"][0]["relative_std"]["bias_instability"].get<double>(), 0.166, 0.002);
  EXPECT_NE(gyrobudget_run("plan " + kMems).out.find("lower bounds"), std::string::npos);
}

TEST(Verbs, OnePercentOfSamplesLostMovesNoCoefficientByAFifthOfItsSigma) {
  const Scratch scratch;
  const std::string whole = scratch.path("whole.csv"), holed = scratch.path("holed.csv");
  ASSERT_EQ(gyrobudget_run("simulate " + kMems + " --duration 36000s --rate 1 --axes x --seed 3 -o " + whole).exit_code,
            0);
  // A hash of the row number drops one row in a hundred.
  ASSERT_EQ(shell("awk 'NR < 4 || (NR * 2654435761) % 4294967296 > 42949672' " + whole + " > " + holed).exit_code, 0);
  const auto a = json_of(gyrobudget_run("calibrate --json " + whole)),
             b = json_of(gyrobudget_run("calibrate --json " + holed));
  EXPECT_NEAR(b["record"]["missing_samples"].get<double>(), 360, 100);
  for (const std::string key : {"arw", "bias_instability", "rrw"}) {
    const auto &x = a["axes"][0]["parameters"][key], &y = b["axes"][0]["parameters"][key];
    const double sigma = x["value"].get<double>() * x["relative_std"].get<double>();
    EXPECT_LT(std::abs(x["value"].get<double>() - y["value"].get<double>()), 0.2 * sigma) << key;
  }
}

// --- Real logs ------------------------------------------------------------------------------------------------------

class RealLogs : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(GYROBUDGET_DATA "/static")) {
      GTEST_SKIP() << "the public data sets are not at " GYROBUDGET_DATA;
    }
  }
};

TEST_F(RealLogs, ConsumerMemsComesOutUsable) {
  const auto json =
      json_of(gyrobudget_run("calibrate " GYROBUDGET_DATA "/static/mems_gyro_x.csv.gz --rate 1 --unit deg/s --json"));
  const auto& axis = json["axes"][0];
  EXPECT_NE(axis["fit"]["verdict"], "not_described");
  EXPECT_EQ(axis["parameters"]["arw"]["status"], "identified");
  EXPECT_EQ(axis["parameters"]["rrw"]["status"], "identified");
  EXPECT_GT(axis["fit"]["tau_min_s"].get<double>(), 1);  // the shortest taus are not white noise
  bool line = false;                                     // at 0.0503 cycles per sample
  for (const auto& advice : axis["advice"])
    line |= advice.get<std::string>().find("line at 0.050") != std::string::npos;
  EXPECT_TRUE(line) << axis["advice"];
}

TEST_F(RealLogs, RingLaserOnAVehicleWithPeopleIsNotDescribed) {
  const auto json = json_of(
      gyrobudget_run(
          "calibrate " GYROBUDGET_DATA
          "/static/rlg_vehicle_counts.csv.gz --rate 100 --input increment --unit arcsec --scale 0.1 --column gx gy gz --json"),
      1);
  ASSERT_EQ(json["axes"].size(), 3U);
  for (const auto& axis : json["axes"]) EXPECT_EQ(axis["fit"]["verdict"], "not_described") << axis["name"];
  // Earth's rate on the axes, from the data's own page.
  EXPECT_NEAR(json["axes"][0]["mean"].get<double>(), -12.2715, 1e-3);
}

TEST_F(RealLogs, WhitePhaseNoiseHasNoneOfTheThree) {
  const Outcome run = gyrobudget_run("calibrate " GYROBUDGET_DATA
                                     "/oscillator/tic_phase_s.csv.gz --rate 1 --input angle --unit s --json");
  const auto json = json_of(run, 1);
  for (const std::string key : {"arw", "bias_instability", "rrw"}) {
    EXPECT_NE(json["axes"][0]["parameters"][key]["status"], "identified") << key;
  }
}

}  // namespace
}  // namespace gyrobudget::tests

// SPDX-License-Identifier: MIT
// navigate: scenes on the command line, and recorded data against published results.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using nlohmann::json;

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegreePerHour = kPi / 180 / 3600;  // rad/s
constexpr double kMicroG = 9.80665e-6;               // m/s^2

const std::string kData = GYROBUDGET_DATA;
const std::string kExamples = GYROBUDGET_EXAMPLES;

json json_of(const Outcome& run, int exit_code = 0) {
  EXPECT_EQ(run.exit_code, exit_code) << run.err;
  return parsed<json>(run.out);
}

std::string read(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

double state(const json& run, const std::string& name, const std::string& what = "value") {
  for (const auto& s : run["states"])
    if (s["name"] == name) return s[what].get<double>();
  ADD_FAILURE() << "no state " << name;
  return NAN;
}

// 20 s at rest, nose to the north, in exact rates and a scene for them.
class Navigate : public testing::Test {
 protected:
  Navigate() {
    constexpr double kRate = 7.292115e-5, kGravity = 9.7803253359;  // at the equator, height 0
    std::ostringstream log;
    log.precision(17);
    log << "time (s),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (m/s^2),accel_y (m/s^2),accel_z (m/s^2)\n";
    for (int k = 0; k <= 200; ++k) log << 0.1 * k << ',' << kRate << ",0,0,0,0," << -kGravity << '\n';
    (void)scratch_.file("imu.csv", log.str());
    (void)scratch_.file("gnss.csv",
                        "time (s),latitude (deg),longitude (deg),height (m)\n5.05,0,0,0\n10.05,0,0,0\n15.05,0,0,0\n");
  }
  [[nodiscard]] Outcome run(const std::string& scene, const std::string& options = "") const {
    return gyrobudget_run("navigate " + scratch_.file("scene.yaml", scene) + " " + options);
  }
  Scratch scratch_;
  const std::string scene_ =
      "name: a desk on the equator\nsite: {latitude: 0 deg, longitude: 0 deg, height: 0 m}\nimu: {file: imu.csv}\n"
      "sensor: mems.yaml\n"
      "alignment: {position_sigma: 1 m, velocity_sigma: 1 cm/s, attitude: {heading: 0 deg}, level_sigma: 0.1 deg, heading_sigma: 1 deg}\n";
  const std::string sensor_ = scratch_.file(
      "mems.yaml", "name: desk MEMS\ngyro: {arw: 0.15 deg/sqrt(h)}\naccelerometer: {turn_on_bias: 1 mg}\n");
};

TEST_F(Navigate, GivesTheFieldsThatOthersRelyOn) {
  const json found = json_of(run(
      scene_ + "aids: {gnss: {file: gnss.csv, position: 1 m}}\nreference: gnss\nsolution: {rate: 20 Hz}\n", "--json"));
  EXPECT_EQ(found["schema"], "gyrobudget.navigation/1");
  EXPECT_EQ(found["status"], "navigated");
  EXPECT_EQ(found["sensor"], "desk MEMS");
  EXPECT_EQ(found["imu"]["samples"], 201);
  EXPECT_EQ(found["epochs"], 401);  // 0 to 20 s at 20 Hz
  EXPECT_NEAR(found["final"]["latitude_deg"].get<double>(), 0, 1e-6);
  EXPECT_NEAR(found["final"]["t_s"].get<double>(), 20, 1e-9);
  EXPECT_GT(found["sigma"]["position_m"]["east"].get<double>(), 0);
  EXPECT_EQ(found["nis"]["aids"][0]["used"], 3);
  EXPECT_LT(found["nis"]["mean"].get<double>(), 1e-3);  // exact fixes
  EXPECT_EQ(found["nis"]["inside_95"], 1);
  EXPECT_LT(found["reference"]["position_rms_m"].get<double>(), 1e-3);
  EXPECT_TRUE(found["reference"]["velocity_rms_m_s"].is_null());
  EXPECT_EQ(found["reference"]["nees_dof"], 3);
  EXPECT_EQ(found["states"].size(), 3U);
}

TEST_F(Navigate, TheSolutionIsATrajectoryAndInnovationsAreListed) {
  const std::string solution = scratch_.path("solution.csv"), innovations = scratch_.path("innovations.csv"),
                    page = scratch_.path("page.html");
  const Outcome text = run(scene_ + "aids: {gnss: {file: gnss.csv, position: 1 m}}\n",
                           "-o " + solution + " --innovations " + innovations + " --report " + page);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_NE(text.out.find("a desk on the equator"), std::string::npos);
  EXPECT_NE(text.err.find("report page: "), std::string::npos);
  EXPECT_EQ(read(solution).substr(0, 60), "time (s),latitude (deg),longitude (deg),height (m),velocity_");
  EXPECT_NE(read(innovations).find("gnss.position,used,"), std::string::npos);
  EXPECT_NE(read(page).find("Navigation: a desk on the equator"), std::string::npos);
  // The solution of one run is the reference of another, and they agree to the digits that are written.
  const json again = json_of(
      run(scene_ + "aids: {gnss: {file: gnss.csv, position: 1 m}}\nreference: {file: " + solution + "}\n", "--json"));
  EXPECT_LT(again["reference"]["position_rms_m"].get<double>(), 2e-6);
  EXPECT_LT(again["reference"]["attitude_rms_deg"].get<double>(), 1e-8);
  EXPECT_EQ(again["reference"]["nees_dof"], 9);
}

TEST_F(Navigate, ExitCodesSayWhatIsWrong) {
  EXPECT_EQ(gyrobudget_run("navigate").exit_code, 2);
  EXPECT_EQ(gyrobudget_run("navigate /nosuch.yaml").exit_code, 3);
  EXPECT_EQ(run(scene_ + "imuu: 3\n").exit_code, 3);
  EXPECT_EQ(run(scene_ + "aids: {gnss: {position: 1 m}}\n").exit_code, 3);  // no file
  EXPECT_EQ(run(scene_, "-o /nosuch/solution.csv").exit_code, 4);
  EXPECT_EQ(gyrobudget_run("navigate " + scratch_.file("planned.yaml", "trajectory: ascent\n")).exit_code, 3);
  // No output replaces what is read.
  const std::string log = read(scratch_.path("imu.csv"));
  for (const std::string input : {"imu.csv", "gnss.csv", "mems.yaml", "scene.yaml"}) {
    EXPECT_EQ(run(scene_ + "aids: {gnss: {file: gnss.csv, position: 1 m}}\n", "-o " + scratch_.path(input)).exit_code,
              2)
        << input;
  }
  EXPECT_EQ(read(scratch_.path("imu.csv")), log);
  // Ten degrees an hour at rest: no heading.
  const std::string self =
      "site: {latitude: 0 deg, longitude: 0 deg, height: 0 m}\nimu: {file: imu.csv}\nsensor: mems.yaml\n"
      "alignment: {position_sigma: 1 m, velocity_sigma: 1 cm/s, attitude: self, duration: 10 s}\n";
  const Outcome refused = run(self, "--json");
  EXPECT_EQ(json_of(refused, 1)["status"], "heading_not_observable");
  EXPECT_FALSE(refused.err.empty());
  EXPECT_TRUE(run(self, "--json -q").err.empty());
}

TEST_F(Navigate, OneSceneIsSimulatedAndNavigated) {
  const std::string scene = scratch_.file(
      "flight.yaml",
      "name: a minute without aids\ntrajectory: cruise:speed=100,duration=60,turn_acceleration=3\nsensor: imu.yaml\n"
      "imu: {file: flight.csv}\nreference: {file: truth.csv}\n"
      "alignment: {position: start, velocity: start, attitude: start, position_sigma: 1 cm, velocity_sigma: 1 mm/s, level_sigma: 0.001 deg, heading_sigma: 0.001 deg}\n"
      "aids: {start: {file: truth.csv, used: no, position: 1 m, velocity: 1 m/s, attitude: 1 deg}}\n");
  const std::string sensor = scratch_.file(
      "imu.yaml", "gyro: {arw: 0.1 deg/sqrt(h), turn_on_bias: 5 deg/h}\naccelerometer: {turn_on_bias: 1 mg}\n");
  const Outcome simulated = gyrobudget_run("simulate " + sensor + " -q --trajectory " + scene + " --truth " +
                                           scratch_.path("truth.csv") + " -o " + scratch_.path("flight.csv"));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const json found = json_of(gyrobudget_run("navigate " + scene + " --json"));
  EXPECT_EQ(found["reference"]["nees_dof"], 9);
  // One run: NEES at each epoch is chi-square of 9, and the epochs go together; 1e-6 beyond 45.
  EXPECT_LT(found["reference"]["nees"].get<double>(), 45);
  EXPECT_GT(found["reference"]["position_rms_m"].get<double>(), 0.1);
  EXPECT_LT(found["reference"]["position_rms_m"].get<double>(), 60);
  EXPECT_EQ(gyrobudget_run("simulate " + sensor + " -q --trajectory " + scratch_.file("none.yaml", scene_)).exit_code,
            3);
}

// IMU, GNSS and barometer of one scene, simulated with the errors it names, then navigated: the innovations and the
// errors are as large as the filter says.
TEST_F(Navigate, SimulatedFixesAreConsistent) {
  const std::string scene = scratch_.file(
      "drone.yaml",
      "trajectory: cruise:speed=25,duration=120,turn_acceleration=3,turn_period=20\nsensor: imu.yaml\n"
      "imu: {file: drone.csv}\nreference: {file: truth.csv}\n"
      "alignment: {position: gnss, velocity: gnss, attitude: {heading: 110.8 deg, pitch: 0 deg, roll: 0 deg}, level_sigma: 1 deg, heading_sigma: 3 deg}\n"
      "aids:\n  gnss: {file: gnss.csv, lever_arm: [0.2 m, 0 m, -0.3 m], time_tag_sigma: 5 ms, outages: [[60 s, 80 s]], position: [1.5 m, 1.5 m, 3 m], velocity: 5 cm/s}\n"
      "  baro: {file: baro.csv, rate: 5 Hz, height: {sigma: 0.3 m, bias_sigma: 2 m}}\n");
  const std::string sensor = scratch_.file(
      "imu.yaml",
      "gyro: {arw: 0.15 deg/sqrt(h), turn_on_bias: 100 deg/h}\naccelerometer: {vrw: 0.05 m/s/sqrt(h), turn_on_bias: 3000 ug}\n");
  const Outcome simulated =
      gyrobudget_run("simulate " + sensor + " --trajectory " + scene + " --truth " + scratch_.path("truth.csv") +
                     " -o " + scratch_.path("drone.csv") + " --fixes " + scratch_.path("."));
  ASSERT_EQ(simulated.exit_code, 0) << simulated.err;
  const json found = json_of(gyrobudget_run("navigate " + scene + " --json"));
  for (const json& aid : found["nis"]["aids"]) {
    EXPECT_EQ(aid["gated"], 0) << aid;
    // Mean NIS beyond 5 standard errors of chi-square: false alarm 1e-6.
    const double dof = aid["dof"], used = aid["used"];
    EXPECT_NEAR(aid["mean"].get<double>() / dof, 1, 5 * std::sqrt(2 / (dof * used))) << aid;
  }
  EXPECT_LT(found["reference"]["nees"].get<double>(), 45);  // as above
  EXPECT_LT(found["reference"]["position_rms_m"].get<double>(), 5);
  EXPECT_EQ(gyrobudget_run("simulate " + sensor + " -q --trajectory ascent --fixes " + scratch_.path(".")).exit_code,
            2);
}

TEST_F(Navigate, NumbersOfThreadsChangeNothing) {
  const std::string scene = scene_ + "aids: {gnss: {file: gnss.csv, position: 1 m}}\n";
  const auto body = [](const std::string& text) { return text.substr(text.find("\"scene\"")); };
  EXPECT_EQ(body(run(scene, "--json --threads 1").out), body(run(scene, "--json --threads 2").out));
}

// --- Recorded data -------------------------------------------------------------------------------------------

// A hand-held IMU beside RTKLIB's solution, on clocks that the scene makes one: hardly a fix is refused.
TEST(WalkWithRtk, TheExampleOfTheDocumentationNavigates) {
  if (!std::filesystem::exists(kData + "/nav/walk_rtk.pos")) GTEST_SKIP() << "no public walk in " << kData << "/nav";
  const json found =
      json_of(gyrobudget_run("navigate " + kExamples + "/scenes/walk-with-rtk.yaml --data " + kData + "/nav --json"));
  ASSERT_EQ(found["nis"]["aids"].size(), 2U);
  constexpr double kLargestNis = 1.5;  // per degree of freedom: the errors are assumed, and the limit is no law
  for (const auto& aid : found["nis"]["aids"]) {
    EXPECT_EQ(aid["used"].get<int>() + aid["gated"].get<int>(), 493) << aid;  // 536 without those of the alignment
    EXPECT_LE(aid["gated"].get<int>(), 5) << aid;
    EXPECT_LT(aid["mean"].get<double>() / aid["dof"].get<double>(), kLargestNis) << aid;
  }
}

// A MEMS IMU aligned by a FOG-INS for 60 s, then alone.
class MemsBesideFog : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kData + "/nav/mems_imu_100hz.csv.gz"))
      GTEST_SKIP() << "no " << kData << "/nav/mems_imu_100hz.csv.gz; set GYROBUDGET_DATA to the public data";
  }
};

TEST_F(MemsBesideFog, FindsThePublishedBiasesAndStaysInsideItsSigmas) {
  const json found =
      json_of(gyrobudget_run("navigate " + kExamples + "/scenes/mems-beside-fog.yaml --data " + kData + "/nav --json"));
  // Estimates published with the data, in their axes right, forward, up; ours are forward, right, down. They are no
  // truth: what is asked is agreement to a fifth of the largest gyro bias, and of 3 mg where only velocities tell.
  const std::array<double, 3> gyro{7.70503e-4, -1.03577e-3, -4.09542e-4};          // rad/s
  const std::array<double, 3> accelerometer{-7.09492e-2, 2.83322e-2, 4.60319e-2};  // m/s^2
  const std::array<double, 3> mounting{7.18906e-4, -1.54277e-3, 5.11199e-3};       // rad
  constexpr double kGyroLimit = 5e-5, kAccelerometerLimit = 3e-2, kMountingLimit = 1e-3;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string axis(1, "xyz"[i]);
    EXPECT_NEAR(state(found, "gyro bias " + axis) * kDegreePerHour, gyro[i], kGyroLimit) << axis;
    EXPECT_NEAR(state(found, "accelerometer bias " + axis) * kMicroG, accelerometer[i], kAccelerometerLimit) << axis;
    // Their mounting turns the other way: from the body to the INS.
    EXPECT_NEAR(std::abs(state(found, "ins.attitude mounting " + axis)) * kPi / 180, std::abs(mounting[i]),
                kMountingLimit)
        << axis;
  }
  for (const auto& aid : found["nis"]["aids"]) {
    EXPECT_EQ(aid["used"], 598);
    EXPECT_EQ(aid["gated"], 0);
    EXPECT_GT(aid["mean"].get<double>() / 3, 0.25) << aid["name"];  // errors of the INS are not white
    EXPECT_LT(aid["mean"].get<double>() / 3, 1.5) << aid["name"];
    EXPECT_GT(aid["inside_95"].get<double>(), 0.9) << aid["name"];
  }
  // Held out: 40 s alone, from 60 s to 100 s. Without the biases that were found the heading alone would be 9 deg off.
  const json& end = found["reference"]["final"];
  const auto length = [](const json& v) {
    return std::hypot(v["east"].get<double>(), v["north"].get<double>(), v["up"].get<double>());
  };
  EXPECT_LT(length(end["attitude_deg"]), 0.1);
  EXPECT_LT(length(end["velocity_m_s"]), 0.3);
  EXPECT_LT(length(end["position_m"]), 10);
  EXPECT_LT(found["reference"]["nees"].get<double>(), found["reference"]["nees_high"].get<double>());
}

// A ring laser IMU in a parked vehicle with people in it.
TEST(ParkedVehicle, TheGyrocompassKnowsThatPeopleMoveInIt) {
  if (!std::filesystem::exists(kData + "/static/rlg_vehicle_counts.csv.gz"))
    GTEST_SKIP() << "no " << kData << "/static/rlg_vehicle_counts.csv.gz; set GYROBUDGET_DATA to the public data";
  const json found = json_of(
      gyrobudget_run("navigate " + kExamples + "/scenes/parked-vehicle.yaml --data " + kData + "/static --json"));
  // An independent gyrocompass of the whole record: 88.6 deg, 5-minute parts from 84.6 to 94.2.
  const double heading = found["final"]["heading_deg"].get<double>();
  const double sigma = found["sigma"]["attitude_deg"]["up"].get<double>();
  EXPECT_NEAR(heading, 88.6, 2);
  // About 3 deg at 95 %; white noise alone would claim 0.03.
  EXPECT_GT(1.96 * sigma, 1.5);
  EXPECT_LT(1.96 * sigma, 7);
}

}  // namespace
}  // namespace gyrobudget::tests

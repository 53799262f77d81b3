// SPDX-License-Identifier: MIT
// gyrobudget fly: shipped scenes, JSON, the flight as CSV, faults, exit codes.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using json = nlohmann::json;
const std::string kScenes = GYROBUDGET_EXAMPLES "/scenes/";
const std::string kVehicle = GYROBUDGET_EXAMPLES "/vehicles/vlm1.yaml";
const std::string kSensors = GYROBUDGET_EXAMPLES "/sensors/";

json fly_json(const std::string& arguments, int exit_code = 0) {
  const Outcome run = gyrobudget_run("fly " + arguments + " --json");
  EXPECT_EQ(run.exit_code, exit_code) << arguments << ": " << run.err;
  EXPECT_FALSE(std::regex_search(run.out, std::regex("\\b(nan|inf)\\b"))) << arguments;
  return parsed<json>(run.out);
}

// A scene that flies, with more keys of `flight:`.
std::string scene(const Scratch& scratch, const std::string& keys, const std::string& more = "") {
  return scratch.file("scene.yaml",
                      "name: a test\nsite: alcantara\nflight:\n  vehicle: " + kVehicle + "\n" + keys + more);
}

// What does not depend on when and how it was run.
std::string body(const Outcome& run) { return run.out.substr(run.out.find("\"scene\"")); }

}  // namespace

TEST(FlyScenes, ThreeImusFromAlcantara) {
  const json ideal = fly_json(kScenes + "vlm1-ideal.yaml"), ifog = fly_json(kScenes + "vlm1-ifog.yaml"),
             mems = fly_json(kScenes + "vlm1-mems.yaml");
  for (const json& found : {ideal, ifog, mems}) {
    EXPECT_EQ(found["schema"], "gyrobudget.flight/1");
    for (const auto* field :
         {"scene", "name", "sensor", "vehicle", "seed", "runs", "ended", "account", "burnout", "nominal", "departure",
          "dispersion", "navigation_error", "margins", "limits", "integrator", "trajectory", "inputs", "notes"})
      EXPECT_TRUE(found.contains(field)) << field;
    EXPECT_EQ(found["ended"], "complete");
    // Point mass over a flat, resting Earth: 22.9 km, 11.4 km, 640 m/s, 25.6 km.
    const json& end = found["burnout"];
    EXPECT_NEAR(end["t_s"].get<double>(), 83, 1e-9);
    EXPECT_NEAR(end["height_m"].get<double>(), 22.9e3, 300);
    EXPECT_NEAR(end["downrange_m"].get<double>(), 11.4e3, 300);
    EXPECT_NEAR(end["speed_m_s"].get<double>(), 640, 5);
    EXPECT_NEAR(end["distance_m"].get<double>(), 25.6e3, 300);
    EXPECT_EQ(found["margins"]["met"], true);
  }
  const auto departure = [](const json& found) { return found["departure"]["position_m"]["rss"].get<double>(); };
  EXPECT_LT(departure(ideal), departure(mems));
  EXPECT_LT(departure(ifog), departure(mems));
  EXPECT_LT(departure(mems), 1000);
}

TEST(FlyScenes, TheBudgetOfASceneIsThatOfItsFlight) {
  const json flown = fly_json(kScenes + "vlm1-mems.yaml");
  const json budget = parsed<json>(gyrobudget_run("budget " + kScenes + "vlm1-mems.yaml --keep-all --json").out);
  EXPECT_NEAR(
      flown["navigation_error"]["position_m"]["rss"].get<double>() / budget["total"]["position_m"]["rss"].get<double>(),
      1, 1e-6);
}

TEST(FlyVerb, MonteCarloIsSplitAndTheSameForAnyThreads) {
  const Scratch scratch;
  const std::string path =
      scene(scratch, "  dispersion: {mass: 0.2 %, wind: 5 m/s}\n", "sensor: " + kSensors + "mems.yaml\nuntil: 30 s\n");
  const auto run = [&](const std::string& threads) {
    return gyrobudget_run("fly " + path + " --runs 6 --seed 9 --json --threads " + threads);
  };
  const Outcome one = run("1"), two = run("2");
  EXPECT_EQ(body(one), body(two));
  const json found = parsed<json>(one.out);
  EXPECT_EQ(found["runs"], 6);
  EXPECT_EQ(found["seed"], 9);
  for (const auto* cause : {"sensors", "vehicle", "all"}) {
    EXPECT_EQ(found["dispersion"][cause]["complete"], 6) << cause;
    EXPECT_GT(found["dispersion"][cause]["position_m"]["rss"].get<double>(), 0) << cause;
  }
  EXPECT_EQ(found["navigation_error"]["monte_carlo"]["runs"], 6);
}

TEST(FlyVerb, SensorsSideBySide) {
  const Scratch scratch;
  const std::string path = scene(scratch, "", "until: 20 s\n");
  const json found =
      fly_json(path + " --sensor ideal --sensor " + kSensors + "ifog.yaml --sensor " + kSensors + "mems.yaml");
  EXPECT_EQ(found["schema"], "gyrobudget.flights/1");
  ASSERT_EQ(found["flights"].size(), 3U);
  EXPECT_TRUE(found["flights"][0]["sensor"].is_null());
  const auto departure = [&](int i) {
    return found["flights"][static_cast<std::size_t>(i)]["departure"]["position_m"]["rss"].get<double>();
  };
  EXPECT_LT(departure(0), departure(1));
  EXPECT_LT(departure(1), departure(2));
}

TEST(FlyVerb, TheFlightAsCsvIsATrajectory) {
  const Scratch scratch;
  const std::string path = scene(scratch, "", "sensor: " + kSensors + "mems.yaml\nuntil: 20 s\n");
  const Outcome run = gyrobudget_run("fly " + path + " -o " + scratch.path("flight.csv") + " --rate 50 --report " +
                                     scratch.path("flight.html"));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("report page"), std::string::npos);
  EXPECT_TRUE(std::ifstream(scratch.path("flight.html")).good());
  const Outcome budget = gyrobudget_run(
      "budget " +
      scratch.file("along.yaml", "site: alcantara\ntrajectory: flight.csv\nsensor: " + kSensors + "mems.yaml\n") +
      " --json");
  EXPECT_EQ(budget.exit_code, 0) << budget.err;
  EXPECT_EQ(parsed<json>(budget.out)["at_s"], 20);
}

// Whatever fails, the flight ends with an account, exit code 1, and no number that is none.
TEST(FlyVerb, FaultsHaveAnAccount) {
  struct Fault {
    const char* keys;
    const char* ended;
  };
  const Scratch scratch;
  for (const auto& [keys, ended] :
       {Fault{"  faults: {nozzle_stuck: {at: 20 s, pitch: 1 deg}}\n", "tumbling"},
        Fault{"  faults: {dead_gyro: {axis: y, at: 10 s}}\n", "tumbling"},
        Fault{"  faults: {navigation_delay: 10 s}\n", "impact"}, Fault{"  faults: {thrust_cut: 0 s}\n", "impact"}}) {
    const json found = fly_json(scene(scratch, keys, "sensor: " + kSensors + "mems.yaml\n") + " --runs 2", 1);
    const std::string how = found["ended"].get<std::string>();
    EXPECT_NE(how, "complete") << keys;
    EXPECT_TRUE(how == ended || how == "not_flown") << keys << found["account"];
    EXPECT_FALSE(found["account"].get<std::string>().empty());
  }
  const json cut = fly_json(
      scene(scratch, "  faults: {thrust_cut: 20 s}\n", "sensor: " + kSensors + "mems.yaml\nuntil: 200 s\n"), 1);
  EXPECT_NE(cut["ended"], "complete");
}

TEST(FlyVerb, SaturatedGyrosAndStormsEndSoundly) {
  const Scratch scratch;
  const std::string slow =
      scratch.file("slow.yaml", "gyro: {arw: 0.1 deg/sqrt(h), range: 0.2 deg/s}\n");  // the program turns by 0.53
  const json saturated = fly_json(scene(scratch, "", "sensor: " + slow + "\n"), 1);
  EXPECT_NE(saturated["ended"], "complete");
  const Outcome storm = gyrobudget_run("fly " + scene(scratch, "  wind: {east: 100 m/s}\n"));
  EXPECT_TRUE(storm.exit_code == 0 || storm.exit_code == 1) << storm.err;
  const Outcome pole = gyrobudget_run(
      "fly " + scratch.file("pole.yaml", "site: {latitude: 90 deg, longitude: 0 deg, height: 0 m}\nflight: {vehicle: " +
                                             kVehicle + "}\n"));
  EXPECT_EQ(pole.exit_code, 0) << pole.err;
}

TEST(FlyVerb, GuidanceComesBackToTheNominalTrajectory) {
  const Scratch scratch;
  const auto crossrange = [&](const std::string& guidance) {
    const json found = fly_json(
        scene(scratch, "  dispersion: {thrust_misalignment: 0.1 deg, wind: 5 m/s}\n" + guidance) + " --runs 20");
    return found["dispersion"]["vehicle"]["position_m"]["crossrange"].get<double>();
  };
  EXPECT_LT(crossrange("  guidance: trajectory\n"), 0.5 * crossrange(""));
}

TEST(FlyVerb, ExitCodesSayWhatIsWrong) {
  const Scratch scratch;
  const auto run = [](const std::string& arguments) { return gyrobudget_run("fly " + arguments); };
  EXPECT_EQ(run("").exit_code, 2);
  EXPECT_EQ(run("/nosuch.yaml").exit_code, 3);
  const Outcome planned = run(scratch.file("planned.yaml", "site: alcantara\ntrajectory: ascent\n"));
  EXPECT_EQ(planned.exit_code, 3);
  EXPECT_NE(planned.err.find("flight: {vehicle:"), std::string::npos) << planned.err;
  const std::string good = scene(scratch, "");
  EXPECT_EQ(run(good + " " + good + " --sensor ideal").exit_code, 2);
  EXPECT_EQ(run(good + " " + good + " -o " + scratch.path("x.csv")).exit_code, 2);
  EXPECT_EQ(run(good + " -o " + good).exit_code, 2);
  EXPECT_EQ(run(good + " --runs -1").exit_code, 2);
  EXPECT_EQ(run(good + " --sensor /nosuch.yaml").exit_code, 3);
  EXPECT_EQ(run(good + " -o /nosuch/x.csv").exit_code, 4);
  const Outcome key = run(scene(scratch, "  vehcle: x\n"));
  EXPECT_EQ(key.exit_code, 3);
  EXPECT_NE(key.err.find("scene.yaml:5:3: "), std::string::npos) << key.err;
}

}  // namespace gyrobudget::tests

// SPDX-License-Identifier: MIT
// The program prints what the library calls answer: budget, fly and navigate, every number of them.
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/report/budget.h"
#include "gyrobudget/app/report/flight.h"
#include "gyrobudget/app/report/navigation.h"
#include "gyrobudget/estimation/budget/study.h"
#include "gyrobudget/estimation/closed_loop/study.h"
#include "gyrobudget/estimation/navigation/navigate.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using nlohmann::json;

const std::string kScenes = GYROBUDGET_EXAMPLES "/scenes/";

json printed(const std::string& arguments) {
  const Outcome run = gyrobudget_run(arguments + " --json");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return parsed<json>(run.out);
}

// All that one JSON has of numbers, with where they stand.
void gather(const json& from, const std::string& place, std::vector<std::pair<std::string, double>>& numbers) {
  if (from.is_number()) numbers.emplace_back(place, from.get<double>());
  if (!from.is_structured()) return;
  for (const auto& [key, value] : from.items()) gather(value, place + "/" + key, numbers);
}

// At least so many numbers, and each the same to the last bit.
void expect_the_same_numbers(const json& program, const std::string& library, std::size_t at_least) {
  std::vector<std::pair<std::string, double>> a, b;
  gather(program, "", a);
  gather(parsed<json>(library), "", b);
  EXPECT_GE(a.size(), at_least);
  EXPECT_EQ(a, b);
}

}  // namespace

TEST(LibraryStudies, BudgetPrintsBudgetStudy) {
  for (const std::string name : {"vlm1-mems", "drone-outage"}) {
    const std::string path = kScenes + name + ".yaml";
    const files::SceneFile file = files::read_scene(path);
    const auto study = budget::study(file.scenario, files::planned_trajectory(file),
                                     {.imu_interval = 1 / 50.0,
                                      .exact = true,
                                      .limit = budget::Options::Limit{budget::Component::crossrange, 10},
                                      .runs = 3,
                                      .each_source = true,
                                      .seed = 5});
    const Outcome run = gyrobudget_run(
        "budget " + path + " --rate 50 --exact --limit 'crossrange < 10 m' --runs 3 --each-source --seed 5 --json");
    EXPECT_EQ(run.exit_code, study.limit->met() ? 0 : 1) << name << run.err;
    const json program = parsed<json>(run.out);
    expect_the_same_numbers(program, report::budget_json({{.sensor = file.sensor, .study = study}}), 1000);
    // And not by way of the report: what the study itself has.
    EXPECT_EQ(program["total"]["position_m"]["rss"], study.axes.position_sigma(study.total(), budget::Component::rss));
    ASSERT_EQ(program["sources"].size(), study.budget.lines.size());
    for (std::size_t i = 0; i < study.budget.lines.size(); ++i) {
      const json& line = program["sources"][i];
      EXPECT_EQ(line["name"], study.budget.lines[i].name);
      for (const budget::Component c : {budget::Component::east, budget::Component::up, budget::Component::crossrange})
        EXPECT_EQ(line["position_m"][std::string(to_string(c))], study.axes.position_sigma(study.line(i), c));
    }
    EXPECT_EQ(program["limit"]["found_m"], study.limit->found);
    EXPECT_EQ(program["monte_carlo"]["nees"], study.monte_carlo->nees.mean);
  }
}

TEST(LibraryStudies, FlyPrintsClosedLoopStudy) {
  for (const std::string name : {"vlm1-mems", "vlm1-ideal"}) {
    const std::string path = kScenes + name + ".yaml";
    const files::SceneFile file = files::read_scene(path);
    report::FlightResult r{.sensor = file.sensor, .plan = file.flight->plan, .dispersion = file.flight->dispersion};
    r.vehicle_numbers = file.flight->vehicle.numbers;
    r.vehicle_left_out = file.flight->vehicle.left_out;
    r.study = closed_loop::study(r.plan, r.dispersion, file.scenario, {.runs = 2, .seed = 5, .record_rate = 10});
    const json program = printed("fly " + path + " --runs 2 --seed 5");
    expect_the_same_numbers(program, report::flight_json({&r, 1}), 5000);
    EXPECT_EQ(program["nominal"]["t_s"], r.study.nominal.end.t);
    EXPECT_EQ(program["burnout"]["t_s"], r.study.flown->end.t);
    EXPECT_EQ(program["dispersion"]["sensors"].is_null(), r.study.sensors.outcomes.empty());
  }
}

TEST(LibraryStudies, NavigatePrintsNavigation) {
  const Scratch scratch;
  std::ostringstream log;
  log.precision(17);
  log << "time (s),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (m/s^2),accel_y (m/s^2),accel_z (m/s^2)\n";
  for (int k = 0; k <= 200; ++k) log << 0.1 * k << ",7.292115e-5,1e-5,0,0.001,0," << -9.7803253359 << '\n';
  (void)scratch.file("imu.csv", log.str());
  (void)scratch.file("gnss.csv", "time (s),latitude (deg),longitude (deg),height (m)\n5.05,0,0,0\n10.05,0,1e-6,0.5\n");
  (void)scratch.file("mems.yaml", "gyro: {arw: 0.15 deg/sqrt(h)}\naccelerometer: {turn_on_bias: 1 mg}\n");
  const std::string scene =
      "site: {latitude: 0 deg, longitude: 0 deg, height: 0 m}\nimu: {file: imu.csv}\nsensor: mems.yaml\n"
      "alignment: {position_sigma: 1 m, velocity_sigma: 1 cm/s, attitude: {heading: 0 deg}, level_sigma: 0.1 deg, heading_sigma: 1 deg}\n"
      "aids: {gnss: {file: gnss.csv, position: 1 m}}\nreference: gnss\n";
  for (const bool smooth : {false, true}) {
    const std::string path = scratch.file("scene.yaml", scene);
    files::SceneFile file = files::read_scene(path);
    report::NavigationResult r{.recording = files::read_recording(file).recording};
    file.scenario.smooth = smooth;
    r.scenario = file.scenario;
    r.run = navigation::navigate(r.scenario, r.recording);
    const json program = printed("navigate " + path + (smooth ? " --smooth" : ""));
    expect_the_same_numbers(program, report::navigation_json(r), 60);
    EXPECT_EQ(program["epochs"], r.run.solutions.size());
    EXPECT_EQ(program["final"]["t_s"], r.run.solutions.back().time);
    EXPECT_EQ(program["sigma"]["position_m"]["up"], r.run.solutions.back().position_sigma[2]);
    EXPECT_EQ(program["nis"]["mean"], r.run.nis().mean);
  }
}

}  // namespace gyrobudget::tests

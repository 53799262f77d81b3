// SPDX-License-Identifier: MIT
// The forms of closed-loop flights, from studies that are flown here.
#include "gyrobudget/app/report/flight.h"

#include "gyrobudget/app/report/flight_words.h"
#include "gyrobudget/app/report/layout.h"
#include "gyrobudget/app/report/page_parts.h"
#include "gyrobudget/estimation/budget/error_budget.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <sstream>
#include <string>

#include "../../json.h"
#include "published_schemas.h"

namespace gyrobudget::report {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;
using closed_loop::Outcome;

constexpr double kDegree = earth::kDegree;
constexpr int kRuns = 3;

const flight::Dispersion kDispersion{.impulse = 0.005, .mass = 0.002, .wind = 5};

navigation::Scenario scenario(bool aided = false) {
  navigation::Scenario s;
  s.sensor.gyro.white = 0.15 * kDegree / 60;
  s.sensor.gyro.turn_on_bias = kDegree / 3600;
  s.alignment.level_sigma = 1e-4;
  if (aided) s.aids.push_back({.name = "gnss", .sigma = Vector3d(2, 2, 4)});
  return s;
}

FlightResult result(const flight::Plan& plan, const flight::Dispersion& dispersion, const navigation::Scenario& s,
                    int runs) {
  return {.scene = "a.yaml",
          .name = "a </script> scene",
          .sensor = "folder/mems.yaml",
          .command = "gyrobudget fly a.yaml",
          .plan = plan,
          .dispersion = dispersion,
          .study = closed_loop::study(plan, dispersion, s, {.runs = runs, .seed = 7}),
          .notes = {"a note"}};
}

flight::Plan short_plan() {
  flight::Plan plan;
  plan.flight.duration = 20;
  return plan;
}

// Each is flown once for all tests.
const FlightResult& full() {
  static const FlightResult kResult = result({}, kDispersion, scenario(), kRuns);
  return kResult;
}
const FlightResult& without_runs() {
  static const FlightResult kResult = result(short_plan(), {}, scenario(), 0);
  return kResult;
}
const FlightResult& aided() {
  static const FlightResult kResult = result(short_plan(), kDispersion, scenario(true), kRuns);
  return kResult;
}
const FlightResult& ideal() {
  static const FlightResult kResult = [] {
    FlightResult r = result(short_plan(), {}, {}, 0);
    r.sensor.clear();
    return r;
  }();
  return kResult;
}
// Its sensors lose it; the nominal flight is complete.
const FlightResult& lost() {
  static const FlightResult kResult = [] {
    flight::Plan plan = short_plan();
    plan.navigator_faults = {.dead_gyro = 1, .dead_gyro_at = 5};
    return result(plan, {}, scenario(), kRuns);
  }();
  return kResult;
}
// Never leaves the pad.
const FlightResult& fallen() {
  static const FlightResult kResult = [] {
    flight::Plan plan = short_plan();
    plan.flight.vehicle.specific_impulse = 50;  // thrust below weight
    return result(plan, kDispersion, scenario(), kRuns);
  }();
  return kResult;
}
// Nothing but the vehicle varies, and the nozzle sticks.
const FlightResult& stuck() {
  static const FlightResult kResult = [] {
    flight::Plan plan = short_plan();
    plan.flight.faults.nozzle_stuck_at = 10;
    plan.flight.faults.nozzle_stuck_offset = {0.02, 0};
    return result(plan, kDispersion, {}, kRuns);
  }();
  return kResult;
}

std::vector<const FlightResult*> all() {
  return {&full(), &without_runs(), &aided(), &ideal(), &lost(), &fallen(), &stuck()};
}

Json json(const FlightResult& r) {
  Json object = tests::parsed<Json>(flight_json({&r, 1}));
  tests::expect_schema(object);
  return object;
}
std::string text(const FlightResult& r) { return flight_text({&r, 1}); }

Json page_data_of(const std::string& page) {
  const std::string open = "<script type=\"application/json\" id=\"data\">";
  const auto from = page.find(open) + open.size();
  return tests::parsed<Json>(page.substr(from, page.find("</script>", from) - from));
}

}  // namespace

TEST(FlightReport, JsonHasTheNumbersOfTheStudy) {
  const auto& r = full();
  const Json j = json(r);
  EXPECT_EQ(j["schema"], "gyrobudget.flight/1");
  EXPECT_EQ(j["seed"], 7);
  EXPECT_EQ(j["runs"], kRuns);
  EXPECT_EQ(j["ended"], "complete");
  EXPECT_EQ(j["notes"].back(), "a note");

  // Where it ends, by another way: heights from the ellipsoid, distance from the pad.
  const auto& end = r.study.flown->end;
  const auto pad = earth::to_ecef(r.plan.flight.world.site);
  EXPECT_NEAR(j["burnout"]["t_s"].get<double>(), 83, 1e-9);
  EXPECT_NEAR(j["burnout"]["height_m"].get<double>(), earth::to_geodetic(end.truth.p_eb_e).height, 1e-6);
  EXPECT_NEAR(j["burnout"]["distance_m"].get<double>(), (end.truth.p_eb_e - pad).norm(), 1e-6);
  EXPECT_NEAR(j["burnout"]["downrange_m"].get<double>(), (end.truth.p_eb_e - pad).dot(r.study.C_launch.col(0)), 1e-6);
  EXPECT_NEAR(j["burnout"]["speed_m_s"].get<double>(), end.truth.v_eb_e.norm(), 1e-9);
  EXPECT_NEAR(j["departure"]["position_m"]["rss"].get<double>(),
              (end.truth.p_eb_e - r.study.nominal.end.truth.p_eb_e).norm(), 1e-6);
  EXPECT_NEAR(j["navigation_error"]["flown"]["velocity_m_s"]["rss"].get<double>(),
              (end.truth.v_eb_e - end.seen.v_eb_e).norm(), 1e-9);

  const auto sigma = r.study.all.spread(&Outcome::position).sigma();
  EXPECT_NEAR(j["dispersion"]["all"]["position_m"]["up"].get<double>(), sigma[2], 1e-9);
  EXPECT_NEAR(j["dispersion"]["all"]["position_m"]["rss"].get<double>(), sigma.norm(), 1e-9);
  EXPECT_EQ(j["dispersion"]["sensors"]["complete"], kRuns);
  EXPECT_EQ(j["dispersion"]["vehicle"]["lost"], 0);

  const auto& error = j["navigation_error"];
  const auto total = navigation::local_sigmas(r.study.budget->total.back(), r.study.C_enu);
  EXPECT_NEAR(error["position_m"]["north"].get<double>(), total.position[1], 1e-9);
  EXPECT_NEAR(error["attitude_deg"]["total"].get<double>(), total.attitude.norm() / kDegree, 1e-12);
  EXPECT_EQ(error["sources"].size(), r.study.budget->lines.size());
  double share = 0;
  for (const auto& source : error["sources"]) share += source["share"].get<double>();
  EXPECT_NEAR(share, 1, 1e-9);
  const auto found = navigation::local_sigmas(r.study.sensors.navigation_error(), r.study.C_enu);
  EXPECT_NEAR(error["monte_carlo"]["position_rss_ratio"].get<double>(), found.position.norm() / total.position.norm(),
              1e-12);
  EXPECT_LT(error["monte_carlo"]["ratio_low"].get<double>(), 1);
  EXPECT_GT(error["monte_carlo"]["ratio_high"].get<double>(), 1);

  EXPECT_EQ(j["integrator"]["method"], "exact");
  EXPECT_EQ(j["integrator"]["steps"], r.study.nominal.work.steps);
  EXPECT_EQ(j["integrator"]["step_s"], 0.01);
  EXPECT_EQ(j["limits"]["dynamic_pressure_pa"], r.study.flown->highest_pressure);
  EXPECT_EQ(j["trajectory"]["t_s"].size(), r.study.flown->points.size());
  EXPECT_NEAR(j["trajectory"]["pitch_deg"][0].get<double>(), 90, 1e-9);
  EXPECT_EQ(j["margins"]["met"], true);
}

TEST(FlightReport, WhatIsNotThereIsNull) {
  const Json none = json(without_runs());
  for (const auto* cause : {"sensors", "vehicle", "all"}) EXPECT_TRUE(none["dispersion"][cause].is_null());
  EXPECT_TRUE(none["navigation_error"]["monte_carlo"].is_null());
  EXPECT_TRUE(none["navigation_error"]["claimed"].is_null());
  EXPECT_TRUE(json(ideal())["sensor"].is_null());
  EXPECT_FALSE(json(aided())["navigation_error"]["claimed"].is_null());

  const Json down = json(fallen());
  EXPECT_EQ(down["ended"], "not_flown");
  EXPECT_EQ(down["nominal"]["ended"], "impact");
  for (const auto* field : {"burnout", "departure", "navigation_error", "trajectory"})
    EXPECT_TRUE(down[field].is_null()) << field;

  const Json gone = json(lost());
  EXPECT_EQ(gone["ended"], "tumbling");
  EXPECT_EQ(gone["dispersion"]["sensors"]["lost"], kRuns);
  EXPECT_EQ(gone["dispersion"]["sensors"]["complete"], 0);
  EXPECT_TRUE(gone["dispersion"]["sensors"]["position_m"].is_null());
  EXPECT_GT(gone["departure"]["position_m"]["rss"].get<double>(), 0);  // from the nominal flight at that time
  EXPECT_TRUE(gone["navigation_error"]["monte_carlo"].is_null());
}

TEST(FlightReport, SeveralSensorsAreAList) {
  const std::vector<FlightResult> two{without_runs(), ideal()};
  const Json j = tests::parsed<Json>(flight_json(two));
  EXPECT_EQ(j["schema"], "gyrobudget.flights/1");
  ASSERT_EQ(j["flights"].size(), 2U);
  EXPECT_EQ(j["flights"][0]["schema"], "gyrobudget.flight/1");
  EXPECT_EQ(flight_names(two), (std::vector<std::string>{"mems.yaml", "ideal"}));
  EXPECT_TRUE(one_nominal(two));
}

TEST(FlightReport, ResultsAreToldApart) {
  std::vector<FlightResult> alike{without_runs(), without_runs()};
  alike[1].sensor = "other/mems.yaml";
  EXPECT_EQ(flight_names(alike)[1], "other/mems.yaml");
  alike[1].sensor = alike[0].sensor;
  alike[1].scene = "folder/b.yaml";
  EXPECT_EQ(flight_names(alike)[1], "b.yaml");
  alike[1].scene = "folder/a.yaml";
  EXPECT_EQ(flight_names(alike)[1], "folder/a.yaml, folder/mems.yaml");
}

TEST(FlightReport, NotesSayWhatTheStudyFound) {
  const auto said = [](const FlightResult& r, std::string_view part) {
    return std::ranges::any_of(notes_of(r), [&](const auto& note) { return note.find(part) != std::string::npos; });
  };
  EXPECT_EQ(notes_of(full()), full().notes);
  EXPECT_TRUE(said(lost(), "faults: gyro y dead from 5 s on"));
  EXPECT_TRUE(said(lost(), "sensors: 3 of 3 flights were lost"));
  EXPECT_TRUE(said(fallen(), "no flights were compared") || said(fallen(), "too short to navigate"));
  FlightResult r = full();
  r.study.stopped = true;
  r.study.runs = 2;
  EXPECT_TRUE(said(r, "interrupted: 2 of 3 flights of each kind"));
  for (auto& o : r.study.sensors.outcomes) o.fixes = {.given = 50, .refused = 1};
  EXPECT_TRUE(said(r, "refused 2 % of their fixes"));
}

TEST(FlightReport, NotesAreTheirsWhoHaveThem) {
  std::vector<FlightResult> two{ideal(), without_runs()};
  two[0].notes = {"of both", "of one"};
  two[1].notes = {"of both"};
  EXPECT_EQ(flight_notes(two), (std::vector<std::string>{"of both", "ideal: of one"}));
  EXPECT_EQ(flight_title(two), "a </script> scene");
  two[1].name = "another";
  EXPECT_EQ(flight_title(two), "VLM-1, first stage");
}

TEST(FlightReport, DifferentFlightsHaveEachTheirNominal) {
  const std::vector<FlightResult> two{full(), [] {
                                        FlightResult r = stuck();
                                        r.scene = "b.yaml";
                                        return r;
                                      }()};
  EXPECT_FALSE(one_nominal(two));
  const std::vector<FlightResult> other_vehicle{aided(), without_runs()};  // alike but for what varies
  EXPECT_FALSE(one_nominal(other_vehicle));
  const std::string out = flight_text(two);
  EXPECT_NE(out.find("nominal, a.yaml"), std::string::npos) << out;
  EXPECT_EQ(out.find("any sensor"), std::string::npos);
}

TEST(FlightReport, NumbersOfTheVehicleHaveTheirOrigin) {
  FlightResult r = ideal();
  r.vehicle_numbers = {{"lift_off_mass", "28 t", flight::Origin::sourced, "published"},
                       {"exit_area", "0.35 m^2", flight::Origin::assumed, "size"},
                       {"burn_time", "83 s", std::nullopt, ""}};
  r.vehicle_left_out = {{"bending", "rigid"}};
  const Json v = json(r)["vehicle"];
  EXPECT_EQ(v["origins"]["sourced"], 1);
  EXPECT_EQ(v["origins"]["derived"], 0);
  EXPECT_EQ(v["origins"]["not stated"], 1);
  EXPECT_EQ(v["numbers"][1]["reason"], "size");
  EXPECT_EQ(v["left_out"][0]["key"], "bending");
  EXPECT_NE(text(r).find("1 sourced, 1 assumed, 1 not stated"), std::string::npos);
}

TEST(FlightReport, TheTextIsNarrowAndHasNoHoles) {
  constexpr std::size_t kWidest = 110;
  for (const FlightResult* r : all()) {
    const std::string out = text(*r);
    EXPECT_FALSE(std::regex_search(out, std::regex("\\bnan\\b|\\binf\\b"))) << out;
    std::istringstream lines(out);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(width(line), kWidest) << line;
  }
  EXPECT_NE(text(full()).find("gyro.arw"), std::string::npos);
  EXPECT_NE(text(full()).find("mems.yaml: unaided strapdown\n"), std::string::npos);
  EXPECT_NE(text(full()).find("Dispersion"), std::string::npos);
  EXPECT_EQ(text(without_runs()).find("Dispersion"), std::string::npos);
  EXPECT_NE(text(lost()).find("mems.yaml turned faster than the limit"), std::string::npos);
  EXPECT_NE(text(fallen()).find("came down"), std::string::npos);
  EXPECT_NE(text(aided()).find("claimed by the filter"), std::string::npos);
}

TEST(FlightReport, ThePageIsWholeAndLoadsNothing) {
  for (const FlightResult* r : all()) {
    std::string page = flight_page({r, 1});
    EXPECT_EQ(page.rfind("<!DOCTYPE html>", 0), 0U);
    EXPECT_NE(page.find("</html>"), std::string::npos);
    EXPECT_EQ(page.find("{{"), std::string::npos) << "an unfilled slot";
    EXPECT_EQ(page.find("a </script> scene"), std::string::npos) << "not escaped";
    const auto chart = page.find(kChartJs);
    if (chart != std::string::npos) page.erase(chart, kChartJs.size());
    EXPECT_EQ(page.find("http://"), std::string::npos);
    EXPECT_EQ(page.find("https://"), std::string::npos);
    const Json data = page_data_of(page);
    ASSERT_FALSE(data.is_discarded());
    const Json& shown = data["flights"][0];
    EXPECT_EQ(shown["clouds"]["sensors"]["points"].size(), static_cast<std::size_t>(r->study.sensors.complete()));
    EXPECT_EQ(shown["nominal_trajectory"]["program_deg"][0], 90);
    EXPECT_EQ(shown["growth"].is_null(), !r->study.budget);
  }
}

TEST(FlightReport, InputsHaveUnitsAndFaults) {
  const auto value = [](const FlightResult& r, std::string_view name) {
    for (const Input& i : inputs(r))
      if (i.name == name) return i.value + " " + i.unit;
    return std::string("none");
  };
  EXPECT_EQ(value(stuck(), "nozzle stuck at"), "10 s");
  EXPECT_EQ(value(stuck(), "nozzle stuck off by, pitch"), "1.14592 deg");
  EXPECT_EQ(value(lost(), "dead gyro"), "y ");
  EXPECT_EQ(value(full(), "total impulse"), "0.5 %");
  EXPECT_EQ(value(full(), "pitch over time"), "8: 90, 83: 50 s: deg");
  EXPECT_EQ(value(full(), "nozzle stuck at"), "none");
}

}  // namespace gyrobudget::report

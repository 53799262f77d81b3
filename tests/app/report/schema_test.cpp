// SPDX-License-Identifier: MIT
// The published schemas describe what the writers print, and every writer has one.
#include "gyrobudget/app/report/accuracy.h"
#include "gyrobudget/app/report/budget.h"
#include "gyrobudget/app/report/flight.h"
#include "gyrobudget/app/report/inspection.h"
#include "gyrobudget/app/report/navigation.h"
#include "gyrobudget/app/report/paper.h"
#include "gyrobudget/app/report/plan.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/estimation/closed_loop/study.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "../../json.h"
#include "fixtures.h"
#include "published_schemas.h"

namespace gyrobudget::report {
namespace {

using Json = nlohmann::json;

// --- Small results, one for each writer --------------------------------------------------------------------------

RunsResult two_runs() {
  const LogResult run = fixtures::mems();
  fit::Combined arw{.records = 2, .identified = 2, .value = 4.4e-5, .lower = 4.3e-5, .upper = 4.5e-5};
  return {.command = "gyrobudget calibrate a.csv b.csv",
          .runs = {run, run},
          .combined = {{"gyro_x", noise::Signal::angular_rate, {arw}, {"c.csv"}}}};
}

InspectionResult inspection() {
  const log::InspectedStream stream{.name = "/imu",
                                    .type = "sensor_msgs/Imu",
                                    .kind = log::StreamKind::imu,
                                    .samples = 9,
                                    .is_read = true,
                                    .clock = "header.stamp",
                                    .first_ns = 1,
                                    .last_ns = 9,
                                    .rate_hz = 1e9,
                                    .mean_rate_hz = 1e9,
                                    .largest_gap_s = 1e-9,
                                    .columns = {{"angular_velocity.x", "rad/s", "the format", 9, 0.1, 1., -1., 2.}},
                                    .odd = {"it is short"}};
  return {
      "gyrobudget inspect walk.bag",
      {.source = "walk.bag", .format = "ROS 1 bag", .streams = {stream}, .notes = {"cut"}, .calibrate = {"walk.bag"}}};
}

PlanStudy plan() {
  const fit::Plan terms{.terms = {{noise::Term::white, 4.4e-5}},
                        .rows = {{3600, {0.01}}, {60, {std::numeric_limits<double>::infinity()}}},
                        .answers = {{noise::Term::white, 0.1, std::numeric_limits<double>::infinity()}}};
  return {.sensor = "MEMS",
          .command = "gyrobudget plan mems.yaml",
          .rate_hz = 100,
          .plan = {.parts = {{{0, 1}, terms}, {{2}, terms}}, .all = terms},
          .notes = {"read as densities"}};
}

AccuracyStudy accuracy_study() {
  AccuracyStudy study{.sensor = "MEMS", .command = "gyrobudget accuracy mems.yaml", .asked = 4};
  study.accuracy.records = 4;
  study.accuracy.samples = 3600;
  study.accuracy.methods = {{.coefficients = {{.truth = 4.4e-5, .rmse = 0.01, .bound = 0.01}}}};
  study.checks = fit::check(fit::parse_requirements("arw.rmse<0.1, whittle.p05<0.1"), study.accuracy);
  return study;
}

SweepStudy sweep() {
  return {.sensor = "MEMS",
          .command = "gyrobudget accuracy mems.yaml --sweep",
          .rate_hz = 1,
          .sweep = {.rows = {{.samples = 3600, .records = 4, .coefficients = {{}}}}}};
}

Paper paper() {
  Paper paper{.command = "gyrobudget paper", .seed = 1, .rate_hz = 100, .duration_s = 36'000};
  paper.rows = {{.id = "table1.model1.arw", .group = "model 1", .what = "ARW", .unit = "deg/sqrt(h)"}};
  paper.rows.front().fitted = PaperRow::Fitted{};
  paper.flight.hypotheses.emplace_back();
  return paper;
}

NavigationResult navigation() {
  NavigationResult result{.scene = "a.yaml", .source = "imu.csv", .command = "gyrobudget navigate a.yaml"};
  result.recording.imu.stamps = {0, 10'000'000};
  result.run.status = navigation::Navigation::Status::no_start;
  result.run.why = "the aid that the alignment needs has no fix";
  return result;
}

// One source, 3 m each way.
BudgetResult budget() {
  BudgetResult result{.scene = "a.yaml", .command = "gyrobudget budget a.yaml"};
  const navigation::CoreMatrix nine = 9 * navigation::CoreMatrix::Identity();
  result.study.budget.times = {0};
  result.study.budget.lines = {{"gyro.arw", {nine}}};
  result.study.budget.total = {nine};
  return result;
}

FlightResult flight() {
  flight::Plan plan;
  plan.flight.duration = 1;
  return {.scene = "a.yaml",
          .command = "gyrobudget fly a.yaml",
          .plan = plan,
          .study = closed_loop::study(plan, {}, {}, {.margins = false})};
}

struct Written {
  std::string name;
  std::string json;
};

std::vector<Written> every_object() {
  const FlightResult flown = flight();
  const std::vector<FlightResult> two{flown, flown};
  return {{"gyrobudget.allan/1", allan_json(fixtures::mems_curve_only())},
          {"gyrobudget.calibration/1", calibration_json(fixtures::mems())},
          {"gyrobudget.runs/1", runs_json(two_runs())},
          {"gyrobudget.inspect/1", inspection_json(inspection())},
          {"gyrobudget.plan/1", plan_json(plan())},
          {"gyrobudget.accuracy/1", accuracy_json(accuracy_study())},
          {"gyrobudget.accuracy_sweep/1", sweep_json(sweep())},
          {"gyrobudget.paper/1", paper_json(paper())},
          {"gyrobudget.navigation/1", navigation_json(navigation())},
          {"gyrobudget.budget/1", budget_json({budget()})},
          {"gyrobudget.budgets/1", budget_json({budget(), budget()})},
          {"gyrobudget.flight/1", flight_json({&flown, 1})},
          {"gyrobudget.flights/1", flight_json(two)}};
}

// --- What is asked of the schemas ----------------------------------------------------------------------------------

TEST(Schemas, EveryOneIsUsed) {
  std::set<std::string> used;
  for (const auto& [name, json] : every_object()) {
    SCOPED_TRACE(name);
    const Json object = tests::parsed<Json>(json);
    EXPECT_EQ(object["schema"], name);
    tests::expect_schema(object);
    used.insert(name);
  }
  EXPECT_EQ(used, tests::published_names()) << "each file of app/report/schema is there for one object above";
}

TEST(Schemas, EveryNameInTheWritersHasItsFile) {
  std::set<std::string> written;
  for (const auto& entry : std::filesystem::directory_iterator(GYROBUDGET_REPORT)) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream in(entry.path());
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    const std::regex name("\"(gyrobudget\\.[a-z_]+/[0-9]+)\"");
    for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at) written.insert((*at)[1]);
  }
  EXPECT_EQ(written, tests::published_names());
}

TEST(Schemas, HoldForResultsOfEveryKind) {
  for (const LogResult& result : {fixtures::mems(), fixtures::not_described(), fixtures::accelerometer(),
                                  fixtures::bounded(), fixtures::imu(), fixtures::hostile_names()}) {
    SCOPED_TRACE(result.source);
    tests::expect_schema(tests::parsed<Json>(calibration_json(result)));
    tests::expect_schema(tests::parsed<Json>(allan_json(result)));
  }
  tests::expect_schema(tests::parsed<Json>(calibration_json(fixtures::mems_curve_only())));  // no fit
}

// Whatever key is lost, added or given another type, the schemas see it: none of their parts is loose.
TEST(Schemas, SeeEveryChange) {
  const auto& schemas = tests::published_schemas();
  for (const auto& [name, json] : every_object()) {
    SCOPED_TRACE(name);
    const Json object = tests::parsed<Json>(json);
    const auto rejected = [&, id = tests::schema_id(name)](const Json& changed) {
      return !schemas.violations(changed, id).empty();
    };
    for (const auto& [key, value] : object.items()) {
      Json without = object, other = object;
      without.erase(key);
      other[key] = value.is_boolean() ? Json("true") : Json(true);
      EXPECT_TRUE(rejected(without)) << key;
      EXPECT_TRUE(rejected(other)) << key;
    }
    // An unknown key in any object that has known ones; keys of tables are checked by their own values.
    const std::function<void(const Json&, const Json::json_pointer&)> walk = [&](const Json& part,
                                                                                 const Json::json_pointer& at) {
      if (part.is_array() && !part.empty()) walk(part.front(), at / 0);
      if (!part.is_object()) return;
      Json more = object;
      more[at]["unheard_of"] = true;
      EXPECT_TRUE(rejected(more)) << at;
      for (const auto& [key, value] : part.items()) walk(value, at / key);
    };
    walk(object, Json::json_pointer());
  }
}

// Shared parts stand once, and none stands for nothing.
TEST(Schemas, UseEveryDefinition) {
  std::set<std::string> defined, used;
  for (const auto& entry : std::filesystem::directory_iterator(GYROBUDGET_SCHEMAS)) {
    const std::string file = entry.path().filename().string();
    std::ifstream in(entry.path());
    const Json document = tests::parsed<Json>(std::string{std::istreambuf_iterator<char>(in), {}});
    const Json definitions = document.value("$defs", Json::object()), flat = document.flatten();
    for (const auto& [key, value] : definitions.items()) defined.insert(file + "#/$defs/" + key);
    for (const auto& [pointer, value] : flat.items()) {
      if (!pointer.ends_with("/$ref")) continue;
      const auto reference = value.get<std::string>();
      if (reference.find('#') != std::string::npos)
        used.insert(reference.starts_with('#') ? file + reference : reference);
    }
  }
  EXPECT_EQ(defined, used);
}

// The schemas are the manual: every field says in a sentence what it is.
TEST(Schemas, DescribeEveryField) {
  std::size_t fields = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROBUDGET_SCHEMAS)) {
    SCOPED_TRACE(entry.path().filename());
    std::ifstream in(entry.path());
    const Json document = tests::parsed<Json>(std::string{std::istreambuf_iterator<char>(in), {}});
    const auto described = [&](const Json& field) {
      const std::string text = field.value("description", field.contains("$ref") ? "This is there." : "");
      return text.size() > 2 && text.ends_with('.') && text.find(' ') != std::string::npos;
    };
    // Conditions name fields only to narrow them.
    const std::function<void(const Json&)> walk = [&](const Json& schema) {
      for (const auto& [keyword, value] : schema.items()) {
        if (keyword == "if" || keyword == "then" || keyword == "else") continue;
        if (keyword == "properties" || keyword == "$defs") {
          for (const auto& [key, field] : value.items()) {
            ++fields;
            EXPECT_TRUE(described(field)) << key << ": " << field;
            walk(field);
          }
        } else if (value.is_object()) {
          walk(value);
        } else if (value.is_array()) {
          for (const Json& one : value)
            if (one.is_object()) walk(one);
        }
      }
    };
    walk(document);
    EXPECT_TRUE(document.contains("title") && described(document));
  }
  EXPECT_GT(fields, 500U);
}

}  // namespace
}  // namespace gyrobudget::report

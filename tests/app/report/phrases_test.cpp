// SPDX-License-Identifier: MIT
// No number without meaning: datasheets of odd records, as text, as JSON and as a page, are searched for phrases that
// say nothing.
#include "gyrobudget/app/report/calibration.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/estimation/calibration/calibrate.h"
#include "gyrobudget/estimation/calibration/sensor_model.h"
#include "gyrobudget/estimation/fit/judgement.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "../../json.h"

namespace gyrobudget::report {
namespace {

using noise::Term;
using Json = nlohmann::ordered_json;

constexpr double kRate = 10;  // [Hz]
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::vector<double> made(std::vector<noise::Process> processes, std::int64_t samples, std::uint64_t seed = 1) {
  return noise::generate_record(processes, samples, 1 / kRate, {.seed = seed, .stream = 0});
}

template <class Change>
std::vector<double> changed(std::vector<double> rate, Change change) {
  for (std::size_t i = 0; i < rate.size(); ++i) rate[i] = change(i, rate[i]);
  return rate;
}

struct Odd {
  std::string name;
  std::vector<double> rate;
};

std::vector<Odd> odd_records() {
  const noise::White white{5e-4};
  const auto plain = made({white}, 4000);
  const auto sine = [](std::size_t i) {
    return std::sin(2 * std::numbers::pi * 1.37 * static_cast<double>(i) / kRate);
  };
  std::vector<Odd> list;
  list.push_back({"silent", std::vector<double>(4000, 1e-3)});
  list.push_back({"all zero", std::vector<double>(4000, 0.0)});
  list.push_back({"two values", changed(plain, [](auto, double y) { return y > 0 ? 1e-3 : 0.0; })});
  list.push_back(
      {"one value that differs", changed(std::vector<double>(4000), [](auto i, auto) { return i == 77 ? 1.0 : 0.0; })});
  list.push_back({"one knock", changed(plain, [](auto i, double y) { return i == 1234 ? 1.0 : y; })});
  list.push_back({"huge ramp", changed(plain, [](auto i, double y) { return y + 1e-3 * static_cast<double>(i); })});
  list.push_back({"nothing but a ramp", changed(plain, [](auto i, auto) { return 1e-3 * static_cast<double>(i); })});
  list.push_back({"tiny", changed(plain, [](auto, double y) { return 1e-100 * y; })});
  list.push_back({"16 samples", made({white}, 16)});
  list.push_back({"40 samples", made({white}, 40)});
  list.push_back({"300 samples", made({white}, 300)});
  list.push_back({"all missing but 20", changed(plain, [](auto i, double y) { return i < 20 ? y : kNaN; })});
  list.push_back({"pure sine", changed(plain, [&](auto i, auto) { return 1e-3 * sine(i); })});
  list.push_back({"sine in noise", changed(plain, [&](auto i, double y) { return y + 1e-3 * sine(i); })});
  list.push_back({"pure walk", made({noise::RateRandomWalk{1e-4}}, 4000)});
  list.push_back({"pure flicker", made({noise::Flicker{1e-4}}, 4000)});
  list.push_back({"pure angle noise", made({noise::Quantization{1e-4}}, 4000)});
  list.push_back({"walk that begins to show", made({white, noise::RateRandomWalk{6e-6}}, 3000, 4)});
  list.push_back({"flicker that begins to show", made({white, noise::Flicker{4e-5}}, 3000, 5)});
  list.push_back({"step", changed(plain, [](auto i, double y) { return i > 2000 ? y + 2e-3 : y; })});
  list.push_back({"alternating", changed(plain, [](auto i, auto) { return i % 2 == 0 ? 1e-3 : -1e-3; })});
  list.push_back({"held", changed(plain, [&](auto i, auto) { return plain[i - i % 3]; })});
  list.push_back({"every fourth missing in a third",
                  changed(plain, [](auto i, double y) { return i < 1300 && i % 4 == 0 ? kNaN : y; })});
  list.push_back({"smooth", changed(plain, [&](auto i, double y) { return i > 0 ? 0.5 * (y + plain[i - 1]) : y; })});
  return list;
}

// A number that means nothing, or a sentence that ends in nothing.
const std::vector<std::string>& empty_phrases() {
  static const std::vector<std::string> kPhrases{
      R"(\b-?nan\b)",
      R"(\b-?inf\b)",
      R"(\(mean -[ )])",
      R"(\bmean -\s)",
      R"((^| )- (deg|rad|m/s|ug|s|Hz|%)\b)",  // "- deg/h"
      R"(known to [1-9]\d\d+ %)",             // "known to 399 %"
      R"(within 0 %)",
      R"(\bby 0 %|up to [+-]?0 %|allow 0 %|off by 0)",
      R"(tau = 0 s|from 0 s to 0 s|\bfrom 0 s on|at 0 s \()",
      R"(between (\S+) and \1 )",  // "between 19 and 19 Hz"
      R"(\b1 (fainter )?lines\b|\b1 samples\b|\b1 times\b)",
      R"(p = 0([ ,;)]|\. |$))",
      R"(record at least longer)",
      R"(at least infinite)",
      R"(infinite)",
      R"(\{\})",
      R"( %  |  ,| \.( |$))",
  };
  return kPhrases;
}

void expect_meaning(const std::string& text, const std::string& what) {
  for (const std::string& phrase : empty_phrases()) {
    std::smatch found;
    EXPECT_FALSE(std::regex_search(text, found, std::regex(phrase, std::regex::icase)))
        << what << ": '" << found.str() << "' (" << phrase << ") in ..."
        << found.prefix().str().substr(std::max<std::ptrdiff_t>(0, found.prefix().length() - 150)) << found.str()
        << found.suffix().str().substr(0, 80);
  }
}

// Every string of a JSON value.
void collect(const Json& value, std::string& texts) {
  if (value.is_string()) texts += value.get<std::string>() + '\n';
  if (value.is_structured())
    for (const auto& part : value) collect(part, texts);
}

std::string between(const std::string& text, const std::string& open, const std::string& close) {
  const auto start = text.find(open) + open.size();
  return text.substr(start, text.find(close, start) - start);
}

void expect_meaning(const LogResult& result, const std::string& what) {
  // Lines are joined: a phrase may be broken over two of them.
  expect_meaning(std::regex_replace(datasheet(result), std::regex("\\n *"), " "), what + ", text");
  std::string texts;
  collect(tests::parsed<Json>(calibration_json(result)), texts);
  expect_meaning(texts, what + ", JSON");
  texts.clear();
  collect(tests::parsed<Json>(between(page(result), R"(<script type="application/json" id="data">)", "</script>")),
          texts);
  expect_meaning(texts, what + ", page");
}

struct Way {
  std::string name;
  calibration::Options options;
};

std::vector<Way> ways() {
  std::vector<Way> list(5);
  list[0].name = "default";
  list[1].name = "cross-check, everything masked";
  list[1].options.cross_check = true;
  list[1].options.mask = {.outliers = true, .steps = true, .warm_up = true};
  list[2].name = "N, R";
  list[2].options.terms = std::vector{Term::white, Term::rate_ramp};
  list[3].name = "likelihood with a line";
  list[3].options.terms = std::vector{Term::white, Term::sinusoid};
  list[3].options.method = fit::Method::whittle;
  list[4].name = "visual";
  list[4].options.method = fit::Method::visual;
  return list;
}

class Phrases : public testing::TestWithParam<Odd> {};

TEST_P(Phrases, SayNothingEmpty) {
  for (const Way& way : ways()) {
    const auto record =
        allan::make_record({{"gyro_x", noise::Signal::angular_rate, GetParam().rate}}, kRate, "odd.csv");
    try {
      const auto sheet = calibration::calibrate(record, way.options);
      EXPECT_TRUE(sheet.axes[0].faults.empty()) << way.name << ": " << sheet.axes[0].faults[0].what;
      expect_meaning(calibration_result(sheet, {}, "gyrobudget calibrate odd.csv"), way.name);
      const auto summary = calibration::summarise(sheet, "odd");
      expect_meaning(provenance(sheet, {summary, "gyrobudget calibrate odd.csv", summary.sensor}),
                     way.name + ", sensor file");
    } catch (const calibration::Unusable& refused) {
      expect_meaning(refused.what(), way.name + ", refusal");
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Of, Phrases, testing::ValuesIn(odd_records()), [](const auto& of) {
  std::string name = of.param.name;
  std::ranges::replace(name, ' ', '_');
  return name;
});

TEST(Phrases, OfChosenTermsSayNothingEmpty) {
  calibration::Options options;
  options.choose_terms = true;
  for (const Odd& odd : odd_records()) {
    if (odd.name != "sine in noise" && odd.name != "huge ramp" && odd.name != "silent") continue;
    const auto record = allan::make_record({{"gyro_x", noise::Signal::angular_rate, odd.rate}}, kRate, "odd.csv");
    expect_meaning(calibration_result(calibration::calibrate(record, options), {}, "calibrate"), odd.name);
  }
}

TEST(Phrases, OfATableSayNothingEmpty) {
  allan::DeviationTable table{.source = "table", .tau_s = {}, .columns = {{.name = "x", .deviation = {}}}};
  for (double tau = 0.1; tau < 2000; tau *= 2) {
    table.tau_s.push_back(tau);
    table.columns[0].deviation.push_back(1e-4 / std::sqrt(tau));
  }
  const auto sheet = calibration::calibrate(table, kRate, 36000);
  expect_meaning(calibration_result(sheet, {}, "calibrate"), "table");
}

// One statement of a walk that is not resolved: no share of it is claimed beside "not resolved".
TEST(Phrases, AnUnresolvedWalkIsSpokenOfOnce) {
  for (std::uint64_t seed = 1; seed < 200; ++seed) {
    const auto rate = made({noise::White{5e-4}, noise::RateRandomWalk{4e-5}}, 300, seed);
    const auto record = allan::make_record({{"gyro_x", noise::Signal::angular_rate, rate}}, kRate, "odd.csv");
    const auto sheet = calibration::calibrate(record);
    const auto& walk = sheet.axes[0].fit[Term::rate_random_walk];
    if (walk.status == fit::Status::identified || !(walk.value > 0) || !fit::is_quotable(sheet.axes[0].fit)) continue;
    const std::string text = std::regex_replace(datasheet(calibration_result(sheet, {}, "")), std::regex("\\n *"), " ");
    EXPECT_EQ(text.find("No rate random walk is seen"), std::string::npos) << text;
    const std::regex share(R"(by variance, [^;.]*rate random walk \d)");
    EXPECT_FALSE(std::regex_search(text, share)) << text;
    return;
  }
  FAIL() << "no record of the kind was met";
}

TEST(Phrases, AFaultIsToldAndTheOthersStand) {
  auto holes = made({noise::White{5e-4}}, 4000, 2);
  for (std::size_t i = 0; i < holes.size(); i += 3) holes[i] = kNaN;
  const auto record = allan::make_record({{"gyro_x", noise::Signal::angular_rate, made({noise::White{5e-4}}, 4000)},
                                          {"gyro_y", noise::Signal::angular_rate, holes}},
                                         kRate, "odd.csv");
  const auto sheet = calibration::calibrate(record);
  const LogResult result = calibration_result(sheet, {}, "calibrate");
  expect_meaning(result, "a column of holes");
  const std::string text = std::regex_replace(datasheet(result), std::regex("\\n *"), " ");
  EXPECT_NE(text.find("The fit of gyro_y ended in an error"), std::string::npos) << text;
  EXPECT_NE(text.find("identified"), std::string::npos);
  const Json json = tests::parsed<Json>(calibration_json(result));
  EXPECT_TRUE(json.at("axes").at(0).at("faults").empty());
  EXPECT_EQ(json.at("axes").at(1).at("faults").at(0).at("stage"), "fit");
  EXPECT_TRUE(json.at("axes").at(1).at("fit").is_null());
}

}  // namespace
}  // namespace gyrobudget::report

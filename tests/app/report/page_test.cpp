// SPDX-License-Identifier: MIT
// What can be tested of the page without a browser: it is whole, loads nothing, and escapes what users name things.
#include "gyrobudget/app/report/page_parts.h"
#include "gyrobudget/app/report/report.h"

#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <string>

#include "../../json.h"
#include "fixtures.h"

namespace gyrobudget::report {
namespace {

using Json = nlohmann::ordered_json;

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t found = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + what.size())) ++found;
  return found;
}

std::string between(const std::string& text, const std::string& open, const std::string& close) {
  const auto start = text.find(open) + open.size();
  return text.substr(start, text.find(close, start) - start);
}

Json data_of(const std::string& page) {
  return tests::parsed<Json>(between(page, "<script type=\"application/json\" id=\"data\">", "</script>"));
}

/// Everything that makes a browser fetch something.
void expect_self_contained(const std::string& page) {
  const std::regex load(R"re((<link|<iframe|<object|<embed|@import|\burl\s*\(|\ssrc\s*=|\shref\s*=\s*["']?(?!#)))re",
                        std::regex::icase);
  std::string markup = page;
  const auto chart = markup.find(kChartJs);  // a library; what it could load the policy below forbids
  ASSERT_NE(chart, std::string::npos);
  markup.erase(chart, kChartJs.size());
  std::smatch found;
  EXPECT_FALSE(std::regex_search(markup, found, load)) << found.str() << found.suffix().str().substr(0, 80);
  EXPECT_EQ(markup.find("http://"), std::string::npos);
  EXPECT_EQ(markup.find("https://"), std::string::npos);
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(Page, IsWholeAndLoadsNothing) {
  for (const LogResult& result :
       {fixtures::mems(), fixtures::mems_curve_only(), fixtures::bounded(), fixtures::not_described()}) {
    const std::string text = page(result);
    EXPECT_EQ(text.rfind("<!DOCTYPE html>", 0), 0U);
    EXPECT_NE(text.find("</html>"), std::string::npos);
    EXPECT_EQ(text.find("{{"), std::string::npos) << "an unfilled slot";
    expect_self_contained(text);
  }
}

TEST(Page, ScriptsAreBalanced) {
  for (const LogResult& result : {fixtures::mems(), fixtures::imu()}) {
    const std::string text = page(result);
    EXPECT_EQ(count(text, "<script"), 3U);
    EXPECT_EQ(count(text, "</script>"), 3U);
  }
}

TEST(Page, NamesOfUsersStayText) {
  const LogResult result = fixtures::hostile_names();
  const std::string text = page(result);
  EXPECT_EQ(count(text, "<script"), 3U);
  EXPECT_EQ(count(text, "</script>"), 3U);
  EXPECT_EQ(text.find("<b>"), std::string::npos);
  EXPECT_EQ(text.find("<img"), std::string::npos);
  EXPECT_NE(text.find("<title>Datasheet of script&gt;&lt;b&gt;&quot;it&#39;s&quot;&amp;"), std::string::npos);
  const Json data = data_of(text);
  EXPECT_EQ(data.at("allan").at("source"), result.source);
  EXPECT_EQ(data.at("allan").at("axes").at(0).at("name"), result.axes.front().name);
  EXPECT_EQ(data.at("calibration").at("axes").at(0).at("advice").at(0), result.axes.front().advice.front());
  EXPECT_EQ(data.at("allan").at("command"), result.command);  // its {{script}} is not filled in
}

TEST(Page, CarriesEverySentenceAndRow) {
  const Json data = data_of(page(fixtures::accelerometer()));
  const Json& axis = data.at("axes").at(0);
  EXPECT_EQ(axis.at("words").at("headline"), "described within 3.1 %");
  for (const char* key : {"verdict", "consequence", "minimum", "beta", "cut"}) {
    EXPECT_FALSE(axis.at("words").at(key).get<std::string>().empty()) << key;
  }
  ASSERT_EQ(axis.at("rows").size(), 5U);
  EXPECT_EQ(axis.at("rows").at(1).at("datasheet").at("value"), "12.0 ± 2.0");
  EXPECT_EQ(axis.at("rows").at(1).at("si").at("unit"), "m/s^2");
  EXPECT_EQ(axis.at("curves").at("terms").size(), 3U);
  EXPECT_EQ(axis.at("curves").at("model").size(), axis.at("curves").at("tau_s").size());
  EXPECT_EQ(axis.at("curves").at("marks").size(), 4U);
  EXPECT_EQ(axis.at("curves").at("terms").at(0).at("text").at("si"), "velocity random walk: N = 0.000333 m/s/sqrt(s)");
  EXPECT_EQ(data.at("calibration").at("axes").at(0).at("fit").at("residuals").size(), 22U);
}

TEST(Page, WithoutAFitThereIsStillACurve) {
  const std::string text = page(fixtures::mems_curve_only());
  EXPECT_NE(text.find("<title>Allan deviation of mems_10h.csv</title>"), std::string::npos);
  const Json data = data_of(text);
  EXPECT_TRUE(data.at("axes").at(0).at("words").is_null());
  EXPECT_TRUE(data.at("calibration").at("axes").at(0).at("fit").is_null());
  EXPECT_GT(data.at("allan").at("axes").at(0).at("points").size(), 50U);
}

TEST(Page, ReadsWithoutScripts) {
  const std::string fallback = between(page(fixtures::mems()), "<noscript>", "</noscript>");
  EXPECT_NE(fallback.find("0.70 ± 0.12"), std::string::npos);
  EXPECT_NE(fallback.find("Verdict: described."), std::string::npos);
}

TEST(Page, StaysSmallForDenseCurves) {
  LogResult result = fixtures::mems();
  auto& points = result.axes.front().points;
  const allan::DeviationPoint last = points.back();
  points.clear();
  for (std::int64_t m = 1; m <= 200000; ++m) {
    allan::DeviationPoint p = last;
    p.m = m;
    p.tau_s = 0.01 * static_cast<double>(m);
    points.push_back(p);
  }
  const std::string text = page(result);
  EXPECT_LE(data_of(text).at("allan").at("axes").at(0).at("points").size(), 300U);
  constexpr std::size_t kLargest = 400000;  // half of it is Chart.js
  EXPECT_LT(text.size(), kLargest);
}

TEST(Page, SameResultSameBytes) {
  LogResult slow = fixtures::mems();
  slow.axes.front().fit->seconds = 3.5;
  EXPECT_EQ(page(fixtures::mems()), page(slow));
}

TEST(Page, EveryElementThatTheScriptAsksForExists) {
  const std::string script(kPageJs), html(kPageHtml);
  const std::regex asked(R"re(byId\("([a-z-]+)"\))re");
  std::set<std::string> ids;
  for (auto it = std::sregex_iterator(script.begin(), script.end(), asked); it != std::sregex_iterator(); ++it)
    ids.insert((*it)[1]);
  EXPECT_GE(ids.size(), 6U);
  for (const std::string& id : ids) EXPECT_NE(html.find("id=\"" + id + "\""), std::string::npos) << id;
  const std::regex classes(R"re(querySelector\("\.([a-z-]+))re");
  for (auto it = std::sregex_iterator(script.begin(), script.end(), classes); it != std::sregex_iterator(); ++it) {
    const std::string name = (*it)[1];
    const std::regex used("class=\"[^\"]*\\b" + name + "\\b");
    EXPECT_TRUE(std::regex_search(html, used) || script.find('"' + name) != std::string::npos) << name;
  }
}

TEST(Page, ExplainsEachNumber) {
  const std::string glossary = between(page(fixtures::mems()), "id=\"glossary\"", "</section>");
  for (const char* word : {"ARW", "bias instability", "RRW", "edf", "p-value", "Worst misfit", "beta", "Raw minimum",
                           "identified, upper bound, left out", "Allan deviation"}) {
    EXPECT_NE(glossary.find(word), std::string::npos) << word;
  }
}

TEST(Page, TitleIsTheNameOfTheFile) {
  LogResult result = fixtures::mems();
  result.source = "some/folder/log.csv";
  EXPECT_NE(page(result).find("<title>Datasheet of log.csv</title>"), std::string::npos);
}

TEST(Page, GivesChartJsItsLicence) {
  EXPECT_NE(page(fixtures::mems()).find("Released under the MIT License"), std::string::npos);
}

}  // namespace
}  // namespace gyrobudget::report

// SPDX-License-Identifier: MIT
// The program prints what the library computes: every number of the same ten records.
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/report/calibration.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/noise/sensor.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

#include <string>
#include <utility>

#include "../estimation/calibration/records.h"
#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using nlohmann::json;

// Shortest decimals that give the same doubles back.
std::string csv(const allan::Record& record) {
  std::string text = "time (s)";
  for (const auto& axis : record.axes)
    text += fmt::format(",{} ({})", axis.name, axis.signal == noise::Signal::angular_rate ? "rad/s" : "m/s^2");
  for (std::int64_t i = 0; i < record.samples; ++i) {
    text += fmt::format("\n{:.1f}", static_cast<double>(i) / record.rate_hz);
    for (const auto& axis : record.axes) text += fmt::format(",{}", axis.rate[static_cast<std::size_t>(i)]);
  }
  return text + "\n";
}

struct Options {
  std::string words;
  calibration::Options library;
};

void expect_same_coefficients(const json& printed, const calibration::AxisDatasheet& axis) {
  for (const auto& c : axis.fit.coefficients) {
    if (!c.fitted) continue;
    const auto& parameter = printed["parameters"][std::string(noise::key(axis.signal, c.term))];
    const double unit = noise::parse_unit(noise::datasheet_unit(axis.signal, c.term)).to_si;
    EXPECT_EQ(parameter["value"].get<double>(), c.value / unit);
    EXPECT_EQ(parameter["lower"].get<double>(), c.lower / unit);
  }
  EXPECT_EQ(printed["fit"]["chi2"].is_null() ? 0 : printed["fit"]["chi2"].get<double>(),
            printed["fit"]["chi2"].is_null() ? 0 : axis.fit.chi2);
  std::size_t outliers = 0;
  for (const auto& found : printed["findings"])
    if (found["kind"] == "outliers" || found["kind"] == "heavy_tail") outliers = found["count"].get<std::size_t>();
  EXPECT_EQ(outliers, axis.findings->outliers.size());
}

void expect_same(const std::string& path, const Options& options) {
  const Outcome program = gyrobudget_run("calibrate --json " + path + " " + options.words);
  const allan::Record record = log::read_log({.path = path});
  const calibration::Datasheet sheet = calibration::calibrate(record, options.library);
  EXPECT_EQ(program.exit_code, sheet.is_complete() ? 0 : 1) << path << " " << options.words;
  json printed = parsed<json>(program.out);
  for (std::size_t i = 0; i < sheet.axes.size(); ++i) expect_same_coefficients(printed["axes"][i], sheet.axes[i]);
  // And all the rest of it.
  const std::string command = printed["command"].get<std::string>();
  json computed = parsed<json>(report::calibration_json(report::calibration_result(sheet, record.notes, command)));
  for (json* result : {&printed, &computed})
    for (json& axis : (*result)["axes"])
      if (axis["fit"].is_object()) axis["fit"].erase("seconds");
  EXPECT_EQ(printed, computed) << json::diff(printed, computed).dump(1);
}

TEST(Library, ComputesWhatCalibratePrints) {
  const Scratch scratch;
  for (const auto& [name, record] : ten_records()) {
    SCOPED_TRACE(name);
    const std::string path = scratch.file("record.csv", csv(record));
    expect_same(path, {"", {}});
    if (name == "knocks") expect_same(path, {"--mask outliers", {.mask = {.outliers = true}}});
    if (name == "step") expect_same(path, {"--mask steps", {.mask = {.steps = true}}});
    if (name == "warm-up") expect_same(path, {"--mask warm-up", {.mask = {.warm_up = true}}});
    if (name == "clean") expect_same(path, {"--cross-check", {.cross_check = true}});
    if (name == "line") expect_same(path, {"--terms auto", {.choose_terms = true}});
  }
}

}  // namespace
}  // namespace gyrobudget::tests

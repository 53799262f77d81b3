// SPDX-License-Identifier: MIT
// The contract of the JSON that other programs read: keys, types, units, and when null is allowed.
#include "../../json.h"

#include "gyrobudget/app/report/report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "fixtures.h"
#include "published_schemas.h"

namespace gyrobudget::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kDegree = std::numbers::pi / 180;

std::vector<std::string> keys_of(const Json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

void expect_keys(const Json& object, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) EXPECT_TRUE(object.contains(key)) << "no \"" << key << "\" in " << object.dump();
}

void expect_record(const Json& document, std::int64_t samples, double rate, double duration) {
  const Json& record = document.at("record");
  expect_keys(record, {"samples", "rate_hz", "duration_s", "missing_samples"});
  EXPECT_TRUE(record.at("samples").is_number_integer());
  EXPECT_EQ(record.at("samples"), samples);
  EXPECT_EQ(record.at("rate_hz"), rate);
  EXPECT_EQ(record.at("duration_s"), duration);
  EXPECT_TRUE(record.at("missing_samples").is_number_integer());
}

TEST(AllanJson, HasEveryFieldOfTheContract) {
  const LogResult result = fixtures::mems_curve_only();
  const Json document = tests::parsed<Json>(allan_json(result));
  EXPECT_EQ(document.at("schema"), "gyrobudget.allan/1");
  EXPECT_EQ(keys_of(document).front(), "schema");
  expect_record(document, 3600000, 100, 36000);
  EXPECT_EQ(document.at("estimator"), "oadev");
  ASSERT_EQ(document.at("axes").size(), 1U);
  const Json& axis = document.at("axes").at(0);
  EXPECT_EQ(axis.at("name"), "gyro_x");
  EXPECT_EQ(axis.at("unit"), "deg/h");
  EXPECT_NEAR(axis.at("mean").get<double>(), 12.3, 1e-12);
  ASSERT_EQ(axis.at("points").size(), result.axes.front().points.size());
  for (const Json& point : axis.at("points")) {
    expect_keys(point, {"tau_s", "m", "deviation", "lower", "upper", "edf", "terms"});
    EXPECT_TRUE(point.at("m").is_number_integer());
    EXPECT_TRUE(point.at("terms").is_number_integer());
    for (const char* key : {"tau_s", "deviation", "lower", "upper", "edf"})
      EXPECT_TRUE(point.at(key).is_number()) << key;
    EXPECT_LE(point.at("lower"), point.at("deviation"));
    EXPECT_GE(point.at("upper"), point.at("deviation"));
  }
}

TEST(AllanJson, DeviationsAreInTheUnitItNames) {
  const LogResult result = fixtures::accelerometer();
  const Json axis = tests::parsed<Json>(allan_json(result)).at("axes").at(0);
  EXPECT_EQ(axis.at("unit"), "ug");
  EXPECT_EQ(axis.at("si_unit"), "m/s^2");
  const double to_si = axis.at("si_per_unit");
  EXPECT_NEAR(to_si, 9.80665e-6, 1e-18);
  const double deviation = axis.at("points").at(0).at("deviation");
  EXPECT_NEAR(deviation * to_si / result.axes.front().points.front().deviation, 1, 1e-15);
}

TEST(AllanJson, DoublesSurviveTheRoundTrip) {
  LogResult result = fixtures::mems_curve_only();
  result.rate_hz = 1.0 / 3;
  result.axes.front().points.front().tau_s = 0.1 + 0.2;
  result.axes.front().points.front().edf = std::numeric_limits<double>::denorm_min();
  const Json document = tests::parsed<Json>(allan_json(result));
  EXPECT_EQ(document.at("record").at("rate_hz").get<double>(), 1.0 / 3);
  EXPECT_EQ(document.at("axes").at(0).at("points").at(0).at("tau_s").get<double>(), 0.1 + 0.2);
  EXPECT_EQ(document.at("axes").at(0).at("points").at(0).at("edf").get<double>(),
            std::numeric_limits<double>::denorm_min());
}

TEST(Json, EndsInOneNewline) {
  for (const std::string& text : {allan_json(fixtures::mems()), calibration_json(fixtures::imu())}) {
    EXPECT_EQ(text.find_last_not_of('\n'), text.size() - 2);
  }
}

const std::vector<std::string> kParameterKeys = {"value", "unit", "lower", "upper", "relative_std", "status"};
const std::vector<std::string> kFitKeys = {"method",  "tau_min_s",    "tau_max_s", "chi2",      "dof",
                                           "p_value", "worst_misfit", "verdict",   "converged", "iterations"};

TEST(CalibrationJson, RunTimesStandInItWhereTheyAreAskedFor) {
  LogResult result = fixtures::mems(), slow = result;
  slow.axes.front().fit->seconds = 3.5;
  EXPECT_EQ(calibration_json(result), calibration_json(slow));
  slow.timing = true;
  EXPECT_EQ(tests::parsed<Json>(calibration_json(slow))["axes"][0]["fit"]["seconds"], 3.5);
}

TEST(CalibrationJson, HasEveryFieldOfTheContract) {
  const Json document = tests::parsed<Json>(calibration_json(fixtures::mems()));
  EXPECT_EQ(document.at("schema"), "gyrobudget.calibration/1");
  expect_record(document, 3600000, 100, 36000);
  const Json& axis = document.at("axes").at(0);
  expect_keys(axis, {"name", "parameters", "minimum", "beta", "fit", "advice"});
  const Json& parameters = axis.at("parameters");
  EXPECT_EQ(keys_of(parameters),
            (std::vector<std::string>{"arw", "bias_instability", "rrw", "quantization", "rate_ramp"}));
  for (const auto& [key, parameter] : parameters.items()) expect_keys(parameter, kParameterKeys);
  EXPECT_EQ(parameters.at("arw").at("unit"), "deg/sqrt(h)");
  EXPECT_EQ(parameters.at("bias_instability").at("unit"), "deg/h");
  EXPECT_EQ(parameters.at("rrw").at("unit"), "deg/h/sqrt(h)");
  EXPECT_EQ(parameters.at("quantization").at("unit"), "arcsec");
  EXPECT_EQ(parameters.at("rate_ramp").at("unit"), "deg/h/h");
  expect_keys(axis.at("minimum"), {"deviation", "tau_s"});
  expect_keys(axis.at("fit"), kFitKeys);
  EXPECT_TRUE(axis.at("advice").is_array());
  EXPECT_TRUE(axis.at("advice").at(0).is_string());
}

TEST(CalibrationJson, GivesTheNumbersOfTheFit) {
  const Json axis = tests::parsed<Json>(calibration_json(fixtures::mems())).at("axes").at(0);
  const Json& parameters = axis.at("parameters");
  EXPECT_NEAR(parameters.at("arw").at("value").get<double>(), 0.15, 1e-15);
  EXPECT_NEAR(parameters.at("bias_instability").at("value").get<double>(), 0.70, 1e-14);
  EXPECT_NEAR(parameters.at("rrw").at("value").get<double>(), 4.32, 1e-13);
  EXPECT_NEAR(parameters.at("arw").at("si").at("value").get<double>(), 0.15 * kDegree / 60, 1e-19);
  EXPECT_EQ(parameters.at("arw").at("si").at("unit"), "rad/sqrt(s)");
  EXPECT_EQ(parameters.at("bias_instability").at("relative_std"), 0.166);
  EXPECT_EQ(parameters.at("arw").at("status"), "identified");
  EXPECT_NEAR(axis.at("beta").get<double>(), 0.49 / (9 * 0.072), 1e-12);
  EXPECT_NEAR(axis.at("minimum").at("deviation").get<double>(), 0.964, 1e-3);
  EXPECT_NEAR(axis.at("minimum").at("tau_s").get<double>(), 268.3, 0.1);
  const Json& fit = axis.at("fit");
  EXPECT_EQ(fit.at("method"), "gls");
  EXPECT_EQ(fit.at("verdict"), "described");
  EXPECT_EQ(fit.at("p_value"), 0.4341);
  EXPECT_EQ(fit.at("dof"), 14);
  EXPECT_EQ(fit.at("converged"), true);
  EXPECT_EQ(fit.at("residuals").size(), 21U);
  // Variances of the fitted coefficients in their units: (0.166 * 0.70 deg/h)^2 for B.
  EXPECT_EQ(fit.at("covariance").at("parameters"), Json({"arw", "bias_instability", "rrw"}));
  EXPECT_NEAR(fit.at("covariance").at("matrix").at(1).at(1).get<double>(), std::pow(0.166 * 0.70, 2), 1e-14);
}

TEST(CalibrationJson, AccelerometersHaveTheirOwnKeys) {
  const Json parameters =
      tests::parsed<Json>(calibration_json(fixtures::accelerometer())).at("axes").at(0).at("parameters");
  EXPECT_EQ(keys_of(parameters),
            (std::vector<std::string>{"vrw", "bias_instability", "accel_rw", "quantization", "rate_ramp"}));
  EXPECT_EQ(parameters.at("vrw").at("unit"), "m/s/sqrt(h)");
  EXPECT_EQ(parameters.at("bias_instability").at("unit"), "ug");
  EXPECT_EQ(parameters.at("accel_rw").at("unit"), "ug/sqrt(h)");
  EXPECT_NEAR(parameters.at("vrw").at("value").get<double>(), 0.02, 1e-16);
  EXPECT_NEAR(parameters.at("accel_rw").at("value").get<double>(), 20, 1e-12);
}

TEST(CalibrationJson, FittedCoefficientsAlwaysHaveNumbers) {
  for (const LogResult& result : {fixtures::mems(), fixtures::bounded(), fixtures::imu(), fixtures::not_described()}) {
    const Json document = tests::parsed<Json>(calibration_json(result));
    for (const Json& axis : document.at("axes")) {
      for (const auto& [key, parameter] : axis.at("parameters").items()) {
        const bool fitted = parameter.at("fitted");
        for (const char* field : {"value", "lower", "upper"}) {
          EXPECT_EQ(parameter.at(field).is_number(), fitted) << key << " " << field;
          EXPECT_EQ(parameter.at(field).is_null(), !fitted) << key << " " << field;
        }
        EXPECT_TRUE(fitted || parameter.at("status") == "left_out") << key;
      }
    }
  }
}

TEST(CalibrationJson, BoundsAreZeroWithAnUpperLimit) {
  const Json parameters = tests::parsed<Json>(calibration_json(fixtures::bounded())).at("axes").at(0).at("parameters");
  const Json& b = parameters.at("bias_instability");
  EXPECT_EQ(b.at("status"), "upper_bound");
  EXPECT_EQ(b.at("value"), 0.0);
  EXPECT_EQ(b.at("lower"), 0.0);
  EXPECT_NEAR(b.at("upper").get<double>(), 1.42e-3, 1e-17);
  EXPECT_TRUE(b.at("relative_std").is_null());  // infinite
  const Json& k = parameters.at("rrw");
  EXPECT_EQ(k.at("status"), "left_out");
  EXPECT_EQ(k.at("value"), 0.0);
  EXPECT_NEAR(k.at("upper").get<double>(), 1.1e-5, 1e-19);
}

TEST(CalibrationJson, AnUpperLimitThatWasNotFoundIsNull) {
  LogResult result = fixtures::mems();
  result.axes.front().fit->coefficients[1].upper = std::numeric_limits<double>::infinity();
  result.axes.front().fit->coefficients[1].lower = std::numeric_limits<double>::quiet_NaN();
  tests::expect_schema(tests::parsed<Json>(calibration_json(result)));
  const Json arw = tests::parsed<Json>(calibration_json(result)).at("axes").at(0).at("parameters").at("arw");
  EXPECT_EQ(arw.at("lower"), 0.0);
  EXPECT_TRUE(arw.at("upper").is_null());
  EXPECT_TRUE(arw.at("si").at("upper").is_null());
  EXPECT_TRUE(arw.at("value").is_number());
}

TEST(CalibrationJson, WhatIsNotANumberIsNull) {
  LogResult result = fixtures::mems();
  fit::Result& fit = *result.axes.front().fit;
  fit.method = fit::Method::visual;
  fit.p_value = fit.chi2 = std::numeric_limits<double>::quiet_NaN();
  result.axes.front().points.front().upper = std::numeric_limits<double>::infinity();
  const Json axis = tests::parsed<Json>(calibration_json(result)).at("axes").at(0);
  tests::expect_schema(tests::parsed<Json>(calibration_json(result)));
  tests::expect_schema(tests::parsed<Json>(allan_json(result)));
  EXPECT_EQ(axis.at("fit").at("method"), "visual");
  EXPECT_TRUE(axis.at("fit").at("p_value").is_null());
  EXPECT_TRUE(axis.at("fit").at("chi2").is_null());
  EXPECT_TRUE(tests::parsed<Json>(allan_json(result)).at("axes").at(0).at("points").at(0).at("upper").is_null());
}

TEST(CalibrationJson, AnUntestedFitHasNoPValue) {
  LogResult result = fixtures::mems();
  result.axes.front().fit->dof = 0;
  EXPECT_TRUE(tests::parsed<Json>(calibration_json(result)).at("axes").at(0).at("fit").at("p_value").is_null());
}

TEST(CalibrationJson, NamesVerdictCutAndMoves) {
  const Json described = tests::parsed<Json>(calibration_json(fixtures::accelerometer())).at("axes").at(0).at("fit");
  EXPECT_EQ(described.at("verdict"), "described_within");
  EXPECT_EQ(described.at("worst_misfit"), 0.031);
  ASSERT_EQ(described.at("moved").size(), 3U);
  EXPECT_EQ(described.at("moved").at(0).at("parameter"), "vrw");
  EXPECT_NEAR(described.at("moved").at(0).at("from").get<double>(), 0.0203, 1e-16);
  EXPECT_EQ(described.at("residuals").at(2).at("used"), false);
  EXPECT_EQ(described.at("residuals").at(3).at("used"), true);
  const Json not_described =
      tests::parsed<Json>(calibration_json(fixtures::not_described())).at("axes").at(0).at("fit");
  EXPECT_EQ(not_described.at("verdict"), "not_described");
  EXPECT_EQ(not_described.at("p_value"), 0.0);
}

TEST(CalibrationJson, WorksWithoutAFit) {
  const Json axis = tests::parsed<Json>(calibration_json(fixtures::mems_curve_only())).at("axes").at(0);
  EXPECT_EQ(axis.at("parameters"), Json::object());
  EXPECT_TRUE(axis.at("fit").is_null());
  EXPECT_TRUE(axis.at("minimum").is_null());
}

TEST(Json, NamesOfAnyBytesAreText) {
  const LogResult result = fixtures::hostile_names();
  const Json document = tests::parsed<Json>(calibration_json(result));
  EXPECT_EQ(document.at("source"), result.source);
  EXPECT_EQ(document.at("axes").at(0).at("name"), result.axes.front().name);
  const std::string note = document.at("notes").at(0);
  EXPECT_NE(note.find("\\ \t tab, newline\nhere"), std::string::npos);
  EXPECT_NE(note.find("\xef\xbf\xbd"), std::string::npos);  // U+FFFD for what is not UTF-8
}

}  // namespace
}  // namespace gyrobudget::report

// SPDX-License-Identifier: MIT
// calibrate --terms: Gauss-Markov processes, sinusoids, and terms chosen by the record.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

// N in deg/sqrt(h), sigma and amplitude in deg/h.
constexpr double kN = 0.15, kSigma = 6, kTime = 120, kAmplitude = 20, kFrequency = 0.05;
const std::string kSensor =
    "name: test\n"
    "gyro:\n"
    "  arw: 0.15 deg/sqrt(h)\n"
    "  gauss_markov: [{sigma: 6 deg/h, correlation_time: 120 s}]\n"
    "  sinusoid: [{amplitude: 20 deg/h, frequency: 0.05 Hz}]\n";

// 5 h at 10 Hz, or another length, of a sensor.
class Log {
 public:
  explicit Log(const std::string& sensor, const std::string& options = "--duration 5h --rate 10 --axes x --seed 3") {
    const auto outcome =
        gyrobudget_run("simulate " + scratch_.file("sensor.yaml", sensor) + " " + options + " -o " + path("log.csv"));
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  [[nodiscard]] std::string path(const std::string& name) const { return scratch_.path(name); }
  [[nodiscard]] Outcome calibrate(const std::string& options) const {
    return gyrobudget_run("calibrate " + path("log.csv") + " " + options);
  }
  [[nodiscard]] nlohmann::json axis(const std::string& options) const {
    const auto outcome = calibrate("--json " + options);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return parsed<nlohmann::json>(outcome.out)["axes"][0];
  }

 private:
  Scratch scratch_;
};

std::string contents(const std::string& path) { return shell("cat '" + path + "'").out; }

double number(const nlohmann::json& parameters, const char* key, const char* what) {
  return parameters[key][what].get<double>();
}

// Within 4 standard deviations (6e-5 of false alarms each), those of the fit's own intervals.
void expect_near(const nlohmann::json& parameter, double truth) {
  const double value = parameter["value"].get<double>(), std_dev = value * parameter["relative_std"].get<double>();
  EXPECT_NEAR(value, truth, 4 * std_dev) << parameter;
  EXPECT_LT(std_dev, 0.1 * truth) << parameter;
}

TEST(Terms, GaussMarkovAndSinusoidAreFittedWithTheirTimeAndFrequency) {
  const Log log(kSensor);
  for (const std::string method : {"gls", "whittle"}) {
    const auto axis = log.axis("--terms N,G,S --method " + method);
    const auto& p = axis["parameters"];
    EXPECT_EQ(axis["fit"]["verdict"], "described") << method;
    expect_near(p["arw"], kN);
    expect_near(p["gauss_markov"], kSigma);
    expect_near(p["sinusoid"], kAmplitude);
    // 120 s in 150 of its lengths: known to 15 %; the likelihood's interval is 2 sigma wide on each side.
    EXPECT_LT(number(p, "gauss_markov", "correlation_time_lower_s"), kTime);
    EXPECT_GT(number(p, "gauss_markov", "correlation_time_upper_s"), kTime);
    EXPECT_NEAR(number(p, "gauss_markov", "correlation_time_s") / kTime, 1, 4 * 0.15);
    // Cramer-Rao: sqrt(12)/(2 pi T) std(A)/A = 1.5e-7 Hz.
    EXPECT_NEAR(number(p, "sinusoid", "frequency_hz"), kFrequency, 4 * 1.5e-7);
    EXPECT_LT(number(p, "sinusoid", "frequency_lower_hz"), number(p, "sinusoid", "frequency_hz"));
    EXPECT_GT(number(p, "sinusoid", "frequency_upper_hz"), number(p, "sinusoid", "frequency_hz"));
    EXPECT_FALSE(p["rrw"]["fitted"].get<bool>());
    for (const auto& found : axis["findings"])
      EXPECT_NE(found["kind"], "line") << "a line of the model is not one that it lacks";
  }
}

TEST(Terms, TextPageAndSensorFileHoldThem) {
  const Log log(kSensor);
  const auto outcome = log.calibrate("--terms N,G,S --cross-check -o " + log.path("out.yaml") + " --kalibr " +
                                     log.path("imu.yaml") + " --report " + log.path("page.html"));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  for (const std::string text :
       {"G  Gauss-Markov noise", "correlation time", "S  sinusoid", "frequency", "The two agree."})
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text << outcome.out;
  EXPECT_EQ(outcome.out.find("not described"), std::string::npos);
  const std::string page = contents(log.path("page.html"));
  EXPECT_NE(page.find("\"shape\":{\"label\":\"correlation time\""), std::string::npos);
  const std::string sensor = contents(log.path("out.yaml"));
  EXPECT_NE(sensor.find("gauss_markov:"), std::string::npos) << sensor;
  EXPECT_NE(sensor.find("frequency: 0.04999"), std::string::npos) << sensor;
  EXPECT_EQ(
      gyrobudget_run("simulate " + log.path("out.yaml") + " --duration 1min --rate 10 -o " + log.path("again.csv"))
          .exit_code,
      0);
  EXPECT_NE(contents(log.path("imu.yaml")).find("Gauss-Markov noise"), std::string::npos);
}

TEST(Terms, AutoFindsThemAndListsWhatItWeighed) {
  const Log log(kSensor);
  const auto axis = log.axis("--terms auto");
  const auto& fit = axis["fit"];
  EXPECT_EQ(fit["chosen"], nlohmann::json({"arw", "gauss_markov", "sinusoid"}));
  EXPECT_EQ(fit["verdict"], "described");
  bool kept_markov = false;
  for (const auto& w : fit["weighed"]) {
    EXPECT_TRUE(w["gain"].is_number() && w["cut"].is_number() && w["beside"].is_array()) << w;
    if (!w["kept"].get<bool>()) continue;
    EXPECT_GT(w["gain"].get<double>(), w["cut"].get<double>());
    kept_markov = kept_markov || w["candidate"] == "gauss_markov";
  }
  EXPECT_TRUE(kept_markov);
  const auto text = log.calibrate("--terms auto").out;
  EXPECT_NE(text.find("weighed:"), std::string::npos) << text;
  EXPECT_NE(text.find("Terms chosen by likelihood ratios: N, G and S."), std::string::npos) << text;
}

// A floor of half a decade is flicker to one reader and a Gauss-Markov process to another: both stand there.
TEST(Terms, WhatTheRecordCannotTellApartIsPrintedTwice) {
  const Log log("name: m\ngyro:\n  arw: 0.15 deg/sqrt(h)\n  bias_instability: 0.70 deg/h\n  rrw: 4.32 deg/h/sqrt(h)\n",
                "--duration 10h --rate 10 --axes x --seed 1");
  const auto axis = log.axis("--terms auto");
  const auto& other = axis["fit"]["alternative"];
  ASSERT_TRUE(other.is_object()) << axis["fit"]["weighed"];
  // At most 2 less likely; more likely by no more than its further parameter must bring.
  EXPECT_LT(other["log_likelihood_difference"].get<double>(), 2);
  EXPECT_GT(other["log_likelihood_difference"].get<double>(), -5);
  EXPECT_TRUE(axis["parameters"]["bias_instability"]["fitted"].get<bool>());
  EXPECT_FALSE(other["parameters"]["bias_instability"]["fitted"].get<bool>());
  EXPECT_GT(number(other["parameters"], "gauss_markov", "correlation_time_s"), 0);
  const auto text = log.calibrate("--terms auto").out;
  for (const std::string part :
       {"The record cannot tell", "wanders on every time scale", "forgets itself in", "The other model"})
    EXPECT_NE(text.find(part), std::string::npos) << part << text;
}

// 5 % of records get a term that they do not have. Of nine, four or more do with a probability of 6e-4.
TEST(Terms, WhiteNoiseAloneRarelyGetsAnother) {
  const Scratch scratch;
  const std::string sensor = scratch.file("sensor.yaml", "name: w\ngyro:\n  arw: 0.15 deg/sqrt(h)\n");
  std::string logs;
  for (const std::string seed : {"1", "2", "3"}) {
    logs += scratch.path(seed + ".csv") + " ";
    ASSERT_EQ(gyrobudget_run("simulate " + sensor + " --duration 1h --rate 2 --seed " + seed + " -o " +
                             scratch.path(seed + ".csv"))
                  .exit_code,
              0);
  }
  int others = 0, axes = 0;
  const auto document = parsed<nlohmann::json>(gyrobudget_run("calibrate --json --terms auto " + logs).out);
  for (const auto& run : document["runs"]) {
    for (const auto& axis : run["axes"]) {
      ++axes;
      if (axis["signal"] == "angular_rate") others += axis["fit"]["chosen"] != nlohmann::json({"arw"});
    }
  }
  EXPECT_GE(axes, 9);
  EXPECT_LE(others, 3);
}

// Known shapes are held; a table, which cannot show them, is fitted with them.
TEST(Terms, AGivenTimeAndFrequencyAreHeld) {
  const Log log(kSensor);
  const auto axis = log.axis("--terms N,G=100s,S=0.05Hz");
  const auto& p = axis["parameters"];
  EXPECT_EQ(number(p, "gauss_markov", "correlation_time_s"), 100);
  EXPECT_EQ(number(p, "gauss_markov", "correlation_time_lower_s"), 100);
  EXPECT_EQ(number(p, "sinusoid", "frequency_hz"), 0.05);
  // A curve of N = 1 deg/sqrt(h) = 60 deg/h/sqrt(Hz) and a process of 10 deg/h and 120 s.
  const Scratch scratch;
  std::string table = "tau (s),x (deg/h)\n";
  for (double tau = 1; tau < 2e4; tau *= 2) {
    const double r = tau / 120;
    const double markov = 100 * 2 / (r * r) * (r - 1.5 + 2 * std::exp(-r) - 0.5 * std::exp(-2 * r));
    table += std::to_string(tau) + "," + std::to_string(std::sqrt(3600 / tau + markov)) + "\n";
  }
  const auto outcome = gyrobudget_run("calibrate --json --curve " + scratch.file("t.csv", table) +
                                      " --rate 10 --duration 40h --terms N,G=120s");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto of_table = parsed<nlohmann::json>(outcome.out)["axes"][0]["parameters"];
  EXPECT_NEAR(number(of_table, "arw", "value"), 1, 0.01);
  EXPECT_NEAR(number(of_table, "gauss_markov", "value"), 10, 0.1);
  EXPECT_NE(gyrobudget_run("calibrate x.csv --terms N,K=3s").err.find("G=120s"), std::string::npos);
}

TEST(Terms, ATableHasNoSamplesForThem) {
  for (const std::string terms : {"auto", "N,G", "N,S"}) {
    const auto outcome = gyrobudget_run("calibrate --curve t.csv --rate 1 --duration 1h --terms " + terms);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_NE(outcome.err.find("need the log"), std::string::npos) << outcome.err;
  }
  EXPECT_NE(gyrobudget_run("calibrate x.csv --terms N,X").err.find("G (gauss_markov)"), std::string::npos);
  EXPECT_EQ(gyrobudget_run("plan x.yaml --want G=10%").exit_code, 2);
}

}  // namespace
}  // namespace gyrobudget::tests

// SPDX-License-Identifier: MIT
// What stands in for a complete log: tables of deviations, and records with samples missing.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

constexpr int kUsage = 2, kBadInput = 3;

nlohmann::json json_of(const Outcome& run) {
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return parsed<nlohmann::json>(run.out);
}

// --- Which rows, which clock, which files ----------------------------------------------------------------------------

class LogOptionsOfTheLine : public testing::Test {
 protected:
  [[nodiscard]] Outcome allan(const std::string& arguments) const {
    return gyrobudget_run("allan " + arguments + " --taus octave --json");
  }
  Scratch scratch_;
};

/// 64 rows of a clock in milliseconds, a word and a reading.
std::string rows_with_words() {
  std::string text = "tick,which,x\n";
  for (int i = 0; i < 64; ++i) text += fmt::format("{},{},{}\n", 1000 + 10 * i, i % 2 ? "odd" : "even", i * 7 % 11);
  return text;
}

TEST_F(LogOptionsOfTheLine, ChooseClockRowsAndUnits) {
  const std::string log = "'" + scratch_.file("log.csv", rows_with_words()) + "' --column x --unit deg/s ";
  EXPECT_DOUBLE_EQ(json_of(allan(log + "--time tick=ms"))["record"]["rate_hz"].get<double>(), 100);
  EXPECT_DOUBLE_EQ(json_of(allan(log + "--time tick=us"))["record"]["rate_hz"].get<double>(), 1e5);
  EXPECT_EQ(json_of(allan(log + "--time none --rate 7"))["record"]["samples"], 64);
  EXPECT_EQ(json_of(allan(log + "--time tick=counter --rate 7"))["record"]["samples"], 64);
  for (const std::string name : {"--rows", "--where"})
    EXPECT_EQ(json_of(allan(log + "--time tick=ms " + name + " which=odd"))["record"]["samples"], 32);
  for (const std::string wrong : {"--time tick=h", "--time tick=counter", "--where which", "--where which="}) {
    const Outcome run = allan(log + wrong);
    EXPECT_EQ(run.exit_code, kUsage) << wrong;
    EXPECT_NE(run.err.find(wrong.starts_with("--time") ? "--time" : "--rows"), std::string::npos) << run.err;
  }
  EXPECT_EQ(allan(log + "--time clock=ms").exit_code, kBadInput);
  EXPECT_EQ(allan(log + "--time tick=ms --where which=none").exit_code, kBadInput);
}

TEST_F(LogOptionsOfTheLine, JoinTwoFilesOfOneRecording) {
  std::string gyro = "time (s),x (deg/s)\n", accelerometer = "time (s),x\n";
  for (int i = 0; i < 64; ++i) {
    gyro += fmt::format("{:.3f},{}\n", 0.01 * i, i * 7 % 11);
    accelerometer += fmt::format("{:.3f},{}\n", 0.01 * i + 0.002, i * 5 % 7);
  }
  const std::string first = "'" + scratch_.file("gyro.csv", gyro) + "'";
  const std::string second = scratch_.file("acc.csv", accelerometer);
  const auto json = json_of(allan(first + " --with '" + second + "=m/s^2'"));
  ASSERT_EQ(json["axes"].size(), 2U);
  const Outcome bare = allan(first + " --with '" + second + "'");
  EXPECT_EQ(bare.exit_code, kBadInput);
  EXPECT_NE(bare.err.find("acc.csv:1:10: column 'x' has no unit"), std::string::npos) << bare.err;
}

TEST_F(LogOptionsOfTheLine, AnEmptyValueIsAnErrorOfUse) {
  const std::string log = "'" + scratch_.file("log.csv", "x (1)\n1\n2\n1\n") + "' ";
  for (const std::string option : {"--rate", "--unit", "--scale", "--column", "--rows", "--time", "--with", "--taus",
                                   "--resample", "--segments", "--plot"}) {
    const Outcome run = allan(log + (option == "--rate" ? "" : "--rate 1 ") + option + " ''");
    EXPECT_EQ(run.exit_code, kUsage) << option;
    EXPECT_NE(run.err.find(option + ": the value is empty; was a variable of the shell not set?"), std::string::npos)
        << run.err;
    EXPECT_EQ(gyrobudget_run("allan " + log + option + "=").exit_code, kUsage) << option;
  }
}

// --- Tables of deviations -------------------------------------------------------------------------------------------

constexpr double kArw = 0.15;  // deg/sqrt(h)
constexpr double kRrw = 4.32;  // deg/h/sqrt(h)

/// White noise and rate random walk at 100 Hz, asymptotes: from 10 samples on they are the truth to 0.5 % of K's part.
std::string table(const std::vector<double>& taus_s) {
  std::string text = "tau (s),adev (deg/h),lower (deg/h)\n";
  for (const double tau : taus_s) {
    const double hours = tau / 3600;
    const double deviation = std::sqrt(kArw * kArw / hours + kRrw * kRrw * hours / 3);
    text += fmt::format("{:.6g},{:.9g},{:.9g}\n", tau, deviation, 0.9 * deviation);
  }
  return text;
}

std::vector<double> octaves() {
  std::vector<double> taus;
  for (double tau = 0.1; tau < 9000; tau *= 2) taus.push_back(tau);
  return taus;
}

class CurveTables : public testing::Test {
 protected:
  Outcome calibrate(const std::string& text, const std::string& options) {
    return gyrobudget_run("calibrate --curve '" + scratch_.file("adev.csv", text) + "' " + options);
  }
  Scratch scratch_;
};

TEST_F(CurveTables, GiveTheCoefficientsTheyWereMadeOf) {
  const auto json = json_of(calibrate(table(octaves()), "--rate 100 --duration 10h --terms N,K --json"));
  ASSERT_EQ(json["axes"].size(), 1U);  // limits are no deviations
  EXPECT_EQ(json["record"]["samples"], 3600000);
  const auto& parameters = json["axes"][0]["parameters"];
  constexpr double kAsymptotes = 5e-3;
  EXPECT_NEAR(parameters["arw"]["value"].get<double>() / kArw, 1, kAsymptotes);
  EXPECT_NEAR(parameters["rrw"]["value"].get<double>() / kRrw, 1, kAsymptotes);
  EXPECT_EQ(json["axes"][0]["fit"]["verdict"], "described");
}

TEST_F(CurveTables, LongerRecordsKnowMore) {
  const auto spread = [&](const std::string& duration) {
    const auto json = json_of(calibrate(table(octaves()), "--rate 100 --terms N,K --json --duration " + duration));
    return json["axes"][0]["parameters"]["rrw"]["relative_std"].get<double>();
  };
  EXPECT_LT(spread("40h"), spread("10h"));
}

TEST_F(CurveTables, TakeTausAsTheyArePrinted) {
  std::vector<double> taus = octaves();
  for (double& tau : taus) tau *= 1.0001;  // rounded somewhere on the way
  EXPECT_EQ(calibrate(table(taus), "--rate 100 --duration 10h --terms N,K").exit_code, 0);
}

TEST_F(CurveTables, RefuseTausThatAreNoWholeNumberOfSamples) {
  const Outcome run = calibrate(table({0.1, 0.2, 0.4, 0.0333 * 25, 1.6, 3.2}), "--rate 10 --duration 10h");
  EXPECT_EQ(run.exit_code, kBadInput);
  for (const char* part : {"adev.csv", "tau = 0.8325 s", "whole number of samples at 10 Hz", "--rate"}) {
    EXPECT_NE(run.err.find(part), std::string::npos) << part << " is not in: " << run.err;
  }
  EXPECT_EQ(run.out, "");
}

TEST_F(CurveTables, NeedTheRecordBehindThem) {
  for (const char* options : {"", "--rate 100", "--duration 10h"}) {
    const Outcome run = calibrate(table(octaves()), options);
    EXPECT_EQ(run.exit_code, kUsage) << options;
    EXPECT_NE(run.err.find("--rate and --duration"), std::string::npos) << run.err;
  }
}

TEST_F(CurveTables, RefuseWhatIsAboutLogs) {
  for (const char* option : {"--strict-gaps", "--ieee", "--scale 2", "--input angle"}) {
    const Outcome run = calibrate(table(octaves()), std::string("--rate 100 --duration 10h ") + option);
    EXPECT_EQ(run.exit_code, kUsage) << option;
  }
}

// --- Missing samples ------------------------------------------------------------------------------------------------

constexpr int kRows = 1000;

/// The cells of a log at 10 Hz, to be changed.
std::vector<std::string> cells() {
  std::vector<std::string> result;
  unsigned state = 1;
  for (int i = 0; i < kRows; ++i) {
    state = state * 1664525U + 1013904223U;
    result.push_back(fmt::format("{:.6f}", state / 4294967296.0 - 0.5));
  }
  return result;
}

std::string log_of(const std::vector<std::string>& cells, int repeated_stamp = -1) {
  std::string text = "time (s),gyro_x (deg/h)\n";
  for (int i = 0; i < kRows; ++i) {
    text += fmt::format("{:.1f},{}\n", 0.1 * (i == repeated_stamp ? i - 1 : i), cells[static_cast<std::size_t>(i)]);
  }
  return text;
}

TEST(MissingSamples, NanInfAndEmptyCellsAreCountedAndSaid) {
  std::vector<std::string> holed = cells();
  holed[100] = "nan";
  holed[200] = "inf";
  holed[300] = "-Inf";
  holed[400] = "";
  const Scratch scratch;
  const std::string path = scratch.file("log.csv", log_of(holed));
  const auto json = json_of(gyrobudget_run("allan '" + path + "' --json --taus octave"));
  EXPECT_EQ(json["record"]["samples"], kRows);
  EXPECT_EQ(json["record"]["missing_samples"], 4);
  const Outcome text = gyrobudget_run("allan '" + path + "'");
  EXPECT_NE(text.out.find("4 missing (0.40 %)"), std::string::npos) << text.out;
  EXPECT_EQ(text.out.find("nan"), std::string::npos) << text.out;
}

TEST(MissingSamples, ARepeatedStampMasksItsPointAndLeavesAGap) {
  const Scratch scratch;
  const std::string path = scratch.file("log.csv", log_of(cells(), 500));
  const Outcome run = gyrobudget_run("allan '" + path + "' --json --taus octave");
  const auto json = json_of(run);
  EXPECT_EQ(json["record"]["samples"], kRows);
  EXPECT_EQ(json["record"]["missing_samples"], 2);  // the point of two samples, and the point of none
  const std::string notes = json["notes"].dump();
  EXPECT_NE(notes.find("1 repeated time stamp (the first in line 502)"), std::string::npos) << notes;
  EXPECT_NE(notes.find("1 gap in time"), std::string::npos) << notes;
  EXPECT_NE(run.err.find("repeated time stamp"), std::string::npos) << run.err;
}

TEST(MissingSamples, StrictGapsWantEverySampleOfACluster) {
  std::vector<std::string> holed = cells();
  holed[kRows / 2] = "nan";
  const Scratch scratch;
  const std::string line = "allan '" + scratch.file("log.csv", log_of(holed)) + "' --json --taus octave";
  const auto usual = json_of(gyrobudget_run(line)), strict = json_of(gyrobudget_run(line + " --strict-gaps"));
  // A term needs 2m samples in a row: one missing in the middle takes 2m of the n - 2m + 1. With 95 % of a cluster
  // being enough, clusters of 20 and more do without it.
  const auto &a = usual["axes"][0]["points"], &b = strict["axes"][0]["points"];
  ASSERT_EQ(a.size(), 9U);  // m = 1 ... 256
  for (std::size_t i = 0; i < a.size(); ++i) {
    const int m = 1 << i, whole = kRows - 2 * m + 1;
    EXPECT_EQ(a[i]["terms"], m >= 20 ? whole : whole - 2 * m) << m;
  }
  for (const auto& point : b) {
    const int m = point["m"];
    EXPECT_EQ(point["terms"], kRows - 4 * m + 1) << m;
  }
}

}  // namespace
}  // namespace gyrobudget::tests

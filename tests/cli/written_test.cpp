// SPDX-License-Identifier: MIT
// What is written on: sensor files of calibrate, Kalibr's, files of others, and what a file does not state.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using json = nlohmann::json;

const std::string kMems = GYROBUDGET_EXAMPLES "/sensors/mems.yaml";
constexpr int kDone = 0, kNoAnswer = 1, kUsage = 2, kNotWritten = 4;

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

std::size_t count(const std::string& text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

// Comments of a file, each sentence in one line.
std::string unwrapped(std::string text) {
  for (std::size_t at = 0; (at = text.find("\n#   ", at)) != std::string::npos;) {
    const std::size_t end = text.find_first_not_of(' ', at + 2);
    if (text[end] == '-')
      at = end;
    else
      text.replace(at, end - at, " ");
  }
  return text;
}

// A log of two hours of a MEMS gyro at 10 Hz: as it is; with an axis three times worse; with a step in x.
class Written : public testing::Test {
 protected:
  Written() {
    EXPECT_EQ(gyrobudget_run("simulate " + kMems + " --duration 2h --rate 10 --seed 4 -o " + log("clean")).exit_code,
              0);
    changed("worse", "$4 *= 3");
    changed("step", "if (i > 30000) $2 += 6e-5");
  }
  [[nodiscard]] std::string log(const std::string& name) const { return path(name + ".csv"); }
  [[nodiscard]] std::string path(const std::string& name) const { return scratch_.path(name); }
  [[nodiscard]] std::string file(const std::string& name, std::string_view text) const {
    return scratch_.file(name, text);
  }
  [[nodiscard]] Outcome calibrate(const std::string& name, const std::string& options) const {
    return gyrobudget_run("calibrate " + log(name) + " " + options);
  }

 private:
  void changed(const std::string& name, const std::string& by) const {
    EXPECT_EQ(
        shell("awk -F, -v OFS=, -v CONVFMT=%.17g '/^[0-9-]/ {i++; " + by + "} 1' " + log("clean") + " > " + log(name))
            .exit_code,
        0);
  }
  Scratch scratch_;
};

// --- Axes ------------------------------------------------------------------------------------------------------------

TEST_F(Written, AxesThatDifferAreWrittenAxisByAxisAndSimulatedSo) {
  ASSERT_EQ(calibrate("worse", "-o " + path("s.yaml")).exit_code, kDone);
  const std::string text = read(path("s.yaml"));
  EXPECT_EQ(count(text, "\n  arw: ["), 1U) << text;
  EXPECT_EQ(count(text, "Axes differ by more than their scatter"), 1U) << text;
  ASSERT_EQ(calibrate("clean", "-o " + path("alike.yaml")).exit_code, kDone);
  EXPECT_EQ(count(read(path("alike.yaml")), "\n  arw: 0.1"), 1U) << read(path("alike.yaml"));
  EXPECT_EQ(count(read(path("alike.yaml")), "Axes differ"), 0U);

  // From the file back to a log: z has three times the noise of x. N of 72 000 samples is known to 0.27 %; 7 of those.
  ASSERT_EQ(
      gyrobudget_run("simulate " + path("s.yaml") + " --duration 2h --rate 10 --seed 9 -o " + log("again")).exit_code,
      0);
  const auto axes = parsed<json>(calibrate("again", "--json").out)["axes"];
  const auto arw = [&](std::size_t i) { return axes[i]["parameters"]["arw"]["value"].get<double>(); };
  EXPECT_NEAR(arw(2) / arw(0), 3, 3 * 7 * 0.0027);
  EXPECT_NEAR(arw(1) / arw(0), 1, 7 * 0.0027);

  // plan says what each axis needs, and accuracy asks which is meant.
  const Outcome plan = gyrobudget_run("plan " + path("s.yaml") + " --want N=1%");
  EXPECT_EQ(count(plan.out, "Axis z:"), 1U) << plan.out;
  const auto planned = parsed<json>(gyrobudget_run("plan " + path("s.yaml") + " --want K=10% --json").out);
  ASSERT_GT(planned["axes"].size(), 1U);
  double longest = 0;
  for (const auto& axis : planned["axes"]) longest = std::max(longest, axis["answers"][0]["duration_s"].get<double>());
  EXPECT_EQ(planned["answers"][0]["duration_s"], longest);
  const std::string few = " --records 2 --duration 1h";
  EXPECT_NE(gyrobudget_run("accuracy " + path("s.yaml") + few).err.find("--axis gyro_x"), std::string::npos);
  EXPECT_EQ(gyrobudget_run("accuracy " + path("s.yaml") + few + " --axis gyro_z").exit_code, kDone);
}

// --- Warnings --------------------------------------------------------------------------------------------------------

TEST_F(Written, NumbersThatMayNotBeUsedYetEndInOneAndWarnInTheFile) {
  const Outcome spoilt = calibrate("step", "-o " + path("s.yaml") + " --kalibr " + path("k.yaml"));
  EXPECT_EQ(spoilt.exit_code, kNoAnswer);
  const std::string_view why = "do not use these numbers yet: gyro_x holds steps that the fit took for noise";
  EXPECT_EQ(count(spoilt.err, why), 1U) << spoilt.err;
  const std::string text = read(path("s.yaml"));
  EXPECT_EQ(text.rfind("# WARNING: do not use these numbers yet: gyro_x", 0), 0U) << text;
  EXPECT_EQ(count(text, "The mean jumps by"), 1U) << text;  // what was found, with its time and size
  EXPECT_EQ(count(text, "\nwarning:\n  - "), 1U) << text;
  EXPECT_EQ(read(path("k.yaml")).rfind("# WARNING: do not use", 0), 0U);
  // Whoever reads the file says it again.
  for (const std::string& verb : {std::string("plan "), "simulate --duration 10s -o " + path("x.csv") + " ",
                                  std::string("accuracy --records 2 --axis gyro_x ")}) {
    const Outcome run = gyrobudget_run(verb + path("s.yaml"));
    EXPECT_EQ(run.exit_code, kDone) << run.err;
    const std::string all = run.out + run.err;
    EXPECT_NE(all.find("warns: do not use"), std::string::npos) << verb << all;
  }
  // Masked, it is an answer, and the file that warns is overwritten by one that does not.
  const Outcome masked = calibrate("step", "--mask steps -o " + path("s.yaml"));
  EXPECT_EQ(masked.exit_code, kDone) << masked.err;
  EXPECT_EQ(count(read(path("s.yaml")), "WARNING"), 0U);
  EXPECT_EQ(count(read(path("s.yaml")), "warning:"), 0U);
}

TEST_F(Written, SeveralRecordsAreSpoiltByOne) {
  const Outcome run = gyrobudget_run("calibrate " + log("clean") + " " + log("step") + " -o " + path("type.yaml"));
  EXPECT_EQ(run.exit_code, kNoAnswer);
  EXPECT_NE(run.err.find("gyro_x holds steps"), std::string::npos) << run.err;
  EXPECT_EQ(read(path("type.yaml")).rfind("# WARNING: ", 0), 0U);
}

TEST_F(Written, WhatIsNotDescribedIsSaidInTheFile) {
  // A saw of 1 mrad/s in z is of no shape that the terms have.
  ASSERT_EQ(shell("awk -F, -v OFS=, -v CONVFMT=%.17g '/^[0-9-]/ {i++; $4 += 1e-3 * ((i % 400) / 200 - 1)} 1' " +
                  log("clean") + " > " + log("saw"))
                .exit_code,
            0);
  EXPECT_EQ(calibrate("saw", "-o " + path("s.yaml")).exit_code, kNoAnswer);
  const std::string text = unwrapped(read(path("s.yaml")));
  EXPECT_EQ(count(text, "gyro_z: not described by the model"), 1U) << text;
  EXPECT_EQ(count(text, "it is not written"), 1U) << text;
  EXPECT_EQ(count(text, "The record tells nothing of gyro z"), 1U) << text;
}

// --- Files that are there already ----------------------------------------------------------------------------------

TEST_F(Written, AFileThatHoldsMoreIsUpdatedAndNotOverwritten) {
  const std::string by_hand =
      "# bought in 2019\nname: bench\ngyro:\n  turn_on_bias: 5 deg/h  # of the maker\n  arw: 1 deg/sqrt(h)\n"
      "  range: 400 deg/s\naccelerometer: {vrw: 0.05 m/s/sqrt(h)}\n";
  const std::string sensor = file("s.yaml", by_hand);
  const Outcome refused = calibrate("clean", "-o " + sensor);
  EXPECT_EQ(refused.exit_code, kNotWritten);
  EXPECT_NE(refused.err.find("gyro.turn_on_bias and gyro.range"), std::string::npos) << refused.err;
  EXPECT_NE(refused.err.find("--update"), std::string::npos) << refused.err;
  EXPECT_EQ(read(sensor), by_hand);
  EXPECT_EQ(refused.out, "");  // before any work

  EXPECT_EQ(calibrate("clean", "--update -o " + sensor).exit_code, kDone);
  const std::string text = read(sensor);
  for (const std::string_view kept : {"# bought in 2019\n", "name: bench\n", "turn_on_bias: 5 deg/h  # of the maker\n",
                                      "range: 400 deg/s\n", "accelerometer: {vrw: 0.05 m/s/sqrt(h)}\n"})
    EXPECT_EQ(count(text, kept), 1U) << kept << text;
  EXPECT_EQ(count(text, "\n  arw: 0.1"), 1U) << text;
  EXPECT_EQ(count(text, "Fitted by:"), 1U) << text;
  // What the file states is not among what it does not: of the gyro the turn-on bias, of the accelerometer nothing.
  EXPECT_EQ(count(text, "gyro.turn_on_bias"), 0U) << text;
  EXPECT_EQ(count(text, "accelerometer.turn_on_bias"), 1U) << text;
  EXPECT_EQ(calibrate("clean", "--update -o " + sensor + " --name other").exit_code, kDone);
  EXPECT_EQ(count(read(sensor), "Fitted by:"), 1U) << read(sensor);
  EXPECT_EQ(count(read(sensor), "name: \"other\"\n"), 1U) << read(sensor);

  // What is not there is made, what is no sensor file is left alone, and --update without a file is a mistake.
  EXPECT_EQ(calibrate("clean", "--update -o " + path("new.yaml")).exit_code, kDone);
  EXPECT_EQ(calibrate("clean", "-o " + path("new.yaml")).exit_code, kDone);
  const std::string notes = file("notes.txt", "buy milk\n");
  EXPECT_EQ(calibrate("clean", "-o " + notes).exit_code, kNotWritten);
  EXPECT_EQ(read(notes), "buy milk\n");
  EXPECT_EQ(calibrate("clean", "--update").exit_code, kUsage);
}

// An accelerometer's log says nothing of the gyro that stands in the file.
TEST_F(Written, ALogOfOneTriadDoesNotReplaceTheOther) {
  EXPECT_EQ(
      shell("sed 's/gyro_\\(.\\) (rad.s)/accel_\\1 (m\\/s^2)/g' " + log("clean") + " > " + log("accel")).exit_code, 0);
  const std::string sensor = file("s.yaml", "gyro: {arw: 1 deg/sqrt(h), rrw: 2 deg/h/sqrt(h)}\n");
  EXPECT_EQ(calibrate("accel", "-o " + sensor).exit_code, kNotWritten);
  EXPECT_EQ(calibrate("accel", "--update -o " + sensor).exit_code, kDone);
  EXPECT_EQ(count(read(sensor), "gyro: {arw: 1 deg/sqrt(h), rrw: 2 deg/h/sqrt(h)}\n"), 1U) << read(sensor);
  EXPECT_EQ(count(read(sensor), "\naccelerometer:\n  vrw: "), 1U) << read(sensor);
}

// --- Kalibr, VINS --------------------------------------------------------------------------------------------------

TEST_F(Written, KalibrsWalkIsNeverZero) {
  // 200 s of white noise: neither flicker nor walk is resolved, so the limit stands there.
  const std::string white = file("white.yaml", "gyro: {arw: 0.15 deg/sqrt(h)}\n");
  ASSERT_EQ(gyrobudget_run("simulate " + white + " --duration 200s --rate 10 --seed 2 -o " + log("white")).exit_code,
            0);
  EXPECT_EQ(calibrate("white", "--kalibr " + path("k.yaml")).exit_code, kDone);
  std::string text = read(path("k.yaml"));
  EXPECT_EQ(count(text, "\ngyroscope_random_walk: 0 "), 0U) << text;
  EXPECT_EQ(count(text, "this is its 95 % limit"), 1U) << text;
  // Flicker without a walk: what stands for it, over the horizon that was asked for.
  const std::string flicker = file("flicker.yaml", "gyro: {arw: 1e-3 deg/sqrt(h), bias_instability: 1 deg/h}\n");
  ASSERT_EQ(gyrobudget_run("simulate " + flicker + " --duration 1h --rate 10 --seed 2 -o " + log("flicker")).exit_code,
            0);
  EXPECT_EQ(calibrate("flicker", "--terms N,B --kalibr " + path("k.yaml") + " --kalibr-horizon 30s").exit_code, kDone);
  text = read(path("k.yaml"));
  EXPECT_EQ(count(text, "\ngyroscope_random_walk: 0 "), 0U) << text;
  EXPECT_EQ(count(text, "stands for the bias instability of"), 1U) << text;
  EXPECT_EQ(count(text, "T = 30 s"), 1U) << text;
}

TEST_F(Written, FilesOfVinsAreReadWithARateOrBothReadingsAreSaid) {
  const std::string vins = file("vins.yaml", "%YAML:1.0\nacc_n: 0.08\ngyr_n: 0.004\nacc_w: 0.00004\ngyr_w: 2.0e-6\n");
  const Outcome with = gyrobudget_run("plan " + vins + " --duration 1h --rate 200");
  EXPECT_NE(with.out.find("0.972 deg/sqrt(h)"), std::string::npos) << with.out;
  const Outcome without = gyrobudget_run("plan " + vins + " --duration 1h");
  EXPECT_NE(without.out.find("read as densities"), std::string::npos) << without.out;
  EXPECT_NE(without.out.find("0.972 deg/sqrt(h) at 200 Hz"), std::string::npos) << without.out;
  const auto notes = parsed<json>(gyrobudget_run("plan " + vins + " --duration 1h --json").out)["notes"];
  EXPECT_EQ(notes.size(), 1U);
  // In a scene the rate stands beside the file.
  const auto budget = [&](const std::string& sensor) {
    const std::string scene = file("scene.yaml", "site: alcantara\ntrajectory: ascent\nsensor: " + sensor + "\n");
    return parsed<json>(gyrobudget_run("budget " + scene + " --json").out);
  };
  const auto rss = [](const json& found) { return found["total"]["position_m"]["rss"].get<double>(); };
  const json densities = budget("vins.yaml"), samples = budget("{rate: 200 Hz, file: vins.yaml}");
  EXPECT_NEAR(rss(densities) / rss(samples), std::sqrt(200.0), 0.01 * std::sqrt(200.0));  // steps of the covariance
  EXPECT_NE(samples["notes"].dump().find("sigmas of a sample at 200 Hz"), std::string::npos);
}

// --- What a file does not state ------------------------------------------------------------------------------------

TEST_F(Written, BudgetFlyAndNavigateSayWhatTheSensorFileDoesNotState) {
  const std::string_view all =
      "no turn-on bias, no scale factor, no misalignment and no g-sensitivity of the gyro, and no accelerometer at all";
  const auto flat = [](std::string text) {  // lines of a paragraph as one
    std::string out;
    for (const char c : text)
      if (c != '\n' && (c != ' ' || (!out.empty() && out.back() != ' ')))
        out += c;
      else if (c == '\n' && !out.empty() && out.back() != ' ')
        out += ' ';
    return out;
  };
  (void)file("gyro.yaml", "gyro: {arw: 0.15 deg/sqrt(h)}\n");
  (void)file("whole.yaml",
             "gyro:\n  arw: 0.15 deg/sqrt(h)\n  turn_on_bias: 1 deg/h\n  scale_factor: 0 ppm\n"
             "  misalignment: 0 arcsec\n  g_sensitivity: 0 deg/h/g\naccelerometer: ideal\n");
  const json names = {"gyro.turn_on_bias", "gyro.scale_factor", "gyro.misalignment", "gyro.g_sensitivity",
                      "accelerometer"};
  struct Verb {
    std::string name, scene;
  };
  const std::string vehicle = GYROBUDGET_EXAMPLES "/vehicles/vlm1.yaml";
  std::ostringstream log;
  log << "time (s),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (m/s^2),accel_y (m/s^2),accel_z (m/s^2)\n";
  for (int k = 0; k <= 200; ++k) log << 0.1 * k << ",7.292115e-5,0,0,0,0,-9.7803253359\n";
  (void)file("imu.csv", log.str());
  const Verb verbs[] = {
      {"budget", "site: alcantara\ntrajectory: ascent\n"},
      {"fly", "site: alcantara\nflight:\n  vehicle: " + vehicle + "\n"},
      {"navigate",
       "site: {latitude: 0 deg, longitude: 0 deg, height: 0 m}\nimu: {file: imu.csv}\n"
       "alignment: {position_sigma: 1 m, velocity_sigma: 1 cm/s, attitude: {heading: 0 deg}, level_sigma: 0.1 deg, heading_sigma: 1 deg}\n"}};
  for (const Verb& verb : verbs) {
    const auto run = [&](const std::string& sensor, const std::string& options) {
      const Outcome outcome = gyrobudget_run(
          verb.name + " " + file(verb.name + ".yaml", verb.scene + "sensor: " + sensor + "\n") + " " + options);
      EXPECT_EQ(outcome.exit_code, kDone) << verb.name << outcome.err;
      return outcome;
    };
    const std::string page = path(verb.name + ".html");
    EXPECT_EQ(count(flat(run("gyro.yaml", "--report " + page).out), all), 1U) << run("gyro.yaml", "").out;
    EXPECT_GE(count(flat(read(page)), all), 1U) << verb.name;
    EXPECT_EQ(parsed<json>(run("gyro.yaml", "--json").out)["not_stated"], names) << verb.name;
    EXPECT_EQ(count(run("whole.yaml", "").out, "The sensor file states"), 0U) << verb.name;
    EXPECT_EQ(parsed<json>(run("whole.yaml", "--json").out)["not_stated"], json::array()) << verb.name;
    EXPECT_EQ(parsed<json>(run("ideal", "--json").out)["not_stated"], json::array()) << verb.name;
  }
}

}  // namespace
}  // namespace gyrobudget::tests

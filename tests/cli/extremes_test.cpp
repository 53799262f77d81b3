// SPDX-License-Identifier: MIT
// Records of extreme scale, length and kind through the whole program: an answer or a verdict, no NaN.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using Json = nlohmann::json;
using Numbers = std::vector<double>;

constexpr std::size_t kSamples = 4099;  // a prime

Numbers white(std::size_t samples = kSamples) {
  std::mt19937_64 bits(1);
  std::normal_distribution<double> normal;
  Numbers x(samples);
  for (double& v : x) v = normal(bits);
  return x;
}

Numbers with(Numbers x, const std::function<double(double)>& f) {
  std::transform(x.begin(), x.end(), x.begin(), f);
  return x;
}

Numbers walk() {
  Numbers x = white();
  double sum = 0;
  for (double& v : x) v = sum += v;
  return x;
}

Outcome run(const Numbers& x, const std::string& options = "") {
  const Scratch scratch;
  std::string text = "w (rad/s)\n";
  for (const double v : x) text += fmt::format("{}\n", v);
  return gyrobudget_run("calibrate --json --rate 10 " + options + " " + scratch.file("log.csv", text));
}

// One JSON object whose numbers are all numbers. JSON has no NaN: it would be null where the schema promises a number.
Json axis_of(const Outcome& outcome) {
  const Json document = parsed<Json>(outcome.out);
  EXPECT_FALSE(document.is_discarded()) << outcome.out << outcome.err;
  if (document.is_discarded()) return {};
  const Json axis = document["axes"][0];
  EXPECT_TRUE(axis["mean"].is_number());
  for (const auto& [name, p] : axis["parameters"].items()) {
    if (!p["fitted"].get<bool>() || p["status"] == "not_quotable") continue;
    EXPECT_TRUE(p["value"].is_number() && p["lower"].is_number()) << name << p;
    EXPECT_LE(p["lower"].get<double>(), p["value"].get<double>() * (1 + 1e-12)) << name << p;
  }
  EXPECT_TRUE(axis["fit"]["verdict"].is_string());
  return axis;
}

const std::vector<std::string> kWays{"", "--method whittle --terms N,B,K", "--cross-check", "--terms auto",
                                     "--terms N,G,S"};

double si(const Json& axis, const std::string& key) { return axis["parameters"][key]["si"]["value"].get<double>(); }

// Of white noise of standard deviation 1 at 10 Hz, N = sqrt(0.1), known to 1/sqrt(2 n) = 1.1 %; 4 sigma. With G beside
// it the two share the shortest taus: 3 times that.
void expect_white(const Outcome& outcome, double factor, const std::string& way) {
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json axis = axis_of(outcome);
  const double tolerance = (way.find('G') == std::string::npos ? 4 : 12) / std::sqrt(2.0 * kSamples);
  EXPECT_NEAR(si(axis, "arw") / (std::sqrt(0.1) * factor), 1, tolerance) << way;
  EXPECT_EQ(axis["parameters"]["arw"]["status"], "identified") << way;
}

TEST(Extremes, WhiteNoiseAlone) {
  for (const auto& way : kWays) expect_white(run(white(), way), 1, way);
}

TEST(Extremes, AConstantABillionTimesTheNoise) {
  const auto x = with(white(), [](double v) { return 1e9 + v; });
  for (const auto& way : kWays) expect_white(run(x, way), 1, way);
}

TEST(Extremes, RandomWalkAlone) {
  // K = 1 per sample is sqrt(10) per root second, known to 1/sqrt(2 n).
  for (const std::string way : {"", "--method whittle", "--terms auto"}) {
    const auto outcome = run(walk(), way);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    const Json axis = axis_of(outcome);
    EXPECT_NEAR(si(axis, "rrw") / std::sqrt(10.0), 1, 5 / std::sqrt(2.0 * kSamples)) << way;
    EXPECT_NE(axis["parameters"]["arw"]["status"], "identified") << way;
  }
}

TEST(Extremes, FiveLevels) {
  // Rounding to whole sigmas and clipping at two leave the standard deviation at 1.02.
  const auto x = with(white(), [](double v) { return 0.01 * std::clamp(std::round(v), -2.0, 2.0); });
  for (const auto& way : kWays) expect_white(run(x, way), 0.0102, way);
}

TEST(Extremes, FewSamples) {
  for (const auto& way : kWays) {
    const auto outcome = run(white(16), way);
    EXPECT_EQ(outcome.exit_code, 1) << way << outcome.err;
    axis_of(outcome);
    EXPECT_EQ(run(white(15), way).exit_code, 3) << way;
  }
}

TEST(Extremes, ScaledUnitsGiveTheSameStatusesAndValues) {
  for (const auto& way : kWays) {
    const Json one = axis_of(run(white(), way));
    for (const double scale : {1e-12, 1e12}) {
      const Json other = axis_of(run(with(white(), [=](double v) { return scale * v; }), way));
      EXPECT_EQ(one["fit"]["verdict"], other["fit"]["verdict"]);
      for (const auto& [name, p] : one["parameters"].items()) {
        const Json& q = other["parameters"][name];
        EXPECT_EQ(p["status"], q["status"]) << way << name;
        if (!p["fitted"].get<bool>()) continue;
        // Scaled samples are rounded once more: 1e-16 each.
        constexpr double kRelative = 1e-10;
        const double upper = p["upper"].get<double>();
        EXPECT_NEAR(p["value"].get<double>(), q["value"].get<double>() / scale, kRelative * upper) << way << name;
        EXPECT_NEAR(upper, q["upper"].get<double>() / scale, kRelative * upper) << way << name;
      }
    }
  }
}

TEST(Extremes, SilenceHasNoAnswerAndNulls) {
  for (const auto& way : kWays) {
    const auto outcome = run(Numbers(5000, 1.25), way);
    EXPECT_EQ(outcome.exit_code, 1) << way << outcome.err;
    const Json axis = axis_of(outcome);
    EXPECT_TRUE(axis["parameters"]["arw"]["value"].is_null()) << way;
    EXPECT_NE(axis["advice"][0].get<std::string>().find("is equal"), std::string::npos) << way;
  }
}

TEST(Extremes, SquaresOutsideDoubleAreRefusedByName) {
  for (const double scale : {1e-310, 1e-200, 1e200, 1e307}) {
    for (const auto& way : kWays) {
      const auto outcome = run(with(white(), [=](double v) { return scale * v; }), way);
      EXPECT_EQ(outcome.exit_code, 3) << scale << way << outcome.err;
      EXPECT_NE(outcome.err.find("column 'w'"), std::string::npos) << outcome.err;
      EXPECT_TRUE(outcome.out.empty());
    }
  }
}

// No noise at all, but not silent: alternation, one spike, a straight line. A verdict, and no endless loop.
TEST(Extremes, RecordsThatAreNoNoise) {
  Numbers alternating(kSamples), spike(kSamples), line(kSamples);
  for (std::size_t i = 0; i < kSamples; ++i)
    alternating[i] = static_cast<double>(i % 2), line[i] = static_cast<double>(i);
  spike[2000] = 1;
  for (const auto& x : {alternating, spike, line}) {
    for (const auto& way : kWays) {
      const auto outcome = run(x, way);
      EXPECT_LE(outcome.exit_code, 1) << way << outcome.err;
      axis_of(outcome);
    }
  }
}

}  // namespace
}  // namespace gyrobudget::tests

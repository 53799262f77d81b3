// SPDX-License-Identifier: MIT
// The table of docs/accuracy-on-real-logs.md in small: what calibrate() makes of records behind filters, rounded, held,
// with gaps, outliers, a warm-up and a knock. Either the intervals hold, or the record is refused.
#include "gyrobudget/estimation/calibration/accuracy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace gyrobudget::calibration {
namespace {

using noise::FrontEnd;
using noise::Recorder;
using noise::Term;
using Kind = FrontEnd::Kind;

// A MEMS gyro at 100 Hz: the paper's [rad/s/sqrt(Hz), rad/s, rad/s/sqrt(s)].
const std::vector<noise::Process> kMems{noise::White{4.36e-5}, noise::Flicker{3.39e-6}, noise::RateRandomWalk{3.49e-7}};
constexpr double kDt = 0.01;
constexpr std::int64_t kSamples = 20'000;
constexpr int kRecords = 24;

struct Case {
  std::string name;
  Recorder recorder;
  Masking mask = {};
  double refused = 0.1;  // share of records at most
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

std::vector<Case> cases() {
  return {
      {"first_order", {.front_end = FrontEnd{Kind::first_order, 3}}},
      {"second_order", {.front_end = FrontEnd{Kind::second_order, 3}}},
      {"moving_average", {.front_end = FrontEnd{Kind::moving_average, noise::kMovingAverageWidth / 16 / kDt}}},
      {"decimation", {.front_end = FrontEnd{Kind::second_order, 40}, .decimation = 4}},
      {"decimation_by_three", {.front_end = FrontEnd{Kind::first_order, 20}, .decimation = 3}},
      {"rounding_small", {.rounding = 0.3}},
      {"rounding_sigma", {.rounding = 1}},
      {"rounding_above_the_noise", {.rounding = 3}, {}, 1},
      {"held_each_second", {.held = 2}},
      {"held_each_third", {.held = 3}},
      {"gaps", {.gaps = 0.02}},
      {"outliers_masked", {.outliers = 0.001}, {.outliers = true}},
      {"many_outliers_masked", {.outliers = 0.01}, {.outliers = true}},
      {"outliers_left_in", {.outliers = 0.02}, {}, 1},
      {"warm_up_masked", {.warm_up = 3}, {.warm_up = true}},
      {"knock_masked", {.knock = 30}, {.motion = true}, 0.4},  // its ends are below what is seen as motion
  };
}

class RecordedAccuracy : public testing::TestWithParam<Case> {};

// Of 24 records whose 95 % intervals hold, fewer than 18 do so in 1 of 7800; numbers that are refused are not wrong.
TEST_P(RecordedAccuracy, IntervalsHoldOrTheRecordIsRefused) {
  constexpr double kFewest = 0.75;
  const auto accuracy =
      measure_accuracy(kMems, GetParam().recorder,
                       {.samples = kSamples, .dt = kDt, .records = kRecords, .seed = 7, .methods = {fit::Method::gls}},
                       {.mask = GetParam().mask});
  ASSERT_TRUE(accuracy.complete);
  const auto& n = accuracy.methods.front().coefficients.front();
  ASSERT_EQ(n.term, Term::white);
  EXPECT_LE(n.refused, GetParam().refused);
  if (n.refused < 1) {
    EXPECT_GE(n.coverage_answered, kFewest) << "of " << n.truth << ", bias " << n.bias;
  }
}

INSTANTIATE_TEST_SUITE_P(Recorders, RecordedAccuracy, testing::ValuesIn(cases()),
                         [](const auto& one) { return one.param.name; });

TEST(RecordedAccuracy, ARecordThatIsTooShortIsRefusedAndNotCounted) {
  const auto accuracy = measure_accuracy(kMems, {.gaps = 0.9}, {.samples = 40, .dt = kDt, .records = 5});
  for (const auto& method : accuracy.methods) {
    for (const auto& c : method.coefficients) {
      EXPECT_EQ(c.refused, 1);
      EXPECT_TRUE(std::isnan(c.coverage_answered));
    }
  }
}

TEST(RecordedAccuracy, RefusesWhatNoRecorderDoes) {
  EXPECT_THROW((void)measure_accuracy(kMems, {.gaps = 1}), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::calibration

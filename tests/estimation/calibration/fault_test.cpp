// SPDX-License-Identifier: MIT
// Faults of one stage of one axis: everything else stands.
#include "gyrobudget/estimation/calibration/detail/stages.h"
#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "../fit/sensors.h"
#include "records.h"

namespace gyrobudget::tests {
namespace {

using calibration::AxisDatasheet;
using calibration::Datasheet;
using calibration::Stage;
using noise::Term;

constexpr std::int64_t kSamples = 6000;
const std::string kFaulty = "gyro_y";
const std::string kMessage = "put there by a test";

allan::Record three_gyros() {
  return allan::make_record({gyro_axis(mems_rates(kSamples, 1)), gyro_axis(mems_rates(kSamples, 2), kFaulty),
                             gyro_axis(mems_rates(kSamples, 3), "gyro_z")},
                            kRecordRate);
}

void expect_same_fit(const AxisDatasheet& a, const AxisDatasheet& b) {
  ASSERT_EQ(a.fit.coefficients.size(), b.fit.coefficients.size());
  for (std::size_t i = 0; i < a.fit.coefficients.size(); ++i) {
    EXPECT_EQ(a.fit.coefficients[i].value, b.fit.coefficients[i].value);
    EXPECT_EQ(a.fit.coefficients[i].upper, b.fit.coefficients[i].upper);
  }
}

class FaultyStage : public testing::TestWithParam<Stage> {};

TEST_P(FaultyStage, LeavesTheOtherStagesAndAxes) {
  auto record = three_gyros();
  if (GetParam() == Stage::temperature)  // which the sensors do not follow: nothing is taken off
    for (std::int64_t i = 0; i < kSamples; ++i)
      record.temperature.push_back(20 + 5 * std::sin(1e-3 * static_cast<double>(i)));
  calibration::Options options;
  options.cross_check = true;
  options.choose_terms = GetParam() == Stage::choice;
  const Datasheet whole = calibration::calibrate(record, options);
  const Datasheet sheet = calibration::detail::calibrate(record, options, [](Stage stage, const std::string& axis) {
    if (stage == GetParam() && axis == kFaulty) throw std::runtime_error(kMessage);
  });
  ASSERT_EQ(sheet.axes.size(), 3U);
  for (const std::size_t i : {0U, 2U}) {
    expect_same_fit(sheet.axes[i], whole.axes[i]);
    EXPECT_EQ(sheet.axes[i].points.size(), whole.axes[i].points.size());
    EXPECT_TRUE(sheet.axes[i].faults.empty());
  }
  const AxisDatasheet& faulty = sheet.axes[1];
  ASSERT_EQ(faulty.faults.size(), 1U);
  EXPECT_EQ(faulty.faults[0].stage, GetParam());
  EXPECT_EQ(faulty.faults[0].what, kMessage);
  EXPECT_FALSE(faulty.faults[0].reason);
  EXPECT_FALSE(sheet.is_complete());
  const bool takes_the_fit = GetParam() == Stage::curve || GetParam() == Stage::fit;
  EXPECT_EQ(faulty.is_fitted(), !takes_the_fit);
  EXPECT_EQ(faulty.has_answer(), !takes_the_fit);
  if (GetParam() == Stage::choice)
    EXPECT_EQ(faulty.fit.fitted_terms, (std::vector{Term::white, Term::flicker, Term::rate_random_walk}));
  else if (!takes_the_fit)
    expect_same_fit(faulty, whole.axes[1]);
  EXPECT_FALSE(faulty.temperature);
  EXPECT_EQ(whole.axes[1].temperature.has_value(), GetParam() == Stage::temperature);
  EXPECT_EQ(faulty.cross_checked.has_value(), !takes_the_fit && GetParam() != Stage::cross_check);
}

INSTANTIATE_TEST_SUITE_P(Every, FaultyStage,
                         testing::Values(Stage::screening, Stage::curve, Stage::choice, Stage::fit, Stage::departure,
                                         Stage::temperature, Stage::lines, Stage::intervals, Stage::cross_check,
                                         Stage::facts));

TEST(Faults, OfEveryAxisAreThrown) {
  const auto record = three_gyros();
  const auto fail = [](Stage stage, const std::string& axis) {
    if (stage == Stage::fit) throw std::runtime_error(axis);
  };
  try {
    (void)calibration::detail::calibrate(record, {}, fail);
    ADD_FAILURE() << "nothing was thrown";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "gyro_x") << "the first axis is named, whichever was first in time";
  }
}

TEST(Faults, AnUnusableColumnLeavesTheOthers) {
  auto record = three_gyros();
  for (std::size_t i = 0; i < record.axes[1].rate.size(); i += 3)
    record.axes[1].rate[i] = std::numeric_limits<double>::quiet_NaN();
  const Datasheet sheet = calibration::calibrate(record);
  EXPECT_TRUE(sheet.axes[0].has_answer());
  EXPECT_TRUE(sheet.axes[2].has_answer());
  ASSERT_EQ(sheet.axes[1].faults.size(), 1U);
  EXPECT_EQ(sheet.axes[1].faults[0].reason, calibration::Unusable::Reason::too_few_taus);
  EXPECT_FALSE(sheet.is_complete());
}

TEST(Faults, OfOneColumnOfATableLeaveTheOthers) {
  allan::DeviationTable table{.source = "table", .tau_s = {}, .columns = {{.name = "x", .deviation = {}}}};
  for (double tau = 0.1; tau < 2000; tau *= 2) {
    table.tau_s.push_back(tau);
    table.columns[0].deviation.push_back(1e-4 / std::sqrt(tau));
  }
  table.columns.push_back({.name = "y", .deviation = std::vector<double>(table.tau_s.size(), 1e200)});
  const Datasheet sheet = calibration::calibrate(table, kRecordRate, 36000);
  EXPECT_TRUE(sheet.axes[0].has_answer());
  EXPECT_FALSE(sheet.axes[1].has_answer());
}

// A line, beside which a walk shows or not, on three axes at once: terms chosen, asked for, and with advice.
TEST(Faults, ASinusoidHasItsDatasheetOnEveryAxis) {
  constexpr double kAmplitude = 8.7e-4, kFrequency = 1.37;  // [rad/s], [Hz]
  const noise::Process processes[] = {noise::White{5.5e-4}, noise::RateRandomWalk{9e-6},
                                      noise::Sinusoid{kAmplitude, kFrequency}};
  std::vector<allan::Axis> axes;
  for (std::uint64_t i = 0; i < 3; ++i)
    axes.push_back(gyro_axis(noise::generate_record(processes, 30000, 1 / kRecordRate, {.seed = 5, .stream = i}),
                             std::string("gyro_") + "xyz"[i]));
  const auto record = allan::make_record(std::move(axes), kRecordRate);
  calibration::Options chosen, given;
  chosen.choose_terms = true;
  given.terms = std::vector{Term::white, Term::rate_random_walk, Term::sinusoid};
  for (const auto& options : {chosen, given}) {
    for (const AxisDatasheet& axis : calibration::calibrate(record, options).axes) {
      EXPECT_TRUE(axis.faults.empty());
      EXPECT_TRUE(axis.has_answer());
      const auto& line = axis.fit[Term::sinusoid];
      EXPECT_EQ(line.status, fit::Status::identified);
      EXPECT_NEAR(line.shape, kFrequency, 1e-4);  // the record has 4e3 cycles; a tenth of one of them is 3e-5 Hz
    }
  }
}

// What the other terms cannot explain is there: a line, or a ramp, has no scatter that white noise could hide in.
TEST(Faults, WhiteNoiseIsIdentifiedBesideALineOrARamp) {
  constexpr double kWhite = 5.5e-4;
  const noise::Process line[] = {noise::White{kWhite}, noise::Sinusoid{8.7e-4, 1.37}};
  const noise::Process ramp[] = {noise::White{kWhite}, noise::RateRamp{2e-7}};
  const auto of = [&](std::span<const noise::Process> processes, calibration::Options options) {
    const auto record = allan::make_record(
        {gyro_axis(noise::generate_record(processes, 30000, 1 / kRecordRate, {.seed = 6, .stream = 0}))}, kRecordRate);
    return calibration::calibrate(record, options);
  };
  calibration::Options with_line, with_ramp, chosen;
  with_line.terms = std::vector{Term::white, Term::sinusoid};
  with_ramp.terms = std::vector{Term::white, Term::rate_ramp};
  chosen.choose_terms = true;
  for (const auto& sheet : {of(line, with_line), of(ramp, with_ramp), of(ramp, chosen)}) {
    const auto& white = sheet.axes[0].fit[Term::white];
    EXPECT_EQ(white.status, fit::Status::identified);
    EXPECT_GT(white.lower, 0.95 * kWhite);
    EXPECT_LT(white.upper, 1.05 * kWhite);
    EXPECT_TRUE(sheet.is_complete());
  }
}

// A hump in the spectrum that only the short taus know: the terms describe the rest.
TEST(LaterStart, IsOfferedWhereItHelps) {
  // Each reading takes back a part of the one before: correlated from sample to sample, white beyond, and no low pass.
  // Strong enough to fail the test and too weak for the whole curve's p-value to fall below the fit's own cut is what
  // no cut is made for: the first of these parts that fails.
  allan::Record record;
  calibration::Datasheet sheet;
  for (double part = 0.016; part < 0.04; part += 0.001) {
    auto rate = mems_rates(36000, 12);
    for (std::size_t i = 1; i < rate.size(); ++i) rate[i] -= part * rate[i - 1];
    record = allan::make_record({gyro_axis(std::move(rate))}, kRecordRate);
    sheet = calibration::calibrate(record);
    if (sheet.axes[0].fit.verdict != fit::Verdict::described) break;
  }
  const auto& axis = sheet.axes[0];
  ASSERT_NE(axis.fit.verdict, fit::Verdict::described);
  ASSERT_TRUE(axis.facts.later);
  calibration::Options later;
  later.tau_min_s = axis.facts.later->tau_min_s;
  EXPECT_GT(*later.tau_min_s, axis.fit.tau_min_s);
  const auto there = calibration::calibrate(record, later);
  EXPECT_EQ(there.axes[0].fit.verdict, fit::Verdict::described);
  EXPECT_EQ(there.axes[0].fit.p_value, axis.facts.later->p_value);
  EXPECT_FALSE(there.axes[0].facts.later);
  EXPECT_FALSE(
      calibration::calibrate(allan::make_record({gyro_axis(mems_rates(36000, 12))}, kRecordRate)).axes[0].facts.later)
      << "a described record needs none";
}

}  // namespace
}  // namespace gyrobudget::tests

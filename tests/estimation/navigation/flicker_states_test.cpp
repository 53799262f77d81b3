// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/navigation/flicker_states.h"

#include "gyrobudget/noise/process.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

using namespace gyrobudget;  // NOLINT

namespace {

// Largest relative error of the Allan deviation, by noise's own Allan variance sampled 1000 times a shortest lag, where
// sampled and averaged processes agree to 1e-6, and at points that the fit did not use.
double worst_error(const navigation::FlickerStates& fit, double shortest, double longest) {
  const double dt = shortest / 1000;
  double worst = 0;
  for (double tau = shortest; tau <= longest; tau *= 1.083) {
    double variance = 0;
    for (const auto& g : fit.processes) variance += noise::allan_variance(g, std::llround(tau / dt), dt);
    worst = std::max(worst, std::abs(std::sqrt(variance / (2 * std::numbers::ln2 / std::numbers::pi)) - 1));
  }
  return worst;
}

}  // namespace

TEST(FlickerStates, HaveTheErrorTheyState) {
  const struct {
    double decades;
    int states;
    double limit;  // of the table in the header
  } cases[] = {{2, 1, 0.38},  {2, 2, 0.047},  {2, 3, 0.0063}, {2, 4, 0.0009}, {3, 2, 0.155},
               {3, 3, 0.032}, {3, 4, 0.0074}, {4, 3, 0.094},  {4, 4, 0.026},  {4, 6, 0.0026}};
  constexpr double kBetweenPoints = 1.005;  // the error is taken on 128 points a decade
  for (const auto& c : cases) {
    const double longest = std::pow(10, c.decades);
    const auto fit = navigation::flicker_states(1, 1, longest, c.states);
    ASSERT_EQ(fit.processes.size(), static_cast<std::size_t>(c.states));
    EXPECT_LT(fit.worst_error, c.limit) << c.decades << " decades, " << c.states;
    EXPECT_LT(worst_error(fit, 1, longest), kBetweenPoints * fit.worst_error + 1e-5) << c.decades << " " << c.states;
  }
}

TEST(FlickerStates, ScaleWithBandAndCoefficient) {
  const auto unit = navigation::flicker_states(1, 1, 100, 3);
  const auto scaled = navigation::flicker_states(3e-9, 0.25, 25, 3);
  constexpr double kRounding = 1e-12;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(scaled.processes[i].sigma / 3e-9 / unit.processes[i].sigma, 1, kRounding);
    EXPECT_NEAR(scaled.processes[i].correlation_time / 0.25 / unit.processes[i].correlation_time, 1, kRounding);
  }
}

TEST(FlickerStates, RefuseWhatTheyCannotFit) {
  EXPECT_THROW((void)navigation::flicker_states(-1, 1, 100, 3), std::invalid_argument);
  EXPECT_THROW((void)navigation::flicker_states(NAN, 1, 100, 3), std::invalid_argument);
  EXPECT_THROW((void)navigation::flicker_states(1, 0, 100, 3), std::invalid_argument);
  EXPECT_THROW((void)navigation::flicker_states(1, 100, 100, 3), std::invalid_argument);
  EXPECT_THROW((void)navigation::flicker_states(1, 1, 1e9, 3), std::invalid_argument);
  EXPECT_THROW((void)navigation::flicker_states(1, 1, 100, 7), std::invalid_argument);
  EXPECT_TRUE(navigation::flicker_states(1, 1, 100, 0).processes.empty());
}

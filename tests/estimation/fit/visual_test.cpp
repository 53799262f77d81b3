// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/fit/visual.h"

#include "gyrobudget/allan/factors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "sensors.h"

namespace gyrobudget::fit {
namespace {

using noise::Term;

allan::Curve dense_curve(const std::vector<noise::Process>& processes, std::int64_t samples, double dt) {
  allan::Curve curve;
  curve.dt = dt;
  curve.samples = samples;
  for (const auto m : allan::log_factors(samples, 200)) {
    curve.points.push_back({m, noise::allan_variance(processes, m, dt), samples - 2 * m + 1});
  }
  return curve;
}

// What the paper's reader measures, in closed form (theory section 3): N is right, "B" is the crossing.
TEST(VisualReading, MeasuresTheCrossingInsteadOfTheBiasInstability) {
  for (const auto& gyro : {tests::ifog(), tests::mems()}) {
    const Result result = read_visually(dense_curve(gyro.processes(), 3600000, 0.01));
    const double flat2 = 2 * std::numbers::ln2 / std::numbers::pi;
    const double crossing2 = 2 * gyro.n * gyro.k / std::numbers::sqrt3 + flat2 * gyro.b * gyro.b;
    // At 1 s the curve holds N^2 plus 0.44 B^2 plus K^2/3.
    const double one_second2 = gyro.n * gyro.n + flat2 * gyro.b * gyro.b + gyro.k * gyro.k / 3;
    EXPECT_NEAR(result[Term::white].value / std::sqrt(one_second2), 1, 1e-3);
    EXPECT_NEAR(result[Term::flicker].value / std::sqrt(crossing2 / flat2), 1, 2e-3);
    EXPECT_NEAR(result[Term::rate_random_walk].value / gyro.k, 1,
                0.03);  // the slope is nearest 1/2 where N and B still add a little
    EXPECT_EQ(result.verdict,
              Verdict::not_described);  // the model made of these readings is far above the curve
  }
}

// The paper's published readings of model 1: 8.11e-3 deg/h for B = 1.70e-3 deg/h.
TEST(VisualReading, ExplainsTableOne) {
  const Result result = read_visually(dense_curve(tests::ifog().processes(), 3600000, 0.01));
  EXPECT_NEAR(noise::from_si(result[Term::flicker].value, "deg/h"), 8.00e-3, 0.03e-3);
}

TEST(VisualReading, NeedsTwoPoints) {
  allan::Curve curve = dense_curve({noise::White{1}}, 100, 1);
  curve.points.resize(1);
  EXPECT_THROW((void)read_visually(curve), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::fit

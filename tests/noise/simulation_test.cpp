// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/simulation.h"

#include "gyrobudget/noise/jerath.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::noise {
namespace {

using Kind = SimulationModel::Kind;

constexpr std::uint64_t kSeed = 5;

SensorModel sensor() {
  SensorModel model{.gyro = {.white = 1e-4, .bias_instability = 1e-5, .rate_random_walk = 1e-6}};
  model.accelerometer = ErrorModel{.white = 1e-2};
  return model;
}

SimulationOptions options(Kind kind) {
  return {.model = {.kind = kind}, .rate_hz = 10, .duration_s = 20, .seed = kSeed};
}

std::vector<double> made(Generator generator, std::size_t samples) {
  std::vector<double> values(samples);
  generator.next(values);
  return values;
}

TEST(Simulation, HasTheAxesOfBothTriads) {
  const Simulation both(sensor(), options(Kind::spectral));
  ASSERT_EQ(both.axes().size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(both.axes()[i].signal, i < 3 ? Signal::angular_rate : Signal::specific_force);
    EXPECT_EQ(both.axes()[i].axis, static_cast<int>(i % 3));
    EXPECT_EQ(both.axes()[i].key.stream, i);
    EXPECT_EQ(both.axes()[i].key.seed, kSeed);
  }
  SensorModel gyro = sensor();
  gyro.accelerometer.reset();
  EXPECT_EQ(Simulation(gyro, options(Kind::spectral)).axes().size(), 3U);
}

TEST(Simulation, AxesHaveTheirNumbersWhateverSubsetIsAskedFor) {
  SimulationOptions some = options(Kind::spectral);
  some.axes = {2, 0};
  const Simulation all(sensor(), options(Kind::spectral)), part(sensor(), some);
  EXPECT_EQ(part.record(0), all.record(2));
  EXPECT_EQ(part.record(1), all.record(0));
  EXPECT_EQ(part.record(2), all.record(5));
  EXPECT_NE(all.record(0), all.record(1));
}

TEST(Simulation, SpectralRecordsAreThoseOfTheExactGenerator) {
  const Simulation simulation(sensor(), options(Kind::spectral));
  EXPECT_FALSE(simulation.streams());
  EXPECT_EQ(simulation.samples(), 200U);
  EXPECT_EQ(simulation.record(1), generate_record(sensor().gyro.processes(1), 200, 0.1, {kSeed, 1}));
}

TEST(Simulation, TheOthersStream) {
  const Simulation simulation(sensor(), options(Kind::gauss_markov));
  EXPECT_TRUE(simulation.streams());
  EXPECT_THROW((void)simulation.record(0), std::invalid_argument);
  const Generator::Options expected{.key = {kSeed, 0}, .longest_tau = 20};
  EXPECT_EQ(made(simulation.generator(0), 200), made(Generator(sensor().gyro.processes(0), 0.1, expected), 200));
}

TEST(Simulation, WithoutEndKeepsTheBandOfTheGenerator) {
  SimulationOptions endless = options(Kind::gauss_markov);
  endless.duration_s = std::numeric_limits<double>::infinity();
  const Simulation simulation(sensor(), endless);
  EXPECT_EQ(simulation.samples(), Simulation::kEndless);
  EXPECT_EQ(made(simulation.generator(2), 50),
            made(Generator(sensor().gyro.processes(2), 0.1, {.key = {kSeed, 2}}), 50));
}

TEST(Simulation, NeedsMemoryForRecordsAndForTheTransformOfFlicker) {
  SensorModel white = sensor();
  white.gyro = {.white = 1};
  EXPECT_EQ(Simulation(white, options(Kind::spectral)).bytes_of_records(), 6 * 8 * 200);
  EXPECT_EQ(Simulation(sensor(), options(Kind::spectral)).bytes_of_records(), (6 + 11) * 8 * 200);
}

TEST(Simulation, RefusesWhatIsNone) {
  SimulationOptions wrong = options(Kind::spectral);
  wrong.axes = {3};
  EXPECT_THROW(Simulation(sensor(), wrong), std::invalid_argument);
  wrong = options(Kind::spectral);
  wrong.rate_hz = 0;
  EXPECT_THROW(Simulation(sensor(), wrong), std::invalid_argument);
  wrong = options(Kind::spectral);
  wrong.duration_s = std::nan("");
  EXPECT_THROW(Simulation(sensor(), wrong), std::invalid_argument);
}

// --- Models ---------------------------------------------------------------------------------------------------------

double density(const Model& model, double frequency_hz) { return ModelMoments(model, 0.1).psd(frequency_hz); }

TEST(SimulationModel, TakesTheCoefficientsOfTheSensor) {
  const ErrorModel errors = sensor().gyro;
  const Jerath jerath{.arw = errors.white[0],
                      .bias_instability = errors.bias_instability[0],
                      .rrw = errors.rate_random_walk[0],
                      .taps = 50};
  EXPECT_EQ(density(model_of({.kind = Kind::jerath, .taps = 50}, errors, 0, 0.1), 0.2),
            density(jerath.model(0.1), 0.2));
  // At half the rate model 2's noise is white but for 1/f: N^2, or half of it where the sensor's densities are taken as
  // two-sided.
  ErrorModel white{.white = 1};
  EXPECT_NEAR(density(model_of({.kind = Kind::imu_sensor, .single_sided = true}, white, 0, 0.1), 5), 1, 1e-12);
  EXPECT_NEAR(density(model_of({.kind = Kind::imu_sensor}, white, 0, 0.1), 5), 0.5, 1e-12);
}

TEST(SimulationModel, ModelThreeWalksWhereItDoesNotAlready) {
  using Bias = Bielas::Bias;
  const auto walks = [](Bias variant, std::optional<bool> asked) {
    const Model with =
        model_of({.kind = Kind::bielas, .variant = variant, .rate_random_walk = asked}, sensor().gyro, 0, 0.1);
    return std::ranges::any_of(with.processes, [](const Process& p) {
      return term(p) == Term::rate_random_walk && coefficient(p) == sensor().gyro.rate_random_walk[0];
    });
  };
  EXPECT_FALSE(walks(Bias::integrated_legacy, {}));
  EXPECT_TRUE(walks(Bias::integrated_legacy, true));
  EXPECT_TRUE(walks(Bias::plain_white, {}));
  EXPECT_FALSE(walks(Bias::plain_white, false));
}

TEST(SimulationModel, SaysWhatItLeavesOut) {
  ErrorModel errors = sensor().gyro;
  errors.quantization = 1e-6;
  errors.gauss_markov = {{1e-5, 10}, {1e-5, 100}};
  EXPECT_TRUE(left_out({.kind = Kind::spectral}, errors).empty());
  EXPECT_TRUE(left_out({.kind = Kind::gauss_markov}, errors).empty());
  const auto terms = left_out({.kind = Kind::jerath}, errors);
  EXPECT_EQ(terms, (std::vector{Term::quantization, Term::gauss_markov, Term::gauss_markov}));
}

TEST(Simulation, AxesHaveTheirOwnNoise) {
  SensorModel model;
  model.gyro.white = {1e-4, 0, 3e-4};
  for (const Kind kind : {Kind::spectral, Kind::gauss_markov, Kind::jerath, Kind::imu_sensor, Kind::bielas}) {
    const Simulation simulation(model, options(kind));
    ASSERT_EQ(simulation.axes().size(), 3U);
    const auto level = [&](std::size_t axis) { return ModelMoments(simulation.axes()[axis].model, 0.1).psd(0.2); };
    EXPECT_NEAR(level(2) / level(0), 9, 1e-9);
    EXPECT_EQ(level(1), 0);
  }
  const Simulation simulation(model, options(Kind::spectral));
  EXPECT_EQ(simulation.record(1), std::vector<double>(200));
  EXPECT_EQ(simulation.record(2), generate_record(model.gyro.processes(2), 200, 0.1, {kSeed, 2}));
}

}  // namespace
}  // namespace gyrobudget::noise

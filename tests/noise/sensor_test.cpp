// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/sensor.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace gyrobudget::noise {
namespace {

constexpr Term kTerms[] = {Term::quantization, Term::white,        Term::flicker, Term::rate_random_walk,
                           Term::rate_ramp,    Term::gauss_markov, Term::sinusoid};
constexpr Signal kSignals[] = {Signal::angular_rate, Signal::specific_force, Signal::dimensionless};

/// Doubled time exponent of a coefficient relative to the signal's, from the Allan variance's power of tau.
int time_exponent(Term term) {
  switch (term) {
    case Term::quantization:
      return 2;
    case Term::white:
      return 1;
    case Term::rate_random_walk:
      return -1;
    case Term::rate_ramp:
      return -2;
    default:
      return 0;
  }
}

TEST(Sensor, DatasheetUnitsHaveTheDimensionOfTheCoefficient) {
  for (const Signal signal : kSignals) {
    const Dimension base = dimension_of(signal);
    EXPECT_EQ(parse_unit(datasheet_unit(signal)).dimension, base);
    for (const Term term : kTerms) {
      Dimension expected = base;
      expected.time = static_cast<std::int8_t>(base.time + time_exponent(term));
      EXPECT_EQ(dimension_of(signal, term), expected) << datasheet_unit(signal, term);
    }
  }
  EXPECT_EQ(dimension_of(Signal::angular_rate), dimension::kAngularRate);
  EXPECT_EQ(dimension_of(Signal::specific_force), dimension::kSpecificForce);
  EXPECT_EQ(dimension_of(Signal::dimensionless), dimension::kNumber);
}

TEST(Sensor, KeysOfFilesAndResults) {
  EXPECT_EQ(key(Signal::angular_rate, Term::white), "arw");
  EXPECT_EQ(key(Signal::angular_rate, Term::flicker), "bias_instability");
  EXPECT_EQ(key(Signal::angular_rate, Term::rate_random_walk), "rrw");
  EXPECT_EQ(key(Signal::specific_force, Term::white), "vrw");
  EXPECT_EQ(key(Signal::specific_force, Term::rate_random_walk), "accel_rw");
  EXPECT_EQ(label(Signal::angular_rate, Term::white), "angle random walk");
  for (const Signal signal : kSignals) {
    EXPECT_EQ(key(signal, Term::quantization), "quantization");
    EXPECT_EQ(key(signal, Term::rate_ramp), "rate_ramp");
    EXPECT_THROW((void)key(signal, static_cast<Term>('?')), std::invalid_argument);
  }
}

TEST(Sensor, ProcessesAreTheNonZeroTerms) {
  EXPECT_TRUE(ErrorModel{}.processes(0).empty());
  ErrorModel gyro;
  gyro[Term::white] = 3;
  gyro[Term::rate_random_walk] = 5;
  gyro.gauss_markov = {{0, 1}, {2, 100}};
  gyro.sinusoids = {{0.5, 50, 0.1}};
  const auto processes = gyro.processes(0);
  ASSERT_EQ(processes.size(), 4u);
  EXPECT_EQ(std::get<White>(processes[0]).n, 3);
  EXPECT_EQ(std::get<RateRandomWalk>(processes[1]).k, 5);
  EXPECT_EQ(std::get<GaussMarkov>(processes[2]).correlation_time, 100);
  EXPECT_EQ(std::get<Sinusoid>(processes[3]).phase, 0.1);
}

TEST(Sensor, CoefficientsByTerm) {
  ErrorModel model;
  double value = 1;
  for (const Term term : kTerms) {
    if (term == Term::gauss_markov || term == Term::sinusoid) {
      EXPECT_THROW((void)model[term], std::invalid_argument);
    } else {
      model[term] = ++value;
      EXPECT_EQ(std::as_const(model)[term], value);
    }
  }
  EXPECT_EQ(model.quantization, 2);
  EXPECT_EQ(model.white, 3);
  EXPECT_EQ(model.bias_instability, 4);
  EXPECT_EQ(model.rate_random_walk, 5);
  EXPECT_EQ(model.rate_ramp, 6);
}

TEST(Sensor, AxesHaveTheirOwnNoise) {
  ErrorModel gyro{.white = {1, 2, 0}, .bias_instability = 3};
  EXPECT_FALSE(gyro.axes_are_alike());
  EXPECT_EQ(gyro.white.largest(), 2);
  gyro.gauss_markov = {{.sigma = {0, 0, -5}, .correlation_time = 100}};
  gyro.sinusoids = {{.amplitude = 7, .frequency = 50}};
  const auto coefficients = [&](std::size_t axis) {
    std::vector<std::pair<Term, double>> list;
    for (const Process& p : gyro.processes(axis)) list.emplace_back(term(p), coefficient(p));
    return list;
  };
  using List = std::vector<std::pair<Term, double>>;
  EXPECT_EQ(coefficients(0), (List{{Term::white, 1}, {Term::flicker, 3}, {Term::sinusoid, 7}}));
  EXPECT_EQ(coefficients(1), (List{{Term::white, 2}, {Term::flicker, 3}, {Term::sinusoid, 7}}));
  EXPECT_EQ(coefficients(2), (List{{Term::flicker, 3}, {Term::gauss_markov, -5}, {Term::sinusoid, 7}}));
  const auto all = gyro.triad_processes();
  ASSERT_EQ(all.size(), 4U);
  for (std::size_t axis = 0; axis < 3; ++axis) {  // each axis is its part of them
    double sum = 0, own = 0;
    for (const TriadProcess& p : all) sum += std::pow(coefficient(p.process) * p.relative[axis], 2);
    for (const auto& [t, c] : coefficients(axis)) own += c * c;
    EXPECT_EQ(sum, own);
  }
  EXPECT_EQ(all[1].relative, PerAxis(1));
  EXPECT_TRUE((ErrorModel{.white = 2, .gauss_markov = {{1, 10}}}.axes_are_alike()));
}

}  // namespace
}  // namespace gyrobudget::noise

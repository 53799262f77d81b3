// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/navigation/sensor_states.h"

#include "gyrobudget/noise/process.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>

using namespace gyrobudget;  // NOLINT
using navigation::SensorStates;

namespace {

constexpr double kScene = 83;  // [s]
constexpr int kGrid = 400;

// Position after the scene from a bias r(t) through a constant specific force of 1: int r(s) (T - s)^2/2 ds. Its
// variance, from the covariance R(s, t) of r, midpoints.
double position_variance(const std::function<double(int, int)>& R) {
  const double cell = kScene / kGrid;
  const auto weight = [&](int i) { return std::pow(kScene - (i + 0.5) * cell, 2) / 2 * cell; };
  double sum = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) sum += weight(i) * weight(j) * R(i, j);
  return sum;
}

double middle(int i) { return (i + 0.5) * kScene / kGrid; }

struct Case {
  double powered_on_before;
  std::optional<double> calibrated_over;
};

// The same from the exact structure function of flicker sampled at dt: zero at the epoch, or with a mean taken off.
double exact(const Case& c, double dt) {
  const auto D = [&](double lag) {
    const auto h = std::llround(lag / dt);
    return h < 1 ? 0.0 : noise::structure_function(noise::Flicker{1}, h, dt);
  };
  const double cell = kScene / kGrid;
  const auto between = [&](int i, int j) { return i == j ? D(cell / 3) : D(std::abs(i - j) * cell); };
  if (!c.calibrated_over)
    return position_variance([&](int i, int j) {
      return (D(middle(i) + c.powered_on_before) + D(middle(j) + c.powered_on_before) - between(i, j)) / 2;
    });
  // R(s, t) = (m(s) + m(t) - D(t - s) - mm)/2, m the mean of D to the window, mm its mean within the window.
  const double window = *c.calibrated_over;
  constexpr int cells = 300;
  double within = 0;
  for (int i = 1; i < cells; ++i) within += 2.0 * (cells - i) * D(i * window / cells) / (cells * cells);
  within += D(window / cells / 3) / cells;
  std::vector<double> to_window(kGrid, 0.0);
  for (int i = 0; i < kGrid; ++i)
    for (int k = 0; k < cells; ++k)
      to_window[static_cast<std::size_t>(i)] += D(middle(i) + (k + 0.5) * window / cells) / cells;
  return position_variance([&](int i, int j) {
    return (to_window[static_cast<std::size_t>(i)] + to_window[static_cast<std::size_t>(j)] - between(i, j) - within) /
           2;
  });
}

// The same from the states of one axis.
double of_states(const SensorStates& states) {
  const auto n = static_cast<int>(states.model.terms.size()) / 3;
  return position_variance([&](int i, int j) {
    const double s = middle(i), t = middle(j);
    double R = 0;
    for (int p = 0; p < n; ++p) {
      const auto& term = states.model.terms[static_cast<std::size_t>(p)];
      for (int q = 0; q < n; ++q)
        R += states.initial(p, q) * decay(term, s) * decay(states.model.terms[static_cast<std::size_t>(q)], t);
      const double tc = term.correlation_time;
      if (std::isinf(tc))
        R += term.walk * term.walk * std::min(s, t);
      else  // stationary
        R += states.initial(p, p) * (std::exp(-std::abs(t - s) / tc) - decay(term, s) * decay(term, t));
    }
    return R;
  });
}

SensorStates::Options scene(double dt, const Case& c) {
  SensorStates::Options options;
  options.scene_length = kScene;
  options.step = dt;
  options.gyro = navigation::Epoch{c.powered_on_before, c.calibrated_over};
  return options;
}

noise::SensorModel flicker_alone() {
  noise::SensorModel sensor;
  sensor.gyro.bias_instability = 1;
  return sensor;
}

}  // namespace

// The position that flicker costs depends on its epoch by a factor of almost three, and on the sample interval where it
// was zero at one sample. Three states hold all of it; B = 1, f = 1, so the numbers are in s^3.
TEST(SensorStates, CarryFlickerFromAnyEpoch) {
  const struct {
    Case epoch;
    double dt, published;
  } rows[] = {
      {{0, std::nullopt}, 0.1, 142700},
      {{60, std::nullopt}, 0.1, 175000},
      {{3600, std::nullopt}, 0.1, 229600},
      {{0, 83.0}, 0.1, 87200},
      {{0, std::nullopt}, 0.01, 0},
      {{60, std::nullopt}, 0.01, 0},
      {{3600, std::nullopt}, 0.01, 0},
      {{0, 83.0}, 0.01, 0},
      {{0, 600.0}, 0.01, 0},
      {{1e5, std::nullopt}, 0.01, 0},
      {{0, 1e5}, 0.01, 0},
  };
  constexpr double kThreeStates = 0.012;  // 0.6 % of the deviation in the band, and what is faster than it
  constexpr double kPublished = 0.004;    // its own discretisation
  for (const auto& row : rows) {
    SensorStates::Options options = scene(row.dt, row.epoch);
    options.flicker_states = 3;
    const double truth = std::sqrt(exact(row.epoch, row.dt));
    if (row.published > 0) {
      EXPECT_NEAR(truth / row.published, 1, kPublished);
    }
    const double ours = std::sqrt(of_states(sensor_states(flicker_alone(), options)));
    EXPECT_NEAR(ours / truth, 1, kThreeStates)
        << row.epoch.powered_on_before << " " << row.epoch.calibrated_over.value_or(0) << " " << row.dt;
  }
}

TEST(SensorStates, StartFromTheClosedFormsOfTheOtherProcesses) {
  noise::SensorModel sensor;
  sensor.gyro.rate_random_walk = 2;
  sensor.gyro.white = 3;
  sensor.gyro.turn_on_bias = 5;
  const auto variance = [&](const Case& c) { return sensor_states(sensor, scene(0.01, c)).initial(0, 0); };
  EXPECT_DOUBLE_EQ(variance({100, std::nullopt}), 5 * 5 + 2 * 2 * 100);
  EXPECT_DOUBLE_EQ(variance({100, 30.0}), 2 * 2 * 30.0 / 3 + 3 * 3 / 30.0);

  noise::SensorModel markov;
  markov.gyro.gauss_markov = {{.sigma = 2, .correlation_time = 50}};
  const auto stationary = sensor_states(markov, scene(0.01, {100, std::nullopt}));
  EXPECT_EQ(stationary.initial(0, 0), 0);
  EXPECT_DOUBLE_EQ(stationary.initial(1, 1), 4);
  // What is left right after a calibration of one correlation time: var(g(0) - mean) = sigma^2 (1 - 2 h + 2 (1 - h)).
  const auto calibrated = sensor_states(markov, scene(0.01, {100, 50.0}));
  const double h = 1 - std::exp(-1.0);
  EXPECT_NEAR(calibrated.initial(0, 0) + calibrated.initial(1, 1) + 2 * calibrated.initial(0, 1),
              4 * (1 - 2 * h + 2 * (1 - h)), 1e-14);
}

TEST(SensorStates, HoldOnlyWhatTheSensorHas) {
  noise::SensorModel ideal;
  EXPECT_TRUE(sensor_states(ideal, scene(0.01, {0, std::nullopt})).model.terms.empty());
  noise::SensorModel white;
  white.gyro.white = 1e-5;
  EXPECT_TRUE(sensor_states(white, scene(0.01, {0, std::nullopt})).model.terms.empty());

  noise::SensorModel full;
  full.gyro.scale_factor = 1e-5;
  full.gyro.misalignment = 1e-4;
  full.gyro.g_sensitivity = 1e-6;
  full.accelerometer.emplace();
  full.accelerometer->turn_on_bias = 1e-3;
  full.accelerometer->misalignment = 1e-4;
  auto options = scene(0.01, {0, std::nullopt});
  EXPECT_EQ(sensor_states(full, options).model.terms.size(), 3u + 6 + 9 + 3 + 6);
  options.misalignment = navigation::Use::left_out;
  options.g_sensitivity = navigation::Use::considered;
  const auto states = sensor_states(full, options);
  EXPECT_EQ(states.model.terms.size(), 3u + 9 + 3);
  EXPECT_EQ(states.left_out.size(), 2u);
  EXPECT_TRUE(states.model.terms[3].considered);
}

// As many flicker states as the rest of the noise lets show: none where white noise hides it, more where it rules.
TEST(SensorStates, ChooseTheFewestFlickerStates) {
  noise::SensorModel sensor = flicker_alone();
  const auto states = [&](double white) {
    sensor.gyro.white = white;
    return sensor_states(sensor, scene(0.01, {0, 83.0})).model.terms.size() / 3 - 1;
  };
  EXPECT_EQ(states(0), 3u);
  EXPECT_EQ(states(20), 2u);
  EXPECT_EQ(states(1000), 0u);
}

TEST(SensorStates, RefuseWhatMakesNoSense) {
  const auto refused = [](auto change) {
    auto options = scene(0.01, {0, std::nullopt});
    change(options);
    EXPECT_THROW((void)sensor_states(flicker_alone(), options), std::invalid_argument);
  };
  refused([](auto& o) { o.scene_length = 0; });
  refused([](auto& o) { o.step = NAN; });
  refused([](auto& o) { o.tolerance = 0; });
  refused([](auto& o) { o.gyro->powered_on_before = -1; });
  refused([](auto& o) { o.gyro->calibrated_over = 0; });
  refused([](auto& o) { o.flicker_states = 7; });
  noise::SensorModel many = flicker_alone();
  many.gyro.gauss_markov.assign(25, {.sigma = 1, .correlation_time = 10});
  EXPECT_THROW((void)sensor_states(many, scene(0.01, {0, std::nullopt})), std::invalid_argument);
}

// Three axes, three sensors: what each has is what a triad of it has on that axis.
TEST(SensorStates, AreThoseOfEachAxis) {
  noise::SensorModel flicker = flicker_alone(), walk, none, mixed;
  walk.gyro.rate_random_walk = 2;
  walk.gyro.white = 3;
  mixed.gyro.bias_instability = {flicker.gyro.bias_instability[0], 0, 0};
  mixed.gyro.rate_random_walk = {0, 2, 0};
  mixed.gyro.white = {0, 3, 0};
  const auto options = scene(0.01, {100, std::nullopt});
  const auto found = sensor_states(mixed, options);
  EXPECT_EQ(found.model.gyro_white, Eigen::Vector3d(0, 3, 0));
  std::size_t at = 0;
  int axis = 0;
  for (const auto* one : {&flicker, &walk, &none}) {
    const auto alone = sensor_states(*one, options);
    for (std::size_t i = 0; i < alone.model.terms.size(); ++i) {
      if (alone.model.terms[i].axis != axis) continue;
      ASSERT_LT(at, found.model.terms.size());
      EXPECT_EQ(found.model.terms[at].axis, axis);
      EXPECT_EQ(found.model.terms[at].walk, alone.model.terms[i].walk);
      EXPECT_EQ(found.model.terms[at].correlation_time, alone.model.terms[i].correlation_time);
      const auto ours = static_cast<Eigen::Index>(at), theirs = static_cast<Eigen::Index>(i);
      EXPECT_EQ(found.initial(ours, ours), alone.initial(theirs, theirs));
      ++at;
    }
    ++axis;
  }
  EXPECT_EQ(found.model.terms.size(), at);
  EXPECT_GT(at, 2U);
}

// SPDX-License-Identifier: MIT
// Each effect of an IMU alone against its closed form. Its noise and epochs: imu_epoch_test.cpp.
#include "gyrobudget/noise/imu.h"

#include "gyrobudget/noise/detail/response.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "allocations.h"

namespace gyrobudget::noise {
namespace {

constexpr double kDt = 0.01;
constexpr double kRounding = 1e-15;  // of the largest number in a formula: a few operations
// Of a statistic against its law: two-sided normal, 1e-6 for each comparison.
constexpr double kSigmas = 4.9;

const ImuIncrement kTruth{.angle = {0.01, -0.02, 0.03}, .velocity = {0.4, -0.5, -0.1}};

SensorModel with_gyro(const std::function<void(ErrorModel&)>& set) {
  SensorModel model;
  set(model.gyro);
  return model;
}

SensorModel with_both(const std::function<void(ErrorModel&)>& set) {
  SensorModel model = with_gyro(set);
  set(model.accelerometer.emplace());
  return model;
}

/// Everything a model can hold.
SensorModel full_model() {
  return with_both([](ErrorModel& m) {
    m = {.quantization = 1e-6,
         .white = 1e-4,
         .bias_instability = 1e-4,
         .rate_random_walk = 1e-5,
         .rate_ramp = 1e-6,
         .gauss_markov = {{1e-4, 10}, {1e-4, 1000}},
         .sinusoids = {{1e-4, 3, 1}},
         .turn_on_bias = 1e-3,
         .scale_factor = 1e-4,
         .misalignment = 1e-4,
         .g_sensitivity = 1e-5,
         .g2_sensitivity = 1e-6,
         .vibration_rectification = 1e-6,
         .filter = FrontEnd{FrontEnd::Kind::second_order, 30, FrontEnd::Sampling::held},
         .delay = 0.013,
         .range = 4};
  });
}

/// Readings of `samples` times the same truth.
std::vector<ImuIncrement> run(Imu imu, int samples, const ImuIncrement& truth = kTruth) {
  std::vector<ImuIncrement> result;
  for (int k = 0; k < samples; ++k) result.push_back(imu.next(truth));
  return result;
}

void expect_same(const ImuIncrement& a, const ImuIncrement& b) {
  EXPECT_EQ(a.angle, b.angle);
  EXPECT_EQ(a.velocity, b.velocity);
}

// --- Effects that depend on the motion ---------------------------------------------------------------------

TEST(Imu, AnIdealOneReadsTheTruth) {
  SensorModel model;
  expect_same(Imu(model, kDt, {}).next(kTruth), kTruth);
  model.accelerometer.emplace();
  Imu imu(model, kDt, {});
  expect_same(imu.next(kTruth), kTruth);
  EXPECT_EQ(imu.gyro_bias(), Vector3{});
}

TEST(Imu, TurnOnBiasIsConstant) {
  Imu imu(with_both([](ErrorModel& m) { m.turn_on_bias = PerAxis(0.1, 0, 0.3); }), kDt, {3, 5});
  const auto& c = imu.constants();
  EXPECT_NE(c.gyro.turn_on_bias[0], 0);
  EXPECT_EQ(c.gyro.turn_on_bias[1], 0);
  EXPECT_NE(c.gyro.turn_on_bias[0], c.accelerometer.turn_on_bias[0]);
  for (int k = 0; k < 200; ++k) {
    const ImuIncrement y = imu.next(kTruth);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(y.angle[i], kTruth.angle[i] + c.gyro.turn_on_bias[i] * kDt);
      EXPECT_EQ(y.velocity[i], kTruth.velocity[i] + c.accelerometer.turn_on_bias[i] * kDt);
    }
    EXPECT_EQ(imu.gyro_bias(), c.gyro.turn_on_bias);
    EXPECT_EQ(imu.accelerometer_bias(), c.accelerometer.turn_on_bias);
  }
}

TEST(Imu, ScaleMisalignmentAndSensitivityToAcceleration) {
  const auto model = with_both([](ErrorModel& m) {
    m.scale_factor = 1e-3;
    m.misalignment = 2e-3;
    m.g_sensitivity = 1e-5;
    m.g2_sensitivity = 1e-6;
  });
  Imu imu(model, kDt, {});
  const auto &g = imu.constants().gyro, &a = imu.constants().accelerometer;
  const ImuIncrement y = imu.next(kTruth);
  const Vector3 &w = kTruth.angle, &v = kTruth.velocity;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(g.misalignment[i][i], 0);
    EXPECT_EQ(a.g_sensitivity[i], Vector3{});  // of an accelerometer that is s and M
    double gyro = w[i] * (1 + g.scale_factor[i]) + g.g2_sensitivity[i] * std::pow(v[i] / kDt, 2) * kDt;
    double accelerometer = v[i] * (1 + a.scale_factor[i]) + a.g2_sensitivity[i] * std::pow(v[i] / kDt, 2) * kDt;
    for (std::size_t j = 0; j < 3; ++j) {
      gyro += g.misalignment[i][j] * w[j] + g.g_sensitivity[i][j] * v[j];
      accelerometer += a.misalignment[i][j] * v[j];
    }
    EXPECT_NEAR(y.angle[i], gyro, kRounding * std::abs(w[i]));
    EXPECT_NEAR(y.velocity[i], accelerometer, kRounding * std::abs(v[i]));
    EXPECT_NE(g.misalignment[i][(i + 1) % 3], g.misalignment[i][(i + 2) % 3]);
  }
}

TEST(Imu, VibrationRectifiesAsItsSquare) {
  const auto model = with_gyro([](ErrorModel& m) { m.vibration_rectification = 1e-6; });
  Imu weak(model, kDt, {}, {.vibration = 10}), strong(model, kDt, {}, {.vibration = 30}), none(model, kDt, {});
  expect_same(none.next(kTruth), kTruth);
  for (std::size_t i = 0; i < 3; ++i) {
    const double bias = weak.constants().gyro.vibration_bias[i];
    EXPECT_NE(bias, 0);
    EXPECT_NEAR(strong.constants().gyro.vibration_bias[i], 9 * bias, 9 * kRounding * std::abs(bias));
  }
  EXPECT_EQ(weak.next(kTruth).angle[0], kTruth.angle[0] + weak.constants().gyro.vibration_bias[0] * kDt);
  EXPECT_EQ(weak.gyro_bias(), weak.constants().gyro.vibration_bias);
}

// 600 runs give 1800 to 5400 numbers of each constant; the mean square of n standard normal ones has std
// sqrt(2/n).
TEST(Imu, ConstantsHaveTheModelsStandardDeviation) {
  const auto model = with_gyro([](ErrorModel& m) {
    m.turn_on_bias = 2;
    m.scale_factor = 3;
    m.misalignment = 4;
    m.g_sensitivity = 5;
    m.g2_sensitivity = 6;
    m.vibration_rectification = 7;
  });
  struct Sum {
    double squares = 0, sum = 0;
    int count = 0;
    void add(double x) {
      squares += x * x;
      sum += x;
      ++count;
    }
  };
  std::array<Sum, 6> sums;
  double cross = 0;  // of two kinds on one axis
  constexpr std::uint64_t kRuns = 600;
  for (std::uint64_t r = 0; r < kRuns; ++r) {
    const Imu imu(model, kDt, {1, r}, {.vibration = 1});
    const auto& c = imu.constants().gyro;
    for (std::size_t i = 0; i < 3; ++i) {
      sums[0].add(c.turn_on_bias[i] / 2);
      sums[1].add(c.scale_factor[i] / 3);
      sums[4].add(c.g2_sensitivity[i] / 6);
      sums[5].add(c.vibration_bias[i] / 7);
      cross += c.turn_on_bias[i] / 2 * c.scale_factor[i] / 3;
      for (std::size_t j = 0; j < 3; ++j) {
        if (i != j) sums[2].add(c.misalignment[i][j] / 4);
        sums[3].add(c.g_sensitivity[i][j] / 5);
      }
    }
  }
  for (const Sum& s : sums) {
    EXPECT_NEAR(s.squares / s.count, 1, kSigmas * std::sqrt(2. / s.count));
    EXPECT_NEAR(s.sum / s.count, 0, kSigmas / std::sqrt(s.count));
  }
  EXPECT_NEAR(cross / sums[0].count, 0, kSigmas / std::sqrt(sums[0].count));
}

// --- Response ----------------------------------------------------------------------------------------------

FrontEnd::Kind kind_of(int order) { return order == 1 ? FrontEnd::Kind::first_order : FrontEnd::Kind::second_order; }

/// Integral over time of the response to a unit step; zero before it.
double step_area(double t, double bandwidth, int order) {
  if (t <= 0) return 0;
  const double w = 2 * std::numbers::pi * bandwidth;
  if (order == 1) return t + std::expm1(-w * t) / w;
  const double s = w / std::numbers::sqrt2;
  return t - (1 - std::exp(-s * t) * std::cos(s * t)) / s;
}

/// Increments behind a low pass by convolution: those of input k are a pulse, the difference of two steps.
std::vector<double> convolved(const std::vector<double>& u, double bandwidth, int order) {
  std::vector<double> y(u.size(), 0.0);
  const auto area = [&](std::size_t samples) {
    return step_area(static_cast<double>(samples) * kDt, bandwidth, order);
  };
  for (std::size_t n = 0; n < u.size(); ++n) {
    for (std::size_t k = 0; k <= n; ++k) {
      const std::size_t age = n - k;
      y[n] += u[k] * (area(age + 1) - 2 * area(age) + (age > 0 ? area(age - 1) : 0)) / kDt;
    }
  }
  return y;
}

/// Starts at zero, so that what comes before the first is known.
std::vector<double> some_signal() {
  std::vector<double> u{0};
  for (int k = 1; k < 300; ++k) u.push_back(std::sin(0.3 * k) + (k % 7 == 0 ? 2. : 0.) - (k > 150 ? 1. : 0.));
  return u;
}

TEST(ImuResponse, LowPassIsTheExactConvolution) {
  constexpr double kTolerance = 1e-12;  // second differences of areas of up to 3 s, over dt
  const auto u = some_signal();
  for (const int order : {1, 2}) {
    for (const double bandwidth : {0.1, 3., 20., 200., 1e4}) {
      detail::LowPass filter(kind_of(order), bandwidth, kDt);
      const auto expected = convolved(u, bandwidth, order);
      for (std::size_t k = 0; k < u.size(); ++k) {
        ASSERT_NEAR(filter.next(u[k]), expected[k], kTolerance) << order << ' ' << bandwidth << ' ' << k;
      }
    }
  }
}

TEST(ImuResponse, LowPassHalvesThePowerAtItsBandwidth) {
  constexpr double kShort = 1e-5, kFrequency = 20;
  constexpr int kPeriod = 5000;
  for (const int order : {1, 2}) {
    detail::LowPass filter(kind_of(order), kFrequency, kShort);
    double power = 0;
    for (int k = 0; k < 20 * kPeriod; ++k) {
      const double y = filter.next(std::sin(2 * std::numbers::pi * k / kPeriod));
      if (k >= 19 * kPeriod) power += y * y;
    }
    constexpr double kSettled = 1e-6;  // samples of 1/5000 of a period: (pi/5000)^2/6 and what is left of the start
    EXPECT_NEAR(power / kPeriod, 0.25, kSettled) << order;
  }
}

TEST(ImuResponse, StartsSettledAndKeepsConstants) {
  for (const int order : {1, 2}) {
    for (const double bandwidth : {1e-300, 1e-6, 1., 1e6, 1e300}) {
      detail::LowPass filter(kind_of(order), bandwidth, kDt);
      for (int k = 0; k < 10; ++k) EXPECT_EQ(filter.next(0.7), 0.7);
    }
  }
  detail::Delay delay(0.037, kDt);
  for (int k = 0; k < 10; ++k) EXPECT_EQ(delay.next(0.7), 0.7);
}

TEST(ImuResponse, DelaySharesOutFractions) {
  const auto u = some_signal();
  for (const double samples : {0., 0.25, 1., 2.5, 17., 99.75}) {
    detail::Delay delay(samples * kDt, kDt);
    const auto whole = static_cast<std::size_t>(samples);
    const double fraction = samples - std::floor(samples);
    for (std::size_t k = 0; k < u.size(); ++k) {
      const double younger = k >= whole ? u[k - whole] : u[0], older = k > whole ? u[k - whole - 1] : u[0];
      ASSERT_NEAR(delay.next(u[k]), (1 - fraction) * younger + fraction * older, 1e-13) << samples << ' ' << k;
    }
  }
}

TEST(ImuResponse, ActsOnWhatIsSensedOfEachAxis) {
  const auto model = with_both([](ErrorModel& m) {
    m.filter = {FrontEnd::Kind::first_order, 5};
    m.delay = kDt;
  });
  Imu imu(model, kDt, {});
  std::vector<detail::LowPass> filters(6, detail::LowPass(FrontEnd::Kind::first_order, 5, kDt));
  std::array<double, 6> before{};
  for (int k = 0; k < 100; ++k) {
    ImuIncrement truth;
    std::array<double, 6> now{};
    for (std::size_t i = 0; i < 3; ++i) {
      truth.angle[i] = std::sin(0.1 * k * static_cast<double>(i + 1));
      truth.velocity[i] = std::cos(0.2 * k * static_cast<double>(i + 1));
      now[i] = filters[i].next(truth.angle[i]);
      now[i + 3] = filters[i + 3].next(truth.velocity[i]);
    }
    if (k == 0) before = now;
    const ImuIncrement y = imu.next(truth);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(y.angle[i], before[i]) << k;
      EXPECT_EQ(y.velocity[i], before[i + 3]) << k;
    }
    before = now;
  }
}

// --- Range and quantization --------------------------------------------------------------------------------

TEST(Imu, RangeSaturatesTheRateAndCounts) {
  const auto model = with_both([](ErrorModel& m) { m.range = 2; });
  Imu imu(model, kDt, {});
  const ImuIncrement truth{.angle = {0.0199, 0.0201, -0.5}, .velocity = {0.02, -0.03, 0}};
  for (int k = 0; k < 3; ++k) {
    expect_same(imu.next(truth), {{0.0199, 2 * kDt, -2 * kDt}, {0.02, -2 * kDt, 0}});
  }
  EXPECT_EQ(imu.gyro_saturated(), (std::array<std::uint64_t, 3>{0, 3, 3}));
  EXPECT_EQ(imu.accelerometer_saturated(), (std::array<std::uint64_t, 3>{0, 3, 0}));
}

/// A rate that hops about, of whole 2^-20: sums of 1e6 are exact.
double thousandths(int k) { return 0x1p-20 * static_cast<double>(std::int64_t{k} * 7919 % 1000); }

TEST(Imu, QuantizationLosesNothing) {
  constexpr double kQ = 1e-5;
  constexpr int kSamples = 1'000'000;
  const double bit = kQ * std::sqrt(12.0);
  Imu imu(with_gyro([](ErrorModel& m) { m.quantization = kQ; }), kDt, {});
  double truth = 0, bits = 0, worst = 0, squares = 0;
  for (int k = 0; k < kSamples; ++k) {
    const double u = thousandths(k);
    const double y = imu.next({.angle = {u, 0, 0}}).angle[0];
    truth += u;
    ASSERT_NEAR(y / bit, std::nearbyint(y / bit), 1e-9);
    bits += std::nearbyint(y / bit);
    const double error = bits * bit - truth;
    worst = std::max(worst, std::abs(error));
    squares += error * error;
  }
  constexpr double kCarried = 1e-12;  // 1e6 roundings of remainders of a bit, and of the bits' sum
  EXPECT_LE(worst, bit * (1 + kCarried) + kSamples * 1e-21);
  EXPECT_GT(worst, 0.5 * bit);
  // Uniform within a bit, about the first remainder.
  double start = 0;
  {
    Imu again(with_gyro([](ErrorModel& m) { m.quantization = kQ; }), kDt, {});
    double sum = 0;  // the mean error is the first remainder, up to kQ/sqrt(samples) as neighbours are unlike
    double total = 0;
    for (int k = 0; k < kSamples; ++k) {
      const double u = thousandths(k);
      total += again.next({.angle = {u, 0, 0}}).angle[0] - u;
      sum += total;
    }
    start = sum / kSamples;
  }
  EXPECT_LE(std::abs(start), 0.5 * bit);
  EXPECT_NEAR(std::sqrt(squares / kSamples - start * start), kQ, 0.01 * kQ);
}

// --- Random numbers ----------------------------------------------------------------------------------------

TEST(Imu, SameKeySameBytes) {
  const SensorModel model = full_model();
  const auto a = run(Imu(model, kDt, {7, 9}, {.vibration = 3}), 500);
  // Runs in turns: neither minds the other, nor being moved.
  Imu other(model, kDt, {7, 10}, {.vibration = 3}), first(model, kDt, {7, 9}, {.vibration = 3});
  Imu moved = std::move(first);
  int equal = 0;
  for (const ImuIncrement& expected : a) {
    equal += other.next(kTruth).angle == expected.angle;  // bits may agree by chance
    expect_same(moved.next(kTruth), expected);
  }
  EXPECT_LT(equal, 50);
  EXPECT_NE(run(Imu(model, kDt, {8, 9}), 1)[0].angle, a[0].angle);
}

// The autocovariance of white noise behind a filter, at lags 0 to 3, is the cosine transform of its power gain, from
// the first samples on. A product of two normal numbers of variance r(0) has a variance of at most 2 r(0)^2, and the
// axes and runs are independent.
TEST(ImuResponse, WhiteNoisePassesTheFilterAndIsStationaryFromTheFirstSample) {
  constexpr double kCorner = 0.05, kSigma = 0.3;
  constexpr int kRuns = 2000, kSamples = 40;
  constexpr double kStandardDeviations = 5;
  using Kind = FrontEnd::Kind;
  for (const Kind kind : {Kind::first_order, Kind::second_order, Kind::moving_average}) {
    const FrontEnd filter{kind, kCorner / kDt, FrontEnd::Sampling::held};
    SensorModel model;
    model.gyro.white = kSigma * std::sqrt(kDt);
    model.gyro.filter = filter;
    std::array<double, 4> first{}, last{};
    for (int r = 0; r < kRuns; ++r) {
      const auto readings = run(Imu(model, kDt, {1, static_cast<std::uint64_t>(r)}), kSamples, {});
      for (std::size_t h = 0; h < first.size(); ++h) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          first[h] += readings[0].angle[axis] * readings[h].angle[axis];
          last[h] += readings[kSamples - 1 - h].angle[axis] * readings[kSamples - 1].angle[axis];
        }
      }
    }
    const SampledFrontEnd sampled(filter, kDt);
    constexpr int kPoints = 1 << 12;
    for (std::size_t h = 0; h < first.size(); ++h) {
      double expected = 0;
      for (int j = 0; j < kPoints; ++j) {
        const double cycles = (j + 0.5) / (2 * kPoints);
        expected +=
            sampled.power_gain(cycles) * std::cos(2 * std::numbers::pi * cycles * static_cast<double>(h)) / kPoints;
      }
      expected *= kSigma * kSigma * kDt * kDt;
      const double r0 = kSigma * kSigma * kDt * kDt * 2 * kCorner * std::numbers::pi / 2;  // at most, of a first order
      const double tolerance = kStandardDeviations * r0 * std::sqrt(2. / (3 * kRuns));
      EXPECT_NEAR(first[h] / (3 * kRuns), expected, tolerance) << name(kind) << " lag " << h;
      EXPECT_NEAR(last[h] / (3 * kRuns), expected, tolerance) << name(kind) << " lag " << h;
    }
  }
}

// Without range and quantization everything is linear in the errors: sources alone sum to the total.
TEST(Imu, SwitchingASourceOffLeavesTheOthers) {
  using enum ErrorSource;
  SensorModel model = full_model();
  for (ErrorModel* m : {&model.gyro, &*model.accelerometer}) {
    m->quantization = 0;
    m->range.reset();
    m->filter.reset();
    m->delay.reset();
    m->powered_on_before = 100;
    m->calibrated_over = 20;
  }
  constexpr int kSamples = 300;
  const auto readings = [&](ErrorSources sources) {
    return run(Imu(model, kDt, {1, 2}, {.vibration = 5, .gyro = sources, .accelerometer = sources}), kSamples);
  };
  const auto total = readings(ErrorSources::all());
  std::vector<ImuIncrement> sum(kSamples, kTruth);
  for (const auto source :
       {turn_on_bias, scale_factor, misalignment, g_sensitivity, g2_sensitivity, vibration_rectification, white,
        flicker, rate_random_walk, rate_ramp, gauss_markov, sinusoid}) {
    const auto alone = readings({source});
    const auto without = readings(ErrorSources::all().without(source));
    double largest = 0;
    for (std::size_t k = 0; k < kSamples; ++k) {
      for (std::size_t i = 0; i < 3; ++i) {
        const double effect = alone[k].angle[i] - kTruth.angle[i];
        sum[k].angle[i] += effect;
        sum[k].velocity[i] += alone[k].velocity[i] - kTruth.velocity[i];
        largest = std::max(largest, std::abs(effect));
        EXPECT_NEAR(total[k].angle[i] - without[k].angle[i], effect, 1e-16);
      }
    }
    // The turn-on bias cancels in the calibration; every other source is there.
    EXPECT_EQ(largest > 1e-12, source != turn_on_bias) << static_cast<int>(source);
  }
  for (std::size_t k = 0; k < kSamples; ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(sum[k].angle[i], total[k].angle[i], 1e-15);
      EXPECT_NEAR(sum[k].velocity[i], total[k].velocity[i], 1e-15);
    }
  }
}

TEST(Imu, SetsOfSources) {
  using enum ErrorSource;
  EXPECT_TRUE(ErrorSources::all().has(range));
  EXPECT_FALSE(ErrorSources().has(white));
  EXPECT_TRUE(ErrorSources({white, flicker}).without(white).has(flicker));
  EXPECT_FALSE(ErrorSources({white, flicker}).without(white).has(white));
  EXPECT_TRUE(ErrorSources().with(delay).has(delay));
  const ErrorModel model = only(full_model().gyro, {white, bandwidth});
  EXPECT_EQ(model.processes(0).size(), 1U);
  EXPECT_TRUE(model.filter);
  EXPECT_FALSE(model.range || model.delay || model.turn_on_bias || model.misalignment);
}

// --- Extremes ----------------------------------------------------------------------------------------------

TEST(Imu, NextAllocatesNothing) {
  Imu imu(full_model(), kDt, {});
  const std::size_t before = tests::allocations();
  for (int k = 0; k < 1000; ++k) (void)imu.next(kTruth);
  EXPECT_EQ(tests::allocations(), before);
}

TEST(Imu, ExtremesStayFinite) {
  for (const double dt : {1e-6, 1e3}) {
    for (const double epoch : {0., 1e8}) {
      for (const double scale : {1e-100, 1e100}) {
        SensorModel model = full_model();
        for (ErrorModel* m : {&model.gyro, &*model.accelerometer}) {
          for (PerAxis* x : {&m->white, &m->bias_instability, &m->rate_random_walk, &m->rate_ramp}) *x *= scale;
          m->turn_on_bias = scale;
          m->range.reset();
          m->filter->bandwidth = 0.2 / dt;  // which white noise must have above 1e-4 of the rate
          m->powered_on_before = epoch;
          if (epoch > 0) m->calibrated_over = epoch / 2;
        }
        Imu imu(model, dt, {});
        for (int k = 0; k < 130; ++k) {
          const ImuIncrement y = imu.next(kTruth);
          for (std::size_t i = 0; i < 3; ++i) {
            ASSERT_TRUE(std::isfinite(y.angle[i]) && std::isfinite(y.velocity[i])) << dt << epoch << scale;
          }
        }
      }
    }
  }
}

TEST(Imu, RefusesWhatMakesNoSense) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const std::function<void(ErrorModel&)>& set, const std::string& word, double dt = kDt) {
    try {
      Imu imu(with_gyro(set), dt, {});
      ADD_FAILURE() << "took " << word;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused([](ErrorModel&) {}, "dt", 0);
  refused([](ErrorModel&) {}, "dt", kNan);
  refused([](ErrorModel& m) { m.white = -1; }, "white");
  refused([](ErrorModel& m) { m.bias_instability = kNan; }, "bias instability");
  refused([](ErrorModel& m) { m.scale_factor = PerAxis(0, 0, kNan); }, "scale factor");
  refused([](ErrorModel& m) { m.filter = {FrontEnd::Kind::first_order, 0}; }, "bandwidth");
  refused([](ErrorModel& m) { m.filter = {static_cast<FrontEnd::Kind>(7), 1}; }, "kind");
  refused(
      [](ErrorModel& m) {
        m.white = 1;
        m.filter = {FrontEnd::Kind::first_order, 0.99e-4 / kDt};
      },
      "at least 1e-4");
  refused([](ErrorModel& m) { m.delay = 1e6; }, "delay");
  refused([](ErrorModel& m) { m.delay = -1; }, "delay");
  refused([](ErrorModel& m) { m.range = -1; }, "range");
  refused([](ErrorModel& m) { m.gauss_markov = {{1, 0}}; }, "correlation time");
  refused([](ErrorModel& m) { m.powered_on_before = -1; }, "powered_on_before");
  refused([](ErrorModel& m) { m.powered_on_before = 1e30; }, "2^62");
  refused([](ErrorModel& m) { m.calibrated_over = 0; }, "at least a sample");
  refused(
      [](ErrorModel& m) {
        m.powered_on_before = 10;
        m.calibrated_over = 11;
      },
      "at most powered_on_before");
  EXPECT_THROW(Imu({}, kDt, {1, std::uint64_t{1} << 45}), std::invalid_argument);
  EXPECT_THROW(Imu({}, kDt, {}, {.vibration = -1}), std::invalid_argument);
}

// --- Axes that differ ----------------------------------------------------------------------------------------

// Each axis has its own white noise and its own quantization; z has neither and reads the truth.
TEST(Imu, AxesHaveTheirOwnNoise) {
  constexpr int kSamples = 20000;
  SensorModel model;
  model.gyro.white = {1e-3, 5e-3, 0};
  model.accelerometer = ErrorModel{.quantization = {1e-3, 0, 0}};
  Imu imu(model, kDt, {});
  Vector3 squares{};
  bool whole = true;
  for (int k = 0; k < kSamples; ++k) {
    const ImuIncrement read = imu.next(kTruth);
    for (std::size_t i = 0; i < 3; ++i) squares[i] += std::pow(read.angle[i] - kTruth.angle[i], 2) / kSamples;
    const double bits = read.velocity[0] / (1e-3 * std::sqrt(12.0));
    whole &= std::abs(bits - std::nearbyint(bits)) < 1e-9;
    EXPECT_EQ(read.velocity[1], kTruth.velocity[1]);
  }
  // A mean of squares scatters by sqrt(2/n); 99.99 % of them lie within 3.9 of that.
  const double band = 3.9 * std::sqrt(2.0 / kSamples);
  EXPECT_NEAR(squares[0] / (1e-3 * 1e-3 * kDt), 1, band);
  EXPECT_NEAR(squares[1] / (5e-3 * 5e-3 * kDt), 1, band);
  EXPECT_EQ(squares[2], 0);
  EXPECT_TRUE(whole);
}

TEST(Imu, NamesWhatIsNotStated) {
  using enum ErrorSource;
  using List = std::vector<ErrorSource>;
  EXPECT_EQ(not_stated({}, Signal::angular_rate), (List{turn_on_bias, scale_factor, misalignment, g_sensitivity}));
  EXPECT_EQ(not_stated({}, Signal::specific_force), (List{turn_on_bias, scale_factor, misalignment}));
  EXPECT_EQ(not_stated({.scale_factor = 0.0, .misalignment = 1e-4}, Signal::specific_force), (List{turn_on_bias}));
  EXPECT_EQ(not_stated({.scale_factor = 0.0, .misalignment = 0.0, .calibrated_over = 60}, Signal::specific_force),
            List{});
}

}  // namespace
}  // namespace gyrobudget::noise

// SPDX-License-Identifier: MIT
// Front ends against slow ways: the spectrum of an impulse through the filter, autocovariances summed over that
// spectrum, and the filter of simulated sensors.
#include "gyrobudget/noise/front_end.h"

#include "gyrobudget/noise/detail/response.h"
#include "gyrobudget/noise/normal.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace gyrobudget::noise {
namespace {

using Kind = FrontEnd::Kind;
using Sampling = FrontEnd::Sampling;
using std::numbers::pi;
constexpr double kDt = 0.01;

std::vector<FrontEnd> front_ends(double corner) {
  std::vector<FrontEnd> list;
  for (const Kind kind : {Kind::first_order, Kind::second_order}) {
    for (const Sampling sampling : {Sampling::analogue, Sampling::bilinear, Sampling::held})
      list.push_back({kind, corner / kDt, sampling});
    for (const double oversampling : {2., 3.3, 16.})
      list.push_back({kind, corner / kDt, Sampling::bilinear, oversampling});
  }
  list.push_back({Kind::moving_average, corner / kDt, Sampling::analogue});
  return list;
}

std::string text(const FrontEnd& f) {
  return std::string(name(f.kind)) + ", sampling " + std::to_string(static_cast<int>(f.sampling)) + " x " +
         std::to_string(f.oversampling) + ", corner " + std::to_string(f.bandwidth * kDt);
}

/// r(0), r(1), ... of samples with a power gain, by the mean over equally spaced frequencies: exact but for r at lags
/// that are whole turns further on.
std::vector<double> autocovariance(const SampledFrontEnd& front_end, int lags) {
  constexpr int kPoints = 1 << 14;
  std::vector<double> r(static_cast<std::size_t>(lags), 0.);
  for (int j = 0; j < kPoints; ++j) {
    const double cycles = static_cast<double>(j) / kPoints;
    const double gain = front_end.power_gain(std::min(cycles, 1 - cycles)) / kPoints;
    for (int h = 0; h < lags; ++h)
      r[static_cast<std::size_t>(h)] += gain * std::cos(2 * pi * std::remainder(cycles * h, 1.));
  }
  return r;
}

TEST(FrontEnd, MemoryIsTheSumOfTheAutocovariance) {
  constexpr double kRounding = 1e-11;  // of sums of some hundred terms, and of (1 - pole)^2
  for (const double corner : {0.01, 0.03, 0.1, 0.25, 0.3}) {
    for (const FrontEnd& f : front_ends(corner)) {
      const SampledFrontEnd front_end(f, kDt);
      const auto lags = static_cast<int>(front_end.settling()) + 2;
      const auto r = autocovariance(front_end, lags);
      for (const int h : {0, 1, 2, 5, 20}) {
        double sum = 0;
        for (int j = h + 1; j < lags; ++j) sum -= (j - h) * r[static_cast<std::size_t>(j)];
        EXPECT_NEAR(front_end.memory(h), sum, kRounding * (1 + std::abs(front_end.memory(0))))
            << text(f) << " lag " << h;
      }
    }
  }
}

TEST(FrontEnd, PassesFrequencyZeroAndHalvesThePowerAtItsBandwidth) {
  for (const double corner : {0.001, 0.01, 0.1}) {
    for (const FrontEnd& f : front_ends(corner)) {
      const SampledFrontEnd front_end(f, kDt);
      EXPECT_NEAR(front_end.power_gain(0), 1, 1e-9) << text(f);
      // What folds down, and the mean over a sample of `held`, are of second order in the corner; pi^2 is the most.
      const bool exact = f.sampling == Sampling::bilinear && f.oversampling == 1;
      const double sampled = exact ? 1e-9 : pi * pi * corner * corner;
      EXPECT_NEAR(front_end.power_gain(corner), 0.5, sampled + 1e-9) << text(f);
    }
  }
}

TEST(FrontEnd, SpectrumIsThatOfAnImpulseThroughTheFilter) {
  for (const FrontEnd& f : front_ends(0.06)) {  // the moving average over 7.38 samples
    const SampledFrontEnd front_end(f, kDt);
    std::vector<double> response(static_cast<std::size_t>(front_end.settling()) + 10, 0.);
    response[1] = 1;
    FrontEndFilter filter(front_end);
    filter(response);
    for (const double cycles : {0., 0.01, 0.05, 0.2, 0.37, 0.5}) {
      std::complex<double> sum = 0;
      for (std::size_t k = 0; k < response.size(); ++k)
        sum += response[k] * std::polar(1., -2 * pi * cycles * static_cast<double>(k));
      EXPECT_NEAR(std::norm(sum), front_end.power_gain(cycles), 1e-12) << text(f) << " at " << cycles;
    }
  }
}

TEST(FrontEnd, AnalogueSamplesHaveTheAutocovarianceOfTheContinuousFilter) {
  constexpr double kCorner = 0.08;
  const double w = 2 * pi * kCorner, s = w / std::numbers::sqrt2;
  const auto first = [&](double h) { return std::exp(-w * h); };
  const auto second = [&](double h) { return std::exp(-s * h) * (std::cos(s * h) + std::sin(s * h)); };
  const auto compare = [&](Kind kind, auto continuous) {
    const auto r = autocovariance(SampledFrontEnd({kind, kCorner / kDt, Sampling::analogue}, kDt), 30);
    for (std::size_t h = 0; h < r.size(); ++h)
      EXPECT_NEAR(r[h] / r[0], continuous(static_cast<double>(h)), 1e-12) << name(kind) << " lag " << h;
  };
  compare(Kind::first_order, first);
  compare(Kind::second_order, second);
}

// Of every R-th sample the spectrum is the sum of R pieces of the filter's own, folded onto one another.
TEST(FrontEnd, OversampledIsTheFilterAtItsOwnRateFolded) {
  for (const Kind kind : {Kind::first_order, Kind::second_order}) {
    for (const double corner : {0.03, 0.2, 0.5, 0.9}) {  // of the first order, R 2 and corner 0.5: a pole at 0
      for (const int R : {2, 3, 4, 16}) {
        const SampledFrontEnd own({kind, corner / kDt, Sampling::bilinear}, kDt / R);
        const auto folded = [&](double cycles) {
          double sum = 0;
          for (int j = 0; j < R; ++j) sum += own.power_gain(std::abs(std::remainder((cycles + j) / R, 1.)));
          return sum;
        };
        const FrontEnd f{kind, corner / kDt, Sampling::bilinear, static_cast<double>(R)};
        const SampledFrontEnd logged(f, kDt);
        // Rounding of what is left of 1 by differences of the pole, (pi corner/R)^-4 times, over the gain itself.
        constexpr double kStated = 1e-8;
        for (const double cycles : {0., 0.1, 0.37, 0.5})
          EXPECT_NEAR(logged.power_gain(cycles) * folded(0) / folded(cycles), 1, kStated) << text(f) << ", " << cycles;
      }
    }
  }
}

TEST(FrontEnd, HeldIsTheFilterOfSimulatedSensors) {
  std::vector<double> samples(300);
  fill_normal({7, 1}, 0, samples);
  for (const int order : {1, 2}) {
    const FrontEnd f{order == 1 ? Kind::first_order : Kind::second_order, 7, Sampling::held};
    auto filtered = samples;
    FrontEndFilter filter(SampledFrontEnd(f, kDt));
    filter(filtered);
    detail::LowPass low_pass(f.kind, 7, kDt);
    for (std::size_t k = 0; k < samples.size(); ++k) ASSERT_NEAR(low_pass.next(samples[k]), filtered[k], 1e-13) << k;
  }
}

TEST(FrontEnd, AMovingAverageIsTheMeanOfItsSamples) {
  for (const double length : {1., 1.5, 7., 7.25, 20.875}) {
    std::vector<double> samples(50), expected;
    fill_normal({7, 2}, 0, samples);
    const auto before = [&](std::size_t k, std::size_t j) { return samples[k < j ? 0 : k - j]; };  // the first had been
    for (std::size_t k = 0; k < samples.size(); ++k) {
      double sum = 0;
      for (std::size_t j = 0; static_cast<double>(j) < length; ++j)
        sum += std::min(1., length - static_cast<double>(j)) * before(k, j);
      expected.push_back(sum / length);
    }
    FrontEndFilter filter(SampledFrontEnd({Kind::moving_average, kMovingAverageWidth / length / kDt}, kDt));
    filter(std::span(samples).first(11));  // in parts
    filter(std::span(samples).subspan(11));
    for (std::size_t k = 0; k < samples.size(); ++k) EXPECT_NEAR(samples[k], expected[k], 1e-13) << length << ' ' << k;
  }
}

// S1 = sum |h| r(h) of the slowest filters by integrals of the continuous ones, which the sums meet to (w dt)^2.
TEST(FrontEnd, MemoryOfSlowFiltersIsThatOfContinuousOnes) {
  constexpr double kCorner = 1e-4, kStated = 1e-8;
  const double w = 2 * pi * kCorner;
  for (const Sampling sampling : {Sampling::analogue, Sampling::bilinear, Sampling::held}) {
    const double tolerance = w * w + kStated;
    const double first = 1 / (2 * w), second = 1 / (2 * std::numbers::sqrt2 * w);
    EXPECT_NEAR(SampledFrontEnd({Kind::first_order, kCorner / kDt, sampling}, kDt).memory(0), -first,
                tolerance * first);
    EXPECT_NEAR(SampledFrontEnd({Kind::second_order, kCorner / kDt, sampling}, kDt).memory(0), -second,
                tolerance * second);
  }
  const double length = kMovingAverageWidth / kCorner;  // samples, not whole: what is left over is of order 1/length^2
  EXPECT_NEAR(SampledFrontEnd({Kind::moving_average, kCorner / kDt}, kDt).memory(0), -length / 6,
              length / 6 * (1 / (length * length) + kStated));
}

TEST(FrontEnd, RefusesWhatItCannotBe) {
  const auto made = [](const FrontEnd& f, double dt) { return SampledFrontEnd(f, dt); };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const double bandwidth : {0., -1., 0.99e-4 / kDt, std::numeric_limits<double>::infinity(), kNaN})
    EXPECT_THROW((void)made({Kind::first_order, bandwidth}, kDt), std::invalid_argument) << bandwidth;
  EXPECT_THROW((void)made({Kind::first_order, 5}, 0), std::invalid_argument);
  EXPECT_THROW((void)made({static_cast<Kind>(9), 5}, kDt), std::invalid_argument);
  for (const double oversampling : {-1., 0.99, FrontEnd::kMostOversampling + 1, kNaN})
    EXPECT_THROW((void)made({Kind::first_order, 5, Sampling::bilinear, oversampling}, kDt), std::invalid_argument);
  EXPECT_THROW(MovingAverage{0.5}, std::invalid_argument);
  EXPECT_THROW(MovingAverage{kNaN}, std::invalid_argument);
}

TEST(FrontEnd, AboveAHundredTimesTheRateIsThat) {
  for (const FrontEnd& f : front_ends(100)) {
    FrontEnd faster = f;
    faster.bandwidth *= 1000;
    EXPECT_EQ(SampledFrontEnd(f, kDt).memory(0), SampledFrontEnd(faster, kDt).memory(0)) << text(f);
    if (f.oversampling > 1) continue;  // what it stops at half its own rate folds down to 0
    EXPECT_LT(std::abs(SampledFrontEnd(f, kDt).memory(0)), 0.01) << text(f);
  }
}

}  // namespace
}  // namespace gyrobudget::noise

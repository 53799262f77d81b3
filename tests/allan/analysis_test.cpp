// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/analysis.h"

#include "gyrobudget/allan/statistics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "reference.h"

namespace gyrobudget::allan {
namespace {

using noise::Signal;

constexpr double kRate = 50;
constexpr double kRounding = 1e-12;  // relative, of variances; see overlapped_variance

Record record(std::vector<std::vector<double>> axes, double rate_hz = kRate) {
  std::vector<Axis> list;
  for (auto& rate : axes)
    list.push_back({"axis " + std::to_string(list.size()), Signal::angular_rate, std::move(rate)});
  return make_record(std::move(list), rate_hz);
}

std::vector<DeviationPoint> points_of(const Analysis& analysis, std::size_t axis = 0, std::size_t curve = 0) {
  return analysis.axes.at(axis).curves.at(curve).points;
}

// --- One record -----------------------------------------------------------------------------------------------------

TEST(Analysis, HasTheDeviationsOfEachAxis) {
  const Record two = record({reference::normal(999, 1), reference::normal(999, 2)});
  const Analysis analysis = analyse(two);
  ASSERT_EQ(analysis.axes.size(), 2U);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    EXPECT_EQ(analysis.axes[axis].axis.name, two.axes[axis].name);
    const auto points = points_of(analysis, axis);
    ASSERT_EQ(points.size(), 9U);  // octaves to 256 <= 999/2
    for (const DeviationPoint& p : points) {
      const auto truth = reference::overlapped_variance(two.axes[axis].rate, p.m, Form::full);
      EXPECT_NEAR(p.deviation * p.deviation / static_cast<double>(truth.variance), 1, kRounding);
      EXPECT_EQ(p.terms, truth.terms);
      EXPECT_EQ(p.tau_s, static_cast<double>(p.m) / kRate);
      EXPECT_LT(p.lower, p.deviation);
      EXPECT_GT(p.upper, p.deviation);
    }
  }
}

TEST(Analysis, HasACurveForEachEstimatorAtItsTaus) {
  const Record one = record({reference::normal(600, 3)});
  const Analysis analysis =
      analyse(one, {.estimators = {Estimator::ohdev, Estimator::totdev}, .taus = {Taus::Kind::decade}, .overlap = 4});
  ASSERT_EQ(analysis.axes.front().curves.size(), 2U);
  EXPECT_EQ(analysis.axes.front().curves[0].estimator, Estimator::ohdev);
  EXPECT_EQ(analysis.axes.front().curves[1].estimator, Estimator::totdev);
  for (std::size_t i = 0; i < 2; ++i) {
    const Estimator estimator = analysis.axes.front().curves[i].estimator;
    const auto points = points_of(analysis, 0, i);
    std::vector<std::int64_t> factors;
    for (const DeviationPoint& p : points) factors.push_back(p.m);
    EXPECT_EQ(factors, factors_of({Taus::Kind::decade}, estimator, 600));
  }
  EXPECT_EQ(points_of(analysis).back().stride, points_of(analysis).back().m / 4);
}

TEST(Analysis, LeavesOutWhatTheMinimumFillDoes) {
  std::vector<double> rate = reference::normal(400, 4);
  for (std::size_t k = 0; k < rate.size(); k += 40) rate[k] = std::numeric_limits<double>::quiet_NaN();
  const Record gaps = record({rate});
  EXPECT_GT(points_of(analyse(gaps)).back().m, 64);  // 39 of 40 are more than 95 %
  EXPECT_LT(points_of(analyse(gaps, {.minimum_fill = 1})).back().m, 40);
  double sum = 0;
  for (const double y : rate) sum += std::isnan(y) ? 0 : y;
  EXPECT_NEAR(analyse(gaps).axes.front().mean, sum / 390, kRounding);
}

// --- Several segments -----------------------------------------------------------------------------------------------

TEST(Analysis, PoolsSegmentsByTheirDegreesOfFreedom) {
  const std::vector<Record> segments{record({reference::normal(700, 5)}), record({reference::normal(300, 6)})};
  const auto first = points_of(analyse(segments[0])), second = points_of(analyse(segments[1])),
             both = points_of(analyse(segments));
  ASSERT_EQ(first.size(), 9U);
  ASSERT_EQ(second.size(), 8U);
  ASSERT_EQ(both.size(), 9U);
  for (std::size_t i = 0; i < second.size(); ++i) {
    const double edf = first[i].edf + second[i].edf;
    const double variance =
        (first[i].edf * std::pow(first[i].deviation, 2) + second[i].edf * std::pow(second[i].deviation, 2)) / edf;
    EXPECT_NEAR(both[i].edf / edf, 1, kRounding);
    EXPECT_NEAR(std::pow(both[i].deviation, 2) / variance, 1, kRounding);
    EXPECT_EQ(both[i].terms, first[i].terms + second[i].terms);
  }
  EXPECT_NEAR(both.back().deviation / first.back().deviation, 1, kRounding);  // the shorter one does not reach it
  const double mean =
      (700 * analyse(segments[0]).axes.front().mean + 300 * analyse(segments[1]).axes.front().mean) / 1000;
  EXPECT_NEAR(analyse(segments).axes.front().mean, mean, kRounding);
}

TEST(Analysis, ViewsAreThoseOfTheLongestSegment) {
  const std::vector<Record> segments{record({reference::normal(300, 7)}), record({reference::normal(900, 8)})};
  const AnalysisOptions options{.spectrum = SpectrumMethod::multitaper, .window_s = 2};
  const AxisAnalysis both = analyse(segments, options).axes.front();
  const AxisAnalysis longest = analyse(segments[1], options).axes.front();
  EXPECT_EQ(both.spectrum->spectrum.density, longest.spectrum->spectrum.density);
  EXPECT_EQ(both.surface->time, longest.surface->time);
}

TEST(Analysis, SegmentsOfOneSensorMatch) {
  const Record first = record({{1, 2}, {3, 4}});
  EXPECT_EQ(match(first, record({{1, 2, 3}, {4, 5, 6}})), Match::alike);
  EXPECT_EQ(match(first, record({{1, 2}, {3, 4}}, kRate * 1.0009)), Match::alike);
  EXPECT_EQ(match(first, record({{1, 2}, {3, 4}}, kRate * 1.0011)), Match::other_rate);
  EXPECT_EQ(match(first, record({{1, 2}})), Match::other_axes);
  Record other = first;
  other.axes[1].signal = Signal::specific_force;
  EXPECT_EQ(match(first, other), Match::other_axes);
  other = first;
  other.axes[0].name = "z";
  EXPECT_EQ(match(first, other), Match::other_axes);
  EXPECT_THROW((void)analyse(std::vector{first, other}), std::invalid_argument);
  EXPECT_THROW((void)analyse(std::span<const Record>{}), std::invalid_argument);
}

// --- Other views ----------------------------------------------------------------------------------------------------

TEST(Analysis, SpectrumIsByTheMethodAskedFor) {
  const Record one = record({reference::normal(4000, 9)});
  EXPECT_FALSE(analyse(one).axes.front().spectrum.has_value());
  for (const SpectrumMethod method : {SpectrumMethod::welch, SpectrumMethod::multitaper}) {
    const auto spectrum = analyse(one, {.spectrum = method}).axes.front().spectrum;
    ASSERT_TRUE(spectrum.has_value());
    EXPECT_EQ(spectrum->method, method);
    const Spectrum expected =
        log_binned(method == SpectrumMethod::welch ? welch(one.axes.front().rate, 1 / kRate)
                                                   : multitaper(one.axes.front().rate, 1 / kRate));
    EXPECT_EQ(spectrum->spectrum.density, expected.density);
  }
}

TEST(Analysis, WindowsAreAQuarterApartAndAtMost400) {
  const Record one = record({reference::normal(40'000, 10)});
  const auto windows = [&](double window_s) { return *analyse(one, {.window_s = window_s}).axes.front().surface; };
  EXPECT_EQ(windows(100).window, 5000);
  EXPECT_EQ(windows(100).hop, 1250);
  EXPECT_EQ(windows(1).window, 50);
  EXPECT_EQ(windows(1).hop, (40'000 - 50) / 400 + 1);
  EXPECT_EQ(windows(1).factors.back(), 16);
  EXPECT_LE(windows(1).time.size(), 400U);
  EXPECT_THROW((void)windows(31 / kRate), WindowError);
  EXPECT_NO_THROW((void)windows(32 / kRate));
  EXPECT_NO_THROW((void)windows(800));
  EXPECT_THROW((void)windows(800.02), WindowError);
}

// --- Streams --------------------------------------------------------------------------------------------------------

TEST(StreamingAnalysis, HasTheTermsOfTheWholeRecord) {
  const Record two = record({reference::normal(5000, 11), reference::normal(5000, 12)});
  StreamingAnalysis stream({{"x", Signal::angular_rate}, {"y", Signal::specific_force}}, kRate);
  for (std::size_t from = 0; from < 5000; from += 1000) {
    const auto piece = [&](std::size_t axis) {
      const auto begin = two.axes[axis].rate.begin() + static_cast<std::ptrdiff_t>(from);
      return std::vector(begin, begin + 1000);
    };
    stream.push(std::vector{piece(0), piece(1)});
  }
  EXPECT_EQ(stream.samples(), 5000);
  const Analysis streamed = stream.analysis(), whole = analyse(two);
  EXPECT_EQ(streamed.axes[1].axis.name, "y");
  EXPECT_EQ(streamed.axes[1].axis.signal, Signal::specific_force);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(streamed.axes[axis].mean, whole.axes[axis].mean, kRounding);
    const auto ours = points_of(streamed, axis), theirs = points_of(whole, axis);
    ASSERT_EQ(ours.size(), theirs.size());
    for (std::size_t i = 0; i < ours.size() && ours[i].m <= 16; ++i) {  // where a term begins at every sample
      EXPECT_EQ(ours[i].terms, theirs[i].terms);
      EXPECT_NEAR(ours[i].deviation / theirs[i].deviation, 1, kRounding);
    }
  }
}

TEST(StreamingAnalysis, RefusesOtherAxesThanItHas) {
  EXPECT_THROW(StreamingAnalysis({}, kRate), std::invalid_argument);
  StreamingAnalysis stream({{"x", Signal::angular_rate}}, kRate);
  EXPECT_THROW(stream.push(std::vector<std::vector<double>>(2)), std::invalid_argument);
}

// The exact loss is from the sum over all lags. The formula is its limit: at these lengths it is off by one term, the
// last one of the record, and by what a stride of one sample costs itself.
TEST(StreamingAnalysis, TheLossOfAnOverlapIsThatOfWhiteNoise) {
  const noise::Process white = noise::White{1};
  constexpr std::int64_t kSamples = 1 << 17, kFactor = 1 << 8;
  const auto dof = [&](std::int64_t stride) {
    return equivalent_dof({Estimator::oadev, kSamples, kFactor, 1, stride}, std::span(&white, 1));
  };
  for (const std::int64_t overlap : {1, 2, 4, 8, 16}) {
    const double exact = 1 - dof(kFactor / overlap) / dof(1);
    const double one_term = static_cast<double>(kFactor) / static_cast<double>(kSamples * overlap);
    EXPECT_NEAR(white_noise_loss(overlap), exact, one_term + white_noise_loss(kFactor)) << overlap;
  }
}

}  // namespace
}  // namespace gyrobudget::allan

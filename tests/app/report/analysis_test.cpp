// SPDX-License-Identifier: MIT
#include "gyrobudget/app/report/analysis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace gyrobudget::report {
namespace {

using allan::Estimator;
using testing::HasSubstr;

allan::Record record(const std::string& source, std::size_t samples) {
  std::vector<double> x(samples), y(samples);
  for (std::size_t k = 0; k < samples; ++k) {
    x[k] = static_cast<double>(k * k % 7);
    y[k] = 2 * x[k];
  }
  allan::Record made =
      allan::make_record({{"x", noise::Signal::angular_rate, x}, {"y", noise::Signal::specific_force, y}}, 10, source);
  made.notes = {"note of " + source};
  return made;
}

TEST(LogResult, OfOneRecordIsWhatItSays) {
  const std::vector<allan::Record> one{record("a.csv", 200)};
  const auto analysis = allan::analyse(
      one,
      {.estimators = {Estimator::oadev, Estimator::hdev}, .spectrum = allan::SpectrumMethod::welch, .window_s = 5});
  const LogResult result = log_result(one, analysis, "gyrobudget allan a.csv");
  EXPECT_EQ(result.source, "a.csv");
  EXPECT_EQ(result.command, "gyrobudget allan a.csv");
  EXPECT_EQ(result.rate_hz, 10);
  EXPECT_EQ(result.samples, 200);
  EXPECT_TRUE(result.segments.empty());
  EXPECT_THAT(result.notes, testing::ElementsAre("note of a.csv"));
  ASSERT_EQ(result.axes.size(), 4U);  // by column, then by estimator
  EXPECT_EQ(result.axes[1].name, "x");
  EXPECT_EQ(result.axes[1].estimator, Estimator::hdev);
  EXPECT_EQ(result.axes[2].signal, noise::Signal::specific_force);
  EXPECT_EQ(result.axes[2].mean, analysis.axes[1].mean);
  EXPECT_EQ(result.axes[3].points.size(), analysis.axes[1].curves[1].points.size());
  for (const std::size_t i : {0U, 2U}) {
    EXPECT_EQ(result.axes[i].psd->method, "welch");
    EXPECT_EQ(result.axes[i].dynamic->window_s, 5);
    EXPECT_FALSE(result.axes[i + 1].psd || result.axes[i + 1].dynamic);
  }
  const auto& variance = analysis.axes[0].surface->variance;
  ASSERT_EQ(result.axes[0].dynamic->deviation.size(), static_cast<std::size_t>(variance.rows()));
  EXPECT_EQ(result.axes[0].dynamic->deviation[1][2], std::sqrt(variance(1, 2)));
}

TEST(LogResult, OfSegmentsTellsWhatWasPooled) {
  const std::vector<allan::Record> two{record("a.csv", 200), record("b.csv", 300)};
  const auto analysis = allan::analyse(two, {.spectrum = allan::SpectrumMethod::multitaper});
  const LogResult logs = log_result(two, analysis, "");
  EXPECT_EQ(logs.source, "a.csv, b.csv");
  EXPECT_EQ(logs.samples, 500);
  ASSERT_EQ(logs.segments.size(), 2U);
  EXPECT_EQ(logs.segments[1].samples, 300);
  EXPECT_THAT(logs.notes, testing::ElementsAre("note of a.csv", "note of b.csv", HasSubstr("2 logs are pooled"),
                                               HasSubstr("those of the longest segment")));
  const std::vector<allan::Record> cut{record("a.csv", 200), record("a.csv", 300)};
  const LogResult segments = log_result(cut, allan::analyse(cut), "", Pooled::segments);
  EXPECT_EQ(segments.source, "a.csv");
  EXPECT_THAT(segments.notes.back(), HasSubstr("2 segments are pooled"));
}

TEST(LogResult, OfAStreamSaysWhatItCosts) {
  EXPECT_THAT(stream_note(16), HasSubstr("every m/16 samples above m = 16; that costs white noise 0.49 %"));
  EXPECT_THAT(stream_note(1), HasSubstr("56 %"));
}

}  // namespace
}  // namespace gyrobudget::report

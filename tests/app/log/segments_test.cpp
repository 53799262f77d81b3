// SPDX-License-Identifier: MIT
// Logs of several stretches, and readings at uneven times put on even ones.
#include "gyrobudget/app/log/log.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <random>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using allan::Record;
using log::Input;
using log::LogOptions;

class Segments : public TemporaryFolder {
 protected:
  [[nodiscard]] std::vector<Record> cut(std::string_view text, double gap_s, LogOptions options = {}) const {
    options.path = file("log.csv", text);
    return log::read_segments(options, gap_s);
  }
  [[nodiscard]] Record read(std::string_view text, LogOptions options) const {
    options.path = file("log.csv", text);
    return log::read_log(options);
  }
  template <class Read>
  static void expect_refused(Read read, const std::string& because) {
    try {
      read();
      ADD_FAILURE() << "nothing thrown, expected: " << because;
    } catch (const text::InputError& error) {
      EXPECT_CONTAINS(std::string(error.what()), because);
    }
  }
};

/// Rows "t,v" from `start` on, `rows` of them at 10 Hz, v counting up from `value`.
std::string rows(double start, int count, int value = 0) {
  std::string text;
  for (int i = 0; i < count; ++i) text += fmt::format("{:.1f},{}\n", start + 0.1 * i, value + i);
  return text;
}
const std::string kHead = "t (s),w (rad/s)\n";

std::string notes_of(const std::vector<Record>& records) {
  std::string all;
  for (const Record& record : records)
    for (const auto& note : record.notes) all += note + '\n';
  return all;
}

TEST_F(Segments, AreCutAtLongGapsAndWhereTimeGoesBack) {
  const auto text = kHead + rows(100, 50) + rows(200, 10, 500) + rows(300, 40, 1000) + rows(0, 60, 2000);
  const auto found = cut(text, 5);
  ASSERT_EQ(found.size(), 3U);
  EXPECT_EQ(found[0].samples, 50);
  EXPECT_EQ(found[1].samples, 40);
  EXPECT_EQ(found[2].samples, 60);
  EXPECT_EQ(found[1].axes[0].rate.front(), 1000);
  EXPECT_EQ(found[2].axes[0].rate.back(), 2059);
  EXPECT_EQ(found[0].first_row, 2);
  EXPECT_EQ(found[1].first_row, 62);
  EXPECT_NEAR(found[1].start_s, 200, 1e-9);
  EXPECT_NEAR(found[2].start_s, -100, 1e-9);
  for (const Record& record : found) EXPECT_EQ(record.rate_hz, found[2].rate_hz);
  const std::string notes = notes_of(found);
  EXPECT_CONTAINS(notes, "3 segments of 5 s, 4 s, 6 s");
  EXPECT_CONTAINS(notes, "time goes back 1 time");
  EXPECT_CONTAINS(notes, "1 piece below 32 rows left out (10 rows)");
}

TEST_F(Segments, ShortGapsStayAndAreMasked) {
  const auto found = cut(kHead + rows(0, 40) + rows(5, 40, 100), 2);  // one second is missing
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].samples, 90);
  EXPECT_EQ(found[0].missing_samples, 10);
  EXPECT_EQ(cut(kHead + rows(0, 40) + rows(5, 40, 100), 0.9).size(), 2U);
}

TEST_F(Segments, RowsWithoutNumbersAreAGapToo) {
  std::string text;
  for (int i = 0; i < 200; ++i) text += i >= 60 && i < 100 ? "nan\n" : fmt::format("{}\n", i);
  const auto found = cut(text, 2, {.rate_hz = 10, .unit = "rad/s"});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].samples, 60);
  EXPECT_EQ(found[1].samples, 100);
  EXPECT_EQ(found[1].missing_samples, 0);
  EXPECT_EQ(found[1].axes[0].rate.front(), 100);
  EXPECT_EQ(cut(text, 5, {.rate_hz = 10, .unit = "rad/s"}).size(), 1U);
}

TEST_F(Segments, NoAngleReachesAcrossACut) {
  const auto text = "t (s),a (rad)\n" + rows(0, 40) + rows(50, 40, 100'000);
  for (const Record& record : cut(text, 1, {.input = Input::angle})) {
    EXPECT_EQ(record.samples, 39);
    for (const double rate : record.axes[0].rate) EXPECT_NEAR(rate, 10, 1e-9);
  }
}

TEST_F(Segments, RefusalsSayWhatToDo) {
  expect_refused([&] { (void)cut(kHead + rows(0, 200), 0.05); }, "the longest has 1");
  std::string other = kHead + rows(0, 100);
  for (int i = 0; i < 50; ++i) other += fmt::format("{:.2f},1\n", 100 + 0.05 * i);
  expect_refused([&] { (void)cut(other, 5); }, "segments must have one rate");
  EXPECT_THROW((void)cut(kHead + rows(0, 50), 0), std::invalid_argument);
}

// --- Resampling -----------------------------------------------------------------------------------------------------

TEST_F(Segments, ResampledRatesAreMeansOfTheirIntervals) {
  const Record r = read("t (s),w (rad/s)\n0,1\n0.2,3\n0.9,5\n1.1,7\n2.5,10\n2.7,nan\n3.0,0\n3.1,0\n3.2,0\n4.05,9\n",
                        {.resample_hz = 1});
  EXPECT_EQ(r.rate_hz, 1);
  ASSERT_EQ(r.samples, 4);
  EXPECT_DOUBLE_EQ(r.axes[0].rate[0], 3);
  EXPECT_DOUBLE_EQ(r.axes[0].rate[1], 7);
  EXPECT_DOUBLE_EQ(r.axes[0].rate[2], 10);
  EXPECT_DOUBLE_EQ(r.axes[0].rate[3], 0);
  EXPECT_CONTAINS(r.notes.back(), "resampled to 1 Hz as asked");
}

TEST_F(Segments, ResampledAnglesKeepTheWholeTurn) {
  // A constant rate stays one whatever the times; a step longer than an interval takes its intervals away.
  std::string text = "t (s),a (rad)\n";
  for (const double t : {0., 0.3, 0.35, 0.9, 1.4, 1.7, 2.2, 2.9, 3.3, 4.9, 5.2, 5.5, 5.9, 6.2})
    text += fmt::format("{},{}\n", t, 2 * t);
  const Record r = read(text, {.input = Input::angle, .resample_hz = 1});
  ASSERT_EQ(r.samples, 6);
  for (const int k : {0, 1, 2, 5}) EXPECT_NEAR(r.axes[0].rate[k], 2, 1e-12) << k;
  EXPECT_TRUE(std::isnan(r.axes[0].rate[3]));
  EXPECT_TRUE(std::isnan(r.axes[0].rate[4]));
  EXPECT_EQ(r.missing_samples, 2);
}

/// Variance of neighbouring samples' differences over two: the Allan variance at the shortest tau.
double first_variance(const std::vector<double>& rate) {
  double sum = 0, terms = 0;
  for (std::size_t k = 0; k + 1 < rate.size(); ++k) {
    const double d = rate[k + 1] - rate[k];
    if (std::isfinite(d)) sum += d * d / 2, ++terms;
  }
  return sum / terms;
}

TEST_F(Segments, WhiteNoiseReadsAsTheNoteSays) {
  // 60 000 readings at uneven steps, a fifth to nine fifths of 10 ms: white rates, and increments of a random walk.
  constexpr int kReadings = 60'000;
  constexpr double kStep = 0.01, kRate = 25;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uneven(0.2, 1.8);
  std::string rates = "t (s),w (rad/s)\n", increments = "t (s),a (rad)\n";
  double t = 0;
  for (int k = 0; k < kReadings; ++k) {
    const double step = kStep * uneven(random);
    t += step;
    rates += fmt::format("{:.9f},{:.17g}\n", t, normal(random));
    increments += fmt::format("{:.9f},{:.17g}\n", t, std::sqrt(step) * normal(random));
  }
  // Standard error of the variance: 15 000 intervals, edf about two thirds of them: 1.4 %; 4 of them.
  constexpr double kScatter = 4 * 0.0141;
  const Record means = read(rates, {.resample_hz = kRate});
  double excess = 0;
  const std::string& note = means.notes.back();
  ASSERT_EQ(std::sscanf(note.c_str() + note.find("reads ") + 6, "%lf", &excess), 1);
  EXPECT_GT(excess, 1);
  EXPECT_NEAR(first_variance(means.axes[0].rate) / (kStep * kRate), std::pow(1 + excess / 100, 2), kScatter);

  const Record spread = read(increments, {.input = Input::increment, .resample_hz = kRate});
  const double low = kStep * (1 + 0.64 / 3) * kRate / 2;  // mean step^2 / mean step / (2 tau)
  EXPECT_NEAR(first_variance(spread.axes[0].rate) / kRate, 1 - low, kScatter);
  EXPECT_CONTAINS(spread.notes.back(), fmt::format("{:.2g} % low at 0.04 s", 100 * (1 - std::sqrt(1 - low))));
}

TEST_F(Segments, ResamplingInventsNothing) {
  const LogOptions fast{.resample_hz = 20};
  expect_refused([&] { (void)read(kHead + rows(0, 100), fast); }, "invents none; give a lower rate");
  expect_refused([&] { (void)read("1\n2\n3\n4\n", {.rate_hz = 1, .unit = "rad/s", .resample_hz = 1}); },
                 "no time column");
  expect_refused([&] { (void)read(kHead + rows(0, 100) + rows(5, 10), {.resample_hz = 2}); }, "goes back");
  expect_refused([&] { (void)read(kHead + rows(0, 1000) + rows(1000, 1000), {.resample_hz = 1}); }, "--segments");
  const auto text = kHead + rows(0, 1000) + rows(1000, 1000);
  const auto both = cut(text, 10, {.resample_hz = 1});
  ASSERT_EQ(both.size(), 2U);
  EXPECT_EQ(both[1].samples, 99);
  EXPECT_THROW((void)read(kHead + rows(0, 100), {.resample_hz = -1}), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::app_tests

// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/calibration/calibrate.h"

#include "gyrobudget/estimation/calibration/sensor_model.h"
#include "gyrobudget/estimation/calibration/several.h"

#include <gtest/gtest.h>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "../fit/sensors.h"
#include "records.h"

namespace gyrobudget::tests {
namespace {

using calibration::calibrate;
using calibration::Datasheet;
using calibration::Unusable;
using noise::Term;

allan::Record record_of(const std::string& name) {
  auto list = ten_records();
  return std::ranges::find(list, name, &NamedRecord::name)->record;
}

template <class Call>
Unusable::Reason reason_of(Call&& call) {
  try {
    call();
  } catch (const Unusable& error) {
    return error.reason;
  }
  ADD_FAILURE() << "nothing was refused";
  return Unusable::Reason::too_short;
}

// N of n samples of white noise has a relative standard deviation of about 1/sqrt(2 n) by likelihood; five of those,
// and as much again for the share of the other terms in the shortest taus.
double tolerance(std::int64_t samples) { return 10 / std::sqrt(2.0 * static_cast<double>(samples)); }

TEST(Calibrate, FindsTheNoiseOfACleanRecord) {
  const auto record = record_of("clean");
  const Datasheet sheet = calibrate(record);
  ASSERT_EQ(sheet.axes.size(), 1U);
  const auto& axis = sheet.axes[0];
  EXPECT_TRUE(axis.has_answer());
  EXPECT_TRUE(sheet.is_complete());
  EXPECT_FALSE(axis.findings->any());
  EXPECT_EQ(axis.fit.fitted_terms, (std::vector{Term::white, Term::flicker, Term::rate_random_walk}));
  EXPECT_NEAR(axis.fit[Term::white].value / mems().n, 1, tolerance(record.samples));
}

// What fit::fit alone does not see: a record of angle steps owes its short taus to quantization. Its square is known to
// sqrt(2/n) by likelihood, Q to half of that; five of those, and as much again for the white noise beside it.
TEST(Calibrate, AddsQuantizationWhereTheFirstTausShowIt) {
  const auto record = record_of("quantized");
  const auto sheet = calibrate(record);
  const auto& q = sheet.axes[0].fit[Term::quantization];
  ASSERT_TRUE(q.fitted);
  EXPECT_EQ(q.status, fit::Status::identified);
  EXPECT_NEAR(q.value / kQuantization, 1, 10 * std::sqrt(0.5 / static_cast<double>(record.samples)));
}

TEST(Calibrate, MasksWhatIsAskedFor) {
  const auto record = record_of("knocks");
  const auto as_it_is = calibrate(record);
  const auto masked = calibrate(record, {.mask = {.outliers = true}});
  EXPECT_EQ(as_it_is.axes[0].findings->outliers.size(), 5U);
  EXPECT_TRUE(as_it_is.axes[0].findings->outliers_spoil());
  EXPECT_TRUE(masked.axes[0].findings->outliers_masked);
  EXPECT_FALSE(masked.axes[0].findings->spoil());
  EXPECT_GT(as_it_is.axes[0].fit[Term::white].value, 1.1 * mems().n);
  EXPECT_NEAR(masked.axes[0].fit[Term::white].value / mems().n, 1, tolerance(record.samples));
}

TEST(Calibrate, NamesStepsWarmUpsAndLines) {
  EXPECT_EQ(calibrate(record_of("step")).axes[0].findings->steps.size(), 1U);
  const auto warm = calibrate(record_of("warm-up"), {.mask = {.warm_up = true}});
  ASSERT_TRUE(warm.axes[0].findings->departure);
  EXPECT_EQ(warm.axes[0].findings->departure->kind, allan::Departure::Kind::warm_up);
  EXPECT_GT(warm.axes[0].findings->first, 0);
  const auto line = calibrate(record_of("line"));
  ASSERT_FALSE(line.axes[0].findings->lines.empty());
  EXPECT_NEAR(line.axes[0].findings->lines.front().frequency_hz, 1.7, 0.01);
}

TEST(Calibrate, SaysThatASilentRecordHoldsNothing) {
  const auto sheet = calibrate(record_of("silent"));
  EXPECT_TRUE(sheet.axes[0].facts.all_equal);
  EXPECT_FALSE(sheet.axes[0].has_answer());
  EXPECT_FALSE(sheet.is_complete());
}

// A sinusoid is no random process: how long to record for B is asked of the others.
TEST(Calibrate, AdvisesOnLengthBesideASinusoid) {
  calibration::Options options;
  options.terms = std::vector{Term::white, Term::flicker, Term::rate_random_walk, Term::sinusoid};
  const auto sheet = calibrate(record_of("line"), options);
  const auto& axis = sheet.axes[0];
  EXPECT_EQ(axis.fit[Term::sinusoid].status, fit::Status::identified);
  EXPECT_FALSE(axis.facts.longer.empty());
  for (const auto& longer : axis.facts.longer) EXPECT_GT(longer.needed_s, longer.duration_s);
}

TEST(Calibrate, IsTheSameForAnyNumberOfThreads) {
  const auto record = record_of("three axes");
  const auto all = calibrate(record);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto alone = calibrate(record);
  for (std::size_t i = 0; i < all.axes.size(); ++i) {
    for (std::size_t k = 0; k < all.axes[i].fit.coefficients.size(); ++k) {
      EXPECT_EQ(all.axes[i].fit.coefficients[k].value, alone.axes[i].fit.coefficients[k].value);
      EXPECT_EQ(all.axes[i].fit.coefficients[k].upper, alone.axes[i].fit.coefficients[k].upper);
    }
  }
}

TEST(Calibrate, RefusesWhatNoDatasheetCanBeMadeOf) {
  const auto short_one = allan::make_record({gyro_axis(mems_rates(calibration::kFewestSamples - 1, 1))}, kRecordRate);
  EXPECT_EQ(reason_of([&] { (void)calibrate(short_one); }), Unusable::Reason::too_short);
  auto holes = mems_rates(400, 1);
  for (std::size_t i = 0; i < holes.size(); i += 3) holes[i] = std::numeric_limits<double>::quiet_NaN();
  const auto gaps = allan::make_record({gyro_axis(holes)}, kRecordRate);
  EXPECT_EQ(reason_of([&] { (void)calibrate(gaps); }), Unusable::Reason::too_few_taus);
  auto huge = mems_rates(400, 1);
  huge[7] = 10 * calibration::kLargestSample;
  const auto scale = allan::make_record({gyro_axis(huge)}, kRecordRate);
  EXPECT_EQ(reason_of([&] { (void)calibrate(scale); }), Unusable::Reason::out_of_scale);
}

TEST(Calibrate, ThrowsForRecordsThatAreNone) {
  allan::Record record = record_of("clean");
  record.rate_hz = 0;
  EXPECT_THROW((void)calibrate(record), std::invalid_argument);
  record.rate_hz = kRecordRate;
  record.samples += 1;
  EXPECT_THROW((void)calibrate(record), std::invalid_argument);
  EXPECT_THROW((void)allan::make_record({gyro_axis({1, 2}), gyro_axis({1})}, 1), std::invalid_argument);
  EXPECT_THROW((void)allan::make_record({}, -1), std::invalid_argument);
}

TEST(Record, CountsSamplesThatAnyAxisMisses) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const auto record = allan::make_record({gyro_axis({1, kNaN, 3, 4}), gyro_axis({kNaN, kNaN, 3, 4}, "y")}, 1, "bench");
  EXPECT_EQ(record.samples, 4);
  EXPECT_EQ(record.missing_samples, 2);
  EXPECT_EQ(record.source, "bench");
}

// The exact Allan deviation of white noise is N/sqrt(tau).
TEST(CalibrateTable, FindsTheNoiseOfATable) {
  allan::DeviationTable table{.source = "table", .tau_s = {}, .columns = {{.name = "x", .deviation = {}}}};
  const double n = 1e-4;
  for (double tau = 0.1; tau < 2000; tau *= 2) {
    table.tau_s.push_back(tau);
    table.columns[0].deviation.push_back(n / std::sqrt(tau));
  }
  const auto sheet = calibrate(table, kRecordRate, 36000);
  EXPECT_NEAR(sheet.axes[0].fit[Term::white].value / n, 1, 1e-6);  // the fit's own convergence
  EXPECT_FALSE(sheet.axes[0].findings);
  table.tau_s[1] = 0.25;
  EXPECT_EQ(reason_of([&] { (void)calibrate(table, kRecordRate, 36000); }), Unusable::Reason::between_samples);
}

TEST(CalibrateSeveral, CombinesRecordsOfOneTypeInTheOrderOfTheFirst) {
  const auto first = record_of("three axes");
  auto second = first;
  std::swap(second.axes[0], second.axes[2]);
  const std::vector records{first, second};
  const auto type = calibration::calibrate(records);
  ASSERT_EQ(type.axes.size(), 3U);
  EXPECT_EQ(type.axes[0].name, "gyro_x");
  EXPECT_EQ(type.records[1].axes[0].name, "gyro_x");
  const auto white = std::ranges::find(type.axes[0].coefficients, Term::white, &fit::Combined::term);
  ASSERT_NE(white, type.axes[0].coefficients.end());
  // Twice the same record is that record, to rounding of squares and their root.
  constexpr double kRounding = 1e-12;
  EXPECT_NEAR(white->value / type.records[0].axes[0].fit[Term::white].value, 1, kRounding);
  EXPECT_TRUE(type.is_complete());
}

// Like is compared with like: the record that begins earlier is fitted once more from where the other one begins.
TEST(CalibrateSeveral, ComparesFromOneStartOn) {
  const auto first = allan::make_record({gyro_axis(mems_rates(20000, 21))}, kRecordRate);
  const auto second = allan::make_record({gyro_axis(mems_rates(20000, 22))}, kRecordRate);
  calibration::Options later;
  later.tau_min_s = 0.8;
  const auto joined = calibration::combine({calibrate(first), calibrate(second, later)});
  const auto alike = calibration::combine({calibrate(first, later), calibrate(second, later)});
  ASSERT_TRUE(joined.axes[0].common_start_s);
  EXPECT_DOUBLE_EQ(*joined.axes[0].common_start_s, 0.8);
  EXPECT_FALSE(alike.axes[0].common_start_s);
  EXPECT_EQ(joined.records[0].axes[0].fit.tau_min_s, 1 / kRecordRate) << "each keeps its own datasheet";
  ASSERT_EQ(joined.axes[0].coefficients.size(), alike.axes[0].coefficients.size());
  for (std::size_t i = 0; i < alike.axes[0].coefficients.size(); ++i) {
    EXPECT_EQ(joined.axes[0].coefficients[i].value, alike.axes[0].coefficients[i].value);
    EXPECT_EQ(joined.axes[0].coefficients[i].p_value, alike.axes[0].coefficients[i].p_value);
  }
}

TEST(CalibrateSeveral, RefusesOtherAxesAndRates) {
  const auto first = calibrate(record_of("three axes"));
  auto other = record_of("clean");
  EXPECT_EQ(reason_of([&] { (void)calibration::matched(other, first); }), Unusable::Reason::other_axes);
  auto faster = record_of("three axes");
  faster.rate_hz *= 1 + 2 * calibration::kRateTolerance;
  EXPECT_EQ(reason_of([&] { (void)calibration::matched(faster, first); }), Unusable::Reason::other_rate);
  EXPECT_THROW((void)calibration::combine({}), std::invalid_argument);
}

constexpr double kSixDigits = 5e-6;  // to which a model is rounded

allan::Record triad(std::array<double, 3> grades, std::uint64_t seed, std::int64_t samples = 20000) {
  std::vector<allan::Axis> axes;
  for (std::size_t i = 0; i < grades.size(); ++i) {
    auto rate = mems_rates(samples, seed + i);
    for (double& y : rate) y *= grades[i];
    axes.push_back(gyro_axis(std::move(rate), std::string("gyro_") + "xyz"[i]));
  }
  return allan::make_record(std::move(axes), kRecordRate);
}

const calibration::TriadCoefficient& told(const calibration::SensorSummary& summary, Term term) {
  return *std::ranges::find(summary.coefficients, term, &calibration::TriadCoefficient::term);
}

// Spectra add up: axes that are alike have the root mean square of them all.
TEST(SensorModel, IsTheRootMeanSquareOfAxesThatAreAlike) {
  const auto sheet = calibrate(triad({1, 1, 1}, 100));
  const auto summary = calibration::summarise(sheet, "bench");
  EXPECT_EQ(summary.sensor.name, "bench");
  EXPECT_FALSE(summary.sensor.accelerometer);
  EXPECT_TRUE(summary.sensor.gyro.axes_are_alike());
  EXPECT_TRUE(summary.borrowed.empty());
  double squares = 0;
  for (const auto& axis : sheet.axes) squares += std::pow(axis.fit[Term::white].value, 2) / 3;
  EXPECT_NEAR(summary.sensor.gyro.white[0] / std::sqrt(squares), 1, kSixDigits);
  EXPECT_FALSE(told(summary, Term::white).per_axis);
}

// A fibre-optic z beside x and y of MEMS: an average would be far off on every axis.
TEST(SensorModel, HasAxesThatDifferOneByOne) {
  const auto sheet = calibrate(triad({1, 1, 0.01}, 110));
  const auto summary = calibration::summarise(sheet, "mixed");
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_NEAR(summary.sensor.gyro.white[i] / sheet.axes[i].fit[Term::white].value, 1, kSixDigits) << i;
  EXPECT_TRUE(told(summary, Term::white).per_axis);
  EXPECT_LT(told(summary, Term::white).p_value, 1e-9);
  // Axes are told by the last letter of their names, not by their order.
  auto turned = triad({1, 1, 0.01}, 110);
  std::rotate(turned.axes.begin(), turned.axes.begin() + 2, turned.axes.end());
  EXPECT_EQ(calibration::summarise(calibrate(turned), "mixed").sensor.gyro.white, summary.sensor.gyro.white);
}

// Two gyros of three, of grades 1 and 5, and one accelerometer: the others borrow.
TEST(SensorModel, AnAxisThatWasNotRecordedHasTheRootMeanSquareOfTheOthers) {
  const auto sheet = calibrate(record_of("three axes"));
  const auto summary = calibration::summarise(sheet, "bench");
  const double x = sheet.axes[0].fit[Term::white].value, y = sheet.axes[1].fit[Term::white].value;
  EXPECT_NEAR(summary.sensor.gyro.white[0] / x, 1, kSixDigits);
  EXPECT_NEAR(summary.sensor.gyro.white[1] / y, 1, kSixDigits);
  EXPECT_NEAR(summary.sensor.gyro.white[2] / std::sqrt((x * x + y * y) / 2), 1, kSixDigits);
  ASSERT_TRUE(summary.sensor.accelerometer);
  EXPECT_TRUE(summary.sensor.accelerometer->white.is_uniform());  // one tells nothing of a difference
  EXPECT_NEAR(summary.sensor.accelerometer->white[0] / sheet.axes[2].fit[Term::white].value, 1, kSixDigits);
  EXPECT_EQ(summary.borrowed, (std::vector<std::string>{"gyro z", "accelerometer y", "accelerometer z"}));
}

// Six gyros in one record, by names that tell no axis: nothing says which is x.
TEST(SensorModel, AxesWithoutPlacesStayOneValue) {
  auto record = triad({1, 1, 1}, 120, 4000);
  for (allan::Axis axis : triad({5, 5, 5}, 130, 4000).axes) record.axes.push_back(std::move(axis));
  for (std::size_t i = 0; i < record.axes.size(); ++i) record.axes[i].name = "rate " + std::to_string(i);
  const auto summary = calibration::summarise(calibrate(record), "two");
  EXPECT_TRUE(summary.sensor.gyro.white.is_uniform());
  EXPECT_EQ(summary.without_places, (std::vector<noise::Signal>{noise::Signal::angular_rate}));
}

TEST(SensorModel, KeepsTheLimitsOfWhatIsNotResolved) {
  const auto sheet = calibrate(triad({1, 1, 1}, 140, 2000));  // 200 s: no walk shows
  const auto summary = calibration::summarise(sheet, "short");
  double squares = 0;
  for (const auto& axis : sheet.axes) {
    ASSERT_NE(axis.fit[Term::rate_random_walk].status, fit::Status::identified) << "another seed is wanted";
    squares += std::pow(axis.fit[Term::rate_random_walk].upper, 2) / 3;
  }
  EXPECT_NEAR(summary.limits.gyro.rate_random_walk[1] / std::sqrt(squares), 1, kSixDigits);
  EXPECT_EQ(summary.limits.gyro.white, noise::PerAxis(0));  // resolved
}

// A walk that begins to show: whether the value of all three axes is resolved is told by all of them together. There
// are triads in which no axis shows it and all do, and others in which one does and all do not.
TEST(SensorModel, AWalkIsResolvedByAllAxesTogether) {
  constexpr std::size_t kTriads = 60;
  constexpr std::int64_t kSamples = 8000;
  std::array<int, kTriads> axes_that_show_it{};
  std::array<bool, kTriads> one_value{}, resolved{};
  tbb::parallel_for(std::size_t{0}, kTriads, [&](std::size_t i) {
    const auto sheet = calibrate(triad({1, 1, 1}, 5000 + 3 * i, kSamples));
    const auto summary = calibration::summarise(sheet, "weak");
    one_value.at(i) = !told(summary, Term::rate_random_walk).per_axis;
    resolved.at(i) = summary.limits.gyro.rate_random_walk[0] == 0;
    axes_that_show_it.at(i) = static_cast<int>(std::ranges::count_if(sheet.axes, [](const auto& axis) {
      return axis.fit[Term::rate_random_walk].status == fit::Status::identified;
    }));
  });
  int none_but_all = 0, one_but_not_all = 0;
  for (std::size_t i = 0; i < kTriads; ++i) {
    if (!one_value.at(i)) continue;
    none_but_all += axes_that_show_it.at(i) == 0 && resolved.at(i);
    one_but_not_all += axes_that_show_it.at(i) == 1 && !resolved.at(i);
    EXPECT_TRUE(resolved.at(i) || axes_that_show_it.at(i) < 3) << i;
  }
  EXPECT_GT(none_but_all, 0);
  EXPECT_GT(one_but_not_all, 0);
}

// Triads of equal axes are written axis by axis in one of 100: of 150 triads and two coefficients that are seen, 300 in
// all, 3 on average. More than 11 come by chance once in 10 000 times (Poisson).
TEST(SensorModel, EqualAxesAreToldApartInOneOfAHundred) {
  constexpr std::size_t kTriads = 150;
  constexpr std::int64_t kSamples = 10000;
  constexpr int kMost = 11;
  std::array<int, kTriads> told_apart{};
  tbb::parallel_for(std::size_t{0}, kTriads, [&](std::size_t i) {
    const auto summary = calibration::summarise(calibrate(triad({1, 1, 1}, 1000 + 3 * i, kSamples)), "many");
    told_apart.at(i) = told(summary, Term::white).per_axis + told(summary, Term::rate_random_walk).per_axis;
  });
  EXPECT_LE(std::accumulate(told_apart.begin(), told_apart.end(), 0), kMost);
}

TEST(SensorModel, OfASilentRecordHasNoAccelerometer) {
  EXPECT_FALSE(calibration::sensor_model(calibrate(record_of("silent")), "silent").accelerometer);
}

}  // namespace
}  // namespace gyrobudget::tests

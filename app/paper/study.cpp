// SPDX-License-Identifier: MIT
#include "study.h"

#include "gyrobudget/allan/confidence.h"
#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/estimation/fit/visual.h"
#include "gyrobudget/noise/bielas.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/imu_sensor.h"
#include "gyrobudget/noise/jerath.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "flight.h"

namespace gyrobudget::inline v0::paper {
namespace {

using noise::Term;
using report::PaperRow;

constexpr double kRate = 100, kDt = 1 / kRate, kDuration = 36'000;
constexpr auto kSamples = static_cast<std::int64_t>(kRate * kDuration);
constexpr std::int64_t kTausRead = 65;  // ten a decade
constexpr std::array kTerms{Term::white, Term::flicker, Term::rate_random_walk};
constexpr std::array kKeys{"arw", "bias_instability", "rrw"};
constexpr std::array kCoefficientNames{"ARW", "bias instability", "RRW"};  // as the paper heads its columns

// Streams of random numbers, one block for each part of the study.
constexpr std::uint64_t kRecordStreams = 0, kScatterStreams = 1000, kDriftStreams = 100'000;
constexpr std::uint64_t kFasterStreams = 200'000, kStreamsEach = 10'000;

/// N, B and K, SI; by the definitions of IEEE Std 952 where not said otherwise.
struct Coefficients {
  double n = 0, b = 0, k = 0;
  [[nodiscard]] double operator[](std::size_t i) const { return i == 0 ? n : i == 1 ? b : k; }
};

double si(double value, std::string_view unit) { return value * noise::parse_unit(unit).to_si; }

std::string_view unit_of(std::size_t i) { return noise::datasheet_unit(noise::Signal::angular_rate, kTerms[i]); }

Coefficients coefficients(double arw, double bias_instability, double rrw) {
  return {si(arw, unit_of(0)), si(bias_instability, unit_of(1)), si(rrw, unit_of(2))};
}

/// A row of table I: what was fed in, what the paper read, and the noise that the model makes of it.
struct Simulation {
  std::string id, name;
  Coefficients reference;           ///< fed in
  std::array<double, 3> published;  ///< read by the paper, datasheet units
  std::array<double, 3> errors;     ///< table II [%]; all 0: not there
  noise::Model model;
  Coefficients actual;  ///< what its noise holds
  std::array<std::string, 3> why;
};

// --- The four records and their reasons ------------------------------------------------------------------------------

const std::string kCrossing =
    "The smallest deviation is not 0.664 B but the crossing of white noise and random walk, sqrt(2 N K/sqrt 3 + 0.441 B^2)";

Simulation model1(const Coefficients& ifog) {
  return {
      "model1",
      "model 1, IFOG",
      ifog,
      {5.40e-4, 8.11e-3, 4.51e-2},
      {0.05, 376.99, 4.37},
      noise::Jerath{.arw = ifog.n, .bias_instability = ifog.b, .rrw = ifog.k}.model(kDt),
      ifog,
      {"White noise of density N is what the model makes and what a reading at 1 s gives.",
       kCrossing + "; B has 4.5 % of that square. The error is the reader's, whatever the record.",
       "The +1/2 slope rests on the few independent stretches at the end of 10 h: a reading of K scatters by a quarter."}};
}

Simulation model2(const Coefficients& ifog) {
  using std::numbers::sqrt2;
  const noise::ImuSensor sensor{
      .noise_density = {ifog.n, 0, 0}, .bias_instability = {ifog.b, 0, 0}, .random_walk = {ifog.k, 0, 0}};
  return {
      "model2",
      "model 2, IFOG",
      ifog,
      {3.81e-4, 7.93e-3, 5.86e-2},
      {-29.46, 366.44, 35.74},
      sensor.model(0, kDt),
      {ifog.n / sqrt2, 0, ifog.k * sqrt2},
      {"imuSensor's default noise type is double-sided: N is the given density over sqrt 2, -29.29 %.",
       kCrossing +
           ". The noise type leaves N K alone; the default 1/f filter of one tap has no floor, so B has no part in it.",
       "The same double-sided default makes K sqrt 2 larger, +41.42 %; the rest is the scatter of one reading, a quarter."}};
}

noise::Model legacy(const Coefficients& given) {
  return noise::Bielas{.arw = given.n, .bias_instability = given.b}.model(kDt);
}

const std::string kNoFloor =
    "Model 3 integrates B into a random walk and has no 1/f noise. " + kCrossing + ", here of N and K = 60 B sqrt(dt).";

Simulation model3(const Coefficients& ifog) {
  return {
      "model3",
      "model 3, IFOG",
      ifog,
      {5.40e-4, 3.77e-3, 1.10e-2},
      {-0.02, 121.70, -74.49},
      legacy(ifog),
      {ifog.n, 0, ifog.b * std::sqrt(kDt)},
      {"White noise of density N is what the model makes and what a reading at 1 s gives.", kNoFloor,
       "The K fed in is not used: B, taken per sample and integrated, walks by 60 B sqrt(dt) deg/h/sqrt(h), 6 B at 100 Hz. Another sample rate gives another K. The rest is scatter."}};
}

Simulation mems(const Coefficients& given) {
  return {
      "mems",
      "MEMS, model 3",
      given,
      {0.15, 1.28, 4.32},
      {},
      legacy(given),
      {given.n, 0, given.b * std::sqrt(kDt)},
      {"White noise of density N is what the model makes and what a reading at 1 s gives.", kNoFloor,
       "60 B sqrt(dt) again, 6 B = 4.20 at 100 Hz. The table's reference value 4.32 has no other source than this reading."}};
}

std::vector<Simulation> simulations() {
  const Coefficients ifog = coefficients(5.4e-4, 1.7e-3, 4.32e-2);
  return {model1(ifog), model2(ifog), model3(ifog), mems(coefficients(0.15, 0.70, 4.32))};
}

// --- Theory ----------------------------------------------------------------------------------------------------------

/// What reading the three points gives on average: N, the crossing over 0.664, K.
Coefficients expected_reading(const Coefficients& c) {
  const double flat = 2 * std::numbers::ln2 / std::numbers::pi;
  return {c.n, std::sqrt((2 * c.n * c.k / std::numbers::sqrt3 + flat * c.b * c.b) / flat), c.k};
}

std::vector<noise::Process> processes(const Coefficients& c) {
  return {noise::White{c.n}, noise::Flicker{c.b}, noise::RateRandomWalk{c.k}};
}

// --- Records ---------------------------------------------------------------------------------------------------------

Coefficients values(const fit::Result& result) {
  return {result[Term::white].value, result[Term::flicker].value, result[Term::rate_random_walk].value};
}

/// Extremes of each of `parts` stretches.
void trace(const std::vector<double>& rate, std::size_t parts, report::PaperRecord& record) {
  const std::size_t length = rate.size() / parts;
  record.trace_step_s = static_cast<double>(length) * kDt;
  for (std::size_t i = 0; i < parts; ++i) {
    const auto begin = rate.begin() + static_cast<std::ptrdiff_t>(i * length);
    const auto [low, high] = std::minmax_element(begin, begin + static_cast<std::ptrdiff_t>(length));
    record.trace_low.push_back(*low);
    record.trace_high.push_back(*high);
  }
}

report::PaperRecord record_of(const Simulation& s, noise::StreamKey key) {
  constexpr std::size_t kTraceParts = 720;
  std::vector<double> rate(static_cast<std::size_t>(kSamples));
  noise::Generator(s.model.processes, s.model.filters, kDt, {.key = key, .longest_tau = kDuration}).next(rate);
  const auto curve = allan::overlapped_variance(rate, kDt, allan::log_factors(kSamples, kTausRead));
  const auto octaves = allan::overlapped_variance(rate, kDt, allan::octave_factors(kSamples));

  report::PaperRecord record{.id = s.id, .reading = fit::read_visually(curve)};
  record.axis.name = s.name;
  record.axis.mean = curve.mean;
  record.axis.fit = fit::fit(octaves);
  record.axis.points = allan::deviation_points(curve, {}, processes(s.actual));
  const noise::ModelMoments moments(s.model, kDt);
  for (const auto& p : record.axis.points) {
    record.exact.push_back(std::sqrt(moments.allan_variance(p.m, kSamples)));
  }
  trace(rate, kTraceParts, record);
  return record;
}

// --- How far one reading scatters -----------------------------------------------------------------------------------

using Scatters = std::array<PaperRow::Scatter, 3>;

PaperRow::Scatter middle(std::vector<double> readings) {
  std::ranges::sort(readings);
  const auto at = [&](double part) {
    return readings[static_cast<std::size_t>(std::lround(part * static_cast<double>(readings.size() - 1)))];
  };
  return {at(0.025), at(0.975)};
}

/// N from its degrees of freedom at 1 s; B and K, whose long taus need no more, from records at 1 Hz.
Scatters scatters(const Simulation& s, std::uint64_t seed, std::uint64_t stream) {
  constexpr std::size_t kRuns = 200;
  constexpr auto kSlow = static_cast<std::int64_t>(kDuration);  // samples at 1 Hz
  const auto factors = allan::log_factors(kSlow, 44);           // ten a decade
  const noise::RecordGenerator generator(processes(s.actual), kSlow, 1);
  std::vector<double> b(kRuns), k(kRuns);
  tbb::parallel_for(std::size_t{0}, kRuns, [&](std::size_t i) {
    const auto rate = generator({seed, stream + i});
    const auto reading = values(fit::read_visually(allan::overlapped_variance(rate, 1, factors)));
    b[i] = reading.b;
    k[i] = reading.k;
  });
  const double edf = allan::equivalent_dof(kSamples, static_cast<std::int64_t>(kRate), kDt, processes(s.actual));
  const double spread = 1.96 / std::sqrt(2 * edf);
  return {PaperRow::Scatter{s.actual.n * (1 - spread), s.actual.n * (1 + spread)}, middle(b), middle(k)};
}

// --- Rows of tables I and II and figures 6 and 7 --------------------------------------------------------------------

PaperRow table1_row(const Simulation& s, const report::PaperRecord& record, const Scatters& scatter, std::size_t i) {
  const std::string unit(unit_of(i));
  const auto out = [&](double value) { return noise::from_si(value, unit); };
  const fit::Coefficient& fitted = (*record.axis.fit)[kTerms[i]];
  return {.id = fmt::format("table1.{}.{}", s.id, kKeys[i]),
          .group = s.name,
          .what = kCoefficientNames[i],
          .unit = unit,
          .published = s.published[i],
          .ours = out(values(record.reading)[i]),
          .theory = out(expected_reading(s.actual)[i]),
          .scatter = PaperRow::Scatter{out(scatter[i].low), out(scatter[i].high)},
          .fitted = PaperRow::Fitted{out(fitted.value), out(fitted.lower), out(fitted.upper), out(s.actual[i]),
                                     fitted.status},
          .why = s.why[i]};
}

/// The same as an error against what was fed in.
PaperRow table2_row(const Simulation& s, const PaperRow& of, std::size_t i) {
  const double reference = noise::from_si(s.reference[i], of.unit);
  const auto error = [&](double value) { return 100 * (value / reference - 1); };
  PaperRow row = of;
  row.id = fmt::format("table2.{}.{}", s.id, kKeys[i]);
  row.unit = std::string(1, '%');
  row.published = s.errors[i];
  row.ours = error(of.ours);
  row.theory = error(of.theory);
  row.scatter = PaperRow::Scatter{error(of.scatter->low), error(of.scatter->high)};
  row.fitted = PaperRow::Fitted{error(of.fitted->value), error(of.fitted->lower), error(of.fitted->upper),
                                error(of.fitted->actual), of.fitted->status};
  return row;
}

/// Figure 6 prints no number; the height of its band is the deviation at one sample.
PaperRow figure6_row(const Simulation& s, const report::PaperRecord& record) {
  const std::string unit(unit_of(1));
  return {.id = fmt::format("fig6.{}.sample_std", s.id),
          .group = s.name,
          .what = "standard deviation of a sample",
          .unit = unit,
          .ours = noise::from_si(record.axis.points.front().deviation, unit),
          .theory = noise::from_si(record.exact.front(), unit),
          .why = "The height of the band in the figure: N sqrt(100 Hz), with sqrt 2 less for model 2."};
}

std::array<PaperRow, 2> figure7_rows(const Simulation& s, const report::PaperRecord& record) {
  const std::string unit(unit_of(1));
  const double flat = std::sqrt(2 * std::numbers::ln2 / std::numbers::pi);
  return {
      PaperRow{.id = fmt::format("fig7.{}.minimum", s.id),
               .group = s.name,
               .what = "smallest deviation",
               .unit = unit,
               .ours = noise::from_si(record.reading.minimum_deviation, unit),
               .theory = noise::from_si(flat * expected_reading(s.actual).b, unit),
               .why = kCrossing + "."},
      PaperRow{
          .id = fmt::format("fig7.{}.minimum_tau", s.id),
          .group = s.name,
          .what = "its averaging time",
          .unit = "s",
          .ours = record.reading.minimum_tau_s,
          .theory = std::numbers::sqrt3 * s.actual.n / s.actual.k,
          .why =
              "Where white noise and random walk cross: sqrt 3 N/K. The bottom is flat, so its place is read to a factor of 2 only."}};
}

// --- Figures 3 and 4 ------------------------------------------------------------------------------------------------

constexpr std::size_t kDriftRuns = 1000, kRunsShown = 40, kDriftTimes = 60;
constexpr double kBandwidth = 5, kFaster = 10, kDriftDuration = 3600;

/// Angles at kDriftTimes times of one run: equation (2) of the paper, one draw of its sigma a sample.
std::vector<double> angles(double arw, double rate_hz, noise::StreamKey key) {
  const double sigma = arw * std::sqrt(kBandwidth);
  const auto each = static_cast<std::size_t>(kDriftDuration * rate_hz) / kDriftTimes;
  std::vector<double> draws(each), result;
  double angle = 0;
  for (std::size_t i = 0; i < kDriftTimes; ++i) {
    noise::fill_normal(key, i * each, draws);
    for (const double u : draws) angle += sigma * u / rate_hz;
    result.push_back(angle);
  }
  return result;
}

std::vector<std::vector<double>> drift_runs(double arw, double rate_hz, std::uint64_t seed, std::uint64_t stream) {
  std::vector<std::vector<double>> runs(kDriftRuns);
  tbb::parallel_for(std::size_t{0}, kDriftRuns, [&](std::size_t i) {
    runs[i] = angles(arw, rate_hz, {seed, stream + i});
  });
  return runs;
}

/// Of all runs at one time; their mean is known to be zero.
double rms_at(const std::vector<std::vector<double>>& runs, std::size_t time) {
  double sum = 0;
  for (const auto& run : runs) sum += run[time] * run[time];
  return std::sqrt(sum / static_cast<double>(runs.size()));
}

report::PaperDrift drift(const std::string& id, const std::string& name, double arw, std::uint64_t seed,
                         std::uint64_t index) {
  auto runs = drift_runs(arw, kBandwidth, seed, kDriftStreams + index * kStreamsEach);
  report::PaperDrift result{.id = id, .name = name, .arw = arw};
  for (std::size_t i = 0; i < kDriftTimes; ++i) {
    result.time_s.push_back(kDriftDuration * static_cast<double>(i + 1) / kDriftTimes);
    result.std.push_back(rms_at(runs, i));
  }
  for (const auto& run : runs) result.final.push_back(run.back());
  const auto faster = drift_runs(arw, kFaster, seed, kFasterStreams + index * kStreamsEach);
  result.final_std_faster = rms_at(faster, kDriftTimes - 1);
  runs.resize(kRunsShown);
  result.runs = std::move(runs);
  return result;
}

std::array<PaperRow, 3> drift_rows(const report::PaperDrift& d, double published) {
  const double theory = noise::from_si(d.arw, "deg/sqrt(h)");  // times sqrt(1 h)
  const double spread = 1.96 / std::sqrt(2.0 * kDriftRuns);
  const auto around = [&](double value) { return PaperRow::Scatter{value * (1 - spread), value * (1 + spread)}; };
  const double slower = theory * std::sqrt(kBandwidth / kFaster);
  constexpr std::size_t kTenth = kDriftTimes / 10 - 1;
  return {
      PaperRow{.id = fmt::format("fig3.{}.growth", d.id),
               .group = d.name,
               .what = "growth from 6 min to 1 h",
               .unit = "1",
               .ours = std::log10(d.std.back() / d.std[kTenth]),
               .theory = 0.5,
               .why = "The exponent of time: an integrated white noise grows as the root of time."},
      PaperRow{
          .id = fmt::format("fig4.{}.std", d.id),
          .group = d.name,
          .what = "standard deviation",
          .unit = "deg",
          .published = published,
          .ours = noise::from_si(d.std.back(), "deg"),
          .theory = theory,
          .scatter = around(theory),
          .why =
              "ARW sqrt(1 h), as the paper says; it needs one draw of equation (2) every 1/bandwidth. 1000 runs scatter by 2 %."},
      PaperRow{
          .id = fmt::format("fig4.{}.std_at_10_hz", d.id),
          .group = d.name,
          .what = "the same sigma, drawn at 10 Hz",
          .unit = "deg",
          .ours = noise::from_si(d.final_std_faster, "deg"),
          .theory = slower,
          .scatter = around(slower),
          .why =
              "The bandwidth in equation (2) must be the sample rate: with 5 Hz in it and 10 draws a second, sqrt(5/10) of the drift is left."}};
}

noise::ErrorModel gyro_of(const Simulation& s) {
  noise::ErrorModel gyro;
  gyro.white = s.actual.n;
  gyro.rate_random_walk = s.actual.k;
  return gyro;
}

/// "fig3" of "fig3.mems.growth".
std::string figure_of(const PaperRow& row) { return row.id.substr(0, row.id.find('.')); }

}  // namespace

report::Paper paper_study(std::uint64_t seed) {
  const auto list = simulations();
  report::Paper paper{
      .seed = seed, .rate_hz = kRate, .duration_s = kDuration, .bandwidth_hz = kBandwidth, .faster_hz = kFaster};
  paper.records.resize(list.size());
  std::vector<Scatters> scatter(list.size());
  tbb::parallel_for(std::size_t{0}, list.size(), [&](std::size_t i) {
    paper.records[i] = record_of(list[i], {seed, kRecordStreams + i});
    scatter[i] = scatters(list[i], seed, kScatterStreams + i * kStreamsEach);
  });
  paper.drifts = {drift("mems", "MEMS", list[3].reference.n, seed, 0),
                  drift("ifog", "IFOG", list[0].reference.n, seed, 1)};

  for (std::size_t s = 0; s < list.size(); ++s) {
    for (std::size_t i = 0; i < kTerms.size(); ++i) {
      paper.rows.push_back(table1_row(list[s], paper.records[s], scatter[s], i));
    }
  }
  for (std::size_t s = 0; s < 3; ++s) {
    for (std::size_t i = 0; i < kTerms.size(); ++i) {
      paper.rows.push_back(table2_row(list[s], paper.rows[3 * s + i], i));
    }
  }
  const auto add = [&](const auto& rows) { paper.rows.insert(paper.rows.end(), rows.begin(), rows.end()); };
  const auto figures = static_cast<std::ptrdiff_t>(paper.rows.size());
  add(drift_rows(paper.drifts[0], 0.15));
  add(drift_rows(paper.drifts[1], 5.4e-4));
  for (std::size_t s = 0; s < 3; ++s) paper.rows.push_back(figure6_row(list[s], paper.records[s]));
  for (std::size_t s = 0; s < list.size(); ++s) add(figure7_rows(list[s], paper.records[s]));
  std::stable_sort(paper.rows.begin() + figures, paper.rows.end(),
                   [](const PaperRow& a, const PaperRow& b) { return figure_of(a) < figure_of(b); });
  auto flown = paper_flight({gyro_of(list[2]), gyro_of(list[3])}, seed);
  add(flown.rows);
  paper.flight = std::move(flown.flight);
  return paper;
}

}  // namespace gyrobudget::inline v0::paper

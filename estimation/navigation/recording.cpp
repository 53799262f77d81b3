// SPDX-License-Identifier: MIT
#include "recording.h"

#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

using Rates = Eigen::Matrix<double, 6, 1>;  // w, f
double seconds(std::int64_t ns) { return static_cast<double>(ns) * noise::kNanosecond; }

void check(const ImuSamples& samples) {
  const std::size_t n = samples.stamps.size();
  if (samples.values.size() != n)
    throw RecordingError(fmt::format("{} samples for {} stamps", samples.values.size(), n));
  if (n < 2) throw RecordingError(fmt::format("an IMU log of {} samples, expected 2 or more", n));
  for (std::size_t k = 1; k < n; ++k) {
    if (samples.stamps[k] <= samples.stamps[k - 1])
      throw RecordingError(fmt::format("IMU sample {} is {:.9f} s after the one before, expected times that ascend", k,
                                       seconds(samples.stamps[k] - samples.stamps[k - 1])));
  }
}

std::int64_t median_step(const std::vector<std::int64_t>& stamps) {
  std::vector<std::int64_t> steps(stamps.size() - 1);
  for (std::size_t k = 0; k < steps.size(); ++k) steps[k] = stamps[k + 1] - stamps[k];
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  return *middle;
}

bool is_gap(std::int64_t step, std::int64_t median) { return 2 * step > 3 * median; }

// Mean rates over an interval; NaN where no sample tells them.
struct Interval {
  std::int64_t from, to;
  Rates rates;
  bool bridged;
};

Rates rates_of(const noise::ImuIncrement& value) {
  Rates rates;
  rates << earth::vector(value.angle), earth::vector(value.velocity);
  return rates;
}

const Rates kUnknown = Rates::Constant(std::numeric_limits<double>::quiet_NaN());

// Each sample over its own interval, gaps between them unknown.
std::vector<Interval> intervals_of_means(const ImuSamples& samples, std::int64_t median) {
  std::vector<Interval> result;
  const auto add = [&](std::int64_t from, std::int64_t to, Rates rates) {
    if (samples.gyro == SampleKind::increment) rates.head<3>() /= seconds(to - from);
    if (samples.accelerometer == SampleKind::increment) rates.tail<3>() /= seconds(to - from);
    const bool known = rates.allFinite();
    result.push_back({from, to, known ? rates : kUnknown, !known});
  };
  const std::size_t n = samples.stamps.size();
  const bool ends = samples.stamp == StampAt::end;
  for (std::size_t k = 0; k < n; ++k) {
    const std::int64_t stamp = samples.stamps[k];
    const bool has_neighbour = ends ? k > 0 : k + 1 < n;
    const std::int64_t neighbour =
        !has_neighbour ? (ends ? stamp - median : stamp + median) : samples.stamps[ends ? k - 1 : k + 1];
    const bool gap = is_gap(std::abs(neighbour - stamp), median);
    const std::int64_t own = gap ? (ends ? stamp - median : stamp + median) : neighbour;
    if (gap && ends) result.push_back({neighbour, own, kUnknown, true});
    add(std::min(own, stamp), std::max(own, stamp), rates_of(samples.values[k]));
    if (gap && !ends) result.push_back({own, neighbour, kUnknown, true});
  }
  return result;
}

// The trapezoidal rule between samples that are complete.
std::vector<Interval> intervals_of_instants(const ImuSamples& samples, std::int64_t median) {
  std::vector<Interval> result;
  std::size_t last = samples.stamps.size();
  for (std::size_t k = 0; k < samples.stamps.size(); ++k) {
    const Rates rates = rates_of(samples.values[k]);
    if (!rates.allFinite()) continue;
    if (last < k) {
      const std::int64_t from = samples.stamps[last], to = samples.stamps[k];
      result.push_back({from, to, (rates_of(samples.values[last]) + rates) / 2, is_gap(to - from, median)});
    }
    last = k;
  }
  return result;
}

// Straight lines through what is unknown, and nothing of it at either end.
void bridge(std::vector<Interval>& intervals) {
  const auto known = [](const Interval& i) { return i.rates.allFinite(); };
  intervals.erase(intervals.begin(), std::ranges::find_if(intervals, known));
  while (!intervals.empty() && !known(intervals.back())) intervals.pop_back();
  const auto middle = [](const Interval& i) { return seconds(i.from) / 2 + seconds(i.to) / 2; };
  for (std::size_t k = 1; k < intervals.size(); ++k) {
    if (known(intervals[k])) continue;
    const Interval& before = intervals[k - 1];  // bridged itself where the run is longer
    std::size_t next = k;
    while (!known(intervals[next])) ++next;
    const double part = (middle(intervals[k]) - middle(before)) / (middle(intervals[next]) - middle(before));
    intervals[k].rates = before.rates + part * (intervals[next].rates - before.rates);
  }
}

}  // namespace

bool take_off_temperature(ImuSamples& samples, const noise::SensorModel& sensor) {
  const bool known = sensor.gyro.temperature || (sensor.accelerometer && sensor.accelerometer->temperature);
  if (samples.temperature.empty() || !known) return false;
  if (samples.temperature.size() != samples.stamps.size())
    throw RecordingError(
        fmt::format("{} temperatures for {} samples", samples.temperature.size(), samples.stamps.size()));
  constexpr double kMean = 10;  // [s]
  const auto time = [&](std::size_t k) { return static_cast<double>(samples.stamps[k] - samples.stamps[0]) * 1e-9; };
  std::vector<double> times, means;
  double sum = 0, middle = 0, from = 0;
  std::size_t count = 0;
  for (std::size_t k = 0; k < samples.stamps.size(); ++k) {
    const bool last = k + 1 == samples.stamps.size();
    if (std::isfinite(samples.temperature[k])) sum += samples.temperature[k], middle += time(k), ++count;
    if ((!last && time(k) - from < kMean) || count == 0) continue;
    const auto n = static_cast<double>(count);
    if (times.empty() || middle / n > times.back()) times.push_back(middle / n), means.push_back(sum / n);
    from = time(k), sum = middle = 0, count = 0;
  }
  if (times.size() < 2) return false;
  const noise::TemperatureProfile profile(times, means);
  const double interval = time(samples.stamps.size() - 1) / static_cast<double>(samples.stamps.size() - 1);
  const auto take_off = [&](const std::optional<noise::TemperatureModel>& model, SampleKind kind,
                            noise::Vector3 noise::ImuIncrement::*triad) {
    if (!model) return;
    const double dt = kind == SampleKind::increment ? interval : 1;
    for (std::size_t k = 0; k < samples.values.size(); ++k) {
      const double degrees = profile.at(time(k)), slope = profile.slope(time(k));
      for (std::size_t i = 0; i < 3; ++i) (samples.values[k].*triad)[i] -= dt * model->bias(i, degrees, slope);
    }
  };
  take_off(sensor.gyro.temperature, samples.gyro, &noise::ImuIncrement::angle);
  if (sensor.accelerometer)
    take_off(sensor.accelerometer->temperature, samples.accelerometer, &noise::ImuIncrement::velocity);
  return true;
}

ImuLog imu_log(const ImuSamples& samples) {
  check(samples);
  const std::int64_t median = median_step(samples.stamps);
  const bool instants = samples.gyro == SampleKind::instant || samples.accelerometer == SampleKind::instant;
  if (instants && samples.gyro != samples.accelerometer)
    throw RecordingError(
        "the gyro's and the accelerometer's samples are of different kinds: either both or none can be of instants");
  std::vector<Interval> intervals =
      instants ? intervals_of_instants(samples, median) : intervals_of_means(samples, median);
  bridge(intervals);
  if (intervals.empty())
    throw RecordingError("no IMU sample has all six numbers, expected three rates and three forces");

  ImuLog log;
  log.typical_interval = seconds(median);
  log.stamps.push_back(intervals.front().from);
  double gap = 0;
  for (const Interval& i : intervals) {
    const double dt = seconds(i.to - i.from);
    log.stamps.push_back(i.to);
    log.increments.push_back(
        {.angle = earth::array(i.rates.head<3>() * dt), .velocity = earth::array(i.rates.tail<3>() * dt)});
    log.bridged.push_back(i.bridged);
    if (i.bridged && gap == 0) ++log.gaps;
    gap = i.bridged ? gap + dt : 0;
    log.longest_gap = std::max(log.longest_gap, gap);
    if (i.bridged) log.bridged_seconds += dt;
  }
  return log;
}

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
#include "recorder.h"

#include "gyrobudget/noise/detail/check.h"
#include "gyrobudget/noise/detail/streams.h"
#include "gyrobudget/noise/normal.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace gyrobudget::inline v0::noise {
namespace {

// Streams of what a recorder draws, apart from those of processes, which have the letters of their terms.
constexpr char kOutlierPlaces = 'o', kOutlierSizes = 'p', kOffset = 'r', kGaps = 'm';

void check(const Recorder& r) {
  constexpr int kMost = 1000;
  for (const auto& [what, count] : {std::pair{"decimation", r.decimation}, {"rows that a reading holds", r.held}})
    detail::require(count >= 1 && count <= kMost, what, count, "from 1 to 1000");
  for (const auto& [what, share] : {std::pair{"share of outliers", r.outliers}, {"share of gaps", r.gaps}})
    detail::require(share >= 0 && share < 1, what, share, "from 0 to 1");
  for (const auto& [what, size] :
       {std::pair{"warm-up", r.warm_up}, {"knock", r.knock}, {"step of the rounding", r.rounding}})
    detail::require(size >= 0 && std::isfinite(size), what, size, "a finite number of standard deviations from 0 on");
}

std::vector<Process> behind(std::span<const Process> processes, const std::optional<FrontEnd>& front_end) {
  std::vector<Process> result(processes.begin(), processes.end());
  for (Process& process : result)
    if (front_end && term(process) == Term::white) process = FilteredWhite{coefficient(process), *front_end};
  return result;
}

/// As it is at the rate at which the sensor samples.
std::optional<FrontEnd> sampled(const Recorder& recorder) {
  std::optional<FrontEnd> front_end = recorder.front_end;
  if (front_end && recorder.decimation > 1) front_end->sampling = FrontEnd::Sampling::bilinear;
  return front_end;
}

/// Variance of a sample of white noise, filtered or not: the mean of its spectrum over frequency.
double sample_variance(const Process& process, double dt) {
  constexpr int kPoints = 1 << 13;
  if (term(process) != Term::white) return 0;
  double sum = 0;
  for (int j = 0; j < kPoints; ++j) sum += psd(process, (j + 0.5) / (2 * kPoints * dt), dt);
  return sum / (kPoints * dt);
}

}  // namespace

RecorderGenerator::RecorderGenerator(std::span<const Process> processes, const Recorder& recorder, std::int64_t samples,
                                     double dt)
    : recorder_((check(recorder), recorder)),
      dt_(dt),
      processes_(behind(processes, recorder.front_end)),
      generator_(behind(processes, sampled(recorder)), samples * recorder.decimation, dt / recorder.decimation) {
  const double faster = dt / recorder.decimation;
  for (const Process& process : behind(processes, sampled(recorder)))
    sigma_ = std::hypot(sigma_, std::sqrt(sample_variance(process, faster)));
  set_noise_of_log();
}

// A row that repeats the one before it has its neighbour's weight in any sum: the weights 1, ..., 2, 0 of a cycle of h
// mix the spectrum at the multiples of 1/h into that at 0.
void RecorderGenerator::set_noise_of_log() {
  const double h = recorder_.held, rate = 1 / dt_, step = recorder_.rounding * sigma_;
  for (Process& process : processes_) {
    if (term(process) != Term::white) continue;
    const double filtered = coefficient(process) * coefficient(process);
    double density = filtered;
    for (int m = 1; m < recorder_.held; ++m) {
      const double cycles = std::min(m, recorder_.held - m) / h, weight = 2 * std::sin(std::numbers::pi * m / h) / h;
      density += weight * weight * psd(process, cycles * rate, dt_);
    }
    const double rounded = recorder_.held == 1 ? 1 : 1 + 2 / h;
    density += step * step * dt_ / 12 * rounded;
    process = with_coefficient(process, coefficient(process) * std::sqrt(density / filtered));
  }
}

std::vector<double> RecorderGenerator::operator()(StreamKey key) const {
  std::vector<double> record = generator_(key);
  const auto every = static_cast<std::size_t>(recorder_.decimation);
  for (std::size_t k = 0; k < record.size() / every; ++k) record[k] = record[k * every];
  record.resize(record.size() / every);
  warm(record);
  knock(record);
  add_outliers(record, key);
  round(record, key);
  hold(record);
  remove(record, key);
  return record;
}

void RecorderGenerator::warm(std::span<double> record) const {
  if (recorder_.warm_up == 0) return;
  constexpr double kTimes = 20;  // that T is in the record
  const double decay = kTimes / static_cast<double>(record.size());
  for (std::size_t k = 0; k < record.size(); ++k)
    record[k] += recorder_.warm_up * sigma_ * std::exp(-decay * static_cast<double>(k));
}

void RecorderGenerator::knock(std::span<double> record) const {
  if (recorder_.knock == 0) return;
  constexpr double kLasts = 0.5, kFrequency = 5;
  const auto rows = std::min(record.size() / 2, static_cast<std::size_t>(std::ceil(kLasts / dt_)));
  for (std::size_t k = 0; k < rows; ++k) {
    const double turn = 2 * std::numbers::pi * kFrequency * dt_ * (static_cast<double>(k) + 0.5);
    record[record.size() / 2 + k] += recorder_.knock * sigma_ * std::sin(turn);
  }
}

void RecorderGenerator::add_outliers(std::span<double> record, StreamKey key) const {
  if (recorder_.outliers == 0) return;
  std::vector<double> places(record.size()), sizes(record.size());
  fill_uniform(detail::source_stream(key, kOutlierPlaces), 0, places);
  fill_normal(detail::source_stream(key, kOutlierSizes), 0, sizes);
  for (std::size_t k = 0; k < record.size(); ++k)
    if (places[k] < recorder_.outliers) record[k] += kOutlierSize * sigma_ * sizes[k];
}

void RecorderGenerator::round(std::span<double> record, StreamKey key) const {
  const double step = recorder_.rounding * sigma_;
  if (step == 0) return;
  double offset = 0;
  fill_uniform(detail::source_stream(key, kOffset), 0, std::span(&offset, 1));
  for (double& sample : record) sample = step * std::nearbyint(sample / step + offset);
}

void RecorderGenerator::hold(std::span<double> record) const {
  if (recorder_.held == 1) return;
  const auto every = static_cast<std::size_t>(recorder_.held);
  for (std::size_t k = every - 1; k < record.size(); k += every) record[k] = record[k - 1];
}

void RecorderGenerator::remove(std::span<double> record, StreamKey key) const {
  if (recorder_.gaps == 0) return;
  std::vector<double> places(record.size());
  fill_uniform(detail::source_stream(key, kGaps), 0, places);
  for (std::size_t k = 0; k < record.size(); ++k)
    if (places[k] < recorder_.gaps) record[k] = std::numeric_limits<double>::quiet_NaN();
}

}  // namespace gyrobudget::inline v0::noise

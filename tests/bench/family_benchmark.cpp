// SPDX-License-Identifier: MIT
// The whole family on one record: time, memory and error of each estimator, of
// strides, streaming and statistics. Prints tables in Markdown.
//
//   family_benchmark [SAMPLES]          (3.6e6: 10 h at 100 Hz)
//
// Every ratio is the median of runs that take turns with what they are compared to, so that a busy machine
// slows both.
#include "gyrobudget/allan/dynamic.h"
#include "gyrobudget/allan/factors.h"
#include "gyrobudget/allan/family.h"
#include "gyrobudget/allan/favar.h"
#include "gyrobudget/allan/psd.h"
#include "gyrobudget/allan/statistics.h"
#include "gyrobudget/allan/streaming.h"
#include "gyrobudget/noise/generate.h"

#include <fmt/core.h>
#include <sys/resource.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

namespace {

namespace allan = gyrobudget::allan;
namespace noise = gyrobudget::noise;
using allan::Estimator;
using Factors = std::vector<std::int64_t>;

constexpr double kDt = 0.01;
constexpr int kRuns = 5;

template <typename Work>
double seconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Median seconds of two alternatives that take turns, and of the ratio of the first to the second.
struct Comparison {
  double first, second, ratio;
};
template <typename First, typename Second>
Comparison take_turns(First first, Second second) {
  std::vector<double> one, two, ratio;
  for (int run = 0; run < kRuns; ++run) {
    one.push_back(seconds(first));
    two.push_back(seconds(second));
    ratio.push_back(one.back() / two.back());
  }
  return {median(one), median(two), median(ratio)};
}

template <typename Work>
auto with_threads(std::size_t threads, Work work) {
  return [threads, work] {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    work();
  };
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

volatile double sink;
void use(const allan::Curve& curve) { sink = curve.points.back().variance; }

/// What textbooks print: prefix sums, then one loop per factor.
void textbook(const std::vector<double>& rate, const Factors& factors) {
  std::vector<double> x(rate.size() + 1, 0.);
  for (std::size_t k = 0; k < rate.size(); ++k) x[k + 1] = x[k] + rate[k];
  for (const std::int64_t factor : factors) {
    const auto m = static_cast<std::size_t>(factor);
    double sum = 0;
    for (std::size_t k = 0; k + 2 * m < x.size(); ++k) {
      const double d = x[k + 2 * m] - 2 * x[k + m] + x[k];
      sum += d * d;
    }
    sink = sum;
  }
}

/// Reads the record once, on all threads.
void read_once(const std::vector<double>& rate) {
  constexpr std::size_t kChunk = 1 << 16;
  std::vector<double> sums(rate.size() / kChunk);
  tbb::parallel_for(std::size_t{0}, sums.size(), [&](std::size_t chunk) {
    double lane[16] = {};
    for (std::size_t k = chunk * kChunk; k < (chunk + 1) * kChunk; k += 16) {
      for (std::size_t l = 0; l < 16; ++l) lane[l] += rate[k + l];
    }
    for (const double value : lane) sums[chunk] += value;
  });
  for (const double sum : sums) sink = sum;
}

/// Relative error of a variance of a part of the record against its definition in long double; -1 where that
/// takes long.
double error_at(Estimator estimator, const std::vector<double>& rate) {
  // Second and third differences in long double at a short and a long factor; the tests hold every estimator
  // to 1e-12.
  if (estimator != Estimator::oadev && estimator != Estimator::ohdev) return -1;
  const bool third = estimator == Estimator::ohdev;
  double worst = 0;
  std::vector<long double> x{0};
  long double mean = 0;
  for (const double y : rate) mean += y;
  mean /= static_cast<long double>(rate.size());
  for (const double y : rate) x.push_back(x.back() + (y - mean));
  for (const std::int64_t factor : {std::int64_t{1}, static_cast<std::int64_t>(rate.size()) / 10}) {
    const auto m = static_cast<std::size_t>(factor), span = (third ? 3 : 2) * m;
    long double sum = 0;
    for (std::size_t k = 0; k + span < x.size(); ++k) {
      const long double d =
          third ? x[k + 3 * m] - 3 * x[k + 2 * m] + 3 * x[k + m] - x[k] : x[k + 2 * m] - 2 * x[k + m] + x[k];
      sum += d * d;
    }
    const long double M = static_cast<long double>(m);
    const long double truth = sum / static_cast<long double>(x.size() - span) / ((third ? 6 : 2) * M * M);
    const double ours = allan::deviation(rate, kDt, estimator, std::span(&factor, 1)).points[0].variance;
    worst = std::max(worst, std::abs(static_cast<double>(ours / truth) - 1));
  }
  return worst;
}

void estimators(const std::vector<double>& rate) {
  fmt::print("\n## Every estimator at octaves\n\n");
  fmt::print(
      "| estimator | taus | longest tau, s | stride there | 1 thread, s | 2 threads, s | statistics, s | error |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  const allan::Series record(rate, kDt);
  (void)record.phase();
  for (const Estimator estimator : allan::kEstimators) {
    const Factors factors = allan::octave_factors(estimator, record.samples());
    const allan::Curve curve = allan::deviation(record, estimator, factors);
    const auto run = [&] { use(allan::deviation(record, estimator, factors)); };
    const double one = seconds(with_threads(1, run)), two = seconds(with_threads(2, run));
    const double facts = seconds([&] { sink = statistics(curve, identify_noise(record, curve)).back().edf; });
    const double error = error_at(estimator, rate);
    fmt::print("| {} | {} | {:.0f} | {} | {:.4f} | {:.4f} | {:.4f} | {} |\n", name(estimator), factors.size(),
               curve.tau(curve.points.size() - 1), curve.points.back().stride, one, two, facts,
               error < 0 ? "1e-12 (tests)" : fmt::format("{:.0e}", error));
  }
  fmt::print("\nPeak memory so far {:.0f} MB for a record of {:.0f} MB.\n", peak_megabytes(),
             8e-6 * static_cast<double>(rate.size()));
}

void against_textbook(const std::vector<double>& rate) {
  fmt::print(
      "\n## 100 log-spaced factors of the oadev, prefix sums included, against the textbook loop (1 thread)\n\n");
  fmt::print(
      "| form | threads | s | textbook, s | ratio | against reading the record per factor |\n|---|---|---|---|---|---|\n");
  const Factors factors = allan::log_factors(static_cast<std::int64_t>(rate.size()), 100);
  for (const std::int64_t overlap : {0, 64, 32, 16, 8}) {
    for (const std::size_t threads : {1, 2}) {
      const auto ours = with_threads(
          threads, [&] { use(allan::deviation(rate, kDt, Estimator::oadev, factors, {.overlap = overlap})); });
      const Comparison plain = take_turns(ours, [&] { textbook(rate, factors); });
      const Comparison read = take_turns(ours, with_threads(threads, [&] { read_once(rate); }));
      fmt::print("| {} | {} | {:.4f} | {:.4f} | {:.3f} | {:.2f} |\n",
                 overlap == 0 ? "every sample" : fmt::format("stride m/{}", overlap), threads, plain.first,
                 plain.second, plain.ratio, read.ratio / static_cast<double>(factors.size()));
    }
  }
}

/// What a second thread gains, against what it gains a loop that only reads; all four take turns.
void scaling(const std::vector<double>& rate) {
  fmt::print("\n## Two threads, 100 log-spaced factors at every sample: speed-up over that of a pure-read loop\n\n");
  const Factors factors = allan::log_factors(static_cast<std::int64_t>(rate.size()), 100);
  const auto ours = [&] { use(allan::deviation(rate, kDt, Estimator::oadev, factors)); };
  const auto read = [&] {
    for (std::size_t i = 0; i < factors.size(); ++i) read_once(rate);
  };
  constexpr int kTurns = 9;
  std::vector<double> gains, reads, ratios;
  for (int turn = 0; turn < kTurns; ++turn) {
    const double one = seconds(with_threads(1, ours)), read_one = seconds(with_threads(1, read)),
                 two = seconds(with_threads(2, ours)), read_two = seconds(with_threads(2, read));
    gains.push_back(one / two);
    reads.push_back(read_one / read_two);
    ratios.push_back(gains.back() / reads.back());
  }
  std::sort(ratios.begin(), ratios.end());
  fmt::print("ours {:.2f}, read {:.2f}, ratio {:.2f} (of {} turns {:.2f} to {:.2f})\n", median(gains), median(reads),
             median(ratios), kTurns, ratios.front(), ratios.back());
}

/// Identification, degrees of freedom, bias and intervals over the time of the curve itself, at octaves.
void cost_of_statistics(const std::vector<double>& rate) {
  fmt::print(
      "\n## Identification and statistics over their curve (1 thread, in turns)\n\n| estimator | per cent |\n|---|---|\n");
  for (const Estimator estimator : {Estimator::oadev, Estimator::mdev, Estimator::ohdev, Estimator::totdev}) {
    const Factors factors = allan::octave_factors(estimator, static_cast<std::int64_t>(rate.size()));
    allan::Curve curve;
    const allan::Series* made = nullptr;
    std::vector<double> ratios;
    for (int run = 0; run < kRuns; ++run) {
      const allan::Series record(rate, kDt);
      made = &record;
      const double whole = seconds(with_threads(1, [&] { curve = allan::deviation(*made, estimator, factors); }));
      const double more =
          seconds(with_threads(1, [&] { sink = statistics(curve, identify_noise(*made, curve)).back().edf; }));
      ratios.push_back(more / whole);
    }
    fmt::print("| {} | {:.1f} |\n", name(estimator), 100 * median(ratios));
  }
}

void stride_loss() {
  fmt::print("\n## What a stride costs: n = 4096, m = 64, loss of degrees of freedom in per cent\n\n");
  fmt::print(
      "| m/stride | white, theory | white, 4000 records | flicker, theory | flicker, records |\n|---|---|---|---|---|\n");
  constexpr std::int64_t kSamples = 4096, kFactor = 64;
  constexpr int kRecords = 4000;
  const noise::Process kinds[] = {noise::White{1}, noise::Flicker{1}};
  const std::int64_t overlaps[] = {16, 8, 4, 2, 1};
  double theory[2][5], measured[2][5];
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const std::span mix(&kinds[kind], 1);
    const noise::RecordGenerator generate(mix, kSamples, 1);
    std::vector<double> values[6];
    for (int r = 0; r < kRecords; ++r) {
      const auto rate = generate({.seed = 5, .stream = static_cast<std::uint64_t>(r)});
      for (std::size_t i = 0; i < 6; ++i) {
        const std::int64_t overlap = i == 0 ? 0 : overlaps[i - 1];
        values[i].push_back(
            allan::deviation(rate, 1, Estimator::oadev, std::span(&kFactor, 1), {.overlap = overlap, .least_stride = 1})
                .points[0]
                .variance);
      }
    }
    const auto scatter = [&](const std::vector<double>& v) {
      double mean = 0, square = 0;
      for (const double value : v) mean += value / kRecords, square += value * value / kRecords;
      return square - mean * mean;
    };
    const double full = allan::equivalent_dof({Estimator::oadev, kSamples, kFactor, 1}, mix);
    for (std::size_t i = 0; i < 5; ++i) {
      const allan::Estimation strided{Estimator::oadev, kSamples, kFactor, 1, kFactor / overlaps[i]};
      theory[kind][i] = 100 * (full / allan::equivalent_dof(strided, mix) - 1);
      measured[kind][i] = 100 * (scatter(values[i + 1]) / scatter(values[0]) - 1);
    }
  }
  for (std::size_t i = 0; i < 5; ++i) {
    fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", overlaps[i], theory[0][i], measured[0][i], theory[1][i],
               measured[1][i]);
  }
}

void streaming(const std::vector<double>& rate) {
  fmt::print("\n## Streaming, recursion, surface, spectra\n\n| what | s | ns a sample |\n|---|---|---|\n");
  const auto row = [&](const std::string& what, double time) {
    fmt::print("| {} | {:.4f} | {:.2f} |\n", what, time, 1e9 * time / static_cast<double>(rate.size()));
  };
  for (const std::int64_t overlap : {16, 32}) {
    row(fmt::format("stream, all octaves, stride m/{}", overlap), seconds([&] {
          allan::StreamingDeviation stream(kDt, {.overlap = overlap});
          stream.push(rate);
          use(stream.curve());
        }));
  }
  row("stream in two halves on two threads, joined", seconds([&] {
        const std::size_t half = rate.size() / 2;
        allan::StreamingDeviation parts[] = {
            allan::StreamingDeviation(kDt),
            allan::StreamingDeviation(kDt, {.first_sample = static_cast<std::int64_t>(half)})};
        tbb::parallel_for(0, 2, [&](int i) {
          const std::span whole(rate);
          parts[i].push(i == 0 ? whole.first(half) : whole.subspan(half));
        });
        parts[0].append(parts[1]);
        use(parts[0].curve());
      }));
  row("FAVAR recursion, all octaves", seconds([&] { use(allan::recursive_variance(rate, kDt)); }));
  const allan::Series record(rate, kDt);
  (void)record.phase();
  const Factors factors = allan::octave_factors(static_cast<std::int64_t>(rate.size()) / 64);
  row("surface, 253 windows of n/64", seconds([&] {
        const std::int64_t window = record.samples() / 64;
        sink = allan::dynamic_variance(record, factors, {window, window / 4}).variance(0, 0);
      }));
  row("Welch", seconds([&] { sink = allan::welch(rate, kDt).density[0]; }));
  row("multitaper, 8 tapers", seconds([&] { sink = allan::multitaper(rate, kDt).density[0]; }));
  fmt::print("\nPeak memory {:.0f} MB.\n", peak_megabytes());
}

}  // namespace

int main(int argc, char** argv) {
  const std::int64_t samples = argc > 1 ? std::llround(std::atof(argv[1])) : 3'600'000;
  const noise::Process ifog[] = {noise::White{1.570796e-7}, noise::RateRandomWalk{3.490659e-9}};
  const std::vector<double> rate = noise::generate_record(ifog, samples, kDt, {.seed = 1});
  fmt::print("{} samples at {} Hz, peak memory {:.0f} MB\n", samples, 1 / kDt, peak_megabytes());
  against_textbook(rate);
  scaling(rate);
  cost_of_statistics(rate);
  estimators(rate);
  streaming(rate);
  stride_loss();
}

// SPDX-License-Identifier: MIT
// Overlapped Allan variance of a 10 h, 100 Hz record at 100 log-spaced factors, against the textbook loop over prefix
// sums and against reading the record from memory. Alternatives take turns within each iteration, so a busy machine
// slows all of them; each ratio is the median over the iterations, with its quartiles.
//
//   allan_benchmark [--benchmark_filter=REGEX]
#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/allan/factors.h"

#include <benchmark/benchmark.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace {

namespace allan = gyrobudget::allan;

constexpr std::int64_t kSamples = 3'600'000;

const std::vector<double>& record() {
  static const std::vector<double> rate = [] {
    std::mt19937_64 bits(1);
    std::normal_distribution<double> normal(15.04, 0.324);
    std::vector<double> values(kSamples);
    for (double& value : values) value = normal(bits);
    return values;
  }();
  return rate;
}

std::vector<double> with_losses() {
  std::vector<double> rate = record();
  std::mt19937_64 bits(2);
  for (double& value : rate) {
    if (bits() % 100 == 0) value = std::nan("");
  }
  return rate;
}

/// What textbooks print: prefix sums, then one loop per factor.
std::vector<double> textbook(const std::vector<double>& rate, const std::vector<std::int64_t>& factors) {
  std::vector<double> x(rate.size() + 1, 0.);
  for (std::size_t k = 0; k < rate.size(); ++k) x[k + 1] = x[k] + rate[k];
  std::vector<double> variances;
  for (const std::int64_t factor : factors) {
    const auto m = static_cast<std::size_t>(factor);
    const std::size_t terms = rate.size() - 2 * m + 1;
    double sum = 0;
    for (std::size_t k = 0; k < terms; ++k) {
      const double d = x[k + 2 * m] - 2 * x[k + m] + x[k];
      sum += d * d;
    }
    variances.push_back(sum / (2. * static_cast<double>(m) * static_cast<double>(m) * static_cast<double>(terms)));
  }
  return variances;
}

/// Reads the record once on all threads.
double read_once(const std::vector<double>& rate) {
  constexpr std::size_t kChunk = 1 << 16;
  const std::size_t chunks = (rate.size() + kChunk - 1) / kChunk;
  std::vector<double> sums(chunks);
  tbb::parallel_for(std::size_t{0}, chunks, [&](std::size_t chunk) {
    double lane[8] = {};
    const std::size_t end = std::min(rate.size(), (chunk + 1) * kChunk);
    for (std::size_t k = chunk * kChunk; k + 8 <= end; k += 8) {
      for (std::size_t l = 0; l < 8; ++l) lane[l] += rate[k + l];
    }
    sums[chunk] = std::accumulate(std::begin(lane), std::end(lane), 0.);
  });
  return std::accumulate(sums.begin(), sums.end(), 0.);
}

template <typename Work>
double seconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  benchmark::DoNotOptimize(work());
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void report(benchmark::State& state, const std::string& name, std::vector<double> ratios) {
  std::sort(ratios.begin(), ratios.end());
  const auto quantile = [&](double p) { return ratios[static_cast<std::size_t>(p * (ratios.size() - 1) + 0.5)]; };
  state.counters[name] = quantile(0.5);
  state.counters[name + "_q1"] = quantile(0.25);
  state.counters[name + "_q3"] = quantile(0.75);
}

/// Argument: threads of the library's run; 0 = all. The textbook loop always has one.
void hundred_factors(benchmark::State& state) {
  const std::vector<double>& rate = record();
  const std::vector<std::int64_t> factors = allan::log_factors(kSamples, 100);
  const auto threads = static_cast<std::size_t>(state.range(0));
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads > 0 ? threads : 256);
  std::vector<double> against_textbook, against_memory;
  for (auto _ : state) {
    const double plain = seconds([&] { return textbook(rate, factors); });
    const double read = seconds([&] { return read_once(rate); });
    const double ours = seconds([&] { return allan::overlapped_variance(rate, 0.01, factors); });
    against_textbook.push_back(plain / ours);
    against_memory.push_back(ours / (read * static_cast<double>(factors.size())));
    state.SetIterationTime(ours);
  }
  report(state, "textbook/ours", against_textbook);
  report(state, "ours/read_per_factor", against_memory);
}
BENCHMARK(hundred_factors)->Arg(1)->Arg(0)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(15);

void octaves(benchmark::State& state) {
  const std::vector<double> rate = state.range(0) != 0 ? with_losses() : record();
  const std::vector<std::int64_t> factors = allan::octave_factors(kSamples);
  for (auto _ : state) benchmark::DoNotOptimize(allan::overlapped_variance(rate, 0.01, factors));
}
BENCHMARK(octaves)->ArgName("one_percent_lost")->Arg(0)->Arg(1)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();

// SPDX-License-Identifier: MIT
// Random numbers against the standard library's, records of 10 h at 100 Hz, and the endless generator's error
// against its run time. Alternatives of a ratio take turns within each iteration, so a busy machine slows all
// of them; a ratio is the median over the iterations, with its quartiles.
//
//   noise_benchmark [--benchmark_filter=REGEX]
#include "gyrobudget/noise/detail/normal_kernel.h"
#include "gyrobudget/noise/generate.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace {

namespace noise = gyrobudget::noise;

constexpr std::int64_t kSamples = 3'600'000;
constexpr double kDt = 0.01;

template <typename Work>
double seconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void report(benchmark::State& state, const std::string& name, std::vector<double> ratios) {
  std::sort(ratios.begin(), ratios.end());
  const auto quantile = [&](double p) {
    return ratios[static_cast<std::size_t>(p * static_cast<double>(ratios.size() - 1) + 0.5)];
  };
  state.counters[name] = quantile(0.5);
  state.counters[name + "_q1"] = quantile(0.25);
  state.counters[name + "_q3"] = quantile(0.75);
}

/// One thread, a million numbers; argument 1 for the AVX2 kernel, 0 for the baseline.
void normal_numbers(benchmark::State& state) {
  const auto target = state.range(0) != 0 ? noise::detail::Target::avx2 : noise::detail::Target::baseline;
  if (!noise::detail::supported(target)) return state.SkipWithError("this processor has no AVX2");
  constexpr std::int64_t kBlocks = 1 << 19;
  std::vector<double> numbers(2 * kBlocks);
  std::mt19937_64 bits(1);
  std::normal_distribution<double> standard;
  std::vector<double> ratios;
  for (auto _ : state) {
    const double library = seconds([&] {
      for (double& x : numbers) x = standard(bits);
      benchmark::DoNotOptimize(numbers.data());
    });
    const double ours = seconds([&] {
      noise::detail::normal_blocks(target, {1, 2}, 0, kBlocks, numbers.data());
      benchmark::DoNotOptimize(numbers.data());
    });
    ratios.push_back(library / ours);
    state.SetIterationTime(ours);
  }
  state.SetItemsProcessed(state.iterations() * 2 * kBlocks);
  report(state, "std/ours", ratios);
}
BENCHMARK(normal_numbers)
    ->ArgName("avx2")
    ->Arg(1)
    ->Arg(0)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond)
    ->Iterations(21);

void whole_record(benchmark::State& state, const noise::Process& process) {
  const noise::RecordGenerator generator(std::array{process}, kSamples, kDt);
  for (auto _ : state) benchmark::DoNotOptimize(generator({1, 0}).data());
  state.SetItemsProcessed(state.iterations() * kSamples);
}
BENCHMARK_CAPTURE(whole_record, white, noise::White{1})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_record, rate_random_walk, noise::RateRandomWalk{1})->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(whole_record, flicker, noise::Flicker{1})->Unit(benchmark::kMillisecond);

/// Largest error of the flicker term's Allan deviation from dt to longest_tau.
double worst_error(double longest_tau, double poles_per_decade) {
  const auto states = noise::flicker_approximation(noise::Flicker{1}, kDt, longest_tau, poles_per_decade);
  double worst = 0;
  for (double m = 1; m * kDt <= longest_tau; m = std::max(m + 1, std::floor(1.1 * m))) {
    const auto factor = static_cast<std::int64_t>(m);
    const double ratio =
        noise::allan_variance(states, factor, kDt) / noise::allan_variance(noise::Flicker{1}, factor, kDt);
    worst = std::max(worst, std::abs(std::sqrt(ratio) - 1));
  }
  return worst;
}

/// Flicker over seven decades of tau; argument: poles per decade times ten.
void endless_flicker(benchmark::State& state) {
  constexpr double kLongestTau = 1e5;
  const double poles = static_cast<double>(state.range(0)) / 10;
  noise::Generator generator(std::array<noise::Process, 1>{noise::Flicker{1}}, kDt,
                             {.longest_tau = kLongestTau, .poles_per_decade = poles});
  std::vector<double> samples(1 << 16);
  for (auto _ : state) {
    generator.next(samples);
    benchmark::DoNotOptimize(samples.data());
  }
  state.SetItemsProcessed(state.iterations() * std::ssize(samples));
  state.counters["error_percent"] = 100 * worst_error(kLongestTau, poles);
}
BENCHMARK(endless_flicker)->ArgName("poles_per_decade_x10")->Arg(5)->Arg(10)->Arg(15)->Arg(20)->Arg(30);

void phase_covariance(benchmark::State& state, const noise::Process& process) {
  double lag = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(noise::phase_covariance(process, lag, kDt));
    lag = lag < 1e6 ? 1.01 * lag + 1 : 0;
  }
}
BENCHMARK_CAPTURE(phase_covariance, white, noise::White{1});
BENCHMARK_CAPTURE(phase_covariance, flicker, noise::Flicker{1});
BENCHMARK_CAPTURE(phase_covariance, gauss_markov, noise::GaussMarkov{1, 10});

}  // namespace

BENCHMARK_MAIN();

// SPDX-License-Identifier: MIT
// Error against run time of every way to make 1/f noise, at 100 Hz: what the Allan deviation and the spectrum
// miss, from exact formulas, beside the time a sample takes, the alternatives taking turns. Then the throughput
// of a whole gyro and of a whole IMU.
//
//   generator_benchmark [repetitions]     the tables
//   generator_benchmark imu [repetitions]   the throughput of a whole IMU alone
//   generator_benchmark far [samples]     the deviation after 1e9 samples, streamed in constant memory
#include "gyrobudget/noise/filter.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/imu.h"
#include "gyrobudget/noise/process.h"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace {

namespace noise = gyrobudget::noise;
using noise::Flicker;

constexpr double kDt = 0.01;
constexpr double kLongestTau = 7200;                                                  // s
constexpr std::array<std::int64_t, 5> kFactors = {1, 100, 10'000, 100'000, 720'000};  // 0.01 s to 2 h
constexpr std::array<double, 3> kFrequencies = {10, 0.01, 1e-4};                      // Hz

/// Processor time: there is one thread, and others may use the machine.
double seconds(const std::function<void()>& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// A way to make 1/f noise of B = 1: its exact moments, and a call that makes `samples` samples.
struct Method {
  std::string name;
  std::function<double(std::int64_t)> allan_variance;
  std::function<double(double)> psd;
  std::size_t samples;
  std::function<void()> make;
  double ns_per_sample = std::numeric_limits<double>::infinity();  ///< best of the repetitions
};

Method streaming(std::string name, noise::Generator generator) {
  constexpr std::size_t kSamples = 1 << 17;
  const auto shared = std::make_shared<noise::Generator>(std::move(generator));
  const auto buffer = std::make_shared<std::vector<double>>(kSamples);
  return {std::move(name), {}, {}, kSamples, [=] { shared->next(*buffer); }};
}

Method filtered(std::string name, const noise::FilteredNoise& filter) {
  Method method = streaming(std::move(name), noise::Generator({}, std::array{filter}, kDt, {}));
  const auto moments = std::make_shared<noise::FilterMoments>(filter);
  method.allan_variance = [=](std::int64_t m) { return moments->allan_variance(m); };
  method.psd = [=](double f) { return noise::psd(filter, f, kDt); };
  return method;
}

Method poles(double per_decade) {
  const auto states = noise::flicker_approximation(Flicker{1}, kDt, kLongestTau, per_decade);
  Method method = streaming(fmt::format("Gauss-Markov, {:3g} poles a decade ({} states)", per_decade, states.size()),
                            noise::Generator(std::array<noise::Process, 1>{Flicker{1}}, kDt,
                                             {.longest_tau = kLongestTau, .poles_per_decade = per_decade}));
  method.allan_variance = [=](std::int64_t m) { return noise::allan_variance(states, m, kDt); };
  method.psd = [=](double f) {
    double sum = 0;
    for (const noise::Process& p : states) sum += noise::psd(p, f, kDt);
    return sum;
  };
  return method;
}

Method whole_record() {
  constexpr std::size_t kSamples = 3'600'000;
  const auto generator =
      std::make_shared<noise::RecordGenerator>(std::array<noise::Process, 1>{Flicker{1}}, kSamples, kDt);
  const auto unit = [] { return Flicker{1}; };
  return {"whole record of 10 h by Fourier transform", [=](std::int64_t m) { return allan_variance(unit(), m, kDt); },
          [=](double f) { return noise::psd(noise::Process(unit()), f, kDt); }, kSamples,
          [=] {
            (void)(*generator)({1, 0});
          }};
}

std::vector<Method> methods() {
  std::vector<Method> all;
  for (const std::int64_t taps : {1, 10, 100, 1000, 10'000, 100'000, 150'000}) {
    all.push_back(filtered(fmt::format("autoregression, {} taps", taps), noise::autoregressive_flicker(1, taps)));
  }
  for (const std::int64_t taps : {10, 100, 1000, 10'000, 100'000, 1'000'000}) {
    all.push_back(filtered(fmt::format("moving average, {} taps", taps), noise::moving_average_flicker(1, taps)));
  }
  for (const double per_decade : {0.5, 1., 1.5, 2., 3.}) all.push_back(poles(per_decade));
  all.push_back(whole_record());
  return all;
}

/// Percent by which a deviation misses.
double miss(double variance, double truth) { return 100 * (std::sqrt(variance / truth) - 1); }

void error_against_run_time(int repetitions) {
  auto all = methods();
  for (int i = 0; i < repetitions; ++i) {
    for (Method& m : all) {
      m.ns_per_sample = std::min(m.ns_per_sample, 1e9 * seconds(m.make) / static_cast<double>(m.samples));
    }
  }
  fmt::print("1/f noise at 100 Hz: error of the Allan deviation (%) at tau, of the root of the spectrum (%) at f\n");
  fmt::print("{:44} {:>9}", "", "ns/sample");
  for (const std::int64_t m : kFactors) fmt::print(" {:>8}", fmt::format("{:g} s", static_cast<double>(m) * kDt));
  for (const double f : kFrequencies) fmt::print(" {:>9}", fmt::format("{:g} Hz", f));
  fmt::print("\n");
  for (const Method& method : all) {
    fmt::print("{:44} {:9.1f}", method.name, method.ns_per_sample);
    for (const std::int64_t m : kFactors) {
      fmt::print(" {:8.3f}", miss(method.allan_variance(m), noise::allan_variance(Flicker{1}, m, kDt)));
    }
    for (const double f : kFrequencies) {
      fmt::print(" {:9.3f}", miss(method.psd(f), noise::psd(noise::Process(Flicker{1}), f, kDt)));
    }
    fmt::print("\n");
  }
  fmt::print(
      "Filters are stationary here; from rest they hold up to 8 % less variance. The whole record is exact in\n"
      "distribution, needs 11 numbers a sample, and cannot go on.\n"
      "Hence the defaults: 2 poles a decade for streams, as more of them only cost; 1e4 taps for model 1, whose\n"
      "floor then holds to 500 s; the whole record by Fourier transform where the record fits in memory.\n\n");
}

/// Of some numbers, sorted here: "3.4 (3.2 to 3.6)", median and middle 80 %.
std::string median_text(std::vector<double> values) {
  std::ranges::sort(values);
  const auto at = [&](double part) {
    return values[static_cast<std::size_t>(std::lround(part * static_cast<double>(values.size() - 1)))];
  };
  return fmt::format("{:.3g} ({:.3g} to {:.3g})", at(0.5), at(0.1), at(0.9));
}

/// White, flicker and rate random walk, beside the library's normal numbers; each repetition runs all three in turn.
void throughput(int repetitions) {
  constexpr std::size_t kSamples = 1 << 20;
  constexpr double kPerSample = 1e9 / kSamples, kPerMinute = 60e-6 * kSamples;  // ns; million samples
  std::vector<double> y(kSamples);
  std::mt19937_64 bits(1);
  std::normal_distribution<double> standard;
  noise::Generator white(std::array<noise::Process, 1>{noise::White{1}}, kDt, {});
  noise::Generator gyro(std::array<noise::Process, 3>{noise::White{1}, Flicker{1}, noise::RateRandomWalk{1}}, kDt, {});
  std::vector<double> ns, ratio, millions;
  for (int i = 0; i < repetitions; ++i) {
    const double library = seconds([&] {
      for (double& x : y) x = standard(bits);
    });
    const double ours = seconds([&] { white.next(y); });
    const double all = seconds([&] { gyro.next(y); });
    ns.push_back(ours * kPerSample);
    ratio.push_back(library / ours);
    millions.push_back(kPerMinute / all);
  }
  fmt::print("Medians of {} turns (middle 80 %), one thread:\n", repetitions);
  fmt::print("white noise: {} ns a sample, {} times the speed of std::normal_distribution over mt19937_64\n",
             median_text(ns), median_text(ratio));
  fmt::print("white + flicker + rate random walk, streaming: {} million samples a minute\n", median_text(millions));
}

/// A whole IMU at 100 Hz, every error on, beside one with white noise and biases only, in turns.
void imu_throughput(int repetitions) {
  constexpr int kSamples = 1 << 15, kAxes = 6;
  const noise::ErrorModel simple{.white = 1e-5, .turn_on_bias = 1e-5};
  const noise::ErrorModel full{
      .quantization = 1e-7,
      .white = 1e-5,
      .bias_instability = 1e-6,
      .rate_random_walk = 1e-7,
      .rate_ramp = 1e-9,
      .gauss_markov = {{1e-6, 100}},
      .turn_on_bias = 1e-5,
      .scale_factor = 1e-4,
      .misalignment = 1e-4,
      .g_sensitivity = 1e-7,
      .g2_sensitivity = 1e-8,
      .vibration_rectification = 1e-8,
      .filter = noise::FrontEnd{noise::FrontEnd::Kind::second_order, 30, noise::FrontEnd::Sampling::held},
      .delay = 0.013,
      .range = 10,
      .powered_on_before = 3600,
      .calibrated_over = 600};
  const noise::ImuIncrement truth{.angle = {1e-3, 2e-3, 3e-3}, .velocity = {0.1, 0.01, -0.1}};
  const auto millions = [&](const noise::ErrorModel& model) {
    noise::Imu imu({.gyro = model, .accelerometer = model}, kDt, {});
    double sum = 0;
    const double elapsed = seconds([&] {
      for (int k = 0; k < kSamples; ++k) sum += imu.next(truth).angle[0];
    });
    return sum == 0 ? 0 : 1e-6 * kAxes * kSamples / elapsed;
  };
  std::vector<double> simple_speed, full_speed, set_up;
  for (int i = 0; i < repetitions; ++i) {
    simple_speed.push_back(millions(simple));
    full_speed.push_back(millions(full));
    set_up.push_back(1e6 * seconds([&] { noise::Imu({.gyro = full, .accelerometer = full}, kDt, {}); }));
  }
  fmt::print("whole IMU, white noise and turn-on bias: {} million axis-samples/s\n", median_text(simple_speed));
  fmt::print("whole IMU, every error: {} million axis-samples/s; a run begins, an hour after power-on, in {} us\n",
             median_text(full_speed), median_text(set_up));
}

/// Overlapped Allan variance from the angle.
double overlapped(const std::vector<double>& angle, std::size_t m) {
  double sum = 0;
  for (std::size_t k = 0; k + 2 * m < angle.size(); ++k) {
    const double d = angle[k + 2 * m] - 2 * angle[k + m] + angle[k];
    sum += d * d;
  }
  return sum / (2 * static_cast<double>(m * m) * static_cast<double>(angle.size() - 2 * m));
}

void far_end(std::uint64_t samples) {
  constexpr std::size_t kRecord = 1 << 20;
  // So that each term shows: white to 1 s, flicker about 10 s, the walk at 1000 s.
  const std::array<noise::Process, 3> gyro = {noise::White{1}, Flicker{0.5}, noise::RateRandomWalk{0.02}};
  noise::Generator generator(gyro, kDt, {});
  const double elapsed = seconds([&] { generator.skip(samples); });
  std::vector<double> y(kRecord), angle = {0};
  generator.next(y);
  for (const double v : y) angle.push_back(angle.back() + (v - y[0]));
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  fmt::print("{} samples in {:.0f} s; peak memory {} MB, of which the record after them takes {}\n", samples, elapsed,
             usage.ru_maxrss / 1024, 2 * kRecord * sizeof(double) >> 20);
  for (const std::size_t m : {1, 100, 1000, 10'000, 100'000}) {
    const auto factor = static_cast<std::int64_t>(m);
    fmt::print("tau {:6g} s: Allan deviation {:.4f} of the exact one (one standard deviation about {:.4f})\n",
               static_cast<double>(m) * kDt, std::sqrt(overlapped(angle, m) / noise::allan_variance(gyro, factor, kDt)),
               std::sqrt(0.5 * static_cast<double>(m) / kRecord));
  }
}

}  // namespace

int main(int count, char** arguments) {
  try {
    if (count > 1 && std::string_view(arguments[1]) == "far") {
      far_end(count > 2 ? static_cast<std::uint64_t>(std::atof(arguments[2])) : 1'000'000'000);
      return 0;
    }
    if (count > 1 && std::string_view(arguments[1]) == "imu") {
      imu_throughput(count > 2 ? std::atoi(arguments[2]) : 15);
      return 0;
    }
    const int repetitions = count > 1 ? std::atoi(arguments[1]) : 15;
    error_against_run_time(repetitions);
    throughput(repetitions);
    imu_throughput(repetitions);
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return 1;
  }
  return 0;
}

// SPDX-License-Identifier: MIT
#include "generate.h"

#include "gyrobudget/noise/detail/check.h"
#include "gyrobudget/noise/detail/state_bank.h"
#include "gyrobudget/noise/detail/streaming_filter.h"
#include "gyrobudget/noise/detail/streams.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <stdexcept>
#include <type_traits>

#include "fft.h"

namespace gyrobudget::inline v0::noise {

using detail::require;
using detail::require_interval;

namespace {

using std::numbers::pi;

constexpr std::size_t kTile = 1024;  // samples worked on at a time

void require_generable(std::span<const Process> processes, double dt) {
  require_interval(dt);
  for (const Process& p : processes) {
    require(std::isfinite(coefficient(p)), "a noise coefficient", coefficient(p), "finite");
    (void)structure_function(p, 1, dt);  // refuses a correlation time that is none
  }
}

/// One stream per process, named by term and occurrence, in the upper 16 bits that users leave free.
class Streams {
 public:
  explicit Streams(StreamKey key) : key_(key) {
    if (key.stream >> detail::kUserBits != 0) {
      throw std::invalid_argument(fmt::format("stream {} must be below 2^{}", key.stream, detail::kUserBits));
    }
  }
  StreamKey next(Term term) { return next(static_cast<char>(term)); }
  StreamKey next(char kind) {
    const std::uint64_t occurrence = used_[kind]++;
    if (occurrence > 255) throw std::invalid_argument("more than 256 noise processes of one term");
    return detail::source_stream(key_, kind, occurrence);
  }

 private:
  StreamKey key_;
  std::map<char, std::uint64_t> used_;
};

/// Running sum whose rounding errors are carried along (Neumaier), so that a walk of 10^12 steps is still
/// exact.
class CompensatedSum {
 public:
  double add(double x) {
    const double sum = sum_ + x;
    error_ += std::abs(sum_) >= std::abs(x) ? (sum_ - sum) + x : (x - sum) + sum_;
    sum_ = sum;
    return sum_ + error_;
  }

 private:
  double sum_ = 0, error_ = 0;
};

// --- One process after the other, in constant memory -------------------------------------------------------

/// Adds its samples to what is in `out`, at most kTile at a time.
class SampleSource {
 public:
  virtual ~SampleSource() = default;
  virtual void add_next(std::span<double> out) = 0;
  /// Goes on as if the next `samples` had been asked for; those whose samples depend on all earlier ones run there.
  virtual void skip(std::uint64_t samples) {
    std::array<double, kTile> unused{};
    for (std::uint64_t count; samples > 0; samples -= count) {
      count = std::min<std::uint64_t>(samples, kTile);
      add_next(std::span(unused).first(static_cast<std::size_t>(count)));
    }
  }
};

/// Standard normal numbers of a stream, one tile at a time.
class Normals {
 public:
  explicit Normals(StreamKey key) : key_(key) {}
  /// The next `count` numbers; valid until the next call, and readable a little further.
  std::span<const double> next(std::size_t count) {
    tile_.resize(std::max(tile_.size(), count + detail::StateBank::kLanes));
    const std::span<double> numbers(tile_.data(), count);
    fill_normal(key_, at_, numbers);
    at_ += count;
    return numbers;
  }
  void skip(std::uint64_t count) { at_ += count; }

 private:
  StreamKey key_;
  std::uint64_t at_ = 0;
  std::vector<double> tile_;
};

class WhiteSource final : public SampleSource {
 public:
  WhiteSource(const White& p, double dt, StreamKey key) : sigma_(p.n / std::sqrt(dt)), normals_(key) {}
  void add_next(std::span<double> out) override {
    const auto u = normals_.next(out.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += sigma_ * u[i];
  }
  void skip(std::uint64_t samples) override { normals_.skip(samples); }

 private:
  double sigma_;
  Normals normals_;
};

class FilteredWhiteSource final : public SampleSource {
 public:
  FilteredWhiteSource(const FilteredWhite& p, double dt, StreamKey key)
      : sigma_(p.n / std::sqrt(dt)), normals_(key), filter_(SampledFrontEnd(p.front_end, dt)) {
    skip(static_cast<std::uint64_t>(SampledFrontEnd(p.front_end, dt).settling()));  // stationary from the start
  }
  void add_next(std::span<double> out) override {
    const auto u = normals_.next(out.size());
    std::array<double, kTile> filtered;
    for (std::size_t i = 0; i < out.size(); ++i) filtered[i] = sigma_ * u[i];
    filter_(std::span(filtered).first(out.size()));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += filtered[i];
  }

 private:
  double sigma_;
  Normals normals_;
  FrontEndFilter filter_;
};

class QuantizationSource final : public SampleSource {
 public:
  QuantizationSource(const Quantization& p, double dt, StreamKey key)
      : sigma_(p.q / dt), normals_(key), previous_(normals_.next(1)[0]) {}
  void add_next(std::span<double> out) override {
    const auto u = normals_.next(out.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] += sigma_ * (u[i] - previous_);
      previous_ = u[i];
    }
  }
  void skip(std::uint64_t samples) override {
    if (samples == 0) return;
    normals_.skip(samples - 1);
    previous_ = normals_.next(1)[0];
  }

 private:
  double sigma_;
  Normals normals_;
  double previous_;  ///< angle error of the reading before
};

class WalkSource final : public SampleSource {
 public:
  WalkSource(const RateRandomWalk& p, double dt, StreamKey key) : step_(p.k * std::sqrt(dt)), normals_(key) {}
  void add_next(std::span<double> out) override {
    const auto u = normals_.next(out.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] += rate_;  // zero at sample 0
      rate_ = sum_.add(step_ * u[i]);
    }
  }

 private:
  double step_;
  Normals normals_;
  CompensatedSum sum_;
  double rate_ = 0;
};

class GaussMarkovSource final : public SampleSource {
 public:
  GaussMarkovSource(const GaussMarkov& p, double dt, StreamKey key)
      : phi_(std::exp(-dt / p.correlation_time)),
        step_(p.sigma * std::sqrt(-std::expm1(-2 * dt / p.correlation_time))),
        normals_(key),
        state_(p.sigma * normals_.next(1)[0]) {}
  void add_next(std::span<double> out) override {
    const auto u = normals_.next(out.size());
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] += state_;
      state_ = phi_ * state_ + step_ * u[i];
    }
  }

 private:
  double phi_, step_;
  Normals normals_;
  double state_;
};

class RampSource final : public SampleSource {
 public:
  RampSource(const RateRamp& p, double dt) : step_(p.r * dt) {}
  void add_next(std::span<double> out) override {
    for (double& y : out) y += step_ * static_cast<double>(at_++);
  }
  void skip(std::uint64_t samples) override { at_ += samples; }

 private:
  double step_;
  std::uint64_t at_ = 0;
};

class SinusoidSource final : public SampleSource {
 public:
  SinusoidSource(const Sinusoid& p, double dt) : p_(p), cycles_(std::remainder(p.frequency * dt, 1.0)) {}
  void add_next(std::span<double> out) override {
    for (double& y : out) {
      const auto k = static_cast<double>(at_++);
      const double turn = std::fma(cycles_, k, -std::nearbyint(cycles_ * k));  // no digits lost to whole turns
      y += p_.amplitude * std::sin(2 * pi * turn + p_.phase);
    }
  }
  void skip(std::uint64_t samples) override { at_ += samples; }

 private:
  Sinusoid p_;
  double cycles_;  ///< per sample
  std::uint64_t at_ = 0;
};

/// Sum of first-order states, all from one stream: number k * (states + 1) + i drives state i into sample k,
/// the last of a sample the walk.
class FlickerSource final : public SampleSource {
 public:
  FlickerSource(std::span<const Process> approximation, double dt, StreamKey key) : normals_(key) {
    const auto start = normals_.next(approximation.size() - 1);
    for (const Process& p : approximation) {
      if (const auto* g = std::get_if<GaussMarkov>(&p)) {
        const double phi = std::exp(-dt / g->correlation_time);
        const double step = g->sigma * std::sqrt(-std::expm1(-2 * dt / g->correlation_time));
        states_.add(phi, step, g->sigma * start[states_.size()]);
      } else {
        walk_step_ = std::get<RateRandomWalk>(p).k * std::sqrt(dt);
      }
    }
    origin_ = states_.sum();
  }

  void add_next(std::span<double> out) override {
    const std::size_t stride = states_.size() + 1;
    const auto u = normals_.next(out.size() * stride);
    std::array<double, kTile> sums;
    states_.run(detail::best_target(), u, stride, std::span(sums).first(out.size()));
    for (std::size_t k = 0; k < out.size(); ++k) {
      out[k] += (sums[k] - origin_) + walk_;
      walk_ = walk_sum_.add(walk_step_ * u[k * stride + stride - 1]);
    }
  }

 private:
  Normals normals_;
  detail::StateBank states_;
  double origin_ = 0;  ///< of the states at sample 0
  double walk_step_ = 0, walk_ = 0;
  CompensatedSum walk_sum_;
};

/// Works in the filter's own blocks, whatever is asked for: that fixes the bytes.
class FilterSource final : public SampleSource {
 public:
  FilterSource(const FilteredNoise& p, StreamKey key)
      : sigma_(p.sigma),
        filter_(detail::make_filter(p.numerator, p.denominator)),
        key_(key),
        block_(filter_->block_size()),
        used_(block_.size()) {}
  void add_next(std::span<double> out) override {
    for (double& y : out) {
      if (used_ == block_.size()) make_block();
      y += sigma_ * block_[used_++];
    }
  }

 private:
  void make_block() {
    fill_normal(key_, at_, block_);
    at_ += block_.size();
    filter_->run(block_);
    used_ = 0;
  }

  double sigma_;
  std::unique_ptr<detail::StreamingFilter> filter_;
  StreamKey key_;
  std::uint64_t at_ = 0;
  std::vector<double> block_;
  std::size_t used_;
};

/// The source of any process but flicker, which has none: whole records and endless ones make it differently.
std::unique_ptr<SampleSource> make_source(const Process& process, double dt, StreamKey key) {
  return std::visit(
      [&](const auto& p) -> std::unique_ptr<SampleSource> {
        using P = std::decay_t<decltype(p)>;
        if constexpr (std::is_same_v<P, White>) return std::make_unique<WhiteSource>(p, dt, key);
        if constexpr (std::is_same_v<P, FilteredWhite>) return std::make_unique<FilteredWhiteSource>(p, dt, key);
        if constexpr (std::is_same_v<P, Quantization>) return std::make_unique<QuantizationSource>(p, dt, key);
        if constexpr (std::is_same_v<P, RateRandomWalk>) return std::make_unique<WalkSource>(p, dt, key);
        if constexpr (std::is_same_v<P, GaussMarkov>) return std::make_unique<GaussMarkovSource>(p, dt, key);
        if constexpr (std::is_same_v<P, RateRamp>) return std::make_unique<RampSource>(p, dt);
        if constexpr (std::is_same_v<P, Sinusoid>) return std::make_unique<SinusoidSource>(p, dt);
        return nullptr;
      },
      process);
}

void add_in_tiles(SampleSource& source, std::span<double> out) {
  for (; !out.empty(); out = out.subspan(std::min(kTile, out.size()))) {
    source.add_next(out.first(std::min(kTile, out.size())));
  }
}

// --- Flicker of a whole record -----------------------------------------------------------------------------

/// Points of a circulant that holds the increments of `samples` samples: even, at least twice as many.
std::int64_t circulant_points(std::int64_t samples) { return 4 * fft_length((samples + 1) / 2); }

/// Standard deviations of the real and imaginary part of each bin of the increments' spectrum for B = 1: sqrt
/// of the circulant's eigenvalues over twice its size.
std::vector<double> increment_amplitudes(std::int64_t samples) {
  const auto points = static_cast<std::size_t>(circulant_points(samples));
  std::vector<double> covariance(points);
  for (std::size_t h = 0; h <= points / 2; ++h) {
    const double lag = static_cast<double>(h);
    covariance[h] = 4 / pi / (1 - 4 * lag * lag);
    covariance[(points - h) % points] = covariance[h];
  }
  const auto eigenvalues = real_spectrum(covariance);
  std::vector<double> amplitudes(eigenvalues.size());
  for (std::size_t k = 0; k < amplitudes.size(); ++k) {
    amplitudes[k] = std::sqrt(std::max(eigenvalues[k].real(), 0.0) / static_cast<double>(2 * points));
  }
  return amplitudes;
}

void add_flicker(const Flicker& p, std::span<const double> amplitudes, StreamKey key, std::span<double> out) {
  std::vector<double> increments;
  {
    std::vector<std::complex<double>> spectrum(amplitudes.size());
    std::array<double, kTile> u;
    for (std::size_t first = 0; first < spectrum.size(); first += kTile / 2) {
      const std::size_t count = std::min(kTile / 2, spectrum.size() - first);
      fill_normal(key, 2 * first, std::span(u).first(2 * count));
      for (std::size_t i = 0; i < count; ++i) {
        spectrum[first + i] = amplitudes[first + i] * std::complex<double>(u[2 * i], u[2 * i + 1]);
      }
    }
    // The two bins that are their own conjugates are real and carry both parts' variance.
    for (std::complex<double>* bin : {&spectrum.front(), &spectrum.back()}) *bin = std::numbers::sqrt2 * bin->real();
    increments = real_signal(spectrum);
  }
  CompensatedSum rate;
  for (std::size_t k = 1; k < out.size(); ++k) out[k] += p.b * rate.add(increments[k]);
}

}  // namespace

struct RecordGenerator::Plan {
  std::vector<Process> processes;
  std::int64_t samples = 0;
  double dt = 1;
  std::vector<double> increment_amplitudes;  ///< empty where there is no flicker
};

RecordGenerator::RecordGenerator(std::span<const Process> processes, std::int64_t samples, double dt) {
  require_generable(processes, dt);
  require(samples >= 1, "record length", static_cast<double>(samples), "at least 1 (samples)");
  Plan plan{{processes.begin(), processes.end()}, samples, dt, {}};
  if (std::ranges::any_of(processes, [](const Process& p) { return std::holds_alternative<Flicker>(p); })) {
    constexpr std::int64_t kMostWithFlicker = 500'000'000;  // the transform counts in 32 bits
    require(samples <= kMostWithFlicker, "length of a record with flicker", static_cast<double>(samples),
            "at most 5e8 (samples); use Generator for longer ones");
    plan.increment_amplitudes = increment_amplitudes(samples);
  }
  plan_ = std::make_unique<const Plan>(std::move(plan));
}
RecordGenerator::~RecordGenerator() = default;
RecordGenerator::RecordGenerator(RecordGenerator&&) noexcept = default;
RecordGenerator& RecordGenerator::operator=(RecordGenerator&&) noexcept = default;

std::vector<double> RecordGenerator::operator()(StreamKey key) const {
  std::vector<double> record(static_cast<std::size_t>(plan_->samples));
  Streams streams(key);
  for (const Process& process : plan_->processes) {
    const StreamKey stream = streams.next(term(process));
    if (const auto* flicker = std::get_if<Flicker>(&process)) {
      add_flicker(*flicker, plan_->increment_amplitudes, stream, record);
    } else {
      add_in_tiles(*make_source(process, plan_->dt, stream), record);
    }
  }
  return record;
}

std::vector<double> generate_record(std::span<const Process> processes, std::int64_t samples, double dt,
                                    StreamKey key) {
  return RecordGenerator(processes, samples, dt)(key);
}

std::vector<Process> flicker_approximation(const Flicker& flicker, double dt, double longest_tau,
                                           double poles_per_decade) {
  require_generable(std::array<Process, 1>{flicker}, dt);
  constexpr double kLongestCluster = 1e15;  // samples
  require(longest_tau >= dt && longest_tau <= kLongestCluster * dt, "longest tau", longest_tau,
          "from dt to 1e15 dt (s)");
  require(poles_per_decade >= 0.5 && poles_per_decade <= 10, "poles per decade", poles_per_decade, "from 0.5 to 10");
  constexpr double kBeyond = 30;   // slowest pole over longest tau
  constexpr double kFastest = 40;  // a: weight (a/2)/sinh(a/2) below 1e-7
  constexpr double kAnchor = 2;    // one of the a: where the rule's error at m = 1 vanishes for two poles per decade
  const double step = std::numbers::ln10 / poles_per_decade;
  const double density = flicker.b * flicker.b / pi * step;
  std::vector<Process> states;
  double a = kAnchor * std::exp(step * std::floor(std::log(kFastest / kAnchor) / step));
  for (;; a *= std::exp(-step)) {
    states.emplace_back(GaussMarkov{std::sqrt(density * 0.5 * a / std::sinh(0.5 * a)), dt / a});
    if (a * kBeyond * longest_tau <= dt) break;
  }
  // The slower poles, a geometric series of D(h) = 2 sigma^2 a h.
  states.emplace_back(RateRandomWalk{std::sqrt(2 * density * a / std::expm1(step) / dt)});
  return states;
}

struct Generator::State {
  std::vector<std::unique_ptr<SampleSource>> sources;
};

Generator::Generator(std::span<const Process> processes, double dt, const Options& options)
    : Generator(processes, {}, dt, options) {}

Generator::Generator(std::span<const Process> processes, std::span<const FilteredNoise> filters, double dt,
                     const Options& options)
    : state_(std::make_unique<State>()) {
  require_generable(processes, dt);
  Streams streams(options.key);
  for (const Process& process : processes) {
    const StreamKey stream = streams.next(term(process));
    if (const auto* flicker = std::get_if<Flicker>(&process)) {
      const auto states = flicker_approximation(*flicker, dt, options.longest_tau, options.poles_per_decade);
      state_->sources.push_back(std::make_unique<FlickerSource>(states, dt, stream));
    } else {
      state_->sources.push_back(make_source(process, dt, stream));
    }
  }
  for (const FilteredNoise& filter : filters) {
    require_valid(filter);
    const StreamKey stream = streams.next('F');
    if (filter.sigma != 0) state_->sources.push_back(std::make_unique<FilterSource>(filter, stream));
  }
}
Generator::~Generator() = default;
Generator::Generator(Generator&&) noexcept = default;
Generator& Generator::operator=(Generator&&) noexcept = default;

void Generator::next(std::span<double> out) {
  std::ranges::fill(out, 0.0);
  for (const auto& source : state_->sources) add_in_tiles(*source, out);
}

void Generator::skip(std::uint64_t samples) {
  for (const auto& source : state_->sources) source->skip(samples);
}

}  // namespace gyrobudget::inline v0::noise

// SPDX-License-Identifier: MIT
#include "sweep.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/allan/family.h"
#include "gyrobudget/noise/generate.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

#include "information.h"

namespace gyrobudget::inline v0::fit {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// A way, and what it is compared for.
struct Entry {
  Comparison comparison;
  Way way;
};

// 1, 2, 3, 4, 6, 8, 11, ...: octaves and what lies between them.
std::vector<std::int64_t> factors_of(std::int64_t samples, int taus_an_octave) {
  std::vector<std::int64_t> list;
  for (int i = 0;; ++i) {
    const auto m = static_cast<std::int64_t>(std::llround(std::exp2(static_cast<double>(i) / taus_an_octave)));
    if (m > samples / 2) return list;
    if (list.empty() || m > list.back()) list.push_back(m);
  }
}

// What one way says of one record.
struct Fitted {
  bool converged = false;
  double curve_seconds = 0, fit_seconds = 0;
  std::vector<Coefficient> coefficients;  // in the order of the terms
};

// First decile: what other programs on the machine disturb least.
double quick(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto tenth = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 10);
  std::nth_element(values.begin(), tenth, values.end());
  return *tenth;
}

// All ways on the records of one length.
class Bench {
 public:
  Bench(const std::vector<noise::Process>& truth, const SweepOptions& options, std::int64_t samples,
        std::vector<Way> ways)
      : truth_(truth), options_(options), samples_(samples), ways_(std::move(ways)) {
    constexpr std::int64_t kMostWhole = 500'000;  // samples of the exact generator, at 88 bytes each
    if (samples <= kMostWhole) generator_.emplace(truth, samples, options.dt);
    std::vector<noise::Process> kinds;
    for (const noise::Term t : options.terms) kinds.push_back(noise::unit_process(t));
    for (const Way& way : ways_) {
      if (way.method == Method::whittle || covariances_.contains(way.taus_an_octave)) continue;
      const auto start = Clock::now();
      allan::CurveCovariance covariance(samples, factors_of(samples, way.taus_an_octave), options.dt, kinds);
      covariances_.emplace(way.taus_an_octave, Covariance{std::move(covariance), seconds_since(start)});
    }
  }

  // Every way on record `index`.
  [[nodiscard]] std::vector<Fitted> record(std::uint64_t index) const {
    const std::vector<double> rate = samples_of({options_.seed, index});
    std::vector<Fitted> all;
    for (const Way& way : ways_) {
      // Alone: a thread that waits inside must not do another record's work on this one's clock.
      tbb::this_task_arena::isolate([&] { all.push_back(fitted(rate, way)); });
    }
    return all;
  }

  [[nodiscard]] SweepRow row(const Entry& entry, const std::vector<std::vector<Fitted>>& records) const {
    const auto at = static_cast<std::size_t>(std::ranges::find(ways_, entry.way) - ways_.begin());
    SweepRow row{.comparison = entry.comparison,
                 .way = entry.way,
                 .samples = samples_,
                 .records = static_cast<int>(records.size())};
    std::vector<double> curve, fit;
    for (const auto& record : records) {
      const Fitted& one = record[at];
      row.unconverged += !one.converged;
      curve.push_back(one.curve_seconds);
      fit.push_back(one.fit_seconds);
    }
    row.curve_seconds = quick(std::move(curve));
    row.fit_seconds = quick(std::move(fit));
    if (needs_covariance(entry.way.method)) row.covariance_seconds = covariances_.at(entry.way.taus_an_octave).seconds;
    for (std::size_t t = 0; t < options_.terms.size(); ++t) {
      const double truth = truth_of(options_.terms[t]);
      if (truth > 0) row.coefficients.push_back(coefficient(records, at, t, truth));
    }
    return row;
  }

 private:
  struct Covariance {
    allan::CurveCovariance matrix;
    double seconds;
  };

  // loglog for its intervals only.
  static bool needs_covariance(Method m) { return m == Method::gls || m == Method::edf || m == Method::loglog; }

  [[nodiscard]] std::vector<double> samples_of(noise::StreamKey key) const {
    if (generator_) return (*generator_)(key);
    std::vector<double> rate(static_cast<std::size_t>(samples_));
    const double duration = static_cast<double>(samples_) * options_.dt;
    noise::Generator(truth_, options_.dt, {.key = key, .longest_tau = duration}).next(rate);
    return rate;
  }

  [[nodiscard]] Fitted fitted(const std::vector<double>& rate, const Way& way) const {
    Data record{.rate = rate, .dt = options_.dt};
    Fitted one;
    allan::Curve curve;
    if (way.method != Method::whittle) {
      const auto& covariance = covariances_.at(way.taus_an_octave).matrix;
      const auto start = Clock::now();
      curve = way.overlap == 0 ? allan::overlapped_variance(rate, options_.dt, covariance.factors())
                               : allan::deviation(rate, options_.dt, allan::Estimator::oadev, covariance.factors(),
                                                  {.overlap = way.overlap, .least_stride = 1});
      one.curve_seconds = seconds_since(start);
      record.curve = &curve;
      record.covariance = &covariance;
    }
    const Options fit_options{.terms = options_.terms, .method = way.method, .tau_min_s = options_.dt};
    const auto start = Clock::now();
    const Result result = fit(record, fit_options);
    one.fit_seconds = seconds_since(start);
    one.converged = result.converged;
    for (const noise::Term t : options_.terms) one.coefficients.push_back(result[t]);
    return one;
  }

  // Slope and visual readings do not know every term: those stay without an error.
  [[nodiscard]] SweptCoefficient coefficient(const std::vector<std::vector<Fitted>>& records, std::size_t way,
                                             std::size_t term, double truth) const {
    const auto standard = static_cast<std::size_t>(std::ranges::find(ways_, Way{}) - ways_.begin());
    double squares = 0, of_default = 0, covered = 0;
    for (const auto& record : records) {
      const Coefficient& c = record[way].coefficients[term];
      if (!c.fitted) return {options_.terms[term], kNaN, kNaN, kNaN, kNaN};
      squares += std::pow(c.value / truth - 1, 2);
      of_default += std::pow(record[standard].coefficients[term].value / truth - 1, 2);
      covered += c.lower <= truth && truth <= c.upper_two_sided;
    }
    const auto used = static_cast<double>(records.size());
    const double rmse = std::sqrt(squares / used);
    return {.term = options_.terms[term],
            .rmse = rmse,
            .over_default = std::sqrt(squares / of_default),
            .over_bound = rmse / bound_of(options_.terms[term]),
            .coverage = covered / used};
  }

  [[nodiscard]] double truth_of(noise::Term term) const {
    double sum = 0;
    for (const auto& p : truth_) {
      if (noise::term(p) == term) sum = std::hypot(sum, noise::coefficient(p));
    }
    return sum;
  }

  [[nodiscard]] double bound_of(noise::Term term) const {
    std::vector<noise::Process> random;
    std::ptrdiff_t at = -1;
    for (const auto& p : truth_) {
      if (noise::term(p) == noise::Term::rate_ramp || noise::term(p) == noise::Term::sinusoid) continue;
      if (noise::term(p) == term) at = static_cast<std::ptrdiff_t>(random.size());
      random.push_back(p);
    }
    return at < 0 ? kNaN : relative_bound(random, samples_, options_.dt)(at);
  }

  const std::vector<noise::Process>& truth_;
  const SweepOptions& options_;
  std::int64_t samples_;
  std::vector<Way> ways_;
  std::optional<noise::RecordGenerator> generator_;
  std::map<int, Covariance> covariances_;  // by taus an octave
};

// --- What is compared -----------------------------------------------------------------------------------------------

std::vector<Entry> entries_of_one_length() {
  std::vector<Entry> list;
  for (const Method m : kMethods) list.push_back({Comparison::method, {.method = m}});
  for (const Method m : {Method::gls, Method::edf, Method::loglog}) {
    list.push_back({Comparison::covariance, {.method = m}});
  }
  for (const int n : {1, 2, 4}) list.push_back({Comparison::taus_an_octave, {.taus_an_octave = n}});
  for (const int n : {0, 64, 32, 16, 8, 4, 2, 1}) list.push_back({Comparison::stride, {.overlap = n}});
  return list;
}

std::vector<Entry> entries_of_a_length() {
  return {{Comparison::record_length, {}},
          {Comparison::record_length, {.overlap = 16}},
          {Comparison::record_length, {.method = Method::whittle}}};
}

// One length, with what is compared there.
struct Part {
  std::int64_t samples = 0;
  int records = 0;
  std::vector<Entry> entries;
  [[nodiscard]] double work() const {
    return static_cast<double>(records) * (static_cast<double>(samples) + 1e4) *
           static_cast<double>(entries.size() + 2);
  }
};

// As many records of a length as cost about the same, up to those asked for.
int records_of(std::int64_t samples, int asked) {
  constexpr std::int64_t kSamplesTogether = 20'000'000;
  constexpr std::int64_t kFewest = 4;
  return static_cast<int>(std::min<std::int64_t>(asked, std::max(kFewest, kSamplesTogether / samples)));
}

std::vector<Part> parts_of(const SweepOptions& o) {
  std::vector<Part> parts{{o.samples, o.records, entries_of_one_length()}};
  constexpr std::int64_t kShortest = 10'000;
  for (std::int64_t n = kShortest; n <= o.longest; n *= 10) {
    parts.push_back({n, records_of(n, o.records), entries_of_a_length()});
  }
  return parts;
}

bool cancelled(const SweepOptions& o) { return o.cancel && o.cancel->load(std::memory_order_relaxed); }

// The records that were finished, from the first on.
std::vector<std::vector<Fitted>> all_records(const Bench& bench, const Part& part, const SweepOptions& o,
                                             const std::function<void(double)>& progress) {
  constexpr std::int64_t kMostTogether = 2'000'000;  // samples; longer records are made one by one, for memory
  constexpr std::size_t kBlock = 16;
  const std::size_t block = part.samples > kMostTogether ? 1 : kBlock;
  std::vector<std::vector<Fitted>> all;
  while (all.size() < static_cast<std::size_t>(part.records)) {
    const std::size_t done = all.size(), count = std::min(block, static_cast<std::size_t>(part.records) - done);
    std::vector<std::vector<Fitted>> next(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      if (!cancelled(o)) next[i] = bench.record(done + i);
    });
    if (cancelled(o)) break;
    std::ranges::move(next, std::back_inserter(all));
    progress(static_cast<double>(all.size()) / part.records);
  }
  return all;
}

void check(const std::vector<noise::Process>& truth, const SweepOptions& o) {
  const bool any = std::ranges::any_of(truth, [](const auto& p) { return noise::coefficient(p) > 0; });
  if (!any) throw std::invalid_argument("a sensor without noise has no accuracy to measure");
  constexpr std::int64_t kFewestSamples = 16;
  if (o.samples < kFewestSamples) {
    throw std::invalid_argument(fmt::format("{} samples are too few; at least {}", o.samples, kFewestSamples));
  }
  if (o.records < 1) throw std::invalid_argument(fmt::format("{} records are too few; at least 1", o.records));
}

}  // namespace

Sweep sweep(const std::vector<noise::Process>& truth, const SweepOptions& options) {
  check(truth, options);
  Sweep sweep;
  const auto start = Clock::now();
  const auto parts = parts_of(options);
  double work = 0, done = 0;
  for (const Part& part : parts) work += part.work();
  for (const Part& part : parts) {
    if (cancelled(options)) break;
    std::vector<Way> ways;
    for (const Entry& entry : part.entries) {
      if (std::ranges::find(ways, entry.way) == ways.end()) ways.push_back(entry.way);
    }
    const Bench bench(truth, options, part.samples, std::move(ways));
    const auto records = all_records(bench, part, options, [&](double share) {
      if (options.progress) options.progress(done + share * part.work(), work);
    });
    done += part.work();
    for (const Entry& entry : part.entries) {
      if (!records.empty()) sweep.rows.push_back(bench.row(entry, records));
    }
  }
  sweep.complete = !cancelled(options);
  sweep.seconds = seconds_since(start);
  return sweep;
}

}  // namespace gyrobudget::inline v0::fit

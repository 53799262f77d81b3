// SPDX-License-Identifier: MIT
#include "accuracy.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/estimation/fit/detail/judge.h"
#include "gyrobudget/noise/generate.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "information.h"

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
using Clock = std::chrono::steady_clock;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Records between two reports of progress: of some seconds at most, whatever the length.
std::size_t block_size(const AccuracyOptions& o) {
  constexpr std::int64_t kSamplesTogether = 1 << 21, kFewest = 16, kMost = 64;
  return static_cast<std::size_t>(std::clamp(kSamplesTogether / o.samples, kFewest, kMost));
}

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// What is kept of one record.
struct One {
  std::vector<Result> results;  // by method, stripped of what the tables do not need
  double seconds = 0;           // to make it and its curve
};

bool cancelled(const AccuracyOptions& o) { return o.cancel && o.cancel->load(std::memory_order_relaxed); }

void check(const std::vector<noise::Process>& truth, const AccuracyOptions& o) {
  const bool any = std::any_of(truth.begin(), truth.end(), [](const auto& p) { return noise::coefficient(p) > 0; });
  if (!any) throw std::invalid_argument("a sensor without noise has no accuracy to measure");
  if (o.methods.empty()) throw std::invalid_argument("no method to measure");
  constexpr std::int64_t kFewestSamples = 16;
  if (o.samples < kFewestSamples)
    throw std::invalid_argument(fmt::format("{} samples are too few; at least {}", o.samples, kFewestSamples));
  if (o.records < 1) throw std::invalid_argument(fmt::format("{} records are too few; at least 1", o.records));
}

// The truth's correlation time and frequency go to the fits that need them given.
class Study {
 public:
  Study(const std::vector<noise::Process>& truth, const AccuracyOptions& options)
      : options_(options),
        generator_(truth, options.samples, options.dt),
        factors_(allan::octave_factors(options.samples)) {
    if (options.answer) return;
    std::vector<noise::Process> kinds;
    for (const Term t : in_order(options.fit.terms)) {
      kinds.push_back(shaped_process(t, options.fit));
      const bool open = (t == Term::gauss_markov && !options.fit.correlation_time_s) ||
                        (t == Term::sinusoid && !options.fit.frequency_hz);
      shared_covariance_ = shared_covariance_ && !open;
    }
    if (shared_covariance_) covariance_.emplace(options.samples, factors_, options.dt, kinds);
  }

  [[nodiscard]] One record(std::uint64_t index) const {
    One one;
    const auto start = Clock::now();
    const noise::StreamKey key{options_.seed, index};
    const auto rate = options_.make ? options_.make(key) : generator_(key);
    Data record{.rate = rate, .dt = options_.dt};
    std::optional<allan::Curve> curve;
    if (!options_.answer) record.curve = &curve.emplace(allan::overlapped_variance(rate, options_.dt, factors_));
    one.seconds = seconds_since(start);
    if (covariance_) record.covariance = &*covariance_;
    for (const Method method : options_.methods) {
      Options fit_options = options_.fit;
      fit_options.method = method;
      Result result = options_.answer ? options_.answer(rate, fit_options) : fit(record, fit_options);
      result.residuals = {};
      result.spectrum = {};
      one.results.push_back(std::move(result));
    }
    return one;
  }

 private:
  const AccuracyOptions& options_;
  noise::RecordGenerator generator_;
  std::vector<std::int64_t> factors_;
  bool shared_covariance_ = true;
  std::optional<allan::CurveCovariance> covariance_;
};

// Root of the summed squares of the truth's processes of a term.
double truth_of(const std::vector<noise::Process>& truth, Term t) {
  double sum = 0;
  for (const auto& p : truth) {
    if (noise::term(p) == t) sum = std::hypot(sum, noise::coefficient(p));
  }
  return sum;
}

// Cramer-Rao bounds of the random terms; NaN for the others.
double bound_of(const std::vector<noise::Process>& truth, Term t, const AccuracyOptions& o) {
  std::vector<noise::Process> random;
  Eigen::Index at = -1;
  for (const auto& p : truth) {
    const bool is_random = noise::term(p) != Term::rate_ramp && noise::term(p) != Term::sinusoid;
    if (!is_random || !(noise::coefficient(p) > 0)) continue;
    if (noise::term(p) == t) at = static_cast<Eigen::Index>(random.size());
    random.push_back(p);
  }
  if (at < 0) return kNaN;
  return (o.fit.front_end ? relative_bound : relative_bound_unknown_bandwidth)(random, o.samples, o.dt)(at);
}

CoefficientAccuracy summarise(const std::vector<One>& all, std::size_t method, Term term, double truth) {
  CoefficientAccuracy a;
  a.term = term;
  a.truth = truth;
  double errors = 0, squares = 0, covered = 0, by_status = 0, identified = 0, covered_identified = 0;
  double stated = 0, answered = 0, covered_answered = 0;
  for (const One& one : all) {
    const Result& result = one.results[method];
    const Coefficient& c = result[term];
    a.values.push_back(c.value);
    const bool is_stated = c.status != Status::not_quotable;
    const bool is_tested = !std::isnan(result.p_value);
    const bool is_answer = is_stated && !(is_tested && result.verdict == Verdict::not_described);
    const double error = is_stated ? c.value / truth - 1 : 0;
    errors += error, squares += error * error, stated += is_stated;
    answered += is_answer, covered_answered += is_answer && c.lower <= truth && truth <= c.upper_two_sided;
    const bool inside = c.lower <= truth && truth <= c.upper, called = c.status == Status::identified;
    covered += c.lower <= truth && truth <= c.upper_two_sided;
    by_status += inside;
    identified += called;
    covered_identified += called && inside;
  }
  const auto records = static_cast<double>(all.size());
  a.bias = truth > 0 && stated > 0 ? errors / stated : kNaN;
  a.rmse = truth > 0 && stated > 0 ? std::sqrt(squares / stated) : kNaN;
  a.refused = 1 - answered / records;
  a.coverage_answered = answered > 0 ? covered_answered / answered : kNaN;
  a.coverage = covered / records;
  a.coverage_by_status = by_status / records;
  a.coverage_identified = identified > 0 ? covered_identified / identified : kNaN;
  a.identified = identified / records;
  a.missed = truth > 0 ? 1 - a.identified : 0;
  return a;
}

MethodAccuracy summarise(const std::vector<One>& all, std::size_t method, const std::vector<noise::Process>& truth,
                         const AccuracyOptions& o) {
  MethodAccuracy m;
  m.method = o.methods[method];
  for (const Term t : in_order(o.fit.terms)) {
    const bool has =
        std::any_of(all.front().results[method].coefficients.begin(), all.front().results[method].coefficients.end(),
                    [=](const auto& c) { return c.term == t; });
    if (!has) continue;  // slope and visual know no G, no S
    m.coefficients.push_back(summarise(all, method, t, truth_of(truth, t)));
    m.coefficients.back().bound = bound_of(truth, t, o);
    m.coefficients.back().over_likelihood = kNaN;
  }
  const double share = 1 / static_cast<double>(all.size());
  for (const One& one : all) {
    const Result& r = one.results[method];
    m.p_values.push_back(r.p_value);
    m.false_terms += share * std::any_of(r.coefficients.begin(), r.coefficients.end(), [&](const auto& c) {
                       return c.status == Status::identified && truth_of(truth, c.term) == 0;
                     });
    m.p_below_5_percent += share * (std::isnan(r.p_value) ? kNaN : r.p_value < 0.05);
    m.p_below_1_percent += share * (std::isnan(r.p_value) ? kNaN : r.p_value < 0.01);
    m.cut += share * !r.moved.empty();
    m.not_described += share * (r.verdict == Verdict::not_described);
    m.unconverged += share * !r.converged;
    m.seconds_per_fit += share * r.seconds;
  }
  return m;
}

void compare_with_likelihood(std::vector<MethodAccuracy>& methods) {
  const auto likelihood =
      std::find_if(methods.begin(), methods.end(), [](const auto& m) { return m.method == Method::whittle; });
  if (likelihood == methods.end()) return;
  for (MethodAccuracy& m : methods) {
    for (CoefficientAccuracy& a : m.coefficients) {
      for (const CoefficientAccuracy& b : likelihood->coefficients) {
        if (a.term == b.term) a.over_likelihood = a.rmse / b.rmse;
      }
    }
  }
}

}  // namespace

std::vector<Term> terms_to_measure(const std::vector<noise::Process>& truth) {
  std::vector<Term> terms{kDefaultTerms.begin(), kDefaultTerms.end()};
  for (const Term t : {Term::quantization, Term::rate_ramp}) {
    const auto has = [t](const noise::Process& p) { return noise::term(p) == t && noise::coefficient(p) > 0; };
    if (std::ranges::any_of(truth, has)) terms.push_back(t);
  }
  return terms;
}

Accuracy measure_accuracy(const std::vector<noise::Process>& truth, const AccuracyOptions& options) {
  const auto start = Clock::now();
  check(truth, options);
  const Study study(truth, options);
  std::vector<One> all;
  while (static_cast<int>(all.size()) < options.records && !cancelled(options)) {
    const std::size_t done = all.size();
    const auto count = std::min(block_size(options), static_cast<std::size_t>(options.records) - done);
    std::vector<One> block(count);
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      if (!cancelled(options)) block[i] = study.record(done + i);
    });
    if (cancelled(options)) break;
    std::move(block.begin(), block.end(), std::back_inserter(all));
    if (options.progress) options.progress(static_cast<int>(all.size()), options.records);
  }
  Accuracy accuracy;
  accuracy.records = static_cast<int>(all.size());
  accuracy.complete = accuracy.records == options.records;
  accuracy.samples = options.samples;
  accuracy.dt = options.dt;
  accuracy.seed = options.seed;
  for (std::size_t m = 0; m < options.methods.size() && !all.empty(); ++m)
    accuracy.methods.push_back(summarise(all, m, truth, options));
  compare_with_likelihood(accuracy.methods);
  for (const One& one : all) accuracy.seconds_per_record += one.seconds / static_cast<double>(all.size());
  accuracy.seconds = seconds_since(start);
  return accuracy;
}

}  // namespace gyrobudget::inline v0::fit

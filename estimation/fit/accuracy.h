// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/normal.h"
#include "gyrobudget/noise/process.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "fit.h"

namespace gyrobudget::inline v0::fit {

/// What simulated records of known truth say of one coefficient by one method. Shares are of all records; their
/// standard error is sqrt(p (1-p)/records), that of an RMSE about rmse/sqrt(2 records).
struct CoefficientAccuracy {
  noise::Term term = noise::Term::white;
  double truth = 0;
  double bias = 0;  ///< mean of value/truth - 1; NaN where the truth is 0, like all relative numbers here
  double rmse = 0;  ///< root mean square of value/truth - 1
  /// Cramer-Rao bound on it (see information.h); NaN for a ramp or a line. The bandwidth of a front end that the fits
  /// are not given is unknown in it.
  double bound = 0;
  double over_likelihood =
      0;                ///< rmse over that of Method::whittle on the same records; NaN where it was not asked for
  double coverage = 0;  ///< [lower, upper_two_sided] holds the truth
  double coverage_by_status = 0;   ///< [lower, upper], whose upper is one-sided where zero is not excluded
  double coverage_identified = 0;  ///< [lower, upper] holds the truth, of the records that call it identified
  double identified = 0;           ///< zero is excluded: for a truth of 0 the rate of false terms
  double missed = 0;               ///< 1 - identified where the truth is not 0, else 0
  double refused = 0;              ///< the fit says that it has no number: Status::not_quotable, or not described
  double coverage_answered = 0;    ///< `coverage` of the records that were not refused; NaN where all were
  std::vector<double> values;      ///< of every record, in order
};

struct MethodAccuracy {
  Method method = Method::gls;
  std::vector<CoefficientAccuracy> coefficients;  ///< of the terms fitted, in the order Q N B K R G S
  double false_terms = 0;        ///< share of records with at least one identified term whose truth is 0
  double p_below_5_percent = 0;  ///< share of records with p < 0.05; NaN for methods without a test
  double p_below_1_percent = 0;
  double cut = 0;            ///< share of records in which a part of the range was cut
  double not_described = 0;  ///< share with that verdict
  double unconverged = 0;
  double seconds_per_fit = 0;    ///< mean of Result::seconds: curve and its covariance excluded
  std::vector<double> p_values;  ///< of every record, in order
};

struct Accuracy {
  int records = 0;  ///< those that were finished
  bool complete = false;
  std::int64_t samples = 0;
  double dt = 1;
  std::uint64_t seed = 1;
  std::vector<MethodAccuracy> methods;
  double seconds_per_record = 0;  ///< to make a record and its curve, mean
  double seconds = 0;             ///< wall time of all
};

struct AccuracyOptions {
  std::int64_t samples = 36000;
  double dt = 1;
  int records = 2000;
  std::uint64_t seed = 1;
  std::vector<Method> methods = {Method::gls, Method::whittle};
  Options fit;  ///< terms, range and limits of every fit; its method is ignored
  /// Makes a record of `samples` rates of the truth, from its key; unset: noise::RecordGenerator. Called from many
  /// threads.
  std::function<std::vector<double>(noise::StreamKey key)> make;
  /// Fits a record; unset: fit(). Called from many threads.
  std::function<Result(std::span<const double> rate, const Options& options)> answer;
  /// Called from one thread at a time after each block of records.
  std::function<void(int done, int of)> progress;
  const std::atomic<bool>* cancel = nullptr;  ///< set from anywhere: the blocks finished so far are the result
};

/// The terms that a study of a sensor fits unless others are asked for: N, B and K, and Q and R where the truth has
/// them.
[[nodiscard]] std::vector<noise::Term> terms_to_measure(const std::vector<noise::Process>& truth);

/// Simulates records of the truth (exact generator, record i from stream i of the seed), fits each by every method and
/// compares. Everything but the times is the same for any number of threads, and record by record for any `records`:
/// a cancelled run is the longer run's beginning.
/// Memory: about 12 numbers per sample and thread. Cost a record of 36 000 samples: about 3 ms to make it and its
/// curve, 2 ms gls, 3 ms whittle, 3 ms the readings; 2000 records on two cores take 10 to 20 s.
/// @param truth processes of the sensor, at least one with a coefficient above zero; those not among the terms fitted
///   are simulated all the same. Numbers that a fit does not state (Status::not_quotable) count as refused, and in
///   neither bias nor RMSE.
/// @throws std::invalid_argument for an empty truth or list of methods, fewer than 16 samples or 1 record, and what fit
///   and noise::RecordGenerator refuse.
[[nodiscard]] Accuracy measure_accuracy(const std::vector<noise::Process>& truth, const AccuracyOptions& options = {});

}  // namespace gyrobudget::inline v0::fit

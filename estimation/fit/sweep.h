// SPDX-License-Identifier: MIT
// What each way to fit costs and buys: the same simulated records fitted in many ways, each way timed by itself.
#pragma once

#include "gyrobudget/noise/process.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

#include "fit.h"

namespace gyrobudget::inline v0::fit {

/// One way to fit a record; that of `Way{}` is the default.
struct Way {
  Method method = Method::gls;
  int taus_an_octave = 1;    ///< those between the octaves are the whole numbers next to 2^(i/2), 2^(i/4)
  std::int64_t overlap = 0;  ///< terms of the curve begin every m/overlap samples; 0: at every sample
  bool operator==(const Way&) const = default;
};

/// What a group of rows compares; within a group all else is as by default.
enum class Comparison {
  method,          ///< every method
  covariance,      ///< the curve's exact one (gls), its diagonal alone (edf), none (loglog)
  taus_an_octave,  ///< 1, 2, 4
  stride,          ///< terms at every sample, then every m/64, m/32, ... m/1
  record_length,   ///< by decades: the default, the stride m/16, and the likelihood
};

/// A coefficient that the truth has, by one way to fit.
struct SweptCoefficient {
  noise::Term term = noise::Term::white;
  double rmse = 0;          ///< relative to the truth; NaN, like the rest, where the method does not know the term
  double over_default = 0;  ///< over that of the default on the same records
  double over_bound = 0;    ///< over the Cramer-Rao bound; NaN for a ramp or a line
  double coverage = 0;      ///< share of records whose [lower, upper_two_sided] holds the truth
};

/// One way on the records of one length.
struct SweepRow {
  Comparison comparison = Comparison::method;  ///< the group it stands in
  Way way;
  std::int64_t samples = 0;
  int records = 0;
  int unconverged = 0;
  std::vector<SweptCoefficient> coefficients;
  double curve_seconds = 0,
         fit_seconds = 0;         ///< of one record, the first decile; the curve's is 0 where none is made
  double covariance_seconds = 0;  ///< once for all axes of a log; 0 where none is made
};

struct Sweep {
  bool complete = false;  ///< not cancelled; else the rows are of the records that were finished
  double seconds = 0;     ///< wall time of all
  std::vector<SweepRow> rows;
};

struct SweepOptions {
  std::int64_t samples = 36'000;      ///< of the records for all but the lengths
  std::int64_t longest = 10'000'000;  ///< lengths go by decades from 10^4 to this; none where it is less
  double dt = 1;                      ///< sample interval [s]
  /// Of each way; of lengths above 10^5 as many as make 2 10^7 samples, where that is fewer. An RMSE of n records is
  /// known to 1/sqrt(2 n) of itself, a coverage c to sqrt(c (1 - c)/n).
  int records = 200;
  std::uint64_t seed = 1;
  std::vector<noise::Term> terms{kDefaultTerms.begin(), kDefaultTerms.end()};  ///< of every fit
  /// Called from one thread at a time after each block of records; work in a unit of its own.
  std::function<void(double done, double of)> progress;
  const std::atomic<bool>* cancel = nullptr;  ///< set from anywhere: the blocks finished so far are the result
};

/// Fits the same records in many ways, each way timed by itself. The errors are the same for any number of threads,
/// the times are not.
///
/// Every fit uses every tau (tau_min is dt): what cuts of the range cost is not the question here. Strided curves are
/// fitted with the covariance of full overlap: their weights, and so their coverage, are those of a curve that is
/// better than they are. Records over 500 000 samples are made by the streaming generator, whose flicker is 0.016 %
/// from exact.
///
/// Cost: with the defaults some minutes on two cores, most of it for the lengths of 10^6 and 10^7.
/// @param truth processes of the sensor, at least one with a coefficient above zero.
/// @throws std::invalid_argument for an empty truth, fewer than 16 samples or 1 record, and what fit and
/// noise::RecordGenerator refuse.
[[nodiscard]] Sweep sweep(const std::vector<noise::Process>& truth, const SweepOptions& options = {});

}  // namespace gyrobudget::inline v0::fit

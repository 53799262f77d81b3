// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/accuracy.h"
#include "gyrobudget/noise/process.h"

#include <atomic>
#include <cstdint>
#include <functional>
#include <vector>

namespace gyrobudget::inline v0::cli {

struct SweepOptions {
  std::int64_t samples = 36'000;      ///< of the records for all but the lengths
  std::int64_t longest = 10'000'000;  ///< lengths go by decades from 10^4 to this
  double dt = 1;
  int records = 200;  ///< of each setting; fewer of lengths above 10^5
  std::uint64_t seed = 1;
  std::vector<noise::Term> terms;
  std::function<void(double done, double of)> progress;
  const std::atomic<bool>* cancel = nullptr;
};

/// Fits the same records in many ways, each way timed by itself: methods, taus an octave (1, 2, 4), strides m/1 to
/// m/64, and lengths. The errors are the same for any number of threads, the times are not.
///
/// Every fit uses every tau (tau_min is dt): what cuts of the range cost is not the question here.
/// Taus between the octaves are the whole numbers next to 2^(i/2) and 2^(i/4). Strided curves are fitted with the
/// covariance of full overlap: their weights, and so their coverage, are those of a curve that is better than they are.
/// Records over 500 000 samples are made by the streaming generator, whose flicker is 0.016 % from exact.
/// @param sweep gets rows, complete and seconds.
void measure_sweep(const std::vector<noise::Process>& truth, const SweepOptions&, report::Sweep& sweep);

}  // namespace gyrobudget::inline v0::cli

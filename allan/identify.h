// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <span>
#include <vector>

#include "series.h"

namespace gyrobudget::inline v0::allan {

/// The power-law noise S_y(f) ~ f^alpha of the rate that dominates at one averaging factor.
struct Identified {
  int alpha = 0;        ///< 2, 1, 0, -1 or -2
  double lag1 = 0;      ///< lag-1 autocorrelation r1 of the cluster means, differenced
  int differences = 0;  ///< how many times they were differenced, 0 or 1
  std::int64_t m = 1;   ///< factor at which it was found: the one asked for, or n/30 where that is shorter
  noise::Term term = noise::Term::white;  ///< Q for alpha 2 and 1, N for 0, B for -1, K for -2
  /// Where the record cannot tell: up to `share` of the variance may be of `widest`, with fewer degrees of freedom.
  noise::Term widest = noise::Term::white;
  double share = 0;
};

/// Lag-1 autocorrelation identification (W. Riley and C. Greenhall, "Power law noise identification using the lag 1
/// autocorrelation", EFTF 2004; NIST SP 1065 section 5.5.3) of a rate record at several averaging factors.
///
/// The means of n/m adjacent clusters have lag-1 autocorrelation r1 and delta = r1/(1 + r1). Below delta = 1/4 they are
/// taken as stationary, and alpha = -2 delta, rounded. Otherwise they are differenced once, and alpha is that of white
/// noise, flicker or random walk, whichever has its exact r1 at this m nearest. (The paper rounds -2 (delta + 1) here,
/// which at m > 10 puts a third of flicker records with random walk.)
///
/// The answer is a whole number and needs at least 30 clusters: above m = n/30 it is taken at n/30. It is right nearly
/// always for 500 clusters and more; with 30 one step off is common. Flicker of phase (alpha 1) reads as 2 above m = 10
/// or so, where aliasing has made it white. A trend reads as -2. All-equal samples read as 0.
///
/// NaN and infinite samples are missing; clusters with fewer than half of their samples are skipped, and so are the
/// products they would be in.
///
/// @param factors 1 <= m <= n/2 each.
/// @return one for each factor, in their order.
/// @throws std::invalid_argument for a factor out of range.
/// Of more than 2^15 clusters 16 stretches of 2^11 neighbours, spread evenly over the record, are looked at: r1 is then
/// known to 0.006 (one sigma), and no two exponents are nearer than 0.1.
/// Cost: prefix sums of the record once, then O(min(n/m, 2^15)) for each factor.
[[nodiscard]] std::vector<Identified> identify_noise(const Series& record, std::span<const std::int64_t> factors);
/// The same of rates alone.
[[nodiscard]] std::vector<Identified> identify_noise(std::span<const double> rate,
                                                     std::span<const std::int64_t> factors);
/// At one factor.
[[nodiscard]] Identified identify_noise(std::span<const double> rate, std::int64_t m);

/// Noises along a curve, without the leaps that few clusters make: from the shortest factor on each noise holds until
/// the lag-1 autocorrelation rejects it by more than 2/sqrt(clusters), its 95 % scatter; then the one found there
/// takes over. With thousands of clusters nothing changes; with 30, where one step off is common, the noise of the
/// last factor that could tell goes on.
///
/// Angle noise has degrees of freedom by the sample, not by the cluster: intervals would be far too narrow where it is
/// seen by mistake. It never holds, and takes over only where the autocorrelation is below -1/4 by that scatter.
/// @param found at ascending or any other factors of one record of n samples.
[[nodiscard]] std::vector<Identified> held_noise(std::vector<Identified> found, std::int64_t samples);

}  // namespace gyrobudget::inline v0::allan

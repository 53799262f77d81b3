// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// A sample that noise would not put where it is: a knock, a glitch of the link.
struct Outlier {
  std::int64_t index = 0;
  double distance = 0;  ///< from the median of its surroundings [signal]
  double sigmas = 0;    ///< |distance| in standard deviations of such distances
};

struct OutlierOptions {
  double false_alarm = 1e-4;  ///< probability that a record of Gaussian noise shows any outlier at all
  double limit = 0;           ///< above 0: in place of that, the distance from which on a sample is one [sigmas]
};

/// Outliers of a record, in order of time.
///
/// A sample is one where it lies further from the median of its 41 neighbours than Gaussian noise puts any of n samples
/// with probability false_alarm. The scale is robust: 1.4826 times the median distance over up to 10^4 samples spread
/// over the record, 5 % added for its own scatter, and never below the smallest distance above zero, so that records
/// of coarse counts are not full of outliers. The surroundings follow flicker, random walk and drift, so these hide
/// no knock. Holds for up to a quarter of the samples of any 41 being outliers; bursts longer than that are not
/// noise beside the record but part of it (see steps.h). Noise with heavier tails than Gaussian has outliers.
/// NaN and infinite samples are missing. All-equal surroundings (scale 0) have none.
///
/// @throws std::invalid_argument for a false alarm outside (0, 1) and a limit that is negative or NaN.
/// Cost: one pass; a sorted neighbourhood for about one sample in 300.
/// Source: the Hampel identifier (L. Davies and U. Gather, J. Am. Stat. Assoc. 88 (1993) 782).
[[nodiscard]] std::vector<Outlier> find_outliers(std::span<const double> rate, const OutlierOptions& options = {});

/// Median distance of samples from the median of their 40 neighbours, they themselves left out, over up to `looks`
/// samples spread over the record: 0.6745 sigma of such distances where the noise is Gaussian. 0 where there are none.
[[nodiscard]] double median_distance(std::span<const double> rate, std::int64_t looks);

}  // namespace gyrobudget::inline v0::allan

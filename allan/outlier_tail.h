// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "outliers.h"

namespace gyrobudget::inline v0::allan {

/// Outliers of which more hide in the noise than stand out of it: a share e of the samples has errors whose distances
/// from their surroundings are normal with s times the sigma of the others,
///
///     p(x) = (1 - e) phi(x) + e phi(x/s)/s,   x in sigmas of the distances of undisturbed samples.
struct OutlierTail {
  double share = 0;   ///< e
  double sigmas = 0;  ///< s
  double limit = 0;   ///< x from which on a sample more likely belongs to the tail: those are the outliers
  /// E[x^2 | |x| < limit] - 1: what the variance of the samples that are left differs by from that of the noise. What
  /// hides raises it, what is cut off the noise lowers it.
  double left = 0;
  double left_sigma = 0;  ///< one sigma of it
  double sigma = 0;       ///< of the distance of an undisturbed sample from its surroundings [signal]
};

/// Kurtosis of the contaminated normal: 3 of a normal one.
[[nodiscard]] double kurtosis(const OutlierTail& tail);

/// The tail that the outliers of a record show, or none: it takes twenty or more that stand out one by one, not in
/// bursts. Maximum likelihood of e and s over the samples beyond the limit, whose number counts too; from the outliers
/// that were found first, then again with those that its limit adds, which replace `outliers`.
///
/// Of 60 records of 1e5 samples each, with normal errors of 10 or 30 sigma in a thousandth or a hundredth, of 5 sigma
/// in a hundredth and of 3 sigma in a twentieth of the samples, `left` is within 1.96 left_sigma of the truth in 95 %
/// and more (tests/allan/outlier_tail_test has twenty of each). The errors' shape is taken for normal, to a tenth of
/// what hides.
/// @param rate      samples of the record, NaN where missing
/// @param outliers  find_outliers of it
/// Cost: one more search, some 1e-8 s a sample, and a fit to a histogram; only of records that have such outliers.
/// Source: the EM view of scale mixtures (J. Tukey's contaminated normal; G. McLachlan and D. Peel, Finite Mixture
/// Models, 2000); the censored likelihood is this project's.
[[nodiscard]] std::optional<OutlierTail> find_outlier_tail(std::span<const double> rate,
                                                           std::vector<Outlier>& outliers);

}  // namespace gyrobudget::inline v0::allan

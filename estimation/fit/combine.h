// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "fit.h"

namespace gyrobudget::inline v0::fit {

/// One coefficient of a sensor type from several records (power-ups, units), which are never joined into one series.
struct Combined {
  noise::Term term = noise::Term::white;
  std::size_t records = 0;      ///< in which it was fitted
  std::size_t identified = 0;   ///< of these
  double value = 0;             ///< root of the mean of c^2
  double lower = 0, upper = 0;  ///< 95 % of that mean
  double spread = 0;            ///< standard deviation of c between records, beyond what each one's scatter explains
  double next_lower = 0,
         next_upper = 0;  ///< 95 % for the true coefficient of another record; equal to the above at
                          ///< fewer than 3 records, where nothing is known of it
  double q = 0;           ///< Cochran's Q; `records` - 1 of it where the records agree
  double p_value = 1;     ///< of Q: below 0.05 the records differ by more than their scatter
};

/// Random-effects mean of every coefficient Q N B K R that at least one result fitted:
///   c_i^2 = mu + u_i + e_i,  u_i of variance T^2 between the records, e_i of variance v_i within.
/// It is on the scale of squares, where estimates are linear, unbiased and may be zero; logarithms have no zero and
/// would leave out the records that saw nothing. v_i comes from each two-sided interval, (upper^2 - lower^2)/3.92 being
/// a standard deviation; where the interval reaches zero, from its upper half. T^2 is Paule and Mandel's: the value at
/// which the weighted squares equal their degrees of freedom. The interval of mu is Hartung, Knapp, Sidik and Jonkman's
/// with Student's t, never narrower than the normal one; that of another record adds T^2 (t with records - 2).
/// One record gives itself.
///
/// Relative weights of squares depend on the estimates: a record that happened to read low also claims to be precise.
/// So within-variances are pooled: v_i = r_i^2 m^2, r_i the relative one at the mean m of all squares, not at its own.
/// @throws std::invalid_argument for no results.
/// Source: R. C. Paule, J. Mandel, J. Res. NBS 87 (1982) 377; J. Hartung, G. Knapp, Stat. Med. 20 (2001) 3875.
[[nodiscard]] std::vector<Combined> combine(std::span<const Result> records);

}  // namespace gyrobudget::inline v0::fit

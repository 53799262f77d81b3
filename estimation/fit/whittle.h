// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <vector>

#include "fit.h"

namespace gyrobudget::inline v0::fit {

/// Maximum likelihood of the record itself, without its Allan curve: the independent check of the curve's fit.
///
/// The sine transform (DST-I) of the differenced record has coefficients c_k, k = 1 .. n-1, that are Gaussian with
/// variances sum_a theta_a phi_a(k) (detail/dst.h): exactly independent for white noise and rate random walk, nearly
/// for the rest (flicker: correlations up to 0.12 between the lowest, which this treats as none). Hence
///   -2 ln L = sum_k ln lambda_k + c_k^2 / lambda_k,
/// in some 200 logarithmic bins, maximised over theta >= 0 by Newton's method. The ramp R is a mean, signed and linear.
/// A Gauss-Markov correlation time and a line's frequency are searched over the whole band (ratio 10^(1/4), or the
/// highest peak against the fitted spectrum from 8 cycles in the record on; then to the root of the likelihood's slope,
/// 1e-10) unless Options has them, or says near what.
///
/// Intervals by profile likelihood ratio, cut 3.841, one-sided limit and boundary test 2.706; the ramp's test is
/// two-sided (3.841), the line's is the largest of n frequencies (2 ln(20 n), 5 %). A line's interval is that of its
/// amplitude beside known noise.
/// chi2 and p-value: the record's power in at most 33 logarithmic bands, each turned into a normal deviate by its
/// chi-square law, dof = bands less parameters. In 12 000 records of
/// 36 000 samples P(p < 0.05) and P(p < 0.01) were 5.1 and 1.1 % for the MEMS gyro of the paper, 4.7 and 1.0 % for its
/// fibre-optic one, 5.2 and 0.9 % without flicker (0.2 and 0.1 of scatter).
///
/// Range: Options::tau_min_s and tau_max_s keep the frequencies 1/(2 tau_max) to 1/(2 tau_min). Where tau_min_s is
/// unset and the whole band has a p-value below 1e-4, the band is halved from above until the model describes it, as
/// the curve's fit cuts its short taus; quantization is fitted from the whole band only.
///
/// Gaps: all of a record is used. Gaps of up to 64 samples are filled with what the rest says they could have been
/// (detail/fill.h), and filled samples count for less. Longer ones, and all where more than a tenth of the samples
/// would be filled, cut the record into stretches, each with a mean of its own, whose log-likelihoods add: nothing is
/// assumed of what happened between them. A stretch has at least 16 samples and is trimmed at its end to a length
/// 2^a 3^b 5^c. Bins of frequency are those of the longest stretch, and a line's frequency and amplitude too. Fewer
/// than 16 samples in a row, or samples all equal, have no answer.
/// `residuals` stays empty: `spectrum` is what there is to compare.
///
/// Cost: one real FFT of n points and about 1 ms; thread-safe, the same bytes always.
/// @param rate samples [signal], NaN or infinite where missing. @param dt sample interval [s].
/// @throws std::invalid_argument for a repeated or missing term, dt, a correlation time or a frequency out of range.
/// Source: P. Whittle 1953; the transform of differences and its end corrections are this project's (theory in dst.h).
[[nodiscard]] Result fit_likelihood(std::span<const double> rate, double dt, const Options& options = {});

/// A front end that was found in a record.
struct FoundFrontEnd {
  noise::FrontEnd front_end;
  WhiteShift choice;
};

/// The low pass in front of a record's samples, if one of the kinds (Options::front_end_kind: of this kind) describes
/// its spectrum from half the rate down to 1/2000 of that, with white noise, flicker and a walk behind it.
/// The kind is that of the least -2 ln L over its bandwidth, for each way of sampling (noise::FrontEnd; at two to
/// four times the log's rate too), with the gain
/// of each bin a factor on every spectrum; it stands where the p-value of the 33 bands reaches 0.001 (a kind that was
/// asked for: always). None for fewer than 1000 samples, outside bandwidths of 0.001 to 2 times the rate, and where one
/// sigma of the bandwidth's logarithm is above 0.35. Cost: some 250 maximisations over up to 1200 bins, 0.1 to 0.2 s on
/// one core of a 2020s processor.
/// @param rate     samples, NaN where missing; the longest stretch and what transform_record adds to it
/// @param dt       sample interval [s]
/// @param options  front_end_kind and p_value_limit count
/// @return bandwidth in Hz; its standard deviation is that of fit_likelihood's profile
/// @throws std::invalid_argument as fit_likelihood does
/// Source: likelihood as in fit_likelihood; the candidates and their acceptance are this project's.
[[nodiscard]] std::optional<FoundFrontEnd> find_front_end(std::span<const double> rate, double dt,
                                                          const Options& options = {});

/// Whether two fits of one record tell the same of one coefficient.
struct Agreement {
  noise::Term term = noise::Term::white;
  double first = 0, second = 0;  ///< values
  /// Difference of the squared coefficients in standard deviations: a 1/3.92 of the wider two-sided interval.
  double difference = 0;
  double limit = 0;  ///< that fewer than one record in 500 passes where the model holds
  bool agrees = true;
};

struct CrossCheck {
  std::vector<Agreement> coefficients;  ///< those that both fitted and both limit
  bool agrees = true;                   ///< all of them
  bool same_range = true;  ///< false: the fits used different ranges of tau, which says something by itself
};

/// Compares the curve's fit with the likelihood's, both made with Options::intervals and, to compare like with like,
/// the likelihood with the curve's Result::tau_min_s.
///
/// Both see the same record, so where the model holds they differ by far less than their standard deviation. Limits,
/// from the 99.9 % points over 1000 records of each of seven cases (both gyros of the paper over 1, 10 and 20 h,
/// without flicker, white noise alone, flicker alone): 0.35 for N, 0.6 for B, 0.8 for others, times the relative
/// standard deviation of K over 13 % within 1 to 4: with few independent long periods the two methods weigh them less
/// alike. Gaps add to them, as the two lose differently by these (measured in whittle.cpp).
[[nodiscard]] CrossCheck cross_check(const Result& gls, const Result& whittle);

}  // namespace gyrobudget::inline v0::fit

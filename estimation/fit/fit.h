// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/covariance.h"
#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/noise/front_end.h"
#include "gyrobudget/noise/process.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace gyrobudget::inline v0::fit {

/// How coefficients are taken from a record. RMSE in 10 h at 1 Hz of (N, B, K) for the paper's MEMS gyro in brackets;
/// fit_study makes the whole table.
enum class Method {
  gls,      ///< generalised least squares with the curve's exact covariance: the default (0.41 %, 20 %, 13 %)
  edf,      ///< least squares weighted with each tau's own variance, correlations ignored (0.42 %, 20 %, 14 %)
  loglog,   ///< unweighted least squares of logarithms, as most published tools do (5 %, 91 %, 47 %)
  slope,    ///< tangents of slope -1/2, 0, +1/2, as MATLAB's example does (see visual.h)
  visual,   ///< three points read off the plot, as the source paper did; here to show what that costs (see visual.h)
  whittle,  ///< maximum likelihood of the record itself, without its Allan curve (see whittle.h); as good as gls
};
inline constexpr std::array kMethods{Method::gls,   Method::edf,    Method::loglog,
                                     Method::slope, Method::visual, Method::whittle};
/// "gls", "edf", "loglog", "slope", "visual" or "whittle".
[[nodiscard]] std::string_view name(Method method);

/// What a record says of one coefficient.
enum class Status {
  /// The boundary test T(0) exceeds its cut (kBoundaryCut where the model fits): zero is excluded, at 5 % of one side.
  /// The two-sided interval excludes it from 3.841 on only: with T(0) between, `lower` is 0.
  identified,
  upper_bound,   ///< zero is not excluded; `upper` is the one-sided 95 % limit
  left_out,      ///< never fitted, or zero with a limit that adds under 1 % to the deviation at every tau
  not_quotable,  ///< fitted, but this record cannot give it: its readings are rounded to steps above their noise
};

/// 5 % cut of the boundary law, half chi-square with 0 and half with 1 degree of freedom; its signed root (1.645) is
/// also the one-sided 95 % limit.
inline constexpr double kBoundaryCut = 2.706;
/// 95 % cut of chi-square with 1 degree of freedom: the two-sided interval.
inline constexpr double kIntervalCut = 3.841;

/// One coefficient (Q, N, B, K, R, sigma of G or amplitude of S), SI, in the units of the signal.
struct Coefficient {
  noise::Term term = noise::Term::white;
  double value = 0;
  double lower = 0;            ///< 95 %; 0 where the interval reaches it
  double upper = 0;            ///< 95 %: two-sided for `identified`, one-sided for `upper_bound` and zero `left_out`
  double upper_two_sided = 0;  ///< 95 %, two-sided whatever the status: [lower, this] covers 95 % of all records
  double relative_std = 0;     ///< one sigma over value, from the Gauss-Newton covariance; infinite where value is 0
  double boundary_test = 0;    ///< T(0); infinite where nothing but this term can explain the curve
  /// Correlation time [s] of G, frequency [Hz] of S; 0 for others. The limits are 95 %, and equal to it where it was
  /// given or the data do not bound it.
  double shape = 0, shape_lower = 0, shape_upper = 0;
  Status status = Status::left_out;
  bool fitted = false;  ///< false: value, lower and upper mean nothing
};

enum class Verdict {
  described,         ///< the model explains the curve: p-value at least Options::p_value_limit
  described_within,  ///< it does not, but misses no tau by more than Options::misfit_limit beyond the scatter
  not_described,     ///< the coefficients are not a description of this record
};

/// One tau of the octave grid beside the fitted model.
struct Residual {
  std::int64_t m = 1;
  double tau_s = 0;
  double measured = 0;      ///< Allan deviation of the record
  double model = 0;         ///< of the fitted model, discrete form
  double relative_std = 0;  ///< of the measured deviation, under the model
  double misfit = 0;        ///< measured / model - 1
  bool used = false;        ///< in the fit; the others were cut, at the short or the long end
};

/// One of some 33 logarithmic bands of the record's spectrum beside the likelihood's model.
struct SpectralResidual {
  double frequency_hz = 0;  ///< geometric middle
  double count = 0;         ///< independent coefficients in it
  double misfit = 0;        ///< root of measured over modelled power, less 1
  double relative_std = 0;  ///< of that root
};

/// How far a coefficient moved because taus were cut.
struct Move {
  noise::Term term = noise::Term::white;
  double from = 0;  ///< fitted to every tau
  double to = 0;    ///< fitted from Result::tau_min_s on
};

/// N, B and K: what datasheets give and most records hold.
inline constexpr std::array kDefaultTerms{noise::Term::white, noise::Term::flicker, noise::Term::rate_random_walk};

/// How N is to be moved by what a fit does not see, and what is not known of that.
struct WhiteShift {
  double shift = 0;  ///< of ln N
  double sigma = 0;  ///< one sigma of it
};

struct Options {
  std::vector<noise::Term> terms{kDefaultTerms.begin(), kDefaultTerms.end()};
  Method method = Method::gls;
  std::optional<double> tau_min_s;  ///< start of the fit; unset: start of the longest run that the model describes
  std::optional<double> tau_max_s;  ///< end of the fit; unset: the last tau of the curve
  double p_value_limit = 0.01;      ///< a run is described when its p-value is at least this
  double misfit_limit = 0.10;       ///< largest misfit of `described_within`
  bool intervals = true;            ///< false: values only, for studies that need no intervals
  std::optional<double> correlation_time_s;  ///< of G; unset: fitted, by the likelihood
  std::optional<double> frequency_hz;        ///< of S; unset: fitted, by the likelihood
  /// Where unset shapes were seen before (Selection has them): the correlation time is then searched within a factor of
  /// 4 of this, the frequency within 4 cycles in the record, whatever else the record holds.
  std::optional<double> near_correlation_time_s, near_frequency_hz;
  /// The low pass in front of the samples, where it is known: taken as it is, or its bandwidth as a start.
  std::optional<noise::FrontEnd> front_end;
  bool fit_bandwidth = false;
  WhiteShift front_end_choice = {};  ///< FittedFrontEnd::choice of the one that was found
  /// The kind, where that alone is known.
  std::optional<noise::FrontEnd::Kind> front_end_kind;
  /// Whether a front end is looked for where the record's short taus are not those of the terms.
  bool find_front_end = true;
  /// With tau_min_s: allows for what any filter leaves from there on, a signed term in 1/tau^2 of the variance (of the
  /// likelihood a curvature of the logarithm of the gain).
  bool unknown_front_end = false;
};

/// The low pass between the noise and the samples.
struct FittedFrontEnd {
  /// Empty where only its memory was seen: which kind it is cannot be told, and the limits hold for all of them.
  std::optional<noise::FrontEnd::Kind> kind;
  double bandwidth = 0;                                                      ///< -3 dB [Hz]
  double lower = 0, upper = 0;                                               ///< 95 %; of a given front end equal to it
  noise::FrontEnd::Sampling sampling = noise::FrontEnd::Sampling::analogue;  ///< that explains the record best
  double oversampling = 1;                                                   ///< likewise
  bool fitted = false;                                                       ///< false: given
  /// It was chosen among kinds and ways of sampling that explain the record about as well: from its N to the mean over
  /// all of them, each with its weight, and their scatter about that. Result's N has it in it.
  WhiteShift choice = {};

  /// @throws std::logic_error where the kind is unknown.
  [[nodiscard]] noise::FrontEnd value() const;
};

struct Result {
  Method method = Method::gls;
  std::vector<Coefficient> coefficients;  ///< Q, N, B, K, R, in this order, fitted or not; then G, S if asked for
  std::vector<noise::Term> fitted_terms;  ///< order of `covariance`
  Eigen::MatrixXd covariance;             ///< of the fitted coefficients (not squares); NaN rows where value is 0
  double tau_min_s = 0;
  double tau_max_s = 0;
  double chi2 = 0;  ///< r' S^-1 r over the used taus with n/m >= 16, linear residuals
  int dof = 0;      ///< number of those taus less number of terms above zero
  double p_value = 0;
  double worst_misfit = 0;  ///< largest part of |misfit| beyond its 95 % scatter, same taus
  double worst_misfit_tau_s = 0;
  Verdict verdict = Verdict::not_described;
  std::vector<Residual> residuals;  ///< every tau of the curve
  std::vector<Move> moved;          ///< empty where nothing was cut at the short end
  double minimum_deviation = 0;     ///< raw minimum of the measured curve over tau <= T/10
  double minimum_tau_s = 0;
  std::optional<FittedFrontEnd> front_end;  ///< where one was given or found
  double beta = 0;                          ///< B^2/(N K), what makes B visible; 0 where N or K is 0
  bool converged = false;
  int iterations = 0;  ///< reweighting steps plus Ceres iterations of the final fit
  double seconds = 0;  ///< wall time; without covariance matrices, but for those of a front end that was found
  // Of Method::whittle only:
  std::vector<SpectralResidual> spectrum;
  std::int64_t first_sample = 0;  ///< of the first stretch that the likelihood is of
  std::int64_t samples = 0;       ///< of all stretches, each trimmed to a length of a fast transform
  std::int64_t stretches = 0;     ///< that the likelihood is of
  double filled_share = 0;        ///< of these samples: missing ones that were filled in
  double log_likelihood = 0;      ///< up to a constant of the record: differences between models count

  /// @throws std::invalid_argument for G or S where it was not asked for.
  [[nodiscard]] const Coefficient& operator[](noise::Term) const;
  /// The fitted processes whose value is above zero.
  [[nodiscard]] std::vector<noise::Process> processes() const;
};

/// What a method may need of one axis.
struct Data {
  std::span<const double> rate;  ///< samples [signal], NaN where missing; needed by `whittle` and where curve is null
  double dt = 1;                 ///< sample interval [s]
  const allan::Curve* curve = nullptr;                 ///< octaves of it; null: made from `rate`
  const allan::CurveCovariance* covariance = nullptr;  ///< of the curve, with the terms asked for; null: made
};

/// Moves N, its limits and covariances, and adds what is not known of the shift to its interval and variance.
void shift_white(Result& result, const WhiteShift& by);

/// Fits by any method: every Options::method answers with the same Result.
///
/// Records of extreme scale are brought to 1 by a power of two first, so their squares stay inside double.
/// `gls` looks for a front end where the curve's short taus ask for one (p-value of the whole curve below 1e-4, or a
/// filter's memory that explains more than chance does in one record of 10^4): the kind and sampling of a low pass that
/// describe the record's spectrum (find_front_end); its bandwidth is then fitted to the curve with the coefficients,
/// and intervals hold for all that is not known of it. Curve methods with term G or S need its correlation time or
/// frequency: where Options has none, the likelihood's is taken, with its limits, and the intervals of the coefficients
/// hold it fixed. Where the likelihood has none (a record of gaps) the term is not fitted. `slope` and `visual` read N,
/// B and K whatever the terms.
/// @throws std::invalid_argument for what the overloads below and fit_likelihood refuse, and for a record that has
/// neither samples nor curve, or no samples where the method needs them.
[[nodiscard]] Result fit(const Data& record, const Options& asked = {});

/// Fits noise coefficients to an Allan variance curve.
///
/// Model: E[s_i] = sum_a A_ia theta_a with theta_a = coefficient^2 >= 0 and A the exact discrete Allan variances
/// (noise::allan_variance; corrected for missing samples). Residuals r = s - A theta are linear and weighted with the
/// exact covariance S(theta) of the overlapped estimates, iterated to its fixed point; on octaves this reaches the
/// likelihood of the whole record (RMSE ratio 1.00 to 1.01). Ceres makes the final step in the coefficients
/// themselves and gives their covariance.
///
/// Intervals: {v : T(v) <= cut}, T(v) = Q(th_v; S(th_v)) - min_th Q(th; S(th_v)), Q(th; S) = r' S^-1 r, where th_v
/// is the iterated fit with the coefficient held at v: both fits see one and the same S. With S frozen at the estimate
/// (Wald), or two different S, or ln det S added, coverage of K falls to 0.86-0.93.
/// Values and intervals come from the full fit always; the boundary test T(0) only sets `status`, and with it which
/// limit `upper` is. Choosing the limit by the status costs coverage where the truth is near the cut (93 % for the B of
/// the paper's MEMS gyro in 10 h): [lower, upper_two_sided] does not.
/// Where the fit's p-value is below p_value_limit, all cuts are multiplied by chi-square per degree of freedom, and a
/// term counts as identified only beyond the 0.1 % point of F(1, dof): a model that is wrong lends no significance to
/// its smallest parts.
///
/// Start: every tau, unless that has a p-value below 1e-4 (a true model is cut in one record of some thousands). Then
/// the sensor may be filtered: beyond a filter's memory all that it leaves in the variance is one term in 1/tau^2 of
/// any sign, -3/2 S1/S0 N^2/(m^2 dt) with S1/S0 its memory in samples. With that term beside the others the start is
/// one octave behind the first tau from which the p-value reaches p_value_limit and whose removal lowers chi-square by
/// less than 6.63, among starts that leave at least half of the octaves with n/m >= 16: what a test cannot see is as
/// large as an interval. Where there is none, every tau is used and the verdict says so. Quantization is fitted from
/// the first tau only: it is strongest there, and behind a filter it cannot be told. Options::front_end replaces white
/// noise by filtered white noise in model and covariance, from the first tau on; a bandwidth that is fitted enters by
/// its slope.
///
/// @param curve       variances of one axis at ascending factors, octave-spaced or sparser (denser grids make S
///                    singular); points without terms (NaN) are skipped.
/// @param covariance  for the curve's record length, factors, form and mask, and at least the terms asked for. It
///                    holds for any axis of the same record: make it once.
/// Other methods of the curve (edf, loglog, slope, visual) are chosen by Options::method.
/// A curve that is zero everywhere, because nothing varies or because squares below 1e-300 left double, has no answer:
/// `fitted` is false for every coefficient.
/// @throws std::invalid_argument for a repeated or missing term, R or S without a random term (gls and edf), G without
///                    Options::correlation_time_s, S without Options::frequency_hz, a covariance of other factors,
///                    fewer taus than terms plus one, or Method::whittle, which needs samples.
/// Sources: theory of generalised least squares; IEEE Std 952-2020 annex C for the model; the interval construction
/// and its measured coverage are this project's own (tests/estimation/fit/fit_study).
[[nodiscard]] Result fit(const allan::Curve& curve, const allan::CurveCovariance& covariance,
                         const Options& options = {});
/// The same for a single curve, making the covariance on the way.
[[nodiscard]] Result fit(const allan::Curve& curve, const Options& options = {});

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/covariance.h"
#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/noise/process.h"

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::fit {

enum class Method { gls, visual };

/// What a record says of one coefficient.
enum class Status {
  identified,   ///< the boundary test exceeds 2.706 (5 % one-sided)
  upper_bound,  ///< zero is not excluded: `upper` is the one-sided 95 % limit
  left_out,     ///< not fitted, or zero with a limit that adds under 1 % to the deviation at every tau
};

struct Coefficient {
  noise::Term term = noise::Term::white;
  double value = 0;          ///< SI; fitted ones always have numbers
  double lower = 0;          ///< 95 %
  double upper = 0;          ///< 95 %, two-sided for `identified`, one-sided for `upper_bound`
  double relative_std = 0;   ///< std / value from the Gauss-Newton covariance; infinite where value is 0
  double boundary_test = 0;  ///< T(0), chi-square mixture with one degree of freedom
  Status status = Status::left_out;
  bool fitted = false;
};

enum class Verdict { described, described_within, not_described };

/// Which taus were cut before `tau_min`, and how much that moved each fitted coefficient.
struct Cut {
  double tau_s = 0;          ///< a tau that was not used
  double misfit = 0;         ///< measured/model deviation - 1, model of the final fit
};

struct Move {
  noise::Term term;
  double from = 0;           ///< value with all taus
  double to = 0;             ///< value from tau_min on
};

struct Residual {
  std::int64_t m = 1;
  double tau_s = 0;
  double measured = 0;       ///< deviation
  double model = 0;          ///< deviation
  double sigma = 0;          ///< (measured variance - model variance) / its standard deviation
  bool used = false;
};

struct Options {
  std::vector<noise::Term> terms = {noise::Term::white, noise::Term::flicker, noise::Term::rate_random_walk};
  Method method = Method::gls;
  std::optional<double> tau_min_s;   ///< fixed start of the fit instead of the longest described run
  std::optional<double> tau_max_s;
  double p_value_limit = 0.01;       ///< a run is described when its p-value is at least this
  double misfit_limit = 0.10;        ///< largest misfit that still counts as `described_within`
};

struct Result {
  Method method = Method::gls;
  std::vector<Coefficient> coefficients;       ///< one for each of Q, N, B, K, R, in this order
  Eigen::MatrixXd covariance;                  ///< of the fitted squared coefficients, order of `fitted_terms`
  std::vector<noise::Term> fitted_terms;
  double tau_min_s = 0;
  double tau_max_s = 0;
  double chi2 = 0;                             ///< over n/m >= 16
  int dof = 0;
  double p_value = 0;
  double worst_misfit = 0;                     ///< largest |measured/model - 1| of the deviation where n/m >= 16
  double worst_misfit_tau_s = 0;
  Verdict verdict = Verdict::not_described;
  std::vector<Cut> cut;
  std::vector<Move> moved;
  std::vector<Residual> residuals;             ///< the whole octave grid
  double minimum_deviation = 0;                ///< raw minimum of the curve over tau <= T/10
  double minimum_tau_s = 0;
  double beta = 0;                             ///< B^2 / (N K); 0 where N or K is 0
  bool converged = false;
  int iterations = 0;
  double seconds = 0;

  [[nodiscard]] const Coefficient& operator[](noise::Term) const;
  /// The fitted processes with non-zero values.
  [[nodiscard]] std::vector<noise::Process> processes() const;
};

/// Fits noise coefficients to an octave-spaced Allan variance curve.
/// @param curve on octave_factors(samples), or a subset of them.
/// @param covariance for curve's length, factors and (at least) the terms asked for; share it among axes.
[[nodiscard]] Result fit(const allan::Curve& curve, const allan::CurveCovariance& covariance, const Options& = {});
/// The same, making the covariance itself.
[[nodiscard]] Result fit(const allan::Curve& curve, const Options& = {});

}  // namespace gyrobudget::inline v0::fit

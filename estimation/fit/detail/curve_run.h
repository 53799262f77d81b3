// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/covariance.h"
#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/estimation/fit/fit.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gls.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::fit {

/// p-value of the whole curve below which short taus may be cut.
inline constexpr double kCutBelow = 1e-4;

/// What a front end adds to the terms, as a column of the linear model that may have any sign.
enum class Free {
  nothing,
  memory,     ///< all that any filter leaves beyond its memory: -3/2 S1/S0 N^2/dt/m^2
  bandwidth,  ///< N^2 d AVAR/d ln bandwidth of Options::front_end
};
[[nodiscard]] Free free_of(const Options& options);

/// A curve ready to fit: points with terms, terms in the order Q N B K R, variances scaled by a power of two so that
/// neither unit nor size of the signal matters.
struct Prepared {
  std::vector<std::size_t> rows;     ///< of the curve
  std::vector<std::size_t> columns;  ///< of the covariance's processes
  std::vector<noise::Term> terms;
  std::vector<std::int64_t> m;
  double dt = 1;
  std::int64_t samples = 0;
  double scale = 1;                                  ///< variance = scaled * scale
  Eigen::VectorXd s;                                 ///< scaled
  Eigen::VectorXd bandwidth_slope;                   ///< of white noise of N = 1, where Options::front_end is fitted
  std::optional<allan::CurveCovariance> covariance;  ///< of rows x columns
  Eigen::MatrixXd expectation;                       ///< likewise; behind the front end

  [[nodiscard]] Eigen::Index tested_until() const;  ///< rows with n/m >= 16 come first
};
/// @throws std::invalid_argument where curve, covariance and options do not go together, as fit() says.
[[nodiscard]] Prepared prepare(const allan::Curve& curve, const allan::CurveCovariance& covariance,
                               const Options& options);

/// The rows [first, end) and columns of a prepared curve as a linear model.
struct TestedFit {
  Eigen::Index first = 0;
  std::vector<noise::Term> terms;
  LinearModel model;
  Free free = Free::nothing;
  GlsSolution solution;
  Eigen::VectorXd gamma;       ///< of the model's free column
  Eigen::MatrixXd covariance;  ///< of theta, where the method has its own
  double chi2 = 0;
  int dof = 0;
  double p_value = 0;
};

/// The model of the rows from `first` on, for some of the terms.
[[nodiscard]] LinearModel linear_model(const Prepared& p, Eigen::Index first, std::span<const std::size_t> columns,
                                       Free free);
/// Goodness of fit over the rows of the run with n/m >= 16, at its solution.
void test_fit(const Prepared& p, TestedFit& run);
/// Fitted from a row on. @param free counts for Method::gls only.
[[nodiscard]] TestedFit fit_from(const Prepared& p, Eigen::Index first, bool drop_quantization, Free free,
                                 Method method = Method::gls);
/// The run that a fit is of: from the tau asked for, of every tau, or from where the terms describe the curve.
/// @throws std::invalid_argument where fewer taus are left than terms plus one.
[[nodiscard]] TestedFit choose_run(const Prepared& p, const Options& options);

/// Whether a front end may stand before the samples: the terms do not describe every tau, or a filter's memory beside
/// them explains the curve better than chance would in one record of ten thousand.
[[nodiscard]] bool may_be_filtered(const allan::Curve& curve, const allan::CurveCovariance& covariance,
                                   const Options& options);

}  // namespace gyrobudget::inline v0::fit

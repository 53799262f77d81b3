// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "gls.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::fit {

/// Sine coefficients c_1 .. c_last of a record (see dst.h), gathered in bins: one by one up to k = 32, then in bins of
/// ratio 1.04. A bin's coefficients count as equally variable, with the mean of their variances: no bias, and a loss of
/// information of order (0.04)^2/12.
struct SineBins {
  /// @param widest  most coefficients in a bin
  SineBins(std::span<const double> coefficients, std::int64_t samples, double dt, std::int64_t last,
           std::int64_t widest = kAnyWidth);
  static constexpr std::int64_t kAnyWidth = std::int64_t{1} << 62;
  /// Adds the coefficients of another stretch of the record, where their frequencies fall. Those below the first bin or
  /// above the last are left out.
  void add(std::span<const double> coefficients, std::int64_t samples);

  std::int64_t samples = 0;
  double dt = 1;
  std::vector<std::int64_t> first;  ///< k of each bin's first coefficient, and one past the last bin's
  Eigen::ArrayXd count;
  Eigen::ArrayXd power;       ///< mean of c^2
  Eigen::ArrayXd reference;   ///< power that the cost is counted from: of the same record, whatever is taken off it
  Eigen::ArrayXd with_ramp;   ///< mean of c d, d the transform of a unit ramp
  Eigen::ArrayXd ramp_power;  ///< mean of d^2
  Eigen::ArrayXd gain;        ///< of a front end that all spectra stand behind; empty: none

  /// Coefficients first <= k < end of a stretch of `samples`.
  struct Part {
    std::int64_t samples = 0, first = 0, end = 0;
  };
  std::vector<std::vector<Part>> parts;  ///< of each bin: one, and one for each stretch added; none in a likelihood
};

/// Likelihood of independent coefficients c_k ~ N(r d_k, sum_a theta_a phi_a(k)), theta >= 0:
///   cost = -2 ln L + const = sum_bins count (P/lambda - 1 - ln(reference/lambda)).
class SineLikelihood {
 public:
  struct Point {
    Eigen::VectorXd theta;  ///< squared coefficients, in the order of the processes
    double ramp = 0;        ///< signed
    double cost = 0;        ///< infinite where nothing allowed explains the record
    int iterations = 0;
    bool converged = false;
  };

  /// @param processes random ones; their coefficients are ignored. @param ramp whether a ramp is fitted too.
  SineLikelihood(SineBins bins, std::span<const noise::Process> processes, bool ramp);

  /// The maximum over theta >= 0 and the ramp, each optionally with one held: Newton's method with the bounds kept by
  /// an active set, Fisher scoring where the curvature is not positive.
  [[nodiscard]] Point maximise(std::optional<Held> held = {}, std::optional<double> held_ramp = {},
                               const Point* start = nullptr) const;

  [[nodiscard]] Eigen::ArrayXd variance(const Eigen::VectorXd& theta) const;      ///< lambda of the bins
  [[nodiscard]] Eigen::ArrayXd power(double ramp) const;                          ///< P less that of the ramp
  [[nodiscard]] Eigen::MatrixXd information(const Eigen::VectorXd& theta) const;  ///< Fisher's, of theta
  [[nodiscard]] double ramp_information(const Eigen::VectorXd& theta) const;      ///< Fisher's, of the ramp
  [[nodiscard]] const SineBins& bins() const { return bins_; }
  [[nodiscard]] Eigen::Index terms() const { return shape_.cols(); }
  /// The same noise behind a filter: all spectra times the power gain of each bin.
  [[nodiscard]] SineLikelihood behind(const Eigen::ArrayXd& gain) const;
  /// The same, but what the last process is has been added behind the filter: its spectrum times one less the gain.
  [[nodiscard]] SineLikelihood before_floor(const Eigen::ArrayXd& gain) const;
  /// The same model for other data in the same bins.
  [[nodiscard]] SineLikelihood with_power(Eigen::ArrayXd power) const;

 private:
  struct Curvature;
  [[nodiscard]] double cost(const Eigen::ArrayXd& lambda, const Eigen::ArrayXd& power) const;
  [[nodiscard]] double best_ramp(const Eigen::ArrayXd& lambda) const;
  void choose_units();

  SineBins bins_;
  bool ramp_ = false;
  Eigen::MatrixXd shape_;  ///< bins x terms, mean of E[c^2] of the process of coefficient unit_
  Eigen::VectorXd unit_;   ///< of theta: a fit starts near 1 in these
};

}  // namespace gyrobudget::inline v0::fit

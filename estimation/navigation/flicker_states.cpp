// SPDX-License-Identifier: MIT
#include "flicker_states.h"

#include "gyrobudget/estimation/navigation/detail/gauss_markov.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include <Eigen/Core>
#include <unsupported/Eigen/NonLinearOptimization>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kFlat = 2 * std::numbers::ln2 / std::numbers::pi;  // Allan variance of flicker over B^2
constexpr int kPointsPerDecade = 16;
constexpr int kLawsonRounds = 60;
constexpr int kRoundsWithoutGain = 8;  // of a per cent
constexpr double kGain = 0.99;

// ln sigma^2 and ln Tc of each state; residual: weighted relative error of the variance.
struct Misfit {
  using Scalar = double;
  using InputType = VectorXd;
  using ValueType = VectorXd;
  using JacobianType = Eigen::MatrixXd;
  enum { InputsAtCompileTime = Eigen::Dynamic, ValuesAtCompileTime = Eigen::Dynamic };

  VectorXd taus, weights;
  int states = 0;

  [[nodiscard]] int inputs() const { return 2 * states; }
  [[nodiscard]] int values() const { return static_cast<int>(taus.size()); }

  [[nodiscard]] double relative_error(const VectorXd& x, Index i) const {
    double sum = 0;
    for (Index k = 0; k < states; ++k)
      sum += std::exp(x[2 * k]) * detail::allan_variance(taus[i] * std::exp(-x[2 * k + 1]));
    return sum / kFlat - 1;
  }
  int operator()(const VectorXd& x, VectorXd& residual) const {
    for (Index i = 0; i < taus.size(); ++i) residual[i] = std::sqrt(weights[i]) * relative_error(x, i);
    return 0;
  }
};

VectorXd start(double shortest, double longest, int states) {
  VectorXd x(2 * states);
  const double ratio = std::log(longest / shortest) / states;
  for (Index k = 0; k < states; ++k) {
    x[2 * k] = std::log(std::min(ratio, 3.0) / std::numbers::pi * 1.2);
    // A process peaks at 1.89 Tc.
    x[2 * k + 1] = std::log(shortest / 1.89) + (static_cast<double>(k) + 0.5) * ratio;
  }
  return x;
}

double worst(const Misfit& misfit, const VectorXd& x) {
  double error = 0;
  for (Index i = 0; i < misfit.taus.size(); ++i)
    error = std::max(error, std::abs(std::sqrt(1 + misfit.relative_error(x, i)) - 1));
  return error;
}

// Lawson: weights grow with the error at their point, so that least squares tends to the smallest largest error.
VectorXd fit(Misfit& misfit, VectorXd x) {
  VectorXd best = x;
  double least = worst(misfit, x);
  int last_gain = 0;
  for (int round = 0; round < kLawsonRounds && round - last_gain < kRoundsWithoutGain; ++round) {
    Eigen::NumericalDiff<Misfit, Eigen::Central> derivative(misfit);
    Eigen::LevenbergMarquardt solver(derivative);
    solver.minimize(x);
    if (const double error = worst(misfit, x); error < least) {
      if (error < kGain * least) last_gain = round;
      least = error;
      best = x;
    }
    for (Index i = 0; i < misfit.taus.size(); ++i) misfit.weights[i] *= std::abs(misfit.relative_error(x, i)) + 1e-9;
    misfit.weights /= misfit.weights.mean();
  }
  return best;
}

}  // namespace

FlickerStates flicker_states(double b, double shortest, double longest, int states) {
  if (!(b >= 0) || !std::isfinite(b))
    throw SetupError(fmt::format("bias instability is {}, expected 0 or more and finite", b));
  if (!(shortest > 0) || !(longest > shortest) || !(longest <= 1e8 * shortest))
    throw SetupError(fmt::format("band of flicker is {} s to {} s, expected positive, ascending and at most 1e8 apart",
                                 shortest, longest));
  if (states < 0 || states > 6) throw SetupError(fmt::format("{} states for flicker, expected 0 to 6", states));
  FlickerStates result;
  result.worst_error = 1;
  if (states == 0) return result;

  Misfit misfit;
  misfit.states = states;
  const auto points = std::max<Index>(4 * states, std::lround(std::log10(longest / shortest) * kPointsPerDecade) + 1);
  misfit.taus = VectorXd::LinSpaced(points, 0, std::log(longest / shortest)).array().exp();
  misfit.weights = VectorXd::Ones(points);
  const VectorXd x = fit(misfit, start(1, longest / shortest, states));
  for (Index k = 0; k < states; ++k)
    result.processes.push_back({b * std::exp(x[2 * k] / 2), shortest * std::exp(x[2 * k + 1])});
  std::sort(result.processes.begin(), result.processes.end(),
            [](const auto& l, const auto& r) { return l.correlation_time < r.correlation_time; });
  misfit.taus = VectorXd::LinSpaced(8 * points, 0, std::log(longest / shortest)).array().exp();  // between, too
  result.worst_error = worst(misfit, x);
  return result;
}

}  // namespace gyrobudget::inline v0::navigation

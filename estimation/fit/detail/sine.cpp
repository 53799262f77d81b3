// SPDX-License-Identifier: MIT
#include "sine.h"

#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>

#include <algorithm>
#include <numbers>

#include "dst.h"
#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

constexpr std::size_t kSlowest = 16;  // half cycles in the record that a line must have to be told from a drift

// How much a line at w explains, from the coefficients near it, with the spectrum of the rest known.
Sine line_at(double w, std::span<const double> c, std::span<const double> lambda, std::int64_t n) {
  constexpr std::int64_t kReach = 64;  // of k; what leaks further is 1/kReach of the power
  const auto center = std::llround(w * static_cast<double>(n) / std::numbers::pi);
  const auto first = std::max<std::int64_t>(1, center - kReach);
  const auto last = std::min<std::int64_t>(static_cast<std::int64_t>(c.size()), center + kReach);
  Eigen::Matrix2d M = Eigen::Matrix2d::Zero();
  Eigen::Vector2d v = Eigen::Vector2d::Zero();
  for (auto k = first; k <= last; ++k) {
    const auto i = static_cast<std::size_t>(k - 1);
    const auto mean = sine_mean_of_line(k, n, w);
    const Eigen::Vector2d d(mean[0], mean[1]);
    M += d * d.transpose() / lambda[i];
    v += d * c[i] / lambda[i];
  }
  const Eigen::Vector2d parts = M.ldlt().solve(v);
  Sine line{.w = w, .parts = {parts(0), parts(1)}, .test = parts.dot(v)};
  const double a = line.amplitude();
  const Eigen::Vector2d along = a > 0 ? Eigen::Vector2d(parts / a) : Eigen::Vector2d(1, 0);
  line.deviation = std::sqrt(along.dot(M.ldlt().solve(along)));
  return line;
}

std::vector<double> variances(const SineLikelihood& likelihood, const Eigen::VectorXd& theta) {
  const Eigen::ArrayXd of_bins = likelihood.variance(theta);
  const auto& first = likelihood.bins().first;
  std::vector<double> lambda(static_cast<std::size_t>(first.back() - 1), 1.0);
  for (std::size_t b = 0; b + 1 < first.size(); ++b) {
    for (auto k = first[b]; k < first[b + 1]; ++k)
      lambda[static_cast<std::size_t>(k - 1)] = of_bins(static_cast<Eigen::Index>(b));
  }
  return lambda;
}

}  // namespace

Sine find_sine(const SineLikelihood& likelihood, const SineLikelihood::Point& point, std::span<const double> c,
               std::optional<double> asked_w, std::optional<double> near_w) {
  const auto lambda = variances(likelihood, point.theta);
  const std::int64_t n = likelihood.bins().samples;
  std::vector<double> shown(c.begin(), c.begin() + static_cast<std::ptrdiff_t>(lambda.size()));
  for (std::size_t i = 0; point.ramp != 0 && i < shown.size(); i += 2)
    shown[i] -= point.ramp * sine_mean_of_ramp(static_cast<std::int64_t>(i) + 1, n, likelihood.bins().dt);
  if (asked_w) return line_at(*asked_w, shown, lambda, n);
  if (shown.size() <= kSlowest) return {};
  std::size_t peak = kSlowest, end = shown.size();
  if (near_w) {
    constexpr double kNear = 8;  // half cycles
    const double k = *near_w * static_cast<double>(n) / std::numbers::pi;
    peak = static_cast<std::size_t>(std::max(static_cast<double>(kSlowest), k - kNear));
    end = std::min(end, static_cast<std::size_t>(std::max(0.0, k + kNear)));
    if (peak >= end) return {};
  }
  double highest = 0;
  for (std::size_t i = peak; i < end; ++i) {
    const double next = i + 1 < shown.size() ? shown[i + 1] * shown[i + 1] / lambda[i + 1] : 0;
    const double height = shown[i] * shown[i] / lambda[i] + next;
    if (height > highest) highest = height, peak = i;
  }
  const double bin = std::numbers::pi / static_cast<double>(n);
  const auto less = [&](double k) { return -line_at(k * bin, shown, lambda, n).test; };
  double best = static_cast<double>(peak) + 1, least = less(best);
  constexpr double kStep = 0.25;
  const double top = static_cast<double>(n) - 0.5;
  for (double k = std::max(0.5, best - 1.5), last = std::min(top, best + 2.5); k <= last; k += kStep) {
    if (const double l = less(k); l < least) least = l, best = k;
  }
  std::uintmax_t budget = 40;
  const auto found = boost::math::tools::brent_find_minima(less, std::max(0.25, best - kStep),
                                                           std::min(top, best + kStep), 20, budget);
  best = found.second < least ? found.first : best;
  // The root of the slope is known far better than the place of the least value.
  constexpr double kReach = 0.01;
  const auto slope = [&](double k) { return less(k + kReach) - less(k - kReach); };
  const double low = slope(best - kReach), high = slope(best + kReach);
  if (low < 0 && high > 0 && best > 0.5 && best < top) {
    budget = 60;
    const auto bracket = boost::math::tools::toms748_solve(slope, best - kReach, best + kReach, low, high,
                                                           boost::math::tools::eps_tolerance<double>(48), budget);
    best = 0.5 * (bracket.first + bracket.second);
  }
  return line_at(best * bin, shown, lambda, n);
}

namespace {

// A stretch less A cos(w j) + B sin(w j).
void take_off(TransformedStretch& t, double w, const std::array<double, 2>& parts) {
  for (std::size_t j = 0; j < t.rate.size(); ++j) {
    const double angle = w * static_cast<double>(j);
    t.rate[j] -= parts[0] * std::cos(angle) + parts[1] * std::sin(angle);
  }
  t.coefficients = sine_transform_of_differences(t.rate);
}

// Least squares of a mean and a line.
std::array<double, 2> line_in(std::span<const double> rate, double w) {
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  Eigen::Vector3d v = Eigen::Vector3d::Zero();
  for (std::size_t j = 0; j < rate.size(); ++j) {
    const double angle = w * static_cast<double>(j);
    const Eigen::Vector3d row(1, std::cos(angle), std::sin(angle));
    M += row * row.transpose();
    v += row * (rate[j] - rate[0]);
  }
  const Eigen::Vector3d parts = M.ldlt().solve(v);
  return {parts(1), parts(2)};
}

}  // namespace

Transformed without_sine(const Transformed& whole, const Sine& line) {
  Transformed t = whole;
  take_off(t, line.w, line.parts);
  for (TransformedStretch& other : t.others) take_off(other, line.w, line_in(other.rate, line.w));
  return t;
}

}  // namespace gyrobudget::inline v0::fit

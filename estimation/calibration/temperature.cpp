// SPDX-License-Identifier: MIT
#include "temperature.h"

#include "gyrobudget/allan/detail/lag_kernel.h"

#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace gyrobudget::inline v0::calibration {
namespace {

using noise::Process;
using noise::Term;

constexpr std::size_t kBlocks = 128;
constexpr std::int64_t kFewestSamples = 1024;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Means of blocks, NaN where one has under half of its samples, and the mean variance within them over their number.
struct BlockMeans {
  std::vector<double> mean;
  double scatter = 0;
};

BlockMeans block_means(std::span<const double> values, double least_fill) {
  BlockMeans blocks{std::vector<double>(kBlocks, kNaN), 0};
  const std::size_t m = values.size() / kBlocks;
  double variances = 0, counted = 0;
  for (std::size_t b = 0; b < kBlocks; ++b) {
    double sum = 0, squares = 0, count = 0;
    for (const double v : values.subspan(b * m, m))
      if (std::isfinite(v)) sum += v, ++count;
    if (count < 1 || count < least_fill * static_cast<double>(m)) continue;
    blocks.mean[b] = sum / count;
    double before = kNaN;
    for (const double v : values.subspan(b * m, m)) {
      if (!std::isfinite(v)) continue;
      if (std::isfinite(before)) squares += (v - before) * (v - before) / 2;
      before = v;
    }
    variances += squares / (count * count), ++counted;
  }
  if (counted > 0) blocks.scatter = variances / counted;
  return blocks;
}

// Gaps of the temperature are bridged by straight lines.
void bridge(std::vector<double>& values) {
  std::size_t known = values.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (known == values.size()) std::fill_n(values.begin(), i, values[i]);
    for (std::size_t k = known + 1; k < i && known < values.size(); ++k)
      values[k] = std::lerp(values[known], values[i], static_cast<double>(k - known) / static_cast<double>(i - known));
    known = i;
  }
  if (known < values.size()) std::fill(values.begin() + std::ptrdiff_t(known), values.end(), values[known]);
}

// --- Generalised least squares at stated levels of flicker and walk -----------------------------------------------

struct Levels {
  double b = 0, k = 0;  // logarithms of the coefficients
};

struct Solution {
  Eigen::VectorXd value;
  Eigen::MatrixXd covariance;
  double likelihood = -std::numeric_limits<double>::infinity();  // restricted, logarithm
};

class Problem {
 public:
  Problem(const std::vector<double>& means, Eigen::MatrixXd design, double m, double dt, const fit::Result& before)
      : design_(std::move(design)), z_(kBlocks - 1), fixed_(Eigen::VectorXd::Zero(kBlocks - 1)) {
    for (std::size_t i = 0; i + 1 < kBlocks; ++i) z_(Eigen::Index(i)) = means[i + 1] - means[i];
    for (const Process& p : before.processes()) {
      const Term t = noise::term(p);
      if (t != Term::rate_ramp && t != Term::flicker && t != Term::rate_random_walk) fixed_ += kernel(p, m, dt);
    }
    flicker_ = kernel(noise::Flicker{1}, m, dt);
    walk_ = kernel(noise::RateRandomWalk{1}, m, dt);
    look_for_start(before);
  }

  [[nodiscard]] Levels start() const { return start_; }

  [[nodiscard]] Solution solve(const Levels& levels) const {
    const Eigen::VectorXd at_lag = fixed_ + std::exp(2 * levels.b) * flicker_ + std::exp(2 * levels.k) * walk_;
    const Eigen::Index n = z_.size();
    Eigen::MatrixXd C(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) C(i, j) = at_lag(std::abs(i - j));
    const Eigen::LLT<Eigen::MatrixXd> factor(C);
    if (factor.info() != Eigen::Success) return {};
    const Eigen::MatrixXd WX = factor.matrixL().solve(design_);
    const Eigen::VectorXd Wz = factor.matrixL().solve(z_);
    const Eigen::LLT<Eigen::MatrixXd> normal(WX.transpose() * WX);
    if (normal.info() != Eigen::Success) return {};
    Solution s;
    s.value = normal.solve(WX.transpose() * Wz);
    s.covariance = normal.solve(Eigen::MatrixXd::Identity(design_.cols(), design_.cols()));
    const double left = (Wz - WX * s.value).squaredNorm();
    double log_determinants = 0;
    for (Eigen::Index i = 0; i < n; ++i) log_determinants += std::log(factor.matrixLLT()(i, i));
    for (Eigen::Index i = 0; i < design_.cols(); ++i) log_determinants += std::log(normal.matrixLLT()(i, i));
    // Flat in the coefficients themselves: a walk of nothing is not more likely than any other. What the curve says of
    // flicker at shorter times than a block stands beside it, twice as wide as it claims.
    const double beside = known_b_ ? (levels.b - known_b_->first) / known_b_->second : 0;
    s.likelihood = -log_determinants - left / 2 + levels.b + levels.k - beside * beside / 2;
    return s;
  }

 private:
  static Eigen::VectorXd kernel(const Process& p, double m, double dt) {
    std::vector<double> lags(kBlocks - 1), values(kBlocks - 1);
    for (std::size_t i = 0; i < lags.size(); ++i) lags[i] = static_cast<double>(i) * m;
    allan::detail::lag_kernel(noise::with_coefficient(p, 1), {std::int64_t(m), std::int64_t(m), dt}, lags, values);
    // Its terms are the differences over the root of 2.
    return 2 * std::pow(noise::coefficient(p), 2) * Eigen::Map<const Eigen::VectorXd>(values.data(), kBlocks - 1);
  }

  // Levels that make each as large as the scatter of the differences, or what was fitted.
  void look_for_start(const fit::Result& before) {
    const double all = z_.squaredNorm() / static_cast<double>(z_.size());
    start_ = {0.5 * std::log(0.1 * all / flicker_(0)), 0.5 * std::log(0.1 * all / walk_(0))};
    for (const auto& c : before.coefficients) {
      if (!c.fitted || !(c.value > 0)) continue;
      if (c.term == Term::rate_random_walk) start_.k = std::log(c.value);
      if (c.term != Term::flicker) continue;
      start_.b = std::log(c.value);
      if (std::isfinite(c.relative_std)) known_b_ = {start_.b, std::max(0.1, 2 * c.relative_std)};
    }
  }

  Eigen::MatrixXd design_;
  Eigen::VectorXd z_, fixed_, flicker_, walk_;
  Levels start_;
  std::optional<std::pair<double, double>> known_b_;
};

// Largest likelihood by steps in either direction that are halved.
Levels most_likely(const Problem& problem) {
  Levels best = problem.start();
  double at_best = problem.solve(best).likelihood;
  for (double step = 1; step > 0.05; step /= 2) {
    for (int tries = 0; tries < 20; ++tries) {
      const Levels from = best;
      for (const auto& [b, k] : {std::pair{step, 0.0}, {-step, 0.0}, {0.0, step}, {0.0, -step}}) {
        const Levels next{from.b + b, from.k + k};
        const double likelihood = problem.solve(next).likelihood;
        if (likelihood > at_best) at_best = likelihood, best = next;
      }
      if (best.b == from.b && best.k == from.k) break;
    }
  }
  return best;
}

// How far from the most likely level the likelihood falls by 1/2, in one direction.
double width_of(const Problem& problem, const Levels& best, bool of_b) {
  constexpr double kLook = 0.25, kLeast = 0.05, kMost = 1.2;
  const auto at = [&](double step) {
    return problem.solve({best.b + (of_b ? step : 0), best.k + (of_b ? 0 : step)}).likelihood;
  };
  const double fall = 2 * at(0) - at(kLook) - at(-kLook);  // second derivative times the square of the step
  return fall > 0 ? std::clamp(kLook / std::sqrt(fall), kLeast, kMost) : kMost;
}

struct Weighed {
  double weight = 0;
  Levels levels;
  Solution solution;
};

std::vector<Weighed> mixture(const Problem& problem) {
  const Levels best = most_likely(problem);
  const double of_b = width_of(problem, best, true), of_k = width_of(problem, best, false);
  const double most = problem.solve(best).likelihood;
  std::vector<Weighed> list;
  if (!std::isfinite(most)) return list;
  double sum = 0;
  for (int i = -3; i <= 3; ++i) {
    for (int j = -4; j <= 4; ++j) {
      const Levels levels{best.b + 0.9 * i * of_b, best.k + 0.75 * j * of_k};
      Solution s = problem.solve(levels);
      const double weight = std::exp(s.likelihood - most);
      if (!(weight > 1e-4)) continue;
      sum += weight;
      list.push_back({weight, levels, std::move(s)});
    }
  }
  for (Weighed& w : list) w.weight /= sum;
  return list;
}

// A quantile of the mixture of normal laws, by halving.
double quantile(const std::vector<std::array<double, 3>>& laws, double p) {  // weight, mean, standard deviation
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const auto& [weight, mean, sigma] : laws)
    low = std::min(low, mean - 10 * sigma), high = std::max(high, mean + 10 * sigma);
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    double below = 0;
    for (const auto& [weight, mean, sigma] : laws)
      below += weight * std::erfc((mean - middle) / (sigma * std::numbers::sqrt2)) / 2;
    (below < p ? low : high) = middle;
  }
  return (low + high) / 2;
}

TemperatureCoefficient summed_up(const std::vector<std::array<double, 3>>& laws) {
  TemperatureCoefficient c{.value = 0, .lower = quantile(laws, 0.025), .upper = quantile(laws, 0.975), .fitted = true};
  for (const auto& [weight, mean, sigma] : laws) c.value += weight * mean;
  return c;
}

// Share of a column that the others explain, in the metric of white differences.
double explained_by_others(const Eigen::MatrixXd& design, Eigen::Index column) {
  if (design.cols() < 2) return 0;
  Eigen::MatrixXd others(design.rows(), design.cols() - 1);
  for (Eigen::Index j = 0, k = 0; j < design.cols(); ++j)
    if (j != column) others.col(k++) = design.col(j);
  const Eigen::VectorXd x = design.col(column);
  const Eigen::VectorXd left = x - others * others.householderQr().solve(x);
  return 1 - left.squaredNorm() / x.squaredNorm();
}

Eigen::VectorXd differences(const Eigen::VectorXd& v) { return v.tail(v.size() - 1) - v.head(v.size() - 1); }

}  // namespace

SmoothTemperature::SmoothTemperature(std::span<const double> temperature, double dt) {
  if (temperature.size() < kBlocks) return;
  BlockMeans blocks = block_means(temperature, 0);
  const auto known = std::ranges::count_if(blocks.mean, [](double v) { return std::isfinite(v); });
  if (known < std::ptrdiff_t(kBlocks) / 2) return;
  bridge(blocks.mean);
  value_ = std::move(blocks.mean);
  block_s_ = static_cast<double>(temperature.size() / kBlocks) * dt;
  double squares = 0;
  const auto end_slope = [&](std::size_t a, std::size_t b, std::size_t c) {  // of a parabola, at a
    return (4 * value_[b] - 3 * value_[a] - value_[c]) / (2 * block_s_);
  };
  slope_.push_back(end_slope(0, 1, 2));
  for (std::size_t i = 1; i + 1 < kBlocks; ++i) slope_.push_back((value_[i + 1] - value_[i - 1]) / (2 * block_s_));
  slope_.push_back(-end_slope(kBlocks - 1, kBlocks - 2, kBlocks - 3));
  for (const double s : slope_) squares += s * s;
  const double noise = blocks.scatter / (2 * block_s_ * block_s_) * static_cast<double>(kBlocks);
  reliability_ = squares > 0 ? std::max(0.0, 1 - noise / squares) : 0;
  const auto [low, high] = std::ranges::minmax(value_);
  usable_ = high - low >= kLeastRange;
}

std::size_t SmoothTemperature::line_at(double t, double& part) const {
  const double position = std::clamp(t / block_s_ - 0.5, 0.0, static_cast<double>(kBlocks - 1));
  const auto i = std::min(static_cast<std::size_t>(position), kBlocks - 2);
  part = position - static_cast<double>(i);
  return i;
}

double SmoothTemperature::at(double t) const {
  double part = 0;
  const std::size_t i = line_at(t, part);
  return std::lerp(value_[i], value_[i + 1], part);
}

double SmoothTemperature::slope(double t) const {
  double part = 0;
  const std::size_t i = line_at(t, part);
  return std::lerp(slope_[i], slope_[i + 1], part);
}

Temperature fit_temperature(std::span<const double> rate, const SmoothTemperature& temperature, double dt,
                            const fit::Result& before) {
  if (std::ssize(rate) < kFewestSamples)
    throw std::invalid_argument(
        fmt::format("found {} samples, expected at least {} to fit a temperature", rate.size(), kFewestSamples));
  const std::size_t m = rate.size() / kBlocks;
  const BlockMeans blocks = block_means(rate, 0.5);
  Temperature found;
  Eigen::VectorXd T(kBlocks), slope(kBlocks);
  for (std::size_t i = 0; i < kBlocks; ++i) {
    const double t = (static_cast<double>(i) + 0.5) * static_cast<double>(m) * dt;
    T(Eigen::Index(i)) = temperature.at(t);
    slope(Eigen::Index(i)) = temperature.slope(t);
  }
  found.reference = T.mean(), found.lowest = T.minCoeff(), found.highest = T.maxCoeff();
  if (std::ranges::any_of(blocks.mean, [](double v) { return !std::isfinite(v); }) || before.processes().empty())
    return found;
  const Eigen::VectorXd above = T.array() - found.reference;
  // Columns by name; what the others explain is dropped, the rate first.
  std::vector<TemperatureCoefficient Temperature::*> names{&Temperature::linear, &Temperature::quadratic};
  Eigen::MatrixXd levels(kBlocks, 3);
  levels << above, above.cwiseAbs2(), slope;
  Eigen::MatrixXd kept = levels.leftCols(2);
  constexpr double kReliable = 0.9, kTold = 0.9999;
  const auto design_of = [](const Eigen::MatrixXd& columns) {
    Eigen::MatrixXd design(kBlocks - 1, columns.cols());
    for (Eigen::Index j = 0; j < columns.cols(); ++j) design.col(j) = differences(columns.col(j));
    return design;
  };
  if (temperature.slope_reliability() > kReliable && explained_by_others(design_of(levels), 2) < kTold) {
    kept = levels;
    names.push_back(&Temperature::rate);
  }
  if (explained_by_others(design_of(kept), 1) >= kTold) {
    kept.col(1) = kept.col(kept.cols() - 1);
    const Eigen::MatrixXd fewer = kept.leftCols(names.size() == 2 ? 1 : 2);
    kept = fewer;
    names.erase(names.begin() + 1);
  }
  // Columns of size one, so that the normal equations are.
  Eigen::MatrixXd design = design_of(kept);
  const Eigen::VectorXd scale = design.colwise().norm();
  for (Eigen::Index j = 0; j < design.cols(); ++j) design.col(j) /= scale(j);
  const Problem problem(blocks.mean, design, static_cast<double>(m), dt, before);
  const std::vector<Weighed> weighed = mixture(problem);
  if (weighed.empty()) return found;
  const Eigen::Map<const Eigen::VectorXd> y(blocks.mean.data(), kBlocks);
  const auto laws = [&](const auto& mean, const auto& variance) {
    std::vector<std::array<double, 3>> list;
    for (const Weighed& w : weighed) list.push_back({w.weight, mean(w), std::sqrt(variance(w))});
    return list;
  };
  for (Eigen::Index j = 0; j < design.cols(); ++j) {
    found.*names[std::size_t(j)] =
        summed_up(laws([&](const Weighed& w) { return w.solution.value(j) / scale(j); },
                       [&](const Weighed& w) { return w.solution.covariance(j, j) / (scale(j) * scale(j)); }));
  }
  // The level is the mean of what the model leaves; its noise is that of the mean since the first sample.
  const Eigen::VectorXd middle = kept.colwise().mean().transpose().cwiseQuotient(scale);
  const double duration = static_cast<double>(rate.size()) * dt, samples = static_cast<double>(rate.size());
  double white = 0;
  for (const auto& c : before.coefficients)
    if (c.term == Term::white && c.fitted) white = c.value * c.value;
  found.bias = summed_up(laws([&](const Weighed& w) { return y.mean() - middle.dot(w.solution.value); },
                              [&](const Weighed& w) {
                                const double b = std::exp(2 * w.levels.b), k = std::exp(2 * w.levels.k);
                                return white / duration + b / std::numbers::pi * (std::log(samples) + 1) +
                                       k * duration / 3 + middle.dot(w.solution.covariance * middle);
                              }));
  // Whether there is a dependence at all: an F test with as many degrees of freedom as slow noise leaves.
  constexpr double kSlow = 12;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(design.cols());
  Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(design.cols(), design.cols());
  for (const Weighed& w : weighed) mean += w.weight * w.solution.value;
  for (const Weighed& w : weighed) {
    const Eigen::VectorXd d = w.solution.value - mean;
    spread += w.weight * (w.solution.covariance + d * d.transpose());
  }
  const double f = mean.dot(spread.ldlt().solve(mean)) / static_cast<double>(mean.size());
  const boost::math::fisher_f law(static_cast<double>(mean.size()), kSlow);
  found.p_value = f > 0 ? cdf(complement(law, f)) : 1;
  double left = 0, all = 0;
  for (std::size_t i = 0; i < kBlocks; ++i) {
    const double model = found.bias.value + found.shift(T(Eigen::Index(i)), slope(Eigen::Index(i)));
    found.points.push_back(
        {(static_cast<double>(i) + 0.5) * static_cast<double>(m) * dt, T(Eigen::Index(i)), blocks.mean[i], model});
    left += std::pow(blocks.mean[i] - model, 2);
    all += std::pow(blocks.mean[i] - y.mean(), 2);
  }
  found.explained = all > 0 ? std::max(0.0, 1 - left / all) : 0;
  return found;
}

}  // namespace gyrobudget::inline v0::calibration

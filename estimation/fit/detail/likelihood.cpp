// SPDX-License-Identifier: MIT
#include "likelihood.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "dst.h"
#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

constexpr std::int64_t kSingle = 32;  // coefficients in bins of their own
constexpr double kBinRatio = 1.04;
constexpr int kMostSteps = 200;
constexpr int kMostHalvings = 40;
constexpr double kTrusted = 1e-6;   // a step that promises less is taken without looking: the cost is rounded
constexpr double kSettled = 1e-20;  // promised change of the cost at which the search ends
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<std::int64_t> bin_starts(std::int64_t last, std::int64_t widest) {
  std::vector<std::int64_t> first;
  std::int64_t k = 1;
  for (; k <= std::min(last, kSingle); ++k) first.push_back(k);
  while (k <= last) {
    first.push_back(k);
    const auto next = static_cast<std::int64_t>(std::llround(static_cast<double>(k) * kBinRatio));
    k = std::max(k + 1, std::min(next, k + widest));
  }
  first.push_back(last + 1);
  return first;
}

// Mean of E[c_k^2] over first <= k < end: the sum, or three-point Gauss quadrature between the halves beside it.
double mean_variance(const noise::Process& unit, std::int64_t first, std::int64_t end, std::int64_t n, double dt) {
  constexpr std::int64_t kSummed = 3;
  if (end - first <= kSummed) {
    double sum = 0;
    for (auto k = first; k < end; ++k) sum += sine_variance(unit, static_cast<double>(k), n, dt);
    return sum / static_cast<double>(end - first);
  }
  const double half = 0.5 * static_cast<double>(end - first);
  const double middle = static_cast<double>(first) - 0.5 + half;
  const double offset = half * std::sqrt(0.6);
  return (5 * sine_variance(unit, middle - offset, n, dt) + 8 * sine_variance(unit, middle, n, dt) +
          5 * sine_variance(unit, middle + offset, n, dt)) /
         18;
}

noise::Process with_unit(const noise::Process& process) { return noise::with_coefficient(process, 1); }

}  // namespace

namespace {

// Mean of E[c_k^2] over all coefficients of a bin.
double mean_variance(const noise::Process& unit, const std::vector<SineBins::Part>& parts, double dt) {
  double sum = 0, count = 0;
  for (const auto& p : parts) {
    const auto size = static_cast<double>(p.end - p.first);
    sum += size * mean_variance(unit, p.first, p.end, p.samples, dt);
    count += size;
  }
  return sum / count;
}

}  // namespace

SineBins::SineBins(std::span<const double> coefficients, std::int64_t samples_, double dt_, std::int64_t last,
                   std::int64_t widest)
    : samples(samples_), dt(dt_), first(bin_starts(last, widest)) {
  const auto bins = static_cast<Eigen::Index>(first.size()) - 1;
  for (Eigen::ArrayXd* mean : {&count, &power, &reference, &with_ramp, &ramp_power}) mean->setZero(bins);
  parts.resize(first.size() - 1);
  add(coefficients, samples);
}

void SineBins::add(std::span<const double> coefficients, std::int64_t of_samples) {
  // k of a stretch of n samples has the frequency of k n_0/n in the one that the bins are of.
  const double ratio = static_cast<double>(of_samples) / static_cast<double>(samples);
  const auto start = [&](std::int64_t k) {
    const double edge =
        of_samples == samples ? static_cast<double>(k) : std::ceil((static_cast<double>(k) - 0.5) * ratio);
    return std::clamp<std::int64_t>(static_cast<std::int64_t>(edge), 1,
                                    static_cast<std::int64_t>(coefficients.size()) + 1);
  };
  for (Eigen::Index b = 0; b < count.size(); ++b) {
    const auto from = start(first[static_cast<std::size_t>(b)]), to = start(first[static_cast<std::size_t>(b) + 1]);
    if (from >= to) continue;
    double cc = 0, cd = 0, dd = 0;
    for (auto k = from; k < to; ++k) {
      const double c = coefficients[static_cast<std::size_t>(k - 1)];
      cc += c * c;
    }
    for (auto k = from | 1; k < to; k += 2) {  // a ramp has odd coefficients only
      const double d = sine_mean_of_ramp(k, of_samples, dt);
      cd += coefficients[static_cast<std::size_t>(k - 1)] * d;
      dd += d * d;
    }
    const double before = count(b);
    count(b) += static_cast<double>(to - from);
    power(b) = reference(b) = (before * power(b) + cc) / count(b);
    with_ramp(b) = (before * with_ramp(b) + cd) / count(b);
    ramp_power(b) = (before * ramp_power(b) + dd) / count(b);
    parts[static_cast<std::size_t>(b)].push_back({of_samples, from, to});
  }
}

SineLikelihood::SineLikelihood(SineBins bins, std::span<const noise::Process> processes, bool ramp)
    : bins_(std::move(bins)), ramp_(ramp) {
  shape_.resize(bins_.count.size(), static_cast<Eigen::Index>(processes.size()));
  for (Eigen::Index a = 0; a < shape_.cols(); ++a) {
    const noise::Process unit = with_unit(processes[static_cast<std::size_t>(a)]);
    for (Eigen::Index b = 0; b < shape_.rows(); ++b) {
      shape_(b, a) = mean_variance(unit, bins_.parts[static_cast<std::size_t>(b)], bins_.dt);
    }
  }
  if (bins_.gain.size() > 0) shape_ = bins_.gain.matrix().asDiagonal() * shape_;
  bins_.parts.clear();  // the shape has them: copies are made for every simulated record
  unit_ = Eigen::VectorXd::Ones(shape_.cols());
  choose_units();
}

// Each term at the most that the record leaves room for: the least of P/phi over wide bands.
void SineLikelihood::choose_units() {
  Eigen::VectorXd least = Eigen::VectorXd::Constant(shape_.cols(), kInfinity);
  constexpr double kBand = 8;  // at least so many coefficients: chi-square is then no longer near 0
  for (Eigen::Index from = 0; from < shape_.rows();) {
    double in_band = 0;
    Eigen::Index to = from;
    const double wanted = std::max(kBand, 3 * static_cast<double>(bins_.first[static_cast<std::size_t>(from)]));
    while (to < shape_.rows() && in_band < wanted) in_band += bins_.count(to++);
    const auto rows = Eigen::seqN(from, to - from);
    const auto count = bins_.count.segment(from, to - from);
    const double power = (count * bins_.power.segment(from, to - from)).sum();
    const bool usable = power > 0 && (in_band >= kBand || from == 0);
    for (Eigen::Index a = 0; usable && a < shape_.cols(); ++a)
      least(a) = std::min(least(a), power / (count * shape_(rows, a).array()).sum());
    from = to;
  }
  least = least.array().isFinite().select(least, 1);
  unit_.array() *= least.array();
  shape_ *= least.asDiagonal();
}

SineLikelihood SineLikelihood::with_power(Eigen::ArrayXd power) const {
  SineLikelihood other = *this;
  other.bins_.power = other.bins_.reference = std::move(power);
  other.bins_.with_ramp.setZero();
  other.choose_units();
  return other;
}

SineLikelihood SineLikelihood::behind(const Eigen::ArrayXd& gain) const {
  SineLikelihood other = *this;
  other.shape_ = gain.matrix().asDiagonal() * shape_ * unit_.cwiseInverse().asDiagonal();
  other.unit_.setOnes();
  other.choose_units();
  return other;
}

SineLikelihood SineLikelihood::before_floor(const Eigen::ArrayXd& gain) const {
  SineLikelihood other = behind(gain);
  const Eigen::Index last = shape_.cols() - 1;
  other.shape_.col(last) = (1 - gain).max(0) * shape_.col(last).array() / unit_(last);
  other.unit_(last) = 1;
  other.choose_units();
  return other;
}

Eigen::ArrayXd SineLikelihood::variance(const Eigen::VectorXd& theta) const {
  return shape_ * theta.cwiseQuotient(unit_);
}

Eigen::ArrayXd SineLikelihood::power(double ramp) const {
  if (ramp == 0) return bins_.power;
  return (bins_.power + ramp * (ramp * bins_.ramp_power - 2 * bins_.with_ramp)).max(0);
}

double SineLikelihood::cost(const Eigen::ArrayXd& lambda, const Eigen::ArrayXd& power) const {
  if (!(lambda.minCoeff() > 0)) return kInfinity;
  constexpr double kNoPower = 1e-300;  // its logarithm is a constant of the record
  const Eigen::ArrayXd ratio = power / lambda;
  return (bins_.count * (ratio - 1 - (bins_.reference.max(kNoPower) / lambda).log())).sum();
}

double SineLikelihood::best_ramp(const Eigen::ArrayXd& lambda) const {
  const Eigen::ArrayXd weight = bins_.count / lambda;
  return (weight * bins_.with_ramp).sum() / (weight * bins_.ramp_power).sum();
}

double SineLikelihood::ramp_information(const Eigen::VectorXd& theta) const {
  return (bins_.count / variance(theta) * bins_.ramp_power).sum();
}

Eigen::MatrixXd SineLikelihood::information(const Eigen::VectorXd& theta) const {
  const Eigen::VectorXd weight = bins_.count / variance(theta).square() / 2;
  const Eigen::MatrixXd scaled = shape_.transpose() * weight.asDiagonal() * shape_;
  return unit_.cwiseInverse().asDiagonal() * scaled * unit_.cwiseInverse().asDiagonal();
}

// A step towards the maximum and the drop of the cost that it promises.
struct SineLikelihood::Curvature {
  Eigen::VectorXd step;
  double promise = 0;

  // max_u g'(u - u0) - 1/2 (u - u0)' M (u - u0) over u >= 0.
  bool solve(const Eigen::MatrixXd& M, const Eigen::VectorXd& g, const Eigen::VectorXd& u, std::optional<Held> held) {
    const Eigen::LLT<Eigen::MatrixXd> factor(M);
    if (factor.info() != Eigen::Success) return false;
    const Eigen::VectorXd target = factor.matrixL().solve(M * u + g);
    step = nonnegative_least_squares(factor.matrixU(), target, held) - u;
    promise = 2 * g.dot(step) - step.dot(M * step);
    if (std::abs(promise) < kTrusted * kTrusted) promise = std::abs(promise);  // rounding
    return step.allFinite() && promise >= 0;
  }
};

SineLikelihood::Point SineLikelihood::maximise(std::optional<Held> held, std::optional<double> held_ramp,
                                               const Point* start) const {
  Point best;
  const Eigen::Index p = shape_.cols();
  Eigen::VectorXd u = start ? Eigen::VectorXd(start->theta.cwiseQuotient(unit_))
                            : Eigen::VectorXd::Constant(p, 1.0 / static_cast<double>(p));
  if (held) {
    held->value /= unit_(held->index);
    u(held->index) = held->value;
    // A start on the bound of everything else has no variance to begin with.
    if (held->value == 0) u = u.cwiseMax(1e-3), u(held->index) = 0;
  }
  best.ramp = held_ramp.value_or(start ? start->ramp : 0);
  Eigen::ArrayXd lambda = shape_ * u;
  if (!(lambda.minCoeff() > 0)) {
    best.theta = u.cwiseProduct(unit_), best.cost = kInfinity, best.converged = true;
    return best;
  }
  double cost_here = kInfinity;
  while (best.iterations < kMostSteps && !best.converged) {
    ++best.iterations;
    if (ramp_ && !held_ramp) best.ramp = best_ramp(lambda);
    const Eigen::ArrayXd P = power(best.ramp), ratio = P / lambda;
    cost_here = cost(lambda, P);
    const Eigen::ArrayXd weight = 0.5 * bins_.count / lambda;
    const Eigen::VectorXd g = shape_.transpose() * (weight * (ratio - 1)).matrix();
    const auto curvature = [&](const Eigen::ArrayXd& w) -> Eigen::MatrixXd {
      Eigen::MatrixXd M = shape_.transpose() * w.matrix().asDiagonal() * shape_;
      M.diagonal() *= 1 + 1e-14;  // two terms of one shape: any split of them will do
      return M;
    };
    Curvature move;
    bool moved = false;
    for (const bool newton : {true, false}) {
      const Eigen::ArrayXd w = newton ? Eigen::ArrayXd(weight / lambda * (2 * ratio - 1)) : weight / lambda;
      if (!move.solve(curvature(w), g, u, held)) continue;
      double part = 1;
      for (int i = 0; i < kMostHalvings && !moved; ++i, part *= 0.5) {
        const Eigen::VectorXd next = (u + part * move.step).cwiseMax(0);
        const Eigen::ArrayXd there = shape_ * next;
        if (!(there.minCoeff() > 0)) continue;
        if (move.promise > kTrusted && !(cost(there, P) < cost_here)) continue;
        u = next, lambda = there, moved = true;
      }
      if (moved) break;
    }
    best.converged = moved && move.promise < kSettled * (1 + std::abs(cost_here));
    if (!moved) break;
  }
  if (ramp_ && !held_ramp) best.ramp = best_ramp(lambda);
  best.theta = u.cwiseProduct(unit_);
  best.cost = cost(lambda, power(best.ramp));
  return best;
}

}  // namespace gyrobudget::inline v0::fit

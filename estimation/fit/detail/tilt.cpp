// SPDX-License-Identifier: MIT
#include "tilt.h"

#include <boost/math/tools/minima.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::FrontEnd;
using Sampling = FrontEnd::Sampling;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kOversamplingCounts = 0.03;  // of bandwidth * dt: below, all ways of sampling are one (front_end.h)
constexpr double kQuarterOfOwnRate = 0.45;    // likewise: from half the log's rate on that is below twice the log's
constexpr std::int64_t kLinearBins = 1024;    // of half the rate: lobes of averages over up to 64 samples are resolved

// Shares of the modelled variance, a column for each coefficient above zero but the held one.
Eigen::MatrixXd shares(const SineLikelihood& likelihood, const Eigen::VectorXd& theta, const Eigen::ArrayXd& lambda,
                       std::optional<Held> held) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index a = 0; a < theta.size(); ++a) {
    if (theta(a) > 0 && !(held && held->index == a)) free.push_back(a);
  }
  Eigen::MatrixXd share(lambda.size(), static_cast<Eigen::Index>(free.size()));
  for (Eigen::Index i = 0; i < share.cols(); ++i) {
    Eigen::VectorXd alone = Eigen::VectorXd::Zero(theta.size());
    alone(free[static_cast<std::size_t>(i)]) = theta(free[static_cast<std::size_t>(i)]);
    share.col(i) = (likelihood.variance(alone) / lambda).matrix();
  }
  return share;
}

// Curvature of the least cost along x: what the coefficients cannot make up for.
double curvature(const Eigen::ArrayXd& count, const Eigen::ArrayXd& slope, const Eigen::MatrixXd& share) {
  const double all = (count * slope.square()).sum();
  if (share.cols() == 0) return all;
  const Eigen::VectorXd along = share.transpose() * (count * slope).matrix();
  const Eigen::MatrixXd M = share.transpose() * count.matrix().asDiagonal() * share;
  return all - along.dot(M.ldlt().solve(along));
}

struct Candidate {
  FrontEnd front_end;
  double cost = kInfinity;
  double white = 0;  // N^2
  double prior = 1;
};

// Bandwidths to begin with, descending. A moving average has zeros: only within a sample of its length do they meet
// those of the spectrum.
std::vector<double> log_corners(FrontEnd::Kind kind) {
  constexpr double kFastest = 1.5, kSlowest = 2e-3, kRatio = 1.4;  // of bandwidths over the rate
  constexpr int kLongest = 65;                                     // lobes of longer averages are not resolved
  std::vector<double> grid;
  if (kind == FrontEnd::Kind::moving_average) {
    for (int length = 1; length <= kLongest; ++length) grid.push_back(std::log(noise::kMovingAverageWidth / length));
  } else {
    for (double x = kFastest; x > kSlowest / kRatio; x /= kRatio) grid.push_back(std::log(x));
  }
  return grid;
}

// The least cost of one front end over what lies in front of it and its floor, each fit beginning where the one before
// ended.
class FilteredCost {
 public:
  FilteredCost(const SineLikelihood& flat, bool has_floor) : flat_(flat), has_floor_(has_floor) {}
  double operator()(const FrontEnd& front_end) {
    const bool again = point_.converged;
    const auto start = point_;
    const Eigen::ArrayXd gain = gain_of(flat_.bins(), front_end);
    const SineLikelihood filtered = has_floor_ ? flat_.before_floor(gain) : flat_.behind(gain);
    point_ = filtered.maximise({}, {}, again ? &start : nullptr);
    return point_.cost;
  }
  // N^2 where the cost was asked for last.
  [[nodiscard]] double white() const { return point_.theta(0); }

 private:
  const SineLikelihood& flat_;
  bool has_floor_;
  SineLikelihood::Point point_;
};

// The least cost of one kind and sampling between two bandwidths, logarithms of bandwidth times dt; to 1e-3 of them,
// well below what a record tells.
Candidate best_between(const SineLikelihood& flat, bool has_floor, FrontEnd front_end, double low, double high) {
  FilteredCost cost(flat, has_floor);
  const auto at = [&](double log_corner) {
    front_end.bandwidth = std::exp(log_corner) / flat.bins().dt;
    return cost(front_end);
  };
  constexpr int kBits = 12;
  std::uintmax_t budget = 40;
  const auto found = boost::math::tools::brent_find_minima(at, low, high, kBits, budget);
  (void)at(found.first);
  return {front_end, found.second, cost.white()};
}

// The logarithms between which the best bandwidth of a kind lies.
std::pair<double, double> around_best(const SineLikelihood& flat, FrontEnd front_end) {
  const std::vector<double> grid = log_corners(front_end.kind);
  FilteredCost cost(flat, true);
  std::size_t best = 1;
  double least = kInfinity;
  for (std::size_t i = 0; i < grid.size(); ++i) {
    front_end.bandwidth = std::exp(grid[i]) / flat.bins().dt;
    const double c = cost(front_end);
    if (c < least) least = c, best = std::clamp<std::size_t>(i, 1, grid.size() - 2);
  }
  return {grid[best + 1], grid[best - 1]};
}

// The best of every way of sampling a kind. They differ near half the rate alone, so that one of them says where to
// look for the others too, a little further about.
void add_best(std::vector<Candidate>& found, const SineLikelihood& flat, FrontEnd::Kind kind) {
  constexpr double kBeside = 0.2;
  const auto [low, high] = around_best(flat, {kind, 0, Sampling::analogue});
  found.push_back(best_between(flat, true, {kind, 0, Sampling::analogue}, low, high));
  if (kind == FrontEnd::Kind::moving_average) return;
  for (const Sampling sampling : {Sampling::bilinear, Sampling::held})
    found.push_back(best_between(flat, true, {kind, 0, sampling}, low - kBeside, high + kBeside));
  if (low < std::log(kOversamplingCounts)) return;
  for (const double oversampling : {2., 4.})
    found.push_back(
        best_between(flat, true, {kind, 0, Sampling::bilinear, oversampling}, low - kBeside, high + kBeside));
}

WhiteShift choice_of(const std::vector<Candidate>& candidates, const Candidate& best) {
  double weights = 0, sum = 0, squares = 0;
  for (const Candidate& c : candidates) {
    if (!(c.white > 0 && best.white > 0)) continue;
    const double weight = c.prior * std::exp(-0.5 * (c.cost - best.cost)), shift = 0.5 * std::log(c.white / best.white);
    weights += weight, sum += weight * shift, squares += weight * shift * shift;
  }
  if (!(weights > 0)) return {};
  const double mean = sum / weights;
  return {mean, std::sqrt(std::max(0., squares / weights - mean * mean))};
}

bool is_faster_than_log(const FrontEnd& f) { return f.sampling == Sampling::analogue || f.oversampling > 1; }

// The candidates of the best one's kind that filter at a faster rate than the log's, from twice that on, are one
// family of a parameter u, the log's rate over the filter's own, 0 of an analogue one: all u from 0 to 1/2 are as
// likely before the record is seen, and together as likely as the analogue one. The cost of a bandwidth at its best is
// a parabola about the best u, ln N a straight line.
class Oversampling {
 public:
  Oversampling(const SineLikelihood& flat, const Candidate& best)
      : flat_(flat), kind_(best.front_end.kind), middle_(std::log(best.front_end.bandwidth * flat.bins().dt)) {}

  // In place of those of the family.
  void refine(std::vector<Candidate>& found) const {
    constexpr int kBits = 7;
    std::uintmax_t budget = 15;
    const double u =
        boost::math::tools::brent_find_minima([&](double x) { return at(x).cost; }, 0., kMostU, kBits, budget).first;
    constexpr double kBeside = 0.04;
    const double center = std::clamp(u, kBeside, kMostU - kBeside);
    const Candidate best = at(u), below = at(center - kBeside), middle = at(center), above = at(center + kBeside);
    if (!(below.white > 0 && above.white > 0)) return;
    const double curvature = (above.cost - 2 * middle.cost + below.cost) / (kBeside * kBeside);
    const double slope = (above.cost - below.cost) / (2 * kBeside);
    const double log_slope = 0.5 * std::log(above.white / below.white) / (2 * kBeside);
    // The analogue one stays for what it is, beforehand as likely as all others of the family together: most are.
    std::erase_if(found, [&](const Candidate& c) { return c.front_end.kind == kind_ && c.front_end.oversampling > 1; });
    found.push_back(best);
    found.back().prior = 0;  // the points stand for it
    constexpr int kPoints = 200;
    for (int i = 0; i < kPoints; ++i) {
      const double x = (i + 0.5) * kMostU / kPoints, away = x - center;
      const double cost = middle.cost + slope * away + 0.5 * std::max(0., curvature) * away * away;
      found.push_back(
          {best.front_end, std::max(cost, best.cost), middle.white * std::exp(2 * log_slope * away), 1. / kPoints});
    }
  }

 private:
  static constexpr double kMostU = 0.5;
  [[nodiscard]] Candidate at(double u) const {
    constexpr double kReach = 0.2, kNone = 1 / FrontEnd::kMostOversampling;
    const bool analogue = u < kNone;
    const FrontEnd f{kind_, 0, analogue ? Sampling::analogue : Sampling::bilinear, analogue ? 1 : 1 / u};
    return best_between(flat_, false, f, middle_ - kReach, middle_ + kReach);
  }

  const SineLikelihood& flat_;
  FrontEnd::Kind kind_;
  double middle_;  // logarithm of a bandwidth near which the best ones lie
};

}  // namespace

std::int64_t widest_bin(std::int64_t samples) { return std::max<std::int64_t>(1, samples / kLinearBins); }

Eigen::ArrayXd gain_of(const SineBins& bins, const FrontEnd& front_end) {
  const noise::SampledFrontEnd filter(front_end, bins.dt);
  const double cycles = 0.5 / static_cast<double>(bins.samples);
  Eigen::ArrayXd gain(bins.count.size());
  for (Eigen::Index b = 0; b < gain.size(); ++b) {
    const auto first = bins.first[static_cast<std::size_t>(b)], end = bins.first[static_cast<std::size_t>(b) + 1];
    const double half = 0.5 * static_cast<double>(end - first), middle = static_cast<double>(first) - 0.5 + half;
    const double offset = end - first == 1 ? 0 : half * std::sqrt(0.6);  // three-point Gauss quadrature
    gain(b) = (5 * filter.power_gain((middle - offset) * cycles) + 8 * filter.power_gain(middle * cycles) +
               5 * filter.power_gain((middle + offset) * cycles)) /
              18;
  }
  constexpr double kLeast = 1e-12;  // no bin is without variance: the likelihood divides by it
  return gain.max(kLeast);
}

Tilt tilt_of(const SineBins& bins, const FrontEnd& front_end) {
  constexpr double kStep = 1e-3;
  const auto at = [&](double x) {
    FrontEnd moved = front_end;
    moved.bandwidth *= std::exp(x);
    return gain_of(bins, moved);
  };
  return {at(0), (at(kStep).log() - at(-kStep).log()) / (2 * kStep), 0};
}

Tilt unknown_tilt(const SineBins& bins, std::int64_t last) {
  Tilt tilt{Eigen::ArrayXd::Ones(bins.count.size()), Eigen::ArrayXd(bins.count.size()), 0};
  for (Eigen::Index b = 0; b < tilt.slope.size(); ++b) {
    const auto i = static_cast<std::size_t>(b);
    const double k = 0.5 * static_cast<double>(bins.first[i] + bins.first[i + 1] - 1) / static_cast<double>(last);
    tilt.slope(b) = -k * k;
  }
  return tilt;
}

TiltedPoint maximise_tilted(const SineLikelihood& flat, const Tilt& tilt, std::optional<Held> held,
                            std::optional<double> held_ramp, const SineLikelihood::Point* start) {
  constexpr int kMostSteps = 30;
  constexpr double kSettled = 1e-5;  // of a standard deviation: the cost is then right to 1e-10
  constexpr double kLongest = 0.5;   // step
  TiltedPoint best;
  best.x = tilt.x;
  const Eigen::ArrayXd& count = flat.bins().count;
  double before_x = 0, before_slope = 0;
  for (int i = 0; i < kMostSteps; ++i) {
    const SineLikelihood here = flat.behind(tilt(best.x));
    best.point = here.maximise(held, held_ramp, start);
    if (!best.point.converged || !std::isfinite(best.point.cost)) return best;
    const Eigen::ArrayXd lambda = here.variance(best.point.theta);
    const double slope = (count * (1 - here.power(best.point.ramp) / lambda) * tilt.slope).sum();
    const double fisher = curvature(count, tilt.slope, shares(here, best.point.theta, lambda, held));
    best.deviation = fisher > 0 ? std::sqrt(2 / fisher) : kInfinity;
    if (!(fisher > 0)) return best;
    // The secant where it is a curvature, Fisher's expectation of it else.
    const double secant = i > 0 ? (slope - before_slope) / (best.x - before_x) : 0;
    const double step = -slope / (secant > 0.2 * fisher ? secant : fisher);
    if (std::abs(step) < kSettled * best.deviation) return best;
    before_x = best.x, before_slope = slope;
    best.x += std::clamp(step, -kLongest, kLongest);
  }
  best.point.converged = false;
  return best;
}

Eigen::MatrixXd information_with_tilt(const SineLikelihood& tilted, const Eigen::VectorXd& theta,
                                      const Eigen::ArrayXd& slope) {
  Eigen::MatrixXd information = tilted.information(theta);
  const Eigen::ArrayXd& count = tilted.bins().count;
  const Eigen::ArrayXd lambda = tilted.variance(theta);
  const double own = 0.5 * (count * slope.square()).sum();
  Eigen::VectorXd shared(theta.size());
  for (Eigen::Index a = 0; a < theta.size(); ++a) {
    Eigen::VectorXd unit = Eigen::VectorXd::Zero(theta.size());
    unit(a) = 1;
    shared(a) = 0.5 * (count * slope * tilted.variance(unit) / lambda).sum();
  }
  if (own > 0) information -= shared * shared.transpose() / own;
  return information;
}

void leave_out_stop_band(SineBins& bins, const FrontEnd& front_end) {
  constexpr double kEnds = 100;
  const Eigen::ArrayXd gain = gain_of(bins, front_end);
  bins.count = (gain < kEnds / static_cast<double>(bins.samples)).select(0, bins.count);
}

ChosenFrontEnd search_front_end(SineBins bins, std::span<const noise::Process> processes,
                                std::optional<FrontEnd::Kind> kind) {
  std::vector<noise::Process> with_floor(processes.begin(), processes.end());
  with_floor.emplace_back(noise::White{1});
  std::vector<Candidate> found;
  const auto cheapest = [&] { return *std::ranges::min_element(found, {}, &Candidate::cost); };
  const SineLikelihood all(bins, with_floor, false);
  using Kind = FrontEnd::Kind;
  for (const Kind k : {Kind::first_order, Kind::second_order, Kind::moving_average})
    if (!kind || *kind == k) add_best(found, all, k);
  leave_out_stop_band(bins, cheapest().front_end);
  const SineLikelihood seen(std::move(bins), processes, false);
  constexpr double kReach = 0.1;
  for (Candidate& c : found) {
    const double middle = std::log(c.front_end.bandwidth * seen.bins().dt);
    c = best_between(seen, false, c.front_end, middle - kReach, middle + kReach);
  }
  const Candidate best = cheapest();
  const double corner = best.front_end.bandwidth * seen.bins().dt;
  const bool resolved = corner > kOversamplingCounts && corner < kQuarterOfOwnRate;
  if (best.front_end.kind != Kind::moving_average && is_faster_than_log(best.front_end) && resolved)
    Oversampling(seen, best).refine(found);
  return {cheapest().front_end, choice_of(found, cheapest())};
}

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#include "outlier_tail.h"

#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/roots.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kFewest = 20;      // outliers that stand out, and show a tail
constexpr double kLeastLimit = 2.5;      // sigmas: below, more noise than tail is cut off
constexpr std::int64_t kLooks = 100000;  // samples that set the scale
constexpr double kMadScatter = 1.166;    // one sigma of a scale from a median of n sizes, times the root of n

double density(double x) { return std::exp(-0.5 * x * x) / std::sqrt(2 * std::numbers::pi); }
/// P(|x| > limit) of a standard normal.
double beyond(double limit) { return std::erfc(limit / std::numbers::sqrt2); }
/// E[x^2; |x| < limit].
double square_within(double limit) { return 1 - beyond(limit) - 2 * limit * density(limit); }

struct Mixture {
  double share, sigmas;
  [[nodiscard]] double operator()(double x) const {
    return (1 - share) * density(x) + share * density(x / sigmas) / sigmas;
  }
  [[nodiscard]] double beyond_limit(double limit) const {
    return (1 - share) * beyond(limit) + share * beyond(limit / sigmas);
  }
  /// OutlierTail::left.
  [[nodiscard]] double left(double limit) const {
    return ((1 - share) * square_within(limit) + hidden(limit)) / (1 - beyond_limit(limit)) - 1;
  }
  /// The tail's part in it.
  [[nodiscard]] double hidden(double limit) const { return share * sigmas * sigmas * square_within(limit / sigmas); }
  /// Where both parts are as likely.
  [[nodiscard]] double crossing() const {
    const double odds = std::log(sigmas * (1 - share) / share);
    return std::sqrt(2 * std::max(0., odds) / (1 - 1 / (sigmas * sigmas)));
  }
  /// Median of |x|.
  [[nodiscard]] double median() const {
    const auto excess = [&](double x) { return 0.5 - beyond_limit(x); };
    std::uintmax_t budget = 60;
    const auto found = boost::math::tools::toms748_solve(excess, 0., 10 * sigmas,
                                                         boost::math::tools::eps_tolerance<double>(30), budget);
    return 0.5 * (found.first + found.second);
  }
};

/// Distances beyond a limit, in groups of like size; and how many samples there are in all.
struct Exceedances {
  struct Group {
    double x, count;
  };
  std::vector<Group> groups;
  double limit = 0, count = 0, samples = 0;

  Exceedances(std::vector<double> sizes, double limit_, double samples_) : limit(limit_), samples(samples_) {
    constexpr std::size_t kGroups = 80;
    std::ranges::sort(sizes);
    const std::size_t each = std::max<std::size_t>(1, sizes.size() / kGroups);
    for (std::size_t i = 0; i < sizes.size(); i += each) {
      const std::size_t end = std::min(sizes.size(), i + each);
      const double sum = std::accumulate(sizes.begin() + static_cast<std::ptrdiff_t>(i),
                                         sizes.begin() + static_cast<std::ptrdiff_t>(end), 0.);
      groups.push_back({sum / static_cast<double>(end - i), static_cast<double>(end - i)});
    }
    count = static_cast<double>(sizes.size());
  }

  /// -ln L of how many lie beyond the limit, and where.
  [[nodiscard]] double cost(double log_share, double log_sigmas) const {
    const Mixture mixture{std::exp(log_share), std::exp(log_sigmas)};
    double sum = (samples - count) * std::log1p(-mixture.beyond_limit(limit));
    for (const Group& g : groups) sum += g.count * std::log(mixture(g.x));
    return -sum;
  }
};

struct Point {
  double log_share = 0, log_sigmas = 0;
  bool inside = false;  ///< of the range that was searched
};

Point maximum_likelihood(const Exceedances& e) {
  constexpr double kLeastSigmas = 1.2, kMostSigmas = 1e6, kMostShare = 0.5;
  constexpr int kBits = 12;  // to 2e-4 of the logarithms, far below their scatter
  const double least_share = std::log(e.count / e.samples) - 1, most_share = std::log(kMostShare);
  const auto best_share = [&](double log_sigmas) {
    std::uintmax_t budget = 50;
    return boost::math::tools::brent_find_minima([&](double log_share) { return e.cost(log_share, log_sigmas); },
                                                 least_share, most_share, kBits, budget);
  };
  const double low = std::log(kLeastSigmas);
  const double high = std::log(std::min(kMostSigmas, 3 * e.groups.back().x));
  if (!(high > low) || !(most_share > least_share)) return {};
  std::uintmax_t budget = 60;
  const auto found =
      boost::math::tools::brent_find_minima([&](double s) { return best_share(s).second; }, low, high, kBits, budget);
  const double share = best_share(found.first).first;
  constexpr double kEdge = 0.01;
  const bool inside = found.first > low + kEdge && found.first < high - kEdge && share < most_share - kEdge;
  return {share, found.first, inside};
}

/// One sigma of Mixture::left by the curvature of the likelihood at its maximum, by the scatter of the scale, which
/// moves the limit, and by errors that are not quite normal: a tenth of what hides.
double sigma_of_left(const Exceedances& e, const Point& p, double limit) {
  constexpr double h = 0.02;
  const auto cost = [&](int i, int j) { return e.cost(p.log_share + i * h, p.log_sigmas + j * h); };
  const auto left = [&](int i, int j) {
    return Mixture{std::exp(p.log_share + i * h), std::exp(p.log_sigmas + j * h)}.left(limit);
  };
  const double aa = (cost(1, 0) - 2 * cost(0, 0) + cost(-1, 0)) / (h * h);
  const double bb = (cost(0, 1) - 2 * cost(0, 0) + cost(0, -1)) / (h * h);
  const double ab = (cost(1, 1) - cost(1, -1) - cost(-1, 1) + cost(-1, -1)) / (4 * h * h);
  const double determinant = aa * bb - ab * ab;
  const double da = (left(1, 0) - left(-1, 0)) / (2 * h), db = (left(0, 1) - left(0, -1)) / (2 * h);
  const Mixture mixture{std::exp(p.log_share), std::exp(p.log_sigmas)};
  const double scale = kMadScatter / std::sqrt(std::min(e.samples, static_cast<double>(kLooks)));
  const double by_scale = (mixture.left(limit * (1 + h)) - mixture.left(limit * (1 - h))) / (2 * h) * scale;
  const double variance = (bb * da * da - 2 * ab * da * db + aa * db * db) / determinant;
  constexpr double kShape = 0.1;
  const double by_shape = kShape * mixture.hidden(limit);
  return variance > 0 && determinant > 0 ? std::hypot(std::sqrt(variance), by_scale, by_shape) : std::abs(left(0, 0));
}

// Knocks and motion last for several samples.
bool stand_alone(const std::vector<Outlier>& outliers) {
  constexpr std::int64_t kClose = 2;
  constexpr std::size_t kMost = 4;  // one of so many may be close to the one before
  std::size_t close = 0;
  for (std::size_t i = 1; i < outliers.size(); ++i)
    close += outliers[i].index - outliers[i - 1].index <= kClose ? 1 : 0;
  return kMost * close <= outliers.size();
}

std::vector<double> sizes_of(const std::vector<Outlier>& outliers, double sigma) {
  std::vector<double> sizes;
  for (const Outlier& o : outliers) sizes.push_back(std::abs(o.distance) / sigma);
  return sizes;
}

}  // namespace

double kurtosis(const OutlierTail& tail) {
  const double square = tail.sigmas * tail.sigmas;
  const double variance = 1 - tail.share + tail.share * square;
  return 3 * (1 - tail.share + tail.share * square * square) / (variance * variance);
}

std::optional<OutlierTail> find_outlier_tail(std::span<const double> rate, std::vector<Outlier>& outliers) {
  if (outliers.size() < kFewest || !stand_alone(outliers)) return {};
  const auto samples = static_cast<double>(std::ranges::count_if(rate, [](double y) { return std::isfinite(y); }));
  const double typical = median_distance(rate, kLooks);
  if (!(typical > 0)) return {};
  const double sigmas = std::abs(outliers.front().distance) / outliers.front().sigmas;  // one of Outlier::sigmas
  double limit = std::abs(std::ranges::min_element(outliers, {}, &Outlier::sigmas)->distance);
  std::vector<Outlier> all = outliers;
  std::optional<OutlierTail> tail;
  // The tail raises the median distance that the scale is taken from, and its limit brings further samples in.
  double sigma = typical / Mixture{0, 1}.median();
  constexpr int kRounds = 4;
  for (int i = 0; i < kRounds; ++i) {
    const Exceedances e(sizes_of(all, sigma), limit / sigma, samples);
    const Point p = maximum_likelihood(e);
    if (!p.inside) return {};
    const Mixture mixture{std::exp(p.log_share), std::exp(p.log_sigmas)};
    sigma = typical / mixture.median();
    tail = OutlierTail{.share = mixture.share, .sigmas = mixture.sigmas, .limit = limit / sigma, .sigma = sigma};
    tail->left = mixture.left(tail->limit);
    tail->left_sigma = sigma_of_left(e, p, tail->limit);
    if (i + 1 == kRounds) break;
    limit = std::min(limit, std::max(kLeastLimit, mixture.crossing()) * sigma);
    all = find_outliers(rate, {.limit = limit / sigmas});
  }
  outliers = std::move(all);
  return tail;
}

}  // namespace gyrobudget::inline v0::allan

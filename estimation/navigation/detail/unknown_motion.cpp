// SPDX-License-Identifier: MIT
#include "unknown_motion.h"

#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace gyrobudget::inline v0::navigation::detail {
namespace {

using Six = Eigen::Matrix<double, 6, 1>;

constexpr double kReach = 10;      // lengths of a gap to either side in which the log is asked
constexpr double kLeastReach = 1;  // s
constexpr double kStride = 0.25;   // lengths between stretches
constexpr double kMost = 100;      // stretches: more of short ones tell nothing new
constexpr double kFewest = 8;      // stretches below which the spread of the samples themselves counts too

// The sound part of a log, summed so that any stretch has its mean at once.
class Motion {
 public:
  explicit Motion(const ImuLog& log) : log_(log) {
    sums_.reserve(log.increments.size() + 1);
    squares_.reserve(log.increments.size() + 1);
    bridged_.reserve(log.increments.size() + 1);
    sums_.push_back(Six::Zero());
    squares_.push_back(Six::Zero());
    bridged_.push_back(0);
    for (std::size_t k = 0; k < log.increments.size(); ++k) {
      sums_.push_back(sums_[k] + seconds(k, k + 1) * rates(k));
      squares_.push_back(squares_[k] + seconds(k, k + 1) * rates(k).cwiseAbs2());
      bridged_.push_back(bridged_[k] + (log.bridged[k] ? 1U : 0U));
    }
  }

  // One sigma of the mean of a bridge from interval `from` to before `to`.
  [[nodiscard]] Six error(std::size_t from, std::size_t to) const {
    const double length = seconds(from, to), reach = std::max(kReach * length, kLeastReach);
    const double begin = time(from) - reach, end = time(to) + reach;
    Six sum = Six::Zero();
    double count = 0;
    const double stride = std::max(kStride * length, (end - begin) / kMost);
    for (double t = begin; t + length <= end; t += stride) {
      const std::size_t first = interval_at(t), last = interval_at(t + length);
      if (first == 0 || last <= first || last >= log_.increments.size() || !sound(first - 1, last + 1)) continue;
      const Six mean = (sums_[last] - sums_[first]) / seconds(first, last);
      sum += (mean - (rates(first - 1) + rates(last)) / 2).cwiseAbs2();
      count += 1;
    }
    Six variance = count > 0 ? Six(sum / count) : Six::Zero();
    if (count < kFewest) variance = variance.cwiseMax(spread(begin, end));
    return variance.cwiseSqrt();
  }

  [[nodiscard]] double seconds(std::size_t from, std::size_t to) const { return time(to) - time(from); }

 private:
  [[nodiscard]] double time(std::size_t stamp) const {
    return static_cast<double>(log_.stamps[stamp] - log_.stamps[0]) * noise::kNanosecond;
  }
  [[nodiscard]] Six rates(std::size_t k) const {
    Six both;
    both << earth::vector(log_.increments[k].angle), earth::vector(log_.increments[k].velocity);
    return both / seconds(k, k + 1);
  }
  [[nodiscard]] bool sound(std::size_t from, std::size_t to) const { return bridged_[from] == bridged_[to]; }
  // The first interval that begins at or after t [s].
  [[nodiscard]] std::size_t interval_at(double t) const {
    const auto stamp = log_.stamps[0] + std::llround(t / noise::kNanosecond);
    return static_cast<std::size_t>(std::ranges::lower_bound(log_.stamps, stamp) - log_.stamps.begin());
  }
  // Variance of the samples from one time to another, those of gaps included, of the whole log if there are few.
  [[nodiscard]] Six spread(double begin, double end) const {
    std::size_t first = interval_at(begin), last = std::min(interval_at(end), log_.increments.size());
    constexpr std::size_t kSamples = 10;
    if (last < first + kSamples) first = 0, last = log_.increments.size();
    const double length = seconds(first, last);
    const Six mean = (sums_[last] - sums_[first]) / length;
    return ((squares_[last] - squares_[first]) / length - mean.cwiseAbs2()).cwiseMax(0);
  }

  const ImuLog& log_;
  std::vector<Six> sums_, squares_;
  std::vector<std::size_t> bridged_;
};

}  // namespace

Gaps::Gaps(const ImuLog& log) {
  if (std::ranges::find(log.bridged, true) == log.bridged.end()) return;
  const Motion motion(log);
  for (std::size_t k = 0; k < log.bridged.size(); ++k) {
    if (!log.bridged[k]) continue;
    const std::size_t from = k;
    while (k < log.bridged.size() && log.bridged[k]) ++k;
    const Six density = motion.error(from, k) * std::sqrt(motion.seconds(from, k));
    gaps_.push_back({from, k, {.rate = density.head<3>(), .force = density.tail<3>()}});
  }
}

const UnknownMotion* Gaps::at(std::size_t interval) const {
  const auto gap = std::ranges::upper_bound(gaps_, interval, {}, &Gap::from);
  if (gap == gaps_.begin() || interval >= std::prev(gap)->to) return nullptr;
  return &std::prev(gap)->motion;
}

}  // namespace gyrobudget::inline v0::navigation::detail

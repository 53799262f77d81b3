// SPDX-License-Identifier: MIT
#include "fill.h"

#include "gyrobudget/noise/normal.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "dst.h"

namespace gyrobudget::inline v0::fit {
namespace {

using Indices = std::span<const std::int64_t>;
constexpr std::int64_t kReach = 256;   // samples on either side that a missing one is told by
constexpr std::int64_t kLevel = 1024;  // over which their mean is taken
constexpr std::size_t kCells = 1024;   // of the spectrum that the reach is worked out from
constexpr int kFewestTurns = 2, kMostTurns = 8, kMostSteps = 40;
constexpr double kLeft = 1e-5;     // of the first bridge's error
constexpr double kSettled = 1e-6;  // squared relative residual of the conditional mean

double& at(std::span<double> x, std::int64_t i) { return x[static_cast<std::size_t>(i)]; }
double at(std::span<const double> x, std::int64_t i) { return x[static_cast<std::size_t>(i)]; }

// Straight lines between the samples beside each gap, level at the ends.
void bridge(std::span<double> rate, Indices missing) {
  const auto n = static_cast<std::int64_t>(rate.size());
  for (std::size_t a = 0; a < missing.size();) {
    std::size_t b = a;
    while (b + 1 < missing.size() && missing[b + 1] == missing[b] + 1) ++b;
    const std::int64_t before = missing[a] - 1, after = missing[b] + 1;
    const double left = before >= 0 ? at(rate, before) : at(rate, after);
    const double right = after < n ? at(rate, after) : left;
    for (std::int64_t i = missing[a]; i <= missing[b]; ++i)
      at(rate, i) = left + (right - left) * static_cast<double>(i - before) / static_cast<double>(after - before);
    a = b + 1;
  }
}

// Power of the rate at each k = 1 .. n-1, smoothed; in units in which the sine coefficients of white noise have 4 s^2.
std::vector<double> smoothed_spectrum(std::span<const double> rate) {
  constexpr std::int64_t kNarrowest = 32;
  constexpr double kWidth = 0.1;
  const auto c = sine_transform_of_differences(rate);
  const auto n = static_cast<double>(rate.size());
  const auto last = static_cast<std::int64_t>(c.size());
  std::vector<double> spectrum(c.size());
  for (std::int64_t from = 1; from <= last;) {
    std::int64_t end = from + std::max(kNarrowest, static_cast<std::int64_t>(kWidth * static_cast<double>(from)));
    if (end + kNarrowest > last) end = last + 1;
    double sum = 0;
    for (std::int64_t k = from; k < end; ++k) {
      const double s = 2 * std::sin(std::numbers::pi * static_cast<double>(k) / (2 * n));
      sum += at(std::span<const double>(c), k - 1) / s * (at(std::span<const double>(c), k - 1) / s);
    }
    const double mean = std::max(sum / static_cast<double>(end - from), 1e-300);
    for (std::int64_t k = from; k < end; ++k) at(std::span(spectrum), k - 1) = mean;
    from = end;
  }
  return spectrum;
}

// A record of that spectrum. The sine transform is its own inverse.
std::vector<double> drawn(const std::vector<double>& spectrum, noise::StreamKey key) {
  const std::size_t n = spectrum.size() + 1;
  std::vector<double> x(n, 0.0);
  noise::fill_normal(key, 0, std::span(x).subspan(1));
  for (std::size_t k = 1; k < n; ++k) {
    const double s = 2 * std::sin(std::numbers::pi * static_cast<double>(k) / (2 * static_cast<double>(n)));
    x[k] = x[k - 1] + s * std::sqrt(spectrum[k - 1]) * x[k];  // summed: the transform takes differences
  }
  const auto differences = sine_transform_of_differences(x);
  std::vector<double> z(n, 0.0);
  for (std::size_t i = 1; i < n; ++i) z[i] = z[i - 1] + differences[i - 1];
  return z;
}

// q(0) .. q(reach): covariance of the noise with the inverse spectrum, 1 at 0, tapered.
std::vector<double> inverse_kernel(const std::vector<double>& spectrum, std::int64_t reach) {
  std::vector<double> sum(kCells, 0.0), count(kCells, 0.0);
  const std::size_t n = spectrum.size() + 1;
  for (std::size_t k = 1; k < n; ++k) {
    const std::size_t cell = k * kCells / n;
    sum[cell] += 1 / spectrum[k - 1];
    ++count[cell];
  }
  std::vector<double> q(static_cast<std::size_t>(reach) + 1, 0.0);
  double cells = 0;
  for (std::size_t i = 0; i < kCells; ++i) {
    if (count[i] == 0) continue;  // short records leave some out, evenly
    ++cells;
    const double step = std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(kCells);
    for (std::size_t h = 0; h < q.size(); ++h) q[h] += sum[i] / count[i] * std::cos(step * static_cast<double>(h));
  }
  const double whole = q[0];
  for (std::size_t h = 0; h < q.size(); ++h) {
    const double taper =
        0.5 + 0.5 * std::cos(std::numbers::pi * static_cast<double>(h) / static_cast<double>(q.size()));
    q[h] *= taper / whole;
  }
  return q;
}

class ConditionalMean {
 public:
  /// @param r  zero where missing
  ConditionalMean(std::span<const double> r, Indices missing, std::vector<double> kernel)
      : r_(r), missing_(missing), q_(std::move(kernel)), exists_(r.size(), 1) {
    for (const auto i : missing) exists_[static_cast<std::size_t>(i)] = 0;
  }

  // Of what is missing.
  [[nodiscard]] std::vector<double> solve() const {
    const auto level = levels();
    std::vector<double> u(missing_.size(), 0.0), residual = right_side(level), direction = residual;
    const auto squares = [](const std::vector<double>& x) {
      double sum = 0;
      for (const double v : x) sum += v * v;
      return sum;
    };
    const double start = squares(residual);
    double before = start;
    for (int step = 0; step < kMostSteps && before > kSettled * start; ++step) {
      const auto image = times(direction);
      double along = 0;
      for (std::size_t a = 0; a < image.size(); ++a) along += direction[a] * image[a];
      if (!(along > 0)) break;
      const double length = before / along;
      for (std::size_t a = 0; a < image.size(); ++a) u[a] += length * direction[a], residual[a] -= length * image[a];
      const double now = squares(residual);
      for (std::size_t a = 0; a < image.size(); ++a) direction[a] = residual[a] + now / before * direction[a];
      before = now;
    }
    for (std::size_t a = 0; a < u.size(); ++a) u[a] += level[a];
    return u;
  }

 private:
  [[nodiscard]] std::int64_t reach() const { return static_cast<std::int64_t>(q_.size()) - 1; }
  [[nodiscard]] std::int64_t first(std::int64_t i) const { return std::max<std::int64_t>(0, i - reach()); }
  [[nodiscard]] std::int64_t end(std::int64_t i) const {
    return std::min<std::int64_t>(static_cast<std::int64_t>(r_.size()), i + reach() + 1);
  }
  [[nodiscard]] double q(std::int64_t lag) const { return q_[static_cast<std::size_t>(std::abs(lag))]; }

  // Mean of what exists around each missing sample.
  [[nodiscard]] std::vector<double> levels() const {
    std::vector<double> sum(r_.size() + 1, 0.0), count(r_.size() + 1, 0.0);
    for (std::size_t i = 0; i < r_.size(); ++i) sum[i + 1] = sum[i] + r_[i], count[i + 1] = count[i] + exists_[i];
    std::vector<double> level;
    for (const auto i : missing_) {
      const auto from = static_cast<std::size_t>(std::max<std::int64_t>(0, i - kLevel));
      const auto to = std::min(r_.size(), static_cast<std::size_t>(i + kLevel + 1));
      const double existing = count[to] - count[from];
      level.push_back(existing > 0 ? (sum[to] - sum[from]) / existing : 0);
    }
    return level;
  }

  [[nodiscard]] std::vector<double> right_side(const std::vector<double>& level) const {
    std::vector<double> b(missing_.size(), 0.0);
    for (std::size_t a = 0; a < b.size(); ++a) {
      const auto i = missing_[a];
      for (auto j = first(i); j < end(i); ++j)
        b[a] -= exists_[static_cast<std::size_t>(j)] * q(i - j) * (at(r_, j) - level[a]);
    }
    return b;
  }

  [[nodiscard]] std::vector<double> times(const std::vector<double>& u) const {
    std::vector<double> image(u.size(), 0.0);
    std::size_t from = 0;
    for (std::size_t a = 0; a < u.size(); ++a) {
      while (missing_[from] < missing_[a] - reach()) ++from;
      for (std::size_t b = from; b < u.size() && missing_[b] <= missing_[a] + reach(); ++b)
        image[a] += q(missing_[a] - missing_[b]) * u[b];
    }
    return image;
  }

  std::span<const double> r_;
  Indices missing_;
  std::vector<double> q_;
  std::vector<unsigned char> exists_;
};

}  // namespace

void fill_gaps(std::span<double> rate, Indices missing, std::uint64_t stream) {
  bridge(rate, missing);
  const double share = static_cast<double>(missing.size()) / static_cast<double>(rate.size());
  const int needed = static_cast<int>(std::ceil(std::log(kLeft) / std::log(share))) - 1;
  const int turns = std::clamp(needed, kFewestTurns, kMostTurns);
  const std::int64_t reach = std::min<std::int64_t>(kReach, static_cast<std::int64_t>(rate.size()) / 4);
  for (int turn = 0; turn < turns; ++turn) {
    const auto spectrum = smoothed_spectrum(rate);
    const auto z = drawn(spectrum, {.seed = 1, .stream = stream});
    std::vector<double> r(rate.size());
    for (std::size_t i = 0; i < r.size(); ++i) r[i] = rate[i] - z[i];
    for (const auto i : missing) at(std::span(r), i) = 0;
    const auto mean = ConditionalMean(r, missing, inverse_kernel(spectrum, reach)).solve();
    for (std::size_t a = 0; a < missing.size(); ++a)
      at(rate, missing[a]) = at(std::span<const double>(z), missing[a]) + mean[a];
  }
}

double information_left(double missing_share) { return (1 - missing_share) * (1 - missing_share); }

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#include "family_reference.h"

#include <algorithm>
#include <functional>
#include <vector>

namespace gyrobudget::allan::reference {
namespace {

using Real = long double;
using Series = std::vector<Real>;

Series phases(std::span<const double> rate, double dt) {
  Real mean = 0;  // no estimator sees it, but it costs digits
  for (const double y : rate) mean += y;
  mean /= static_cast<Real>(rate.size());
  Series x{0};
  for (const double y : rate) x.push_back(x.back() + (y - mean) * dt);
  return x;
}

Real mean_square(std::int64_t count, std::int64_t stride, const std::function<Real(std::int64_t)>& term) {
  Real sum = 0;
  std::int64_t terms = 0;
  for (std::int64_t k = 0; k < count; k += stride, ++terms) sum += term(k) * term(k);
  return sum / terms;
}

Real sum(const Series& z, std::int64_t from, std::int64_t count) {
  Real total = 0;
  for (std::int64_t i = from; i < from + count; ++i) total += z[static_cast<std::size_t>(i)];
  return total;
}

/// Mean square of the second difference of means over m, of a stretch continued evenly to both sides.
Real evenly_continued(const Series& z, std::int64_t first, std::int64_t m) {
  const std::int64_t length = 3 * m, half = length / 2;
  Series stretch(z.begin() + first, z.begin() + first + length);
  // The slope between the means of the two halves; an odd stretch leaves its middle out.
  const Real apart = length % 2 == 0 ? length / 2.0L : length / 2.0L + 0.5L;
  const Real slope = (sum(stretch, length - half, half) - sum(stretch, 0, half)) / half / apart;
  for (std::int64_t i = 0; i < length; ++i) stretch[static_cast<std::size_t>(i)] -= slope * i;
  Series whole(stretch.rbegin(), stretch.rend());
  whole.insert(whole.end(), stretch.begin(), stretch.end());
  whole.insert(whole.end(), stretch.rbegin(), stretch.rend());
  return mean_square(6 * m, 1, [&](std::int64_t i) {
    return (sum(whole, i, m) - 2 * sum(whole, i + m, m) + sum(whole, i + 2 * m, m)) / m;
  });
}

Real theo1(const Series& x, std::int64_t m, std::int64_t stride) {
  Real total = 0;
  std::int64_t terms = 0;
  for (std::size_t i = 0, M = static_cast<std::size_t>(m); i + M < x.size(); i += static_cast<std::size_t>(stride)) {
    for (std::size_t delta = 0; delta < M / 2; ++delta) {
      const Real d = (x[i] - x[i - delta + M / 2]) + (x[i + M] - x[i + delta + M / 2]);
      total += d * d / static_cast<Real>(M / 2 - delta);
    }
    ++terms;
  }
  return total / terms / 0.75L;
}

}  // namespace

long double family_variance(Estimator estimator, std::span<const double> rate, double dt, std::int64_t m,
                            std::int64_t stride) {
  const Series x = phases(rate, dt);
  const auto n = static_cast<std::int64_t>(rate.size());
  const Real tau = static_cast<Real>(m) * dt;
  const auto X = [&](std::int64_t k) { return x[static_cast<std::size_t>(k)]; };
  const auto second = [&](std::int64_t k) { return X(k + 2 * m) - 2 * X(k + m) + X(k); };
  const auto third = [&](std::int64_t k) { return X(k + 3 * m) - 3 * X(k + 2 * m) + 3 * X(k + m) - X(k); };
  const auto reflected = [&](std::int64_t k) {
    return k < 0 ? 2 * X(0) - X(-k) : k > n ? 2 * X(n) - X(2 * n - k) : X(k);
  };
  switch (estimator) {
    case Estimator::adev:
      return mean_square(n - 2 * m + 1, m, second) / (2 * tau * tau);
    case Estimator::oadev:
      return mean_square(n - 2 * m + 1, stride, second) / (2 * tau * tau);
    case Estimator::mdev:
      return mean_square(n - 3 * m + 2, stride,
                         [&](std::int64_t k) {
                           Real mean = 0;
                           for (std::int64_t i = k; i < k + m; ++i) mean += second(i) / m;
                           return mean;
                         }) /
             (2 * tau * tau);
    case Estimator::tdev:
      return tau * tau / 3 * family_variance(Estimator::mdev, rate, dt, m, stride);
    case Estimator::hdev:
      return mean_square(n - 3 * m + 1, m, third) / (6 * tau * tau);
    case Estimator::ohdev:
      return mean_square(n - 3 * m + 1, stride, third) / (6 * tau * tau);
    case Estimator::totdev:
      return mean_square(n - 1, stride,
                         [&](std::int64_t k) { return reflected(k + 1 + m) - 2 * X(k + 1) + reflected(k + 1 - m); }) /
             (2 * tau * tau);
    case Estimator::mtotdev:
    case Estimator::ttotdev: {
      Real total = 0;
      std::int64_t terms = 0;
      for (std::int64_t k = 0; k + 3 * m <= n + 1; k += stride, ++terms) total += evenly_continued(x, k, m);
      const Real variance = total / terms / (2 * tau * tau);
      return estimator == Estimator::mtotdev ? variance : variance * tau * tau / 3;
    }
    case Estimator::htotdev: {
      if (m == 1) return family_variance(Estimator::ohdev, rate, dt, 1, stride);
      const Series y(rate.begin(), rate.end());
      Real total = 0;
      std::int64_t terms = 0;
      for (std::int64_t k = 0; k + 3 * m <= n; k += stride, ++terms) total += evenly_continued(y, k, m);
      return total / terms / 6;
    }
    case Estimator::theo1:
      return theo1(x, m, stride) / (tau * tau);
    case Estimator::theobr: {
      Real ratio = 0;
      const std::int64_t last = std::max<std::int64_t>(0, (n + 1) / 30 - 3);
      for (std::int64_t i = 0; i <= last; ++i) {
        ratio += family_variance(Estimator::oadev, rate, dt, 9 + 3 * i) /
                 family_variance(Estimator::theo1, rate, dt, 12 + 4 * i) / static_cast<Real>(last + 1);
      }
      return ratio * family_variance(Estimator::theo1, rate, dt, m, stride);
    }
    case Estimator::theoh:
      return 5 * m <= n ? family_variance(Estimator::oadev, rate, dt, m, stride)
                        : family_variance(Estimator::theobr, rate, dt, 4 * m / 3, stride);
    case Estimator::pdev: {
      if (m == 1) return family_variance(Estimator::oadev, rate, dt, 1, stride);
      const auto slopes = [&](std::int64_t k) {
        Real sum = 0;
        for (std::int64_t j = 0; j < m; ++j) sum += ((m - 1) / 2.0L - j) * (X(k + j) - X(k + j + m));
        return sum;
      };
      const Real M = static_cast<Real>(m);
      return 72 / (M * M * M * M * tau * tau) * mean_square(n - 2 * m + 2, stride, slopes);
    }
  }
  return 0;
}

}  // namespace gyrobudget::allan::reference

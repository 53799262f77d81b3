// SPDX-License-Identifier: MIT
#include "innovation_check.h"

#include "gyrobudget/estimation/navigation/detail/lost.h"
#include "gyrobudget/estimation/navigation/detail/runner.h"
#include "gyrobudget/estimation/navigation/detail/tried.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Vector3d;

struct Series {
  std::vector<double> times;
  std::vector<Vector3d> residuals;  ///< 0 in the rows that there are not
};

Series used(const Navigation& run, std::size_t aid) {
  Series series;
  for (const InnovationAt& at : run.innovations) {
    if (at.aid != aid || at.innovation.status != Innovation::Status::used) continue;
    series.times.push_back(at.time);
    series.residuals.emplace_back(Vector3d::Zero());
    series.residuals.back().head(at.innovation.rows) = at.innovation.residual.head(at.innovation.rows);
  }
  return series;
}

// At a lag of so many fixes.
double correlation(const Series& series, std::size_t lag) {
  double product = 0, square = 0;
  for (std::size_t k = 0; k + lag < series.residuals.size(); ++k) {
    product += series.residuals[k].dot(series.residuals[k + lag]);
    square += series.residuals[k].squaredNorm();
  }
  return square > 0 ? product / square : 0;
}

InnovationVerdict::Correlated correlated(const Series& series, int rows) {
  InnovationVerdict::Correlated result;
  double square = 0, change = 0;
  for (std::size_t k = 0; k < series.residuals.size(); ++k) {
    square += series.residuals[k].squaredNorm();
    if (k > 0) change += (series.residuals[k] - series.residuals[k - 1]).squaredNorm();
  }
  const auto n = static_cast<double>(series.residuals.size()) * rows;
  result.sigma = std::sqrt(square / n);
  result.white = std::sqrt(change / n / 2);
  const double interval = (series.times.back() - series.times.front()) / static_cast<double>(series.times.size() - 1);
  const double level = std::exp(-1);
  std::size_t lag = 1, longest = series.residuals.size() / 4;
  while (lag < longest && correlation(series, lag) > level) lag += std::max<std::size_t>(1, lag / 20);
  result.time = static_cast<double>(lag) * interval;
  return result;
}

double log_likelihood(const Scenario& scenario, const Recording& part) {
  static const detail::NisLimit limit(detail::LostWatch::kDisagrees);
  double sum = 0;
  for (const InnovationAt& at : detail::run(scenario, part).innovations) {
    const Innovation& i = at.innovation;
    if (!detail::LostWatch::watched(scenario.aids[at.aid]) || i.status == Innovation::Status::not_finite) continue;
    sum -= (std::min(i.nis, limit.of(i.rows)) + i.log_det) / 2;
  }
  return sum;
}

}  // namespace

std::vector<InnovationVerdict> innovation_verdicts(const Navigation& run) {
  constexpr std::int64_t kFewest = 100;
  constexpr double kLow = 0.5, kHigh = 2, kWhite = 0.5;
  std::vector<InnovationVerdict> list;
  for (const AidSummary& aid : run.aids) {
    const double nis = aid.nis_mean / aid.rows;
    if (aid.used < kFewest || (nis >= kLow && nis <= kHigh)) continue;
    const Series series = used(run, aid.aid);
    InnovationVerdict verdict{
        .aid = aid.aid, .nis_per_dof = nis, .correlation = correlation(series, 1), .correlated = {}};
    if (verdict.correlation > kWhite) verdict.correlated = correlated(series, aid.rows);
    list.push_back(verdict);
  }
  return list;
}

NoiseFactors noise_factors(const Scenario& scenario, const Recording& recording) {
  const Recording part = detail::beginning(scenario, recording);
  const Scenario base = detail::quick(scenario);
  std::vector<double> factors;
  for (int half = -8; half <= 12; ++half) factors.push_back(std::pow(2, half / 2.0));
  std::vector<double> of_imu(factors.size()), of_aids(factors.size());
  tbb::parallel_for(std::size_t{0}, 2 * factors.size(), [&](std::size_t i) {
    const std::size_t k = i / 2;
    Scenario changed = base;
    if (i % 2 == 0) {
      changed.sensor.gyro.white *= factors[k];
      if (changed.sensor.accelerometer) changed.sensor.accelerometer->white *= factors[k];
      of_imu[k] = log_likelihood(changed, part);
    } else {
      for (Aid& aid : changed.aids)
        if (detail::LostWatch::watched(aid)) aid.sigma_factor *= factors[k];
      of_aids[k] = log_likelihood(changed, part);
    }
  });
  const auto one = static_cast<std::size_t>(std::ranges::find(factors, 1.0) - factors.begin());
  const auto best = [&](const std::vector<double>& likelihoods) {
    const auto at = static_cast<std::size_t>(std::ranges::max_element(likelihoods) - likelihoods.begin());
    return std::pair(factors[at], likelihoods[at] - likelihoods[one]);
  };
  const auto [imu, imu_gain] = best(of_imu);
  const auto [aids, aids_gain] = best(of_aids);
  return {.imu = imu, .imu_gain = imu_gain, .aids = aids, .aids_gain = aids_gain};
}

}  // namespace gyrobudget::inline v0::navigation

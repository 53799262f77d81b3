// SPDX-License-Identifier: MIT
#include "agreement.h"

#include <algorithm>

#include "sources.h"

namespace gyrobudget::inline v0::budget {
namespace {

using Local = Eigen::Matrix<double, navigation::kCoreStates, 1>;

Local local_sigmas(const Study& study, const navigation::CoreMatrix& P) {
  const navigation::LocalSigmas s = navigation::local_sigmas(P, study.axes.C_enu);
  Local all;
  all << s.position, s.velocity, s.attitude;
  return all;
}

// A band that holds all of `count` numbers, each a sigma ratio, with 99 % or more.
navigation::Band band_of_all(double runs, int count) {
  return navigation::sigma_ratio_band(runs, 1 - (1 - kBandOfOne) / std::max(count, 1));
}

}  // namespace

Agreement agreement(const Study& study, const navigation::CoreMatrix& linear, const navigation::CoreMatrix& found,
                    double runs) {
  constexpr double kMatters = 0.01;
  const Local of_table = local_sigmas(study, linear), of_flights = local_sigmas(study, found);
  const Local total = local_sigmas(study, study.total());
  const double second = second_order(linear);
  Agreement result{.runs = runs};
  for (Eigen::Index k = 0; k < of_table.size(); ++k) {
    Agreement::Axis& axis = result.axes[static_cast<std::size_t>(k)];
    axis.linear = of_table[k];
    axis.found = of_flights[k];
    axis.of_three = of_table.segment<3>(k - k % 3).norm();
    axis.matters = std::max(axis.linear, axis.found) >= std::sqrt(kMatters) * total[k] && axis.found > 0;
    axis.first_order = axis.linear > std::sqrt(second) * axis.of_three;
  }
  return result;
}

Agreement total_agreement(const Study& study) {
  return agreement(study, study.total(), study.monte_carlo->covariance, study.monte_carlo->runs);
}

std::vector<std::optional<Agreement>> source_agreements(const Study& study) {
  std::vector<std::optional<Agreement>> list;
  for (std::size_t i = 0; i < study.monte_carlo->sources.size(); ++i) {
    auto& one = list.emplace_back();
    const auto& alone = study.monte_carlo->sources[i];
    if (!alone) continue;
    one = agreement(study, study.line(i), alone->covariance, alone->runs);
    one->random = study.budget.lines[i].name != kUncompensatedEarthRate;
  }
  return list;
}

AllRatios all_ratios(const Study& study) {
  struct Numbered {
    std::optional<std::size_t> line;
    Agreement agreement;
  };
  std::vector<Numbered> all{{std::nullopt, total_agreement(study)}};
  const auto sources = source_agreements(study);
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (sources[i]) all.push_back({i, *sources[i]});
  AllRatios result;
  const double runs = study.monte_carlo->runs;
  for (const Numbered& numbered : all) {
    const Agreement& one = numbered.agreement;
    result.compared +=
        static_cast<int>(std::ranges::count_if(one.axes, [&](const auto& a) { return one.compares(a); }));
  }
  result.band = ratio_band(study);
  result.together = band_of_all(runs, result.compared);
  for (const auto& [line, one] : all)
    for (std::size_t k = 0; k < one.axes.size(); ++k) {
      if (!one.compares(one.axes[k])) continue;
      const double ratio = one.axes[k].ratio();
      if (!result.band.holds(ratio)) ++result.outside;
      if (!result.together.holds(ratio)) result.far.push_back({line, k, ratio});
    }
  return result;
}

std::vector<Contradiction> contradictions(const Study& study) {
  constexpr double kFar = 0.1;
  constexpr int kChecks = navigation::kCoreStates + 1;  // and NEES
  const auto& mc = *study.monte_carlo;
  const Agreement total = total_agreement(study);
  const navigation::Band band = band_of_all(mc.runs, kChecks);
  std::vector<Contradiction> list;
  for (std::size_t k = 0; k < total.axes.size(); ++k) {
    const Agreement::Axis& axis = total.axes[k];
    const double upper = band.upper * std::hypot(axis.linear, axis.first_order ? 0 : kFar * axis.of_three);
    const bool above = axis.found > upper && axis.found > (1 + kFar) * axis.linear;
    const bool below =
        axis.first_order && axis.found < band.lower * axis.linear && axis.found < (1 - kFar) * axis.linear;
    if (above || below) list.push_back({k, axis.found, axis.linear});
  }
  if (mc.nees.dof == 0) return list;
  const auto right = navigation::chi_square_mean_band(mc.nees.dof, mc.runs, 1 - (1 - kBandOfOne) / kChecks);
  const double per_dof = mc.nees.mean / mc.nees.dof;
  if (!right.holds(mc.nees.mean) && std::abs(std::sqrt(per_dof) - 1) > kFar)
    list.push_back({std::nullopt, mc.nees.mean, static_cast<double>(mc.nees.dof)});
  return list;
}

navigation::Band ratio_band(const Study& study) {
  return navigation::sigma_ratio_band(study.monte_carlo->runs, kBandOfOne);
}

navigation::Band nees_band(const Study& study) {
  const auto& mc = *study.monte_carlo;
  return navigation::chi_square_mean_band(std::max(mc.nees.dof, 1), mc.runs, kBandOfOne);
}

}  // namespace gyrobudget::inline v0::budget

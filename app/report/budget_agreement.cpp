// SPDX-License-Identifier: MIT
#include "budget_agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Local = Eigen::Matrix<double, navigation::kCoreStates, 1>;

Local local_sigmas(const BudgetResult& r, const navigation::CoreMatrix& P) {
  const navigation::LocalSigmas s = navigation::local_sigmas(P, r.C_enu);
  Local all;
  all << s.position, s.velocity, s.attitude;
  return all;
}

std::string name_of(std::size_t axis) { return fmt::format("{} {}", kQuantities[axis / 3], kAxisNames[axis % 3]); }

std::string with_unit(double value, std::size_t axis) {
  constexpr std::array kUnits{"m", "m/s", "deg"};
  return fmt::format("{} {}", number(axis < 6 ? value : value / earth::kDegree, 3), kUnits[axis / 3]);
}

// A band that holds all of `count` numbers, each a sigma ratio, with 99 % or more.
navigation::Band band_of_all(double runs, int count) {
  return navigation::sigma_ratio_band(runs, 1 - (1 - kBandOfOne) / std::max(count, 1));
}

}  // namespace

Agreement agreement(const BudgetResult& r, const navigation::CoreMatrix& linear, const navigation::CoreMatrix& found,
                    double runs) {
  constexpr double kMatters = 0.01;
  const Local of_table = local_sigmas(r, linear), of_flights = local_sigmas(r, found);
  const Local total = local_sigmas(r, r.budget.total[r.at_index]);
  const double second = budget::second_order(linear);
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

Agreement total_agreement(const BudgetResult& r) {
  return agreement(r, r.budget.total[r.at_index], r.monte_carlo->covariance, r.monte_carlo->runs);
}

std::vector<std::optional<Agreement>> source_agreements(const BudgetResult& r) {
  std::vector<std::optional<Agreement>> list;
  for (std::size_t i = 0; i < r.monte_carlo->sources.size(); ++i) {
    auto& one = list.emplace_back();
    const auto& alone = r.monte_carlo->sources[i];
    if (!alone) continue;
    one = agreement(r, r.budget.lines[i].covariance[r.at_index], alone->covariance, alone->runs);
    one->random = r.budget.lines[i].name != budget::kUncompensatedEarthRate;
  }
  return list;
}

AllRatios all_ratios(const BudgetResult& r) {
  struct Named {
    std::string name;
    Agreement agreement;
  };
  std::vector<Named> all{{"total", total_agreement(r)}};
  const auto sources = source_agreements(r);
  for (std::size_t i = 0; i < sources.size(); ++i)
    if (sources[i]) all.push_back({r.budget.lines[i].name, *sources[i]});
  AllRatios result;
  const double runs = r.monte_carlo->runs;
  for (const Named& named : all) {
    const Agreement& one = named.agreement;
    result.compared +=
        static_cast<int>(std::ranges::count_if(one.axes, [&](const auto& a) { return one.compares(a); }));
  }
  result.band = navigation::sigma_ratio_band(runs, kBandOfOne);
  result.together = band_of_all(runs, result.compared);
  for (const auto& [name, one] : all)
    for (std::size_t k = 0; k < one.axes.size(); ++k) {
      if (!one.compares(one.axes[k])) continue;
      if (!result.band.holds(one.axes[k].ratio())) ++result.outside;
      if (!result.together.holds(one.axes[k].ratio()))
        result.far.push_back(fmt::format("{}, {} {}", name, name_of(k), number(one.axes[k].ratio(), 3)));
    }
  return result;
}

std::vector<std::string> contradictions(const BudgetResult& r) {
  constexpr double kFar = 0.1;
  constexpr int kChecks = navigation::kCoreStates + 1;  // and NEES
  const auto& mc = *r.monte_carlo;
  const Agreement total = total_agreement(r);
  const navigation::Band band = band_of_all(mc.runs, kChecks);
  std::vector<std::string> list;
  for (std::size_t k = 0; k < total.axes.size(); ++k) {
    const Agreement::Axis& axis = total.axes[k];
    const double upper = band.upper * std::hypot(axis.linear, axis.first_order ? 0 : kFar * axis.of_three);
    const bool above = axis.found > upper && axis.found > (1 + kFar) * axis.linear;
    const bool below =
        axis.first_order && axis.found < band.lower * axis.linear && axis.found < (1 - kFar) * axis.linear;
    if (above || below)
      list.push_back(fmt::format("{}: {} where the covariance has {}", name_of(k), with_unit(axis.found, k),
                                 with_unit(axis.linear, k)));
  }
  if (mc.nees.dof == 0) return list;
  const auto right = navigation::chi_square_mean_band(mc.nees.dof, mc.runs, 1 - (1 - kBandOfOne) / kChecks);
  const double per_dof = mc.nees.mean / mc.nees.dof;
  if (!right.holds(mc.nees.mean) && std::abs(std::sqrt(per_dof) - 1) > kFar)
    list.push_back(fmt::format("NEES: {} where a right covariance gives {}", number(mc.nees.mean, 3), mc.nees.dof));
  return list;
}

std::string direction_text(const budget::MonteCarlo::Nees::LeftOut& direction) {
  constexpr double kPart = 0.3;  // smaller weights are not named
  std::vector<std::size_t> order(navigation::kCoreStates);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto weight = [&](std::size_t k) { return direction.weights[static_cast<Eigen::Index>(k)]; };
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t k) { return std::abs(weight(k)); });
  std::string text;
  for (const std::size_t k : order)
    if (std::abs(weight(k)) >= kPart)
      text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", name_of(k), weight(k));
  return text;
}

}  // namespace gyrobudget::inline v0::report

// SPDX-License-Identifier: MIT
#include "planned_fix.h"

#include "gyrobudget/estimation/navigation/detail/check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

using detail::require;
using Eigen::Vector3d;

constexpr double kMostFixes = 1e6;

}  // namespace

int aid_of(const PlannedFix& planned) {
  return std::visit([](const auto& fix) { return fix.aid; }, planned.fix);
}

Measurement linearise(const PlannedFix& planned, const earth::Motion& truth, const ErrorStateModel& model) {
  constexpr std::array<double, kMaxErrorTerms> zeros{};
  const Estimate estimate{.motion = truth, .model = &model, .terms = zeros.data()};
  return std::visit([&](const auto& fix) { return measure(fix, estimate); }, planned.fix);
}

StartFromFix start_from(const PlannedFix& planned, const earth::Motion& truth, const ErrorStateModel& model) {
  if (std::holds_alternative<HeightFix>(planned.fix))
    throw std::invalid_argument("a fix of height gives no start: position, velocity or attitude does");
  const int first = std::holds_alternative<PositionFix>(planned.fix)   ? kPosition
                    : std::holds_alternative<VelocityFix>(planned.fix) ? kVelocity
                                                                       : kAttitude;
  const Measurement rows = linearise(planned, truth, model);
  StartFromFix start;
  start.by_terms.setZero(kCoreStates, static_cast<Eigen::Index>(model.terms.size()));
  for (const MeasurementRow& row : rows.row) {  // of a residual that the start makes zero
    const Vector3d axis = row.h.segment<3>(first);
    start.by_terms.middleRows<3>(first) -= axis * row.h.tail(start.by_terms.cols()).transpose();
    if (first != kAttitude) start.by_attitude.middleRows<3>(first) -= axis * row.h.segment<3>(kAttitude).transpose();
    start.white.block<3, 3>(first, first) += row.variance * axis * axis.transpose();
  }
  return start;
}

std::vector<double> fix_times(const FixPlan& plan) {
  require(plan.interval > 0 && std::isfinite(plan.interval), "interval of fixes [s]", plan.interval, "above 0");
  require(plan.last - plan.first <= kMostFixes * plan.interval, "number of fixes",
          (plan.last - plan.first) / plan.interval, fmt::format("at most {:g}", kMostFixes));
  std::vector<double> times;
  for (std::size_t k = 0;; ++k) {
    const double t = plan.first + static_cast<double>(k) * plan.interval;
    if (!(t <= plan.last + 1e-9 * plan.interval)) break;
    const bool out = std::any_of(plan.outages.begin(), plan.outages.end(),
                                 [t](const auto& outage) { return t >= outage.first && t <= outage.second; });
    if (!out) times.push_back(std::min(t, plan.last));
  }
  return times;
}

}  // namespace gyrobudget::inline v0::navigation

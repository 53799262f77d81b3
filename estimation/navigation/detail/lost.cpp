// SPDX-License-Identifier: MIT
#include "lost.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::navigation::detail {
namespace {

constexpr int kGoodAgain = 3;  // fixes in a row that agree, before one of them is a good one

}  // namespace

LostWatch::LostWatch(const Scenario& scenario, double start) : scenario_(scenario), aids_(scenario.aids.size()) {
  forget(start);
}

void LostWatch::forget(double time) {
  for (Watched& aid : aids_) {
    aid = {};
    aid.last_good = time;
  }
}

std::optional<Refused::Kind> LostWatch::watched(const Aid& aid) {
  switch (aid.kind) {
    case Aid::Kind::position:
      return Refused::Kind::position;
    case Aid::Kind::velocity:
      return Refused::Kind::velocity;
    case Aid::Kind::height:
      return Refused::Kind::height;
    case Aid::Kind::attitude:
    case Aid::Kind::rest:
      break;
  }
  return std::nullopt;
}

bool LostWatch::saw(std::size_t number, double time, const Innovation& innovation) {
  if (!watched(scenario_.aids[number]) || innovation.status == Innovation::Status::not_finite) return false;
  Watched& aid = aids_[number];
  const bool disagrees = innovation.status == Innovation::Status::gated || limit_.passed(innovation);
  const auto place = static_cast<std::size_t>(aid.seen++ % kWindow);
  aid.disagreed[place] = disagrees;
  aid.residuals[place].setZero();
  if (!disagrees)
    aid.residuals[place].head(innovation.rows) =
        innovation.residual.head(innovation.rows).cwiseQuotient(innovation.sigma.head(innovation.rows));
  aid.agreed_in_row = disagrees ? 0 : aid.agreed_in_row + 1;
  if (aid.agreed_in_row >= kGoodAgain) aid.last_good = time;
  return disagrees;
}

std::optional<std::string> LostWatch::lost() const {
  for (std::size_t i = 0; i < aids_.size(); ++i) {
    const Watched& aid = aids_[i];
    const std::string& name = scenario_.aids[i].name;
    if (static_cast<int>(aid.disagreed.count()) >= kMany)
      return fmt::format("{} of the last {} fixes of {} disagree with the filter", aid.disagreed.count(),
                         std::min<std::int64_t>(aid.seen, kWindow), name);
    if (aid.seen < kWindow) continue;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& residual : aid.residuals) mean += residual / kWindow;
    Eigen::Index worst = 0;
    if (mean.cwiseAbs().maxCoeff(&worst) > kOneSided)
      return fmt::format("the last {} fixes of {} pull one way: their mean is {:.2g} sigma of what the filter expects",
                         kWindow, name, std::abs(mean[worst]));
  }
  return std::nullopt;
}

}  // namespace gyrobudget::inline v0::navigation::detail

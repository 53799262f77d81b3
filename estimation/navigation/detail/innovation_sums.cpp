// SPDX-License-Identifier: MIT
#include "innovation_sums.h"

#include "gyrobudget/estimation/navigation/consistency.h"

#include <boost/math/distributions/chi_squared.hpp>

namespace gyrobudget::inline v0::navigation::detail {

InnovationSums::InnovationSums(const Scenario& scenario, std::vector<AidSummary>& summaries) : summaries_(summaries) {
  constexpr double kInside = 0.95;
  for (std::size_t i = 0; i < scenario.aids.size(); ++i) {
    place_.push_back(summaries.size());
    if (!scenario.aids[i].used) continue;
    AidSummary s;
    s.aid = i;
    s.rows = rows(scenario.aids[i].kind);
    summaries.push_back(s);
    limit_.push_back(quantile(boost::math::chi_squared(s.rows), kInside));
  }
}

void InnovationSums::add(const InnovationAt& at) {
  AidSummary& s = of(at.aid);
  const Innovation& i = at.innovation;
  if (i.status == Innovation::Status::not_finite) {
    ++s.not_finite;
    return;
  }
  s.inside_95 += i.nis <= limit_[place_[at.aid]] ? 1 : 0;
  if (i.status == Innovation::Status::gated) {
    ++s.gated;
    return;
  }
  ++s.used;
  s.nis_mean += i.nis;
  s.residual_mean += i.residual;
  s.residual_rms += i.residual.cwiseAbs2();
}

void InnovationSums::finish() {
  for (AidSummary& s : summaries_) {
    const auto used = static_cast<double>(s.used);
    if (s.used + s.gated > 0) s.inside_95 /= static_cast<double>(s.used + s.gated);
    if (s.used == 0) continue;
    s.nis_mean /= used;
    const Band band = chi_square_mean_band(s.rows, used);
    s.nis_low = band.lower;
    s.nis_high = band.upper;
    s.residual_mean /= used;
    s.residual_rms = (s.residual_rms / used).cwiseSqrt();
  }
}

}  // namespace gyrobudget::inline v0::navigation::detail

// SPDX-License-Identifier: MIT
#include "profile.h"

#include <boost/math/tools/roots.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace gyrobudget::inline v0::fit {
namespace {

constexpr unsigned kRootBits = 38;  // limits to about 1e-11 of their bracket
constexpr int kMostDoublings = 80;

// One end of a search: a value and its test.
struct End {
  double v = 0;
  double test = 0;
};

// The v between `inside` (T <= cut) and `outside` (T > cut) with T(v) = cut. The root of T is nearly linear in v.
double solve_cut(const HeldTest& test, double cut, End inside, End outside) {
  const auto excess = [&](double t) {  // of an infinite test only the sign matters
    return std::sqrt(std::isfinite(t) ? t : 4 * cut + 1) - std::sqrt(cut);
  };
  // Data at the edge of rounding may leave no bracket; the outer end is then the safe answer.
  const double at_inside = excess(inside.test), at_outside = excess(outside.test);
  if (!(at_inside < 0 && at_outside > 0) || !std::isfinite(outside.v) || inside.v == outside.v) return outside.v;
  const bool rising = outside.v > inside.v;
  std::uintmax_t budget = 40;
  const auto bracket = boost::math::tools::toms748_solve(
      [&](double v) { return excess(test(v)); }, std::min(inside.v, outside.v), std::max(inside.v, outside.v),
      rising ? at_inside : at_outside, rising ? at_outside : at_inside,
      boost::math::tools::eps_tolerance<double>(kRootBits), budget);
  return 0.5 * (bracket.first + bracket.second);
}

}  // namespace

ProfileInterval profile_interval(const HeldTest& test, double estimate, double standard_deviation, double cut) {
  const double step = 1.2 * std::sqrt(cut) * standard_deviation;
  ProfileInterval interval;

  End inside{estimate, 0}, outside{estimate - step, 0};
  for (int i = 0; i < kMostDoublings && estimate > 0; ++i) {
    outside.v = std::max(outside.v, 0.0);
    outside.test = test(outside.v);
    if (outside.test > cut) {
      interval.lower = solve_cut(test, cut, inside, outside);
      break;
    }
    if (outside.v == 0) break;  // the interval reaches zero
    inside = outside;
    outside.v = estimate - 2 * (estimate - outside.v);
  }

  inside = {estimate, estimate > 0 ? 0 : test(0)};
  outside.v = estimate + step;
  for (int i = 0; i < kMostDoublings; ++i) {
    outside.test = test(outside.v);
    if (outside.test > cut) {
      interval.upper = solve_cut(test, cut, inside, outside);
      return interval;
    }
    inside = outside;
    outside.v = estimate + 2 * (outside.v - estimate);
  }
  interval.upper = std::numeric_limits<double>::infinity();  // too few degrees of freedom to exclude anything
  return interval;
}

}  // namespace gyrobudget::inline v0::fit

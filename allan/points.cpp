// SPDX-License-Identifier: MIT
#include "points.h"

#include <cmath>

#include "statistics.h"

namespace gyrobudget::inline v0::allan {

std::vector<DeviationPoint> deviation_points(const Curve& curve, std::span<const Identified> identified,
                                             std::span<const noise::Process> mix) {
  std::vector<Identified> types(identified.begin(), identified.end());
  types.resize(curve.points.size());  // white noise where nothing is known
  const auto known_points = mix.empty() ? statistics(curve, types) : statistics(curve, mix);
  std::vector<DeviationPoint> points;
  for (std::size_t i = 0; i < curve.points.size(); ++i) {
    const Point& p = curve.points[i];
    const PointStatistics& known = known_points[i];
    if (p.terms < 1 || !std::isfinite(p.variance)) continue;
    points.push_back({.m = p.m,
                      .tau_s = curve.tau(i),
                      .deviation = std::sqrt(known.variance),
                      .lower = std::sqrt(known.interval.lower),
                      .upper = std::sqrt(known.interval.upper),
                      .edf = known.edf,
                      .terms = p.terms,
                      .alpha = types[i].alpha,
                      .stride = p.stride,
                      .bias = known.bias});
  }
  return points;
}

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "lookup_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {

LookupTable LookupTable::linear(std::initializer_list<Point> points) { return {std::vector<Point>(points), false}; }
LookupTable LookupTable::linear(std::vector<Point> points) { return {std::move(points), false}; }
LookupTable LookupTable::smooth(std::initializer_list<Point> points) { return {std::vector<Point>(points), true}; }
LookupTable LookupTable::smooth(std::vector<Point> points) { return {std::move(points), true}; }

LookupTable::LookupTable(std::vector<Point> points, bool smooth) : points_(std::move(points)), smooth_(smooth) {
  if (points_.empty()) throw std::invalid_argument("a table needs at least one point");
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (!std::isfinite(points_[k].first) || !std::isfinite(points_[k].second))
      throw std::invalid_argument(
          fmt::format("point {} of the table, ({}, {}), must be finite", k, points_[k].first, points_[k].second));
    if (k > 0 && !(points_[k].first > points_[k - 1].first))
      throw std::invalid_argument(
          fmt::format("the table's abscissae must ascend, but {} follows {}", points_[k].first, points_[k - 1].first));
  }
  join(smooth_ ? slopes() : std::vector<double>());
}

/// Slopes of the spline at the points: h' s[k-1] + 2 (h + h') s[k] + h s[k+1] = 3 (h' D + h D'), D the slopes
/// of the chords before and after, h and h' their lengths; zero at both ends. Solved by elimination.
std::vector<double> LookupTable::slopes() const {
  const std::size_t n = points_.size();
  std::vector<double> slope(n, 0.0), above(n, 0.0);
  for (std::size_t k = 1; k + 1 < n; ++k) {
    const double h = points_[k].first - points_[k - 1].first;
    const double h_next = points_[k + 1].first - points_[k].first;
    const double chord = (points_[k].second - points_[k - 1].second) / h;
    const double chord_next = (points_[k + 1].second - points_[k].second) / h_next;
    const double pivot = 2 * (h + h_next) - h_next * above[k - 1];
    above[k] = h / pivot;
    slope[k] = (3 * (h_next * chord + h * chord_next) - h_next * slope[k - 1]) / pivot;
  }
  for (std::size_t k = n - 1; k-- > 1;) slope[k] -= above[k] * slope[k + 1];
  return slope;
}

void LookupTable::join(const std::vector<double>& slopes) {
  pieces_.push_back({points_.front().first, points_.front().second, 0, 0, 0, 0});
  for (std::size_t k = 0; k + 1 < points_.size(); ++k) {
    const auto [x, y] = points_[k];
    const double h = points_[k + 1].first - x;
    const double chord = (points_[k + 1].second - y) / h;
    Piece piece{x, y, chord, 0, 0, 0};
    if (smooth_) {
      piece.b = slopes[k];
      piece.c = (3 * chord - 2 * slopes[k] - slopes[k + 1]) / h;
      piece.d = (slopes[k] + slopes[k + 1] - 2 * chord) / (h * h);
    }
    piece.sum = integral(x, k);
    if (!std::isfinite(piece.b + piece.c + piece.d + piece.sum))
      throw std::invalid_argument(fmt::format("the table is too steep from {} to {}", x, points_[k + 1].first));
    pieces_.push_back(piece);
  }
  const double end = points_.back().first;
  const double sum = integral(end, pieces_.size() - 1);
  pieces_.push_back({end, points_.back().second, 0, 0, 0, sum});
}

LookupTable LookupTable::scaled(double factor) const {
  std::vector<Point> points = points_;
  for (Point& point : points) point.second *= factor;
  return {std::move(points), smooth_};
}

LookupTable LookupTable::shifted(double offset) const {
  std::vector<Point> points = points_;
  for (Point& point : points) point.second += offset;
  return {std::move(points), smooth_};
}

std::pair<double, double> LookupTable::range() const {
  const auto by_value = [](const Point& a, const Point& b) { return a.second < b.second; };
  const auto at_points = std::minmax_element(points_.begin(), points_.end(), by_value);
  std::pair<double, double> range{at_points.first->second, at_points.second->second};
  if (!smooth_) return range;
  for (std::size_t k = 1; k < points_.size(); ++k) {
    const Piece& p = pieces_[k];  // its slope, b + 2 c x + 3 d x^2, has two zeros or none
    const double discriminant = p.c * p.c - 3 * p.b * p.d;
    if (!(discriminant >= 0)) continue;
    const double q = -p.c - std::copysign(std::sqrt(discriminant), p.c);
    for (const double x : {q / (3 * p.d), p.b / q}) {
      if (!(x > 0 && x < points_[k].first - p.from)) continue;
      const double value = at(p.from + x, k).value;
      range = {std::min(range.first, value), std::max(range.second, value)};
    }
  }
  return range;
}

}  // namespace gyrobudget::inline v0::flight

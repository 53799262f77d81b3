// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <initializer_list>
#include <string_view>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::flight {

/// A function of one variable through given points; beyond them it keeps their outermost values.
///   linear  straight between the points: only continuous. An integrator has to stop at the points.
///   smooth  cubic spline with horizontal ends (de Boor, A Practical Guide to Splines, 2001, chapter IV):
///           twice continuously differentiable between its ends, once at them. It passes through every point
///           and may swing over between them, as any such spline.
///
///   const auto drag = flight::LookupTable::smooth({{0, 0.30}, {0.95, 0.42}, {1.2, 0.55}, {5, 0.25}});
class LookupTable {
 public:
  using Point = std::pair<double, double>;

  /// The same value everywhere.
  LookupTable(double constant = 0) : LookupTable(linear({{0, constant}})) {}
  /// @throws std::invalid_argument for no points, abscissae not ascending or too near each other, numbers
  /// that are not finite.
  [[nodiscard]] static LookupTable linear(std::initializer_list<Point> points);
  [[nodiscard]] static LookupTable linear(std::vector<Point> points);
  [[nodiscard]] static LookupTable smooth(std::initializer_list<Point> points);
  [[nodiscard]] static LookupTable smooth(std::vector<Point> points);

  /// Value and derivatives.
  struct Jet {
    double value;
    double first;
    double second;
  };

  [[nodiscard]] double operator()(double x) const { return at(x, piece(x)).value; }
  [[nodiscard]] Jet at(double x) const { return at(x, piece(x)); }

  /// The piece that x is on, from its first point on: 0 is before the first point, size() from the last on.
  [[nodiscard]] std::size_t piece(double x) const {
    std::size_t k = 0;
    while (k < points_.size() && x >= points_[k].first) ++k;  // few points: faster than halving
    return k;
  }
  /// The polynomial of that piece, also beyond its ends: for whoever stays on one piece over a step.
  [[nodiscard]] Jet at(double x, std::size_t piece) const {
    const Piece& c = pieces_[piece];
    const double d = x - c.from;
    return {c.a + d * (c.b + d * (c.c + d * c.d)), c.b + d * (2 * c.c + 3 * d * c.d), 2 * c.c + 6 * d * c.d};
  }
  /// Integral from the first point to x, exact.
  [[nodiscard]] double integral(double x) const { return integral(x, piece(x)); }
  [[nodiscard]] double integral(double x, std::size_t piece) const {
    const Piece& c = pieces_[piece];
    const double d = x - c.from;
    return c.sum + d * (c.a + d * (c.b / 2 + d * (c.c / 3 + d * c.d / 4)));
  }

  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  /// Every value times this.
  [[nodiscard]] LookupTable scaled(double factor) const;
  /// Every value plus this.
  [[nodiscard]] LookupTable shifted(double offset) const;
  /// Least and greatest value, of a smooth table also between its points.
  [[nodiscard]] std::pair<double, double> range() const;

 private:
  struct Piece {
    double from, a, b, c, d;  ///< a + b x + c x^2 + d x^3 with x counted from `from`
    double sum;               ///< integral up to `from`
  };
  LookupTable(std::vector<Point> points, bool smooth);
  void join(const std::vector<double>& slopes);
  [[nodiscard]] std::vector<double> slopes() const;

  std::vector<Point> points_;
  std::vector<Piece> pieces_;
  bool smooth_;
};

}  // namespace gyrobudget::inline v0::flight

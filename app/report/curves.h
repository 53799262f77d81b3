// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "result.h"

// What a picture of an axis shows beside the measured points; drawn by gnuplot and by the page alike. All SI.
namespace gyrobudget::inline v0::report {

/// Flat part of the Allan deviation of flicker noise over B: sqrt(2 ln 2/pi).
inline constexpr double kFlickerFloor = 0.66428247;

/// Deviation of one term of the model over AxisCurves::tau_s.
struct TermCurve {
  noise::Term term = noise::Term::white;
  bool limit = false;  ///< drawn at the 95 % upper limit of a term that is only bounded
  double coefficient = 0;
  std::vector<double> deviation;
};

/// A point of the plot with a name: where a coefficient is read, or the raw minimum.
struct Mark {
  std::string name;  ///< "N", "B", "K", "Q", "R", "G", "S" or "min"
  double tau_s = 0;
  double deviation = 0;
  std::string text;  ///< how the point gives the number, in datasheet units
};

struct AxisCurves {
  std::vector<double> tau_s;
  std::vector<double> model;  ///< the sum of the fitted terms; empty without a fit
  std::vector<TermCurve> terms;
  std::vector<Mark> marks;
  double tau_low_s = 0, tau_high_s = 0;          ///< range worth showing
  double deviation_low = 0, deviation_high = 0;  ///< range worth showing, term lines clipped
};

/// "angle random walk: N = 0.150 deg/sqrt(h)"; "<" for a limit.
[[nodiscard]] std::string term_text(noise::Signal, const TermCurve&, std::string_view unit);

/// Curves on about a dozen taus a decade from the first to the last measured point.
[[nodiscard]] AxisCurves axis_curves(const AxisResult&, double rate_hz);

/// At most `limit` of the points, evenly spread in log tau, the first and the last always among them.
[[nodiscard]] std::vector<allan::DeviationPoint> thinned(const std::vector<allan::DeviationPoint>&, std::size_t limit);

}  // namespace gyrobudget::inline v0::report

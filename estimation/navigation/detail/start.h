// SPDX-License-Identifier: MIT
// Inside navigation: from a scene's alignment to the filter's start.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

#include <variant>

#include "fix_track.h"

namespace gyrobudget::inline v0::navigation::detail {

/// Why there is no start.
struct NoStart {
  Navigation::Status status;
  std::string why;
};

/// When, at the earliest, a filter can start: all aids that the alignment needs have a fix, and what aligns
/// itself has stood. Which part of the log that takes.
[[nodiscard]] std::variant<NoStart, Span> start_span(const Scenario&, const ImuLog&, const std::vector<FixTrack>&,
                                                     std::int64_t origin);

struct Start {
  AlignmentResult result;
  StateMatrix P0;  ///< of the model's states at span.to
  /// By the aid's number, the time up to which its fixes are in the start: each is used once.
  std::vector<double> used_to;
};

/// State and covariance at span.to. `terms` is the covariance of the model's terms at span.from.
///
/// All that is one error enters as one. What the IMU aligned itself by is the mean of its errors over the span, with
/// which the terms at its end are correlated: levelled by an accelerometer of bias b, the body is off level by b/g just
/// so that this accelerometer sees none of it; a bias that has walked meanwhile, by as much of it as the mean has seen.
/// A start that is taken from an aid has that aid's errors, and where a lever arm leads to its antenna those of the
/// attitude. Of an aid that is not used, and where the scene gives a sigma beside it, only sigmas count.
[[nodiscard]] std::variant<NoStart, Start> start(const Scenario&, const Recording&, const std::vector<FixTrack>&,
                                                 const Span&, const ErrorStateModel&, const StateMatrix& terms);

}  // namespace gyrobudget::inline v0::navigation::detail

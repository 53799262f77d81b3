// SPDX-License-Identifier: MIT
// Inside navigation: filters that start again from fixes which the filter of the run refuses.
//
// What went wrong is not known, so several filters run side by side, each a copy of the refused one with more
// uncertainty of one kind. With r the refused residual, of a position or a height,
//   position             dp + w, w of sigma 2 |r|
//   position, velocity   beside it dv + u, u of sigma 3 |r|/T, at most kFastest; T the time since the last good fix
//   all by a factor      P s^2, s^2 = NIS/rows of the refused fix: all that made the drift was larger than thought
//   attitude too         as the second, beside it 5 deg of level and 40 deg of heading, and sensor errors times 5
// and of a velocity, u of sigma 2 |r| and w of sigma |r| T. A first update by the refused fix makes w and u what the
// fix tells. Each then sees every fix. One that a fix of position, velocity or height contradicts (NIS beyond the
// point of kContradicted) is given up; of those that are left the likeliest is the answer,
//   ln L = -1/2 sum (NIS + ln det S),
// where ln det S charges each for what it left open: the least that explains the fixes prevails.
#pragma once

#include "gyrobudget/estimation/navigation/filter.h"

#include <array>
#include <memory>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::navigation::detail {

inline constexpr double kContradicted = 1e-4;  ///< chance that a right fix ends a right trial

struct Trial {
  Filter filter;
  std::unique_ptr<FilterHistory> record;  ///< of it, where the run is smoothed
  std::string_view what;                  ///< that was started again, in words
  double log_likelihood = 0;
};

/// What a fix that was refused is of, and since when none was good.
struct Refused {
  enum class Kind { position, velocity, height };
  Kind kind = Kind::position;
  Innovation innovation;
  double since = 0;  ///< [s], above 0
};

/// Copies of `lost`, widened; the refused fix is for use() still. `recorded` gives each a record of its own.
[[nodiscard]] std::vector<Trial> trials(const Filter& lost, const Refused& refused, bool recorded);

/// The NIS that a right fix passes with a chance of `false_alarm`.
class NisLimit {
 public:
  explicit NisLimit(double false_alarm);
  [[nodiscard]] double of(int rows) const { return limit_[static_cast<std::size_t>(rows)]; }
  [[nodiscard]] bool passed(const Innovation& innovation) const {
    return !(innovation.nis <= limit_[static_cast<std::size_t>(innovation.rows)]);
  }

 private:
  std::array<double, 4> limit_{};  ///< by number of rows
};

}  // namespace gyrobudget::inline v0::navigation::detail

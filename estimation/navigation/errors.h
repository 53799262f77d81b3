// SPDX-License-Identifier: MIT
// What a caller of navigation, budget and closed loop may want to catch by its name. All of these derive from
// std::invalid_argument; what throws that type itself, such as matrices of sizes that do not fit, is a mistake in the
// calling program and is not to be caught as if it were an answer.
#pragma once

#include <stdexcept>

namespace gyrobudget::inline v0::navigation {

/// A number that a scene, a filter or a budget is set up with is out of its range, or several numbers, each of which
/// may be, cannot be together. The message has the value, the limit and the unit.
class SetupError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// What was recorded cannot be used as it is: times that do not ascend, lists whose lengths do not fit.
class RecordingError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// The estimate or its covariance has grown beyond all numbers. A position that has left the field of Earth is
/// earth::OutsideDomain instead.
class Diverged : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

}  // namespace gyrobudget::inline v0::navigation

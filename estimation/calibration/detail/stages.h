// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/calibration/calibrate.h"

#include <exception>
#include <functional>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::calibration::detail {

/// Told of each stage of each axis as it begins, from several threads at once. What it throws is taken for an error of
/// that stage: tests put faults there.
using Observer = std::function<void(Stage stage, const std::string& axis)>;

/// The stages of one axis: an error in one becomes a fault, and the others go on.
class Stages {
 public:
  /// Refers to all three.
  Stages(const std::string& axis, const Observer& observer, std::vector<Fault>& faults)
      : axis_(axis), observer_(observer), faults_(faults) {}

  /// From here on errors are of this stage.
  void enter(Stage stage) {
    current_ = stage;
    if (observer_) observer_(stage, axis_);
  }

  /// Does a part of the job, which may enter further stages. Every error is caught here, whatever its kind, and named
  /// by its stage: it is shown as a fault and never becomes a number. Only memory that runs out is not the axis' own.
  /// @return the error, null where there was none
  template <class Work>
  std::exception_ptr attempt(Stage stage, Work&& work) {
    try {
      enter(stage);
      std::forward<Work>(work)();
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const Unusable& error) {
      faults_.push_back({current_, error.what(), error.reason});
      return std::current_exception();
    } catch (const std::exception& error) {
      faults_.push_back({current_, error.what(), {}});
      return std::current_exception();
    }
    return nullptr;
  }

 private:
  const std::string& axis_;
  const Observer& observer_;
  std::vector<Fault>& faults_;
  Stage current_ = Stage::screening;
};

/// calibrate() with an observer.
[[nodiscard]] Datasheet calibrate(const allan::Record& record, const Options& options, const Observer& observer);

}  // namespace gyrobudget::inline v0::calibration::detail

// SPDX-License-Identifier: MIT
// Inside navigation: the innovations of each aid in sum.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

#include <vector>

namespace gyrobudget::inline v0::navigation::detail {

/// Fills the summaries of the aids that a scene uses; these must outlive it.
class InnovationSums {
 public:
  InnovationSums(const Scenario& scenario, std::vector<AidSummary>& summaries);

  /// Of an aid that is used.
  [[nodiscard]] AidSummary& of(std::size_t aid) { return summaries_[place_[aid]]; }
  void add(const InnovationAt& at);
  /// From sums to means.
  void finish();

 private:
  std::vector<AidSummary>& summaries_;
  std::vector<std::size_t> place_;
  std::vector<double> limit_;
};

}  // namespace gyrobudget::inline v0::navigation::detail

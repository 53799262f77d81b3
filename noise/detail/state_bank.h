// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "normal_kernel.h"

namespace gyrobudget::inline v0::noise::detail {

/// First-order states x_i <- phi_i x_i + step_i u_i side by side. They are added up in four virtual lanes, so
/// that every target gives the same bytes.
class StateBank {
 public:
  static constexpr std::size_t kLanes = 4;

  void add(double phi, double step, double start);
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] double sum() const;
  /// The sum of the states before each of sums.size() steps. Number k * stride + i of `drive` is u_i of step k;
  /// reads, to no effect, up to kLanes - 1 numbers beyond those of the last step.
  void run(Target, std::span<const double> drive, std::size_t stride, std::span<double> sums);

 private:
  std::size_t size_ = 0;
  std::vector<double> phi_, step_, state_;  ///< filled up with zeros to a multiple of kLanes
};

}  // namespace gyrobudget::inline v0::noise::detail

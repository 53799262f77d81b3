// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <vector>

namespace gyrobudget::inline v0::noise::detail {

/// Low pass of the signal whose increments over samples these are, exact where its rate is constant over each
/// sample:
///   first order    x' = w (u - x),                    w = 2 pi bandwidth
///   second order   x'' = w^2 (u - x) - sqrt(2) w x'   (Butterworth)
/// At rest at the first increment.
class LowPass {
 public:
  /// @throws std::invalid_argument for an order other than 1 and 2, a bandwidth that is not positive and
  /// finite.
  LowPass(double bandwidth, int order, double dt);
  [[nodiscard]] double next(double increment);

 private:
  [[nodiscard]] double next_first_order(double increment);
  [[nodiscard]] double next_second_order(double increment);

  int order_;
  double a_;                      ///< w dt, of order 2 over sqrt 2
  double decay_, cosine_, sine_;  ///< exp(-a); of order 2 times cos a, sin a
  double mean_;                   ///< of exp(-w t) over a sample, order 1
  double value_ = 0, speed_ = 0;  ///< x dt and, of order 2, x' dt sqrt(2)/w
  bool started_ = false;
};

/// The signal some time ago, by its increments over samples: those of a fraction of a sample are shared out.
class Delay {
 public:
  /// @throws std::invalid_argument for a delay that is negative or longer than 1e7 samples.
  Delay(double delay, double dt);
  [[nodiscard]] double next(double increment);

 private:
  double fraction_;
  std::vector<double> past_;  ///< a ring of the last increments
  std::size_t at_ = 0;
  bool started_ = false;
};

}  // namespace gyrobudget::inline v0::noise::detail

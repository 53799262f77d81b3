// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/front_end.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace gyrobudget::inline v0::noise::detail {

/// Low pass of the signal whose increments over samples these are, exact where its rate is constant over each
/// sample:
///   first order    x' = w (u - x),                    w = 2 pi bandwidth
///   second order   x'' = w^2 (u - x) - sqrt(2) w x'   (Butterworth)
///   moving average over 0.442946/bandwidth, of the samples
/// At rest at the first increment.
class LowPass {
 public:
  /// @throws std::invalid_argument for a bandwidth that is not positive and finite, of a moving average one below
  /// 5e-8/dt, and a value that is no Kind.
  LowPass(FrontEnd::Kind kind, double bandwidth, double dt);
  [[nodiscard]] double next(double increment);

 private:
  [[nodiscard]] double next_first_order(double increment);
  [[nodiscard]] double next_second_order(double increment);

  FrontEnd::Kind kind_;
  double a_ = 0;                              ///< w dt, of order 2 over sqrt 2
  double decay_ = 0, cosine_ = 0, sine_ = 0;  ///< exp(-a); of order 2 times cos a, sin a
  double mean_ = 0;                           ///< of exp(-w t) over a sample, order 1
  std::optional<MovingAverage> average_;
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

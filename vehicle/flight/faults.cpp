// SPDX-License-Identifier: MIT
#include "faults.h"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {

std::size_t check(const NavigatorFaults& faults, double period) {
  constexpr double kMostPeriods = 1e6;
  if (faults.dead_gyro && (*faults.dead_gyro < 0 || *faults.dead_gyro > 2))
    throw SetupError(fmt::format("dead gyro is axis {}, expected 0 to 2", *faults.dead_gyro));
  if (std::isnan(faults.dead_gyro_at)) throw SetupError("time of the dead gyro is not a number");
  const double periods = std::round(faults.delay / period);
  if (!(periods >= 0 && periods <= kMostPeriods))
    throw SetupError(fmt::format("delay of navigation is {} s, expected 0 to {} periods of {} s", faults.delay,
                                 kMostPeriods, period));
  return static_cast<std::size_t>(periods);
}

}  // namespace gyrobudget::inline v0::flight

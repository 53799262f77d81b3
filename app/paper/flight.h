// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/paper.h"
#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <vector>

namespace gyrobudget::inline v0::paper {

/// The paper's two gyros, as its model 3 makes them: white noise and a random walk of the rate.
struct PaperGyros {
  noise::ErrorModel ifog, mems;
};

struct PaperFlightStudy {
  report::PaperFlight flight;
  std::vector<report::PaperRow> rows;  ///< fig8, fig9, fig10
};

/// Flies the first stage in closed loop with each gyro, many times, and again for each hypothesis about the paper's
/// distances. Nothing is fitted to these: where a size is looked for that gives them, it is told as what it takes.
[[nodiscard]] PaperFlightStudy paper_flight(const PaperGyros&, std::uint64_t seed);

}  // namespace gyrobudget::inline v0::paper

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/paper.h"

#include <cstdint>

namespace gyrobudget::inline v0::paper {

/// Simulates what the paper simulated and reads it as the paper did: four records of 10 h at 100 Hz, 1000 angles over
/// 1 h for each of two sensors, and 200 shorter records of each kind for the scatter of a reading; then flies it
/// (paper_flight.h).
[[nodiscard]] report::Paper paper_study(std::uint64_t seed);

}  // namespace gyrobudget::inline v0::paper

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/paper.h"

#include <cstdint>
#include <vector>

#include "setting.h"

namespace gyrobudget::inline v0::paper {

/// What could have made the paper's distances: what each supposition gives, by flights, and how much of it the
/// published distances take. `reference` is along the prompt plan.
[[nodiscard]] std::vector<report::PaperHypothesis> paper_hypotheses(const closed_loop::TiltResponse& reference,
                                                                    const PaperGyroErrors&, std::uint64_t seed);

}  // namespace gyrobudget::inline v0::paper

// SPDX-License-Identifier: MIT
// What a navigation run found, in sentences.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "navigation.h"

namespace gyrobudget::inline v0::report {

/// "clock", "lever_arm", "axes", "unit", "heading", "sigma".
[[nodiscard]] std::string_view name(navigation::Suspect::Kind kind);

/// "The stamps of gnss are 18 s late: ...".
[[nodiscard]] std::string suspect_text(const NavigationResult& r, const navigation::Suspect& suspect);
/// The line of the scene that would mend it: "time_tag: -18 s". Empty where no line can.
[[nodiscard]] std::string suspect_mend(const NavigationResult& r, const navigation::Suspect& suspect);

/// What to do where innovations are far from what the sigmas say: "gnss.position: ...". Empty where they are as they
/// should be.
[[nodiscard]] std::vector<std::string> innovation_texts(const NavigationResult& r);

/// "Lost from 31 s to 52 s: ...", one for each span.
[[nodiscard]] std::vector<std::string> lost_texts(const NavigationResult& r);

}  // namespace gyrobudget::inline v0::report

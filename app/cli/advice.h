// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/deviation.h"
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/estimation/fit/fit.h"

#include <string>
#include <vector>

namespace gyrobudget::inline v0::cli {

/// True where none of N, B and K is identified: the samples are all equal, or there is nothing but quantization.
[[nodiscard]] bool holds_no_answer(const fit::Result&);

/// "described (p = 0.41)" and the like, for a comment.
[[nodiscard]] std::string one_line_verdict(const fit::Result&);

/// Takes the raw minimum of the curve that the person sees.
void note_minimum(fit::Result&, const allan::Curve& display);

/// What to know and do next, in plain words, most important first; `findings` tell what the record holds beside noise.
[[nodiscard]] std::vector<std::string> advise(const fit::Result&, const allan::Axis&, const allan::Curve& octaves,
                                              const std::vector<std::string>& findings);

}  // namespace gyrobudget::inline v0::cli

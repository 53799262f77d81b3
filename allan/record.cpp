// SPDX-License-Identifier: MIT
#include "record.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::allan {

Record make_record(std::vector<Axis> axes, double rate_hz, std::string source) {
  if (!(rate_hz > 0 && std::isfinite(rate_hz)))
    throw std::invalid_argument(fmt::format("rate of a record is {} Hz, expected it positive and finite", rate_hz));
  const std::size_t samples = axes.empty() ? 0 : axes.front().rate.size();
  for (const Axis& axis : axes) {
    if (axis.rate.size() != samples)
      throw std::invalid_argument(fmt::format("axis '{}' has {} samples and axis '{}' {}, expected one length for all",
                                              axis.name, axis.rate.size(), axes.front().name, samples));
  }
  Record record{.source = std::move(source), .rate_hz = rate_hz, .samples = static_cast<std::int64_t>(samples)};
  for (std::size_t i = 0; i < samples; ++i)
    record.missing_samples +=
        std::ranges::any_of(axes, [i](const Axis& axis) { return !std::isfinite(axis.rate[i]); }) ? 1 : 0;
  record.axes = std::move(axes);
  return record;
}

}  // namespace gyrobudget::inline v0::allan

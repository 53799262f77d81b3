// SPDX-License-Identifier: MIT
#include "rows.h"

#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::log {

void check_request(const std::vector<StreamInfo>& streams, std::size_t stream, std::span<const std::size_t> fields) {
  const StreamInfo& info = streams.at(stream);
  for (const std::size_t field : fields) static_cast<void>(info.fields.at(field));
}

void finish(Rows& rows, const StreamInfo& stream, std::span<const std::size_t> fields) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    std::vector<double>& column = rows.columns[i];
    std::uint64_t missing = 0;
    for (double& value : column) {
      if (std::isfinite(value)) continue;
      value = std::numeric_limits<double>::quiet_NaN();
      ++missing;
    }
    if (missing > 0)
      rows.notes.push_back(
          fmt::format("{}: {} without a number", stream.fields[fields[i]].name, counted(missing, "row")));
  }
}

bool is_constant(std::span<const std::int64_t> stamps) {
  return stamps.size() > 1 && std::ranges::all_of(stamps, [&](std::int64_t s) { return s == stamps.front(); });
}

double median_interval_s(std::span<const std::int64_t> stamps) {
  if (stamps.size() < 2) return 0;
  // A few thousand, spread over the whole, are as good as all.
  constexpr std::size_t kMost = 4096;
  const std::size_t step = 1 + (stamps.size() - 2) / kMost;
  std::vector<double> intervals;
  for (std::size_t i = 1; i < stamps.size(); i += step)
    intervals.push_back(static_cast<double>(stamps[i]) - static_cast<double>(stamps[i - 1]));
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  return *middle * noise::kNanosecond;
}

void note_decimation(Rows& rows, double covered_s) {
  constexpr double kApart = 1.5, kSlowestSensor_s = 0.03;
  const double interval = median_interval_s(rows.stamps_ns);
  if (covered_s > 0 && interval > kApart * covered_s) {
    rows.is_decimated = true;
    rows.notes.push_back(fmt::format(
        "rows are {:.4g} s apart and cover {:.4g} s each: the recorder left out what is between, and an Allan curve from them would be wrong",
        interval, covered_s));
  } else if (!(covered_s > 0) && interval > kSlowestSensor_s) {
    rows.notes.push_back(fmt::format(
        "rows are {:.4g} s apart, more than a sensor's own interval: the recorder left out what is between, and an Allan curve from them may be wrong",
        interval));
  }
}

std::string clean_name(std::string_view name) {
  constexpr std::size_t kMostBytes = 200;
  return text::printable(text::trim(name.substr(0, kMostBytes)));
}

std::string UniqueNames::take(std::string_view name) {
  int& last = taken_[std::string(name)];
  if (last == 0) {
    last = 1;
    return std::string(name);
  }
  std::string unique;
  do {
    unique = fmt::format("{} ({})", name, ++last);
  } while (!taken_.emplace(unique, 1).second);
  return unique;
}

std::string counted(std::uint64_t count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

}  // namespace gyrobudget::inline v0::log

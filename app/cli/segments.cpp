// SPDX-License-Identifier: MIT
#include "segments.h"

#include "gyrobudget/allan/analysis.h"
#include "gyrobudget/app/text/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <stdexcept>

#include "analysis.h"

namespace gyrobudget::inline v0::cli {
namespace {

void check_alike(const allan::Record& first, const allan::Record& other) {
  switch (allan::match(first, other)) {
    case allan::Match::alike:
      return;
    case allan::Match::other_axes:
      throw text::InputError(fmt::format(
          "{}: its columns are not those of {}, expected segments of one log; choose the same columns of both with --column",
          other.source, first.source));
    case allan::Match::other_rate:
      throw text::InputError(
          fmt::format("{}: its rate is {:.6g} Hz, that of {} {:.6g} Hz; only logs of one rate are pooled", other.source,
                      other.rate_hz, first.source, first.rate_hz));
  }
}

}  // namespace

std::vector<std::string> logs_of(const AllanArguments& a) {
  std::vector<std::string> paths{a.curve.log.path};
  for (const auto& path : a.segments) {
    if (std::ranges::find(paths, path) != paths.end())
      throw std::invalid_argument(fmt::format("{} is given twice", path));
    paths.push_back(path);
  }
  return paths;
}

std::vector<allan::Record> read_segments(const AllanArguments& a) {
  std::vector<allan::Record> records;
  for (const auto& path : logs_of(a)) {
    CurveArguments next = a.curve;
    next.log.path = path;
    std::vector<allan::Record> read;
    if (a.gap_s) {
      read = read_cut_record(next, *a.gap_s, a.common);
    } else {
      read.push_back(read_record(next, a.common));
    }
    std::ranges::move(read, std::back_inserter(records));
    check_alike(records.front(), records.back());
  }
  return records;
}

}  // namespace gyrobudget::inline v0::cli

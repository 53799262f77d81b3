// SPDX-License-Identifier: MIT
#include "several.h"

#include "gyrobudget/estimation/fit/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::calibration {
namespace {

template <class Axes>
std::string names(const Axes& axes) {
  std::string text;
  for (const auto& axis : axes) text += fmt::format("{}'{}'", text.empty() ? "" : ", ", axis.name);
  return text;
}

CombinedAxis combined(const std::vector<Datasheet>& records, std::size_t axis) {
  const AxisDatasheet& first = records.front().axes[axis];
  CombinedAxis result{.name = first.name, .signal = first.signal, .coefficients = {}, .left_out = {}};
  std::vector<fit::Result> fits;
  for (const Datasheet& record : records) {
    const fit::Result& fit = record.axes[axis].fit;
    const bool rounded = std::ranges::find(fit.coefficients, fit::Status::not_quotable, &fit::Coefficient::status) !=
                         fit.coefficients.end();
    if (fit::is_quotable(fit) && !rounded)
      fits.push_back(fit);
    else
      result.left_out.push_back(record.source);
  }
  if (!fits.empty()) result.coefficients = fit::combine(fits);
  return result;
}

}  // namespace

bool TypeDatasheet::is_complete() const {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (std::ranges::none_of(records, [i](const Datasheet& record) { return record.axes[i].has_answer(); }))
      return false;
  }
  return true;
}

allan::Record matched(allan::Record record, const Datasheet& first) {
  if (!(std::abs(record.rate_hz / first.rate_hz - 1) <= kRateTolerance))
    throw Unusable(Unusable::Reason::other_rate,
                   fmt::format("{}: found a rate of {:.6g} Hz, expected the {:.6g} Hz of {}", record.source,
                               record.rate_hz, first.rate_hz, first.source));
  const std::string found = names(record.axes);
  std::vector<allan::Axis> axes;
  for (const AxisDatasheet& wanted : first.axes) {
    const auto at = std::ranges::find_if(
        record.axes, [&](const allan::Axis& axis) { return axis.name == wanted.name && axis.signal == wanted.signal; });
    if (at == record.axes.end()) break;
    axes.push_back(std::move(*at));
    record.axes.erase(at);
  }
  if (!record.axes.empty() || axes.size() != first.axes.size())
    throw Unusable(Unusable::Reason::other_axes, fmt::format("{}: found the columns {}, expected {} as in {}",
                                                             record.source, found, names(first.axes), first.source));
  record.axes = std::move(axes);
  return record;
}

TypeDatasheet combine(std::vector<Datasheet> records) {
  if (records.empty()) throw std::invalid_argument("there are no datasheets to combine, expected one at least");
  const std::size_t axes = records.front().axes.size();
  for (const Datasheet& record : records) {
    if (record.axes.size() != axes)
      throw std::invalid_argument(fmt::format("{} has {} axes, expected {}", record.source, record.axes.size(), axes));
  }
  TypeDatasheet sheet{.records = std::move(records), .axes = {}};
  for (std::size_t i = 0; i < axes; ++i) sheet.axes.push_back(combined(sheet.records, i));
  return sheet;
}

TypeDatasheet calibrate(std::span<const allan::Record> records, const Options& options) {
  std::vector<Datasheet> sheets;
  for (const allan::Record& record : records)
    sheets.push_back(calibrate(sheets.empty() ? record : matched(record, sheets.front()), options));
  return combine(std::move(sheets));
}

}  // namespace gyrobudget::inline v0::calibration

// SPDX-License-Identifier: MIT
#include "several.h"

#include "gyrobudget/estimation/fit/judgement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::calibration {
namespace {

constexpr double kStartTolerance = 1 + kRateTolerance;  // starts of one octave differ as the rates do

template <class Axes>
std::string names(const Axes& axes) {
  std::string text;
  for (const auto& axis : axes) text += fmt::format("{}'{}'", text.empty() ? "" : ", ", axis.name);
  return text;
}

// A fit once more from a later start on, its own terms and shapes held. Quantization stays with the first one.
fit::Result fit_from(const AxisDatasheet& axis, double tau_min_s) {
  fit::Options options;
  options.terms = axis.fit.fitted_terms;
  std::erase(options.terms, noise::Term::quantization);
  options.tau_min_s = tau_min_s;
  options.tau_max_s = axis.fit.tau_max_s;
  if (const auto* g = fit::find(axis.fit, noise::Term::gauss_markov)) options.correlation_time_s = g->shape;
  if (const auto* line = fit::find(axis.fit, noise::Term::sinusoid)) options.frequency_hz = line->shape;
  fit::Result result = fit::fit(axis.octaves, options);
  const auto* own = fit::find(axis.fit, noise::Term::quantization);
  const auto q = std::ranges::find(result.coefficients, noise::Term::quantization, &fit::Coefficient::term);
  if (own != nullptr && q != result.coefficients.end()) *q = *own;
  return result;
}

// Taus from `tau_min_s` on that a fit has beyond its terms.
bool can_begin_at(const fit::Result& fit, double tau_min_s) {
  const auto taus =
      std::ranges::count_if(fit.residuals, [&](const auto& r) { return r.tau_s >= tau_min_s * (1 - 1e-9); });
  return fit.method == fit::Method::gls && taus > static_cast<std::ptrdiff_t>(fit.fitted_terms.size());
}

// The latest start of several fits, where they differ and all of them can begin there.
std::optional<double> common_start(const std::vector<const AxisDatasheet*>& axes) {
  double earliest = std::numeric_limits<double>::infinity(), latest = 0;
  for (const AxisDatasheet* axis : axes) {
    earliest = std::min(earliest, axis->fit.tau_min_s);
    latest = std::max(latest, axis->fit.tau_min_s);
  }
  if (!(latest > kStartTolerance * kStartTolerance * earliest)) return {};
  const bool all =
      std::ranges::all_of(axes, [&](const auto* axis) { return can_begin_at(axis->fit, latest / kStartTolerance); });
  return all ? std::optional(latest) : std::nullopt;
}

CombinedAxis combined(const std::vector<Datasheet>& records, std::size_t axis) {
  const AxisDatasheet& first = records.front().axes[axis];
  CombinedAxis result{
      .name = first.name, .signal = first.signal, .coefficients = {}, .left_out = {}, .common_start_s = {}};
  std::vector<const AxisDatasheet*> taken;
  for (const Datasheet& record : records) {
    const fit::Result& fit = record.axes[axis].fit;
    const bool rounded = std::ranges::find(fit.coefficients, fit::Status::not_quotable, &fit::Coefficient::status) !=
                         fit.coefficients.end();
    if (fit::is_quotable(fit) && !rounded)
      taken.push_back(&record.axes[axis]);
    else
      result.left_out.push_back(record.source);
  }
  result.common_start_s = common_start(taken);
  std::vector<fit::Result> fits;
  for (const AxisDatasheet* sheet : taken)
    fits.push_back(result.common_start_s ? fit_from(*sheet, *result.common_start_s / kStartTolerance) : sheet->fit);
  if (!fits.empty()) result.coefficients = fit::combine(fits);
  return result;
}

}  // namespace

bool TypeDatasheet::is_complete() const {
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto of = [i](const Datasheet& record) -> const AxisDatasheet& { return record.axes[i]; };
    if (std::ranges::none_of(records, &AxisDatasheet::has_answer, of)) return false;
    if (std::ranges::any_of(
            records, [](const AxisDatasheet& a) { return a.has_answer() && a.is_spoilt(); }, of))
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

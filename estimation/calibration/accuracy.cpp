// SPDX-License-Identifier: MIT
#include "accuracy.h"

#include <limits>
#include <span>
#include <utility>

namespace gyrobudget::inline v0::calibration {
namespace {

/// Of a record that was refused.
fit::Result no_answer(const fit::Options& asked) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  fit::Result result{.method = asked.method};
  for (const noise::Term t : asked.terms) {
    fit::Coefficient& c = result.coefficients.emplace_back(fit::Coefficient{.term = t});
    c.value = c.lower = c.upper = c.upper_two_sided = kNaN;
    c.status = fit::Status::not_quotable;
  }
  result.p_value = kNaN;
  return result;
}

}  // namespace

fit::Accuracy measure_accuracy(const std::vector<noise::Process>& truth, const noise::Recorder& recorder,
                               fit::AccuracyOptions study, const Options& calibrate) {
  const noise::RecorderGenerator generator(truth, recorder, study.samples, study.dt);
  study.make = [&](noise::StreamKey key) { return generator(key); };
  study.answer = [&](std::span<const double> rate, const fit::Options& asked) {
    Options options = calibrate;
    options.method = asked.method;
    const auto record = allan::make_record({{.name = "rate", .rate = {rate.begin(), rate.end()}}}, 1 / study.dt);
    try {
      AxisDatasheet axis = std::move(calibration::calibrate(record, options).axes.front());
      if (!axis.is_fitted()) return no_answer(asked);
      if (axis.is_spoilt()) axis.fit.verdict = fit::Verdict::not_described;
      return std::move(axis.fit);
    } catch (const Unusable&) {
      return no_answer(asked);
    }
  };
  return fit::measure_accuracy(generator.processes(), study);
}

}  // namespace gyrobudget::inline v0::calibration

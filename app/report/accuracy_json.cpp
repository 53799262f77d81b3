// SPDX-License-Identifier: MIT
// The accuracy of fits for programs, and the data that accuracy.js and sweep.js draw.
#include "gyrobudget/noise/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "accuracy.h"
#include "json_text.h"
#include "page_parts.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Json = nlohmann::ordered_json;
using noise::Term;

std::string key_of(noise::Signal signal, Term term) {
  if (term == Term::gauss_markov || term == Term::sinusoid) return {static_cast<char>(term)};
  return std::string(noise::key(signal, term));
}

std::string_view text(noise::Signal signal) {
  return signal == noise::Signal::angular_rate ? "angular_rate" : "specific_force";
}

double binomial_std(double share, double of) { return std::sqrt(share * (1 - share) / of); }

Json coefficient_json(const AccuracyStudy& study, const fit::CoefficientAccuracy& c) {
  const double records = study.accuracy.records;
  const std::string unit(noise::datasheet_unit(study.signal, c.term));
  return {{"term", std::string(1, static_cast<char>(c.term))},
          {"truth", noise::from_si(c.truth, unit)},
          {"unit", unit},
          {"bias", number_or_null(c.bias)},
          {"rmse", number_or_null(c.rmse)},
          {"bound", number_or_null(c.bound)},
          {"over_bound", number_or_null(c.rmse / c.bound)},
          {"over_likelihood", number_or_null(c.over_likelihood)},
          {"coverage", c.coverage},
          {"coverage_std", binomial_std(c.coverage, records)},
          {"coverage_by_status", c.coverage_by_status},
          {"coverage_identified", number_or_null(c.coverage_identified)},
          {"coverage_identified_std", number_or_null(binomial_std(c.coverage_identified, records * c.identified))},
          {"identified", c.identified},
          {"missed", c.missed},
          {"refused", c.refused},
          {"coverage_answered", number_or_null(c.coverage_answered)}};
}

Json method_json(const AccuracyStudy& study, const fit::MethodAccuracy& m) {
  Json coefficients = Json::object();
  for (const auto& c : m.coefficients) coefficients[key_of(study.signal, c.term)] = coefficient_json(study, c);
  return {{"method", fit::name(m.method)},
          {"coefficients", coefficients},
          {"false_terms", m.false_terms},
          {"p05", number_or_null(m.p_below_5_percent)},
          {"p01", number_or_null(m.p_below_1_percent)},
          {"cut", m.cut},
          {"not_described", m.not_described},
          {"unconverged", m.unconverged},
          {"seconds_per_fit", m.seconds_per_fit}};
}

Json check_json(noise::Signal signal, const fit::Check& c) {
  return {{"text", c.text},
          {"method", fit::name(c.method)},
          {"coefficient", c.term ? Json(key_of(signal, *c.term)) : Json(nullptr)},
          {"value", number_or_null(c.value)},
          {"low", number_or_null(c.low)},
          {"high", number_or_null(c.high)},
          {"met", c.met}};
}

Json document(const AccuracyStudy& study) {
  const auto& a = study.accuracy;
  Json methods = Json::array(), checks = Json::array();
  for (const auto& m : a.methods) methods.push_back(method_json(study, m));
  for (const auto& c : study.checks) checks.push_back(check_json(study.signal, c));
  return {{"schema", "gyrobudget.accuracy/1"},
          {"version", kVersion},
          {"command", study.command},
          {"sensor", study.sensor},
          {"signal", text(study.signal)},
          {"seed", a.seed},
          {"record",
           {{"samples", a.samples}, {"rate_hz", 1 / a.dt}, {"duration_s", static_cast<double>(a.samples) * a.dt}}},
          {"records", a.records},
          {"asked", study.asked},
          {"complete", a.complete},
          {"seconds", a.seconds},
          {"seconds_per_record", a.seconds_per_record},
          {"methods", methods},
          {"requirements", checks},
          {"words", accuracy_words(study)}};
}

Json sweep_row_json(noise::Signal signal, const fit::SweepRow& row) {
  Json coefficients = Json::object();
  for (const auto& c : row.coefficients) {
    coefficients[key_of(signal, c.term)] = {{"term", std::string(1, static_cast<char>(c.term))},
                                            {"rmse", number_or_null(c.rmse)},
                                            {"over_default", number_or_null(c.over_default)},
                                            {"over_bound", number_or_null(c.over_bound)},
                                            {"coverage", number_or_null(c.coverage)}};
  }
  return {{"group", group_of(row)},           {"setting", setting_of(row)},
          {"default", row.way == fit::Way{}}, {"samples", row.samples},
          {"records", row.records},           {"unconverged", row.unconverged},
          {"coefficients", coefficients},     {"curve_seconds", row.curve_seconds},
          {"fit_seconds", row.fit_seconds},   {"covariance_seconds", row.covariance_seconds}};
}

Json document(const SweepStudy& study) {
  Json rows = Json::array();
  for (const auto& row : study.sweep.rows) rows.push_back(sweep_row_json(study.signal, row));
  return {{"schema", "gyrobudget.accuracy_sweep/1"},
          {"version", kVersion},
          {"command", study.command},
          {"sensor", study.sensor},
          {"signal", text(study.signal)},
          {"rate_hz", study.rate_hz},
          {"seed", study.seed},
          {"complete", study.sweep.complete},
          {"seconds", study.sweep.seconds},
          {"rows", rows},
          {"words", sweep_words(study)}};
}

// Names and command lines may hold any bytes.
std::string text_of(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

// --- The page -------------------------------------------------------------------------------------------------------

/// Counts in equal bins from 0 to `reach`; what lies beyond is in the last.
Json counts(const std::vector<double>& values, double reach, std::size_t bins) {
  std::vector<std::int64_t> all(bins);
  for (const double v : values) {
    if (std::isnan(v)) continue;
    const double bin = std::clamp(v / reach * static_cast<double>(bins), 0.0, static_cast<double>(bins - 1));
    ++all[static_cast<std::size_t>(bin)];
  }
  return all;
}

/// Estimates over the truth: 40 bins up to what 4 of the largest RMSE reach, with what is at zero apart.
Json estimates(const AccuracyStudy& study, std::size_t coefficient_index) {
  const auto& methods = study.accuracy.methods;
  const auto& first = methods.front().coefficients[coefficient_index];
  if (!(first.truth > 0)) return nullptr;
  constexpr double kReach = 4;
  constexpr std::size_t kBins = 40;
  double spread = first.rmse;
  for (const auto& m : methods) {
    if (m.method == fit::Method::gls || m.method == fit::Method::whittle) {
      for (const auto& c : m.coefficients) spread = c.term == first.term ? c.rmse : spread;
    }
  }
  const double low = std::max(0.0, 1 - kReach * spread), high = 1 + kReach * spread;
  Json series = Json::array();
  for (const auto& m : methods) {
    const auto at = std::ranges::find(m.coefficients, first.term, &fit::CoefficientAccuracy::term);
    if (at == m.coefficients.end()) continue;
    std::vector<double> inside;
    std::int64_t zero = 0, outside = 0;
    for (const double v : at->values) {
      const double x = v / first.truth;
      if (x == 0)
        ++zero;
      else if (x < low || x > high)
        ++outside;
      else
        inside.push_back(x - low);
    }
    series.push_back({{"method", fit::name(m.method)},
                      {"counts", counts(inside, high - low, kBins)},
                      {"zero", zero},
                      {"outside", outside}});
  }
  return {{"key", key_of(study.signal, first.term)},
          {"label", noise::label(study.signal, first.term)},
          {"letter", std::string(1, static_cast<char>(first.term))},
          {"low", low},
          {"high", high},
          {"bound", number_or_null(first.bound)},
          {"series", series}};
}

std::string data_text(const Json& data) { return without_markup(text_of(data, -1)); }

}  // namespace

std::string accuracy_json(const AccuracyStudy& study) { return text_of(document(study), 2) + "\n"; }
std::string sweep_json(const SweepStudy& study) { return text_of(document(study), 2) + "\n"; }

std::string accuracy_data(const AccuracyStudy& study) {
  Json histograms = Json::array(), p_values = Json::array();
  const auto& methods = study.accuracy.methods;
  for (std::size_t i = 0; !methods.empty() && i < methods.front().coefficients.size(); ++i) {
    if (Json one = estimates(study, i); !one.is_null()) histograms.push_back(std::move(one));
  }
  constexpr std::size_t kBins = 20;
  for (const auto& m : methods) {
    if (!std::isfinite(m.p_below_5_percent)) continue;
    p_values.push_back({{"method", fit::name(m.method)}, {"counts", counts(m.p_values, 1, kBins)}});
  }
  return data_text({{"accuracy", document(study)}, {"estimates", histograms}, {"p_values", p_values}});
}

std::string sweep_data(const SweepStudy& study) { return data_text({{"sweep", document(study)}}); }

}  // namespace gyrobudget::inline v0::report

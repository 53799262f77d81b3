// SPDX-License-Identifier: MIT
#include "values.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <stdexcept>

namespace gyrobudget::inline v0::cli {

using noise::Term;

double quantity(const std::string& option, const std::string& text, const noise::Dimension& dimension) {
  try {
    return noise::parse_quantity(text, dimension);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}", option, error.what()));
  }
}

double positive(const std::string& option, double value, const std::string& text) {
  if (value > 0 && std::isfinite(value)) return value;
  throw std::invalid_argument(fmt::format("{} {}: must be above 0", option, text));
}

double duration(const std::string& option, const std::string& text) {
  return positive(option, quantity(option, text, noise::dimension::kTime), text);
}

log::RowsOf rows_of(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
    throw std::invalid_argument(
        fmt::format("--rows {}: expected a column and the number or word that its rows have, as in --rows I=0", text));
  log::RowsOf rows{.column = text.substr(0, equals)};
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data() + equals + 1, end, rows.value);
  if (error != std::errc{} || at != end) rows.word = text.substr(equals + 1);
  return rows;
}

namespace {
/// A number without a unit.
bool is_bare(const std::string& text) { return text.find_first_not_of("0123456789.eE+- ") == std::string::npos; }
}  // namespace

log::TimeOf time_of(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos) return {text};
  const std::string unit = text.substr(equals + 1);
  if (equals > 0 && std::ranges::find(log::kTimeUnitNames, unit) != log::kTimeUnitNames.end())
    return {text.substr(0, equals), unit};
  throw std::invalid_argument(fmt::format(
      "--time {}: expected a column, and behind = one of s, ms, us, ns, iso, gps, counter, as in --time stamp=ms",
      text));
}

log::With with_of(const std::string& text) {
  const std::size_t equals = text.rfind('=');
  if (equals == std::string::npos || equals == 0) return {text};
  try {
    static_cast<void>(noise::parse_unit(text.substr(equals + 1)));
    return {text.substr(0, equals), text.substr(equals + 1)};
  } catch (const std::invalid_argument&) {
    return {text};  // the name of a file
  }
}

// "100", "100 Hz", "1 kHz"
double rate(const std::string& option, const std::string& text) {
  return positive(option, quantity(option, is_bare(text) ? text + " Hz" : text, noise::dimension::kFrequency), text);
}

std::uint64_t whole_number(const std::string& option, const std::string& text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw std::invalid_argument(
        fmt::format("{} {}: must be a whole number from 0 to 18446744073709551615", option, text));
  }
  return value;
}

std::uint64_t seed(const std::string& text) { return whole_number("--seed", text); }

namespace {

const std::map<std::string, Term> kTermNames{
    {"Q", Term::quantization},
    {"quantization", Term::quantization},
    {"N", Term::white},
    {"arw", Term::white},
    {"B", Term::flicker},
    {"bias_instability", Term::flicker},
    {"K", Term::rate_random_walk},
    {"rrw", Term::rate_random_walk},
    {"R", Term::rate_ramp},
    {"rate_ramp", Term::rate_ramp},
    {"G", Term::gauss_markov},
    {"gauss_markov", Term::gauss_markov},
    {"S", Term::sinusoid},
    {"sinusoid", Term::sinusoid},
};

Term term_named(const std::string& option, const std::string& name) {
  if (const auto at = kTermNames.find(name); at != kTermNames.end()) return at->second;
  throw std::invalid_argument(fmt::format(
      "{}: no term '{}'; there are Q (quantization), N (arw), B (bias_instability), K (rrw), R (rate_ramp), G (gauss_markov) and S (sinusoid)",
      option, name));
}

}  // namespace

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(separator, start), text.size());
    parts.push_back(text.substr(start, end - start));
    start = end + 1;
  }
  return parts;
}

std::vector<Term> terms(const std::string& text) {
  std::vector<Term> list;
  for (const auto& name : split(text, ',')) list.push_back(term_named("--terms", name));
  return list;
}

ShapedTerms shaped_terms(const std::string& text) {
  ShapedTerms asked;
  for (const auto& item : split(text, ',')) {
    const auto parts = split(item, '=');
    const Term term = term_named("--terms", parts[0]);
    asked.terms.push_back(term);
    if (parts.size() == 1) continue;
    if (parts.size() == 2 && term == Term::gauss_markov) {
      asked.correlation_time_s = duration("--terms", parts[1]);
    } else if (parts.size() == 2 && term == Term::sinusoid) {
      asked.frequency_hz = rate("--terms", parts[1]);
    } else {
      throw std::invalid_argument(fmt::format(
          "--terms {}: only G takes a correlation time, as in G=120s, and S a frequency, as in S=0.05Hz", item));
    }
  }
  return asked;
}

// "B=10%"
GivenFrontEnd front_end(const std::string& text) {
  using Kind = noise::FrontEnd::Kind;
  const auto colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  for (const Kind k : {Kind::first_order, Kind::second_order, Kind::moving_average}) {
    if (kind != noise::name(k)) continue;
    if (colon == std::string::npos) return {k, {}};
    return {k, rate("--front-end", text.substr(colon + 1))};
  }
  throw std::invalid_argument(fmt::format(
      "--front-end {}: must be first_order, second_order or moving_average, with a bandwidth behind it where it is known: first_order:25Hz",
      text));
}

namespace {

constexpr const char* kFrontEnd = "--front-end";

double size_of(const std::string& item, const std::string& size) {
  if (size.empty())
    throw std::invalid_argument(fmt::format("--front-end {0}: write its size behind it, as in {0}:2", item));
  return quantity(kFrontEnd, is_bare(size) ? size + " 1" : size, noise::dimension::kNumber);
}

noise::FrontEnd front_end_of_records(const std::string& item, double rate_hz) {
  const GivenFrontEnd given = front_end(item);
  if (!given.bandwidth)
    throw std::invalid_argument(
        fmt::format("--front-end {0}: simulated records need a bandwidth, as in {0}:25Hz", item));
  noise::FrontEnd front_end{given.kind, *given.bandwidth};
  if (given.kind == noise::FrontEnd::Kind::moving_average) {
    const double samples = std::max(1., std::round(noise::kMovingAverageWidth * rate_hz / front_end.bandwidth));
    front_end.bandwidth = noise::kMovingAverageWidth * rate_hz / samples;
  }
  return front_end;
}

}  // namespace

noise::Recorder recorder(const std::string& text, double rate_hz) {
  noise::Recorder r;
  for (const std::string& item : split(text, ',')) {
    const auto colon = item.find(':');
    const std::string what = item.substr(0, colon), size = colon == std::string::npos ? "" : item.substr(colon + 1);
    const auto count = [&] { return static_cast<int>(whole_number(kFrontEnd, size)); };
    if (what == "decimation")
      r.decimation = count();
    else if (what == "held")
      r.held = count();
    else if (what == "rounding")
      r.rounding = size_of(what, size);
    else if (what == "gaps")
      r.gaps = size_of(what, size);
    else if (what == "outliers")
      r.outliers = size_of(what, size);
    else if (what == "warm_up")
      r.warm_up = size_of(what, size);
    else if (what == "knock")
      r.knock = size_of(what, size);
    else
      r.front_end = front_end_of_records(item, rate_hz);
  }
  return r;
}

calibration::Masking masking(const std::vector<std::string>& names) {
  const auto has = [&](const char* what) { return std::ranges::find(names, what) != names.end(); };
  return {has("outliers"), has("steps"), has("warm-up"), has("motion")};
}

fit::PlanOptions::Wish wish(const std::string& text) {
  const auto parts = split(text, '=');
  if (parts.size() != 2) throw std::invalid_argument(fmt::format("--want '{}': write TERM=ACCURACY, e.g. B=10%", text));
  const double accuracy = quantity("--want", parts[1], noise::dimension::kNumber);
  const Term term = term_named("--want", parts[0]);
  if (term == Term::gauss_markov || term == Term::sinusoid)
    throw std::invalid_argument(fmt::format("--want {}: plan knows Q, N, B, K and R only", text));
  return {term, positive("--want", accuracy, text)};
}

fit::Method method_named(const std::string& name) {
  const auto at = std::ranges::find_if(fit::kMethods, [&](fit::Method m) { return fit::name(m) == name; });
  if (at != fit::kMethods.end()) return *at;
  throw std::invalid_argument(
      fmt::format("--methods: no method '{}'; there are gls, edf, loglog, slope, visual and whittle", name));
}

std::vector<allan::Estimator> estimators(const std::string& text) {
  if (text == "all") return {std::begin(allan::kEstimators), std::end(allan::kEstimators)};
  std::vector<allan::Estimator> list;
  for (const auto& name : split(text, ',')) {
    const auto estimator = allan::estimator_named(name);
    if (!estimator) {
      std::string known;
      for (const auto e : allan::kEstimators) known += fmt::format("{}{}", known.empty() ? "" : ", ", allan::name(e));
      throw std::invalid_argument(fmt::format("--estimator: no estimator '{}'; there are {}, or all", name, known));
    }
    if (std::ranges::find(list, *estimator) == list.end()) list.push_back(*estimator);
  }
  return list;
}

allan::Taus taus(const std::string& text) {
  using Kind = allan::Taus::Kind;
  if (text == "octave") return {Kind::octave};
  if (text == "decade") return {Kind::decade};
  if (text == "all") return {Kind::all};
  constexpr std::size_t kMostDigits = 6;
  const bool number = !text.empty() && text.size() <= kMostDigits && std::ranges::all_of(text, text::is_digit);
  if (number && std::stoi(text) > 1) return {Kind::logarithmic, std::stoi(text)};
  throw std::invalid_argument(fmt::format("--taus {}: must be octave, decade, all, or a number from 2 on", text));
}

// "1", "m" or "m/16": how many terms begin in a cluster; 0 for all.
std::int64_t overlap(const std::string& text) {
  constexpr std::uint64_t kMost = 4096;
  if (text == "1") return 0;
  if (text == "m") return 1;
  if (text.starts_with("m/")) {
    const std::uint64_t parts = whole_number("--stride", text.substr(2));
    if (parts >= 1 && parts <= kMost) return static_cast<std::int64_t>(parts);
  }
  throw std::invalid_argument(
      fmt::format("--stride {}: must be 1 (a term at every sample), m, or m/N with N from 1 to {}", text, kMost));
}

// "9h", or "1000" samples
std::uint64_t skipped_samples(const std::string& text, double rate_hz) {
  if (text.find_first_not_of("0123456789") == std::string::npos) return whole_number("--skip", text);
  const double samples = std::round(quantity("--skip", text, noise::dimension::kTime) * rate_hz);
  constexpr double kMost = 9e18;
  if (samples >= 0 && samples <= kMost) return static_cast<std::uint64_t>(samples);
  throw std::invalid_argument(fmt::format("--skip {}: must be from 0 to 9e18 samples", text));
}

BudgetArguments::Limit limit(const std::string& text) {
  const auto parts = split(text, '<');
  const auto trimmed = [](std::string word) {
    word.erase(0, std::min(word.find_first_not_of(' '), word.size()));
    word.erase(word.find_last_not_of(' ') + 1);
    return word;
  };
  std::vector<std::string_view> names;
  for (const budget::Component component : budget::kComponents) names.push_back(to_string(component));
  const std::string wanted = trimmed(parts[0]);
  const auto* const component = std::ranges::find(budget::kComponents, wanted, budget::to_string);
  if (parts.size() != 2 || component == budget::kComponents.end())
    throw std::invalid_argument(
        fmt::format("--limit '{}': write COMPONENT < LENGTH, e.g. 'crossrange < 10 m'; components are {}", text,
                    fmt::join(names, ", ")));
  const double metres = quantity("--limit", trimmed(parts[1]), noise::dimension::kLength);
  return {text, *component, positive("--limit", metres, text)};
}

}  // namespace gyrobudget::inline v0::cli

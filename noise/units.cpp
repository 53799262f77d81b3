// SPDX-License-Identifier: MIT
#include "units.h"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <vector>

#include "constants.h"

namespace gyrobudget::inline v0::noise {
namespace {

/// A unit while it is worked out: long double, so that the factor rounds once, at the end.
struct Scale {
  long double factor = 1;
  int angle = 0, length = 0, time = 0, mass = 0, temperature = 0;  ///< doubled exponents, as in Dimension
};

Scale power(const Scale& base, int halves) {
  const long double root = halves % 2 == 0 ? base.factor : std::sqrt(base.factor);
  const int steps = halves % 2 == 0 ? halves / 2 : halves;
  Scale result;
  for (int i = 0; i < std::abs(steps); ++i) result.factor *= root;
  if (steps < 0) result.factor = 1 / result.factor;
  result.angle = base.angle * halves / 2;
  result.length = base.length * halves / 2;
  result.time = base.time * halves / 2;
  result.mass = base.mass * halves / 2;
  result.temperature = base.temperature * halves / 2;
  return result;
}

Scale product(const Scale& a, const Scale& b) {
  return {a.factor * b.factor, a.angle + b.angle, a.length + b.length,
          a.time + b.time,     a.mass + b.mass,   a.temperature + b.temperature};
}

// --- Names -------------------------------------------------------------------------------------------------

struct Name {
  std::string_view text;
  Scale scale;
  bool takes_prefix = false;
};

constexpr long double kRevolution = 2 * std::numbers::pi_v<long double>;
constexpr long double kDegree = kRevolution / 360;
constexpr long double kEarthRate = 7.292115e-5L;  // WGS 84, rad/s
constexpr long double kMinute = 60, kHour = 3600, kDay = 86400, kFoot = 0.3048L;

constexpr Name kNames[] = {
    {"rad", {1, 2, 0, 0}, true},
    {"radian", {1, 2, 0, 0}, true},
    {"radians", {1, 2, 0, 0}, true},
    {"deg", {kDegree, 2, 0, 0}, true},
    {"degree", {kDegree, 2, 0, 0}},
    {"degrees", {kDegree, 2, 0, 0}},
    {"arcmin", {kDegree / 60, 2, 0, 0}},
    {"arcminute", {kDegree / 60, 2, 0, 0}},
    {"arcminutes", {kDegree / 60, 2, 0, 0}},
    {"arcsec", {kDegree / 3600, 2, 0, 0}, true},
    {"arcsecs", {kDegree / 3600, 2, 0, 0}},
    {"arcsecond", {kDegree / 3600, 2, 0, 0}, true},
    {"arcseconds", {kDegree / 3600, 2, 0, 0}, true},
    {"asec", {kDegree / 3600, 2, 0, 0}},
    {"as", {kDegree / 3600, 2, 0, 0}, true},
    {"rev", {kRevolution, 2, 0, 0}},
    {"s", {1, 0, 0, 2}, true},
    {"sec", {1, 0, 0, 2}, true},
    {"secs", {1, 0, 0, 2}},
    {"second", {1, 0, 0, 2}},
    {"seconds", {1, 0, 0, 2}},
    {"min", {kMinute, 0, 0, 2}},
    {"mins", {kMinute, 0, 0, 2}},
    {"minute", {kMinute, 0, 0, 2}},
    {"minutes", {kMinute, 0, 0, 2}},
    {"h", {kHour, 0, 0, 2}},
    {"hr", {kHour, 0, 0, 2}},
    {"hrs", {kHour, 0, 0, 2}},
    {"hour", {kHour, 0, 0, 2}},
    {"hours", {kHour, 0, 0, 2}},
    {"d", {kDay, 0, 0, 2}},
    {"day", {kDay, 0, 0, 2}},
    {"days", {kDay, 0, 0, 2}},
    {"Hz", {1, 0, 0, -2}, true},
    {"hertz", {1, 0, 0, -2}},
    {"m", {1, 0, 2, 0}, true},
    {"meter", {1, 0, 2, 0}},
    {"meters", {1, 0, 2, 0}},
    {"metre", {1, 0, 2, 0}},
    {"metres", {1, 0, 2, 0}},
    {"ft", {kFoot, 0, 2, 0}},
    {"foot", {kFoot, 0, 2, 0}},
    {"feet", {kFoot, 0, 2, 0}},
    {"in", {kFoot / 12, 0, 2, 0}},
    {"inch", {kFoot / 12, 0, 2, 0}},
    {"g", {kStandardGravityLong, 0, 2, -4}, true},
    {"gee", {kStandardGravityLong, 0, 2, -4}},
    {"Gal", {0.01L, 0, 2, -4}, true},
    {"gal", {0.01L, 0, 2, -4}, true},
    {"dps", {kDegree, 2, 0, -2}, true},
    {"dph", {kDegree / kHour, 2, 0, -2}},
    {"rpm", {kRevolution / kMinute, 2, 0, -2}},
    {"meru", {kEarthRate / 1000, 2, 0, -2}},  // milli Earth rate unit
    {"kg", {1, 0, 0, 0, 2}},
    {"t", {1000, 0, 0, 0, 2}},
    {"N", {1, 0, 2, -4, 2}, true},
    {"Nm", {1, 0, 4, -4, 2}, true},
    {"Pa", {1, 0, -2, -4, 2}, true},
    {"K", {1, 0, 0, 0, 0, 2}},
    {"kelvin", {1, 0, 0, 0, 0, 2}},
    {"degC", {1, 0, 0, 0, 0, 2}},
    {"C", {1, 0, 0, 0, 0, 2}},
    {"celsius", {1, 0, 0, 0, 0, 2}},
    {"%", {0.01L, 0, 0, 0}},
    {"percent", {0.01L, 0, 0, 0}},
    {"ppm", {1e-6L, 0, 0, 0}},
    {"ppb", {1e-9L, 0, 0, 0}},
    {"dimensionless", {1, 0, 0, 0}},
};

struct Prefix {
  char letter;
  long double factor;
};
constexpr Prefix kPrefixes[] = {{'p', 1e-12L}, {'n', 1e-9L}, {'u', 1e-6L}, {'m', 1e-3L},
                                {'c', 1e-2L},  {'k', 1e3L},  {'M', 1e6L}};

constexpr std::string_view kWithoutSize[] = {"count",  "counts", "cnt", "cts", "lsb",  "digit",
                                             "digits", "raw",    "v",   "mv",  "volt", "volts"};

bool prefixed(const Prefix& prefix, const Name& name) {
  return name.takes_prefix && (prefix.letter != 'c' || name.text == "m");  // centi: the centimetre only
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::ranges::transform(result, result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

std::optional<Scale> find_name(std::string_view word) {
  for (const Name& name : kNames) {
    if (name.text == word) return name.scale;
  }
  for (const Prefix& prefix : kPrefixes) {
    if (!word.starts_with(prefix.letter)) continue;
    for (const Name& name : kNames) {
      if (name.text == word.substr(1) && prefixed(prefix, name)) return product({prefix.factor}, name.scale);
    }
  }
  if (word.size() < 2) return std::nullopt;
  for (const Name& name : kNames) {
    if (lower(name.text) == lower(word)) return name.scale;
  }
  return std::nullopt;
}

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

/// " (did you mean 'hr'?)", or nothing where no name is near.
std::string suggestion(std::string_view word) {
  std::string best;
  int best_distance = 1 + static_cast<int>(word.size() / 4);
  const auto offer = [&](const std::string& candidate) {
    const auto longer = static_cast<int>(candidate.size()) - static_cast<int>(word.size());
    if (std::abs(longer) > best_distance) return;  // at least so many letters to add or drop
    const int distance = edit_distance(lower(word), lower(candidate));
    if (distance < best_distance || (best.empty() && distance == best_distance)) {
      best = candidate;
      best_distance = distance;
    }
  };
  for (const Name& name : kNames) offer(std::string(name.text));
  for (const Name& name : kNames) {
    for (const Prefix& prefix : kPrefixes) {
      if (prefixed(prefix, name)) offer(prefix.letter + std::string(name.text));
    }
  }
  return best.empty() ? best : fmt::format(" (did you mean '{}'?)", best);
}

// --- Unicode to ASCII --------------------------------------------------------------------------------------

struct Spelling {
  std::string_view from, to;
};
constexpr Spelling kSigns[] = {{"°", "deg"},    {"º", "deg"},    {"˚", "deg"},     {"′", "arcmin"},  {"″", "arcsec"},
                               {"’", "arcmin"}, {"”", "arcsec"}, {"''", "arcsec"}, {"\"", "arcsec"}, {"'", "arcmin"},
                               {"µ", "u"},      {"μ", "u"},      {"√", " sqrt "},  {"·", "*"},       {"⋅", "*"},
                               {"×", "*"},      {"∙", "*"},      {"•", "*"},       {"∕", "/"},       {"⁄", "/"},
                               {"−", "-"},      {"–", "-"},      {"‑", "-"},       {"\u00a0", " "},  {"\u2009", " "},
                               {"\u202f", " "}, {"\t", " "}};
constexpr Spelling kSuperscripts[] = {{"⁻", "-"}, {"⁺", "+"}, {"⁰", "0"},  {"¹", "1"}, {"²", "2"},
                                      {"³", "3"}, {"⁴", "4"}, {"⁵", "5"},  {"⁶", "6"}, {"⁷", "7"},
                                      {"⁸", "8"}, {"⁹", "9"}, {"½", "1/2"}};

template <std::size_t n>
const Spelling* find_spelling(const Spelling (&table)[n], std::string_view text) {
  const auto* found = std::ranges::find_if(table, [&](const Spelling& s) { return text.starts_with(s.from); });
  return found == std::end(table) ? nullptr : found;
}

std::string to_ascii(std::string_view text) {
  std::string result;
  bool raised = false;
  while (!text.empty()) {
    const Spelling* superscript = find_spelling(kSuperscripts, text);
    const Spelling* sign = superscript ? superscript : find_spelling(kSigns, text);
    if (superscript && !raised && !result.ends_with('^')) result += '^';
    raised = superscript != nullptr;
    result += sign ? sign->to : text.substr(0, 1);
    text.remove_prefix(sign ? sign->from.size() : 1);
  }
  return result;
}

/// The beginning of a text that may be anything, fit for a message.
std::string excerpt(std::string_view text) {
  constexpr std::size_t kShown = 60;
  std::string result(text.substr(0, kShown));
  std::ranges::replace_if(
      result, [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text.size() > kShown ? result + "..." : result;
}

// --- Grammar -----------------------------------------------------------------------------------------------

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

constexpr std::size_t kLongestUnit = 200;  // bytes; bounds the depth of nesting too

/// Recursive descent over the ASCII form; see the grammar in the header.
class Parser {
 public:
  explicit Parser(std::string_view original) : original_(original), text_(to_ascii(original)) {}

  Unit parse() {
    skip_blanks();
    if (rest().empty()) fail("there is no unit; write 1 for a plain number");
    const Scale scale = product_of_factors();
    if (!rest().empty()) fail(fmt::format("found '{}' behind a complete unit", excerpt(rest())));
    return {static_cast<double>(scale.factor),
            {static_cast<std::int8_t>(scale.angle), static_cast<std::int8_t>(scale.length),
             static_cast<std::int8_t>(scale.time), static_cast<std::int8_t>(scale.mass),
             static_cast<std::int8_t>(scale.temperature)}};
  }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw std::invalid_argument(fmt::format("unit '{}': {}", excerpt(original_), reason));
  }

  /// Refuses what no sensor has, before an int or a double overflows.
  const Scale& bounded(const Scale& scale) const {
    const auto fits = [](int exponent) { return std::abs(exponent) <= std::numeric_limits<std::int8_t>::max(); };
    if (!std::isnormal(static_cast<double>(scale.factor)) || !fits(scale.angle) || !fits(scale.length) ||
        !fits(scale.time) || !fits(scale.mass) || !fits(scale.temperature)) {
      fail("its size or powers are beyond reason");
    }
    return scale;
  }

  std::string_view rest() const { return std::string_view(text_).substr(at_); }
  char next(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }
  void skip_blanks() {
    while (next() == ' ') ++at_;
  }
  bool accept(std::string_view token) {
    skip_blanks();
    if (!rest().starts_with(token)) return false;
    at_ += token.size();
    skip_blanks();
    return true;
  }

  Scale product_of_factors() {
    Scale result = factor();
    for (;;) {
      skip_blanks();
      const bool divide = accept("/") || accept_word("per");
      if (divide) {
        result = bounded(product(result, power(factor(), -2)));
      } else if (accept("*") || accept_hyphen() || accept_dot() || is_letter(next()) || next() == '(' ||
                 next() == '%') {
        result = bounded(product(result, factor()));
      } else {
        return result;
      }
    }
  }

  Scale factor() {
    skip_blanks();
    if (accept("(")) {
      const Scale inner = product_of_factors();
      if (!accept(")")) fail("a parenthesis is not closed");
      return with_power(inner);
    }
    if (next() == '1' && !is_digit(next(1)) && next(1) != '.') {
      ++at_;
      return with_power(Scale{});
    }
    const std::string_view word = take_word();
    if (word.empty()) fail_at_next();
    if (const auto named = find_name(word)) return with_power(*named);
    for (const std::string_view root : {"sqrt", "root", "rt"}) {
      if (lower(word.substr(0, root.size())) == root) return root_of_rest(word.size() - root.size());
    }
    fail_unknown(word);
  }

  /// Square root of the factor that starts `unread` letters back or, after an optional hyphen, here.
  Scale root_of_rest(std::size_t unread) {
    at_ -= unread;
    accept("-");
    const Scale radicand = factor();
    if (radicand.angle % 2 != 0 || radicand.length % 2 != 0 || radicand.time % 2 != 0 || radicand.mass % 2 != 0 ||
        radicand.temperature % 2 != 0) {
      fail("a fourth root is in no unit of a sensor");
    }
    return power(radicand, 1);
  }

  /// Letters, or a percent sign; "arc sec" and "arc-sec" are one word.
  std::string_view take_word() {
    const std::size_t start = at_;
    if (next() == '%') return std::string_view(text_).substr(at_++, 1);
    while (is_letter(next())) ++at_;
    if (text_.substr(start, at_ - start) == "deg" && next() == ' ' && next(1) == 'C' && !is_letter(next(2))) {
      text_.erase(at_, 1);  // "deg C" is no product
      ++at_;
    }
    if (lower(text_.substr(start, at_ - start)) == "arc" && (next() == ' ' || next() == '-') && is_letter(next(1))) {
      text_.erase(at_, 1);
      while (is_letter(next())) ++at_;
    }
    return std::string_view(text_).substr(start, at_ - start);
  }

  bool accept_word(std::string_view word) {
    if (lower(rest().substr(0, word.size())) != word || is_letter(next(word.size()))) return false;
    at_ += word.size();
    return true;
  }

  bool accept_hyphen() {
    if (next() != '-' || !is_letter(next(1))) return false;
    ++at_;
    return true;
  }

  // m.s^-2, where no number goes on.
  bool accept_dot() {
    if (next() != '.' || !is_letter(next(1))) return false;
    ++at_;
    return true;
  }

  Scale with_power(const Scale& base) {
    const bool bare = is_digit(next()) || ((next() == '-' || next() == '+') && is_digit(next(1)));
    if (!bare && !accept("^") && !accept("**")) return base;
    const bool parenthesis = !bare && accept("(");
    const int halves = exponent();
    if (parenthesis && !accept(")")) fail("a parenthesis is not closed");
    const auto whole = [&](int doubled) { return doubled * halves % 2 == 0; };
    if (!whole(base.angle) || !whole(base.length) || !whole(base.time) || !whole(base.mass) || !whole(base.temperature))
      fail("a fourth root is in no unit of a sensor");
    return bounded(power(base, halves));
  }

  /// Twice the exponent: 2 -> 4, -1/2 -> -1, 1.5 -> 3.
  int exponent() {
    const bool negative = next() == '-';
    if (negative || next() == '+') ++at_;
    double value = number();
    if (next() == '/' && is_digit(next(1))) {
      ++at_;
      value /= number();
    }
    constexpr double kLargest = 16;
    if (!(value <= kLargest) || 2 * value != std::floor(2 * value)) {
      fail(fmt::format("an exponent must be a whole or half number up to {}", kLargest));
    }
    return static_cast<int>(2 * value) * (negative ? -1 : 1);
  }

  double number() {
    double value = 0;
    if (!is_digit(next())) fail("an exponent is missing or unreadable");
    const char* begin = text_.data() + at_;
    const auto [end, error] = std::from_chars(begin, text_.data() + text_.size(), value, std::chars_format::fixed);
    if (error != std::errc{}) fail("an exponent is unreadable");
    at_ += static_cast<std::size_t>(end - begin);
    return value;
  }

  [[noreturn]] void fail_at_next() const {
    if (rest().empty()) fail("it stops where a name was expected");
    fail(fmt::format("found '{}' where a name was expected", excerpt(rest())));
  }

  [[noreturn]] void fail_unknown(std::string_view word) const {
    if (std::ranges::find(kWithoutSize, lower(word)) != std::end(kWithoutSize)) {
      fail(fmt::format("'{}' has no size of its own; give the size of one as a scale (--scale) and its unit", word));
    }
    fail(fmt::format("'{}' is no known unit{}", excerpt(word), suggestion(word)));
  }

  std::string_view original_;
  std::string text_;
  std::size_t at_ = 0;
};

std::string_view trim(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

struct Example {
  Dimension dimension;
  std::string_view units;
};
constexpr Example kExamples[] = {
    {dimension::kNumber, "1, %, ppm"},
    {dimension::kTime, "s, ms, h"},
    {dimension::kFrequency, "Hz, kHz"},
    {dimension::kAngle, "arcsec, deg, rad"},
    {dimension::kAngularRate, "deg/h, deg/s, rad/s"},
    {{2, 0, -1}, "deg/sqrt(h), deg/h/sqrt(Hz), rad/s/sqrt(Hz)"},
    {{2, 0, -3}, "deg/h/sqrt(h), rad/s/sqrt(s), rad/s^2/sqrt(Hz)"},
    {{2, 0, -4}, "deg/h/h, rad/s^2"},
    {{2, -2, 2}, "deg/h/g, rad/s/(m/s^2)"},
    {dimension::kVelocity, "m/s, ft/s"},
    {dimension::kSpecificForce, "ug, mg, g, m/s^2"},
    {{0, 2, -3}, "m/s/sqrt(h), ug/sqrt(Hz), m/s^2/sqrt(Hz)"},
    {{0, 2, -5}, "ug/sqrt(h), m/s^2/sqrt(s), m/s^3/sqrt(Hz)"},
    {{0, 2, -6}, "ug/h, m/s^3"},
    {dimension::kLength, "m, cm, ft"},
    {dimension::kArea, "m^2"},
    {dimension::kMass, "kg, t"},
    {dimension::kForce, "N, kN"},
    {dimension::kMoment, "N m, kN m"},
    {dimension::kInertia, "kg m^2"},
    {dimension::kTemperature, "degC, K"},
    {{2, 0, -2, 0, -2}, "deg/h/K, rad/s/K"},
    {{2, 0, -2, 0, -4}, "deg/h/K^2, rad/s/K^2"},
    {{2, 0, 0, 0, -2}, "deg/h/(K/min), rad/K"},
    {{0, 2, -4, 0, -2}, "ug/K, m/s^2/K"},
    {{0, 2, -4, 0, -4}, "ug/K^2, m/s^2/K^2"},
    {{0, 2, -2, 0, -2}, "ug/(K/min), m/s/K"},
    {{0, -2, -4, 2}, "Pa, kPa"},
    {{-2, 0, 0}, "1/rad, 1/deg"},
    {{2, -2, 0}, "rad/m, deg/m"},
    {{0, 0, 1}, "1/sqrt(Hz)"},
    {{0, 0, -1}, "1/sqrt(s)"},
};

/// A number with trailing zeros up to `digits` significant ones, and no dot without digits behind it.
std::string significant(double value, int digits) {
  if (value == 0) return "0";
  std::string text = fmt::format("{:#.{}g}", value, digits);
  const std::size_t first = text.find_first_not_of("-0."), dot = text.find('.');
  if (dot != std::string::npos && first < dot && dot - first >= static_cast<std::size_t>(digits)) {
    text.erase(dot, text.find_first_not_of("0123456789", dot + 1) - dot);
  }
  return text;
}

}  // namespace

Unit parse_unit(std::string_view text) {
  if (text.size() > kLongestUnit) {
    throw std::invalid_argument(
        fmt::format("unit '{}' is {} bytes long; at most {} are read", excerpt(text), text.size(), kLongestUnit));
  }
  return Parser(text).parse();
}

double parse_quantity(std::string_view text, const Dimension& expected) {
  const std::string_view trimmed = trim(text);
  const std::string_view digits = trimmed.substr(trimmed.starts_with('+') && !trimmed.starts_with("+-") ? 1 : 0);
  double number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || !std::isfinite(number)) {
    throw std::invalid_argument(
        fmt::format("'{}' does not start with a finite number; expected a number and a unit ({})", excerpt(text),
                    example_units(expected)));
  }
  const std::string_view unit_text = trim(digits.substr(static_cast<std::size_t>(end - digits.data())));
  if (unit_text.empty()) {
    throw std::invalid_argument(
        fmt::format("'{}' has no unit; expected one like {}", excerpt(text), example_units(expected)));
  }
  const Unit unit = parse_unit(unit_text);
  if (unit.dimension != expected) {
    throw std::invalid_argument(fmt::format("'{}' has a unit of the wrong kind (the kind of {}); expected one like {}",
                                            excerpt(text), example_units(unit.dimension), example_units(expected)));
  }
  const double si = number * unit.to_si;
  if (!std::isfinite(si))
    throw std::invalid_argument(fmt::format("'{}' is beyond the range of numbers", excerpt(text)));
  return si;
}

std::string example_units(const Dimension& dimension) {
  for (const Example& example : kExamples) {
    if (example.dimension == dimension) return std::string(example.units);
  }
  std::string result;
  for (const auto& [name, doubled] : {std::pair{"rad", dimension.angle},
                                      {"m", dimension.length},
                                      {"s", dimension.time},
                                      {"kg", dimension.mass},
                                      {"K", dimension.temperature}}) {
    if (doubled == 0) continue;
    result += fmt::format("{}{}^{}", result.empty() ? "" : " ", name, doubled / 2.0);
  }
  return result;
}

std::string quantity_text(double si, std::string_view unit, int digits) {
  constexpr int kMostDigits = std::numeric_limits<double>::max_digits10;
  if (digits < 1 || digits > kMostDigits) {
    throw std::invalid_argument(
        fmt::format("{} significant digits asked for; 1 to {} can be had", digits, kMostDigits));
  }
  const std::string number = significant(from_si(si, unit), digits);
  return unit == "1" ? number : fmt::format("{} {}", number, unit);
}

double from_si(double si, std::string_view unit) { return si / parse_unit(unit).to_si; }

}  // namespace gyrobudget::inline v0::noise

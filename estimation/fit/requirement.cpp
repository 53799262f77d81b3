// SPDX-License-Identifier: MIT
#include "requirement.h"

#include "gyrobudget/noise/sensor.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

constexpr std::array kQuantities{
    std::pair{"rmse", Quantity::rmse},
    std::pair{"bias", Quantity::bias},
    std::pair{"coverage", Quantity::coverage},
    std::pair{"coverage_identified", Quantity::coverage_identified},
    std::pair{"identified", Quantity::identified},
    std::pair{"missed", Quantity::missed},
    std::pair{"false_terms", Quantity::false_terms},
    std::pair{"p05", Quantity::p05},
    std::pair{"p01", Quantity::p01},
    std::pair{"unconverged", Quantity::unconverged},
    std::pair{"seconds", Quantity::seconds},
};
constexpr std::array kTerms{Term::quantization, Term::white,        Term::flicker, Term::rate_random_walk,
                            Term::rate_ramp,    Term::gauss_markov, Term::sinusoid};

bool of_method(Quantity q) { return q >= Quantity::false_terms; }

std::optional<Method> find_method(std::string_view word) {
  const auto at = std::find_if(kMethods.begin(), kMethods.end(), [=](Method m) { return name(m) == word; });
  return at == kMethods.end() ? std::nullopt : std::optional(*at);
}

std::optional<Term> find_term(std::string_view word) {
  for (const Term t : kTerms) {
    if (word.size() == 1 && word.front() == static_cast<char>(t)) return t;
    for (const auto signal :
         {noise::Signal::angular_rate, noise::Signal::specific_force, noise::Signal::dimensionless}) {
      if (t != Term::gauss_markov && t != Term::sinusoid && noise::key(signal, t) == word) return t;
    }
  }
  return std::nullopt;
}

std::optional<Quantity> find_quantity(std::string_view word) {
  for (const auto& [text, quantity] : kQuantities) {
    if (word == text) return quantity;
  }
  return std::nullopt;
}

std::string quantities() {
  std::vector<std::string_view> words;
  for (const auto& [text, quantity] : kQuantities) words.emplace_back(text);
  return fmt::format("{}", fmt::join(words, ", "));
}

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  std::vector<Requirement> all() {
    std::vector<Requirement> list;
    do {
      list.push_back(one());
    } while (take(","));
    if (at_ < text_.size()) fail(at_, "expected a comma or the end");
    return list;
  }

 private:
  [[noreturn]] void fail(std::size_t at, const std::string& why) const {
    const auto found = at < text_.size() ? fmt::format("'{}'", text_.substr(at, 20)) : std::string("the end");
    throw std::invalid_argument(fmt::format("requirement \"{}\", column {}: found {}; {}", text_, at + 1, found, why));
  }

  void skip_spaces() {
    while (at_ < text_.size() && text_[at_] == ' ') ++at_;
  }

  bool take(std::string_view token) {
    skip_spaces();
    if (!text_.substr(at_).starts_with(token)) return false;
    at_ += token.size();
    return true;
  }

  std::string_view word() {
    skip_spaces();
    const std::size_t start = at_;
    const auto belongs = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    };
    while (at_ < text_.size() && belongs(text_[at_])) ++at_;
    return text_.substr(start, at_ - start);
  }

  // A number ends before ".." of a range.
  double number() {
    skip_spaces();
    auto part = text_.substr(at_);
    part = part.substr(0, part.find(".."));
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc() || !std::isfinite(value)) fail(at_, "expected a number");
    at_ += static_cast<std::size_t>(end - part.data());
    return value;
  }

  void subject(Requirement& r) {
    for (;;) {
      skip_spaces();
      const std::size_t start = at_;
      const auto text = word();
      if (const auto quantity = find_quantity(text)) {
        r.quantity = *quantity;
        if (of_method(*quantity) && r.term) fail(start, "this is of a method, not of a coefficient");
        return;
      }
      const auto method = find_method(text);
      const auto term = find_term(text);
      if (method && !r.method && !r.term) {
        r.method = method;
      } else if (term && !r.term) {
        r.term = term;
      } else {
        fail(start, fmt::format("expected a quantity ({}), or a method or coefficient before it", quantities()));
      }
      if (!take(".")) fail(at_, "expected '.' and a quantity");
    }
  }

  void limits(Requirement& r) {
    r.low = -kInfinity, r.high = kInfinity;
    if (take("in ")) {
      r.low = number();
      if (!take("..")) fail(at_, "expected '..' and the upper limit");
      const std::size_t start = at_;
      r.high = number();
      if (r.high < r.low) fail(start, "the upper limit is below the lower");
      return;
    }
    const bool below = take("<");
    if (!below && !take(">")) fail(at_, "expected <, <=, >, >= or 'in LOW..HIGH'");
    r.strict = !take("=");
    (below ? r.high : r.low) = number();
    if (!take("*")) return;
    skip_spaces();
    const std::size_t start = at_;
    const auto unit = word();
    if (r.quantity != Quantity::rmse) fail(start, "only rmse is measured against crlb or likelihood");
    if (unit != "crlb" && unit != "likelihood") fail(start, "expected crlb or likelihood");
    r.relative = unit == "crlb" ? Requirement::Relative::bound : Requirement::Relative::likelihood;
  }

  Requirement one() {
    Requirement r;
    skip_spaces();
    const std::size_t start = at_;
    subject(r);
    limits(r);
    r.text = text_.substr(start, at_ - start);
    skip_spaces();
    return r;
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

double value_of(const Requirement& r, const CoefficientAccuracy& c) {
  switch (r.quantity) {
    case Quantity::rmse:
      if (r.relative == Requirement::Relative::bound) return c.rmse / c.bound;
      return r.relative == Requirement::Relative::likelihood ? c.over_likelihood : c.rmse;
    case Quantity::bias:
      return std::abs(c.bias);
    case Quantity::coverage:
      return c.coverage;
    case Quantity::coverage_identified:
      return c.coverage_identified;
    case Quantity::identified:
      return c.identified;
    case Quantity::missed:
      return c.missed;
    default:
      return kNaN;
  }
}

double value_of(Quantity q, const MethodAccuracy& m) {
  switch (q) {
    case Quantity::false_terms:
      return m.false_terms;
    case Quantity::p05:
      return m.p_below_5_percent;
    case Quantity::p01:
      return m.p_below_1_percent;
    case Quantity::unconverged:
      return m.unconverged;
    case Quantity::seconds:
      return m.seconds_per_fit;
    default:
      return kNaN;
  }
}

Check judged(const Requirement& r, Method method, std::optional<Term> term, double value) {
  const bool met = r.strict ? value > r.low && value < r.high : value >= r.low && value <= r.high;
  return {r.text, method, term, value, r.low, r.high, met};
}

}  // namespace

std::vector<Requirement> parse_requirements(std::string_view text) { return Reader(text).all(); }

std::vector<Check> check(const std::vector<Requirement>& requirements, const Accuracy& accuracy) {
  std::vector<Check> checks;
  for (const Requirement& r : requirements) {
    const std::size_t before = checks.size();
    const auto m = std::find_if(accuracy.methods.begin(), accuracy.methods.end(),
                                [&](const auto& x) { return !r.method || x.method == *r.method; });
    if (m != accuracy.methods.end() && of_method(r.quantity)) {
      checks.push_back(judged(r, m->method, {}, value_of(r.quantity, *m)));
    } else if (m != accuracy.methods.end()) {
      for (const CoefficientAccuracy& c : m->coefficients) {
        if (r.term ? c.term == *r.term : c.truth > 0) checks.push_back(judged(r, m->method, c.term, value_of(r, c)));
      }
    }
    if (checks.size() == before) checks.push_back(judged(r, r.method.value_or(Method::gls), r.term, kNaN));
  }
  return checks;
}

}  // namespace gyrobudget::inline v0::fit

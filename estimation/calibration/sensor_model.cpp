// SPDX-License-Identifier: MIT
#include "sensor_model.h"

#include "gyrobudget/estimation/fit/combine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::calibration {
namespace {

using fit::Coefficient;
using noise::PerAxis;
using noise::Signal;
using noise::Term;

constexpr std::size_t kAxes = 3;
constexpr std::array kTerms{Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp};
constexpr double kInterval = 2 * 1.959963984540054;  // standard deviations of a 95 % interval

double to_digits(double value, int digits = 6) { return std::stod(fmt::format("{:.{}g}", value, digits)); }

double rounded(double si, Signal signal, Term term) {
  const auto unit = noise::datasheet_unit(signal, term);
  return to_digits(noise::from_si(si, unit)) * noise::parse_unit(unit).to_si;
}

/// What one axis of a record, or of a sensor type, has.
struct Axis {
  std::string name;
  Signal signal;
  bool answers;
  fit::Result fit;
  const Temperature* temperature = nullptr;                         // that was taken off
  std::vector<std::optional<fit::FittedFrontEnd>> front_ends = {};  // of each record
};

bool is_identified(const Coefficient& c) { return c.status == fit::Status::identified; }

const Coefficient* fitted(const Axis& axis, Term term) {
  const auto& list = axis.fit.coefficients;
  const auto at = std::ranges::find(list, term, &Coefficient::term);
  return at != list.end() && at->fitted && at->status != fit::Status::not_quotable ? &*at : nullptr;
}

/// The axis has the term, and its record cannot give it.
bool is_not_quotable(const Axis& axis, Term term) {
  return std::ranges::any_of(axis.fit.coefficients, [&](const Coefficient& c) {
    return c.term == term && c.fitted && c.status == fit::Status::not_quotable;
  });
}

std::vector<Axis> axes_of(const Datasheet& sheet) {
  std::vector<Axis> axes;
  for (const AxisDatasheet& a : sheet.axes)
    axes.push_back({a.name,
                    a.signal,
                    a.has_answer(),
                    a.fit,
                    a.temperature && a.temperature->removed ? &*a.temperature : nullptr,
                    {a.fit.front_end}});
  return axes;
}

std::vector<Axis> axes_of(const TypeDatasheet& sheet) {
  std::vector<Axis> axes;
  for (const CombinedAxis& a : sheet.axes) {
    Axis& axis = axes.emplace_back(Axis{a.name, a.signal, !a.coefficients.empty(), {}});
    for (const Datasheet& record : sheet.records) {
      for (const AxisDatasheet& own : record.axes)
        if (own.name == a.name && own.has_answer()) axis.front_ends.push_back(own.fit.front_end);
    }
    for (const Term t : kTerms) {
      Coefficient& c = axis.fit.coefficients.emplace_back(Coefficient{.term = t});
      const auto at = std::ranges::find(a.coefficients, t, &fit::Combined::term);
      if (at == a.coefficients.end()) continue;
      c.value = at->value, c.lower = at->lower, c.upper = c.upper_two_sided = at->upper;
      const bool seen = at->lower > 0 || 2 * at->identified > at->records;
      c.status = seen ? fit::Status::identified : fit::Status::upper_bound;
      c.boundary_test = seen ? std::numeric_limits<double>::infinity() : 0;
      c.fitted = true;
    }
  }
  return axes;
}

/// Which of x, y, z each axis is; empty where that is not told.
std::vector<std::size_t> places_of(const std::vector<Axis>& axes) {
  if (axes.size() > kAxes) return {};
  std::vector<std::size_t> places;
  for (const Axis& axis : axes) {
    const char last = axis.name.empty() ? ' ' : static_cast<char>(std::tolower(axis.name.back()));
    const auto place = static_cast<std::size_t>(last - 'x');
    if (last < 'x' || last > 'z' || std::ranges::find(places, place) != places.end()) {
      if (axes.size() == kAxes) return {0, 1, 2};
      return {};
    }
    places.push_back(place);
  }
  return places;
}

/// Of the axes whose temperature was taken off: each its own, where there are three in all; else that of the one.
std::optional<noise::TemperatureModel> temperature_model(const std::vector<Axis>& axes, Signal signal) {
  if (axes.size() != 1 && axes.size() != kAxes) return std::nullopt;
  const auto places = places_of(axes);
  std::array<const Temperature*, kAxes> each{};
  std::optional<noise::TemperatureModel> model;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const Temperature* t = axes[i].temperature;
    if (t == nullptr) continue;
    if (axes.size() == 1)
      each.fill(t);  // one axis stands for all
    else
      each.at(places[i]) = t;
    if (!model) model.emplace().reference = to_digits(t->reference);
  }
  if (!model) return model;
  const auto of = [&](TemperatureCoefficient Temperature::*member, const char* over) {
    const double unit = noise::parse_unit(std::string(noise::datasheet_unit(signal)) + over).to_si;
    const auto one = [&](const Temperature* t) {
      return t != nullptr ? to_digits((t->*member).value / unit) * unit : 0;
    };
    return PerAxis(one(each[0]), one(each[1]), one(each[2]));
  };
  model->linear = of(&Temperature::linear, "/K");
  model->quadratic = of(&Temperature::quadratic, "/K^2");
  model->rate = of(&Temperature::rate, "/(K/min)");
  return model;
}

/// p-value of the positive values of two or three axes being one, on the scale of logarithms: that of chi-square with
/// one or two degrees of freedom.
double alike(const std::vector<Coefficient>& list, double Coefficient::*value, double Coefficient::*lower,
             double Coefficient::*upper) {
  double sum = 0, weights = 0, squares = 0;
  for (const Coefficient& c : list) {
    const double low = c.*lower > 0 ? std::log(c.*lower) : 2 * std::log(c.*value) - std::log(c.*upper);
    const double std = (std::log(c.*upper) - low) / kInterval;
    if (!(std > 0) || !std::isfinite(std))  // given, or not bounded by the record: the same number or not
      return std::ranges::all_of(list, [&](const Coefficient& o) { return o.*value == list.front().*value; }) ? 1 : 0;
    const double w = 1 / (std * std), x = std::log(c.*value);
    sum += w * x, weights += w, squares += w * x * x;
  }
  const double q = std::max(0.0, squares - sum * sum / weights);
  return list.size() == 2 ? std::erfc(std::sqrt(q / 2)) : std::exp(-q / 2);
}

/// The axes of one kind, with those that answer and where they belong.
class Triad {
 public:
  Triad(std::vector<Axis> axes, Signal signal) : signal_(signal), all_(axes.size()) {
    const auto places = places_of(axes);
    has_places_ = !places.empty();
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if (!axes[i].answers) continue;
      if (has_places_) places_.push_back(places[i]);
      axes_.push_back(std::move(axes[i]));
    }
    if (axes_.size() < 2 || !has_places_) return;
    std::vector<fit::Result> fits;
    for (const Axis& axis : axes_) {
      for (const Term term : kTerms)  // a value without an interval has no scatter to compare with
        if (const Coefficient* c = fitted(axis, term); c && !(c->upper_two_sided > c->lower)) return;
      fits.push_back(axis.fit);
    }
    combined_ = fit::combine(fits);
  }

  [[nodiscard]] bool empty() const { return axes_.empty(); }
  [[nodiscard]] bool lacks_places() const { return !has_places_ && axes_.size() > 1; }

  void summarise(noise::ErrorModel& model, noise::ErrorModel& limits, std::vector<TriadCoefficient>& told) const {
    for (const Term term : kTerms) coefficient(term, model, limits, told);
    gauss_markov(model, told);
    sinusoid(model, told);
  }

  /// The one low pass of all axes and records; none where there is not one.
  [[nodiscard]] std::optional<noise::FrontEnd> filter() const {
    constexpr double kFar = 3.3;     // standard deviations: 1 in 1000 is further off
    constexpr double kGiven = 1e-9;  // deviation of a bandwidth that was given, not found
    double sum = 0, weights = 0;
    const auto deviation = [&](const fit::FittedFrontEnd& f) {
      return std::max(kGiven, std::log(f.upper / f.lower) / kInterval);
    };
    const auto all = front_ends();
    for (const auto& f : all) {
      if (!f || !f->kind || f->kind != all.front()->kind) return std::nullopt;
      const double weight = std::pow(deviation(*f), -2);
      sum += weight * std::log(f->bandwidth), weights += weight;
    }
    if (all.empty()) return std::nullopt;
    const double mean = sum / weights;
    for (const auto& f : all)
      if (!(std::abs(std::log(f->bandwidth) - mean) <= kFar * deviation(*f))) return std::nullopt;
    return noise::FrontEnd{*all.front()->kind, to_digits(std::exp(mean)), noise::FrontEnd::Sampling::held};
  }
  [[nodiscard]] bool is_filtered() const {
    return std::ranges::any_of(front_ends(), [](const auto& f) { return f.has_value(); });
  }

  [[nodiscard]] std::vector<std::string> borrowed() const {
    std::vector<std::string> names;
    if (!has_places_ || axes_.empty() || all_ == 0) return names;
    const char* triad = signal_ == Signal::angular_rate ? "gyro" : "accelerometer";
    for (std::size_t place = 0; place < kAxes; ++place)
      if (std::ranges::find(places_, place) == places_.end())
        names.push_back(fmt::format("{} {}", triad, "xyz"[place]));
    return names;
  }

 private:
  [[nodiscard]] std::vector<std::optional<fit::FittedFrontEnd>> front_ends() const {
    std::vector<std::optional<fit::FittedFrontEnd>> all;
    for (const Axis& axis : axes_) all.insert(all.end(), axis.front_ends.begin(), axis.front_ends.end());
    return all;
  }
  [[nodiscard]] bool can_differ() const { return has_places_ && axes_.size() > 1; }
  [[nodiscard]] double over_axes() const { return 1 / std::sqrt(static_cast<double>(axes_.size())); }

  /// A value for each axis; those that the record tells nothing of have the root mean square.
  [[nodiscard]] PerAxis spread(const std::vector<double>& values, Term term) const {
    double squares = 0;
    for (const double v : values) squares += v * v;
    PerAxis result = rounded(std::sqrt(squares) * over_axes(), signal_, term);
    for (std::size_t i = 0; i < values.size(); ++i) result[places_[i]] = rounded(values[i], signal_, term);
    return result;
  }
  [[nodiscard]] PerAxis pooled(const std::vector<double>& values, Term term) const {
    double size = 0;
    for (const double v : values) size = std::hypot(size, v);
    return rounded(size * over_axes(), signal_, term);
  }

  /// Gives the `open` ones, which are 0, the root mean square of the others.
  static void fill_in(std::vector<double>& values, const std::vector<std::size_t>& open) {
    double squares = 0;
    for (const double v : values) squares += v * v;
    const double size = std::sqrt(squares / static_cast<double>(values.size() - open.size()));
    for (const std::size_t i : open) values[i] = size;
  }

  void coefficient(Term term, noise::ErrorModel& model, noise::ErrorModel& limits,
                   std::vector<TriadCoefficient>& told) const {
    std::vector<double> values, uppers;
    std::vector<double> tests;      // of zero, by the axes that were fitted with it
    std::vector<std::size_t> open;  // axes that have it in a size that their record cannot give
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const Axis& axis = axes_[i];
      const Coefficient* c = fitted(axis, term);
      // What a model that is off a little adds to a test is no evidence.
      if (c) tests.push_back(axis.fit.verdict == fit::Verdict::described || is_identified(*c) ? c->boundary_test : 0);
      if (is_not_quotable(axis, term)) open.push_back(i);
      values.push_back(c ? c->value : 0);
      uppers.push_back(c && std::isfinite(c->upper) ? c->upper : 0);
    }
    if (tests.empty()) return;
    TriadCoefficient t{.signal = signal_, .term = term};
    const auto at = std::ranges::find(combined_, term, &fit::Combined::term);
    if (at != combined_.end()) t.p_value = at->p_value;
    t.per_axis = can_differ() && (tests.size() + open.size() < axes_.size() || t.p_value < kAxesDiffer);
    fill_in(values, open);
    model[term] = t.per_axis ? spread(values, term) : pooled(values, term);
    if (t.per_axis) {
      for (std::size_t i = 0; i < axes_.size(); ++i)
        if (const Coefficient* c = fitted(axes_[i], term); c && is_identified(*c)) uppers[i] = 0;
      fill_in(uppers, open);
      limits[term] = spread(uppers, term);
    } else if (!resolved_together(tests)) {
      fill_in(uppers, open);
      limits[term] = pooled(uppers, term);
    }
    told.push_back(t);
  }

  /// Zero is excluded by all axes together, at 5 %: of three without the term one shows it by chance in 14 % of
  /// records. The sum of n boundary tests is chi-square with k degrees of freedom in binom(n, k)/2^n of cases (Shapiro,
  /// Biometrika 72 (1985) 133); beyond three axes, which have no places, it is approximated by its mean and variance.
  static bool resolved_together(const std::vector<double>& tests) {
    constexpr std::array kCuts{2.706, 4.231, 5.435};
    const auto n = static_cast<double>(tests.size());
    const double cut = tests.size() <= kCuts.size() ? kCuts.at(tests.size() - 1) : n / 2 + 1.9 * std::sqrt(1.25 * n);
    return std::accumulate(tests.begin(), tests.end(), 0.0) > cut;
  }

  void gauss_markov(noise::ErrorModel& model, std::vector<TriadCoefficient>& told) const {
    const auto found = of(Term::gauss_markov);
    if (found.empty()) return;
    TriadCoefficient t{.signal = signal_, .term = Term::gauss_markov};
    if (found.size() > 1 && has_places_)
      t.p_value = std::min(size_alike(found), alike(values_of(found), &Coefficient::shape, &Coefficient::shape_lower,
                                                    &Coefficient::shape_upper));
    t.per_axis = can_differ() && (found.size() < axes_.size() || t.p_value < kAxesDiffer);
    if (!t.per_axis && !lacks_places()) {
      double log_time = 0;
      for (const auto& [axis, c] : found) log_time += std::log(c.shape) / static_cast<double>(found.size());
      model.gauss_markov.push_back({pooled(sizes_of(found), Term::gauss_markov), to_digits(std::exp(log_time))});
    } else {
      for (const auto& [axis, c] : found)
        model.gauss_markov.push_back({of_axis(axis, c.value, Term::gauss_markov), to_digits(c.shape)});
    }
    told.push_back(t);
  }

  void sinusoid(noise::ErrorModel& model, std::vector<TriadCoefficient>& told) const {
    constexpr double kSame = 1e-3;
    constexpr int kDigits = 9;
    auto found = of(Term::sinusoid);
    while (!found.empty()) {
      const double frequency = found.front().coefficient.shape;
      std::vector<Found> line;
      std::erase_if(found, [&](const Found& f) {
        if (std::abs(f.coefficient.shape - frequency) > kSame * frequency) return false;
        line.push_back(f);
        return true;
      });
      TriadCoefficient t{.signal = signal_, .term = Term::sinusoid};
      if (line.size() > 1 && has_places_) t.p_value = size_alike(line);
      t.per_axis = can_differ() && (line.size() < axes_.size() || t.p_value < kAxesDiffer);
      PerAxis amplitude = pooled(sizes_of(line), Term::sinusoid);
      if (t.per_axis) {
        std::vector<double> values(axes_.size());
        for (const auto& [axis, c] : line) values[axis] = c.value;
        amplitude = spread(values, Term::sinusoid);
      }
      model.sinusoids.push_back({amplitude, to_digits(frequency, kDigits)});
      told.push_back(t);
    }
  }

  /// What the axis of this number alone has, and its part of those that the record tells nothing of.
  [[nodiscard]] PerAxis of_axis(std::size_t axis, double value, Term term) const {
    if (!has_places_) return rounded(value * over_axes(), signal_, term);
    std::vector<double> values(axes_.size());
    values[axis] = value;
    return spread(values, term);
  }

  struct Found {
    std::size_t axis;
    Coefficient coefficient;
  };
  [[nodiscard]] std::vector<Found> of(Term term) const {
    std::vector<Found> found;
    for (std::size_t i = 0; i < axes_.size(); ++i)
      if (const Coefficient* c = fitted(axes_[i], term); c && c->value > 0) found.push_back({i, *c});
    return found;
  }
  static std::vector<Coefficient> values_of(const std::vector<Found>& found) {
    std::vector<Coefficient> list;
    for (const Found& f : found) list.push_back(f.coefficient);
    return list;
  }
  static std::vector<double> sizes_of(const std::vector<Found>& found) {
    std::vector<double> list;
    for (const Found& f : found) list.push_back(f.coefficient.value);
    return list;
  }
  static double size_alike(const std::vector<Found>& found) {
    return alike(values_of(found), &Coefficient::value, &Coefficient::lower, &Coefficient::upper_two_sided);
  }

  Signal signal_;
  std::size_t all_;
  bool has_places_ = false;
  std::vector<Axis> axes_;           // that answer
  std::vector<std::size_t> places_;  // of these, where they have one
  std::vector<fit::Combined> combined_;
};

template <class Sheet>
SensorSummary summary_of(const Sheet& sheet, std::string name) {
  SensorSummary result;
  result.sensor.name = std::move(name);
  const std::vector<Axis> axes = axes_of(sheet);
  for (const Signal signal : {Signal::angular_rate, Signal::specific_force}) {
    std::vector<Axis> own;
    std::ranges::copy_if(axes, std::back_inserter(own), [&](const Axis& a) { return a.signal == signal; });
    auto temperature = temperature_model(own, signal);
    const Triad triad(std::move(own), signal);
    if (triad.empty()) continue;
    const bool gyro = signal == Signal::angular_rate;
    noise::ErrorModel& model = gyro ? result.sensor.gyro : result.sensor.accelerometer.emplace();
    noise::ErrorModel& limits = gyro ? result.limits.gyro : result.limits.accelerometer.emplace();
    triad.summarise(model, limits, result.coefficients);
    model.temperature = std::move(temperature);
    model.filter = triad.filter();
    if (!model.filter && triad.is_filtered()) result.without_filter.push_back(signal);
    for (std::string& axis : triad.borrowed()) result.borrowed.push_back(std::move(axis));
    if (triad.lacks_places()) result.without_places.push_back(signal);
  }
  return result;
}

}  // namespace

SensorSummary summarise(const Datasheet& sheet, std::string name) { return summary_of(sheet, std::move(name)); }
SensorSummary summarise(const TypeDatasheet& sheet, std::string name) { return summary_of(sheet, std::move(name)); }

noise::SensorModel sensor_model(const Datasheet& sheet, std::string name) {
  return summarise(sheet, std::move(name)).sensor;
}
noise::SensorModel sensor_model(const TypeDatasheet& sheet, std::string name) {
  return summarise(sheet, std::move(name)).sensor;
}

}  // namespace gyrobudget::inline v0::calibration

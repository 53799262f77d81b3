// SPDX-License-Identifier: MIT
#include "kalibr.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::sensor_file {
namespace {

using noise::ErrorModel;
using noise::SensorModel;
using noise::Signal;
using noise::Term;

/// Where a number comes from.
enum class Origin { none, limit, of_flicker, fitted };

struct Number {
  double value = 0;
  Origin origin = Origin::none;
  std::size_t axis = 0;
};

/// What the file says of one triad.
class Triad {
 public:
  Triad(const ErrorModel& model, const ErrorModel& limits, Signal signal, double horizon_s)
      : model_(model), limits_(limits), signal_(signal), horizon_s_(horizon_s) {}

  [[nodiscard]] std::string text() const {
    const Number white = largest([&](std::size_t i) { return of_term(Term::white, i); });
    const Number walk = largest([&](std::size_t i) { return walk_of(i); });
    return line(white, "noise_density", is_gyro() ? "rad/s/sqrt(Hz)" : "m/s^2/sqrt(Hz)", white_words(white)) +
           line(walk, "random_walk", is_gyro() ? "rad/s^2/sqrt(Hz)" : "m/s^3/sqrt(Hz)", walk_words(walk)) +
           left_out(walk);
  }

 private:
  [[nodiscard]] bool is_gyro() const { return signal_ == Signal::angular_rate; }
  [[nodiscard]] const char* name() const { return is_gyro() ? "gyroscope" : "accelerometer"; }
  [[nodiscard]] std::string quoted(double si, Term term) const {
    return noise::quantity_text(si, noise::datasheet_unit(signal_, term));
  }

  template <class Of>
  static Number largest(const Of& of) {
    Number most;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Number number = of(axis);
      number.axis = axis;
      if (number.value > most.value) most = number;
    }
    return most;
  }

  [[nodiscard]] bool resolved(Term term, std::size_t axis) const {
    return model_[term][axis] > 0 && limits_[term][axis] == 0;
  }
  [[nodiscard]] Number of_term(Term term, std::size_t axis) const {
    if (resolved(term, axis)) return {model_[term][axis], Origin::fitted};
    return limits_[term][axis] > 0 ? Number{limits_[term][axis], Origin::limit} : Number{};
  }
  [[nodiscard]] Number walk_of(std::size_t axis) const {
    if (resolved(Term::rate_random_walk, axis) || !resolved(Term::flicker, axis))
      return of_term(Term::rate_random_walk, axis);
    return {walk_of_flicker(model_.bias_instability[axis], horizon_s_), Origin::of_flicker};
  }

  [[nodiscard]] std::string line(const Number& number, std::string_view key, std::string_view unit,
                                 const std::string& words) const {
    if (number.origin == Origin::none)
      return fmt::format("# {0}_{1} is not known, and 0 would be wrong: fill it in\n# {0}_{1}:  # [{2}]\n", name(), key,
                         unit);
    return fmt::format("# {0}_{1}: {2}\n{0}_{1}: {3}  # [{4}]\n", name(), key, words, number.value, unit);
  }

  /// ", of axis z, which has the largest" where the axes differ.
  [[nodiscard]] std::string of_axis(const Number& number, bool differ) const {
    return differ ? fmt::format(", the largest of the three axes, that of {}", "xyz"[number.axis]) : std::string();
  }

  [[nodiscard]] std::string of(const Number& number, Term term) const {
    const bool differ = !model_[term].is_uniform() || !limits_[term].is_uniform();
    const std::string size = quoted(number.value, term);
    if (number.origin == Origin::fitted)
      return fmt::format("{} as it is, {}{}", noise::label(signal_, term), size, of_axis(number, differ));
    return fmt::format("the record does not resolve {}: this is its 95 % limit, {}{}", noise::label(signal_, term),
                       size, of_axis(number, differ));
  }

  [[nodiscard]] std::string white_words(const Number& white) const { return of(white, Term::white); }

  [[nodiscard]] std::string walk_words(const Number& walk) const {
    if (walk.origin != Origin::of_flicker) return of(walk, Term::rate_random_walk);
    const double b = model_.bias_instability[walk.axis], limit = limits_.rate_random_walk[walk.axis];
    const bool differ = !model_.bias_instability.is_uniform() || !model_.rate_random_walk.is_uniform();
    return fmt::format(
        "no {} is resolved ({}); this one stands for the bias instability of {} over T = {}: B sqrt(6 ln 2/(pi T)), whose Allan deviation at T is the flicker floor{}",
        noise::label(signal_, Term::rate_random_walk),
        limit > 0 ? fmt::format("it is at most {}, 95 %", quoted(limit, Term::rate_random_walk)) : "none was fitted",
        quoted(b, Term::flicker), text::duration_text(horizon_s_), of_axis(walk, differ));
  }

  [[nodiscard]] std::string left_out(const Number& walk) const {
    std::string text;
    const auto say = [&](Term term, const std::string& what, const std::string& why) {
      text += fmt::format("# {} {}: {} has no place in this form{}\n", name(), noise::label(signal_, term), what, why);
    };
    for (const Term t : {Term::flicker, Term::quantization, Term::rate_ramp}) {
      const double size = model_[t].largest();
      if (size == 0 || (t == Term::flicker && walk.origin == Origin::of_flicker)) continue;
      const double stands = t == Term::flicker ? walk_of_flicker(size, horizon_s_) : 0;
      say(t, quoted(size, t),
          stands > 0 ? fmt::format("; over {} it moves as a random walk of {} does", text::duration_text(horizon_s_),
                                   quoted(stands, Term::rate_random_walk))
                     : std::string());
    }
    for (const auto& g : model_.gauss_markov)
      say(Term::gauss_markov,
          fmt::format("{} with a correlation time of {:.6g} s", quoted(g.sigma.largest(), Term::gauss_markov),
                      g.correlation_time),
          "");
    for (const auto& s : model_.sinusoids)
      say(Term::sinusoid, fmt::format("{} at {:.6g} Hz", quoted(s.amplitude.largest(), Term::sinusoid), s.frequency),
          "");
    return text;
  }

  const ErrorModel& model_;
  const ErrorModel& limits_;
  Signal signal_;
  double horizon_s_;
};

void require_positive(double value, std::string_view what, std::string_view unit) {
  if (!(std::isfinite(value) && value > 0))
    throw std::invalid_argument(fmt::format("{} is {} {}; it must be above 0 and finite", what, value, unit));
}

std::string comment_lines(std::string_view comment) {
  std::string text;
  while (!comment.empty()) {
    const std::size_t end = std::min(comment.find('\n'), comment.size());
    text += fmt::format("#{}{}\n", end > 0 ? " " : "", comment.substr(0, end));
    comment.remove_prefix(std::min(end + 1, comment.size()));
  }
  return text;
}

}  // namespace

double walk_of_flicker(double b, double horizon_s) {
  return b * std::sqrt(6 * std::numbers::ln2 / (std::numbers::pi * horizon_s));
}

std::string kalibr_yaml(const SensorModel& model, const KalibrOptions& options) {
  require_positive(options.update_rate_hz, "update_rate_hz", "Hz");
  require_positive(options.horizon_s, "horizon_s", "s");
  const SensorModel limits = options.limits.value_or(SensorModel{});
  std::string text = comment_lines(options.comment) + "# Kalibr imu.yaml: continuous-time densities, two-sided, SI\n";
  if (model.accelerometer) {
    const ErrorModel limit = limits.accelerometer.value_or(ErrorModel{});
    text += Triad(*model.accelerometer, limit, Signal::specific_force, options.horizon_s).text();
  } else {
    text += "# accelerometer_noise_density and accelerometer_random_walk are not known: fill them in\n";
  }
  text += Triad(model.gyro, limits.gyro, Signal::angular_rate, options.horizon_s).text();
  return text + fmt::format("rostopic: /imu0\nupdate_rate: {}  # [Hz]\n", options.update_rate_hz);
}

}  // namespace gyrobudget::inline v0::sensor_file

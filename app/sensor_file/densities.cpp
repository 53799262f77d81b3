// SPDX-License-Identifier: MIT
#include "gyrobudget/app/sensor_file/detail/densities.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include "kalibr.h"

namespace gyrobudget::inline v0::sensor_file::detail {
namespace {

using noise::Term;

/// ", the largest of the three axes, that of z" where the axes differ.
std::string of_axis(const Density& density, bool differ) {
  return differ ? fmt::format(", the largest of the three axes, that of {}", "xyz"[density.axis]) : std::string();
}

template <class Of>
Density largest(const Of& of) {
  Density most;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Density density = of(axis);
    density.axis = axis;
    if (density.value > most.value) most = density;
  }
  return most;
}

}  // namespace

const char* Densities::name() const { return is_gyro() ? "gyroscope" : "accelerometer"; }

std::string Densities::quoted(double si, Term term) const {
  return noise::quantity_text(si, noise::datasheet_unit(signal_, term));
}

bool Densities::resolved(Term term, std::size_t axis) const {
  return model_[term][axis] > 0 && limits_[term][axis] == 0;
}

Density Densities::of_term(Term term, std::size_t axis) const {
  if (resolved(term, axis)) return {model_[term][axis], Origin::fitted, axis};
  return limits_[term][axis] > 0 ? Density{limits_[term][axis], Origin::limit, axis} : Density{};
}

Density Densities::walk(std::size_t axis) const {
  if (resolved(Term::rate_random_walk, axis) || !resolved(Term::flicker, axis))
    return of_term(Term::rate_random_walk, axis);
  return {walk_of_flicker(model_.bias_instability[axis], horizon_s_), Origin::of_flicker, axis};
}

Density Densities::largest_of_term(Term term) const {
  return largest([&](std::size_t axis) { return of_term(term, axis); });
}
Density Densities::largest_white() const { return largest_of_term(Term::white); }
Density Densities::largest_walk() const {
  return largest([&](std::size_t axis) { return walk(axis); });
}

std::string Densities::of(const Density& density, Term term) const {
  const bool differ = !model_[term].is_uniform() || !limits_[term].is_uniform();
  const std::string size = quoted(density.value, term);
  if (density.origin == Origin::fitted)
    return fmt::format("{} as it is, {}{}", noise::label(signal_, term), size, of_axis(density, differ));
  return fmt::format("the record does not resolve {}: this is its 95 % limit, {}{}", noise::label(signal_, term), size,
                     of_axis(density, differ));
}

std::string Densities::walk_words(const Density& walk) const {
  if (walk.origin != Origin::of_flicker) return of(walk, Term::rate_random_walk);
  const double b = model_.bias_instability[walk.axis], limit = limits_.rate_random_walk[walk.axis];
  const bool differ = !model_.bias_instability.is_uniform() || !model_.rate_random_walk.is_uniform();
  return fmt::format(
      "no {} is resolved ({}); this one stands for the bias instability of {} over T = {}: B sqrt(6 ln 2/(pi T)), whose Allan deviation at T is the flicker floor{}",
      noise::label(signal_, Term::rate_random_walk),
      limit > 0 ? fmt::format("it is at most {}, 95 %", quoted(limit, Term::rate_random_walk)) : "none was fitted",
      quoted(b, Term::flicker), text::duration_text(horizon_s_), of_axis(walk, differ));
}

std::vector<std::string> Densities::left_out(const Density& walk) const {
  std::vector<std::string> list;
  const auto say = [&](Term term, const std::string& what, const std::string& why) {
    list.push_back(
        fmt::format("{} {}: {} has no place in this form{}", name(), noise::label(signal_, term), what, why));
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
    say(Term::sinusoid, fmt::format("{} at {:.6g} Hz", quoted(s.amplitude.largest(), Term::sinusoid), s.frequency), "");
  return list;
}

}  // namespace gyrobudget::inline v0::sensor_file::detail

// SPDX-License-Identifier: MIT
#include "scenario.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {

std::string_view name(Aid::Kind kind) {
  constexpr std::array<std::string_view, 5> names{"position", "velocity", "height", "attitude", "rest"};
  return names[static_cast<std::size_t>(kind)];
}

int rows(Aid::Kind kind) { return kind == Aid::Kind::height ? 1 : 3; }

void check(const Aid& aid) {
  const auto require = [&](bool good, std::string_view what, double value, std::string_view expected) {
    if (!good) throw SetupError(fmt::format("{}: {} is {}, expected {}", aid.name, what, value, expected));
  };
  for (int i = 0; i < rows(aid.kind); ++i)
    require(aid.sigma[i] > 0 && std::isfinite(aid.sigma[i]), "sigma", aid.sigma[i], "above 0 and finite");
  for (int i = 0; i < 3; ++i) {
    require(aid.bias_sigma[i] >= 0 && std::isfinite(aid.bias_sigma[i]), "sigma of its bias", aid.bias_sigma[i],
            "0 or more");
    require(aid.correlated_sigma[i] >= 0 && std::isfinite(aid.correlated_sigma[i]), "sigma of its correlated error",
            aid.correlated_sigma[i], "0 or more");
    require(aid.lever_arm_sigma[i] >= 0 && std::isfinite(aid.lever_arm_sigma[i]), "sigma of its lever arm",
            aid.lever_arm_sigma[i], "0 or more");
    require(std::isfinite(aid.lever_arm[i]), "lever arm", aid.lever_arm[i], "a finite number");
  }
  require(aid.correlation_time > 0, "correlation time", aid.correlation_time, "above 0 s");
  require(aid.rate > 0 && std::isfinite(aid.rate), "rate", aid.rate, "above 0 Hz");
  require(aid.sigma_factor > 0 && std::isfinite(aid.sigma_factor), "factor of its sigma", aid.sigma_factor,
          "above 0 and finite");
  require(std::isfinite(aid.time_tag), "time tag", aid.time_tag, "a finite time");
  require(aid.time_tag_sigma >= 0 && std::isfinite(aid.time_tag_sigma), "sigma of its time tag", aid.time_tag_sigma,
          "0 s or more");
}

Eigen::Vector3d total_sigma(const Aid& aid) {
  return ((aid.sigma_factor * aid.sigma).array().square() + aid.bias_sigma.array().square() +
          aid.correlated_sigma.array().square())
      .sqrt();
}

AidTerms aid_terms(const Aid& aid, int number) {
  AidTerms result;
  const auto add = [&](ErrorTerm term, double sigma) {
    if (sigma == 0) return;
    term.carrier = Carrier::aid;
    term.aid = number;
    result.terms.push_back(term);
    result.variances.push_back(sigma * sigma);
  };
  for (int i = 0; i < rows(aid.kind); ++i) {
    add({.effect = Effect::bias, .axis = i}, aid.bias_sigma[i]);
    const double walk = aid.correlated_sigma[i] * std::sqrt(2 / aid.correlation_time);
    add({.effect = Effect::bias, .axis = i, .correlation_time = aid.correlation_time, .walk = walk},
        aid.correlated_sigma[i]);
  }
  if (aid.kind == Aid::Kind::position || aid.kind == Aid::Kind::velocity)
    for (int i = 0; i < 3; ++i) add({.effect = Effect::lever_arm, .axis = i}, aid.lever_arm_sigma[i]);
  add({.effect = Effect::time_tag}, aid.time_tag_sigma);
  return result;
}

std::size_t clock_of(const std::vector<Aid>& aids, std::size_t number) {
  std::size_t owner = number;
  for (std::size_t i = number; i-- > 0 && !aids[number].clock.empty() && aids[i].clock == aids[number].clock;)
    if (aids[i].used) owner = i;
  return owner;
}

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
#include "hypotheses.h"

#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <utility>

namespace gyrobudget::inline v0::paper {
namespace {

using closed_loop::TiltResponse;
using earth::kDegree;
using Eigen::Vector3d;
using flight::FlightRecord;
using flight::Plan;
using report::PaperHypothesis;

constexpr double kHour = 3600;
constexpr int kNoiseRuns = 10,
              kOtherRuns = 3;  // where noise makes the distance, and where it hardly adds to it

// --- Hypotheses on what the gyros do -----------------------------------------------------------------------

struct Supposition {
  std::string id, what, why;
  PaperSetting setting;
  std::function<void(noise::ErrorModel&)> misread;  ///< none: gyros as they are
};

std::function<void(noise::ErrorModel&)> times(double factor) {
  return [factor](noise::ErrorModel& gyro) {
    gyro.white *= factor;
    gyro.rate_random_walk *= factor;
  };
}

/// A draw of equation (2) at the rate of control that stays: its standard deviation as a bias.
std::function<void(noise::ErrorModel&)> frozen(double period) {
  return [period](noise::ErrorModel& gyro) {
    if (gyro.white.largest() > 0) {
      gyro.turn_on_bias = gyro.white;
      *gyro.turn_on_bias *= 1 / std::sqrt(period);
    }
    gyro.white = gyro.rate_random_walk = 0;
  };
}

std::vector<Supposition> suppositions() {
  const Plan prompt = prompt_plan(), north = towards(prompt, 0);
  const navigation::Strapdown::Options no_turn{.earth_rate_in_attitude = false};
  const PaperSetting right{prompt, prompt, {}};
  return {
      {"as_it_should_be",
       "gyros of table I, full navigation, no lag",
       "The noise is far too small for both, by factors that have nothing in common.",
       right,
       {}},
      {"lag",
       "the loop damps the rate, so it flies 2 damping/frequency late",
       "It gives the ideal gyro's 0.20 km, and the same to all three gyros.",
       {lagging(prompt), prompt, {}},
       {}},
      {"earth_rate",
       "Earth's rate left out of the attitude, azimuth 90 deg",
       "0.347 deg of pitch at the end; the same for all three.",
       {prompt, prompt, no_turn},
       {}},
      {"earth_rate_north",
       "the same with azimuth 0 deg",
       "It is then roll and yaw; the same for all three.",
       {north, north, no_turn},
       {}},
      {"radians", "deg/sqrt(h) and deg/h taken for rad/sqrt(h) and rad/h",
       "A factor of 57.3: metres with the IFOG, most of a kilometre with the MEMS.", right, times(1 / kDegree)},
      {"root_second", "ARW and RRW taken per sqrt(s) for per sqrt(h)", "A factor of 60, much the same.", right,
       times(60)},
      {"per_second", "deg/h taken for deg/s",
       "A factor of 3600: the IFOG's flight is still within a quarter of a kilometre, and with the MEMS the vehicle comes down.",
       right, times(kHour)},
      {"frozen_seed", "a seed that starts again at every sample: one draw of equation (2) that stays",
       "It acts as a bias. Still a ratio of 278 between the two gyros.", right, frozen(prompt.flight.period)},
  };
}

/// Distance from the reference at the end, by flights and to first order.
PaperHypothesis::Gyro flown(const PaperSetting& setting, const TiltResponse& reference, const noise::ErrorModel& gyro,
                            std::uint64_t seed) {
  const Vector3d place = expected_place(setting, reference);
  PaperHypothesis::Gyro result{.flights = 1};
  if (noisy(gyro)) {
    const auto many = fly_many(setting, gyro, place.isZero() ? kNoiseRuns : kOtherRuns, seed);
    result.flights = static_cast<int>(many.sensors.outcomes.size());
    result.lost = result.flights - many.sensors.complete();
    if (result.lost < result.flights) result.km = rms_distance(many, reference.nominal()) / kKm;
  } else {
    result.km = distance(fly_wrong(setting), reference.nominal()) / kKm;
  }
  constexpr double kSmall = 0.1;  // of the way from the pad: beyond, first order says nothing
  const double theory = std::sqrt(place.squaredNorm() + reference.covariance(gyro).trace());
  const Vector3d& pad = reference.nominal().points.front().truth.p_eb_e;
  if (result.lost == 0 && theory < kSmall * (end_of(reference.nominal()) - pad).norm()) result.theory_km = theory / kKm;
  return result;
}

PaperHypothesis hypothesis(const Supposition& s, const PaperGyroErrors& gyros, std::uint64_t seed) {
  PaperHypothesis result{.id = s.id, .what = s.what, .takes_unit = {}, .why = s.why};
  const TiltResponse reference(s.setting.reference);
  const bool by_noise_alone = expected_place(s.setting, reference).isZero();
  for (std::size_t i = 0; i < kPaperGyros; ++i) {
    noise::ErrorModel gyro = gyros[i];
    if (s.misread) s.misread(gyro);
    PaperHypothesis::Gyro& of = result.gyros[i] = flown(s.setting, reference, gyro, seed);
    if (!by_noise_alone || !noisy(gyro) || !of.theory_km) continue;
    of.takes = kPublishedKm[i] / *of.theory_km;
    result.takes_unit = "times";
  }
  return result;
}

// --- Hypotheses of a size, whatever the gyro ---------------------------------------------------------------

struct Sized {
  std::string id, what, unit, why;
  std::function<double(double)> metres;  ///< of so much of it, by a flight
};

/// The size that gives this distance, nearly proportional to it.
std::optional<double> size_for(const Sized& sized, double metres, double at_one) {
  constexpr int kMost = 10;
  constexpr double kClose = 1e-3;
  double size = metres / at_one;
  for (int i = 0; i < kMost; ++i) {
    const double got = sized.metres(size);
    size *= metres / got;
    if (std::abs(got / metres - 1) < kClose) return size;
  }
  return std::nullopt;
}

Plan without_side_force(Plan plan) {
  plan.flight.vehicle.normal_force_slope = 0;
  return plan;
}
Plan late(Plan plan, double by) {
  auto points = plan.control.pitch.points();
  for (auto& point : points) point.first += by;
  plan.control.pitch = flight::LookupTable::linear(points);
  return plan;
}

std::vector<Sized> sizes() {
  const Plan plan = prompt_plan(), bare = without_side_force(plan);
  const PaperSetting right{plan, plan, {}}, no_push{bare, bare, {}};
  const auto from = [](const Plan& of) {
    return [reference = fly_nominal(of)](const FlightRecord& record) { return distance(record, reference); };
  };
  const auto apart = from(plan), apart_bare = from(bare);
  return {
      {"offset", "pitch told 1 deg too high throughout", "deg",
       "The published distances equal such an offset: what a misaligned or misread attitude does, not noise.",
       [=](double x) { return apart(fly_wrong(right, {.angle = x * kDegree})); }},
      {"offset_without_side_force", "the same where air does not push back", "deg",
       "Air's side force takes a third off what thrust alone does.",
       [=](double x) { return apart_bare(fly_wrong(no_push, {.angle = x * kDegree})); }},
      {"bias", "a pitch gyro's bias of 1 deg/h, from ignition on", "deg/h",
       "No bias of these gyros is near what it takes; table I gives none.",
       [=](double x) { return apart(fly_wrong(right, {.rate = x * kDegree / kHour})); }},
      {"late", "the program flown 1 s late", "s",
       "0.20 km is the lag of the loop, 2 damping/frequency; the others take the lag of a loop that could not fly.",
       [=](double x) { return apart(fly_nominal(late(plan, x))); }},
      {"thrust", "specific impulse less by 1 %", "%",
       "A vehicle other than the reference's makes kilometres without any gyro, but the same for all three.",
       [=](double x) {
         Plan weak = plan;
         weak.flight.vehicle.specific_impulse *= 1 - x / 100;
         return apart(fly_nominal(weak));
       }},
  };
}

PaperHypothesis hypothesis(const Sized& sized) {
  PaperHypothesis result{.id = sized.id, .what = sized.what, .takes_unit = sized.unit, .why = sized.why};
  const double at_one = sized.metres(1);
  for (std::size_t i = 0; i < kPaperGyros; ++i) {
    auto& gyro = result.gyros[i];
    gyro.takes = size_for(sized, kPublishedKm[i] * kKm, at_one);
    gyro.km = at_one / kKm;
    gyro.flights = 1;
  }
  return result;
}

// --- Hypotheses on what the reference is -------------------------------------------------------------------

PaperHypothesis alone(std::string id, std::string what, std::string why, double metres,
                      std::optional<double> theory = {}) {
  PaperHypothesis result{.id = std::move(id), .what = std::move(what), .takes_unit = {}, .why = std::move(why)};
  result.gyros[0] = {.km = metres / kKm, .theory_km = theory, .flights = 1, .lost = 0, .takes = {}};
  return result;
}

std::vector<PaperHypothesis> on_the_reference(const TiltResponse& response) {
  const Plan plan = prompt_plan();
  Plan sourced = plan, airless = plan;
  sourced.flight.vehicle = flight::vlm1();
  airless.flight.world.atmosphere = false;
  const Vector3d exact = exact_end(plan);
  const PaperSetting vacuum{lagging(airless), airless, {}};
  const TiltResponse in_vacuum(airless);
  return {
      alone("exact_reference", "no lag, against a reference that has its nose on the program exactly",
            "A loop without integral part gives way to the air's moment. That alone is the paper's 0.20 km, too.",
            (end_of(response.nominal()) - exact).norm(), response.position_of_standing_error().norm() / kKm),
      alone("exact_reference_lag", "with lag, against the same",
            "Lag and the air's moment turn the nose opposite ways: with this vehicle they nearly cancel.",
            (end_of(fly_nominal(lagging(plan))) - exact).norm()),
      alone("vacuum", "the lag where there is no air", "Nothing pushes back, so the lag shows in full.",
            distance(fly_nominal(vacuum.plan), in_vacuum.nominal()), expected_place(vacuum, in_vacuum).norm() / kKm),
      alone(
          "thrust_model", "the sourced VLM-1 flown against the paper's scale as reference",
          "1 t of mass, 3 s of specific impulse and 0.05 m^2 of exit area: nearly the IFOG's distance, without a gyro.",
          distance(fly_nominal(sourced), response.nominal())),
  };
}

}  // namespace

std::vector<PaperHypothesis> paper_hypotheses(const TiltResponse& reference, const PaperGyroErrors& gyros,
                                              std::uint64_t seed) {
  const auto supposed = suppositions();
  const auto sized = sizes();
  std::vector<PaperHypothesis> result(supposed.size() + sized.size());
  tbb::parallel_for(std::size_t{0}, result.size(), [&](std::size_t i) {
    result[i] = i < supposed.size() ? hypothesis(supposed[i], gyros, seed) : hypothesis(sized[i - supposed.size()]);
  });
  const auto others = on_the_reference(reference);
  result.insert(result.end(), others.begin(), others.end());
  return result;
}

}  // namespace gyrobudget::inline v0::paper

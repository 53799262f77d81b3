// SPDX-License-Identifier: MIT
#include "flight.h"

#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "hypotheses.h"
#include "setting.h"

namespace gyrobudget::inline v0::paper {
namespace {

using closed_loop::TiltResponse;
using earth::kDegree;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using flight::FlightRecord;
using flight::Plan;
using report::PaperHypothesis;
using report::PaperPath;
using report::PaperRow;

constexpr std::array kIds{"ideal", "ifog", "mems"}, kGyroNames{"ideal gyro", "IFOG", "MEMS"};
constexpr double kPublishedYaw = 0.4;  // [deg], "less than"
constexpr int kFlights = 48;           // flights with one gyro

// --- Paths -------------------------------------------------------------------------------------------------

/// Every so many points of a record.
constexpr std::size_t kThinned = 5;

PaperPath path_of(std::string id, std::string name, const FlightRecord& record, const FlightRecord& reference,
                  const FlightRecord& ideal, const Plan& plan) {
  const flight::AttitudeControl program(plan.flight.vehicle, plan.flight.world.site, plan.control);
  const Matrix3d C = earth::LocalFrame::launch_plane(plan.flight.world.site, plan.control.azimuth).C_el();
  PaperPath path{.id = std::move(id), .name = std::move(name)};
  const Vector3d pad = reference.points.front().truth.p_eb_e;
  for (std::size_t i = 0; i < std::min({record.points.size(), reference.points.size(), ideal.points.size()});
       i += kThinned) {
    const flight::FlightPoint& p = record.points[i];
    const Vector3d place = C.transpose() * (p.truth.p_eb_e - pad);
    path.downrange.push_back(place[0]);
    path.crossrange.push_back(place[1]);
    path.up.push_back(place[2]);
    path.distance.push_back((p.truth.p_eb_e - reference.points[i].truth.p_eb_e).norm());
    path.from_ideal.push_back((p.truth.p_eb_e - ideal.points[i].truth.p_eb_e).norm());
    const Eigen::Quaterniond wanted = program.reference(p.t);
    const Vector3d flown = body_turn(wanted, p.truth.q_eb), measured = body_turn(wanted, p.seen.q_eb);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      path.flown[axis].push_back(flown[static_cast<Eigen::Index>(axis)]);
      path.measured[axis].push_back(measured[static_cast<Eigen::Index>(axis)]);
    }
  }
  return path;
}

// --- Rows --------------------------------------------------------------------------------------------------

double degrees(double radians) { return radians / kDegree; }

/// Of the root mean square over n draws with this covariance: 95 % lie within so much of it.
double spread(const Matrix3d& covariance, int n) {
  const double trace = covariance.trace();
  return trace > 0 ? 1.96 / 2 * std::sqrt(2 * (covariance * covariance).trace() / n) / trace : 0;
}
PaperRow::Scatter around(double value, double part) { return {value * (1 - part), value * (1 + part)}; }

/// The many flights with one gyro, and the theory of them.
struct Flown {
  closed_loop::Study study;
  double rms_from_ideal = 0, rms_distance = 0, rms_navigation = 0, rms_crossrange = 0;  ///< [m]
  Matrix3d covariance = Matrix3d::Zero();  ///< of the departure, theory, e axes
};

Flown fly_gyro(const PaperSetting& setting, const TiltResponse& response, const noise::ErrorModel& gyro,
               std::uint64_t seed) {
  Flown result{.study = fly_many(setting, gyro, noisy(gyro) ? kFlights : 0, seed)};
  result.covariance = response.covariance(gyro);
  const auto& s = result.study;
  if (!noisy(gyro)) {
    result.rms_distance = distance(*s.flown, response.nominal());
    return result;
  }
  result.rms_distance = rms_distance(s, response.nominal());
  double from_ideal = 0, navigation = 0, across = 0;
  for (const auto& o : s.sensors.outcomes) {
    if (!o.counts()) continue;
    from_ideal += o.position.squaredNorm();
    navigation += o.navigation.head<3>().squaredNorm();
    across += o.position[1] * o.position[1];
  }
  const auto root = [&](double sum) { return std::sqrt(sum / std::max(s.sensors.complete(), 1)); };
  result.rms_from_ideal = root(from_ideal);
  result.rms_navigation = root(navigation);
  result.rms_crossrange = root(across);
  return result;
}

/// A body axis' turn of a record against another at the same times.
template <typename Attitude>
std::vector<double> turns(const FlightRecord& record, const FlightRecord& against, int axis, Attitude attitude) {
  std::vector<double> result;
  for (std::size_t i = 0; i < std::min(record.points.size(), against.points.size()); ++i)
    result.push_back(body_turn(attitude(against.points[i]), attitude(record.points[i]))[axis]);
  return result;
}
const auto kTruth = [](const flight::FlightPoint& p) { return p.truth.q_eb; };
const auto kMeasured = [](const flight::FlightPoint& p) { return p.seen.q_eb; };
enum Axis { roll, pitch, yaw };

double largest(const std::vector<double>& values) {
  double result = 0;
  for (const double v : values) result = std::max(result, std::abs(v));
  return result;
}
double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

std::vector<PaperRow> distance_rows(const std::array<Flown, kPaperGyros>& flown, const TiltResponse& response,
                                    const PaperSetting& setting, const Matrix3d& C) {
  const Vector3d expected = expected_place(setting, response);
  const Vector3d pad = response.nominal().points.front().truth.p_eb_e;
  std::vector<PaperRow> rows;
  rows.push_back(
      {.id = "fig8.mems.crossrange_m",
       .group = "MEMS",
       .what = "crossrange at 83 s, rms",
       .unit = "m",
       .ours = flown[2].rms_crossrange,
       .theory = std::sqrt(C.col(1).dot(flown[2].covariance * C.col(1))),
       .scatter = around(std::sqrt(C.col(1).dot(flown[2].covariance * C.col(1))), 1.96 / std::sqrt(2.0 * kFlights)),
       .why = "The figure's trajectories lie in one plane. They do: noise takes them out of it by metres."});
  rows.push_back(
      {.id = "fig9.reference.reach_km",
       .group = "reference",
       .what = "distance from the pad at 83 s",
       .unit = "km",
       .ours = (end_of(response.nominal()) - pad).norm() / kKm,
       .theory = (exact_end(setting.reference) - pad).norm() / kKm,
       .why =
           "The paper's 16 % and 20 % are of 29.1 to 29.6 km. The vehicle's mass and specific impulse were chosen to match that. Theory: nose exactly on the program."});
  for (std::size_t i = 0; i < kPaperGyros; ++i) {
    const double trace = flown[i].covariance.trace();
    const double theory = std::sqrt(expected.squaredNorm() + trace);
    PaperRow row{.id = fmt::format("fig9.{}.distance_km", kIds[i]),
                 .group = kGyroNames[i],
                 .what = "distance from the reference",
                 .unit = "km",
                 .published = kPublishedKm[i],
                 .ours = flown[i].rms_distance / kKm,
                 .theory = theory / kKm};
    row.why =
        i == 0
            ? "The loop damps the rate, so it follows a turning program late by 2 damping/frequency = 0.56 s, which air makes less of. Damping the rate's error instead, it does not lag: that is the reference."
            : "The lag again; the gyro adds what the next row says. No unit, seed or missing Earth rate makes the published distance: see the hypotheses.";
    rows.push_back(row);
    if (i == 0) continue;
    rows.push_back(
        {.id = fmt::format("fig9.{}.from_ideal_m", kIds[i]),
         .group = kGyroNames[i],
         .what = "distance from the ideal gyro's flight, rms",
         .unit = "m",
         .ours = flown[i].rms_from_ideal,
         .theory = std::sqrt(trace),
         .scatter = around(std::sqrt(trace), spread(flown[i].covariance, kFlights)),
         .why = "What the gyro does to the flight: its angle random walk turns the nose, and thrust does the rest."});
    const auto& total = flown[i].study.budget->total.back();
    const Matrix3d navigation = total.topLeftCorner<3, 3>();
    rows.push_back({.id = fmt::format("fig9.{}.navigation_m", kIds[i]),
                    .group = kGyroNames[i],
                    .what = "navigation's error of position, rms",
                    .unit = "m",
                    .ours = flown[i].rms_navigation,
                    .theory = std::sqrt(navigation.trace()),
                    .scatter = around(std::sqrt(navigation.trace()), spread(navigation, kFlights)),
                    .why = "Against truth, with perfect accelerometers. Theory: linear covariance in open loop."});
  }
  return rows;
}

/// What is left of Earth's rate about an axis of the body at the end, where the attitude takes no notice of it.
std::vector<PaperRow> earth_rate_rows() {
  struct Case {
    const char *id, *what;
    double azimuth;
    int axis;
    std::optional<double> published;
    const char* why;
  };
  const std::array cases{
      Case{"fig10.pitch.earth_rate_deg",
           "measured pitch less true, Earth's rate left out, azimuth 90 deg",
           90 * kDegree,
           1,
           {},
           "15 deg/h over 83 s is 0.347 deg about the polar axis. Flying east from the equator, that is pitch."},
      Case{"fig10.yaw.earth_rate_deg", "the same of yaw", 90 * kDegree, 2, {}, "Next to nothing is left for yaw."},
      Case{"fig10.yaw.earth_rate_north_deg",
           "the same of yaw, azimuth 0 deg",
           0,
           2,
           {},
           "Only a launch towards a pole, or axes named otherwise, brings it into yaw."},
  };
  std::vector<PaperRow> rows;
  for (const Case& c : cases) {
    const Plan plan = towards(prompt_plan(), c.azimuth);
    const flight::FlightPoint end = fly_wrong({plan, plan, {.earth_rate_in_attitude = false}}).end;
    const flight::AttitudeControl program(plan.flight.vehicle, plan.flight.world.site, plan.control);
    const Vector3d theory = program.reference(end.t).conjugate() * Vector3d(0, 0, earth::wgs84::kEarthRate * end.t);
    rows.push_back({.id = c.id,
                    .group = "ideal gyro",
                    .what = c.what,
                    .unit = "deg",
                    .ours = degrees(body_turn(end.truth.q_eb, end.seen.q_eb)[c.axis]),
                    .theory = degrees(theory[c.axis]),
                    .why = c.why});
  }
  return rows;
}

/// Of the integrated noise of a gyro at the end of a flight [rad].
double angle_sigma(const noise::ErrorModel& gyro, double t) {
  const double N = gyro.white[Axis::yaw], K = gyro.rate_random_walk[Axis::yaw];
  return std::sqrt(N * N * t + K * K * t * t * t / 3);
}

PaperRow yaw_row(std::size_t i, const FlightRecord& flown, const FlightRecord& ideal, const noise::ErrorModel& gyro) {
  // The largest excursion of a random walk over its sigma at the end: mean, 2.5 and 97.5 % points.
  const double mean = std::sqrt(std::numbers::pi / 2);
  constexpr double kLow = 0.560, kHigh = 2.498;
  const double sigma = angle_sigma(gyro, flown.end.t);
  return {
      .id = i == 2 ? "fig10.yaw.max_error_deg" : "fig10.yaw.ifog.max_error_deg",
      .group = kGyroNames[i],
      .what = "largest error of yaw in a flight (published: less than)",
      .unit = "deg",
      .published = kPublishedYaw,
      .ours = degrees(largest(turns(flown, ideal, Axis::yaw, kTruth))),
      .theory = degrees(mean * sigma),
      .scatter = PaperRow::Scatter{degrees(kLow * sigma), degrees(kHigh * sigma)},
      .why =
          "True attitude against the ideal gyro's flight: integrated noise, whose largest excursion is on average 1.25 of its sigma at the end."};
}

PaperRow roll_row(std::size_t i, const FlightRecord& flown, const FlightRecord& ideal, const noise::ErrorModel& gyro,
                  const Plan& plan) {
  return {
      .id = fmt::format("fig10.roll.{}.measured_rms_deg", kIds[i]),
      .group = kGyroNames[i],
      .what = "measured roll against the program, rms",
      .unit = "deg",
      .ours = degrees(rms(turns(flown, ideal, Axis::roll, kMeasured))),
      .theory = degrees(gyro.white[static_cast<std::size_t>(Axis::roll)] /
                        std::sqrt(4 * plan.control.damping * plan.control.frequency)),
      .why =
          "What such a figure shows: the loop holds what is measured to the program, all but the noise above its bandwidth, N/sqrt(4 damping frequency). The drift of the gyro does not show in it."};
}

PaperRow lag_row(const FlightRecord& ideal, const FlightRecord& prompt, const Plan& plan) {
  constexpr double kSettled = 14, kFading = 75;  // [s]
  const auto turned = turns(ideal, prompt, Axis::pitch, kTruth);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < turned.size(); ++i) {
    if (ideal.points[i].t < kSettled || ideal.points[i].t > kFading) continue;
    sum += turned[i];
    ++count;
  }
  return {
      .id = "fig10.pitch.lag_deg",
      .group = "ideal gyro",
      .what = "pitch behind the reference, mean of 14 to 75 s",
      .unit = "deg",
      .ours = degrees(sum / count),
      .theory = degrees(-plan.control.pitch.at(kSettled).first * lag_of(plan)),
      .why = "2 damping/frequency times the program's rate. Theory is without air, whose moment takes a tenth off."};
}

std::vector<PaperRow> attitude_rows(const std::array<Flown, kPaperGyros>& flown, const PaperGyroErrors& gyros,
                                    const TiltResponse& response, const Plan& plan) {
  std::vector<PaperRow> rows;
  const FlightRecord& ideal = *flown[0].study.flown;
  for (const std::size_t i : {2U, 1U}) {
    rows.push_back(yaw_row(i, *flown[i].study.flown, ideal, gyros[i]));
    rows.push_back(roll_row(i, *flown[i].study.flown, ideal, gyros[i], plan));
  }
  rows.push_back(lag_row(ideal, response.nominal(), plan));
  const auto earth = earth_rate_rows();
  rows.insert(rows.end(), earth.begin(), earth.end());
  return rows;
}

// --- Words -------------------------------------------------------------------------------------------------

const PaperHypothesis& named(const std::vector<PaperHypothesis>& all, std::string_view id) {
  return *std::ranges::find(all, id, &PaperHypothesis::id);
}

std::vector<std::string> words(const std::vector<PaperHypothesis>& all, const std::vector<PaperRow>& rows) {
  const auto ours = [&](std::string_view id) { return std::ranges::find(rows, id, &PaperRow::id)->ours; };
  const auto takes = [&](std::string_view id, std::size_t i) { return named(all, id).gyros[i].takes.value_or(0); };
  const auto km = [&](std::string_view id) { return named(all, id).gyros[0].km.value_or(0); };
  return {
      fmt::format(
          "Distance is taken at 83 s, from where the reference is then: the same vehicle on the same program with perfect gyros and no lag, {:.1f} km from the pad. The paper defines neither; its percentages are of 29.1 to 29.6 km.",
          ours("fig9.reference.reach_km")),
      fmt::format(
          "Through navigation, these gyros cost {:.2f} m (IFOG) and {:.0f} m (MEMS), and flights depart by {:.2f} and {:.0f} m. The published 4.66 and 5.92 km are 1.27 apart, the noises 278: no misread unit, which is a factor common to both, makes these two; it takes {:.0f} times the noise of one, {:.0f} times that of the other.",
          ours("fig9.ifog.navigation_m"), ours("fig9.mems.navigation_m"), ours("fig9.ifog.from_ideal_m"),
          ours("fig9.mems.from_ideal_m"), takes("as_it_should_be", 1), takes("as_it_should_be", 2)),
      fmt::format(
          "0.20 km with the ideal gyro is the lag of an attitude loop that damps the rate ({:.3f} km at 2.5 rad/s and 0.7, both assumed before any comparison); damping the rate's error, there is none. It may also be the air's moment, {:.3f} km against a reference exactly on the program; both at once cancel to {:.3f} km.",
          ours("fig9.ideal.distance_km"), km("exact_reference"), km("exact_reference_lag")),
      fmt::format(
          "4.66 and 5.92 km equal attitudes told wrong by a constant {:.1f} and {:.1f} deg ({:.1f} and {:.1f} where air does not push back), gyro biases of {:.0f} and {:.0f} deg/h, or {:.1f} and {:.1f} % of specific impulse. None of these is a noise of table I.",
          takes("offset", 1), takes("offset", 2), takes("offset_without_side_force", 1),
          takes("offset_without_side_force", 2), takes("bias", 1), takes("bias", 2), takes("thrust", 1),
          takes("thrust", 2)),
      fmt::format(
          "A yaw error below 0.4 deg has the size of Earth's rate over 83 s, 0.347 deg, but flying east that is pitch ({:.3f} deg, yaw {:.3f}); only a launch to the north ({:.3f} deg of yaw) or other names of axes bring it into yaw. Noise alone gives {:.3f} deg.",
          ours("fig10.pitch.earth_rate_deg"), ours("fig10.yaw.earth_rate_deg"), ours("fig10.yaw.earth_rate_north_deg"),
          ours("fig10.yaw.max_error_deg")),
  };
}

report::PaperFlight figures(const std::array<Flown, kPaperGyros>& flown, const TiltResponse& response, const Plan& plan,
                            std::vector<PaperHypothesis> hypotheses) {
  const FlightRecord& reference = response.nominal();
  report::PaperFlight result{.published_km = kPublishedKm};
  for (std::size_t i = 0; i < reference.points.size(); i += kThinned) {
    result.time_s.push_back(reference.points[i].t);
    result.pitch.push_back(plan.control.pitch(reference.points[i].t));
  }
  const auto add = [&](std::string id, std::string name, const FlightRecord& record) {
    const FlightRecord& ideal = *flown[0].study.flown;
    result.paths.push_back(path_of(std::move(id), std::move(name), record, reference, ideal, plan));
  };
  add("reference", "reference", reference);
  for (std::size_t i = 0; i < kPaperGyros; ++i) add(kIds[i], kGyroNames[i], *flown[i].study.flown);
  const PaperSetting prompt{prompt_plan(), prompt_plan(), {}};
  for (const std::size_t i : {1U, 2U}) {
    const double offset = named(hypotheses, "offset").gyros[i].takes.value_or(0);
    add(fmt::format("offset_{}", kIds[i]), fmt::format("pitch told {:.1f} deg too high", offset),
        fly_wrong(prompt, {.angle = offset * kDegree}));
  }
  result.hypotheses = std::move(hypotheses);
  return result;
}

}  // namespace

PaperFlightStudy paper_flight(const PaperGyros& given, std::uint64_t seed) {
  const PaperGyroErrors gyros{noise::ErrorModel{}, given.ifog, given.mems};
  const PaperSetting setting{lagging(prompt_plan()), prompt_plan(), {}};
  const TiltResponse response(setting.reference);
  std::array<Flown, kPaperGyros> flown;
  for (std::size_t i = 0; i < kPaperGyros; ++i) flown[i] = fly_gyro(setting, response, gyros[i], seed);
  auto supposed = paper_hypotheses(response, gyros, seed);

  PaperFlightStudy result;
  result.rows = distance_rows(flown, response, setting, flown[0].study.C_launch);
  const auto attitude = attitude_rows(flown, gyros, response, setting.plan);
  result.rows.insert(result.rows.end(), attitude.begin(), attitude.end());
  auto said = words(supposed, result.rows);
  result.flight = figures(flown, response, setting.plan, std::move(supposed));
  result.flight.words = std::move(said);
  return result;
}

}  // namespace gyrobudget::inline v0::paper

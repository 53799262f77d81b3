// SPDX-License-Identifier: MIT
#include "flight_numbers.h"

#include "gyrobudget/estimation/budget/error_budget.h"
#include "gyrobudget/estimation/navigation/consistency.h"
#include "gyrobudget/vehicle/earth/attitude.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "words.h"
#include <Eigen/Eigenvalues>

namespace gyrobudget::inline v0::report {

using closed_loop::Study;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using flight::FlightPoint;
using flight::FlightRecord;

std::vector<std::string> flight_names(std::span<const FlightResult> results) {
  using Name = std::string (*)(const FlightResult&);
  constexpr std::array<Name, 4> kWays{
      [](const FlightResult& r) { return r.sensor.empty() ? "ideal" : file_name(r.sensor); },
      [](const FlightResult& r) { return r.sensor.empty() ? "ideal" : r.sensor; },
      [](const FlightResult& r) { return file_name(r.scene); },
      [](const FlightResult& r) { return r.scene + ", " + (r.sensor.empty() ? "ideal" : r.sensor); },
  };
  std::vector<std::string> names;
  for (const Name way : kWays) {
    names.clear();
    for (const auto& r : results) names.push_back(printable(way(r)));
    if (std::set(names.begin(), names.end()).size() == names.size()) break;
  }
  return names;
}

std::string flight_title(std::span<const FlightResult> results) {
  const FlightResult& first = results[0];
  const bool one = std::ranges::all_of(results, [&](const auto& r) { return r.name == first.name; });
  if (!one) return printable(first.plan.flight.vehicle.name);
  return printable(first.name.empty() ? first.scene : first.name);
}

std::string navigation_words(const Study& s) {
  std::string words = s.aided ? "strapdown and filter" : "unaided strapdown";
  if (s.pad > 0) words += ", aligned over " + duration_text(s.pad) + " on the pad before";
  return words;
}

std::vector<std::string> flight_notes(std::span<const FlightResult> results) {
  struct Note {
    std::string text, names;
    std::size_t count = 0;
  };
  const std::vector<std::string> names = flight_names(results);
  std::vector<Note> notes;
  for (std::size_t i = 0; i < results.size(); ++i)
    for (const auto* list : {&results[i].study.notes, &results[i].notes})
      for (const auto& text : *list) {
        auto note = std::ranges::find(notes, text, &Note::text);
        if (note == notes.end()) note = notes.insert(notes.end(), {.text = text});
        note->names += (note->count++ > 0 ? ", " : "") + names[i];
      }
  std::vector<std::string> out;
  for (const Note& n : notes)
    out.push_back(n.count >= results.size() ? printable(n.text) : n.names + ": " + printable(n.text));
  return out;
}

bool one_nominal(std::span<const FlightResult> results) {
  return std::ranges::all_of(results, [&](const FlightResult& r) {
    const FlightPoint &a = r.study.nominal.end, &b = results[0].study.nominal.end;
    return a.t == b.t && a.truth.p_eb_e == b.truth.p_eb_e && a.truth.v_eb_e == b.truth.v_eb_e &&
           std::ranges::equal(r.study.vehicle.outcomes, results[0].study.vehicle.outcomes, {},
                              &closed_loop::Outcome::position, &closed_loop::Outcome::position);
  });
}

std::string not_flown(const Study& s) {
  return s.budget ? "was not flown: its alignment on the pad found no heading"
                  : "was not flown: the flight is too short to navigate";
}

LaunchAttitude launch_attitude(const Eigen::Quaterniond& q_eb, const Matrix3d& C_launch) {
  // To downrange, right, down. With C_y(pitch) C_z(yaw) C_x(roll) the second row is (sin y, cos y cos r, -cos y sin r), and
  // the first column (cos p cos y, sin y, -sin p cos y).
  const Matrix3d C_lb = Vector3d(1, -1, -1).asDiagonal() * C_launch.transpose() * q_eb.toRotationMatrix();
  return {std::atan2(-C_lb(2, 0), C_lb(0, 0)), std::asin(std::clamp(C_lb(1, 0), -1.0, 1.0)),
          std::atan2(-C_lb(1, 2), C_lb(1, 1))};
}

FlightFrame::FlightFrame(const FlightResult& r)
    : launch_(earth::LocalFrame::launch_plane(r.plan.flight.world.site, r.plan.control.azimuth)),
      nominal_(&r.study.nominal) {
  constexpr std::size_t kPointsOfASpline = 4;
  if (nominal_->points.size() > kPointsOfASpline) path_ = flight::trajectory(*nominal_);
}

FromPad FlightFrame::from_pad(const FlightPoint& p) const {
  return {p.t, launch_.from_ecef(p.truth.p_eb_e), launch_.C_el().transpose() * p.truth.v_eb_e,
          earth::to_geodetic(p.truth.p_eb_e), launch_attitude(p.truth.q_eb, launch_.C_el())};
}

Difference FlightFrame::difference(const earth::Pose& a, const earth::Pose& b) const {
  const auto local = [&](const Vector3d& e) -> Vector3d { return launch_.C_el().transpose() * e; };
  return {local(a.p_eb_e - b.p_eb_e), local(a.v_eb_e - b.v_eb_e),
          local(earth::log_rotation((a.q_eb * b.q_eb.conjugate()).normalized()))};
}

Difference FlightFrame::navigation_error(const FlightPoint& p) const { return difference(p.truth, p.seen); }

std::optional<Difference> FlightFrame::departure(const FlightPoint& p) const {
  constexpr double kSameTime = 1e-9;  // [s]
  if (std::abs(p.t - nominal_->end.t) < kSameTime) return difference(p.truth, nominal_->end.truth);
  if (!path_ || p.t > nominal_->end.t) return std::nullopt;
  return difference(p.truth, path_->at(p.t).pose);
}

LimitsUsed limits_used(const FlightResult& r, const FlightRecord& record) {
  LimitsUsed used{.deflection = record.largest_deflection,
                  .deflection_limit = r.plan.flight.vehicle.actuator.deflection_limit,
                  .limited = record.limited};
  const auto look = [&](const FlightPoint& p) {
    const double q = p.flow.dynamic_pressure;
    used.pressure_angle = std::max(used.pressure_angle, q * p.flow.angle_of_attack);
    if (q > used.pressure) {
      used.pressure = q;
      used.pressure_at = p.t;
      used.mach = p.flow.mach;
    }
  };
  for (const FlightPoint& p : record.points) look(p);
  look(record.end);
  return used;
}

const FlightRecord& shown_record(const FlightResult& r) { return r.study.flown ? *r.study.flown : r.study.nominal; }

double decibel(double factor) { return 20 * std::log10(factor); }

std::vector<LeastMargins> least_margins(const closed_loop::MarginsAt& margins) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<LeastMargins> list;
  for (const flight::Margins& m : margins.points) {
    auto least = std::ranges::find(list, m.mode_factor, &LeastMargins::mode_factor);
    if (least == list.end())
      least =
          list.insert(list.end(), {.mode_factor = m.mode_factor, .gain_up = kNone, .gain_down = kNone, .phase = kNone});
    const auto take = [&](double& value, double& at, double found) {
      if (found >= value) return;
      value = found;
      at = m.t;
    };
    take(least->gain_up, least->gain_up_at, decibel(m.gain_up));
    take(least->gain_down, least->gain_down_at, -decibel(m.gain_down));
    take(least->phase, least->phase_at, m.phase / earth::kDegree);
    least->stable = least->stable && m.stable;
  }
  return list;
}

Ellipse ellipse(const Matrix3d& covariance, double launch_azimuth) {
  constexpr double kHalfTurn = 180 * earth::kDegree;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(Eigen::Matrix2d(covariance.topLeftCorner<2, 2>()));
  const Eigen::Vector2d sigma = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
  const Eigen::Vector2d major = solver.eigenvectors().col(1);
  const double azimuth = launch_azimuth - std::atan2(major[1], major[0]);  // crossrange is to the left
  return {sigma[1], sigma[0], azimuth - kHalfTurn * std::floor(azimuth / kHalfTurn)};
}

std::array<FlightsOf, 3> causes(const Study& s) {
  return {{{"sensors", &s.sensors}, {"vehicle", &s.vehicle}, {"all", &s.all}}};
}

std::optional<NavigationCheck> navigation_check(const Study& s) {
  const int runs = s.sensors.complete();
  if (!s.budget || runs < 2) return std::nullopt;
  const auto found = navigation::local_sigmas(s.sensors.navigation_error(), s.C_launch);
  const auto expected = navigation::local_sigmas(s.budget->total.back(), s.C_launch);
  const auto ratio = [](double a, double b) { return b > 0 ? a / b : std::numeric_limits<double>::quiet_NaN(); };
  NavigationCheck check{.runs = runs};
  for (int i = 0; i < 3; ++i) check.position_ratio[i] = ratio(found.position[i], expected.position[i]);
  check.position = ratio(found.position.norm(), expected.position.norm());
  check.velocity = ratio(found.velocity.norm(), expected.velocity.norm());
  check.attitude = ratio(found.attitude.norm(), expected.attitude.norm());
  const auto band = navigation::sigma_ratio_band(runs, kRatioBand);
  check.low = band.lower;
  check.high = band.upper;
  return check;
}

std::array<OriginCount, 4> origins(const FlightResult& r) {
  using flight::Origin;
  std::array<OriginCount, 4> counts;
  const std::array<std::optional<Origin>, 4> all{Origin::sourced, Origin::derived, Origin::assumed, std::nullopt};
  for (std::size_t i = 0; i < all.size(); ++i)
    counts[i] = {files::to_string(all[i]),
                 static_cast<int>(std::ranges::count(r.vehicle_numbers, all[i], &files::VehicleNumber::origin))};
  return counts;
}

}  // namespace gyrobudget::inline v0::report

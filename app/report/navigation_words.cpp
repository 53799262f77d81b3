// SPDX-License-Identifier: MIT
#include "navigation_words.h"

#include "gyrobudget/noise/units.h"
#include "gyrobudget/vehicle/earth/attitude.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <variant>

#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using navigation::Aid;
using navigation::Suspect;

// "gnss" where it is all that the device measures, else "gnss.position".
std::string device_of(const NavigationResult& r, const Suspect& suspect) {
  const Aid& aid = r.scenario.aids[suspect.aids.front()];
  return aid.clock.empty() ? aid.name : aid.clock;
}

std::string mended_axes(const NavigationResult& r, const std::string& axes) {
  std::string out;
  bool minus = false;
  for (const char c : axes) {
    minus |= c == '-';
    if (c < 'x' || c > 'z') continue;
    std::string own = r.imu_axes[static_cast<std::size_t>(c - 'x')];
    if (minus) own = own.starts_with('-') ? own.substr(1) : "-" + own;
    out += fmt::format("{}{}", out.empty() ? "" : ", ", own);
    minus = false;
  }
  return out;
}

std::string unit_words(const Suspect& suspect) {
  const bool larger = suspect.value > 1;
  if (suspect.gyro)
    return larger ? "The gyro's numbers are rad/s, and are read as deg/s"
                  : "The gyro's numbers are deg/s, and are read as rad/s";
  return larger ? "The accelerometer's numbers are g, and are read as m/s^2"
                : "The accelerometer's numbers are m/s^2, and are read as g";
}

}  // namespace

std::string_view name(Suspect::Kind kind) {
  constexpr std::array<std::string_view, 6> names{"clock", "lever_arm", "axes", "unit", "heading", "sigma"};
  return names[static_cast<std::size_t>(kind)];
}

std::string suspect_text(const NavigationResult& r, const Suspect& s) {
  switch (s.kind) {
    case Suspect::Kind::clock: {
      constexpr double kLeap = 18;
      return fmt::format("The stamps of {} are {} s {}{}", device_of(r, s), number(std::abs(s.value), 3),
                         s.value < 0 ? "late" : "early",
                         std::abs(s.value) == kLeap ? ", the difference of GPS time and UTC" : "");
    }
    case Suspect::Kind::lever_arm:
      return fmt::format("The antenna of {} is {}, {}, {} m forward, right and down of the IMU", device_of(r, s),
                         number(s.lever_arm[0], 2), number(s.lever_arm[1], 2), number(s.lever_arm[2], 2));
    case Suspect::Kind::axes:
      return fmt::format("The IMU's axes that point forward, right, down are {}{}", mended_axes(r, s.axes),
                         s.mirrored ? ", a left-handed set: the log has a sign wrong" : "");
    case Suspect::Kind::unit:
      return unit_words(s);
    case Suspect::Kind::heading:
      return fmt::format("The heading of the start is off by {} deg", number(s.value / earth::kDegree, 3));
    case Suspect::Kind::sigma:
      return fmt::format("The sigmas of {} are too small, by a factor of {} or so", device_of(r, s),
                         number(s.value, 2));
  }
  return {};
}

std::string suspect_mend(const NavigationResult& r, const Suspect& s) {
  switch (s.kind) {
    case Suspect::Kind::clock:
      return fmt::format("time_tag: {} s", number(r.scenario.aids[s.aids.front()].time_tag + s.value, 6));
    case Suspect::Kind::lever_arm:
      return fmt::format("lever_arm: [{} m, {} m, {} m]", number(s.lever_arm[0], 3), number(s.lever_arm[1], 3),
                         number(s.lever_arm[2], 3));
    case Suspect::Kind::axes:
      return s.mirrored ? std::string() : fmt::format("axes: [{}]", mended_axes(r, s.axes));
    case Suspect::Kind::heading: {
      const auto* euler = std::get_if<earth::Euler>(&r.scenario.alignment.attitude);
      const auto* self = std::get_if<navigation::SelfAlignment>(&r.scenario.alignment.attitude);
      const double old = euler != nullptr ? euler->yaw : self != nullptr ? self->heading.value_or(0) : 0;
      return fmt::format("heading: {} deg",
                         number(std::remainder(old + s.value, 2 * std::numbers::pi) / earth::kDegree, 6));
    }
    case Suspect::Kind::sigma: {
      const Aid& aid = r.scenario.aids[s.aids.front()];
      const auto& fixes = r.recording.fixes[s.aids.front()];
      if (!fixes.empty() && fixes.front().sigma) return {};  // the file tells them
      return fmt::format("{}: {} {}", navigation::name(aid.kind), number(aid.sigma[0] * s.value, 3), unit_of(aid.kind));
    }
    case Suspect::Kind::unit:
      return s.gyro ? fmt::format("columns: {{gyro_x: NAME ({0}), gyro_y: NAME ({0}), gyro_z: NAME ({0})}}",
                                  s.value > 1 ? "rad/s" : "deg/s")
                    : fmt::format("columns: {{accel_x: NAME ({0}), accel_y: NAME ({0}), accel_z: NAME ({0})}}",
                                  s.value > 1 ? "g" : "m/s^2");
  }
  return {};
}

namespace {

std::string verdict_text(const NavigationResult& r, const navigation::InnovationVerdict& v) {
  const Aid& aid = r.scenario.aids[v.aid];
  const std::string unit(unit_of(aid.kind));
  const double to_si = noise::parse_unit(unit).to_si;
  const std::string start =
      fmt::format("{}: NIS/dof is {}, and right sigmas give 1. ", aid.name, number(v.nis_per_dof, 2));
  if (!v.correlated)
    return start + fmt::format("The residuals are as good as white (correlation {} from fix to fix): {}",
                               number(v.correlation, 2),
                               v.nis_per_dof < 1 ? "sigma is larger than the fixes' errors."
                                                 : "a sigma, of the aid or of the IMU's noise, is too small.");
  const std::string key = fmt::format("{}: {{sigma: {} {}, correlated: {{sigma: {} {}, time: {} s}}}}",
                                      navigation::name(aid.kind), number(v.correlated->white / to_si, 2), unit,
                                      number(v.correlated->sigma / to_si, 2), unit, number(v.correlated->time, 2));
  return start +
         fmt::format(
             "The residuals agree from fix to fix (correlation {}): the errors are correlated. {} {} or more over {} s would explain them; in the scene: {}",
             number(v.correlation, 3), number(v.correlated->sigma / to_si, 2), unit, number(v.correlated->time, 2),
             key);
}

}  // namespace

std::vector<std::string> innovation_texts(const NavigationResult& r) {
  std::vector<std::string> out;
  for (const navigation::InnovationVerdict& verdict : navigation::innovation_verdicts(r.run))
    out.push_back(verdict_text(r, verdict));
  if (!r.noise) return out;
  out.push_back(fmt::format(
      "The innovations are likeliest with the IMU's white noise times {} (ln L larger by {}), or with the aids' white sigmas times {} (by {}); each tried with the other as told.",
      number(r.noise->imu, 2), number(r.noise->imu_gain, 3), number(r.noise->aids, 2), number(r.noise->aids_gain, 3)));
  return out;
}

std::vector<std::string> lost_texts(const NavigationResult& r) {
  std::vector<std::string> out;
  for (const navigation::LostSpan& span : r.run.lost) {
    std::string text = fmt::format("lost from {:.6g} s to {:.6g} s: {}", span.from, span.to, span.why);
    if (span.recovered)
      text += fmt::format("; {} were started again from the fixes{}", span.restarted,
                          span.held ? "" : ", and soon lost again");
    else
      text += "; not found again";
    out.push_back(std::move(text));
  }
  return out;
}

}  // namespace gyrobudget::inline v0::report

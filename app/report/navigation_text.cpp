// SPDX-License-Identifier: MIT
// Navigation runs for the terminal and as CSV.
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/noise/units.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <iterator>

#include "layout.h"
#include "navigation.h"
#include "navigation_words.h"
#include "sensor_words.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Eigen::Vector3d;
using navigation::Aid;
using navigation::Carrier;
using navigation::Effect;
using navigation::Navigation;

std::string_view letter(int axis) { return std::string_view("xyz").substr(static_cast<std::size_t>(axis), 1); }

StateText aid_state_text(const Aid& aid, const navigation::ErrorTerm& term) {
  constexpr std::array<std::string_view, 3> kLocal{"east", "north", "up"};
  if (term.effect == Effect::time_tag)  // one of all that the device measures, or of this aid alone
    return {(term.aids > 1 ? aid.clock : aid.name) + " time tag", "ms", 1e-3};
  if (term.effect == Effect::lever_arm) return {fmt::format("{} lever arm {}", aid.name, letter(term.axis)), "m", 1};
  const std::string unit(unit_of(aid.kind));
  const double to_si = noise::parse_unit(unit).to_si;
  const std::string_view kind = std::isfinite(term.correlation_time) ? "correlated error"
                                : aid.kind == Aid::Kind::attitude    ? "mounting"
                                                                     : "bias";
  if (aid.kind == Aid::Kind::height) return {fmt::format("{} {}", aid.name, kind), unit, to_si};
  const std::string_view axis =
      aid.kind == Aid::Kind::attitude ? letter(term.axis) : kLocal[static_cast<std::size_t>(term.axis)];
  return {fmt::format("{} {} {}", aid.name, kind, axis), unit, to_si};
}

std::string vector_text(const Vector3d& v, int digits) {
  return fmt::format("{}, {}, {}", number(v[0], digits), number(v[1], digits), number(v[2], digits));
}

// --- Sections of the summary ---

std::string heading(const NavigationResult& r) {
  const auto& imu = r.recording.imu;
  const std::string name = r.scenario.name.empty() ? r.scene : r.scenario.name;
  return fmt::format("{}\n  IMU: {}, {} samples every {} over {}\n", printable(name), printable(r.source),
                     count_text(static_cast<std::int64_t>(imu.increments.size())), tau_text(imu.typical_interval),
                     duration_text(static_cast<double>(imu.stamps.back() - imu.stamps.front()) * noise::kNanosecond));
}

std::string bullets(std::string_view title, const std::vector<std::string>& items) {
  std::string out;
  if (!items.empty()) out += fmt::format("\n{}\n", title);
  for (const std::string& item : items) out += wrapped(printable(item), "  - ", "    ");
  return out;
}

std::string final_solution(const NavigationResult& r) {
  const navigation::Solution& s = r.run.solutions.back();
  const earth::Geodetic at = earth::to_geodetic(s.state.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
  const Vector3d v = C_en.transpose() * s.state.v_eb_e;
  const earth::Euler euler = earth::to_euler(Eigen::Quaterniond(C_en).conjugate() * s.state.q_eb);
  const double deg = earth::kDegree;
  std::string out = fmt::format("\nSolution at {:.10g} s (last of {})\n", s.time,
                                count_text(static_cast<std::int64_t>(r.run.solutions.size())));
  TextTable table({Align::left, Align::left, Align::left});
  table.row({"  position",
             fmt::format("{:.8f} deg, {:.8f} deg, {:.3f} m", at.latitude / deg, at.longitude / deg, at.height),
             fmt::format("one sigma east, north, up: {} m", vector_text(s.position_sigma, 3))});
  table.row({"  velocity", fmt::format("north {:.4f}, east {:.4f}, down {:.4f} m/s", v[0], v[1], v[2]),
             fmt::format("{} m/s", vector_text(s.velocity_sigma, 3))});
  table.row({"  attitude",
             fmt::format("heading {:.4f}, pitch {:.4f}, roll {:.4f} deg", euler.yaw / deg, euler.pitch / deg,
                         euler.roll / deg),
             fmt::format("{} deg", vector_text(s.attitude_sigma / deg, 3))});
  return out + table.text() + wrapped(not_stated_text(r.not_stated, kTheseSigmas), "  ", "  ");
}

std::vector<std::string> suspects_lines(const NavigationResult& r) {
  std::vector<std::string> lines;
  for (const navigation::Suspect& s : r.suspects) {
    const std::string mend = suspect_mend(r, s);
    lines.push_back(fmt::format("{} % of the misfit: {}.{}", number(100 * s.explained, 3), suspect_text(r, s),
                                mend.empty() ? "" : fmt::format(" In the scene: {}", mend)));
  }
  return lines;
}

// What many refused fixes mean.
std::string refused(const NavigationResult& r) {
  std::string out;
  for (const auto& a : r.run.aids) {
    if (!a.many_refused()) continue;
    out += wrapped(
        fmt::format(
            "{} of {} fixes of {} were refused by the gate. The filter is surer than it should be: look at the start, at the sensor file, at this aid's sigma, axes and units.",
            count_text(a.gated), count_text(a.used + a.gated), printable(r.scenario.aids[a.aid].name)),
        "  ", "  ");
  }
  return out;
}

std::string aids_table(const NavigationResult& r) {
  if (r.run.aids.empty()) return {};
  std::string out = "\nAids (NIS: squared innovation over what the filter expected; right sigmas give 1)\n";
  TextTable table({Align::left, Align::right, Align::right, Align::right, Align::right, Align::left, Align::right,
                   Align::right, Align::left});
  table.row({"  aid", "used", "gated", "left out", "NIS/dof", "95 % band", "inside 95 %", "residual rms", ""});
  for (const auto& a : r.run.aids) {
    const Aid& aid = r.scenario.aids[a.aid];
    const bool any = a.used > 0;
    const std::string unit(unit_of(aid.kind));
    const Vector3d rms = a.residual_rms / noise::parse_unit(unit).to_si;
    table.row({fmt::format("  {}", printable(aid.name)), count_text(a.used), count_text(a.gated + a.not_finite),
               count_text(a.left_out), any ? number(a.nis_mean / a.rows, 3) : "-",
               any ? fmt::format("{} to {}", number(a.nis_low / a.rows, 3), number(a.nis_high / a.rows, 3)) : "-",
               any ? percent(a.inside_95) : "-", any ? number(a.rows == 1 ? std::abs(rms[0]) : rms.norm(), 3) : "-",
               any ? unit : ""});
  }
  return out + table.text() + refused(r);
}

std::string states_table(const NavigationResult& r) {
  if (r.run.model.terms.empty() || r.run.solutions.empty()) return {};
  std::string out = "\nEstimated errors\n";
  TextTable table({Align::left, Align::right, Align::right, Align::right, Align::left});
  table.row({"  state", "sigma at start", "at the end", "sigma", "unit"});
  const navigation::Solution& last = r.run.solutions.back();
  for (std::size_t k = 0; k < r.run.model.terms.size(); ++k) {
    const StateText t = state_text(r.scenario, r.run.model.terms[k]);
    table.row({fmt::format("  {}", printable(t.name)), number(r.run.initial[k] / t.to_si, 3),
               number(last.terms[k] / t.to_si), number(last.term_sigmas[k] / t.to_si, 3), t.unit});
  }
  return out + table.text();
}

std::string reference_text(const NavigationResult& r) {
  if (!r.run.reference || r.run.reference->errors.empty()) return {};
  const navigation::ReferenceSummary& ref = *r.run.reference;
  std::string out = fmt::format("\nAgainst the reference, {} epochs (errors as lengths of vectors)\n",
                                count_text(static_cast<std::int64_t>(ref.errors.size())));
  TextTable table(
      {Align::right, Align::right, Align::right, Align::right, Align::right, Align::right, Align::right, Align::right});
  table.row({"t [s]", "position [m]", "3 sigma", "velocity [m/s]", "3 sigma", "attitude [deg]", "3 sigma",
             fmt::format("NEES/{}", ref.dof)});
  const auto cell = [](bool has, double value) { return has ? number(value, 3) : "-"; };
  const auto row = [&](std::string t, Vector3d length, const navigation::ReferenceError& e, double nees) {
    const double deg = earth::kDegree;
    table.row({std::move(t), cell(ref.has_position, length[0]), cell(ref.has_position, 3 * e.position_sigma.norm()),
               cell(ref.has_velocity, length[1]), cell(ref.has_velocity, 3 * e.velocity_sigma.norm()),
               cell(ref.has_attitude, length[2] / deg), cell(ref.has_attitude, 3 * e.attitude_sigma.norm() / deg),
               number(nees / ref.dof, 3)});
  };
  constexpr std::size_t kRows = 10;
  const std::size_t n = ref.errors.size();
  std::size_t last = n;
  for (std::size_t i = 0; i <= kRows; ++i) {
    const std::size_t at = (n - 1) * i / kRows;
    if (at == last) continue;
    last = at;
    const auto& e = ref.errors[at];
    row(fmt::format("{:.6g}", e.time), {e.position.norm(), e.velocity.norm(), e.attitude.norm()}, e, e.nees);
  }
  table.row({"rms", cell(ref.has_position, ref.position_rms), "", cell(ref.has_velocity, ref.velocity_rms), "",
             cell(ref.has_attitude, ref.attitude_rms / earth::kDegree), "", number(ref.nees_mean / ref.dof, 3)});
  out += table.text();
  out += fmt::format(
      "  NEES (squared error over what the filter claims; right sigmas and a perfect reference give 1): {} of the epochs in the 95 % band {} to {}\n",
      percent(ref.nees_inside_95), number(ref.nees_low / ref.dof, 3), number(ref.nees_high / ref.dof, 3));
  return out;
}

// A time of the scene on the clock of the log, to the nanosecond: those of an epoch have more digits than a double.
std::string on_log_clock(const NavigationResult& r, double t) {
  constexpr std::int64_t kSecond = noise::kNanosecondsPerSecond;
  const std::int64_t ns = r.recording.origin + std::llround(t * kSecond);
  std::string text = fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", std::abs(ns) / kSecond, std::abs(ns) % kSecond);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string_view status_word(navigation::Innovation::Status status) {
  switch (status) {
    case navigation::Innovation::Status::gated:
      return "gated";
    case navigation::Innovation::Status::not_finite:
      return "not_finite";
    default:
      return "used";
  }
}

}  // namespace

std::string_view unit_of(Aid::Kind kind) {
  switch (kind) {
    case Aid::Kind::position:
    case Aid::Kind::height:
      return "m";
    case Aid::Kind::attitude:
      return "deg";
    default:
      return "m/s";
  }
}

StateText state_text(const navigation::Scenario& scenario, const navigation::ErrorTerm& term) {
  if (term.carrier == Carrier::aid) return aid_state_text(scenario.aids.at(static_cast<std::size_t>(term.aid)), term);
  const bool gyro = term.carrier == Carrier::gyro;
  const auto with = [&](std::string_view unit) {
    std::string name = navigation::name(term);
    if (std::isfinite(term.correlation_time)) name += fmt::format(", {} s", number(term.correlation_time, 3));
    return StateText{name, std::string(unit), noise::parse_unit(unit).to_si};
  };
  switch (term.effect) {
    case Effect::scale_factor:
      return with("ppm");
    case Effect::misalignment:
      return {navigation::name(term), "arcsec", noise::parse_unit("arcsec").to_si};
    case Effect::g_sensitivity:
      return with("deg/h/g");
    default:
      return with(gyro ? "deg/h" : "ug");
  }
}

std::string navigation_text(const NavigationResult& r) {
  std::string out = heading(r);
  std::vector<std::string> words = r.run.alignment.words;
  if (r.run.status == Navigation::Status::lost)
    out += fmt::format("\n{}", wrapped("LOST, use no number of this run: " + r.run.why, "", "  "));
  else if (!r.run.usable())
    out += fmt::format("\n{}", wrapped("No whole solution: " + r.run.why, "", "  "));
  out += bullets("Suspects, each tried by a run", suspects_lines(r));
  out += bullets("Lost and found", lost_texts(r));
  out += bullets("Alignment", words);
  if (!r.run.solutions.empty()) out += final_solution(r);
  out += aids_table(r);
  out += bullets("What the innovations say", innovation_texts(r));
  out += states_table(r) + reference_text(r);
  std::vector<std::string> left_out;
  for (const auto& l : r.run.left_out) left_out.push_back(fmt::format("{}: {}", l.what, l.why));
  return out + bullets("Left out of the filter", left_out) + bullets("How the data were read", r.notes);
}

std::string solution_csv(const NavigationResult& r) {
  constexpr std::array<const char*, 3> kLocal{"east", "north", "up"};
  std::string out =
      "time (s),latitude (deg),longitude (deg),height (m),velocity_north (m/s),velocity_east (m/s),velocity_down (m/s),q_w (1),q_x (1),q_y (1),q_z (1),heading (deg),pitch (deg),roll (deg)";
  for (const auto* what : {"position_{} (m)", "velocity_{} (m/s)", "attitude_{} (deg)"})
    for (const auto* axis : kLocal) out += fmt::format(",sigma_{}", fmt::format(fmt::runtime(what), axis));
  for (const auto* what : {"gyro_bias_{} (rad/s)", "accel_bias_{} (m/s^2)"})
    for (const auto* axis : {"x", "y", "z"}) {
      const std::string name = fmt::format(fmt::runtime(what), axis);
      out += fmt::format(",{0},sigma_{0}", name);
    }
  out += ",lost (1)\n";
  const double deg = earth::kDegree;
  for (const navigation::Solution& s : r.run.solutions) {
    const earth::Geodetic at = earth::to_geodetic(s.state.p_eb_e);
    const Eigen::Matrix3d C_en = earth::C_e_ned(at.latitude, at.longitude);
    const Vector3d v = C_en.transpose() * s.state.v_eb_e;
    Eigen::Quaterniond q = Eigen::Quaterniond(C_en).conjugate() * s.state.q_eb;
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const earth::Euler e = earth::to_euler(q);
    auto to = std::back_inserter(out);
    fmt::format_to(
        to, "{},{:.12g},{:.12g},{:.6f},{:.7g},{:.7g},{:.7g},{:.12g},{:.12g},{:.12g},{:.12g},{:.7g},{:.7g},{:.7g}",
        on_log_clock(r, s.time), at.latitude / deg, at.longitude / deg, at.height, v[0], v[1], v[2], q.w(), q.x(),
        q.y(), q.z(), e.yaw / deg, e.pitch / deg, e.roll / deg);
    for (int i = 0; i < 3; ++i) fmt::format_to(to, ",{:.5g}", s.position_sigma[i]);
    for (int i = 0; i < 3; ++i) fmt::format_to(to, ",{:.5g}", s.velocity_sigma[i]);
    for (int i = 0; i < 3; ++i) fmt::format_to(to, ",{:.5g}", s.attitude_sigma[i] / deg);
    for (int i = 0; i < 3; ++i) fmt::format_to(to, ",{:.6g},{:.4g}", s.gyro_bias[i], s.gyro_bias_sigma[i]);
    for (int i = 0; i < 3; ++i)
      fmt::format_to(to, ",{:.6g},{:.4g}", s.accelerometer_bias[i], s.accelerometer_bias_sigma[i]);
    out += s.lost ? ",1\n" : ",0\n";
  }
  return out;
}

std::string innovations_csv(const NavigationResult& r) {
  std::string out = "time (s),aid,status,nis (1),dof (1),residual_1,residual_2,residual_3,sigma_1,sigma_2,sigma_3\n";
  auto to = std::back_inserter(out);
  for (const auto& at : r.run.innovations) {
    const auto& i = at.innovation;
    fmt::format_to(to, "{},{},{},{:.6g},{}", on_log_clock(r, at.time), r.scenario.aids[at.aid].name,
                   status_word(i.status), i.nis, i.rows);
    for (const Vector3d* v : {&i.residual, &i.sigma})
      for (int k = 0; k < 3; ++k) out += k < i.rows ? fmt::format(",{:.6g}", (*v)[k]) : ",";
    out += "\n";
  }
  return out;
}

}  // namespace gyrobudget::inline v0::report

// SPDX-License-Identifier: MIT
#include "fixes_file.h"

#include "gyrobudget/estimation/navigation/simulated_fixes.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <fmt/format.h>

#include <cstdint>
#include <map>

namespace gyrobudget::inline v0::files {
namespace {

using navigation::Aid;
using navigation::Fix;

std::string_view header(Aid::Kind kind) {
  switch (kind) {
    case Aid::Kind::position:
      return ",latitude (deg),longitude (deg),height (m)";
    case Aid::Kind::velocity:
      return ",velocity_north (m/s),velocity_east (m/s),velocity_down (m/s)";
    case Aid::Kind::height:
      return ",height (m)";
    case Aid::Kind::attitude:
      return ",q_w (1),q_x (1),q_y (1),q_z (1)";
    case Aid::Kind::rest:
      break;
  }
  return "";
}

std::string_view empty_cells(Aid::Kind kind) {
  return kind == Aid::Kind::height ? "," : kind == Aid::Kind::attitude ? ",,,," : ",,,";
}

std::string cells(Aid::Kind kind, const Fix& fix) {
  switch (kind) {
    case Aid::Kind::position: {
      const earth::Geodetic at = earth::to_geodetic(fix.value);
      return fmt::format(",{:.11f},{:.11f},{:.6f}", at.latitude / earth::kDegree, at.longitude / earth::kDegree,
                         at.height);
    }
    case Aid::Kind::velocity:
      return fmt::format(",{:.9g},{:.9g},{:.9g}", fix.value[0], fix.value[1], fix.value[2]);
    case Aid::Kind::height:
      return fmt::format(",{:.6f}", fix.value[0]);
    case Aid::Kind::attitude: {
      const double sign = fix.q_nb.w() < 0 ? -1 : 1;
      return fmt::format(",{:.12f},{:.12f},{:.12f},{:.12f}", sign * fix.q_nb.w(), sign * fix.q_nb.x(),
                         sign * fix.q_nb.y(), sign * fix.q_nb.z());
    }
    case Aid::Kind::rest:
      break;
  }
  return "";
}

}  // namespace

std::string fixes_csv(const DeviceFixes& device) {
  const std::size_t kinds = device.kinds.size();
  std::map<std::int64_t, std::vector<const Fix*>> rows;
  for (std::size_t k = 0; k < kinds; ++k)
    for (const Fix& fix : device.fixes[k]) {
      auto& row = rows[fix.stamp];
      row.resize(kinds, nullptr);
      row[k] = &fix;
    }
  std::string out = "time (s)";
  for (const auto kind : device.kinds) out += header(kind);
  out += "\n";
  for (const auto& [stamp, row] : rows) {
    out += fmt::format("{:.9f}", static_cast<double>(stamp) * 1e-9);
    for (std::size_t k = 0; k < kinds; ++k)
      out += row[k] != nullptr ? cells(device.kinds[k], *row[k]) : std::string(empty_cells(device.kinds[k]));
    out += "\n";
  }
  return out;
}

std::vector<DeviceFixes> simulated_devices(const navigation::Scenario& scenario, const earth::Trajectory& trajectory,
                                           std::uint64_t seed, std::uint64_t run) {
  std::vector<DeviceFixes> list;
  for (std::size_t i = 0; i < scenario.aids.size(); ++i) {
    const Aid& aid = scenario.aids[i];
    if (!aid.used || aid.kind == Aid::Kind::rest) continue;
    const std::string device = aid.name.substr(0, aid.name.rfind('.'));
    if (list.empty() || list.back().device != device) list.push_back({device, {}, {}});
    list.back().kinds.push_back(aid.kind);
    list.back().fixes.push_back(navigation::simulated_fixes(aid, static_cast<int>(i), trajectory, seed, run,
                                                            static_cast<int>(navigation::clock_of(scenario.aids, i))));
  }
  return list;
}

}  // namespace gyrobudget::inline v0::files

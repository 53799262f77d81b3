// SPDX-License-Identifier: MIT
#include "fix_columns.h"

#include <algorithm>
#include <string>

namespace gyrobudget::inline v0::files::columns {
namespace {

// Sources: common_interfaces of ROS, PX4's messages, ArduPilot's log messages, RTKLIB 2.4, NMEA 0183, gpsd_json(5).
const std::vector<FixStream>& fix_streams() {
  static const std::vector<std::pair<std::string_view, std::string_view>> kPx4{
      {"latitude", "latitude_deg"},
      {"latitude", "lat"},
      {"longitude", "longitude_deg"},
      {"longitude", "lon"},
      {"height", "altitude_ellipsoid_m"},
      {"height", "alt_ellipsoid"},
      {"height_over_geoid", "altitude_msl_m"},
      {"height_over_geoid", "alt"},
      {"velocity_north", "vel_n_m_s"},
      {"velocity_east", "vel_e_m_s"},
      {"velocity_down", "vel_d_m_s"},
      {"position_sigma_horizontal", "eph"},
      {"position_sigma_up", "epv"},
      {"velocity_sigma", "s_variance_m_s"},  // a sigma, for all its name
      {"quality", "fix_type"}};
  static const std::vector<FixStream> kStreams{{"sensor_msgs/NavSatFix",
                                                {{"height", "altitude"},
                                                 {"position_sigma_east", "position_covariance[0]"},
                                                 {"position_sigma_north", "position_covariance[4]"},
                                                 {"position_sigma_up", "position_covariance[8]"},
                                                 {"quality", "status.status"}},
                                                0,
                                                2},
                                               {"vehicle_gps_position", kPx4, 3, 6},
                                               {"sensor_gps", kPx4, 3, 6},
                                               {"GPS",
                                                {{"latitude", "Lat"},
                                                 {"longitude", "Lng"},
                                                 {"height_over_geoid", "Alt"},
                                                 {"speed", "Spd"},
                                                 {"course", "GCrs"},
                                                 {"velocity_down", "VZ"},
                                                 {"position_sigma_horizontal", "HAcc"},
                                                 {"position_sigma_up", "VAcc"},
                                                 {"velocity_sigma", "SAcc"},
                                                 {"quality", "Status"}},
                                                3,
                                                6,
                                                "GPA"},
                                               {"RTKLIB solution", {}, 1, 6},
                                               {"NMEA", {}, 1, 5},
                                               {"gpsd TPV", {}, 2, 3}};
  return kStreams;
}

/// ROS 2 names a type with one part more: "sensor_msgs/msg/NavSatFix".
std::string as_ros1(std::string_view type) {
  constexpr std::string_view kPart = "/msg/";
  const std::size_t at = type.find(kPart);
  if (at == std::string_view::npos) return std::string(type);
  return std::string(type.substr(0, at)) + std::string(type.substr(at + kPart.size() - 1));
}

}  // namespace

const FixStream* fix_stream(std::string_view type) {
  const auto& streams = fix_streams();
  const auto found = std::ranges::find(streams, as_ros1(type), &FixStream::type);
  return found == streams.end() ? nullptr : &*found;
}

log::ColumnMap named(const log::NamedFile& file, const log::ColumnMap& of_scene) {
  log::ColumnMap map = of_scene;
  const FixStream* stream = file.stream() ? fix_stream(file.stream()->type) : nullptr;
  if (!stream) return map;
  for (const auto& [ours, theirs] : stream->names)
    if (file.has(theirs)) map.emplace(ours, theirs);
  return map;
}

}  // namespace gyrobudget::inline v0::files::columns

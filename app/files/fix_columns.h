// SPDX-License-Identifier: MIT
// The columns that fixes of aids are made of: our names, and those of the streams of known recorders.
#pragma once

#include "gyrobudget/app/log/named_file.h"

#include <array>
#include <string_view>
#include <utility>
#include <vector>

#include "scene_columns.h"

namespace gyrobudget::inline v0::files::columns {

namespace dimension = noise::dimension;

inline constexpr log::Wanted kHeightOverGeoid{"height_over_geoid", {"altmsl"}, dimension::kLength};
/// Of the geoid over the ellipsoid.
inline constexpr log::Wanted kGeoidHeight{"geoid_height", {"geoid_separation"}, dimension::kLength};
inline constexpr std::array<log::Wanted, 3> kEcef{
    {{"ecef_x", {}, dimension::kLength}, {"ecef_y", {}, dimension::kLength}, {"ecef_z", {}, dimension::kLength}}};
/// From a base to the antenna, and the base.
inline constexpr std::array<log::Wanted, 6> kBaseline{{{"baseline_east", {}, dimension::kLength},
                                                       {"baseline_north", {}, dimension::kLength},
                                                       {"baseline_up", {}, dimension::kLength},
                                                       {"base_latitude", {}, dimension::kAngle},
                                                       {"base_longitude", {}, dimension::kAngle},
                                                       {"base_height", {}, dimension::kLength}}};

inline constexpr log::Wanted kNorth{"velocity_north", {"v_north", "vn"}, dimension::kVelocity};
inline constexpr log::Wanted kEast{"velocity_east", {"v_east", "ve"}, dimension::kVelocity};
inline constexpr log::Wanted kDown{"velocity_down", {"v_down", "vd"}, dimension::kVelocity};
inline constexpr log::Wanted kUp{"velocity_up", {"v_up", "vu"}, dimension::kVelocity};
inline constexpr std::array<log::Wanted, 3> kEcefVelocity{{{"ecef_velocity_x", {}, dimension::kVelocity},
                                                           {"ecef_velocity_y", {}, dimension::kVelocity},
                                                           {"ecef_velocity_z", {}, dimension::kVelocity}}};
/// Over ground, and its direction from true north.
inline constexpr log::Wanted kSpeed{"speed", {"speed_over_ground"}, dimension::kVelocity};
inline constexpr log::Wanted kCourse{"course", {"course_over_ground"}, dimension::kAngle};

inline constexpr log::Wanted kHeading{"heading", {"yaw"}, dimension::kAngle};
inline constexpr log::Wanted kYawCcw{"yaw_ccw", {}, dimension::kAngle};

/// One sigma, or a variance where its unit is one.
struct SigmaColumns {
  std::array<log::Wanted, 3> local;  ///< east, north, up
  log::Wanted horizontal;            ///< of east and of north
  log::Wanted all;                   ///< of each of the three
  std::array<log::Wanted, 6> ecef;   ///< x, y, z, and roots of the covariances xy, yz, zx with their signs
};
inline constexpr SigmaColumns kPositionSigma{{{{"position_sigma_east", {}, dimension::kLength},
                                               {"position_sigma_north", {}, dimension::kLength},
                                               {"position_sigma_up", {}, dimension::kLength}}},
                                             {"position_sigma_horizontal", {}, dimension::kLength},
                                             {"position_sigma", {}, dimension::kLength},
                                             {{{"position_sigma_x", {}, dimension::kLength},
                                               {"position_sigma_y", {}, dimension::kLength},
                                               {"position_sigma_z", {}, dimension::kLength},
                                               {"position_sigma_xy", {}, dimension::kLength},
                                               {"position_sigma_yz", {}, dimension::kLength},
                                               {"position_sigma_zx", {}, dimension::kLength}}}};
inline constexpr SigmaColumns kVelocitySigma{{{{"velocity_sigma_east", {}, dimension::kVelocity},
                                               {"velocity_sigma_north", {}, dimension::kVelocity},
                                               {"velocity_sigma_up", {}, dimension::kVelocity}}},
                                             {"velocity_sigma_horizontal", {}, dimension::kVelocity},
                                             {"velocity_sigma", {}, dimension::kVelocity},
                                             {{{"velocity_sigma_x", {}, dimension::kVelocity},
                                               {"velocity_sigma_y", {}, dimension::kVelocity},
                                               {"velocity_sigma_z", {}, dimension::kVelocity},
                                               {"velocity_sigma_xy", {}, dimension::kVelocity},
                                               {"velocity_sigma_yz", {}, dimension::kVelocity},
                                               {"velocity_sigma_zx", {}, dimension::kVelocity}}}};

/// What a receiver says of how it found a fix.
inline constexpr log::Wanted kQuality{"quality", {}, dimension::kNumber};

/// Which columns of a known stream are ours, and which of its rows are fixes.
struct FixStream {
  std::string_view type;  ///< StreamInfo::type, as ROS 1 has it
  /// Ours and theirs; of several for one of ours the first that the stream has.
  std::vector<std::pair<std::string_view, std::string_view>> names;
  double least_quality = 0, most_quality = 0;  ///< of a fix that was measured
  std::string_view accuracy = {};  ///< message whose rows of the same time have the sigmas, "GPA" beside "GPS"
};
/// Null for a stream of another type.
[[nodiscard]] const FixStream* fix_stream(std::string_view type);

/// The columns of a file by our names: those that the scene maps, then those of its stream.
[[nodiscard]] log::ColumnMap named(const log::NamedFile& file, const log::ColumnMap& of_scene);

}  // namespace gyrobudget::inline v0::files::columns

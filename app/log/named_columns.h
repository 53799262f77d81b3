// SPDX-License-Identifier: MIT
// Tables whose columns are known by name.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "columns.h"
#include "layout.h"
#include "table.h"

namespace gyrobudget::inline v0::log {

/// A column by its name, other names in lower case that mean the same, and what it measures.
struct Wanted {
  std::string_view name;
  std::array<std::string_view, 7> others;  ///< those that are empty name nothing
  noise::Dimension dimension;
};

inline constexpr Wanted kTimeColumn{"time", {"t", "timestamp", "timeus", "sampletimefine"}, noise::dimension::kTime};

inline constexpr noise::Dimension kLengthDimension = noise::dimension::kLength;
/// Geodetic place.
inline constexpr std::array<Wanted, 3> kPlaceColumns{{{"latitude", {"lat", "lat"}, noise::dimension::kAngle},
                                                      {"longitude", {"lon", "lng"}, noise::dimension::kAngle},
                                                      {"height", {"altitude", "alt"}, kLengthDimension}}};
/// q_nb, body against north, east, down.
inline constexpr std::array<Wanted, 4> kQuaternionColumns{{{"q_w", {"qw", "q_nb_w"}, noise::dimension::kNumber},
                                                           {"q_x", {"qx", "q_nb_x"}, noise::dimension::kNumber},
                                                           {"q_y", {"qy", "q_nb_y"}, noise::dimension::kNumber},
                                                           {"q_z", {"qz", "q_nb_z"}, noise::dimension::kNumber}}};
/// The same as angles.
inline constexpr std::array<Wanted, 3> kEulerColumns{{{"yaw", {"heading", "yaw"}, noise::dimension::kAngle},
                                                      {"pitch", {"pitch", "pitch"}, noise::dimension::kAngle},
                                                      {"roll", {"roll", "roll"}, noise::dimension::kAngle}}};

/// Which column of a file stands for a name, and in what unit: {"yaw_ccw", "yaw_rad (rad)"}. The unit, with a
/// factor where a count has one ("gx (0.1 arcsec)"), may be left out where the header has it.
using ColumnMap = std::map<std::string, std::string>;

/// The columns of one log. Messages name it, and the line of its header where it has one.
class NamedColumns {
 public:
  /// @param source  its name, for messages @param map  which columns stand for which names, before all else
  /// @param expected  what the log should hold, for the message where a column is missing
  /// The source, the layout and the map must outlive this.
  NamedColumns(const std::string& source, const Layout& layout, const ColumnMap& map, std::string_view expected)
      : source_(source), layout_(layout), map_(map), expected_(expected) {}

  /// Its place, by the map first; empty where there is none.
  /// @throws InputError for a column that the map names and the file has not.
  [[nodiscard]] std::optional<std::size_t> find(const Wanted& wanted) const;
  /// The same with the factor to SI. @throws InputError also where there is none, or its unit is wrong.
  [[nodiscard]] DataColumn get(const Wanted& wanted) const;
  /// The first of several dimensions that the column's unit has: {column, which}.
  [[nodiscard]] std::pair<DataColumn, std::size_t> get(const Wanted& wanted,
                                                       const std::vector<noise::Dimension>& dimensions) const;

 private:
  struct Mapped {
    std::string name, unit;
  };
  [[nodiscard]] std::optional<Mapped> mapped(const Wanted& wanted) const;
  [[nodiscard]] std::optional<std::size_t> place(std::string_view name) const;

  const std::string& source_;
  const Layout& layout_;
  const ColumnMap& map_;
  std::string_view expected_;
};

/// The time column of a choice as whole nanoseconds beside the data columns.
void add_stamps(Choice& choice, const DataColumn& time);

}  // namespace gyrobudget::inline v0::log

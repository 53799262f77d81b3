// SPDX-License-Identifier: MIT
#include "dialects.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

namespace gyrobudget::inline v0::log {
namespace {

struct DialectColumn {
  std::string_view name;            ///< in the header; a '*' at its end stands for the rest
  std::string_view unit;            ///< of a number in it
  std::string_view scale_key = {};  ///< the line of the preamble that gives the factor to that unit; empty: `scale`
  double scale = 1;                 ///< units of one number
};

struct HeaderDialect {
  std::string_view name;
  std::string_view first_line;                ///< how the text begins; empty: any
  std::vector<std::string_view> names_of_it;  ///< columns that make it this one
  std::vector<DialectColumn> columns;
  std::string_view remark = {};
};

const std::vector<HeaderDialect>& header_dialects() {
  static const std::vector<HeaderDialect> kDialects{
      {"PX4 sensor_combined",
       "",
       {"timestamp", "gyro_rad[0]", "accelerometer_m_s2[0]"},
       {{"timestamp", "us"}, {"gyro_rad[*", "rad/s"}, {"accelerometer_m_s2[*", "m/s^2"}}},
      {"an IMU message of ArduPilot",
       "",
       {"TimeUS", "GyrX", "GyrY", "GyrZ", "AccX"},
       {{"TimeUS", "us"},
        {"GyrX", "rad/s"},
        {"GyrY", "rad/s"},
        {"GyrZ", "rad/s"},
        {"AccX", "m/s^2"},
        {"AccY", "m/s^2"},
        {"AccZ", "m/s^2"}}},
      {"Sensor Logger",
       "",
       {"time", "seconds_elapsed", "z", "y", "x"},
       {{"time", "ns"}, {"seconds_elapsed", "s"}},
       "its Gyroscope.csv is in rad/s, and its Accelerometer.csv in m/s^2 without gravity: give --unit"},
      {"Android's GnssLogger",
       "",
       {"elapsedRealtimeNanos", "utcTimeMillis"},
       {{"elapsedRealtimeNanos", "ns"},
        {"UncalGyroXRadPerSec", "rad/s"},
        {"UncalGyroYRadPerSec", "rad/s"},
        {"UncalGyroZRadPerSec", "rad/s"},
        {"UncalAccelXMps2", "m/s^2"},
        {"UncalAccelYMps2", "m/s^2"},
        {"UncalAccelZMps2", "m/s^2"}}},
      {"Xsens' MT Manager",
       "// Start Time",
       {"PacketCounter"},
       {{"SampleTimeFine", "us", "", 100},
        {"Acc_*", "m/s^2"},
        {"Gyr_*", "rad/s"},
        {"FreeAcc_*", ""},
        {"VelInc_*", "m/s"},
        {"Temperature", "degC"}},
       "SampleTimeFine counts 0.1 ms"},
      {"gyroflow",
       "GYROFLOW IMU LOG",
       {"t", "gx", "gy", "gz"},
       {{"t", "s", "tscale"},
        {"gx", "rad/s", "gscale"},
        {"gy", "rad/s", "gscale"},
        {"gz", "rad/s", "gscale"},
        {"ax", "g", "ascale"},
        {"ay", "g", "ascale"},
        {"az", "g", "ascale"}},
       "the axes stay as they were recorded"}};
  return kDialects;
}

using NamedUnit = std::pair<std::string_view, std::string_view>;

struct RowsWithoutHeader {
  std::string_view name;
  std::string_view tag;                    ///< their first cell; empty: what `is_it` says of their numbers
  bool (*is_it)(std::span<const double>);  ///< of one row
  std::vector<NamedUnit> columns;
  std::string_view remark = {};
};

/// A place, angles, gravity, and at the end how many satellites and in which modes.
bool is_oxts(std::span<const double> row) {
  constexpr std::size_t kForce = 11, kWhole = 25;
  constexpr double kLeastForce = 4, kMostForce = 20;  // [m/s^2]: a car on the road
  const double force = std::hypot(row[kForce], row[kForce + 1], row[kForce + 2]);
  return std::abs(row[0]) <= 90 && std::abs(row[1]) <= 180 && force > kLeastForce && force < kMostForce &&
         std::ranges::all_of(row.subspan(kWhole), [](double x) { return x >= -1 && x < 100 && x == std::floor(x); });
}

const std::vector<RowsWithoutHeader>& rows_without_header() {
  static const std::vector<RowsWithoutHeader> kRows{
      {"VectorNav's VNIMU",
       "$VNIMU",
       nullptr,
       {{"tag", ""},
        {"MagX", ""},
        {"MagY", ""},
        {"MagZ", ""},
        {"AccX", "m/s^2"},
        {"AccY", "m/s^2"},
        {"AccZ", "m/s^2"},
        {"GyrX", "rad/s"},
        {"GyrY", "rad/s"},
        {"GyrZ", "rad/s"},
        {"Temp", "degC"},
        {"Pres", ""}}},
      // Of its two triads the one along the vehicle's axes has units; the other is the same, levelled.
      {"KITTI's oxts",
       "",
       is_oxts,
       {{"lat", "deg"},
        {"lon", "deg"},
        {"alt", "m"},
        {"roll", "rad"},
        {"pitch", "rad"},
        {"yaw_ccw", "rad"},
        {"vn", "m/s"},
        {"ve", "m/s"},
        {"vf", ""},
        {"vl", ""},
        {"vu", "m/s"},
        {"ax", "m/s^2"},
        {"ay", "m/s^2"},
        {"az", "m/s^2"},
        {"af", ""},
        {"al", ""},
        {"au", ""},
        {"wx", "rad/s"},
        {"wy", "rad/s"},
        {"wz", "rad/s"},
        {"wf", ""},
        {"wl", ""},
        {"wu", ""},
        {"pos_accuracy", "m"},
        {"vel_accuracy", "m/s"},
        {"navstat", ""},
        {"numsats", ""},
        {"posmode", ""},
        {"velmode", ""},
        {"orimode", ""}},
       "its files have no time: give the rate, 10 Hz of synced and 100 Hz of raw sequences"}};
  return kRows;
}

struct ForeignLine {
  std::string_view start;
  std::string_view advice;
};

constexpr ForeignLine kForeign[] = {
    {"%RAWIMUS",
     "found NovAtel's RAWIMUS, counts in the order Z, -Y, X whose size is that of the IMU; take its numbers out (tr ';*' ',,' < LOG | cut -d, -f5,7-12) and give --scale and --unit with --input increment, the accelerometer's and the gyro's apart"},
    {"#RAWIMU",
     "found NovAtel's RAWIMU, counts in the order Z, -Y, X whose size is that of the IMU; take its numbers out (cut -d';' -f2 < LOG | tr '*' ',') and give --scale and --unit with --input increment, the accelerometer's and the gyro's apart"},
    {"# UncalGyro,",
     "found a log of Android's GnssLogger, rows of many kinds; take one of them: (grep '^# UncalGyro,' LOG | cut -c3-; grep '^UncalGyro,' LOG) > gyro.csv"},
    {"{\"",
     "found JSON, expected a table; convert it, as in jq -r '[.ts,.gx,.gy,.gz]|@csv' LOG > log.csv, and name the columns"},
    {"H Product:Blackbox", "found a Blackbox log of a flight controller; decode it first: blackbox_decode LOG"}};

/// The number behind a key in the preamble: "gscale,0.0012"; empty where there is none.
std::optional<double> preamble_number(const Layout& layout, std::string_view key) {
  for (const std::string_view line : layout.preamble) {
    const std::size_t end = line.find_first_of(",;\t=");
    if (end == std::string_view::npos || text::trim(line.substr(0, end)) != key) continue;
    double value = 0;
    const auto cell = text::parse_number(text::trim(line.substr(end + 1)), false, value);
    if (cell == text::Cell::number && value != 0) return value;
  }
  return std::nullopt;
}

bool has_name(const Layout& layout, std::string_view name) {
  return std::ranges::find(layout.headings, name, &Heading::name) != layout.headings.end();
}

bool is_of(const Layout& layout, const HeaderDialect& dialect) {
  if (!layout.first_line.starts_with(dialect.first_line)) return false;
  return std::ranges::all_of(dialect.names_of_it, [&](auto name) { return has_name(layout, name); });
}

bool is_named(const DialectColumn& column, std::string_view name) {
  return column.name.ends_with('*') ? name.starts_with(column.name.substr(0, column.name.size() - 1))
                                    : name == column.name;
}

ToldUnit told(const Layout& layout, const HeaderDialect& dialect, const Heading& heading) {
  const auto column =
      std::ranges::find_if(dialect.columns, [&](const DialectColumn& c) { return is_named(c, heading.name); });
  if (column == dialect.columns.end()) return {};
  if (column->scale_key.empty()) return {std::string(column->unit), column->scale};
  const auto scale = preamble_number(layout, column->scale_key);
  return scale ? ToldUnit{std::string(column->unit), *scale} : ToldUnit{};
}

}  // namespace

std::optional<Recognised> recognise(const Layout& layout) {
  for (const HeaderDialect& dialect : header_dialects()) {
    if (!is_of(layout, dialect)) continue;
    Recognised result;
    result.note = fmt::format("by its header this is {}, whose format has the units{}{}", dialect.name,
                              dialect.remark.empty() ? "" : "; ", dialect.remark);
    for (const Heading& h : layout.headings) result.columns.push_back(told(layout, dialect, h));
    return result;
  }
  return std::nullopt;
}

std::optional<KnownRows> headings_of_known_rows(const Layout& layout) {
  const auto is_row_of = [&](const RowsWithoutHeader& rows, const std::vector<std::string_view>& cells) {
    if (cells.size() != rows.columns.size()) return false;
    if (!rows.is_it) return cells.front() == rows.tag;
    std::vector<double> numbers(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (text::parse_number(cells[i], layout.dialect.decimal_comma, numbers[i]) != text::Cell::number) return false;
    }
    return rows.is_it(numbers);
  };
  for (const RowsWithoutHeader& rows : rows_without_header()) {
    if (!std::ranges::all_of(layout.sample, [&](const auto& cells) { return is_row_of(rows, cells); })) continue;
    KnownRows known;
    for (const auto& [name, unit] : rows.columns) known.headings.push_back({std::string(name), std::string(unit), 1});
    known.note = fmt::format("by their form the rows are {}, whose format has the units{}{}", rows.name,
                             rows.remark.empty() ? "" : "; ", rows.remark);
    return known;
  }
  return std::nullopt;
}

std::string_view advice_on(std::string_view line) {
  line = text::trim(line);
  const auto* found = std::ranges::find_if(kForeign, [&](const auto& f) { return line.starts_with(f.start); });
  return found == std::end(kForeign) ? std::string_view{} : found->advice;
}

}  // namespace gyrobudget::inline v0::log

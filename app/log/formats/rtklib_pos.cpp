// SPDX-License-Identifier: MIT
#include "rtklib_pos.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "../calendar.h"
#include "table_recording.h"

namespace gyrobudget::inline v0::log::rtklib {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kGpsEpoch_s = 315'964'800;  // 1980-01-06, from 1970

/// A column of the header, and the field that it becomes.
struct KnownColumn {
  std::string_view theirs, ours, unit;
  bool is_sigma = false;  ///< 0 stands for none
};
constexpr KnownColumn kColumns[] = {
    {"latitude(deg)", "latitude", "deg"},
    {"longitude(deg)", "longitude", "deg"},
    {"latitude(d'\")", "latitude", "deg"},
    {"longitude(d'\")", "longitude", "deg"},
    {"height(m)", "height", "m"},
    {"x-ecef(m)", "ecef_x", "m"},
    {"y-ecef(m)", "ecef_y", "m"},
    {"z-ecef(m)", "ecef_z", "m"},
    {"e-baseline(m)", "baseline_east", "m"},
    {"n-baseline(m)", "baseline_north", "m"},
    {"u-baseline(m)", "baseline_up", "m"},
    {"Q", "quality", ""},
    {"ns", "satellites", ""},
    {"sdn(m)", "position_sigma_north", "m", true},
    {"sde(m)", "position_sigma_east", "m", true},
    {"sdu(m)", "position_sigma_up", "m", true},
    {"sdx(m)", "position_sigma_x", "m", true},
    {"sdy(m)", "position_sigma_y", "m", true},
    {"sdz(m)", "position_sigma_z", "m", true},
    {"sdxy(m)", "position_sigma_xy", "m"},
    {"sdyz(m)", "position_sigma_yz", "m"},
    {"sdzx(m)", "position_sigma_zx", "m"},
    {"age(s)", "age", "s"},
    {"ratio", "ratio", ""},
    {"vn(m/s)", "velocity_north", "m/s"},
    {"ve(m/s)", "velocity_east", "m/s"},
    {"vu(m/s)", "velocity_up", "m/s"},
    {"vx(m/s)", "ecef_velocity_x", "m/s"},
    {"vy(m/s)", "ecef_velocity_y", "m/s"},
    {"vz(m/s)", "ecef_velocity_z", "m/s"},
    {"sdvn", "velocity_sigma_north", "m/s", true},
    {"sdve", "velocity_sigma_east", "m/s", true},
    {"sdvu", "velocity_sigma_up", "m/s", true},
    {"sdvx", "velocity_sigma_x", "m/s", true},
    {"sdvy", "velocity_sigma_y", "m/s", true},
    {"sdvz", "velocity_sigma_z", "m/s", true},
    {"sdvxy", "velocity_sigma_xy", "m/s"},
    {"sdvyz", "velocity_sigma_yz", "m/s"},
    {"sdvzx", "velocity_sigma_zx", "m/s"},
};
constexpr std::array<std::string_view, 3> kClocks{"GPST", "UTC", "JST"};
constexpr std::array<std::string_view, 3> kPlaces{"latitude", "ecef_x", "baseline_east"};

bool is_mark(char c) { return c == ' ' || c == '\t' || c == ',' || c == ';'; }

/// The cells of a line: the separator is an option of RTKLIB.
std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  line = text::trim(line);
  while (!line.empty()) {
    const auto begin = std::ranges::find_if_not(line, is_mark);
    line.remove_prefix(static_cast<std::size_t>(begin - line.begin()));
    const auto length = static_cast<std::size_t>(std::ranges::find_if(line, is_mark) - line.begin());
    if (length > 0) cells.push_back(line.substr(0, length));
    line.remove_prefix(length);
  }
  return cells;
}

const KnownColumn* known_column(std::string_view name) {
  const auto* found = std::ranges::find_if(kColumns, [&](const KnownColumn& c) {
    return c.theirs == name ||
           (name.ends_with("(m/s)") && c.theirs.starts_with("sd") && c.theirs == name.substr(0, name.size() - 5));
  });
  return found == std::end(kColumns) ? nullptr : found;
}

/// "%  GPST   latitude(deg) longitude(deg) ...": without the mark and the clock; empty for another line.
struct HeaderLine {
  std::string_view clock;
  std::vector<std::string_view> columns;
};
std::optional<HeaderLine> header_of(std::string_view line) {
  line = text::trim(line);
  if (!line.starts_with('%')) return std::nullopt;
  std::vector<std::string_view> cells = cells_of(line.substr(1));
  if (cells.size() < 4 || std::ranges::find(kClocks, cells[0]) == kClocks.end()) return std::nullopt;
  HeaderLine header{cells[0], {cells.begin() + 1, cells.end()}};
  const KnownColumn* first = known_column(header.columns.front());
  if (!first || std::ranges::find(kPlaces, first->ours) == kPlaces.end()) return std::nullopt;
  return header;
}

/// Goes through the lines of a text.
template <class Take>
void each_line(std::string_view text, Take take) {
  for (std::int64_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    take(text.substr(0, end), number);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

double number_of(std::string_view cell) {
  double value = kNone;
  return text::parse_number(cell, false, value) == text::Cell::number ? value : kNone;
}

/// A date and a time of day, or week and seconds of it [ns since 1970]; empty for what is neither.
std::optional<std::int64_t> stamp_of(std::string_view first, std::string_view second) {
  std::int64_t day = 0, time = 0;
  if (parse_calendar(first, StampForm::date, day) == text::Cell::number) {
    if (parse_calendar(second, StampForm::time_of_day, time) != text::Cell::number || time > kDay) return std::nullopt;
    return day + time;
  }
  constexpr double kMostWeeks = 12'000;  // of 64 bits of nanoseconds
  const double week = number_of(first);
  const bool is_time = text::parse_stamp(second, false, noise::kNanosecondsPerSecond, time) == text::Cell::number;
  if (!(week >= 0 && week < kMostWeeks) || week != std::floor(week) || !is_time || time < 0 || time > kWeek)
    return std::nullopt;
  return kGpsEpoch_s * noise::kNanosecondsPerSecond + static_cast<std::int64_t>(week) * kWeek + time;
}

/// "40 05 59.9", of which the degrees carry the sign.
double from_degrees_minutes_seconds(std::span<const std::string_view> cells) {
  const double degrees = number_of(cells[0]), minutes = number_of(cells[1]), seconds = number_of(cells[2]);
  const double size = std::abs(degrees) + minutes / 60 + seconds / 3600;
  return cells[0].starts_with('-') ? -size : size;
}

class Reader {
 public:
  explicit Reader(const Bytes& bytes) : bytes_(bytes) {}

  std::unique_ptr<Recording> read() {
    each_line(bytes_.text(), [&](std::string_view line, std::int64_t number) { take(line, number); });
    StreamInfo& info = table_.info;
    info.name = "solution";
    info.type = "RTKLIB solution";
    info.kind = StreamKind::gnss;
    info.clock = clock_;
    if (left_out_ > 0 && table_.rows.stamps_ns.empty())
      text::fail_at(
          bytes_.name(), first_left_out_, 1,
          fmt::format(
              "found no row of the {} columns of the header, expected a date and time, or week and seconds, before them",
              columns_.size()));
    if (left_out_ > 0)
      notes_.push_back(
          fmt::format("{} lines are left out, the first of them line {}: they are no rows of the header's columns",
                      left_out_, first_left_out_));
    if (bytes_.cut()) notes_.emplace_back("the packed data stop in the middle");
    note_heights();
    std::vector<StreamTable> tables;
    tables.push_back(std::move(table_));
    return std::make_unique<TableRecording>("RTKLIB solution", std::move(tables), std::move(notes_));
  }

 private:
  void take(std::string_view line, std::int64_t number) {
    if (text::trim(line).empty()) return;
    if (!text::trim(line).starts_with('%')) return take_row(line, number);
    if (const auto header = header_of(line)) return take_header(*header, number);
    if (line.find("geodetic") != std::string_view::npos) heights_ = Heights::geodetic;
    if (line.find("ellipsoidal") != std::string_view::npos) heights_ = Heights::ellipsoidal;
    take_base(line);
  }

  // A solution may be written behind another one: its header has to be the same.
  void take_header(const HeaderLine& header, std::int64_t number) {
    if (!columns_.empty()) {
      if (header.columns == columns_ && header.clock == clock_) return;
      text::fail_at(
          bytes_.name(), number, 1,
          "found a second header with other columns or another clock, expected one solution a file; split it");
    }
    clock_ = header.clock;
    columns_ = header.columns;
    for (const std::string_view column : columns_) {
      const KnownColumn* known = known_column(column);
      const bool has_it =
          known && std::ranges::find(table_.info.fields, known->ours, &Field::name) != table_.info.fields.end();
      known_.push_back(has_it ? nullptr : known);
      if (!known || has_it) continue;
      const bool over_geoid = known->ours == "height" && heights_ == Heights::geodetic;
      table_.info.fields.push_back({over_geoid ? "height_over_geoid" : std::string(known->ours),
                                    std::string(known->unit), known->unit.empty() ? "" : "the header of the solution"});
    }
    add_base_fields();
    table_.rows.columns.resize(table_.info.fields.size());
  }

  void take_base(std::string_view line) {
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || line.find("ref pos") == std::string_view::npos) return;
    for (const std::string_view cell : cells_of(line.substr(colon + 1))) base_.push_back(number_of(cell));
  }

  void add_base_fields() {
    constexpr std::size_t kThree = 3, kDegreesMinutesSeconds = 7;
    if (known_.empty() || !known_.front() || known_.front()->ours != "baseline_east") return;
    if (base_.size() == kDegreesMinutesSeconds) {
      const auto angle = [&](std::size_t at) {
        const double size = std::abs(base_[at]) + base_[at + 1] / 60 + base_[at + 2] / 3600;
        return std::signbit(base_[at]) ? -size : size;
      };
      base_ = {angle(0), angle(3), base_[6]};
    }
    if (base_.size() != kThree) return base_.clear();
    constexpr std::array<std::string_view, 3> kNames{"base_latitude", "base_longitude", "base_height"};
    for (std::size_t i = 0; i < kThree; ++i)
      table_.info.fields.push_back({std::string(kNames[i]), i < 2 ? "deg" : "m", "the line \"ref pos\""});
  }

  void leave_out(std::int64_t number) {
    if (left_out_++ == 0) first_left_out_ = number;
  }

  void take_row(std::string_view line, std::int64_t number) {
    if (columns_.empty()) return leave_out(number);
    const std::vector<std::string_view> cells = cells_of(line);
    constexpr std::size_t kTime = 2;  // cells
    if (cells.size() < kTime) return leave_out(number);
    const auto stamp = stamp_of(cells[0], cells[1]);
    std::vector<double> row;
    std::size_t at = kTime;
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const std::size_t width = columns_[i].ends_with("(d'\")") ? 3 : 1;
      if (at + width > cells.size()) return leave_out(number);
      const std::span<const std::string_view> of(cells.data() + at, width);
      at += width;
      if (!known_[i]) continue;
      double value = width == 1 ? kNone : from_degrees_minutes_seconds(of);
      if (width == 1 && text::parse_number(of[0], false, value) == text::Cell::text) return leave_out(number);
      row.push_back(known_[i]->is_sigma && value == 0 ? kNone : value);
    }
    if (!stamp || at != cells.size()) return leave_out(number);
    row.insert(row.end(), base_.begin(), base_.end());
    table_.rows.stamps_ns.push_back(*stamp);
    for (std::size_t i = 0; i < row.size(); ++i) table_.rows.columns[i].push_back(row[i]);
  }

  void note_heights() {
    if (heights_ != Heights::unsaid ||
        std::ranges::find(table_.info.fields, "height", &Field::name) == table_.info.fields.end())
      return;
    table_.rows.notes.emplace_back(
        "no line says whether heights are ellipsoidal or geodetic: they are taken as ellipsoidal, as RTKLIB writes them when nothing else is asked");
  }

  enum class Heights { unsaid, ellipsoidal, geodetic };
  const Bytes& bytes_;
  StreamTable table_;
  std::vector<std::string> notes_;
  std::string clock_;
  std::vector<std::string_view> columns_;  ///< of the header
  std::vector<const KnownColumn*> known_;  ///< one for each; null for what is passed over
  std::vector<double> base_;               ///< latitude, longitude [deg], height [m]
  Heights heights_ = Heights::unsaid;
  std::int64_t left_out_ = 0, first_left_out_ = 0;
};

}  // namespace
}  // namespace gyrobudget::inline v0::log::rtklib

namespace gyrobudget::inline v0::log {

bool is_rtklib_pos(std::string_view head) {
  if (!head.starts_with('%')) return false;
  bool found = false;
  rtklib::each_line(head,
                    [&](std::string_view line, std::int64_t) { found = found || rtklib::header_of(line).has_value(); });
  return found;
}

std::unique_ptr<Recording> open_rtklib_pos(std::shared_ptr<const Bytes> bytes) { return rtklib::Reader(*bytes).read(); }

}  // namespace gyrobudget::inline v0::log

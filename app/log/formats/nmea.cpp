// SPDX-License-Identifier: MIT
#include "nmea.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "../calendar.h"
#include "table_recording.h"

namespace gyrobudget::inline v0::log::nmea {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kKnot = 1852.0 / 3600;  // [m/s]

/// The columns of a row, in this order.
enum Column : std::size_t {
  latitude,
  longitude,
  height_over_geoid,
  geoid_height,
  quality,
  satellites,
  hdop,
  speed,
  course,
  sigma_north,
  sigma_east,
  sigma_up,
  columns
};
constexpr std::array<std::pair<std::string_view, std::string_view>, columns> kFields{{{"latitude", "deg"},
                                                                                      {"longitude", "deg"},
                                                                                      {"height_over_geoid", "m"},
                                                                                      {"geoid_height", "m"},
                                                                                      {"quality", ""},
                                                                                      {"satellites", ""},
                                                                                      {"hdop", ""},
                                                                                      {"speed", "m/s"},
                                                                                      {"course", "deg"},
                                                                                      {"position_sigma_north", "m"},
                                                                                      {"position_sigma_east", "m"},
                                                                                      {"position_sigma_up", "m"}}};

// --- Sentences ------------------------------------------------------------------------------------------------------

/// "$GPGGA,...*5C" without its mark and checksum.
struct Sentence {
  std::string_view kind;                ///< "GGA"
  std::vector<std::string_view> cells;  ///< behind the name
  [[nodiscard]] std::string_view cell(std::size_t i) const { return i < cells.size() ? cells[i] : std::string_view(); }
};
enum class Line { sentence, wrong_checksum, other };

constexpr std::array<std::string_view, 5> kKinds{"GGA", "RMC", "VTG", "GST", "ZDA"};

int hex_digit(char c) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  const std::size_t at = kDigits.find(static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c));
  return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

/// The exclusive or of all characters is what the two digits behind the star say.
bool is_right(std::string_view content, std::string_view digits) {
  unsigned sum = 0;
  for (const char c : content) sum ^= static_cast<unsigned char>(c);
  constexpr int kHigh = 16;
  return digits.size() == 2 && hex_digit(digits[0]) >= 0 && hex_digit(digits[1]) >= 0 &&
         static_cast<unsigned>(hex_digit(digits[0]) * kHigh + hex_digit(digits[1])) == sum;
}

/// A sentence without a checksum is no proof of itself: it counts as one with a wrong one.
Line parse(std::string_view line, Sentence& sentence) {
  line = text::trim(line);
  constexpr std::size_t kName = 6;  // "$GPGGA"
  if (!line.starts_with('$') || line.size() <= kName || line[kName] != ',') return Line::other;
  sentence.kind = line.substr(3, 3);
  if (std::ranges::find(kKinds, sentence.kind) == kKinds.end()) return Line::other;
  const std::size_t star = line.rfind('*');
  if (star == std::string_view::npos || !is_right(line.substr(1, star - 1), line.substr(star + 1)))
    return Line::wrong_checksum;
  sentence.cells.clear();
  std::string_view rest = line.substr(kName + 1, star - kName - 1);
  for (;;) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    sentence.cells.push_back(rest.substr(0, comma));
    if (comma == rest.size()) return Line::sentence;
    rest.remove_prefix(comma + 1);
  }
}

double number(std::string_view cell) {
  double value = kNone;
  return text::parse_number(cell, false, value) == text::Cell::number ? value : kNone;
}

/// So many digits; -1 for anything else.
int digits(std::string_view cell, std::size_t at, std::size_t count) {
  int value = 0;
  if (at + count > cell.size()) return -1;
  for (const char c : cell.substr(at, count)) {
    if (!text::is_digit(c)) return -1;
    value = 10 * value + (c - '0');
  }
  return value;
}

/// "172814.25" [ns since midnight].
std::optional<std::int64_t> time_of(std::string_view cell) {
  const int hours = digits(cell, 0, 2), minutes = digits(cell, 2, 2), whole = digits(cell, 4, 2);
  std::int64_t seconds = 0;
  constexpr int kLeapSecond = 60;
  if (hours < 0 || hours > 23 || minutes < 0 || minutes > 59 || whole < 0 || whole > kLeapSecond) return std::nullopt;
  const bool is_number =
      text::parse_stamp(cell.substr(4), false, noise::kNanosecondsPerSecond, seconds) == text::Cell::number;
  if (!is_number || seconds > (kLeapSecond + 1) * noise::kNanosecondsPerSecond) return std::nullopt;
  return (hours * 60 + minutes) * 60 * noise::kNanosecondsPerSecond + seconds;
}

/// Days since 1970 of a day, month and year; empty for what is none.
std::optional<std::int64_t> day_of(int day, int month, int year) {
  using namespace std::chrono;
  constexpr int kFirst = 1970, kLast = 2200;  // of 64 bits of nanoseconds
  if (day < 0 || month < 0 || year < kFirst || year > kLast) return std::nullopt;
  const year_month_day date{std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                            std::chrono::day(static_cast<unsigned>(day))};
  if (!date.ok()) return std::nullopt;
  return std::int64_t{sys_days(date).time_since_epoch().count()};
}

/// "280825": years from 80 on are those of the last century.
std::optional<std::int64_t> day_of(std::string_view ddmmyy) {
  constexpr int kFirstOfGps = 80;
  const int year = digits(ddmmyy, 4, 2);
  return year < 0 ? std::nullopt
                  : day_of(digits(ddmmyy, 0, 2), digits(ddmmyy, 2, 2), year + (year < kFirstOfGps ? 2000 : 1900));
}

/// "4005.80123", "N": degrees and minutes [deg].
double angle_of(std::string_view cell, std::string_view side, std::string_view negative) {
  const std::size_t point = std::min(cell.find('.'), cell.size());
  if (point < 3) return kNone;
  const double minutes = number(cell.substr(point - 2)), degrees = number(cell.substr(0, point - 2));
  const double size = degrees + minutes / 60;
  constexpr double kMostMinutes = 60;
  if (!(minutes >= 0 && minutes < kMostMinutes) || side.size() != 1) return kNone;
  return side == negative ? -size : size;
}

// --- Epochs ---------------------------------------------------------------------------------------------------------

/// What a receiver says of one instant.
struct Epoch {
  std::int64_t time = 0;            ///< since midnight [ns]
  std::optional<std::int64_t> day;  ///< since 1970, where a sentence tells it
  std::array<double, columns> values{};
  std::array<bool, kKinds.size()> seen{};
};

class Reader {
 public:
  explicit Reader(const Bytes& bytes) : bytes_(bytes) {}

  std::unique_ptr<Recording> read() {
    std::string_view text = bytes_.text();
    Sentence sentence;
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      const Line line = parse(text.substr(0, end), sentence);
      if (line == Line::sentence) take(sentence);
      wrong_ += line == Line::wrong_checksum;
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    StreamTable table;
    table.info = {.name = "NMEA", .type = "NMEA", .kind = StreamKind::gnss, .clock = "UTC"};
    for (const auto& [name, unit] : kFields)
      table.info.fields.push_back({std::string(name), std::string(unit), unit.empty() ? "" : "NMEA has it so"});
    fill(table);
    std::vector<std::string> notes;
    if (wrong_ > 0)
      notes.push_back(fmt::format("{} sentences are left out: their checksum is wrong or missing", wrong_));
    if (bytes_.cut()) notes.emplace_back("the packed data stop in the middle");
    std::vector<StreamTable> tables;
    tables.push_back(std::move(table));
    return std::make_unique<TableRecording>("NMEA 0183", std::move(tables), std::move(notes));
  }

 private:
  void take(const Sentence& s) {
    const auto kind = static_cast<std::size_t>(std::ranges::find(kKinds, s.kind) - kKinds.begin());
    const bool has_time = s.kind != "VTG";
    if (has_time) {
      const auto time = time_of(s.cell(0));
      if (!time) return;
      if (epochs_.empty() || epochs_.back().time != *time) {
        epochs_.emplace_back().time = *time;
        epochs_.back().values.fill(kNone);
      }
    }
    if (epochs_.empty()) return;
    Epoch& epoch = epochs_.back();
    if (std::exchange(epoch.seen[kind], true)) return;
    if (s.kind == "GGA") take_gga(s, epoch);
    if (s.kind == "RMC") take_rmc(s, epoch);
    if (s.kind == "VTG") take_vtg(s, epoch);
    if (s.kind == "GST") take_gst(s, epoch);
    if (s.kind == "ZDA") epoch.day = day_of(digits(s.cell(1), 0, 2), digits(s.cell(2), 0, 2), digits(s.cell(3), 0, 4));
  }

  static void take_gga(const Sentence& s, Epoch& epoch) {
    epoch.values[latitude] = angle_of(s.cell(1), s.cell(2), "S");
    epoch.values[longitude] = angle_of(s.cell(3), s.cell(4), "W");
    epoch.values[quality] = number(s.cell(5));
    epoch.values[satellites] = number(s.cell(6));
    epoch.values[hdop] = number(s.cell(7));
    epoch.values[height_over_geoid] = number(s.cell(8));
    epoch.values[geoid_height] = number(s.cell(10));
  }

  static void take_rmc(const Sentence& s, Epoch& epoch) {
    const bool is_valid = s.cell(1) == "A";
    const auto set = [&](Column column, double value) {
      if (std::isnan(epoch.values[column])) epoch.values[column] = value;
    };
    set(latitude, angle_of(s.cell(2), s.cell(3), "S"));
    set(longitude, angle_of(s.cell(4), s.cell(5), "W"));
    set(quality, is_valid ? 1 : 0);
    if (is_valid) take_motion(number(s.cell(6)) * kKnot, number(s.cell(7)), epoch);
    if (const auto day = day_of(s.cell(8))) epoch.day = day;
  }

  static void take_vtg(const Sentence& s, Epoch& epoch) {
    constexpr std::size_t kCourse = 0, kKnots = 4;
    if (s.cell(8) == "N") return;  // its mode: not valid
    take_motion(number(s.cell(kKnots)) * kKnot, number(s.cell(kCourse)), epoch);
  }

  // What stands has no course, whatever the receiver writes.
  static void take_motion(double v, double angle, Epoch& epoch) {
    if (!std::isnan(epoch.values[speed])) return;
    epoch.values[speed] = v;
    epoch.values[course] = v > 0 ? angle : kNone;
  }

  static void take_gst(const Sentence& s, Epoch& epoch) {
    epoch.values[sigma_north] = number(s.cell(5));
    epoch.values[sigma_east] = number(s.cell(6));
    epoch.values[sigma_up] = number(s.cell(7));
  }

  /// Days are told, or counted on: a time of day that falls by more than half a day is that of the next.
  void date() {
    std::optional<std::int64_t> day;
    for (std::size_t i = 0; i < epochs_.size(); ++i) {
      if (day && !epochs_[i].day) epochs_[i].day = *day + (epochs_[i - 1].time - epochs_[i].time > kDay / 2 ? 1 : 0);
      day = epochs_[i].day;
    }
    for (std::size_t i = epochs_.size(); i-- > 1;) {
      if (!epochs_[i].day || epochs_[i - 1].day) continue;
      epochs_[i - 1].day = *epochs_[i].day - (epochs_[i - 1].time - epochs_[i].time > kDay / 2 ? 1 : 0);
    }
  }

  void fill(StreamTable& table) {
    const bool is_dated = std::ranges::any_of(epochs_, [](const Epoch& e) { return e.day.has_value(); });
    if (!is_dated && !epochs_.empty()) epochs_.front().day = 0;
    date();
    table.rows.columns.resize(columns);
    for (const Epoch& epoch : epochs_) {
      table.rows.stamps_ns.push_back(*epoch.day * kDay + epoch.time);
      for (std::size_t i = 0; i < columns; ++i) table.rows.columns[i].push_back(epoch.values[i]);
    }
    if (is_dated) return;
    table.info.clock = "UTC time of day";
    table.rows.notes.emplace_back("no sentence tells the date: stamps count from the first midnight");
  }

  const Bytes& bytes_;
  std::vector<Epoch> epochs_;
  std::int64_t wrong_ = 0;
};

}  // namespace
}  // namespace gyrobudget::inline v0::log::nmea

namespace gyrobudget::inline v0::log {

bool is_nmea(std::string_view head) {
  if (!head.starts_with('$')) return false;
  nmea::Sentence sentence;
  while (!head.empty()) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    if (nmea::parse(head.substr(0, end), sentence) == nmea::Line::sentence) return true;
    head.remove_prefix(std::min(end + 1, head.size()));
  }
  return false;
}

std::unique_ptr<Recording> open_nmea(std::shared_ptr<const Bytes> bytes) { return nmea::Reader(*bytes).read(); }

}  // namespace gyrobudget::inline v0::log

// SPDX-License-Identifier: MIT
#include "gpsd_json.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "../calendar.h"
#include "table_recording.h"

namespace gyrobudget::inline v0::log::gpsd {
namespace {

using Json = nlohmann::json;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A field, and the key of a TPV report that it is.
struct ReportKey {
  std::string_view ours, unit, theirs;
};
constexpr std::array<ReportKey, 17> kKeys{{{"latitude", "deg", "lat"},
                                           {"longitude", "deg", "lon"},
                                           {"height", "m", "altHAE"},
                                           {"height_over_geoid", "m", "altMSL"},
                                           {"quality", "", "mode"},
                                           {"velocity_north", "m/s", "velN"},
                                           {"velocity_east", "m/s", "velE"},
                                           {"velocity_down", "m/s", "velD"},
                                           {"speed", "m/s", "speed"},
                                           {"course", "deg", "track"},
                                           {"velocity_up", "m/s", "climb"},
                                           {"position_sigma_east", "m", "epx"},
                                           {"position_sigma_north", "m", "epy"},
                                           {"position_sigma_up", "m", "epv"},
                                           {"velocity_sigma_horizontal", "m/s", "eps"},
                                           {"velocity_sigma_up", "m/s", "epc"},
                                           {"status", "", "status"}}};

double number(const Json& report, std::string_view key) {
  const auto at = report.find(key);
  return at != report.end() && at->is_number() ? at->get<double>() : kNone;
}

std::string word(const Json& report, std::string_view key) {
  const auto at = report.find(key);
  return at != report.end() && at->is_string() ? at->get<std::string>() : std::string();
}

double value_of(const Json& report, const ReportKey& key) {
  if (key.ours == "course" && !(number(report, "speed") > 0)) return kNone;  // what stands has none
  const double value = number(report, key.theirs);
  // Up to 3.20 there was one height, over the geoid.
  if (key.ours == "height_over_geoid" && std::isnan(value) && !report.contains("altHAE")) return number(report, "alt");
  return value;
}

class Reader {
 public:
  explicit Reader(const Bytes& bytes) : bytes_(bytes) {}

  std::unique_ptr<Recording> read() {
    std::string_view text = bytes_.text();
    while (!text.empty()) {
      const std::size_t end = std::min(text.find('\n'), text.size());
      take(text::trim(text.substr(0, end)));
      text.remove_prefix(std::min(end + 1, text.size()));
    }
    std::vector<std::string> notes;
    if (broken_ > 0) notes.push_back(fmt::format("{} lines are left out: they are no whole JSON object", broken_));
    if (timeless_ > 0)
      notes.push_back(fmt::format("{} reports are left out: they have no time, as before the first fix", timeless_));
    if (bytes_.cut()) notes.emplace_back("the packed data stop in the middle");
    return std::make_unique<TableRecording>("gpsd's JSON", tables(), std::move(notes));
  }

 private:
  void take(std::string_view line) {
    if (line.empty()) return;
    const Json report = Json::parse(line, nullptr, false);
    if (report.is_discarded() || !report.is_object()) {
      ++broken_;
      return;
    }
    if (word(report, "class") != "TPV") return;
    const std::string time = word(report, "time");
    std::int64_t stamp = 0;
    if (parse_calendar(time, StampForm::date_time, stamp) != text::Cell::number) {
      ++timeless_;
      return;
    }
    Rows& rows = devices_[word(report, "device")];
    rows.columns.resize(kKeys.size());
    rows.stamps_ns.push_back(stamp);
    for (std::size_t i = 0; i < kKeys.size(); ++i) rows.columns[i].push_back(value_of(report, kKeys[i]));
  }

  std::vector<StreamTable> tables() {
    std::vector<StreamTable> list;
    for (auto& [device, rows] : devices_) {
      StreamTable table;
      const bool is_alone = devices_.size() == 1;
      table.info = {.name = is_alone ? "TPV" : "TPV " + text::printable(device),
                    .type = "gpsd TPV",
                    .kind = StreamKind::gnss,
                    .clock = "UTC"};
      for (const ReportKey& key : kKeys)
        table.info.fields.push_back(
            {std::string(key.ours), std::string(key.unit), key.unit.empty() ? "" : "gpsd has it so"});
      table.rows = std::move(rows);
      table.rows.notes.emplace_back(
          "gpsd takes the height over the ellipsoid from a coarse table of its own where the receiver tells no geoid, metres off; its errors are of no stated confidence");
      list.push_back(std::move(table));
    }
    return list;
  }

  const Bytes& bytes_;
  std::map<std::string, Rows> devices_;
  std::int64_t broken_ = 0, timeless_ = 0;
};

}  // namespace
}  // namespace gyrobudget::inline v0::log::gpsd

namespace gyrobudget::inline v0::log {

bool is_gpsd_json(std::string_view head) {
  const std::string_view start = head.substr(0, head.find('\n'));
  constexpr std::array<std::string_view, 2> kStarts{"{\"class\":\"", "{\"class\": \""};
  constexpr std::array<std::string_view, 8> kClasses{"VERSION", "DEVICES", "DEVICE", "WATCH",
                                                     "TPV",     "SKY",     "GST",    "PPS"};
  return std::ranges::any_of(kStarts, [&](std::string_view mark) {
    return start.starts_with(mark) && std::ranges::any_of(kClasses, [&](std::string_view name) {
             return start.substr(mark.size()).starts_with(std::string(name) + '"');
           });
  });
}

std::unique_ptr<Recording> open_gpsd_json(std::shared_ptr<const Bytes> bytes) { return gpsd::Reader(*bytes).read(); }

}  // namespace gyrobudget::inline v0::log

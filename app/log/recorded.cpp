// SPDX-License-Identifier: MIT
#include "recorded.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <stdexcept>
#include <utility>

#include "layout.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kFirstRows = 256;  // for a first look at arrays

bool holds_inertial(const StreamInfo& s) {
  return s.kind == StreamKind::imu || s.kind == StreamKind::gyroscope || s.kind == StreamKind::accelerometer;
}

/// "/imu/data (imu, 2144 rows)"
std::string described(const StreamInfo& s) {
  const std::string kind = s.kind == StreamKind::other ? s.type : std::string(name(s.kind));
  return fmt::format("{} ({}{}{} rows)", text::printable(s.name), text::printable(kind), kind.empty() ? "" : ", ",
                     s.count);
}

std::vector<std::size_t> places_of(const std::vector<StreamInfo>& streams, bool (*of)(const StreamInfo&)) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < streams.size(); ++i)
    if (of(streams[i])) places.push_back(i);
  return places;
}

std::string listed(const std::vector<StreamInfo>& streams, const std::vector<std::size_t>& places) {
  constexpr std::size_t kListed = 20;
  std::vector<std::string> names;
  for (const std::size_t i : places) names.push_back(described(streams[i]));
  if (names.empty()) return "nothing";
  const std::size_t more = names.size() > kListed ? names.size() - kListed : 0;
  names.resize(names.size() - more);
  if (more > 0) names.push_back(fmt::format("{} more", more));
  return text::listing(names);
}

bool is_any(const StreamInfo&) { return true; }
bool is_read(const StreamInfo& s) { return !s.fields.empty(); }
bool is_array(const StreamInfo& s) { return s.clock.empty() && is_read(s); }

std::vector<std::size_t> streams_for(const Recording& recording, const StreamUse& use) {
  auto places = places_of(recording.streams(), use.is_meant);
  return places.empty() ? places_of(recording.streams(), is_array) : places;
}

/// The columns of a stream as the chooser of text logs knows them: the fields, and the clock behind them.
struct Headed {
  Layout layout;
  std::vector<std::vector<std::string>> cells;  ///< that the layout's sample refers to
  std::optional<std::size_t> clock;
};

Headed headed(const StreamInfo& info, const std::vector<std::vector<double>>& arrays) {
  Headed h;
  for (const Field& f : info.fields) h.layout.headings.push_back({f.name, f.unit, 1});
  if (!info.clock.empty()) {
    h.clock = h.layout.headings.size();
    h.layout.headings.push_back({info.clock, "ns", 1});
  }
  h.layout.columns = h.layout.headings.size();
  h.layout.body_line = 1;
  const std::size_t rows = arrays.empty() ? 1 : std::min(kFirstRows, arrays[0].size());
  h.cells.assign(rows, std::vector<std::string>(h.layout.columns));
  for (std::size_t i = 0; i < arrays.size(); ++i)
    for (std::size_t k = 0; k < rows; ++k)
      if (std::isfinite(arrays[i][k])) h.cells[k][i] = fmt::format("{}", arrays[i][k]);
  for (const auto& row : h.cells) h.layout.sample.emplace_back(row.begin(), row.end());
  return h;
}

void keep_rows(Rows& of, const std::vector<std::size_t>& rows) {
  const auto keep = [&](auto& column) {
    auto kept = column;
    kept.resize(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) kept[i] = column[rows[i]];
    column = std::move(kept);
  };
  keep(of.stamps_ns);
  for (auto& column : of.columns) keep(column);
}

}  // namespace

std::vector<std::size_t> sensor_streams(const Recording& recording) { return streams_for(recording, use_as_log()); }

const StreamUse& use_as_log() {
  static constexpr StreamUse kUse{holds_inertial, "IMU, gyroscope or accelerometer", "--topic"};
  return kUse;
}

void put_in_order(Rows& rows) {
  const auto& stamps = rows.stamps_ns;
  const auto goes_back = [&](std::size_t i) { return stamps[i] < stamps[i - 1]; };
  std::size_t back = 0, repeated = 0;
  for (std::size_t i = 1; i < stamps.size(); ++i) back += goes_back(i), repeated += stamps[i] == stamps[i - 1];
  if (back == 0 && repeated == 0) return;
  std::vector<std::size_t> order(stamps.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t row) { return stamps[row]; });
  const auto kept =
      std::unique(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return stamps[a] == stamps[b]; });
  const auto dropped = static_cast<std::size_t>(order.end() - kept);
  order.erase(kept, order.end());
  keep_rows(rows, order);
  if (back > 0)
    rows.notes.push_back(
        fmt::format("the time goes back {} times: the rows are put in the order of their stamps", back));
  if (dropped > 0) rows.notes.push_back(fmt::format("{} rows repeat a stamp: the first of each is kept", dropped));
}

std::vector<std::int64_t> stamps_of(const std::vector<double>& times, std::int64_t ns_per_unit) {
  constexpr double kMost = 9.2e18;  // of 64 bits
  std::vector<std::int64_t> stamps;
  stamps.reserve(times.size());
  for (const double t : times) {
    const double ns = t * static_cast<double>(ns_per_unit);
    stamps.push_back(std::abs(ns) < kMost ? std::llround(ns) : text::kNoStamp);
  }
  return stamps;
}

std::size_t choose_stream(const Recording& recording, const std::string& source,
                          const std::optional<std::string>& topic, const StreamUse& use) {
  const auto& streams = recording.streams();
  const auto place = [&](auto found) { return static_cast<std::size_t>(found - streams.begin()); };
  if (topic) {
    const auto found = std::ranges::find(streams, *topic, &StreamInfo::name);
    if (found != streams.end()) {
      if (!found->fields.empty()) return place(found);
      text::fail(source, fmt::format("{} is not a type that is read; there are {}", described(*found),
                                     listed(streams, places_of(streams, is_read))));
    }
    std::vector<std::string> names;
    for (const StreamInfo& s : streams) names.push_back(s.name);
    throw std::invalid_argument(fmt::format("{} {}: {} has no such stream{}; it has {}", use.topic,
                                            text::printable(*topic), source, text::suggestion(*topic, names),
                                            listed(streams, places_of(streams, is_any))));
  }
  const auto places = streams_for(recording, use);
  if (places.size() == 1) return places.front();
  if (places.size() > 1)
    throw std::invalid_argument(
        fmt::format("{} holds {}; choose one of them: {} NAME", source, listed(streams, places), use.topic));
  std::string why;
  for (const std::string& note : recording.notes()) why += "; " + note;
  text::fail(source, fmt::format("this {} holds no {} that can be read; it has {}{}", recording.format(), use.what,
                                 listed(streams, places_of(streams, is_any)), why));
}

Recorded read_recorded(const Recording& recording, const LogOptions& options) {
  const std::size_t stream = choose_stream(recording, options.path, options.topic);
  const StreamInfo& info = recording.streams()[stream];
  Recorded recorded;
  recorded.source = fmt::format("{}, {}", text::input_name(options.path), text::printable(info.name));
  Rows arrays;
  if (info.clock.empty()) {
    std::vector<std::size_t> all(info.fields.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    arrays = recording.read(stream, all);
  }
  const Headed columns = headed(info, arrays.columns);
  recorded.choice = choose_columns(recorded.source, columns.layout, options, columns.clock);
  Choice& choice = recorded.choice;
  // A message has many numbers that are no rates, which inspect shows.
  if (columns.clock) std::erase_if(choice.notes, [](const std::string& note) { return note.starts_with("left out "); });
  put_beside(choice);
  std::vector<std::size_t> fields;
  for (const DataColumn& c : choice.data) fields.push_back(c.index);
  if (columns.clock) {
    arrays = recording.read(stream, fields);
    put_in_order(arrays);
    recorded.stamps = std::move(arrays.stamps_ns);
    recorded.numbers = std::move(arrays.columns);
    if (arrays.clock != info.clock) choice.time_name = arrays.clock;
  } else {
    for (const std::size_t f : fields) recorded.numbers.push_back(arrays.columns[f]);
    if (!choice.stamps.empty())
      recorded.stamps = stamps_of(arrays.columns[choice.stamps[0].index], choice.stamps[0].ns_per_unit);
  }
  for (std::size_t i = 0; i < choice.data.size(); ++i)
    for (double& x : recorded.numbers[i]) x *= choice.data[i].to_si;
  recorded.notes = recording.notes();
  recorded.notes.insert(recorded.notes.end(), arrays.notes.begin(), arrays.notes.end());
  return recorded;
}

}  // namespace gyrobudget::inline v0::log

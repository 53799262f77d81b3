// SPDX-License-Identifier: MIT
#include "names.h"

#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::log {
namespace {

struct TimeUnit {
  std::string_view word;
  std::int64_t ns;
};
constexpr std::int64_t kNano = 1, kMicro = 1'000, kMilli = 1'000'000, kSecond = noise::kNanosecondsPerSecond;
constexpr TimeUnit kTimeUnits[] = {
    {"s", kSecond},     {"sec", kSecond},    {"secs", kSecond},      {"second", kSecond}, {"seconds", kSecond},
    {"ms", kMilli},     {"msec", kMilli},    {"msecs", kMilli},      {"millis", kMilli},  {"milliseconds", kMilli},
    {"us", kMicro},     {"usec", kMicro},    {"usecs", kMicro},      {"micros", kMicro},  {"microseconds", kMicro},
    {"µs", kMicro},     {"ns", kNano},       {"nsec", kNano},        {"nsecs", kNano},    {"nanos", kNano},
    {"nanosec", kNano}, {"nanosecs", kNano}, {"nanoseconds", kNano},
};
constexpr std::string_view kTimeWords[] = {"timestamp", "time", "stamp", "ts", "tow", "sow", "epoch", "elapsed", "t"};

std::int64_t time_unit(std::string_view word) {
  const auto* found = std::ranges::find(kTimeUnits, word, &TimeUnit::word);
  return found == std::end(kTimeUnits) ? 0 : found->ns;
}

/// The words of a name in lower case: letters between other signs.
std::vector<std::string> words_of(std::string_view name) {
  std::vector<std::string> words(1);
  for (const char c : text::lower(name)) {
    const bool letter = (c >= 'a' && c <= 'z') || static_cast<unsigned char>(c) >= 0x80;
    if (letter) {
      words.back() += c;
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.size() > 1 && words.back().empty()) words.pop_back();
  return words;
}

bool is_time_word(std::string_view word) { return std::ranges::find(kTimeWords, word) != std::end(kTimeWords); }

/// "timeus" is time in us.
std::optional<TimeName> joined_name(std::string_view word) {
  for (const std::string_view base : {"timestamp", "time", "stamp"}) {
    if (!word.starts_with(base)) continue;
    if (const std::int64_t ns = time_unit(word.substr(base.size()))) return TimeName{ns, false};
  }
  for (const std::string_view base : {"timestamp", "time"}) {  // unixtime, gpstime, systime
    if (word.ends_with(base)) return TimeName{};
  }
  return std::nullopt;
}

bool has_prefix(const std::vector<std::string>& words, std::initializer_list<std::string_view> prefixes) {
  return std::ranges::any_of(words, [&](const std::string& word) {
    return std::ranges::any_of(prefixes, [&](std::string_view prefix) { return word.starts_with(prefix); });
  });
}

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::ranges::find(words, word) != words.end();
}

}  // namespace

std::optional<TimeName> time_name(std::string_view name) {
  const std::vector<std::string> words = words_of(name);
  const std::int64_t unit = time_unit(words.back());
  if (words.size() == 1) {
    if (unit != 0) return TimeName{unit, true};
    if (is_time_word(words[0])) return TimeName{};
    return joined_name(words[0]);
  }
  // header.stamp.secs is a name that is a unit too: its nanoseconds stand in a column of their own.
  const std::string& before = words[words.size() - 2];
  constexpr std::size_t kSpelledOut = 3;
  if (unit != 0 && is_time_word(before)) return TimeName{unit, before == "stamp" && words.back().size() >= kSpelledOut};
  const bool any = std::ranges::any_of(words, [](const std::string& word) {
    return is_one_of(word, {"time", "timestamp", "stamp", "tow", "sow", "epoch"});
  });
  if (any) return TimeName{unit, false};
  return joined_name(words.back());
}

NameKind kind_of_name(std::string_view name) {
  const std::vector<std::string> words = words_of(name);
  if (has_prefix(words, {"temp", "degc", "celsius"}) || name == "T") return NameKind::temperature;
  if (has_prefix(words, {"seq",  "index",  "idx",    "count",  "packet", "frame", "mag",     "press", "baro",
                         "quat", "orient", "cov",    "status", "flag",   "valid", "volt",    "batt",  "lat",
                         "lon",  "alt",    "height", "roll",   "pitch",  "yaw",   "heading", "week",  "humid"}) ||
      is_one_of(words[0], {"id", "i", "n", "no", "nr", "sample", "q", "qw", "qx", "qy", "qz", "mx", "my", "mz"})) {
    return NameKind::other;
  }
  if (has_prefix(words, {"gyr", "ang", "omega", "rate", "dtheta"}) ||
      is_one_of(words[0], {"w", "wx", "wy", "wz", "gx", "gy", "gz"})) {
    return NameKind::gyro;
  }
  if (has_prefix(words, {"acc", "linear", "dv", "vel"}) ||
      is_one_of(words[0], {"a", "ax", "ay", "az", "fx", "fy", "fz"})) {
    return NameKind::accelerometer;
  }
  return NameKind::unknown;
}

std::string_view unit_hint(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kEndings[] = {
      {"dps", "deg/s"},
      {"degps", "deg/s"},
      {"deg_s", "deg/s"},
      {"deg_per_s", "deg/s"},
      {"dph", "deg/h"},
      {"degph", "deg/h"},
      {"deg_h", "deg/h"},
      {"radps", "rad/s"},
      {"rads", "rad/s"},
      {"rad_s", "rad/s"},
      {"rad_per_s", "rad/s"},
      {"mps2", "m/s^2"},
      {"ms2", "m/s^2"},
      {"m_s2", "m/s^2"},
      {"mps", "m/s"},
      {"m_s", "m/s"},
      {"mg", "mg"},
      {"ug", "ug"},
      {"g", "g"},
      {"arcsec", "arcsec"},
      {"deg", "deg"},
      {"rad", "rad"},
      {"s", "s"},
  };
  const std::string low = text::lower(name);
  for (const auto& [ending, unit] : kEndings) {
    const std::size_t at = low.size() - std::min(low.size(), ending.size());
    if (at > 1 && low.substr(at) == ending && (low[at - 1] == '_' || low[at - 1] == '.')) return unit;
  }
  return {};
}

}  // namespace gyrobudget::inline v0::log

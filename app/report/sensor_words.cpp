// SPDX-License-Identifier: MIT
#include "sensor_words.h"

#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/imu.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace gyrobudget::inline v0::report {
namespace {

using noise::ErrorSource;
using noise::Signal;

struct Word {
  ErrorSource source;
  std::string_view key, word;
};
constexpr std::array kWords{Word{ErrorSource::turn_on_bias, "turn_on_bias", "turn-on bias"},
                            Word{ErrorSource::scale_factor, "scale_factor", "scale factor"},
                            Word{ErrorSource::misalignment, "misalignment", "misalignment"},
                            Word{ErrorSource::g_sensitivity, "g_sensitivity", "g-sensitivity"}};

constexpr std::array<std::string_view, 2> kTriads{"gyro", "accelerometer"};

// Nothing is stated of it at all.
bool is_blank(const noise::ErrorModel& model) {
  return model.triad_processes().empty() && !model.turn_on_bias && !model.scale_factor && !model.misalignment &&
         !model.g_sensitivity && !model.g2_sensitivity && !model.vibration_rectification && !model.temperature;
}

}  // namespace

std::vector<std::string> not_stated(const noise::SensorModel& sensor) {
  std::vector<std::string> names;
  const auto add = [&](const noise::ErrorModel* model, Signal signal, std::string_view triad) {
    if (!model || is_blank(*model)) return names.emplace_back(triad), void();
    for (const ErrorSource source : noise::not_stated(*model, signal))
      names.push_back(fmt::format("{}.{}", triad, std::ranges::find(kWords, source, &Word::source)->key));
  };
  add(&sensor.gyro, Signal::angular_rate, kTriads[0]);
  add(sensor.accelerometer ? &*sensor.accelerometer : nullptr, Signal::specific_force, kTriads[1]);
  return names;
}

std::string not_stated_text(std::span<const std::string> names, std::string_view numbers) {
  std::vector<std::string> parts;
  for (const std::string_view triad : kTriads) {
    std::vector<std::string> words;
    for (const auto& word : kWords)
      if (std::ranges::find(names, fmt::format("{}.{}", triad, word.key)) != names.end())
        words.push_back(fmt::format("no {}", word.word));
    if (!words.empty()) parts.push_back(fmt::format("{} of the {}", text::listing(words), triad));
    if (std::ranges::find(names, triad) != names.end()) parts.push_back(fmt::format("no {} at all", triad));
  }
  if (parts.empty()) return {};
  return fmt::format(
      "The sensor file states {}: what it leaves out is taken as zero, and {} nothing of it. State it there, also where it is zero.",
      fmt::join(parts, ", and "), numbers);
}

std::vector<std::string> sensor_notes(std::span<const std::string> warnings, std::span<const std::string> readings,
                                      std::string_view path) {
  std::vector<std::string> notes;
  for (const std::string& warning : warnings)
    notes.push_back(fmt::format("{} warns: {}", path, text::printable(warning)));
  for (const std::string& reading : readings) notes.push_back(text::printable(reading));
  return notes;
}

}  // namespace gyrobudget::inline v0::report

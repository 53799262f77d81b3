// SPDX-License-Identifier: MIT
#include "temperature_profile.h"

#include "gyrobudget/app/log/named_columns.h"
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::files {
namespace {

namespace dimension = noise::dimension;

double value_of(std::map<std::string, std::string, std::less<>>& given, std::string_view key,
                const noise::Dimension& unit) {
  const auto at = given.find(key);
  if (at == given.end()) throw std::invalid_argument(fmt::format("a temperature that goes needs {}=...", key));
  const double value = noise::parse_quantity(at->second, unit);
  given.erase(at);
  return value;
}

noise::TemperatureProfile warm_up(std::string_view text) {
  std::map<std::string, std::string, std::less<>> given;
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(','));
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos)
      throw std::invalid_argument(
          fmt::format("'{}': expected from=20 degC,to=45 degC,time_constant=10 min", std::string(part)));
    given[std::string(text::trim(part.substr(0, equals)))] = std::string(text::trim(part.substr(equals + 1)));
    text.remove_prefix(std::min(part.size() + 1, text.size()));
  }
  const double from = value_of(given, "from", dimension::kTemperature);
  const double to = value_of(given, "to", dimension::kTemperature);
  const double time_constant = value_of(given, "time_constant", dimension::kTime);
  if (!given.empty())
    throw std::invalid_argument(
        fmt::format("'{}': a temperature has from, to and time_constant", given.begin()->first));
  return {from, to, time_constant};
}

noise::TemperatureProfile table(const std::string& path) {
  constexpr log::Wanted kColumn{"temperature", {"temp", "celsius"}, dimension::kTemperature};
  constexpr std::string_view kExpected = "expected a header with time (s) and temperature (degC)";
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  const log::Bytes source(path);
  const log::Layout layout = log::read_layout(source);
  const log::ColumnMap map;
  const log::NamedColumns columns(source.name(), layout, map, kExpected);
  log::Choice choice;
  choice.data.push_back(columns.get(kColumn));
  log::add_stamps(choice, columns.get(log::kTimeColumn));
  const log::Table rows = log::TableReader(source, layout, kChunk).read(choice);
  std::vector<double> time, temperature;
  for (std::size_t i = 0; i < rows.rows; ++i) {
    if (!std::isfinite(rows.numbers[0][i])) continue;
    const double t = static_cast<double>(rows.stamps[i] - rows.stamps[0]) / noise::kNanosecondsPerSecond;
    if (!time.empty() && !(t > time.back())) text::fail(path, fmt::format("its time does not ascend at {} s", t));
    time.push_back(t), temperature.push_back(rows.numbers[0][i]);
  }
  if (time.size() < 2) text::fail(path, fmt::format("found {} temperatures, expected two at least", time.size()));
  return {std::move(time), std::move(temperature)};
}

}  // namespace

noise::TemperatureProfile temperature_profile(const std::string& text) {
  if (text.find('=') != std::string::npos) return warm_up(text);
  if (text.find_first_not_of("+-.0123456789") > 0)
    return noise::TemperatureProfile(noise::parse_quantity(text, dimension::kTemperature));
  return table(text);
}

}  // namespace gyrobudget::inline v0::files

// SPDX-License-Identifier: MIT
#include "trajectory_spec.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/units.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "trajectory_file.h"

namespace gyrobudget::inline v0::files {
namespace {

/// A key of a path: where its number goes and the unit it has where none is written.
struct Key {
  std::string name;
  std::string_view unit;
  double* value;
};

constexpr std::string_view kSite = "site";

/// The keys of one path and the place that `site` sets.
struct Keys {
  std::vector<Key> list;
  earth::Geodetic* place = nullptr;
  bool site_sets_height = true;

  void add(std::string name, std::string_view unit, double& value) { list.push_back({std::move(name), unit, &value}); }
  void add_place(earth::Geodetic& position) {
    place = &position;
    add("latitude", "deg", position.latitude);
    add("longitude", "deg", position.longitude);
    add("height", "m", position.height);
  }
  void add_vibration(earth::Vibration& v) {
    add("coning_angle", "deg", v.coning_angle);
    add("coning_frequency", "Hz", v.coning_frequency);
    add("sculling_angle", "deg", v.sculling_angle);
    add("sculling_acceleration", "m/s^2", v.sculling_acceleration);
    add("sculling_frequency", "Hz", v.sculling_frequency);
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> result;
    if (place != nullptr) result.emplace_back(kSite);
    for (const Key& k : list) result.push_back(k.name);
    return result;
  }
};

// --- The paths: options, their keys, and the trajectory they make ------------------------------------------

struct StandSpec {
  static constexpr std::string_view kName = "static";
  earth::Stand stand;
  earth::Euler attitude;

  [[nodiscard]] Keys keys() {
    Keys k;
    k.add_place(stand.position);
    k.add("yaw", "deg", attitude.yaw);
    k.add("pitch", "deg", attitude.pitch);
    k.add("roll", "deg", attitude.roll);
    k.add("spin_x", "deg/s", stand.spin.x());
    k.add("spin_y", "deg/s", stand.spin.y());
    k.add("spin_z", "deg/s", stand.spin.z());
    k.add_vibration(stand.vibration);
    k.add("duration", "s", stand.duration);
    return k;
  }
  [[nodiscard]] earth::Trajectory make() {
    stand.q_nb = earth::from_euler(attitude);
    return earth::stand(stand);
  }
};

struct CruiseSpec {
  static constexpr std::string_view kName = "cruise";
  earth::Cruise cruise;

  [[nodiscard]] Keys keys() {
    Keys k;
    k.add_place(cruise.start);
    k.site_sets_height = false;
    k.add("azimuth", "deg", cruise.azimuth);
    k.add("speed", "m/s", cruise.speed);
    k.add("turn_acceleration", "m/s^2", cruise.turn_acceleration);
    k.add("turn_period", "s", cruise.turn_period);
    k.add_vibration(cruise.vibration);
    k.add("duration", "s", cruise.duration);
    return k;
  }
  [[nodiscard]] earth::Trajectory make() const { return earth::cruise(cruise); }
};

struct ClimbSpec {
  static constexpr std::string_view kName = "climb";
  earth::Climb climb;

  [[nodiscard]] Keys keys() {
    Keys k;
    k.add_place(climb.site);
    k.add("azimuth", "deg", climb.azimuth);
    k.add("acceleration", "m/s^2", climb.acceleration);
    k.add_vibration(climb.vibration);
    k.add("duration", "s", climb.duration);
    return k;
  }
  [[nodiscard]] earth::Trajectory make() const { return earth::climb(climb); }
};

struct AscentSpec {
  static constexpr std::string_view kName = "ascent";
  earth::Ascent ascent;

  [[nodiscard]] Keys keys() {
    Keys k;
    k.add_place(ascent.site);
    k.add("azimuth", "deg", ascent.azimuth);
    k.add("pitch_over_at", "s", ascent.pitch_over_at);
    k.add("pitch_end", "deg", ascent.pitch_end);
    k.add("force_start", "m/s^2", ascent.force_start);
    k.add("force_end", "m/s^2", ascent.force_end);
    k.add("tail_off", "s", ascent.tail_off);
    k.add("duration", "s", ascent.duration);
    return k;
  }
  [[nodiscard]] earth::Trajectory make() const { return earth::ascent(ascent); }
};

/// Calls visit with a default of each path.
template <class Visit>
void for_each_path(Visit visit) {
  visit(StandSpec{});
  visit(CruiseSpec{});
  visit(ClimbSpec{});
  visit(AscentSpec{});
}

// --- Reading -----------------------------------------------------------------------------------------------

double number(const Key& key, std::string_view text) {
  double value = 0;
  if (text::parse_number(text, false, value) == text::Cell::number) return value * noise::parse_unit(key.unit).to_si;
  try {
    return noise::parse_quantity(text, noise::parse_unit(key.unit).dimension);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(fmt::format("{}: {}; a plain number is in {}", key.name, error.what(), key.unit));
  }
}

void set_site(const Keys& keys, std::string_view name) {
  const earth::Geodetic& site = earth::find_site(name).position;
  keys.place->latitude = site.latitude;
  keys.place->longitude = site.longitude;
  if (keys.site_sets_height) keys.place->height = site.height;
}

void set(const Keys& keys, std::string_view path, std::string_view option) {
  const std::size_t equals = option.find('=');
  const std::string name(text::trim(option.substr(0, equals)));
  const auto known = keys.names();
  if (std::ranges::find(known, name) == known.end()) {
    throw std::invalid_argument(fmt::format("trajectory {}: {} is no option of it{}; there are {}", path,
                                            text::quoted(name), text::suggestion(name, known), text::listing(known)));
  }
  if (equals == std::string_view::npos) {
    throw std::invalid_argument(
        fmt::format("trajectory {}: {} has no value, expected {}=...", path, text::quoted(name), name));
  }
  const std::string_view value = text::trim(option.substr(equals + 1));
  if (name == kSite) return set_site(keys, value);
  const auto key = std::ranges::find(keys.list, name, &Key::name);
  *key->value = number(*key, value);
}

template <class Spec>
void set_all(Spec& spec, std::string_view options) {
  const Keys keys = spec.keys();
  while (!options.empty()) {
    const std::size_t end = std::min(options.find(','), options.size());
    set(keys, Spec::kName, options.substr(0, end));
    options.remove_prefix(std::min(end + 1, options.size()));
  }
}

/// Calls visit with the path of that name, its options set.
template <class Visit>
bool visit_named(const std::string& text, Visit visit) {
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view name = text::trim(std::string_view(text).substr(0, colon));
  bool found = false;
  for_each_path([&]<class Spec>(Spec spec) {
    if (name != Spec::kName) return;
    set_all(spec, std::string_view(text).substr(std::min(colon + 1, text.size())));
    visit(spec);
    found = true;
  });
  return found;
}

}  // namespace

std::optional<earth::Trajectory> named_trajectory(const std::string& text) {
  std::optional<earth::Trajectory> result;
  (void)visit_named(text, [&](auto& spec) { result = spec.make(); });
  return result;
}

bool is_named_trajectory(const std::string& text) {
  return visit_named(text, [](const auto&) {});
}

std::vector<std::string> trajectory_words() {
  std::vector<std::string> words;
  for_each_path([&]<class Spec>(const Spec&) { words.emplace_back(Spec::kName); });
  return words;
}

std::string trajectory_names() {
  std::string text;
  for_each_path([&]<class Spec>(Spec spec) {
    text += fmt::format("  {}: {}\n", Spec::kName, text::listing(spec.keys().names()));
  });
  return text;
}

}  // namespace gyrobudget::inline v0::files

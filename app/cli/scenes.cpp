// SPDX-License-Identifier: MIT
#include "scenes.h"

#include "gyrobudget/app/report/sensor_words.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::cli {

std::vector<files::SceneFile> flight_scenes(const FlyArguments& a) {
  if (a.scenes.size() > 1 && !a.sensors.empty())
    throw std::invalid_argument("--sensor takes the place of one scene's: give one scene, or leave it out");
  std::vector<files::SceneFile> scenes;
  for (const std::string& path : a.scenes) {
    scenes.push_back(files::read_scene(path));
    scenes.back().path = path;  // as it was typed
    if (!scenes.back().flight)
      throw text::InputError(fmt::format(
          "{}: found no flight, expected one: write 'flight: {{vehicle: vlm1.yaml}}' in place of what moves", path));
  }
  if (a.sensors.empty()) return scenes;
  const files::SceneFile one = std::move(scenes.front());
  scenes.assign(a.sensors.size(), one);
  for (std::size_t i = 0; i < scenes.size(); ++i) files::change_sensor(scenes[i], a.sensors[i]);
  return scenes;
}

std::vector<std::string> not_stated_of(const files::SceneFile& scene) {
  return scene.sensor.empty() ? std::vector<std::string>{} : report::not_stated(scene.scenario.sensor);
}

std::vector<std::string> sensor_notes_of(const files::SceneFile& scene) {
  return report::sensor_notes(scene.sensor_warnings, scene.sensor_notes, scene.sensor);
}

text::InputError refusal(const std::string& scene, const std::exception& error) {
  return text::InputError(fmt::format("{}: {}", scene, error.what()));
}

}  // namespace gyrobudget::inline v0::cli

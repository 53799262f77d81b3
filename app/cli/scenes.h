// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/flight/vehicle.h"

#include <exception>
#include <string>
#include <vector>

#include "arguments.h"

// Scenes that verbs work on.
namespace gyrobudget::inline v0::cli {

/// The scenes that `fly` flies beside one another: those that were named, or one of them with each of the sensors.
/// @throws text::InputError as files::read_scene does and for a scene without a flight; std::invalid_argument for
/// sensors beside several scenes.
[[nodiscard]] std::vector<files::SceneFile> flight_scenes(const FlyArguments& arguments);

/// What the scene's sensor file does not state; empty for an ideal sensor, which has no file.
[[nodiscard]] std::vector<std::string> not_stated_of(const files::SceneFile& scene);
/// What that file warns of, and how it was read.
[[nodiscard]] std::vector<std::string> sensor_notes_of(const files::SceneFile& scene);

/// "scene.yaml: what is wrong".
[[nodiscard]] text::InputError refusal(const std::string& scene, const std::exception& error);

/// What `work` returns. What a scene asks that cannot be is an error of that file, not one of the command line.
/// @throws text::InputError for it; what else `work` throws passes through.
template <class Work>
auto naming(const std::string& scene, const Work& work) {
  try {
    return work();
  } catch (const navigation::SetupError& error) {
    throw refusal(scene, error);
  } catch (const navigation::RecordingError& error) {
    throw refusal(scene, error);
  } catch (const navigation::Diverged& error) {
    throw refusal(scene, error);
  } catch (const flight::SetupError& error) {
    throw refusal(scene, error);
  }
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
// New coefficients for a sensor file that is there already.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <string>
#include <string_view>
#include <vector>

#include "sensor_file.h"

namespace gyrobudget::inline v0::sensor_file {

/// The last line of a comment that a program puts at the head of a sensor file, which begins with "WARNING: " or
/// "Fitted by: ". It is replaced with the numbers it is about; what stands above and below is its owner's.
inline constexpr std::string_view kEndOfComment = "(written by gyrobudget calibrate up to here; --update replaces it)";

/// New noise coefficients, and what goes to the head of the file.
struct Update {
  noise::SensorModel model;  ///< its noise, and what else it has
  struct Fitted {
    noise::Signal signal;
    noise::Term term;
  };
  std::vector<Fitted> fitted;         ///< which coefficients are known; the others are not looked at
  bool rename = false;                ///< the model's name takes the place of the file's
  std::string comment;                ///< in place of the last one (kEndOfComment is its last line)
  std::vector<std::string> warnings;  ///< in place of the file's
};

/// What a file holds that sensor_yaml(update.model) would not: "gyro.turn_on_bias", "lever_arm", "accelerometer". Noise
/// coefficients of a triad that was fitted count where the file was not written by a program (kEndOfComment).
/// @return empty where nothing is lost, also where there is no such file, or a pipe or a device, or one without text.
/// @throws InputError for a file that is no sensor file of this project's form: then all of it would be lost.
[[nodiscard]] std::vector<std::string> held_beyond(const std::string& path, const Update& update);

struct Merged {
  std::string text;                ///< of the file
  noise::SensorModel model;        ///< that it holds
  std::vector<std::string> taken;  ///< what was in the file and is not any more: "gyro.gauss_markov"
};

/// The file with the fitted coefficients, and what else the model has, in place of its own, and all else as it was,
/// comments and order too: lines are replaced, and where a triad stands in braces it is written anew. Coefficients that
/// were not fitted stay, as a record says nothing of them; but Gauss-Markov processes go where flicker or a walk was
/// fitted and they were not, as these then hold what they stood for.
/// @throws InputError where the file cannot be read as a sensor file of this project's form.
[[nodiscard]] Merged merged(const std::string& path, const Update& update);

}  // namespace gyrobudget::inline v0::sensor_file

// SPDX-License-Identifier: MIT
#include "kalibr.h"

#include "gyrobudget/app/sensor_file/detail/densities.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::sensor_file {
namespace {

using detail::Densities;
using detail::Density;
using detail::Origin;
using noise::ErrorModel;
using noise::SensorModel;
using noise::Signal;

std::string line(const Densities& densities, const Density& density, std::string_view key, std::string_view unit,
                 const std::string& words) {
  if (density.origin == Origin::none)
    return fmt::format("# {0}_{1} is not known, and 0 would be wrong: fill it in\n# {0}_{1}:  # [{2}]\n",
                       densities.name(), key, unit);
  return fmt::format("# {0}_{1}: {2}\n{0}_{1}: {3}  # [{4}]\n", densities.name(), key, words, density.value, unit);
}

/// What the file says of one triad.
std::string triad_text(const Densities& d) {
  const Density white = d.largest_white(), walk = d.largest_walk();
  std::string text =
      line(d, white, "noise_density", d.is_gyro() ? "rad/s/sqrt(Hz)" : "m/s^2/sqrt(Hz)", d.white_words(white)) +
      line(d, walk, "random_walk", d.is_gyro() ? "rad/s^2/sqrt(Hz)" : "m/s^3/sqrt(Hz)", d.walk_words(walk));
  for (const std::string& words : d.left_out(walk)) text += fmt::format("# {}\n", words);
  return text;
}

void require_positive(double value, std::string_view what, std::string_view unit) {
  if (!(std::isfinite(value) && value > 0))
    throw std::invalid_argument(fmt::format("{} is {} {}; it must be above 0 and finite", what, value, unit));
}

std::string comment_lines(std::string_view comment) {
  std::string text;
  while (!comment.empty()) {
    const std::size_t end = std::min(comment.find('\n'), comment.size());
    text += fmt::format("#{}{}\n", end > 0 ? " " : "", comment.substr(0, end));
    comment.remove_prefix(std::min(end + 1, comment.size()));
  }
  return text;
}

}  // namespace

double walk_of_flicker(double b, double horizon_s) {
  return b * std::sqrt(6 * std::numbers::ln2 / (std::numbers::pi * horizon_s));
}

std::string kalibr_yaml(const SensorModel& model, const KalibrOptions& options) {
  require_positive(options.update_rate_hz, "update_rate_hz", "Hz");
  require_positive(options.horizon_s, "horizon_s", "s");
  const SensorModel limits = options.limits.value_or(SensorModel{});
  std::string text = comment_lines(options.comment) + "# Kalibr imu.yaml: continuous-time densities, two-sided, SI\n";
  if (model.accelerometer) {
    const ErrorModel limit = limits.accelerometer.value_or(ErrorModel{});
    text += triad_text({*model.accelerometer, limit, Signal::specific_force, options.horizon_s});
  } else {
    text += "# accelerometer_noise_density and accelerometer_random_walk are not known: fill them in\n";
  }
  text += triad_text({model.gyro, limits.gyro, Signal::angular_rate, options.horizon_s});
  return text + fmt::format("rostopic: /imu0\nupdate_rate: {}  # [Hz]\n", options.update_rate_hz);
}

}  // namespace gyrobudget::inline v0::sensor_file

// SPDX-License-Identifier: MIT
#include "flown.h"

#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/trajectory_file.h"
#include "gyrobudget/app/text/error.h"

#include <fmt/format.h>

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "paths.h"

namespace gyrobudget::inline v0::cli {

void check_flight_paths(const SimulateArguments& a) {
  const FlightArguments& flight = *a.flight;
  if (!flight.fixes.empty() && !files::is_scene(flight.trajectory))
    throw std::invalid_argument("--fixes: the aids stand in a scene; give one (.yaml) as --trajectory");
  if (!flight.fixes.empty() && !std::filesystem::is_directory(flight.fixes))
    throw text::OutputError(fmt::format("{}: no such folder for --fixes", flight.fixes));
  const std::vector<Output> outputs{{"-o", a.output == "-" ? "" : a.output}, {"--truth", flight.truth}};
  check_outputs(a.sensor, outputs);
  if (std::filesystem::exists(flight.trajectory)) check_outputs(flight.trajectory, outputs);
}

Flown flown_of(const SimulateArguments& a, const earth::Trajectory& trajectory) {
  if (a.duration_s > trajectory.duration()) {
    throw std::invalid_argument(
        fmt::format("--duration {} s: the trajectory ends at {} s", a.duration_s, trajectory.duration()));
  }
  const double duration = a.duration_s == 0 ? trajectory.duration() : a.duration_s;
  const std::uint64_t count = files::whole_intervals(duration, a.rate_hz);
  if (count <= a.skipped) {
    throw std::invalid_argument(
        fmt::format("{} s at {} Hz are {} samples, of which --skip leaves none", duration, a.rate_hz, count));
  }
  return {duration, count - a.skipped};
}

}  // namespace gyrobudget::inline v0::cli

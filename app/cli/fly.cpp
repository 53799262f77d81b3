// SPDX-License-Identifier: MIT
// fly: scene with a flight -> flight in closed loop.
#include "gyrobudget/app/files/flight_file.h"
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/report/flight.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <stdexcept>

#include "paths.h"
#include "scenes.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

report::FlightResult fly(const FlyArguments& a, const files::SceneFile& scene, Watch& watch) {
  const files::FlightSource& source = *scene.flight;
  report::FlightResult r{.scene = scene.path,
                         .name = scene.scenario.name,
                         .sensor = scene.sensor,
                         .command = a.common.command_line,
                         .vehicle = source.vehicle.path,
                         .vehicle_numbers = source.vehicle.numbers,
                         .vehicle_left_out = source.vehicle.left_out,
                         .plan = source.plan,
                         .dispersion = source.dispersion,
                         .study = {},
                         .not_stated = not_stated_of(scene),
                         .notes = sensor_notes_of(scene)};
  r.study = naming(scene.path, [&] {
    return closed_loop::study(r.plan, r.dispersion, scene.scenario,
                              {.runs = a.runs, .seed = a.seed, .record_rate = a.rate, .progress = std::ref(watch)});
  });
  if (scene.sensor.empty() && a.sensors.empty())
    r.notes.emplace_back("the IMU is ideal: the scene names no sensor file");
  return r;
}

}  // namespace

int run(const FlyArguments& a) {
  const std::vector<Output> outputs{{"-o", a.output}, {"--report", a.report}};
  for (const std::string& scene : a.scenes) check_outputs(scene, outputs);
  for (const std::string& sensor : a.sensors) check_outputs(sensor, outputs);
  if (a.output == "-" && a.common.json)
    throw std::invalid_argument("-o - and --json both want standard output: give one of them a file");
  const std::vector<files::SceneFile> scenes = flight_scenes(a);
  for (const auto& scene : scenes)
    for (const std::string& input : {scene.sensor, scene.flight->vehicle.path}) check_outputs(input, outputs);
  if (scenes.size() > 1 && !a.output.empty())
    throw std::invalid_argument(
        fmt::format("-o {}: {} flights do not go into one file; write them one by one", a.output, scenes.size()));
  std::vector<report::FlightResult> results;
  {
    Watch watch(a.common, "flights");
    for (auto scene = scenes.begin(); scene != scenes.end() && !watch.interrupted(); ++scene)
      results.push_back(fly(a, *scene, watch));
  }
  if (!a.output.empty()) {
    const report::FlightResult& r = results.front();
    files::write_flight(a.output, r.study.shown(), r.plan.flight.world.site, r.plan.control.azimuth,
                        a.common.command_line);
    if (a.output != "-") say(a.common, "flight: " + a.output);
  }
  if (a.output != "-") print(a.common.json ? report::flight_json(results) : report::flight_text(results));
  if (!a.report.empty()) {
    text::write_file(a.report, report::flight_page(results));
    say(a.common, "report page: " + a.report);
  }
  if (results.size() < scenes.size() || results.back().study.stopped) return exit_interrupted;
  const bool all = std::ranges::all_of(results, [](const auto& r) { return r.study.flew_to_the_end(); });
  return all ? exit_done : exit_no_answer;
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
// fly: scene with a flight -> flight in closed loop.
#include "gyrobudget/closed_loop/study.h"
#include "gyrobudget/io/flight_file.h"
#include "gyrobudget/io/output.h"
#include "gyrobudget/io/scene_file.h"
#include "gyrobudget/report/flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using report::FlightResult;

// What is flown beside one another.
struct Case {
  std::string scene;
  io::SceneFile file;
};

std::vector<Case> cases(const FlyArguments& a) {
  if (a.scenes.size() > 1 && !a.sensors.empty())
    throw std::invalid_argument("--sensor takes the place of one scene's: give one scene, or leave it out");
  std::vector<Case> result;
  for (const std::string& scene : a.scenes) {
    result.push_back({scene, io::read_scene(scene)});
    if (!result.back().file.flight)
      throw io::InputError(fmt::format(
          "{}: found no flight, expected one: write 'flight: {{vehicle: vlm1.yaml}}' in place of what moves",
          scene));
  }
  if (a.sensors.empty()) return result;
  const Case one = std::move(result.front());
  result.clear();
  for (const std::string& sensor : a.sensors) {
    result.push_back(one);
    io::change_sensor(result.back().file, sensor);
  }
  return result;
}

FlightResult fly(const FlyArguments& a, Case& c, Progress& progress, const Interruption& interruption) {
  io::FlightSource& source = *c.file.flight;
  flight::Flight& flight = source.plan.flight;
  flight.record_every = std::max(1, static_cast<int>(std::lround(1 / (a.rate * flight.period))));
  closed_loop::Study::Options options{.runs = a.runs, .seed = a.seed};
  options.progress = [&](int done, int of) {
    progress.update(done, of);
    return !interruption.asked();
  };
  FlightResult r{.scene = c.scene,
                 .name = c.file.scenario.name,
                 .sensor = c.file.sensor,
                 .command = a.common.command_line,
                 .vehicle = source.vehicle.path,
                 .vehicle_numbers = source.vehicle.numbers,
                 .vehicle_left_out = source.vehicle.left_out,
                 .plan = source.plan,
                 .dispersion = source.dispersion,
                 .study = study(source.plan, source.dispersion, c.file.scenario, options)};
  if (c.file.sensor.empty() && a.sensors.empty())
    r.study.notes.emplace_back("the IMU is ideal: the scene names no sensor file");
  return r;
}

std::string output_of(const FlyArguments& a, std::size_t i, std::size_t of) {
  if (of == 1 || a.output.empty()) return a.output;
  throw std::invalid_argument(
      fmt::format("-o {}: {} flights do not go into one file; write them one by one (this is number {})",
                  a.output, of, i + 1));
}

bool flew_to_the_end(const FlightResult& r) {
  return r.study.nominal.ended == flight::Ended::complete && r.study.flown &&
         r.study.flown->ended == flight::Ended::complete;
}

}  // namespace

int run(const FlyArguments& a) {
  const std::vector<Output> outputs{{"-o", a.output}, {"--report", a.report}};
  for (const std::string& scene : a.scenes) check_outputs(scene, outputs);
  for (const std::string& sensor : a.sensors) check_outputs(sensor, outputs);
  if (a.output == "-" && a.common.json)
    throw std::invalid_argument("-o - and --json both want standard output: give one of them a file");
  std::vector<Case> all = cases(a);
  for (const Case& c : all)
    for (const std::string& input : {c.file.sensor, c.file.flight->vehicle.path})
      check_outputs(input, outputs);
  (void)output_of(a, 0, all.size());
  std::vector<FlightResult> results;
  {
    Progress progress(a.common, "flights");
    const Interruption interruption;
    for (Case& c : all) results.push_back(fly(a, c, progress, interruption));
  }
  if (!a.output.empty()) {
    const FlightResult& r = results.front();
    io::write_flight(a.output, r.study.flown.value_or(r.study.nominal), r.plan.flight, r.plan.control.azimuth,
                     a.common.command_line);
    if (a.output != "-") say(a.common, "flight: " + a.output);
  }
  if (a.output != "-") print(a.common.json ? report::flight_json(results) : report::flight_text(results));
  if (!a.report.empty()) {
    io::write_file(a.report, report::flight_page(results));
    say(a.common, "report page: " + a.report);
  }
  return std::ranges::all_of(results, flew_to_the_end) ? exit_done : exit_no_answer;
}

}  // namespace gyrobudget::inline v0::cli

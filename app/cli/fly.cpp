// SPDX-License-Identifier: MIT
// fly: scene with a flight -> flight in closed loop.
#include "gyrobudget/app/files/flight_file.h"
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/report/flight.h"
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/estimation/closed_loop/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "notes.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using report::FlightResult;

// What is flown beside one another.
struct Case {
  std::string scene;
  files::SceneFile file;
};

std::vector<Case> cases(const FlyArguments& a) {
  if (a.scenes.size() > 1 && !a.sensors.empty())
    throw std::invalid_argument("--sensor takes the place of one scene's: give one scene, or leave it out");
  std::vector<Case> result;
  for (const std::string& scene : a.scenes) {
    result.push_back({scene, files::read_scene(scene)});
    if (!result.back().file.flight)
      throw text::InputError(fmt::format(
          "{}: found no flight, expected one: write 'flight: {{vehicle: vlm1.yaml}}' in place of what moves", scene));
  }
  if (a.sensors.empty()) return result;
  const Case one = std::move(result.front());
  result.clear();
  for (const std::string& sensor : a.sensors) {
    result.push_back(one);
    files::change_sensor(result.back().file, sensor);
  }
  return result;
}

closed_loop::Study study_of(const Case& c, const closed_loop::Study::Options& options) {
  try {
    return study(c.file.flight->plan, c.file.flight->dispersion, c.file.scenario, options);
  } catch (const std::invalid_argument& error) {  // of numbers that only together cannot be
    throw text::InputError(fmt::format("{}: {}", c.scene, error.what()));
  }
}

void add_notes(closed_loop::Study& s, const flight::Plan& plan, int runs) {
  note_faults(s.notes, plan);
  if (s.stopped) s.notes.push_back(fmt::format("interrupted: {} of {} flights of each kind", s.runs, runs));
  for (const auto& [kind, flights] :
       {std::pair{"sensors", &s.sensors}, std::pair{"vehicle", &s.vehicle}, std::pair{"all", &s.all}})
    note_lost(s.notes, kind, *flights);
  std::int64_t fixes = 0, refused = 0;
  for (const closed_loop::Outcome& o : s.sensors.outcomes) {
    fixes += o.fixes;
    refused += o.refused;
  }
  note_refused(s.notes, fixes, refused);
}

FlightResult fly(const FlyArguments& a, Case& c, Progress& progress, const Interruption& interruption) {
  files::FlightSource& source = *c.file.flight;
  flight::Flight& flight = source.plan.flight;
  constexpr double kMostPeriods = 1e6;
  flight.record_every = static_cast<int>(std::clamp(std::round(1 / (a.rate * flight.period)), 1.0, kMostPeriods));
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
                 .study = study_of(c, options)};
  add_notes(r.study, source.plan, a.runs);
  if (c.file.sensor.empty() && a.sensors.empty())
    r.study.notes.emplace_back("the IMU is ideal: the scene names no sensor file");
  return r;
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
    for (const std::string& input : {c.file.sensor, c.file.flight->vehicle.path}) check_outputs(input, outputs);
  if (all.size() > 1 && !a.output.empty())
    throw std::invalid_argument(
        fmt::format("-o {}: {} flights do not go into one file; write them one by one", a.output, all.size()));
  std::vector<FlightResult> results;
  {
    Progress progress(a.common, "flights");
    const Interruption interruption;
    for (Case& c : all) {
      if (interruption.asked()) break;
      results.push_back(fly(a, c, progress, interruption));
    }
  }
  if (!a.output.empty()) {
    const FlightResult& r = results.front();
    files::write_flight(a.output, r.study.flown.value_or(r.study.nominal), r.plan.flight.world.site,
                        r.plan.control.azimuth, a.common.command_line);
    if (a.output != "-") say(a.common, "flight: " + a.output);
  }
  if (a.output != "-") print(a.common.json ? report::flight_json(results) : report::flight_text(results));
  if (!a.report.empty()) {
    text::write_file(a.report, report::flight_page(results));
    say(a.common, "report page: " + a.report);
  }
  if (results.size() < all.size() || results.back().study.stopped) return exit_interrupted;
  return std::ranges::all_of(results, flew_to_the_end) ? exit_done : exit_no_answer;
}

}  // namespace gyrobudget::inline v0::cli

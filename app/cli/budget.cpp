// SPDX-License-Identifier: MIT
// budget: scene -> error budget per source.
#include "gyrobudget/app/report/budget.h"

#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/report/notes.h"
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

budget::Options options(const BudgetArguments& a, double end) {
  if (a.at && !(*a.at >= 0 && *a.at <= end))
    throw std::invalid_argument(fmt::format("--at {} s: the scene runs from 0 to {} s", *a.at, end));
  budget::Options asked{.at = a.at, .step = a.step, .imu_interval = 1 / a.rate, .exact = a.exact};
  asked.tolerance = a.keep_all ? std::nullopt : std::optional(a.tolerance);
  if (a.limit) asked.limit = {.component = a.limit->component, .position = a.limit->metres};
  asked.runs = a.runs;
  asked.each_source = a.each_source;
  asked.seed = a.seed;
  return asked;
}

report::BudgetResult result(const BudgetArguments& a, const files::SceneFile& file,
                            const earth::Trajectory& trajectory) {
  report::BudgetResult r{.scene = a.scene,
                         .name = file.scenario.name,
                         .sensor = file.sensor,
                         .command = a.common.command_line,
                         .limit = a.limit ? a.limit->text : "",
                         .not_stated = not_stated_of(file),
                         .notes = sensor_notes_of(file)};
  if (file.flight) report::note_short_flight(r.notes, file.flight->plan.flight, trajectory.duration());
  budget::Options asked = options(a, trajectory.duration());
  std::optional<Watch> watch;
  if (a.runs > 0) asked.progress = std::ref(watch.emplace(a.common, "runs"));
  r.study = budget::study(file.scenario, trajectory, asked);
  return r;
}

}  // namespace

int run(const BudgetArguments& a) {
  const std::vector<Output> outputs{{"--report", a.report}};
  check_outputs(a.scene, outputs);
  files::SceneFile file = files::read_scene(a.scene);
  for (const std::string& input : {file.sensor, file.trajectory}) check_outputs(input, outputs);
  for (const std::string& input : a.sensors) check_outputs(input, outputs);
  if (file.flight) check_outputs(file.flight->vehicle.path, outputs);
  const earth::Trajectory trajectory = files::planned_trajectory(file);
  std::vector<report::BudgetResult> results;
  if (a.sensors.empty()) results.push_back(result(a, file, trajectory));
  for (const std::string& sensor : a.sensors) {
    if (!results.empty() && results.back().study.stopped) break;
    change_sensor(file, sensor);
    results.push_back(result(a, file, trajectory));
  }
  print(a.common.json ? report::budget_json(results) : report::budget_text(results));
  if (!a.report.empty()) {
    text::write_file(a.report, report::budget_page(results));
    say(a.common, "report page: " + a.report);
  }
  if (results.back().study.stopped) return exit_interrupted;
  const bool met = std::ranges::all_of(results, [](const auto& r) { return !r.study.limit || r.study.limit->met(); });
  return met ? exit_done : exit_no_answer;
}

}  // namespace gyrobudget::inline v0::cli

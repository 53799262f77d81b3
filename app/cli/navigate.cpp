// SPDX-License-Identifier: MIT
// navigate: scene with a recorded IMU log -> navigation solution.
#include "gyrobudget/estimation/navigation/navigate.h"

#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/report/navigation.h"
#include "gyrobudget/app/text/output.h"

#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "paths.h"
#include "scenes.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

// What the scene reads, which no output may replace.
std::vector<std::string> inputs(const files::SceneFile& scene) {
  std::vector<std::string> paths{scene.imu->path};
  if (!scene.sensor.empty()) paths.push_back(scene.sensor);
  for (const files::AidSource& aid : scene.aids) {
    if (!aid.path.empty()) paths.push_back(aid.path);
  }
  return paths;
}

std::array<std::string, 3> axes_of(const files::ImuSource& imu) {
  std::array<std::string, 3> axes;
  for (std::size_t i = 0; i < axes.size(); ++i)
    axes[i] = fmt::format("{}{}", imu.sign[i] < 0 ? "-" : "", "xyz"[static_cast<std::size_t>(imu.axis[i])]);
  return axes;
}

void write(const NavigateArguments& a, const report::NavigationResult& r) {
  if (!a.output.empty()) text::write_file(a.output, report::solution_csv(r));
  if (!a.innovations.empty()) text::write_file(a.innovations, report::innovations_csv(r));
  if (a.report.empty()) return;
  text::write_file(a.report, report::navigation_page(r));
  say(a.common, "report page: " + a.report);
}

}  // namespace

int run(const NavigateArguments& a) {
  const std::vector<Output> outputs{{"-o", a.output}, {"--innovations", a.innovations}, {"--report", a.report}};
  check_outputs(a.scene, outputs);
  files::SceneFile scene = files::read_scene(a.scene, a.data_folder);
  if (!scene.imu)
    throw text::InputError(fmt::format(
        "{}: found no \"imu:\" with a recorded log, which navigate needs; a trajectory is for simulate", a.scene));
  for (const std::string& input : inputs(scene)) check_outputs(input, outputs);
  files::SceneData data = files::read_recording(scene);
  std::vector<std::string> not_stated = not_stated_of(scene);
  report::NavigationResult result{.scene = a.scene,
                                  .source = scene.imu->path,
                                  .command = a.common.command_line,
                                  .scenario = std::move(scene.scenario),
                                  .recording = std::move(data.recording),
                                  .run = {},
                                  .notes = std::move(data.notes),
                                  .not_stated = std::move(not_stated),
                                  .suspects = {},
                                  .noise = {},
                                  .imu_axes = axes_of(*scene.imu)};
  for (std::string& note : sensor_notes_of(scene)) result.notes.push_back(std::move(note));
  if (scene.sensor.empty())
    result.notes.emplace_back(
        "the scene names no sensor file: the IMU is taken as ideal, and no error of it is estimated");
  if (a.smooth) result.scenario.smooth = true;
  if (result.scenario.smooth)
    result.notes.emplace_back("solutions are smoothed: each uses all fixes, those after it too");
  result.run = naming(a.scene, [&] { return navigation::navigate(result.scenario, result.recording); });
  if (result.run.status == navigation::Navigation::Status::lost ||
      result.run.status == navigation::Navigation::Status::failed)
    result.suspects = navigation::suspects(result.scenario, result.recording);
  else if (!navigation::innovation_verdicts(result.run).empty())
    result.noise = navigation::noise_factors(result.scenario, result.recording);
  print(a.common.json ? report::navigation_json(result) : report::navigation_text(result));
  write(a, result);
  if (result.run.usable()) return exit_done;
  say(a.common, fmt::format("gyrobudget: {}", result.run.why));
  return exit_no_answer;
}

}  // namespace gyrobudget::inline v0::cli

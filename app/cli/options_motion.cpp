// SPDX-License-Identifier: MIT
// Options of the verbs of what moves: navigate, budget and fly.
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/vehicle_file.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <string>

#include "options.h"
#include "values.h"

namespace gyrobudget::inline v0::cli {
namespace {

App* add_navigate(App& app, NavigateArguments& a, Texts&) {
  auto* verb = app.add_subcommand(
      "navigate",
      "From a recorded IMU log, with GNSS, barometer or a reference, to position, velocity and attitude.\n\n"
      "  gyrobudget navigate drive.yaml -o solution.csv --report drive.html\n"
      "  gyrobudget navigate examples/scenes/mems-beside-fog.yaml --data my/logs --json\n");
  verb->add_option("scene", a.scene, "scene file: the log, the sensor, the alignment, the aids")
      ->required()
      ->type_name("SCENE");
  verb->add_option("--data", a.data_folder, "folder of the logs that the scene names [that of the scene]")
      ->type_name("FOLDER");
  auto* out = verb->add_option_group("Output");
  out->add_option("-o,--output", a.output, "write the solution with one-sigma columns")->type_name("FILE.csv");
  out->add_flag("--smooth", a.smooth, "solutions from all fixes, later ones too (fixed-interval smoother)");
  out->add_option("--innovations", a.innovations, "write what every fix told: residual, sigma, NIS")
      ->type_name("FILE.csv");
  out->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  add_common(*verb, a.common);
  verb->footer(fmt::format("Scene (YAML, every value with its unit):\n\n{}", files::scene_help()));
  return verb;
}

App* add_budget(App& app, BudgetArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "budget",
      "What each error source costs along a planned scene, in metres and degrees, by linear covariance.\n\n"
      "  gyrobudget budget examples/scenes/vlm1-ifog.yaml --exact --runs 200 --report budget.html\n"
      "  gyrobudget budget scene.yaml --sensor a.yaml --sensor b.yaml --limit 'crossrange < 10 m'\n");
  verb->add_option("scene", a.scene, "scene file: site, trajectory, sensor, alignment, aids")
      ->required()
      ->type_name("SCENE");
  auto* ask = verb->add_option_group("Question");
  ask->add_option("--at", texts.at, "time of the table [end of the scene]")->type_name("TIME");
  ask->add_option("--sensor", a.sensors, "in place of the scene's; several: side by side")->type_name("FILE");
  ask->add_option(
         "--limit", texts.limit,
         "how far may each source grow, and how long must a scene that aligns itself stand: 'east|north|up|downrange|crossrange|horizontal|rss < LENGTH'; exit 1 where the total is above it")
      ->type_name("TEXT");
  auto* how = verb->add_option_group("Method");
  how->add_option("--tolerance", a.tolerance,
                  "sources that together change no total by more than this fraction are left out and listed")
      ->check(Range{0.0, 0.5})
      ->capture_default_str();
  how->add_flag("--keep-all", a.keep_all, "leave nothing out");
  how->add_option("--step", texts.step, "of the covariance [1/200 of the scene, at most 1 s below an hour]")
      ->type_name("TIME");
  how->add_option("--rate", texts.rate, "of the IMU: it sets 1/f noise at short times and Monte Carlo [100 Hz]")
      ->type_name("HZ");
  how->add_flag("--exact", a.exact,
                "each source again by integrals over its structure function, without states for 1/f");
  how->add_option("--runs", a.runs, "Monte Carlo of the whole chain, not linearised; 0: none")
      ->check(Range{0, 1000000})
      ->capture_default_str();
  how->add_flag("--each-source", a.each_source, "as many runs of each source of the table alone")->needs("--runs");
  how->add_option("--seed", texts.seed, "of its random numbers")->capture_default_str();
  verb->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  add_common(*verb, a.common);
  verb->footer("Every key of a scene: gyrobudget navigate --help");
  return verb;
}

void finish(BudgetArguments& a, const Texts& texts) {
  if (!texts.at.empty()) a.at = quantity("--at", texts.at, noise::dimension::kTime);
  if (!texts.step.empty()) a.step = duration("--step", texts.step);
  if (!texts.rate.empty()) a.rate = rate("--rate", texts.rate);
  if (!texts.limit.empty()) a.limit = limit(texts.limit);
  a.seed = seed(texts.seed);
}

App* add_fly(App& app, FlyArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "fly",
      "A launch vehicle in closed loop, steered by what its sensors tell.\n\n"
      "  gyrobudget fly examples/scenes/vlm1-ifog.yaml examples/scenes/vlm1-mems.yaml --report flight.html\n"
      "  gyrobudget fly scene.yaml --sensor ideal --sensor mems.yaml --runs 200 --report flight.html\n");
  verb->add_option("scene", a.scenes, "scene files with a flight: site, vehicle, control, sensor, alignment, aids")
      ->required()
      ->type_name("SCENE");
  verb->add_option("--sensor", a.sensors, "in place of the scene's, \"ideal\" too; several: side by side")
      ->type_name("FILE")
      ->allow_extra_args(false);
  verb->add_option("--runs", a.runs, "Monte Carlo flights of each kind: sensors alone, vehicle alone, both; 0: none")
      ->check(Range{0, 1000000})
      ->capture_default_str();
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into every output")->capture_default_str();
  auto* out = verb->add_option_group("Output");
  out->add_option("-o,--output", a.output, "write the flight: trajectory, attitude, nozzle, air, navigation error")
      ->type_name("FILE.csv");
  out->add_option("--rate", texts.rate, "of its rows [10 Hz]")->type_name("HZ");
  out->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  add_common(*verb, a.common);
  verb->footer(
      fmt::format("Every key of a scene: gyrobudget navigate --help\n\nVehicle (YAML):\n\n{}", files::vehicle_help()));
  return verb;
}

void finish(FlyArguments& a, const Texts& texts) {
  if (!texts.rate.empty()) a.rate = rate("--rate", texts.rate);
  a.seed = seed(texts.seed);
}

void finish(NavigateArguments&, const Texts&) {}

}  // namespace

Verb navigate_verb(App& app) { return make_verb<NavigateArguments>(app, add_navigate, finish); }
Verb budget_verb(App& app) { return make_verb<BudgetArguments>(app, add_budget, finish); }
Verb fly_verb(App& app) { return make_verb<FlyArguments>(app, add_fly, finish); }

}  // namespace gyrobudget::inline v0::cli

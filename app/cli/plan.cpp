// SPDX-License-Identifier: MIT
// plan: sensor file -> how long to record for an accuracy, or what accuracy a length buys.
#include "gyrobudget/app/report/plan.h"

#include "gyrobudget/app/report/sensor_words.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;
constexpr std::array kPlanned{Term::quantization, Term::white, Term::flicker, Term::rate_random_walk};

// What fit::plan would refuse, in words of the command line.
void check(const noise::SensorModel& sensor, const PlanArguments& a) {
  const auto has = [&](noise::Term term) { return sensor.gyro[term].largest() > 0; };
  if (std::ranges::none_of(kPlanned, has)) {
    throw text::InputError(fmt::format(
        "{}: the gyro has no noise coefficient above zero; plan needs the expected arw, bias_instability and rrw",
        sensor.name));
  }
  if (a.duration_s && !fit::can_plan(*a.duration_s, a.rate_hz)) {
    throw std::invalid_argument(fmt::format("--duration {:g} s at {:g} Hz: a record of 16 to 1e15 samples is expected",
                                            *a.duration_s, a.rate_hz));
  }
  for (const auto& wish : a.wishes) {
    if (std::ranges::find(kPlanned, wish.term) != kPlanned.end() && has(wish.term)) continue;
    throw std::invalid_argument(
        fmt::format("--want {}: {} has no such term above zero", static_cast<char>(wish.term), sensor.name));
  }
}

}  // namespace

int run(const PlanArguments& a) {
  const sensor_file::SensorFile file = sensor_file::read_sensor_file(a.sensor, {.rate_hz = a.sensor_rate_hz});
  const noise::SensorModel& sensor = file.model;
  check(sensor, a);
  const report::PlanStudy study{
      .sensor = sensor.name,
      .command = a.common.command_line,
      .rate_hz = a.rate_hz,
      .plan = fit::plan_axes(sensor.gyro, {.rate_hz = a.rate_hz, .duration_s = a.duration_s, .wishes = a.wishes}),
      .notes = report::sensor_notes(file.warnings, file.notes, a.sensor)};
  print(a.common.json ? report::plan_json(study) : report::plan_table(study));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

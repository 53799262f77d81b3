// SPDX-License-Identifier: MIT
// plan: sensor file -> how long to record for an accuracy, or what accuracy a length buys.
#include "gyrobudget/app/report/plan.h"

#include "gyrobudget/app/sensor_file/sensor_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

// What fit::plan would refuse, in words of the command line.
void check(const noise::SensorModel& sensor, const PlanArguments& a) {
  const auto terms = fit::planned_terms(sensor.gyro);
  if (terms.empty()) {
    throw text::InputError(fmt::format(
        "{}: the gyro has no noise coefficient above zero; plan needs the expected arw, bias_instability and rrw",
        sensor.name));
  }
  if (a.duration_s && !fit::can_plan(*a.duration_s, a.rate_hz)) {
    throw std::invalid_argument(fmt::format("--duration {:g} s at {:g} Hz: a record of 16 to 1e15 samples is expected",
                                            *a.duration_s, a.rate_hz));
  }
  for (const auto& wish : a.wishes) {
    if (std::ranges::find(terms, wish.term, noise::term) != terms.end()) continue;
    throw std::invalid_argument(
        fmt::format("--want {}: {} has no such term above zero", static_cast<char>(wish.term), sensor.name));
  }
}

}  // namespace

int run(const PlanArguments& a) {
  const noise::SensorModel sensor = sensor_file::read_sensor(a.sensor);
  check(sensor, a);
  const report::PlanStudy study{
      .sensor = sensor.name,
      .command = a.common.command_line,
      .rate_hz = a.rate_hz,
      .plan = fit::plan(sensor.gyro, {.rate_hz = a.rate_hz, .duration_s = a.duration_s, .wishes = a.wishes})};
  print(a.common.json ? report::plan_json(study) : report::plan_table(study));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

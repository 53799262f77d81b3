// SPDX-License-Identifier: MIT
// plan: sensor file -> how long to record for an accuracy, or what accuracy a length buys.
#include "gyrobudget/app/report/plan.h"

#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/estimation/fit/information.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

// What the record must tell apart: the random terms of the sensor among N, B, K and Q.
std::vector<noise::Process> random_terms(const noise::SensorModel& sensor) {
  std::vector<noise::Process> list;
  for (const Term t : {Term::quantization, Term::white, Term::flicker, Term::rate_random_walk}) {
    if (sensor.gyro[t] > 0) list.push_back(noise::with_coefficient(noise::unit_process(t), sensor.gyro[t]));
  }
  if (list.empty()) {
    throw text::InputError(fmt::format(
        "{}: the gyro has no noise coefficient above zero; plan needs the expected arw, bias_instability and rrw",
        sensor.name));
  }
  return list;
}

report::PlanRow row_for(const std::vector<noise::Process>& terms, double duration_s, double dt) {
  const auto samples = static_cast<std::int64_t>(std::llround(duration_s / dt));
  const Eigen::VectorXd bound = fit::relative_bound(terms, samples, dt);
  return {duration_s, {bound.data(), bound.data() + bound.size()}};
}

constexpr double kHour = 3600;
constexpr double kDefaultAccuracy = 0.10;

}  // namespace

int run(const PlanArguments& a) {
  const noise::SensorModel sensor = sensor_file::read_sensor(a.sensor);
  const auto terms = random_terms(sensor);
  const double dt = 1 / a.rate_hz;
  report::Plan plan{.sensor = sensor.name, .command = a.common.command_line, .rate_hz = a.rate_hz};
  for (const auto& process : terms) plan.terms.push_back({noise::term(process), noise::coefficient(process)});

  constexpr double kFewestSamples = 16, kMostSamples = 1e15;
  if (a.duration_s && !(*a.duration_s >= kFewestSamples * dt && *a.duration_s <= kMostSamples * dt)) {
    throw std::invalid_argument(fmt::format("--duration {:g} s at {:g} Hz: a record of 16 to 1e15 samples is expected",
                                            *a.duration_s, a.rate_hz));
  }
  if (a.duration_s) {
    plan.rows.push_back(row_for(terms, *a.duration_s, dt));
  } else if (a.wishes.empty()) {
    for (const double hours : {0.5, 1.0, 2.0, 5.0, 10.0, 24.0, 48.0, 100.0, 300.0}) {
      plan.rows.push_back(row_for(terms, hours * kHour, dt));
    }
  }
  auto wishes = a.wishes;
  if (wishes.empty() && !a.duration_s) {
    for (const auto& t : plan.terms) wishes.push_back({t.term, kDefaultAccuracy});
  }
  for (const auto& wish : wishes) {
    const auto at =
        std::find_if(plan.terms.begin(), plan.terms.end(), [&](const auto& t) { return t.term == wish.term; });
    if (at == plan.terms.end()) {
      throw std::invalid_argument(
          fmt::format("--want {}: {} has no such term above zero", static_cast<char>(wish.term), sensor.name));
    }
    const auto index = static_cast<std::size_t>(at - plan.terms.begin());
    plan.answers.push_back({wish.term, wish.relative_std, fit::duration_for(terms, index, wish.relative_std, dt)});
  }
  print(a.common.json ? report::plan_json(plan) : report::plan_table(plan));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

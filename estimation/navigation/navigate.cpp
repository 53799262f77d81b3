// SPDX-License-Identifier: MIT
#include "navigate.h"

#include "gyrobudget/estimation/navigation/detail/runner.h"
#include "gyrobudget/estimation/navigation/detail/time_tags.h"

#include <fmt/format.h>

#include <variant>

namespace gyrobudget::inline v0::navigation {
namespace {

void check_aid_number(const Scenario& scenario, std::size_t aid, Aid::Kind kind, const char* what) {
  if (aid >= scenario.aids.size())
    throw SetupError(fmt::format("{}: aid number {}, there are {}", what, aid, scenario.aids.size()));
  if (scenario.aids[aid].kind != kind)
    throw SetupError(fmt::format("{}: aid {} measures {}, not {}", what, scenario.aids[aid].name,
                                 name(scenario.aids[aid].kind), name(kind)));
}

}  // namespace

void detail::check_input(const Scenario& scenario, const Recording& recording) {
  if (recording.imu.increments.empty() || recording.imu.stamps.size() != recording.imu.increments.size() + 1)
    throw RecordingError(fmt::format("IMU log of {} increments and {} stamps, expected one stamp more",
                                     recording.imu.increments.size(), recording.imu.stamps.size()));
  if (recording.fixes.size() != scenario.aids.size())
    throw RecordingError(fmt::format("{} lists of fixes for {} aids", recording.fixes.size(), scenario.aids.size()));
  for (const Aid& aid : scenario.aids) navigation::check(aid);
  const AlignmentPlan& a = scenario.alignment;
  if (const auto* from = std::get_if<FromAid>(&a.position))
    check_aid_number(scenario, from->aid, Aid::Kind::position, "alignment's position");
  if (const auto* from = std::get_if<FromAid>(&a.velocity))
    check_aid_number(scenario, from->aid, Aid::Kind::velocity, "alignment's velocity");
  if (const auto* from = std::get_if<FromAid>(&a.attitude))
    check_aid_number(scenario, from->aid, Aid::Kind::attitude, "alignment's attitude");
  for (const std::size_t aid : scenario.reference) {
    if (aid >= scenario.aids.size()) check_aid_number(scenario, aid, Aid::Kind::position, "reference");
  }
  if (!(scenario.solution_interval > 0))
    throw SetupError(fmt::format("interval of solutions is {} s, expected above 0 s", scenario.solution_interval));
}

NisSummary Navigation::nis() const {
  double sum = 0, dof = 0, inside = 0, tested = 0;
  for (const AidSummary& a : aids) {
    const auto used = static_cast<double>(a.used), all = static_cast<double>(a.used + a.gated);
    sum += a.nis_mean * used;
    dof += used * a.rows;
    inside += a.inside_95 * all;
    tested += all;
  }
  return {sum / dof, inside / tested};
}

Navigation navigate(const Scenario& scenario, const Recording& recording) {
  detail::check_input(scenario, recording);
  return detail::run_with_time_tags(scenario, recording);
}

}  // namespace gyrobudget::inline v0::navigation

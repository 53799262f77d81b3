// SPDX-License-Identifier: MIT
// The logs of a scene together: one clock for IMU and aids.
#include "gyrobudget/app/log/calendar.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <span>
#include <stdexcept>
#include <utility>

#include "scene_columns.h"
#include "scene_file.h"
#include "scene_logs.h"

namespace gyrobudget::inline v0::files {
namespace {

using navigation::Aid;
using navigation::Fix;

void note_imu(const ImuSource& source, const navigation::ImuLog& imu, std::vector<std::string>& notes) {
  if (imu.gaps == 0) return;
  notes.push_back(fmt::format(
      "{}: {} gap{} of {:.3g} s in all, the longest {:.3g} s, bridged by straight rates; the sigmas grow over them as far as the motion around them lets expect",
      source.path, imu.gaps, imu.gaps == 1 ? "" : "s", imu.bridged_seconds, imu.longest_gap));
}

// --- Clocks ---

/// Whether a stamp counts from an epoch, such as 1970: beyond 1e6 s it is the clock of no run.
bool is_dated(std::int64_t stamp) {
  constexpr std::int64_t kFar = 1'000'000'000'000'000;  // [ns]
  return stamp > kFar || stamp < -kFar;
}

std::string stamp_in(std::int64_t stamp, const std::string& scale) {
  if (!is_dated(stamp)) return fmt::format("{:.3f} s", static_cast<double>(stamp) * noise::kNanosecond);
  return log::calendar_text(stamp) + (scale.empty() ? "" : " ") + scale;
}

std::string device_name(const Aid& aid) { return aid.name.substr(0, aid.name.rfind('.')); }

/// One of the two counts from an epoch and the other does not.
void check_kind_of_clock(const Aid& aid, const AidFixes& found, std::int64_t first_sample) {
  const std::int64_t first = found.fixes.front().stamp;
  if (is_dated(first) == is_dated(first_sample)) return;
  const std::string clocks =
      fmt::format("aids.{}: its fixes begin at {} and the IMU's samples at {}, expected one clock", device_name(aid),
                  stamp_in(first, found.time_scale), stamp_in(first_sample, ""));
  if (!is_dated(first)) throw text::InputError(clocks + "; put the fixes on the IMU's");
  throw text::InputError(
      fmt::format("{}; say in the scene which instant is 0 on the IMU's clock, as in imu: {{epoch: {}{}}}", clocks,
                  log::calendar_text(first - first % noise::kNanosecondsPerSecond),
                  found.time_scale.empty() ? "" : " " + found.time_scale));
}

/// Scales that both sides tell have to be one; leap seconds are never put in or taken out in silence.
void check_scale(const ImuSource& imu, const Aid& aid, const AidFixes& found, std::vector<std::string>& notes) {
  if (found.time_scale.empty() || !is_dated(found.fixes.front().stamp)) return;
  if (imu.epoch && !imu.epoch->scale.empty() && imu.epoch->scale != found.time_scale)
    throw text::InputError(fmt::format(
        "aids.{}: its stamps are {} and the IMU's \"epoch:\" is {}, expected one; give the epoch in {} (GPST is 18 s ahead of UTC since 2017)",
        device_name(aid), found.time_scale, imu.epoch->scale, found.time_scale));
  if (imu.epoch || found.time_scale != "GPST") return;
  notes.push_back(fmt::format(
      "{}: its stamps are GPST, and the IMU's are taken as that too; where they are UTC, which is 18 s behind since 2017, say time_tag: -18 s",
      aid.name));
}

/// Fixes that all lie before or behind the IMU's samples.
void note_overlap(const Aid& aid, const AidFixes& found, const navigation::ImuLog& imu,
                  std::vector<std::string>& notes) {
  const std::int64_t first = found.fixes.front().stamp, last = found.fixes.back().stamp;
  if (first <= imu.stamps.back() && last >= imu.stamps.front()) return;
  const double apart = static_cast<double>(first) - static_cast<double>(imu.stamps.front());
  constexpr double kRollover = 1024 * static_cast<double>(log::kWeek);
  const double turns = std::round(apart / kRollover);
  const bool rolled = turns != 0 && std::abs(apart - turns * kRollover) < static_cast<double>(log::kDay);
  notes.push_back(fmt::format(
      "{}: its fixes, from {} to {}, and the IMU's samples, from {} to {}, do not overlap{}", aid.name,
      stamp_in(first, found.time_scale), stamp_in(last, found.time_scale), stamp_in(imu.stamps.front(), ""),
      stamp_in(imu.stamps.back(), ""),
      rolled ? fmt::format(": they are {:g} times 1024 weeks apart, the week of GPS came round", turns) : ""));
}

}  // namespace

std::vector<std::string> column_names(std::initializer_list<std::span<const log::Wanted>> lists) {
  std::vector<std::string> names{std::string(log::kTimeColumn.name)};
  for (const auto& list : lists) {
    for (const log::Wanted& w : list) names.emplace_back(w.name);
  }
  return names;
}

SceneData read_recording(const SceneFile& scene) {
  if (!scene.imu)
    throw text::InputError(
        "the scene has no \"imu:\" with a recorded log; one of a trajectory is for simulate, budget and fly");
  SceneData data;
  const noise::SensorModel& sensor = scene.scenario.sensor;
  const bool warm = sensor.gyro.temperature || (sensor.accelerometer && sensor.accelerometer->temperature);
  navigation::ImuSamples samples = read_samples(*scene.imu, warm, data.notes);
  if (navigation::take_off_temperature(samples, sensor))
    data.notes.emplace_back("the sensor file's bias over temperature is taken off, by the log's temperature");
  else if (warm)
    data.notes.emplace_back("the sensor file has a bias over temperature, which this log has no temperature for");
  const std::int64_t first = samples.stamps.front();
  data.recording.origin = scene.imu->epoch ? scene.imu->epoch->ns : is_dated(first) ? first : 0;
  try {
    data.recording.imu = navigation::imu_log(samples);
  } catch (const std::invalid_argument& error) {
    text::fail(scene.imu->path, error.what());
  }
  note_imu(*scene.imu, data.recording.imu, data.notes);
  for (std::size_t i = 0; i < scene.aids.size(); ++i) {
    const Aid& aid = scene.scenario.aids[i];
    const bool recorded = !scene.aids[i].path.empty();
    if (!recorded && aid.kind != Aid::Kind::rest)
      throw text::InputError(fmt::format("aids.{}: there is no \"file:\" with its fixes", aid.name));
    data.recording.fixes.emplace_back();
    if (!recorded) continue;
    AidFixes found = read_fixes(aid, scene.aids[i], aid.name.starts_with("reference."), data.notes);
    if (!found.fixes.empty()) {
      check_kind_of_clock(aid, found, first);
      check_scale(*scene.imu, aid, found, data.notes);
      note_overlap(aid, found, data.recording.imu, data.notes);
    }
    data.recording.fixes.back() = std::move(found.fixes);
  }
  return data;
}

}  // namespace gyrobudget::inline v0::files

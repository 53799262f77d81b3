// SPDX-License-Identifier: MIT
// The logs of a scene: IMU samples and fixes of aids, by the names of their columns.
#include "gyrobudget/app/log/named_columns.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>
#include <utility>

#include "scene_columns.h"
#include "scene_file.h"

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Vector3d;
using navigation::Aid;
using navigation::Fix;
namespace dimension = noise::dimension;

constexpr std::size_t kChunk = std::size_t{1} << 20;

constexpr std::array<log::Wanted, 3> kGyro{{{"gyro_x", {"w_rs_s_x", "gyrox"}, dimension::kAngularRate},
                                            {"gyro_y", {"w_rs_s_y", "gyroy"}, dimension::kAngularRate},
                                            {"gyro_z", {"w_rs_s_z", "gyroz"}, dimension::kAngularRate}}};
constexpr std::array<log::Wanted, 3> kAccelerometer{
    {{"accel_x", {"a_rs_s_x", "accelerometer_x"}, dimension::kSpecificForce},
     {"accel_y", {"a_rs_s_y", "accelerometer_y"}, dimension::kSpecificForce},
     {"accel_z", {"a_rs_s_z", "accelerometer_z"}, dimension::kSpecificForce}}};
constexpr log::Wanted kNorth{"velocity_north", {"v_north", "vn"}, dimension::kVelocity};
constexpr log::Wanted kEast{"velocity_east", {"v_east", "ve"}, dimension::kVelocity};
constexpr log::Wanted kDown{"velocity_down", {"v_down", "vd"}, dimension::kVelocity};
constexpr log::Wanted kUp{"velocity_up", {"v_up", "vu"}, dimension::kVelocity};
constexpr log::Wanted kHeading{"heading", {"yaw", "yaw"}, dimension::kAngle};
constexpr log::Wanted kYawCcw{"yaw_ccw", {"yaw_ccw", "yaw_ccw"}, dimension::kAngle};

std::string hint(std::string_view example, std::string_view names) {
  return fmt::format("expected a header with {}, or their columns in the scene, as in columns: {{{}}}", names, example);
}

/// A text file, its layout and the numbers of chosen columns.
class File {
 public:
  explicit File(const std::string& path)
      : source_(path), layout_(log::read_layout(source_)), reader_(source_, layout_, kChunk) {}

  [[nodiscard]] const std::string& name() const { return source_.name(); }
  [[nodiscard]] log::NamedColumns columns(const log::ColumnMap& map, std::string_view expected) const {
    return {source_, layout_, map, expected};
  }
  [[nodiscard]] log::Table read(const log::Choice& choice) const { return reader_.read(choice); }
  [[noreturn]] void fail_row(std::size_t row, const std::string& message) const {
    text::fail_at(name(), reader_.line_of_row(row), 1, message);
  }
  /// Every row needs a stamp, after that of the row before.
  void check_stamps(const log::Table& table) const {
    for (std::size_t row = 0; row < table.rows; ++row) {
      if (table.stamps[row] == text::kNoStamp) fail_row(row, "found no time, expected one in every row");
      if (row > 0 && table.stamps[row] <= table.stamps[row - 1])
        fail_row(row, "found a time that is not after the one before, expected times that ascend");
    }
  }

 private:
  log::Bytes source_;
  log::Layout layout_;
  log::TableReader reader_;
};

// --- The IMU -------------------------------------------------------------------------------------------------

constexpr const char* kImuExample = "gyro_x: wx (deg/s)";
constexpr const char* kImuNames = "gyro_x (rad/s) ... gyro_z, accel_x (m/s^2) ... accel_z, and time (s)";

// Three columns that are all rates or all increments.
bool add_triad(const File& file, const log::NamedColumns& columns, std::span<const log::Wanted> wanted,
               const noise::Dimension& rate, const noise::Dimension& increment, log::Choice& choice) {
  std::size_t first = 0;
  for (const log::Wanted& w : wanted) {
    const auto [column, which] = columns.get(w, {rate, increment});
    if (&w == wanted.data()) first = which;
    if (which != first)
      text::fail(file.name(), fmt::format("column {} is {}, {} is not: expected three rates or three increments",
                                          text::quoted(column.name), which == 0 ? "a rate" : "an increment",
                                          text::quoted(choice.data.back().name)));
    choice.data.push_back(column);
  }
  return first == 1;
}

Vector3d turned(const ImuSource& imu, const log::Table& table, std::size_t first, std::size_t row) {
  Vector3d result;
  for (std::size_t i = 0; i < 3; ++i)
    result[static_cast<Eigen::Index>(i)] =
        imu.sign[i] * table.numbers[first + static_cast<std::size_t>(imu.axis[i])][row];
  return result;
}

std::vector<std::int64_t> stamps(const File& file, const log::Table& table, const ImuSource& imu, bool timed) {
  if (timed) {
    file.check_stamps(table);
    return table.stamps;
  }
  std::vector<std::int64_t> result(table.rows);
  constexpr double kNanoseconds = 1e9;
  for (std::size_t k = 0; k < table.rows; ++k)
    result[k] = std::llround(static_cast<double>(k) / *imu.rate_hz * kNanoseconds);
  return result;
}

navigation::ImuSamples read_samples(const ImuSource& imu, bool with_temperature) {
  const File file(imu.path);
  const std::string expected = hint(kImuExample, kImuNames);
  const log::NamedColumns columns = file.columns(imu.columns, expected);
  log::Choice choice;
  navigation::ImuSamples samples;
  using navigation::SampleKind;
  const SampleKind rates = imu.instants ? SampleKind::instant : SampleKind::mean;
  const bool angles = add_triad(file, columns, kGyro, dimension::kAngularRate, dimension::kAngle, choice);
  const bool velocities =
      add_triad(file, columns, kAccelerometer, dimension::kSpecificForce, dimension::kVelocity, choice);
  samples.gyro = angles ? SampleKind::increment : rates;
  samples.accelerometer = velocities ? SampleKind::increment : rates;
  samples.stamp = imu.stamp;
  if (imu.instants && angles != velocities)
    text::fail(file.name(), "samples: instant asks for rates, found one triad of increments");
  constexpr log::Wanted kTemperature{"temperature", {"temp", "T"}, dimension::kTemperature};
  const bool has_temperature = with_temperature && columns.find(kTemperature).has_value();
  if (has_temperature) choice.data.push_back(columns.get(kTemperature));
  const bool timed = !imu.rate_hz || columns.find(log::kTimeColumn);
  if (timed) log::add_stamps(choice, columns.get(log::kTimeColumn));

  log::Table table = file.read(choice);
  if (has_temperature) samples.temperature = std::move(table.numbers.back());
  constexpr std::size_t kFewest = 2;
  if (table.rows < kFewest)
    text::fail(file.name(), fmt::format("has {} rows, expected 2 or more IMU samples", table.rows));
  samples.stamps = stamps(file, table, imu, timed);
  constexpr std::size_t kFirstForce = 3;
  for (std::size_t row = 0; row < table.rows; ++row)
    samples.values.push_back({.angle = earth::array(turned(imu, table, 0, row)),
                              .velocity = earth::array(turned(imu, table, kFirstForce, row))});
  return samples;
}

// --- Aids ----------------------------------------------------------------------------------------------------

constexpr const char* kAidExample = "latitude: lat_rad (rad)";

// The columns of one quantity; and how numbers of a row become a fix.
struct Plan {
  std::vector<log::Wanted> wanted;
  std::string names;
};

Plan plan_of(Aid::Kind kind, const log::NamedColumns& columns) {
  switch (kind) {
    case Aid::Kind::position:
      return {{log::kPlaceColumns.begin(), log::kPlaceColumns.end()},
              "latitude (deg), longitude (deg), height (m) and time (s)"};
    case Aid::Kind::height:
      return {{log::kPlaceColumns.back()}, "height (m) and time (s)"};
    case Aid::Kind::velocity:
      return {{kNorth, kEast, columns.find(kUp) ? kUp : kDown},
              "velocity_north (m/s), velocity_east (m/s), velocity_down (m/s) or velocity_up, and time (s)"};
    case Aid::Kind::attitude:
    case Aid::Kind::rest:  // has no file
      break;
  }
  const std::string names = "heading (deg), pitch (deg), roll (deg) or q_w, q_x, q_y, q_z, and time (s)";
  if (columns.find(log::kQuaternionColumns.front()))
    return {{log::kQuaternionColumns.begin(), log::kQuaternionColumns.end()}, names};
  const log::Wanted& yaw = columns.find(kYawCcw)                 ? kYawCcw
                           : columns.find(log::kEulerColumns[0]) ? log::kEulerColumns[0]
                                                                 : kHeading;
  return {{yaw, log::kEulerColumns[1], log::kEulerColumns[2]}, names};
}

Eigen::Quaterniond attitude(const File& file, std::size_t row, const Plan& plan, const log::Table& table) {
  const auto at = [&](std::size_t i) { return table.numbers[i][row]; };
  if (plan.wanted.size() == log::kQuaternionColumns.size()) {
    const Eigen::Quaterniond q(at(0), at(1), at(2), at(3));
    constexpr double kTolerance = 0.01;
    if (!(std::abs(q.norm() - 1) <= kTolerance))
      file.fail_row(row, fmt::format("found a quaternion of length {:.6g}, expected 1 (w first)", q.norm()));
    return q.normalized();
  }
  const double sign = plan.wanted.front().name == kYawCcw.name ? -1 : 1;
  return earth::from_euler({sign * at(0), at(1), at(2)});
}

Fix fix_of(Aid::Kind kind, const File& file, std::size_t row, const Plan& plan, const log::Table& table) {
  const auto at = [&](std::size_t i) { return table.numbers[i][row]; };
  Fix fix;
  fix.stamp = table.stamps[row];
  switch (kind) {
    case Aid::Kind::position:
      if (std::abs(at(0)) > 90 * earth::kDegree)
        file.fail_row(row, fmt::format("found a latitude of {} deg, expected -90 to 90", at(0) / earth::kDegree));
      fix.value = earth::to_ecef({at(0), at(1), at(2)});
      break;
    case Aid::Kind::height:
      fix.value[0] = at(0);
      break;
    case Aid::Kind::velocity:
      fix.value = {at(0), at(1), plan.wanted.back().name == kUp.name ? -at(2) : at(2)};
      break;
    case Aid::Kind::attitude:
      fix.q_nb = attitude(file, row, plan, table);
      break;
    case Aid::Kind::rest:  // has no file
      break;
  }
  return fix;
}

// The fixes of one aid; `optional` ones may have no columns.
std::vector<Fix> read_fixes(const Aid& aid, const AidSource& source, bool optional, std::vector<std::string>& notes) {
  const File file(source.path);
  const std::string expected = hint(kAidExample, plan_of(aid.kind, file.columns(source.columns, {})).names);
  const log::NamedColumns columns = file.columns(source.columns, expected);
  const Plan plan = plan_of(aid.kind, columns);
  log::Choice choice;
  for (const log::Wanted& w : plan.wanted) {
    if (optional && !columns.find(w)) return {};
    choice.data.push_back(columns.get(w));
  }
  log::add_stamps(choice, columns.get(log::kTimeColumn));
  const log::Table table = file.read(choice);
  file.check_stamps(table);
  std::vector<Fix> fixes;
  for (std::size_t row = 0; row < table.rows; ++row) {
    bool complete = true;
    for (const auto& column : table.numbers) complete &= std::isfinite(column[row]);
    if (complete) fixes.push_back(fix_of(aid.kind, file, row, plan, table));
  }
  if (fixes.size() < table.rows)
    notes.push_back(fmt::format("{}: {} of {} rows have a number missing and are passed over", aid.name,
                                table.rows - fixes.size(), table.rows));
  return fixes;
}

std::vector<std::string> names_of(std::initializer_list<std::span<const log::Wanted>> lists) {
  std::vector<std::string> names{std::string(log::kTimeColumn.name)};
  for (const auto& list : lists) {
    for (const log::Wanted& w : list) names.emplace_back(w.name);
  }
  return names;
}

void note_imu(const ImuSource& source, const navigation::ImuLog& imu, std::vector<std::string>& notes) {
  if (imu.gaps == 0) return;
  notes.push_back(fmt::format(
      "{}: {} gap{} of {:.3g} s in all, the longest {:.3g} s, bridged by straight rates; the sigmas grow over them as far as the motion around them lets expect",
      source.path, imu.gaps, imu.gaps == 1 ? "" : "s", imu.bridged_seconds, imu.longest_gap));
}

}  // namespace

const std::vector<std::string>& imu_column_names() {
  static const std::vector<std::string> names = names_of({kGyro, kAccelerometer});
  return names;
}

const std::vector<std::string>& aid_column_names() {
  static const std::array kOthers{kNorth, kEast, kDown, kUp, kHeading, kYawCcw};
  static const std::vector<std::string> names =
      names_of({log::kPlaceColumns, kOthers, log::kEulerColumns, log::kQuaternionColumns});
  return names;
}

SceneData read_recording(const SceneFile& scene) {
  if (!scene.imu)
    throw text::InputError(
        "the scene has no \"imu:\" with a recorded log; one of a trajectory is for simulate, budget and fly");
  SceneData data;
  const noise::SensorModel& sensor = scene.scenario.sensor;
  const bool warm = sensor.gyro.temperature || (sensor.accelerometer && sensor.accelerometer->temperature);
  navigation::ImuSamples samples = read_samples(*scene.imu, warm);
  if (navigation::take_off_temperature(samples, sensor))
    data.notes.emplace_back("the sensor file's bias over temperature is taken off, by the log's temperature");
  else if (warm)
    data.notes.emplace_back("the sensor file has a bias over temperature, which this log has no temperature for");
  constexpr std::int64_t kFar = 1'000'000'000'000'000;  // ns: the clock of an epoch, not of a run
  data.recording.origin = std::abs(samples.stamps.front()) > kFar ? samples.stamps.front() : 0;
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
    data.recording.fixes.push_back(
        recorded ? read_fixes(aid, scene.aids[i], aid.name.starts_with("reference."), data.notes) : std::vector<Fix>{});
  }
  return data;
}

}  // namespace gyrobudget::inline v0::files

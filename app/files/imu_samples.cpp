// SPDX-License-Identifier: MIT
// The IMU's samples of a scene, by the names of their columns.
#include "gyrobudget/app/log/named_file.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <span>
#include <utility>

#include "scene_columns.h"
#include "scene_logs.h"

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Vector3d;
namespace dimension = noise::dimension;

// Names of texts, of sensor_msgs/Imu, PX4's sensor_combined and vehicle_imu, and ArduPilot's IMU.
constexpr std::array<log::Wanted, 3> kGyro{
    {{"gyro_x",
      {"w_rs_s_x", "gyrox", "angular_velocity.x", "gyro_rad[0]", "gyrx", "delta_angle[0]", "gyr_x"},
      dimension::kAngularRate},
     {"gyro_y",
      {"w_rs_s_y", "gyroy", "angular_velocity.y", "gyro_rad[1]", "gyry", "delta_angle[1]", "gyr_y"},
      dimension::kAngularRate},
     {"gyro_z",
      {"w_rs_s_z", "gyroz", "angular_velocity.z", "gyro_rad[2]", "gyrz", "delta_angle[2]", "gyr_z"},
      dimension::kAngularRate}}};
constexpr std::array<log::Wanted, 3> kAccelerometer{{{"accel_x",
                                                      {"a_rs_s_x", "accelerometer_x", "linear_acceleration.x",
                                                       "accelerometer_m_s2[0]", "accx", "delta_velocity[0]", "acc_x"},
                                                      dimension::kSpecificForce},
                                                     {"accel_y",
                                                      {"a_rs_s_y", "accelerometer_y", "linear_acceleration.y",
                                                       "accelerometer_m_s2[1]", "accy", "delta_velocity[1]", "acc_y"},
                                                      dimension::kSpecificForce},
                                                     {"accel_z",
                                                      {"a_rs_s_z", "accelerometer_z", "linear_acceleration.z",
                                                       "accelerometer_m_s2[2]", "accz", "delta_velocity[2]", "acc_z"},
                                                      dimension::kSpecificForce}}};

constexpr log::StreamUse kImuStream{[](const log::StreamInfo& s) { return s.kind == log::StreamKind::imu; }, "IMU",
                                    "topic:"};
constexpr std::string_view kImuColumns =
    "expected gyro_x (rad/s) ... gyro_z, accel_x (m/s^2) ... accel_z and time (s), or their columns in the scene, as in columns: {gyro_x: wx (deg/s)}";

// Three columns that are all rates or all increments.
bool add_triad(const log::NamedFile& file, const log::NamedColumns& columns, std::span<const log::Wanted> wanted,
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

std::vector<std::int64_t> sample_stamps(const log::NamedFile& file, const log::Table& table, const ImuSource& imu,
                                        bool timed) {
  std::vector<std::int64_t> result(table.rows);
  if (timed) {
    file.check_stamps(table);
    result = table.stamps;
  } else {
    constexpr double kNanoseconds = 1e9;
    for (std::size_t k = 0; k < table.rows; ++k)
      result[k] = std::llround(static_cast<double>(k) / *imu.rate_hz * kNanoseconds);
  }
  if (!imu.epoch) return result;
  for (std::int64_t& stamp : result) {
    if (__builtin_add_overflow(stamp, imu.epoch->ns, &stamp))
      text::fail(file.name(), "its times count from an epoch already; leave \"epoch:\" out of the scene");
  }
  return result;
}

}  // namespace

const std::vector<std::string>& imu_column_names() {
  static const std::vector<std::string> names = column_names({kGyro, kAccelerometer});
  return names;
}

navigation::ImuSamples read_samples(const ImuSource& imu, bool with_temperature, std::vector<std::string>& notes) {
  const log::NamedFile file(imu.path, imu.topic, kImuStream);
  const log::NamedColumns columns = file.columns(imu.columns, kImuColumns);
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
  constexpr log::Wanted kTemperature{"temperature", {"temp"}, dimension::kTemperature};
  const bool has_temperature = with_temperature && columns.find(kTemperature).has_value();
  if (has_temperature) choice.data.push_back(columns.get(kTemperature));
  const bool timed = !imu.rate_hz || columns.find(log::kTimeColumn);
  if (timed) log::add_stamps(choice, columns.get(log::kTimeColumn));

  bool is_decimated = false;
  log::Table table = file.read(choice, notes, is_decimated);
  if (is_decimated)
    text::fail(
        file.name(),
        "its rows cover less than the time between them: the recorder left out samples, and navigation from the rest would be wrong; take a stream that has them all");
  if (has_temperature) samples.temperature = std::move(table.numbers.back());
  constexpr std::size_t kFewest = 2;
  if (table.rows < kFewest)
    text::fail(file.name(), fmt::format("has {} rows, expected 2 or more IMU samples", table.rows));
  samples.stamps = sample_stamps(file, table, imu, timed);
  constexpr std::size_t kFirstForce = 3;
  for (std::size_t row = 0; row < table.rows; ++row)
    samples.values.push_back({.angle = earth::array(turned(imu, table, 0, row)),
                              .velocity = earth::array(turned(imu, table, kFirstForce, row))});
  return samples;
}

}  // namespace gyrobudget::inline v0::files

// SPDX-License-Identifier: MIT
#include "message_types.h"

#include <fmt/format.h>

#include <utility>

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::string_view kXyz = "xyz";

/// Puts a type together, member by member.
class TypeBuilder {
 public:
  explicit TypeBuilder(std::string name, StreamKind kind = StreamKind::other, std::string md5sum = {}) {
    type_.name = std::move(name);
    type_.kind = kind;
    type_.md5sum = std::move(md5sum);
  }

  TypeBuilder& number(std::string name, std::string unit = {}, Primitive primitive = Primitive::f64) {
    type_.members.push_back({std::move(name), std::move(unit), primitive, mark_});
    return *this;
  }
  TypeBuilder& vector(const std::string& name, const std::string& unit, std::string_view parts = kXyz) {
    for (const char part : parts) number(fmt::format("{}.{}", name, part), unit);
    return *this;
  }
  /// A matrix, of which the diagonal is offered. @param units  of its numbers, a row each
  TypeBuilder& covariance(const std::string& name, const std::vector<std::string>& units) {
    const std::size_t rows = units.size();
    for (std::size_t i = 0; i < rows * rows; ++i)
      number(i % (rows + 1) == 0 ? fmt::format("{}[{}]", name, i) : std::string(), units[i / rows]);
    return *this;
  }
  TypeBuilder& covariance(const std::string& name, const std::string& unit) {
    return covariance(name, std::vector<std::string>(3, unit));
  }
  /// What follows, up to end_mark(), is absent where a member, that many places on, holds `absent`.
  TypeBuilder& mark(std::ptrdiff_t places_on, double absent, std::string words) {
    const auto member = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(type_.members.size()) + places_on);
    type_.marks.push_back({member, absent, std::move(words)});
    mark_ = type_.marks.size();
    return *this;
  }
  TypeBuilder& end_mark() {
    mark_ = 0;
    return *this;
  }
  TypeBuilder& goes_on() {
    type_.goes_on = true;
    return *this;
  }
  MessageType done() { return std::move(type_); }

 private:
  MessageType type_;
  std::size_t mark_ = 0;
};

MessageType imu() {
  TypeBuilder imu("sensor_msgs/Imu", StreamKind::imu, "6a62c6daae103f4ff57a132d6f95cec2");
  const auto part = [&](const std::string& name, const std::string& unit, std::string_view parts) {
    const auto covariance = static_cast<std::ptrdiff_t>(parts.size());
    imu.mark(covariance, -1, fmt::format("{}_covariance[0] is -1", name)).vector(name, unit, parts).end_mark();
  };
  part("orientation", "", "xyzw");
  imu.covariance("orientation_covariance", "rad^2");
  part("angular_velocity", "rad/s", kXyz);
  imu.covariance("angular_velocity_covariance", "rad^2/s^2");
  part("linear_acceleration", "m/s^2", kXyz);
  imu.covariance("linear_acceleration_covariance", "m^2/s^4");
  return imu.done();
}

MessageType nav_sat_fix() {
  constexpr std::ptrdiff_t kStatus = -2, kCovarianceType = 9;  // from where their marks begin
  return TypeBuilder("sensor_msgs/NavSatFix", StreamKind::gnss, "2d3a8cd499b9b4a0249fb98fd05cfa48")
      .number("status.status", "", Primitive::i8)
      .number("status.service", "", Primitive::u16)
      .mark(kStatus, -1, "status.status is -1, no fix")
      .number("latitude", "deg")
      .number("longitude", "deg")
      .number("altitude", "m")
      .mark(kCovarianceType, 0, "position_covariance_type is 0, unknown")
      .covariance("position_covariance", "m^2")
      .end_mark()
      .number("position_covariance_type", "", Primitive::u8)
      .done();
}

std::vector<MessageType> all_types() {
  std::vector<MessageType> types{imu(), nav_sat_fix()};
  types.push_back(TypeBuilder("sensor_msgs/MagneticField", StreamKind::magnetometer, "2f3b0b43eed0c9501de0fa3ff89a45aa")
                      .vector("magnetic_field", "T")
                      .covariance("magnetic_field_covariance", "T^2")
                      .done());
  types.push_back(
      TypeBuilder("sensor_msgs/FluidPressure").number("fluid_pressure", "Pa").number("variance", "Pa^2").done());
  types.push_back(
      TypeBuilder("sensor_msgs/Temperature").number("temperature", "degC").number("variance", "K^2").done());
  types.push_back(TypeBuilder("sensor_msgs/TimeReference")
                      .number("time_ref.sec", "s", Primitive::u32)
                      .number("time_ref.nanosec", "ns", Primitive::u32)
                      .goes_on()
                      .done());
  types.push_back(TypeBuilder("geometry_msgs/Vector3Stamped").vector("vector", "").done());
  types.push_back(
      TypeBuilder("geometry_msgs/TwistStamped").vector("twist.linear", "m/s").vector("twist.angular", "rad/s").done());
  types.push_back(
      TypeBuilder("geometry_msgs/TwistWithCovarianceStamped")
          .vector("twist.twist.linear", "m/s")
          .vector("twist.twist.angular", "rad/s")
          .covariance("twist.covariance", {"m^2/s^2", "m^2/s^2", "m^2/s^2", "rad^2/s^2", "rad^2/s^2", "rad^2/s^2"})
          .done());
  types.push_back(TypeBuilder("geometry_msgs/AccelStamped")
                      .vector("accel.linear", "m/s^2")
                      .vector("accel.angular", "rad/s^2")
                      .done());
  types.push_back(TypeBuilder("geometry_msgs/PoseStamped")
                      .vector("pose.position", "m")
                      .vector("pose.orientation", "", "xyzw")
                      .done());
  return types;
}

/// Whether a name of ROS 1 is the recorded one, which ROS 2 gives one more part: "sensor_msgs/msg/Imu".
bool is_named(std::string_view name, std::string_view recorded) {
  constexpr std::string_view kPart = "/msg";
  if (name == recorded) return true;
  const std::size_t slash = name.find('/');
  return recorded.size() == name.size() + kPart.size() && recorded.substr(0, slash) == name.substr(0, slash) &&
         recorded.substr(slash, kPart.size()) == kPart && recorded.ends_with(name.substr(slash));
}

}  // namespace

const MessageType* message_type(std::string_view recorded) {
  static const std::vector<MessageType> kTypes = all_types();
  for (const MessageType& type : kTypes) {
    if (is_named(type.name, recorded)) return &type;
  }
  return nullptr;
}

}  // namespace gyrobudget::inline v0::log

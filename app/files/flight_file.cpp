// SPDX-License-Identifier: MIT
#include "flight_file.h"

#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <stdexcept>
#include <vector>

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

// The columns of a flight: each point adds to them in one order, so that names and values stand together.
class Columns {
 public:
  void begin() { next_ = 0; }
  void add(const std::string& name, const char* unit, double value) {
    if (next_ == all_.size()) all_.push_back({name, unit, {}});
    all_[next_++].values.push_back(value);
  }
  void add(const std::string& name, std::initializer_list<const char*> parts, const char* unit, const Vector3d& v) {
    Eigen::Index i = 0;
    for (const char* part : parts) add(name + part, unit, v[i++]);
  }
  [[nodiscard]] const std::vector<log::LogColumn>& all() const { return all_; }

 private:
  std::vector<log::LogColumn> all_;
  std::size_t next_ = 0;
};

struct Axes {
  earth::LocalFrame enu, launch;
};

void add_pose(Columns& c, const earth::Pose& truth, const Axes& axes) {
  const earth::Geodetic place = earth::to_geodetic(truth.p_eb_e);
  const Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
  Quaterniond q_nb = Quaterniond(C_en).conjugate() * truth.q_eb;
  if (q_nb.w() < 0) q_nb.coeffs() = -q_nb.coeffs();
  c.add("latitude", "deg", place.latitude);
  c.add("longitude", "deg", place.longitude);
  c.add("height", "m", place.height);
  c.add("velocity_", {"north", "east", "down"}, "m/s", C_en.transpose() * truth.v_eb_e);
  c.add("q_w", "1", q_nb.w());
  c.add("q_", {"x", "y", "z"}, "1", q_nb.vec());
  c.add("", {"downrange", "crossrange", "up"}, "m", axes.launch.from_ecef(truth.p_eb_e));
  const Vector3d nose = axes.enu.C_el().transpose() * (truth.q_eb * Vector3d::UnitX());
  c.add("nose_azimuth", "deg", std::atan2(nose.x(), nose.y()));
  c.add("nose_elevation", "deg", std::asin(std::clamp(nose.z(), -1.0, 1.0)));
}

void add_errors(Columns& c, const flight::FlightPoint& p, const Axes& axes) {
  const Matrix3d C = axes.enu.C_el().transpose();
  const auto parts = {"east", "north", "up"};
  c.add("position_error_", parts, "m", C * (p.truth.p_eb_e - p.seen.p_eb_e));
  c.add("velocity_error_", parts, "m/s", C * (p.truth.v_eb_e - p.seen.v_eb_e));
  c.add("attitude_error_", parts, "deg", C * earth::log_rotation(p.truth.q_eb * p.seen.q_eb.conjugate()));
}

void add_vehicle(Columns& c, const flight::FlightPoint& p) {
  c.add("nozzle_pitch", "deg", p.deflection[0]);
  c.add("nozzle_yaw", "deg", p.deflection[1]);
  c.add("command_pitch", "deg", p.command.pitch);
  c.add("command_yaw", "deg", p.command.yaw);
  c.add("mach", "1", p.flow.mach);
  c.add("dynamic_pressure", "Pa", p.flow.dynamic_pressure);
  c.add("angle_of_attack", "deg", p.flow.angle_of_attack);
  c.add("airspeed", "m/s", p.flow.speed);
  c.add("thrust", "N", p.flow.thrust);
}

}  // namespace

void write_flight(const std::string& path, const flight::FlightRecord& record, const earth::Geodetic& site,
                  double azimuth, const std::string& comment) {
  if (record.points.size() < 2)
    throw std::invalid_argument(
        fmt::format("a flight of {} points cannot be written, expected 2 or more", record.points.size()));
  const double interval = record.points[1].t - record.points[0].t;
  const Axes axes{earth::LocalFrame::east_north_up(site), earth::LocalFrame::launch_plane(site, azimuth)};
  Columns columns;
  std::size_t k = 0;
  for (const flight::FlightPoint& p : record.points) {
    constexpr double kOnGrid = 1e-6;
    if (std::abs(p.t - static_cast<double>(k++) * interval) > kOnGrid * interval) break;
    columns.begin();
    add_pose(columns, p.truth, axes);
    add_errors(columns, p, axes);
    add_vehicle(columns, p);
  }
  log::write_log(path, columns.all(), 1 / interval, comment);
}

}  // namespace gyrobudget::inline v0::files

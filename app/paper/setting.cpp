// SPDX-License-Identifier: MIT
#include "setting.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/vector.h"
#include "gyrobudget/vehicle/flight/point_mass.h"

#include <cmath>

namespace gyrobudget::inline v0::paper {

using Eigen::Vector3d;
using flight::FlightRecord;
using flight::Plan;
using flight::RateFeedback;

namespace {

class WrongGyros {
 public:
  WrongGyros(const PaperSetting& setting, const WrongPitch& wrong)
      : strapdown_(start(pose_on_pad(setting.plan.flight), {0, wrong.angle, 0}), setting.strapdown),
        rate_(0, wrong.rate, 0) {}
  void step(const noise::ImuIncrement& exact, double dt) {
    sensed_ = exact;
    earth::vector(sensed_.angle) += rate_ * dt;
    strapdown_.step(sensed_, dt);
  }
  [[nodiscard]] const earth::Pose& state() const { return strapdown_.state(); }
  [[nodiscard]] const noise::ImuIncrement& sensed() const { return sensed_; }

 private:
  static earth::Pose start(const earth::Pose& pose, const Vector3d& angle) {
    return {.p_eb_e = pose.p_eb_e, .v_eb_e = pose.v_eb_e, .q_eb = pose.q_eb * earth::exp_rotation(angle)};
  }
  navigation::Strapdown strapdown_;
  Vector3d rate_;
  noise::ImuIncrement sensed_;
};

}  // namespace

bool noisy(const noise::ErrorModel& gyro) { return !gyro.triad_processes().empty() || gyro.turn_on_bias; }

Plan prompt_plan() {
  Plan plan;
  plan.flight.vehicle = flight::vlm1_paper();
  return plan;
}
Plan lagging(Plan plan) {
  plan.control.feedback = RateFeedback::rate;
  return plan;
}
Plan towards(Plan plan, double azimuth) {
  plan.control.azimuth = plan.flight.azimuth = azimuth;
  return plan;
}
double lag_of(const Plan& plan) { return 2 * plan.control.damping / plan.control.frequency; }

const Vector3d& end_of(const FlightRecord& record) { return record.end.truth.p_eb_e; }
double distance(const FlightRecord& a, const FlightRecord& b) { return (end_of(a) - end_of(b)).norm(); }

Vector3d exact_end(const Plan& plan) {
  const flight::Vehicle& vehicle = plan.flight.vehicle;
  const flight::AttitudeControl program(vehicle, plan.flight.world.site, plan.control);
  const auto end = fly_point_mass(plan.flight, program).end;
  const double ahead = vehicle.imu_station - burn_state(vehicle, end.t).centre_of_mass;
  return end.truth.p_eb_e + end.truth.q_eb * Vector3d(ahead, 0, 0);
}

Vector3d body_turn(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  return earth::log_rotation(from.conjugate() * to);
}

closed_loop::Study fly_many(const PaperSetting& setting, const noise::ErrorModel& gyro, int runs, std::uint64_t seed) {
  navigation::Scenario scenario;
  scenario.sensor.gyro = gyro;
  scenario.azimuth = setting.plan.control.azimuth;
  scenario.filter.strapdown = setting.strapdown;
  return closed_loop::study(setting.plan, {}, scenario, {.runs = runs, .seed = seed, .margins = false});
}

double rms_distance(const closed_loop::Study& many, const FlightRecord& reference) {
  const Vector3d apart = many.C_launch.transpose() * (end_of(many.nominal) - end_of(reference));
  double square = 0;
  for (const auto& o : many.sensors.outcomes)
    if (o.counts()) square += (apart + o.position).squaredNorm() / many.sensors.complete();
  return std::sqrt(square);
}

FlightRecord fly_wrong(const PaperSetting& setting, const WrongPitch& wrong) {
  WrongGyros gyros(setting, wrong);
  return fly(setting.plan, setting.plan.flight, {}, gyros);
}

Vector3d expected_place(const PaperSetting& setting, const closed_loop::TiltResponse& reference) {
  const Plan& plan = setting.plan;
  const double lag = plan.control.feedback == RateFeedback::rate ? lag_of(plan) : 0;
  const double turn = setting.strapdown.earth_rate_in_attitude ? 0 : earth::wgs84::kEarthRate;
  return reference.position([&](double t) -> Vector3d {
    return -lag * plan.control.pitch.at(t).first * reference.pitch_axis(t) - Vector3d(0, 0, turn * t);
  });
}

}  // namespace gyrobudget::inline v0::paper

// SPDX-License-Identifier: MIT
// Scenes that fly.
#include "gyrobudget/app/files/flight_file.h"
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/trajectory_file.h"

#include <cmath>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using earth::kDegree;
using text::InputError;

const std::string kVehicles = GYROBUDGET_EXAMPLES "/vehicles/";

class FlightSection : public TemporaryFolder {
 protected:
  [[nodiscard]] files::SceneFile read(const std::string& flight) const {
    return files::read_scene(file("scene.yaml", "site: alcantara\nazimuth: 80 deg\nflight:\n" + flight));
  }
  [[nodiscard]] std::string message(const std::string& flight) const {
    return message_of<InputError>([&] { (void)read(flight); });
  }
  [[nodiscard]] static std::string vehicle() { return "  vehicle: " + kVehicles + "vlm1.yaml\n"; }
};

TEST_F(FlightSection, TheVehicleAloneIsAFlightOfDefaults) {
  const files::SceneFile scene = read(vehicle());
  ASSERT_TRUE(scene.flight);
  const flight::Plan& plan = scene.flight->plan;
  EXPECT_EQ(plan.flight.vehicle.lift_off_mass, 28000);
  EXPECT_TRUE(plan.flight.vehicle.bending);
  ASSERT_EQ(plan.control.notches.size(), 1U);  // on the bending mode
  EXPECT_EQ(plan.control.notches[0].frequency(0), 6);
  EXPECT_DOUBLE_EQ(plan.control.azimuth, 80 * kDegree);
  EXPECT_DOUBLE_EQ(plan.flight.azimuth, 80 * kDegree);
  EXPECT_DOUBLE_EQ(plan.flight.pitch, 90 * kDegree);
  EXPECT_EQ(plan.flight.world.site.latitude, scene.scenario.site->latitude);
  EXPECT_FALSE(plan.guidance);
  EXPECT_TRUE(scene.flight->dispersion.none());
  EXPECT_TRUE(scene.trajectory.empty());
  EXPECT_GT(scene.flight->vehicle.numbers.size(), 20U);
}

TEST_F(FlightSection, EveryKeyIsTaken) {
  const files::SceneFile scene = read(vehicle() + R"(
  bending: no
  pitch: [[0 s, 80 deg], [50 s, 60 deg]]
  control: {frequency: 3 rad/s, damping: 0.8, feedback: rate, least_thrust: 10 %, rate: 50 Hz,
            notch: {frequency: 7 Hz, depth: 0.1, width: 0.6}}
  guidance: {frequency: 0.3 rad/s, damping: 1.1, angle_limit: 4 deg}
  atmosphere: no
  wind: {east: 5 m/s, north: -3 m/s, shear_east: [[0 km, 0 m/s], [10 km, 30 m/s]], shear_north: 2 m/s,
         gust: {height: 9 km, half_width: 300 m, north: 9 m/s, up: 1 m/s}}
  dispersion: {impulse: 0.5 %, burn_time: 1 %, mass: 0.2 %, inertia: 3 %, axial_drag: 10 %, normal_force: 8 %,
               pressure_ahead: 10 cm, centre_of_mass: 5 cm, thrust_misalignment: 0.05 deg, wind: 4 m/s, gust: 7 %}
  faults: {thrust_cut: 70 s, nozzle_stuck: {at: 60 s, pitch: 1 deg, yaw: 2 deg}, dead_gyro: {axis: z, at: 5 s},
           thrust_misalignment: {pitch: 0.1 deg, yaw: 0.2 deg}, navigation_delay: 100 ms}
  integrator: {method: fehlberg78, step: 5 ms, tolerance: 1e-8}
until: 40 s
)");
  const flight::Plan& plan = scene.flight.value().plan;
  const flight::Flight& f = plan.flight;
  EXPECT_FALSE(f.vehicle.bending);
  EXPECT_DOUBLE_EQ(f.pitch, 80 * kDegree);
  EXPECT_NEAR(plan.control.pitch(25), 70 * kDegree, 1e-12);
  EXPECT_EQ(plan.control.frequency, 3);
  EXPECT_EQ(plan.control.damping, 0.8);
  EXPECT_EQ(plan.control.feedback, flight::RateFeedback::rate);
  EXPECT_DOUBLE_EQ(plan.control.least_thrust, 0.1);
  EXPECT_DOUBLE_EQ(f.period, 0.02);
  ASSERT_EQ(plan.control.notches.size(), 1U);
  EXPECT_EQ(plan.control.notches[0].frequency(0.5), 7);
  EXPECT_EQ(plan.control.notches[0].depth, 0.1);
  EXPECT_EQ(plan.control.notches[0].width, 0.6);
  EXPECT_EQ(plan.guidance.value().frequency, 0.3);
  EXPECT_EQ(plan.guidance->damping, 1.1);
  EXPECT_DOUBLE_EQ(plan.guidance->angle_limit, 4 * kDegree);
  EXPECT_FALSE(f.world.atmosphere);
  EXPECT_EQ(f.world.wind.steady, Eigen::Vector3d(5, -3, 0));
  EXPECT_DOUBLE_EQ(f.world.wind.east(5000), 15);
  EXPECT_EQ(f.world.wind.north(100), 2);
  EXPECT_EQ(f.world.wind.gust.peak, Eigen::Vector3d(0, 9, 1));
  EXPECT_EQ(f.world.wind.gust.half_width, 300);
  const flight::Dispersion& d = scene.flight->dispersion;
  EXPECT_DOUBLE_EQ(d.impulse, 0.005);
  EXPECT_DOUBLE_EQ(d.burn_time, 0.01);
  EXPECT_DOUBLE_EQ(d.mass, 0.002);
  EXPECT_DOUBLE_EQ(d.inertia, 0.03);
  EXPECT_DOUBLE_EQ(d.axial_drag, 0.1);
  EXPECT_DOUBLE_EQ(d.normal_force, 0.08);
  EXPECT_DOUBLE_EQ(d.pressure_ahead, 0.1);
  EXPECT_DOUBLE_EQ(d.centre_of_mass, 0.05);
  EXPECT_DOUBLE_EQ(d.thrust_misalignment, 0.05 * kDegree);
  EXPECT_EQ(d.wind, 4);
  EXPECT_DOUBLE_EQ(d.gust, 0.07);
  EXPECT_EQ(f.faults.thrust_cut_at, 70);
  EXPECT_EQ(f.faults.nozzle_stuck_at, 60);
  EXPECT_DOUBLE_EQ(f.faults.nozzle_stuck_offset.y(), 2 * kDegree);
  EXPECT_DOUBLE_EQ(f.faults.thrust_misalignment.x(), 0.1 * kDegree);
  EXPECT_EQ(plan.navigator_faults.dead_gyro, 2);
  EXPECT_EQ(plan.navigator_faults.dead_gyro_at, 5);
  EXPECT_DOUBLE_EQ(plan.navigator_faults.delay, 0.1);
  EXPECT_EQ(f.integration.method, flight::Method::fehlberg78);
  EXPECT_DOUBLE_EQ(f.integration.step, 0.005);
  EXPECT_EQ(f.integration.tolerance, 1e-8);
  EXPECT_EQ(f.duration, 40);
}

TEST_F(FlightSection, WordsStandForGroups) {
  const files::SceneFile scene = read(vehicle() + "  guidance: trajectory\n  integrator: exact\n" +
                                      "  control: {notch: none}\n  faults: {nozzle_stuck: 10 s, dead_gyro: x}\n");
  const flight::Plan& plan = scene.flight.value().plan;
  EXPECT_TRUE(plan.guidance);
  EXPECT_TRUE(plan.control.notches.empty());
  EXPECT_EQ(plan.flight.integration.method, flight::Method::exact);
  EXPECT_EQ(plan.flight.faults.nozzle_stuck_at, 10);
  EXPECT_EQ(plan.navigator_faults.dead_gyro, 0);
}

TEST_F(FlightSection, WhatIsWrongHasItsPlaceAndAMend) {
  const auto expect = [&](const std::string& flight, const std::string& place, const std::string& words) {
    const std::string found = message(flight);
    EXPECT_CONTAINS(found, "scene.yaml:" + place) << flight;
    EXPECT_CONTAINS(found, words) << flight;
  };
  expect("  bending: no\n", "4:", "vehicle file");
  expect("  vehicle: nowhere.yaml\n", "4:12: vehicle:", "nowhere.yaml");
  expect(vehicle() + "  contrl: {}\n", "5:3:", "did you mean");
  expect(vehicle() + "  control: {frequency: 2.5 Hz}\n", "5:", "rad/s");
  expect(vehicle() + "  pitch: [[8 s, 90 deg], [8 s, 50 deg]]\n", "5:", "ascend");
  expect(vehicle() + "  pitch: [8 s, 90 deg]\n", "5:", "pairs, as in [[8 s, 90 deg]");
  expect(vehicle() + "  dispersion: {mass: 10 %}\n", "5:", "propellant");
  expect(vehicle() + "  dispersion: {mass: -1 %}\n", "5:", "mass");
  expect(vehicle() + "  faults: {dead_gyro: {at: 5 s}}\n", "5:", "axis");
  expect(vehicle() + "  faults: {nozzle_stuck: {at: 1 s, pitch: 10 deg}}\n", "5:", "limit of 3 deg");
  expect(vehicle() + "  wind: {gust: {height: 1 km}}\n", "5:", "half_width");
  expect(vehicle() + "  integrator: euler\n", "5:", "runge_kutta4");
  expect(vehicle() + "  control: {notch: {frequency: 70 Hz}}\n", "4:", "half the control rate");
  expect("  vehicle: " + kVehicles + "vlm1-paper.yaml\n  bending: yes\n", "5:", "no bending mode");
  expect(vehicle() + "trajectory: ascent\n", "4:", "one of them");
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)files::read_scene(file("scene.yaml", "flight:\n" + vehicle())); }),
                  "site");
}

TEST_F(FlightSection, ItsNominalFlightIsATrajectory) {
  const files::SceneFile scene = read(vehicle() + "until: 20 s\n");
  const earth::Trajectory trajectory = files::planned_trajectory(scene);
  EXPECT_DOUBLE_EQ(trajectory.duration(), 20);
  const flight::FlightRecord record = fly_nominal(scene.flight->plan);
  EXPECT_LT((trajectory.at(20).pose.p_eb_e - record.end.truth.p_eb_e).norm(), 1e-6);
  EXPECT_LT((trajectory.at(20).pose.v_eb_e - record.end.truth.v_eb_e).norm(), 1e-3);
  const std::string short_one =
      message_of<InputError>([&] { (void)files::planned_trajectory(read(vehicle() + "until: 0.5 s\n")); });
  EXPECT_CONTAINS(short_one, "too short");
  EXPECT_CONTAINS(
      message_of<InputError>([&] {
        (void)files::planned_trajectory(files::read_scene(file(
            "scene.yaml",
            "site: alcantara\nimu: {file: imu.csv}\nalignment: {position_sigma: 1 m, velocity_sigma: 1 m/s, attitude: {heading: 0 deg}, level_sigma: 1 deg, heading_sigma: 1 deg}\n")));
      }),
      "found neither a trajectory nor a flight");
}

TEST_F(FlightSection, AFlightWrittenReadsAsATrajectory) {
  const files::SceneFile scene = read(vehicle() + "until: 10 s\n");
  const flight::Plan& plan = scene.flight.value().plan;
  const flight::FlightRecord record = fly_nominal(plan);
  files::write_flight(path("flight.csv"), record, plan.flight.world.site, plan.control.azimuth, "a test");
  const earth::Trajectory back = files::read_trajectory(path("flight.csv"));
  EXPECT_NEAR(back.duration(), 10, 1e-9);
  EXPECT_LT((back.at(7).pose.p_eb_e - record.points[700].truth.p_eb_e).norm(), 1e-6);
  EXPECT_LT(back.at(7).pose.q_eb.angularDistance(record.points[700].truth.q_eb), 1e-7);
  const std::string head = content(path("flight.csv")).substr(0, 2000);
  for (const char* column :
       {"nose_elevation (deg)", "position_error_east (m)", "nozzle_pitch (deg)", "dynamic_pressure (Pa)", "thrust (N)"})
    EXPECT_CONTAINS(head, column);
}

}  // namespace
}  // namespace gyrobudget::app_tests

// SPDX-License-Identifier: MIT
// Error against run time of the flight: integrators over the stiffness of the actuator, steps on the real
// scene, what each part costs that a scene may leave out, and flights a second. Alternatives take turns in
// one run; each counts with its fastest. Usage: flight_benchmark [stiffness|steps|parts|speed|loop ...]
#include "gyrobudget/estimation/budget/scene.h"
#include "gyrobudget/estimation/closed_loop/inertial_navigator.h"
#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/flight/fly.h"
#include "gyrobudget/vehicle/flight/plan.h"
#include "gyrobudget/vehicle/flight/point_mass.h"

#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace {

using namespace gyrobudget;
using namespace gyrobudget::flight;
using Eigen::Vector3d;

template <class F>
double seconds(const F& f) {
  const auto before = std::chrono::steady_clock::now();
  f();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

struct Flown {
  FlightRecord record;
  double seconds = std::numeric_limits<double>::infinity();
};

AttitudeControl control_of(const Flight& plan) {
  AttitudeControl::Options options;
  if (plan.vehicle.bending) options.notches = {Notch{plan.vehicle.bending->frequency}};
  return {plan.vehicle, plan.world.site, options};
}

void fly_again(const Flight& plan, Flown& flown) {
  AttitudeControl control = control_of(plan);
  PerfectNavigator navigator;
  const double spent = seconds([&] { flown.record = fly(plan, control, navigator); });
  flown.seconds = std::min(flown.seconds, spent);
}

double apart(const FlightRecord& a, const FlightRecord& b) { return (a.end.truth.p_eb_e - b.end.truth.p_eb_e).norm(); }

/// One second from 20 s after lift-off on, open loop, the nozzle moved each period: time for 83 s and error of
/// the angular rate, against RODAS at 1e-11.
struct Burst {
  BodyState end;
  double seconds = 0;
  std::int64_t evaluations = 0;
};
Burst burst(double factor, const Integration& integration, int periods) {
  Vehicle v = vlm1();
  v.actuator.frequency *= factor;
  v.actuator.rate_limit = 100;
  v.actuator.delay = 0;
  BodyState start = on_pad(earth::alcantara().position, 90 * earth::kDegree, 85 * earth::kDegree);
  start.t = 21;
  start.p_ib_i += 1000 * start.p_ib_i.normalized();
  start.v_ib_i += start.q_ib * Vector3d(110, 0, 0);
  Body body(v, {}, start, integration);
  Burst result;
  result.seconds = seconds([&] {
    for (int k = 0; k < periods; ++k) {
      const Command command{1e-3 * (k * 7 % 5 - 2), 1e-3 * (k * 3 % 4 - 1.5), 0};
      if (!body.advance(command, 21 + (k + 1) * 0.01)) break;
    }
  });
  result.end = body.state();
  result.evaluations = body.work().evaluations;
  return result;
}

void stiffness() {
  fmt::print(
      "\nActuator faster by a factor: seconds of run time for 83 s of flight, error of the angular rate [rad/s] after the burst\n");
  struct Row {
    const char* name;
    Integration integration;
    bool steps_with_factor;
  };
  const std::vector<Row> rows{{"exact, 10 ms", {Method::exact, 0.01, 0}, false},
                              {"exact, 2 ms", {Method::exact, 0.002, 0}, false},
                              {"runge_kutta4", {Method::runge_kutta4, 0.01, 0}, true},
                              {"dormand_prince 1e-7", {Method::dormand_prince, 0.01, 1e-7}, false},
                              {"fehlberg78 1e-7", {Method::fehlberg78, 0.01, 1e-7}, false},
                              {"rosenbrock 1e-7", {Method::rosenbrock, 0.01, 1e-7}, false}};
  fmt::print("{:>22}", "factor");
  for (const Row& row : rows) fmt::print("{:>22}", row.name);
  fmt::print("\n");
  for (const double factor : {1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6}) {
    fmt::print("{:>22}", factor);
    // Explicit methods crawl: a shorter burst measures them as well.
    const int periods = factor >= 1e6 ? 2 : factor >= 1e5 ? 10 : 100;
    const BodyState truth = burst(factor, {Method::rosenbrock, 0.01, 1e-11}, periods).end;
    for (const Row& row : rows) {
      Integration integration = row.integration;
      if (row.steps_with_factor) integration.step = std::min(0.01, 0.05 / factor);  // w h = 1.26
      Burst best = burst(factor, integration, periods);
      if (best.seconds < 0.1)
        for (int k = 0; k < 3; ++k) best.seconds = std::min(best.seconds, burst(factor, integration, periods).seconds);
      fmt::print("{:>12.3g} {:>9.1e}", best.seconds * 8300 / periods, (best.end.w_ib_b - truth.w_ib_b).norm());
    }
    fmt::print("\n");
  }
}

void steps() {
  for (const bool bends : {false, true}) {
    Flight plan;
    if (bends) plan.vehicle.bending = Bending{};
    fmt::print("\nThe flight of 83 s{}: error at its end against fehlberg78 at 1e-13\n", bends ? ", bending" : "");
    plan.integration = {Method::fehlberg78, 0.01, 1e-13};
    Flown truth;
    fly_again(plan, truth);
    struct Row {
      Integration integration;
      Flown flown;
    };
    std::vector<Row> rows;
    for (const double step : {0.01, 0.005, 0.0025}) {
      rows.push_back({{Method::exact, step, 0}, {}});
      rows.push_back({{Method::runge_kutta4, step, 0}, {}});
    }
    for (const double tolerance : {1e-7, 1e-9, 1e-11, 1e-13}) {
      rows.push_back({{Method::dormand_prince, 0.01, tolerance}, {}});
      rows.push_back({{Method::fehlberg78, 0.01, tolerance}, {}});
    }
    for (const double tolerance : {1e-7, 1e-9}) rows.push_back({{Method::rosenbrock, 0.01, tolerance}, {}});
    for (int pass = 0; pass < 3; ++pass)
      for (Row& row : rows) {
        plan.integration = row.integration;
        fly_again(plan, row.flown);
      }
    fmt::print("{:>16} {:>8} {:>10} {:>12} {:>12} {:>12}\n", "method", "step/s", "tolerance", "run time/s",
               "evaluations", "error/m");
    for (const Row& row : rows)
      fmt::print("{:>16} {:>8} {:>10.0e} {:>12.4f} {:>12} {:>12.1e}\n", to_string(row.integration.method),
                 row.integration.step, row.integration.tolerance, row.flown.seconds, row.flown.record.work.evaluations,
                 apart(row.flown.record, truth.record));
  }
}

void parts() {
  fmt::print("\nLeft out of a scene: run time against the whole, and what it moves the end by\n");
  Flight whole;
  whole.vehicle.bending = Bending{};
  whole.world.wind.steady = {0, 5, 0};
  struct Row {
    const char* name;
    Flight plan;
    Flown flown;
  };
  std::vector<Row> rows{{"nothing", whole, {}},       {"bending", whole, {}},
                        {"wind", whole, {}},          {"IMU 9 m off the centre", whole, {}},
                        {"bending, wind", whole, {}}, {"air", whole, {}}};
  rows[1].plan.vehicle.bending.reset();
  rows[2].plan.world.wind = {};
  rows[3].plan.vehicle.imu_station = 7;
  rows[4].plan = rows[1].plan;
  rows[4].plan.world.wind = {};
  rows[5].plan.world.atmosphere = false;
  for (int pass = 0; pass < 5; ++pass)
    for (Row& row : rows) fly_again(row.plan, row.flown);
  for (const Row& row : rows)
    fmt::print("{:>22} {:>8.4f} s {:>6.2f} {:>12.4g} m\n", row.name, row.flown.seconds,
               row.flown.seconds / rows[0].flown.seconds, apart(row.flown.record, rows[0].flown.record));
  const AttitudeControl program = control_of(rows[4].plan);
  Flight at_centre = rows[4].plan;  // both from where the centre of mass begins
  at_centre.vehicle.imu_station = 7;
  Flown centre;
  fly_again(at_centre, centre);
  for (const double step : {0.5, 0.1, 0.01}) {
    Flown point;
    for (int pass = 0; pass < 5; ++pass)
      point.seconds =
          std::min(point.seconds, seconds([&] { point.record = fly_point_mass(at_centre, program, step); }));
    fmt::print("{:>22} {:>8.5f} s {:>6.4f} {:>12.4g} m (against bending, wind)\n",
               fmt::format("attitude, step {}", step), point.seconds, point.seconds / rows[0].flown.seconds,
               apart(point.record, centre.record));
  }
}

void speed() {
  fmt::print("\nClosed-loop flights of 83 s a second on one core, 100 Hz control and navigation\n");
  for (const bool bends : {false, true}) {
    Flight plan;
    if (bends) plan.vehicle.bending = Bending{};
    double perfect = 1e9, strapdown = 1e9, error = 0;
    FlightRecord record;
    for (int pass = 0; pass < 10; ++pass) {
      Flown flown;
      fly_again(plan, flown);
      perfect = std::min(perfect, flown.seconds);
      AttitudeControl control = control_of(plan);
      const earth::Pose pad = pose_on_pad(plan);
      navigation::Strapdown navigator(pad);
      strapdown = std::min(strapdown, seconds([&] { record = fly(plan, control, navigator); }));
      error = (record.end.seen.p_eb_e - record.end.truth.p_eb_e).norm();
    }
    fmt::print("{:>22}: perfect navigator {:.0f}, strapdown {:.0f} (its error {:.1e} m); {} at {} s\n",
               bends ? "bending" : "rigid", 1 / perfect, 1 / strapdown, error, to_string(record.work.method),
               plan.integration.step);
  }
}

// The whole loop: sensors with errors, and the filter with fixes of GNSS.
navigation::Scenario navigation_scene(bool filter) {
  navigation::Scenario scene;
  scene.sensor.gyro.white = 0.15 * earth::kDegree / 60;
  scene.sensor.gyro.bias_instability = 0.7 * earth::kDegree / 3600;
  scene.sensor.gyro.turn_on_bias = 1 * earth::kDegree / 3600;
  scene.sensor.gyro.powered_on_before = 600;
  scene.sensor.accelerometer.emplace();
  scene.sensor.accelerometer->white = 1e-3;
  scene.sensor.accelerometer->turn_on_bias = 1e-3;
  scene.sensor.accelerometer->bias_instability = 1e-4;
  scene.states.flicker_states = 1;
  scene.alignment.level_sigma = scene.alignment.heading_sigma = 1e-3;
  if (!filter) return scene;
  scene.aids.push_back({.name = "gnss.position", .sigma = Vector3d(2, 2, 4)});
  scene.aids.push_back(
      {.name = "gnss.velocity", .kind = navigation::Aid::Kind::velocity, .sigma = Vector3d::Constant(0.1)});
  return scene;
}

void loop() {
  fmt::print("\nFlights of 83 s a second in closed loop, one core, control and navigation at 100 Hz, exact at 10 ms\n");
  flight::Plan plan;
  const auto trajectory = flight::trajectory(fly_nominal(plan));
  plan.flight.record_every = 0;
  for (const bool filter : {false, true}) {
    const navigation::Scenario scenario = navigation_scene(filter);
    const auto scene = budget::budget_scene(scenario, trajectory, {});
    const budget::MonteCarlo::Options options{.filter = scenario.filter};
    const budget::SimulatedScene simulated(scene.timeline, scenario.sensor, scene.initial, scene.C_enu, scene.design,
                                           scene.aids, options);
    double best = std::numeric_limits<double>::infinity(), error = 0;
    int states = 0;
    for (int pass = 0; pass < 10; ++pass)
      best = std::min(best, seconds([&] {
                        closed_loop::InertialNavigator navigator(simulated, static_cast<std::uint64_t>(pass));
                        const FlightRecord record = fly(plan, plan.flight, {}, navigator);
                        error += (record.end.seen.p_eb_e - record.end.truth.p_eb_e).norm() / 10;
                        if (const auto& ekf = navigator.inside().filter()) states = ekf->model().states();
                      }));
    fmt::print("{:>40}: {:.0f} (navigation off by {:.3g} m on average)\n",
               filter ? fmt::format("sensors with errors, EKF of {} states", states)
                      : std::string("sensors with errors, strapdown"),
               1 / best, error);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::pair<std::string_view, void (*)()>> tables{
      {"speed", speed}, {"loop", loop}, {"steps", steps}, {"parts", parts}, {"stiffness", stiffness}};
  for (const auto& [name, run] : tables)
    if (argc == 1 || std::find(argv + 1, argv + argc, name) != argv + argc) run();
}

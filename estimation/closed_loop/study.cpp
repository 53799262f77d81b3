// SPDX-License-Identifier: MIT
#include "study.h"

#include "gyrobudget/estimation/budget/scene_runs.h"
#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "inertial_navigator.h"

namespace gyrobudget::inline v0::closed_loop {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using flight::FlightRecord;
using navigation::CoreMatrix;
using navigation::kCoreStates;

constexpr double kMarginsUntil = 0.2;  // of the mean thrust
constexpr int kMarginPoints = 83;      // along the flight
constexpr std::array kModeFactors{1.0, 0.9, 1.1};

flight::Plan whole_periods(flight::Plan plan) {
  flight::Flight& f = plan.flight;
  const double duration = std::isnan(f.duration) ? f.vehicle.burn_time : f.duration;
  constexpr double kRounding = 1e-9;
  if (f.period > 0 && duration >= f.period) f.duration = f.period * std::floor(duration / f.period * (1 + kRounding));
  return plan;
}

flight::Plan recorded(flight::Plan plan, std::optional<double> rate) {
  constexpr double kMostPeriods = 1e6;
  flight::Flight& f = plan.flight;
  if (rate) f.record_every = static_cast<int>(std::clamp(std::round(1 / (*rate * f.period)), 1.0, kMostPeriods));
  return plan;
}

bool varies(const noise::SensorModel& sensor, const budget::BudgetScene& scene) {
  return !scene.sources.empty() || sensor.accelerometer.has_value();
}

MarginsAt margins_along(const flight::Plan& plan, const FlightRecord& nominal) {
  MarginsAt result;
  flight::AttitudeControlOptions options = plan.control;
  options.period = plan.flight.period;
  const flight::Vehicle& vehicle = plan.flight.vehicle;
  const flight::AttitudeControl control(vehicle, plan.flight.world.site, options);
  const std::size_t every = std::max<std::size_t>(1, nominal.points.size() / kMarginPoints);
  for (std::size_t i = 0; i < nominal.points.size(); i += every) {
    const flight::FlightPoint& p = nominal.points[i];
    // At burnout the flow is that of just before, the control's gain that of after.
    if (p.t >= vehicle.burn_time || p.flow.thrust < kMarginsUntil * vehicle.mean_thrust()) continue;
    result.until = p.t;
    for (const double factor : kModeFactors) {
      if (factor != 1 && !vehicle.bending) continue;
      result.points.push_back(margins(vehicle, control, {p.t, p.flow.thrust, p.flow.dynamic_pressure, factor}));
    }
  }
  return result;
}

// Truth less estimate, axes of e.
template <class State>
Eigen::Matrix<double, kCoreStates, 1> error(const earth::Pose& truth, const State& estimate) {
  Eigen::Matrix<double, kCoreStates, 1> e;
  e << truth.p_eb_e - estimate.p_eb_e, truth.v_eb_e - estimate.v_eb_e,
      earth::log_rotation(truth.q_eb * estimate.q_eb.conjugate());
  return e;
}

// Flights of the plan, with what they share.
class Flyer {
 public:
  Flyer(const flight::Plan& plan, const flight::Dispersion& dispersion, const FlightRecord& nominal,
        const budget::SimulatedScene& scene, const Matrix3d& C_launch, std::uint64_t seed)
      : plan_(plan),
        dispersion_(dispersion),
        nominal_(nominal),
        reference_(flight::waypoints(nominal)),
        scene_(scene),
        C_launch_(C_launch),
        seed_(seed) {}

  // With the sensors of a run; none where they found no heading on the pad.
  [[nodiscard]] std::optional<FlightRecord> with_sensors(const flight::Flight& flown, std::uint64_t run) const {
    InertialNavigator navigator(scene_, run);
    if (!navigator.inside().aligned()) return std::nullopt;
    return fly(plan_, flown, reference_, navigator);
  }

  [[nodiscard]] Outcome outcome(bool sensors, bool vehicle, std::uint64_t run) const {
    flight::Flight flown = vehicle ? disperse(plan_.flight, dispersion_, seed_, run) : plan_.flight;
    flown.duration = plan_.flight.duration;
    flown.record_every = 0;
    if (sensors) {
      InertialNavigator navigator(scene_, run);
      if (!navigator.inside().aligned()) return Outcome{.aligned = false};
      const FlightRecord record = fly(plan_, flown, reference_, navigator);
      Outcome o = outcome_of(record);
      // Not what the controller was told, which may be late.
      if (o.counts()) o.navigation = error(record.end.truth, navigator.state());
      o.fixes = navigator.inside().fixes();
      return o;
    }
    flight::PerfectNavigator navigator;
    return outcome_of(fly(plan_, flown, reference_, navigator));
  }

 private:
  [[nodiscard]] Outcome outcome_of(const FlightRecord& record) const {
    const flight::FlightPoint &end = record.end, &planned = nominal_.end;
    Outcome o{.ended = record.ended, .t = end.t};
    const auto local = [&](const Vector3d& e) -> Vector3d { return C_launch_.transpose() * e; };
    const auto turn = [](const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
      return earth::log_rotation(a * b.conjugate());
    };
    o.position = local(end.truth.p_eb_e - planned.truth.p_eb_e);
    o.velocity = local(end.truth.v_eb_e - planned.truth.v_eb_e);
    o.attitude = local(turn(end.truth.q_eb, planned.truth.q_eb));
    o.navigation = error(end.truth, end.seen);
    return o;
  }

  const flight::Plan& plan_;
  const flight::Dispersion& dispersion_;
  const FlightRecord& nominal_;
  std::vector<flight::Waypoint> reference_;
  const budget::SimulatedScene& scene_;
  const Matrix3d& C_launch_;
  std::uint64_t seed_;
};

struct Kind {
  Flights* flights;
  bool sensors, vehicle;
};

// All kinds of one run, run after run, so that what was stopped early has as many of each.
void fly_many(Study& study, const Flyer& flyer, const std::vector<Kind>& kinds, const Options& options) {
  const auto kinds_count = static_cast<int>(kinds.size());
  const int flights = options.runs * kinds_count;
  for (const Kind& kind : kinds) kind.flights->outcomes.resize(static_cast<std::size_t>(options.runs));
  std::vector<char> flown(static_cast<std::size_t>(options.runs), 0);
  std::atomic<bool> stopped = false;
  std::mutex mutex;
  int done = 0;
  tbb::parallel_for(0, options.runs, [&](int run) {
    if (stopped) return;
    const auto r = static_cast<std::size_t>(run);
    for (const Kind& kind : kinds)
      kind.flights->outcomes[r] = flyer.outcome(kind.sensors, kind.vehicle, static_cast<std::uint64_t>(run));
    const std::lock_guard lock(mutex);
    flown[r] = 1;
    done += kinds_count;
    if (options.progress && !options.progress(done, flights)) stopped = true;
  });
  study.runs = static_cast<int>(std::ranges::count(flown, 1));
  study.stopped = stopped;
  for (const Kind& kind : kinds) {
    std::size_t k = 0;
    std::erase_if(kind.flights->outcomes, [&](const Outcome&) { return flown[k++] == 0; });
  }
}

}  // namespace

int Flights::complete() const { return static_cast<int>(std::ranges::count_if(outcomes, &Outcome::counts)); }
int Flights::unaligned() const { return static_cast<int>(std::ranges::count(outcomes, false, &Outcome::aligned)); }
int Flights::lost() const { return static_cast<int>(outcomes.size()) - complete() - unaligned(); }

Flights::Spread Flights::spread(Vector3d Outcome::*member) const {
  Spread result;
  const int n = complete();
  if (n < 2) return result;
  for (const Outcome& o : outcomes)
    if (o.counts()) result.mean += o.*member / n;
  for (const Outcome& o : outcomes) {
    const Vector3d d = o.*member - result.mean;
    if (o.counts()) result.covariance += d * d.transpose() / (n - 1);
  }
  return result;
}

CoreMatrix Flights::navigation_error() const {
  CoreMatrix sum = CoreMatrix::Zero();
  for (const Outcome& o : outcomes)
    if (o.counts()) sum += o.navigation * o.navigation.transpose();
  return sum / std::max(complete(), 1);
}

budget::FixCount Flights::fixes() const {
  budget::FixCount sum;
  for (const Outcome& o : outcomes) sum += o.fixes;
  return sum;
}

bool Study::not_compared() const { return asked > 0 && !too_short() && nominal.ended != flight::Ended::complete; }

bool Study::flew_to_the_end() const {
  return nominal.ended == flight::Ended::complete && flown && flown->ended == flight::Ended::complete;
}

Study study(const flight::Plan& asked, const flight::Dispersion& dispersion, const navigation::Scenario& scenario,
            const Options& options) {
  if (options.runs < 0) throw navigation::SetupError(fmt::format("{} runs, expected none or more", options.runs));
  const flight::Plan plan = recorded(whole_periods(asked), options.record_rate);
  Study result;
  result.seed = options.seed;
  result.asked = options.runs;
  result.azimuth = plan.control.azimuth;
  result.C_enu = earth::LocalFrame::east_north_up(plan.flight.world.site).C_el();
  result.C_launch = earth::LocalFrame::launch_plane(plan.flight.world.site, plan.control.azimuth).C_el();
  result.nominal = fly_nominal(plan);
  if (options.margins) result.margins = margins_along(plan, result.nominal);
  if (!flight::makes_a_trajectory(result.nominal)) return result;
  const auto scene =
      budget::budget_scene(scenario, trajectory(result.nominal), budget::question_of(scenario, plan.flight.period));
  result.no_heading = scene.no_heading;
  result.out_of_range = scene.out_of_range;
  result.left_out = scene.left_out;
  result.aided = scene.design.has_value();
  result.pad = -scene.timeline.start();
  result.budget = budget::error_budget(scene.timeline, scene.sources, scene.design);
  budget::MonteCarlo::Options simulated;
  simulated.seed = options.seed;
  simulated.imu_interval = plan.flight.period;
  simulated = whole_scene(scene, scenario, simulated);
  const budget::SimulatedScene simulation(scene.timeline, scenario.sensor, scene.initial, scene.C_enu, scene.design,
                                          scene.aids, simulated);
  const Flyer flyer(plan, dispersion, result.nominal, simulation, result.C_launch, options.seed);
  result.flown = flyer.with_sensors(plan.flight, 0);
  if (options.runs == 0 || result.nominal.ended != flight::Ended::complete) return result;
  std::vector<Kind> kinds;
  const bool sensors = varies(scenario.sensor, scene), vehicle = !dispersion.none();
  if (sensors) kinds.push_back({&result.sensors, true, false});
  if (vehicle) kinds.push_back({&result.vehicle, false, true});
  if (sensors && vehicle) kinds.push_back({&result.all, true, true});
  fly_many(result, flyer, kinds, options);
  return result;
}

}  // namespace gyrobudget::inline v0::closed_loop

// SPDX-License-Identifier: MIT
#include "body.h"

#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/flight/detail/actuator.h"
#include "gyrobudget/vehicle/flight/detail/dynamics.h"
#include "gyrobudget/vehicle/flight/detail/rosenbrock.h"
#include "gyrobudget/vehicle/flight/detail/square.h"

#include <boost/numeric/odeint/algebra/vector_space_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {

using namespace detail;
namespace odeint = boost::numeric::odeint;
using earth::Inertial;
using earth::wgs84::kEarthRate;

std::string_view to_string(Method method) {
  switch (method) {
    case Method::automatic:
      return "automatic";
    case Method::exact:
      return "exact";
    case Method::runge_kutta4:
      return "runge_kutta4";
    case Method::dormand_prince:
      return "dormand_prince";
    case Method::fehlberg78:
      return "fehlberg78";
    case Method::rosenbrock:
      return "rosenbrock";
  }
  return "unknown";
}

BodyState on_pad(const earth::Geodetic& site, double azimuth, double pitch) {
  BodyState s;
  s.p_ib_i = earth::to_ecef(site);
  s.v_ib_i = Vector3d(0, 0, kEarthRate).cross(s.p_ib_i);
  s.q_ib = Quaterniond(earth::C_e_ned(site.latitude, site.longitude)) * earth::exp_rotation({0, 0, azimuth}) *
           earth::exp_rotation({0, pitch, 0});
  s.w_ib_b = s.q_ib.conjugate() * Vector3d(0, 0, kEarthRate);
  return s;
}

namespace {

constexpr double kInstant = 1e-12;   // [s]; times nearer than this are one
constexpr double kStableStep = 2.0;  // step times eigenvalue an explicit method of order 4 bears with a margin
constexpr double kHopeless = 1e9;    // as error of a step that is no number
constexpr double kLayerSide = 1e-4;  // [m]; nearer to a layer's end, the way of flight tells the layer

/// Steps of fixed or adapted size over a segment, by any method with step(system, x, t, h, out, error).
struct Pace {
  double longest;
  double tolerance;
  double next = 0;  ///< step to begin with, kept from segment to segment
};

/// A method of Odeint behind the signature of Rosenbrock.
template <class Stepper>
struct Explicit {
  Stepper stepper;
  template <class System, class X>
  void step(const System& system, const X& x, double t, double h, const X&, X& out, X& error) {
    stepper.do_step(system, x, t, out, h, error);
  }
};

template <class X>
using Classical = odeint::runge_kutta4<X, double, X, double, odeint::vector_space_algebra>;
/// Odeint keeps the slope at a step's end for the next one, also of a step that was thrown away: give it the
/// slope at the start each time.
template <class X>
struct DormandPrince {
  odeint::runge_kutta_dopri5<X, double, X, double, odeint::vector_space_algebra> stepper;
  X slope, slope_after;
  template <class System>
  void step(const System& system, const X& x, double t, double h, const X&, X& out, X& error) {
    system(x, slope, t);
    stepper.do_step(system, x, slope, t, out, slope_after, h, error);
  }
};
template <class X>
using Fehlberg = Explicit<odeint::runge_kutta_fehlberg78<X, double, X, double, odeint::vector_space_algebra>>;

double equal_step(double length, double longest, int& steps) {
  steps = std::max(1, static_cast<int>(std::ceil(length / longest - 1e-9)));
  return length / steps;
}

/// True where the segment was crossed.
template <class Stepper, class System, class X>
bool cross(Stepper& stepper, const System& system, X& x, double from, double to, int order, int evaluations, Pace& pace,
           Body::Work& work) {
  const X scale = system.scale();
  X out, error;
  double t = from;
  double h = pace.tolerance > 0 && pace.next > 0 ? pace.next : pace.longest;
  if (pace.tolerance == 0) {
    int steps = 0;
    h = equal_step(to - from, pace.longest, steps);
  }
  while (t < to - kInstant) {
    const double rest = to - t;
    const bool last = h >= rest * (1 - 1e-9);
    const double taken = last ? rest : (pace.tolerance > 0 && 2 * h > rest ? rest / 2 : h);
    stepper.step(system, x, t, taken, scale, out, error);
    work.evaluations += evaluations;
    double wrong = 0;
    if (pace.tolerance > 0) {
      wrong = (error.array() / scale.array()).abs().maxCoeff() / pace.tolerance;
      if (!out.allFinite()) wrong = kHopeless;
      const double factor = std::clamp(0.9 * std::pow(std::max(wrong, 1e-10), -1.0 / order), 0.2, 4.0);
      const double wanted = std::min(taken * factor, pace.longest);
      h = taken < h && factor >= 1 ? std::max(h, wanted) : wanted;  // cut short by the end: says little of h
    }
    if (!(wrong <= 1)) {
      ++work.rejected;
      if (h < kInstant) return false;
      continue;
    }
    if (!out.allFinite()) return false;
    x = out;
    t = last ? to : t + taken;
    ++work.steps;
  }
  pace.next = h;
  return true;
}

void check_state(const BodyState& s) {
  const bool finite = std::isfinite(s.t) && s.p_ib_i.allFinite() && s.v_ib_i.allFinite() &&
                      s.q_ib.coeffs().allFinite() && s.w_ib_b.allFinite() && s.deflection.allFinite() &&
                      s.deflection_rate.allFinite() && s.bend.allFinite() && s.bend_rate.allFinite();
  if (!finite) throw std::invalid_argument("the state at the start must be finite");
  if (std::abs(s.q_ib.norm() - 1) > 1e-6)
    throw std::invalid_argument(
        fmt::format("the attitude at the start has norm {}, but must be within 1e-6 of 1", s.q_ib.norm()));
}

/// Commands on their way to the actuator, by the time they arrive.
class Queue {
 public:
  void push(double arrives, const Vector2d& command) {
    if (count_ == kSize)
      throw SetupError(fmt::format("more than {} commands are delayed on their way to the nozzle", kSize));
    items_[(first_ + count_++) % kSize] = {arrives, command};
  }
  [[nodiscard]] double next() const {
    return count_ > 0 ? items_[first_].first : std::numeric_limits<double>::infinity();
  }
  void clear() { count_ = 0; }
  Vector2d pop() {
    Vector2d command = items_[first_].second;
    first_ = (first_ + 1) % kSize;
    --count_;
    return command;
  }

 private:
  static constexpr std::size_t kSize = 250;
  std::array<std::pair<double, Vector2d>, kSize> items_;
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace

struct Body::Impl {
  Impl(const Vehicle& vehicle, const World& world, const BodyState& start, const Integration& integration,
       const Faults& faults)
      : plant(vehicle, world, faults),
        state(start),
        pace{integration.step, integration.tolerance},
        breaks(plant.burn.breaks()),
        issued(start.deflection),
        acting(start.deflection) {
    segment = segment_at(state.t, state.t + kInstant);
    work.method = integration.method;
    if (work.method == Method::automatic)
      work.method = stiffness(false) * pace.longest < kStableStep ? Method::exact : Method::rosenbrock;
  }

  Plant plant;
  BodyState state;
  Pace pace;
  std::vector<double> breaks;  ///< of the thrust
  Queue queue;
  Vector2d issued;  ///< last command after its limits
  Vector2d acting;  ///< command at the actuator
  double roll_moment = 0;
  bool limited = false;
  bool stuck = false;
  Segment segment;  ///< the last one
  noise::ImuIncrement increment;
  Work work;
  ActuatorStep actuator;

  [[nodiscard]] RigidState rigid() const { return {state.p_ib_i, state.v_ib_i, state.q_ib, state.w_ib_b}; }

  void take(const Command& command, double dt) {
    const Actuator& a = plant.vehicle.actuator;
    if (!stuck && state.t >= plant.faults.nozzle_stuck_at - kInstant) {
      stuck = true;
      state.deflection += plant.faults.nozzle_stuck_offset;
      state.deflection_rate.setZero();
      acting = state.deflection;
      queue.clear();
    }
    const Vector2d wanted(command.pitch, command.yaw);
    const Vector2d asked = wanted - issued;
    const Vector2d change = asked.cwiseMax(-a.rate_limit * dt).cwiseMin(a.rate_limit * dt);
    const Vector2d reached = issued + change;  // may be off `wanted` by a rounding
    const Vector2d allowed = reached.cwiseMax(-a.deflection_limit).cwiseMin(a.deflection_limit);
    limited = change != asked || allowed != reached;
    issued = allowed;
    roll_moment = std::clamp(command.roll_moment, -plant.vehicle.roll_moment_limit, plant.vehicle.roll_moment_limit);
    if (!stuck) queue.push(state.t + a.delay, allowed);
  }

  [[nodiscard]] int layer_now() const {
    if (!plant.world.atmosphere) return standard_atmosphere::kLayers;
    const Height h = height_of(state.p_ib_i);
    return standard_atmosphere::layer(h.above_ellipsoid + (h.up.dot(state.v_ib_i) < 0 ? -kLayerSide : kLayerSide));
  }
  [[nodiscard]] Segment segment_at(double from, double to) const {
    return {plant.burn.piece((from + to) / 2), layer_now(), acting, roll_moment};
  }

  /// When the height passes the next end of a layer before `to`, by height, its rate and its acceleration.
  [[nodiscard]] double layer_crossing(double to) const {
    if (!plant.world.atmosphere) return to;
    const Height h = height_of(state.p_ib_i);
    const Vector3d spin(0, 0, kEarthRate);
    const Vector3d v = state.v_ib_i - spin.cross(state.p_ib_i);
    const double rate = h.up.dot(v);
    const double span = (std::abs(rate) + 100 * (to - state.t)) * (to - state.t);
    const auto& bounds = standard_atmosphere::bounds();
    for (std::size_t k = 1; k < bounds.size(); ++k) {
      const double gap = bounds[k] - h.above_ellipsoid;
      if (std::abs(gap) > span || std::abs(gap) < kLayerSide) continue;
      Segment here = segment_at(state.t, to);
      const Vector3d a = motion(plant, here, state.t, rigid(), state.deflection).acceleration_i - 2 * spin.cross(v) -
                         spin.cross(spin.cross(state.p_ib_i));
      const double discriminant = rate * rate + 2 * h.up.dot(a) * gap;
      if (discriminant < 0) continue;
      const double wait = 2 * gap / (rate + std::copysign(std::sqrt(discriminant), rate));
      if (wait > kInstant && state.t + wait < to - kInstant) return state.t + wait;
    }
    return to;
  }

  bool advance(const Command& command, double end) {
    const BodyState before = state;
    increment = {};
    take(command, end - state.t);
    while (state.t < end) {
      while (queue.next() <= state.t + kInstant) acting = queue.pop();
      double to = std::min(end, queue.next());
      const auto next = std::upper_bound(breaks.begin(), breaks.end(), state.t + kInstant);
      if (next != breaks.end()) to = std::min(to, *next);
      to = layer_crossing(to);
      if (end - to < kInstant) to = end;
      segment = segment_at(state.t, to);
      if (!integrate(to)) {
        state = before;
        return false;
      }
      state.t = to;
    }
    return true;
  }

  bool integrate(double to) try {
    return plant.vehicle.bending ? integrate_with<true>(to) : integrate_with<false>(to);
  } catch (const earth::OutsideDomain&) {  // the place left the domain of gravitation
    return false;
  }

  template <bool kBending>
  bool integrate_with(double to) {
    if (work.method == Method::exact) return exact<kBending>(to);
    using D = Dynamics<true, kBending>;
    using X = typename D::X;
    const D system{plant, segment};
    X x = D::pack(state, increment);
    bool done = false;
    switch (work.method) {
      case Method::runge_kutta4:
        done = classical(system, x, to);
        break;
      case Method::dormand_prince: {
        DormandPrince<X> stepper;
        done = cross(stepper, system, x, state.t, to, 5, 7, pace, work);
        break;
      }
      case Method::fehlberg78: {
        Fehlberg<X> stepper;
        done = cross(stepper, system, x, state.t, to, 8, 13, pace, work);
        break;
      }
      default: {
        Rosenbrock<D::kSize> stepper;
        done = cross(stepper, system, x, state.t, to, 4, Rosenbrock<D::kSize>::kEvaluations, pace, work);
      }
    }
    D::unpack(x, state, increment);
    return done && x.allFinite();
  }

  template <class D, class X>
  bool classical(const D& system, X& x, double to) {
    Classical<X> stepper;
    int steps = 0;
    const double h = equal_step(to - state.t, pace.longest, steps);
    for (int k = 0; k < steps; ++k) stepper.do_step(system, x, state.t + k * h, h);
    work.steps += steps;
    work.evaluations += std::int64_t{4} * steps;
    return x.allFinite();
  }

  template <bool kBending>
  bool exact(double to) {
    using D = Dynamics<false, kBending>;
    Classical<typename D::X> stepper;
    int steps = 0;
    const double h = equal_step(to - state.t, pace.longest, steps);
    if (h != actuator.h()) actuator = ActuatorStep(plant.vehicle.actuator, h);
    auto x = D::pack(state, increment);
    const D system{plant, segment};
    for (int k = 0; k < steps; ++k) {
      segment.start = state.t + k * h;
      for (int plane = 0; plane < 2; ++plane) {
        const Vector2d gap(state.deflection[plane] - acting[plane], state.deflection_rate[plane]);
        segment.offset[plane] = acting[plane] + actuator.offset(gap);
        segment.slope[plane] = actuator.slope(gap);
        const Vector2d after = actuator.advance(gap);
        state.deflection[plane] = acting[plane] + after[0];
        state.deflection_rate[plane] = after[1];
      }
      stepper.do_step(system, x, segment.start, h);
    }
    work.steps += steps;
    work.evaluations += std::int64_t{4} * steps;
    D::unpack(x, state, increment);
    return x.allFinite();
  }

  template <class D>
  [[nodiscard]] double stiffness_of(const D& system) const {
    Rosenbrock<D::kSize> tool;
    return spectral_radius(tool.jacobian(system, D::pack(state, increment), state.t, pace.longest, system.scale()));
  }
  [[nodiscard]] double stiffness(bool with_actuator) const {
    const bool bends = plant.vehicle.bending.has_value();
    if (with_actuator)
      return bends ? stiffness_of(Dynamics<true, true>{plant, segment})
                   : stiffness_of(Dynamics<true, false>{plant, segment});
    return bends ? stiffness_of(Dynamics<false, true>{plant, segment})
                 : stiffness_of(Dynamics<false, false>{plant, segment});
  }
};

Body::Body(const Vehicle& vehicle, const World& world, const BodyState& start, const Integration& integration,
           const Faults& faults) {
  vehicle.check();
  check_state(start);
  if (!(integration.step > 0) || !std::isfinite(integration.step))
    throw SetupError(fmt::format("longest step is {} s, but must be positive and finite", integration.step));
  if (!(integration.tolerance >= 0))
    throw SetupError(fmt::format("tolerance of a step is {}, but must be zero or more", integration.tolerance));
  impl_ = std::make_unique<Impl>(vehicle, world, start, integration, faults);
}
Body::Body(Body&&) noexcept = default;
Body& Body::operator=(Body&&) noexcept = default;
Body::~Body() = default;

bool Body::advance(const Command& command, double t) {
  if (!(t >= impl_->state.t) || !std::isfinite(t))
    throw std::invalid_argument(fmt::format("asked to fly to {} s, but it is {} s already", t, impl_->state.t));
  return impl_->advance(command, t);
}

const BodyState& Body::state() const { return impl_->state; }
const noise::ImuIncrement& Body::increment() const { return impl_->increment; }
bool Body::limited() const { return impl_->limited; }
Body::Work Body::work() const { return impl_->work; }
double Body::stiffness(bool with_actuator) const { return impl_->stiffness(with_actuator); }

earth::Pose Body::pose() const {
  const BodyState& s = impl_->state;
  const Vehicle& v = impl_->plant.vehicle;
  const Burn::Now now = impl_->plant.burn.at(s.t, impl_->segment.burn);
  const Vector3d r(v.imu_station - now.centre_of_mass, 0, 0);
  const earth::Moving inertial{s.p_ib_i + s.q_ib * r,
                               s.v_ib_i + s.q_ib * (s.w_ib_b.cross(r) - Vector3d(now.cm_velocity, 0, 0))};
  const earth::Moving moving = Inertial().to_ecef(inertial, s.t);
  const Quaterniond q_ei = earth::exp_rotation({0, 0, -kEarthRate * s.t});
  return {.p_eb_e = moving.p, .v_eb_e = moving.v, .q_eb = q_ei * s.q_ib * earth::exp_rotation(bent(v, s.bend))};
}

earth::TrajectoryPoint Body::imu() const {
  const BodyState& s = impl_->state;
  const Vehicle& v = impl_->plant.vehicle;
  const Motion m = motion(impl_->plant, impl_->segment, s.t, impl_->rigid(), s.deflection);
  const Vector3d a = bent(v, s.bend);
  return {.t = s.t,
          .pose = pose(),
          .sensed = {.f_ib_b = earth::exp_rotation(-a) * m.f_imu_b,
                     .w_ib_b = bent_rate(s.w_ib_b, a, bent(v, s.bend_rate))}};
}

Body::Flow Body::flow() const {
  Stream air;
  const Motion m = motion(impl_->plant, impl_->segment, impl_->state.t, impl_->rigid(), impl_->state.deflection, &air);
  const double sound = air.air.speed_of_sound;
  return {air.height,
          0.5 * air.air.density * air.speed * air.speed,
          sound > 0 ? air.speed / sound : 0,
          air.speed,
          std::atan2(air.velocity_b.tail<2>().norm(), air.velocity_b.x()),
          m.thrust};
}

}  // namespace gyrobudget::inline v0::flight

// SPDX-License-Identifier: MIT
// Six degrees of freedom against exact solutions, and each integrator's order.
#include "gyrobudget/vehicle/flight/body.h"

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::flight {
namespace {

using earth::wgs84::kEarthRate;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr Integration kPrecise{Method::fehlberg78, 1, 1e-14};

/// No thrust, no air.
Vehicle inert() {
  Vehicle v;
  v.name = "inert";
  v.lift_off_mass = 100;
  v.burn_time = 1;
  v.roll_inertia = 10;
  v.pitch_inertia = 20;
  v.yaw_inertia = 25;
  return v;
}
const World kVacuum{.atmosphere = false};

BodyState in_orbit(const Vector3d& p, const Vector3d& v) {
  BodyState s;
  s.p_ib_i = p;
  s.v_ib_i = v;
  s.q_ib = Quaterniond(0.5, -0.5, 0.1, 0.7).normalized();
  s.w_ib_b = Vector3d::Zero();
  return s;
}

TEST(Body, TumblesWithItsEnergyAndAngularMomentum) {
  const Vector3d inertia(10, 20, 25);
  BodyState s = in_orbit({7e6, 0, 0}, {0, 7500, 0});
  s.w_ib_b = {0.05, 1, 0.02};  // about the middle axis: it flips over
  const auto energy = [&](const BodyState& b) { return b.w_ib_b.dot(inertia.cwiseProduct(b.w_ib_b)); };
  const auto momentum = [&](const BodyState& b) -> Vector3d { return b.q_ib * inertia.cwiseProduct(b.w_ib_b); };
  Body body(inert(), kVacuum, s, kPrecise);
  bool flipped = false;
  for (int k = 1; k <= 1000; ++k) {
    ASSERT_TRUE(body.advance({}, k));
    flipped |= body.state().w_ib_b.y() < -0.9;
  }
  EXPECT_TRUE(flipped);
  EXPECT_NEAR(energy(body.state()) / energy(s), 1, 1e-10);
  EXPECT_LT((momentum(body.state()) - momentum(s)).norm() / momentum(s).norm(), 1e-10);
}

/// Potential of the normal field by its zonal terms: independent of the acceleration's recursion.
double potential(const Vector3d& p) {
  const double r = p.norm(), s = p.z() / r, ratio = earth::wgs84::kEquatorialRadius / r;
  double sum = 1;
  for (int n = 2; n <= 12; n += 2)
    sum -= earth::normal_zonal(n) * std::pow(ratio, n) * std::legendre(static_cast<unsigned>(n), s);
  return earth::wgs84::kGM / r * sum;
}

TEST(Body, KeepsTheInvariantsOfAnEllipticalOrbit) {
  const BodyState s = in_orbit({7e6, 0, 0}, {0, 6000, 5500});
  Body body(inert(), kVacuum, s, {Method::fehlberg78, 60, 1e-13});
  const auto energy = [](const BodyState& b) { return b.v_ib_i.squaredNorm() / 2 - potential(b.p_ib_i); };
  double highest = 0;
  for (int k = 1; k <= 120; ++k) {
    ASSERT_TRUE(body.advance({}, 60 * k));
    highest = std::max(highest, body.state().p_ib_i.norm());
  }
  EXPECT_GT(highest, 8e6);
  EXPECT_NEAR(energy(body.state()) / energy(s), 1, 1e-12);
  EXPECT_NEAR(body.state().p_ib_i.cross(body.state().v_ib_i).z() / s.p_ib_i.cross(s.v_ib_i).z(), 1, 1e-12);
}

TEST(Body, ComesRoundACircularOrbitInItsPeriod) {
  const Vector3d p(8e6, 0, 0);
  const double g = earth::normal_gravitation(p).norm();
  const BodyState s = in_orbit(p, {0, std::sqrt(g * 8e6), 0});
  Body body(inert(), kVacuum, s, {Method::fehlberg78, 60, 1e-13});
  ASSERT_TRUE(body.advance({}, 2 * pi * std::sqrt(8e6 / g)));
  EXPECT_LT((body.state().p_ib_i - p).norm(), 1e-5);
}

/// The same fall in Earth's own axes, with Coriolis and centrifugal terms, by Runge-Kutta.
Vector3d fall_in_ecef(const Vector3d& start, double duration) {
  using State = Eigen::Matrix<double, 6, 1>;
  const Vector3d spin(0, 0, kEarthRate);
  const auto rate = [&](const State& x) {
    State dx;
    dx << x.tail<3>(), earth::normal_gravity(x.head<3>()) - 2 * spin.cross(x.tail<3>());
    return dx;
  };
  State x;
  x << start, Vector3d::Zero();
  constexpr int kSteps = 1000;
  const double h = duration / kSteps;
  for (int k = 0; k < kSteps; ++k) {
    const State a = rate(x), b = rate(x + h / 2 * a), c = rate(x + h / 2 * b), d = rate(x + h * c);
    x += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return x.head<3>();
}

TEST(Body, FallsOverTheRotatingEarth) {
  constexpr double kTime = 20;
  const auto place = earth::Geodetic::from_degrees(45, 20, 10000);
  Body body(inert(), kVacuum, on_pad(place, 0, 0), kPrecise);
  noise::ImuIncrement sum;
  for (int k = 1; k <= 20; ++k) {
    ASSERT_TRUE(body.advance({}, k));
    earth::vector(sum.velocity) += earth::vector(body.increment().velocity);
  }
  const auto here = earth::Inertial().to_ecef({body.state().p_ib_i, body.state().v_ib_i}, kTime);
  EXPECT_LT((here.p - fall_in_ecef(earth::to_ecef(place), kTime)).norm(), 2e-8);  // 20 roundings of 1 nm
  const Vector3d enu = earth::LocalFrame::east_north_up(place).from_ecef(here.p);
  const double g = earth::normal_gravity(earth::to_ecef(place)).norm();
  const double east = kEarthRate * g * std::pow(kTime, 3) / 3 * std::cos(45 * earth::kDegree);
  EXPECT_NEAR(enu.x() / east, 1, 1e-3);       // next terms: gravity's gradient and omega t
  EXPECT_EQ(sum.velocity, noise::Vector3{});  // a falling accelerometer senses nothing
}

TEST(Body, GainsTheSpeedOfTsiolkovsky) {
  Vehicle v = inert();
  v.lift_off_mass = 28000;
  v.propellant = 12000;
  v.burn_time = 83;
  v.specific_impulse = 277;
  v.centre_of_mass = 5;
  v.imu_station = 5;
  Body body(v, kVacuum, on_pad(earth::alcantara().position, 0, pi / 2), kPrecise);
  Vector3d sum = Vector3d::Zero();
  for (int k = 1; k <= 100; ++k) {
    ASSERT_TRUE(body.advance({}, k));  // the burn ends within the 83rd or goes on to its end: exactly there
    sum += earth::vector(body.increment().velocity);
  }
  EXPECT_NEAR(sum.x(), 277 * kStandardGravity * std::log(28.0 / 16.0), 1e-9);
  EXPECT_LT(sum.tail<2>().norm(), 1e-12);
}

TEST(Body, ThrustCutLeavesThePropellant) {
  Vehicle v = vlm1();
  Body body(v, kVacuum, on_pad(earth::alcantara().position, 0, pi / 2), kPrecise, {.thrust_cut_at = 20.005});
  Vector3d sum = Vector3d::Zero();
  for (int k = 1; k <= 30; ++k) {
    ASSERT_TRUE(body.advance({}, k));
    sum += earth::vector(body.increment().velocity);
  }
  const double left = burn_state(v, 20.005).mass;
  // The IMU's own motion against the centre of mass adds the change of its speed.
  const double cm_velocity_0 = 3 * burn_state(v, 0).vacuum_thrust / (277 * kStandardGravity * 12000);
  EXPECT_NEAR(sum.x(),
              277 * kStandardGravity * std::log(28000 / left) + cm_velocity_0 -
                  3 * burn_state(v, 20.004999).vacuum_thrust / (277 * kStandardGravity * 12000),
              1e-3);
}

// --- integrators --------------------------------------------------------------------------------------

/// Eight seconds of powered flight through air with the nozzle moved every second; no table's point, no end
/// of a layer within.
BodyState fly_smooth(const Integration& integration, bool bends) {
  Vehicle v = vlm1();
  v.actuator = {.frequency = 1, .damping = 0.7, .rate_limit = 10};
  if (bends) v.bending = Bending{.frequency = LookupTable::linear({{0, 0.4}, {1, 0.6}})};
  BodyState s = on_pad(earth::alcantara().position, 1, 1.2);
  s.t = 2;
  s.v_ib_i += s.q_ib * Vector3d(100, 1, -2);
  s.w_ib_b += Vector3d(0.3, 0.02, -0.03);
  Body body(v, {}, s, integration);
  for (int k = 0; k < 8; ++k) {
    const Command command{(k % 3 - 1) * 4e-3, (k % 2) * 3e-3, 50.0 * (k % 2)};
    EXPECT_TRUE(body.advance(command, 3 + k));
  }
  return body.state();
}

double distance(const BodyState& a, const BodyState& b) {
  return (a.v_ib_i - b.v_ib_i).norm() + 10 * (a.w_ib_b - b.w_ib_b).norm() +
         10 * (a.q_ib.coeffs() - b.q_ib.coeffs()).norm() + 10 * (a.bend - b.bend).norm();
}

struct Order {
  Method method;
  double step;
  double order;
};
class Orders : public testing::TestWithParam<Order> {};

TEST_P(Orders, ShowsOnASmoothScene) {
  for (const bool bends : {false, true}) {
    const BodyState truth = fly_smooth({Method::fehlberg78, 0.02, 0}, bends);
    const auto [method, step, order] = GetParam();
    const double coarse = distance(fly_smooth({method, step, 0}, bends), truth);
    const double fine = distance(fly_smooth({method, step / 2, 0}, bends), truth);
    EXPECT_GT(fine, 1e-12);  // above rounding
    EXPECT_NEAR(std::log2(coarse / fine), order, order / 10) << to_string(method) << " " << coarse << " " << fine;
  }
}
INSTANTIATE_TEST_SUITE_P(All, Orders,
                         testing::Values(Order{Method::exact, 0.05, 4}, Order{Method::runge_kutta4, 0.05, 4},
                                         Order{Method::dormand_prince, 0.05, 5}, Order{Method::fehlberg78, 0.25, 8},
                                         Order{Method::rosenbrock, 0.05, 4}),
                         [](const auto& test) { return std::string(to_string(test.param.method)); });

TEST(Integrators, FamiliesAgreeAtTightTolerance) {
  const BodyState truth = fly_smooth(kPrecise, true);
  EXPECT_LT(distance(fly_smooth({Method::dormand_prince, 1, 1e-13}, true), truth), 1e-9);
  EXPECT_LT(distance(fly_smooth({Method::rosenbrock, 1, 1e-12}, true), truth), 1e-7);
}

TEST(Integrators, StiffnessIsThatOfTheActuator) {
  Vehicle v = vlm1();
  v.actuator.frequency = 4e3;
  const BodyState pad = on_pad(earth::alcantara().position, 0, pi / 2);
  const Body body(v, {}, pad);
  EXPECT_NEAR(body.stiffness(true) / (2 * pi * 4e3), 1, 0.02);
  EXPECT_LT(body.stiffness(false), 2);
  EXPECT_EQ(body.work().method, Method::exact);
  v.bending = Bending{.frequency = 400};
  const Body stiff(v, {}, pad);
  EXPECT_NEAR(stiff.stiffness(false) / (2 * pi * 400), 1, 0.02);
  EXPECT_EQ(stiff.work().method, Method::rosenbrock);
}

TEST(Integrators, ExactDoesNotCareHowFastTheActuatorIs) {
  // A nozzle that follows at once turns the body by the command's torque; the exact method and RODAS agree.
  for (const double factor : {1e2, 1e4, 1e6}) {
    Vehicle v = vlm1();
    v.actuator.frequency *= factor;
    v.actuator.rate_limit = 100;
    const BodyState pad = on_pad(earth::alcantara().position, 0, pi / 2);
    Body exact(v, {}, pad, {Method::exact, 0.01, 0}), stiff(v, {}, pad, {Method::rosenbrock, 0.01, 1e-10});
    for (int k = 1; k <= 20; ++k) {
      const Command command{k % 2 == 0 ? 0.01 : -0.005, 0.001 * k, 0};
      ASSERT_TRUE(exact.advance(command, k * 0.01));
      ASSERT_TRUE(stiff.advance(command, k * 0.01));
    }
    EXPECT_LT((exact.state().w_ib_b - stiff.state().w_ib_b).norm(), 1e-7) << factor;
    if (factor <= 1e3) {  // explicit methods crawl beyond; where steps are rejected they are taken anew
      Body explicit_one(v, {}, pad, {Method::dormand_prince, 0.01, 1e-9});
      for (int k = 1; k <= 20; ++k)
        ASSERT_TRUE(explicit_one.advance({k % 2 == 0 ? 0.01 : -0.005, 0.001 * k, 0}, k * 0.01));
      EXPECT_GT(explicit_one.work().rejected, 0);
      EXPECT_LT((explicit_one.state().w_ib_b - stiff.state().w_ib_b).norm(), 1e-8);
    }
    EXPECT_LT((exact.state().deflection - stiff.state().deflection).norm(), 1e-8) << factor;
  }
}

TEST(Body, LimitsAndDelayOfTheNozzle) {
  Vehicle v = vlm1();
  v.actuator.delay = 0.025;
  const BodyState pad = on_pad(earth::alcantara().position, 0, pi / 2);
  Body body(v, {}, pad);
  ASSERT_TRUE(body.advance({.pitch = 1}, 0.01));
  EXPECT_TRUE(body.limited());
  ASSERT_TRUE(body.advance({.pitch = 1}, 0.02));
  EXPECT_EQ(body.state().deflection[0], 0);  // nothing has arrived yet
  for (int k = 3; k <= 200; ++k) ASSERT_TRUE(body.advance({.pitch = 1}, k * 0.01));
  EXPECT_NEAR(body.state().deflection[0], v.actuator.deflection_limit, 1e-6);
  ASSERT_TRUE(body.advance({.pitch = v.actuator.deflection_limit}, 2.01));
  EXPECT_FALSE(body.limited());
}

TEST(Body, RefusesMisuse) {
  const BodyState pad = on_pad(earth::alcantara().position, 0, pi / 2);
  EXPECT_THROW(Body(vlm1(), {}, pad, {.step = 0}), std::invalid_argument);
  EXPECT_THROW(Body(vlm1(), {}, pad, {.tolerance = -1}), std::invalid_argument);
  Body body(vlm1(), {}, pad);
  EXPECT_THROW((void)body.advance({}, -1), std::invalid_argument);
  BodyState broken = pad;
  broken.v_ib_i.x() = NAN;
  EXPECT_THROW(Body(vlm1(), {}, broken), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::flight

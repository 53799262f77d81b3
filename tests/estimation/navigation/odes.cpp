// SPDX-License-Identifier: MIT
#include "odes.h"

#include "gyrobudget/vehicle/earth/gravity.h"

#include <boost/numeric/odeint/algebra/vector_space_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include <cmath>

namespace odes {
namespace {

namespace odeint = boost::numeric::odeint;

template <typename State, typename System>
void integrate(const System& system, State& state, double t, double step) {
  odeint::runge_kutta_fehlberg78<State, double, State, double, odeint::vector_space_algebra> stepper;
  const auto steps = std::llround(t / step);
  for (long long k = 0; k < steps; ++k) stepper.do_step(system, state, static_cast<double>(k) * step, step);
}

}  // namespace

Eigen::Vector3d tumbling_angle(double t) {
  return 2 * Eigen::Vector3d(1 - std::cos(t), std::sin(1.3 * t) / 1.3, (std::cos(1.0) - std::cos(0.7 * t + 1)) / 0.7);
}

Eigen::Quaterniond tumbled(double t) {
  Eigen::Vector4d q = Eigen::Quaterniond::Identity().coeffs();
  integrate(
      [](const Eigen::Vector4d& x, Eigen::Vector4d& derivative, double at) {
        const Eigen::Vector3d w(std::sin(at), std::cos(1.3 * at), std::sin(0.7 * at + 1));  // half the rates
        derivative = (Eigen::Quaterniond(x) * Eigen::Quaterniond(0, w.x(), w.y(), w.z())).coeffs();
      },
      q, t, 0.01);
  return Eigen::Quaterniond(q).normalized();
}

std::pair<Eigen::Vector3d, Eigen::Vector3d> orbit(const Eigen::Vector3d& p, const Eigen::Vector3d& v, double t) {
  using Vector6d = Eigen::Matrix<double, 6, 1>;
  Vector6d state;
  state << p, v;
  integrate(
      [](const Vector6d& x, Vector6d& derivative, double) {
        derivative.head<3>() = x.tail<3>();
        derivative.tail<3>() = gyrobudget::earth::normal_gravitation(x.head<3>());
      },
      state, t, 1.0);
  return {state.head<3>(), state.tail<3>()};
}

}  // namespace odes

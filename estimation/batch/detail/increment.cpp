// SPDX-License-Identifier: MIT
#include "increment.h"

#include "gyrobudget/estimation/navigation/covariance.h"
#include "gyrobudget/estimation/navigation/detail/imu_reader.h"
#include "gyrobudget/estimation/navigation/detail/unknown_motion.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <cmath>

#include <Eigen/Geometry>

namespace gyrobudget::inline v0::batch::detail {
namespace {

using earth::skew;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using navigation::kAttitude;
using navigation::kCoreStates;
using navigation::kPosition;
using navigation::kVelocity;

const Vector3d kEarthRate(0, 0, earth::wgs84::kEarthRate);

// How axes of e at the end see what stood still since the start.
Matrix3d turned_back(double tau) { return earth::exp_rotation(-tau * kEarthRate).toRotationMatrix(); }

// Integrals of gravitation over the interval, once and twice, by its ends: g is straight to 1e-9 m/s^2 over a second.
struct Pull {
  Vector3d once, twice;
};
Pull pull(const Increment& increment, const Matrix3d& M) {
  const Vector3d g0 = earth::normal_gravitation(increment.from.p_eb_e);
  const Vector3d g1 = M.transpose() * earth::normal_gravitation(increment.to.p_eb_e);
  const double tau = increment.tau;
  return {tau / 2 * (g0 + g1), tau * tau / 6 * (2 * g0 + g1)};
}

// d(gravitation)/dp: that of gravity less the centrifugal part.
Matrix3d gravitation_gradient(const Vector3d& p) {
  return earth::normal_gravity_gradient(p) + skew(kEarthRate) * skew(kEarthRate);
}

// The IMU's errors off what it measured. Those that multiply do so with the true signal: one repetition, as in Filter.
Sensed corrected(const Layout& layout, const Sensed& raw, const Eigen::VectorXd& mean_terms) {
  navigation::SensorCorrection errors;
  for (int repetition = 0; repetition < 2; ++repetition)
    errors = navigation::sensor_errors(layout.model.terms, mean_terms.data(), raw.w_ib_b - errors.gyro,
                                       raw.f_ib_b - errors.accelerometer);
  return {raw.w_ib_b - errors.gyro, raw.f_ib_b - errors.accelerometer};
}

// One strapdown over the whole log, set to each node as it comes, with the transitions of an interval multiplied.
class Pass {
 public:
  Pass(const navigation::Recording& recording, const Layout& layout, const Node& first,
       const navigation::Strapdown::Options& options)
      : imu_(recording.imu, recording.origin, first.time),
        gaps_(recording.imu),
        layout_(layout),
        strapdown_(first.pose, options),
        lineariser_(layout.model) {}

  Increment run(const Node& node, const Eigen::VectorXd& terms, double to) {
    const auto n = static_cast<Eigen::Index>(layout_.model.terms.size());
    Increment result;
    result.tau = to - node.time;
    result.from = node.pose;
    result.terms = terms;
    result.coupling = Eigen::MatrixXd::Zero(kCoreStates, n);
    result.decay = Eigen::VectorXd::Ones(n);
    navigation::Covariance noise(navigation::StateMatrix::Zero(kCoreStates + n, kCoreStates + n),
                                 navigation::Form::plain);
    strapdown_.set_state(node.pose);
    bool first = true;
    while (imu_.before(to)) {
      const auto [imu, dt, interval] = imu_.next(to);
      result.end = {earth::vector(imu.angle) / dt, earth::vector(imu.velocity) / dt};
      if (first) result.begin = result.end;
      first = false;
      noise.propagate(step(result, dt, gaps_.at(interval)));
    }
    result.to = strapdown_.state();
    result.Q = noise.matrix();
    return result;
  }

 private:
  const navigation::Transition& step(Increment& result, double dt, const navigation::detail::UnknownMotion* unknown) {
    const auto& terms = layout_.model.terms;
    Eigen::VectorXd mean = result.terms.cwiseProduct(result.decay);
    for (std::size_t k = 0; k < terms.size(); ++k)
      mean[static_cast<Eigen::Index>(k)] *= navigation::mean_decay(terms[k], dt);
    const Sensed sensed = corrected(layout_, result.end, mean);
    const earth::Pose before = strapdown_.state();
    strapdown_.step({.angle = earth::array(dt * sensed.w_ib_b), .velocity = earth::array(dt * sensed.f_ib_b)}, dt);
    Quaterniond middle = strapdown_.state().q_eb;
    const double sign = middle.dot(before.q_eb) < 0 ? -1 : 1;
    middle.coeffs() = (middle.coeffs() + sign * before.q_eb.coeffs()).normalized();
    navigation::StepInput input;
    input.dt = dt;
    input.p_eb_e = (before.p_eb_e + strapdown_.state().p_eb_e) / 2;
    input.C_eb = middle.toRotationMatrix();
    input.w_ib_b = sensed.w_ib_b;
    input.f_ib_b = input.C_eb.transpose() * strapdown_.last_specific_force_e();
    if (unknown != nullptr) input.unknown = unknown->density();
    const navigation::Transition& transition = lineariser_(input);
    result.coupling = transition.core * result.coupling;
    for (std::size_t k = 0; k < terms.size(); ++k) {
      const auto& term = transition.terms[k];
      const auto i = static_cast<Eigen::Index>(k);
      if (term.signal >= 0) result.coupling.col(i) += term.gain * result.decay[i] * transition.input.col(term.signal);
      result.decay[i] *= term.decay;
    }
    return transition;
  }

  navigation::detail::ImuReader imu_;
  navigation::detail::Gaps gaps_;
  const Layout& layout_;
  navigation::Strapdown strapdown_;
  navigation::Lineariser lineariser_;
};

}  // namespace

Layout::Layout(const navigation::ErrorStateModel& model_) : model(model_) {
  for (std::size_t k = 0; k < model.terms.size(); ++k)
    (model.terms[k].walk > 0 ? chained : global).push_back(static_cast<int>(k));
}

Eigen::VectorXd terms_at(const Layout& layout, const Node& node, const Eigen::VectorXd& global, double since) {
  Eigen::VectorXd terms(static_cast<Eigen::Index>(layout.model.terms.size()));
  for (std::size_t i = 0; i < layout.chained.size(); ++i)
    terms[layout.chained[i]] = node.chained[static_cast<Eigen::Index>(i)];
  for (std::size_t i = 0; i < layout.global.size(); ++i)
    terms[layout.global[i]] =
        global[static_cast<Eigen::Index>(i)] *
        navigation::decay(layout.model.terms[static_cast<std::size_t>(layout.global[i])], node.time - since);
  return terms;
}

Matrix3d left_jacobian(const Vector3d& phi) {
  const double x = phi.norm();
  const bool small = x < 1e-4;
  const double a = small ? 0.5 - x * x / 24 : (1 - std::cos(x)) / (x * x);
  const double b = small ? 1.0 / 6 - x * x / 120 : (x - std::sin(x)) / (x * x * x);
  return Matrix3d::Identity() + a * skew(phi) + b * skew(phi) * skew(phi);
}

Matrix3d inverse_left_jacobian(const Vector3d& phi) {
  const double x = phi.norm();
  const double k = x < 1e-3 ? 1.0 / 12 + x * x / 720 : (1 - x / 2 / std::tan(x / 2)) / (x * x);
  return Matrix3d::Identity() - 0.5 * skew(phi) + k * skew(phi) * skew(phi);
}

Prediction predict(const Increment& increment, const earth::Pose& from, const Eigen::VectorXd& terms) {
  const double tau = increment.tau;
  const Matrix3d M = turned_back(tau), W = skew(kEarthRate);
  const Matrix3d A = (from.q_eb * increment.from.q_eb.conjugate()).toRotationMatrix();
  const Pull g = pull(increment, M);
  const Vector3d v_from = increment.from.v_eb_e + W * increment.from.p_eb_e;
  const Vector3d v_to = M.transpose() * (increment.to.v_eb_e + W * increment.to.p_eb_e);
  const Eigen::Matrix<double, kCoreStates, 1> moved = increment.coupling * (terms - increment.terms);
  const Vector3d dp = moved.segment<3>(kPosition), dv = moved.segment<3>(kVelocity) + W * dp;
  const Vector3d psi = moved.segment<3>(kAttitude);
  const Vector3d u_v = v_to - v_from - g.once + M.transpose() * dv;
  const Vector3d u_p =
      M.transpose() * increment.to.p_eb_e - increment.from.p_eb_e - tau * v_from - g.twice + M.transpose() * dp;

  const Matrix3d gradient = gravitation_gradient(increment.from.p_eb_e);
  const Vector3d away = from.p_eb_e - increment.from.p_eb_e;
  const Vector3d v = from.v_eb_e + W * from.p_eb_e;
  Prediction end;
  end.pose.p_eb_e = M * (from.p_eb_e + tau * v + g.twice + tau * tau / 2 * gradient * away + A * u_p);
  end.pose.v_eb_e = M * (v + g.once + tau * gradient * away + A * u_v) - W * end.pose.p_eb_e;
  const Matrix3d carried = M * A * M.transpose();
  end.pose.q_eb = (Quaterniond(carried) * earth::exp_rotation(psi) * increment.to.q_eb).normalized();

  const Matrix3d I = Matrix3d::Identity();
  end.core.setZero();
  end.core.block<3, 3>(kPosition, kPosition) = M * (I + tau * W + tau * tau / 2 * gradient);
  end.core.block<3, 3>(kPosition, kVelocity) = tau * M;
  end.core.block<3, 3>(kPosition, kAttitude) = -M * skew(A * u_p);
  end.core.block<3, 3>(kVelocity, kPosition) = M * (W + tau * gradient);
  end.core.block<3, 3>(kVelocity, kVelocity) = M;
  end.core.block<3, 3>(kVelocity, kAttitude) = -M * skew(A * u_v);
  end.core.block<3, 3>(kAttitude, kAttitude) = M;
  end.core.middleRows<3>(kVelocity) -= W * Eigen::Matrix<double, 3, 9>(end.core.middleRows<3>(kPosition));
  const auto& c = increment.coupling;
  end.terms.resize(kCoreStates, terms.size());
  end.terms.middleRows<3>(kPosition) = carried * c.middleRows<3>(kPosition);
  end.terms.middleRows<3>(kVelocity) =
      carried * (c.middleRows<3>(kVelocity) + W * c.middleRows<3>(kPosition)) - W * end.terms.middleRows<3>(kPosition);
  end.terms.middleRows<3>(kAttitude) = carried * left_jacobian(psi) * c.middleRows<3>(kAttitude);
  return end;
}

Preintegrator::Preintegrator(const navigation::Recording& recording, const Layout& layout,
                             const navigation::Strapdown::Options& strapdown)
    : recording_(recording), layout_(layout), strapdown_(strapdown) {}

std::vector<Increment> Preintegrator::operator()(const std::vector<Node>& nodes, const Eigen::VectorXd& global) const {
  std::vector<Increment> increments;
  Pass pass(recording_, layout_, nodes.front(), strapdown_);
  for (std::size_t k = 0; k + 1 < nodes.size(); ++k)
    increments.push_back(
        pass.run(nodes[k], terms_at(layout_, nodes[k], global, nodes.front().time), nodes[k + 1].time));
  return increments;
}

}  // namespace gyrobudget::inline v0::batch::detail

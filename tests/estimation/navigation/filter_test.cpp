// SPDX-License-Identifier: MIT
#include "gyrobudget/estimation/navigation/filter.h"

#include "gyrobudget/noise/normal.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace gyrobudget;  // NOLINT
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::Form;

namespace {

navigation::ErrorTerm term(navigation::Carrier carrier, navigation::Effect effect, int axis, int input = 0) {
  navigation::ErrorTerm t;
  t.carrier = carrier;
  t.effect = effect;
  t.axis = axis;
  t.input = input;
  return t;
}

navigation::ErrorStateModel biases_and_scale_factors() {
  navigation::ErrorStateModel model;
  model.gyro_white.setConstant(1e-5);
  model.accelerometer_white.setConstant(1e-4);
  for (const auto carrier : {navigation::Carrier::gyro, navigation::Carrier::accelerometer})
    for (const auto effect : {navigation::Effect::bias, navigation::Effect::scale_factor})
      for (int i = 0; i < 3; ++i) model.terms.push_back(term(carrier, effect, i));
  return model;
}

earth::Pose start_of(const earth::Trajectory& path) {
  const auto p = path.at(0);
  return p.pose;
}

navigation::StateMatrix diagonal(const navigation::ErrorStateModel& model, double p, double v, double psi, double bias,
                                 double scale) {
  navigation::StateVector s(model.states());
  s.segment<3>(0).setConstant(p);
  s.segment<3>(3).setConstant(v);
  s.segment<3>(6).setConstant(psi);
  for (std::size_t k = 0; k < model.terms.size(); ++k)
    s[9 + static_cast<int>(k)] = model.terms[k].effect != navigation::Effect::bias     ? scale
                                 : model.terms[k].carrier == navigation::Carrier::gyro ? bias
                                                                                       : 1000 * bias;
  return s.cwiseAbs2().asDiagonal();
}

}  // namespace

// A filter that is given the truth but for biases and scale factors finds them from perfect positions.
TEST(Filter, FindsBiasesOfAPerfectIMUFromPositions) {
  earth::Cruise cruise;
  cruise.turn_acceleration = 5;
  cruise.duration = 400;
  const auto path = earth::cruise(cruise);
  auto model = biases_and_scale_factors();
  const Vector3d gyro_bias{1e-5, -2e-5, 3e-5}, accelerometer_bias{1e-2, 2e-2, -1e-2};
  for (const Form form : {Form::plain, Form::joseph, Form::square_root}) {
    navigation::Filter::Options options;
    options.form = form;
    options.covariance_interval = 0.1;
    navigation::Filter filter(start_of(path), model, diagonal(model, 1, 0.1, 1e-3, 5e-5, 1e-4), options);
    const double dt = 0.02;
    int used = 0, fixes = 0;
    for (int k = 0; (k + 1) * dt <= cruise.duration; ++k) {
      auto imu = path.increment(k * dt, (k + 1) * dt);
      earth::vector(imu.angle) += dt * gyro_bias;
      earth::vector(imu.velocity) += dt * accelerometer_bias;
      filter.propagate(imu, dt);
      if ((k + 1) % 50 == 0) {
        const auto truth = path.at((k + 1) * dt);
        ++fixes;
        used +=
            filter
                .update(measure(navigation::PositionFix{truth.pose.p_eb_e, Vector3d::Constant(0.1)}, filter.estimate()))
                .status == navigation::Innovation::Status::used;
      }
    }
    EXPECT_EQ(used, fixes);
    const auto truth = path.at(filter.time());
    const auto P = filter.covariance().matrix();
    const Vector3d dp = truth.pose.p_eb_e - filter.state().p_eb_e;
    for (int i = 0; i < 3; ++i) {
      EXPECT_LT(std::abs(dp[i]), 4 * std::sqrt(P(i, i)));
      EXPECT_LT(std::abs(filter.term(i) - gyro_bias[i]), 4 * std::sqrt(P(9 + i, 9 + i)));
      EXPECT_LT(std::abs(filter.term(6 + i) - accelerometer_bias[i]), 4 * std::sqrt(P(15 + i, 15 + i)));
    }
  }
}

// SPDX-License-Identifier: MIT
#include "run_parts.h"

#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <algorithm>
#include <cmath>

namespace gyrobudget::inline v0::navigation::detail {
namespace {

using Eigen::Vector3d;

void sum_biases(Carrier carrier, const Estimate& estimate, const StateMatrix& P, Vector3d& bias, Vector3d& sigma) {
  const auto& terms = estimate.model->terms;
  for (int axis = 0; axis < 3; ++axis) {
    StateVector h = StateVector::Zero(P.cols());
    for (std::size_t k = 0; k < terms.size(); ++k) {
      const ErrorTerm& term = terms[k];
      if (term.carrier != carrier || term.effect != Effect::bias || term.axis != axis) continue;
      h[kCoreStates + static_cast<int>(k)] = 1;
      bias[axis] += estimate.terms[k];
    }
    sigma[axis] = std::sqrt(std::max(0.0, h.dot(P * h)));
  }
}

}  // namespace

double stamp(const Recording& recording, std::size_t k) {
  return static_cast<double>(recording.imu.stamps[k] - recording.origin) * noise::kNanosecond;
}

noise::ImuIncrement piece(const Recording& recording, std::size_t k, double from, double to) {
  const auto& imu = recording.imu;
  const double begin = stamp(recording, k), end = stamp(recording, k + 1);
  if (from <= begin + kSame && to >= end - kSame) return imu.increments[k];
  const auto rates = [&](std::size_t i) {
    const double dt = stamp(recording, i + 1) - stamp(recording, i);
    return earth::Sensed{.f_ib_b = earth::vector(imu.increments[i].velocity) / dt,
                         .w_ib_b = earth::vector(imu.increments[i].angle) / dt};
  };
  const auto middle = [&](std::size_t i) { return (stamp(recording, i) + stamp(recording, i + 1)) / 2; };
  auto [f, w] = rates(k);
  const double away = (from + to) / 2 - middle(k);
  if (k > 0 && k + 1 < imu.increments.size()) {
    const auto [f_before, w_before] = rates(k - 1);
    const auto [f_after, w_after] = rates(k + 1);
    const double between = middle(k + 1) - middle(k - 1);
    f += away * (f_after - f_before) / between;
    w += away * (w_after - w_before) / between;
  }
  return {.angle = earth::array(w * (to - from)), .velocity = earth::array(f * (to - from))};
}

Solution solution(const Estimate& estimate, const StateMatrix& P, double t) {
  Solution s;
  s.time = t;
  s.state = estimate.motion.pose;
  const earth::Geodetic at = earth::to_geodetic(s.state.p_eb_e);
  const LocalSigmas local =
      local_sigmas(P.topLeftCorner<kCoreStates, kCoreStates>(), earth::C_e_enu(at.latitude, at.longitude));
  s.position_sigma = local.position;
  s.velocity_sigma = local.velocity;
  s.attitude_sigma = local.attitude;
  for (int k = 0; k < static_cast<int>(estimate.model->terms.size()); ++k) {
    s.terms.push_back(estimate.terms[k]);
    s.term_sigmas.push_back(std::sqrt(std::max(0.0, P(kCoreStates + k, kCoreStates + k))));
  }
  sum_biases(Carrier::gyro, estimate, P, s.gyro_bias, s.gyro_bias_sigma);
  sum_biases(Carrier::accelerometer, estimate, P, s.accelerometer_bias, s.accelerometer_bias_sigma);
  return s;
}

}  // namespace gyrobudget::inline v0::navigation::detail

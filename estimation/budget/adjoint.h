// SPDX-License-Identifier: MIT
// Errors at one time as sums over all that happened before: the budget by another route.
//
// One backward pass through the same steps and gains gives d x(T)/d eps_k, by how much each error eps_k met on the
// way moves position, velocity and attitude at T. A source's covariance is then
//   cov x(T) = sum_kl (dx/deps_k) E[eps_k eps_l^T] (dx/deps_l)^T,
// with E[eps eps^T] taken from the process itself: its structure function where it has no variance. No process is
// approximated by states here, so this checks the route that does. Source: Gelb (1974), section 9.2 (adjoint).
#pragma once

#include "gyrobudget/estimation/navigation/sensor_states.h"
#include "gyrobudget/noise/process.h"

#include <vector>

#include "error_budget.h"

namespace gyrobudget::inline v0::budget {

/// Derivatives of [p, v, psi] at `time`. 600 bytes a step.
struct Adjoint {
  double time = 0;
  std::size_t steps = 0;  ///< those that end at or before `time`, and all of a pad that aligned the start
  std::vector<navigation::InputMatrix> input;  ///< [step] by mean errors of gyro x y z, accelerometer x y z
  navigation::InputMatrix through_start =
      navigation::InputMatrix::Zero();  ///< by these for a second of the pad, through the alignment
  std::vector<Eigen::Matrix<double, navigation::kCoreStates, 3>> fix;   ///< [fix] by errors of its rows
  navigation::CoreMatrix initial = navigation::CoreMatrix::Identity();  ///< by the errors at the scene's start
};

/// By all of what a step's mean errors do. @param sensed Source::sensed
[[nodiscard]] navigation::InputMatrix by_errors(const Adjoint& adjoint, const Timeline& timeline, std::size_t step,
                                                bool sensed = true);

/// Where errors grow beyond all numbers, what came before is not finite.
/// @throws std::invalid_argument unless `time` is the end of a step (times of interest are) or the start.
[[nodiscard]] Adjoint adjoint(const Timeline& timeline, const FrozenGains& gains, double time);

/// Covariance from one process on each axis of a triad, independent and alike but for their size, since its epoch:
///   E[r(s) r(t)] = [D(s + P) + D(t + P) - D(|t - s|)]/2            zero at -P, D its structure function
///                = [m(s) + m(t) - D(|t - s|) - mm]/2               mean over the last T taken off
/// with m(t) the mean of D from t to that window and mm its mean within. White noise is N^2/dt in each step and
/// N^2/T in the mean. Sinusoid and ramp are not random.
/// @param imu_interval at which the process is sampled [s]: it sets what flicker is at short lags
/// @throws std::invalid_argument for quantization, ramp and sinusoid, an interval that is not positive, and more than
/// 2^62 of them since the epoch.
/// Time O(steps^2), 0.1 s for 2000; beyond these the process is held over so many neighbouring steps that 2000 are
/// left.
[[nodiscard]] navigation::CoreMatrix process_response(const Adjoint& adjoint, const Timeline& timeline,
                                                      navigation::Carrier carrier, const noise::TriadProcess& process,
                                                      const navigation::Epoch& epoch, double imu_interval);

/// Covariance from a source by its states, whatever they are: white noise, terms, initial core covariance and, where it
/// is an aid, the white noise of that aid's fixes. What error_budget finds going forwards, to rounding, in O(steps).
[[nodiscard]] navigation::CoreMatrix state_response(const Adjoint& adjoint, const Timeline& timeline,
                                                    const Source& source);

/// Without states for what varies slowly: by process_response where the source has processes, else state_response.
[[nodiscard]] navigation::CoreMatrix response(const Adjoint& adjoint, const Timeline& timeline, const Source& source,
                                              double imu_interval);

}  // namespace gyrobudget::inline v0::budget

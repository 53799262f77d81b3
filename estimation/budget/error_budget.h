// SPDX-License-Identifier: MIT
// The navigation error budget: what each source of error costs along a planned scene, by linear covariance.
//
// A filter that aids the navigator has one set of gains, from its own design model. They are computed once and
// frozen: each source then passes alone, with its true model, through the same
//   x+ = (I - K H) Phi x,
// x holding the errors of position, velocity and attitude, the filter's estimates and the source's own states.
// So sources that are independent add up exactly, and the true sigma stands beside the one the filter claims.
// Running the filter again for each source would tune it anew to that source and add up to nothing.
//
// A coarse alignment on the pad is one gain more. The attitude it starts the filter with is wrong by
//   psi_0 = G mean(dw, df),
// G the alignment's, the mean that of the source's own errors over the pad, which the filter then meets again in
// the same data. With x = x' + M psi_0, x' the errors had the start been right and M what a start of psi_0 grows to,
// E[x' psi_0^T] and E[psi_0 psi_0^T] are gathered beside E[x' x'^T] and put together where the pad ends: nothing is
// left out, neither tilt that is a bias' own nor noise that is used twice.
// Sources: Gelb (ed.), Applied Optimal Estimation (1974), section 7.2; Maybeck, Stochastic Models, Estimation and
// Control, vol. 1 (1979), section 6.8.
#pragma once

#include "gyrobudget/estimation/navigation/aiding.h"
#include "gyrobudget/estimation/navigation/covariance.h"
#include "gyrobudget/estimation/navigation/error_state.h"
#include "gyrobudget/estimation/navigation/sensor_states.h"
#include "gyrobudget/noise/imu.h"
#include "gyrobudget/noise/process.h"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "timeline.h"

namespace gyrobudget::inline v0::budget {

/// psi_e at the scene's start by mean errors over the pad, true minus sensed, of gyro x, y, z and accelerometer
/// x, y, z [rad per rad/s, rad per m/s^2]: a coarse alignment to first order (alignment.h).
using AlignmentGain = Eigen::Matrix<double, 3, 6>;

/// One line of the budget: something that is wrong, with its true size, and nothing else.
struct Source {
  std::string name;                   ///< "gyro.arw", "initial.heading", "aid.gnss.position"
  navigation::ErrorStateModel model;  ///< white noise and terms of this source
  navigation::StateMatrix initial;    ///< covariance of model.terms at the scene's start
  navigation::CoreMatrix core =
      navigation::CoreMatrix::Zero();  ///< covariance of position, velocity, attitude there, axes of e
  /// Covariance of these with the terms, where both are one error; empty: none.
  Eigen::Matrix<double, navigation::kCoreStates, Eigen::Dynamic> cross;
  int aid = -1;  ///< the white noise of this aid's fixes is the source
  /// What the terms that vary stand for, on each axis of a triad: for routes without states (adjoint.h).
  struct Slow {
    navigation::Carrier carrier = navigation::Carrier::gyro;
    std::vector<noise::TriadProcess> processes;
    navigation::Epoch epoch;
  };
  std::optional<Slow> slow;
  /// The error of a sensor that it is, for Monte Carlo, which simulates the sensor.
  struct OfSensor {
    navigation::Carrier carrier = navigation::Carrier::gyro;
    noise::ErrorSource error{};
  };
  std::optional<OfSensor> sensor;
  /// Where given, each term's effect is multiplied by it [any unit]: errors that are fixed in other axes than
  /// the body's, such as Earth's rate left out or an error of gravity.
  std::function<double(const navigation::StepInput& input, std::size_t term)> shape;
  bool sensed = true;  ///< false: the navigator makes it, no sensor: an alignment of what is sensed is free of it
};

/// The filter as it is designed: it sets the gains.
struct Design {
  navigation::ErrorStateModel model;
  navigation::StateMatrix initial;  ///< its P0, core and terms
  navigation::Form form = navigation::Form::joseph;
  std::optional<AlignmentGain> alignment;  ///< of the attitude that it starts from
};

/// Gains of every row of every fix, from the design alone.
struct FrozenGains {
  navigation::ErrorStateModel model;                 ///< of the design; empty: no filter
  std::vector<std::vector<Eigen::VectorXd>> of_fix;  ///< [fix][row], core and model.terms
  std::vector<navigation::CoreMatrix> claimed;       ///< the design's own covariance at the times of interest
  std::optional<AlignmentGain> alignment;            ///< of the attitude at the start; none: by no sensor
};
/// @throws navigation::SetupError for fixes without a design, and what Covariance refuses.
[[nodiscard]] FrozenGains frozen_gains(const Timeline& timeline, const std::optional<Design>& design);

struct Budget {
  struct Contribution {
    std::string name;
    std::vector<navigation::CoreMatrix> covariance;  ///< true errors of p, v, psi at each time, axes of e
  };
  std::vector<double> times;
  std::vector<Contribution> lines;              ///< one a source, in their order
  std::vector<navigation::CoreMatrix> total;    ///< their sum
  std::vector<navigation::CoreMatrix> claimed;  ///< what the filter believes; empty without a design
  std::size_t steps = 0;
};

/// Each source's own states s beside p, v, psi and the filter's estimates, x -> Phi x + G eps over a step and
/// x -> (I - K H) x + K eps at each row of a fix with the frozen gain K, carry P -> F P F^T + Q; p [m], v [m/s] and
/// psi [rad] of it at the times of interest are the source's line. Time: steps x sources x states^2.
/// @throws std::invalid_argument for sources whose initial covariance does not fit their terms and more states than
/// navigation::kMaxStates together with the filter's; navigation::SetupError for fixes without a design;
/// navigation::Diverged for errors that grow beyond all numbers.
[[nodiscard]] Budget error_budget(const Timeline& timeline, std::span<const Source> sources, const FrozenGains& gains);
[[nodiscard]] Budget error_budget(const Timeline& timeline, std::span<const Source> sources,
                                  const std::optional<Design>& design = {});

}  // namespace gyrobudget::inline v0::budget

// SPDX-License-Identifier: MIT
#pragma once

#include "model.h"

namespace gyrobudget::inline v0::noise {

/// Model 3 of Nunes et al., after M. S. Bielas, "Stochastic and dynamic modeling of fiber gyros", Proc. SPIE
/// 2292 (1994) 240-254: angle random walk and a bias, y_k = N u_k / sqrt(dt) + c_k, with four readings of "bias
/// instability":
///
///     integrated_legacy  c_{k+1} = c_k + B dt v_k      what the paper's numbers show it did
///     plain_white        c_k = B v_k                   "a simple random variation"
///     gauss_markov       c stationary, standard deviation B, correlation time Tc
///     flicker            c the 1/f process             "a more complex model"
///
/// and a rate random walk besides where `rrw` is not zero. PSD: the sum of those in process.h of White{N},
/// RateRandomWalk{K} and, in this order, RateRandomWalk{B sqrt(dt)}, White{B sqrt(dt)}, GaussMarkov{B, Tc},
/// Flicker{B}.
///
/// Where it departs from IEEE Std 952:
/// - integrated_legacy takes B, a rate, for the standard deviation *per sample* of a rate of change of the rate
///   (B rad/s is used as B rad/s^2). The result has no floor: it is a rate random walk of K_eff = B sqrt(dt),
///   in usual units 60 B sqrt(dt) deg/h/sqrt(h) (B in deg/h, dt in s): 6 B at 100 Hz, 60 B at 1 Hz. The sample
///   rate sets the noise. It serves to reproduce published results, nothing else.
/// - plain_white adds B^2 dt to N^2: no floor either, and it too depends on the sample rate.
/// - gauss_markov has a top of 0.617 B at tau = 1.89 Tc where the flat of 1/f noise is 0.664 B, and falls off
///   on both sides.
/// Nothing is truncated and nothing biased by the start.
struct Bielas {
  enum class Bias { integrated_legacy, plain_white, gauss_markov, flicker };

  double arw = 0;               ///< N [rad/sqrt(s)]
  double bias_instability = 0;  ///< B [rad/s]
  double rrw = 0;               ///< K [rad/s/sqrt(s)]; the paper's simulation has none
  Bias bias = Bias::integrated_legacy;
  double correlation_time = 100;  ///< Tc [s], of gauss_markov

  /// The paper's model sampled at dt [s]. @throws std::invalid_argument for a Bias that is none, dt not
  /// positive and finite.
  [[nodiscard]] Model model(double dt) const;
};

}  // namespace gyrobudget::inline v0::noise

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "error_state.h"
#include "errors.h"

namespace gyrobudget::inline v0::navigation {

/// When the bias of a sensor was known last. 1/f noise and random walk have no variance, only one of what they
/// have moved since some time: without this their effect on a scene is not defined.
struct Epoch {
  /// Both are zero this long before the scene starts, beside the turn-on bias [s].
  double powered_on_before = 0;
  /// The mean of the sensor's output over this long until the scene starts was taken off: turn-on bias,
  /// powered_on_before and a Gauss-Markov process' past then count no more; white noise leaves N/sqrt(T) [s].
  std::optional<double> calibrated_over;
};

/// That of a sensor file, which counts from the scene's start.
[[nodiscard]] Epoch epoch_of(const noise::ErrorModel& errors);
/// @throws SetupError for a calibration of 0 s or less, a negative powered_on_before, naming the triad.
void check(const Epoch& epoch, std::string_view triad);

/// What becomes of a constant that a datasheet gives: a state to be estimated, one that is only counted
/// (Schmidt), or none.
enum class Use { estimated, considered, left_out };

/// From a sensor file to the states that a scene needs, and no others.
///
/// Per axis and triad, with r(t) what is left of the slow errors since the epoch:
///   one bias state       turn-on bias, vibration rectification, random walk K, and what flicker has moved more
///                        slowly than its band
///   Gauss-Markov states  flicker, by flicker_states(); each gauss_markov entry of the file that the axis has
/// and, where the file has them, scale factor, misalignment (six a triad), g-sensitivity (nine) and g2-sensitivity.
///
/// Flicker is F(t) = sum g_i(t), g_i stationary; its value at the epoch leaves it, so the bias state starts
/// correlated with each g_i: with sum g_i(-P) taken off for a sensor switched on P before,
///   cov(c, g_i) = -sigma_i^2 exp(-P/T_i),
/// and with the mean over the last T taken off, c = -mean(g_i) - mean(K walk) - mean(white):
///   cov(c, g_i) = -sigma_i^2 h,  h = (1 - e^-a)/a,  a = T/T_i,  var mean(g_i) = 2 sigma_i^2 (1 - h)/a,
///   var mean(walk) = K^2 T/3,  var mean(white) = N^2/T.
/// What the true structure function D has moved beyond the band adds to c's variance.
struct SensorStates {
  struct Options {
    double scene_length = 0;                   ///< [s], positive
    double step = 0.01;                        ///< interval of the IMU [s], positive
    std::optional<Epoch> gyro, accelerometer;  ///< in place of the sensor file's
    /// How the temperature goes from the scene's start on; not given: at the reference of the sensor file.
    std::optional<noise::TemperatureProfile> temperature;
    double vibration = 0;  ///< level that vibration rectification sees [m/s^2 rms]
    /// Gauss-Markov states for flicker, per axis; not given: the fewest, up to 3, that hold the Allan
    /// deviation of all noise together at the scene's length to `tolerance`.
    std::optional<int> flicker_states;
    double tolerance = 0.01;
    /// Start of the band of flicker [s]; not given: scene_length/100. The bias over shorter times than this holds
    /// more than its states say, though not by what reaches velocity: where it is looked at itself, give its time.
    std::optional<double> shortest;
    Use scale_factor = Use::estimated;
    Use misalignment = Use::estimated;
    Use g_sensitivity = Use::estimated;  ///< and g2_sensitivity
  };
  /// What the file has and the states leave out, with a word why.
  struct LeftOut {
    std::string what;
    std::string why;
  };

  ErrorStateModel model;
  StateMatrix initial;  ///< covariance of model.terms at the scene's start
  std::vector<LeftOut> left_out;
};

/// The band of flicker is from `shortest` (not below `step`) to scene_length. What is faster than a hundredth of the
/// scene acts as white noise below 1e-4 of flicker's own Allan variance at its length, what is slower than the scene is
/// constant within it.
/// A sensor without an error has no state for it; `accelerometer` left out of the file has none at all.
/// @throws SetupError for options out of range, a calibration of 0 s or less, a negative
/// powered_on_before, and more than kMaxErrorTerms states.
[[nodiscard]] SensorStates sensor_states(const noise::SensorModel& sensor, const SensorStates::Options& options);

/// blockdiag(core, terms): the P0 of a filter.
[[nodiscard]] StateMatrix initial_covariance(const CoreMatrix& core, const StateMatrix& terms);

}  // namespace gyrobudget::inline v0::navigation

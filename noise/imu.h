// SPDX-License-Identifier: MIT
// A whole inertial measurement unit: what it reads where an ideal one would read the truth.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <optional>
#include <vector>

#include "increment.h"
#include "sensor.h"

namespace gyrobudget::inline v0::noise {

using Matrix3 = std::array<Vector3, 3>;  ///< element [i][j] acts on axis i by what is along j

/// What an error model holds, one bit each, for switching on and off.
enum class ErrorSource : unsigned {
  turn_on_bias,
  scale_factor,
  misalignment,
  g_sensitivity,
  g2_sensitivity,
  vibration_rectification,
  white,
  flicker,
  rate_random_walk,
  rate_ramp,
  gauss_markov,
  sinusoid,
  quantization,
  bandwidth,
  delay,
  range,
  temperature,
};

/// A set of them.
class ErrorSources {
 public:
  constexpr ErrorSources(std::initializer_list<ErrorSource> sources = {}) {
    for (const ErrorSource s : sources) bits_ |= bit(s);
  }
  [[nodiscard]] static constexpr ErrorSources all() { return from_bits(~0U); }
  [[nodiscard]] constexpr ErrorSources with(ErrorSource s) const { return from_bits(bits_ | bit(s)); }
  [[nodiscard]] constexpr ErrorSources without(ErrorSource s) const { return from_bits(bits_ & ~bit(s)); }
  [[nodiscard]] constexpr bool has(ErrorSource s) const { return (bits_ & bit(s)) != 0; }

 private:
  static constexpr unsigned bit(ErrorSource s) { return 1U << static_cast<unsigned>(s); }
  static constexpr ErrorSources from_bits(unsigned bits) {
    ErrorSources result;
    result.bits_ = bits;
    return result;
  }
  unsigned bits_ = 0;
};

/// The model with nothing but these sources; its epoch stays.
[[nodiscard]] ErrorModel only(const ErrorModel& model, const ErrorSources& sources);

/// The errors that a triad's model leaves open, of those that a log at rest cannot tell and a budget is small without:
/// turn-on bias (unless a calibration takes it off), scale factor, misalignment, and of a gyro g-sensitivity. What is
/// stated to be zero is not among them.
[[nodiscard]] std::vector<ErrorSource> not_stated(const ErrorModel& model, Signal signal);

/// Names the random numbers of one IMU in one run.
struct ImuKey {
  std::uint64_t seed = 1;
  std::uint64_t run = 0;  ///< below 2^45
};

/// What a run has drawn for one triad and keeps: the truth that a filter would estimate.
struct TriadConstants {
  Vector3 turn_on_bias = {};     ///< [signal]
  Vector3 scale_factor = {};     ///< [1]
  Matrix3 misalignment = {};     ///< [rad], zero on the diagonal
  Matrix3 g_sensitivity = {};    ///< [signal/(m/s^2)]
  Vector3 g2_sensitivity = {};   ///< [signal/(m/s^2)^2]
  Vector3 vibration_bias = {};   ///< coefficient times the square of the vibration level [signal]
  Vector3 calibrated_bias = {};  ///< what a calibration found and takes off every reading [signal]
};

struct ImuConstants {
  TriadConstants gyro, accelerometer;
};

/// One IMU in one run. Fed with ideal increments, it returns measured ones. With u the true increment of a
/// triad (angle or velocity), v the true velocity increment, f = v/dt and x_k the noise of sample k
/// (process.h has it sampled), axis i of the triad reads
///
///     sensed    e_i = u_i (1 + s_i) + sum_{j != i} M_ij u_j + sum_j G_ij v_j + D_i f_i^2 dt
///     response  r = low pass and delay of e
///     raw       z_i = r_i + (turn-on bias + V_i level^2 + temperature + flicker + walk + ramp + Gauss-Markov +
///                            sinusoid + white) dt, kept within +-range dt
///     reading   y_i = z_i to a whole number of least significant bits, less calibrated_bias_i dt
///
/// - **Drawn once a run**, normal with the model's std: turn-on bias, s, the six M_ij (a non-orthogonality:
///   each angle is
///   independent, rows are axes; M_ij = -M_ji would be a rotation of the case), the nine G_ij (gyros only),
/// D, V.
/// - **Temperature**: TemperatureModel::bias at the middle of the interval, where Options::temperature says how
///   it goes from the first sample on; it is of the sensor, not drawn, and a calibration leaves it.
/// - **Response**: it acts on what is sensed. ErrorModel::filter acts on white noise as well (not on the part of it in
///   a calibration's mean, which lacks a memory of the filter over T of its variance); the other coefficients are those
///   of the output. First order 1/(1 + s/w) or second order Butterworth, w = 2 pi bandwidth, -3 dB at the bandwidth,
///   exact for increments of rates that are constant over a sample, or a moving average of the samples. A delay of a
///   fraction of a sample shares the increments of both; exact for such rates too. All are settled at the first
///   increment.
/// - **Quantization**: bits of Q sqrt(12). What is left over goes to the next reading, so the sum of the
///   readings is never off by a bit from that of z, however many there are; the first remainder is uniform.
/// - **Range** saturates z and counts the samples of each axis where it did.
///
/// **Epoch**: flicker, random walk and ramp are zero at power-on, powered_on_before the first sample (none
/// given: at the first sample) and run on; Gauss-Markov is stationary throughout; a sinusoid counts time from
/// the first sample. `calibrated_over` T: the mean of what was read over the T before the first sample, in
/// error of the truth at rest and without vibration, is taken off: turn-on bias, noise of every kind and
/// quantization are in it, errors that depend on the motion (s, M, G, D) are not. The turn-on bias cancels;
/// of flicker remains b(t) less its mean. Then powered_on_before cannot be shorter than T, and where it is
/// not given it is T; the law of the readings does not depend on it. Times are rounded to whole samples.
/// A level that is taken from one sample holds all of flicker's band, so without a calibration the variance
/// of b(t) grows with the logarithm of the sample rate, by 1.47 B^2 a decade.
///
/// What comes before the first sample is not run through: flicker is noise::flicker_approximation, so all
/// that has a past is a first-order state whose value at the start and whose sum over the calibration are
/// jointly normal, with moments composed by doubling the interval. An hour or a decade costs as much as a
/// second.
///
/// Each source of each axis draws from a stream of its own, keyed by (seed, run): switching one off leaves
/// the numbers of the others as they are, and readings do not depend on how calls are grouped or runs
/// ordered. A triad without errors costs a copy. next() allocates nothing.
///
///     noise::Imu imu(sensor, 0.01, {.seed = 1, .run = 7});
///     for (const auto& truth : increments) use(imu.next(truth));
class Imu {
 public:
  struct Options {
    double vibration = 0;                              ///< level [m/s^2 rms]
    std::optional<TemperatureProfile> temperature;     ///< from the first sample on; unset: at the reference
    std::optional<double> powered_on_before;           ///< for both triads, in place of the model's
    std::optional<double> calibrated_over;             ///< as well
    ErrorSources gyro = ErrorSources::all();           ///< what is on
    ErrorSources accelerometer = ErrorSources::all();  ///< what is on
    double duration = 1e4;                             ///< [s] over which flicker is to be right, beside its past
    double poles_per_decade = 2;  ///< of flicker: 0.02 % error of its Allan deviation, see flicker_approximation
  };

  /// Increments are those of intervals of dt [s].
  /// @throws std::invalid_argument for dt, a vibration level, a duration or a coefficient that is negative (ramp: any
  /// sign) or not finite, a filter's bandwidth that is not positive, or below 1e-4 of the rate where there is white
  /// noise, a delay of more than 1e7 samples, an epoch of more than 2^62 samples or one that ends in the calibration,
  /// run >= 2^45, and what flicker_approximation refuses.
  Imu(const SensorModel& model, double dt, ImuKey key, const Options& options);
  Imu(const SensorModel& model, double dt, ImuKey key) : Imu(model, dt, key, Options()) {}
  ~Imu();
  Imu(Imu&&) noexcept;
  Imu& operator=(Imu&&) noexcept;

  /// What is measured over the next interval.
  [[nodiscard]] ImuIncrement next(const ImuIncrement& truth);

  [[nodiscard]] const ImuConstants& constants() const;
  /// All that varies slowly or not at all, as it was over the last sample (before the first: zero) [signal]:
  /// turn-on bias, vibration rectification, flicker, random walk, ramp and Gauss-Markov, less
  /// calibrated_bias.
  [[nodiscard]] const Vector3& gyro_bias() const;
  [[nodiscard]] const Vector3& accelerometer_bias() const;
  /// Samples so far at which an axis was out of range.
  [[nodiscard]] const std::array<std::uint64_t, 3>& gyro_saturated() const;
  [[nodiscard]] const std::array<std::uint64_t, 3>& accelerometer_saturated() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace gyrobudget::inline v0::noise

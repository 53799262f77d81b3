// SPDX-License-Identifier: MIT
// The error state of an inertial navigator and how it moves from step to step: the model that filter,
// smoother, alignment and error budget share.
//
// Order: x = [dp_e, dv_e, psi_e | s_1 ... s_n], truth minus estimate,
//   p_eb_e = p^ + dp_e,  v_eb_e = v^ + dv_e,  q_eb = exp(psi_e) q^_eb   (psi on the left, in ECEF axes),
// and s_k an error of a sensor or of an aid. Against Earth (Groves 2013, section 14.2.2, in this sign):
//   d(dp)/dt  = dv
//   d(dv)/dt  = G dp - 2 [w_ie x] dv - [C_eb f x] psi + C_eb df
//   d(psi)/dt = -[w_ie x] psi + C_eb dw
// where dw = w_ib_b - w^_ib_b and df alike come from the sensor states, and G is the gradient of gravity.
#pragma once

#include "gyrobudget/vehicle/earth/trajectory.h"

#include <array>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "errors.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::navigation {

inline constexpr int kCoreStates = 9;      ///< dp, dv, psi
inline constexpr int kPosition = 0;        ///< first row of dp
inline constexpr int kVelocity = 3;        ///< first row of dv
inline constexpr int kAttitude = 6;        ///< first row of psi
inline constexpr int kMaxErrorTerms = 63;  ///< most sensor and aid states
inline constexpr int kMaxStates = kCoreStates + kMaxErrorTerms;

/// Sizes are chosen at run time below a fixed maximum, so that a filter's loop allocates nothing.
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxStates, 1>;
using StateMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxStates, kMaxStates>;
using CoreMatrix = Eigen::Matrix<double, kCoreStates, kCoreStates>;
/// Effect of one unit of error of gyro x, y, z and accelerometer x, y, z, held over a step.
using InputMatrix = Eigen::Matrix<double, kCoreStates, 6>;

/// What carries a modelled error.
enum class Carrier { gyro, accelerometer, aid };

/// How it enters. With u the sensor's input (w_ib_b [rad/s] or f_ib_b [m/s^2]) and e_i a body axis, the
/// measured signal is u + ... plus
///   bias           s e_axis                     [signal]
///   scale_factor   s u_axis e_axis              [1]
///   misalignment   s u_input e_axis             [rad], axis != input
///   g_sensitivity  s f_input e_axis             [rad/s per m/s^2], gyro only
///   g2_sensitivity s f_axis^2 e_axis            [signal/(m/s^2)^2]
/// and for an aid, of number `aid`,
///   bias           s on component `axis` of what it measures, in its own axes and unit
///   lever_arm      s along body axis `axis`     [m], from IMU to antenna
///   time_tag       s, measured later than stated by [s]; no axis
enum class Effect { bias, scale_factor, misalignment, g_sensitivity, g2_sensitivity, lever_arm, time_tag };

/// One state beyond position, velocity and attitude: first-order Gauss-Markov, random walk or constant,
///   ds/dt = -s/correlation_time + w,  w white of two-sided density walk^2.
struct ErrorTerm {
  Carrier carrier = Carrier::gyro;
  Effect effect = Effect::bias;
  int axis = 0;                                                       ///< 0 to 2
  int input = 0;                                                      ///< 0 to 2, of misalignment and g-sensitivity
  int aid = 0;                                                        ///< number of the aid
  int aids = 1;                                                       ///< aids that share it: `aid` and those after it
  double correlation_time = std::numeric_limits<double>::infinity();  ///< positive [s]
  double walk = 0;          ///< K [unit/sqrt(s)]; sigma sqrt(2/Tc) keeps a Gauss-Markov state stationary
  bool considered = false;  ///< Schmidt: counted in the covariance, never corrected

  /// Whether it is an error of the aid with this number.
  [[nodiscard]] bool is_of_aid(int number) const {
    return carrier == Carrier::aid && aid <= number && number < aid + aids;
  }
};

/// exp(-dt/Tc): what is left of a term after dt [s].
[[nodiscard]] double decay(const ErrorTerm& term, double dt);
/// Mean of exp(-t/Tc) over 0 to dt: what acts of a term over a step, by its value at the start.
[[nodiscard]] double mean_decay(const ErrorTerm& term, double dt);

/// White noise of the sensors and the states beyond the core.
struct ErrorStateModel {
  Eigen::Vector3d gyro_white = Eigen::Vector3d::Zero();           ///< N of each axis [rad/sqrt(s)]
  Eigen::Vector3d accelerometer_white = Eigen::Vector3d::Zero();  ///< [m/s/sqrt(s)]
  std::vector<ErrorTerm> terms;

  [[nodiscard]] int states() const { return kCoreStates + static_cast<int>(terms.size()); }
  /// @throws SetupError for numbers that are not finite or out of range, more than kMaxErrorTerms
  /// terms, a misalignment on its own axis, an effect that its carrier does not have.
  void check() const;
};

/// "gyro bias x", "accelerometer misalignment y<-z", "aid 0 lever arm x".
[[nodiscard]] std::string name(const ErrorTerm& term);

/// One step of the linear model,
///   x+ = Phi x + noise,  Phi = [core, coupling; 0, diag(decay)],  noise covariance Q = G diag(q) G^T,
/// in factors that cost little to apply. A navigator uses the mean of a signal over a step, so only mean
/// errors enter: coupling column k is input.col(signal_k) gain_k, and white noise enters as the mean rate's
/// variance N^2/dt through `input`. That is exact for a strapdown fed with increments, not an approximation
/// in dt. A state's noise and the mean of it over the step are drawn jointly (closed form):
///   G = [input | kick_1 ... kick_n],  kick_k = input.col(signal_k) spill_k + e_(9+k).
/// Attitude is moved by itself and the gyro alone: core(6 ... 8, 0 ... 5) and input(6 ... 8, 3 ... 5) are
/// zero.
struct Transition {
  struct Term {
    int signal = -1;   ///< column of `input`; -1: aids touch no navigation state
    double decay = 1;  ///< exp(-dt/Tc)
    double gain = 0;   ///< of the state at the start of the step on the mean error of its signal
    double noise = 0;  ///< variance added to the state over the step
    double spill = 0;  ///< mean error of the signal per unit of that noise
  };
  double dt = 0;
  CoreMatrix core = CoreMatrix::Identity();
  InputMatrix input = InputMatrix::Zero();
  Eigen::Matrix<double, 6, 1> input_noise = Eigen::Matrix<double, 6, 1>::Zero();  ///< variances of mean errors
  std::array<Term, kMaxErrorTerms> terms;
  int size = kCoreStates;  ///< states; terms[0 ... size - 9) count

  /// Phi and Q in full: for tests, smoothing over long steps and print-outs.
  [[nodiscard]] StateMatrix matrix() const;
  [[nodiscard]] StateMatrix noise() const;
};

/// What the model is linearised about: means over one step.
struct StepInput {
  double dt = 0;           ///< [s]
  Eigen::Vector3d p_eb_e;  ///< [m]
  Eigen::Matrix3d C_eb;    ///< at mid-step
  Eigen::Vector3d w_ib_b;  ///< [rad/s]
  Eigen::Vector3d f_ib_b;  ///< [m/s^2]
  double t = 0;            ///< at mid-step, since the start of the scene, for errors that go with time [s]
  /// White noise of the mean rate and force beside the model's own, for motion that was not measured: densities
  /// of gyro x, y, z [rad^2/s] and accelerometer x, y, z [m^2/s^3].
  Eigen::Matrix<double, 6, 1> unknown = Eigen::Matrix<double, 6, 1>::Zero();
};

/// Makes the transitions of one model. What depends on dt alone is kept from step to step.
class Lineariser {
 public:
  /// @throws SetupError for what ErrorStateModel::check refuses.
  explicit Lineariser(ErrorStateModel model);

  [[nodiscard]] const ErrorStateModel& model() const { return model_; }
  [[nodiscard]] int states() const { return model_.states(); }

  /// Phi of the core is exp(F dt), to rounding for dt above kSecondOrder and to second order in dt up to it.
  /// What is then left out turns position by |f| w_ie dt^3/2 for a unit attitude error and the inputs by w_ie
  /// dt of themselves: 1e-6 of them at 10 ms. The motion of f within a step adds (w dt)^2/12 of what f does
  /// in it.
  /// @throws std::invalid_argument unless dt > 0 and finite.
  [[nodiscard]] const Transition& operator()(const StepInput& step);
  static constexpr double kSecondOrder = 0.05;  ///< [s]

 private:
  void set_interval(double dt);

  ErrorStateModel model_;
  Transition transition_;
  std::array<double, kMaxErrorTerms> mean_decay_{};  ///< mean of exp(-t/Tc) over the step
  std::array<double, kMaxErrorTerms> mean_noise_{};  ///< spill of a unit sensitivity
  std::array<double, kMaxErrorTerms> rest_noise_{};  ///< variance of the mean that the state does not share
};

/// Effect of the error terms on what the sensors read, for estimates s of them: subtract it.
struct SensorCorrection {
  Eigen::Vector3d gyro = Eigen::Vector3d::Zero();           ///< [rad/s]
  Eigen::Vector3d accelerometer = Eigen::Vector3d::Zero();  ///< [m/s^2]
};
/// `values[k]` belongs to terms[k]; w and f are the true signals, or estimates of them.
[[nodiscard]] SensorCorrection sensor_errors(std::span<const ErrorTerm> terms, const double* values,
                                             const Eigen::Vector3d& w_ib_b, const Eigen::Vector3d& f_ib_b);

}  // namespace gyrobudget::inline v0::navigation

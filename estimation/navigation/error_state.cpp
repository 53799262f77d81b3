// SPDX-License-Identifier: MIT
#include "error_state.h"

#include "gyrobudget/estimation/navigation/detail/gauss_markov.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/gravity.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <string_view>

namespace gyrobudget::inline v0::navigation {
namespace {

using detail::mean_exponential;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// 8-point Gauss-Legendre rule on [0, 1] (Abramowitz & Stegun 25.4.30), symmetric about 1/2.
constexpr std::array<double, 4> kNodes{0.18343464249564981, 0.52553240991632899, 0.79666647741362674,
                                       0.96028985649753623};
constexpr std::array<double, 4> kWeights{0.36268378337836198, 0.31370664587788729, 0.22238103445337447,
                                         0.10122853629037626};

template <typename Function>
double integral_0_1(Function f) {
  double sum = 0;
  for (std::size_t i = 0; i < kNodes.size(); ++i)
    sum += kWeights[i] / 2 * (f((1 - kNodes[i]) / 2) + f((1 + kNodes[i]) / 2));
  return sum;
}

// Variance of a step's mean that the state at its end does not share, over walk^2 dt; a = dt/Tc. The mean is
// the integral of w(u) (1 - e^(-a u))/a and the state that of w(u) e^(-a u), u back from the step's end.
// Above a = 1 nothing cancels in the closed form; below, the square of the difference is integrated.
double unshared_variance(double a, double spill) {
  if (a > 1) {
    const double h = mean_exponential(a), h2 = mean_exponential(2 * a);
    return (1 - 2 * h + h2) / (a * a) - spill * spill * h2;
  }
  return integral_0_1([&](double u) {
    const double left = u * mean_exponential(a * u) - spill * std::exp(-a * u);
    return left * left;
  });
}

void require(bool good, const ErrorTerm& term, std::string_view what, double value, std::string_view expected) {
  if (!good) throw SetupError(fmt::format("{}: {} is {}, expected {}", name(term), what, value, expected));
}

void check_term(const ErrorTerm& term) {
  require(term.axis >= 0 && term.axis < 3, term, "axis", term.axis, "0, 1 or 2");
  require(term.input >= 0 && term.input < 3, term, "input", term.input, "0, 1 or 2");
  require(term.effect != Effect::misalignment || term.axis != term.input, term, "input", term.input,
          "an axis other than its own");
  require(term.correlation_time > 0, term, "correlation time", term.correlation_time, "above 0 s");
  require(term.walk >= 0 && std::isfinite(term.walk), term, "walk", term.walk, "0 or more and finite");
  require(term.aid >= 0, term, "aid", term.aid, "0 or more");
  require(term.aids >= 1, term, "number of its aids", term.aids, "1 or more");
  const bool of_aid = term.effect == Effect::lever_arm || term.effect == Effect::time_tag;
  const bool of_sensor = term.effect == Effect::scale_factor || term.effect == Effect::misalignment ||
                         term.effect == Effect::g_sensitivity || term.effect == Effect::g2_sensitivity;
  const bool of_gyro = term.effect == Effect::g_sensitivity;
  const bool good = term.carrier == Carrier::aid ? !of_sensor : !of_aid && (!of_gyro || term.carrier == Carrier::gyro);
  if (!good) throw SetupError(fmt::format("{}: there is no such error", name(term)));
}

// Change of what a sensor reads in its axis by a unit of the term.
double sensitivity(const ErrorTerm& term, const Vector3d& w_ib_b, const Vector3d& f_ib_b) {
  const Vector3d& own = term.carrier == Carrier::gyro ? w_ib_b : f_ib_b;
  switch (term.effect) {
    case Effect::scale_factor:
      return own[term.axis];
    case Effect::misalignment:
      return own[term.input];
    case Effect::g_sensitivity:
      return f_ib_b[term.input];
    case Effect::g2_sensitivity:
      return f_ib_b[term.axis] * f_ib_b[term.axis];
    default:
      return 1;
  }
}

}  // namespace

void ErrorStateModel::check() const {
  const auto check_white = [](const Vector3d& n, std::string_view what) {
    if (!(n.array() >= 0).all() || !n.allFinite())
      throw SetupError(fmt::format("{} is ({}, {}, {}), expected 0 or more and finite", what, n[0], n[1], n[2]));
  };
  check_white(gyro_white, "white noise of the gyro [rad/sqrt(s)]");
  check_white(accelerometer_white, "white noise of the accelerometer [m/s/sqrt(s)]");
  if (terms.size() > kMaxErrorTerms)
    throw SetupError(fmt::format("{} error terms, the filter holds at most {}", terms.size(), kMaxErrorTerms));
  for (const auto& term : terms) check_term(term);
}

double decay(const ErrorTerm& term, double dt) { return std::exp(-dt / term.correlation_time); }

double mean_decay(const ErrorTerm& term, double dt) { return mean_exponential(dt / term.correlation_time); }

std::string name(const ErrorTerm& term) {
  constexpr std::string_view axes = "xyz";
  constexpr std::array<std::string_view, 7> effects{"bias",           "scale factor", "misalignment", "g-sensitivity",
                                                    "g2-sensitivity", "lever arm",    "time tag"};
  const auto axis = [&](int i) { return i >= 0 && i < 3 ? axes.substr(static_cast<std::size_t>(i), 1) : "?"; };
  const std::string carrier = term.carrier == Carrier::gyro            ? "gyro"
                              : term.carrier == Carrier::accelerometer ? "accelerometer"
                                                                       : fmt::format("aid {}", term.aid);
  const std::string start = fmt::format("{} {}", carrier, effects[static_cast<std::size_t>(term.effect)]);
  switch (term.effect) {
    case Effect::time_tag:
      return start;
    case Effect::misalignment:
    case Effect::g_sensitivity:
      return fmt::format("{} {}<-{}", start, axis(term.axis), axis(term.input));
    default:
      return fmt::format("{} {}", start, axis(term.axis));
  }
}

StateMatrix Transition::matrix() const {
  StateMatrix phi = StateMatrix::Zero(size, size);
  phi.topLeftCorner<kCoreStates, kCoreStates>() = core;
  for (int k = 0; k + kCoreStates < size; ++k) {
    const Term& term = terms[static_cast<std::size_t>(k)];
    phi(kCoreStates + k, kCoreStates + k) = term.decay;
    if (term.signal >= 0) phi.col(kCoreStates + k).head<kCoreStates>() = term.gain * input.col(term.signal);
  }
  return phi;
}

StateMatrix Transition::noise() const {
  StateMatrix q = StateMatrix::Zero(size, size);
  q.topLeftCorner<kCoreStates, kCoreStates>() = input * input_noise.asDiagonal() * input.transpose();
  StateVector kick(size);
  for (int k = 0; k + kCoreStates < size; ++k) {
    const Term& term = terms[static_cast<std::size_t>(k)];
    kick.setZero();
    kick[kCoreStates + k] = 1;
    if (term.signal >= 0) kick.head<kCoreStates>() = term.spill * input.col(term.signal);
    q += term.noise * kick * kick.transpose();
  }
  return q;
}

Lineariser::Lineariser(ErrorStateModel model) : model_(std::move(model)) {
  model_.check();
  transition_.size = model_.states();
  for (std::size_t k = 0; k < model_.terms.size(); ++k) {
    const ErrorTerm& term = model_.terms[k];
    const int first = term.carrier == Carrier::gyro ? 0 : 3;
    transition_.terms[k].signal = term.carrier == Carrier::aid ? -1 : first + term.axis;
  }
}

void Lineariser::set_interval(double dt) {
  if (dt == transition_.dt && dt > 0) return;
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("step of {} s, expected above 0 s and finite", dt));
  for (std::size_t k = 0; k < model_.terms.size(); ++k) {
    const ErrorTerm& term = model_.terms[k];
    const double a = dt / term.correlation_time;
    const double density = term.walk * term.walk;
    const double h = mean_exponential(a), h2 = mean_exponential(2 * a);
    mean_decay_[k] = h;
    mean_noise_[k] = h * h / (2 * h2);
    rest_noise_[k] = density * dt * unshared_variance(a, mean_noise_[k]);
    transition_.terms[k].decay = std::exp(-a);
    transition_.terms[k].noise = density * dt * h2;
  }
  transition_.dt = dt;
}

namespace {

const Matrix3d& earth_rate() {
  static const Matrix3d turn = earth::skew({0, 0, earth::wgs84::kEarthRate});
  return turn;
}

// exp(F dt) and its integral times B, to second order: seven blocks and five.
void expand(const StepInput& step, const Matrix3d& force, const Matrix3d& gradient, CoreMatrix& core,
            InputMatrix& input) {
  const double dt = step.dt, half = dt * dt / 2;
  const Matrix3d& turn = earth_rate();
  const Matrix3d identity = Matrix3d::Identity();
  core.block<3, 3>(kPosition, kPosition) = identity + half * gradient;
  core.block<3, 3>(kPosition, kVelocity) = dt * identity - 2 * half * turn;
  core.block<3, 3>(kPosition, kAttitude) = -half * force;
  core.block<3, 3>(kVelocity, kPosition) = dt * gradient - 2 * half * turn * gradient;
  core.block<3, 3>(kVelocity, kVelocity) = identity - 2 * dt * turn + half * (gradient + 4 * turn * turn);
  core.block<3, 3>(kVelocity, kAttitude) = -dt * force + half * (2 * turn * force + force * turn);
  core.block<3, 3>(kAttitude, kAttitude) = identity - dt * turn + half * turn * turn;

  const Matrix3d tilt = force * step.C_eb;
  input.block<3, 3>(kPosition, 0) = -dt * half / 3 * tilt;
  input.block<3, 3>(kVelocity, 0) = -half * tilt;
  input.block<3, 3>(kAttitude, 0) = dt * step.C_eb;
  input.block<3, 3>(kPosition, 3) = half * step.C_eb;
  input.block<3, 3>(kVelocity, 3) = dt * step.C_eb;
}

// The same by the whole series. F's eigenvalues are Schuler's and Earth's, 1.2e-3 rad/s at most beside the
// vertical's, so that at 100 s a term is below a tenth of the one before it.
void sum_series(const StepInput& step, const Matrix3d& force, const Matrix3d& gradient, CoreMatrix& core,
                InputMatrix& input) {
  constexpr int kMostTerms = 200;
  CoreMatrix F = CoreMatrix::Zero();
  F.block<3, 3>(kPosition, kVelocity).setIdentity();
  F.block<3, 3>(kVelocity, kPosition) = gradient;
  F.block<3, 3>(kVelocity, kVelocity) = -2 * earth_rate();
  F.block<3, 3>(kVelocity, kAttitude) = -force;
  F.block<3, 3>(kAttitude, kAttitude) = -earth_rate();
  CoreMatrix power = CoreMatrix::Identity(), integral = step.dt * power;  // (F dt)^k/k!, its sum by time
  core = power;
  for (int k = 1; k < kMostTerms; ++k) {
    power = (step.dt / k * F).lazyProduct(power).eval();
    core += power;
    integral += step.dt / (k + 1) * power;
    if ((power.array().abs() <= 1e-17 * core.array().abs()).all()) break;
  }
  input.leftCols<3>() = integral.middleCols<3>(kAttitude) * step.C_eb;
  input.rightCols<3>() = integral.middleCols<3>(kVelocity) * step.C_eb;
}

}  // namespace

const Transition& Lineariser::operator()(const StepInput& step) {
  set_interval(step.dt);
  const double dt = step.dt;
  const Matrix3d force = earth::skew(step.C_eb * step.f_ib_b);
  const Matrix3d gradient = earth::normal_gravity_gradient(step.p_eb_e);
  (dt <= kSecondOrder ? expand : sum_series)(step, force, gradient, transition_.core, transition_.input);

  transition_.input_noise << model_.gyro_white.array().square() / dt, model_.accelerometer_white.array().square() / dt;
  transition_.input_noise += step.unknown / dt;
  for (std::size_t k = 0; k < model_.terms.size(); ++k) {
    Transition::Term& term = transition_.terms[k];
    if (term.signal < 0) continue;
    // A sensor that reads too much makes the navigator turn too far: truth minus estimate is the negative.
    const double s = -sensitivity(model_.terms[k], step.w_ib_b, step.f_ib_b);
    term.gain = s * mean_decay_[k];
    term.spill = s * mean_noise_[k];
    transition_.input_noise[term.signal] += s * s * rest_noise_[k];
  }
  return transition_;
}

SensorCorrection sensor_errors(std::span<const ErrorTerm> terms, const double* values, const Vector3d& w_ib_b,
                               const Vector3d& f_ib_b) {
  SensorCorrection errors;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    if (terms[k].carrier == Carrier::aid) continue;
    Vector3d& signal = terms[k].carrier == Carrier::gyro ? errors.gyro : errors.accelerometer;
    signal[terms[k].axis] += sensitivity(terms[k], w_ib_b, f_ib_b) * values[k];
  }
  return errors;
}

}  // namespace gyrobudget::inline v0::navigation

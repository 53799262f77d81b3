// SPDX-License-Identifier: MIT
// Truth here: numerical derivatives of the strapdown itself, what each error does to a sensor written out
// once more, and the continuous model of a term integrated in long double by doubling.
#include "gyrobudget/estimation/navigation/error_state.h"

#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <cmath>

#include "reference.h"

using namespace gyrobudget;  // NOLINT
using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::Carrier;
using navigation::Effect;
using navigation::ErrorTerm;
using navigation::kAttitude;
using navigation::kCoreStates;
using navigation::kPosition;
using navigation::kVelocity;

namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr double kRate = earth::wgs84::kEarthRate;
constexpr double kGradient = 3.1e-6;     // largest of the gravity gradient [1/s^2]
constexpr double kGradientError = 2e-4;  // of it, that its closed form leaves out; and of a chord for a tangent

using CoreVector = Eigen::Matrix<double, kCoreStates, 1>;

struct Scene {
  earth::Pose state;
  Vector3d w_ib_b, f_ib_b;
};

Scene scene(double rate) {
  Scene s;
  s.state.p_eb_e = earth::to_ecef({0.7, 2.1, 3000});
  s.state.v_eb_e = {120, -200, 90};
  s.state.q_eb = earth::exp_rotation({0.4, -1.1, 2.0});
  s.w_ib_b = rate * Vector3d{0.6, -0.64, 0.48};
  s.f_ib_b = {3, -5, -12};
  return s;
}

earth::Pose moved(const earth::Pose& from, const CoreVector& x) {
  return {from.p_eb_e + x.segment<3>(kPosition), from.v_eb_e + x.segment<3>(kVelocity),
          earth::exp_rotation(x.segment<3>(kAttitude)) * from.q_eb};
}

CoreVector difference(const earth::Pose& truth, const earth::Pose& estimate) {
  CoreVector x;
  x << truth.p_eb_e - estimate.p_eb_e, truth.v_eb_e - estimate.v_eb_e,
      earth::log_rotation(truth.q_eb * estimate.q_eb.conjugate());
  return x;
}

earth::Pose stepped(const earth::Pose& from, const Vector3d& w, const Vector3d& f, double dt) {
  navigation::Strapdown::Options options;
  options.order = 1;
  navigation::Strapdown strapdown(from, options);
  strapdown.step({.angle = earth::array(dt * w), .velocity = earth::array(dt * f)}, dt);
  return strapdown.state();
}

navigation::StepInput input_of(const Scene& s, double dt) {
  navigation::StepInput step;
  step.dt = dt;
  step.p_eb_e = s.state.p_eb_e + dt / 2 * s.state.v_eb_e;
  step.C_eb = earth::exp_rotation({0, 0, -kRate * dt / 2}).toRotationMatrix() *
              (s.state.q_eb * earth::exp_rotation(dt / 2 * s.w_ib_b)).toRotationMatrix();
  step.w_ib_b = s.w_ib_b;
  step.f_ib_b = s.f_ib_b;
  return step;
}

double perturbation(int state) { return state < kVelocity ? 1000 : state < kAttitude ? 10 : 1e-4; }

// Bounds of what the model leaves out by row and column of 3 x 3 blocks, from the third term of exp(F dt),
// from the turn of f in a step and from the closed gradient; none is a fit.
double core_tolerance(const Scene& s, double dt, int row, int column) {
  const double f = s.f_ib_b.norm(), turn = (s.w_ib_b.norm() + kRate) * dt, d3 = dt * dt * dt / 6;
  const bool cut = dt <= navigation::Lineariser::kSecondOrder;
  const double lost = kGradientError * kGradient;
  // of f over the step: its first moment for position, its mean for velocity
  const double f1 = f * dt * dt * (turn / 12 + turn * turn / 12), f0 = f * dt * (turn * turn / 24 + kRate * dt * turn);
  const double midpoint = f * kGradient * dt * dt * dt / 24;  // the strapdown takes gravitation amid the step
  const double third[3][3] = {
      {d3 * 2 * kRate * kGradient, d3 * (kGradient + 4 * kRate * kRate), d3 * 3 * kRate * f},
      {d3 * kGradient * (kGradient + 4 * kRate * kRate), d3 * 4 * kRate * (kGradient + 2 * kRate * kRate),
       d3 * f * (kGradient + 7 * kRate * kRate)},
      {0, 0, d3 * kRate * kRate * kRate}};
  const double other[3][3] = {{lost * dt * dt / 2, lost * dt * dt * dt, f1 + midpoint * dt},
                              {lost * dt, lost * dt * dt, f0 + midpoint},
                              {0, 0, 0}};
  return (cut ? third[row][column] : 0) + other[row][column];
}

// Rounding of the end state over the perturbation.
double rounding(int row, int column) {
  const double size = row < kVelocity ? 6.4e6 : row < kAttitude ? 500 : 4;
  return 4 * kEps * size / perturbation(column);
}

ErrorTerm term(Carrier carrier, Effect effect, int axis, int input = 0,
               double correlation_time = std::numeric_limits<double>::infinity()) {
  ErrorTerm t;
  t.carrier = carrier;
  t.effect = effect;
  t.axis = axis;
  t.input = input;
  t.correlation_time = correlation_time;
  return t;
}

std::vector<ErrorTerm> every_sensor_term() {
  std::vector<ErrorTerm> terms;
  for (const auto carrier : {Carrier::gyro, Carrier::accelerometer})
    for (int i = 0; i < 3; ++i) {
      terms.push_back(term(carrier, Effect::bias, i, 0, 30));
      terms.push_back(term(carrier, Effect::scale_factor, i));
      terms.push_back(term(carrier, Effect::g2_sensitivity, i));
      for (int j = 0; j < 3; ++j)
        if (j != i) terms.push_back(term(carrier, Effect::misalignment, i, j));
    }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) terms.push_back(term(Carrier::gyro, Effect::g_sensitivity, i, j));
  return terms;
}

}  // namespace

// Turning bodies and still ones, steps below and above the change of order.
TEST(ErrorState, CoreIsTheDerivativeOfTheStrapdown) {
  for (const double rate : {0.0, 0.5})
    for (const double dt : {0.001, 0.01, 0.05, 0.1, 1.0}) {
      const Scene s = scene(rate);
      navigation::Lineariser lineariser{navigation::ErrorStateModel{}};
      const auto& step = lineariser(input_of(s, dt));
      for (int j = 0; j < kCoreStates; ++j) {
        const CoreVector x = perturbation(j) * CoreVector::Unit(j);
        const CoreVector column = difference(stepped(moved(s.state, x), s.w_ib_b, s.f_ib_b, dt),
                                             stepped(moved(s.state, -x), s.w_ib_b, s.f_ib_b, dt)) /
                                  (2 * perturbation(j));
        for (int i = 0; i < kCoreStates; ++i)
          EXPECT_NEAR(step.core(i, j), column[i],
                      core_tolerance(s, dt, i / 3, j / 3) + rounding(i, j) + 1e-9 * dt * dt * (j < kAttitude ? 0 : 15))
              << "row " << i << " column " << j << " dt " << dt << " rate " << rate;
      }
    }
}

// Truth minus estimate after a step whose true increments are greater than the used ones by a unit rate.
TEST(ErrorState, InputIsTheDerivativeByIncrements) {
  for (const double rate : {0.0, 0.5})
    for (const double dt : {0.001, 0.01, 0.1, 1.0}) {
      const Scene s = scene(rate);
      navigation::Lineariser lineariser{navigation::ErrorStateModel{}};
      const auto& step = lineariser(input_of(s, dt));
      const double turn = s.w_ib_b.norm() * dt + kRate * dt, f = s.f_ib_b.norm();
      for (int j = 0; j < 6; ++j) {
        const double e = j < 3 ? 1e-4 / dt : 1;
        Vector3d dw = Vector3d::Zero(), df = Vector3d::Zero();
        (j < 3 ? dw : df)[j % 3] = e;
        const CoreVector column = difference(stepped(s.state, s.w_ib_b + dw, s.f_ib_b + df, dt),
                                             stepped(s.state, s.w_ib_b - dw, s.f_ib_b - df, dt)) /
                                  (2 * e);
        for (int i = 0; i < kCoreStates; ++i) {
          // A turn within the step moves the input's own axes and f by that much about mid-step.
          const double size[3][2] = {{f * dt * dt * dt / 6, dt * dt / 2}, {f * dt * dt / 2, dt}, {dt, 0}};
          const double whole = size[i / 3][j / 3];
          EXPECT_NEAR(step.input(i, j), column[i],
                      whole * (turn + 1e-8) + 4 * kEps *
                                                  (i < 3   ? 6.4e6
                                                   : i < 6 ? 500
                                                           : 4) /
                                                  e)
              << "row " << i << " column " << j << " dt " << dt << " rate " << rate;
        }
      }
    }
}

// The error of every sensor term, written out: measured = true + s (...). A navigator that believes it moves
// as the term's column says, with its decay over the step.
TEST(ErrorState, CouplingIsTheDerivativeByEveryTerm) {
  const double dt = 0.01;
  const Scene s = scene(0.5);
  navigation::ErrorStateModel model;
  model.terms = every_sensor_term();
  navigation::Lineariser lineariser(model);
  const auto Phi = lineariser(input_of(s, dt)).matrix();
  for (std::size_t k = 0; k < model.terms.size(); ++k) {
    const ErrorTerm& t = model.terms[k];
    const bool gyro = t.carrier == Carrier::gyro;
    const Vector3d u = gyro ? s.w_ib_b : s.f_ib_b;
    const double sensitivity = t.effect == Effect::bias             ? 1
                               : t.effect == Effect::scale_factor   ? u[t.axis]
                               : t.effect == Effect::misalignment   ? u[t.input]
                               : t.effect == Effect::g2_sensitivity ? std::pow(s.f_ib_b[t.axis], 2)
                                                                    : s.f_ib_b[t.input];
    // 1e-3 of a signal's error, whatever its unit
    const double e = 1e-3 / std::abs(sensitivity);
    const double a = dt / t.correlation_time;
    const double mean = std::isinf(t.correlation_time) ? 1 : (1 - std::exp(-a)) / a;
    Vector3d dw = Vector3d::Zero(), df = Vector3d::Zero();
    (gyro ? dw : df)[t.axis] = e * mean * sensitivity;
    const auto truth = stepped(s.state, s.w_ib_b, s.f_ib_b, dt);
    const CoreVector column = (difference(truth, stepped(s.state, s.w_ib_b + dw, s.f_ib_b + df, dt)) -
                               difference(truth, stepped(s.state, s.w_ib_b - dw, s.f_ib_b - df, dt))) /
                              (2 * e);
    const double f = s.f_ib_b.norm(), turn = (s.w_ib_b.norm() + kRate) * dt;
    for (int i = 0; i < kCoreStates; ++i) {
      const double size[3][2] = {{f * dt * dt * dt / 6, dt * dt / 2}, {f * dt * dt / 2, dt}, {dt, 0}};
      const double whole = std::abs(sensitivity) * size[i / 3][gyro ? 0 : 1];
      EXPECT_NEAR(Phi(i, kCoreStates + static_cast<int>(k)), column[i],
                  whole * (turn + 1e-8) + 4 * kEps *
                                              (i < 3   ? 6.4e6
                                               : i < 6 ? 500
                                                       : 4) /
                                              e)
          << navigation::name(t) << " row " << i;
    }
    const auto own = static_cast<Eigen::Index>(kCoreStates + k);
    EXPECT_DOUBLE_EQ(Phi(own, own), std::exp(-a));
  }
}

// sensor_errors is what the coupling is made of.
TEST(ErrorState, SensorErrorsAreThoseOfTheCoupling) {
  const Scene s = scene(0.5);
  const auto terms = every_sensor_term();
  for (std::size_t k = 0; k < terms.size(); ++k) {
    std::vector<double> values(terms.size(), 0);
    values[k] = 2;
    const auto errors = navigation::sensor_errors(terms, values.data(), s.w_ib_b, s.f_ib_b);
    navigation::ErrorStateModel model;
    model.terms.push_back(terms[k]);
    model.terms[0].correlation_time = std::numeric_limits<double>::infinity();
    navigation::Lineariser lineariser(model);
    const auto& step = lineariser(input_of(s, 0.01));
    Eigen::Matrix<double, 6, 1> mean = Eigen::Matrix<double, 6, 1>::Zero();
    mean[step.terms[0].signal] = -2 * step.terms[0].gain;
    EXPECT_DOUBLE_EQ((mean.head<3>() - errors.gyro).norm(), 0) << navigation::name(terms[k]);
    EXPECT_DOUBLE_EQ((mean.tail<3>() - errors.accelerometer).norm(), 0) << navigation::name(terms[k]);
  }
}

// Terms of aids touch no navigation state, but decay.
TEST(ErrorState, TermsOfAidsOnlyDecay) {
  navigation::ErrorStateModel model;
  for (const auto effect : {Effect::bias, Effect::lever_arm, Effect::time_tag})
    model.terms.push_back(term(Carrier::aid, effect, 1, 0, 5));
  navigation::Lineariser lineariser(model);
  const auto Phi = lineariser(input_of(scene(0.5), 2)).matrix();
  for (int k = kCoreStates; k < kCoreStates + 3; ++k) {
    EXPECT_EQ(Phi.col(k).head<kCoreStates>().norm(), 0);
    EXPECT_EQ(Phi.row(k).head<kCoreStates>().norm(), 0);
    EXPECT_DOUBLE_EQ(Phi(k, k), std::exp(-0.4));
  }
}

// Joint covariance of a term and its mean over the step, from steps so small that a Taylor series is exact,
// doubled.
TEST(ErrorState, NoiseFactorsAreThoseOfTheContinuousModel) {
  using Reference = long double;
  constexpr double kWalk = 3;
  constexpr double kTolerance = 1e-12;  // of the quadrature, and of the Taylor series for steps of 2^-16 Tc
  for (int decade = -9; decade <= 6; ++decade)
    for (const double part : {1.0, 2.7}) {
      const double dt = 0.01, time = dt / (part * std::pow(10, decade));
      const int doublings = std::max(4, static_cast<int>(std::ceil(std::log2(dt / time))) + 16);
      navigation::ErrorStateModel model;
      model.terms.push_back(term(Carrier::gyro, Effect::bias, 0, 0, time));
      model.terms[0].walk = kWalk;
      navigation::Lineariser lineariser(model);
      const auto& step = lineariser(input_of(scene(0), dt));
      // x = (state, its integral); per unit of dt
      const Reference a = Reference(dt) / Reference(time), h = std::exp2(Reference(-doublings));
      const Reference b = a * h;
      reference::Matrix<Reference> phi(2, 2), q(2, 2);
      phi(0, 0) = std::exp(-b);
      phi(1, 1) = 1;
      phi(1, 0) = h * (1 - b / 2 + b * b / 6 - b * b * b / 24);
      q(0, 0) = h * (1 - b + b * b * 2 / 3 - b * b * b / 3);
      q(0, 1) = q(1, 0) = h * h * (1.0L / 2 - b / 2 + b * b * 7 / 24);
      q(1, 1) = h * h * h * (1.0L / 3 - b / 4 + b * b * 7 / 60);
      for (int i = 0; i < doublings; ++i) {
        q = phi * q * phi.transposed() + q;
        phi = phi * phi;
      }
      const Reference scale = Reference(kWalk) * Reference(kWalk) * Reference(dt);
      const Reference state = scale * q(0, 0), cross = scale * q(0, 1), mean = scale * q(1, 1);
      const auto& t = step.terms[0];
      const auto near = [&](double ours, Reference theirs, const char* what) {
        EXPECT_NEAR(ours, static_cast<double>(theirs), kTolerance * std::abs(static_cast<double>(theirs)))
            << what << " at dt/Tc " << static_cast<double>(a);
      };
      near(t.decay, phi(0, 0), "decay");
      near(-t.gain, phi(1, 0), "gain");
      near(t.noise, state, "noise");
      near(-t.spill, cross / state, "spill");
      near(step.input_noise[0], mean - cross * cross / state, "rest");
    }
}

TEST(ErrorState, WhiteNoiseIsThatOfTheMean) {
  navigation::ErrorStateModel model;
  model.gyro_white = {1e-5, 2e-5, 3e-5};
  model.accelerometer_white = {1e-3, 0, 3e-3};
  navigation::Lineariser lineariser(model);
  const auto& step = lineariser(input_of(scene(0), 0.02));
  for (int i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(step.input_noise[i], model.gyro_white[i] * model.gyro_white[i] / 0.02);
    EXPECT_DOUBLE_EQ(step.input_noise[3 + i], model.accelerometer_white[i] * model.accelerometer_white[i] / 0.02);
  }
}

// Two half-steps against one, of a body at rest in inertial axes: Phi to what the order leaves out, noise
// where the mean over a step says all (not position and velocity, which see when within the step an error
// came).
TEST(ErrorState, TwoHalfStepsAreAStep) {
  const Scene s = scene(0);
  for (const double dt : {0.01, 0.04, 0.2, 4.0}) {
    navigation::ErrorStateModel model;
    model.gyro_white.setConstant(1e-4);
    model.accelerometer_white.setConstant(1e-3);
    model.terms = every_sensor_term();
    for (std::size_t k = 0; k < model.terms.size(); ++k) {
      model.terms[k].correlation_time = std::pow(10, static_cast<double>(k % 9) - 4);
      model.terms[k].walk = k % 3 == 0 ? 0 : 1e-3;
    }
    auto input = input_of(s, dt);
    navigation::Lineariser lineariser(model);
    const navigation::Transition whole = lineariser(input);
    input.dt = dt / 2;
    const navigation::Transition half = lineariser(input);
    const navigation::StateMatrix Phi = whole.matrix(), twice = half.matrix() * half.matrix();
    const double f = s.f_ib_b.norm();
    for (int j = 0; j < Phi.cols(); ++j)
      for (int i = 0; i < Phi.rows(); ++i) {
        double tolerance = 16 * kEps * (1 + std::abs(Phi(i, j)));
        if (i < kCoreStates && j < kCoreStates) {
          if (dt <= navigation::Lineariser::kSecondOrder)
            tolerance += core_tolerance(s, dt, i / 3, j / 3);
          else if (dt / 2 <= navigation::Lineariser::kSecondOrder)
            tolerance += 2 * core_tolerance(s, navigation::Lineariser::kSecondOrder, i / 3, j / 3);
        } else if (i < kCoreStates) {
          // The first half of an error that decays is greater: a/16 of dt^2 and alike; axes turn by w_ie dt.
          const auto& t = whole.terms[static_cast<std::size_t>(j - kCoreStates)];
          const double a = std::min(1.0, dt / model.terms[static_cast<std::size_t>(j - kCoreStates)].correlation_time);
          const double size[3][2] = {{f * dt * dt * dt / 6, dt * dt / 2}, {f * dt * dt / 2, dt}, {dt, 0}};
          const double gain =
              std::max(std::abs(t.gain), 2 * std::abs(half.terms[static_cast<std::size_t>(j - kCoreStates)].gain));
          tolerance += gain * size[i / 3][t.signal < 3 ? 0 : 1] * (a + 4 * kRate * dt);
        }
        EXPECT_NEAR(Phi(i, j), twice(i, j), tolerance) << i << ", " << j << " dt " << dt;
      }
    const navigation::StateMatrix Q = whole.noise(),
                                  sum = half.matrix() * half.noise() * half.matrix().transpose() + half.noise();
    for (int i = kAttitude; i < Q.rows(); ++i)
      for (int j = kAttitude; j < Q.cols(); ++j)
        EXPECT_NEAR(Q(i, j), sum(i, j), (1e-12 + 2 * kRate * dt) * std::sqrt(Q(i, i) * Q(j, j))) << i << ", " << j;
  }
}

TEST(ErrorState, RefusesWhatIsNotAModel) {
  const auto refused = [](auto change) {
    navigation::ErrorStateModel model;
    model.terms.push_back(term(Carrier::gyro, Effect::misalignment, 0, 1));
    change(model);
    EXPECT_THROW(model.check(), std::invalid_argument);
    EXPECT_THROW(navigation::Lineariser{model}, std::invalid_argument);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refused([&](auto& m) { m.gyro_white[1] = nan; });
  refused([&](auto& m) { m.accelerometer_white[1] = -1; });
  refused([&](auto& m) { m.terms[0].input = 0; });
  refused([&](auto& m) { m.terms[0].axis = 3; });
  refused([&](auto& m) { m.terms[0].input = -1; });
  refused([&](auto& m) { m.terms[0].correlation_time = 0; });
  refused([&](auto& m) { m.terms[0].correlation_time = nan; });
  refused([&](auto& m) { m.terms[0].walk = -1; });
  refused([&](auto& m) { m.terms[0].effect = Effect::time_tag; });
  refused([&](auto& m) { m.terms[0].carrier = Carrier::aid; });
  refused([&](auto& m) { m.terms[0] = term(Carrier::accelerometer, Effect::g_sensitivity, 0); });
  refused([&](auto& m) { m.terms.assign(navigation::kMaxErrorTerms + 1, term(Carrier::gyro, Effect::bias, 0)); });
  navigation::Lineariser lineariser{navigation::ErrorStateModel{}};
  for (const double dt : {0.0, -1.0, nan, std::numeric_limits<double>::infinity()})
    EXPECT_THROW((void)lineariser(input_of(scene(0), dt)), std::invalid_argument);
}

TEST(ErrorState, NamesSayCarrierEffectAndAxes) {
  EXPECT_EQ(navigation::name(term(Carrier::gyro, Effect::bias, 0)), "gyro bias x");
  EXPECT_EQ(navigation::name(term(Carrier::accelerometer, Effect::misalignment, 1, 2)),
            "accelerometer misalignment y<-z");
  EXPECT_EQ(navigation::name(term(Carrier::aid, Effect::lever_arm, 2)), "aid 0 lever arm z");
  EXPECT_EQ(navigation::name(term(Carrier::aid, Effect::time_tag, 0)), "aid 0 time tag");
}

// SPDX-License-Identifier: MIT
// The square-root form where a filter could break, each against the same model in a hundred digits: every
// sigma within kTolerance of it, or a refusal that says why.
#include "gyrobudget/estimation/navigation/filter.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <cmath>
#include <limits>

#include "reference.h"

using namespace gyrobudget;  // NOLINT
using Eigen::Vector3d;
using navigation::Carrier;
using navigation::Effect;
using navigation::Form;
using navigation::Innovation;
using navigation::kAttitude;
using navigation::kCoreStates;
using navigation::kPosition;
using navigation::kVelocity;
using navigation::StateMatrix;
using navigation::StateVector;

namespace {

constexpr double kTolerance = 1e-6;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// 332 bits
using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<100>, boost::multiprecision::et_off>;

navigation::ErrorTerm bias(Carrier carrier, int axis, double correlation_time = kInfinity, double walk = 0) {
  navigation::ErrorTerm t;
  t.carrier = carrier;
  t.axis = axis;
  t.correlation_time = correlation_time;
  t.walk = walk;
  return t;
}

navigation::ErrorStateModel with_biases(double correlation_time = kInfinity, double gyro_walk = 1e-9) {
  navigation::ErrorStateModel model;
  model.gyro_white.setConstant(1e-6);
  model.accelerometer_white.setConstant(1e-4);
  for (int i = 0; i < 3; ++i) model.terms.push_back(bias(Carrier::gyro, i, correlation_time, gyro_walk));
  for (int i = 0; i < 3; ++i) model.terms.push_back(bias(Carrier::accelerometer, i, correlation_time, 1e-7));
  return model;
}

struct Place {
  Vector3d p_eb_e = earth::to_ecef({-0.042, -0.775, 100});
  Eigen::Quaterniond q_eb = earth::exp_rotation({0.3, -0.8, 1.1});
};

/// The factors and a hundred digits, side by side.
class Pair {
 public:
  Pair(const navigation::ErrorStateModel& model, const StateVector& variance, const Place& place = {},
       Form form = Form::square_root)
      : place_(place),
        lineariser_(model),
        ours_(StateMatrix(variance.asDiagonal()), form),
        truth_(StateMatrix(variance.asDiagonal())) {}

  void step(double dt, const Vector3d& f = {0.5, -1, -9.8}, const Vector3d& w = {0.01, 0.02, -0.1}) {
    navigation::StepInput input;
    input.dt = dt;
    input.p_eb_e = place_.p_eb_e;
    input.C_eb = place_.q_eb.toRotationMatrix();
    input.w_ib_b = w;
    input.f_ib_b = f;
    const auto& step = lineariser_(input);
    ours_.propagate(step);
    truth_ = reference::propagated(truth_, step);
    check();
  }
  /// Three rows on three states.
  void fix(int first, double sigma) {
    for (int i = 0; i < 3; ++i) update(StateVector::Unit(ours_.size(), first + i), sigma);
  }
  void height(double sigma) {
    StateVector h = StateVector::Zero(ours_.size());
    h.segment<3>(kPosition) = place_.p_eb_e.normalized();
    update(h, sigma);
  }
  [[nodiscard]] double worst() const { return worst_; }
  [[nodiscard]] const navigation::Covariance& covariance() const { return ours_; }

 private:
  void update(const StateVector& h, double sigma) {
    const navigation::MeasurementRow row{h, sigma * sigma};
    (void)ours_.update(row);
    truth_ = reference::updated(truth_, row);
    check();
  }
  void check() {
    for (int i = 0; i < ours_.size(); ++i) {
      const double ratio = static_cast<double>(sqrt(Real(ours_.variance(i)) / truth_(i, i)));
      const double off = std::abs(ratio - 1);
      worst_ = off <= worst_ ? worst_ : std::isfinite(off) ? off : kInfinity;
    }
  }
  Place place_;
  navigation::Lineariser lineariser_;
  navigation::Covariance ours_;
  reference::Matrix<Real> truth_;
  double worst_ = 0;
};

StateVector usual_variances(int states) {
  StateVector v = StateVector::Constant(states, 1e-6);
  v.segment<3>(kPosition).setConstant(100);
  v.segment<3>(kVelocity).setConstant(1);
  v.segment<3>(kAttitude).setConstant(1e-4);
  v.tail(states - kCoreStates).head(3).setConstant(1e-10);
  return v;
}

}  // namespace

// Variances of 1e-20 to 1e20 in one filter, the great ones in every part of the state once.
TEST(Extremes, VariancesOverFortyDecades) {
  constexpr int kStates = 15;
  for (int shift = 0; shift < kStates; shift += 5) {
    StateVector variance(kStates);
    for (int i = 0; i < kStates; ++i) variance[(i * 4 + shift) % kStates] = std::pow(10, -20 + 40. * i / (kStates - 1));
    Pair pair(with_biases(), variance);
    for (int k = 0; k < 8; ++k) {
      pair.step(0.01);
      if (k % 4 == 1) pair.fix(kPosition, 1);
      if (k % 4 == 2) pair.fix(kVelocity, 0.01);
      if (k % 4 == 3) pair.fix(kAttitude, 1e-3);
    }
    EXPECT_LT(pair.worst(), kTolerance) << shift;
  }
}

TEST(Extremes, PositionsOfAMicrometreAndAThousandKilometres) {
  for (const double sigma : {1e-6, 1e6})
    for (const double start : {1e-6, 1.0, 1e10}) {
      Pair pair(with_biases(), start * usual_variances(15));
      for (int k = 0; k < 10; ++k) {
        pair.step(0.1);
        pair.fix(kPosition, sigma);
      }
      EXPECT_LT(pair.worst(), kTolerance) << sigma << " m, start " << start;
    }
  // One after the other
  Pair pair(with_biases(), usual_variances(15));
  for (int k = 0; k < 10; ++k) {
    pair.step(0.1);
    pair.fix(kPosition, k % 2 == 0 ? 1e6 : 1e-6);
  }
  EXPECT_LT(pair.worst(), kTolerance);
}

TEST(Extremes, GyroDriftOfATurnASecond) {
  const double turn = 2 * M_PI;
  StateVector variance = usual_variances(15);
  variance.segment<3>(kCoreStates).setConstant(turn * turn);
  Pair pair(with_biases(kInfinity, 1), variance);
  for (int k = 0; k < 12; ++k) {
    pair.step(0.01);
    if (k % 3 == 2) pair.fix(kAttitude, 1e-4);
    if (k % 4 == 3) pair.fix(kPosition, 1);
  }
  EXPECT_LT(pair.worst(), kTolerance);
}

// Height alone grows by e^45 in that time. With a barometer it does not, and the rest can be found again.
TEST(Extremes, TenHoursFreeInertial) {
  for (const bool barometer : {false, true}) {
    Pair pair(with_biases(3600), usual_variances(15));
    for (int k = 0; k < 360; ++k) {
      pair.step(100, {0.5, -1, -9.8}, {0, 0, 0});
      if (barometer) pair.height(10);
    }
    EXPECT_LT(pair.worst(), kTolerance) << "free, barometer " << barometer;
    if (!barometer) continue;
    pair.fix(kPosition, 1);
    pair.fix(kAttitude, 1e-6);
    EXPECT_LT(pair.worst(), kTolerance) << "found again";
  }
}

TEST(Extremes, CorrelationTimesOfAMicrosecondAndAMillionSeconds) {
  navigation::ErrorStateModel model = with_biases();
  for (const double time : {1e-6, 1e-3, 1.0, 1e6})
    for (int i = 0; i < 2; ++i) {
      model.terms.push_back(bias(i == 0 ? Carrier::gyro : Carrier::accelerometer, i, time, 1e-5 * std::sqrt(2 / time)));
    }
  StateVector variance = usual_variances(model.states());
  variance.tail(8).setConstant(1e-10);
  Pair pair(model, variance);
  for (int k = 0; k < 12; ++k) {
    pair.step(k % 2 == 0 ? 0.01 : 10);
    if (k % 3 == 2) pair.fix(kPosition, 1);
  }
  EXPECT_LT(pair.worst(), kTolerance);
}

TEST(Extremes, PitchOfNinetyDegreesAndPoles) {
  for (const double latitude : {-M_PI / 2, 0.0, M_PI / 2})
    for (const double pitch : {-M_PI / 2, M_PI / 2}) {
      Place place;
      place.p_eb_e = earth::to_ecef({latitude, M_PI, 0});
      place.q_eb = Eigen::Quaterniond(earth::C_e_ned(latitude, M_PI)) * earth::from_euler({0.3, pitch, 0});
      Pair pair(with_biases(), usual_variances(15), place);
      for (int k = 0; k < 6; ++k) {
        pair.step(0.1);
        pair.fix(k % 2 == 0 ? kPosition : kAttitude, 0.01);
      }
      EXPECT_LT(pair.worst(), kTolerance) << latitude << " " << pitch;
    }
}

// Automatic is Joseph's until a row shrinks a variance too much for it, and as good as the factors from there
// on.
TEST(Extremes, AutomaticFormLeavesBeforeDigitsAreLost) {
  Pair mild(with_biases(), usual_variances(15), {}, Form::automatic);
  for (int k = 0; k < 6; ++k) {
    mild.step(0.1);
    mild.fix(kPosition, 1);
  }
  EXPECT_EQ(mild.covariance().form(), Form::joseph);
  EXPECT_LT(mild.worst(), kTolerance);
  for (const double scale : {1e4, 1e12, 1e20}) {
    Pair pair(with_biases(), scale * usual_variances(15), {}, Form::automatic);
    for (int k = 0; k < 6; ++k) {
      pair.step(0.1);
      pair.fix(kPosition, 1e-2);
      pair.fix(kAttitude, 1e-6);
    }
    EXPECT_EQ(pair.covariance().form(), Form::square_root);
    EXPECT_LT(pair.worst(), kTolerance) << scale;
  }
}

TEST(Extremes, RefusalsAreClear) {
  const Place place;
  const earth::Pose start{place.p_eb_e, Vector3d::Zero(), place.q_eb};
  const StateMatrix P0 = usual_variances(15).asDiagonal();
  navigation::Filter filter(start, with_biases(), P0);
  const noise::ImuIncrement imu;
  const navigation::PositionFix fix{place.p_eb_e + Vector3d(1, 2, 3), {1, 1, 1}};

  // An update before the first sample is one like others.
  EXPECT_EQ(filter.update(measure(fix, filter.estimate())).status, Innovation::Status::used);
  EXPECT_LT(filter.covariance().variance(0), 1);
  EXPECT_GT(filter.state().p_eb_e.x(), place.p_eb_e.x() + 0.9);
  const auto accelerated = measure(navigation::VelocityFix{{0, 0, 0}, {1, 1, 1}}, filter.estimate());
  EXPECT_TRUE(accelerated.residual.allFinite());

  // Nothing happens in no time, and time does not run back.
  const StateMatrix before = filter.covariance().matrix();
  filter.propagate(imu, 0);
  EXPECT_EQ((filter.covariance().matrix() - before).norm(), 0);
  for (const double dt : {-1e-9, -1.0, kNaN, kInfinity}) EXPECT_THROW(filter.propagate(imu, dt), std::invalid_argument);
  for (const double bad : {kNaN, kInfinity}) {
    EXPECT_THROW(filter.propagate({.velocity = {bad, 0, 0}}, 0.01), std::invalid_argument);
    auto broken = fix;
    broken.p_eb_e.y() = bad;
    EXPECT_EQ(filter.update(measure(broken, filter.estimate())).status, Innovation::Status::not_finite);
  }
  EXPECT_EQ(filter.time(), 0);
  EXPECT_EQ((filter.covariance().matrix() - before).norm(), 0);

  // A hundred seconds in one step
  filter.propagate({.velocity = {0, 0, 980}}, 100);
  EXPECT_TRUE(filter.covariance().matrix().allFinite());
  EXPECT_EQ(filter.time(), 100);

  // Far beyond the gate
  auto far = fix;
  far.p_eb_e.x() += 1e9;
  EXPECT_EQ(filter.update(measure(far, filter.estimate())).status, Innovation::Status::gated);
}

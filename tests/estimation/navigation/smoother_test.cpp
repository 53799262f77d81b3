// SPDX-License-Identifier: MIT
// Truth here: the smoother of Rauch, Tung and Striebel in long double on a small problem, with inverses and
// all; and closed-loop flights whose errors are known.
#include "gyrobudget/estimation/navigation/smoother.h"

#include "gyrobudget/estimation/navigation/filter.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/paths.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/chi_squared.hpp>

#include <algorithm>
#include <cmath>

#include "reference.h"
#include <Eigen/Cholesky>

using namespace gyrobudget;  // NOLINT
using Eigen::Vector3d;
using navigation::Carrier;
using navigation::kCoreStates;
using navigation::StateMatrix;
using navigation::StateVector;
using Real = long double;
using Dense = reference::Matrix<Real>;

namespace {

constexpr int kStates = 12;
constexpr int kSteps = 6;

navigation::Transition transition(std::uint64_t seed) {
  reference::Normal normal(seed);
  navigation::Transition step;
  step.dt = 1;
  step.size = kStates;
  normal.fill(step.core);
  step.core = navigation::CoreMatrix::Identity() + 0.1 * step.core;
  step.core.block<3, 6>(6, 0).setZero();
  normal.fill(step.input);
  step.input.block<3, 3>(6, 3).setZero();
  step.input_noise.setConstant(0.3);
  for (std::size_t k = 0; k < kStates - kCoreStates; ++k)
    step.terms[k] = {.signal = static_cast<int>(2 * k), .decay = 0.9, .gain = 0.5, .noise = 0.1, .spill = 0.2};
  return step;
}

// What a filter without loop holds at a time, before and after its measurements.
struct Moment {
  Dense x{kStates, 1}, P{kStates, kStates}, x_before{kStates, 1}, P_before{kStates, kStates};
};

double largest(const StateMatrix& ours, const Dense& truth) {
  double worst = 0;
  for (int i = 0; i < truth.rows(); ++i)
    for (int j = 0; j < truth.cols(); ++j)
      worst = std::max(worst, std::abs(static_cast<double>(Real(ours(i, j)) - truth(i, j))));
  return worst;
}

}  // namespace

// Two transitions between measurements, two rows each, and an epoch after each of them.
TEST(Smoother, IsThatOfRauchTungAndStriebel) {
  // Rounding of a hundred products of order ten over a few steps.
  constexpr double kTolerance = 1e-11;
  for (const auto form : {navigation::Form::joseph, navigation::Form::square_root}) {
    reference::Normal normal(3);
    const StateMatrix P0 = 4 * StateMatrix::Identity(kStates, kStates);
    navigation::Covariance ours(P0, form);
    navigation::FilterHistory record(kStates);
    const earth::Pose nowhere{{0, 0, 0}, {0, 0, 0}, Eigen::Quaterniond::Identity()};
    std::vector<Moment> moments(kSteps);
    std::vector<Dense> moves;
    StateVector x = StateVector::Zero(kStates);
    Dense x_true(kStates, 1), P_true(P0);
    std::vector<StateVector> filtered;
    for (int k = 0; k < kSteps; ++k) {
      Dense whole = Dense::identity(kStates);
      for (int half = 0; half < 2; ++half) {
        const auto step = transition(static_cast<std::uint64_t>(10 + 2 * k + half));
        ours.propagate(step);
        record.moved(step);
        x = step.matrix() * x;
        whole = reference::phi<Real>(step) * whole;
        x_true = reference::phi<Real>(step) * x_true;
        P_true = reference::propagated(P_true, step);
      }
      moves.push_back(whole);
      Moment& moment = moments[static_cast<std::size_t>(k)];
      moment.x_before = x_true;
      moment.P_before = P_true;
      for (int i = 0; i < 2; ++i) {
        navigation::MeasurementRow row{StateVector::Zero(kStates), 0.5};
        normal.fill(row.h);
        const double z = 3 * normal();
        const double residual = z - row.h.dot(x), S = row.h.dot(ours.times(row.h)) + row.variance;
        const StateVector gain = ours.update(row);
        record.updated(row, S, residual, gain);
        x += residual * gain;
        const Dense h(row.h), g = P_true * h;
        const Real s = (h.transposed() * g)(0, 0) + Real(row.variance);
        x_true = x_true + ((Real(z) - (h.transposed() * x_true)(0, 0)) / s) * g;
        P_true = reference::updated(P_true, row);
      }
      moment.x = x_true;
      moment.P = P_true;
      filtered.push_back(x);
      record.keep(k, nowhere, x.tail(kStates - kCoreStates), ours.matrix());
    }

    const auto smoothed = smooth(record);
    ASSERT_EQ(smoothed.size(), static_cast<std::size_t>(kSteps));
    Dense xs = moments.back().x, Ps = moments.back().P;
    for (int k = kSteps - 1; k >= 0; --k) {
      const auto at = static_cast<std::size_t>(k);
      if (k + 1 < kSteps) {
        const Moment& next = moments[at + 1];
        const Dense C = moments[at].P * moves[at + 1].transposed() * next.P_before.inverse();
        xs = moments[at].x + C * (xs - next.x_before);
        Ps = moments[at].P + C * (Ps - next.P_before) * C.transposed();
      }
      EXPECT_EQ(smoothed[at].time, k);
      EXPECT_LT(largest(smoothed[at].P, Ps), kTolerance * 10) << k;
      EXPECT_LT(largest(StateMatrix(filtered[at] + smoothed[at].correction), xs), kTolerance * 10) << k;
      EXPECT_LT((smoothed[at].terms - (filtered[at] + smoothed[at].correction).tail(kStates - kCoreStates)).norm(),
                kTolerance);
      EXPECT_EQ((smoothed[at].state.p_eb_e - smoothed[at].correction.head<3>()).norm(), 0);
      for (int i = 0; i < kStates; ++i)
        EXPECT_LE(smoothed[at].P(i, i), static_cast<double>(moments[at].P(i, i)) * (1 + kTolerance));
    }
    // The last epoch knows all already
    EXPECT_EQ(smoothed.back().correction.norm(), 0);
  }
}

// Flights of a filter in its closed loop, its errors and the sensors' drawn from what it is told. The
// normalised squares of all smoothed errors sum to chi-square.
TEST(Smoother, ErrorsAreThoseClaimed) {
  constexpr int kRuns = 40;
  constexpr double kFalseAlarm = 1e-6, kDt = 0.1, kDuration = 60;
  constexpr int kSize = 15;
  earth::Cruise cruise;
  cruise.turn_acceleration = 5;
  cruise.turn_period = 30;
  cruise.duration = kDuration;
  const auto path = earth::cruise(cruise);
  const auto imu = path.increments(kDt);
  navigation::ErrorStateModel model;
  model.gyro_white.setConstant(1e-5);
  model.accelerometer_white.setConstant(1e-3);
  for (const auto carrier : {Carrier::gyro, Carrier::accelerometer})
    for (int i = 0; i < 3; ++i) {
      navigation::ErrorTerm term;
      term.carrier = carrier;
      term.axis = i;
      model.terms.push_back(term);
    }
  StateVector sigma(kSize);
  sigma << Vector3d::Constant(5), Vector3d::Constant(0.3), Vector3d::Constant(2e-3), Vector3d::Constant(1e-5),
      Vector3d::Constant(1e-2);
  const Vector3d fix_sigma(1, 1, 1);

  const std::vector<int> kept{100, 300, 500};
  std::vector<double> nees(kept.size(), 0), filter_error(kept.size(), 0), error(kept.size(), 0);
  for (int run = 0; run < kRuns; ++run) {
    reference::Normal normal(static_cast<std::uint64_t>(100 + run));
    StateVector x(kSize);
    normal.fill(x);
    x = x.cwiseProduct(sigma).eval();
    const auto at0 = path.at(0);
    const earth::Pose start{at0.pose.p_eb_e - x.segment<3>(0), at0.pose.v_eb_e - x.segment<3>(3),
                            (earth::exp_rotation(-x.segment<3>(6)) * at0.pose.q_eb).normalized()};
    navigation::Filter filter(start, model, StateMatrix(sigma.cwiseAbs2().asDiagonal()));
    navigation::FilterHistory record(kSize);
    filter.record(&record);
    std::vector<Vector3d> filter_positions;
    for (int k = 0; k < static_cast<int>(imu.size()); ++k) {
      auto measured = imu[static_cast<std::size_t>(k)];
      for (int i = 0; i < 3; ++i) {
        earth::vector(measured.angle)[i] += kDt * x[9 + i] + 1e-5 * std::sqrt(kDt) * normal();
        earth::vector(measured.velocity)[i] += kDt * x[12 + i] + 1e-3 * std::sqrt(kDt) * normal();
      }
      filter.propagate(measured, kDt);
      if (std::find(kept.begin(), kept.end(), k + 1) != kept.end()) {
        filter.keep_epoch();
        filter_positions.push_back(filter.state().p_eb_e);
      }
      if ((k + 1) % 10 == 5) {
        Vector3d noise;
        normal.fill(noise);
        filter.update(
            measure(navigation::PositionFix{path.at((k + 1) * kDt).pose.p_eb_e + noise, fix_sigma}, filter.estimate()));
      }
    }
    const auto smoothed = smooth(record);
    for (std::size_t e = 0; e < smoothed.size(); ++e) {
      const auto truth = path.at(smoothed[e].time);
      StateVector off(kSize);
      off << truth.pose.p_eb_e - smoothed[e].state.p_eb_e, truth.pose.v_eb_e - smoothed[e].state.v_eb_e,
          earth::log_rotation(truth.pose.q_eb * smoothed[e].state.q_eb.conjugate()), x.tail(6) - smoothed[e].terms;
      nees[e] += off.dot(smoothed[e].P.llt().solve(off));
      error[e] += off.head<3>().squaredNorm();
      filter_error[e] += (truth.pose.p_eb_e - filter_positions[e]).squaredNorm();
    }
  }
  const boost::math::chi_squared law(kRuns * kSize);
  for (std::size_t e = 0; e < kept.size(); ++e) {
    EXPECT_GT(nees[e], quantile(law, kFalseAlarm / 6)) << kept[e];
    EXPECT_LT(nees[e], quantile(complement(law, kFalseAlarm / 6))) << kept[e];
    EXPECT_LT(error[e], filter_error[e]) << kept[e];
  }
}

TEST(Smoother, MemoryIsAsStated) {
  navigation::FilterHistory record(kStates);
  const StateVector any = StateVector::Zero(kStates);
  for (int k = 0; k < 1000; ++k) record.moved(transition(1));
  EXPECT_EQ(record.bytes(), 0U);  // one stretch, not closed
  record.updated({any, 1}, 1, 0, any);
  EXPECT_GE(record.bytes(), (81 + 10 * 3 + 2 * 12 + 2) * sizeof(double));
  EXPECT_LE(record.bytes(), 2 * (81 + 10 * 3 + 2 * 12 + 2) * sizeof(double));
}

TEST(Smoother, RefusesWhatItCannotSmooth) {
  EXPECT_THROW(navigation::FilterHistory(8), std::invalid_argument);
  EXPECT_THROW(navigation::FilterHistory(navigation::kMaxStates + 1), std::invalid_argument);
  navigation::FilterHistory record(kStates), other(kStates + 1);
  EXPECT_THROW(other.moved(transition(1)), std::invalid_argument);
  EXPECT_THROW(record.updated({StateVector::Zero(11), 1}, 1, 0, StateVector::Zero(12)), std::invalid_argument);
  EXPECT_TRUE(smooth(record).empty());

  navigation::ErrorStateModel model;
  model.terms.resize(3);
  const earth::Pose start{earth::to_ecef({0, 0, 0}), {0, 0, 0}, Eigen::Quaterniond::Identity()};
  const StateMatrix P0 = StateMatrix::Identity(kStates, kStates);
  navigation::Filter filter(start, model, P0);
  EXPECT_THROW(filter.keep_epoch(), std::logic_error);
  EXPECT_THROW(filter.record(&other), std::invalid_argument);
  model.terms[1].considered = true;
  navigation::Filter schmidt(start, model, P0);
  EXPECT_THROW(schmidt.record(&record), std::invalid_argument);
}

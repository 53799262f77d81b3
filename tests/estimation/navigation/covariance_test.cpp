// SPDX-License-Identifier: MIT
// Truth here: Phi P Phi^T + Q and (I - k h) P (I - k h)^T + r k k^T in long double, by plain dense algebra.
#include "gyrobudget/estimation/navigation/covariance.h"

#include "gyrobudget/estimation/navigation/detail/covariance_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "reference.h"
#include <Eigen/Eigenvalues>

using namespace gyrobudget;  // NOLINT
using navigation::Covariance;
using navigation::Form;
using navigation::kCoreStates;
using navigation::StateMatrix;
using navigation::StateVector;
using Real = long double;
using Dense = reference::Matrix<Real>;

namespace {

constexpr std::array kForms{Form::plain, Form::joseph, Form::square_root};
constexpr double kEps = std::numeric_limits<double>::epsilon();
constexpr std::array kSizes{9, 10, 12, 15, 21, 33, 72};

// Elements of order one, zeros where a transition has them.
navigation::Transition transition(int states, std::uint64_t seed) {
  reference::Normal normal(seed);
  navigation::Transition step;
  step.dt = 1;
  step.size = states;
  normal.fill(step.core);
  step.core.block<3, 6>(6, 0).setZero();
  normal.fill(step.input);
  step.input.block<3, 3>(6, 3).setZero();
  for (int i = 0; i < 6; ++i) step.input_noise[i] = i == 2 ? 0 : std::abs(normal());
  for (int k = 0; k < states - kCoreStates; ++k) {
    auto& term = step.terms[static_cast<std::size_t>(k)];
    term.signal = k % 8 == 7 ? -1 : k % 7 % 6;
    term.decay = k % 3 == 0 ? 1 : std::exp(-std::abs(normal()));
    term.noise = k % 4 == 0 ? 0 : std::abs(normal());
    if (term.signal < 0) continue;
    term.gain = normal();
    term.spill = normal();
  }
  return step;
}

StateMatrix covariance(int states, std::uint64_t seed) {
  reference::Normal normal(seed);
  StateMatrix root(states, states);
  normal.fill(root);
  return StateMatrix(root * root.transpose()) + StateMatrix(StateMatrix::Identity(states, states));
}

navigation::MeasurementRow row(int states, std::uint64_t seed) {
  reference::Normal normal(seed);
  navigation::MeasurementRow made;
  made.h.resize(states);
  normal.fill(made.h);
  made.variance = 0.5;
  return made;
}

// Largest error in units of sqrt(P_ii P_jj) of the reference.
double error(const StateMatrix& P, const Dense& truth) {
  double worst = 0;
  for (int i = 0; i < truth.rows(); ++i)
    for (int j = 0; j < truth.cols(); ++j) {
      const double off = std::abs(static_cast<double>(Real(P(i, j)) - truth(i, j)));
      const double e = off == 0 ? 0 : off / std::sqrt(static_cast<double>(truth(i, i) * truth(j, j)));
      worst = std::isfinite(e) ? std::max(worst, e) : std::numeric_limits<double>::infinity();
    }
  return worst;
}

void expect_covariance(const StateMatrix& P) {
  EXPECT_EQ((P - P.transpose()).cwiseAbs().maxCoeff(), 0);
  const StateVector scale = P.diagonal().cwiseSqrt().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd correlation = scale.asDiagonal() * P * scale.asDiagonal();
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(correlation, Eigen::EigenvaluesOnly).eigenvalues()[0],
            -static_cast<double>(P.rows()) * 8 * kEps);
}

}  // namespace

// Rounding of three sums of up to 72 products of order one beside each other.
constexpr double kOneStep = 72 * 3 * 4 * kEps;

TEST(Covariance, MovesAsDenseAlgebraSays) {
  for (const int states : kSizes)
    for (const Form form : kForms)
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const auto step = transition(states, seed);
        const StateMatrix P = covariance(states, seed + 10);
        Covariance ours(P, form);
        ours.propagate(step);
        EXPECT_LT(error(ours.matrix(), reference::propagated(Dense(P), step)), kOneStep) << states;
        EXPECT_LT(error(StateMatrix(step.matrix() * P * step.matrix().transpose() + step.noise()),
                        reference::propagated(Dense(P), step)),
                  kOneStep);
        for (int i = 0; i < states; ++i)
          EXPECT_NEAR(ours.variance(i), ours.matrix()(i, i), kOneStep * ours.variance(i));
      }
}

// A term that forgets itself within a step, to the last digit or beyond what a double holds. A state that
// nothing feeds ends as none.
TEST(Covariance, MovesTermsThatForgetThemselves) {
  constexpr Real kNothing = 1e-95L;
  for (const double decay : {1e-8, 1e-40, 1e-49, 1e-51, 1e-120, 0.0})
    for (const double noise : {0.0, 2.0})
      for (const Form form : kForms) {
        auto step = transition(15, 4);
        for (const std::size_t k : {1U, 2U, 5U}) {
          step.terms[k].decay = decay;
          step.terms[k].noise = noise;
        }
        Dense truth(covariance(15, 5));
        Covariance ours(covariance(15, 5), form);
        for (int i = 0; i < 6; ++i) {
          ours.propagate(step);
          truth = reference::propagated(truth, step);
          StateMatrix P = ours.matrix();
          Dense expected = truth;
          for (int j = 0; j < 15; ++j)
            if (truth(j, j) < kNothing) {
              EXPECT_LT(P(j, j), kNothing);
              for (int l = 0; l < 15; ++l) P(j, l) = P(l, j) = 0, expected(j, l) = expected(l, j) = 0;
              P(j, j) = 1;
              expected(j, j) = 1;
            }
          EXPECT_LT(error(P, expected), (i + 1) * kOneStep) << decay << " " << noise << " step " << i;
        }
      }
}

TEST(Covariance, KernelsGiveTheSameBytes) {
  using navigation::detail::Target;
  if (!navigation::detail::supported(Target::avx2)) GTEST_SKIP() << "this processor has no AVX2";
  for (const int states : kSizes) {
    const auto step = transition(states, 6);
    StateMatrix a = StateMatrix::Zero(navigation::detail::padded(states), states);
    a.topRows(states) = covariance(states, 7);
    a = StateMatrix(a);
    StateMatrix b = a;
    navigation::detail::propagate_dense(Target::baseline, step, a.data());
    navigation::detail::propagate_dense(Target::avx2, step, b.data());
    EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())), 0) << states;
    EXPECT_EQ(a.bottomRows(a.rows() - states).cwiseAbs().sum(), 0);  // what fills up stays zero
  }
}

// A kernel that is compiled as if P were aligned to whole lanes traps at six of the eight places, or at four.
TEST(Covariance, KernelsNeedNoAlignmentButThatOfADouble) {
  using navigation::detail::Target;
  constexpr int kPlaces = 8;  // of a double within 64 bytes
  for (const Target target : {Target::baseline, Target::avx2}) {
    if (!navigation::detail::supported(target)) continue;
    for (const int states : kSizes) {
      const auto step = transition(states, 6);
      StateMatrix start = StateMatrix::Zero(navigation::detail::padded(states), states);
      start.topRows(states) = covariance(states, 7);
      StateMatrix expected = start;
      navigation::detail::propagate_dense(target, step, expected.data());
      const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(start.size());
      for (int place = 0; place < kPlaces; ++place) {
        alignas(64) double memory[navigation::kMaxStates * navigation::kMaxStates + kPlaces];
        std::memcpy(memory + place, start.data(), bytes);
        navigation::detail::propagate_dense(target, step, memory + place);
        EXPECT_EQ(std::memcmp(memory + place, expected.data(), bytes), 0) << states << " at " << place;
      }
    }
  }
}

TEST(Covariance, UpdatesAsDenseAlgebraSays) {
  for (const int states : kSizes)
    for (const Form form : kForms) {
      const StateMatrix P = covariance(states, 20);
      const auto z = row(states, 21);
      Covariance ours(P, form);
      const StateVector ph = ours.times(z.h);
      const StateVector gain = ours.update(z);
      const Dense g = Dense(P) * Dense(z.h);
      const Real s = (Dense(z.h).transposed() * g)(0, 0) + Real(z.variance);
      // An element of P h and of the gain against what may stand there; P against what it was, as it is a
      // difference.
      for (int i = 0; i < states; ++i) {
        const double whole = std::sqrt(P(i, i) * static_cast<double>(s));
        EXPECT_NEAR(ph[i], static_cast<double>(g(i, 0)), kOneStep * whole);
        EXPECT_NEAR(gain[i], static_cast<double>(g(i, 0) / s), kOneStep * whole / static_cast<double>(s));
      }
      const Dense truth = reference::updated(Dense(P), z);
      double worst = 0;
      for (int i = 0; i < states; ++i)
        for (int j = 0; j < states; ++j)
          worst = std::max(worst, std::abs(static_cast<double>(Real(ours.matrix()(i, j)) - truth(i, j))) /
                                      std::sqrt(P(i, i) * P(j, j)));
      EXPECT_LT(worst, kOneStep) << states;
    }
}

TEST(Covariance, ConsideredStatesAreCountedNotCorrected) {
  for (const int states : {12, 21, 33})
    for (const Form form : kForms) {
      const StateMatrix P = covariance(states, 30);
      std::array<bool, navigation::kMaxStates> considered{};
      considered[4] = considered[9] = considered[static_cast<std::size_t>(states) - 1] = true;
      const std::span<const bool> flags(considered.data(), static_cast<std::size_t>(states));
      Covariance ours(P, form);
      Dense truth(P);
      for (std::uint64_t i = 0; i < 5; ++i) {
        const auto z = row(states, 31 + i);
        const StateVector gain = ours.update(z, flags);
        truth = reference::updated(truth, z, flags);
        for (int j = 0; j < states; ++j) EXPECT_EQ(gain[j] == 0, considered[static_cast<std::size_t>(j)]);
      }
      EXPECT_LT(error(ours.matrix(), truth),
                5 * 100 * kOneStep);  // differences of up to a hundred times their size
      for (const int j : {4, 9, states - 1}) EXPECT_NEAR(ours.variance(j), P(j, j), 5 * kOneStep * P(j, j));
    }
}

// A thousand steps and updates: still symmetric to the last bit, still a covariance, and all forms the same.
TEST(Covariance, StaysSymmetricAndPositive) {
  constexpr int kStates = 21, kSteps = 1000;
  std::vector<StateMatrix> ends;
  for (const Form form : kForms) {
    Covariance ours(covariance(kStates, 40), form);
    for (int i = 0; i < kSteps; ++i) {
      auto step = transition(kStates, 41 + static_cast<std::uint64_t>(i % 7));
      step.core = 0.8 * navigation::CoreMatrix::Identity() + 0.03 * step.core;  // decays
      step.input *= 0.05;
      for (auto& term : step.terms) term.noise += 0.01;
      ours.propagate(step);
      for (std::uint64_t j = 0; j < 3; ++j) (void)ours.update(row(kStates, 50 + j + static_cast<std::uint64_t>(i % 5)));
      if (i % 100 == 0) expect_covariance(ours.matrix());
    }
    expect_covariance(ours.matrix());
    ends.push_back(ours.matrix());
  }
  for (std::size_t f = 1; f < ends.size(); ++f)
    EXPECT_LT(error(ends[f], Dense(ends[0])), 1e-9);  // kSteps roundings, times a condition number of 1e4
}

TEST(Covariance, TakesSingularOnes) {
  StateMatrix P = StateMatrix::Zero(12, 12);
  for (const Form form : kForms) {
    Covariance none(P, form);
    EXPECT_EQ(none.matrix().cwiseAbs().sum(), 0);
    const auto z = row(12, 60);
    EXPECT_EQ(none.update(z).norm(), 0);
    const auto step = transition(12, 61);
    none.propagate(step);
    EXPECT_LT(error(none.matrix(), reference::noise<Real>(step)), kOneStep);
  }
  // Three states that are one
  P.setIdentity();
  P.block<3, 3>(3, 3).setOnes();
  for (const Form form : kForms) {
    Covariance ours(P, form);
    EXPECT_EQ((ours.matrix() - P).cwiseAbs().maxCoeff(), 0);
    (void)ours.update(row(12, 62));
    expect_covariance(ours.matrix());
  }
}

TEST(Covariance, RefusesWhatIsNone) {
  const auto refused = [](const StateMatrix& P) {
    for (const Form form : kForms) EXPECT_THROW((Covariance{P, form}), std::invalid_argument);
  };
  const StateMatrix good = covariance(12, 70);
  refused(good.topRows(11));
  refused(good.topLeftCorner(8, 8));
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0}) {
    StateMatrix P = good;
    P(3, 3) = bad;
    refused(P);
  }
  StateMatrix P = good;
  P(1, 2) += 1e-6 * std::sqrt(P(1, 1) * P(2, 2));
  refused(P);
  P = StateMatrix::Identity(12, 12);  // pairs correlate by -0.9 each: allowed two by two, not together
  P.block<3, 3>(0, 0).setConstant(-0.9);
  P.diagonal().setOnes();
  refused(P);

  Covariance ours(good, Form::joseph);
  EXPECT_THROW(ours.propagate(transition(13, 1)), std::invalid_argument);
  EXPECT_THROW((void)ours.times(StateVector::Zero(11)), std::invalid_argument);
  EXPECT_THROW(ours.update(row(11, 1)), std::invalid_argument);
  auto z = row(12, 1);
  for (const double bad :
       {0.0, -1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    z.variance = bad;
    EXPECT_THROW(ours.update(z), std::invalid_argument);
  }
  z = row(12, 1);
  z.h[4] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ours.update(z), std::invalid_argument);
  EXPECT_EQ((ours.matrix() - good).cwiseAbs().maxCoeff(), 0);
}

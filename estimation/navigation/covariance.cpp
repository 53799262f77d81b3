// SPDX-License-Identifier: MIT
#include "covariance.h"

#include "gyrobudget/estimation/navigation/detail/covariance_kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

constexpr int kCore = kCoreStates;
constexpr int kInputs = 6;
// Below this a weight is none; its square must not underflow beside others of 1e100.
constexpr double kVanished = 1e-200;
// A state that keeps less of itself over a step is new after it.
constexpr double kSmallDecay = 1e-50;
using CoreVector = Eigen::Matrix<double, kCore, 1>;

void check(const StateMatrix& P) {
  if (P.rows() != P.cols() || P.rows() < kCore)
    throw std::invalid_argument(
        fmt::format("covariance of {} x {}, expected square with at least {} rows", P.rows(), P.cols(), kCore));
  for (int j = 0; j < P.cols(); ++j)
    for (int i = 0; i <= j; ++i) {
      const double scale = std::sqrt(P(i, i)) * std::sqrt(P(j, j));
      if (!std::isfinite(P(i, j)) || !(P(j, j) >= 0) || !(std::abs(P(i, j) - P(j, i)) <= 1e-9 * scale) ||
          !(std::abs(P(i, j)) <= (1 + 1e-9) * scale))
        throw std::invalid_argument(
            fmt::format("covariance ({}, {}) is {} and ({}, {}) {} beside variances {} and {}: not a covariance", i, j,
                        P(i, j), j, i, P(j, i), P(i, i), P(j, j)));
    }
}

// P = U D U^T, U unit upper triangular with D on its diagonal (Bierman 1977, III.3). A remainder below
// rounding of its own variance is none: the state is a combination of those after it.
enum class Remainder { refused_if_negative, none_if_negative };
void factorise(StateMatrix& p, Remainder remainder) {
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * static_cast<double>(p.rows());
  const StateVector variance = p.diagonal();
  for (auto j = p.rows() - 1; j >= 0; --j) {
    const double d = p(j, j);
    if (remainder == Remainder::refused_if_negative && d < -rounding * variance[j])
      throw std::invalid_argument(fmt::format("covariance is not positive semi-definite at state {}", j));
    if (d <= rounding * variance[j]) {
      p.col(j).head(j + 1).setZero();
      continue;
    }
    for (auto i = j - 1; i >= 0; --i) {
      const double u = p(i, j) / d;
      p.col(i).head(i + 1) -= u * p.col(j).head(i + 1);
      p(i, j) = u;
    }
  }
}

// U D U^T <- U D U^T + c a a^T, c >= 0, for the first a.size() states (Agee & Turner 1972; Bierman 1977,
// III.4). Where the new term prevails, U and a are weighed instead of corrected: nothing cancels (V.3).
template <typename Factors>
void add_rank_one(Factors& ud, double c, StateVector& a) {
  for (auto j = a.size() - 1; j >= 0 && c > 0; --j) {
    const double s = a[j], old = ud(j, j), d = old + c * s * s;
    if (s == 0 || d < kVanished) continue;
    const double beta = c * s / d, kept = old / d;
    c *= kept;
    ud(j, j) = d;
    auto u = ud.col(j).head(j);
    if (beta * s <= 1. / 16) {
      a.head(j) -= s * u;
      u += beta * a.head(j);
    } else {
      for (Eigen::Index i = 0; i < j; ++i) {
        const double before = u[i];
        u[i] = kept * before + beta * a[i];
        a[i] -= s * before;
      }
    }
  }
}

// Modified weighted Gram-Schmidt (Thornton 1976; Bierman 1977, VI.4): W diag(weight) W^T = U D U^T into the
// first rows of `ud`, for the rows of a small W.
template <typename Factors>
void orthogonalise(Eigen::Matrix<double, kCore + kInputs, kCore>& w,
                   const Eigen::Matrix<double, kCore + kInputs, 1>& weight, Factors& ud) {
  Eigen::Matrix<double, kCore + kInputs, 1> weighted;
  for (int j = kCore - 1; j >= 0; --j) {
    weighted = weight.cwiseProduct(w.col(j));
    const double d = weighted.dot(w.col(j));
    ud(j, j) = d;
    for (int i = 0; i < j; ++i) {
      const double u = d > kVanished ? weighted.dot(w.col(i)) / d : 0;
      ud(i, j) = u;
      w.col(i) -= u * w.col(j);
    }
  }
}

void zero_considered(StateVector& gain, std::span<const bool> considered) {
  for (std::size_t i = 0; i < considered.size(); ++i)
    if (considered[i]) gain[static_cast<Eigen::Index>(i)] = 0;
}

}  // namespace

Covariance::Covariance(const StateMatrix& P, Form form)
    : form_(form == Form::automatic ? Form::joseph : form),
      automatic_(form == Form::automatic),
      size_(static_cast<int>(P.rows())),
      p_(StateMatrix::Zero(detail::padded(size_), P.cols())) {
  check(P);
  StateMatrix factors = P;
  factorise(factors, Remainder::refused_if_negative);
  p_.topRows(size_) = form == Form::square_root ? factors : StateMatrix((P + P.transpose()) / 2);
}

void Covariance::propagate(const Transition& step) {
  if (step.size != size_)
    throw std::invalid_argument(fmt::format("transition of {} states, covariance of {}", step.size, size_));
  if (form_ == Form::square_root)
    propagate_factors(step);
  else
    detail::propagate_dense(detail::best_target(), step, p_.data());
}

// Phi U = [core U_cc, core U_cs + C U_ss; 0, decay U_ss] is triangular already but for its first nine rows
// and columns: only these, with the inputs' noise, have to be made triangular anew. What is left is the
// diagonal of the sensor block, made one again by weights, and one rank-one addition a noisy term.
void Covariance::propagate_factors(const Transition& step) {
  const int n = size_ - kCore;
  Eigen::Matrix<double, kCore + kInputs, kCore> w;
  Eigen::Matrix<double, kCore + kInputs, 1> weight;
  CoreMatrix u = p_.topLeftCorner<kCore, kCore>().triangularView<Eigen::UnitUpper>();
  w.topRows<kCore>().noalias() = u.transpose().lazyProduct(step.core.transpose());
  w.bottomRows<kInputs>() = step.input.transpose();
  weight << p_.diagonal().head<kCore>(), step.input_noise;
  orthogonalise(w, weight, p_);

  for (int k = 0; k < n; ++k) transform_column(step, k);
  StateVector kick(size_);
  for (int k = 0; k < n; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.noise == 0) continue;
    kick.setZero(kCore + k + 1);
    kick[kCore + k] = 1;
    if (term.signal >= 0) kick.head<kCore>() = term.spill * step.input.col(term.signal);
    add_rank_one(p_, term.noise, kick);
  }
}

// Column 9 + k of Phi U, with its last element made one. Where next to nothing of the state is left, the
// column is instead a source of the states before it.
void Covariance::transform_column(const Transition& step, int k) {
  const double own = step.terms[static_cast<std::size_t>(k)].decay;
  auto column = p_.col(kCore + k);
  double& d = p_(kCore + k, kCore + k);
  const double variance = d;
  d = 1;
  Eigen::Matrix<double, kInputs, 1> errors = Eigen::Matrix<double, kInputs, 1>::Zero();
  for (int i = 0; i <= k; ++i) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(i)];
    if (term.signal >= 0) errors[term.signal] += term.gain * column[kCore + i];
    column[kCore + i] *= term.decay;
  }
  const CoreVector top = column.head<kCore>();
  column.head<kCore>().noalias() = step.core.lazyProduct(top);
  column.head<kCore>().noalias() += step.input.lazyProduct(errors);
  d = variance * own * own;
  if (own > kSmallDecay && d > kVanished) {
    if (own != 1) column.head(kCore + k) /= own;
    return;
  }
  StateVector source = column.head(kCore + k);
  column.setZero();
  if (variance > 0) add_rank_one(p_, variance, source);
}

StateVector Covariance::times(const StateVector& h) const {
  if (h.size() != size_)
    throw std::invalid_argument(fmt::format("row of {} states, covariance of {}", h.size(), size_));
  if (form_ != Form::square_root) return p_.topRows(size_).lazyProduct(h);
  StateVector f(size_);
  for (int j = 0; j < size_; ++j) f[j] = p_(j, j) * (h[j] + p_.col(j).head(j).dot(h.head(j)));
  for (int j = 0; j < size_; ++j) f.head(j) += f[j] * p_.col(j).head(j);
  return f;
}

StateVector Covariance::update(const MeasurementRow& row, std::span<const bool> considered) {
  if (row.h.size() != size_ || !(row.variance > 0) || !std::isfinite(row.variance) || !row.h.allFinite())
    throw std::invalid_argument(
        fmt::format("measurement row of {} states with variance {}, expected {} states, finite, and a variance above 0",
                    row.h.size(), row.variance, size_));
  return form_ == Form::square_root ? update_factors(row, considered) : update_dense(row, considered);
}

StateVector Covariance::update_dense(const MeasurementRow& row, std::span<const bool> considered) {
  auto p = p_.topRows(size_);
  StateVector g(size_);
  g.noalias() = p.lazyProduct(row.h);
  const double s = row.h.dot(g) + row.variance;
  if (automatic_ && s > kShrinkLimit * row.variance) {
    leave_for_square_root();
    return update_factors(row, considered);
  }
  StateVector gain = g / s;
  zero_considered(gain, considered);
  // Plain: P - k g^T - g k^T + S k k^T, which is P - k h P where k is optimal.
  if (form_ == Form::plain) {
    for (int j = 0; j < size_; ++j) p.col(j) -= gain[j] * g + (g[j] - s * gain[j]) * gain;
    symmetrise();
  } else {
    joseph(row, g, gain);
  }
  return gain;
}

// From the left, then from the right with what h sees of it, so errors of the gain enter squared. g is P h.
void Covariance::joseph(const MeasurementRow& row, StateVector& g, const StateVector& gain) {
  auto p = p_.topRows(size_);
  for (int j = 0; j < size_; ++j) p.col(j) -= g[j] * gain;
  g.noalias() = p.lazyProduct(row.h);
  for (int j = 0; j < size_; ++j) p.col(j) += gain[j] * (row.variance * gain - g);
  symmetrise();
}

void Covariance::leave_for_square_root() {
  StateMatrix factors = p_.topRows(size_);
  factorise(factors, Remainder::none_if_negative);
  p_.topRows(size_) = factors;
  form_ = Form::square_root;
}

void Covariance::symmetrise() {
  for (int j = 0; j < size_; ++j)
    for (int i = 0; i < j; ++i) p_(i, j) = p_(j, i) = (p_(i, j) + p_(j, i)) / 2;
}

void Covariance::update_with(const MeasurementRow& row, const StateVector& gain) {
  if (form_ == Form::square_root || row.h.size() != size_ || gain.size() != size_)
    throw std::invalid_argument(
        fmt::format("update with a given gain needs the plain or Joseph form and {} states; row has {}, gain {}", size_,
                    row.h.size(), gain.size()));
  StateVector g(size_);
  g.noalias() = p_.topRows(size_).lazyProduct(row.h);
  joseph(row, g, gain);
}

void Covariance::add(const StateMatrix& more) {
  if (form_ == Form::square_root || more.rows() != size_ || more.cols() != size_)
    throw std::invalid_argument(fmt::format("an addition of {} x {} needs the plain or Joseph form and {} states",
                                            more.rows(), more.cols(), size_));
  p_.topRows(size_) += more;
  symmetrise();
}

StateVector Covariance::update_factors(const MeasurementRow& row, std::span<const bool> considered) {
  StateVector gain = StateVector::Zero(size_);
  double alpha = row.variance;
  for (int j = 0; j < size_; ++j) {
    const double f = row.h[j] + p_.col(j).head(j).dot(row.h.head(j));
    gain[j] = f;  // U^T h, before U changes
  }
  const StateVector f = gain;
  gain.setZero();
  for (int j = 0; j < size_; ++j) {
    const double v = p_(j, j) * f[j], before = alpha;
    alpha += f[j] * v;
    const double lambda = -f[j] / before;
    p_(j, j) *= before / alpha;
    for (int i = 0; i < j; ++i) {
      const double u = p_(i, j);
      p_(i, j) = u + lambda * gain[i];
      gain[i] += v * u;
    }
    gain[j] = v;
  }
  gain /= alpha;
  if (std::none_of(considered.begin(), considered.end(), [](bool c) { return c; })) return gain;
  StateVector left_out = gain;
  zero_considered(gain, considered);
  left_out -= gain;
  add_rank_one(p_, alpha, left_out);
  return gain;
}

StateMatrix Covariance::matrix() const {
  if (form_ != Form::square_root) return p_.topRows(size_);
  const StateMatrix u = p_.topRows(size_).triangularView<Eigen::UnitUpper>();
  const StateMatrix P = u * p_.diagonal().asDiagonal() * u.transpose();
  return (P + P.transpose()) / 2;
}

double Covariance::variance(int i) const {
  if (form_ != Form::square_root) return p_(i, i);
  double sum = p_(i, i);
  for (int j = i + 1; j < size_; ++j) sum += p_(i, j) * p_(i, j) * p_(j, j);
  return sum;
}

LocalSigmas local_sigmas(const CoreMatrix& covariance_e, const Eigen::Matrix3d& C_el) {
  const auto sigmas = [&](int row) -> Eigen::Vector3d {
    const Eigen::Matrix3d local = C_el.transpose() * covariance_e.block<3, 3>(row, row) * C_el;
    return local.diagonal().cwiseMax(0).cwiseSqrt();
  };
  return {sigmas(kPosition), sigmas(kVelocity), sigmas(kAttitude)};
}

}  // namespace gyrobudget::inline v0::navigation

// SPDX-License-Identifier: MIT
#include "covariance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

constexpr int kCore = kCoreStates;
// Room for the weighted rows of Thornton's algorithm: states, six inputs, one noise a term.
constexpr int kMaxColumns = kMaxStates + 6 + kMaxErrorTerms;
using Tall = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxColumns, kMaxStates>;
using Weights = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxColumns, 1>;
using Signals = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxStates, 6>;
using CoreColumns = Eigen::Matrix<double, Eigen::Dynamic, kCore, 0, kMaxStates, kCore>;

void check(const StateMatrix& P) {
  if (P.rows() != P.cols() || P.rows() < kCore)
    throw std::invalid_argument(fmt::format("covariance of {} x {}, expected square with at least {} rows",
                                            P.rows(), P.cols(), kCore));
  for (int j = 0; j < P.cols(); ++j)
    for (int i = 0; i <= j; ++i) {
      const double scale = std::sqrt(P(i, i)) * std::sqrt(P(j, j));
      if (!std::isfinite(P(i, j)) || !(P(j, j) >= 0) || !(std::abs(P(i, j) - P(j, i)) <= 1e-9 * scale) ||
          !(std::abs(P(i, j)) <= (1 + 1e-9) * scale))
        throw std::invalid_argument(fmt::format(
            "covariance ({}, {}) is {} and ({}, {}) {} beside variances {} and {}: not a covariance", i, j,
            P(i, j), j, i, P(j, i), P(i, i), P(j, j)));
    }
}

// P = U D U^T, U unit upper triangular with D on its diagonal (Bierman 1977, III.3). A remainder below rounding
// of its own variance is none: the state is a combination of those after it.
void factorise(StateMatrix& p) {
  const double rounding = 16 * std::numeric_limits<double>::epsilon() * static_cast<double>(p.rows());
  const StateVector variance = p.diagonal();
  for (auto j = p.rows() - 1; j >= 0; --j) {
    const double d = p(j, j);
    if (d < -rounding * variance[j])
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

// U D U^T <- U D U^T + c a a^T, c >= 0 (Agee & Turner 1972; Bierman 1977, III.4).
void add_rank_one(StateMatrix& ud, double c, StateVector& a) {
  for (auto j = ud.rows() - 1; j >= 0; --j) {
    const double s = a[j], d = ud(j, j) + c * s * s;
    if (d == 0) continue;
    const double beta = c * s / d;
    c *= ud(j, j) / d;
    ud(j, j) = d;
    a.head(j) -= s * ud.col(j).head(j);
    ud.col(j).head(j) += beta * a.head(j);
  }
}

void zero_considered(StateVector& gain, std::span<const bool> considered) {
  for (std::size_t i = 0; i < considered.size(); ++i)
    if (considered[i]) gain[static_cast<Eigen::Index>(i)] = 0;
}

}  // namespace

Covariance::Covariance(const StateMatrix& P, Form form)
    : form_(form), size_(static_cast<int>(P.rows())), p_(P) {
  check(P);
  StateMatrix factors = P;
  factorise(factors);
  if (form == Form::square_root) p_ = factors;
}

void Covariance::propagate(const Transition& step) {
  if (step.size != size_)
    throw std::invalid_argument(fmt::format("transition of {} states, covariance of {}", step.size, size_));
  form_ == Form::square_root ? propagate_factors(step) : propagate_dense(step);
}

// With C = input W, W (6 x n) one gain a column, and M = [core, C] P:
//   P_cc = M_c core^T + (M_s W^T) input^T + input q input^T,  P_sc = decay (M_s)^T + ...,  P_ss = decay P decay + q.
// Every product runs along columns of P.
void Covariance::propagate_dense(const Transition& step) {
  const int n = size_ - kCore;
  Signals errors = Signals::Zero(size_, 6);  // P W^T
  Eigen::Matrix<double, 6, 1> noise = step.input_noise;
  bool decays = false;
  for (int k = 0; k < n; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    decays |= term.decay != 1;
    if (term.signal < 0) continue;
    errors.col(term.signal) += term.gain * p_.col(kCore + k);
    noise[term.signal] += term.noise * term.spill * term.spill;
  }
  CoreColumns m(size_, kCore);  // M^T
  m.noalias() = p_.leftCols<kCore>().lazyProduct(step.core.transpose());
  m.noalias() += errors.lazyProduct(step.input.transpose());

  Eigen::Matrix<double, kCore, 6> shared = step.input * noise.asDiagonal();
  for (int k = 0; k < n; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.signal >= 0) shared.col(term.signal) += term.gain * m.row(kCore + k).transpose();
  }
  CoreMatrix core;
  core.noalias() = m.topRows<kCore>().transpose().lazyProduct(step.core.transpose());
  core.noalias() += shared.lazyProduct(step.input.transpose());
  p_.topLeftCorner<kCore, kCore>() = (core + core.transpose()) / 2;

  for (int k = 0; k < n; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    auto column = p_.col(kCore + k).head<kCore>();
    column = term.decay * m.row(kCore + k).transpose();
    if (term.signal >= 0 && term.noise != 0) column += term.noise * term.spill * step.input.col(term.signal);
    p_.row(kCore + k).head<kCore>() = column.transpose();
    if (decays)
      for (int l = 0; l < n; ++l)
        p_(kCore + l, kCore + k) *= term.decay * step.terms[static_cast<std::size_t>(l)].decay;
    p_(kCore + k, kCore + k) += term.noise;
  }
}

// Thornton's modified weighted Gram-Schmidt on the rows of [Phi U, G] with weights [D, q], last row first.
// A row of W is a column here, so that the inner loops are contiguous.
void Covariance::propagate_factors(const Transition& step) {
  const int n = size_ - kCore;
  const int columns = size_ + 6 + n;
  Tall w = Tall::Zero(columns, size_);
  Weights weight(columns);
  weight.head(size_) = p_.diagonal();
  weight.segment<6>(size_) = step.input_noise;

  // Rows of U to columns, with the unit diagonal.
  for (int i = 0; i < size_; ++i) {
    w(i, i) = 1;
    for (int j = i + 1; j < size_; ++j) w(j, i) = p_(i, j);
  }
  CoreColumns core = w.topLeftCorner(size_, kCore).lazyProduct(step.core.transpose());
  Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kMaxStates, 6> errors = Signals::Zero(size_, 6);
  for (int k = 0; k < n; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    auto row = w.col(kCore + k);
    if (term.signal >= 0) errors.col(term.signal) += term.gain * row.head(size_);
    row.head(size_) *= term.decay;
    row[size_ + 6 + k] = 1;
    weight[size_ + 6 + k] = term.noise;
    if (term.signal >= 0)
      w.row(size_ + 6 + k).head<kCore>() = term.spill * step.input.col(term.signal).transpose();
  }
  w.topLeftCorner(size_, kCore) = core + errors.lazyProduct(step.input.transpose());
  w.block(size_, 0, 6, kCore) = step.input.transpose();

  Weights weighted(columns);
  for (int j = size_ - 1; j >= 0; --j) {
    weighted = weight.cwiseProduct(w.col(j));
    const double d = weighted.dot(w.col(j));
    p_(j, j) = d;
    for (int i = 0; i < j; ++i) {
      const double u = d > 0 ? weighted.dot(w.col(i)) / d : 0;
      p_(i, j) = u;
      w.col(i) -= u * w.col(j);
    }
  }
}

StateVector Covariance::times(const StateVector& h) const {
  if (h.size() != size_)
    throw std::invalid_argument(fmt::format("row of {} states, covariance of {}", h.size(), size_));
  if (form_ != Form::square_root) return p_ * h;
  StateVector f(size_);
  for (int j = 0; j < size_; ++j) f[j] = p_(j, j) * (h[j] + p_.col(j).head(j).dot(h.head(j)));
  for (int j = 0; j < size_; ++j) f.head(j) += f[j] * p_.col(j).head(j);
  return f;
}

StateVector Covariance::update(const MeasurementRow& row, std::span<const bool> considered) {
  if (row.h.size() != size_ || !(row.variance > 0) || !std::isfinite(row.variance) || !row.h.allFinite())
    throw std::invalid_argument(fmt::format(
        "measurement row of {} states with variance {}, expected {} states, finite, and a variance "
        "above 0",
        row.h.size(), row.variance, size_));
  return form_ == Form::square_root ? update_factors(row, considered) : update_dense(row, considered);
}

StateVector Covariance::update_dense(const MeasurementRow& row, std::span<const bool> considered) {
  StateVector g(size_);
  g.noalias() = p_ * row.h;
  const double s = row.h.dot(g) + row.variance;
  StateVector gain = g / s;
  zero_considered(gain, considered);
  // Plain: P - k g^T - g k^T + S k k^T, which is P - k h P where k is optimal.
  if (form_ == Form::plain) {
    for (int j = 0; j < size_; ++j) p_.col(j) += (s * gain[j] - g[j]) * gain - gain[j] * g;
    symmetrise();
  } else {
    joseph(row, g, gain);
  }
  return gain;
}

// From the left, then from the right with what h sees of it, so that errors of the gain enter squared. g is P h.
void Covariance::joseph(const MeasurementRow& row, StateVector& g, const StateVector& gain) {
  for (int j = 0; j < size_; ++j) p_.col(j) -= g[j] * gain;
  g.noalias() = p_ * row.h;
  for (int j = 0; j < size_; ++j) p_.col(j) += gain[j] * (row.variance * gain - g);
  symmetrise();
}

void Covariance::symmetrise() {
  for (int j = 0; j < size_; ++j)
    for (int i = 0; i < j; ++i) p_(i, j) = p_(j, i) = (p_(i, j) + p_(j, i)) / 2;
}

void Covariance::update_with(const MeasurementRow& row, const StateVector& gain) {
  if (form_ == Form::square_root || row.h.size() != size_ || gain.size() != size_)
    throw std::invalid_argument(fmt::format(
        "update with a given gain needs the plain or Joseph form and {} states; row has {}, gain {}", size_,
        row.h.size(), gain.size()));
  StateVector g(size_);
  g.noalias() = p_ * row.h;
  joseph(row, g, gain);
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
  if (form_ != Form::square_root) return p_;
  StateMatrix u = p_.triangularView<Eigen::UnitUpper>();
  return u * p_.diagonal().asDiagonal() * u.transpose();
}

double Covariance::variance(int i) const {
  if (form_ != Form::square_root) return p_(i, i);
  double sum = p_(i, i);
  for (int j = i + 1; j < size_; ++j) sum += p_(i, j) * p_(i, j) * p_(j, j);
  return sum;
}

}  // namespace gyrobudget::inline v0::navigation

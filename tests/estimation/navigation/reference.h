// SPDX-License-Identifier: MIT
// Plain dense algebra over any scalar, long double or one of many digits: what the filter's numbers are held
// against. Slow, and written from the textbook alone.
#pragma once

#include "gyrobudget/estimation/navigation/covariance.h"
#include "gyrobudget/estimation/navigation/error_state.h"
#include "gyrobudget/noise/normal.h"

#include <cstddef>
#include <span>
#include <vector>

namespace gyrobudget::reference {

template <typename T>
class Matrix {
 public:
  Matrix(int rows, int cols)
      : rows_(rows), cols_(cols), x_(static_cast<std::size_t>(rows) * static_cast<std::size_t>(cols), T(0)) {}
  template <typename Derived>
  explicit Matrix(const Eigen::MatrixBase<Derived>& m)
      : Matrix(static_cast<int>(m.rows()), static_cast<int>(m.cols())) {
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < cols_; ++j) (*this)(i, j) = T(m(i, j));
  }
  static Matrix identity(int n) {
    Matrix m(n, n);
    for (int i = 0; i < n; ++i) m(i, i) = T(1);
    return m;
  }

  [[nodiscard]] int rows() const { return rows_; }
  [[nodiscard]] int cols() const { return cols_; }
  T& operator()(int i, int j) { return x_[static_cast<std::size_t>(i * cols_ + j)]; }
  const T& operator()(int i, int j) const { return x_[static_cast<std::size_t>(i * cols_ + j)]; }

  [[nodiscard]] Matrix transposed() const {
    Matrix m(cols_, rows_);
    for (int i = 0; i < rows_; ++i)
      for (int j = 0; j < cols_; ++j) m(j, i) = (*this)(i, j);
    return m;
  }
  friend Matrix operator*(const Matrix& a, const Matrix& b) {
    Matrix m(a.rows_, b.cols_);
    for (int i = 0; i < a.rows_; ++i)
      for (int k = 0; k < a.cols_; ++k) {
        if (a(i, k) == 0) continue;
        for (int j = 0; j < b.cols_; ++j) m(i, j) += a(i, k) * b(k, j);
      }
    return m;
  }
  friend Matrix operator*(const T& s, Matrix a) {
    for (T& x : a.x_) x *= s;
    return a;
  }
  friend Matrix operator+(Matrix a, const Matrix& b) {
    for (std::size_t i = 0; i < a.x_.size(); ++i) a.x_[i] += b.x_[i];
    return a;
  }
  friend Matrix operator-(Matrix a, const Matrix& b) {
    for (std::size_t i = 0; i < a.x_.size(); ++i) a.x_[i] -= b.x_[i];
    return a;
  }

  /// A^-1 of a symmetric positive definite matrix, by Gauss-Jordan without exchange.
  [[nodiscard]] Matrix inverse() const {
    Matrix a = *this, b = identity(rows_);
    for (int p = 0; p < rows_; ++p) {
      const T pivot = a(p, p);
      for (int j = 0; j < cols_; ++j) {
        a(p, j) /= pivot;
        b(p, j) /= pivot;
      }
      for (int i = 0; i < rows_; ++i) {
        if (i == p) continue;
        const T factor = a(i, p);
        for (int j = 0; j < cols_; ++j) {
          a(i, j) -= factor * a(p, j);
          b(i, j) -= factor * b(p, j);
        }
      }
    }
    return b;
  }

 private:
  int rows_, cols_;
  std::vector<T> x_;
};

/// Phi of a step, from its factors.
template <typename T>
Matrix<T> phi(const navigation::Transition& step) {
  Matrix<T> m(step.size, step.size);
  for (int i = 0; i < navigation::kCoreStates; ++i)
    for (int j = 0; j < navigation::kCoreStates; ++j) m(i, j) = T(step.core(i, j));
  for (int k = navigation::kCoreStates; k < step.size; ++k) {
    const auto& term = step.terms[static_cast<std::size_t>(k - navigation::kCoreStates)];
    m(k, k) = T(term.decay);
    for (int i = 0; term.signal >= 0 && i < navigation::kCoreStates; ++i)
      m(i, k) = T(term.gain) * T(step.input(i, term.signal));
  }
  return m;
}

/// Q of a step, from its factors.
template <typename T>
Matrix<T> noise(const navigation::Transition& step) {
  const int inputs = 6, terms = step.size - navigation::kCoreStates;
  Matrix<T> g(step.size, inputs + terms), q(inputs + terms, inputs + terms);
  for (int s = 0; s < inputs; ++s) {
    q(s, s) = T(step.input_noise[s]);
    for (int i = 0; i < navigation::kCoreStates; ++i) g(i, s) = T(step.input(i, s));
  }
  for (int k = 0; k < terms; ++k) {
    const auto& term = step.terms[static_cast<std::size_t>(k)];
    q(inputs + k, inputs + k) = T(term.noise);
    g(navigation::kCoreStates + k, inputs + k) = T(1);
    for (int i = 0; term.signal >= 0 && i < navigation::kCoreStates; ++i)
      g(i, inputs + k) = T(term.spill) * T(step.input(i, term.signal));
  }
  return g * q * g.transposed();
}

template <typename T>
Matrix<T> propagated(const Matrix<T>& P, const navigation::Transition& step) {
  const Matrix<T> m = phi<T>(step);
  return m * P * m.transposed() + noise<T>(step);
}

/// (I - k h) P (I - k h)^T + r k k^T with the optimal gain, but 0 for considered states.
template <typename T>
Matrix<T> updated(const Matrix<T>& P, const navigation::MeasurementRow& row, std::span<const bool> considered = {}) {
  const Matrix<T> h = Matrix<T>(row.h).transposed(), g = P * h.transposed();
  Matrix<T> k = (T(1) / ((h * g)(0, 0) + T(row.variance))) * g;
  for (std::size_t i = 0; i < considered.size(); ++i)
    if (considered[i]) k(static_cast<int>(i), 0) = T(0);
  const Matrix<T> left = Matrix<T>::identity(P.rows()) - k * h;
  return left * P * left.transposed() + T(row.variance) * (k * k.transposed());
}

/// Standard normal numbers by their index.
class Normal {
 public:
  explicit Normal(std::uint64_t seed) : seed_(seed) {}
  double operator()() {
    double x = 0;
    noise::fill_normal({seed_, 0}, next_++, {&x, 1});
    return x;
  }
  template <typename Any>
  void fill(Any& m) {
    for (Eigen::Index j = 0; j < m.cols(); ++j)
      for (Eigen::Index i = 0; i < m.rows(); ++i) m(i, j) = (*this)();
  }

 private:
  std::uint64_t seed_, next_ = 0;
};

}  // namespace gyrobudget::reference

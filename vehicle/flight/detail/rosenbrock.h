// SPDX-License-Identifier: MIT
// RODAS: a stiffly accurate Rosenbrock method of order 4 with an embedded one of order 3, six stages.
// Source: E. Hairer & G. Wanner, Solving Ordinary Differential Equations II (2nd ed. 1996), section IV.7, in
// the transformed form of IV.7, eq. (7.25), that needs no product with the Jacobian; coefficients of the
// method "RODAS" there, section VI.4.
#pragma once

#include <array>
#include <cmath>

#include "square.h"
#include <Eigen/Core>

namespace gyrobudget::inline v0::flight::detail {

/// One step of y' = f(t, y): (I/(g h) - J) k_i = f(t + c_i h, y + sum a_ij k_j) + sum C_ij k_j/h + d_i h f_t.
/// J and f_t come from forward differences of the size `scale` eps^(1/2).
template <int N>
class Rosenbrock {
 public:
  static_assert(N <= kMostStates);
  using X = Eigen::Matrix<double, N, 1>;

  /// System is called as system(y, dydt, t).
  template <class System>
  void step(const System& system, const X& y, double t, double h, const X& scale, X& out, X& error) {
    X f0, ft;
    linearise(system, y, t, h, scale, f0, ft);
    Square w = -jacobian_;
    w.diagonal().array() += 1 / (kGamma * h);
    const Factors factors(w);
    std::array<X, kStages> k;
    X at, f;
    for (std::size_t i = 0; i < kStages; ++i) {
      if (i == 0) {
        f = f0;
      } else {
        at = y;
        for (std::size_t j = 0; j < i; ++j) at += kA[i][j] * k[j];
        system(at, f, t + kC[i] * h);
      }
      for (std::size_t j = 0; j < i; ++j) f += (kK[i][j] / h) * k[j];
      if (kD[i] != 0) f += (kD[i] * h) * ft;
      factors.solve(f.data(), k[i].data());
    }
    out = at + k[5];
    error = k[5];
  }

  template <class System>
  const Square& jacobian(const System& system, const X& y, double t, double h, const X& scale) {
    X f0, ft;
    linearise(system, y, t, h, scale, f0, ft);
    return jacobian_;
  }
  static constexpr int kEvaluations = N + 7;

 private:
  static constexpr std::size_t kStages = 6;
  static constexpr double kGamma = 0.25;
  static constexpr std::array<double, kStages> kC{0, 0.386, 0.21, 0.63, 1, 1};
  static constexpr std::array<double, kStages> kD{0.25, -0.1043, 0.1035, -0.0362, 0, 0};
  using Rows = std::array<std::array<double, kStages - 1>, kStages>;
  static constexpr Rows kA{{{},
                            {1.544},
                            {0.9466785280815826, 0.2557011698983284},
                            {3.314825187068521, 2.896124015972201, 0.9986419139977817},
                            {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950},
                            {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.6878860361058950, 1}}};
  static constexpr Rows kK{
      {{},
       {-5.6688},
       {-2.430093356833875, -0.2063599157091915},
       {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
       {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.70890893206160},
       {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054}}};

  template <class System>
  void linearise(const System& system, const X& y, double t, double h, const X& scale, X& f0, X& ft) {
    constexpr double root = 1.5e-8;
    system(y, f0, t);
    X moved = y, f;
    for (int j = 0; j < N; ++j) {
      moved[j] = y[j] + root * std::max(std::abs(y[j]), scale[j]);
      system(moved, f, t);
      jacobian_.col(j) = (f - f0) / (moved[j] - y[j]);
      moved[j] = y[j];
    }
    const double later = t + 1e-3 * h;
    system(y, f, later);
    ft = (f - f0) / (later - t);
  }

  Square jacobian_{N, N};
};

}  // namespace gyrobudget::inline v0::flight::detail

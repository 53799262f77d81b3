// SPDX-License-Identifier: MIT
// The two halves of the covariance's fast evaluation: kernels free of cancellation, against the nine-term definition
// in quadruple precision; and few nodes in place of all lags, against all lags.
#include "gyrobudget/allan/detail/lag_sum.h"

#include "gyrobudget/allan/detail/lag_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace gyrobudget::allan::detail {
namespace {

__extension__ using Quad = __float128;

// ---- kernels ---------------------------------------------------------------------------------------------------

Quad exponential(Quad x) {  // Taylor after halving; the arguments here are within +-100
  constexpr int kHalvings = 20, kTerms = 12;
  x /= 1 << kHalvings;
  Quad sum = 1;
  for (int k = kTerms; k > 0; --k) sum = 1 + sum * x / k;
  for (int i = 0; i < kHalvings; ++i) sum *= sum;
  return sum;
}

/// Phase covariances R/dt^2 at lags 0 .. last, from their definition.
std::vector<Quad> phase_covariances(const noise::Process& process, double dt, std::int64_t last) {
  std::vector<Quad> r(static_cast<std::size_t>(last) + 1);
  Quad odd_harmonic = 0;
  Quad decay = 0, phi = 0, power = 1;
  if (const auto* p = std::get_if<noise::GaussMarkov>(&process)) {
    decay = static_cast<Quad>(dt) / static_cast<Quad>(p->correlation_time);
    phi = exponential(-decay);
  }
  for (std::size_t h = 0; h < r.size(); ++h) {
    const Quad lag = static_cast<Quad>(h);
    switch (noise::term(process)) {
      case noise::Term::quantization:
        r[h] = h == 0 ? 1 / (static_cast<Quad>(dt) * dt) : 0;
        break;
      case noise::Term::white:
        r[h] = -lag / (2 * static_cast<Quad>(dt));
        break;
      case noise::Term::flicker:
        r[h] = (4 * lag * lag - 1) * odd_harmonic / (4 * static_cast<Quad>(std::numbers::pi));
        odd_harmonic += 1 / (2 * lag + 1);
        break;
      case noise::Term::rate_random_walk:
        r[h] = dt * (lag * lag * lag - lag) / 12;
        break;
      case noise::Term::gauss_markov:
        r[h] = -lag * (1 + phi) / (2 * (1 - phi)) + phi * (1 - power) / ((1 - phi) * (1 - phi));
        power *= phi;
        break;
      default:
        break;
    }
  }
  return r;
}

Quad nine_terms(const std::vector<Quad>& r, std::int64_t m1, std::int64_t m2, std::int64_t u) {
  const int c[] = {1, -2, 1};
  Quad sum = 0;
  for (int a = -1; a <= 1; ++a) {
    for (int b = -1; b <= 1; ++b) {
      sum += c[a + 1] * c[b + 1] * r[static_cast<std::size_t>(std::abs(u + a * m1 + b * m2))];
    }
  }
  return sum / (2 * static_cast<Quad>(m1) * m2);
}

/// Lags around every kink and a sprinkling between and beyond.
std::vector<std::int64_t> interesting_lags(std::int64_t m1, std::int64_t m2) {
  std::vector<std::int64_t> lags;
  for (const std::int64_t knot : {std::int64_t{0}, m1, m2 - m1, m2, m1 + m2}) {
    for (std::int64_t step = -40; step <= 40; ++step) lags.push_back(knot + step);
    for (double away = 50; away < 40. * static_cast<double>(m2); away *= 1.3) {
      lags.push_back(knot + static_cast<std::int64_t>(away));
      lags.push_back(knot - static_cast<std::int64_t>(away));
    }
  }
  std::erase_if(lags, [](std::int64_t lag) { return lag < 0; });
  return lags;
}

// Relative to the geometric mean of the two Allan variances, the natural scale of C.
constexpr double kKernelError = 1e-12;

class LagKernel : public testing::TestWithParam<noise::Process> {};

TEST_P(LagKernel, IsTheFourthDifferenceOfThePhaseCovariance) {
  const std::int64_t kPairs[][2] = {{1, 1},   {1, 2},    {1, 3},     {2, 2},      {7, 11},     {16, 16},   {16, 17},
                                    {1, 100}, {30, 500}, {100, 130}, {1, 10'000}, {100, 3000}, {777, 3001}};
  constexpr double kInterval = 0.01;
  const std::vector<Quad> r = phase_covariances(GetParam(), kInterval, 420'000);
  for (const auto& [m1, m2] : kPairs) {
    const std::vector<std::int64_t> lags = interesting_lags(m1, m2);
    const std::vector<double> u(lags.begin(), lags.end());
    std::vector<double> c(u.size());
    lag_kernel(GetParam(), {m1, m2, kInterval}, u, c);
    const auto scale = std::sqrt(static_cast<double>(nine_terms(r, m1, m1, 0) * nine_terms(r, m2, m2, 0)));
    for (std::size_t i = 0; i < lags.size(); ++i) {
      const auto truth = static_cast<double>(nine_terms(r, m1, m2, lags[i]));
      ASSERT_NEAR(c[i] / scale, truth / scale, kKernelError) << "m " << m1 << " " << m2 << " u " << lags[i];
    }
  }
}

std::string name_of(const testing::TestParamInfo<noise::Process>& info) {
  std::string name = std::to_string(info.index);
  name.push_back(static_cast<char>(noise::term(info.param)));
  return name;
}

INSTANTIATE_TEST_SUITE_P(Processes, LagKernel,
                         testing::Values(noise::Quantization{1}, noise::White{1}, noise::Flicker{1},
                                         noise::RateRandomWalk{1}, noise::GaussMarkov{1, 1e-4},
                                         noise::GaussMarkov{1, 0.009}, noise::GaussMarkov{1, 0.5},
                                         noise::GaussMarkov{1, 37}, noise::GaussMarkov{1, 1e4}),
                         name_of);

TEST(LagKernelOfGaussMarkov, GoesToARandomWalk) {
  // sigma^2 (1 - e^(-a h)) -> 2 sigma^2 a h / 2: K^2 = 2 sigma^2 / Tc, to first order in m dt / Tc.
  constexpr double kCorrelationTime = 1e12;
  const Pair pair{30, 500, 1};
  std::vector<double> u(1000), slow(u.size()), walk(u.size());
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = static_cast<double>(i);
  lag_kernel(noise::GaussMarkov{1, kCorrelationTime}, pair, u, slow);
  lag_kernel(noise::RateRandomWalk{1}, pair, u, walk);
  for (std::size_t i = 0; i < u.size(); ++i) {
    ASSERT_NEAR(slow[i] * kCorrelationTime / 2 / walk[0], walk[i] / walk[0], 1e-9);
  }
}

// The nine terms in double lose what their size is over the kernel's: phases of m2 samples over variances of 1/m2.
TEST(LagKernelOfFilteredWhite, IsTheFourthDifferenceOfThePhaseCovariance) {
  constexpr double kDt = 0.01, kNineTerms = 1e-11;
  const noise::FilteredWhite unit{1, {noise::FrontEnd::Kind::second_order, 4, noise::FrontEnd::Sampling::analogue}};
  for (const auto& [m1, m2] : {std::pair{1, 1}, {1, 4}, {3, 50}, {64, 128}}) {
    const std::vector<double> lags{0, 1, 2, 3, 5, 17, 50, 63, 64, 65, 127, 128, 200, 400};
    std::vector<double> c(lags.size());
    lag_kernel(unit, {m1, m2, kDt}, lags, c);
    for (std::size_t i = 0; i < lags.size(); ++i) {
      double sum = 0;
      for (int a = -1; a <= 1; ++a) {
        for (int b = -1; b <= 1; ++b)
          sum += (a == 0 ? -2 : 1) * (b == 0 ? -2 : 1) *
                 noise::phase_covariance(unit, std::abs(lags[i] + a * m1 + b * m2), kDt);
      }
      const double scale = 1 / (2. * m1 * m2 * kDt * kDt);
      EXPECT_NEAR(c[i], scale * sum, kNineTerms / kDt) << m1 << ' ' << m2 << " lag " << lags[i];
    }
  }
}

TEST(LagKernelOfMeans, IsTheProductOfTheMeans) {
  const std::vector<double> u{0, 1, 17, 1000};
  std::vector<double> c(u.size());
  const double dt = 0.5;
  lag_kernel(noise::RateRamp{1}, {3, 8, dt}, u, c);
  for (const double value : c) EXPECT_DOUBLE_EQ(value, 3 * dt / std::sqrt(2.) * 8 * dt / std::sqrt(2.));

  const noise::Sinusoid line{1, 0.11, 0};
  lag_kernel(line, {3, 8, dt}, u, c);
  const double gain = std::sqrt(noise::allan_variance(line, 3, dt) * noise::allan_variance(line, 8, dt));
  for (std::size_t i = 0; i < u.size(); ++i) {
    EXPECT_NEAR(c[i], gain * std::cos(2 * std::numbers::pi * 0.11 * dt * u[i]), 1e-12);
  }
}

// ---- nodes -----------------------------------------------------------------------------------------------------

TEST(LagNodes, SumPolynomialsExactly) {
  const Pair pair{100, 1000, 1};
  for (const std::int64_t end : {1, 5, 17, 100, 101, 700, 1000, 1100, 1500, 5000}) {
    const LagNodes nodes = lag_nodes(pair, end);
    for (int degree = 0; degree <= 11; ++degree) {
      const auto power = [&](double u) { return std::pow((u + 1) / static_cast<double>(end), degree); };
      double all = 0, few = 0;
      for (std::int64_t u = 0; u < end; ++u) all += power(static_cast<double>(u));
      for (std::size_t i = 0; i < nodes.u.size(); ++i) few += nodes.w[i] * power(nodes.u[i]);
      ASSERT_NEAR(few / all, 1, 1e-13) << "end " << end << " degree " << degree;
    }
  }
}

TEST(LagNodes, StayAwayFromKinksUnlessWhole) {
  for (const Pair pair : {Pair{1, 1, 1}, Pair{1, 2, 1}, Pair{5, 1000, 1}, Pair{512, 1024, 1}, Pair{700, 1000, 1}}) {
    const LagNodes nodes = lag_nodes(pair, 100'000);
    for (const double u : nodes.u) {
      if (u == std::floor(u)) continue;
      for (const std::int64_t knot : {std::int64_t{0}, pair.m1, pair.m2 - pair.m1, pair.m2, pair.m1 + pair.m2}) {
        ASSERT_GE(std::abs(u - static_cast<double>(knot)), kSmooth);
      }
    }
  }
}

// Relative to the sum of the absolute values: the bound that lag_sum.h states.
constexpr double kSumError = 1e-9;

TEST(LagNodes, SumProductsOfKernels) {
  const std::vector<noise::Process> processes{noise::Quantization{1},   noise::White{1},           noise::Flicker{1},
                                              noise::RateRandomWalk{1}, noise::GaussMarkov{1, 50}, noise::RateRamp{1}};
  for (const Pair pair : {Pair{1, 1, 1}, Pair{1, 2, 1}, Pair{1, 4096, 1}, Pair{64, 4096, 1}, Pair{100, 130, 1},
                          Pair{999, 1000, 1}, Pair{1000, 1000, 1}, Pair{2000, 4096, 1}, Pair{17, 33, 1}}) {
    for (const std::int64_t end : {pair.m2 / 2 + 1, pair.m2 + 1, 3 * pair.m2 + 7, 20 * pair.m2 + 1000}) {
      const LagNodes nodes = lag_nodes(pair, end);
      std::vector<double> every(static_cast<std::size_t>(end));
      for (std::size_t u = 0; u < every.size(); ++u) every[u] = static_cast<double>(u);
      std::vector<std::vector<double>> full, few;
      for (const noise::Process& process : processes) {
        lag_kernel(process, pair, every, full.emplace_back(every.size()));
        lag_kernel(process, pair, nodes.u, few.emplace_back(nodes.u.size()));
      }
      for (std::size_t a = 0; a < processes.size(); ++a) {
        for (std::size_t b = a; b < processes.size(); ++b) {
          double exact = 0, size = 0, sum = 0;
          for (std::size_t i = 0; i < every.size(); ++i) {
            exact += full[a][i] * full[b][i];
            size += std::abs(full[a][i] * full[b][i]);
          }
          for (std::size_t i = 0; i < nodes.u.size(); ++i) sum += nodes.w[i] * few[a][i] * few[b][i];
          ASSERT_NEAR(sum / size, exact / size, kSumError)
              << "m " << pair.m1 << " " << pair.m2 << " end " << end << " processes " << a << " " << b;
        }
      }
    }
  }
}

TEST(LagNodes, AreFew) { EXPECT_LT(lag_nodes({1 << 10, 1 << 19, 0.01}, 3'000'000).u.size(), 2000U); }

}  // namespace
}  // namespace gyrobudget::allan::detail

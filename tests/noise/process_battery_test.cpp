// SPDX-License-Identifier: MIT
// One battery for every process: its spectrum, structure function, phase covariance and Allan variance are
// four views of the same second moments, so each must give the others; samples of both generators must show
// them too.
#include "gyrobudget/noise/process.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>

namespace gyrobudget::noise {
namespace {

using std::numbers::pi;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Case {
  std::string name;
  Process unit;  ///< of unit coefficient; Gauss-Markov times and frequencies are in samples and made with dt
};

Process with_interval(Process p, double dt) {
  if (auto* g = std::get_if<GaussMarkov>(&p)) g->correlation_time *= dt;
  if (auto* s = std::get_if<Sinusoid>(&p)) s->frequency /= dt;
  return p;
}

bool is_mean(const Process& p) { return std::holds_alternative<RateRamp>(p); }
bool has_spectrum(const Process& p) {
  return !std::holds_alternative<RateRamp>(p) && !std::holds_alternative<Sinusoid>(p);
}

/// (1/(2 m^2 dt^2)) sum c_a c_b R((a - b) m), c = (1, -2, 1).
double allan_from_phase(const Process& p, std::int64_t m, double dt) {
  const double M = static_cast<double>(m);
  const auto R = [&](double lag) { return phase_covariance(p, lag, dt); };
  return (6 * R(0) - 8 * R(M) + 2 * R(2 * M)) / (2 * M * M * dt * dt);
}

/// Rounding of allan_from_phase: what it adds up over what is left.
double phase_rounding(const Process& p, std::int64_t m, double dt, double allan) {
  const double M = static_cast<double>(m);
  const double magnitude = 8 * std::abs(phase_covariance(p, M, dt)) +
                           2 * std::abs(phase_covariance(p, 2 * M, dt)) +
                           6 * std::abs(phase_covariance(p, 0, dt));
  return 4 * kEpsilon * magnitude / (2 * M * M * dt * dt) + 8 * kEpsilon * allan;
}

/// E of the estimator by -D/2 as generalised covariance of the rates: weights -1 on m samples, +1 on the next
/// m.
double allan_from_structure(const Process& p, std::int64_t m, double dt) {
  double sum = 0;
  for (std::int64_t h = 1; h < 2 * m; ++h) {
    // sum over pairs at lag h of w_i w_j: the autocorrelation of the (-1, +1) step.
    const std::int64_t pairs = h < m ? 2 * m - 3 * h : h - 2 * m;
    sum -= static_cast<double>(pairs) * structure_function(p, h, dt);
  }
  return sum / (2 * static_cast<double>(m * m));
}

/// int_0^{1/(2 dt)} S(f) |H(u)|^2 df by Gauss-Legendre panels that grow geometrically from zero and are never
/// longer than a third of the gain's period 1/m.
template <typename Gain>
double spectral_integral(const Process& p, double m, double dt, Gain gain) {
  // 10-point nodes and weights on [-1, 1] (Abramowitz & Stegun table 25.4).
  constexpr std::array<double, 5> kNode = {0.148874338981631, 0.433395394129247, 0.679409568299024,
                                           0.865063366688985, 0.973906528517172};
  constexpr std::array<double, 5> kWeight = {0.295524224714753, 0.269266719309996, 0.219086362515982,
                                             0.149451349150581, 0.066671344308688};
  double sum = 0;
  for (double lower = 0, upper = 1e-9; lower < 0.5;
       lower = upper, upper = std::min({2 * upper, upper + 1 / (3 * m), 0.5})) {
    const double middle = 0.5 * (lower + upper), half = 0.5 * (upper - lower);
    for (std::size_t i = 0; i < kNode.size(); ++i) {
      for (const double u : {middle - half * kNode[i], middle + half * kNode[i]}) {
        sum += kWeight[i] * half * psd(p, u / dt, dt) * gain(u) / dt;
      }
    }
  }
  return sum;
}

double allan_from_psd(const Process& p, std::int64_t m, double dt) {
  const double M = static_cast<double>(m);
  return spectral_integral(p, M, dt, [=](double u) {
    const double s = std::sin(pi * M * u);
    return 4 * std::pow(s, 4) / std::pow(M * std::sin(pi * u), 2);
  });
}

double structure_from_psd(const Process& p, std::int64_t lag, double dt) {
  const double L = static_cast<double>(lag);
  return spectral_integral(p, L, dt, [=](double u) { return 8 * std::pow(std::sin(pi * L * u), 2); });
}

class Battery : public testing::TestWithParam<std::tuple<Case, double, double>> {
 protected:
  double dt() const { return std::get<1>(GetParam()); }
  double scale() const { return std::get<2>(GetParam()); }
  Process process() const {
    return with_coefficient(with_interval(std::get<0>(GetParam()).unit, dt()), scale());
  }
};

constexpr std::int64_t kFactors[] = {1, 2, 3, 5, 16, 17, 100, 333};

TEST_P(Battery, PhaseCovarianceGivesAllanVariance) {
  const Process p = process();
  if (is_mean(p)) {
    EXPECT_EQ(phase_covariance(p, 3, dt()), 0);
    return;
  }
  for (const std::int64_t m : kFactors) {
    const double allan = allan_variance(p, m, dt());
    EXPECT_NEAR(allan_from_phase(p, m, dt()), allan, phase_rounding(p, m, dt(), allan)) << m;
    EXPECT_LE(phase_rounding(p, m, dt(), allan), 1e-9 * allan)
        << "the check above must be able to fail; m = " << m;
  }
}

TEST_P(Battery, StructureFunctionGivesAllanVariance) {
  const Process p = process();
  for (const std::int64_t m : kFactors) {
    const double allan = allan_variance(p, m, dt());
    const double rounding = 4 * kEpsilon * static_cast<double>(m) * structure_function(p, 2 * m, dt());
    EXPECT_NEAR(allan_from_structure(p, m, dt()), allan, rounding + 16 * kEpsilon * allan) << m;
  }
}

TEST_P(Battery, SpectrumGivesAllanVarianceAndStructureFunction) {
  const Process p = process();
  if (!has_spectrum(p)) return;         // a line or a trend has no density to integrate
  constexpr double kQuadrature = 1e-7;  // lower cut of the first panel for the random walk
  for (const std::int64_t m : kFactors) {
    const double allan = allan_variance(p, m, dt()), structure = structure_function(p, m, dt());
    EXPECT_NEAR(allan_from_psd(p, m, dt()), allan, kQuadrature * allan) << m;
    EXPECT_NEAR(structure_from_psd(p, m, dt()), structure, kQuadrature * structure) << m;
  }
}

TEST_P(Battery, SecondMomentsScaleWithTheSquareOfTheCoefficient) {
  const Process p = process(), unit = with_coefficient(p, 1);
  const double s2 = scale() * scale();
  constexpr double kRounding = 8 * kEpsilon;
  for (const std::int64_t m : kFactors) {
    const double M = static_cast<double>(m);
    EXPECT_NEAR(allan_variance(p, m, dt()), s2 * allan_variance(unit, m, dt()),
                kRounding * allan_variance(p, m, dt()));
    EXPECT_NEAR(structure_function(p, m, dt()), s2 * structure_function(unit, m, dt()),
                kRounding * structure_function(p, m, dt()));
    EXPECT_NEAR(phase_covariance(p, M, dt()), s2 * phase_covariance(unit, M, dt()),
                kRounding * std::abs(phase_covariance(p, M, dt())));
  }
  EXPECT_EQ(structure_function(p, 0, dt()), 0);
  EXPECT_EQ(allan_variance(with_coefficient(p, 0), 7, dt()), 0);
}

TEST_P(Battery, PhaseCovarianceIsEven) {
  for (const double lag : {0.25, 1.0, 7.5, 1e6}) {
    EXPECT_EQ(phase_covariance(process(), -lag, dt()), phase_covariance(process(), lag, dt()));
  }
}

const Case kCases[] = {{"Quantization", Quantization{1}},
                       {"White", White{1}},
                       {"Flicker", Flicker{1}},
                       {"RateRandomWalk", RateRandomWalk{1}},
                       {"RateRamp", RateRamp{1}},
                       {"GaussMarkovFast", GaussMarkov{1, 0.3}},
                       {"GaussMarkovSlow", GaussMarkov{1, 150}},
                       {"Sinusoid", Sinusoid{1, 0.0137, 0.5}}};

INSTANTIATE_TEST_SUITE_P(Processes, Battery,
                         testing::Combine(testing::ValuesIn(kCases), testing::Values(1e-9, 0.01, 1.0, 1e6),
                                          testing::Values(1e-30, 1.0, 1e30)),
                         [](const auto& instance) {
                           std::string name =
                               std::get<0>(instance.param).name + "_dt" +
                               std::to_string(std::lround(std::log10(std::get<1>(instance.param)))) + "_c" +
                               std::to_string(std::lround(std::log10(std::get<2>(instance.param))));
                           for (char& c : name) c = c == '-' ? 'm' : c;
                           return name;
                         });

}  // namespace
}  // namespace gyrobudget::noise

// SPDX-License-Identifier: MIT
// One battery for every process: its spectrum, structure function, phase covariance and Allan variance are
// four views of the same second moments, so each must give the others; samples of both generators must show
// them too.
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/process.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

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
  if (auto* f = std::get_if<FilteredWhite>(&p)) f->front_end.bandwidth /= dt;
  return p;
}

Process with_phase(Process p, double phase) {
  if (auto* s = std::get_if<Sinusoid>(&p)) s->phase = phase;
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
  const double magnitude = 8 * std::abs(phase_covariance(p, M, dt)) + 2 * std::abs(phase_covariance(p, 2 * M, dt)) +
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
  constexpr std::array<double, 5> kNode = {0.148874338981631, 0.433395394129247, 0.679409568299024, 0.865063366688985,
                                           0.973906528517172};
  constexpr std::array<double, 5> kWeight = {0.295524224714753, 0.269266719309996, 0.219086362515982, 0.149451349150581,
                                             0.066671344308688};
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

constexpr double kIntervals[] = {1e-9, 0.01, 1.0, 1e6};
constexpr double kScales[] = {1e-30, 1.0, 1e30};
constexpr std::int64_t kFactors[] = {1, 2, 3, 5, 16, 17, 100, 333};

class Battery : public testing::TestWithParam<Case> {
 protected:
  static Process process(double scale, double dt) {
    return with_coefficient(with_interval(GetParam().unit, dt), scale);
  }
  /// Runs `check(process, dt)` over sample intervals and coefficients of many decades.
  template <typename Check>
  static void everywhere(Check check) {
    for (const double dt : kIntervals) {
      for (const double scale : kScales) {
        SCOPED_TRACE(GetParam().name + ", dt " + std::to_string(dt) + ", log10 of coefficient " +
                     std::to_string(std::log10(scale)));
        check(process(scale, dt), dt);
      }
    }
  }
};

TEST_P(Battery, PhaseCovarianceGivesAllanVariance) {
  everywhere([](const Process& p, double dt) {
    for (const std::int64_t m : kFactors) {
      const double allan = allan_variance(p, m, dt);
      if (is_mean(p)) {
        EXPECT_EQ(phase_covariance(p, static_cast<double>(m), dt), 0);
        continue;
      }
      EXPECT_NEAR(allan_from_phase(p, m, dt), allan, phase_rounding(p, m, dt, allan)) << m;
      EXPECT_LE(phase_rounding(p, m, dt, allan), 1e-9 * allan) << "the check above could not fail, m = " << m;
    }
  });
}

TEST_P(Battery, StructureFunctionGivesAllanVariance) {
  everywhere([](const Process& p, double dt) {
    for (const std::int64_t m : kFactors) {
      const double allan = allan_variance(p, m, dt);
      const double rounding = 4 * kEpsilon * static_cast<double>(m) * structure_function(p, 2 * m, dt);
      EXPECT_NEAR(allan_from_structure(p, m, dt), allan, rounding + 16 * kEpsilon * allan) << m;
      EXPECT_LE(rounding, 1e-6 * allan) << "the check above could not fail, m = " << m;
    }
  });
}

TEST_P(Battery, SpectrumGivesAllanVarianceAndStructureFunction) {
  constexpr double kQuadrature = 1e-7;  // the first panel, from frequency zero, of the random walk
  everywhere([](const Process& p, double dt) {
    if (!has_spectrum(p)) return;
    for (const std::int64_t m : kFactors) {
      const double allan = allan_variance(p, m, dt), structure = structure_function(p, m, dt);
      EXPECT_NEAR(allan_from_psd(p, m, dt), allan, kQuadrature * allan) << m;
      EXPECT_NEAR(structure_from_psd(p, m, dt), structure, kQuadrature * structure) << m;
    }
  });
}

TEST_P(Battery, SecondMomentsScaleWithTheSquareOfTheCoefficient) {
  everywhere([](const Process& p, double dt) {
    const Process unit = with_coefficient(p, 1), none = with_coefficient(p, 0);
    const double square = coefficient(p) * coefficient(p);
    const auto expect_scaled = [&](auto moment) {
      EXPECT_NEAR(moment(p), square * moment(unit), 8 * kEpsilon * std::abs(moment(p)));
      EXPECT_EQ(moment(none), 0);
    };
    for (const std::int64_t m : kFactors) {
      expect_scaled([&](const Process& q) { return allan_variance(q, m, dt); });
      expect_scaled([&](const Process& q) { return structure_function(q, m, dt); });
      expect_scaled([&](const Process& q) { return phase_covariance(q, static_cast<double>(m), dt); });
      expect_scaled([&](const Process& q) { return psd(q, 0.123 / dt, dt); });
    }
  });
}

TEST_P(Battery, LagsRunFromZeroAndAreEven) {
  everywhere([](const Process& p, double dt) {
    EXPECT_EQ(structure_function(p, 0, dt), 0);
    for (const double lag : {0.25, 1.0, 7.5, 1e6, 1e9}) {
      EXPECT_EQ(phase_covariance(p, -lag, dt), phase_covariance(p, lag, dt));
      EXPECT_TRUE(std::isfinite(phase_covariance(p, lag, dt)));
    }
  });
}

// --- Samples -----------------------------------------------------------------------------------------------

/// Overlapped Allan variance of the first `terms` triples of a record, from its angle at unit interval.
double overlapped(const std::vector<double>& angle, std::int64_t m, std::int64_t terms) {
  const auto cluster = static_cast<std::size_t>(m);
  double sum = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(terms); ++k) {
    const double difference = angle[k + 2 * cluster] - 2 * angle[k + cluster] + angle[k];
    sum += difference * difference;
  }
  return sum / (2 * static_cast<double>(m * m * terms));
}

std::vector<double> running_sum(const std::vector<double>& rate) {
  std::vector<double> angle = {0};
  for (const double y : rate) angle.push_back(angle.back() + y);
  return angle;
}

struct MonteCarlo {
  double mean = 0, standard_error = 0;
};

MonteCarlo summary(const std::vector<double>& values) {
  const double n = static_cast<double>(values.size());
  double mean = 0, squares = 0;
  for (const double v : values) mean += v / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  return {mean, std::sqrt(squares / (n * (n - 1)))};
}

// Student's t with 299 degrees exceeds 6 with probability 6e-9; at 10 processes, 2 generators, 2 intervals and
// 6 + 4 statistics the whole family fails by chance with probability 2e-6.
constexpr int kRecords = 300;
constexpr double kSigmas = 6;
constexpr std::int64_t kTerms = 1000;
constexpr std::int64_t kSampledFactors[] = {1, 2, 5, 16, 100, 300};
constexpr std::int64_t kSamples = kTerms + 2 * 300 - 1;

/// Record `run` of a process by each of the two generators.
using Make = std::vector<double> (*)(const Process&, double dt, std::uint64_t run);

std::vector<double> whole_record(const Process& p, double dt, std::uint64_t run) {
  return generate_record(std::array{p}, kSamples, dt, {2026, run});
}

constexpr double kLongestCluster = 1000;  // samples
std::vector<double> endless_record(const Process& p, double dt, std::uint64_t run) {
  Generator generator(std::array{p}, dt, {.key = {2027, run}, .longest_tau = kLongestCluster * dt});
  std::vector<double> y(kSamples);
  generator.next(y);
  return y;
}

TEST_P(Battery, SamplesOfBothGeneratorsHaveTheAllanVariance) {
  constexpr double kApproximation = 2 * 6e-4;  // of flicker by the endless generator, stated there for the deviation
  for (const double dt : {0.01, 1e6}) {
    const Process p = process(1, dt);
    for (const Make make : {whole_record, endless_record}) {
      std::vector<std::vector<double>> values(std::size(kSampledFactors));
      for (std::uint64_t run = 0; run < kRecords; ++run) {
        // A sinusoid without a random start would show one phase only.
        const Process drawn = with_phase(p, 2 * pi * (static_cast<double>(run) + 0.5) / kRecords);
        const auto angle = running_sum(make(drawn, dt, run));
        for (std::size_t i = 0; i < values.size(); ++i) {
          values[i].push_back(overlapped(angle, kSampledFactors[i], kTerms));
        }
      }
      for (std::size_t i = 0; i < values.size(); ++i) {
        const double expected = allan_variance(p, kSampledFactors[i], dt);
        const auto [mean, error] = summary(values[i]);
        EXPECT_NEAR(mean, expected, kSigmas * error + kApproximation * expected) << kSampledFactors[i] << ' ' << dt;
        EXPECT_LT(error, 0.15 * expected) << "too few records to tell";
      }
    }
  }
}

TEST_P(Battery, SamplesOfBothGeneratorsHaveTheStructureFunction) {
  // From sample 0, so that the start (zero, stationary) is in it.
  constexpr double kApproximation = 2 * 1.6e-4;
  constexpr double kDt = 0.01;
  const Process p = process(1, kDt);
  for (const Make make : {whole_record, endless_record}) {
    for (const std::int64_t lag : {1, 2, 40, 900}) {
      std::vector<double> values;
      for (std::uint64_t run = 0; run < kRecords; ++run) {
        const auto y = make(with_phase(p, 2 * pi * (static_cast<double>(run) + 0.5) / kRecords), kDt, run);
        const double difference = y[static_cast<std::size_t>(lag)] - y[0];
        values.push_back(difference * difference);
      }
      const double expected = structure_function(p, lag, kDt);
      const auto [mean, error] = summary(values);
      EXPECT_NEAR(mean, expected, kSigmas * error + kApproximation * expected) << lag;
      EXPECT_LT(error, 0.15 * expected) << "too few records to tell";
    }
  }
}

TEST_P(Battery, SamplesScaleWithTheCoefficientAndStayFinite) {
  for (const double dt : kIntervals) {
    for (const Make make : {whole_record, endless_record}) {
      const auto y = make(process(1, dt), dt, 5), zero = make(process(0, dt), dt, 5);
      EXPECT_EQ(zero, std::vector<double>(kSamples, 0.0));
      for (const double scale : {0x1p-100, 1e-30, 2.0, 1e30}) {
        const auto z = make(process(scale, dt), dt, 5);
        double largest = 0;
        for (const double v : y) largest = std::max(largest, std::abs(v));
        for (std::size_t k = 0; k < z.size(); k += 37) {
          ASSERT_NEAR(z[k], scale * y[k], scale * largest * 1e-13) << k << ' ' << scale;
        }
      }
    }
  }
}

const Case kCases[] = {
    {"Quantization", Quantization{1}},
    {"White", White{1}},
    {"Flicker", Flicker{1}},
    {"RateRandomWalk", RateRandomWalk{1}},
    {"RateRamp", RateRamp{1}},
    {"GaussMarkovFast", GaussMarkov{1, 0.3}},
    {"GaussMarkovSlow", GaussMarkov{1, 150}},
    {"Sinusoid", Sinusoid{1, 0.0137, 0.5}},
    {"FilteredFirstOrder", FilteredWhite{1, {FrontEnd::Kind::first_order, 0.2}}},
    {"FilteredSecondOrder", FilteredWhite{1, {FrontEnd::Kind::second_order, 0.15, FrontEnd::Sampling::held}}}};

INSTANTIATE_TEST_SUITE_P(Processes, Battery, testing::ValuesIn(kCases),
                         [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace gyrobudget::noise

// SPDX-License-Identifier: MIT
// The estimators against published numbers: NIST SP 1065's test suite and Stable32's tables.
#include "gyrobudget/allan/family.h"

#include <gtest/gtest.h>

#include <cmath>

#include "../truth/sp1065.h"
#include "logs.h"

namespace gyrobudget::allan {
namespace {

double one(Estimator estimator, std::span<const double> rate, std::int64_t m) {
  return std::sqrt(deviation(rate, 1, estimator, std::span(&m, 1)).points[0].variance);
}

/// NIST SP 1065 table 31: the 1000-point set, seven digits, m = 1, 10, 100.
struct Row {
  Estimator estimator;
  double deviation[3];
  double bias = 1;  ///< of the variance, that the table has removed beyond m = 1 (Hadamard) or everywhere
};
// Of white frequency noise: modified total 0.73 (ibid. table 11), Hadamard total 1 - 0.005 (ibid. table 12).
constexpr Row kThousandPoints[] = {{Estimator::adev, {2.922319e-01, 9.965736e-02, 3.897804e-02}},
                                   {Estimator::oadev, {2.922319e-01, 9.159953e-02, 3.241343e-02}},
                                   {Estimator::mdev, {2.922319e-01, 6.172376e-02, 2.170921e-02}},
                                   {Estimator::tdev, {1.687202e-01, 3.563623e-01, 1.253382e+00}},
                                   {Estimator::hdev, {2.943883e-01, 1.052754e-01, 3.910861e-02}},
                                   {Estimator::ohdev, {2.943883e-01, 9.581083e-02, 3.237638e-02}},
                                   {Estimator::htotdev, {2.943883e-01, 9.614787e-02, 3.058103e-02}, 0.995},
                                   {Estimator::totdev, {2.922319e-01, 9.134743e-02, 3.406530e-02}},
                                   {Estimator::mtotdev, {2.418528e-01, 6.499161e-02, 2.287774e-02}, 0.73},
                                   {Estimator::ttotdev, {1.396338e-01, 3.752293e-01, 1.320847e+00}, 0.73}};

TEST(Sp1065Family, ThousandPoints) {
  const std::vector<double> rate = truth::sp1065_frequencies();
  for (const Row& row : kThousandPoints) {
    const std::int64_t factors[] = {1, 10, 100};
    for (int i = 0; i < 3; ++i) {
      SCOPED_TRACE(name(row.estimator));
      const bool corrected = row.estimator != Estimator::htotdev || factors[i] > 1;
      const double bias = corrected ? row.bias : 1;
      expect_printed(one(row.estimator, rate, factors[i]) / std::sqrt(bias), row.deviation[i], 7);
    }
  }
}

TEST(Stable32Family, Theo1OfTheThousandPoints) {
  // Stable32 1.60's run at tau = 7.5, 75 and 750 s, no bias removed, as AllanTools' tests quote it.
  const std::vector<double> rate = truth::sp1065_frequencies();
  expect_printed(one(Estimator::theo1, rate, 10), 1.0757e-01, 5);
  expect_printed(one(Estimator::theo1, rate, 100), 3.1789e-02, 5);
  expect_printed(one(Estimator::theo1, rate, 1000), 5.0524e-03, 5);
}

/// What Stable32 divides a variance by, for the noise its table names: of total and Hadamard total, not of
/// modified total. Greenhall, Howe, Percival 1999 and Howe et al. 2005, as in SP 1065 tables 8 and 12.
double removed_bias(Estimator estimator, int alpha, std::int64_t m, std::int64_t samples) {
  const double share = static_cast<double>(m) / static_cast<double>(samples);
  if (estimator == Estimator::totdev) return 1 - (alpha == -1 ? 0.481 : alpha == -2 ? 0.75 : 0) * share;
  if (estimator == Estimator::htotdev && m > 1) return 0.995;  // its only table is of white noise
  return 1;
}

TEST(Stable32Family, EveryTable) {
  SKIP_WITHOUT("oscillator/stable32_reference.csv");
  const auto sets = oscillators();
  int checked = 0;
  for (const auto& row : read_table("oscillator/stable32_reference.csv")) {
    const std::string &set = row.at("dataset"), &statistic = row.at("statistic");
    const auto estimator = estimator_named(statistic);
    ASSERT_TRUE(estimator.has_value()) << statistic;
    const std::int64_t m = std::stoll(row.at("af"));
    const auto& rate = sets.at(set);
    const double bias = removed_bias(*estimator, std::stoi(row.at("alpha")), m, static_cast<std::int64_t>(rate.size()));
    const double ours = one(*estimator, rate, m) / std::sqrt(bias);
    // The OCXO table is off by 1.3e-3 itself (the folder's README).
    if (set == "ocxo_frequency_hz") {
      EXPECT_NEAR(ours / number(row, "sigma"), 1, 2e-3) << set << " " << statistic << " m " << m;
    } else {
      SCOPED_TRACE(set + " " + statistic + " m " + std::to_string(m));
      expect_printed(ours, number(row, "sigma"), 5);
    }
    ++checked;
  }
  EXPECT_EQ(checked, 242);
}

}  // namespace
}  // namespace gyrobudget::allan

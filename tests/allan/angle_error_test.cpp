// SPDX-License-Identifier: MIT
// TIE rms and MTIE: against their definitions, and what clocks' tables and closed forms say.
#include "gyrobudget/allan/angle_error.h"

#include "gyrobudget/noise/generate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "reference.h"

namespace gyrobudget::allan {
namespace {

TEST(AngleError, IsTheDefinition) {
  std::vector<double> rate = reference::normal(300, 91);
  for (double& y : rate) y = 7 + 0.1 * y;
  long double mean = 0;
  for (const double y : rate) mean += y / 300.0L;
  std::vector<long double> x{0};
  for (const double y : rate) x.push_back(x.back() + (y - mean) * 0.5L);
  const std::vector<std::int64_t> factors{64, 1, 2, 3, 7, 8, 100, 299, 300, 5};  // in any order
  const auto found = angle_error(Series(rate, 0.5), factors);
  constexpr double kExact = 1e-12;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    const auto m = static_cast<std::size_t>(factors[i]);
    long double squares = 0, greatest = 0;
    for (std::size_t k = 0; k + m < x.size(); ++k) {
      squares += (x[k + m] - x[k]) * (x[k + m] - x[k]) / static_cast<long double>(x.size() - m);
      const auto [least, most] = std::minmax_element(x.begin() + k, x.begin() + k + m + 1);
      greatest = std::max(greatest, *most - *least);
    }
    EXPECT_EQ(found[i].m, factors[i]);
    EXPECT_EQ(found[i].tau, 0.5 * static_cast<double>(m));
    if (m < 300) {
      EXPECT_NEAR(found[i].rms / static_cast<double>(std::sqrt(squares)), 1, kExact) << m;
    } else {
      EXPECT_LT(found[i].rms, kExact);  // the mean is that of the record
    }
    EXPECT_NEAR(found[i].greatest / static_cast<double>(greatest), 1, kExact) << m;
  }
}

TEST(AngleError, OfARandomWalkOfTheAngle) {
  // White rate: TIE rms is N sqrt(tau), less the mean's part tau/T; MTIE of one step is its largest step.
  const noise::Process white[] = {noise::White{2}};
  const auto rate = noise::generate_record(white, 200'000, 0.01, {.seed = 6});
  const std::int64_t factors[] = {1, 100};
  const auto found = angle_error(Series(rate, 0.01), factors);
  EXPECT_NEAR(found[1].rms / 2, 1, 4 * std::sqrt(0.5 / 2000));  // 2000 seconds, 4 sigma
  double largest = 0, mean = 0;
  for (const double y : rate) mean += y / 200'000;
  for (const double y : rate) largest = std::max(largest, std::abs(y - mean));
  EXPECT_NEAR(found[0].greatest, largest * 0.01, 1e-12);
}

TEST(AngleError, EdgesAndMisuse) {
  const std::vector<double> nothing(10, std::numeric_limits<double>::quiet_NaN());
  const std::int64_t one[] = {1}, far[] = {11}, none[] = {0};
  EXPECT_TRUE(std::isnan(angle_error(Series(nothing), one)[0].rms));
  EXPECT_TRUE(std::isnan(angle_error(Series(nothing), one)[0].greatest));
  const std::vector<double> constant(10, 3.);
  EXPECT_EQ(angle_error(Series(constant), one)[0].greatest, 0);
  EXPECT_THROW((void)angle_error(Series(constant), far), std::invalid_argument);
  EXPECT_THROW((void)angle_error(Series(constant), none), std::invalid_argument);
  EXPECT_TRUE(angle_error(Series(constant), {}).empty());
}

}  // namespace
}  // namespace gyrobudget::allan

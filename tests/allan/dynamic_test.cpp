// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/dynamic.h"

#include "gyrobudget/allan/factors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "reference.h"

namespace gyrobudget::allan {
namespace {

TEST(Dynamic, EveryWindowIsItsOwnCurve) {
  for (const bool gaps : {false, true}) {
    std::vector<double> rate = reference::normal(5000, 71);
    if (gaps) {
      for (std::size_t k = 0; k < rate.size(); k += 97) rate[k] = std::numeric_limits<double>::quiet_NaN();
    }
    for (const DynamicOptions& options : {DynamicOptions{}, DynamicOptions{400, 100}, DynamicOptions{401, 7},
                                          DynamicOptions{300, 1000}, DynamicOptions{5000, 1}}) {
      const auto [window, hop] = resolved(options, 5000);
      const auto factors = octave_factors(window);
      const DynamicSurface surface = dynamic_variance(Series(rate, 0.5), factors, options);
      ASSERT_EQ(static_cast<std::int64_t>(surface.time.size()), (5000 - window) / hop + 1);
      for (std::size_t w = 0; w < surface.time.size(); w += 5) {
        const auto begin = static_cast<std::size_t>(hop) * w;
        EXPECT_EQ(surface.time[w], 0.5 * (static_cast<double>(begin) + static_cast<double>(window) / 2));
        const Curve truth =
            overlapped_variance(std::span(rate).subspan(begin, static_cast<std::size_t>(window)), 0.5, factors);
        const Curve ours = surface.curve(w);
        for (std::size_t i = 0; i < factors.size(); ++i) {
          EXPECT_EQ(ours.points[i].terms, truth.points[i].terms);
          if (truth.points[i].terms == 0) {
            EXPECT_TRUE(std::isnan(ours.points[i].variance));
          } else {
            EXPECT_NEAR(ours.points[i].variance / truth.points[i].variance, 1, 1e-12);
          }
        }
      }
    }
  }
}

TEST(Dynamic, SeesNoiseThatChanges) {
  // Ten times the noise in the middle third: the surface tells when.
  std::vector<double> rate = reference::normal(30'000, 72);
  for (std::size_t k = 10'000; k < 20'000; ++k) rate[k] *= 10;
  const std::int64_t factors[] = {1, 8};
  const DynamicSurface surface = dynamic_variance(Series(rate), factors, {1000, 500});
  for (std::size_t w = 0; w < surface.time.size(); ++w) {
    const double from = surface.time[w] - 500, to = surface.time[w] + 500;
    const bool loud = from >= 10'000 && to <= 20'000, quiet = to <= 10'000 || from >= 20'000;
    if (!loud && !quiet) continue;
    // 4.5 sigma at the 80 degrees of freedom of m = 8.
    EXPECT_NEAR(surface.variance(static_cast<Eigen::Index>(w), 1) * 8 / (loud ? 100 : 1), 1, 0.75);
  }
}

TEST(Dynamic, MisuseThrows) {
  const std::vector<double> rate = reference::normal(100, 73);
  const Series record(rate);
  const std::int64_t factors[] = {1, 20};
  EXPECT_THROW((void)dynamic_variance(record, factors, {101, 1}), std::invalid_argument);
  EXPECT_THROW((void)dynamic_variance(record, factors, {1, 1}), std::invalid_argument);
  EXPECT_THROW((void)dynamic_variance(record, factors, {50, -1}), std::invalid_argument);
  EXPECT_THROW((void)dynamic_variance(record, factors, {39, 1}), std::invalid_argument);
  EXPECT_NO_THROW((void)dynamic_variance(record, factors, {40, 1}));
}

}  // namespace
}  // namespace gyrobudget::allan

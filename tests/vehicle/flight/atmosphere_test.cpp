// SPDX-License-Identifier: MIT
// Tables, the standard atmosphere against its published tables, wind, and the fast height.
#include "gyrobudget/vehicle/flight/atmosphere.h"

#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/flight/detail/height.h"
#include "gyrobudget/vehicle/flight/lookup_table.h"
#include "gyrobudget/vehicle/flight/vehicle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::flight {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

TEST(LookupTable, LinearPassesThroughItsPointsAndKeepsItsEnds) {
  const LookupTable table = LookupTable::linear({{1, 2}, {3, 6}, {4, 0}});
  EXPECT_EQ(table(0), 2);
  EXPECT_EQ(table(2), 4);
  EXPECT_EQ(table(3), 6);
  EXPECT_EQ(table(9), 0);
  EXPECT_EQ(table.integral(3), 8);
  EXPECT_EQ(table.integral(4), 11);
  EXPECT_EQ(table.integral(6), 11);
  EXPECT_EQ(table.scaled(2)(2), 8);
}

TEST(LookupTable, SmoothHasContinuousSecondDerivatives) {
  const LookupTable table =
      LookupTable::smooth({{0, 0.3}, {0.8, 0.33}, {0.95, 0.42}, {1.05, 0.55}, {1.2, 0.55}, {5, 0.25}});
  for (std::size_t k = 1; k + 1 < table.points().size(); ++k) {
    const double x = table.points()[k].first;
    const LookupTable::Jet before = table.at(x, k), after = table.at(x, k + 1);
    EXPECT_NEAR(before.value, table.points()[k].second, 8 * kEpsilon);
    EXPECT_EQ(after.value, table.points()[k].second);
    EXPECT_NEAR(before.first, after.first, 1e-13);
    EXPECT_NEAR(before.second, after.second, 1e-10 * std::abs(after.second));
  }
  EXPECT_EQ(table.at(0, 1).first, 0);
  EXPECT_NEAR(table.at(5, 5).first, 0, 1e-14);
}

TEST(LookupTable, SmoothReproducesACubicWithHorizontalEnds) {
  const auto cubic = [](double x) { return x * x * (3 - 2 * x); };
  const LookupTable table = LookupTable::smooth({{0, 0}, {0.2, cubic(0.2)}, {0.7, cubic(0.7)}, {1, 1}});
  for (double x = 0; x <= 1; x += 0.01) EXPECT_NEAR(table(x), cubic(x), 8 * kEpsilon) << x;
  EXPECT_NEAR(table.integral(1), 0.5, 8 * kEpsilon);
}

TEST(LookupTable, RangeIsThatOfAllValues) {
  EXPECT_EQ(LookupTable::linear({{0, 1}, {1, 3}, {2, -1}}).range(), std::pair(-1.0, 3.0));
  EXPECT_EQ(LookupTable(4).range(), std::pair(4.0, 4.0));
  // By symmetry the slopes at 1 and 2 are s and -s, with 4 s - s = 3 (1 + 0): between them 1 + x (1 - x).
  const LookupTable humped = LookupTable::smooth({{0, 0}, {1, 1}, {2, 1}, {3, 0}});
  EXPECT_EQ(humped.range().first, 0);
  EXPECT_NEAR(humped.range().second, 1.25, 8 * kEpsilon);
  const LookupTable table =
      LookupTable::smooth({{0, 0.3}, {0.8, -0.33}, {0.95, 0.42}, {1.05, 0.55}, {1.2, 0.1}, {5, 2}});
  double least = table(0), greatest = table(0);
  constexpr double kStep = 1e-4;
  for (double x = 0; x < 5; x += kStep) {
    least = std::min(least, table(x));
    greatest = std::max(greatest, table(x));
  }
  constexpr double kMissed = 1e-5;  // second derivatives below 1e3, times the step squared
  EXPECT_NEAR(table.range().first, least, kMissed);
  EXPECT_NEAR(table.range().second, greatest, kMissed);
  EXPECT_LE(table.range().first, least + 8 * kEpsilon);
  EXPECT_GE(table.range().second, greatest - 8 * kEpsilon);
}

TEST(LookupTable, ScalesAndShiftsAtEveryAbscissa) {
  const LookupTable table = LookupTable::smooth({{0, 0.3}, {0.8, 0.33}, {0.95, 0.42}, {5, 0.25}});
  for (double x = -1; x < 6; x += 0.1) {
    EXPECT_NEAR(table.scaled(3)(x), 3 * table(x), 16 * kEpsilon) << x;
    EXPECT_NEAR(table.shifted(2)(x), 2 + table(x), 16 * kEpsilon) << x;
  }
}

TEST(LookupTable, RefusesWhatIsNoFunction) {
  EXPECT_THROW((void)LookupTable::linear({{0, 1}, {1e-320, 2}}), std::invalid_argument);
  EXPECT_THROW((void)LookupTable::smooth({{0, 1}, {1e-320, 2}, {1, 2}}), std::invalid_argument);
  EXPECT_THROW((void)LookupTable::linear({{1, 0}, {1, 2}}), std::invalid_argument);
  EXPECT_THROW((void)LookupTable::smooth({{0, 0}, {1, NAN}}), std::invalid_argument);
  EXPECT_THROW((void)LookupTable::linear(std::vector<LookupTable::Point>()), std::invalid_argument);
}

/// U.S. Standard Atmosphere 1976, table I: geometric height, temperature, pressure, density as printed.
struct Row {
  double height, temperature, pressure, density;
};
constexpr Row kPublished[] = {
    {0, 288.150, 1.01325e5, 1.2250},     {1000, 281.651, 8.9876e4, 1.1117},    {5000, 255.676, 5.4048e4, 0.73643},
    {10000, 223.252, 2.6500e4, 0.41351}, {20000, 216.650, 5.5293e3, 0.088910}, {30000, 226.509, 1.1970e3, 0.018410},
    {50000, 270.650, 79.779, 1.0269e-3}, {70000, 219.585, 5.2209, 8.2829e-5},  {80000, 198.639, 1.0524, 1.8458e-5}};

TEST(StandardAtmosphere, AgreesWithThePublishedTable) {
  constexpr double kLastDigit = 1e-4;  // relative, one unit of the fifth figure
  for (const Row& row : kPublished) {
    const Air air = standard_atmosphere::at(row.height);
    EXPECT_NEAR(air.temperature, row.temperature, 6e-4) << row.height;
    EXPECT_NEAR(air.pressure / row.pressure, 1, kLastDigit) << row.height;
    EXPECT_NEAR(air.density / row.density, 1, kLastDigit) << row.height;
  }
  EXPECT_NEAR(standard_atmosphere::at(0).speed_of_sound, 340.294, 1e-3);
  EXPECT_NEAR(standard_atmosphere::at(10000).speed_of_sound, 299.532, 1e-3);
}

TEST(StandardAtmosphere, LayersMeetAndEndAtTheTop) {
  // Pressures at the bases in geopotential height, table 4 of the standard [Pa].
  constexpr double kBase[] = {101325, 22632, 5474.9, 868.02, 110.91, 66.939, 3.9564};
  const auto& bounds = standard_atmosphere::bounds();
  for (int k = 1; k < standard_atmosphere::kLayers; ++k) {
    const double h = bounds[static_cast<std::size_t>(k)];
    const Air below = standard_atmosphere::at(h, k - 1), above = standard_atmosphere::at(h, k);
    EXPECT_NEAR(below.pressure / above.pressure, 1, 1e-13);
    EXPECT_NEAR(below.temperature, above.temperature, 1e-10);
    EXPECT_NEAR(above.pressure / kBase[k], 1, 6e-5);
    EXPECT_EQ(standard_atmosphere::layer(h), k);
    EXPECT_EQ(standard_atmosphere::layer(std::nextafter(h, 0.0)), k - 1);
  }
  EXPECT_NEAR(bounds.back(), 86000, 1);
  EXPECT_NEAR(standard_atmosphere::at(bounds.back() - 1e-6).pressure, 0.37338, 2e-5);
  EXPECT_EQ(standard_atmosphere::at(bounds.back()).density, 0);
  EXPECT_EQ(standard_atmosphere::at(1e9).pressure, 0);
  EXPECT_TRUE(std::isfinite(standard_atmosphere::at(-1e6).density));
}

TEST(Wind, AddsSteadyShearAndGust) {
  Wind wind;
  EXPECT_TRUE(wind.calm());
  wind.steady = {1, 2, 0};
  wind.east = LookupTable::linear({{0, 0}, {10000, 20}});
  wind.gust = {5000, 500, {0, 0, 3}};
  EXPECT_FALSE(wind.calm());
  EXPECT_LT((wind.at(5000) - Eigen::Vector3d(11, 2, 3)).norm(), 1e-14);
  EXPECT_LT((wind.at(5250) - Eigen::Vector3d(11.5, 2, 1.5)).norm(), 1e-14);
  EXPECT_LT((wind.at(6000) - Eigen::Vector3d(13, 2, 0)).norm(), 1e-14);
}

TEST(Height, AgreesWithTheExactOneToAMicrometre) {
  for (double latitude = -90; latitude <= 90; latitude += 7.5)
    for (const double height : {-1e4, 0.0, 1e4, 1e5, 1e6}) {
      const auto place = earth::Geodetic::from_degrees(latitude, 33, height);
      const detail::Height fast = detail::height_of(earth::to_ecef(place));
      EXPECT_NEAR(fast.above_ellipsoid, height, 1e-6) << latitude;
      EXPECT_LT((fast.up - earth::up_e(place.latitude, place.longitude)).norm(), 1e-8) << latitude << " " << height;
    }
}

TEST(Vehicle, MassAndThrustFollowTheTables) {
  const Vehicle v = vlm1();
  v.check();
  EXPECT_NEAR(v.mean_thrust(), 393e3, 500);
  EXPECT_EQ(burn_state(v, 0).mass, 28000);
  EXPECT_NEAR(burn_state(v, 83).mass, 16000, 1e-9);
  EXPECT_NEAR(burn_state(v, 500).mass, 16000, 1e-9);
  EXPECT_EQ(burn_state(v, 83).vacuum_thrust, 0);
  EXPECT_NEAR(burn_state(v, 83).centre_of_mass, 10, 1e-12);
  EXPECT_NEAR(burn_state(v, 83).pitch_inertia, 2e5, 1e-6);
  double impulse = 0;  // midpoint sum: exact on each straight piece, 1e-6 across the knots
  for (int k = 0; k < 83000; ++k) impulse += burn_state(v, (k + 0.5) * 1e-3).vacuum_thrust * 1e-3;
  EXPECT_NEAR(impulse / (277 * kStandardGravity * 12000), 1, 1e-7);
}

TEST(Vehicle, EveryNumberHasItsOrigin) {
  EXPECT_EQ(vlm1_provenance().size(), 18U);
  for (const Provenance& p : vlm1_provenance()) {
    EXPECT_FALSE(p.number.empty());
    EXPECT_FALSE(p.reason.empty());
  }
}

TEST(Vehicle, RefusesWhatCannotFly) {
  const auto refused = [](auto change) {
    Vehicle v = vlm1();
    change(v);
    EXPECT_THROW(v.check(), std::invalid_argument);
  };
  refused([](Vehicle& v) { v.propellant = v.lift_off_mass; });
  refused([](Vehicle& v) { v.lift_off_mass = NAN; });
  refused([](Vehicle& v) { v.burn_time = 0; });
  refused([](Vehicle& v) { v.pitch_inertia = 0; });
  refused([](Vehicle& v) { v.thrust_shape = 0; });
  refused([](Vehicle& v) { v.thrust_shape = LookupTable::linear({{0.1, 1}, {1, 1}}); });
  refused([](Vehicle& v) { v.pitch_inertia = LookupTable::smooth({{0, 4}, {0.1, 0.1}, {0.2, 0.1}, {1, 4}}); });
  refused([](Vehicle& v) { v.actuator.delay = -1; });
  refused([](Vehicle& v) { v.bending = Bending{.frequency = 0}; });
}

TEST(Vehicle, TellsWhichNumberItRefuses) {
  Vehicle v = vlm1();
  v.actuator.delay = 2;
  try {
    v.check();
    FAIL() << "expected a refusal";
  } catch (const VehicleError& error) {
    EXPECT_EQ(error.number, "actuator.delay");
    EXPECT_STREQ(error.what(), "delay of the actuator is 2 s, but must be from 0 to 1");
  }
}

}  // namespace
}  // namespace gyrobudget::flight

// SPDX-License-Identifier: MIT
// Geodetic coordinates and radii: against GeographicLib (Geocentric, Ellipsoid), the defining formulas in
// long double, and round trips at many points.
#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <gtest/gtest.h>

#include <GeographicLib/Ellipsoid.hpp>
#include <GeographicLib/Geocentric.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "points.h"

namespace gyrobudget::earth {
namespace {

using std::numbers::pi;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kNanometre = 1e-9;

Eigen::Vector3d reference_ecef(const Geodetic& g) {
  const long double s = std::sin(static_cast<long double>(g.latitude));
  const long double c = std::cos(static_cast<long double>(g.latitude));
  const long double f = 1 / 298.257223563L;
  const long double e2 = f * (2 - f);
  const long double radius = 6378137 / std::sqrt(1 - e2 * s * s);
  const long double out = (radius + g.height) * c;
  return {static_cast<double>(out * std::cos(static_cast<long double>(g.longitude))),
          static_cast<double>(out * std::sin(static_cast<long double>(g.longitude))),
          static_cast<double>(((1 - e2) * radius + g.height) * s)};
}

double longitude_difference(double a, double b) { return std::remainder(a - b, 2 * pi); }

TEST(Ellipsoid, ConstantsAreThoseOfGeographicLib) {
  const auto& truth = GeographicLib::Ellipsoid::WGS84();
  EXPECT_EQ(wgs84::kEquatorialRadius, truth.EquatorialRadius());
  EXPECT_EQ(wgs84::kFlattening, truth.Flattening());
  EXPECT_NEAR(wgs84::kPolarRadius, truth.PolarRadius(), kNanometre);
  EXPECT_NEAR(wgs84::kEccentricitySquared, truth.EccentricitySq(), kEpsilon * 0.01);
}

TEST(Ellipsoid, EcefIsTheDefiningFormulaToTwoUlp) {
  for (const Geodetic& g : many_points()) {
    const Eigen::Vector3d p = to_ecef(g);
    ASSERT_LE((p - reference_ecef(g)).cwiseAbs().maxCoeff(), 2 * kEpsilon * p.norm())
        << g.latitude << " " << g.longitude << " " << g.height;
  }
}

TEST(Ellipsoid, GeodeticAgreesWithGeographicLib) {
  const auto& geocentric = GeographicLib::Geocentric::WGS84();
  for (const Geodetic& truth : many_points()) {
    const Eigen::Vector3d p = reference_ecef(truth);
    const Geodetic ours = to_geodetic(p);
    double latitude = 0;
    double longitude = 0;
    double height = 0;
    geocentric.Reverse(p.x(), p.y(), p.z(), latitude, longitude, height);
    const double distance = p.norm();
    const double tolerance = 3 * kNanometre * std::max(1.0, distance / wgs84::kEquatorialRadius);
    ASSERT_NEAR(ours.height, truth.height, tolerance);
    ASSERT_NEAR((ours.latitude - truth.latitude) * distance, 0, 2 * tolerance) << truth.latitude << " " << truth.height;
    ASSERT_NEAR(longitude_difference(ours.longitude, truth.longitude) * std::hypot(p.x(), p.y()), 0, 2 * tolerance);
    // GeographicLib's own error is up to 8 nm.
    ASSERT_NEAR(ours.height, height, 8 * tolerance);
    ASSERT_NEAR((ours.latitude - latitude * kDegree) * distance, 0, 8 * tolerance);
  }
}

TEST(Ellipsoid, RoundTripFromAnywhere) {
  Uniform uniform(7);
  for (int k = 0; k < 20000; ++k) {
    const double scale = std::pow(10, uniform(0, 7.2));
    const Eigen::Vector3d p = uniform.vector(scale);
    const Geodetic g = to_geodetic(p);
    ASSERT_TRUE(std::abs(g.latitude) <= pi / 2 && std::abs(g.longitude) <= pi && std::isfinite(g.height));
    // The height runs from the surface inwards, so near the centre the round trip still rounds as at the
    // surface.
    const double tolerance = 4 * kNanometre * std::max(1.0, p.norm() / wgs84::kEquatorialRadius);
    const double evolute = wgs84::kEquatorialRadius * wgs84::kEccentricitySquared;
    if (p.norm() > evolute + 1000) {
      ASSERT_LE((to_ecef(g) - p).norm(), tolerance) << p.transpose();
    } else {  // the normal is ill-defined near the evolute; the point on it still is near
      ASSERT_LE((to_ecef(g) - p).norm(), 1e-3) << p.transpose();
    }
  }
}

TEST(Ellipsoid, HeightIsTheSmallestDistanceNearTheCentre) {
  const auto& geocentric = GeographicLib::Geocentric::WGS84();
  Uniform uniform(8);
  for (int k = 0; k < 5000; ++k) {
    const Eigen::Vector3d p = uniform.vector(std::pow(10, uniform(-100, 5)));
    double latitude = 0;
    double longitude = 0;
    double height = 0;
    geocentric.Reverse(p.x(), p.y(), p.z(), latitude, longitude, height);
    ASSERT_NEAR(to_geodetic(p).height, height, 8 * kNanometre) << p.transpose();
  }
}

TEST(Ellipsoid, CoordinatesWhoseSquaresUnderflowAreTheCentre) {
  Uniform uniform(10);
  for (int k = 0; k < 2000; ++k) {
    const Geodetic g = to_geodetic(uniform.vector(std::pow(10, uniform(-320, -100))));
    ASSERT_NEAR(g.height, -wgs84::kPolarRadius, kNanometre);
    ASSERT_NEAR(std::abs(g.latitude), pi / 2, kEpsilon);
  }
}

TEST(Ellipsoid, Corners) {
  const Geodetic centre = to_geodetic({0, 0, 0});
  EXPECT_EQ(centre.latitude, pi / 2);
  EXPECT_EQ(centre.longitude, 0);
  EXPECT_EQ(centre.height, -wgs84::kPolarRadius);
  const Geodetic pole = to_geodetic({0, 0, -wgs84::kPolarRadius - 100});
  EXPECT_EQ(pole.latitude, -pi / 2);
  EXPECT_EQ(pole.longitude, 0);
  EXPECT_NEAR(pole.height, 100, kNanometre);
  const Geodetic date_line = to_geodetic({-wgs84::kEquatorialRadius, 0, 0});
  EXPECT_EQ(date_line.latitude, 0);
  EXPECT_EQ(std::abs(date_line.longitude), pi);
  EXPECT_EQ(date_line.height, 0);
}

TEST(Ellipsoid, RadiiAreThoseOfGeographicLib) {
  const auto& ellipsoid = GeographicLib::Ellipsoid::WGS84();
  for (double degrees = -90; degrees <= 90; degrees += 0.5) {
    EXPECT_NEAR(meridian_radius(degrees * kDegree), ellipsoid.MeridionalCurvatureRadius(degrees), 4 * kNanometre);
    EXPECT_NEAR(transverse_radius(degrees * kDegree), ellipsoid.TransverseCurvatureRadius(degrees), 4 * kNanometre);
  }
}

TEST(Ellipsoid, RefusesWhatIsNoPlace) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(static_cast<void>(to_geodetic({nan, 0, 0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(to_geodetic({0, 0, std::numeric_limits<double>::infinity()})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(to_geodetic({1e16, 0, 0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(Geodetic::from_degrees(90.0001, 0, 0)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(Geodetic::from_degrees(nan, 0, 0)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(Geodetic::from_degrees(0, nan, 0)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(Geodetic::from_degrees(0, 0, nan)), std::invalid_argument);
  EXPECT_NEAR(to_geodetic({5e14, 0, 5e14}).latitude, pi / 4, 1e-8);
}

}  // namespace
}  // namespace gyrobudget::earth

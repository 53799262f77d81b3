// SPDX-License-Identifier: MIT
// Frames against GeographicLib (LocalCartesian, Geocentric), numerical derivatives and hand-derived values.
#include "gyrobudget/vehicle/earth/frames.h"

#include "gyrobudget/vehicle/earth/site.h"

#include <gtest/gtest.h>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "points.h"
#include <Eigen/LU>

namespace gyrobudget::earth {
namespace {

using std::numbers::pi;

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kNanometre = 1e-9;

double off_identity(const Eigen::Matrix3d& C) { return (C * C.transpose() - Eigen::Matrix3d::Identity()).norm(); }

TEST(Frames, RotationsAreProperAndNamedAxesPointWhereTheySay) {
  for (const Geodetic& g : many_points(2000)) {
    const Eigen::Matrix3d enu = C_e_enu(g.latitude, g.longitude);
    const Eigen::Matrix3d ned = C_e_ned(g.latitude, g.longitude);
    for (const Eigen::Matrix3d& C : {enu, ned}) {
      ASSERT_LE(off_identity(C), 8 * kEpsilon);
      ASSERT_NEAR(C.determinant(), 1, 8 * kEpsilon);
    }
    ASSERT_EQ(enu.col(2), up_e(g.latitude, g.longitude));
    ASSERT_EQ(ned.col(2), -enu.col(2));
    ASSERT_EQ(ned.col(0), enu.col(1));
    ASSERT_EQ(ned.col(1), enu.col(0));
    ASSERT_EQ(enu(2, 0), 0);  // east is level with the equator
    ASSERT_GE(enu(2, 1), 0);  // north leans to the north pole
  }
}

TEST(Frames, EnuIsGeographicLibsMatrix) {
  const auto& geocentric = GeographicLib::Geocentric::WGS84();
  for (const Geodetic& g : many_points(2000)) {
    std::vector<double> M(9);
    double x = 0;
    double y = 0;
    double z = 0;
    geocentric.Forward(g.latitude / kDegree, g.longitude / kDegree, g.height, x, y, z, M);
    const Eigen::Matrix3d C = C_e_enu(g.latitude, g.longitude);
    for (int row = 0; row < 3; ++row)
      for (int col = 0; col < 3; ++col)
        ASSERT_NEAR(C(row, col), M[static_cast<std::size_t>(3 * row + col)], 8 * kEpsilon);
  }
}

TEST(Frames, LocalFrameIsLocalCartesian) {
  Uniform uniform(3);
  for (const Geodetic& origin : many_points(300)) {
    if (origin.height > 1e5) continue;
    const GeographicLib::LocalCartesian truth(origin.latitude / kDegree, origin.longitude / kDegree, origin.height);
    const auto local = LocalFrame::east_north_up(origin);
    const Geodetic there{uniform(-pi / 2, pi / 2), uniform(-pi, pi), uniform(0, 3e5)};
    Eigen::Vector3d p;
    truth.Forward(there.latitude / kDegree, there.longitude / kDegree, there.height, p.x(), p.y(), p.z());
    const Eigen::Vector3d p_eb_e = to_ecef(there);
    // Both round positions of up to two Earth radii, and degrees round where radians do not.
    ASSERT_LE((local.from_ecef(p_eb_e) - p).norm(), 20 * kNanometre);
    ASSERT_LE((local.to_ecef(local.from_ecef(p_eb_e)) - p_eb_e).norm(), 8 * kNanometre);
  }
}

TEST(Frames, LaunchPlaneTurnsWithItsAzimuth) {
  const Geodetic site = alcantara().position;
  const auto enu = LocalFrame::east_north_up(site);
  const auto ned = LocalFrame::north_east_down(site);
  EXPECT_LE((LocalFrame::launch_plane(site, pi / 2).C_el() - enu.C_el()).norm(), 4 * kEpsilon);
  for (const double azimuth : {-1.0, 0.0, 0.3, pi / 2, 2.0, pi, 6.0}) {
    const auto plane = LocalFrame::launch_plane(site, azimuth);
    const Eigen::Vector3d downrange_ned = ned.C_el().transpose() * plane.C_el().col(0);
    EXPECT_NEAR(downrange_ned.x(), std::cos(azimuth), 4 * kEpsilon);
    EXPECT_NEAR(downrange_ned.y(), std::sin(azimuth), 4 * kEpsilon);
    EXPECT_NEAR(downrange_ned.z(), 0, 4 * kEpsilon);
    EXPECT_LE((plane.C_el().col(2) - enu.C_el().col(2)).norm(), 4 * kEpsilon);
    EXPECT_NEAR(plane.C_el().determinant(), 1, 8 * kEpsilon);
  }
  EXPECT_THROW((void)LocalFrame::launch_plane(site, std::numeric_limits<double>::infinity()), std::invalid_argument);
}

TEST(Frames, InertialRoundTripAndFixedPointsMoveEast) {
  Uniform uniform(5);
  for (const Geodetic& g : many_points(2000)) {
    const Inertial inertial(uniform(-10, 10));
    const double t = uniform(-1e5, 1e5);
    const Moving e{to_ecef(g), uniform.vector(1e4)};
    const Moving there = inertial.from_ecef(e, t);
    const Moving back = inertial.to_ecef(there, t);
    ASSERT_LE((back.p - e.p).norm(), 8 * kEpsilon * e.p.norm());
    ASSERT_LE((back.v - e.v).norm(), 8 * kEpsilon * (e.v.norm() + 1000));
    ASSERT_NEAR(there.p.norm(), e.p.norm(), 4 * kEpsilon * e.p.norm());
  }
  const Moving still = Inertial().from_ecef({{wgs84::kEquatorialRadius, 0, 0}, Eigen::Vector3d::Zero()}, 0);
  EXPECT_NEAR(still.v.y(), 465.1011, 1e-4);  // Groves (2013), 2.4.6: 465 m/s at the equator
  const double quarter = pi / 2 / wgs84::kEarthRate;
  const Moving later = Inertial().from_ecef({{1, 0, 0}, Eigen::Vector3d::Zero()}, quarter);
  EXPECT_NEAR(later.p.y(), 1, 1e-15);
}

TEST(Frames, InertialVelocityIsTheDerivativeOfInertialPosition) {
  const Inertial inertial(0.4);
  const Eigen::Vector3d p0(4e6, 3e6, 4e6);
  const Eigen::Vector3d v(7000, -300, 120);
  const auto p_i = [&](double t) { return inertial.from_ecef({p0 + v * t, v}, t).p; };
  constexpr double h = 1;  // error of the difference: h^2/6 omega^2 v, 6e-6 m/s, and rounding over h
  const Eigen::Vector3d numeric = (p_i(100 + h) - p_i(100 - h)) / (2 * h);
  EXPECT_LE((numeric - inertial.from_ecef({p0 + v * 100, v}, 100).v).norm(), 2e-5);
}

TEST(Frames, RatesOfNorthEastDown) {
  Uniform uniform(9);
  for (int k = 0; k < 2000; ++k) {
    const Geodetic g{uniform(-1.5, 1.5), uniform(-pi, pi), uniform(0, 3e5)};
    const Eigen::Matrix3d C_en = C_e_ned(g.latitude, g.longitude);
    const Eigen::Vector3d w_ie_e(0, 0, wgs84::kEarthRate);
    ASSERT_LE((earth_rate_ned(g.latitude) - C_en.transpose() * w_ie_e).norm(), 4 * kEpsilon * wgs84::kEarthRate);

    // d(C_en)/dt = C_en [w_en_n x], by a central difference along the motion.
    const Eigen::Vector3d v_n = uniform.vector(1000);
    const double dt = 0.1;
    const auto C_at = [&](double t) {
      const Geodetic there = to_geodetic(to_ecef(g) + C_en * v_n * t);
      return C_e_ned(there.latitude, there.longitude);
    };
    const Eigen::Matrix3d W = C_en.transpose() * (C_at(dt) - C_at(-dt)) / (2 * dt);
    const Eigen::Vector3d w = transport_rate_ned(g, v_n);
    ASSERT_LE((Eigen::Vector3d(W(2, 1), W(0, 2), W(1, 0)) - w).norm(), 1e-6 * w.norm() + 1e-13);
  }
  EXPECT_THROW(static_cast<void>(transport_rate_ned({pi / 2, 0, 0}, {1, 1, 0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(transport_rate_ned({-pi / 2, 0, 0}, {1, 1, 0})), std::invalid_argument);
}

TEST(Site, AlcantaraByName) {
  EXPECT_NEAR(find_site("alcantara").position.latitude, -2.373 * kDegree, 1e-15);
  EXPECT_NEAR(alcantara().position.longitude, -44.396 * kDegree, 1e-15);
  EXPECT_EQ(sites().size(), 1U);
  try {
    static_cast<void>(find_site("kourou"));
    FAIL();
  } catch (const std::invalid_argument& e) {
    EXPECT_NE(std::string(e.what()).find("alcantara"), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrobudget::earth

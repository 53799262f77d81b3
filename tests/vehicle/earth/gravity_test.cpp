// SPDX-License-Identifier: MIT
// Normal gravity against GeographicLib's closed form, published values, and its own derivatives. A gravity
// model file is made from the ellipsoid's form factors, so that a model of known field is read without data.
#include "gyrobudget/vehicle/earth/gravity.h"

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity_model.h"
#include "gyrobudget/vehicle/earth/site.h"

#include <gtest/gtest.h>

#include <GeographicLib/NormalGravity.hpp>
#include <stdlib.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>

#include "points.h"

namespace gyrobudget::earth {
namespace {

using std::numbers::pi;

constexpr double kBound = 2e-14;  // [m/s^2]; two formulas that round 9.8 a few times

const GeographicLib::NormalGravity& truth() { return GeographicLib::NormalGravity::WGS84(); }

Eigen::Vector3d true_gravity(const Eigen::Vector3d& p) {
  Eigen::Vector3d g;
  truth().U(p.x(), p.y(), p.z(), g.x(), g.y(), g.z());
  return g;
}

TEST(Gravity, EqualsGeographicLibEverywhere) {
  for (const Geodetic& g : many_points()) {
    const Eigen::Vector3d p = to_ecef(g);
    ASSERT_LE((normal_gravity(p) - true_gravity(p)).norm(), kBound) << g.latitude << " " << g.height;
    Eigen::Vector3d pull;
    truth().V0(p.x(), p.y(), p.z(), pull.x(), pull.y(), pull.z());
    ASSERT_LE((normal_gravitation(p) - pull).norm(), kBound) << g.latitude << " " << g.height;
  }
}

TEST(Gravity, AlongAnAscentFromAlcantara) {
  const auto pad = LocalFrame::launch_plane(alcantara().position, pi / 2);
  for (double t = 0; t <= 400; t += 1) {
    const Eigen::Vector3d p = pad.to_ecef({1.5 * t * t, 0.1 * t * t, 2 * t * t});  // to 320 km and beyond
    ASSERT_LE((normal_gravity(p) - true_gravity(p)).norm(), kBound) << t;
  }
}

TEST(Gravity, SomiglianaIsGravityOnTheEllipsoid) {
  EXPECT_NEAR(somigliana(0), 9.7803253359, 5.1e-11);       // NGA.STND.0036 (2014), table 3.6
  EXPECT_NEAR(somigliana(pi / 2), 9.8321849379, 5.1e-11);  // the same table
  for (double degrees = -90; degrees <= 90; degrees += 0.25) {
    const double latitude = degrees * kDegree;
    EXPECT_NEAR(somigliana(latitude), truth().SurfaceGravity(degrees), kBound);
    const Eigen::Vector3d gravity = normal_gravity(to_ecef({latitude, 0.7, 0}));
    EXPECT_NEAR(gravity.norm(), somigliana(latitude), kBound);
    // The ellipsoid is an equipotential surface: gravity has no level part on it.
    EXPECT_LE((gravity + somigliana(latitude) * up_e(latitude, 0.7)).norm(), kBound);
  }
}

TEST(Gravity, ZonalsAreTheEllipsoids) {
  for (int n = 2; n <= 12; n += 2)
    EXPECT_NEAR(normal_zonal(n), truth().DynamicalFormFactor(n), 1e-15 * std::abs(normal_zonal(2))) << n;
  EXPECT_THROW(static_cast<void>(normal_zonal(3)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(normal_zonal(14)), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(normal_zonal(0)), std::invalid_argument);
}

TEST(Gravity, GradientIsTheDerivative) {
  constexpr double h = 100;  // [m]; the difference errs by (h/r)^2, 3e-10, and rounding over h, 5e-11 of GM/r^3
  double worst = 0;
  for (const Geodetic& g : many_points(2000)) {
    const Eigen::Vector3d p = to_ecef(g);
    Eigen::Matrix3d numeric;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = h * Eigen::Vector3d::Unit(k);
      numeric.col(k) = (normal_gravity(p + step) - normal_gravity(p - step)) / (2 * h);
    }
    const Eigen::Matrix3d G = normal_gravity_gradient(p);
    ASSERT_LE((G - G.transpose()).norm(), 1e-20);
    worst = std::max(worst, (G - numeric).norm() * std::pow(p.norm(), 3) / wgs84::kGM);
    // Laplace: the mass is elsewhere, so what remains of the trace is the rotation's.
    ASSERT_NEAR(G.trace(), 2 * wgs84::kEarthRate * wgs84::kEarthRate, 1e-20);
  }
  EXPECT_LE(worst, 1e-4);
  EXPECT_GE(worst, 1e-6);  // J4 is left out, so a smaller bound would not be one
  RecordProperty("worst", std::to_string(worst));
}

TEST(Gravity, RefusesTheCentre) {
  EXPECT_THROW(static_cast<void>(normal_gravity({0, 0, 0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(normal_gravity({std::nan(""), 0, 7e6})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(normal_gravity_gradient({0, 9e5, 0})), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(normal_gravitation({std::numeric_limits<double>::infinity(), 0, 0})),
               std::invalid_argument);
}

/// Writes the ellipsoid's field as a gravity model: metadata, id, and the zonals, C_n0 = -J_n/sqrt(2n + 1);
/// degree 0 is the mass.
class ModelFile {
 public:
  ModelFile() {
    std::string name = (std::filesystem::temp_directory_path() / "gyrobudget-gravity-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());  // tests run beside each other: each has a folder of its own
    constexpr int kDegreeOfFile = 20;
    std::ofstream meta(path());
    meta.precision(17);
    meta << "EGMF-1\nName ellipsoid\nDescription the WGS84 ellipsoid itself\nModelRadius " << wgs84::kEquatorialRadius
         << "\nModelMass " << wgs84::kGM << "\nAngularVelocity " << wgs84::kEarthRate << "\nReferenceRadius "
         << wgs84::kEquatorialRadius << "\nReferenceMass " << wgs84::kGM << "\nFlattening " << wgs84::kFlattening
         << "\nHeightOffset 0\nNormalization full\nID ELLIPSOI\n";
    std::ofstream cof(path() + ".cof", std::ios::binary);
    const auto put_int = [&](std::int32_t value) { cof.write(reinterpret_cast<const char*>(&value), sizeof value); };
    const auto put = [&](double value) { cof.write(reinterpret_cast<const char*>(&value), sizeof value); };
    cof << "ELLIPSOI";
    put_int(kDegreeOfFile);
    put_int(0);
    for (int n = 0; n <= kDegreeOfFile; ++n)
      put(n == 0 || n % 2 != 0 ? 0 : -truth().DynamicalFormFactor(n) / std::sqrt(2 * n + 1));
    put_int(-1);  // no correction to the height
    put_int(-1);
  }
  ~ModelFile() { std::filesystem::remove_all(folder_); }
  ModelFile(const ModelFile&) = delete;
  ModelFile& operator=(const ModelFile&) = delete;
  [[nodiscard]] std::string path() const { return (folder_ / "ellipsoid.egm").string(); }

 private:
  std::filesystem::path folder_;
};

TEST(GravityModel, OfTheEllipsoidIsNormalGravity) {
  const ModelFile file;
  const GravityModel model(file.path());
  EXPECT_EQ(model.description(), "the WGS84 ellipsoid itself");
  for (const Geodetic& g : many_points(2000)) {
    const Eigen::Vector3d p = to_ecef(g);
    ASSERT_LE((model.gravity(p) - normal_gravity(p)).norm(), kBound);
    ASSERT_LE((model.gravitation(p) - normal_gravitation(p)).norm(), kBound);
  }
}

TEST(GravityModel, CutAtADegreeIsThePointMass) {
  const ModelFile file;
  const GravityModel model(file.path(), 0);
  const Eigen::Vector3d p(7e6, 1e6, 2e6);
  EXPECT_LE((model.gravitation(p) + wgs84::kGM / std::pow(p.norm(), 3) * p).norm(), kBound);
}

TEST(GravityModel, SaysWhatItCannotRead) {
  EXPECT_THROW(GravityModel("egm96"), std::invalid_argument);
  EXPECT_THROW(GravityModel("x.egm", -1), std::invalid_argument);
  try {
    const GravityModel none("/nowhere/none.egm");
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("/nowhere/none.egm"), std::string::npos);
  }
}

}  // namespace
}  // namespace gyrobudget::earth

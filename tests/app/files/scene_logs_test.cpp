// SPDX-License-Identifier: MIT
// Scenes of which IMU and aids were recorded by others: streams of recordings, solutions of receivers, their clocks,
// heights and errors.
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <gmock/gmock.h>

#include <fmt/format.h>

#include <filesystem>

#include "../log/formats/ulog_writer.h"
#include "../log/recording_writer.h"
#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using earth::kDegree;
using Eigen::Vector3d;
using testing::Contains;
using testing::HasSubstr;
using text::InputError;

constexpr double kMicron = 1e-6;  // [m]: some 1000 times the rounding of ECEF coordinates
constexpr std::int64_t kSecond = 1'000'000'000;

const std::string kStart =
    "alignment: {position_sigma: 1 m, velocity_sigma: 1 cm/s, attitude: {heading: 0 deg}, level_sigma: 1 deg, heading_sigma: 1 deg}\n";
const std::string kImuCsv =
    "time (s),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (m/s^2),accel_y (m/s^2),accel_z (m/s^2)\n0,0,0,0,0,0,-9.8\n1,0,0,0,0,0,-9.8\n2,0,0,0,0,0,-9.8\n";

class SceneLogs : public TemporaryFolder {
 protected:
  [[nodiscard]] files::SceneData data(const std::string& scene) const {
    return files::read_recording(files::read_scene(file("scene.yaml", "site: alcantara\n" + kStart + scene)));
  }
  [[nodiscard]] std::string message(const std::string& scene) const {
    return message_of<InputError>([&] { (void)data(scene); });
  }
  /// The notes of a scene with a text IMU.
  static std::string all(const std::vector<std::string>& notes) {
    std::string text;
    for (const std::string& note : notes) text += note + "\n";
    return text;
  }
};

// --- The IMU ---------------------------------------------------------------------------------------------------------

std::string bag(int imus, int first_status = 0) {
  using namespace recording_writer;
  BagWriter bag;
  for (int i = 0; i < imus; ++i)
    bag.connection(static_cast<std::uint32_t>(i), fmt::format("/imu{}", i), "sensor_msgs/Imu");
  bag.connection(7, "/fix", "sensor_msgs/NavSatFix");
  bag.connection(8, "/vel", "geometry_msgs/TwistWithCovarianceStamped");
  for (std::uint32_t k = 0; k < 4; ++k) {
    const Stamp at{1'700'000'000, 10'000'000 * k}, recorded{1'700'000'001, 0};  // the sample's own clock counts
    for (int i = 0; i < imus; ++i)
      bag.message(static_cast<std::uint32_t>(i), recorded, ros1_imu(at, imu_numbers(static_cast<int>(k))));
    Fix fix;
    fix.status = k == 0 ? first_status : 0;
    fix.covariance_type = k == 3 ? 0 : 2;
    bag.message(7, recorded, ros1_fix(at, fix));
    Buffer twist = ros1_header(at, "map");
    for (const double v : {1.0, 2.0, 3.0, 0.0, 0.0, 0.0}) twist.number(v);
    for (int i = 0; i < 36; ++i) twist.number(i % 7 == 0 ? 0.25 : 0.0);
    bag.message(8, recorded, twist.bytes);
  }
  bag.end_chunk();
  return bag.closed();
}

TEST_F(SceneLogs, AnImuOfABagHasItsUnitsAndItsOwnClock) {
  (void)file("walk.bag", bag(1));
  const auto r = data("imu: {file: walk.bag, axes: [y, x, -z]}\n").recording;
  EXPECT_EQ(r.origin, 1'700'000'000 * kSecond);
  ASSERT_EQ(r.imu.increments.size(), 4U);
  constexpr double kDt = 0.01, kRounding = 1e-15;
  // Sample i: rates i + .1, .2, .3; forces -i + .4, -i + .5, 9.6.
  EXPECT_NEAR(r.imu.increments[2].angle[0], 2.2 * kDt, kRounding);
  EXPECT_NEAR(r.imu.increments[2].angle[1], 2.1 * kDt, kRounding);
  EXPECT_NEAR(r.imu.increments[2].angle[2], -2.3 * kDt, kRounding);
  EXPECT_NEAR(r.imu.increments[2].velocity[2], -9.6 * kDt, kRounding);
}

TEST_F(SceneLogs, OfSeveralImusNoneIsPicked) {
  (void)file("walk.bag", bag(2));
  EXPECT_THAT(message("imu: {file: walk.bag}\n"), HasSubstr("choose one of them: topic: NAME"));
  EXPECT_EQ(data("imu: {file: walk.bag, topic: /imu1}\n").recording.imu.increments.size(), 4U);
  EXPECT_THAT(message("imu: {file: walk.bag, topic: /imu2}\n"), HasSubstr("topic: /imu2: "));
  (void)file("imu.csv", kImuCsv);
  EXPECT_THAT(message("imu: {file: imu.csv, topic: /imu}\n"), HasSubstr("it is no recording with topics"));
}

TEST_F(SceneLogs, AnImuOfWhichTheRecorderLeftOutSamplesIsRefused) {
  UlogWriter log;
  log.format(
      "vehicle_imu:uint64_t timestamp;float[3] delta_angle;float[3] delta_velocity;uint16_t delta_angle_dt;uint16_t delta_velocity_dt;");
  log.subscribe(1, "vehicle_imu");
  const auto rows = [&](std::uint64_t step_us) {
    UlogWriter copy = log;
    for (std::uint64_t k = 0; k < 8; ++k)
      copy.data(1, packed(1000 + step_us * k, .001F, .002F, .003F, 0.F, 0.F, -.049F, std::uint16_t{5000},
                          std::uint16_t{5000}));
    return copy.bytes();
  };
  (void)file("log.ulg", rows(500'000));
  EXPECT_THAT(message("imu: {file: log.ulg}\n"), HasSubstr("the recorder left out samples"));
  (void)file("log.ulg", rows(5'000));
  const auto r = data("imu: {file: log.ulg}\n").recording;
  EXPECT_EQ(r.imu.increments[3].angle[1], static_cast<double>(.002F));  // an increment stays what it is
}

// --- Fixes of recordings ---------------------------------------------------------------------------------------------

TEST_F(SceneLogs, FixesOfABagWithTheErrorsThatTheyHave) {
  (void)file("walk.bag", bag(1, -1));
  const auto found = data(
      "imu: {file: walk.bag}\naids:\n  gnss: {file: walk.bag, position: 1 m}\n"
      "  own: {file: walk.bag, topic: /fix, position: file, height: {sigma: file}}\n"
      "  vel: {file: walk.bag, topic: /vel, velocity: file, columns: {velocity_east: twist.twist.linear.x, velocity_north: twist.twist.linear.y, velocity_up: twist.twist.linear.z, velocity_sigma: 'twist.covariance[0]'}}\n");
  const auto& fixes = found.recording.fixes;
  ASSERT_EQ(fixes.size(), 4U);
  ASSERT_EQ(fixes[0].size(), 3U);  // the first has the status of no fix
  EXPECT_EQ(fixes[0][0].stamp, 1'700'000'000 * kSecond + 10'000'000);
  EXPECT_LT((fixes[0][0].value - earth::to_ecef({-2.3 * kDegree, -44.4 * kDegree, 12.5})).norm(), kMicron);
  EXPECT_FALSE(fixes[0][0].sigma);
  ASSERT_EQ(fixes[1].size(), 2U);  // and the last has no covariance
  EXPECT_LT((*fixes[1][0].sigma - Vector3d(2, std::sqrt(5), 4)).norm(), kMicron);
  EXPECT_EQ(fixes[2][0].value[0], 12.5);
  EXPECT_DOUBLE_EQ((*fixes[2][0].sigma)[0], 4);
  ASSERT_EQ(fixes[3].size(), 4U);
  EXPECT_EQ(fixes[3][0].value, Vector3d(2, 1, -3));
  EXPECT_EQ(*fixes[3][0].sigma, Vector3d::Constant(.5));
  EXPECT_THAT(all(found.notes), HasSubstr("gnss.position: 1 of 4 rows say that nothing was measured"));
  EXPECT_THAT(all(found.notes), HasSubstr("own.position: 1 of 4 rows have no sigma above 0"));
}

std::string px4(const std::string& fields, const std::string& values) {
  UlogWriter log;
  log.format(
      "vehicle_gps_position:uint64_t timestamp;int32_t lat;int32_t lon;int32_t alt;" + fields +
      "float s_variance_m_s;float eph;float epv;float vel_n_m_s;float vel_e_m_s;float vel_d_m_s;uint8_t fix_type;");
  log.subscribe(1, "vehicle_gps_position");
  for (const std::uint8_t type : {2, 3, 8})
    log.data(1, packed(std::uint64_t{500'000} + 100'000 * type, -23'731'000, -443'964'000, 41'200) + values +
                    packed(.4F, 1.5F, 2.5F, 1.F, 2.F, 3.F, type));
  return log.bytes();
}

TEST_F(SceneLogs, Px4sFixesOverTheEllipsoidOrWithTheGeoidAskedFor) {
  (void)file("imu.csv", kImuCsv);
  const std::string scene = "imu: {file: imu.csv}\naids:\n  gnss: {file: log.ulg, position: file, velocity: file";
  (void)file("log.ulg", px4("int32_t alt_ellipsoid;", packed(16'250)));
  const auto found = data(scene + "}\n");
  const auto& fixes = found.recording.fixes;
  ASSERT_EQ(fixes[0].size(), 1U);  // 2 is flat, 8 is extrapolated
  EXPECT_EQ(fixes[0][0].stamp, 800'000'000);
  EXPECT_LT((fixes[0][0].value - earth::to_ecef({-2.3731 * kDegree, -44.3964 * kDegree, 16.25})).norm(), kMicron);
  EXPECT_EQ(*fixes[0][0].sigma, Vector3d(1.5, 1.5, 2.5));
  EXPECT_EQ(fixes[1][0].value, Vector3d(1, 2, 3));
  EXPECT_EQ(*fixes[1][0].sigma, Vector3d::Constant(static_cast<double>(.4F)));

  (void)file("log.ulg", px4("", ""));
  EXPECT_THAT(message(scene + "}\n"), HasSubstr("aids.gnss: its heights are over the geoid (mean sea level)"));
  const auto told = data(scene + ", geoid_separation: -24.95 m}\n");
  EXPECT_LT((told.recording.fixes[0][0].value - earth::to_ecef({-2.3731 * kDegree, -44.3964 * kDegree, 16.25})).norm(),
            kMicron);
  EXPECT_THAT(told.notes, Contains(HasSubstr("lies -24.95 m over the ellipsoid, as the scene says")));
}

/// A dataflash log as text: GPS by status, with its errors in GPA.
std::string dataflash() {
  std::string log =
      "FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\n"
      "FMT, 130, 50, GPS, QBBIHBcLLeffffB, TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw,U\n"
      "FMT, 131, 30, GPA, QBCCCC, TimeUS,I,VDop,HAcc,VAcc,SAcc\n";
  log += "GPS, 200000, 0, 1, 0, 0, 0, 9.9, 0, 0, 0, 0, 0, 0, 0, 1\n";
  log += "GPS, 400000, 0, 3, 400, 2414, 9, 0.9, -2.3731, -44.3964, 41.20, 5.0, 90.0, -0.5, 0, 1\n";
  log += "GPA, 400000, 0, 1.2, 0.75, 1.50, 0.25\n";
  log += "GPS, 600000, 0, 6, 600, 2414, 9, 0.9, -2.3731, -44.3964, 41.20, 0.0, 77.0, 0.0, 0, 1\n";
  log += "GPA, 600000, 0, 1.2, 0.02, 0.03, 0.05\n";
  return log;
}

TEST_F(SceneLogs, ArduPilotsFixesWithTheErrorsOfTheMessageBeside) {
  (void)file("imu.csv", kImuCsv);
  (void)file("log.log", dataflash());
  const std::string scene =
      "imu: {file: imu.csv}\naids:\n  gnss: {file: log.log, position: file, velocity: file, geoid_separation: -24.95 m}\n";
  const auto found = data(scene);
  const auto& fixes = found.recording.fixes;
  ASSERT_EQ(fixes[0].size(), 2U);
  EXPECT_EQ(fixes[0][1].stamp, 600'000'000);
  EXPECT_LT((fixes[0][1].value - earth::to_ecef({-2.3731 * kDegree, -44.3964 * kDegree, 16.25})).norm(), kMicron);
  EXPECT_EQ(*fixes[0][0].sigma, Vector3d(.75, .75, 1.5));
  EXPECT_EQ(*fixes[0][1].sigma, Vector3d(.02, .02, .03));
  EXPECT_LT((fixes[1][0].value - Vector3d(0, 5, -.5)).norm(), kMicron);
  EXPECT_EQ(fixes[1][1].value, Vector3d(0, 0, 0));  // it stands: the course says nothing
  EXPECT_EQ(*fixes[1][1].sigma, Vector3d::Constant(.05));
}

// --- Solutions of receivers ------------------------------------------------------------------------------------------

const std::string kPos =
    "% (lat/lon/height=WGS84/ellipsoidal,Q=1:fix,2:float,5:single,ns=# of satellites)\n"
    "%  GPST latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) sdun(m) age(s) ratio vn(m/s) ve(m/s) vu(m/s)\n"
    "2025/08/28 17:30:39.500 40.1 -105.15 1600.5 1 18 0.02 0.03 0.04 0 0 0 0 12 1 2 3\n"
    "2025/08/28 17:30:40.500 40.1 -105.15 1600.5 5 18 2 3 4 0 0 0 0 12 1 2 3\n";
const std::string kWalk =
    "imu: {file: imu.csv, epoch: 2025/08/28 17:30:39.000 GPST}\naids:\n  gnss: {file: walk.pos, velocity: 5 cm/s, position: ";

TEST_F(SceneLogs, RtklibsSolutionOnTheImusClock) {
  (void)file("imu.csv", kImuCsv);
  (void)file("walk.pos", kPos);
  const auto found = data(kWalk + "file}\n");
  const auto& r = found.recording;
  EXPECT_EQ(r.imu.stamps[1] - r.origin, 0);  // the scene's time is the IMU's own
  ASSERT_EQ(r.fixes[1].size(), 2U);          // in the order of the scene
  EXPECT_EQ(r.fixes[1][0].stamp - r.origin, kSecond / 2);
  EXPECT_EQ(*r.fixes[1][0].sigma, Vector3d(.03, .02, .04));
  EXPECT_EQ(*r.fixes[1][1].sigma, Vector3d(3, 2, 4));
  EXPECT_EQ(r.fixes[0][0].value, Vector3d(1, 2, -3));
  EXPECT_THAT(found.notes, Contains("gnss.position: its quality is 1 in 1 rows and 5 in 1 rows"));
  EXPECT_EQ(data(kWalk + "1 m, quality: 1}\n").recording.fixes[0].size(), 1U);
  EXPECT_EQ(data(kWalk + "1 m, quality: [1, 5]}\n").recording.fixes[0].size(), 2U);
}

TEST_F(SceneLogs, ClocksThatAreNotOneAreRefused) {
  (void)file("imu.csv", kImuCsv);
  (void)file("walk.pos", kPos);
  EXPECT_THAT(
      message("imu: {file: imu.csv}\naids:\n  gnss: {file: walk.pos, position: 1 m}\n"),
      HasSubstr(
          "begin at 2025-08-28 17:30:39.500 GPST and the IMU's samples at 0.000 s, expected one clock; say in the scene which instant is 0 on the IMU's clock, as in imu: {epoch: 2025-08-28 17:30:39.000 GPST}"));
  EXPECT_THAT(
      message("imu: {file: imu.csv, epoch: 2025-08-28 17:30:21 UTC}\naids:\n  gnss: {file: walk.pos, position: 1 m}\n"),
      HasSubstr("its stamps are GPST and the IMU's \"epoch:\" is UTC"));
  EXPECT_THAT(message("imu: {file: imu.csv, epoch: yesterday}\n"), HasSubstr("expected a date and a time of day"));
  (void)file("late.csv", "time (s),height (m)\n0,1\n1,2\n");
  EXPECT_THAT(message(kWalk + "1 m}\n  baro: {file: late.csv, height: 1 m}\n"),
              HasSubstr("put the fixes on the IMU's"));
  const auto found =
      data("imu: {file: imu.csv, epoch: 2006-01-12 17:30:39}\naids:\n  gnss: {file: walk.pos, position: 1 m}\n");
  EXPECT_THAT(all(found.notes), HasSubstr("do not overlap: they are 1 times 1024 weeks apart"));
}

TEST_F(SceneLogs, GpstBesideAClockOfAnUnknownScaleIsSaid) {
  (void)file("imu.csv",
             "time (ns),gyro_x (rad/s),gyro_y (rad/s),gyro_z (rad/s),accel_x (g),accel_y (g),accel_z (g)\n"
             "1756402239000000000,0,0,0,0,0,-1\n1756402240000000000,0,0,0,0,0,-1\n");
  (void)file("walk.pos", kPos);
  EXPECT_THAT(all(data("imu: {file: imu.csv}\naids:\n  gnss: {file: walk.pos, position: 1 m}\n").notes),
              HasSubstr("time_tag: -18 s"));
}

TEST_F(SceneLogs, RtklibsEarthFixedAndBaselineSolutionsAreTheSamePlace) {
  (void)file("imu.csv", kImuCsv);
  const earth::Geodetic base{40.1 * kDegree, -105.15 * kDegree, 1600};
  const Eigen::Matrix3d C_enu = earth::C_e_enu(base.latitude, base.longitude);
  const Vector3d away(10, 20, 3), p = earth::to_ecef(base) + C_enu * away, v = C_enu * Vector3d(2, 1, 3);
  // Sigmas of 1, 2 and 3 m east, north, up, seen along x, y, z.
  const Eigen::Matrix3d P = C_enu * Vector3d(1, 4, 9).asDiagonal() * C_enu.transpose();
  const auto root = [](double c) { return c < 0 ? -std::sqrt(-c) : std::sqrt(c); };
  (void)file(
      "walk.pos",
      "%  GPST x-ecef(m) y-ecef(m) z-ecef(m) Q ns sdx(m) sdy(m) sdz(m) sdxy(m) sdyz(m) sdzx(m) age(s) ratio vx(m/s) vy(m/s) vz(m/s)\n" +
          fmt::format(
              "2025/08/28 17:30:39.500 {:.9f} {:.9f} {:.9f} 1 18 {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} 0 9 {:.9f} {:.9f} {:.9f}\n",
              p[0], p[1], p[2], root(P(0, 0)), root(P(1, 1)), root(P(2, 2)), root(P(0, 1)), root(P(1, 2)),
              root(P(0, 2)), v[0], v[1], v[2]));
  const auto ecef = data(kWalk + "file}\n").recording.fixes;
  EXPECT_LT((ecef[1][0].value - p).norm(), kMicron);
  EXPECT_LT((*ecef[1][0].sigma - Vector3d(1, 2, 3)).norm(), 1e-4);  // axes of two places 22 m apart: 4e-6 rad
  EXPECT_LT((ecef[0][0].value - Vector3d(1, 2, -3)).norm(), 1e-4);
  const std::string rows =
      "%  GPST e-baseline(m) n-baseline(m) u-baseline(m) Q ns\n2025/08/28 17:30:39.500 10 20 3 1 9\n";
  const std::string scene =
      "imu: {file: imu.csv, epoch: 2025/08/28 17:30:39.000 GPST}\naids:\n  gnss: {file: walk.pos, position: 1 m}\n";
  (void)file("walk.pos", "% ref pos   :  40.1 -105.15  1600.0\n" + rows);
  EXPECT_LT((data(scene).recording.fixes[0][0].value - p).norm(), kMicron);
  (void)file("walk.pos", rows);
  EXPECT_THAT(message(scene), HasSubstr("has positions from a base and not where that is"));
}

TEST_F(SceneLogs, NmeaHasTheReceiversGeoidAndNoVerticalVelocity) {
  (void)file("imu.csv", kImuCsv);
  (void)file("walk.nmea",
             "$GPRMC,173039.50,A,4006.00,N,10509.00,W,7.2,90.0,280825,,,A*70\r\n"
             "$GPGGA,173039.50,4006.00,N,10509.00,W,1,12,0.8,1617.4,M,-16.9,M,,*66\r\n");
  const std::string scene = "imu: {file: imu.csv, epoch: 2025-08-28 17:30:39 UTC}\naids:\n  gnss: {file: walk.nmea, ";
  const auto found = data(scene + "position: 3 m}\n");
  ASSERT_EQ(found.recording.fixes[0].size(), 1U);
  EXPECT_LT((found.recording.fixes[0][0].value - earth::to_ecef({40.1 * kDegree, -105.15 * kDegree, 1600.5})).norm(),
            kMicron);
  EXPECT_THAT(all(found.notes), HasSubstr("lies -16.9 to -16.9 m over the ellipsoid, as the receiver says"));
  EXPECT_THAT(message(scene + "velocity: 1 m/s}\n"), HasSubstr("no vertical velocity"));
}

TEST_F(SceneLogs, ErrorsOfTheFileHaveToBeThere) {
  (void)file("imu.csv", kImuCsv);
  (void)file("gnss.csv", "time (s),latitude (deg),longitude (deg),height (m),acc (m)\n0,1,2,3,0.5\n");
  const std::string scene = "imu: {file: imu.csv}\naids:\n  gnss: {file: gnss.csv, position: file";
  EXPECT_THAT(message(scene + "}\n"),
              HasSubstr("no column with it; name it, as in columns: {position_sigma: accuracy}"));
  EXPECT_EQ(*data(scene + ", columns: {position_sigma: acc}}\n").recording.fixes[0][0].sigma, Vector3d::Constant(.5));
  EXPECT_THAT(message(scene + ", quality: 1}\n"), HasSubstr("asks for a column \"quality\""));
  EXPECT_THAT(message("imu: {file: imu.csv}\naids:\n  gnss: {file: gnss.csv, attitude: file}\n"),
              HasSubstr("found sigma: file, expected numbers: only positions"));
  EXPECT_THAT(message_of<InputError>([&] {
                (void)files::read_scene(
                    file("plan.yaml", "trajectory: ascent\naids:\n  gnss: {file: gnss.csv, position: file}\n"));
              }),
              HasSubstr("where nothing was recorded there is no file"));
}

// --- Real recordings -------------------------------------------------------------------------------------------------

TEST_F(SceneLogs, RealRecordingsHaveImuAndFixesOnOneClock) {
  const std::string logs = std::string(GYROBUDGET_DATA) + "/logs/";
  if (!std::filesystem::exists(logs)) GTEST_SKIP() << "no public recordings in " << logs << "; set GYROBUDGET_DATA";
  const auto scene = [&](const std::string& log, const std::string& imu, const std::string& gnss) {
    return data(fmt::format("imu: {{file: {0}{1}, topic: '{2}'}}\naids:\n  gnss: {{file: {0}{1}, position: {3}}}\n",
                            logs, log, imu, gnss));
  };
  // Of README's counts: 1298 rows of sensor_combined; receivers at 5 Hz beside them, all of them with a fix.
  const auto px4 = scene("ulog/cube_small.ulg", "sensor_combined", "file, velocity: file").recording;
  EXPECT_GE(px4.imu.increments.size(), 1298U);
  ASSERT_EQ(px4.fixes[0].size(), 32U);
  EXPECT_GT(px4.fixes[0].front().stamp, px4.imu.stamps.front());
  EXPECT_LT(px4.fixes[0].back().stamp, px4.imu.stamps.back() + 1'000'000'000);
  const earth::Geodetic trondheim = earth::to_geodetic(px4.fixes[0].front().value);
  EXPECT_NEAR(trondheim.latitude, 63.41705 * kDegree, 1e-4 * kDegree);
  constexpr double kMean = 104.328, kSigma = 5.96;  // of alt_ellipsoid, which is 40 m over alt; of epv [m]
  EXPECT_NEAR(trondheim.height, kMean, kSigma);
  const auto sitl =
      scene("ardupilot/copter_444_sitl.bin", "IMU[0]", "file, velocity: file, geoid_separation: 0 m").recording;
  EXPECT_EQ(sitl.fixes[0].size(), 125U);
  EXPECT_LT(sitl.fixes[1].front().value.norm(), 1);
  EXPECT_THAT(message(fmt::format(
                  "imu: {{file: {}ros1/razor_lz4.bag}}\naids:\n  gnss: {{file: {}ros1/razor_lz4.bag, position: 1 m}}\n",
                  logs, logs)),
              HasSubstr("holds no GNSS receiver that can be read; it has"));
}

}  // namespace
}  // namespace gyrobudget::app_tests

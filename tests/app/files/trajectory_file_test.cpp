// SPDX-License-Identifier: MIT
#include "gyrobudget/app/files/trajectory_file.h"

#include "gyrobudget/vehicle/earth/paths.h"

#include <cmath>
#include <stdexcept>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using earth::kDegree;
using earth::Trajectory;
using text::InputError;

constexpr double kSamePosition = 4e-9;   // m: two roundings of 0.9 nm each, over three axes
constexpr double kSameAttitude = 4e-15;  // of a unit quaternion, through its digits and a product

class TrajectoryFile : public TemporaryFolder {
 protected:
  [[nodiscard]] Trajectory read(std::string_view text) const { return files::read_trajectory(file("truth.csv", text)); }
  [[nodiscard]] std::string message(std::string_view text) const {
    return message_of<InputError>([&] { (void)read(text); });
  }
};

void expect_same(const Trajectory& found, const Trajectory& expected) {
  EXPECT_DOUBLE_EQ(found.duration(), expected.duration());
  for (const double part : {0., 0.3, 0.77, 1.}) {
    const auto a = found.at(part * found.duration()), b = expected.at(part * expected.duration());
    EXPECT_LT((a.pose.p_eb_e - b.pose.p_eb_e).norm(), kSamePosition) << part;
    EXPECT_LT((a.pose.v_eb_e - b.pose.v_eb_e).norm(), kSamePosition) << part;
    EXPECT_LT(1 - std::abs(a.pose.q_eb.dot(b.pose.q_eb)), kSameAttitude) << part;
  }
}

std::string usage_error(const std::string& spec) {
  return message_of<std::invalid_argument>([&] { (void)files::read_trajectory(spec); });
}

// --- By name -----------------------------------------------------------------------------------------------

TEST_F(TrajectoryFile, NamesAreThePathsWithTheirDefaults) {
  expect_same(files::read_trajectory("static"), earth::stand({}));
  expect_same(files::read_trajectory("cruise"), earth::cruise({}));
  expect_same(files::read_trajectory("climb:"), earth::climb({}));
  expect_same(files::read_trajectory(" ascent "), earth::ascent({}));
}

TEST_F(TrajectoryFile, OptionsReachTheirPlaces) {
  expect_same(
      files::read_trajectory(
          "cruise:speed=900 km/h, duration=600,azimuth=30,turn_acceleration=0.5g,turn_period=40,height=3000,coning_angle=1,coning_frequency=5,sculling_angle=0.1 deg,sculling_acceleration=2,sculling_frequency=7Hz"),
      earth::cruise({.start = {earth::alcantara().position.latitude, earth::alcantara().position.longitude, 3000},
                     .azimuth = 30 * kDegree,
                     .speed = 250,
                     .turn_acceleration = 0.5 * 9.80665,
                     .turn_period = 40,
                     .vibration = {.coning_angle = kDegree,
                                   .coning_frequency = 5,
                                   .sculling_angle = 0.1 * kDegree,
                                   .sculling_acceleration = 2,
                                   .sculling_frequency = 7},
                     .duration = 600}));
  expect_same(
      files::read_trajectory(
          "static:latitude=45,longitude=0.1rad,height=1km,yaw=10,pitch=20,roll=30,spin_x=1,spin_y=2,spin_z=3,duration=2min"),
      earth::stand({.position = {45 * kDegree, 0.1, 1000},
                    .q_nb = earth::from_euler({10 * kDegree, 20 * kDegree, 30 * kDegree}),
                    .spin = Eigen::Vector3d(1, 2, 3) * kDegree,
                    .duration = 120}));
  expect_same(files::read_trajectory("climb:azimuth=0,acceleration=20,duration=10"),
              earth::climb({.azimuth = 0, .acceleration = 20, .duration = 10}));
  expect_same(files::read_trajectory(
                  "ascent:azimuth=10,pitch_over_at=5,pitch_end=40,force_start=14,force_end=20,tail_off=3,duration=60"),
              earth::ascent({.azimuth = 10 * kDegree,
                             .pitch_over_at = 5,
                             .pitch_end = 40 * kDegree,
                             .force_start = 14,
                             .force_end = 20,
                             .tail_off = 3,
                             .duration = 60}));
}

TEST_F(TrajectoryFile, SiteSetsThePlaceAndLaterKeysChangeIt) {
  const auto& site = earth::alcantara().position;
  expect_same(files::read_trajectory("static:latitude=50,site=alcantara"), earth::stand({}));
  expect_same(files::read_trajectory("static:site=alcantara,height=100"),
              earth::stand({.position = {site.latitude, site.longitude, 100}}));
  expect_same(files::read_trajectory("cruise:latitude=50,site=alcantara"), earth::cruise({}));
}

TEST_F(TrajectoryFile, WrongOptionsAreNamed) {
  EXPECT_CONTAINS(usage_error("cruise:sped=250"), "did you mean 'speed'?");
  EXPECT_CONTAINS(usage_error("cruise:spin_x=2"), "there are site, latitude");
  EXPECT_CONTAINS(usage_error("cruise:speed"), "expected speed=");
  EXPECT_CONTAINS(usage_error("cruise:speed=fast"), "a plain number is in m/s");
  EXPECT_CONTAINS(usage_error("cruise:speed=3 kg"), "speed");
  EXPECT_CONTAINS(usage_error("ascent:site=woomera"), "alcantara");
  EXPECT_CONTAINS(usage_error("static:duration=-1"), "duration");
  const std::string unknown = message_of<InputError>([] { (void)files::read_trajectory("asent:duration=3"); });
  EXPECT_CONTAINS(unknown, "did you mean 'ascent'?");
  EXPECT_CONTAINS(unknown, "static, cruise, climb and ascent");
}

TEST_F(TrajectoryFile, HelpNamesEveryKey) {
  const std::string help = files::trajectory_names();
  for (const char* word : {"static: site", "spin_z", "turn_period", "acceleration", "tail_off"}) {
    EXPECT_CONTAINS(help, word);
  }
}

// --- Files -------------------------------------------------------------------------------------------------

TEST_F(TrajectoryFile, WrittenTruthComesBack) {
  const Trajectory turns = earth::cruise({.turn_acceleration = 5, .turn_period = 30, .duration = 20});
  for (const auto form : {files::AttitudeForm::quaternion, files::AttitudeForm::euler}) {
    const std::string name = path("turns.csv.gz");
    files::write_trajectory(name, turns, {.rate_hz = 10, .attitude = form, .comment = "a comment"});
    const Trajectory read = files::read_trajectory(name);
    EXPECT_EQ(read.duration(), 20);
    for (int k = 0; k <= 200; ++k) {
      const auto a = read.at(0.1 * k), b = turns.at(0.1 * k);
      ASSERT_LT((a.pose.p_eb_e - b.pose.p_eb_e).norm(), kSamePosition) << k;
      ASSERT_LT(1 - std::abs(a.pose.q_eb.dot(b.pose.q_eb)), kSameAttitude) << k;
    }
  }
}

TEST_F(TrajectoryFile, VelocityIsAgainstEarthInNorthEastDown) {
  files::write_trajectory(path("climb.csv"), earth::climb({.acceleration = 10, .duration = 4.9}),
                          {.rate_hz = 1, .duration = 4.1});
  const std::string text = content(path("climb.csv"));
  EXPECT_EQ(
      text.substr(0, text.find('\n')),
      "time (s),latitude (deg),longitude (deg),height (m),velocity_north (m/s),velocity_east (m/s),velocity_down (m/s),q_w (1),q_x (1),q_y (1),q_z (1)");
  const std::string row = text.substr(text.find("\n3,"));
  EXPECT_CONTAINS(row.substr(0, row.find('\n', 1)), ",-30");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 6);
}

constexpr const char* kRows =
    "0,10,20,100,90,90,0\n1,10,20,110,90,90,0\n2,10,20,120,90,90,0\n3,10,20,130,90,90,0\n4,10,20,140,90,90,0\n";

TEST_F(TrajectoryFile, FilesOfOthers) {
  const std::string head = "t (s),lat (deg),lon (deg),altitude (m),heading (deg),pitch (deg),roll (deg)\n";
  const auto here = read(head + kRows).at(2);
  EXPECT_LT((here.pose.p_eb_e - to_ecef(earth::Geodetic::from_degrees(10, 20, 120))).norm(), kSamePosition);
  // Any order and unit, other columns, blanks as delimiters, nanoseconds of an epoch, a rounded quaternion.
  const auto other = read(
      "timestamp [ns]; q_x; q_y; q_z; q_w; height (km); temperature; longitude (rad); latitude (deg)\n"
      "1700000000000000000; 0; 0.7071; 0; 0.7071; 0.1; hot; 0; 10\n"
      "1700000001000000000; 0; 0.7071; 0; 0.7071; 0.2; hot; 0; 10\n"
      "1700000002000000001; 0; 0.7071; 0; 0.7071; 0.3; hot; 0; 10\n"
      "1700000003000000000; 0; -0.7071; 0; -0.7071; 0.4; hot; 0; 10\n");
  EXPECT_EQ(other.duration(), 3);
  EXPECT_LT((other.at(1).pose.p_eb_e - to_ecef(earth::Geodetic::from_degrees(10, 0, 200))).norm(), 1e-6);
}

TEST_F(TrajectoryFile, WhatIsWrongIsSaidWithItsLine) {
  const std::string head = "time (s),latitude (deg),longitude (deg),height (m),yaw (deg),pitch (deg),roll (deg)\n";
  EXPECT_CONTAINS(message("time (s),latitude (deg),height (m)\n0,1,2\n1,1,2\n"), "no column 'longitude'");
  EXPECT_CONTAINS(
      message("time (s),latitude,longitude (deg),height (m),yaw (deg),pitch (deg),roll (deg)\n" + std::string(kRows)),
      ":1:10: column 'latitude' has no unit");
  EXPECT_CONTAINS(message(head + kRows + "3.5,10,20,150,90,90,0\n"), ":7:1: found a time that is not after");
  EXPECT_CONTAINS(message(head + kRows + "5,10,,150,90,90,0\n"), ":7:1: column 'longitude' has no number");
  EXPECT_CONTAINS(message(head + kRows + "5,100,0,150,90,90,0\n"), "latitude of 100 deg");
  EXPECT_CONTAINS(message(head + kRows + "5,10,0,1e300,90,90,0\n"), ":7:1: found a height of 1e+300 m");
  EXPECT_CONTAINS(message(head + "0,10,20,100,0,0,0\n1,10,20,100,0,0,0\n"), "4");
  EXPECT_CONTAINS(message("time (s),latitude (deg),longitude (deg),height (m),q_w,q_x,q_y,q_z\n0,10,20,100,2,0,0,0\n"
                          "1,10,20,100,1,0,0,0\n"),
                  "quaternion of length 2");
}

}  // namespace
}  // namespace gyrobudget::app_tests

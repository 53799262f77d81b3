// SPDX-License-Identifier: MIT
#include "gyrobudget/app/files/scene_file.h"

#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/site.h"

#include <cmath>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using earth::kDegree;
using navigation::Aid;
using navigation::FromAid;
using text::InputError;

const std::string kStart =
    "alignment: {position_sigma: 1 m, velocity_sigma: 1 cm/s, attitude: {heading: 0 deg}, level_sigma: 1 deg, heading_sigma: 1 deg}\n";
const std::string kHead = "site: alcantara\nimu: {file: imu.csv}\n" + kStart;

class SceneFile : public TemporaryFolder {
 protected:
  [[nodiscard]] files::SceneFile read(std::string_view text) const {
    return files::read_scene(file("scene.yaml", text));
  }
  [[nodiscard]] std::string message(std::string_view text) const {
    return message_of<InputError>([&] { (void)read(text); });
  }
  [[nodiscard]] files::SceneData data(std::string_view text) const { return files::read_recording(read(text)); }
};

TEST_F(SceneFile, AnotherSensorKeepsTheScenesEpoch) {
  (void)file("a.yaml", "gyro:\n  rrw: 1 deg/h/sqrt(h)\n");
  const auto other = file("b.yaml", "gyro:\n  rrw: 2 deg/h/sqrt(h)\n  powered_on_before: 3 s\naccelerometer:\n");
  files::SceneFile scene = read("trajectory: ascent\nsensor: {file: a.yaml, powered_on_before: 10 min}\n");
  const double walk = scene.scenario.sensor.gyro.rate_random_walk[0];
  files::change_sensor(scene, other);
  EXPECT_EQ(scene.sensor, other);
  EXPECT_DOUBLE_EQ(scene.scenario.sensor.gyro.rate_random_walk[0], 2 * walk);
  EXPECT_EQ(scene.scenario.sensor.gyro.powered_on_before, 600);
  EXPECT_EQ(scene.scenario.sensor.accelerometer.value().powered_on_before, 600);
}

TEST_F(SceneFile, TheHelpIsASceneThatReads) {
  (void)file("mems.yaml", "gyro:\n  arw: 0.1 deg/sqrt(h)\n");
  (void)file("vlm1.yaml", files::vehicle_help());
  const files::SceneFile scene = read(files::scene_help());
  const auto& s = scene.scenario;
  EXPECT_EQ(s.name, "delivery drone, GNSS outage");
  ASSERT_TRUE(s.site);
  EXPECT_DOUBLE_EQ(s.site->latitude, earth::alcantara().position.latitude);
  EXPECT_DOUBLE_EQ(*s.sensor.gyro.powered_on_before, 600);
  EXPECT_DOUBLE_EQ(*s.sensor.gyro.calibrated_over, 60);
  EXPECT_EQ(s.states.flicker_states, 2);
  EXPECT_EQ(s.states.misalignment, navigation::Use::considered);
  ASSERT_EQ(s.aids.size(), 3U);
  const Aid& gnss = s.aids[0];
  EXPECT_EQ(gnss.name, "gnss.position");
  EXPECT_EQ(gnss.sigma, Eigen::Vector3d(2, 2, 4));
  EXPECT_EQ(gnss.lever_arm, Eigen::Vector3d(0.2, 0, -1));
  EXPECT_DOUBLE_EQ(gnss.time_tag, -0.02);
  EXPECT_DOUBLE_EQ(gnss.time_tag_sigma, 0.005);
  EXPECT_DOUBLE_EQ(gnss.correlation_time, 300);
  EXPECT_EQ(gnss.outages.size(), 1U);
  EXPECT_DOUBLE_EQ(gnss.valid.to, 600);
  EXPECT_EQ(s.aids[1].kind, Aid::Kind::velocity);
  EXPECT_DOUBLE_EQ(s.aids[1].sigma[2], 0.05);
  EXPECT_EQ(s.aids[2].kind, Aid::Kind::rest);
  EXPECT_DOUBLE_EQ(s.filter.gate_false_alarm, 1e-6);
  EXPECT_DOUBLE_EQ(s.solution_interval, 0.1);
  EXPECT_EQ(s.reference, (std::vector<std::size_t>{0, 1}));
  ASSERT_TRUE(scene.imu);
  EXPECT_EQ(scene.imu->path, path("imu.csv"));
  EXPECT_EQ(scene.imu->axis, (std::array<int, 3>{1, 0, 2}));
  EXPECT_EQ(scene.imu->sign, (std::array<int, 3>{1, 1, -1}));
  EXPECT_EQ(scene.aids[0].path, path("gnss.csv"));
  EXPECT_EQ(scene.aids[2].path, "");
}

TEST_F(SceneFile, TheExamplesRead) {
  int scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(GYROBUDGET_EXAMPLES "/scenes")) {
    if (entry.path().extension() != ".yaml") continue;
    const files::SceneFile scene = files::read_scene(entry.path().string());
    EXPECT_FALSE(scene.scenario.name.empty()) << entry.path();
    EXPECT_EQ(scene.sensor.empty(), entry.path().stem() == "vlm1-ideal") << entry.path();
    ++scenes;
  }
  EXPECT_GE(scenes, 9);
}

TEST_F(SceneFile, DataMayLieElsewhere) {
  const std::string scene = file("scene.yaml", kHead);
  EXPECT_EQ(files::read_scene(scene, "/data").imu->path, "/data/imu.csv");
  EXPECT_EQ(
      files::read_scene(file("other.yaml", "site: alcantara\nimu: {file: /a/b.csv}\n" + kStart), "/data").imu->path,
      "/a/b.csv");
}

TEST_F(SceneFile, ATrajectoryNeedsNoAlignment) {
  EXPECT_EQ(read("trajectory: ascent:duration=50\n").trajectory, "ascent:duration=50");
  EXPECT_EQ(read("trajectory: fly.csv\n").trajectory, path("fly.csv"));
  EXPECT_CONTAINS(message("trajectory: ascent:durations=50\n"), "scene.yaml:1:13: ");
}

TEST_F(SceneFile, WhatIsWrongHasItsPlaceAndAMend) {
  EXPECT_CONTAINS(message("imuu: {file: a.csv}\n"),
                  "scene.yaml:1:1: 'imuu' is no key of a scene (did you mean 'imu'?)");
  EXPECT_CONTAINS(message("name: x\n"), "found none of \"imu:\", \"trajectory:\" and \"flight:\"");
  EXPECT_CONTAINS(message("imu: {file: a.csv}\n"), "found no \"alignment:\"");
  EXPECT_CONTAINS(message("imu: {file: a.csv}\n" + kStart), "found no site");
  EXPECT_CONTAINS(message("site: alcantra\n"), "scene.yaml:1:7: site: found 'alcantra' (did you mean 'alcantara'?)");
  EXPECT_CONTAINS(message("site: {latitude: 91 deg, longitude: 0 deg, height: 0 m}\n"), "expected -90 to 90 deg");
  EXPECT_CONTAINS(message("site: {latitude: 9 deg, height: 0 m}\n"), "expected latitude, longitude and height");
  EXPECT_CONTAINS(message(kHead + "until: 20\n"), "scene.yaml:4:8: until: ");
  EXPECT_CONTAINS(message(kHead + "until: 20 m\n"), "scene.yaml:4:8: until: ");
  EXPECT_CONTAINS(message(kHead + "until: 20 s\nuntil: 30 s\n"), "is given twice");
  for (const char* name : {"../gps", "a/b", "/gps", ".gps", "\"\"", "\"a\\nb\"", "\"a\\u0007\""})
    EXPECT_CONTAINS(message(kHead + "aids: {" + name + ": {position: 3 m}}\n"), "expected one that a file can have");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {file: g.csv}}\n"), "aids.gps: found nothing that it measures");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {file: g.csv, position: {bias_sigma: 1 m}}}\n"), "found no \"sigma:\"");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {position: 3 m/s}}\n"), "sigma: ");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {position: 0 m}}\n"), "expected a value above 0");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {position: [1 m, 2 m]}}\n"),
                  "found a list of 2, expected one value or three");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {position: 3 m, outages: [[3 s]]}}\n"), "expected pairs of times");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {position: 3 m, outages: [[3 s, 2 s]]}}\n"), "before it begins");
  EXPECT_CONTAINS(message(kHead + "aids: {gps: {position: 3 m, columns: {latitud: x}}}\n"),
                  "(did you mean 'latitude'?)");
  EXPECT_CONTAINS(message(kHead + "reference: gps\n"), "is no aid that measures position, velocity or attitude");
  EXPECT_CONTAINS(message(kHead + "filter: {form: josef}\n"), "(did you mean 'joseph'?)");
  EXPECT_CONTAINS(message(kHead + "filter: {gate: 2}\n"), "expected a share from 0 to below 1");
  EXPECT_CONTAINS(message(kHead + "filter: {order: 9}\n"), "expected a whole number from 1 to 8");
  EXPECT_CONTAINS(message(kHead + "sensor: nosuch.yaml\n"), "scene.yaml:4:9: sensor: ");
  const std::string imu = "site: alcantara\nimu: {file: a.csv, axes: ";
  EXPECT_CONTAINS(message(imu + "[x, y, -z]}\n"), "a mirror");
  EXPECT_CONTAINS(message(imu + "[x, x, z]}\n"), "an axis twice");
  EXPECT_CONTAINS(message(imu + "[x, y]}\n"), "expected the log's axes");
  const std::string align = "site: alcantara\nimu: {file: a.csv}\nalignment: ";
  EXPECT_CONTAINS(message(align + "{attitude: self}\n"), "found no \"position_sigma:\"");
  EXPECT_CONTAINS(message(align + "{position_sigma: 1 m}\n"), "found no \"attitude:\"");
  EXPECT_CONTAINS(message(align + "{attitude: {heading: 0 deg}, duration: 3 s}\n"), "belong to \"attitude: self\"");
  EXPECT_CONTAINS(message(align + "{attitude: self, heading: 3 deg}\n"), "needs its heading_sigma");
  EXPECT_CONTAINS(message(align + "{attitude: ins}\n"), "is no aid that measures attitude");
  EXPECT_CONTAINS(message("a: b: c\n"), "no YAML");
  EXPECT_CONTAINS(message("- 1\n"), "expected keys like");
}

TEST_F(SceneFile, ALogInCountsWithOtherAxes) {
  (void)file("imu.csv", "t;a;b;c;d;e;f\n0,00;1;2;3;0;0;80\n0,01;1;2;3;0;0;80\n0,02;1;2;3;0;0;80\n");
  const auto found = data(
      "site: alcantara\nimu:\n  file: imu.csv\n  axes: [y, x, -z]\n  columns: {time: t (s), gyro_x: a (0.1 arcsec), gyro_y: b (0.1 arcsec), gyro_z: c (0.1 arcsec), accel_x: d (125 ug*s), accel_y: 6 (125 ug*s), accel_z: f (125 ug*s)}\n" +
      kStart);
  const auto& imu = found.recording.imu;
  ASSERT_EQ(imu.increments.size(), 3U);
  const double count = 0.1 / 3600 * kDegree;
  EXPECT_NEAR(imu.increments[1].angle[0], 2 * count, 1e-18);
  EXPECT_NEAR(imu.increments[1].angle[1], 1 * count, 1e-18);
  EXPECT_NEAR(imu.increments[1].angle[2], -3 * count, 1e-18);
  EXPECT_NEAR(imu.increments[1].velocity[2], -80 * 125e-6 * 9.80665, 1e-12);
  EXPECT_EQ(found.recording.origin, 0);
  EXPECT_TRUE(found.notes.empty());
}

TEST_F(SceneFile, RatesFromTheHeaderAndAids) {
  (void)file("imu.csv",
             "time (s),gyro_x (deg/s),gyro_y (deg/s),gyro_z (deg/s),accel_x (g),accel_y (g),accel_z (g)\n"
             "100.0,1,0,0,0,0,-1\n100.1,1,0,0,0,0,-1\n100.2,1,0,0,0,0,-1\n100.5,1,0,0,0,0,-1\n100.6,1,0,0,0,0,-1\n");
  (void)file("ins.csv",
             "t_s,lat,lon,h,vN,vE,vU,yaw,pitch,roll\n100,0.1,0.2,30,1,2,3,0.5,0.1,0\n100.2,0.1,0.2,30,1,2,,0.5,0.1,0\n"
             "100.4,0.1,0.2,31,1,2,3,0.5,0.1,0\n");
  const auto found = data(
      kHead +
      "aids:\n  ins:\n    file: ins.csv\n    columns: {time: t_s (s), latitude: lat (rad), longitude: lon (rad), height: h (m), velocity_north: vN (m/s), velocity_east: vE (m/s), velocity_up: vU (m/s), yaw_ccw: yaw (rad), pitch: pitch (rad), roll: roll (rad)}\n    position: 1 m\n    velocity: 1 m/s\n    attitude: 1 deg\n    height: 1 m\n");
  const auto& r = found.recording;
  EXPECT_EQ(r.origin, 0);  // the clock of a run is kept
  EXPECT_EQ(r.imu.gaps, 1);
  EXPECT_NEAR(r.imu.increments[1].angle[0], 0.1 * kDegree, 1e-15);
  ASSERT_EQ(found.notes.size(), 2U);
  EXPECT_CONTAINS(found.notes[0], "1 gap of 0.2 s");
  EXPECT_CONTAINS(found.notes[1], "ins.velocity: 1 of 3 rows have a number missing");
  ASSERT_EQ(r.fixes.size(), 4U);
  EXPECT_LT((r.fixes[0][0].value - earth::to_ecef({0.1, 0.2, 30})).norm(), 1e-9);
  EXPECT_EQ(r.fixes[1][1].value, Eigen::Vector3d(1, 2, -3));
  EXPECT_NEAR(earth::to_euler(r.fixes[2][0].q_nb).yaw, -0.5, 1e-12);
  EXPECT_DOUBLE_EQ(r.fixes[3][2].value[0], 31);
}

TEST_F(SceneFile, TheClockOfAnEpochCountsFromTheFirstSample) {
  (void)file("imu.csv",
             "time (ns),gyro_x (deg/s),gyro_y (deg/s),gyro_z (deg/s),accel_x (g),accel_y (g),accel_z (g)\n"
             "1403636579758555392,1,0,0,0,0,-1\n1403636579763555392,1,0,0,0,0,-1\n1403636579768555392,1,0,0,0,0,-1\n");
  const auto r = data(kHead).recording;
  EXPECT_EQ(r.origin, 1403636579758555392);
  EXPECT_EQ(r.imu.stamps.front(), 1403636579753555392);
  EXPECT_EQ(r.imu.stamps.back(), 1403636579768555392);
}

TEST_F(SceneFile, LogsThatCannotBeReadSayWhere) {
  const auto complain = [&](const std::string& log) {
    (void)file("imu.csv", log);
    return message_of<InputError>([&] { (void)data(kHead); });
  };
  EXPECT_CONTAINS(complain("time (s),gyro_x (deg/s)\n0,1\n1,1\n"), "found no column 'gyro_y'");
  EXPECT_CONTAINS(complain("time (s),gyro_x (deg/s),gyro_y,gyro_z,accel_x,accel_y,accel_z\n0,1,1,1,1,1,1\n"),
                  "imu.csv:1:25: column 'gyro_y' has no unit");
  EXPECT_CONTAINS(complain("gyro_x (rad),gyro_y (rad),gyro_z (rad),accel_x (g),accel_y (g),accel_z (g)\n1,1,1,1,1,1\n"),
                  "found no column 'time'");
  const std::string head = "time (s),gyro_x (rad),gyro_y (rad),gyro_z (rad),accel_x (g),accel_y (g),accel_z (g)\n";
  EXPECT_CONTAINS(complain(head + "0,1,1,1,1,1,1\n0,1,1,1,1,1,1\n"), "imu.csv:3:1: found a time that is not after");
  EXPECT_CONTAINS(complain(head + "0,1,1,1,1,1,1\n"), "expected 2 or more IMU samples");
  EXPECT_CONTAINS(message_of<InputError>([&] { (void)data("trajectory: ascent\n"); }), "has no \"imu:\"");
}

}  // namespace
}  // namespace gyrobudget::app_tests

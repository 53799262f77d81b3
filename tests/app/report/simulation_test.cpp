// SPDX-License-Identifier: MIT
#include "gyrobudget/app/report/simulation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace gyrobudget::report {
namespace {

using testing::HasSubstr;

noise::SensorModel sensor() {
  noise::SensorModel model{.gyro = {.quantization = 1e-6, .white = 1e-4}};
  model.accelerometer = noise::ErrorModel{.white = 1e-3};
  return model;
}

std::vector<std::string> names(const log::LogHead& head) {
  std::vector<std::string> list;
  for (const auto& c : head.columns) list.push_back(c.name + " " + c.unit);
  return list;
}

TEST(SimulatedLog, AtRestSaysHowItWasMade) {
  const noise::Simulation simulation(sensor(), {.rate_hz = 50, .duration_s = 20, .seed = 7, .axes = {2, 0}});
  const log::LogHead head = rest_head(simulation, "MEMS", "spectral", "deg/h", 3, log::Format::csv);
  EXPECT_THAT(names(head), testing::ElementsAre("gyro_z deg/h", "gyro_x deg/h", "accel_z m/s^2", "accel_x m/s^2"));
  EXPECT_EQ(head.rate_hz, 50);
  EXPECT_EQ(head.first_sample, 3U);
  EXPECT_EQ(head.comment,
            "gyrobudget simulate: sensor MEMS, model spectral, seed 7, 50 Hz, 20 s, without the first 3 samples");
  const noise::Simulation endless(sensor(), {.duration_s = std::numeric_limits<double>::infinity()});
  EXPECT_THAT(rest_head(endless, "MEMS", "1", "rad/s", 0, log::Format::csv).comment,
              testing::EndsWith("100 Hz, endless"));
}

TEST(SimulatedLog, OfAnImuHasRowsOfTheIntervalsBeforeThem) {
  const log::LogHead rates = imu_head({.seed = 1, .run = 2}, "MEMS", "ascent", "deg/s", false, 5, log::Format::csv);
  EXPECT_EQ(rates.first_sample, 6U);
  EXPECT_THAT(names(rates), testing::ElementsAre("gyro_x deg/s", "gyro_y deg/s", "gyro_z deg/s", "accel_x m/s^2",
                                                 "accel_y m/s^2", "accel_z m/s^2"));
  EXPECT_THAT(rates.comment, HasSubstr("trajectory ascent, seed 1, run 2, 100 Hz, no vibration; each row is the mean"));
  const auto increments = imu_head({.vibration = 19.6133}, "MEMS", "ascent", "rad", true, 0, log::Format::csv);
  EXPECT_EQ(increments.columns.back().unit, "m/s");
  EXPECT_THAT(increments.comment, HasSubstr("vibration 2.000 g rms; each row is the increment over"));
}

TEST(SimulatedLog, SaysWhatIsSpecial) {
  EXPECT_THAT(left_out_notes({.kind = noise::SimulationModel::Kind::bielas}, sensor(), "3"),
              testing::ElementsAre(HasSubstr("model 3 has no quantization; it is left out")));
  EXPECT_TRUE(left_out_notes({}, sensor(), "spectral").empty());
  noise::SensorModel special = sensor();
  special.accelerometer.reset();
  special.gyro.range = 1e-9;
  special.lever_arm = {1, 0, 0};
  noise::Imu imu(special, 0.01, {});
  (void)imu.next({});
  const auto notes = imu_notes(special, imu);
  ASSERT_EQ(notes.size(), 3U);
  EXPECT_THAT(notes[0], HasSubstr("gyro out of range in 1, 1 and 1 samples"));
  EXPECT_THAT(notes[1], HasSubstr("lever_arm"));
  EXPECT_THAT(notes[2], HasSubstr("no accelerometer"));
}

TEST(SimulatedLog, InBinaryNeedsWordsToBeRead) {
  log::LogHead head{{{"gyro_x", "deg/s"}, {"gyro_y", "deg/s"}}, 100, "", 0, log::Format::f64};
  EXPECT_EQ(
      how_to_read(head),
      "each sample is gyro_x (deg/s), gyro_y (deg/s); read it with --format f64 --rate 100 --unit deg/s --columns 2");
  head.format = log::Format::npy;
  EXPECT_THAT(how_to_read(head), testing::EndsWith("--format npy --rate 100 --unit deg/s"));
}

}  // namespace
}  // namespace gyrobudget::report

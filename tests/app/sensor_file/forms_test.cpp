// SPDX-License-Identifier: MIT
// The forms of other tools, each taken back to N and K by the formula of its tool.
#include "gyrobudget/app/sensor_file/forms.h"

#include "gyrobudget/app/sensor_file/minimum.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <numbers>
#include <regex>
#include <stdexcept>
#include <string>
#include <vector>

namespace gyrobudget::sensor_file {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kRate = 200, kDegree = std::numbers::pi / 180, kNineDigits = 1e-8;
constexpr double kN = 2e-4, kK = 3e-6, kNa = 5e-3, kKa = 7e-5;  // SI; of the axes x and y half of it

noise::SensorModel sensor() {
  noise::SensorModel model;
  model.gyro.white = noise::PerAxis(kN / 2, kN / 2, kN);
  model.gyro.rate_random_walk = noise::PerAxis(kK / 2, kK / 2, kK);
  model.gyro.bias_instability = 1e-5;
  model.accelerometer.emplace();
  model.accelerometer->white = kNa;
  model.accelerometer->rate_random_walk = kKa;
  return model;
}

std::string written(const std::string& form, const noise::SensorModel& model = sensor()) {
  return form_text(form, model, {.update_rate_hz = kRate, .comment = "made by a test"});
}

/// The numbers behind a key, wherever the form has them.
std::vector<double> numbers(const std::string& text, const std::string& key) {
  std::smatch line;
  const std::regex wanted("(?:^|\n)[ <]*(?:params->|imu\\.|param set )?" +
                          std::regex_replace(key, std::regex("\\."), "\\.") +
                          "[ >:=]+(?:gtsam::Vector3\\(|\\[)?([^\\]\\)<\n]*)");
  if (!std::regex_search(text, line, wanted)) return {};
  std::vector<double> list;
  const std::string whole = line[1], row = whole.substr(0, whole.find('#'));
  const std::regex number("[-+0-9.e]+");
  for (std::sregex_iterator at(row.begin(), row.end(), number), end; at != end; ++at)
    list.push_back(std::stod(at->str()));
  return list;
}

struct Number {
  std::string form, key;
  double expected;   ///< of the z axis, or the only one
  double half = -1;  ///< of x, where the form has each axis
};

TEST(Forms, HaveTheNumbersOfTheirTools) {
  const double markov = std::sqrt(4 * 3600 / 2.);
  for (const Number& n :
       std::vector<Number>{{"kalibr", "gyroscope_noise_density", kN},
                           {"kalibr", "accelerometer_random_walk", kKa},
                           {"openvins", "gyroscope_noise_density", kN},
                           {"openvins", "gyroscope_random_walk", kK},
                           {"vins", "gyr_n", kN * std::sqrt(kRate)},
                           {"vins", "acc_w", kKa * std::sqrt(kRate)},
                           {"orb_slam3", "IMU.NoiseGyro", kN},
                           {"orb_slam3", "IMU.AccWalk", kKa},
                           {"orb_slam3", "IMU.Frequency", kRate},
                           {"gtsam", "gyroscopeCovariance", kN * kN, kN * kN / 4},
                           {"gtsam", "biasAccCovariance", kKa * kKa, kKa * kKa},
                           {"px4_sitl", "gyroscopeNoiseDensity", kN},
                           {"px4_sitl", "accelerometerRandomWalk", kKa},
                           {"kf_gins", "arw", kN / kDegree * 60, kN / kDegree * 30},
                           {"kf_gins", "vrw", kNa * 60, kNa * 60},
                           {"kf_gins", "gbstd", kK * markov / kDegree * 3600, kK * markov / kDegree * 1800},
                           {"kf_gins", "abstd", kKa * markov * 1e5, kKa * markov * 1e5},
                           {"kf_gins", "corrtime", 4},
                           {"navego", "arw", kN, kN / 2},
                           {"navego", "vrrw", kKa, kKa},
                           {"px4_ekf2", "EKF2_GYR_NOISE", kN * 10},  // at 100 Hz
                           {"px4_ekf2", "EKF2_ACC_NOISE", kNa * 10},
                           {"px4_ekf2", "EKF2_GYR_B_NOISE", kK * 10},
                           {"px4_ekf2", "EKF2_ACC_B_NOISE", kKa * 10},
                           {"pyins", "gyro\\[\"noise\"\\]", kN, kN / 2},
                           {"pyins", "gyro\\[\"bias_walk\"\\]", kK, kK / 2},
                           {"pyins", "accel\\[\"bias_walk\"\\]", kKa, kKa},
                           {"matlab", "Gyroscope.NoiseDensity", kN, kN / 2},
                           {"matlab", "Gyroscope.BiasInstability", 1e-5, 1e-5},
                           {"matlab", "Accelerometer.RandomWalk", kKa, kKa}}) {
    const auto found = numbers(written(n.form), n.key);
    ASSERT_EQ(found.size(), n.half < 0 ? 1U : 3U) << n.form << ' ' << n.key << '\n' << written(n.form);
    EXPECT_NEAR(found.back() / n.expected, 1, kNineDigits) << n.form << ' ' << n.key;
    if (n.half >= 0) {
      EXPECT_NEAR(found.front() / n.half, 1, kNineDigits) << n.form << ' ' << n.key;
    }
  }
}

TEST(Forms, NeverHaveAWalkOfZero) {
  noise::SensorModel model = sensor();
  model.gyro.rate_random_walk = 0;
  model.accelerometer->rate_random_walk = 0;  // and nothing that it could stand for
  for (const std::string& form : form_names()) {
    SCOPED_TRACE(form);
    const std::string text = written(form, model);
    EXPECT_THAT(text, HasSubstr("fill it in"));
    EXPECT_THAT(text, HasSubstr("made by a test"));
    EXPECT_FALSE(std::regex_search(text, std::regex("[Ww]alk[^\n]*[:=>(\\[] ?0[ ,;\\])<\n]"))) << text;
  }
  const double stands = walk_of_flicker(1e-5, 100);
  EXPECT_NEAR(numbers(written("vins", model), "gyr_w").at(0) / (stands * std::sqrt(kRate)), 1, kNineDigits);
  EXPECT_THAT(written("vins", model), HasSubstr("stands for the bias instability"));
  EXPECT_THAT(written("matlab", model), Not(HasSubstr("stands for the bias instability")));
}

/// The least of the curve over a fine grid of averaging times, N, B and K by their own formulae.
double least(double n, double b, double k) {
  double most = std::numeric_limits<double>::infinity();
  constexpr int kPerDecade = 2000;
  for (int i = -4 * kPerDecade; i <= 8 * kPerDecade; ++i) {
    const double tau = std::pow(10., static_cast<double>(i) / kPerDecade);
    most = std::min(most, std::sqrt(n * n / tau + 2 * std::log(2.) / std::numbers::pi * b * b + k * k * tau / 3));
  }
  return most;
}

TEST(Minimum, IsThatOfTheCurveAndComesBack) {
  constexpr double kOfGrid = 1e-6;  // half a step of 1.15e-3 from the minimum, which is flat: (5.8e-4)^2 / 4
  for (const double b : {0., 1e-6, 1e-4}) {
    EXPECT_NEAR(curve_minimum(kN, b, kK) / least(kN, b, kK), 1, kOfGrid);
    const double cancelled = kK * kN / (b * b + 1e-300) * 4e-16;  // of the difference of squares
    EXPECT_NEAR(flicker_of_minimum(curve_minimum(kN, b, kK), kN, kK).value(), b, b * (1e-12 + cancelled) + 1e-13);
  }
  EXPECT_NEAR(curve_minimum(kN, 1e-5, 0), 0.664 * 1e-5, 0.001e-5);  // IEEE Std 952's 0.664
  EXPECT_FALSE(flicker_of_minimum(0.9 * curve_minimum(kN, 0, kK), kN, kK));
}

// What its own reader makes of it has the same curve's minimum and the same N.
TEST(Forms, ImuUtilsComesBack) {
  const std::string path = testing::TempDir() + "gyrobudget_imu_utils.yaml";
  std::ofstream(path) << written("imu_utils");
  const noise::SensorModel back = read_sensor(path);
  std::remove(path.c_str());
  const noise::SensorModel model = sensor();
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(back.gyro.white[i] / model.gyro.white[i], 1, kNineDigits);
    EXPECT_NEAR(curve_minimum(0, back.gyro.bias_instability[i], 0) /
                    curve_minimum(model.gyro.white[i], model.gyro.bias_instability[i], model.gyro.rate_random_walk[i]),
                1, kNineDigits);
    EXPECT_NEAR(back.accelerometer->white[i] / kNa, 1, kNineDigits);
  }
}

TEST(Forms, SayWhatTheyHaveNoPlaceFor) {
  EXPECT_THAT(written("gtsam"), HasSubstr("// gyroscope bias instability: "));
  EXPECT_THAT(written("matlab"), Not(HasSubstr("no place in this form")));
}

// XML has no two hyphens inside a comment, and a command line has many.
TEST(Forms, CommentsOfXmlAreLegal) {
  const std::string text = form_text("px4_sitl", sensor(), {.update_rate_hz = kRate, .comment = "tool --rate 3 ---"});
  EXPECT_FALSE(std::regex_search(text, std::regex("<!--[^\n]*--[^>\n]"))) << text;
  EXPECT_THAT(text, HasSubstr("tool - -rate 3"));
}

TEST(Forms, RefuseOtherNamesAndRates) {
  EXPECT_THROW((void)written("kalibre"), std::invalid_argument);
  EXPECT_THROW((void)form_text("vins", sensor(), {.update_rate_hz = 0}), std::invalid_argument);
  EXPECT_THROW((void)form_text("vins", sensor(), {.update_rate_hz = std::numeric_limits<double>::quiet_NaN()}),
               std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::sensor_file

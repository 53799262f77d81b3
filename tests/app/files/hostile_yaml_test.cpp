// SPDX-License-Identifier: MIT
// Every value of every YAML file that is read, in turn, as a word, a list, nothing, keys: it is read, or refused with
// its place; nothing else leaves.
#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/vehicle_file.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"

#include <yaml-cpp/yaml.h>

#include <functional>
#include <regex>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using text::InputError;
using Read = std::function<void(const std::string& path)>;

const std::string kSensor =
    "name: x\nwarning: y\ngyro:\n  arw: [1 deg/sqrt(h), 1 deg/sqrt(h), 2 deg/sqrt(h)]\n"
    "  gauss_markov: [{sigma: 0.1 deg/h, correlation_time: 300 s}]\n"
    "  sinusoid: [{amplitude: 2 deg/h, frequency: 50 mHz, phase: 0 deg}]\n"
    "  filter: {kind: second_order, bandwidth: 100 Hz}\n  range: 400 deg/s\n"
    "  temperature: {reference: 30 degC, linear: 5 deg/h/K}\n  powered_on_before: 1 h\n"
    "accelerometer: {vrw: 1 m/s/sqrt(h)}\nlever_arm: [1 m, 0 m, 0 m]\n";
constexpr const char* kKalibr =
    "imu0:\n  accelerometer_noise_density: 2.0e-3\n  gyroscope_noise_density: 1.7e-4\n  accelerometer_random_walk: 3e-3\n"
    "  gyroscope_random_walk: 1.9e-5\n  update_rate: 200.0\n";
constexpr const char* kVins = "gyr_n: 0.004\ngyr_w: 2.0e-6\nacc_n: 0.08\nacc_w: 0.00004\n";
constexpr const char* kImuUtils = "type: IMU\nGyr:\n  unit: rad/s\n  avg-axis:\n    gyr_n: 1.8e-3\n    gyr_w: 2.5e-5\n";

class HostileYaml : public TemporaryFolder {
 protected:
  /// Reads the text once for each of its values and each thing that could stand there.
  void try_all(const std::string& text, const Read& read) {
    const YAML::Node root = YAML::Load(text);
    change_below(root, root, read);
    EXPECT_GT(tried_, 0);
  }

 private:
  void change_below(const YAML::Node& root, YAML::Node node, const Read& read) {  // NOLINT(misc-no-recursion)
    for (YAML::iterator at = node.begin(); at != node.end(); ++at) {
      YAML::Node value = node.IsMap() ? at->second : YAML::Node(*at);
      const YAML::Node kept = YAML::Clone(value);
      for (const char* other : {"word", "[a, [b]]", "~", "{a: {b: c}}", "[]", "{}", "-1e308 deg", "nan"}) {
        value = YAML::Load(other);
        try_one(root, read);
      }
      value = kept;
      if (value.IsMap() || value.IsSequence()) change_below(root, value, read);
    }
  }

  void try_one(const YAML::Node& root, const Read& read) {
    YAML::Emitter out;
    out << root;
    const std::string path = file("changed.yaml", out.c_str());
    ++tried_;
    try {
      read(path);
    } catch (const InputError& error) {
      EXPECT_TRUE(std::regex_search(error.what(), std::regex(R"([^ :]+:\d+:\d+: )"))) << error.what() << out.c_str();
    } catch (const std::exception& error) {
      ADD_FAILURE() << error.what() << '\n' << out.c_str();
    }
  }

  int tried_ = 0;
};

TEST_F(HostileYaml, Scenes) {
  (void)file("vlm1.yaml", files::vehicle_help());
  (void)file("mems.yaml", kSensor);
  try_all(std::string(files::scene_help()), [](const std::string& path) { (void)files::read_scene(path); });
}

// The flight stands in place of a trajectory and of a log.
TEST_F(HostileYaml, Flights) {
  (void)file("vlm1.yaml", files::vehicle_help());
  YAML::Node scene = YAML::Load(std::string(files::scene_help()));
  YAML::Node flight;
  flight["site"] = scene["site"];
  flight["flight"] = scene["flight"];
  YAML::Emitter out;
  out << flight;
  try_all(out.c_str(), [](const std::string& path) { (void)files::read_scene(path); });
}

TEST_F(HostileYaml, Vehicles) {
  try_all(std::string(files::vehicle_help()), [](const std::string& path) { (void)files::read_vehicle(path); });
}

TEST_F(HostileYaml, SensorFiles) {
  for (const std::string& text : {kSensor, std::string(kKalibr), std::string(kVins), std::string(kImuUtils)})
    try_all(text, [](const std::string& path) { (void)sensor_file::read_sensor(path); });
}

}  // namespace
}  // namespace gyrobudget::app_tests

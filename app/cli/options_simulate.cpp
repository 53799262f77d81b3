// SPDX-License-Identifier: MIT
// Options of simulate.
#include "gyrobudget/app/files/temperature_profile.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "options.h"
#include "values.h"

namespace gyrobudget::inline v0::cli {
namespace {

// What --model knows, and which options go with it.
struct ModelName {
  noise::SimulationModel::Kind kind;
  std::vector<std::string> options;
};

const std::map<std::string, ModelName> kModels{
    {"spectral", {noise::SimulationModel::Kind::spectral, {}}},
    {"gauss-markov", {noise::SimulationModel::Kind::gauss_markov, {}}},
    {"1", {noise::SimulationModel::Kind::jerath, {"--taps"}}},
    {"2", {noise::SimulationModel::Kind::imu_sensor, {"--taps", "--noise-type"}}},
    {"3", {noise::SimulationModel::Kind::bielas, {"--variant", "--rrw", "--correlation-time"}}},
};

const std::map<std::string, noise::Bielas::Bias> kVariants{
    {"integrated_legacy", noise::Bielas::Bias::integrated_legacy},
    {"plain_white", noise::Bielas::Bias::plain_white},
    {"gauss_markov", noise::Bielas::Bias::gauss_markov},
    {"flicker", noise::Bielas::Bias::flicker},
};

template <class Value>
std::vector<std::string> names(const std::map<std::string, Value>& map) {
  std::vector<std::string> list;
  for (const auto& [name, value] : map) list.push_back(name);
  return list;
}

void add_model(App& app, SimulateArguments& a, Texts& texts) {
  auto* group = app.add_option_group("Model");
  group
      ->add_option(
          "--model", a.model_name,
          "spectral: exact, the whole record in memory; gauss-markov: 1/f as a sum of Gauss-Markov processes; 1: Jerath's filter; 2: MATLAB's imuSensor; 3: Bielas. All but spectral stream in constant memory")
      ->check(IsMember{names(kModels)})
      ->capture_default_str();
  group
      ->add_option(
          "--taps", texts.taps,
          "models 1 and 2: past samples that the 1/f filter remembers; its floor holds to 5 taps/rate [1: 10000; 2: 1, as imuSensor]")
      ->type_name("N");
  group
      ->add_option("--noise-type", texts.noise_type,
                   "model 2: double-sided makes N smaller and K larger by 1.414, as imuSensor does [double-sided]")
      ->check(IsMember{{"double-sided", "single-sided"}});
  group
      ->add_option(
          "--variant", texts.variant,
          "model 3: what bias instability is; integrated_legacy is what the paper did, a random walk of 60 B sqrt(dt) deg/h/sqrt(h) [integrated_legacy]")
      ->check(IsMember{names(kVariants)});
  group
      ->add_option("--rrw", texts.rrw,
                   "model 3: the sensor's rate random walk besides [off for integrated_legacy, else on]")
      ->check(IsMember{{"on", "off"}});
  group->add_option("--correlation-time", texts.correlation_time, "model 3, gauss_markov [100 s]")->type_name("TIME");
}

void add_flight(App& app, Texts& texts) {
  auto* group = app.add_option_group("A whole IMU in motion");
  group
      ->add_option(
          "--trajectory", texts.trajectory,
          "how it moves: a CSV of time, latitude, longitude, height and q_w, q_x, q_y, q_z or yaw, pitch, roll; or static, cruise, climb, ascent, with options behind a colon, key=value parted by commas; or a scene (.yaml) that names one. Each row of the log is of the interval that ends at its time")
      ->type_name("FILE|NAME[:...]|SCENE");
  group->add_option("--truth", texts.truth, "write position, velocity and attitude as CSV")->type_name("FILE");
  group->add_option("--fixes", texts.fixes, "write what the scene's aids measure, with their errors: DEVICE.csv there")
      ->type_name("FOLDER");
  group->add_option("--attitude", texts.attitude, "form of the attitude in --truth [quaternion]")
      ->check(IsMember{{"quaternion", "euler"}});
  group
      ->add_option("--input", texts.flight_input,
                   "what the log is to hold: rate (and specific force), or increment (angle and velocity) [rate]")
      ->check(IsMember{{"rate", "increment"}});
  group->add_option("--vibration", texts.vibration, "level for vibration rectification, rms, e.g. \"2 g\" [0]")
      ->type_name("LEVEL");
  group->add_option("--run", texts.run, "another turn-on of the IMU: all that is drawn is drawn anew [0]")
      ->type_name("N");
}

App* add_simulate(App& app, SimulateArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "simulate",
      "Simulates the log of a sensor at rest, or of a whole IMU along a trajectory.\n\n"
      "  gyrobudget simulate examples/sensors/ifog.yaml --duration 10h --rate 100 -o ifog.csv\n"
      "  gyrobudget simulate mems.yaml --trajectory cruise:duration=600 --truth truth.csv -o imu.csv\n");
  verb->add_option("sensor", a.sensor, "sensor file (YAML), or one of Kalibr, VINS or imu_utils")
      ->required()
      ->type_name("SENSOR");
  verb->add_option(
          "--duration", texts.duration,
          "length of the log, e.g. 10h, 90 min, 3600 s; endless: until the reader closes the pipe [with --trajectory: all of it]")
      ->type_name("TIME");
  verb->add_option("--rate", texts.rate,
                   "sample rate, also of sigmas of a sample that a file of VINS or imu_utils gives [100 Hz; densities]")
      ->type_name("HZ");
  verb->add_option("--skip", texts.skip,
                   "leave out the start, a time (9h) or a number of samples; the rest is the same bytes")
      ->type_name("TIME|SAMPLES");
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into the log")->capture_default_str();
  verb->add_option("--axes", texts.axes, "axes to simulate")->capture_default_str();
  verb->add_option("--unit", a.unit, "of the gyro columns [rad/s; increments: rad]");
  verb->add_option(
          "--temperature", texts.temperature,
          "how the temperature goes, for the sensor file's bias over it: \"35 degC\", \"from=20 degC,to=45 degC,time_constant=10 min\", or a table of time and temperature; it becomes a column of the log [at the reference]")
      ->type_name("PROFILE|FILE");
  verb->add_option("-o,--output", a.output, "log to write; .gz compresses; .npy, .f64 and .f32 are binary; - is stdout")
      ->type_name("FILE")
      ->capture_default_str();
  add_format(*verb, texts, "csv, or binary: f32, f64 (raw, little-endian), npy [by the ending of -o]");
  add_model(*verb, a, texts);
  add_flight(*verb, texts);
  verb->footer(
      "Trajectories by name and their options (metres, seconds, m/s, m/s^2, Hz, deg, deg/s, or with a unit):\n" +
      files::trajectory_names() + "\nEvery key of a sensor file: gyrobudget export --help");
  add_common(*verb, a.common, false);
  return verb;
}

void finish_model(SimulateArguments& a, const Texts& texts) {
  const ModelName& chosen = kModels.at(a.model_name);
  a.model.kind = chosen.kind;
  const std::vector<std::pair<std::string, std::string>> given{{"--taps", texts.taps},
                                                               {"--noise-type", texts.noise_type},
                                                               {"--variant", texts.variant},
                                                               {"--rrw", texts.rrw},
                                                               {"--correlation-time", texts.correlation_time}};
  for (const auto& [option, value] : given) {
    if (value.empty() || std::ranges::find(chosen.options, option) != chosen.options.end()) continue;
    throw std::invalid_argument(fmt::format("{} {}: --model {} has no such option", option, value, a.model_name));
  }
  if (!texts.taps.empty()) a.model.taps = static_cast<std::int64_t>(whole_number("--taps", texts.taps));
  a.model.single_sided = texts.noise_type == "single-sided";
  if (!texts.variant.empty()) a.model.variant = kVariants.at(texts.variant);
  if (!texts.rrw.empty()) a.model.rate_random_walk = texts.rrw == "on";
  if (texts.correlation_time.empty()) return;
  if (a.model.variant != noise::Bielas::Bias::gauss_markov) {
    throw std::invalid_argument("--correlation-time belongs to --variant gauss_markov");
  }
  a.model.correlation_time_s = duration("--correlation-time", texts.correlation_time);
}

void finish_extent(SimulateArguments& a, const Texts& texts) {
  if (texts.duration.empty())
    throw std::invalid_argument("simulate needs --duration TIME, e.g. 10h, or a --trajectory");
  const bool endless = texts.duration == "endless";
  a.duration_s = endless ? std::numeric_limits<double>::infinity() : duration("--duration", texts.duration);
  if (endless && a.output != "-") {
    throw std::invalid_argument(
        fmt::format("--duration endless: {} would never be whole; write to standard output", a.output));
  }
  if (!texts.rate.empty()) a.sensor_rate_hz = a.rate_hz = rate("--rate", texts.rate);
  const double samples = a.duration_s * a.rate_hz;
  if (samples < 2) {
    throw std::invalid_argument(fmt::format("{} s at {} Hz is less than two samples", a.duration_s, a.rate_hz));
  }
  constexpr double kMostSamples = 1e15;
  if (!endless && samples > kMostSamples) {
    throw std::invalid_argument(
        fmt::format("{:.3g} samples are more than the {:.0e} that simulate makes; lower --rate or --duration", samples,
                    kMostSamples));
  }
  if (!texts.skip.empty()) a.skipped = skipped_samples(texts.skip, a.rate_hz);
  if (static_cast<double>(a.skipped) >= std::round(samples)) {
    throw std::invalid_argument(
        fmt::format("--skip {}: the log of {} has no samples beyond that", texts.skip, texts.duration));
  }
}

// Options of a sensor at rest have no say in motion, and the other way round.
void check_flight_options(const SimulateArguments& a, const Texts& texts) {
  if (texts.trajectory.empty()) {
    for (const auto& [option, value] : {std::pair{"--truth", texts.truth},
                                        {"--fixes", texts.fixes},
                                        {"--attitude", texts.attitude},
                                        {"--input", texts.flight_input},
                                        {"--vibration", texts.vibration},
                                        {"--run", texts.run}}) {
      if (!value.empty()) throw std::invalid_argument(fmt::format("{} belongs to --trajectory", option));
    }
    return;
  }
  const auto refuse = [](bool given, const char* option, const char* why) {
    if (given) throw std::invalid_argument(fmt::format("{}: {}; leave it out with --trajectory", option, why));
  };
  refuse(a.model_name != "spectral", "--model", "an IMU has the noise of its sensor file, 1/f to 0.02 %");
  refuse(texts.axes != "x,y,z", "--axes", "an IMU has all of them");
  refuse(texts.duration == "endless", "--duration endless", "a trajectory ends");
  refuse(!texts.attitude.empty() && texts.truth.empty(), "--attitude", "it is the form of --truth");
}

void finish_flight(SimulateArguments& a, const Texts& texts) {
  FlightArguments flight{.trajectory = texts.trajectory, .truth = texts.truth, .fixes = texts.fixes};
  if (texts.attitude == "euler") flight.attitude = files::AttitudeForm::euler;
  if (texts.flight_input == "increment") flight.input = log::Input::increment;
  if (!texts.vibration.empty()) {
    flight.vibration = quantity("--vibration", texts.vibration, noise::dimension::kSpecificForce);
    if (flight.vibration < 0) throw std::invalid_argument("--vibration: must not be negative");
  }
  if (!texts.run.empty()) flight.run = whole_number("--run", texts.run);
  if (!texts.rate.empty()) a.sensor_rate_hz = a.rate_hz = rate("--rate", texts.rate);
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  if (!texts.skip.empty()) a.skipped = skipped_samples(texts.skip, a.rate_hz);
  a.flight = std::move(flight);
}

void check_gyro_unit(const SimulateArguments& a) {
  const bool angles = a.flight && a.flight->input == log::Input::increment;
  const auto expected = angles ? noise::dimension::kAngle : noise::dimension::kAngularRate;
  if (a.unit.empty() || noise::parse_unit(a.unit).dimension == expected) return;
  throw std::invalid_argument(
      angles ? fmt::format("--unit {}: not a unit of angle; try deg, arcsec or rad", a.unit)
             : fmt::format("--unit {}: not a unit of angular rate; try deg/s, deg/h or rad/s", a.unit));
}

void finish(SimulateArguments& a, const Texts& texts) {
  check_flight_options(a, texts);
  if (texts.trajectory.empty()) {
    finish_extent(a, texts);
  } else {
    finish_flight(a, texts);
  }
  finish_model(a, texts);
  a.format = texts.format.empty() ? log::format_of(a.output) : *log::format_named(texts.format);
  if (a.format == log::Format::npy && std::isinf(a.duration_s)) {
    throw std::invalid_argument("--format npy: its header holds the length, which an endless log has not; use f64");
  }
  if (a.format != log::Format::csv && a.output.ends_with(".gz")) {
    throw std::invalid_argument(fmt::format("-o {}: only text is compressed; leave out .gz", a.output));
  }
  if (!texts.temperature.empty()) a.temperature = files::temperature_profile(texts.temperature);
  a.seed = seed(texts.seed);
  for (const auto& axis : split(texts.axes, ',')) {
    if (axis != "x" && axis != "y" && axis != "z") {
      throw std::invalid_argument(fmt::format("--axes {}: axes are x, y and z, separated by commas", texts.axes));
    }
    a.axes.push_back(axis.front() - 'x');
  }
  check_gyro_unit(a);
}

}  // namespace

Verb simulate_verb(App& app) { return make_verb<SimulateArguments>(app, add_simulate, finish); }

}  // namespace gyrobudget::inline v0::cli

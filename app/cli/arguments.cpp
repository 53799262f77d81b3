// SPDX-License-Identifier: MIT
// The one file that includes CLI11.
#include "arguments.h"

#include "gyrobudget/io/scene_file.h"
#include "gyrobudget/io/vehicle_file.h"
#include "gyrobudget/noise/units.h"
#include "gyrobudget/version.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <stdexcept>

#include "values.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

// --- The options that verbs share ---------------------------------------------------------------------------------

// Options as text, before they become values with units.
struct Texts {
  std::string rate, duration, terms, tau_min, tau_max, input = "rate", method = "gls", axes = "x,y,z";
  std::string seed = "1", skip, taps, noise_type, variant, rrw, correlation_time;
  std::string records, methods, axis = "gyro", require;
  std::string estimators = "oadev", stride = "1", format, psd, window, gap, resample;
  std::string trajectory, truth, fixes, attitude, flight_input, vibration, run;
  std::string at, step, limit;
  std::vector<std::string> wishes, mask, logs;
};

void add_common(CLI::App& app, Common& common, bool has_json = true) {
  auto* group = app.add_option_group("Common");
  if (has_json) group->add_flag("--json", common.json, "one JSON object on stdout and nothing else");
  group->add_flag("-q,--quiet", common.quiet, "no messages on stderr");
  group
      ->add_option("--threads", common.threads,
                   "number of threads (all cores); the result does not depend on it")
      ->check(CLI::Range(0, 4096));
}

void add_pictures(CLI::App& app, Pictures& pictures) {
  auto* group = app.add_option_group("Pictures");
  group->add_option("--report", pictures.report, "write a self-contained HTML page")->type_name("FILE.html");
  group->add_option("--plot", pictures.plot, "write the figure")->type_name("FILE.svg|.png|.pdf");
}

void add_format(CLI::App& app, Texts& texts, const std::string& help) {
  app.add_option("--format", texts.format, help)
      ->check(CLI::IsMember({"csv", "f32", "f64", "npy"}))
      ->type_name("FORMAT");
}

void add_log(CLI::App& app, CurveArguments& curve, Texts& texts) {
  auto* group = app.add_option_group("Log");
  group->add_option("--rate", texts.rate, "sample rate, where the log has no time column")->type_name("HZ");
  group->add_option(
      "--unit", curve.log.unit,
      "unit of the data columns without one in the header, e.g. deg/s, rad/s, deg/h, g; 1 is dimensionless");
  group->add_option("--input", texts.input, "what a sample is: rate, increment (angle per sample) or angle")
      ->check(CLI::IsMember({"rate", "increment", "angle"}));
  group->add_option("--scale", curve.log.scale, "units per count");
  group->add_option("--column", curve.log.columns, "names or numbers (from 1) of the columns to use")
      ->type_name("NAME|N ...");
  add_format(*group, texts,
             "csv, or binary: f32, f64 (raw, little-endian), npy; needs --rate and --unit [by the ending]");
  group->add_option("--columns", curve.log.file_columns, "numbers a sample has in a raw binary log [1]")
      ->check(CLI::Range(1, 65536))
      ->type_name("K");
  group
      ->add_option(
          "--resample", texts.resample,
          "average readings at uneven times over even intervals of this rate; only where asked for, and "
          "it is said what that does to short taus")
      ->type_name("HZ");
  group->add_flag("--strict-gaps", curve.strict_gaps,
                  "use a cluster only where none of its samples is missing (else 95 %)");
}

void add_curve(CLI::App& app, CurveArguments& curve, const std::string& default_taus) {
  curve.taus = default_taus;
  auto* group = app.add_option_group("Curve");
  group
      ->add_option("--taus", curve.taus,
                   "averaging times: octave, decade, all, or a number of log-spaced ones")
      ->type_name("octave|decade|all|N")
      ->capture_default_str();
  group->add_flag("--ieee", curve.ieee_form,
                  "n - 2m terms as IEEE Std 952 and MATLAB count (else n - 2m + 1)");
}

void finish_log(CurveArguments& curve, const Texts& texts) {
  if (!texts.rate.empty()) curve.log.rate_hz = rate("--rate", texts.rate);
  if (!texts.resample.empty()) curve.log.resample_hz = rate("--resample", texts.resample);
  curve.log.input = texts.input == "angle"       ? io::Input::angle
                    : texts.input == "increment" ? io::Input::increment
                                                 : io::Input::rate;
  if (!texts.format.empty()) curve.log.format = io::format_named(texts.format);
  const bool named = curve.taus == "octave" || curve.taus == "decade" || curve.taus == "all";
  const bool count = !curve.taus.empty() && curve.taus.size() < 7 &&
                     curve.taus.find_first_not_of("0123456789") == std::string::npos &&
                     std::stoi(curve.taus) > 1;
  if (!named && !count) {
    throw std::invalid_argument(
        fmt::format("--taus {}: must be octave, decade, all, or a number from 2 on", curve.taus));
  }
  if (curve.log.scale == 0 || !std::isfinite(curve.log.scale)) {
    throw std::invalid_argument(fmt::format("--scale {}: must be a number other than 0", curve.log.scale));
  }
}

// --- The verbs ----------------------------------------------------------------------------------------------------

// What --model knows, and which options go with it.
struct ModelName {
  SimulateArguments::Model model;
  std::vector<std::string> options;
};

const std::map<std::string, ModelName> kModels{
    {"spectral", {SimulateArguments::Model::spectral, {}}},
    {"gauss-markov", {SimulateArguments::Model::gauss_markov, {}}},
    {"1", {SimulateArguments::Model::jerath, {"--taps"}}},
    {"2", {SimulateArguments::Model::imu_sensor, {"--taps", "--noise-type"}}},
    {"3", {SimulateArguments::Model::bielas, {"--variant", "--rrw", "--correlation-time"}}},
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

void add_model(CLI::App& app, SimulateArguments& a, Texts& texts) {
  auto* group = app.add_option_group("Model");
  group
      ->add_option("--model", a.model_name,
                   "spectral: exact, the whole record in memory; gauss-markov: 1/f as a sum of Gauss-Markov "
                   "processes; 1: Jerath's filter; 2: MATLAB's imuSensor; 3: Bielas. All but spectral stream "
                   "in constant memory")
      ->check(CLI::IsMember(names(kModels)))
      ->capture_default_str();
  group
      ->add_option(
          "--taps", texts.taps,
          "models 1 and 2: past samples that the 1/f filter remembers; its floor holds to 5 taps/rate "
          "[1: 10000; 2: 1, as imuSensor]")
      ->type_name("N");
  group
      ->add_option("--noise-type", texts.noise_type,
                   "model 2: double-sided makes N smaller and K larger by 1.414, as imuSensor does "
                   "[double-sided]")
      ->check(CLI::IsMember({"double-sided", "single-sided"}));
  group
      ->add_option(
          "--variant", texts.variant,
          "model 3: what bias instability is; integrated_legacy is what the paper did, a random walk "
          "of 60 B sqrt(dt) deg/h/sqrt(h) [integrated_legacy]")
      ->check(CLI::IsMember(names(kVariants)));
  group
      ->add_option("--rrw", texts.rrw,
                   "model 3: the sensor's rate random walk besides [off for integrated_legacy, else on]")
      ->check(CLI::IsMember({"on", "off"}));
  group->add_option("--correlation-time", texts.correlation_time, "model 3, gauss_markov [100 s]")
      ->type_name("TIME");
}

void add_flight(CLI::App& app, Texts& texts) {
  auto* group = app.add_option_group("A whole IMU in motion");
  group
      ->add_option(
          "--trajectory", texts.trajectory,
          "how it moves: a CSV of time, latitude, longitude, height and q_w, q_x, q_y, q_z or yaw, pitch, "
          "roll; or static, cruise, climb, ascent, with options behind a colon, key=value parted by "
          "commas; or a scene (.yaml) that names one. Each row of the log is of the interval that ends at "
          "its "
          "time")
      ->type_name("FILE|NAME[:...]|SCENE");
  group->add_option("--truth", texts.truth, "write position, velocity and attitude as CSV")
      ->type_name("FILE");
  group
      ->add_option("--fixes", texts.fixes,
                   "write what the scene's aids measure, with their errors: DEVICE.csv there")
      ->type_name("FOLDER");
  group->add_option("--attitude", texts.attitude, "form of the attitude in --truth [quaternion]")
      ->check(CLI::IsMember({"quaternion", "euler"}));
  group
      ->add_option(
          "--input", texts.flight_input,
          "what the log is to hold: rate (and specific force), or increment (angle and velocity) [rate]")
      ->check(CLI::IsMember({"rate", "increment"}));
  group
      ->add_option("--vibration", texts.vibration, "level for vibration rectification, rms, e.g. \"2 g\" [0]")
      ->type_name("LEVEL");
  group->add_option("--run", texts.run, "another turn-on of the IMU: all that is drawn is drawn anew [0]")
      ->type_name("N");
}

CLI::App* add_simulate(CLI::App& app, SimulateArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "simulate",
      "Simulates the log of a sensor at rest, or of a whole IMU along a trajectory.\n\n"
      "  gyrobudget simulate examples/sensors/ifog.yaml --duration 10h --rate 100 -o ifog.csv\n"
      "  gyrobudget simulate mems.yaml --trajectory cruise:duration=600 --truth truth.csv -o imu.csv\n");
  verb->add_option("sensor", a.sensor, "sensor file (YAML), or a Kalibr imu.yaml")
      ->required()
      ->type_name("SENSOR");
  verb->add_option("--duration", texts.duration,
                   "length of the log, e.g. 10h, 90 min, 3600 s; endless: until the reader closes the pipe "
                   "[with --trajectory: all of it]")
      ->type_name("TIME");
  verb->add_option("--rate", texts.rate, "sample rate [100 Hz]")->type_name("HZ");
  verb->add_option("--skip", texts.skip,
                   "leave out the start, a time (9h) or a number of samples; the rest is the same bytes")
      ->type_name("TIME|SAMPLES");
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into the log")
      ->capture_default_str();
  verb->add_option("--axes", texts.axes, "axes to simulate")->capture_default_str();
  verb->add_option("--unit", a.unit, "of the gyro columns [rad/s; increments: rad]");
  verb->add_option("-o,--output", a.output,
                   "log to write; .gz compresses; .npy, .f64 and .f32 are binary; - is stdout")
      ->type_name("FILE")
      ->capture_default_str();
  add_format(*verb, texts, "csv, or binary: f32, f64 (raw, little-endian), npy [by the ending of -o]");
  add_model(*verb, a, texts);
  add_flight(*verb, texts);
  verb->footer(
      "Trajectories by name and their options (metres, seconds, m/s, m/s^2, Hz, deg, deg/s, or with a "
      "unit):\n" +
      io::trajectory_names());
  add_common(*verb, a.common, false);
  return verb;
}

void finish_model(SimulateArguments& a, const Texts& texts) {
  const ModelName& chosen = kModels.at(a.model_name);
  a.model = chosen.model;
  const std::vector<std::pair<std::string, std::string>> given{
      {"--taps", texts.taps},
      {"--noise-type", texts.noise_type},
      {"--variant", texts.variant},
      {"--rrw", texts.rrw},
      {"--correlation-time", texts.correlation_time}};
  for (const auto& [option, value] : given) {
    if (value.empty() || std::ranges::find(chosen.options, option) != chosen.options.end()) continue;
    throw std::invalid_argument(
        fmt::format("{} {}: --model {} has no such option", option, value, a.model_name));
  }
  if (!texts.taps.empty()) a.taps = static_cast<std::int64_t>(whole_number("--taps", texts.taps));
  a.single_sided = texts.noise_type == "single-sided";
  if (!texts.variant.empty()) a.variant = kVariants.at(texts.variant);
  if (!texts.rrw.empty()) a.rate_random_walk = texts.rrw == "on";
  if (texts.correlation_time.empty()) return;
  if (a.variant != noise::Bielas::Bias::gauss_markov) {
    throw std::invalid_argument("--correlation-time belongs to --variant gauss_markov");
  }
  a.correlation_time_s = duration("--correlation-time", texts.correlation_time);
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
  if (!texts.rate.empty()) a.rate_hz = rate("--rate", texts.rate);
  const double samples = a.duration_s * a.rate_hz;
  if (samples < 2) {
    throw std::invalid_argument(
        fmt::format("{} s at {} Hz is less than two samples", a.duration_s, a.rate_hz));
  }
  constexpr double kMostSamples = 1e15;
  if (!endless && samples > kMostSamples) {
    throw std::invalid_argument(
        fmt::format("{:.3g} samples are more than the {:.0e} that simulate makes; lower --rate or "
                    "--duration",
                    samples, kMostSamples));
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
    if (given)
      throw std::invalid_argument(fmt::format("{}: {}; leave it out with --trajectory", option, why));
  };
  refuse(a.model_name != "spectral", "--model", "an IMU has the noise of its sensor file, 1/f to 0.02 %");
  refuse(texts.axes != "x,y,z", "--axes", "an IMU has all of them");
  refuse(texts.duration == "endless", "--duration endless", "a trajectory ends");
  refuse(!texts.attitude.empty() && texts.truth.empty(), "--attitude", "it is the form of --truth");
}

void finish_flight(SimulateArguments& a, const Texts& texts) {
  FlightArguments flight{.trajectory = texts.trajectory, .truth = texts.truth, .fixes = texts.fixes};
  if (texts.attitude == "euler") flight.attitude = io::AttitudeForm::euler;
  if (texts.flight_input == "increment") flight.input = io::Input::increment;
  if (!texts.vibration.empty()) {
    flight.vibration = quantity("--vibration", texts.vibration, noise::dimension::kSpecificForce);
    if (flight.vibration < 0) throw std::invalid_argument("--vibration: must not be negative");
  }
  if (!texts.run.empty()) flight.run = whole_number("--run", texts.run);
  if (!texts.rate.empty()) a.rate_hz = rate("--rate", texts.rate);
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  if (!texts.skip.empty()) a.skipped = skipped_samples(texts.skip, a.rate_hz);
  a.flight = std::move(flight);
}

void check_gyro_unit(const SimulateArguments& a) {
  const bool angles = a.flight && a.flight->input == io::Input::increment;
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
  a.format = texts.format.empty() ? io::format_of(a.output) : *io::format_named(texts.format);
  if (a.format == io::Format::npy && std::isinf(a.duration_s)) {
    throw std::invalid_argument(
        "--format npy: its header holds the length, which an endless log has not; use f64");
  }
  if (a.format != io::Format::csv && a.output.ends_with(".gz")) {
    throw std::invalid_argument(fmt::format("-o {}: only text is compressed; leave out .gz", a.output));
  }
  a.seed = seed(texts.seed);
  a.axes = split(texts.axes, ',');
  for (const auto& axis : a.axes) {
    if (axis != "x" && axis != "y" && axis != "z") {
      throw std::invalid_argument(
          fmt::format("--axes {}: axes are x, y and z, separated by commas", texts.axes));
    }
  }
  check_gyro_unit(a);
}

void add_estimators(CLI::App& app, Texts& texts) {
  auto* group = app.add_option_group("Estimator");
  group
      ->add_option("--estimator", texts.estimators,
                   "adev, oadev, mdev, tdev, hdev, ohdev, totdev, mtotdev, ttotdev, htotdev, theo1, theobr, "
                   "theoh, pdev; several with "
                   "commas; or all")
      ->type_name("NAME,...")
      ->capture_default_str();
  group
      ->add_option(
          "--stride", texts.stride,
          "terms begin at every sample (1), or every m/N samples: m/16 costs white noise 0.5 % of the "
          "degrees of freedom, m/4 8 %, m 56 %; below 8 samples it is taken as 1")
      ->type_name("1|m/N|m")
      ->capture_default_str();
}

void add_segments(CLI::App& app, Texts& texts) {
  app.add_option_group("Segments")
      ->add_option(
          "--segments", texts.gap,
          "cut each log where more than this is missing, or time goes back, and pool the segments into one "
          "curve: power-ups, dropped data")
      ->type_name("GAP");
}

void add_views(CLI::App& app, Texts& texts) {
  auto* group = app.add_option_group("Other views, for --report and --json");
  group
      ->add_option("--psd", texts.psd,
                   "root of the two-sided power spectral density, deg/h/sqrt(Hz) for a gyro, by welch or "
                   "multitaper (sine tapers)")
      ->check(CLI::IsMember({"welch", "multitaper"}))
      ->type_name("METHOD");
  group->add_option("--dynamic", texts.window, "Allan deviation over time, of windows of this length")
      ->type_name("WINDOW");
}

void finish_views(AllanArguments& a, const Texts& texts) {
  if (!texts.psd.empty()) {
    a.psd = texts.psd == "welch" ? AllanArguments::Psd::welch : AllanArguments::Psd::multitaper;
  }
  if (!texts.window.empty()) a.dynamic_s = duration("--dynamic", texts.window);
  const std::string option = a.psd ? "--psd" : "--dynamic";
  if (!a.psd && !a.dynamic_s) return;
  if (!a.common.json && a.pictures.report.empty())
    throw std::invalid_argument(
        fmt::format("{} goes into --report FILE.html and --json; give one of them", option));
  if (!a.segments.empty()) throw std::invalid_argument(fmt::format("{} looks at one log", option));
  if (a.stream)
    throw std::invalid_argument(
        fmt::format("{} needs the whole log; leave out --stream and --follow", option));
}

void add_streaming(CLI::App& app, AllanArguments& a) {
  auto* group = app.add_option_group("Endless logs");
  group->add_flag("--stream", a.stream,
                  "read in constant memory: oadev at octaves, terms every m/16 samples");
  group->add_flag(
      "--follow", a.follow,
      "the same, with a table while the log grows: each second on a terminal, else at each doubling; "
      "Ctrl-C prints the last one");
}

void check_stream(const AllanArguments& a, const std::string& default_taus) {
  const std::string option = a.follow ? "--follow" : "--stream";
  const auto refuse = [&](bool wrong, const std::string& what) {
    if (wrong) throw std::invalid_argument(fmt::format("{} {}", option, what));
  };
  refuse(!a.segments.empty(), "reads one log");
  refuse(a.gap_s.has_value(), "reads one segment; leave out --segments");
  refuse(a.curve.log.resample_hz.has_value(), "cannot resample; leave out --resample");
  refuse(a.estimators != std::vector{allan::Estimator::oadev}, "knows the oadev only; leave out --estimator");
  refuse(a.curve.taus != "octave" && a.curve.taus != default_taus, "has octaves only; leave out --taus");
  refuse(a.curve.ieee_form, "counts n - 2m + 1 terms; leave out --ieee");
  refuse((a.overlap & (a.overlap - 1)) != 0, "needs a stride of m/N with N a power of two");
}

constexpr const char* kTaus = "50";

void finish(AllanArguments& a, const Texts& texts) {
  a.curve.log.path = texts.logs.front();
  a.segments.assign(texts.logs.begin() + 1, texts.logs.end());
  finish_log(a.curve, texts);
  if (!texts.gap.empty()) a.gap_s = duration("--segments", texts.gap);
  a.estimators = estimators(texts.estimators);
  a.overlap = overlap(texts.stride);
  a.stream = a.stream || a.follow;
  if (a.stream) check_stream(a, kTaus);
  finish_views(a, texts);
  const bool full = a.estimators == std::vector{allan::Estimator::oadev} && a.overlap == 0;
  if (a.curve.ieee_form && !full) {
    throw std::invalid_argument(
        "--ieee counts the terms of the oadev at every sample; leave out --estimator and --stride");
  }
}

CLI::App* add_allan(CLI::App& app, AllanArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand("allan",
                                  "Allan deviation of a log, with degrees of freedom and 95 % intervals.\n\n"
                                  "  gyrobudget allan imu.csv --plot allan.svg\n"
                                  "  gyrobudget allan counts.txt --rate 100 --unit deg/h --scale 0.1 "
                                  "--estimator oadev,mdev,totdev --json\n");
  verb->add_option(
          "log", texts.logs,
          "CSV or text, also .gz; - is stdin. Several are power-ups of one sensor, pooled into one curve")
      ->required()
      ->type_name("LOG ...");
  add_log(*verb, a.curve, texts);
  add_segments(*verb, texts);
  add_curve(*verb, a.curve, kTaus);
  add_estimators(*verb, texts);
  add_views(*verb, texts);
  add_streaming(*verb, a);
  add_pictures(*verb, a.pictures);
  add_common(*verb, a.common);
  return verb;
}

CLI::App* add_calibrate(CLI::App& app, CalibrateArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "calibrate",
      "From a static log to the datasheet: ARW, bias instability and RRW with intervals and a verdict.\n\n"
      "  gyrobudget calibrate imu.csv --report datasheet.html -o sensor.yaml\n"
      "  gyrobudget calibrate gyro.txt --rate 200 --unit deg/s --kalibr imu.yaml\n");
  verb->add_option("log", a.logs,
                   "CSV or text, also .gz; - is stdin; several: records of one sensor type, each fitted by "
                   "itself, then combined")
      ->type_name("LOG ...");
  add_log(*verb, a.curve, texts);
  verb->get_option("--rate")->description(
      "sample rate, where the log has no time column; of the record behind --curve");
  auto* fit = verb->add_option_group("Fit");
  fit->add_option(
         "--terms", texts.terms,
         "terms to fit, of Q,N,B,K,R, G (one Gauss-Markov process) and S (one sinusoid); auto: those that "
         "the record holds, by likelihood ratios; G=120s and S=0.05Hz hold its correlation time and its "
         "frequency [N,B,K, and Q where the shortest taus show "
         "quantization]")
      ->type_name("LIST|auto");
  fit->add_option(
         "--method", texts.method,
         "gls: least squares with the exact covariance; edf: each tau's own variance; loglog: no weights; "
         "slope, visual: read off the plot, to compare; whittle: likelihood of the record")
      ->check(CLI::IsMember({"gls", "edf", "loglog", "slope", "visual", "whittle"}))
      ->capture_default_str();
  fit->add_flag("--cross-check", a.cross_check,
                "fit the likelihood of the record too, and say whether the two agree");
  fit->add_option(
         "--mask", texts.mask,
         "leave out of the fit what is found in the record: outliers, steps (all but the longest part "
         "without one), warm-up")
      ->delimiter(',')
      ->check(CLI::IsMember({"outliers", "steps", "warm-up"}))
      ->type_name("outliers,steps,warm-up");
  fit->add_option("--tau-min", texts.tau_min,
                  "shortest tau to fit [start of the longest run the model describes]")
      ->type_name("TIME");
  fit->add_option("--tau-max", texts.tau_max, "longest tau to fit [all]")->type_name("TIME");
  auto* table = verb->add_option_group("Curve table instead of a log");
  auto* file =
      table->add_option("--curve", a.curve_file, "table of tau and deviation (CSV with units in the header)")
          ->type_name("FILE");
  file->excludes(verb->get_option("log"));
  table->add_option("--duration", texts.duration, "length of the record behind --curve")->type_name("TIME");
  add_curve(*verb, a.curve, "50");
  auto* out = verb->add_option_group("Output");
  out->add_option("-o,--output", a.output, "write the sensor file")->type_name("SENSOR.yaml");
  out->add_option("--kalibr", a.kalibr, "write Kalibr's imu.yaml")->type_name("FILE.yaml");
  out->add_option("--name", a.name, "the sensor's name in these files [name of the log]");
  add_pictures(*verb, a.pictures);
  add_common(*verb, a.common);
  return verb;
}

void finish(CalibrateArguments& a, const Texts& texts) {
  finish_log(a.curve, texts);
  if (a.logs.empty() == a.curve_file.empty()) {
    throw std::invalid_argument(
        fmt::format("calibrate needs a log (or - for stdin), or a table with --curve{}",
                    a.curve.log.columns.empty() ? "" : "; put the log before --column"));
  }
  for (auto log = a.logs.begin(); log != a.logs.end(); ++log) {
    if (std::find(a.logs.begin(), log, *log) == log) continue;
    throw std::invalid_argument(fmt::format("{} is given twice: one record counts once", *log));
  }
  if (!a.logs.empty()) a.curve.log.path = a.logs.front();
  const bool of_samples = texts.method == "whittle" || a.cross_check || !texts.mask.empty();
  if (of_samples && !a.curve_file.empty())
    throw std::invalid_argument(
        "--method whittle, --cross-check and --mask need the log, not a table (--curve)");
  if (texts.terms == "auto") {
    a.choose_terms = true;
  } else if (!texts.terms.empty()) {
    const ShapedTerms given = shaped_terms(texts.terms);
    a.terms = given.terms;
    a.correlation_time_s = given.correlation_time_s;
    a.frequency_hz = given.frequency_hz;
  }
  const auto asked = [&](Term t) { return a.terms && std::ranges::find(*a.terms, t) != a.terms->end(); };
  const bool open_time = asked(Term::gauss_markov) && !a.correlation_time_s;
  const bool open_frequency = asked(Term::sinusoid) && !a.frequency_hz;
  if (!a.curve_file.empty() && (a.choose_terms || open_time || open_frequency))
    throw std::invalid_argument(
        "--terms auto, and G and S of unknown time and frequency, need the log, not a table (--curve); for a "
        "table give them: --terms N,G=120s,S=0.05Hz");
  a.method = *std::find_if(fit::kMethods.begin(), fit::kMethods.end(),
                           [&](fit::Method m) { return fit::name(m) == texts.method; });
  const auto masks = [&](const char* what) {
    return std::find(texts.mask.begin(), texts.mask.end(), what) != texts.mask.end();
  };
  a.masking = {masks("outliers"), masks("steps"), masks("warm-up")};
  if (!texts.tau_min.empty()) a.tau_min_s = duration("--tau-min", texts.tau_min);
  if (!texts.tau_max.empty()) a.tau_max_s = duration("--tau-max", texts.tau_max);
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  if (!a.curve_file.empty() &&
      (a.curve.ieee_form || a.curve.strict_gaps || a.curve.log.scale != 1 || texts.input != "rate")) {
    throw std::invalid_argument(
        "--curve: --ieee, --strict-gaps, --scale and --input are about logs, not tables");
  }
  if (!a.curve_file.empty() && (!a.duration_s || !a.curve.log.rate_hz)) {
    throw std::invalid_argument(
        "--curve: the statistics need the record behind the table; give its --rate and --duration");
  }
}

CLI::App* add_plan(CLI::App& app, PlanArguments& a, Texts& texts) {
  auto* verb =
      app.add_subcommand("plan",
                         "How long to record for a wanted accuracy, or what accuracy a recording buys.\n\n"
                         "  gyrobudget plan examples/sensors/mems.yaml --want B=10%\n"
                         "  gyrobudget plan sensor.yaml --duration 2h --rate 200\n");
  verb->add_option("sensor", a.sensor, "sensor file with the expected coefficients")
      ->required()
      ->type_name("SENSOR");
  verb->add_option("--rate", texts.rate, "sample rate [100 Hz]")->type_name("HZ");
  verb->add_option("--duration", texts.duration, "what will a record of this length buy?")->type_name("TIME");
  verb->add_option("--want", texts.wishes,
                   "how long for this accuracy (one sigma, relative), e.g. B=10% or arw=1%")
      ->type_name("TERM=ACCURACY ...");
  add_common(*verb, a.common);
  return verb;
}

void finish(PlanArguments& a, const Texts& texts) {
  if (!texts.rate.empty()) a.rate_hz = rate("--rate", texts.rate);
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  for (const auto& text : texts.wishes) a.wishes.push_back(wish(text));
}

CLI::App* add_accuracy(CLI::App& app, AccuracyArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "accuracy",
      "How wrong the fits are: simulates records of known truth and compares.\n\n"
      "  gyrobudget accuracy examples/sensors/mems.yaml --report accuracy.html\n"
      "  gyrobudget accuracy sensor.yaml --duration 2h --rate 10 --require \"arw.rmse<1.1*crlb, coverage in "
      "0.92..0.98\"\n"
      "  gyrobudget accuracy sensor.yaml --sweep\n");
  verb->add_option("sensor", a.sensor, "sensor file: the truth")->required()->type_name("SENSOR");
  verb->add_option("--duration", texts.duration, "length of a record [10h]")->type_name("TIME");
  verb->add_option("--rate", texts.rate, "sample rate [1 Hz]")->type_name("HZ");
  verb->add_option("--records", texts.records, "how many [500; 200 for --sweep]")->type_name("N");
  verb->add_option("--methods", texts.methods, "of gls, edf, loglog, slope, visual, whittle [gls,whittle]")
      ->type_name("LIST");
  verb->add_option("--terms", texts.terms,
                   "terms to fit, of Q,N,B,K,R [N,B,K, and Q and R where the sensor has them]")
      ->type_name("LIST");
  verb->add_option("--axis", texts.axis, "which of the sensor's two")
      ->check(CLI::IsMember({"gyro", "accelerometer"}))
      ->capture_default_str();
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into every output")
      ->capture_default_str();
  verb->add_option("--require", texts.require,
                   "limits, [METHOD.][COEFFICIENT.]QUANTITY < NUMBER[*crlb|*likelihood] or in LOW..HIGH; "
                   "quantities: rmse, bias, coverage, coverage_identified, identified, missed, false_terms, "
                   "p05, p01, unconverged, seconds; exit code 1 where one is broken")
      ->type_name("LIMITS");
  verb->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  verb->add_flag("--sweep", a.sweep,
                 "error against run time instead: over methods, taus an octave, strides and record lengths");
  verb->add_option("--longest", a.longest, "longest record of the sweep, samples from 1e4 to 1e8 [1e7]")
      ->check(CLI::Range(1e4, 1e8))
      ->type_name("N");
  add_common(*verb, a.common);
  return verb;
}

void finish_sweep(AccuracyArguments& a, const Texts& texts) {
  for (const auto& [option, text] : {std::pair{"--methods", texts.methods}, {"--require", texts.require}}) {
    if (a.sweep && !text.empty()) {
      throw std::invalid_argument(fmt::format("{}: --sweep takes every method and has no limits", option));
    }
  }
  if (a.longest && !a.sweep) throw std::invalid_argument("--longest belongs to --sweep");
}

void finish(AccuracyArguments& a, const Texts& texts) {
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  if (!texts.rate.empty()) a.rate_hz = rate("--rate", texts.rate);
  constexpr double kFewestSamples = 16, kMostSamples = 1e8;
  const double samples = std::round(a.duration_s * a.rate_hz);
  if (!(samples >= kFewestSamples && samples <= kMostSamples)) {
    throw std::invalid_argument(fmt::format("{:g} s at {:g} Hz are {:.3g} samples; a record has 16 to 1e8",
                                            a.duration_s, a.rate_hz, samples));
  }
  if (!texts.records.empty()) {
    constexpr std::uint64_t kMostRecords = 10'000'000;
    const std::uint64_t records = whole_number("--records", texts.records);
    if (records < 1 || records > kMostRecords) {
      throw std::invalid_argument(fmt::format("--records {}: must be from 1 to {}", records, kMostRecords));
    }
    a.records = static_cast<int>(records);
  }
  for (const auto& name : split(texts.methods.empty() ? "gls,whittle" : texts.methods, ',')) {
    const fit::Method method = method_named(name);
    if (std::ranges::find(a.methods, method) == a.methods.end()) a.methods.push_back(method);
  }
  if (!texts.terms.empty()) a.terms = terms(texts.terms);
  if (texts.axis == "accelerometer") a.signal = noise::Signal::specific_force;
  a.seed = seed(texts.seed);
  if (!texts.require.empty()) a.requirements = fit::parse_requirements(texts.require);
  finish_sweep(a, texts);
}

CLI::App* add_paper(CLI::App& app, PaperArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "paper",
      "The tables and figures of Nunes et al. beside ours, and why they differ: gyro noise,\n"
      "the first stage flown in closed loop on each gyro, and what could have made its\n"
      "distances.\n\n"
      "  gyrobudget paper --report paper.html\n"
      "  gyrobudget paper --seed 7 --json\n");
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into every output")
      ->capture_default_str();
  verb->add_option("--report", a.report, "write a self-contained HTML page with the figures")
      ->type_name("FILE.html");
  add_common(*verb, a.common);
  return verb;
}

CLI::App* add_navigate(CLI::App& app, NavigateArguments& a) {
  auto* verb = app.add_subcommand(
      "navigate",
      "From a recorded IMU log, with GNSS, barometer or a reference, to position, velocity and attitude.\n\n"
      "  gyrobudget navigate drive.yaml -o solution.csv --report drive.html\n"
      "  gyrobudget navigate examples/scenes/mems-beside-fog.yaml --data my/logs --json\n");
  verb->add_option("scene", a.scene, "scene file: the log, the sensor, the alignment, the aids")
      ->required()
      ->type_name("SCENE");
  verb->add_option("--data", a.data_folder, "folder of the logs that the scene names [that of the scene]")
      ->type_name("FOLDER");
  auto* out = verb->add_option_group("Output");
  out->add_option("-o,--output", a.output, "write the solution with one-sigma columns")
      ->type_name("FILE.csv");
  out->add_flag("--smooth", a.smooth, "solutions from all fixes, later ones too (fixed-interval smoother)");
  out->add_option("--innovations", a.innovations, "write what every fix told: residual, sigma, NIS")
      ->type_name("FILE.csv");
  out->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  add_common(*verb, a.common);
  verb->footer(fmt::format("Scene (YAML, every value with its unit):\n\n{}", io::scene_help()));
  return verb;
}

CLI::App* add_budget(CLI::App& app, BudgetArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "budget",
      "What each error source costs along a planned scene, in metres and degrees, by linear covariance.\n\n"
      "  gyrobudget budget examples/scenes/vlm1-ifog.yaml --exact --runs 200 --report budget.html\n"
      "  gyrobudget budget scene.yaml --sensor a.yaml --sensor b.yaml --limit 'crossrange < 10 m'\n");
  verb->add_option("scene", a.scene, "scene file: site, trajectory, sensor, alignment, aids")
      ->required()
      ->type_name("SCENE");
  auto* ask = verb->add_option_group("Question");
  ask->add_option("--at", texts.at, "time of the table [end of the scene]")->type_name("TIME");
  ask->add_option("--sensor", a.sensors, "in place of the scene's; several: side by side")->type_name("FILE");
  ask->add_option(
         "--limit", texts.limit,
         "how far may each source grow, and how long must a scene that aligns itself stand: "
         "'east|north|up|downrange|crossrange|horizontal|rss < LENGTH'; exit 1 where the total is above it")
      ->type_name("TEXT");
  auto* how = verb->add_option_group("Method");
  how->add_option("--tolerance", a.tolerance,
                  "sources that together change no total by more than this fraction are left out and listed")
      ->check(CLI::Range(0.0, 0.5))
      ->capture_default_str();
  how->add_flag("--keep-all", a.keep_all, "leave nothing out");
  how->add_option("--step", texts.step, "of the covariance [1/200 of the scene, at most 1 s below an hour]")
      ->type_name("TIME");
  how->add_option("--rate", texts.rate,
                  "of the IMU: it sets 1/f noise at short times and Monte Carlo [100 Hz]")
      ->type_name("HZ");
  how->add_flag("--exact", a.exact,
                "each source again by integrals over its structure function, without states for 1/f");
  how->add_option("--runs", a.runs, "Monte Carlo of the whole chain, not linearised; 0: none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  how->add_flag("--each-source", a.each_source, "as many runs of each source of the table alone")
      ->needs("--runs");
  how->add_option("--seed", texts.seed, "of its random numbers")->capture_default_str();
  verb->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  add_common(*verb, a.common);
  verb->footer("Every key of a scene: gyrobudget navigate --help");
  return verb;
}

void finish(BudgetArguments& a, const Texts& texts) {
  if (!texts.at.empty()) a.at = quantity("--at", texts.at, noise::dimension::kTime);
  if (!texts.step.empty()) a.step = duration("--step", texts.step);
  if (!texts.rate.empty()) a.rate = rate("--rate", texts.rate);
  if (!texts.limit.empty()) a.limit = limit(texts.limit);
  a.seed = seed(texts.seed);
}

CLI::App* add_fly(CLI::App& app, FlyArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "fly",
      "A launch vehicle in closed loop, steered by what its sensors tell.\n\n"
      "  gyrobudget fly examples/scenes/vlm1-ifog.yaml examples/scenes/vlm1-mems.yaml --report flight.html\n"
      "  gyrobudget fly scene.yaml --sensor ideal --sensor mems.yaml --runs 200 -o flight.csv\n");
  verb->add_option("scene", a.scenes,
                   "scene files with a flight: site, vehicle, control, sensor, alignment, aids")
      ->required()
      ->type_name("SCENE");
  verb->add_option("--sensor", a.sensors, "in place of the scene's, \"ideal\" too; several: side by side")
      ->type_name("FILE")
      ->allow_extra_args(false);
  verb->add_option("--runs", a.runs,
                   "Monte Carlo flights of each kind: sensors alone, vehicle alone, both; 0: none")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into every output")
      ->capture_default_str();
  auto* out = verb->add_option_group("Output");
  out->add_option("-o,--output", a.output,
                  "write the flight: trajectory, attitude, nozzle, air, navigation error")
      ->type_name("FILE.csv");
  out->add_option("--rate", texts.rate, "of its rows [10 Hz]")->type_name("HZ");
  out->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  add_common(*verb, a.common);
  verb->footer(fmt::format("Every key of a scene: gyrobudget navigate --help\n\nVehicle (YAML):\n\n{}",
                           io::vehicle_help()));
  return verb;
}

void finish(FlyArguments& a, const Texts& texts) {
  if (!texts.rate.empty()) a.rate = rate("--rate", texts.rate);
  a.seed = seed(texts.seed);
}

// --- Help -----------------------------------------------------------------------------------------------------------

// The list of verbs shows what each is for, without its examples.
class Formatter : public CLI::Formatter {
 public:
  Formatter() { column_width(30); }
  std::string make_subcommand(const CLI::App* verb) const override {
    const std::string description = verb->get_description();
    return fmt::format("  {:<12}{}\n", verb->get_name(), description.substr(0, description.find('\n')));
  }

  // A group of options under its own name instead of "[Option Group: Log]", "  Options:".
  std::string make_expanded(const CLI::App* group) const override {
    std::string options = make_groups(group, CLI::AppFormatMode::Sub);
    options = options.substr(options.find(':') + 2);  // behind "Options:\n"
    return fmt::format("\n{}:\n{}", group->get_group(), options);
  }
};

// --- Errors of use --------------------------------------------------------------------------------------------------

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitute = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitute});
    }
  }
  return row.back();
}

// "; did you mean --rate?" for an unknown word, or nothing where no name is near.
std::string suggestion(const CLI::App& app, const std::string& word) {
  std::string best;
  std::size_t nearest = 3;
  const auto consider = [&](const std::string& name) {
    if (const auto distance = edit_distance(word, name); distance < nearest) nearest = distance, best = name;
  };
  for (const auto* verb : app.get_subcommands({})) {
    if (!verb->get_name().empty()) consider(verb->get_name());
    if (!verb->parsed() && !verb->get_name().empty()) continue;
    for (const auto* option : verb->get_options()) {
      for (const auto& name : option->get_lnames()) consider("--" + name);
    }
    for (const auto* group : verb->get_subcommands({})) {
      for (const auto* option : group->get_options()) {
        for (const auto& name : option->get_lnames()) consider("--" + name);
      }
    }
  }
  return best.empty() ? "" : fmt::format("; did you mean {}?", best);
}

Answered answer(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) {  // --help and --version
    app.exit(error);
    return {exit_done};
  }
  std::string message = error.what();
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) {
    // "The following arguments were not expected: 5 --rat": the words in reverse.
    std::string word = message.substr(message.rfind(": ") + 2);
    const auto option = word.find("--");
    word = option != std::string::npos ? word.substr(option) : word.substr(word.rfind(' ') + 1);
    word = word.substr(0, word.find_first_of(" ="));
    message = fmt::format("'{}' is not known here{}", word, suggestion(app, word));
  }
  fmt::print(stderr, "gyrobudget: {}\nRun gyrobudget --help, or gyrobudget VERB --help.\n", message);
  return {exit_usage};
}

std::string command_line(int argc, const char* const* argv) {
  std::string line = "gyrobudget";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain =
        !word.empty() && word.find_first_of(" \t\n'\"\\$`*?[](){}<>|&;#~!") == std::string::npos;
    if (plain) {
      line += " " + word;
      continue;
    }
    line += " '";
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += "'";
  }
  return line;
}

}  // namespace

Arguments parse_arguments(int argc, const char* const* argv) {
  CLI::App app(
      "From a gyro log to a navigation error budget, stating its own error at every step.\n\n"
      "  gyrobudget calibrate imu.csv --report datasheet.html\n"
      "  gyrobudget simulate examples/sensors/mems.yaml --duration 10h -o mems.csv\n",
      "gyrobudget");
  app.set_version_flag("-V,--version", fmt::format("gyrobudget {}", kVersion));
  app.require_subcommand(0, 1);
  app.formatter(std::make_shared<Formatter>());
  SimulateArguments simulate;
  AllanArguments allan;
  CalibrateArguments calibrate;
  PlanArguments plan;
  AccuracyArguments accuracy;
  PaperArguments paper;
  NavigateArguments navigate;
  BudgetArguments budget;
  FlyArguments fly;
  Texts texts;
  const auto* calibrate_verb = add_calibrate(app, calibrate, texts);
  const auto* allan_verb = add_allan(app, allan, texts);
  const auto* simulate_verb = add_simulate(app, simulate, texts);
  const auto* plan_verb = add_plan(app, plan, texts);
  const auto* accuracy_verb = add_accuracy(app, accuracy, texts);
  const auto* paper_verb = add_paper(app, paper, texts);
  const auto* navigate_verb = add_navigate(app, navigate);
  const auto* budget_verb = add_budget(app, budget, texts);
  const auto* fly_verb = add_fly(app, fly, texts);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return answer(app, error);
  }
  const std::string line = command_line(argc, argv);
  if (calibrate_verb->parsed()) {
    finish(calibrate, texts);
    calibrate.common.command_line = line;
    return calibrate;
  }
  if (allan_verb->parsed()) {
    finish(allan, texts);
    allan.common.command_line = line;
    return allan;
  }
  if (simulate_verb->parsed()) {
    finish(simulate, texts);
    simulate.common.command_line = line;
    return simulate;
  }
  if (plan_verb->parsed()) {
    finish(plan, texts);
    plan.common.command_line = line;
    return plan;
  }
  if (accuracy_verb->parsed()) {
    finish(accuracy, texts);
    accuracy.common.command_line = line;
    return accuracy;
  }
  if (paper_verb->parsed()) {
    paper.seed = seed(texts.seed);
    paper.common.command_line = line;
    return paper;
  }
  if (navigate_verb->parsed()) {
    navigate.common.command_line = line;
    return navigate;
  }
  if (budget_verb->parsed()) {
    finish(budget, texts);
    budget.common.command_line = line;
    return budget;
  }
  if (fly_verb->parsed()) {
    finish(fly, texts);
    fly.common.command_line = line;
    return fly;
  }
  fmt::print(stderr, "{}", app.help());
  return Answered{exit_usage};
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/analysis.h"
#include "gyrobudget/allan/estimator.h"
#include "gyrobudget/app/files/trajectory_file.h"
#include "gyrobudget/app/log/log.h"
#include "gyrobudget/estimation/budget/components.h"
#include "gyrobudget/estimation/calibration/calibrate.h"
#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/estimation/fit/plan.h"
#include "gyrobudget/estimation/fit/requirement.h"
#include "gyrobudget/noise/recorder.h"
#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/noise/simulation.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// What the command line asks for, one struct per verb, already checked and in SI. Only app.cpp knows CLI11.
namespace gyrobudget::inline v0::cli {

/// Options that every verb has.
struct Common {
  bool json = false;
  bool quiet = false;
  int threads = 0;           ///< 0: all cores
  std::string command_line;  ///< as typed, to repeat the run
};

/// Pictures and pages beside the main output.
struct Pictures {
  std::string report;  ///< path of the HTML page; empty: none
  std::string plot;    ///< path of the picture; empty: none
};

/// A whole IMU along a trajectory instead of a sensor at rest.
struct FlightArguments {
  std::string trajectory;  ///< as files::read_trajectory has it
  std::string truth;       ///< path of the truth; empty: none
  std::string fixes;       ///< folder for those of the scene's aids; empty: none
  files::AttitudeForm attitude = files::AttitudeForm::quaternion;
  log::Input input = log::Input::rate;  ///< what the log holds, or increments
  double vibration = 0;                 ///< [m/s^2 rms]
  std::uint64_t run = 0;
};

struct SimulateArguments {
  Common common;
  std::string sensor;
  double duration_s = 0;  ///< infinite: until the reader has enough; 0: the whole trajectory
  double rate_hz = 100;
  std::optional<double> sensor_rate_hz;  ///< as PlanArguments has it
  noise::SimulationModel model;
  std::string model_name = "spectral";  ///< as typed
  std::uint64_t skipped = 0;            ///< samples left out at the start
  std::uint64_t seed = 1;
  std::vector<int> axes;  ///< 0, 1, 2 for x, y, z
  std::string unit;       ///< of the gyro columns; empty: rad/s
  std::optional<noise::TemperatureProfile> temperature;
  std::string output = "-";
  log::Format format = log::Format::csv;
  std::optional<FlightArguments> flight;
};

/// How a log is turned into a curve, shared by allan and calibrate.
struct CurveArguments {
  log::LogOptions log;
  allan::Taus taus;
  allan::Form form = allan::Form::full;
  double minimum_fill = allan::kMinimumFill;  ///< part of a cluster's samples that must exist
};

struct AllanArguments {
  Common common;
  Pictures pictures;
  CurveArguments curve;
  std::vector<std::string> segments;  ///< further logs, pooled with the first into one curve
  std::optional<double> gap_s;        ///< each log is cut where more than this is missing
  std::vector<allan::Estimator> estimators{allan::Estimator::oadev};
  std::int64_t overlap = 0;  ///< terms begin every m/overlap samples; 0: at every sample, of a stream every m/16
  std::optional<allan::SpectrumMethod> psd;  ///< beside the deviation, in the page and the JSON
  std::optional<double> dynamic_s;           ///< window of the dynamic deviation
  bool stream = false;                       ///< read piece by piece, in constant memory
  bool follow = false;                       ///< stream, and show the table while the log grows
};

struct CalibrateArguments {
  Common common;
  Pictures pictures;
  CurveArguments curve;
  std::vector<std::string> logs;     ///< several: records of one sensor type
  std::optional<double> gap_s;       ///< cut each where more than this is missing, into records
  std::string curve_file;            ///< a table of deviations instead of a log
  std::optional<double> duration_s;  ///< of the record behind a curve file
  calibration::Options options;      ///< but for what `curve` says
  std::string output;                ///< sensor file
  bool update = false;               ///< the sensor file is there already, and keeps what else it holds
  std::string kalibr;                ///< imu.yaml
  double kalibr_horizon_s = 100;     ///< over which a walk stands for 1/f noise in it
  std::string name;                  ///< of the sensor, for the sensor file
  bool timing = false;               ///< run times stand in the JSON
};

struct InspectArguments {
  Common common;
  std::string log;
};

struct ExportArguments {
  Common common;
  std::string sensor;
  std::string form;
  double rate_hz = 0;                    ///< of the IMU whose samples the other tool takes
  std::optional<double> sensor_rate_hz;  ///< as PlanArguments has it
  double horizon_s = 100;                ///< over which a walk stands for 1/f noise
  std::string output = "-";
};

struct PlanArguments {
  Common common;
  std::string sensor;
  double rate_hz = 100;
  std::optional<double> sensor_rate_hz;  ///< the same where it was given: of sigmas of a sample in the sensor file
  std::optional<double> duration_s;
  std::vector<fit::PlanOptions::Wish> wishes;
};

struct AccuracyArguments {
  Common common;
  std::string sensor;
  noise::Signal signal = noise::Signal::angular_rate;  ///< which of the sensor's two
  std::optional<std::size_t> axis;                     ///< 0, 1, 2 for x, y, z; unset: all are to be alike
  std::optional<noise::Recorder> recorder;             ///< that the records are simulated behind
  calibration::Options calibrate;                      ///< of such records
  double duration_s = 36'000;
  double rate_hz = 1;
  std::optional<double> sensor_rate_hz;  ///< as PlanArguments has it
  std::optional<int> records;
  std::vector<fit::Method> methods;
  std::optional<std::vector<noise::Term>> terms;  ///< unset: N, B, K, and Q and R where the sensor has them
  std::uint64_t seed = 1;
  std::vector<fit::Requirement> requirements;
  std::string report;             ///< path of the HTML page; empty: none
  bool sweep = false;             ///< error against run time instead
  std::optional<double> longest;  ///< record of the sweep [samples]; unset: 1e7
};

struct PaperArguments {
  Common common;
  std::string report;  ///< path of the HTML page; empty: none
  std::uint64_t seed = 1;
};

struct NavigateArguments {
  Common common;
  std::string scene;
  std::string data_folder;  ///< where the scene's logs are; empty: beside the scene
  std::string output;       ///< CSV of the solution; empty: none
  std::string innovations;  ///< CSV; empty: none
  bool smooth = false;      ///< also where the scene does not say so
  std::string report;       ///< path of the HTML page; empty: none
};

struct BudgetArguments {
  Common common;
  std::string scene;
  std::vector<std::string> sensors;  ///< in place of the scene's, side by side
  std::optional<double> at;          ///< time of the table [s]; unset: the end
  double tolerance = 1e-3;           ///< of each total that may be left out
  bool keep_all = false;
  double step = 0;           ///< of the covariance [s]; 0: by the scene's length
  double rate = 100;         ///< of the IMU [Hz]
  bool exact = false;        ///< the same by integrals over structure functions
  int runs = 0;              ///< of Monte Carlo
  bool each_source = false;  ///< and so many of each source alone
  std::uint64_t seed = 1;
  struct Limit {
    std::string text;  ///< as typed
    budget::Component component = budget::Component::rss;
    double metres = 0;
  };
  std::optional<Limit> limit;
  std::string report;  ///< path of the HTML page; empty: none
};

struct FlyArguments {
  Common common;
  std::vector<std::string> scenes;   ///< side by side
  std::vector<std::string> sensors;  ///< in place of the scene's, "ideal" too; with one scene
  int runs = 0;                      ///< of Monte Carlo, of each kind
  std::uint64_t seed = 1;
  std::string output;  ///< path of the flight's CSV; empty: none
  double rate = 10;    ///< of its rows [Hz]
  std::string report;  ///< path of the HTML page; empty: none
};

/// The command line was answered already (--help, --version) or is wrong.
struct Answered {
  int exit_code = 0;
};

using Arguments =
    std::variant<Answered, SimulateArguments, AllanArguments, CalibrateArguments, InspectArguments, ExportArguments,
                 PlanArguments, AccuracyArguments, PaperArguments, NavigateArguments, BudgetArguments, FlyArguments>;

/// Reads the command line; prints help, version and usage errors itself.
[[nodiscard]] Arguments parse_arguments(int argc, const char* const* argv);

}  // namespace gyrobudget::inline v0::cli

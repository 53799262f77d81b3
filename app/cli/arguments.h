// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/fit/fit.h"
#include "gyrobudget/io/log.h"

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// What the command line asks for, one struct per verb, already checked and in SI. Only arguments.cpp knows CLI11.
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

struct SimulateArguments {
  Common common;
  std::string sensor;
  double duration_s = 0;
  double rate_hz = 100;
  std::string model = "spectral";
  std::uint64_t seed = 1;
  std::vector<std::string> axes;  ///< x, y, z
  std::string unit;               ///< of the gyro columns; empty: rad/s
  std::string output = "-";
};

/// How a log is turned into a curve, shared by allan and calibrate.
struct CurveArguments {
  io::LogOptions log;
  std::string taus;  ///< octave, decade, all, or a count
  bool ieee_form = false;
  bool strict_gaps = false;
};

struct AllanArguments {
  Common common;
  Pictures pictures;
  CurveArguments curve;
};

struct CalibrateArguments {
  Common common;
  Pictures pictures;
  CurveArguments curve;
  std::string curve_file;                         ///< a table of deviations instead of a log
  std::optional<double> duration_s;               ///< of the record behind a curve file
  std::optional<std::vector<noise::Term>> terms;  ///< unset: N, B, K, and Q where the first tau shows it
  fit::Method method = fit::Method::gls;
  std::optional<double> tau_min_s, tau_max_s;
  std::string output;  ///< sensor file
  std::string kalibr;  ///< imu.yaml
  std::string name;    ///< of the sensor, for the sensor file
};

struct PlanArguments {
  Common common;
  std::string sensor;
  double rate_hz = 100;
  std::optional<double> duration_s;
  struct Wish {
    noise::Term term = noise::Term::flicker;
    double relative_std = 0.1;
  };
  std::vector<Wish> wishes;
};

/// The command line was answered already (--help, --version) or is wrong.
struct Answered {
  int exit_code = 0;
};

using Arguments =
    std::variant<Answered, SimulateArguments, AllanArguments, CalibrateArguments, PlanArguments>;

/// Reads the command line; prints help, version and usage errors itself.
[[nodiscard]] Arguments parse_arguments(int argc, const char* const* argv);

}  // namespace gyrobudget::inline v0::cli

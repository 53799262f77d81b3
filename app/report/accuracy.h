// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/fit/accuracy.h"
#include "gyrobudget/estimation/fit/requirement.h"
#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <string>
#include <vector>

// How wrong fits are, measured on simulated records of known truth, and what each bit of accuracy costs in time.
namespace gyrobudget::inline v0::report {

struct AccuracyStudy {
  std::string sensor;  ///< its name
  std::string command;
  noise::Signal signal = noise::Signal::angular_rate;
  int asked = 0;  ///< records; fewer where it was interrupted
  fit::Accuracy accuracy;
  std::vector<fit::Check> checks;  ///< of the limits that were asked for
};

/// What the numbers mean, one thing each.
[[nodiscard]] std::vector<std::string> accuracy_words(const AccuracyStudy&);
/// Tables and words for the terminal.
[[nodiscard]] std::string accuracy_table(const AccuracyStudy&);
/// The fields are described by schema/accuracy-1.schema.json, which is installed with the program. Shares and errors are
/// fractions, errors relative to the truth; `*_std` are binomial standard errors.
[[nodiscard]] std::string accuracy_json(const AccuracyStudy&);
/// One HTML page that opens offline, with plots.
[[nodiscard]] std::string accuracy_page(const AccuracyStudy&);

/// One way to fit in the table of error against run time.
struct SweepRow {
  struct Coefficient {
    noise::Term term = noise::Term::white;
    double rmse = 0;          ///< relative to the truth
    double over_default = 0;  ///< over that of the default on the same records
    double over_bound = 0;
    double coverage = 0;
  };
  std::string group;    ///< "taus an octave"
  std::string setting;  ///< "2"
  bool is_default = false;
  std::int64_t samples = 0;
  int records = 0;
  int unconverged = 0;
  std::vector<Coefficient> coefficients;
  double curve_seconds = 0,
         fit_seconds = 0;         ///< of one record, the first decile; the curve's is 0 where none is made
  double covariance_seconds = 0;  ///< once for all axes of a log; 0 where none is made
};

struct Sweep {
  std::string sensor;
  std::string command;
  noise::Signal signal = noise::Signal::angular_rate;
  double rate_hz = 0;
  std::uint64_t seed = 0;
  bool complete = false;
  double seconds = 0;
  std::vector<SweepRow> rows;
};

/// Which defaults follow from the rows, and by how much.
[[nodiscard]] std::vector<std::string> sweep_words(const Sweep&);
[[nodiscard]] std::string sweep_table(const Sweep&);
/// The fields are described by schema/accuracy_sweep-1.schema.json, which is installed with the program.
[[nodiscard]] std::string sweep_json(const Sweep&);
[[nodiscard]] std::string sweep_page(const Sweep&);

}  // namespace gyrobudget::inline v0::report

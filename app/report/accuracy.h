// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/fit/accuracy.h"
#include "gyrobudget/estimation/fit/requirement.h"
#include "gyrobudget/estimation/fit/sweep.h"
#include "gyrobudget/noise/sensor.h"

#include <cstdint>
#include <string>
#include <string_view>
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
/// The fields are described by schema/accuracy-1.schema.json, which is installed with the program. Shares and errors
/// are fractions, errors relative to the truth; `*_std` are binomial standard errors.
[[nodiscard]] std::string accuracy_json(const AccuracyStudy&);
/// One HTML page that opens offline, with plots.
[[nodiscard]] std::string accuracy_page(const AccuracyStudy&);

/// A sweep over ways to fit, with what it is of.
struct SweepStudy {
  std::string sensor;  ///< its name
  std::string command;
  noise::Signal signal = noise::Signal::angular_rate;
  double rate_hz = 0;
  std::uint64_t seed = 0;
  fit::Sweep sweep;
};

/// What a row's group compares, "taus an octave", and what the row itself is, "2".
[[nodiscard]] std::string_view group_of(const fit::SweepRow&);
[[nodiscard]] std::string setting_of(const fit::SweepRow&);

/// Which defaults follow from the rows, and by how much.
[[nodiscard]] std::vector<std::string> sweep_words(const SweepStudy&);
[[nodiscard]] std::string sweep_table(const SweepStudy&);
/// The fields are described by schema/accuracy_sweep-1.schema.json, which is installed with the program.
[[nodiscard]] std::string sweep_json(const SweepStudy&);
[[nodiscard]] std::string sweep_page(const SweepStudy&);

}  // namespace gyrobudget::inline v0::report

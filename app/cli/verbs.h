// SPDX-License-Identifier: MIT
#pragma once

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// The program's exit codes.
enum Exit : int {
  exit_done = 0,
  exit_no_answer =
      1,  ///< ran, but an axis has no answer: not described, nothing resolved, not converged; or a limit is broken
  exit_usage = 2,
  exit_bad_input = 3,
  exit_bad_output = 4,
  exit_interrupted = 130,
};

// One verb per file; each returns an exit code and throws text::InputError, text::OutputError or std::invalid_argument.
[[nodiscard]] int run(const SimulateArguments&);         ///< sensor file -> log
[[nodiscard]] int run_flight(const SimulateArguments&);  ///< with `flight`: sensor file, trajectory -> log
[[nodiscard]] int run(const AllanArguments&);            ///< log -> deviations
[[nodiscard]] int run_stream(const AllanArguments&);     ///< with `stream`: read piece by piece, in constant memory
[[nodiscard]] int run(const CalibrateArguments&);        ///< log -> datasheet
[[nodiscard]] int run(const InspectArguments&);          ///< log -> what is in it
[[nodiscard]] int run(const ExportArguments&);           ///< sensor file -> the form of another tool
[[nodiscard]] int run(const PlanArguments&);             ///< sensor file -> recording time or accuracy
[[nodiscard]] int run(const AccuracyArguments&);         ///< sensor file -> how wrong the fits are
/// With `sweep`: every way to fit records of this truth, error against run time.
[[nodiscard]] int run_sweep(const AccuracyArguments&, const std::string& sensor,
                            const std::vector<noise::Process>& truth);
[[nodiscard]] int run(const PaperArguments&);     ///< the source paper's tables and figures beside ours
[[nodiscard]] int run(const NavigateArguments&);  ///< scene with a recorded IMU log -> navigation solution
[[nodiscard]] int run(const BudgetArguments&);    ///< scene -> error budget per source
[[nodiscard]] int run(const FlyArguments&);       ///< scene with a flight -> flight in closed loop

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/report/result.h"

#include <string>

namespace gyrobudget::inline v0::report {

[[nodiscard]] std::string allan_table(const LogResult&);       ///< text for the terminal
[[nodiscard]] std::string datasheet(const LogResult&);         ///< text for the terminal
[[nodiscard]] std::string allan_json(const LogResult&);        ///< schema gyrobudget.allan/1
[[nodiscard]] std::string calibration_json(const LogResult&);  ///< schema gyrobudget.calibration/1
[[nodiscard]] std::string page(const LogResult&);              ///< self-contained HTML, opens offline
/// Picture of the deviation curves by gnuplot; format by ending: .svg, .png, .pdf.
/// @throws std::invalid_argument for another ending, io::OutputError where gnuplot fails or the file cannot be written.
void write_plot(const LogResult&, const std::string& path);

}  // namespace gyrobudget::inline v0::report

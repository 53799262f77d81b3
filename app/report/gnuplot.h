// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

namespace gyrobudget::inline v0::report {

/// Runs a script in gnuplot and gives back what it draws to its standard output. No shell, no file on disk, no
/// start-up file of the user's; the decimal sign is a point whatever the locale.
/// @throws text::OutputError where gnuplot is missing (naming the package) or fails (with its own words).
[[nodiscard]] std::string run_gnuplot(const std::string& script);

/// Text as a gnuplot string: inside single quotes neither back-quotes nor backslashes mean anything.
[[nodiscard]] std::string gnuplot_string(std::string_view text);

}  // namespace gyrobudget::inline v0::report

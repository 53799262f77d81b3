// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>
#include <string>

namespace gyrobudget::inline v0::io {

/// Input unreadable, malformed or too short; the program exits with 3. The message names place, finding, expectation
/// and mend: "log.csv:17:3: found 'abc', expected a number; ...".
struct InputError : std::runtime_error { using std::runtime_error::runtime_error; };
/// Output could not be written; exit 4.
struct OutputError : std::runtime_error { using std::runtime_error::runtime_error; };

}  // namespace gyrobudget::inline v0::io

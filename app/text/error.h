// SPDX-License-Identifier: MIT
#pragma once

#include <stdexcept>

namespace gyrobudget::inline v0::text {

/// Input unreadable, malformed or too short; the program exits with 3. The message names place, finding, expectation
/// and mend: "log.csv:17:3: found 'abc' in column 'gyro_x', expected a number; ...".
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Output could not be written; the program exits with 4. The message names the path, the system's reason and a mend.
struct OutputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace gyrobudget::inline v0::text

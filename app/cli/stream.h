// SPDX-License-Identifier: MIT
#pragma once

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// allan --stream and --follow: the log is read piece by piece, in constant memory.
[[nodiscard]] int run_stream(const AllanArguments&);

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "entries.h"

namespace gyrobudget::fuzz {

/// Logs of autopilots, arrays, and packed ones. HDF5 is not among them: its library is not ours to mend.
[[nodiscard]] std::vector<Entry> recording_entries();

}  // namespace gyrobudget::fuzz

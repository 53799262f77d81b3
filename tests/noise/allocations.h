// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

namespace gyrobudget::tests {

/// How often operator new was called so far by this program.
[[nodiscard]] std::size_t allocations();

}  // namespace gyrobudget::tests

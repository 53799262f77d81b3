// SPDX-License-Identifier: MIT
#pragma once

/// Calls of operator new by this program so far.
long allocations();

// SPDX-License-Identifier: MIT
// A libFuzzer program for one entry: GYROBUDGET_FUZZ_ENTRY is its name. An exception that leaves ends the program.
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "entries.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace gyrobudget::fuzz;
  static const Entry& entry = *std::ranges::find(entries(), GYROBUDGET_FUZZ_ENTRY, &Entry::name);
  entry.run({reinterpret_cast<const char*>(data), size});
  return 0;
}

// SPDX-License-Identifier: MIT
#include "terminal.h"

#include "gyrobudget/io/output.h"

#include <cstdio>

namespace gyrobudget::inline v0::cli {

void say(const Common& common, std::string_view line) {
  if (!common.quiet) std::fprintf(stderr, "%.*s\n", static_cast<int>(line.size()), line.data());
}

void print(std::string_view text) { io::write_file("-", text); }

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
// The command line: which verb, and what it is asked.
#include "arguments.h"

#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/version.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "options.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

std::string command_line(int argc, const char* const* argv) {
  std::string line = "gyrobudget";
  for (int i = 1; i < argc; ++i) line += " " + text::shell_word(argv[i]);
  return line;
}

}  // namespace

Arguments parse_arguments(int argc, const char* const* argv) {
  App app("gyrobudget",
          "From a gyro log to a navigation error budget, stating its own error at every step.\n\n"
          "  gyrobudget calibrate imu.csv --report datasheet.html\n"
          "  gyrobudget simulate examples/sensors/mems.yaml --duration 10h -o mems.csv\n",
          fmt::format("gyrobudget {}", kVersion));
  const std::vector verbs{inspect_verb(app),  calibrate_verb(app), allan_verb(app),    simulate_verb(app),
                          export_verb(app),   plan_verb(app),      accuracy_verb(app), paper_verb(app),
                          navigate_verb(app), budget_verb(app),    fly_verb(app)};
  if (const auto exit_code = app.parse(argc, argv)) return Answered{*exit_code};
  const auto verb = std::ranges::find_if(verbs, [](const Verb& v) { return v.app->parsed(); });
  if (verb == verbs.end()) {
    fmt::print(stderr, "{}", app.help());
    return Answered{exit_usage};
  }
  Arguments arguments = verb->arguments();
  std::visit(
      [&](auto& a) {
        if constexpr (requires { a.common; }) a.common.command_line = command_line(argc, argv);
      },
      arguments);
  return arguments;
}

}  // namespace gyrobudget::inline v0::cli

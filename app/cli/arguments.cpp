// SPDX-License-Identifier: MIT
// The command line: verbs, help, errors of use.
#include "arguments.h"

#include "gyrobudget/noise/version.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "options.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

// --- Help -----------------------------------------------------------------------------------------------------------

// The list of verbs shows what each is for, without its examples.
class Formatter : public CLI::Formatter {
 public:
  Formatter() { column_width(30); }
  std::string make_subcommand(const CLI::App* verb) const override {
    const std::string description = verb->get_description();
    return fmt::format("  {:<12}{}\n", verb->get_name(), description.substr(0, description.find('\n')));
  }

  // A group of options under its own name instead of "[Option Group: Log]", "  Options:".
  std::string make_expanded(const CLI::App* group) const override {
    std::string options = make_groups(group, CLI::AppFormatMode::Sub);
    options = options.substr(options.find(':') + 2);  // behind "Options:\n"
    return fmt::format("\n{}:\n{}", group->get_group(), options);
  }
};

// --- Errors of use --------------------------------------------------------------------------------------------------

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitute = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitute});
    }
  }
  return row.back();
}

// "; did you mean --rate?" for an unknown word, or nothing where no name is near.
std::string suggestion(const CLI::App& app, const std::string& word) {
  std::string best;
  std::size_t nearest = 3;
  const auto consider = [&](const std::string& name) {
    if (const auto distance = edit_distance(word, name); distance < nearest) nearest = distance, best = name;
  };
  for (const auto* verb : app.get_subcommands({})) {
    if (!verb->get_name().empty()) consider(verb->get_name());
    if (!verb->parsed() && !verb->get_name().empty()) continue;
    for (const auto* option : verb->get_options()) {
      for (const auto& name : option->get_lnames()) consider("--" + name);
    }
    for (const auto* group : verb->get_subcommands({})) {
      for (const auto* option : group->get_options()) {
        for (const auto& name : option->get_lnames()) consider("--" + name);
      }
    }
  }
  return best.empty() ? "" : fmt::format("; did you mean {}?", best);
}

Answered answer(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) {  // --help and --version
    app.exit(error);
    return {exit_done};
  }
  std::string message = error.what();
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError)) {
    // "The following arguments were not expected: 5 --rat": the words in reverse.
    std::string word = message.substr(message.rfind(": ") + 2);
    const auto option = word.find("--");
    word = option != std::string::npos ? word.substr(option) : word.substr(word.rfind(' ') + 1);
    word = word.substr(0, word.find_first_of(" ="));
    message = fmt::format("'{}' is not known here{}", word, suggestion(app, word));
  }
  fmt::print(stderr, "gyrobudget: {}\nRun gyrobudget --help, or gyrobudget VERB --help.\n", message);
  return {exit_usage};
}

std::string command_line(int argc, const char* const* argv) {
  std::string line = "gyrobudget";
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = !word.empty() && word.find_first_of(" \t\n'\"\\$`*?[](){}<>|&;#~!") == std::string::npos;
    if (plain) {
      line += " " + word;
      continue;
    }
    line += " '";
    for (const char c : word) line += c == '\'' ? std::string("'\\''") : std::string(1, c);
    line += "'";
  }
  return line;
}

}  // namespace

Arguments parse_arguments(int argc, const char* const* argv) {
  CLI::App app(
      "From a gyro log to a navigation error budget, stating its own error at every step.\n\n"
      "  gyrobudget calibrate imu.csv --report datasheet.html\n"
      "  gyrobudget simulate examples/sensors/mems.yaml --duration 10h -o mems.csv\n",
      "gyrobudget");
  app.set_version_flag("-V,--version", fmt::format("gyrobudget {}", kVersion));
  app.require_subcommand(0, 1);
  app.formatter(std::make_shared<Formatter>());
  const std::vector verbs{calibrate_verb(app), allan_verb(app),    simulate_verb(app),
                          plan_verb(app),      accuracy_verb(app), paper_verb(app),
                          navigate_verb(app),  budget_verb(app),   fly_verb(app)};
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return answer(app, error);
  }
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

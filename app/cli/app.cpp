// SPDX-License-Identifier: MIT
// Verbs and options by CLI11: help and errors of use.
#include "app.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <sstream>
#include <utility>

#include "terminal.h"
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

int answer(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) {  // --help and --version
    std::ostringstream words;        // app.exit() would not tell that they could not be written
    app.exit(error, words, words);
    print(words.str());
    return exit_done;
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
  complain(fmt::format("gyrobudget: {}\nRun gyrobudget --help, or gyrobudget VERB --help.", message));
  return exit_usage;
}

// What a shell makes of a variable that is not set.
std::string refuse_empty(std::string& text) {
  return text.empty() ? "the value is empty; was a variable of the shell not set?" : "";
}

}  // namespace

// --- Options --------------------------------------------------------------------------------------------------------

Option* Option::type_name(const std::string& name) { return option_->type_name(name), this; }
Option* Option::description(const std::string& help) { return option_->description(help), this; }
Option* Option::required() { return option_->required(), this; }
Option* Option::capture_default_str() { return option_->capture_default_str(), this; }
Option* Option::check(const IsMember& allowed) { return option_->check(CLI::IsMember(allowed.words)), this; }
Option* Option::check(Range<int> allowed) { return option_->check(CLI::Range(allowed.least, allowed.most)), this; }
Option* Option::check(Range<double> allowed) { return option_->check(CLI::Range(allowed.least, allowed.most)), this; }
Option* Option::needs(const std::string& other) { return option_->needs(other), this; }
Option* Option::needs(Option* other) { return option_->needs(other->option_), this; }
Option* Option::excludes(Option* other) { return option_->excludes(other->option_), this; }
Option* Option::delimiter(char separator) { return option_->delimiter(separator), this; }
Option* Option::allow_extra_args(bool several) { return option_->allow_extra_args(several), this; }

// --- Verbs and groups -----------------------------------------------------------------------------------------------

App::App(const std::string& name, const std::string& description, const std::string& version)
    : program_(std::make_unique<CLI::App>(description, name)), app_(program_.get()) {
  app_->set_version_flag("-V,--version", version);
  app_->require_subcommand(0, 1);
  app_->formatter(std::make_shared<Formatter>());
}
App::App(CLI::App* inner) : app_(inner) {}
App::~App() = default;

App* App::add_subcommand(const std::string& name, const std::string& description) {
  return inner_.emplace_back(new App(app_->add_subcommand(name, description))).get();
}
App* App::add_option_group(const std::string& heading) {
  return inner_.emplace_back(new App(app_->add_option_group(heading))).get();
}

Option* App::kept(CLI::Option* option) { return &options_.emplace_back(option); }
template <class Value>
Option* App::add_option(const std::string& names, Value& value, const std::string& help) {
  CLI::Option* option = app_->add_option(names, value, help);
  if (names.starts_with('-')) option->check(CLI::Validator(refuse_empty, ""));
  return kept(option);
}
Option* App::add_flag(const std::string& names, bool& value, const std::string& help) {
  return kept(app_->add_flag(names, value, help));
}
Option* App::get_option(const std::string& name) { return kept(app_->get_option(name)); }
void App::footer(const std::string& text) { app_->footer(text); }

bool App::parsed() const { return app_->parsed(); }
std::string App::help() const { return app_->help(); }
std::optional<int> App::parse(int argc, const char* const* argv) try {
  app_->parse(argc, argv);
  return {};
} catch (const CLI::ParseError& error) {
  return answer(*app_, error);
}

// What options may fill.
template Option* App::add_option(const std::string&, std::string&, const std::string&);
template Option* App::add_option(const std::string&, std::optional<std::string>&, const std::string&);
template Option* App::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option* App::add_option(const std::string&, int&, const std::string&);
template Option* App::add_option(const std::string&, std::int64_t&, const std::string&);
template Option* App::add_option(const std::string&, double&, const std::string&);
template Option* App::add_option(const std::string&, std::optional<double>&, const std::string&);

}  // namespace gyrobudget::inline v0::cli

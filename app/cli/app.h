// SPDX-License-Identifier: MIT
// Inside the command line: verbs and options as CLI11 has them, under the same names. Its header alone takes 3.4 s to
// compile, so app.cpp is the one file that includes it, and these stand for its classes everywhere else.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace gyrobudget::inline v0::cli {

/// One of these words.
struct IsMember {
  std::vector<std::string> words;
};
/// A number from `least` to `most`: whole ones for options of whole numbers.
template <class Number>
struct Range {
  Number least, most;
};
template <class Number>
Range(Number, Number) -> Range<Number>;

/// An option of a verb; each function gives the option itself, so that calls are chained.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  /// What stands for its value in --help.
  Option* type_name(const std::string& name);
  Option* description(const std::string& help);
  Option* required();
  /// Shows the value it has now in --help.
  Option* capture_default_str();
  Option* check(const IsMember& allowed);
  Option* check(Range<int> allowed);
  Option* check(Range<double> allowed);
  /// Without that other one it is an error of use.
  Option* needs(const std::string& other);
  Option* needs(Option* other);
  /// Beside that other one it is an error of use.
  Option* excludes(Option* other);
  /// Parts the values of one word.
  Option* delimiter(char separator);
  /// Whether it takes several words, as an option of a list does.
  Option* allow_extra_args(bool several);

 private:
  CLI::Option* option_;
};

/// The program, a verb of it, or a group of options under a heading of its own in --help. Who made it owns it, and what
/// the options are to fill must live until the line is parsed.
class App {
 public:
  /// The program.
  App(const std::string& name, const std::string& description, const std::string& version);
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  App* add_subcommand(const std::string& name, const std::string& description);
  App* add_option_group(const std::string& heading);
  /// `value` is a text, a list of texts, a number or one that may be unset: the end of app.cpp has the types.
  template <class Value>
  Option* add_option(const std::string& names, Value& value, const std::string& help);
  Option* add_flag(const std::string& names, bool& value, const std::string& help);
  /// The one of that name; throws where there is none.
  [[nodiscard]] Option* get_option(const std::string& name);
  void footer(const std::string& text);

  [[nodiscard]] bool parsed() const;
  [[nodiscard]] std::string help() const;
  /// Parses the line; where that leads to no verb, prints help, the version or what is wrong, and gives an exit code.
  [[nodiscard]] std::optional<int> parse(int argc, const char* const* argv);

 private:
  explicit App(CLI::App* inner);
  Option* kept(CLI::Option* option);

  std::unique_ptr<CLI::App> program_;  ///< of the program alone
  CLI::App* app_;
  std::deque<std::unique_ptr<App>> inner_;
  std::deque<Option> options_;
};

}  // namespace gyrobudget::inline v0::cli

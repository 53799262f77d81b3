// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gyrobudget::tests {

/// What the program did.
struct Outcome {
  int exit_code = 0;
  std::string out;
  std::string err;
};

/// A folder of its own, empty at first, gone at the end.
class Scratch {
 public:
  Scratch();
  ~Scratch();
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  /// Writes a file and returns its path.
  std::string file(const std::string& name, std::string_view text) const;
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] std::size_t files() const;  ///< how many there are

 private:
  std::filesystem::path folder_;
};

/// Runs `gyrobudget ARGUMENTS` (a shell line) and waits. Where it prints one of the program's JSON objects, that has to
/// conform to its published schema; so does that of `shell`.
[[nodiscard]] Outcome gyrobudget_run(const std::string& arguments);
/// Runs any shell line; %P in it is the program's path.
[[nodiscard]] Outcome shell(std::string line);

}  // namespace gyrobudget::tests

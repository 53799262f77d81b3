// SPDX-License-Identifier: MIT
#include "paths.h"

#include "gyrobudget/app/text/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <stdexcept>

namespace gyrobudget::inline v0::cli {
namespace {

namespace fs = std::filesystem;

// The same regular file, or what will be one; devices may be named as often as one likes.
bool same_file(const std::string& a, const std::string& b) {
  if (a.empty() || b.empty() || a == "-" || b == "-") return false;
  std::error_code ignored;
  const bool exist = fs::exists(a, ignored) && fs::exists(b, ignored);
  if (exist) return fs::is_regular_file(a, ignored) && fs::equivalent(a, b, ignored);
  return fs::absolute(a, ignored).lexically_normal() == fs::absolute(b, ignored).lexically_normal();
}

// Before hours of work, not after: the folder must be there, and an option is not a name.
void check_name(const Output& output) {
  if (output.path.size() > 1 && output.path.front() == '-') {
    throw std::invalid_argument(
        fmt::format("{0} {1}: {1} looks like an option; a file of that name is ./{1}", output.option, output.path));
  }
  std::error_code ignored;
  const fs::path folder = fs::path(output.path).parent_path();
  if (folder.empty() || fs::is_directory(folder, ignored)) return;
  throw text::OutputError(fmt::format("{} {}: found no folder {}; make it, or name a file in one that is there",
                                      output.option, output.path, folder.string()));
}

void check_picture(const Output& output) {
  const std::string ending = fs::path(output.path).extension().string();
  constexpr std::array kFormats{".svg", ".png", ".pdf"};
  if (std::ranges::find(kFormats, ending) == kFormats.end()) {
    throw std::invalid_argument(fmt::format("{} {}: a picture ends in .svg, .png or .pdf", output.option, output.path));
  }
}

}  // namespace

void check_outputs(const std::string& input, const std::vector<Output>& outputs) {
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const Output& output = outputs[i];
    if (output.path.empty()) continue;
    if (output.path == "-") {
      throw std::invalid_argument(fmt::format("{} -: standard output holds the result; name a file", output.option));
    }
    check_name(output);
    if (same_file(output.path, input)) {
      throw std::invalid_argument(
          fmt::format("{} {}: that is the input; name another file", output.option, output.path));
    }
    for (std::size_t j = 0; j < i; ++j) {
      if (same_file(output.path, outputs[j].path)) {
        throw std::invalid_argument(
            fmt::format("{} and {} name the same file, {}", outputs[j].option, output.option, output.path));
      }
    }
    if (output.option == "--plot") check_picture(output);
  }
}

}  // namespace gyrobudget::inline v0::cli

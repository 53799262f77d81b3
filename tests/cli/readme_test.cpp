// SPDX-License-Identifier: MIT
// The README's blocks between "<!-- run: COMMAND -->" or "<!-- file: PATH -->" and "<!-- end -->" are what the command
// prints and what the file holds. GYROBUDGET_UPDATE_README=1 rewrites them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "program.h"

namespace gyrobudget::tests {
namespace {

const std::string kRoot = GYROBUDGET_EXAMPLES "/..";

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

std::string output_of(const std::string& command) {
  const std::string line =
      replaced(replaced(command, "example_calibrate", "'" GYROBUDGET_EXAMPLE "'"), "gyrobudget ", "%P ");
  const Outcome outcome = shell("cd '" + kRoot + "' && " + line);
  EXPECT_EQ(outcome.exit_code, 0) << command << "\n" << outcome.err;
  return outcome.out;
}

// What belongs between the two comments, fenced.
std::string block(const std::string& kind, const std::string& what) {
  if (kind == "file") return "\n```cpp\n" + contents(kRoot + "/" + what) + "```\n\n";
  return "\n```\n" + output_of(what) + "```\n\n";
}

TEST(Readme, ShowsWhatTheProgramPrints) {
  const std::string readme = contents(kRoot + "/README.md");
  std::string expected;
  std::size_t at = 0, blocks = 0;
  for (const std::string begin = "<!-- ", end = "<!-- end -->"; at < readme.size();) {
    const std::size_t open = readme.find(begin, at), close = readme.find(" -->\n", open);
    const std::size_t colon = readme.find(": ", open);
    if (open == std::string::npos || close == std::string::npos) break;
    const std::size_t body = close + 5, stop = readme.find(end, body);
    ASSERT_NE(stop, std::string::npos) << "a block without end";
    const std::string kind = readme.substr(open + begin.size(), colon - open - begin.size());
    expected += readme.substr(at, body - at) + block(kind, readme.substr(colon + 2, close - colon - 2)) + end;
    at = stop + end.size();
    ++blocks;
  }
  expected += readme.substr(at);
  EXPECT_EQ(blocks, 5U);
  if (std::getenv("GYROBUDGET_UPDATE_README") != nullptr)
    std::ofstream(kRoot + "/README.md", std::ios::binary) << expected;
  EXPECT_EQ(readme, expected) << "run this test with GYROBUDGET_UPDATE_README=1 and look at the difference";
}

}  // namespace
}  // namespace gyrobudget::tests

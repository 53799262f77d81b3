// SPDX-License-Identifier: MIT
#include "program.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "../app/report/published_schemas.h"
#include "../json.h"

namespace gyrobudget::tests {
namespace {

std::string contents(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// Whatever a test looks at, other programs rely on all of it.
void check_schema(const std::string& out) {
  if (!out.starts_with('{')) return;
  const auto json = parsed<nlohmann::json>(out);
  const std::string name = json.is_object() && json.contains("schema") ? json["schema"].dump() : "";
  if (name.starts_with("\"gyrobudget.")) expect_schema(json);
}

}  // namespace

Scratch::Scratch() {
  std::string name = (std::filesystem::temp_directory_path() / "gyrobudget-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no scratch folder");
  folder_ = name;
}

Scratch::~Scratch() {
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string Scratch::file(const std::string& name, std::string_view text) const {
  std::ofstream(folder_ / name, std::ios::binary) << text;
  return path(name);
}

std::size_t Scratch::files() const {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++count;
  return count;
}

Outcome shell(std::string line) {
  const std::string program = "'" GYROBUDGET_PROGRAM "'";
  for (std::size_t at = 0; (at = line.find("%P", at)) != std::string::npos; at += program.size()) {
    line.replace(at, 2, program);
  }
  const Scratch scratch;
  const std::string out = scratch.path("out"), err = scratch.path("err");
  const int status = std::system(("( " + line + " ) >'" + out + "' 2>'" + err + "' </dev/null").c_str());
  Outcome run;
  run.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  run.out = contents(out);
  run.err = contents(err);
  check_schema(run.out);
  return run;
}

Outcome gyrobudget_run(const std::string& arguments) { return shell("%P " + arguments); }

}  // namespace gyrobudget::tests

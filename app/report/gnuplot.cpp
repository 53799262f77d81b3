// SPDX-License-Identifier: MIT
#include "gnuplot.h"

#include "gyrobudget/app/text/error.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using text::OutputError;

[[noreturn]] void fail(std::string_view what, int error) {
  throw OutputError(fmt::format("cannot draw with gnuplot: {}: {}", what, std::strerror(error)));
}

/// A file in memory without a name: script and output need no place on disk, and no two pipes can block each other.
class MemoryFile {
 public:
  explicit MemoryFile(const char* name) : descriptor_(memfd_create(name, MFD_CLOEXEC)) {
    if (descriptor_ < 0) fail("no memory for a file", errno);
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  [[nodiscard]] int descriptor() const { return descriptor_; }

  void fill(std::string_view bytes) const {
    for (std::size_t done = 0; done < bytes.size();) {
      const ssize_t count = write(descriptor_, bytes.data() + done, bytes.size() - done);
      if (count < 0 && errno != EINTR) fail("the script could not be kept in memory", errno);
      if (count > 0) done += static_cast<std::size_t>(count);
    }
    lseek(descriptor_, 0, SEEK_SET);
  }

  [[nodiscard]] std::string content() const {
    std::string bytes;
    lseek(descriptor_, 0, SEEK_SET);
    std::array<char, 1 << 16> buffer{};
    for (;;) {
      const ssize_t count = read(descriptor_, buffer.data(), buffer.size());
      if (count < 0 && errno != EINTR) fail("its output could not be read", errno);
      if (count == 0) return bytes;
      if (count > 0) bytes.append(buffer.data(), static_cast<std::size_t>(count));
    }
  }

 private:
  int descriptor_;
};

/// Standard input, output and error of a child.
class Redirection {
 public:
  Redirection(const MemoryFile& in, const MemoryFile& out, const MemoryFile& err) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_adddup2(&actions_, in.descriptor(), STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, out.descriptor(), STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions_, err.descriptor(), STDERR_FILENO);
  }
  ~Redirection() { posix_spawn_file_actions_destroy(&actions_); }
  Redirection(const Redirection&) = delete;
  Redirection& operator=(const Redirection&) = delete;
  [[nodiscard]] const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

pid_t start(const Redirection& redirection) {
  // "-d": no start-up files; "-": commands come from standard input.
  std::array<std::string, 3> words = {"gnuplot", "-d", "-"};
  std::array<char*, 4> arguments = {words[0].data(), words[1].data(), words[2].data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawnp(&child, "gnuplot", redirection.get(), nullptr, arguments.data(), environ);
  if (error == ENOENT) {
    throw OutputError(
        "cannot draw the figure: the program gnuplot was not found; install the Debian package gnuplot-nox (apt-get install gnuplot-nox)");
  }
  if (error != 0) fail("it could not be started", error);
  return child;
}

/// True where the child ended by itself and without an error.
bool finished_well(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) fail("lost sight of it", errno);
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

std::string run_gnuplot(const std::string& script) {
  const MemoryFile in("gnuplot script"), out("gnuplot output"), err("gnuplot messages");
  in.fill(script);
  const bool good = finished_well(start(Redirection(in, out, err)));
  std::string picture = out.content();
  if (!good || picture.empty()) {
    const std::string message = err.content();
    throw OutputError("cannot draw the figure: gnuplot failed" + (message.empty() ? "" : ": " + message));
  }
  return picture;
}

std::string gnuplot_string(std::string_view text) {
  std::string quoted = "'";
  for (const char c : printable(text)) {
    if (c == '\'') quoted += '\'';
    quoted += c;
  }
  return quoted + '\'';
}

}  // namespace gyrobudget::inline v0::report

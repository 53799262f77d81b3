// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// A line for the person at the terminal: stderr, unless --quiet.
void say(const Common&, std::string_view line);

/// A message, whatever names are in it: what a terminal would obey becomes blanks.
void complain(std::string_view line);

/// The verb's result, names in it as complain() has them: stdout. @throws text::OutputError where it cannot be written.
void print(std::string_view text);

/// Writes an HTML page and says where. @throws text::OutputError where it cannot be written.
void write_page(const std::string& path, std::string_view page, const Common&);

/// A bar with the time left on stderr, where that is a terminal and --quiet is not given; gone when this ends.
class Progress {
 public:
  /// @param of what: "records".
  Progress(const Common&, std::string of_what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Draws at most ten times a second.
  void update(double done, double of);

 private:
  using Clock = std::chrono::steady_clock;
  std::string of_what_;
  bool shown_;
  Clock::time_point start_ = Clock::now(), drawn_{};
};

/// While one exists, the first interrupt (Ctrl-C, SIGTERM) asks the work to stop, and the second ends the program.
class Interruption {
 public:
  Interruption() noexcept;
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;
  [[nodiscard]] const std::atomic<bool>& asked() const noexcept;
};

/// Work that is shown and may be stopped: what a study tells of its progress. It answers false once it is asked to
/// stop.
class Watch {
 public:
  /// @param of_what "records".
  Watch(const Common& common, std::string of_what) : progress_(common, std::move(of_what)) {}
  bool operator()(std::int64_t done, std::int64_t of) {
    progress_.update(static_cast<double>(done), static_cast<double>(of));
    return !interrupted();
  }
  [[nodiscard]] bool interrupted() const { return interruption_.asked(); }

 private:
  Progress progress_;
  Interruption interruption_;
};

/// For the handler of signals: true where an Interruption takes this one. Async-signal-safe.
[[nodiscard]] bool taken_by_interruption() noexcept;

}  // namespace gyrobudget::inline v0::cli

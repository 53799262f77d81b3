// SPDX-License-Identifier: MIT
#include "live_table.h"

#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/output.h"

#include <unistd.h>

#include "terminal.h"

namespace gyrobudget::inline v0::cli {
namespace {

constexpr const char* kClear = "\x1b[H\x1b[2J";

}  // namespace

LiveTable::LiveTable() : terminal_(isatty(STDOUT_FILENO) == 1) {}

void LiveTable::update(std::int64_t samples, const std::function<report::LogResult()>& result) {
  if (samples < 2 || !due(samples)) return;
  const std::string table = report::allan_table(result());
  if (terminal_) text::write_file("-", kClear);
  print(terminal_ ? table : table + '\n');
  shown_ = samples;
}

void LiveTable::finish(std::int64_t samples, const report::LogResult& result) {
  if (samples == shown_) return;
  if (terminal_) text::write_file("-", kClear);
  print(report::allan_table(result));
}

bool LiveTable::due(std::int64_t samples) {
  if (!terminal_) {
    if (samples < next_) return false;
    while (next_ <= samples) next_ *= 2;
    return true;
  }
  const auto now = Clock::now();
  if (samples == shown_ || now - last_ < std::chrono::seconds{1}) return false;
  last_ = now;
  return true;
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
#include "terminal.h"

#include "gyrobudget/app/text/output.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace gyrobudget::inline v0::cli {
namespace {

std::atomic<bool> someone_listens{false}, interrupt_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a handler of signals may set it");

}  // namespace

void say(const Common& common, std::string_view line) {
  if (!common.quiet) complain(line);
}

void complain(std::string_view line) { std::fprintf(stderr, "%s\n", text::printable_lines(line).c_str()); }

void print(std::string_view text) { text::write_file("-", text::printable_lines(text)); }

void write_page(const std::string& path, std::string_view page, const Common& common) {
  text::write_file(path, page);
  say(common, "report page: " + path);
}

Progress::Progress(const Common& common, std::string of_what)
    : of_what_(std::move(of_what)), shown_(!common.quiet && isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (shown_) std::fputs("\r\x1b[K", stderr);
}

void Progress::update(double done, double of) {
  constexpr auto kBetween = std::chrono::milliseconds(100);
  const auto now = Clock::now();
  if (!shown_ || now - drawn_ < kBetween) return;
  drawn_ = now;
  constexpr int kWidth = 30;
  const double part = std::clamp(done / of, 0.0, 1.0);
  const int full = static_cast<int>(part * kWidth);
  const double spent = std::chrono::duration<double>(now - start_).count();
  fmt::print(stderr, "\r[{:#<{}}{:.<{}}] {:.0f} % of the {}, {} left \x1b[K", "", full, "", kWidth - full, 100 * part,
             of_what_,
             part > 0 ? text::duration_text(spent * (1 - part) / part, text::DurationForm::rough) : "some time");
  std::fflush(stderr);
}

Interruption::Interruption() noexcept {
  interrupt_asked = false;
  someone_listens = true;
}

Interruption::~Interruption() { someone_listens = false; }

const std::atomic<bool>& Interruption::asked() const noexcept { return interrupt_asked; }

bool taken_by_interruption() noexcept { return someone_listens && !interrupt_asked.exchange(true); }

}  // namespace gyrobudget::inline v0::cli

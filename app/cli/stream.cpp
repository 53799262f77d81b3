// SPDX-License-Identifier: MIT
// allan --stream and --follow: deviations of a log that is never in memory as a whole.
#include "stream.h"

#include "gyrobudget/allan/statistics.h"
#include "gyrobudget/allan/streaming.h"
#include "gyrobudget/app/log/stream.h"
#include "gyrobudget/app/report/report.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "analysis.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

constexpr std::int64_t kOverlap = 16;

// --- The stream ---------------------------------------------------------------------------------------------------------

std::string efficiency_note(std::int64_t overlap) {
  // Of the degrees of freedom of white noise, in percent; statistics.h.
  const double loss = overlap >= 4 ? 125.0 / static_cast<double>(overlap * overlap) : overlap == 2 ? 27 : 56;
  return fmt::format(
      "read as a stream: octaves only, terms begin every m/{0} samples above m = {0}; that costs white noise {1:.2g} % of the degrees of freedom, flicker and random walk less, quantization more; they stand in the table",
      overlap, loss);
}

/// The log so far.
class Streamed {
 public:
  explicit Streamed(const AllanArguments& a)
      : arguments_(a), log_(a.curve.log), overlap_(a.overlap > 0 ? a.overlap : kOverlap) {
    const allan::StreamingOptions options{.overlap = overlap_,
                                          .minimum_fill = a.curve.strict_gaps ? 1 : allan::kMinimumFill};
    axes_.assign(log_.columns().size(), allan::StreamingDeviation(1 / log_.rate_hz(), options));
    for (const auto& note : log_.notes()) say(a.common, "note: " + note);
  }

  /// @returns false at the end
  bool advance() {
    constexpr std::chrono::milliseconds kPatience{200};
    const auto progress = log_.read(rates_, kPatience);
    tbb::parallel_for(std::size_t{0}, axes_.size(), [&](std::size_t i) { axes_[i].push(rates_[i]); });
    return progress != log::LogStream::Progress::end;
  }

  [[nodiscard]] std::int64_t samples() const { return axes_.front().samples(); }

  void require_samples() const {
    if (samples() >= 2) return;
    throw text::InputError(
        fmt::format("{}: holds {} samples, expected at least 2; record longer", log_.source(), samples()));
  }

  [[nodiscard]] report::LogResult result() const {
    report::LogResult result;
    result.source = log_.source();
    result.command = arguments_.common.command_line;
    result.rate_hz = log_.rate_hz();
    result.samples = samples();
    result.missing_samples = log_.missing_samples();
    result.notes = log_.notes();
    result.notes.push_back(efficiency_note(overlap_));
    for (std::size_t i = 0; i < axes_.size(); ++i) {
      const allan::Curve curve = axes_[i].curve();
      report::AxisResult& out = result.axes.emplace_back();
      out.name = log_.columns()[i].name;
      out.signal = log_.columns()[i].signal;
      out.mean = curve.mean;
      out.points = allan::deviation_points(curve, allan::identify_noise(curve));
    }
    return result;
  }

 private:
  const AllanArguments& arguments_;
  log::LogStream log_;
  std::int64_t overlap_;
  std::vector<allan::StreamingDeviation> axes_;
  std::vector<std::vector<double>> rates_;
};

// --- Showing it -----------------------------------------------------------------------------------------------------------

/// Prints the table while the log grows: once a second in place of the last one on a terminal, else at each doubling.
class Display {
 public:
  void update(const Streamed& log) {
    if (log.samples() < 2 || !due(log.samples())) return;
    print(terminal_ ? "\x1b[H\x1b[2J" + report::allan_table(log.result()) : report::allan_table(log.result()) + '\n');
    shown_ = log.samples();
  }
  /// The table of the whole, unless it is the last that was shown.
  void finish(const Streamed& log, const report::LogResult& result) {
    if (log.samples() == shown_) return;
    print((terminal_ ? "\x1b[H\x1b[2J" : "") + report::allan_table(result));
  }

 private:
  using Clock = std::chrono::steady_clock;

  bool due(std::int64_t samples) {
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

  bool terminal_ = isatty(STDOUT_FILENO) == 1;
  Clock::time_point last_;
  std::int64_t shown_ = 0;
  std::int64_t next_ = 1024;
};

}  // namespace

int run_stream(const AllanArguments& a) {
  check_outputs(a.curve.log.path, {{"--report", a.pictures.report}, {"--plot", a.pictures.plot}});
  Streamed log(a);
  Display display;
  const bool shows = a.follow && !a.common.json;
  std::optional<Interruption> interruption;  // of a stream that is followed: the last table is printed
  if (a.follow) interruption.emplace();
  const auto interrupted = [&] { return interruption && interruption->asked(); };
  while (!interrupted() && log.advance()) {
    if (shows) display.update(log);
  }
  if (interrupted() && log.samples() < 2) return exit_interrupted;
  log.require_samples();
  const report::LogResult result = log.result();
  if (shows) {
    display.finish(log, result);
  } else {
    print(a.common.json ? report::allan_json(result) : report::allan_table(result));
  }
  write_pictures(result, a.pictures, a.common);
  return interrupted() ? exit_interrupted : exit_done;
}

}  // namespace gyrobudget::inline v0::cli

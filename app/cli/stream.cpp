// SPDX-License-Identifier: MIT
// allan --stream and --follow: deviations of a log that is never in memory as a whole.
#include "gyrobudget/app/log/stream.h"

#include "gyrobudget/allan/analysis.h"
#include "gyrobudget/app/report/analysis.h"
#include "gyrobudget/app/report/report.h"
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "analysis.h"
#include "live_table.h"
#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

/// Axes that hold an answer; those of columns without numbers are left out, and the record's notes say so.
allan::Analysis answered(const log::LogStream& log, allan::Analysis analysis, allan::Record& record) {
  std::vector<std::string> empty;
  std::vector<allan::AxisAnalysis> axes;
  for (std::size_t i = 0; i < analysis.axes.size(); ++i) {
    if (log.numbers().at(i) >= 2)
      axes.push_back(std::move(analysis.axes[i]));
    else
      empty.push_back(text::quoted(log.columns()[i].name));
  }
  if (!empty.empty()) record.notes.push_back(fmt::format("left out {} (fewer than two numbers)", text::listing(empty)));
  analysis.axes = std::move(axes);
  return analysis;
}

report::LogResult result_of(const log::LogStream& log, const allan::StreamingAnalysis& stream, std::int64_t overlap,
                            const AllanArguments& a) {
  allan::Record read{.source = log.source(),
                     .rate_hz = log.rate_hz(),
                     .samples = stream.samples(),
                     .missing_samples = log.missing_samples(),
                     .notes = log.notes()};
  read.notes.push_back(report::stream_note(overlap));
  const allan::Analysis analysis = answered(log, stream.analysis(), read);
  return report::log_result(std::span(&read, 1), analysis, a.common.command_line);
}

void print_result(const report::LogResult& result, const AllanArguments& a) {
  print(a.common.json ? report::allan_json(result) : report::allan_table(result));
}

}  // namespace

int run_stream(const AllanArguments& a) {
  check_outputs(a.curve.log.path, {{"--report", a.pictures.report}, {"--plot", a.pictures.plot}});
  log::LogStream log(a.curve.log);
  for (const auto& note : log.notes()) say(a.common, "note: " + note);
  const std::int64_t overlap = a.overlap > 0 ? a.overlap : allan::StreamingOptions{}.overlap;
  allan::StreamingAnalysis stream(log.columns(), log.rate_hz(),
                                  {.overlap = overlap, .minimum_fill = a.curve.minimum_fill});
  const auto result = [&] { return result_of(log, stream, overlap, a); };
  std::optional<LiveTable> table;
  std::optional<Interruption> interruption;  // of a stream that is followed: the last table is printed
  if (a.follow) interruption.emplace();
  if (a.follow && !a.common.json) table.emplace();
  const auto interrupted = [&] { return interruption && interruption->asked(); };
  constexpr std::chrono::milliseconds kPatience{200};
  std::vector<std::vector<double>> rates;
  for (auto progress = log::LogStream::Progress::none; !interrupted() && progress != log::LogStream::Progress::end;) {
    progress = log.read(rates, kPatience);
    stream.push(rates);
    if (table && progress != log::LogStream::Progress::end) table->update(stream.samples(), result);
  }
  if (interrupted() && (stream.samples() < 2 || std::ranges::max(log.numbers()) < 2)) return exit_interrupted;
  // Of a column that was asked for, no note is enough.
  const std::int64_t numbers =
      a.curve.log.columns.empty() ? std::ranges::max(log.numbers()) : std::ranges::min(log.numbers());
  if (numbers < 2) {
    throw text::InputError(fmt::format("{}: holds {} samples and {} numbers in a column, expected at least 2; {}",
                                       log.source(), stream.samples(), numbers,
                                       stream.samples() < 2 ? "record longer" : "check what wrote it"));
  }
  const report::LogResult whole = result();
  table ? table->finish(stream.samples(), whole) : print_result(whole, a);
  write_pictures(whole, a.pictures, a.common);
  return interrupted() ? exit_interrupted : exit_done;
}

}  // namespace gyrobudget::inline v0::cli

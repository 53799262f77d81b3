// SPDX-License-Identifier: MIT
#include "named_file.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "dialects.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kNamedChunk = std::size_t{1} << 20;  // of a text for one task

/// The fields of a stream, behind its clock where it has one.
Layout layout_of_stream(const StreamInfo& stream) {
  Layout layout;
  if (!stream.clock.empty()) layout.headings.push_back({std::string(kTimeColumn.name), "ns", 1});
  for (const Field& field : stream.fields) layout.headings.push_back({field.name, field.unit, 1});
  layout.columns = layout.headings.size();
  return layout;
}

/// Units that the program which wrote a text has by its format, where its header has none; with a factor before them
/// where a number counts several: "100 us".
void take_units_of_dialect(Layout& layout) {
  const auto dialect = recognise(layout);
  if (!dialect) return;
  for (std::size_t i = 0; i < layout.headings.size(); ++i) {
    const ToldUnit& told = dialect->columns[i];
    if (!layout.headings[i].unit.empty() || told.unit.empty()) continue;
    layout.headings[i].unit = told.scale == 1 ? told.unit : fmt::format("{} {}", told.scale, told.unit);
  }
}

}  // namespace

NamedFile::NamedFile(const std::string& path, const std::optional<std::string>& topic, const StreamUse& use)
    : path_(text::input_name(path)), name_(path_), recording_(open_recording(path)) {
  if (!recording_) {
    if (topic) text::fail(name_, fmt::format("{} {}: it is no recording with topics", use.topic, text::quoted(*topic)));
    source_.emplace(path);
    layout_ = read_layout(*source_);
    take_units_of_dialect(layout_);
    reader_.emplace(*source_, layout_, kNamedChunk);
    return;
  }
  try {
    stream_ = choose_stream(*recording_, name_, topic, use);
  } catch (const std::invalid_argument& error) {  // which of a command line would be wrong usage
    throw text::InputError(error.what());
  }
  layout_ = layout_of_stream(*stream());
  name_ = fmt::format("{}, {}", name_, text::printable(stream()->name));
}

bool NamedFile::has(std::string_view heading) const {
  return std::ranges::find(layout_.headings, heading, &Heading::name) != layout_.headings.end();
}

Table NamedFile::read(const Choice& choice, std::vector<std::string>& notes) const {
  bool ignored = false;
  return read(choice, notes, ignored);
}

Table NamedFile::read(const Choice& choice, std::vector<std::string>& notes, bool& is_decimated) const {
  return recording_ ? read_stream(choice, notes, is_decimated) : reader_->read(choice);
}

Table NamedFile::read_stream(const Choice& choice, std::vector<std::string>& notes, bool& is_decimated) const {
  const bool has_clock = !stream()->clock.empty();
  const std::size_t before = has_clock ? 1 : 0;  // headings before those of the fields
  std::vector<std::size_t> fields;
  for (const DataColumn& c : choice.data) {
    if (c.index < before) text::fail(name_, fmt::format("{} is its clock, expected a number", text::quoted(c.name)));
    fields.push_back(c.index - before);
  }
  const bool time_is_a_field = !choice.stamps.empty() && choice.stamps.front().index >= before;
  if (time_is_a_field) fields.push_back(choice.stamps.front().index - before);
  Rows rows = recording_->read(stream_, fields);
  if (time_is_a_field) {
    rows.stamps_ns = stamps_of(rows.columns.back(), choice.stamps.front().ns_per_unit);
    rows.columns.pop_back();
  } else if (has_clock) {
    put_in_order(rows);
  }
  Table table;
  table.rows = rows.columns.empty() ? rows.stamps_ns.size() : rows.columns.front().size();
  table.stamps = std::move(rows.stamps_ns);
  table.numbers = std::move(rows.columns);
  table.complete = false;
  for (std::size_t i = 0; i < table.numbers.size(); ++i)
    for (double& x : table.numbers[i]) x *= choice.data[i].to_si;
  for (const std::string& note : recording_->notes()) notes.push_back(fmt::format("{}: {}", path_, note));
  for (const std::string& note : rows.notes) notes.push_back(fmt::format("{}: {}", name_, note));
  is_decimated = rows.is_decimated;
  return table;
}

void NamedFile::fail_row(std::size_t row, const std::string& message) const {
  if (reader_) text::fail_at(name_, reader_->line_of_row(row), 1, message);
  text::fail(name_, fmt::format("row {}: {}", row + 1, message));
}

void NamedFile::check_stamps(const Table& table) const {
  for (std::size_t row = 0; row < table.rows; ++row) {
    if (table.stamps[row] == text::kNoStamp) fail_row(row, "found no time, expected one in every row");
    if (row > 0 && table.stamps[row] <= table.stamps[row - 1])
      fail_row(row, "found a time that is not after the one before, expected times that ascend");
  }
}

}  // namespace gyrobudget::inline v0::log

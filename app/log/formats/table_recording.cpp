// SPDX-License-Identifier: MIT
#include "table_recording.h"

#include "rows.h"

namespace gyrobudget::inline v0::log {

TableRecording::TableRecording(std::string format, std::vector<StreamTable> streams, std::vector<std::string> notes)
    : format_(std::move(format)), notes_(std::move(notes)) {
  for (StreamTable& table : streams) {
    table.info.count = static_cast<std::int64_t>(table.rows.stamps_ns.size());
    table.rows.clock = table.info.clock;
    streams_.push_back(std::move(table.info));
    rows_.push_back(std::move(table.rows));
  }
}

Rows TableRecording::read(std::size_t stream, std::span<const std::size_t> fields) const {
  check_request(streams_, stream, fields);
  const Rows& all = rows_[stream];
  Rows rows{.stamps_ns = all.stamps_ns, .clock = all.clock, .columns = {}, .notes = all.notes};
  for (const std::size_t field : fields) rows.columns.push_back(all.columns[field]);
  finish(rows, streams_[stream], fields);
  return rows;
}

}  // namespace gyrobudget::inline v0::log

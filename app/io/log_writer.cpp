// SPDX-License-Identifier: MIT
#include "gyrobudget/io/log_writer.h"

#include "gyrobudget/io/output.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <new>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::io {
namespace {

constexpr std::size_t kRowsPerTask = std::size_t{1} << 14;

void check(std::span<const LogColumn> columns, double rate_hz, std::string_view comment) {
  if (columns.empty()) throw std::invalid_argument("a log needs at least one column");
  if (!(std::isfinite(rate_hz) && rate_hz > 0)) {
    throw std::invalid_argument(fmt::format("rate_hz is {} Hz; it must be above 0 and finite", rate_hz));
  }
  for (const LogColumn& c : columns) {
    if (c.values.size() != columns[0].values.size()) {
      throw std::invalid_argument(
          fmt::format("column '{}' has {} values, '{}' has {}; they must be equally long", c.name,
                      c.values.size(), columns[0].name, columns[0].values.size()));
    }
    if (c.name.find_first_of(",\"\r\n") != std::string::npos) {
      throw std::invalid_argument(
          fmt::format("column name '{}' must not hold commas, quotes or line breaks", c.name));
    }
  }
  if (comment.find_first_of("\r\n") != std::string_view::npos) {
    throw std::invalid_argument("the comment of a log must be one line");
  }
}

std::string header(std::span<const LogColumn> columns, std::string_view comment) {
  std::string text = comment.empty() ? std::string() : fmt::format("# {}\n", comment);
  text += "time (s)";
  for (const LogColumn& c : columns) text += fmt::format(",{} ({})", c.name, c.unit);
  return text + '\n';
}

/// The whole of `text` as one gzip member; members one behind the other are one gzip file.
std::string compressed(const std::string& text) {
  constexpr int kWindow = 15 + 16;  // 32 KiB, gzip header and check sum
  constexpr int kMemory = 8;
  z_stream stream = {};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kWindow, kMemory, Z_DEFAULT_STRATEGY) !=
      Z_OK) {
    throw std::bad_alloc();
  }
  std::string result(deflateBound(&stream, text.size()), '\0');
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));  // zlib's interface; only read
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(result.data());
  stream.avail_out = static_cast<uInt>(result.size());
  deflate(&stream, Z_FINISH);
  result.resize(stream.total_out);
  deflateEnd(&stream);
  return result;
}

class Formatter {
 public:
  Formatter(std::span<const LogColumn> columns, double rate_hz) : columns_(columns), rate_hz_(rate_hz) {
    for (const LogColumn& c : columns) to_si_.push_back(noise::parse_unit(c.unit).to_si);
  }

  [[nodiscard]] std::string rows(std::size_t first, std::size_t last) const {
    constexpr std::size_t kLongestNumber = 25;  // -1.7976931348623157e+308 and a delimiter
    std::string text((last - first) * (columns_.size() + 1) * kLongestNumber, '\0');
    char* at = text.data();
    for (std::size_t row = first; row < last; ++row) {
      at = number(at, static_cast<double>(row) / rate_hz_);
      for (std::size_t i = 0; i < columns_.size(); ++i) {
        *at++ = ',';
        at = number(at, columns_[i].values[row] / to_si_[i]);
      }
      *at++ = '\n';
    }
    text.resize(static_cast<std::size_t>(at - text.data()));
    return text;
  }

 private:
  static char* number(char* at, double value) {
    constexpr std::ptrdiff_t kRoom = 24;
    if (std::isnan(value)) return std::copy_n("nan", 3, at);  // never -nan
    return std::to_chars(at, at + kRoom, value).ptr;
  }

  std::span<const LogColumn> columns_;
  double rate_hz_;
  std::vector<double> to_si_;
};

}  // namespace

void write_log(const std::string& path, std::span<const LogColumn> columns, double rate_hz,
               std::string_view comment) {
  check(columns, rate_hz, comment);
  const Formatter formatter(columns, rate_hz);
  const bool gzip = path.ends_with(".gz");
  OutputFile file(path);
  const std::string head = header(columns, comment);
  file.write(gzip ? compressed(head) : head);

  using Rows = std::pair<std::size_t, std::size_t>;
  const std::size_t count = columns[0].values.size();
  std::size_t next = 0;
  const auto cut = [&](tbb::flow_control& control) {
    if (next == count) control.stop();
    const std::size_t first = std::exchange(next, std::min(next + kRowsPerTask, count));
    return Rows{first, next};
  };
  const auto format = [&](const Rows& rows) {
    std::string text = formatter.rows(rows.first, rows.second);
    return gzip ? compressed(text) : text;
  };
  const auto write = [&](const std::string& bytes) { file.write(bytes); };
  const auto in_flight = 2 * static_cast<std::size_t>(tbb::info::default_concurrency());
  tbb::parallel_pipeline(in_flight,
                         tbb::make_filter<void, Rows>(tbb::filter_mode::serial_in_order, cut) &
                             tbb::make_filter<Rows, std::string>(tbb::filter_mode::parallel, format) &
                             tbb::make_filter<std::string, void>(tbb::filter_mode::serial_in_order, write));
  file.commit();
}

}  // namespace gyrobudget::inline v0::io

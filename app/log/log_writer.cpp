// SPDX-License-Identifier: MIT
#include "log_writer.h"

#include "gyrobudget/app/text/output.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>
#include <tbb/info.h>
#include <tbb/parallel_pipeline.h>
#include <zlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <new>
#include <stdexcept>
#include <utility>
#include <vector>

#include "binary.h"

namespace gyrobudget::inline v0::log {
namespace {

constexpr std::size_t kRowsPerTask = std::size_t{1} << 14;

void check(const LogHead& head) {
  if (head.columns.empty()) throw std::invalid_argument("a log needs at least one column");
  if (!(std::isfinite(head.rate_hz) && head.rate_hz > 0)) {
    throw std::invalid_argument(fmt::format("rate_hz is {} Hz; it must be above 0 and finite", head.rate_hz));
  }
  for (const LogHead::Column& c : head.columns) {
    if (c.name.find_first_of(",\"\r\n") != std::string::npos) {
      throw std::invalid_argument(fmt::format("column name '{}' must not hold commas, quotes or line breaks", c.name));
    }
  }
  if (head.comment.find_first_of("\r\n") != std::string::npos) {
    throw std::invalid_argument("the comment of a log must be one line");
  }
}

std::string header(const LogHead& head, std::uint64_t samples) {
  if (head.format == Format::npy) return npy_header(samples, head.columns.size(), true);
  if (head.format != Format::csv) return {};
  std::string text = head.comment.empty() ? std::string() : fmt::format("# {}\n", head.comment);
  text += "time (s)";
  for (const LogHead::Column& c : head.columns) text += fmt::format(",{} ({})", c.name, c.unit);
  return text + '\n';
}

/// The whole of `text` as one gzip member; members one behind the other are one gzip file.
std::string compressed(const std::string& text) {
  constexpr int kWindow = 15 + 16;  // 32 KiB, gzip header and check sum
  constexpr int kMemory = 8;
  z_stream stream = {};
  if (deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kWindow, kMemory, Z_DEFAULT_STRATEGY) != Z_OK) {
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

/// Some rows of a log, from sample `first` on, column after column.
struct Batch {
  std::uint64_t first = 0;
  std::size_t count = 0;
  std::vector<double> values;
};

class Formatter {
 public:
  explicit Formatter(const LogHead& head) : rate_hz_(head.rate_hz), format_(head.format) {
    for (const LogHead::Column& c : head.columns) to_si_.push_back(noise::parse_unit(c.unit).to_si);
  }

  [[nodiscard]] std::string operator()(const Batch& rows) const {
    if (format_ == Format::csv) return text(rows);
    return format_ == Format::f32 ? bytes<float>(rows) : bytes<double>(rows);
  }

 private:
  [[nodiscard]] std::string text(const Batch& rows) const {
    constexpr std::size_t kLongestNumber = 25;  // -1.7976931348623157e+308 and a delimiter
    std::string text(rows.count * (to_si_.size() + 1) * kLongestNumber, '\0');
    char* at = text.data();
    for (std::size_t row = 0; row < rows.count; ++row) {
      at = number(at, static_cast<double>(rows.first + row) / rate_hz_);
      for (std::size_t i = 0; i < to_si_.size(); ++i) {
        *at++ = ',';
        at = number(at, rows.values[i * rows.count + row] / to_si_[i]);
      }
      *at++ = '\n';
    }
    text.resize(static_cast<std::size_t>(at - text.data()));
    return text;
  }

  template <class Number>
  [[nodiscard]] std::string bytes(const Batch& rows) const {
    std::string text(rows.count * to_si_.size() * sizeof(Number), '\0');
    char* at = text.data();
    for (std::size_t row = 0; row < rows.count; ++row) {
      for (std::size_t i = 0; i < to_si_.size(); ++i, at += sizeof(Number)) {
        const auto number = static_cast<Number>(rows.values[i * rows.count + row] / to_si_[i]);
        std::memcpy(at, &number, sizeof(Number));
      }
    }
    return text;
  }

  static char* number(char* at, double value) {
    constexpr std::ptrdiff_t kRoom = 24;
    if (std::isnan(value)) return std::copy_n("nan", 3, at);  // never -nan
    return std::to_chars(at, at + kRoom, value).ptr;
  }

  double rate_hz_;
  Format format_;
  std::vector<double> to_si_;
};

/// The next at most kRowsPerTask rows of those that end before `end`.
Batch produced(std::uint64_t first, std::uint64_t end, std::size_t columns, const LogProducer& produce) {
  Batch rows{first, static_cast<std::size_t>(std::min<std::uint64_t>(kRowsPerTask, end - first)), {}};
  rows.values.resize(rows.count * columns);
  std::vector<std::span<double>> spans;
  for (std::size_t i = 0; i < columns; ++i) {
    spans.push_back(std::span(rows.values).subspan(i * rows.count, rows.count));
  }
  produce(spans);
  return rows;
}

}  // namespace

void write_log(const std::string& path, const LogHead& head, std::uint64_t samples, const LogProducer& produce) {
  check(head);
  const Formatter formatter(head);
  const bool gzip = head.format == Format::csv && path.ends_with(".gz");
  text::OutputFile file(path);
  const std::string top = header(head, samples);
  file.write(gzip ? compressed(top) : top);

  const std::uint64_t end = head.first_sample + samples;
  std::uint64_t next = head.first_sample;
  const auto make = [&](tbb::flow_control& control) {
    if (next == end) {
      control.stop();
      return Batch{};
    }
    Batch rows = produced(next, end, head.columns.size(), produce);
    next += rows.count;
    return rows;
  };
  const auto format = [&](const Batch& rows) {
    std::string text = formatter(rows);
    return gzip ? compressed(text) : text;
  };
  const auto write = [&](const std::string& bytes) { file.write(bytes); };
  const auto in_flight = 2 * static_cast<std::size_t>(tbb::info::default_concurrency());
  tbb::parallel_pipeline(in_flight, tbb::make_filter<void, Batch>(tbb::filter_mode::serial_in_order, make) &
                                        tbb::make_filter<Batch, std::string>(tbb::filter_mode::parallel, format) &
                                        tbb::make_filter<std::string, void>(tbb::filter_mode::serial_in_order, write));
  file.commit();
}

void write_log(const std::string& path, std::span<const LogColumn> columns, double rate_hz, std::string_view comment,
               Format format) {
  LogHead head{{}, rate_hz, std::string(comment), 0, format};
  for (const LogColumn& c : columns) {
    if (c.values.size() != columns[0].values.size()) {
      throw std::invalid_argument(fmt::format("column '{}' has {} values, '{}' has {}; they must be equally long",
                                              c.name, c.values.size(), columns[0].name, columns[0].values.size()));
    }
    head.columns.push_back({c.name, c.unit});
  }
  std::size_t at = 0;
  write_log(path, head, columns.empty() ? 0 : columns[0].values.size(), [&](std::span<const std::span<double>> out) {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      std::copy_n(columns[i].values.begin() + static_cast<std::ptrdiff_t>(at), out[i].size(), out[i].begin());
    }
    at += out[0].size();
  });
}

}  // namespace gyrobudget::inline v0::log

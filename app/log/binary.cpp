// SPDX-License-Identifier: MIT
#include "binary.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>

#include "compression.h"
#include "layout.h"

namespace gyrobudget::inline v0::log {
namespace {

static_assert(std::endian::native == std::endian::little, "raw numbers are copied as they are");

using namespace std::string_view_literals;
constexpr std::string_view kMagic = "\x93NUMPY"sv;
constexpr std::size_t kShortPrefix = 10, kLongPrefix = 12;  // magic, version, length of 2 or 4 bytes
/// NumPy writes some hundred bytes for an array of numbers, and reads 10 000 unless it is told otherwise.
constexpr std::size_t kLongestHeader = std::size_t{1} << 16;

std::size_t little_endian(std::string_view bytes) {
  std::size_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8U | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// Reads the Python dictionary in the header of a .npy, and nothing but what NumPy writes there.
class HeaderParser {
 public:
  HeaderParser(std::string_view name, std::string_view text) : name_(name), text_(text) {}

  NpyHeader read() {
    NpyHeader header;
    unsigned seen = 0;
    expect('{');
    while (!accept('}')) {
      const std::string_view key = string();
      expect(':');
      if (key == "descr") {
        header.descr = string();
        seen |= 1U;
      } else if (key == "fortran_order") {
        header.fortran_order = boolean();
        seen |= 2U;
      } else if (key == "shape") {
        header.shape = tuple();
        seen |= 4U;
      } else {
        wrong("one of the keys descr, fortran_order and shape");
      }
      if (!accept(',') && peek() != '}') wrong("a comma or a brace");
    }
    if (seen != 7U) wrong("the keys descr, fortran_order and shape");
    if (peek() != '\0') wrong("nothing behind the dictionary");
    return header;
  }

 private:
  [[noreturn]] void wrong(std::string_view expected) const {
    text::fail(name_, fmt::format("its header holds {} at byte {}, expected {}; write the array with numpy.save",
                                  at_ < text_.size() ? text::quoted(text_.substr(at_)) : "nothing", at_, expected));
  }
  char peek() {
    while (at_ < text_.size() && (text::is_blank(text_[at_]) || text_[at_] == '\n')) ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool accept(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) wrong(fmt::format("'{}'", c));
  }
  std::string_view string() {
    const char quote = peek();
    if (quote == '[') {
      text::fail(
          name_,
          "holds records of several fields, expected numbers (dtype <f4 or <f8); save the columns as one array: numpy.save(file, numpy.column_stack([a['x'], a['y']]))");
    }
    if (quote != '\'' && quote != '"') wrong("text in quotes");
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) wrong("text in quotes");
    const std::string_view value = text_.substr(at_ + 1, end - at_ - 1);
    at_ = end + 1;
    return value;
  }
  bool boolean() {
    peek();
    for (const auto& [word, value] : {std::pair{"True"sv, true}, std::pair{"False"sv, false}}) {
      if (!text_.substr(at_).starts_with(word)) continue;
      at_ += word.size();
      return value;
    }
    wrong("True or False");
  }
  std::vector<std::int64_t> tuple() {
    std::vector<std::int64_t> numbers;
    expect('(');
    while (!accept(')')) {
      peek();
      std::int64_t value = 0;
      const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
      if (error != std::errc() || value < 0) wrong("a length");
      at_ = static_cast<std::size_t>(end - text_.data());
      numbers.push_back(value);
      if (!accept(',') && peek() != ')') wrong("a comma or a bracket");
    }
    return numbers;
  }

  std::string_view name_, text_;
  std::size_t at_ = 0;
};

bool is_double(std::string_view name, std::string_view descr) {
  if (descr == "<f8") return true;
  if (descr == "<f4") return false;
  const bool big_endian = descr == ">f8" || descr == ">f4";
  text::fail(
      name,
      fmt::format("holds {} (dtype {}), expected little-endian numbers of dtype <f4 or <f8; save array.astype('<f8')",
                  big_endian ? "big-endian numbers" : "other than real numbers", text::quoted(descr)));
}

}  // namespace

std::string_view name(Format format) {
  switch (format) {
    case Format::f32:
      return "f32";
    case Format::f64:
      return "f64";
    case Format::npy:
      return "npy";
    case Format::csv:
      break;
  }
  return "csv";
}

std::optional<Format> format_named(std::string_view wanted) {
  for (const Format f : {Format::csv, Format::f32, Format::f64, Format::npy}) {
    if (name(f) == wanted) return f;
  }
  return std::nullopt;
}

Format format_of(std::string_view full_path) {
  const std::string_view path = without_compression(full_path);
  const std::string ending = text::lower(path.substr(std::min(path.size(), path.rfind('.') + 1)));
  return path.find('.') == std::string_view::npos ? Format::csv : format_named(ending).value_or(Format::csv);
}

std::size_t npy_header_bytes(std::string_view name, std::string_view head) {
  if (!head.starts_with(kMagic.substr(0, head.size())) || head.empty()) {
    text::fail(
        name,
        fmt::format(
            "begins with {}, expected the mark of a .npy, \\x93NUMPY; raw numbers are read with --format f32 or f64, text with --format csv",
            text::quoted(head.substr(0, kMagic.size()))));
  }
  const auto cut = [&]() {
    text::fail(name,
               fmt::format("ends after {} bytes, inside the header of a .npy; it is a damaged copy: copy it again",
                           head.size()));
  };
  if (head.size() < kShortPrefix) cut();
  const int version = static_cast<unsigned char>(head[kMagic.size()]);
  if (version < 1 || version > 3) {
    text::fail(name, fmt::format("is a .npy of version {}, expected 1 to 3; save it again with numpy.save", version));
  }
  if (version == 1) return kShortPrefix + little_endian(head.substr(kMagic.size() + 2, 2));
  if (head.size() < kLongPrefix) cut();
  const std::size_t length = little_endian(head.substr(kMagic.size() + 2, 4));
  if (length <= kLongestHeader) return kLongPrefix + length;
  text::fail(
      name,
      fmt::format(
          "says that its header has {} bytes, expected at most {}; it is damaged, or not from numpy.save: copy it again",
          length, kLongestHeader));
}

NpyHeader parse_npy_header(std::string_view name, std::string_view bytes) {
  const std::size_t size = npy_header_bytes(name, bytes);
  if (bytes.size() < size) {
    text::fail(name, fmt::format("ends after {} bytes, inside a header of {}; it is a damaged copy: copy it again",
                                 bytes.size(), size));
  }
  const std::size_t prefix = bytes[kMagic.size()] == 1 ? kShortPrefix : kLongPrefix;
  NpyHeader header = HeaderParser(name, bytes.substr(prefix, size - prefix)).read();
  header.bytes = size;
  return header;
}

BinaryLayout read_npy_header(std::string_view name, std::string_view bytes) {
  const NpyHeader header = parse_npy_header(name, bytes);
  const auto& shape = header.shape;
  if (shape.empty() || shape.size() > 2) {
    text::fail(
        name,
        fmt::format(
            "holds an array of {} dimensions, expected 1 (samples) or 2 (samples x columns); save array.reshape(len(array), -1)",
            shape.size()));
  }
  if (header.fortran_order && shape.size() == 2 && shape[1] != 1) {
    text::fail(
        name,
        "holds an array in Fortran order, expected C order (sample after sample); save numpy.ascontiguousarray(array)");
  }
  BinaryLayout layout{is_double(name, header.descr), header.bytes, shape.size() == 2 ? shape[1] : 1, shape[0]};
  constexpr std::int64_t kMostColumns = 1 << 16;
  if (layout.columns < 1 || layout.columns > kMostColumns) {
    text::fail(name, fmt::format("holds {} columns, expected 1 to {}; its rows are samples: save array.T",
                                 layout.columns, kMostColumns));
  }
  constexpr std::int64_t kMostRows = std::numeric_limits<std::int64_t>::max() / 16 / kMostColumns;
  if (*layout.rows > kMostRows) text::fail(name, fmt::format("cannot hold {} samples; it is damaged", *layout.rows));
  return layout;
}

std::string npy_header(std::uint64_t rows, std::size_t columns, bool is_double) {
  const std::string shape = columns == 1 ? fmt::format("({},)", rows) : fmt::format("({}, {})", rows, columns);
  std::string text =
      fmt::format("{{'descr': '<f{}', 'fortran_order': False, 'shape': {}, }}", is_double ? 8 : 4, shape);
  constexpr std::size_t kAlignment = 64;
  const std::size_t total = (kShortPrefix + text.size() + 1 + kAlignment - 1) / kAlignment * kAlignment;
  text.resize(total - kShortPrefix - 1, ' ');
  text += '\n';
  std::string header(kMagic);
  header += {'\x01', '\x00', static_cast<char>(text.size() & 0xffU), static_cast<char>(text.size() >> 8U)};
  return header + text;
}

BinaryLayout binary_layout(std::string_view name, std::string_view bytes, Format format, std::int64_t columns) {
  if (format == Format::npy) {
    BinaryLayout layout = read_npy_header(name, bytes);
    if (columns != 1 && columns != layout.columns) {
      text::fail(name, fmt::format("holds {} columns, but --columns says {}; leave it out: the header knows",
                                   layout.columns, columns));
    }
    return layout;
  }
  return {format == Format::f64, 0, columns, std::nullopt};
}

std::string binary_column_name(std::int64_t index) { return fmt::format("column {}", index + 1); }

Choice choose_binary_columns(const std::string& name, const BinaryLayout& layout, const LogOptions& options) {
  if (!options.rate_hz) text::fail(name, "is binary and has no time, expected the sample rate: --rate HZ");
  if (!options.unit) {
    text::fail(name, fmt::format("is binary and has no units, expected that of its numbers: --unit {}",
                                 options.input == Input::rate ? "deg/s" : "rad"));
  }
  Layout text;
  text.columns = static_cast<std::size_t>(layout.columns);
  for (std::int64_t i = 0; i < layout.columns; ++i) {
    text.headings.push_back({binary_column_name(i), "", i + 1});
  }
  text.sample.emplace_back(text.columns, "0");
  return choose_columns(name, text, options);
}

void decode(std::string_view rows, const BinaryLayout& layout, const Choice& choice,
            std::span<const std::span<double>> columns) {
  const auto values = [&]<class Number>(Number) {
    const std::size_t stride = layout.row_bytes();
    const std::size_t count = rows.size() / stride;
    constexpr std::size_t kGrain = std::size_t{1} << 14;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, kGrain), [&](const auto& range) {
      for (std::size_t i = 0; i < columns.size(); ++i) {
        const char* at = rows.data() + choice.data[i].index * sizeof(Number);
        const double to_si = choice.data[i].to_si;
        for (std::size_t row = range.begin(); row != range.end(); ++row) {
          Number number;
          std::memcpy(&number, at + row * stride, sizeof(Number));
          const double value = static_cast<double>(number) * to_si;
          columns[i][row] = std::isfinite(value) ? value : std::numeric_limits<double>::quiet_NaN();
        }
      }
    });
  };
  if (layout.is_double) {
    values(double{});
  } else {
    values(float{});
  }
}

std::int64_t count_rows(std::string_view name, const BinaryLayout& layout, std::uint64_t bytes) {
  const auto row = static_cast<std::uint64_t>(layout.row_bytes());
  if (layout.rows) {
    const std::uint64_t expected = static_cast<std::uint64_t>(*layout.rows) * row;
    if (bytes == expected) return *layout.rows;
    text::fail(
        name,
        fmt::format(
            "holds {} bytes behind its header, expected {} ({} x {} numbers of {} bytes); it is {}: copy it again",
            bytes, expected, *layout.rows, layout.columns, layout.width(),
            bytes < expected ? "truncated" : "not one array, or damaged"));
  }
  if (bytes % row == 0) return static_cast<std::int64_t>(bytes / row);
  text::fail(
      name,
      fmt::format(
          "holds {} bytes, expected a multiple of {} ({} of {} bytes a sample); check --format and --columns, or whether the copy is whole",
          bytes, row, layout.columns == 1 ? "one number" : fmt::format("{} numbers", layout.columns), layout.width()));
}

}  // namespace gyrobudget::inline v0::log

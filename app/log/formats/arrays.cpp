// SPDX-License-Identifier: MIT
#include "arrays.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <new>
#include <utility>

#include "rows.h"

namespace gyrobudget::inline v0::log {
namespace arrays {
namespace {

constexpr std::int64_t kMostColumns = 4096;  // a picture has more, a log has not
constexpr std::int64_t kMostNumbers = std::int64_t{1} << 40;

/// "a, b, c and 3 more"
std::string few(const NameList& names) {
  std::vector<std::string> shown = names.shown;
  if (names.more > 0) shown.push_back(fmt::format("{} more", names.more));
  return text::listing(shown);
}

void add_to(std::vector<NameList>& lists, std::string_view of, std::string_view name) {
  auto list = std::ranges::find(lists, of, &NameList::of);
  constexpr std::size_t kShown = 5, kMostLists = 64;
  if (list == lists.end() && lists.size() == kMostLists) return;  // strangers may think of more
  if (list == lists.end()) list = lists.insert(lists.end(), {std::string(of), {}, 0});
  if (list->shown.size() < kShown) {
    list->shown.emplace_back(name);
  } else {
    ++list->more;
  }
}

/// How MATLAB turns an object of a class into numbers.
struct Export {
  std::string_view class_name, command;
};
constexpr Export kExports[] = {
    {"timetable", "S.t = seconds(x.Time - x.Time(1)); S.v = x{:,:}; save('log.mat', '-struct', 'S', '-v7')"},
    {"table", "S.v = table2array(x); save('log.mat', '-struct', 'S', '-v7')"},
    {"datetime", "t = posixtime(x); save('log.mat', 't', '-v7')"},
    {"duration", "t = seconds(x); save('log.mat', 't', '-v7')"},
    {"timeseries", "S.t = x.Time; S.v = x.Data; save('log.mat', '-struct', 'S', '-v7')"},
};

}  // namespace
}  // namespace arrays

// --- Shapes ---------------------------------------------------------------------------------------------------------

std::optional<ArrayShape> array_shape(std::span<const std::int64_t> dimensions) {
  ArrayShape shape{1, 1};
  int counted_dimensions = 0;
  int place = 0, first_place = 0;
  for (const std::int64_t length : dimensions) {
    ++place;
    if (length < 1) return std::nullopt;
    if (length == 1) continue;
    if (++counted_dimensions > 2 || length > arrays::kMostNumbers) return std::nullopt;
    if (counted_dimensions == 1) first_place = place;
    (counted_dimensions == 1 ? shape.rows : shape.columns) = length;
  }
  if (counted_dimensions == 1) shape.transposed = first_place > 1;
  if (shape.columns > shape.rows) {
    std::swap(shape.rows, shape.columns);
    shape.transposed = true;
  }
  if (shape.columns > arrays::kMostColumns || shape.rows > arrays::kMostNumbers / shape.columns) return std::nullopt;
  return shape;
}

std::string shape_text(std::span<const std::int64_t> dimensions) {
  return dimensions.empty() ? "1" : fmt::format("{}", fmt::join(dimensions, " x "));
}

// --- Streams --------------------------------------------------------------------------------------------------------

ArrayRecording::ArrayRecording(std::string format, std::vector<Array> arrays, std::vector<std::string> notes,
                               std::shared_ptr<const void> keeper)
    : format_(std::move(format)), arrays_(std::move(arrays)), notes_(std::move(notes)), keeper_(std::move(keeper)) {
  list_streams();
  note_single_numbers();
}

void ArrayRecording::list_streams() {
  // The members of each group by their length; groups as they come in the file.
  std::vector<std::string> groups;
  std::map<std::string, std::map<std::int64_t, std::vector<std::size_t>, std::greater<>>> by_length;
  NamesByReason turned;
  for (std::size_t i = 0; i < arrays_.size(); ++i) {
    const Array& array = arrays_[i];
    if (array.shape.rows < 2) continue;
    const auto [found, is_new] = by_length.try_emplace(array.group);
    if (is_new) groups.push_back(array.group);
    found->second[array.shape.rows].push_back(i);
    if (array.shape.transposed && array.shape.columns > 1) {
      turned.add(fmt::format("{} x {} is taken as {} rows of {}", array.shape.columns, array.shape.rows,
                             array.shape.rows, array.shape.columns),
                 array.group.empty() ? array.name : array.group + "." + array.name);
    }
  }
  turned.note(notes_);
  for (const std::string& group : groups) {
    bool is_longest = true;
    for (const auto& [rows, members] : by_length[group]) {
      const std::string& only = arrays_[members.front()].name;
      const std::string base = group.empty() ? "arrays" : group;
      std::string name = is_longest ? base : fmt::format("{} ({} rows)", base, rows);
      if (members.size() == 1 && (group.empty() || !is_longest)) name = group.empty() ? only : group + "." + only;
      add_stream(name, members);
      is_longest = false;
    }
  }
  UniqueNames names;
  for (StreamInfo& stream : streams_) stream.name = names.take(stream.name);
}

void ArrayRecording::add_stream(const std::string& name, const std::vector<std::size_t>& members) {
  StreamInfo info{.name = name};
  info.count = arrays_[members.front()].shape.rows;
  std::vector<Place>& places = places_.emplace_back();
  UniqueNames names;
  for (const std::size_t i : members) {
    const Array& array = arrays_[i];
    for (std::int64_t column = 0; column < array.shape.columns; ++column) {
      const std::string field = array.shape.columns == 1 ? array.name : fmt::format("{}[{}]", array.name, column);
      info.fields.push_back({names.take(field), array.unit, array.unit.empty() ? "" : "the file tells it"});
      places.push_back({i, static_cast<std::size_t>(column)});
    }
  }
  streams_.push_back(std::move(info));
}

void ArrayRecording::note_single_numbers() {
  constexpr std::size_t kMost = 20;
  std::vector<std::string> shown;
  for (const Array& array : arrays_) {
    if (array.shape.rows != 1 || shown.size() == kMost) continue;
    std::array<double, 1> value{};
    const WantedColumn wanted{0, value};
    try {
      array.read({&wanted, 1});
    } catch (const text::InputError&) {
      continue;  // it is of no stream
    }
    shown.push_back(fmt::format("{}{}{} = {:.10g}", array.group, array.group.empty() ? "" : ".", array.name, value[0]));
  }
  if (!shown.empty()) notes_.push_back(fmt::format("single numbers beside: {}", fmt::join(shown, ", ")));
}

Rows ArrayRecording::read(std::size_t stream, std::span<const std::size_t> fields) const {
  check_request(streams_, stream, fields);
  Rows rows;
  rows.columns.resize(fields.size());
  std::map<std::size_t, std::vector<WantedColumn>> of_array;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Place place = places_[stream][fields[i]];
    of_array[place.array].push_back({place.column, {}});
  }
  std::map<std::size_t, std::size_t> next;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Place place = places_[stream][fields[i]];
    rows.columns[i].resize(static_cast<std::size_t>(streams_[stream].count));
    of_array[place.array][next[place.array]++].out = rows.columns[i];
  }
  for (const auto& [array, wanted] : of_array) {
    if (arrays_[array].read(wanted))
      rows.notes.push_back(fmt::format("{}: whole numbers beyond 2^53 are rounded", arrays_[array].name));
  }
  finish(rows, streams_[stream], fields);
  return rows;
}

// --- What is left out -----------------------------------------------------------------------------------------------

void MatlabObjects::add(std::string_view variable, std::string_view class_name) {
  arrays::add_to(of_class_, class_name, variable);
}

void MatlabObjects::note(std::vector<std::string>& notes) const {
  for (const NameList& variables : of_class_) {
    const std::string& class_name = variables.of;
    const auto* known = std::ranges::find(arrays::kExports, class_name, &arrays::Export::class_name);
    const std::string_view command = known == std::end(arrays::kExports)
                                         ? "save what it holds as arrays of numbers, save('log.mat', ..., '-v7')"
                                         : known->command;
    notes.push_back(fmt::format("{}: of MATLAB's class {}, which only MATLAB can read; export it there: {}",
                                arrays::few(variables), class_name.empty() ? "?" : class_name, command));
  }
}

void NamesByReason::add(std::string_view reason, std::string_view name) { arrays::add_to(of_reason_, reason, name); }

void NamesByReason::note(std::vector<std::string>& notes) const {
  for (const NameList& names : of_reason_) notes.push_back(fmt::format("{}: {}", names.of, arrays::few(names)));
}

// --- Bytes ----------------------------------------------------------------------------------------------------------

struct ByteStream::Inflating {
  z_stream stream = {};
  std::string_view packed;
  std::vector<char> buffer = std::vector<char>(kMost);
  std::size_t first = 0, last = 0;  ///< of the buffer: not taken yet
  bool ended = false, whole = false;

  explicit Inflating(std::string_view bytes, int window) : packed(bytes) {
    if (inflateInit2(&stream, window) != Z_OK) throw std::bad_alloc();
  }
  ~Inflating() { inflateEnd(&stream); }
  Inflating(const Inflating&) = delete;
  Inflating& operator=(const Inflating&) = delete;

  /// Fills the buffer, as far as there is something.
  void fill() {
    std::copy(buffer.begin() + static_cast<std::ptrdiff_t>(first), buffer.begin() + static_cast<std::ptrdiff_t>(last),
              buffer.begin());
    last -= std::exchange(first, 0);
    while (!ended && last < buffer.size()) {
      constexpr std::size_t kMostPacked = std::size_t{1} << 30;
      const std::size_t offered = std::min(packed.size(), kMostPacked);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));  // zlib's interface; only read
      stream.avail_in = static_cast<uInt>(offered);
      stream.next_out = reinterpret_cast<Bytef*>(buffer.data() + last);
      stream.avail_out = static_cast<uInt>(buffer.size() - last);
      const int status = ::inflate(&stream, Z_NO_FLUSH);
      if (status == Z_MEM_ERROR) throw std::bad_alloc();
      packed.remove_prefix(offered - stream.avail_in);
      last = buffer.size() - stream.avail_out;
      ended = status != Z_OK;
      whole = status == Z_STREAM_END;
    }
  }
};

ByteStream::ByteStream(const Bytes& file, std::string_view plain) : file_(&file), unreleased_(plain), plain_(plain) {}
ByteStream::ByteStream(const Bytes& file, std::string_view packed, int window)
    : file_(&file), unreleased_(packed), inflating_(std::make_unique<Inflating>(packed, window)) {}
ByteStream::~ByteStream() = default;
ByteStream::ByteStream(ByteStream&&) noexcept = default;
ByteStream& ByteStream::operator=(ByteStream&&) noexcept = default;

/// @param rest  of the bytes of the file
void ByteStream::release(std::string_view rest) {
  constexpr std::size_t kPart = std::size_t{1} << 22;
  const std::size_t passed = unreleased_.size() - rest.size();
  if (passed < kPart) return;
  file_->release(unreleased_.substr(0, passed));
  unreleased_ = rest;
}

std::string_view ByteStream::inflate(std::size_t size) {
  if (inflating_->last - inflating_->first < size) {
    inflating_->fill();
    release(inflating_->packed);
  }
  const std::size_t got = std::min(size, inflating_->last - inflating_->first);
  const std::string_view bytes(inflating_->buffer.data() + inflating_->first, got);
  inflating_->first += got;
  return bytes;
}

std::string_view ByteStream::take(std::size_t size) {
  size = std::min(size, kMost);
  std::string_view bytes;
  if (inflating_) {
    bytes = inflate(size);
  } else {
    release(plain_);  // what was given last time is used
    bytes = plain_.substr(0, size);
    plain_.remove_prefix(bytes.size());
  }
  pass(bytes);
  return bytes;
}

void ByteStream::pass(std::string_view bytes) {
  taken_ += bytes.size();
  if (!watched_) return;
  crc_ = static_cast<std::uint32_t>(::crc32_z(crc_, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

bool ByteStream::skip(std::uint64_t size) {
  if (!inflating_) {
    const auto step = static_cast<std::size_t>(std::min<std::uint64_t>(size, plain_.size()));
    pass(plain_.substr(0, step));
    plain_.remove_prefix(step);
    return step == size;
  }
  while (size > 0) {
    const std::size_t got = take(static_cast<std::size_t>(std::min<std::uint64_t>(size, kMost))).size();
    if (got == 0) return false;
    size -= got;
  }
  return true;
}

bool ByteStream::finish() {
  while (!take(kMost).empty()) {
  }
  return !inflating_ || inflating_->whole;
}

// --- Matrices -------------------------------------------------------------------------------------------------------

namespace arrays {
namespace {

/// One number of a matrix after the other, and whether any was rounded.
class Numbers {
 public:
  explicit Numbers(const MatrixLayout& layout)
      : type_(layout.type), size_(size_of(layout.type)), swap_(layout.big_endian && size_ > 1) {}

  double operator()(const char* at) {
    std::array<char, sizeof(double)> turned;
    if (swap_) {
      std::reverse_copy(at, at + size_, turned.begin());
      at = turned.data();
    }
    const double value = to_double(type_, at);
    constexpr double kExact = 9007199254740992;  // 2^53
    if (!is_floating(type_) && (value > kExact || value < -kExact)) rounded_ = true;
    return value;
  }
  [[nodiscard]] bool rounded() const { return rounded_; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  NumberType type_;
  std::size_t size_;
  bool swap_;
  bool rounded_ = false;
};

/// @returns whether there were so many
bool read_column(ByteStream& bytes, Numbers& numbers, std::span<double> out) {
  const std::size_t block = ByteStream::kMost / numbers.size();
  for (std::size_t row = 0; row < out.size();) {
    const std::size_t wanted = std::min(block, out.size() - row);
    const std::string_view part = bytes.take(wanted * numbers.size());
    if (part.size() < wanted * numbers.size()) return false;
    for (std::size_t i = 0; i < wanted; ++i) out[row++] = numbers(part.data() + i * numbers.size());
  }
  return true;
}

bool read_by_columns(ByteStream& bytes, const MatrixLayout& layout, std::span<const WantedColumn> columns,
                     Numbers& numbers) {
  const std::uint64_t column_bytes = static_cast<std::uint64_t>(layout.shape.rows) * numbers.size();
  std::size_t done = 0;  // columns that are read or skipped
  std::vector<WantedColumn> ordered(columns.begin(), columns.end());
  std::ranges::stable_sort(ordered, {}, &WantedColumn::column);
  std::span<const double> last;
  for (const WantedColumn& wanted : ordered) {
    if (wanted.column < done) {  // the same once more
      std::ranges::copy(last, wanted.out.begin());
      continue;
    }
    if (!bytes.skip(column_bytes * (wanted.column - done)) || !read_column(bytes, numbers, wanted.out)) return false;
    last = wanted.out;
    done = wanted.column + 1;
  }
  return true;
}

bool read_by_rows(ByteStream& bytes, const MatrixLayout& layout, std::span<const WantedColumn> columns,
                  Numbers& numbers) {
  const std::size_t row_bytes = static_cast<std::size_t>(layout.shape.columns) * numbers.size();
  const auto rows = static_cast<std::size_t>(layout.shape.rows);
  const std::size_t block = ByteStream::kMost / row_bytes;  // above 0: kMostColumns
  for (std::size_t row = 0; row < rows;) {
    const std::size_t count = std::min(block, rows - row);
    const std::string_view part = bytes.take(count * row_bytes);
    if (part.size() < count * row_bytes) return false;
    for (const WantedColumn& wanted : columns) {
      const char* at = part.data() + wanted.column * numbers.size();
      for (std::size_t i = 0; i < count; ++i) wanted.out[row + i] = numbers(at + i * row_bytes);
    }
    row += count;
  }
  return true;
}

}  // namespace
}  // namespace arrays

MatrixReading read_matrix(ByteStream& bytes, const MatrixLayout& layout, std::span<const WantedColumn> columns) {
  arrays::Numbers numbers(layout);
  const bool whole = layout.by_columns ? arrays::read_by_columns(bytes, layout, columns, numbers)
                                       : arrays::read_by_rows(bytes, layout, columns, numbers);
  return {whole, numbers.rounded()};
}

}  // namespace gyrobudget::inline v0::log

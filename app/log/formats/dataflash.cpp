// SPDX-License-Identifier: MIT
#include "dataflash.h"

#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <optional>
#include <type_traits>
#include <utility>

#include "number_type.h"
#include "rows.h"

namespace gyrobudget::inline v0::log::dataflash {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kHead = "\xa3\x95"sv;
constexpr std::size_t kHeadBytes = 3;  // and the type
constexpr std::uint8_t kFormatType = 0x80;
constexpr std::size_t kFormatBytes = 89;  // of a message that tells a format
constexpr std::size_t kBatchSamples = 32;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

// --- Formats of messages --------------------------------------------------------------------------------------------

/// What a letter of a format stands for.
struct Letter {
  char letter;
  std::optional<NumberType> number;  ///< none: text
  std::size_t count;                 ///< of numbers, or characters
  double scale = 1;                  ///< that the letter has by itself
};
constexpr Letter kLetters[] = {{'a', NumberType::i16, kBatchSamples},
                               {'b', NumberType::i8, 1},
                               {'B', NumberType::u8, 1},
                               {'h', NumberType::i16, 1},
                               {'H', NumberType::u16, 1},
                               {'i', NumberType::i32, 1},
                               {'I', NumberType::u32, 1},
                               {'q', NumberType::i64, 1},
                               {'Q', NumberType::u64, 1},
                               {'f', NumberType::f32, 1},
                               {'d', NumberType::f64, 1},
                               {'g', NumberType::f16, 1},
                               {'n', std::nullopt, 4},
                               {'N', std::nullopt, 16},
                               {'Z', std::nullopt, 64},
                               {'c', NumberType::i16, 1, 0.01},
                               {'C', NumberType::u16, 1, 0.01},
                               {'e', NumberType::i32, 1, 0.01},
                               {'E', NumberType::u32, 1, 0.01},
                               {'L', NumberType::i32, 1, 1e-7},
                               {'M', NumberType::u8, 1}};

/// A column of a message.
struct Column {
  std::string label;
  const Letter* letter = nullptr;
  std::size_t offset = 0;  ///< behind the head

  [[nodiscard]] bool is_number() const { return letter->number.has_value(); }
  [[nodiscard]] bool is_whole() const { return is_number() && !is_floating(*letter->number) && letter->count == 1; }
};

/// What a FMT message tells.
struct Definition {
  std::uint8_t type = 0;
  std::size_t length = 0;  ///< of a message with its head
  std::string name;
  std::vector<Column> columns;  ///< none where format and length do not agree
  bool is_understood = true;
  std::string units, multipliers;              ///< a letter for each column, from FMTU; empty without
  std::optional<std::size_t> instance, clock;  ///< columns

  [[nodiscard]] const Column* column(std::string_view label) const {
    const auto found = std::ranges::find(columns, label, &Column::label);
    return found == columns.end() ? nullptr : &*found;
  }
};

/// The text of a field of fixed length.
std::string_view until_nul(std::string_view field) { return field.substr(0, field.find('\0')); }

/// The name without the number of the sensor: "IMU" for "IMU2".
std::string_view family(std::string_view name) {
  while (!name.empty() && text::is_digit(name.back())) name.remove_suffix(1);
  return name;
}

/// @returns bytes of a message's body; nothing for a format that is not known
std::optional<std::size_t> add_columns(std::string_view format, std::string_view labels, std::vector<Column>& columns) {
  std::size_t offset = 0;
  constexpr std::size_t kMostColumns = 64;  // a binary log has 16
  if (format.size() > kMostColumns) return std::nullopt;
  for (const char c : format) {
    const auto* letter = std::ranges::find(kLetters, c, &Letter::letter);
    if (letter == std::end(kLetters)) return std::nullopt;
    const std::size_t end = std::min(labels.find(','), labels.size());
    std::string label = clean_name(labels.substr(0, end));
    if (label.empty()) label = fmt::format("column {}", columns.size() + 1);
    columns.push_back({std::move(label), letter, offset});
    labels.remove_prefix(std::min(end + 1, labels.size()));
    offset += letter->count * (letter->number ? size_of(*letter->number) : 1);
  }
  return offset;
}

/// The first of the columns by which ArduPilot tells the time. GPS of old has TimeMS for the time of week, and T.
std::optional<std::size_t> clock_of(const Definition& definition) {
  const bool is_gps = family(definition.name) == "GPS";
  for (const std::string_view label : {"SampleUS"sv, "TimeUS"sv, is_gps ? "T"sv : "TimeMS"sv}) {
    const Column* column = definition.column(label);
    if (column && column->is_whole()) return static_cast<std::size_t>(column - definition.columns.data());
  }
  return std::nullopt;
}

Definition make_definition(std::uint8_t type, std::size_t length, std::string_view name, std::string_view format,
                           std::string_view labels, bool is_text) {
  Definition definition{type, length, clean_name(name), {}};
  const auto size = add_columns(format, labels, definition.columns);
  definition.is_understood = size && (is_text || kHeadBytes + *size == length);
  if (!definition.is_understood) definition.columns.clear();
  definition.clock = clock_of(definition);
  const Column* instance = definition.column("I");
  if (instance && instance - definition.columns.data() == 1 && instance->letter->letter == 'B') definition.instance = 1;
  return definition;
}

/// Formats as they are told on the way. A later one of the same type holds from there on.
class Catalogue {
 public:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  /// @param told  the whole of what tells the format: what was told before is the same definition
  template <class Make>
  std::size_t define(std::string_view told, const Make& make) {
    const auto found = known_.find(told);
    if (found != known_.end()) return found->second;
    definitions.push_back(make());
    known_.emplace(told, definitions.size() - 1);
    return definitions.size() - 1;
  }

  std::vector<Definition> definitions;

 private:
  std::map<std::string_view, std::size_t> known_;
};

// --- Messages -------------------------------------------------------------------------------------------------------

struct Message {
  std::size_t definition = 0;
  std::string_view body;  ///< behind the head; of text: behind the name
};

struct Losses {
  std::size_t skipped = 0;  ///< bytes, or lines of a text
  std::size_t skipped_at = kNowhere, cut_at = kNowhere;
};

/// What both walks share: they release what they have passed.
class Releaser {
 public:
  explicit Releaser(const Bytes& bytes) : bytes_(bytes) {}
  void passed(std::size_t at) {
    constexpr std::size_t kPart = std::size_t{1} << 24;
    if (at - released_ < kPart) return;
    bytes_.release(bytes_.text().substr(released_, at - released_));
    released_ = at;
  }

 private:
  const Bytes& bytes_;
  std::size_t released_ = 0;
};

/// Goes through a binary log by the lengths of its messages: marks within them mean nothing.
class BinaryWalk {
 public:
  BinaryWalk(const Bytes& bytes, Catalogue& catalogue) : text_(bytes.text()), catalogue_(catalogue), releaser_(bytes) {
    of_type_.fill(Catalogue::kNone);
    of_type_[kFormatType] = catalogue_.define("", [] {
      return make_definition(kFormatType, kFormatBytes, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", false);
    });
  }

  bool next(Message& message) {
    while (at_ < text_.size()) {
      const std::size_t length = length_at(at_);
      if (length == 0) {
        skip();
      } else if (length > text_.size() - at_) {
        losses_.cut_at = at_;
        return false;
      } else {
        const auto type = static_cast<std::uint8_t>(text_[at_ + 2]);
        if (type == kFormatType) define(text_.substr(at_ + kHeadBytes, length - kHeadBytes));
        message = {of_type_[type], text_.substr(at_ + kHeadBytes, length - kHeadBytes)};
        at_ += length;
        releaser_.passed(at_);
        return true;
      }
    }
    return false;
  }
  [[nodiscard]] const Losses& losses() const { return losses_; }

 private:
  /// Of the message there; 0 where there is none.
  [[nodiscard]] std::size_t length_at(std::size_t at) const {
    const std::size_t left = text_.size() - at;
    const std::string_view head = text_.substr(at, kHead.size());
    if (left < kHeadBytes) return kHead.starts_with(head) ? kHeadBytes : 0;
    if (head != kHead) return 0;
    const auto type = static_cast<std::uint8_t>(text_[at + 2]);
    if (type == kFormatType) return kFormatBytes;
    return of_type_[type] == Catalogue::kNone ? 0 : catalogue_.definitions[of_type_[type]].length;
  }

  /// To the next message that another one follows, or the end of the file.
  void skip() {
    const std::size_t from = at_;
    for (;;) {
      at_ = std::min(text_.find(kHead, at_ + 1), text_.size());
      if (at_ == text_.size()) break;
      const std::size_t length = length_at(at_), left = text_.size() - at_;
      if (length == 0 || length > left) continue;
      if (length == left || text_.substr(at_ + length).starts_with(kHead)) break;
    }
    if (losses_.skipped_at == kNowhere) losses_.skipped_at = from;
    losses_.skipped += at_ - from;
  }

  void define(std::string_view body) {
    constexpr std::size_t kName = 2, kFormat = 6, kLabels = 22;
    const auto type = static_cast<std::uint8_t>(body[0]);
    const std::size_t length = static_cast<std::uint8_t>(body[1]);
    if (length < kHeadBytes || (type == kFormatType && length != kFormatBytes)) return;
    of_type_[type] = catalogue_.define(body, [&] {
      return make_definition(type, length, until_nul(body.substr(kName, kFormat - kName)),
                             until_nul(body.substr(kFormat, kLabels - kFormat)), until_nul(body.substr(kLabels)),
                             false);
    });
  }

  std::string_view text_;
  Catalogue& catalogue_;
  Releaser releaser_;
  std::array<std::size_t, 256> of_type_{};
  std::size_t at_ = 0;
  Losses losses_;
};

/// Goes through a log that was turned into text: "NAME, value, value".
class TextWalk {
 public:
  TextWalk(const Bytes& bytes, Catalogue& catalogue) : text_(bytes.text()), catalogue_(catalogue), releaser_(bytes) {}

  bool next(Message& message) {
    while (at_ < text_.size()) {
      const std::size_t begin = at_, end = text_.find('\n', at_);
      if (end == std::string_view::npos) {  // its last number may be cut
        losses_.cut_at = begin;
        return false;
      }
      at_ = end + 1;
      releaser_.passed(std::min(at_, text_.size()));
      const std::string_view line = text::trim(text_.substr(begin, end - begin));
      if (line.empty()) continue;
      const std::size_t comma = std::min(line.find(','), line.size());
      const std::string_view name = text::trim(line.substr(0, comma));
      const std::string_view body = line.substr(std::min(comma + 1, line.size()));
      if (name == "FMT") define(body);
      const auto found = of_name_.find(name);
      if (found != of_name_.end()) {
        message = {found->second, body};
        return true;
      }
      if (losses_.skipped_at == kNowhere) losses_.skipped_at = begin;
      ++losses_.skipped;
    }
    return false;
  }
  [[nodiscard]] const Losses& losses() const { return losses_; }

 private:
  /// "128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns"
  void define(std::string_view body) {
    std::array<std::string_view, 4> cells;
    for (std::string_view& cell : cells) {
      const std::size_t end = std::min(body.find(','), body.size());
      cell = text::trim(body.substr(0, end));
      body.remove_prefix(std::min(end + 1, body.size()));
    }
    const std::string_view type_text = cells[0], name = cells[2],
                           format = cells[3];  // its length is that of the binary
    unsigned type = 0;
    const auto parsed = std::from_chars(type_text.data(), type_text.data() + type_text.size(), type);
    constexpr unsigned kLastType = 0xff;
    if (parsed.ec != std::errc() || type > kLastType || name.empty()) return;
    const std::string_view told(type_text.data(),
                                static_cast<std::size_t>(body.data() + body.size() - type_text.data()));
    of_name_[name] = catalogue_.define(
        told, [&] { return make_definition(static_cast<std::uint8_t>(type), 0, name, format, body, true); });
  }

  std::string_view text_;
  Catalogue& catalogue_;
  Releaser releaser_;
  std::map<std::string_view, std::size_t> of_name_;
  std::size_t at_ = 0;
  Losses losses_;
};

// --- Values ---------------------------------------------------------------------------------------------------------

/// Reads columns of messages, of one kind of log.
class Values {
 public:
  explicit Values(bool is_text) : is_text_(is_text) {}

  /// Looks at a message. @returns whether it has all its columns
  bool take(const Definition& definition, const Message& message) {
    body_ = message.body;
    if (!is_text_) return true;
    cells_.clear();
    std::string_view rest = body_;
    while (cells_.size() + 1 < definition.columns.size() && rest.find(',') != std::string_view::npos) {
      cells_.push_back(text::trim(rest.substr(0, rest.find(','))));
      rest.remove_prefix(rest.find(',') + 1);
    }
    cells_.push_back(text::trim(rest));  // the last one may be text with commas
    columns_ = definition.columns.data();
    return cells_.size() == definition.columns.size();
  }

  /// As it stands there: without any scale in a binary log, with that of its letter in text. @param k  of an array
  [[nodiscard]] double number(const Column& column, std::size_t k = 0) const {
    if (!is_text_) return to_double(*column.letter->number, at(column) + k * size_of(*column.letter->number));
    double value = kNone;
    return text::parse_number(cell(column), false, value) == text::Cell::number ? value : kNone;
  }
  [[nodiscard]] std::uint64_t whole(const Column& column) const {
    constexpr auto kNotThere = std::numeric_limits<std::uint64_t>::max();
    if (!is_text_) return to_unsigned(*column.letter->number, at(column));
    std::int64_t value = 0;
    return text::parse_stamp(cell(column), false, 1, value) == text::Cell::number && value >= 0
               ? static_cast<std::uint64_t>(value)
               : kNotThere;
  }
  [[nodiscard]] std::string_view letters(const Column& column) const {
    return is_text_ ? cell(column) : until_nul({at(column), column.letter->count});
  }

 private:
  [[nodiscard]] const char* at(const Column& column) const { return body_.data() + column.offset; }
  [[nodiscard]] std::string_view cell(const Column& column) const {
    return cells_[static_cast<std::size_t>(&column - columns_)];
  }

  bool is_text_;
  std::string_view body_;
  std::vector<std::string_view> cells_;
  const Column* columns_ = nullptr;
};

// --- Units ----------------------------------------------------------------------------------------------------------

struct KnownUnit {
  std::string_view family;  ///< empty for all
  std::string_view label, unit;
  double scale = 1;  ///< beside that of the letter
};
/// Of logs that tell no units.
constexpr KnownUnit kUnits[] = {
    {"", "TimeUS", "us"},     {"", "TimeMS", "ms"},       {"", "SampleUS", "us"},     {"IMU", "GyrX", "rad/s"},
    {"IMU", "GyrY", "rad/s"}, {"IMU", "GyrZ", "rad/s"},   {"IMU", "AccX", "m/s^2"},   {"IMU", "AccY", "m/s^2"},
    {"IMU", "AccZ", "m/s^2"}, {"IMU", "T", "degC"},       {"IMU", "Temp", "degC"},    {"ACC", "AccX", "m/s^2"},
    {"ACC", "AccY", "m/s^2"}, {"ACC", "AccZ", "m/s^2"},   {"GYR", "GyrX", "rad/s"},   {"GYR", "GyrY", "rad/s"},
    {"GYR", "GyrZ", "rad/s"}, {"MAG", "MagX", "T", 1e-7}, {"MAG", "MagY", "T", 1e-7}, {"MAG", "MagZ", "T", 1e-7},
    {"GPS", "Lat", "deg"},    {"GPS", "Lng", "deg"},      {"GPS", "Alt", "m"},        {"GPS", "RelAlt", "m"},
    {"GPS", "Spd", "m/s"},    {"GPS", "GCrs", "deg"},     {"GPS", "VZ", "m/s"},       {"GPA", "HAcc", "m"},
    {"GPA", "VAcc", "m"},     {"GPA", "SAcc", "m/s"}};

/// How the log writes a unit, how we do, and how much one is of ours.
struct Spelling {
  std::string_view theirs, ours;
  double scale = 1;
};
constexpr Spelling kSpellings[] = {{"m/s/s", "m/s^2"},
                                   {"degheading", "deg"},
                                   {"deglatitude", "deg"},
                                   {"deglongitude", "deg"},
                                   {"Gauss", "T", 1e-4},
                                   {"mGauss", "T", 1e-7},
                                   {"s", "s"},
                                   {"instance", ""},
                                   {"UNKNOWN", ""}};

using LabelOf = std::map<char, std::string>;
using FactorOf = std::map<char, double>;

/// A field of a stream: a number of a column.
struct FieldPlan {
  std::size_t column = 0, element = 0;
  double scale = 1;
  Field field;
};

class UnitTable {
 public:
  LabelOf labels;
  FactorOf factors;

  /// @param is_text  the numbers have the scale of their letter already
  [[nodiscard]] FieldPlan plan(const Definition& definition, std::size_t index, bool is_text) const {
    const Column& column = definition.columns[index];
    FieldPlan plan{index, 0, is_text ? 1 : column.letter->scale, {column.label, "", ""}};
    if (index < definition.units.size()) {
      told(definition, index, is_text, plan);
    } else {
      documented(definition.name, plan);
    }
    return plan;
  }

 private:
  /// A factor of the log holds the scale of the letter already.
  void told(const Definition& definition, std::size_t index, bool is_text, FieldPlan& plan) const {
    const auto label = labels.find(definition.units[index]);
    const char multiplier = index < definition.multipliers.size() ? definition.multipliers[index] : '-';
    if (label == labels.end() || multiplier == '?') return;
    const auto factor = factors.find(multiplier);
    if (multiplier != '-' && factor == factors.end()) return;
    if (multiplier != '-' && factor->second != 0)
      plan.scale = factor->second / (is_text ? definition.columns[index].letter->scale : 1);
    const auto* spelling = std::ranges::find(kSpellings, label->second, &Spelling::theirs);
    const bool is_ours = spelling == std::end(kSpellings);
    plan.field.unit = is_ours ? label->second : std::string(spelling->ours);
    if (!is_ours) plan.scale *= spelling->scale;
    if (!plan.field.unit.empty()) plan.field.unit_from = "UNIT of the log";
  }

  static void documented(std::string_view name, FieldPlan& plan) {
    for (const KnownUnit& known : kUnits) {
      if ((!known.family.empty() && known.family != family(name)) || known.label != plan.field.name) continue;
      plan.field.unit = known.unit;
      plan.field.unit_from = "ArduPilot has it so";
      plan.scale *= known.scale;
      return;
    }
  }
};

// --- Batches --------------------------------------------------------------------------------------------------------

/// Some thousand samples of one sensor without a gap: a header, and messages of 32 samples each.
struct Batch {
  bool is_gyroscope = false;
  std::uint8_t instance = 0;
  double divisor = 1, rate_hz = 0;
  std::uint64_t samples = 0, start_us = 0;
};

/// Follows headers and tells what their messages hold.
class Batches {
 public:
  /// Where it is a header.
  void take(const Definition& definition, const Values& values) {
    const auto number = [&](std::string_view label) {
      const Column* column = definition.column(label);
      return column && column->is_number() ? values.number(*column) : kNone;
    };
    const auto whole = [&](std::string_view label) {
      const Column* column = definition.column(label);
      return column && column->is_whole() ? values.whole(*column) : 0;
    };
    const Batch batch{whole("type") == 1, static_cast<std::uint8_t>(whole("instance")),
                      number("mul"),      number("smp_rate"),
                      whole("smp_cnt"),   whole("SampleUS")};
    const auto id = static_cast<std::uint16_t>(whole("N"));
    if (batch.divisor > 0 && batch.rate_hz > 0 && batch.start_us < kMostUs) {
      batches_[id] = batch;
    } else {
      batches_.erase(id);
    }
  }

  struct Piece {
    const Batch* batch = nullptr;  ///< null where its header is missing
    std::uint64_t first = 0;       ///< of its samples, within the batch
    std::size_t count = 0;
  };
  /// Where it is one of the messages behind a header.
  [[nodiscard]] Piece piece(const Definition& definition, const Values& values) const {
    const Column *id = definition.column("N"), *sequence = definition.column("seqno");
    const auto is_samples = [&](std::string_view label) {
      const Column* column = definition.column(label);
      return column && column->letter->letter == 'a';
    };
    if (!id || !id->is_whole() || !sequence || !sequence->is_whole()) return {};
    if (!is_samples("x") || !is_samples("y") || !is_samples("z")) return {};
    const auto found = batches_.find(static_cast<std::uint16_t>(values.whole(*id)));
    if (found == batches_.end()) return {};
    constexpr std::uint64_t kLastPiece = 0xffff;
    const std::uint64_t first = std::min(values.whole(*sequence), kLastPiece) * kBatchSamples;
    const Batch& batch = found->second;
    if (first >= batch.samples) return {};
    return {&batch, first, static_cast<std::size_t>(std::min<std::uint64_t>(kBatchSamples, batch.samples - first))};
  }

  static constexpr std::uint64_t kMostUs = std::uint64_t{1} << 52;

 private:
  std::map<std::uint16_t, Batch> batches_;
};

// --- The recording --------------------------------------------------------------------------------------------------

/// Which messages are the rows of a stream.
struct Source {
  std::size_t definition = 0;
  int instance = -1;      ///< -1: all
  bool is_batch = false;  ///< samples of batches: the definition is 1 for a gyroscope
  auto operator<=>(const Source&) const = default;
};

StreamKind kind_of(const Definition& definition) {
  const std::string_view name = family(definition.name);
  const auto has = [&](std::string_view label) { return definition.column(label) != nullptr; };
  if (name == "IMU" && has("GyrX") && has("AccX")) return StreamKind::imu;
  if (name == "GYR" && has("GyrX")) return StreamKind::gyroscope;
  if (name == "ACC" && has("AccX")) return StreamKind::accelerometer;
  if (name == "MAG" && has("MagX")) return StreamKind::magnetometer;
  return name == "GPS" && has("Lat") ? StreamKind::gnss : StreamKind::other;
}

template <class Walk>
class Dataflash : public Recording {
 public:
  explicit Dataflash(std::shared_ptr<const Bytes> bytes) : bytes_(std::move(bytes)) {
    learn();
    count();
    list_streams();
  }

  [[nodiscard]] std::string format() const override {
    return kIsText ? "ArduPilot dataflash, as text" : "ArduPilot dataflash";
  }
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  [[nodiscard]] const std::vector<std::string>& notes() const override { return notes_; }
  [[nodiscard]] Rows read(std::size_t stream, std::span<const std::size_t> fields) const override;

 private:
  static constexpr bool kIsText = std::is_same_v<Walk, TextWalk>;

  void learn();
  void learn_units(std::size_t definition, const Values& values);
  void count();
  void count_one(const Source& source, std::int64_t rows);
  void note(const Losses& losses, std::uint64_t short_rows);
  void list_streams();
  void list_messages(const Source& source, StreamInfo& info);
  [[nodiscard]] Source source_of(std::size_t definition, const Values& values) const;
  [[nodiscard]] Rows read_messages(std::size_t stream, std::span<const std::size_t> fields,
                                   std::optional<std::size_t> clock) const;
  [[nodiscard]] Rows read_batches(std::size_t stream, std::span<const std::size_t> fields) const;
  void append_batch(const Definition& definition, const Values& values, const Batches::Piece& piece,
                    std::span<const std::size_t> fields, Rows& rows) const;

  std::shared_ptr<const Bytes> bytes_;
  Catalogue catalogue_;
  UnitTable units_;
  std::map<Source, std::size_t> places_;
  std::vector<Source> sources_;
  std::vector<std::int64_t> counts_;
  std::vector<std::vector<FieldPlan>> plans_;  ///< of each stream
  std::size_t fields_ = 0;
  std::vector<StreamInfo> streams_;
  std::vector<std::string> notes_;
};

/// The formats, and the units, which may come behind what they are of.
template <class Walk>
void Dataflash<Walk>::learn() {
  Walk walk(*bytes_, catalogue_);
  Values values(kIsText);
  Message message;
  while (walk.next(message)) {
    const Definition& definition = catalogue_.definitions[message.definition];
    const std::string_view name = definition.name;
    if (name != "UNIT" && name != "MULT" && name != "FMTU") continue;
    if (values.take(definition, message)) learn_units(message.definition, values);
  }
}

template <class Walk>
void Dataflash<Walk>::learn_units(std::size_t index, const Values& values) {
  const Definition& definition = catalogue_.definitions[index];
  const Column *id = definition.column("Id"), *label = definition.column("Label"), *factor = definition.column("Mult");
  if (id && id->is_whole()) {
    const char letter = static_cast<char>(values.whole(*id));
    if (definition.name == "UNIT" && label && !label->is_number())
      units_.labels[letter] = clean_name(values.letters(*label));
    if (definition.name == "MULT" && factor && factor->is_number()) units_.factors[letter] = values.number(*factor);
  }
  const Column *type = definition.column("FmtType"), *units = definition.column("UnitIds"),
               *multipliers = definition.column("MultIds");
  if (definition.name != "FMTU" || !type || !units || !multipliers) return;
  if (!type->is_whole() || units->is_number() || multipliers->is_number()) return;
  const std::uint64_t wanted = values.whole(*type);
  const std::string unit_letters(values.letters(*units)), multiplier_letters(values.letters(*multipliers));
  for (Definition& of : catalogue_.definitions) {
    if (of.type != wanted || unit_letters.size() != of.columns.size()) continue;
    of.units = unit_letters;
    of.multipliers = multiplier_letters;
    const std::size_t instance = of.units.find('#');
    if (instance != std::string::npos && of.columns[instance].is_whole()) of.instance = instance;
  }
}

template <class Walk>
Source Dataflash<Walk>::source_of(std::size_t definition, const Values& values) const {
  const Definition& of = catalogue_.definitions[definition];
  if (!of.instance) return {definition};
  constexpr std::uint64_t kMostInstances = 255;
  return {definition, static_cast<int>(std::min(values.whole(of.columns[*of.instance]), kMostInstances))};
}

template <class Walk>
void Dataflash<Walk>::count_one(const Source& source, std::int64_t rows) {
  const auto [found, is_new] = places_.try_emplace(source, sources_.size());
  if (is_new) {
    sources_.push_back(source);
    counts_.push_back(0);
  }
  counts_[found->second] += rows;
}

template <class Walk>
void Dataflash<Walk>::count() {
  Walk walk(*bytes_, catalogue_);
  Values values(kIsText);
  Batches batches;
  std::uint64_t short_rows = 0;
  Message message;
  while (walk.next(message)) {
    const Definition& definition = catalogue_.definitions[message.definition];
    if (!values.take(definition, message)) {
      ++short_rows;
      continue;
    }
    count_one(source_of(message.definition, values), 1);
    if (kIsText) continue;
    if (definition.name == "ISBH") batches.take(definition, values);
    if (definition.name != "ISBD") continue;
    const Batches::Piece piece = batches.piece(definition, values);
    if (piece.batch)
      count_one({piece.batch->is_gyroscope ? 1U : 0U, piece.batch->instance, true},
                static_cast<std::int64_t>(piece.count));
  }
  note(walk.losses(), short_rows);
}

template <class Walk>
void Dataflash<Walk>::note(const Losses& losses, std::uint64_t short_rows) {
  const std::size_t size = bytes_->text().size();
  if (bytes_->cut())
    notes_.push_back(
        fmt::format("the {} data stop in the middle: the log ends after {} bytes", name(bytes_->compression()), size));
  if (losses.cut_at != kNowhere) {
    notes_.push_back(fmt::format("the file ends inside a {}: {} from byte {} on left out", kIsText ? "line" : "message",
                                 counted(size - losses.cut_at, "byte"), losses.cut_at));
  }
  if (losses.skipped > 0) {
    notes_.push_back(fmt::format("left out as of no message: {}, the first at byte {}",
                                 counted(losses.skipped, kIsText ? "line" : "byte"), losses.skipped_at));
  }
  if (short_rows > 0) notes_.push_back(fmt::format("{} with too few values left out", counted(short_rows, "line")));
}

template <class Walk>
void Dataflash<Walk>::list_messages(const Source& source, StreamInfo& info) {
  const Definition& definition = catalogue_.definitions[source.definition];
  info.name = source.instance < 0 ? definition.name : fmt::format("{}[{}]", definition.name, source.instance);
  info.type = definition.name;
  info.kind = kind_of(definition);
  if (definition.clock) info.clock = definition.columns[*definition.clock].label;
  std::vector<FieldPlan>& plans = plans_.emplace_back();
  constexpr std::size_t kMostFields = std::size_t{1} << 17;  // of all streams: strangers may tell formats without end
  if (fields_ > kMostFields) return;
  for (std::size_t i = 0; i < definition.columns.size(); ++i) {
    const Column& column = definition.columns[i];
    if (!column.is_number() || (kIsText && column.letter->count > 1)) continue;
    const FieldPlan plan = units_.plan(definition, i, kIsText);
    for (std::size_t k = 0; k < column.letter->count; ++k) {
      plans.push_back(plan);
      plans.back().element = k;
      if (column.letter->count > 1) plans.back().field.name = fmt::format("{}[{}]", column.label, k);
    }
  }
  for (const FieldPlan& plan : plans) info.fields.push_back(plan.field);
  fields_ += plans.size();
}

template <class Walk>
void Dataflash<Walk>::list_streams() {
  UniqueNames names;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    const Source& source = sources_[i];
    StreamInfo info;
    if (source.is_batch) {
      const bool is_gyroscope = source.definition == 1;
      info.name = fmt::format("{} batches[{}]", is_gyroscope ? "gyroscope" : "accelerometer", source.instance);
      info.type = "ISBH, ISBD";
      info.kind = is_gyroscope ? StreamKind::gyroscope : StreamKind::accelerometer;
      info.clock = "SampleUS";
      // What FMTU says of these messages is the accelerometer's unit for both.
      for (const char* axis : {"x", "y", "z"})
        info.fields.push_back({axis, is_gyroscope ? "rad/s" : "m/s^2", "ArduPilot has it so"});
      plans_.emplace_back();
    } else {
      list_messages(source, info);
      const Definition& definition = catalogue_.definitions[source.definition];
      if (!definition.is_understood && definition.length > kHeadBytes)
        notes_.push_back(fmt::format("{}: its format does not agree with its length; it is not read", definition.name));
    }
    info.name = names.take(info.name);
    info.count = counts_[i];
    streams_.push_back(std::move(info));
  }
}

/// Stamps as they come, of a counter that may have 32 bits.
class Stamps {
 public:
  explicit Stamps(const Column& column)
      : ns_per_unit_(column.label.ends_with("US") ? 1000 : 1'000'000),
        wraps_(column.letter->number == NumberType::u32) {}

  /// Nothing beyond the range of 64 bits.
  std::optional<std::int64_t> take(std::uint64_t value) {
    constexpr std::uint64_t kTurn = std::uint64_t{1} << 32;
    if (wraps_ && before_ > value && before_ - value > kTurn / 2) turns_ += kTurn;
    before_ = value;
    value += turns_;
    constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
    if (value > kMost / static_cast<std::uint64_t>(ns_per_unit_)) return std::nullopt;
    return static_cast<std::int64_t>(value) * ns_per_unit_;
  }
  [[nodiscard]] bool wrapped() const { return turns_ > 0; }

 private:
  std::int64_t ns_per_unit_;
  bool wraps_;
  std::uint64_t before_ = 0, turns_ = 0;
};

template <class Walk>
Rows Dataflash<Walk>::read_messages(std::size_t stream, std::span<const std::size_t> fields,
                                    std::optional<std::size_t> clock) const {
  const Source& source = sources_[stream];
  const Definition& definition = catalogue_.definitions[source.definition];
  Rows rows;
  rows.columns.resize(fields.size());
  const auto count = static_cast<std::size_t>(counts_[stream]);
  for (auto& column : rows.columns) column.reserve(count);
  std::optional<Stamps> stamps;
  if (clock) {
    stamps.emplace(definition.columns[*clock]);
    rows.stamps_ns.reserve(count);
    rows.clock = definition.columns[*clock].label;
  }
  std::uint64_t beyond = 0;
  Catalogue catalogue = catalogue_;
  Walk walk(*bytes_, catalogue);
  Values values(kIsText);
  Message message;
  while (walk.next(message)) {
    if (message.definition != source.definition || !values.take(definition, message)) continue;
    if (source.instance >= 0 && source_of(message.definition, values) != source) continue;
    if (stamps) {
      const auto stamp = stamps->take(values.whole(definition.columns[*clock]));
      if (!stamp) {
        ++beyond;
        continue;
      }
      rows.stamps_ns.push_back(*stamp);
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      const FieldPlan& plan = plans_[stream][fields[i]];
      rows.columns[i].push_back(values.number(definition.columns[plan.column], plan.element) * plan.scale);
    }
  }
  if (beyond > 0) rows.notes.push_back(fmt::format("{} with a time beyond reason left out", counted(beyond, "row")));
  if (stamps && stamps->wrapped())
    rows.notes.push_back(fmt::format("{} is a counter of 32 bits that began anew: it is continued", rows.clock));
  return rows;
}

template <class Walk>
void Dataflash<Walk>::append_batch(const Definition& definition, const Values& values, const Batches::Piece& piece,
                                   std::span<const std::size_t> fields, Rows& rows) const {
  constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  constexpr double kSecond = 1e9;
  const Batch& batch = *piece.batch;
  for (std::size_t k = 0; k < piece.count; ++k) {
    const double since_ns = std::min(static_cast<double>(piece.first + k) / batch.rate_hz * kSecond, kSecond * kSecond);
    rows.stamps_ns.push_back(static_cast<std::int64_t>(batch.start_us) * 1000 + std::llround(since_ns));
  }
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Column& column = *definition.column(kAxes[fields[i]]);
    for (std::size_t k = 0; k < piece.count; ++k) rows.columns[i].push_back(values.number(column, k) / batch.divisor);
  }
}

template <class Walk>
Rows Dataflash<Walk>::read_batches(std::size_t stream, std::span<const std::size_t> fields) const {
  const Source& source = sources_[stream];
  Rows rows;
  rows.columns.resize(fields.size());
  const auto count = static_cast<std::size_t>(counts_[stream]);
  for (auto& column : rows.columns) column.reserve(count);
  rows.stamps_ns.reserve(count);
  rows.clock = "SampleUS";
  Catalogue catalogue = catalogue_;
  Walk walk(*bytes_, catalogue);
  Values values(kIsText);
  Batches batches;
  std::uint64_t pieces = 0, last_us = 0;
  double rate_hz = 0;
  Message message;
  while (walk.next(message)) {
    const Definition& definition = catalogue_.definitions[message.definition];
    if (definition.name != "ISBH" && definition.name != "ISBD") continue;
    values.take(definition, message);
    if (definition.name == "ISBH") {
      batches.take(definition, values);
      continue;
    }
    const Batches::Piece piece = batches.piece(definition, values);
    if (!piece.batch || piece.batch->is_gyroscope != (source.definition == 1) ||
        piece.batch->instance != source.instance)
      continue;
    if (pieces == 0 || piece.batch->start_us != last_us) ++pieces;
    last_us = piece.batch->start_us;
    rate_hz = piece.batch->rate_hz;
    append_batch(definition, values, piece, fields, rows);
  }
  rows.notes.push_back(fmt::format(
      "{} pieces at {:.6g} Hz nominal, with gaps between them: good for spectra, not for long averaging times", pieces,
      rate_hz));
  return rows;
}

template <class Walk>
Rows Dataflash<Walk>::read(std::size_t stream, std::span<const std::size_t> fields) const {
  check_request(streams_, stream, fields);
  if (sources_[stream].is_batch) {
    Rows rows = read_batches(stream, fields);
    finish(rows, streams_[stream], fields);
    return rows;
  }
  const Definition& definition = catalogue_.definitions[sources_[stream].definition];
  Rows rows = read_messages(stream, fields, definition.clock);
  const Column* logged = definition.column("TimeUS");
  if (rows.clock == "SampleUS" && logged && logged->is_whole() && is_constant(rows.stamps_ns)) {
    const auto place = static_cast<std::size_t>(logged - definition.columns.data());
    Rows logged_rows = read_messages(stream, {}, place);
    if (logged_rows.stamps_ns.size() == rows.stamps_ns.size()) {
      rows.stamps_ns = std::move(logged_rows.stamps_ns);
      rows.notes.push_back(
          fmt::format("{} tells no time: {} stands in", std::exchange(rows.clock, logged->label), logged->label));
    }
  }
  if (rows.clock == "TimeMS" || rows.clock == "T") rows.notes.emplace_back("stamps are whole milliseconds");
  const double interval = median_interval_s(rows.stamps_ns);
  if (streams_[stream].kind == StreamKind::imu && interval > 0) {
    rows.notes.push_back(fmt::format(
        "the log has {:.4g} Hz, picked from a sensor that runs at 1 kHz or more: its faster noise is folded into what is here",
        1 / interval));
  }
  finish(rows, streams_[stream], fields);
  return rows;
}

}  // namespace
}  // namespace gyrobudget::inline v0::log::dataflash

namespace gyrobudget::inline v0::log {

bool is_dataflash(std::string_view head) {
  return head.starts_with(dataflash::kHead) && head.size() > 2 &&
         static_cast<std::uint8_t>(head[2]) == dataflash::kFormatType;
}

bool is_dataflash_text(std::string_view head) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  if (head.starts_with(kMark)) head.remove_prefix(kMark.size());
  std::string_view rest = head.substr(std::min(head.find_first_not_of(" \t\r\n"), head.size()));
  for (const std::string_view word : {"FMT", "128", "89", "FMT"}) {
    if (!rest.starts_with(word)) return false;
    rest.remove_prefix(word.size());
    const std::size_t next = std::min(rest.find_first_not_of(", \t"), rest.size());
    if (rest.substr(0, next).find(',') == std::string_view::npos) return false;
    rest.remove_prefix(next);
  }
  return true;
}

std::unique_ptr<Recording> open_dataflash(std::shared_ptr<const Bytes> bytes) {
  return std::make_unique<dataflash::Dataflash<dataflash::BinaryWalk>>(std::move(bytes));
}

std::unique_ptr<Recording> open_dataflash_text(std::shared_ptr<const Bytes> bytes) {
  return std::make_unique<dataflash::Dataflash<dataflash::TextWalk>>(std::move(bytes));
}

}  // namespace gyrobudget::inline v0::log

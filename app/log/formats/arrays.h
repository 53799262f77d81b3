// SPDX-License-Identifier: MIT
// Files of arrays: how arrays become streams, and how their numbers are read.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "../bytes.h"
#include "../recording.h"
#include "number_type.h"

namespace gyrobudget::inline v0::log {

/// How an array is taken as rows of samples: the longer of two dimensions, the first where they are equal.
struct ArrayShape {
  std::int64_t rows = 0, columns = 0;
  bool transposed = false;  ///< rows are its second dimension
};

/// Dimensions of 1 do not count. Nothing for an array without elements, of more than two dimensions, or of more than
/// 4096 columns or 2^40 numbers.
[[nodiscard]] std::optional<ArrayShape> array_shape(std::span<const std::int64_t> dimensions);

/// "3 x 600"
[[nodiscard]] std::string shape_text(std::span<const std::int64_t> dimensions);

/// A column that is wanted, and where its numbers go: as many as there are rows.
struct WantedColumn {
  std::size_t column = 0;
  std::span<double> out;
};

struct Array {
  std::string group;  ///< a struct or group, "imu.raw"; empty for the top level
  std::string name;
  ArrayShape shape;
  std::string unit = {};
  /// @returns whether integers beyond 2^53 were rounded @throws InputError
  std::function<bool(std::span<const WantedColumn>)> read;
};

/// A file may have no more arrays; a log has some tens.
inline constexpr std::size_t kMostArrays = std::size_t{1} << 16;

/// Arrays of a group that are equally long are a stream.
class ArrayRecording : public Recording {
 public:
  /// @param keeper  what `read` of the arrays refers to
  ArrayRecording(std::string format, std::vector<Array> arrays, std::vector<std::string> notes,
                 std::shared_ptr<const void> keeper);

  [[nodiscard]] std::string format() const override { return format_; }
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  [[nodiscard]] const std::vector<std::string>& notes() const override { return notes_; }
  [[nodiscard]] Rows read(std::size_t stream, std::span<const std::size_t> fields) const override;

 private:
  struct Place {
    std::size_t array = 0, column = 0;
  };
  void list_streams();
  void add_stream(const std::string& name, const std::vector<std::size_t>& members);
  void note_single_numbers();

  std::string format_;
  std::vector<Array> arrays_;
  std::vector<StreamInfo> streams_;
  std::vector<std::vector<Place>> places_;  ///< of the fields of each stream
  std::vector<std::string> notes_;
  std::shared_ptr<const void> keeper_;
};

/// Names of which the same is to be said; of many, the first.
struct NameList {
  std::string of;  ///< what they have in common
  std::vector<std::string> shown;
  std::size_t more = 0;
};

/// Objects that only MATLAB can read, by their class.
class MatlabObjects {
 public:
  void add(std::string_view variable, std::string_view class_name);
  /// One for each class, with what exports it.
  void note(std::vector<std::string>& notes) const;

 private:
  std::vector<NameList> of_class_;
};

/// Arrays of which the same is to be said: "left out, cells: a, b and 3 more".
class NamesByReason {
 public:
  void add(std::string_view reason, std::string_view name);
  void note(std::vector<std::string>& notes) const;

 private:
  std::vector<NameList> of_reason_;
};

/// Bytes one behind the other: those of a file, or inflated on the way.
class ByteStream {
 public:
  static constexpr std::size_t kMost = std::size_t{1} << 16;  ///< bytes at a time

  /// @param file  which the bytes are a part of: what was passed may leave memory
  ByteStream(const Bytes& file, std::string_view plain);
  /// @param window  zlib's: 15 for its own format, -15 without any
  /// @throws std::bad_alloc
  ByteStream(const Bytes& file, std::string_view packed, int window);
  ~ByteStream();
  ByteStream(ByteStream&&) noexcept;
  ByteStream& operator=(ByteStream&&) noexcept;

  /// The next bytes, at most kMost; fewer where they end or are damaged. They hold until the next call.
  [[nodiscard]] std::string_view take(std::size_t size);
  /// @returns whether there were so many
  bool skip(std::uint64_t size);
  [[nodiscard]] std::uint64_t taken() const { return taken_; }
  /// Goes to the end. @returns whether what was inflated came to its own, with the check sum that zlib's format has.
  bool finish();
  /// From here on, what is taken or skipped goes into a check sum.
  void watch() { watched_ = true; }
  /// CRC-32 of what was watched.
  [[nodiscard]] std::uint32_t crc() const { return crc_; }

 private:
  struct Inflating;
  std::string_view inflate(std::size_t size);
  void pass(std::string_view bytes);
  void release(std::string_view rest);

  const Bytes* file_;
  std::string_view unreleased_;
  std::string_view plain_;
  std::unique_ptr<Inflating> inflating_;
  std::uint64_t taken_ = 0;
  std::uint32_t crc_ = 0;
  bool watched_ = false;
};

/// Numbers one behind the other.
struct MatrixLayout {
  NumberType type = NumberType::f64;
  bool big_endian = false;
  ArrayShape shape;
  bool by_columns = false;  ///< the numbers of a column stand together; otherwise those of a row

  [[nodiscard]] std::uint64_t bytes() const {
    return static_cast<std::uint64_t>(shape.rows) * static_cast<std::uint64_t>(shape.columns) * size_of(type);
  }
};

struct MatrixReading {
  bool whole = true;     ///< false: the bytes ended before
  bool rounded = false;  ///< there are integers beyond 2^53
};
[[nodiscard]] MatrixReading read_matrix(ByteStream& bytes, const MatrixLayout& layout,
                                        std::span<const WantedColumn> columns);

}  // namespace gyrobudget::inline v0::log

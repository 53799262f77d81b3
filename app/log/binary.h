// SPDX-License-Identifier: MIT
// Logs without text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "columns.h"
#include "format.h"
#include "log.h"

namespace gyrobudget::inline v0::log {

/// Where the numbers of a binary log stand.
struct BinaryLayout {
  bool is_double = true;
  std::size_t offset = 0;  ///< bytes before the first number
  std::int64_t columns = 1;
  std::optional<std::int64_t> rows;  ///< where a header says so

  [[nodiscard]] std::size_t width() const { return is_double ? sizeof(double) : sizeof(float); }
  [[nodiscard]] std::size_t row_bytes() const { return static_cast<std::size_t>(columns) * width(); }
};

/// Bytes that the header of a .npy takes, from its first 12 bytes (fewer where the file ends).
/// @throws InputError for what is no .npy, a version that is not known, or a header of more than 64 KiB.
[[nodiscard]] std::size_t npy_header_bytes(std::string_view name, std::string_view head);

/// The dictionary in the header of a .npy.
struct NpyHeader {
  std::string descr;  ///< "<f8"
  bool fortran_order = false;
  std::vector<std::int64_t> shape;
  std::size_t bytes = 0;  ///< of the header
};

/// Any array's. @throws InputError for a header that ends early or is not as NumPy writes it, and records of fields.
[[nodiscard]] NpyHeader parse_npy_header(std::string_view name, std::string_view bytes);

/// What the whole header says of a log.
/// @throws InputError for a header that ends early or is not as NumPy writes it, numbers that are not little-endian f4
/// or f8, Fortran order, or an array of other than one or two dimensions.
[[nodiscard]] BinaryLayout read_npy_header(std::string_view name, std::string_view bytes);

/// The header of an array of `rows` x `columns` (1-D for one column), of a length that NumPy's own have.
[[nodiscard]] std::string npy_header(std::uint64_t rows, std::size_t columns, bool is_double);

/// The layout of a binary log from its first bytes: the header, or what the options say.
[[nodiscard]] BinaryLayout binary_layout(std::string_view name, std::string_view bytes, Format, std::int64_t columns);

/// Chooses columns by number; LogOptions::unit is that of all of them.
/// @throws InputError for a missing rate or unit, or a column that does not exist.
[[nodiscard]] Choice choose_binary_columns(const std::string& name, const BinaryLayout&, const LogOptions&);

/// Turns whole rows into numbers, column by column, times their to_si; what is not finite becomes NaN.
/// @param columns one for each chosen column, as long as there are rows.
void decode(std::string_view rows, const BinaryLayout&, const Choice&, std::span<const std::span<double>> columns);

/// @throws InputError where the bytes behind the header are not the rows that they should be.
[[nodiscard]] std::int64_t count_rows(std::string_view name, const BinaryLayout&, std::uint64_t bytes);

/// "column 1", from 1.
[[nodiscard]] std::string binary_column_name(std::int64_t index);

}  // namespace gyrobudget::inline v0::log

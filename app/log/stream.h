// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "log.h"

namespace gyrobudget::inline v0::log {

/// A log read piece by piece, in memory that does not grow with its length: pipes without end, files larger than
/// memory.
///
/// It is read as by read_log, with these differences. Packed logs and angles are refused (unpack, or difference them
/// first). The rate of a text with time stamps is LogOptions::rate_hz, or that of its first rows. From there the stamps
/// are followed one by one: one that is late by half an interval or more leaves missing samples before it, one that
/// repeats masks its sample. Time that goes back is an error, and so is a gap by which more than a million samples, and
/// more than there are, would be missing. A gap is handed out in pieces: it takes no more memory than samples do.
///
///     LogStream log({.path = "-", .rate_hz = 100, .unit = "deg/s", .format = Format::f64});
///     std::vector<std::vector<double>> rates;
///     while (log.read(rates, patience) != LogStream::Progress::end) use(rates);
class LogStream {
 public:
  using Column = allan::AxisLabel;
  enum class Progress {
    samples,  ///< there are new ones
    none,     ///< none yet
    end,      ///< and no more will come; there may be new ones
  };

  /// Reads the start, and waits for it: 100 lines, or the header.
  /// @throws InputError for the log, std::invalid_argument for options, as read_log does.
  explicit LogStream(const LogOptions&);
  ~LogStream();
  LogStream(const LogStream&) = delete;
  LogStream& operator=(const LogStream&) = delete;

  [[nodiscard]] const std::string& source() const;
  [[nodiscard]] double rate_hz() const;
  [[nodiscard]] const std::vector<Column>& columns() const;
  [[nodiscard]] const std::vector<std::string>& notes() const;
  [[nodiscard]] const std::vector<std::int64_t>& numbers() const;  ///< so far: of each column, those that are there
  [[nodiscard]] std::int64_t missing_samples() const;              ///< so far: at which any column has no number

  /// The next samples, one vector for each column: rates [SI], NaN where missing. About a megabyte of input, or of
  /// numbers, at most.
  /// Returns early where a signal arrives, and after `patience` without input.
  /// @throws InputError for what is not as it should be.
  Progress read(std::vector<std::vector<double>>& rates, std::chrono::milliseconds patience);

 private:
  class Reader;
  class Text;
  class Binary;
  std::unique_ptr<Reader> reader_;
};

}  // namespace gyrobudget::inline v0::log

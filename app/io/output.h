// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/io/error.h"

#include <cstdio>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::io {

/// A file that appears whole or not at all: written beside its final name, synced and renamed by commit(), removed
/// otherwise (also on an interrupt, see remove_unfinished_outputs). "-" is standard output; devices and pipes are
/// written in place.
class OutputFile {
 public:
  explicit OutputFile(std::string path);   ///< @throws OutputError
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  void write(std::string_view bytes);      ///< @throws OutputError
  void commit();                           ///< @throws OutputError

 private:
  std::string path_, temporary_;
  int descriptor_ = -1;
};

/// The whole of `bytes` as the file `path`.
void write_file(const std::string& path, std::string_view bytes);

/// Async-signal-safe: unlinks temporary files of outputs that were not committed.
void remove_unfinished_outputs() noexcept;

}  // namespace gyrobudget::inline v0::io

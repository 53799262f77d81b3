// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>

#include "error.h"

namespace gyrobudget::inline v0::text {

/// A file that appears whole or not at all: written beside its final name, synced to disk and renamed by commit(),
/// removed otherwise (also on an interrupt, see remove_unfinished_outputs; after a kill, by the next of its name).
/// Until then a file that already has the name stays as it was; afterwards the new one has its access rights. A
/// symbolic link keeps pointing at its target, which is replaced, or made where there was none.
///
/// "-" is standard output. Devices, pipes and /dev/stdout, /dev/fd/N, /proc/... cannot be replaced: they are written
/// in place, as the bytes come.
///
///     OutputFile file("sensor.yaml");
///     file.write(text);
///     file.commit();
class OutputFile {
 public:
  /// @throws OutputError where the file cannot be created: with the path, the system's reason and a mend.
  explicit OutputFile(std::string path);
  ~OutputFile();
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  /// @throws OutputError (disk full, input/output error, closed pipe).
  void write(std::string_view bytes);
  /// Makes the file appear under its name; call it once, last.
  /// @throws OutputError, also for errors that the system reports as late as when it syncs or closes.
  void commit();

 private:
  void open_beside(const std::string& target, unsigned mode);
  void close();

  std::string path_;       ///< as given, for messages
  std::string target_;     ///< final name, links resolved; empty when written in place
  std::string temporary_;  ///< empty when written in place
  int descriptor_ = -1;
  int slot_ = -1;  ///< in the list of unfinished outputs
};

/// The whole of `bytes` as the file `path`. @throws OutputError
void write_file(const std::string& path, std::string_view bytes);

/// Unlinks the temporary files of outputs that were not committed. Async-signal-safe: for the handler of an interrupt.
void remove_unfinished_outputs() noexcept;

}  // namespace gyrobudget::inline v0::text

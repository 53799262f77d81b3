// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace gyrobudget::inline v0::log {

/// A folder of its own for files that libraries must open by a name. It goes with what is in it; files that are open by
/// then stay readable, and nobody has to clear up after a program that was stopped.
class TemporaryFolder {
 public:
  /// @param name  of the input that needs it, for messages
  /// @throws text::InputError where none can be made.
  explicit TemporaryFolder(std::string name);
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] std::string path(std::string_view file) const { return (folder_ / file).string(); }
  /// @throws text::InputError where there is no room.
  void copy(const std::string& from, std::string_view file) const;
  /// Unpacks a file that is packed as a whole.
  /// @return the fault where not all of it is whole
  /// @throws text::InputError where there is no room, it unpacks to more than a recording can, or this build leaves the
  /// library out.
  [[nodiscard]] std::string unpack(const std::string& from, std::string_view file) const;

 private:
  std::string name_;
  std::filesystem::path folder_;
};

}  // namespace gyrobudget::inline v0::log

// SPDX-License-Identifier: MIT
#include "output.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

namespace gyrobudget::inline v0::text {
namespace {

// --- What a signal handler may look at: fixed storage, lock-free flags -------------------------------------------

struct Slot {
  enum State : int { free, reserved, active };
  std::atomic<int> state{free};
  char path[PATH_MAX] = {};
};
static_assert(std::atomic<int>::is_always_lock_free);

constexpr std::size_t kMostUnfinished = 32;
std::array<Slot, kMostUnfinished> unfinished;

/// Notes a temporary file before it is created, so that no interrupt can leave it behind. -1: no room.
int note_unfinished(const std::string& path) {
  if (path.size() >= PATH_MAX) return -1;
  for (std::size_t i = 0; i < unfinished.size(); ++i) {
    int expected = Slot::free;
    if (!unfinished[i].state.compare_exchange_strong(expected, Slot::reserved)) continue;
    std::memcpy(unfinished[i].path, path.c_str(), path.size() + 1);
    unfinished[i].state.store(Slot::active);
    return static_cast<int>(i);
  }
  return -1;
}

void forget_unfinished(int slot) {
  if (slot >= 0) unfinished[static_cast<std::size_t>(slot)].state.store(Slot::free);
}

// --- Messages ----------------------------------------------------------------------------------------------------

std::string mend(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free some space or choose another disk";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a place you may write to";
    case ENOENT:
      return "create its folder first";
    case EISDIR:
      return "name a file in that folder";
    case ENOTDIR:
      return "one part of the path is a file, not a folder";
    case EPIPE:
      return "the program that reads the pipe has ended";
    case ENAMETOOLONG:
      return "choose a shorter name";
    default:
      return "check the disk or choose another place";
  }
}

[[noreturn]] void fail(const std::string& path, int error) {
  throw OutputError(fmt::format("{}: cannot be written: {}; {}", path == "-" ? "standard output" : path,
                                std::generic_category().message(error), mend(error)));
}

// --- Where the bytes go ------------------------------------------------------------------------------------------

/// Names of descriptors, which cannot be replaced even where a regular file is behind them.
bool names_a_descriptor(const std::string& path) {
  return path == "/dev/stdout" || path == "/dev/stderr" || path.starts_with("/dev/fd/") || path.starts_with("/proc/");
}

/// Where the last of the links leads, whether there is a file or not.
std::string resolved(std::string path) {
  constexpr int kMostLinks = 40;  // as the kernel follows
  std::array<char, PATH_MAX> to{};
  for (int i = 0; i < kMostLinks; ++i) {
    const ssize_t size = ::readlink(path.c_str(), to.data(), to.size());
    if (size <= 0) break;
    const std::string_view target(to.data(), static_cast<std::size_t>(size));
    path = target.starts_with('/') ? std::string(target) : path.substr(0, path.rfind('/') + 1) + std::string(target);
  }
  return path;
}

// --- Temporary files ---------------------------------------------------------------------------------------------

/// ".log.csv.1234-1.part": of log.csv, by process 1234.
constexpr std::string_view kPart = ".part";

std::string beside(const std::string& target) {
  static std::atomic<unsigned> count{0};
  const std::size_t name = target.rfind('/') + 1;  // npos + 1 == 0
  return fmt::format("{}.{}.{}-{}{}", target.substr(0, name), target.substr(name), ::getpid(), ++count, kPart);
}

bool is_part_of(std::string_view file, std::string_view name) {
  if (!file.starts_with('.') || !file.ends_with(kPart) || file.size() < name.size() + kPart.size() + 2) return false;
  file = file.substr(1, file.size() - 1 - kPart.size());
  return file.starts_with(name) && file[name.size()] == '.' && file.size() > name.size() + 1 &&
         file.substr(name.size() + 1).find_first_not_of("0123456789-") == std::string_view::npos;
}

/// Who writes a temporary file holds its lock, also on a disk that machines share: one that is free was left behind.
bool lock(int descriptor, int how) {
  while (::flock(descriptor, how) != 0) {
    if (errno != EINTR) return false;
  }
  return true;
}

void remove_if_left_behind(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (descriptor < 0) return;
  struct stat status = {};
  if (::fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
      lock(descriptor, LOCK_EX | LOCK_NB))
    ::unlink(path.c_str());
  ::close(descriptor);
}

/// Runs that were killed could not take their temporary files with them: those of this target go now.
void remove_parts_left_behind(const std::string& target) {
  const std::size_t name = target.rfind('/') + 1;
  const std::string folder = target.substr(0, name);
  std::error_code error;  // of a folder that is not there, or may not be listed: then nothing is found
  std::filesystem::directory_iterator at(folder.empty() ? "." : folder, error);
  for (; !error && at != std::filesystem::directory_iterator(); at.increment(error)) {
    const std::string file = at->path().filename().string();
    if (is_part_of(file, std::string_view(target).substr(name))) remove_if_left_behind(folder + file);
  }
}

/// A new file whose lock is held; -1 and errno where there can be none.
int create_locked(const std::string& path, unsigned mode) {
  for (;;) {
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (descriptor < 0) return -1;
    struct stat status = {};
    lock(descriptor, LOCK_EX);  // where a disk has no locks, nobody removes anything
    if (::fstat(descriptor, &status) != 0 || status.st_nlink > 0) return descriptor;
    ::close(descriptor);  // another run found it before it was locked
  }
}

constexpr unsigned kDefaultMode = 0666;  // less the umask
constexpr unsigned kPermissionBits = 07777;

}  // namespace

OutputFile::OutputFile(std::string path) : path_(std::move(path)) {
  if (path_.empty()) throw OutputError("the name of an output file is empty; name a file, or - for standard output");
  if (path_ == "-") {
    descriptor_ = ::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 0);
    if (descriptor_ < 0) fail(path_, errno);
    return;
  }
  struct stat status = {};
  const bool exists = ::stat(path_.c_str(), &status) == 0;
  if (!exists && errno != ENOENT) fail(path_, errno);
  if (exists && S_ISDIR(status.st_mode)) fail(path_, EISDIR);
  if (exists && (!S_ISREG(status.st_mode) || names_a_descriptor(path_))) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (descriptor_ < 0) fail(path_, errno);
    return;
  }
  // A rename would replace a write-protected file without a word: ask first.
  if (exists && ::access(path_.c_str(), W_OK) != 0) fail(path_, errno);
  open_beside(resolved(path_), exists ? status.st_mode & kPermissionBits : kDefaultMode);
}

void OutputFile::open_beside(const std::string& target, unsigned mode) {
  target_ = target;
  temporary_ = beside(target);
  remove_parts_left_behind(target);
  slot_ = note_unfinished(temporary_);
  if (slot_ < 0) fail(path_, temporary_.size() < PATH_MAX ? EMFILE : ENAMETOOLONG);
  descriptor_ = create_locked(temporary_, kDefaultMode);
  if (descriptor_ < 0) {
    const int error = errno;
    forget_unfinished(slot_);
    fail(path_, error);
  }
  if (mode != kDefaultMode) ::fchmod(descriptor_, mode);  // best effort: the content matters more
}

OutputFile::~OutputFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (slot_ < 0) return;
  ::unlink(temporary_.c_str());
  forget_unfinished(slot_);
}

void OutputFile::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail(path_, errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void OutputFile::commit() {
  // Pipes and terminals have nothing to sync and say EINVAL.
  if (::fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP && errno != EROFS) fail(path_, errno);
  close();
  if (slot_ < 0) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail(path_, errno);
  forget_unfinished(std::exchange(slot_, -1));
}

void OutputFile::close() {
  if (::close(std::exchange(descriptor_, -1)) != 0 && errno != EINTR) fail(path_, errno);
}

void write_file(const std::string& path, std::string_view bytes) {
  OutputFile file(path);
  file.write(bytes);
  file.commit();
}

void remove_unfinished_outputs() noexcept {
  for (Slot& slot : unfinished) {
    if (slot.state.load() == Slot::active) ::unlink(slot.path);
  }
}

}  // namespace gyrobudget::inline v0::text

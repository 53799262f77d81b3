// SPDX-License-Identifier: MIT
#include "rosbag2.h"

#include "gyrobudget/app/log/compression.h"
#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <tuple>
#include <utility>

#include "mcap.h"
#include "message_recording.h"
#include "ros1_bag.h"
#include "sqlite_source.h"
#include "temporary_folder.h"

namespace gyrobudget::inline v0::log {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMetadata = "metadata.yaml";

// --- metadata.yaml ----------------------------------------------------------------------------------------------

/// A scalar of YAML without its quotes or the comment behind it.
std::string yaml_scalar(std::string_view text) {
  text = text::trim(text);
  if (text.empty() || (text.front() != '"' && text.front() != '\'')) {
    return std::string(text::trim(text.substr(0, text.find(" #"))));
  }
  const char quote = text.front();
  std::string value;
  for (std::size_t i = 1; i < text.size(); ++i) {
    const bool is_escape = quote == '"' ? text[i] == '\\' : text[i] == '\'' && text.substr(i).starts_with("''");
    if (text[i] == quote && !is_escape) break;
    if (is_escape && i + 1 < text.size()) ++i;
    value += text[i];
  }
  return value;
}

std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

/// Items between brackets, on one line or more.
std::vector<std::string> flow_sequence(std::string_view text) {
  std::vector<std::string> items;
  text = text.substr(0, text.find(']'));
  while (!text.empty()) {
    const std::size_t comma = std::min(text.find(','), text.size());
    std::string item = yaml_scalar(text.substr(0, comma));
    if (!item.empty()) items.push_back(std::move(item));
    text.remove_prefix(std::min(comma + 1, text.size()));
  }
  return items;
}

/// Items behind dashes, each on a line.
std::vector<std::string> block_sequence(std::string_view text) {
  std::vector<std::string> items;
  while (!text.empty()) {
    const std::string_view line = text::trim(take_line(text));
    if (line.empty() || line.starts_with('#')) continue;
    if (!line.starts_with("- ")) break;
    items.push_back(yaml_scalar(line.substr(2)));
  }
  return items;
}

// --- Files ------------------------------------------------------------------------------------------------------

std::string first_bytes(const std::string& path) {
  constexpr std::size_t kHead = 512;
  std::string head(kHead, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(file.gcount()));
  return head;
}

/// A file of a recording and what is to be said of it.
struct OpenedFile {
  std::string format;
  std::unique_ptr<MessageSource> source;
  std::string note;
};

OpenedFile open_unpacked_file(const std::string& path, const std::string& name) {
  const std::string head = first_bytes(path);
  if (is_sqlite(head)) return {"rosbag2", open_sqlite_source(path, name), {}};
  if (is_mcap(head)) return {"MCAP", open_mcap_source(path, name), {}};
  if (is_ros1_bag(head)) return {"ROS 1 bag", open_ros1_bag_source(path, name), {}};
  text::fail(name,
             fmt::format("begins with {}, expected a database, an MCAP or a bag of ROS; unpack or export it first",
                         text::quoted(head.substr(0, 16))));
}

OpenedFile open_file(const std::string& path) {
  const Compression compression = compression_of(first_bytes(path));
  if (compression == Compression::none) return open_unpacked_file(path, path);
  const TemporaryFolder folder(path);
  const std::string fault = folder.unpack(path, "unpacked");
  OpenedFile file = open_unpacked_file(folder.path("unpacked"), path);
  if (!fault.empty())
    file.note = fmt::format("{}: its {} data are cut or damaged ({})", path, name(compression), fault);
  return file;
}

std::unique_ptr<Recording> one_file(OpenedFile file) {
  std::vector<std::unique_ptr<MessageSource>> sources;
  sources.push_back(std::move(file.source));
  std::vector<std::string> notes;
  if (!file.note.empty()) notes.push_back(std::move(file.note));
  return std::make_unique<MessageRecording>(std::move(file.format), std::move(sources), std::move(notes));
}

// --- Folders ----------------------------------------------------------------------------------------------------

/// A file of a split recording: "name_12.db3" is part 12 of "name".
struct NumberedFile {
  std::string stem, ending;
  std::int64_t number = 0;
  fs::path path;
};

/// @return empty where it is no file of a bag
std::optional<NumberedFile> numbered_file(const fs::path& path) {
  std::string name = path.filename().string();
  if (name.ends_with(".zstd")) name.resize(name.size() - std::string_view(".zstd").size());
  for (const std::string_view ending : {".db3", ".mcap"}) {
    if (!name.ends_with(ending)) continue;
    NumberedFile file{name.substr(0, name.size() - ending.size()), std::string(ending), 0, path};
    const std::size_t underscore = file.stem.rfind('_');
    if (underscore == std::string::npos) return file;
    const char* const end = file.stem.data() + file.stem.size();
    const auto [stop, error] = std::from_chars(file.stem.data() + underscore + 1, end, file.number);
    if (error == std::errc() && stop == end) {
      file.stem.resize(underscore);
    } else {
      file.number = 0;
    }
    return file;
  }
  return std::nullopt;
}

std::vector<fs::path> files_of_folder(const std::string& path) {
  std::vector<NumberedFile> files;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(path, error)) {
    std::optional<NumberedFile> file = entry.is_regular_file(error) ? numbered_file(entry.path()) : std::nullopt;
    if (file) files.push_back(std::move(*file));
  }
  if (error) text::fail(path, fmt::format("cannot be listed: {}; check its permissions", error.message()));
  const auto is_of_another = [&](const NumberedFile& file) {
    return file.stem != files.front().stem || file.ending != files.front().ending;
  };
  const auto other = std::ranges::find_if(files, is_of_another);
  if (other != files.end()) {
    text::fail(path, fmt::format("has no {}, and files of several recordings, {} and {}; name one of these files",
                                 kMetadata, text::quoted(files.front().path.filename().string()),
                                 text::quoted(other->path.filename().string())));
  }
  // Of a file that is there packed and not packed, the recorder has not finished packing: the longer name goes.
  const auto key = [](const NumberedFile& file) { return std::tuple(file.number, file.path.native().size()); };
  std::ranges::sort(files, {}, key);
  const auto is_same = [](const NumberedFile& a, const NumberedFile& b) { return a.number == b.number; };
  files.erase(std::unique(files.begin(), files.end(), is_same), files.end());
  std::vector<fs::path> paths;
  for (const NumberedFile& file : files) paths.push_back(file.path);
  return paths;
}

/// Where a file of the metadata is: in the folder, whatever that was called when it was recorded (up to version 3 the
/// path begins with that name), and packed or not.
std::optional<fs::path> find_file(const fs::path& folder, const std::string& named) {
  const fs::path file(named);
  for (const fs::path& candidate : {folder / file, folder / file.filename(), folder.parent_path() / file}) {
    for (const char* suffix : {"", ".zstd"}) {
      fs::path path = candidate;
      path += suffix;
      std::error_code error;
      if (fs::is_regular_file(path, error)) return path;
    }
  }
  return std::nullopt;
}

std::vector<fs::path> files_of_metadata(const fs::path& folder, const std::vector<std::string>& named,
                                        std::vector<std::string>& notes) {
  std::vector<fs::path> files;
  for (const std::string& name : named) {
    std::optional<fs::path> file = find_file(folder, name);
    if (file) {
      files.push_back(std::move(*file));
    } else {
      notes.push_back(fmt::format("{} names {}, which is not there: left out", kMetadata, text::quoted(name)));
    }
  }
  return files;
}

/// Of several files one may be empty or torn, the last one of a recorder that was killed: the others are read.
std::vector<std::unique_ptr<MessageSource>> open_files(const std::vector<fs::path>& files,
                                                       std::vector<std::string>& notes) {
  std::vector<std::unique_ptr<MessageSource>> sources;
  std::string first_fault;
  for (const fs::path& file : files) {
    try {
      OpenedFile opened = open_file(file.string());
      sources.push_back(std::move(opened.source));
      if (!opened.note.empty()) notes.push_back(std::move(opened.note));
    } catch (const text::InputError& error) {
      if (first_fault.empty()) first_fault = error.what();
      notes.push_back(fmt::format("a file is left out: {}", error.what()));
    }
  }
  if (sources.empty()) throw text::InputError(first_fault);
  return sources;
}

}  // namespace

std::optional<std::vector<std::string>> rosbag2_files(std::string_view metadata) {
  constexpr std::string_view kKey = "relative_file_paths:";
  bool is_bag = false;
  while (!metadata.empty()) {
    const std::string_view line = text::trim(take_line(metadata));
    is_bag = is_bag || line.starts_with("rosbag2_bagfile_information:");
    if (!is_bag || !line.starts_with(kKey)) continue;
    const std::string_view behind = text::trim(line.substr(kKey.size()));
    if (!behind.starts_with('[')) return block_sequence(metadata);
    const char* const begin = behind.data() + 1;
    return flow_sequence({begin, static_cast<std::size_t>(metadata.data() + metadata.size() - begin)});
  }
  if (!is_bag) return std::nullopt;
  return std::vector<std::string>();
}

std::unique_ptr<Recording> open_rosbag2_folder(const std::string& path) {
  constexpr std::size_t kMostMetadata = std::size_t{64} << 20;
  const fs::path folder = fs::path(path).has_filename() ? fs::path(path) : fs::path(path).parent_path();
  std::error_code error;
  std::vector<fs::path> files;
  std::vector<std::string> notes;
  if (fs::is_regular_file(folder / kMetadata, error)) {
    const std::string metadata = text::read_text((folder / kMetadata).string(), kMostMetadata, "the metadata of a bag");
    const auto named = rosbag2_files(metadata);
    if (!named) return nullptr;
    files = files_of_metadata(folder, *named, notes);
  }
  if (files.empty()) {
    files = files_of_folder(folder.string());
    if (files.empty()) return nullptr;
    notes.push_back(fmt::format(
        "the recorder did not write {}, or its files were renamed: all files of the folder are read", kMetadata));
  }
  std::vector<std::unique_ptr<MessageSource>> sources = open_files(files, notes);
  return std::make_unique<MessageRecording>("rosbag2", std::move(sources), std::move(notes));
}

std::unique_ptr<Recording> open_rosbag2_database(const std::string& path) { return one_file(open_file(path)); }

std::unique_ptr<Recording> open_packed_recording(const std::string& path) { return one_file(open_file(path)); }

}  // namespace gyrobudget::inline v0::log

// SPDX-License-Identifier: MIT
#include "hdf5.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#if GYROBUDGET_HAS_HDF5
#include <fcntl.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include "arrays.h"
#include "rows.h"
#endif

namespace gyrobudget::inline v0::log {

bool is_matlab_73(std::string_view head) {
  using namespace std::string_view_literals;
  constexpr std::size_t kVersionAt = 124;
  return head.starts_with("MATLAB 7.3 MAT-file") && head.size() >= kVersionAt + 4 &&
         head.substr(kVersionAt, 4) == "\x00\x02IM"sv;
}

bool is_hdf5(std::string_view head) {
  constexpr std::string_view kSignature = "\x89HDF\r\n\x1a\n";
  for (const std::size_t at : {0, 512, 1024, 2048})
    if (at < head.size() && head.substr(at).starts_with(kSignature)) return true;
  return false;
}

#if GYROBUDGET_HAS_HDF5
namespace hdf5 {
namespace {

/// The library is built without threads of its own: one at a time.
std::mutex& library() {
  static std::mutex mutex;
  return mutex;
}

/// Holds the library, and keeps it from printing what it thinks of a file.
class Library {
 public:
  Library() : lock_(library()) { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

 private:
  std::lock_guard<std::mutex> lock_;
};

/// Whether a call comes back. The library crashes on some damaged files, so that a process of its own goes first: it
/// leaves nothing behind, and is ended where it takes too long.
template <class Call>
bool comes_back(const Call& call) {
  const pid_t child = ::fork();
  if (child < 0) return true;  // nothing is told
  if (child == 0) {
    constexpr unsigned kLongest_s = 60;
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGALRM}) std::signal(signal, SIG_DFL);
    ::alarm(kLongest_s);
    const int nowhere = ::open("/dev/null", O_WRONLY);
    if (nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);
    try {
      call();
    } catch (...) {  // it will be thrown again
    }
    ::_exit(0);
  }
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status);
}

/// Something of the library's, to be closed.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&&) = delete;
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  [[nodiscard]] hid_t id() const { return id_; }
  [[nodiscard]] bool good() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// What the library asks for while it takes the bytes of a file as they are, where they are: it copies nothing, and does
// not write.
extern "C" {
void* gyrobudget_image(std::size_t /*size*/, H5FD_file_image_op_t /*operation*/, void* bytes) { return bytes; }
void* gyrobudget_image_copy(void* to, const void* /*from*/, std::size_t /*size*/, H5FD_file_image_op_t /*operation*/,
                            void* /*bytes*/) {
  return to;
}
void* gyrobudget_image_resize(void* /*old*/, std::size_t /*size*/, H5FD_file_image_op_t /*operation*/,
                              void* /*bytes*/) {
  return nullptr;
}
herr_t gyrobudget_image_free(void* /*image*/, H5FD_file_image_op_t /*operation*/, void* /*bytes*/) { return 0; }
void* gyrobudget_image_data(void* bytes) { return bytes; }
herr_t gyrobudget_image_data_free(void* /*bytes*/) { return 0; }
}

/// A file that the library has open, by its bytes: it was mapped or unpacked.
class File {
 public:
  explicit File(std::shared_ptr<const Bytes> bytes) : bytes_(std::move(bytes)) {
    if (bytes_->cut())
      text::fail(name(),
                 fmt::format("the {} data stop in the middle, and a part of an HDF5 file is no file; fetch it again",
                             log::name(bytes_->compression())));
    const Library held;
    if (comes_back([this] { open(); })) open();
    if (file_ >= 0) return;
    text::fail(
        name(),
        "cannot be opened as HDF5: it is cut or damaged, or was not closed when it was written; copy it again, or try h5clear -s and h5repack");
  }
  ~File() {
    const Library held;
    H5Fclose(file_);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  [[nodiscard]] hid_t id() const { return file_; }
  [[nodiscard]] const std::string& name() const { return bytes_->name(); }
  void release() const { bytes_->release(bytes_->text()); }

 private:
  void open() {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    char* image = const_cast<char*>(bytes_->text().data());  // the library's interface; only read
    H5FD_file_image_callbacks_t callbacks{gyrobudget_image,
                                          gyrobudget_image_copy,
                                          gyrobudget_image_resize,
                                          gyrobudget_image_free,
                                          gyrobudget_image_data,
                                          gyrobudget_image_data_free,
                                          image};
    constexpr std::size_t kIncrement = std::size_t{1} << 16;
    static std::uint64_t opened = 0;
    if (H5Pset_fapl_core(access.id(), kIncrement, 0) >= 0 &&
        H5Pset_file_image_callbacks(access.id(), &callbacks) >= 0 &&
        H5Pset_file_image(access.id(), image, bytes_->text().size()) >= 0)
      file_ = H5Fopen(fmt::format("recording {}", ++opened).c_str(), H5F_ACC_RDONLY, access.id());
  }

  std::shared_ptr<const Bytes> bytes_;
  hid_t file_ = -1;
};

// --- Attributes -----------------------------------------------------------------------------------------------------

bool has_attribute(hid_t object, const char* name) { return H5Aexists(object, name) > 0; }

/// A short text, however it ends; empty where there is none.
std::string text_attribute(hid_t object, const char* name) {
  constexpr std::size_t kMost = 256;
  if (!has_attribute(object, name)) return {};
  const Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  if (!attribute.good()) return {};
  const Handle type(H5Aget_type(attribute.id()), H5Tclose), space(H5Aget_space(attribute.id()), H5Sclose);
  if (!type.good() || H5Tget_class(type.id()) != H5T_STRING || H5Sget_simple_extent_npoints(space.id()) != 1) return {};
  if (H5Tis_variable_str(type.id()) > 0) {
    char* text = nullptr;
    if (H5Aread(attribute.id(), type.id(), &text) < 0 || !text) return {};
    std::string copy(text, ::strnlen(text, kMost));
    H5free_memory(text);
    return clean_name(copy);
  }
  const std::size_t size = H5Tget_size(type.id());
  if (size == 0 || size > kMost) return {};
  std::string text(size, '\0');
  if (H5Aread(attribute.id(), type.id(), text.data()) < 0) return {};
  return clean_name(std::string_view(text).substr(0, text.find('\0')));
}

// --- Data sets ------------------------------------------------------------------------------------------------------

/// Which of a data set's dimensions are rows and columns.
struct Extent {
  std::vector<hsize_t> lengths;
  std::size_t rows = 0;
  std::optional<std::size_t> columns;
  ArrayShape shape;
};

/// @param reversed  as MATLAB and Octave write them: the first dimension is the last of the data set
std::optional<Extent> extent_of(hid_t space, bool reversed, std::vector<std::int64_t>& lengths) {
  constexpr int kMostDimensions = 8;
  const int count = H5Sget_simple_extent_ndims(space);
  if (count < 0 || count > kMostDimensions) return std::nullopt;
  Extent extent;
  extent.lengths.resize(static_cast<std::size_t>(count));
  if (H5Sget_simple_extent_dims(space, extent.lengths.data(), nullptr) < 0) return std::nullopt;
  for (const hsize_t length : extent.lengths)
    lengths.push_back(static_cast<std::int64_t>(std::min<hsize_t>(length, hsize_t{1} << 62)));
  if (reversed) std::ranges::reverse(lengths);
  const auto shape = array_shape(lengths);
  if (!shape) return std::nullopt;
  extent.shape = *shape;
  std::vector<std::size_t> long_ones;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const std::size_t place = reversed ? lengths.size() - 1 - i : i;
    if (extent.lengths[place] > 1) long_ones.push_back(place);
  }
  if (long_ones.size() == 2 && shape->transposed) std::swap(long_ones[0], long_ones[1]);
  if (!long_ones.empty()) extent.rows = long_ones[0];
  if (long_ones.size() > 1) extent.columns = long_ones[1];
  return extent;
}

/// Reads columns of one data set.
class DataSet {
 public:
  DataSet(hid_t file, const std::string& path, Extent extent)
      : extent_(std::move(extent)),
        set_(open(file, path)),
        space_(set_.good() ? H5Dget_space(set_.id()) : -1, H5Sclose) {}

  /// @returns false where the library cannot
  bool read(const File& file, std::span<const WantedColumn> columns) {
    if (!set_.good() || !space_.good()) return false;
    const bool by_columns = !extent_.columns || *extent_.columns < extent_.rows;
    const auto rows = static_cast<std::size_t>(extent_.shape.rows);
    for (std::size_t row = 0; row < rows;) {
      const std::size_t count = std::min(block(by_columns), rows - row);
      if (!(by_columns ? read_columns(row, count, columns) : read_rows(row, count, columns))) return false;
      row += count;
      file.release();
    }
    return true;
  }

 private:
  static constexpr std::size_t kBlock = std::size_t{1} << 16;

  /// With a cache that holds a row of chunks, or each would be unpacked for each column.
  Handle open(hid_t file, const std::string& path) {
    const Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
    const double bytes = look_at_chunks(file, path);
    constexpr double kLeast = 1 << 20, kMost = 1 << 30;
    constexpr std::size_t kSlots = 4099;
    H5Pset_chunk_cache(access.id(), kSlots, static_cast<std::size_t>(std::clamp(2 * bytes, kLeast, kMost)), 1);
    return {H5Dopen2(file, path.c_str(), access.id()), H5Dclose};
  }

  /// The set is closed again: the library keeps the cache with which it was opened first.
  /// @returns bytes of the chunks beside each other that hold all columns
  double look_at_chunks(hid_t file, const std::string& path) {
    const Handle set(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (!set.good()) return 0;
    const Handle creation(H5Dget_create_plist(set.id()), H5Pclose), type(H5Dget_type(set.id()), H5Tclose);
    std::vector<hsize_t> chunk(extent_.lengths.size());
    const bool is_chunked = !chunk.empty() && H5Pget_layout(creation.id()) == H5D_CHUNKED &&
                            H5Pget_chunk(creation.id(), static_cast<int>(chunk.size()), chunk.data()) > 0;
    if (!is_chunked) return 0;
    chunk_rows_ = std::max<hsize_t>(1, chunk[extent_.rows]);
    auto bytes = static_cast<double>(H5Tget_size(type.id()));
    for (const hsize_t length : chunk) bytes *= static_cast<double>(length);
    if (extent_.columns)
      bytes *= std::ceil(static_cast<double>(extent_.shape.columns) / static_cast<double>(chunk[*extent_.columns]));
    return bytes;
  }

  /// Rows at a time: whole chunks where they are not too long.
  [[nodiscard]] std::size_t block(bool by_columns) const {
    const std::size_t wide =
        by_columns ? kBlock : std::max<std::size_t>(1, 4 * kBlock / static_cast<std::size_t>(extent_.shape.columns));
    if (by_columns && chunk_rows_ > wide) return static_cast<std::size_t>(chunk_rows_);
    return std::max<std::size_t>(1, wide / static_cast<std::size_t>(chunk_rows_)) *
           static_cast<std::size_t>(std::min<hsize_t>(chunk_rows_, wide));
  }

  bool select(std::size_t row, std::size_t rows, std::size_t column, std::size_t columns, double* out) {
    std::vector<hsize_t> start(extent_.lengths.size(), 0), count(extent_.lengths.size(), 1);
    if (!start.empty()) {
      start[extent_.rows] = row;
      count[extent_.rows] = rows;
    }
    if (extent_.columns) {
      start[*extent_.columns] = column;
      count[*extent_.columns] = columns;
    }
    if (!start.empty() &&
        H5Sselect_hyperslab(space_.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) < 0)
      return false;
    // Of the same shape, or the library would go from number to number.
    const Handle memory(
        start.empty() ? H5Screate(H5S_SCALAR) : H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
        H5Sclose);
    return H5Dread(set_.id(), H5T_NATIVE_DOUBLE, memory.id(), space_.id(), H5P_DEFAULT, out) >= 0;
  }

  bool read_columns(std::size_t row, std::size_t count, std::span<const WantedColumn> columns) {
    return std::ranges::all_of(
        columns, [&](const WantedColumn& c) { return select(row, count, c.column, 1, c.out.data() + row); });
  }

  bool read_rows(std::size_t row, std::size_t count, std::span<const WantedColumn> columns) {
    const auto width = static_cast<std::size_t>(extent_.shape.columns);
    buffer_.resize(count * width);
    if (!select(row, count, 0, width, buffer_.data())) return false;
    for (const WantedColumn& c : columns)
      for (std::size_t i = 0; i < count; ++i) c.out[row + i] = buffer_[i * width + c.column];
    return true;
  }

  Extent extent_;
  hsize_t chunk_rows_ = 1;
  Handle set_, space_;
  std::vector<double> buffer_;
};

/// Whether a type is of the integers and floating-point numbers that processors have. A damaged file may tell of
/// others, and the library computes with them beyond its memory.
bool is_number(hid_t type) {
  const H5T_class_t of = H5Tget_class(type);
  const std::size_t size = H5Tget_size(type), bits = 8 * size;
  if (of != H5T_INTEGER && of != H5T_FLOAT) return false;
  if (size != 1 && size != 2 && size != 4 && size != 8) return false;
  if (H5Tget_precision(type) != bits || H5Tget_offset(type) != 0) return false;
  if (of == H5T_INTEGER) return true;
  std::size_t sign = 0, exponent_at = 0, exponent = 0, fraction_at = 0, fraction = 0;
  if (H5Tget_fields(type, &sign, &exponent_at, &exponent, &fraction_at, &fraction) < 0) return false;
  const std::size_t expected = size == 8 ? 11 : size == 4 ? 8 : 5;
  return size > 1 && sign == bits - 1 && exponent == expected && fraction == bits - 1 - expected && fraction_at == 0 &&
         exponent_at == fraction;
}

/// Why numbers of a data set cannot be had; empty where they can.
/// @param size  bytes of one of its numbers
std::string obstacle(hid_t set, std::int64_t numbers, std::size_t size) {
  const Handle creation(H5Dget_create_plist(set), H5Pclose);
  if (H5Pget_layout(creation.id()) == H5D_VIRTUAL || H5Pget_external_count(creation.id()) > 0)
    return "kept in other files";
  for (int i = 0; i < H5Pget_nfilters(creation.id()); ++i) {
    unsigned flags = 0, settings = 0;
    std::size_t values = 0;
    constexpr std::size_t kName = 64;
    std::array<char, kName> name{};
    const H5Z_filter_t filter = H5Pget_filter2(creation.id(), static_cast<unsigned>(i), &flags, &values, nullptr, kName,
                                               name.data(), &settings);
    if (H5Zfilter_avail(filter) <= 0) {
      name.back() = '\0';
      return fmt::format("packed by the filter {} ({}), which is not here: h5repack -f GZIP=4", filter,
                         clean_name(name.data()));
    }
  }
  // A chunk is unpacked whole, however little of it there is.
  std::array<hsize_t, H5S_MAX_RANK> chunk{};
  const int dimensions =
      H5Pget_layout(creation.id()) == H5D_CHUNKED ? H5Pget_chunk(creation.id(), H5S_MAX_RANK, chunk.data()) : 0;
  double chunk_bytes = dimensions > 0 ? static_cast<double>(size) : 0;
  for (int i = 0; i < dimensions; ++i) chunk_bytes *= static_cast<double>(chunk[static_cast<std::size_t>(i)]);
  constexpr double kMostGrowth = 1100, kAlways = 1 << 16;
  const double most = kMostGrowth * static_cast<double>(H5Dget_storage_size(set)) + kAlways;
  return static_cast<double>(numbers) * static_cast<double>(size) > most || chunk_bytes > most ? "never filled" : "";
}

// --- Groups ---------------------------------------------------------------------------------------------------------

struct Entry {
  std::string name;
  bool is_hard = false;
};

extern "C" herr_t gyrobudget_collect_link(hid_t /*group*/, const char* name, const H5L_info_t* info, void* data) {
  constexpr std::size_t kMost = 100'000;
  auto& entries = *static_cast<std::vector<Entry>*>(data);
  try {
    entries.push_back({name, info->type == H5L_TYPE_HARD});
  } catch (...) {  // not through a library in C
    return -1;
  }
  return entries.size() < kMost ? 0 : 1;
}

class Reader {
 public:
  explicit Reader(std::shared_ptr<const Bytes> bytes, std::string format, bool is_matlab)
      : format_(std::move(format)), is_matlab_(is_matlab), file_(std::make_shared<File>(std::move(bytes))) {}

  std::unique_ptr<Recording> run() {
    {
      const Library held;
      const Handle root(H5Gopen2(file_->id(), "/", H5P_DEFAULT), H5Gclose);
      const bool sound = comes_back([&] {
        is_trial_ = true;
        if (root.good()) walk(root.id(), "/", "", 0);
      });
      if (!sound)
        text::fail(file_->name(),
                   "is a damaged HDF5 file, on which the library itself fails; copy it again, or try h5repack");
      if (root.good()) walk(root.id(), "/", "", 0);
      objects_.note(notes_);
      left_out_.note(notes_);
    }
    return std::make_unique<ArrayRecording>(format_, std::move(arrays_), std::move(notes_), file_);
  }

 private:
  void leave_out(std::string_view reason, std::string_view name) {
    left_out_.add(fmt::format("left out, {}", reason), name);
  }

  void walk(hid_t group, const std::string& path, const std::string& name, int depth) {
    constexpr int kDeepest = 16;
    std::vector<Entry> entries;
    hsize_t index = 0;
    if (H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, &index, gyrobudget_collect_link, &entries) < 0)
      notes_.push_back(fmt::format("the group {} is damaged: not all of it was read", clean_name(path)));
    for (const Entry& entry : entries) {
      if (is_matlab_ && depth == 0 && entry.name.starts_with('#')) continue;  // what cells and objects refer to
      const std::string shown = clean_name(entry.name), full = name.empty() ? shown : name + separator() + shown;
      if (!entry.is_hard || depth == kDeepest) {
        leave_out(entry.is_hard ? "groups too deep" : "links to elsewhere", full);
        continue;
      }
      const Handle object(H5Oopen(group, entry.name.c_str(), H5P_DEFAULT), H5Oclose);
      if (!object.good()) {
        leave_out("damaged", full);
      } else if (H5Iget_type(object.id()) == H5I_DATASET) {
        data_set(object.id(), path + entry.name, name, shown);
      } else if (H5Iget_type(object.id()) == H5I_GROUP) {
        enter(object.id(), path + entry.name + "/", full, depth);
      }
    }
  }

  [[nodiscard]] std::string separator() const { return is_matlab_ ? "." : "/"; }

  void enter(hid_t group, const std::string& path, const std::string& name, int depth) {
    H5O_info_t info;
    if (H5Oget_info(group, &info) < 0 || !seen_.insert({info.fileno, info.addr}).second) return;  // groups in a circle
    if (has_attribute(group, "MATLAB_sparse")) return leave_out("sparse matrices", name);
    if (has_attribute(group, "pandas_type")) return leave_out("tables of pandas (save them with to_csv)", name);
    if (has_attribute(group, "OCTAVE_NEW_FORMAT")) return octave(group, path, name, depth);
    walk(group, path, name, depth + 1);
  }

  /// A variable of Octave is a group of its type and its value.
  void octave(hid_t group, const std::string& path, const std::string& name, int depth) {
    const Handle value(H5Oopen(group, "value", H5P_DEFAULT), H5Oclose);
    if (!value.good()) return leave_out("damaged", name);
    if (H5Iget_type(value.id()) == H5I_GROUP) return walk(value.id(), path + "value/", name, depth + 1);
    const bool was_matlab = std::exchange(is_matlab_, true);  // it turns dimensions as MATLAB does
    const std::size_t dot = name.rfind('/');
    const std::string parent = dot == std::string::npos ? "" : name.substr(0, dot);
    data_set(value.id(), path + "value", parent, dot == std::string::npos ? name : name.substr(dot + 1));
    is_matlab_ = was_matlab;
  }

  void data_set(hid_t set, const std::string& path, const std::string& group, const std::string& name) {
    const std::string full = group.empty() ? name : group + separator() + name;
    const std::string matlab_class = text_attribute(set, "MATLAB_class");
    if (has_attribute(set, "MATLAB_object_decode")) return objects_.add(full, matlab_class);
    if (has_attribute(set, "MATLAB_empty") || has_attribute(set, "OCTAVE_EMPTY_MATRIX"))
      return leave_out("empty", full);
    const Handle type(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose);
    if (!type.good() || !space.good()) return leave_out("damaged", full);
    const H5T_class_t of = H5Tget_class(type.id());
    if (matlab_class == "char" || of == H5T_STRING) return leave_out("text", full);
    if (of == H5T_REFERENCE) return leave_out("cells", full);
    if (of == H5T_COMPOUND)
      return leave_out("complex numbers, ranges and records (save x + 0, or each by itself)", full);
    if (!is_number(type.id())) return leave_out("no numbers", full);
    std::vector<std::int64_t> lengths;
    const auto extent = extent_of(space.id(), is_matlab_, lengths);
    if (!extent) return leave_out("empty, of more than two dimensions, or wide", full);
    if (const std::string why = obstacle(set, extent->shape.rows * extent->shape.columns, H5Tget_size(type.id()));
        !why.empty())
      return leave_out(why, full);
    if (arrays_.size() == kMostArrays) return leave_out("more arrays than a log has", full);
    if (is_trial_) return try_first_row(path, *extent);
    const bool may_round = of == H5T_INTEGER && H5Tget_size(type.id()) >= sizeof(std::int64_t);
    arrays_.push_back({group, name, extent->shape, unit_of(set), reading(path, full, *extent, may_round)});
  }

  /// What tells where its numbers are is looked at too.
  void try_first_row(const std::string& path, Extent extent) const {
    extent.shape.rows = 1;
    double number = 0;
    const WantedColumn first{0, {&number, 1}};
    static_cast<void>(DataSet(file_->id(), path, extent).read(*file_, {&first, 1}));
  }

  static std::string unit_of(hid_t set) {
    const std::string unit = text_attribute(set, "units");
    return unit.empty() ? text_attribute(set, "unit") : unit;
  }

  [[nodiscard]] std::function<bool(std::span<const WantedColumn>)> reading(const std::string& path,
                                                                           const std::string& name,
                                                                           const Extent& extent, bool may_round) const {
    return [file = file_, path, name, extent, may_round](std::span<const WantedColumn> columns) {
      const Library held;
      const bool sound = DataSet(file->id(), path, extent).read(*file, columns);
      if (!sound) text::fail(file->name(), fmt::format("the data of {} are damaged; copy the file again", name));
      constexpr double kExact = 9007199254740992;  // 2^53
      return may_round && std::ranges::any_of(columns, [](const WantedColumn& c) {
               return std::ranges::any_of(c.out, [](double v) { return v > kExact || v < -kExact; });
             });
    };
  }

  std::string format_;
  bool is_matlab_;
  bool is_trial_ = false;
  std::shared_ptr<File> file_;
  std::set<std::pair<unsigned long, haddr_t>> seen_;
  std::vector<Array> arrays_;
  MatlabObjects objects_;
  NamesByReason left_out_;
  std::vector<std::string> notes_;
};

}  // namespace
}  // namespace hdf5

std::unique_ptr<Recording> open_hdf5(std::shared_ptr<const Bytes> bytes) {
  const bool is_matlab = is_matlab_73(bytes->text());
  return hdf5::Reader(std::move(bytes), is_matlab ? "MATLAB 7.3" : "HDF5", is_matlab).run();
}
#else
std::unique_ptr<Recording> open_hdf5(std::shared_ptr<const Bytes> bytes) {
  text::fail(
      bytes->name(),
      "is an HDF5 or MATLAB 7.3 file, which this build cannot read; build it with Debian's package libhdf5-dev, or save it with '-v7'");
}
#endif

}  // namespace gyrobudget::inline v0::log

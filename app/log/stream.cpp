// SPDX-License-Identifier: MIT
#include "stream.h"

#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/noise/constants.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "binary.h"
#include "bytes.h"
#include "clock.h"
#include "compression.h"
#include "grid.h"
#include "layout.h"
#include "table.h"

namespace gyrobudget::inline v0::log {
namespace {

using std::chrono::milliseconds;

constexpr std::size_t kBlock = std::size_t{1} << 20;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A descriptor and the bytes of it that are not used yet.
class Inlet {
 public:
  explicit Inlet(const std::string& path)
      : name_(path == "-" ? "standard input" : path),
        descriptor_(path == "-" ? STDIN_FILENO : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY)),
        owned_(path != "-") {
    if (descriptor_ < 0) fail_to_read(errno);
  }
  ~Inlet() {
    if (owned_) ::close(descriptor_);
  }
  Inlet(const Inlet&) = delete;
  Inlet& operator=(const Inlet&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::string_view bytes() const { return buffer_; }
  [[nodiscard]] bool ended() const { return ended_; }
  void drop(std::size_t count) { buffer_.erase(0, count); }

  /// Takes in what is there, up to a block; waits at most `patience` for the first of it.
  void fill(milliseconds patience) {
    while (!ended_ && buffer_.size() < kBlock && readable(patience)) {
      const std::size_t before = buffer_.size();
      buffer_.resize(kBlock);
      const ssize_t got = ::read(descriptor_, buffer_.data() + before, kBlock - before);
      const int error = errno;
      buffer_.resize(before + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
      if (got < 0 && error == EINTR) return;
      if (got < 0) fail_to_read(error);
      ended_ = got == 0;
      patience = milliseconds{0};
    }
  }

 private:
  [[noreturn]] void fail_to_read(int error) const {
    text::fail(name_,
               fmt::format("cannot be read: {}; check the path and the disk", std::generic_category().message(error)));
  }
  [[nodiscard]] bool readable(milliseconds patience) const {
    pollfd wanted{descriptor_, POLLIN, 0};
    return ::poll(&wanted, 1, static_cast<int>(patience.count())) > 0;
  }

  std::string name_;
  int descriptor_;
  bool owned_;
  bool ended_ = false;
  std::string buffer_;
};

/// Follows time stamps that come one by one.
class Tracker {
 public:
  struct Place {
    std::int64_t missing = 0;  ///< points to leave out before this one
    bool repeated = false;     ///< the stamp of the row before: masks its point
    bool is_placed = true;     ///< the row has a stamp
  };

  explicit Tracker(double interval_ns) : interval_(interval_ns) {}

  /// @param fail_here is called with what is wrong with this stamp.
  template <class Fail>
  Place next(std::int64_t stamp, const Fail& fail_here) {
    if (!started_) {
      started_ = true;
      origin_ = before_ = stamp;
      expected_ = interval_;
      stamps_ = 1;
      return {};
    }
    if (stamp == before_) return {.repeated = true};
    std::int64_t since = 0;
    if (__builtin_sub_overflow(stamp, origin_, &since)) fail_here("jumps by more than 292 years");
    if (stamp < before_) {
      fail_here(fmt::format("goes back by {:g} s",
                            (static_cast<double>(before_) - static_cast<double>(stamp)) * noise::kNanosecond));
    }
    before_ = stamp;
    const auto time = static_cast<double>(since);
    const double late = std::max(0.0, std::rint((time - expected_) / interval_));
    // As in a whole log, where at most half may be missing: so that no few stamps make work without end.
    constexpr double kAlwaysFilled = 1e6;
    if (missing_ + late > std::max(kAlwaysFilled, stamps_)) {
      fail_here(fmt::format("jumps by {:g} s: {:.0f} samples are missing by now, more than the {:.0f} that are there",
                            (time - expected_) * noise::kNanosecond, missing_ + late, stamps_));
    }
    constexpr double kGain = 0.05;  // share of the offset that is taken over with each stamp
    const double tracked = expected_ + late * interval_;
    expected_ = tracked + kGain * (time - tracked) + interval_;
    missing_ += late;
    ++stamps_;
    return {.missing = static_cast<std::int64_t>(late)};
  }

 private:
  double interval_;
  bool started_ = false;
  std::int64_t origin_ = 0, before_ = 0;
  double expected_ = 0;
  double missing_ = 0, stamps_ = 0;  ///< how many so far
};

LogOptions checked(const LogOptions& options) {
  if (options.rate_hz && !(std::isfinite(*options.rate_hz) && *options.rate_hz > 0)) {
    throw std::invalid_argument(fmt::format("rate_hz is {} Hz; it must be above 0 and finite", *options.rate_hz));
  }
  if (!std::isfinite(options.scale) || options.scale == 0) {
    throw std::invalid_argument(fmt::format("scale is {}; it must be finite and not 0", options.scale));
  }
  if (options.input == Input::angle) {
    throw std::invalid_argument("a stream holds rates or increments; angles are read as a whole only");
  }
  return options;
}

}  // namespace

// --- What both kinds share ------------------------------------------------------------------------------------------

class LogStream::Reader {
 public:
  explicit Reader(const LogOptions& options) : options_(checked(options)), inlet_(options.path) {}
  virtual ~Reader() = default;
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  Progress read(std::vector<std::vector<double>>& rates, milliseconds patience) {
    rates.resize(columns_.size());
    for (auto& column : rates) column.clear();
    if (!holds_back()) inlet_.fill(patience);
    take(rates);
    if (options_.input == Input::increment) {
      for (auto& column : rates) {
        for (double& v : column) v *= rate_hz_;
      }
    }
    count_missing(rates);
    if (inlet_.ended() && !holds_back()) return Progress::end;
    return rates.front().empty() ? Progress::none : Progress::samples;
  }

  std::vector<Column> columns_;
  double rate_hz_ = 0;
  std::vector<std::string> notes_;
  std::int64_t missing_ = 0;
  std::vector<std::int64_t> numbers_;  ///< of each column
  [[nodiscard]] const Inlet& inlet() const { return inlet_; }

 protected:
  /// Moves whole rows from the inlet into the columns: all of them, or those before a long gap.
  virtual void take(std::vector<std::vector<double>>& columns) = 0;
  /// Whether rows of the last take are left for the next one.
  [[nodiscard]] virtual bool holds_back() const { return false; }

  void refuse_packed() const {
    const Compression compression = compression_of(inlet_.bytes());
    if (compression == Compression::none) return;
    text::fail(inlet_.name(),
               fmt::format("is {}, which is not read as a stream; unpack it: {} LOG | gyrobudget allan -",
                           log::name(compression), command(compression)));
  }

  void choose(Choice choice) {
    choice_ = std::move(choice);
    for (const DataColumn& c : choice_.data) columns_.push_back({c.name, c.signal});
    notes_.insert(notes_.end(), choice_.notes.begin(), choice_.notes.end());
  }

  LogOptions options_;
  Inlet inlet_;
  Choice choice_;

 private:
  void count_missing(const std::vector<std::vector<double>>& rates) {
    numbers_.resize(rates.size());
    for (std::size_t i = 0; i < rates.size(); ++i)
      numbers_[i] += std::ranges::count_if(rates[i], [](double rate) { return !std::isnan(rate); });
    for (std::size_t i = 0; i < rates.front().size(); ++i) {
      missing_ += std::ranges::any_of(rates, [&](const auto& c) { return std::isnan(c[i]); }) ? 1 : 0;
    }
  }
};

// --- Binary ---------------------------------------------------------------------------------------------------------

class LogStream::Binary : public LogStream::Reader {
 public:
  Binary(const LogOptions& options, Format format) : Reader(options) {
    if (format == Format::npy) {
      wait_for(12);  // longest prefix; a file that ends before it is told so
      refuse_packed();
      wait_for(npy_header_bytes(inlet_.name(), inlet_.bytes().substr(0, 12)));
    }
    layout_ = binary_layout(inlet_.name(), inlet_.bytes(), format, options.file_columns);
    inlet_.drop(layout_.offset);
    choose(choose_binary_columns(inlet_.name(), layout_, options));
    rate_hz_ = *options.rate_hz;
  }

 private:
  void wait_for(std::size_t bytes) {
    while (!inlet_.ended() && inlet_.bytes().size() < bytes) inlet_.fill(milliseconds{-1});
  }

  void take(std::vector<std::vector<double>>& columns) override {
    if (bytes_ == 0 && layout_.offset == 0) refuse_packed();
    const std::size_t rows = inlet_.bytes().size() / layout_.row_bytes();
    std::vector<std::span<double>> spans;
    for (auto& column : columns) {
      column.resize(rows);
      spans.emplace_back(column);
    }
    const std::size_t used = rows * layout_.row_bytes();
    decode(inlet_.bytes().substr(0, used), layout_, choice_, spans);
    inlet_.drop(used);
    bytes_ += used;
    const bool too_many = layout_.rows && bytes_ > static_cast<std::uint64_t>(*layout_.rows) * layout_.row_bytes();
    if (inlet_.ended() || too_many) {
      // Throws unless the length is as it should be.
      static_cast<void>(count_rows(inlet_.name(), layout_, bytes_ + inlet_.bytes().size()));
    }
  }

  BinaryLayout layout_;
  std::uint64_t bytes_ = 0;  ///< of rows
};

// --- Text -----------------------------------------------------------------------------------------------------------

class LogStream::Text : public LogStream::Reader {
 public:
  explicit Text(const LogOptions& options) : Reader(options) {
    wait_for_rows();
    if (inlet_.bytes().empty()) text::fail(inlet_.name(), "is empty, expected a log; check how it was written");
    refuse_packed();
    text::check_text(inlet_.name(), inlet_.bytes());
    if (inlet_.bytes().starts_with("\xef\xbb\xbf")) inlet_.drop(3);
    const Bytes head(inlet_.name(), whole_lines());
    layout_ = read_layout(head);
    notes_ = layout_.notes;
    choose(followed(choose_columns(inlet_.name(), layout_, options)));
    find_rate(head);
    layout_.sample.clear();  // they lie in the text
    layout_.preamble.clear();
    inlet_.drop(std::exchange(layout_.body, 0));
  }

 private:
  void wait_for_rows() {
    constexpr std::int64_t kRows = 100;
    const auto lines = [&] { return std::ranges::count(inlet_.bytes(), '\n'); };
    while (!inlet_.ended() && inlet_.bytes().size() < kBlock && lines() < kRows) {
      inlet_.fill(milliseconds{-1});
    }
  }

  [[nodiscard]] std::string_view whole_lines() const {
    const std::string_view bytes = inlet_.bytes();
    const std::string_view lines = inlet_.ended() ? bytes : bytes.substr(0, bytes.rfind('\n') + 1);
    if (lines.empty() && bytes.size() >= kBlock) fail_long_line(inlet_.name(), layout_.body_line + 1, bytes);
    return lines;
  }

  /// A counter that turns out to count something else could not be taken back: it is followed only where asked for.
  static Choice followed(Choice choice) {
    if (choice.count_ns == 0 || choice.time_asked) return choice;
    choice.notes.push_back(fmt::format("{} seems to count the samples: --time COLUMN=counter finds those that are lost",
                                       choice.time_name));
    choice.stamps.clear();
    return choice;
  }

  void find_rate(const Bytes& head) {
    if (choice_.stamps.empty()) {
      rate_hz_ = *options_.rate_hz;
      return;
    }
    const TableReader reader(head, layout_, options_.chunk_bytes);
    Table table = reader.read(choice_);
    if (auto note = unroll(table.stamps, choice_)) notes_.push_back(*std::move(note));
    if (choice_.count_ns > 0) {
      rate_hz_ = *options_.rate_hz;
      follow_clock(static_cast<double>(choice_.count_ns));
      return;
    }
    const auto stamps = std::ranges::count_if(table.stamps, [](std::int64_t t) { return t != text::kNoStamp; });
    if (stamps < 2)
      text::fail(inlet_.name(), fmt::format("holds {} row{} with a time, expected at least 2; record longer", stamps,
                                            stamps == 1 ? "" : "s"));
    const Grid grid =
        make_grid(table.stamps, options_.rate_hz,
                  {inlet_.name(), choice_.time_name, [&](std::size_t row) { return reader.line_of_row(row); }});
    rate_hz_ = options_.rate_hz.value_or(grid.rate_hz);
    follow_clock(noise::kNanosecondsPerSecond / rate_hz_);
    if (options_.rate_hz) return;
    notes_.push_back(fmt::format("rate {:.6g} Hz from the first {} time stamps of {}; --rate HZ is taken as it is",
                                 rate_hz_, table.stamps.size(), choice_.time_name));
  }

  void follow_clock(double interval_ns) {
    tracker_.emplace(interval_ns);
    unroller_.emplace(choice_.wraps, interval_ns);
  }

  void take(std::vector<std::vector<double>>& columns) override {
    if (!holds_back()) read_rows();
    if (tracker_) {
      hand_out(columns);
    } else {
      columns = std::move(table_.numbers);
      table_ = {};
    }
  }
  [[nodiscard]] bool holds_back() const override { return tracker_ && row_ < table_.rows; }

  void read_rows() {
    table_ = {};
    row_ = 0;
    const std::string_view lines = whole_lines();
    if (lines.empty()) {
      table_.numbers.resize(columns_.size());
      return;
    }
    const Bytes piece(inlet_.name(), lines);
    const TableReader reader(piece, layout_, options_.chunk_bytes);
    table_ = reader.read(choice_);
    if (tracker_) find_places(reader);
    layout_.body_line += std::ranges::count(lines, '\n');
    inlet_.drop(lines.size());
  }

  void find_places(const TableReader& reader) {
    places_.clear();
    for (std::size_t row = 0; row < table_.rows; ++row) {
      if (table_.stamps[row] == text::kNoStamp) {
        places_.push_back({.is_placed = false});
        continue;
      }
      places_.push_back(tracker_->next((*unroller_)(table_.stamps[row]), [&](const std::string& what) {
        text::fail_at(inlet_.name(), reader.line_of_row(row), 1,
                      fmt::format("the time {} {}, expected rising time; cut the log here", choice_.time_name, what));
      }));
    }
  }

  /// Rows and what is missing between them, until the columns have a block's worth: a gap may be longer than memory.
  void hand_out(std::vector<std::vector<double>>& columns) {
    const std::size_t most = std::max<std::size_t>(1, kBlock / sizeof(double) / columns.size());
    for (; row_ < table_.rows && columns.front().size() < most; ++row_) {
      Tracker::Place& place = places_[row_];
      if (!place.is_placed) continue;
      const auto filled = std::min(place.missing, static_cast<std::int64_t>(most - columns.front().size()));
      for (auto& column : columns) column.insert(column.end(), static_cast<std::size_t>(filled), kNone);
      place.missing -= filled;
      if (place.missing > 0) return;
      for (std::size_t i = 0; i < columns.size(); ++i) {
        if (!place.repeated) {
          columns[i].push_back(table_.numbers[i][row_]);
        } else if (!columns[i].empty()) {  // the row before may have been handed out already; then its number stands
          columns[i].back() = kNone;
        }
      }
    }
  }

  Layout layout_;
  Table table_;                         ///< rows that are read
  std::vector<Tracker::Place> places_;  ///< of each row
  std::size_t row_ = 0;                 ///< the first that is not handed out
  std::optional<Tracker> tracker_;
  std::optional<Unroller> unroller_;
};

// --- LogStream ------------------------------------------------------------------------------------------------------

LogStream::LogStream(const LogOptions& options) {
  const Format format = options.format.value_or(format_of(options.path));
  if (format == Format::csv) {
    reader_ = std::make_unique<Text>(options);
  } else {
    reader_ = std::make_unique<Binary>(options, format);
  }
}
LogStream::~LogStream() = default;

const std::string& LogStream::source() const { return reader_->inlet().name(); }
double LogStream::rate_hz() const { return reader_->rate_hz_; }
const std::vector<LogStream::Column>& LogStream::columns() const { return reader_->columns_; }
const std::vector<std::string>& LogStream::notes() const { return reader_->notes_; }
const std::vector<std::int64_t>& LogStream::numbers() const { return reader_->numbers_; }
std::int64_t LogStream::missing_samples() const { return reader_->missing_; }

LogStream::Progress LogStream::read(std::vector<std::vector<double>>& rates, milliseconds patience) {
  return reader_->read(rates, patience);
}

}  // namespace gyrobudget::inline v0::log

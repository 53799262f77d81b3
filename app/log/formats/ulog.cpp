// SPDX-License-Identifier: MIT
#include "ulog.h"

#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "number_type.h"
#include "rows.h"

namespace gyrobudget::inline v0::log::ulog {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kMagic = "\x55\x4c\x6f\x67\x01\x12\x35"sv;
constexpr std::size_t kHeader = 16, kMessageHead = 3;  // magic, version, time; size and type
constexpr std::string_view kSync = "\x08\x00\x53\x2f\x73\x13\x20\x25\x0c\xbb\x12"sv;
constexpr std::int64_t kMicrosecond = 1000;  // [ns]
constexpr std::size_t kNowhere = std::numeric_limits<std::size_t>::max();

// --- Messages -------------------------------------------------------------------------------------------------------

struct Message {
  char type = 0;
  std::string_view content;
  std::size_t at = 0;  ///< of its head in the file
};

/// What was passed over on the way through a file.
struct Losses {
  std::size_t damaged = 0;            ///< bytes
  std::size_t damaged_at = kNowhere;  ///< the first
  std::size_t cut_parts = 0;          ///< behind which more was appended
  std::size_t cut_at = kNowhere;      ///< where the last message starts, which is not whole
};

/// Goes through the messages of a file, and over what is damaged.
class Walk {
 public:
  /// @param parts  where appended data begin, in ascending order and within the file
  Walk(const Bytes& bytes, const std::vector<std::size_t>& parts) : bytes_(bytes), text_(bytes.text()), parts_(parts) {}

  bool next(Message& message) {
    for (;;) {
      const std::size_t end = part_ < parts_.size() ? parts_[part_] : text_.size();
      if (at_ < end && take(end, message)) return true;
      if (at_ < end) continue;
      if (part_ == parts_.size()) return false;
      at_ = parts_[part_++];
    }
  }
  [[nodiscard]] const Losses& losses() const { return losses_; }

 private:
  static bool is_type(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }

  /// @returns whether there is a message; otherwise it has moved on.
  bool take(std::size_t end, Message& message) {
    const std::size_t left = end - at_;
    if (left < kMessageHead) return lose(end, true);
    const std::size_t size = load<std::uint16_t>(text_, at_);
    const char type = text_[at_ + 2];
    if (!is_type(type) || size == 0) return lose(end, false);
    if (kMessageHead + size > left) return lose(end, true);
    message = {type, text_.substr(at_ + kMessageHead, size), at_};
    at_ += kMessageHead + size;
    release();
    return true;
  }

  /// Moves to the next mark that the log has for this, or to the end.
  bool lose(std::size_t end, bool may_be_cut) {
    const std::size_t found = text_.substr(0, end).find(kSync, at_ + 1);
    const bool is_damage = found != std::string_view::npos || !may_be_cut;
    const std::size_t to = std::min(found, end);
    if (is_damage) {
      if (losses_.damaged_at == kNowhere) losses_.damaged_at = at_;
      losses_.damaged += to - at_;
    } else if (part_ < parts_.size()) {
      ++losses_.cut_parts;
    } else {
      losses_.cut_at = at_;
    }
    at_ = to;
    return false;
  }

  void release() {
    constexpr std::size_t kPart = std::size_t{1} << 24;
    if (at_ - released_ < kPart) return;
    bytes_.release(text_.substr(released_, at_ - released_));
    released_ = at_;
  }

  const Bytes& bytes_;
  std::string_view text_;
  const std::vector<std::size_t>& parts_;
  std::size_t part_ = 0, at_ = kHeader, released_ = 0;
  Losses losses_;
};

// --- Formats --------------------------------------------------------------------------------------------------------

struct FormatField {
  std::string_view type, name;
  std::size_t count = 1;
  bool is_array = false;
};

/// "name:type field;type[n] field;..."
struct MessageFormat {
  std::string_view name;
  std::vector<FormatField> fields;
};

std::optional<FormatField> parse_field(std::string_view text) {
  const std::size_t blank = text.find(' ');
  if (blank == std::string_view::npos || blank == 0 || blank + 1 == text.size()) return std::nullopt;
  FormatField field{text.substr(0, blank), text.substr(blank + 1)};
  const std::size_t bracket = field.type.find('[');
  if (bracket == std::string_view::npos) return field;
  const std::string_view number = field.type.substr(bracket + 1);
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), field.count);
  if (error != std::errc() || std::string_view(end, number.data() + number.size()) != "]") return std::nullopt;
  field.type = field.type.substr(0, bracket);
  field.is_array = true;
  return field;
}

std::optional<MessageFormat> parse_format(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos || colon == 0) return std::nullopt;
  MessageFormat format{text.substr(0, colon), {}};
  text.remove_prefix(colon + 1);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(';'), text.size());
    if (end > 0) {
      const auto field = parse_field(text.substr(0, end));
      if (!field) return std::nullopt;
      format.fields.push_back(*field);
    }
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return format;
}

struct BasicType {
  std::string_view name;
  std::optional<NumberType> number;  ///< none: characters
  std::size_t size;
};
constexpr std::array<BasicType, 12> kBasicTypes{{{"int8_t", NumberType::i8, 1},
                                                 {"uint8_t", NumberType::u8, 1},
                                                 {"int16_t", NumberType::i16, 2},
                                                 {"uint16_t", NumberType::u16, 2},
                                                 {"int32_t", NumberType::i32, 4},
                                                 {"uint32_t", NumberType::u32, 4},
                                                 {"int64_t", NumberType::i64, 8},
                                                 {"uint64_t", NumberType::u64, 8},
                                                 {"float", NumberType::f32, 4},
                                                 {"double", NumberType::f64, 8},
                                                 {"bool", NumberType::u8, 1},
                                                 {"char", std::nullopt, 1}}};

/// A number of a message, what was nested taken apart.
struct Leaf {
  std::string name;  ///< "gyro_rad[1]"
  std::string base;  ///< "gyro_rad"
  NumberType type = NumberType::f32;
  std::size_t offset = 0;
  double scale = 1;
  std::string_view unit = {};
  bool in_burst = false;  ///< one of as many as there are samples: the offset is that of the first
};

struct Layout {
  std::vector<Leaf> leaves;
  std::size_t size = 0;    ///< of a message
  std::size_t needed = 0;  ///< without padding at its end, which may be left out
};

using MessageFormats = std::map<std::string_view, MessageFormat>;

/// Takes nested formats apart. What is written by strangers may nest without end.
class Flattening {
 public:
  explicit Flattening(const MessageFormats& formats) : formats_(formats) {}

  /// Nothing for a format that is not there, holds itself, or is larger than a message.
  std::optional<Layout> operator()(std::string_view name) {
    Layout layout;
    if (!add(name, "", 0, layout)) return std::nullopt;
    return layout;
  }

 private:
  static constexpr int kDeepest = 8;
  static constexpr std::size_t kLargest = 0xffff;  // bytes of a message, and steps on the way

  bool add(std::string_view name, const std::string& prefix, int depth, Layout& layout) {
    const auto format = formats_.find(name);
    if (format == formats_.end() || depth > kDeepest) return false;
    return std::ranges::all_of(format->second.fields,
                               [&](const FormatField& field) { return add(field, prefix, depth, layout); });
  }

  bool add(const FormatField& field, const std::string& prefix, int depth, Layout& layout) {
    const auto* basic = std::ranges::find(kBasicTypes, field.type, &BasicType::name);
    const bool is_basic = basic != kBasicTypes.end();
    const bool is_text = is_basic && !basic->number;
    const bool is_padding = field.name.starts_with("_padding");
    if (field.count > kLargest) return false;
    if (is_basic && (is_text || is_padding)) {
      layout.size += field.count * basic->size;
      if (!is_padding) layout.needed = layout.size;
      return layout.size <= kLargest;
    }
    const std::string base = prefix + clean_name(field.name);
    for (std::size_t i = 0; i < field.count; ++i) {
      const std::string name = field.is_array ? fmt::format("{}[{}]", base, i) : base;
      if (++steps_ > kLargest) return false;
      if (!is_basic) {
        if (!add(field.type, name + ".", depth + 1, layout)) return false;
        continue;
      }
      layout.leaves.push_back({name, base, *basic->number, layout.size});
      layout.size += basic->size;
      layout.needed = layout.size;
      if (layout.size > kLargest) return false;
    }
    return true;
  }

  const MessageFormats& formats_;
  std::size_t steps_ = 0;
};

// --- What topics mean -----------------------------------------------------------------------------------------------

/// The number of a field in SI, or in what people use, is raw * scale.
struct KnownUnit {
  std::string_view topic;  ///< empty for all
  std::string_view field;
  enum { any, whole, fraction } type;  ///< some changed both type and unit
  std::string_view unit;
  double scale = 1;
};

constexpr KnownUnit kUnits[] = {
    {"", "timestamp", KnownUnit::any, "us"},
    {"", "timestamp_sample", KnownUnit::any, "us"},
    {"sensor_combined", "gyro_rad", KnownUnit::any, "rad/s"},
    {"sensor_combined", "accelerometer_m_s2", KnownUnit::any, "m/s^2"},
    {"sensor_combined", "gyro_integral_dt", KnownUnit::whole, "us"},
    {"sensor_combined", "gyro_integral_dt", KnownUnit::fraction, "s"},  // in logs of 2017 and before
    {"sensor_combined", "accelerometer_integral_dt", KnownUnit::whole, "us"},
    {"sensor_combined", "accelerometer_integral_dt", KnownUnit::fraction, "s"},
    {"sensor_combined", "accelerometer_timestamp_relative", KnownUnit::whole, "us"},
    {"sensor_combined", "magnetometer_ga", KnownUnit::fraction, "T", 1e-4},
    {"vehicle_imu", "delta_angle", KnownUnit::fraction, "rad"},
    {"vehicle_imu", "delta_velocity", KnownUnit::fraction, "m/s"},
    {"vehicle_imu", "delta_angle_dt", KnownUnit::whole, "us"},
    {"vehicle_imu", "delta_velocity_dt", KnownUnit::whole, "us"},
    {"vehicle_angular_velocity", "xyz", KnownUnit::fraction, "rad/s"},
    {"vehicle_acceleration", "xyz", KnownUnit::fraction, "m/s^2"},
    {"sensor_gyro", "x", KnownUnit::fraction, "rad/s"},
    {"sensor_gyro", "y", KnownUnit::fraction, "rad/s"},
    {"sensor_gyro", "z", KnownUnit::fraction, "rad/s"},
    {"sensor_gyro", "temperature", KnownUnit::fraction, "degC"},
    {"sensor_accel", "x", KnownUnit::fraction, "m/s^2"},
    {"sensor_accel", "y", KnownUnit::fraction, "m/s^2"},
    {"sensor_accel", "z", KnownUnit::fraction, "m/s^2"},
    {"sensor_accel", "temperature", KnownUnit::fraction, "degC"},
    {"sensor_mag", "x", KnownUnit::fraction, "T", 1e-4},  // gauss
    {"sensor_mag", "y", KnownUnit::fraction, "T", 1e-4},
    {"sensor_mag", "z", KnownUnit::fraction, "T", 1e-4},
    {"sensor_mag", "temperature", KnownUnit::fraction, "degC"},
    {"vehicle_magnetometer", "magnetometer_ga", KnownUnit::fraction, "T", 1e-4},
    {"sensor_gyro_fifo", "dt", KnownUnit::fraction, "us"},
    {"sensor_accel_fifo", "dt", KnownUnit::fraction, "us"},
    {"sensor_gps", "lat", KnownUnit::whole, "deg", 1e-7},
    {"sensor_gps", "lon", KnownUnit::whole, "deg", 1e-7},
    {"sensor_gps", "alt", KnownUnit::whole, "m", 1e-3},
    {"sensor_gps", "alt_ellipsoid", KnownUnit::whole, "m", 1e-3},
    {"sensor_gps", "latitude_deg", KnownUnit::fraction, "deg"},
    {"sensor_gps", "longitude_deg", KnownUnit::fraction, "deg"},
    {"sensor_gps", "altitude_msl_m", KnownUnit::fraction, "m"},
    {"sensor_gps", "altitude_ellipsoid_m", KnownUnit::fraction, "m"},
    {"sensor_gps", "eph", KnownUnit::fraction, "m"},
    {"sensor_gps", "epv", KnownUnit::fraction, "m"},
    {"sensor_gps", "s_variance_m_s", KnownUnit::fraction, "m/s"},
    {"sensor_gps", "c_variance_rad", KnownUnit::fraction, "rad"},
    {"sensor_gps", "vel_m_s", KnownUnit::fraction, "m/s"},
    {"sensor_gps", "vel_n_m_s", KnownUnit::fraction, "m/s"},
    {"sensor_gps", "vel_e_m_s", KnownUnit::fraction, "m/s"},
    {"sensor_gps", "vel_d_m_s", KnownUnit::fraction, "m/s"},
    {"sensor_gps", "cog_rad", KnownUnit::fraction, "rad"},
    {"sensor_gps", "time_utc_usec", KnownUnit::whole, "us"},
};

struct KnownTopic {
  std::string_view name;
  StreamKind kind;
  bool is_sampled = false;  ///< rows that leave out samples deserve a word
};
/// Filtered topics, vehicle_angular_velocity, are of no kind: they are not what a sensor measures.
constexpr KnownTopic kTopics[] = {
    {"sensor_combined", StreamKind::imu, true},        {"vehicle_imu", StreamKind::imu, true},
    {"sensor_gyro", StreamKind::gyroscope, true},      {"sensor_gyro_fifo", StreamKind::gyroscope},
    {"sensor_accel", StreamKind::accelerometer, true}, {"sensor_accel_fifo", StreamKind::accelerometer},
    {"sensor_mag", StreamKind::magnetometer},          {"vehicle_magnetometer", StreamKind::magnetometer},
    {"vehicle_gps_position", StreamKind::gnss},        {"sensor_gps", StreamKind::gnss}};

const KnownTopic* known_topic(std::string_view name) {
  const auto* found = std::ranges::find(kTopics, name, &KnownTopic::name);
  return found == std::end(kTopics) ? nullptr : found;
}

void set_unit(std::string_view topic, Leaf& leaf) {
  const std::string_view canonical = topic == "vehicle_gps_position" ? "sensor_gps" : topic;
  for (const KnownUnit& known : kUnits) {
    if ((!known.topic.empty() && known.topic != canonical) || known.field != leaf.base) continue;
    if (known.type != KnownUnit::any && (known.type == KnownUnit::fraction) != is_floating(leaf.type)) continue;
    leaf.unit = known.unit;
    leaf.scale = known.scale;
    return;
  }
}

const Leaf* leaf_named(const Layout& layout, std::string_view name) {
  const auto found = std::ranges::find(layout.leaves, name, &Leaf::name);
  return found == layout.leaves.end() ? nullptr : &*found;
}

// --- Topics ---------------------------------------------------------------------------------------------------------

/// How rows of a topic are taken out of its messages.
struct Plan {
  Layout layout;
  std::optional<Leaf> clock, publication;
  std::optional<Leaf> samples, sample_dt, sample_scale;  ///< of bursts
  std::size_t burst = 0;                                 ///< samples that a message has room for; 0: no bursts
  std::optional<Leaf> accelerometer_age;                 ///< says whether sensor_combined has an accelerometer
  std::optional<Leaf> covered;                           ///< time that a row covers

  /// Rows that a message gives; none for one that is too short.
  [[nodiscard]] std::size_t rows(std::string_view content) const {
    if (content.size() < layout.needed) return 0;
    if (burst == 0) return 1;
    return static_cast<std::size_t>(
        std::min<std::uint64_t>(burst, to_unsigned(samples->type, content.data() + samples->offset)));
  }
};

std::optional<Leaf> copy(const Leaf* leaf) { return leaf ? std::optional(*leaf) : std::nullopt; }

/// Bursts: x[0] to x[31] become one field of as many rows as there are samples.
void fold_bursts(std::string_view topic, Plan& plan) {
  Layout& layout = plan.layout;
  plan.samples = copy(leaf_named(layout, "samples"));
  plan.sample_dt = copy(leaf_named(layout, "dt"));
  plan.sample_scale = copy(leaf_named(layout, "scale"));
  const auto count = [&](std::string_view base) { return std::ranges::count(layout.leaves, base, &Leaf::base); };
  const auto room = count("x");
  if (!plan.samples || !plan.sample_dt || !plan.sample_scale || room < 2 || count("y") != room || count("z") != room)
    return;
  plan.burst = static_cast<std::size_t>(room);
  std::erase_if(layout.leaves, [](const Leaf& leaf) {
    const bool axis = leaf.base == "x" || leaf.base == "y" || leaf.base == "z";
    return axis && leaf.name != leaf.base + "[0]";
  });
  for (Leaf& leaf : layout.leaves) {
    if (!leaf.name.ends_with("[0]") || leaf.base.size() != 1) continue;
    leaf.name = leaf.base;
    leaf.in_burst = true;
    leaf.unit = topic.starts_with("sensor_gyro") ? "rad/s" : "m/s^2";
  }
}

Plan make_plan(std::string_view topic, Layout layout) {
  Plan plan;
  for (Leaf& leaf : layout.leaves) set_unit(topic, leaf);
  plan.layout = std::move(layout);
  const auto stamp = [&](std::string_view name) {
    const Leaf* leaf = leaf_named(plan.layout, name);
    return leaf && leaf->type == NumberType::u64 ? copy(leaf) : std::nullopt;
  };
  plan.publication = stamp("timestamp");
  plan.clock = stamp("timestamp_sample");
  if (!plan.clock) plan.clock = plan.publication;
  if (topic == "sensor_gyro_fifo" || topic == "sensor_accel_fifo") fold_bursts(topic, plan);
  if (topic == "sensor_combined") {
    plan.accelerometer_age = copy(leaf_named(plan.layout, "accelerometer_timestamp_relative"));
    plan.covered = copy(leaf_named(plan.layout, "gyro_integral_dt"));
  }
  if (topic == "vehicle_imu") plan.covered = copy(leaf_named(plan.layout, "delta_angle_dt"));
  return plan;
}

struct Topic {
  std::string_view name;
  std::uint8_t instance = 0;
  std::optional<Plan> plan;
  bool is_known = true;              ///< false: its format is not there, or not understood
  std::vector<double> covered = {};  ///< what the first rows say that they cover
};

/// The time that each row covers; 0 where the topic does not say it.
double covered_s(const Topic& topic) {
  if (topic.covered.empty()) return 0;
  std::vector<double> values = topic.covered;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  constexpr double kMicro = 1e-6;
  return *middle * (topic.plan->covered->unit == "us" ? kMicro : 1);
}

/// Which topic a data message is of, as subscriptions come and go.
class Subscriptions {
 public:
  static constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

  explicit Subscriptions(std::vector<Topic>& topics) : topics_(&topics) {}
  explicit Subscriptions(const std::vector<Topic>& topics) : known_(&topics) {}

  void add(std::string_view content) {
    constexpr std::size_t kName = 3;
    if (content.size() <= kName) return;
    const auto instance = static_cast<std::uint8_t>(content[0]);
    std::string_view name = content.substr(kName);
    name = name.substr(0, name.find('\0'));
    of_id_[load<std::uint16_t>(content, 1)] = place(name, instance);
  }
  void remove(std::string_view content) {
    if (content.size() >= 2) of_id_[load<std::uint16_t>(content, 0)] = kNone;
  }
  /// kNone for an identifier that nothing told of.
  [[nodiscard]] std::size_t topic_of(std::string_view content) const {
    return content.size() < 2 ? kNone : of_id_[load<std::uint16_t>(content, 0)];
  }

 private:
  std::size_t place(std::string_view name, std::uint8_t instance) {
    constexpr std::size_t kMostTopics = std::size_t{1} << 14;  // a log has some hundreds
    const auto known = places_.find({name, instance});
    if (known != places_.end()) return known->second;
    const std::size_t next = places_.size();
    if (next == kMostTopics || (known_ && next == known_->size())) return kNone;
    places_.emplace(std::pair{name, instance}, next);
    if (topics_) topics_->push_back({name, instance, std::nullopt});
    return next;
  }

  std::vector<Topic>* topics_ = nullptr;
  const std::vector<Topic>* known_ = nullptr;
  std::vector<std::size_t> of_id_ = std::vector<std::size_t>(std::size_t{1} << 16, kNone);
  std::map<std::pair<std::string_view, std::uint8_t>, std::size_t> places_;
};

// --- The recording --------------------------------------------------------------------------------------------------

class Ulog : public Recording {
 public:
  explicit Ulog(std::shared_ptr<const Bytes> bytes) : bytes_(std::move(bytes)), text_(bytes_->text()) {
    read_header();
    scan();
    list_streams();
  }

  [[nodiscard]] std::string format() const override { return "PX4 ULog"; }
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  [[nodiscard]] const std::vector<std::string>& notes() const override { return notes_; }
  [[nodiscard]] Rows read(std::size_t stream, std::span<const std::size_t> fields) const override;

 private:
  void read_header();
  void read_flags(std::string_view content);
  void scan();
  void understand(Topic& topic);
  void count(Topic& topic, std::size_t id, std::string_view data);
  void note_scan(const Losses& losses, std::uint64_t strangers);
  void note_dropout(std::string_view content);
  void note_selection(const Topic& topic, std::string_view data);
  void list_streams();
  void append(const Plan& plan, std::span<const Leaf> leaves, const Leaf* clock, std::string_view data,
              Rows& rows) const;

  std::shared_ptr<const Bytes> bytes_;
  std::string_view text_;
  std::vector<std::size_t> parts_;
  MessageFormats formats_;
  std::vector<Topic> topics_;
  std::vector<std::int64_t> counts_;
  std::vector<std::uint64_t> short_;  ///< messages that are shorter than their format, of each topic
  std::vector<StreamInfo> streams_;
  std::vector<std::string> notes_;
  std::size_t fields_left_ = std::size_t{1} << 17;  ///< of all topics: formats of strangers may be large, topics many
  std::uint64_t dropouts_ = 0, dropped_ms_ = 0, longest_dropout_ms_ = 0;
  std::optional<double> selected_;  ///< device of the gyroscope that sensor_combined has
  std::uint64_t selections_ = 0;
};

void Ulog::read_header() {
  if (text_.size() < kHeader) {
    text::fail(bytes_->name(),
               fmt::format("ends after {} bytes, inside the {} bytes of the header of a ULog; copy it again",
                           text_.size(), kHeader));
  }
  const auto version = static_cast<unsigned char>(text_[kMagic.size()]);
  constexpr unsigned kNewest = 1;
  if (version > kNewest)
    notes_.push_back(fmt::format("the log says version {} of its format; it is read as version {}", version, kNewest));
  constexpr std::size_t kFlagBytes = 40;
  if (text_.size() < kHeader + kMessageHead + kFlagBytes || text_[kHeader + 2] != 'B') return;
  if (load<std::uint16_t>(text_, kHeader) >= kFlagBytes) read_flags(text_.substr(kHeader + kMessageHead, kFlagBytes));
}

void Ulog::read_flags(std::string_view content) {
  constexpr std::size_t kFlags = 8, kOffsets = 16, kParts = 3;
  const std::string_view incompatible = content.substr(kFlags, kFlags);
  const bool appended = (incompatible[0] & 1) != 0;
  const bool unknown =
      (incompatible[0] & ~1) != 0 || incompatible.substr(1).find_first_not_of('\0') != std::string_view::npos;
  if (unknown) {
    text::fail(
        bytes_->name(),
        "sets a flag of its format that forbids readers which do not know it; convert it with PX4's own ulog2csv");
  }
  if (!appended) return;
  for (std::size_t i = 0; i < kParts; ++i) {
    const auto at = load<std::uint64_t>(content, kOffsets + i * sizeof(std::uint64_t));
    if (at == 0) continue;
    if (at > kHeader && at < text_.size()) {
      parts_.push_back(at);
    } else {
      notes_.push_back(fmt::format("data appended at byte {} are not there: the file has {} bytes", at, text_.size()));
    }
  }
  std::ranges::sort(parts_);
}

void Ulog::scan() {
  Walk walk(*bytes_, parts_);
  Subscriptions subscriptions(topics_);
  std::uint64_t strangers = 0;
  Message message;
  while (walk.next(message)) {
    switch (message.type) {
      case 'F':
        if (const auto format = parse_format(message.content)) formats_.emplace(format->name, *format);
        break;
      case 'A':
        subscriptions.add(message.content);
        counts_.resize(topics_.size());
        short_.resize(topics_.size());
        break;
      case 'R':
        subscriptions.remove(message.content);
        break;
      case 'O':
        note_dropout(message.content);
        break;
      case 'D': {
        const std::size_t id = subscriptions.topic_of(message.content);
        if (id == Subscriptions::kNone) {
          ++strangers;
          break;
        }
        Topic& topic = topics_[id];
        understand(topic);
        count(topic, id, message.content.substr(2));
        break;
      }
      default:  // parameters, texts, and what later versions bring
        break;
    }
  }
  note_scan(walk.losses(), strangers);
}

/// Takes the format of a topic apart, once.
void Ulog::understand(Topic& topic) {
  if (topic.plan) return;
  auto layout = Flattening(formats_)(topic.name);
  if (layout && layout->leaves.size() > fields_left_) layout.reset();
  topic.is_known = layout.has_value();
  if (layout) fields_left_ -= layout->leaves.size();
  topic.plan = make_plan(topic.name, std::move(layout).value_or(Layout{}));
}

void Ulog::count(Topic& topic, std::size_t id, std::string_view data) {
  const Plan& plan = *topic.plan;
  if (data.size() < plan.layout.needed) {
    ++short_[id];
    return;
  }
  counts_[id] += static_cast<std::int64_t>(plan.rows(data));
  constexpr std::size_t kEnough = 256;
  if (plan.covered && topic.covered.size() < kEnough)
    topic.covered.push_back(to_double(plan.covered->type, data.data() + plan.covered->offset));
  if (topic.name == "sensor_selection") note_selection(topic, data);
}

void Ulog::note_dropout(std::string_view content) {
  if (content.size() < 2) return;
  const std::uint64_t duration = load<std::uint16_t>(content, 0);
  ++dropouts_;
  dropped_ms_ += duration;
  longest_dropout_ms_ = std::max(longest_dropout_ms_, duration);
}

void Ulog::note_selection(const Topic& topic, std::string_view data) {
  const Leaf* device = leaf_named(topic.plan->layout, "gyro_device_id");
  if (!device || data.size() < topic.plan->layout.needed) return;
  const double id = to_double(device->type, data.data() + device->offset);
  if (selected_ && *selected_ != id) ++selections_;
  selected_ = id;
}

void Ulog::note_scan(const Losses& losses, std::uint64_t strangers) {
  if (bytes_->cut())
    notes_.push_back(fmt::format("the {} data stop in the middle: the log ends after {} bytes",
                                 name(bytes_->compression()), text_.size()));
  if (losses.cut_at != kNowhere) {
    notes_.push_back(fmt::format("the file ends inside a message: {} from byte {} on left out",
                                 counted(text_.size() - losses.cut_at, "byte"), losses.cut_at));
  }
  if (losses.cut_parts > 0)
    notes_.push_back(fmt::format("{} cut where data were appended", counted(losses.cut_parts, "message")));
  if (losses.damaged > 0) {
    notes_.push_back(fmt::format("left out as damaged: {}, the first at byte {}", counted(losses.damaged, "byte"),
                                 losses.damaged_at));
  }
  if (dropouts_ > 0) {
    notes_.push_back(fmt::format("the recorder lost data {}, {} ms in all, {} ms at the longest",
                                 dropouts_ == 1 ? "once" : fmt::format("{} times", dropouts_), dropped_ms_,
                                 longest_dropout_ms_));
  }
  if (strangers > 0) notes_.push_back(fmt::format("{} of no known topic left out", counted(strangers, "message")));
  if (selections_ > 0) {
    notes_.push_back(fmt::format("the autopilot changed its gyroscope {}: sensor_combined holds more than one sensor",
                                 selections_ == 1 ? "once" : fmt::format("{} times", selections_)));
  }
}

void Ulog::list_streams() {
  std::map<std::string_view, int> instances;
  for (const Topic& topic : topics_) instances[topic.name] = std::max<int>(instances[topic.name], topic.instance);
  UniqueNames names;
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    Topic& topic = topics_[i];
    understand(topic);  // where it had no data
    StreamInfo info;
    const std::string shown = clean_name(topic.name);
    info.name = names.take(instances[topic.name] > 0 ? fmt::format("{}[{}]", shown, topic.instance) : shown);
    info.type = shown;
    if (const KnownTopic* known = known_topic(topic.name)) info.kind = known->kind;
    for (const Leaf& leaf : topic.plan->layout.leaves)
      info.fields.push_back({leaf.name, std::string(leaf.unit), leaf.unit.empty() ? "" : "the topic has it so"});
    info.count = counts_[i];
    if (topic.plan->clock) info.clock = topic.plan->clock->name;
    streams_.push_back(std::move(info));
    if (!topic.is_known)
      notes_.push_back(
          fmt::format("{}: its format is not there or not understood; it is not read", streams_.back().name));
  }
}

/// The stamp of a row in nanoseconds; nothing beyond the range of 64 bits.
std::optional<std::int64_t> stamp_of(const Leaf& clock, std::string_view data) {
  const auto us = load<std::uint64_t>(data, clock.offset);
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max() / kMicrosecond / 2);
  if (us > kMost) return std::nullopt;
  return static_cast<std::int64_t>(us) * kMicrosecond;
}

/// The rows of one message behind the others.
void Ulog::append(const Plan& plan, std::span<const Leaf> leaves, const Leaf* clock, std::string_view data,
                  Rows& rows) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInvalid = 0x7fffffff;
  const std::size_t count = plan.rows(data);
  if (count == 0) return;
  if (clock) {
    const auto stamp = stamp_of(*clock, data);
    if (!stamp) return;
    double step_ns =
        plan.burst > 0 ? to_double(plan.sample_dt->type, data.data() + plan.sample_dt->offset) * kMicrosecond : 0;
    constexpr double kLongestStep_ns = 1e9;
    if (!(step_ns >= 0 && step_ns < kLongestStep_ns)) step_ns = 0;
    for (std::size_t k = 0; k < count; ++k)
      rows.stamps_ns.push_back(*stamp -
                               static_cast<std::int64_t>(std::llround(static_cast<double>(count - 1 - k) * step_ns)));
  }
  const auto number = [&](const Leaf& leaf, std::size_t k) {
    return to_double(leaf.type, data.data() + leaf.offset + k * size_of(leaf.type)) * leaf.scale;
  };
  const bool has_accelerometer = !plan.accelerometer_age || number(*plan.accelerometer_age, 0) != kInvalid;
  const double burst_scale = plan.burst > 0 ? number(*plan.sample_scale, 0) : 1;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    const Leaf& leaf = leaves[i];
    const bool missing = !has_accelerometer && leaf.base.starts_with("accelerometer");
    for (std::size_t k = 0; k < count; ++k)
      rows.columns[i].push_back(missing ? kNone : leaf.in_burst ? number(leaf, k) * burst_scale : number(leaf, 0));
  }
}

Rows Ulog::read(std::size_t stream, std::span<const std::size_t> fields) const {
  check_request(streams_, stream, fields);
  const Plan& plan = *topics_[stream].plan;
  std::vector<Leaf> leaves;
  for (const std::size_t field : fields) leaves.push_back(plan.layout.leaves[field]);

  const auto go = [&](const Leaf* clock, std::span<const Leaf> wanted) {
    Rows rows;
    rows.columns.resize(wanted.size());
    const auto count = static_cast<std::size_t>(streams_[stream].count);
    for (auto& column : rows.columns) column.reserve(count);
    if (clock) rows.stamps_ns.reserve(count);
    Walk walk(*bytes_, parts_);
    Subscriptions subscriptions(std::as_const(topics_));
    Message message;
    while (walk.next(message)) {
      if (message.type == 'A') subscriptions.add(message.content);
      if (message.type == 'R') subscriptions.remove(message.content);
      if (message.type == 'D' && subscriptions.topic_of(message.content) == stream)
        append(plan, wanted, clock, message.content.substr(2), rows);
    }
    return rows;
  };

  const Leaf* clock = plan.clock ? &*plan.clock : nullptr;
  Rows rows = go(clock, leaves);
  rows.clock = streams_[stream].clock;
  if (clock && plan.publication && clock->name != plan.publication->name && is_constant(rows.stamps_ns)) {
    Rows published = go(&*plan.publication, {});
    if (published.stamps_ns.size() == rows.stamps_ns.size()) {
      rows.stamps_ns = std::move(published.stamps_ns);
      rows.clock = plan.publication->name;
      rows.notes.push_back(fmt::format("{} tells no time: {} stands in", clock->name, rows.clock));
    }
  }
  if (short_[stream] > 0)
    rows.notes.push_back(fmt::format("{} shorter than the format left out", counted(short_[stream], "message")));
  if (clock && rows.stamps_ns.size() < static_cast<std::size_t>(streams_[stream].count)) {
    rows.notes.push_back(
        fmt::format("{} with a time beyond reason left out",
                    counted(static_cast<std::uint64_t>(streams_[stream].count) - rows.stamps_ns.size(), "row")));
  }
  const KnownTopic* known = known_topic(topics_[stream].name);
  if (known && known->is_sampled) {
    note_decimation(rows, covered_s(topics_[stream]));
  }
  finish(rows, streams_[stream], fields);
  return rows;
}

}  // namespace
}  // namespace gyrobudget::inline v0::log::ulog

namespace gyrobudget::inline v0::log {

bool is_ulog(std::string_view head) { return head.starts_with(ulog::kMagic); }

std::unique_ptr<Recording> open_ulog(std::shared_ptr<const Bytes> bytes) {
  return std::make_unique<ulog::Ulog>(std::move(bytes));
}

}  // namespace gyrobudget::inline v0::log

// SPDX-License-Identifier: MIT
#include "trajectory_file.h"

#include "gyrobudget/app/log/bytes.h"
#include "gyrobudget/app/log/columns.h"
#include "gyrobudget/app/log/layout.h"
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/log/named_columns.h"
#include "gyrobudget/app/log/table.h"
#include "gyrobudget/app/text/number.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/units.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/sampled.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <vector>

#include "trajectory_spec.h"

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Quaterniond;

// --- Columns by name ---------------------------------------------------------------------------------------

constexpr std::size_t kNumbers = 1 + log::kPlaceColumns.size();  // before those of the attitude

constexpr const char* kExpected =
    "expected a header with time (s), latitude (deg), longitude (deg), height (m), and q_w, q_x, q_y, q_z or yaw (deg), pitch (deg), roll (deg)";

/// Times so far from 0 that a double of them would blur what a spline sees are read as whole nanoseconds.
bool is_far(const log::Layout& layout, const log::DataColumn& time) {
  constexpr double kFar = 1e6;  // s
  double first = 0;
  const bool read =
      text::parse_number(layout.sample.front()[time.index], layout.dialect.decimal_comma, first) == text::Cell::number;
  return read && std::abs(first * time.to_si) > kFar;
}

log::Choice choose(const log::Bytes& source, const log::Layout& layout) {
  const log::ColumnMap none;
  const log::NamedColumns columns(source.name(), layout, none, kExpected);
  log::Choice choice;
  choice.data.push_back(columns.get(log::kTimeColumn));
  if (is_far(layout, choice.data.front())) {
    log::add_stamps(choice, choice.data.front());
  }
  for (const log::Wanted& w : log::kPlaceColumns) choice.data.push_back(columns.get(w));
  if (columns.find(log::kQuaternionColumns.front())) {
    for (const log::Wanted& w : log::kQuaternionColumns) choice.data.push_back(columns.get(w));
  } else {
    for (const log::Wanted& w : log::kEulerColumns) choice.data.push_back(columns.get(w));
  }
  return choice;
}

// --- Rows --------------------------------------------------------------------------------------------------

/// The columns of a file as samples of a trajectory.
class Samples {
 public:
  Samples(const log::Bytes& source, const log::TableReader& reader, const log::Choice& choice)
      : source_(source), reader_(reader), choice_(choice), table_(reader.read(choice)) {}

  [[nodiscard]] earth::Trajectory trajectory() {
    check_complete();
    std::vector<earth::Geodetic> positions;
    std::vector<Quaterniond> attitudes;
    for (std::size_t row = 0; row < table_.rows; ++row) {
      positions.push_back(position(row));
      attitudes.push_back(attitude(row));
    }
    try {
      return earth::through_samples(times(), positions, attitudes);
    } catch (const std::invalid_argument& error) {
      text::fail(source_.name(), error.what());
    }
  }

 private:
  [[nodiscard]] double number(std::size_t column, std::size_t row) const { return table_.numbers[column][row]; }
  [[noreturn]] void fail_row(std::size_t row, const std::string& message) const {
    text::fail_at(source_.name(), reader_.line_of_row(row), 1, message);
  }

  void check_complete() const {
    for (std::size_t column = 0; column < choice_.data.size(); ++column) {
      for (std::size_t row = 0; row < table_.rows; ++row) {
        if (!std::isnan(number(column, row))) continue;
        fail_row(row, fmt::format("column {} has no number, expected one in every row; leave the row out",
                                  text::quoted(choice_.data[column].name)));
      }
    }
  }

  [[nodiscard]] std::vector<double> times() const {
    std::vector<double> result(table_.rows);
    for (std::size_t row = 0; row < table_.rows; ++row) {
      constexpr double kNanosecond = 1e-9;
      result[row] = table_.stamps.empty()
                        ? number(0, row)
                        : static_cast<double>(table_.stamps[row] - table_.stamps.front()) * kNanosecond;
      if (row > 0 && !(result[row] > result[row - 1])) {
        fail_row(row, "found a time that is not after the one before; expected times that ascend");
      }
    }
    return result;
  }

  [[nodiscard]] earth::Geodetic position(std::size_t row) const {
    const earth::Geodetic place{number(1, row), number(2, row), number(3, row)};
    if (std::abs(place.latitude) > 90 * earth::kDegree) {
      fail_row(row,
               fmt::format("found a latitude of {} deg, expected one from -90 to 90", place.latitude / earth::kDegree));
    }
    constexpr double kFarthest = 1e9;  // m: the Moon is nearer
    if (!(std::abs(place.height) <= kFarthest))
      fail_row(row,
               fmt::format("found a height of {} m, expected one within {} m of the ground", place.height, kFarthest));
    return place;
  }

  [[nodiscard]] Quaterniond attitude(std::size_t row) const {
    const auto at = [&](std::size_t i) { return number(kNumbers + i, row); };
    if (choice_.data.size() == kNumbers + log::kEulerColumns.size()) return earth::from_euler({at(0), at(1), at(2)});
    const Quaterniond q(at(0), at(1), at(2), at(3));
    constexpr double kTolerance = 0.01;
    if (!(std::abs(q.norm() - 1) <= kTolerance)) {
      fail_row(row,
               fmt::format("found a quaternion of length {:.6g}, expected 1 (w first: q_w,q_x,q_y,q_z)", q.norm()));
    }
    return q.normalized();
  }

  const log::Bytes& source_;
  const log::TableReader& reader_;
  const log::Choice& choice_;
  log::Table table_;
};

earth::Trajectory read_file(const std::string& path) {
  constexpr std::size_t kChunk = std::size_t{1} << 20;
  const log::Bytes source(path);
  const log::Layout layout = log::read_layout(source);
  const log::Choice choice = choose(source, layout);
  const log::TableReader reader(source, layout, kChunk);
  return Samples(source, reader, choice).trajectory();
}

// --- Writing -----------------------------------------------------------------------------------------------

log::LogHead truth_head(const TruthOptions& options) {
  log::LogHead head;
  head.rate_hz = options.rate_hz;
  head.comment = options.comment;
  head.columns = {{"latitude", "deg"},       {"longitude", "deg"},     {"height", "m"},
                  {"velocity_north", "m/s"}, {"velocity_east", "m/s"}, {"velocity_down", "m/s"}};
  const auto add = [&](const auto& wanted, const char* unit) {
    for (const log::Wanted& w : wanted) head.columns.push_back({std::string(w.name), unit});
  };
  if (options.attitude == AttitudeForm::quaternion) {
    add(log::kQuaternionColumns, "1");
  } else {
    add(log::kEulerColumns, "deg");
  }
  return head;
}

/// The numbers of one row, SI, in the order of truth_head.
std::vector<double> truth_row(const earth::TrajectoryPoint& point, AttitudeForm form) {
  const earth::Geodetic place = earth::to_geodetic(point.pose.p_eb_e);
  const Eigen::Matrix3d C_en = earth::C_e_ned(place.latitude, place.longitude);
  const Eigen::Vector3d v_eb_n = C_en.transpose() * point.pose.v_eb_e;
  Quaterniond q_nb = Quaterniond(C_en).conjugate() * point.pose.q_eb;
  if (q_nb.w() < 0) q_nb.coeffs() = -q_nb.coeffs();
  std::vector<double> row{place.latitude, place.longitude, place.height, v_eb_n.x(), v_eb_n.y(), v_eb_n.z()};
  if (form == AttitudeForm::quaternion) {
    row.insert(row.end(), {q_nb.w(), q_nb.x(), q_nb.y(), q_nb.z()});
  } else {
    const earth::Euler euler = earth::to_euler(q_nb);
    row.insert(row.end(), {euler.yaw, euler.pitch, euler.roll});
  }
  return row;
}

}  // namespace

earth::Trajectory read_trajectory(const std::string& name_or_path) {
  if (auto named = named_trajectory(name_or_path)) return *std::move(named);
  std::error_code unknown;
  if (name_or_path != "-" && !std::filesystem::exists(name_or_path, unknown)) {
    const auto words = trajectory_words();
    const std::string word = name_or_path.substr(0, name_or_path.find(':'));
    text::fail(name_or_path, fmt::format("found no such file, and no trajectory of that name{}; there are {}",
                                         text::suggestion(word, words), text::listing(words)));
  }
  return read_file(name_or_path);
}

std::uint64_t whole_intervals(double duration, double rate_hz) {
  constexpr double kRounding = 1e-9;  // of an interval
  return static_cast<std::uint64_t>(std::floor(duration * rate_hz + kRounding));
}

void write_trajectory(const std::string& path, const earth::Trajectory& trajectory, const TruthOptions& options) {
  const log::LogHead head = truth_head(options);
  const double duration = std::min(options.duration, trajectory.duration());
  std::uint64_t sample = 0;
  log::write_log(path, head, whole_intervals(duration, head.rate_hz) + 1,
                 [&](std::span<const std::span<double>> columns) {
                   for (std::size_t i = 0; i < columns.front().size(); ++i, ++sample) {
                     const double t = std::min(static_cast<double>(sample) / head.rate_hz, trajectory.duration());
                     const auto row = truth_row(trajectory.at(t), options.attitude);
                     for (std::size_t c = 0; c < columns.size(); ++c) columns[c][i] = row[c];
                   }
                 });
}

}  // namespace gyrobudget::inline v0::files

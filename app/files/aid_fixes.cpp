// SPDX-License-Identifier: MIT
// The fixes of a scene's aids, by the names of their columns.
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/ellipsoid.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>

#include "fix_columns.h"
#include "scene_columns.h"
#include "scene_logs.h"

namespace gyrobudget::inline v0::files {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using navigation::Aid;
using navigation::Fix;

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();
constexpr log::StreamUse kFixFile{[](const log::StreamInfo& s) { return s.kind == log::StreamKind::gnss; },
                                  "GNSS receiver", "topic:"};

std::string_view names_for(Aid::Kind kind) {
  switch (kind) {
    case Aid::Kind::position:
      return "latitude (deg), longitude (deg), height (m) and time (s)";
    case Aid::Kind::height:
      return "height (m) and time (s)";
    case Aid::Kind::velocity:
      return "velocity_north (m/s), velocity_east (m/s), velocity_down (m/s) or velocity_up, and time (s)";
    case Aid::Kind::attitude:
    case Aid::Kind::rest:  // has no file
      break;
  }
  return "heading (deg), pitch (deg), roll (deg) or q_w, q_x, q_y, q_z, and time (s)";
}

std::string expected_of(Aid::Kind kind) {
  return fmt::format(
      "expected a header with {}, or their columns in the scene, as in columns: {{latitude: lat_rad (rad)}}",
      names_for(kind));
}

/// "aids.gnss" of "gnss.position".
std::string device_of(const Aid& aid) { return "aids." + aid.name.substr(0, aid.name.rfind('.')); }

class FixReader {
 public:
  FixReader(const Aid& aid, const AidSource& source, bool is_optional, std::vector<std::string>& notes)
      : aid_(aid),
        source_(source),
        is_optional_(is_optional),
        notes_(notes),
        file_(source.path, source.topic, kFixFile),
        map_(columns::named(file_, source.columns)),
        expected_(expected_of(aid.kind)),
        columns_(file_.columns(map_, expected_)),
        stream_(file_.stream() ? columns::fix_stream(file_.stream()->type) : nullptr) {}

  AidFixes read() {
    choose();
    if (is_missing_) return {};
    log::add_stamps(choice_, columns_.get(log::kTimeColumn));
    std::vector<std::string> of_file;
    table_ = file_.read(choice_, of_file);
    file_.check_stamps(table_);
    join_accuracy();
    AidFixes result;
    for (row_ = 0; row_ < table_.rows; ++row_) take_row(result.fixes);
    say(of_file);
    if (source_.sigma_from_file && result.fixes.empty() && without_sigma_ > 0)
      text::fail(
          file_.name(),
          fmt::format(
              "{}: not one of {} fixes has a sigma above 0, expected them where the scene says \"sigma: file\"; give numbers in the scene",
              aid_.name, without_sigma_));
    result.time_scale = time_scale();
    return result;
  }

 private:
  // --- Which columns ---

  void need(const log::Wanted& wanted) {
    if (place_.contains(wanted.name)) return;
    if (is_optional_ && !columns_.find(wanted)) {
      is_missing_ = true;
      return;
    }
    place_.emplace(wanted.name, choice_.data.size());
    choice_.data.push_back(columns_.get(wanted));
  }
  void need(std::span<const log::Wanted> list) {
    for (const log::Wanted& wanted : list) need(wanted);
  }
  [[nodiscard]] bool has(const log::Wanted& wanted) const { return columns_.find(wanted).has_value(); }
  [[nodiscard]] bool uses(const log::Wanted& wanted) const { return place_.contains(wanted.name); }

  void choose() {
    switch (aid_.kind) {
      case Aid::Kind::position:
        choose_position();
        break;
      case Aid::Kind::height:
        choose_height();
        break;
      case Aid::Kind::velocity:
        choose_velocity();
        break;
      case Aid::Kind::attitude:
      case Aid::Kind::rest:  // has no file
        choose_attitude();
        break;
    }
    if (has(columns::kQuality) && (stream_ || !source_.quality.empty())) need(columns::kQuality);
    if (!source_.quality.empty() && !uses(columns::kQuality))
      text::fail(
          file_.name(),
          fmt::format(
              "{}: \"quality:\" asks for a column \"quality\" that is not there; name it, as in columns: {{quality: fix}}",
              device_of(aid_)));
    if (source_.sigma_from_file && !is_joined()) choose_sigma();
  }

  void choose_position() {
    if (has(columns::kEcef[0])) return need(columns::kEcef);
    if (has(columns::kBaseline[0])) {
      if (!has(columns::kBaseline[3]))
        text::fail(
            file_.name(),
            "has positions from a base and not where that is, expected a line \"% ref pos\" above them; let RTKLIB write it (out-outhead = on), or ask it for latitude, longitude and height (out-solformat = llh)");
      return need(columns::kBaseline);
    }
    need(std::span(log::kPlaceColumns).first<2>());
    choose_height();
  }

  // Heights are over the ellipsoid; others need the geoid's.
  void choose_height() {
    const log::Wanted& ellipsoidal = log::kPlaceColumns[2];
    if (source_.geoid_separation) return need(has(columns::kHeightOverGeoid) ? columns::kHeightOverGeoid : ellipsoidal);
    // What the format of a stream calls "alt" may be over the geoid.
    const bool is_ellipsoidal =
        stream_ ? map_.contains(std::string(ellipsoidal.name)) || file_.has(ellipsoidal.name) : has(ellipsoidal);
    if (is_ellipsoidal || !has(columns::kHeightOverGeoid)) return need(ellipsoidal);
    if (!has(columns::kGeoidHeight))
      text::fail(
          file_.name(),
          fmt::format(
              "{}: its heights are over the geoid (mean sea level), expected how high that lies over the ellipsoid there, as in geoid_separation: -16.9 m; a geoid model (EGM96, EGM2008) tells it",
              device_of(aid_)));
    need(columns::kHeightOverGeoid);
    need(columns::kGeoidHeight);
  }

  void choose_velocity() {
    if (has(columns::kEcefVelocity[0]) && !has(columns::kNorth)) {
      need(columns::kEcefVelocity);
      return need(columns::kEcef);  // where north, east and down are told
    }
    if (has(columns::kSpeed) && !has(columns::kNorth)) {
      need(columns::kSpeed);
      need(columns::kCourse);
      if (!has(columns::kUp) && !has(columns::kDown))
        text::fail(
            file_.name(),
            fmt::format(
                "{}: has speed and course and no vertical velocity, expected all three; leave \"velocity:\" out of the aid",
                device_of(aid_)));
    } else {
      need(columns::kNorth);
      need(columns::kEast);
    }
    need(has(columns::kUp) && !has(columns::kDown) ? columns::kUp : columns::kDown);
  }

  void choose_attitude() {
    if (has(log::kQuaternionColumns[0])) return need(log::kQuaternionColumns);
    need(has(columns::kYawCcw)        ? columns::kYawCcw
         : has(log::kEulerColumns[0]) ? log::kEulerColumns[0]
                                      : columns::kHeading);
    need(std::span(log::kEulerColumns).last<2>());
  }

  [[nodiscard]] const columns::SigmaColumns& sigma_columns() const {
    return aid_.kind == Aid::Kind::velocity ? columns::kVelocitySigma : columns::kPositionSigma;
  }

  // Those that may be of variances.
  void need_sigma(const log::Wanted& wanted) {
    const noise::Dimension& d = wanted.dimension;
    const noise::Dimension variance{static_cast<std::int8_t>(2 * d.angle), static_cast<std::int8_t>(2 * d.length),
                                    static_cast<std::int8_t>(2 * d.time)};
    place_.emplace(wanted.name, choice_.data.size());
    const auto [column, which] = columns_.get(wanted, {d, variance});
    choice_.data.push_back(column);
    if (which == 1) variances_.push_back(choice_.data.size() - 1);
  }

  void choose_sigma() {
    const columns::SigmaColumns& sigma = sigma_columns();
    const bool is_ecef = uses(columns::kEcef[0]);
    if (!has(sigma.all) && !has(is_ecef ? sigma.ecef[0] : sigma.local[2]))
      text::fail(
          file_.name(),
          fmt::format(
              "{0}: found sigma: file and no column with it; name it, as in columns: {{{1}: accuracy}} (or {1}_east, {1}_north, {1}_up), or give numbers in the scene",
              aid_.name, sigma.all.name));
    if (aid_.kind == Aid::Kind::height) return need_sigma(has(sigma.local[2]) ? sigma.local[2] : sigma.all);
    if (is_ecef && has(sigma.ecef[0])) {
      for (const log::Wanted& w : sigma.ecef) need_sigma(w);
    } else if (has(sigma.all)) {
      need_sigma(sigma.all);
    } else if (has(sigma.horizontal)) {
      need_sigma(sigma.horizontal);
      need_sigma(sigma.local[2]);
    } else {
      for (const log::Wanted& w : sigma.local) need_sigma(w);
    }
  }

  /// Whether the sigmas are in a message of their own.
  [[nodiscard]] bool is_joined() const {
    return stream_ && !stream_->accuracy.empty() && !has(columns::kPositionSigma.horizontal);
  }

  /// "GPA[0]" has the sigmas of "GPS[0]", at the same times.
  void join_accuracy() {
    if (!source_.sigma_from_file || !is_joined()) return;
    const std::string& name = file_.stream()->name;
    const std::string topic = std::string(stream_->accuracy) + name.substr(std::min(name.size(), stream_->type.size()));
    const log::NamedFile accuracy(source_.path, topic, kFixFile);
    log::ColumnMap map;
    for (const auto& [ours, theirs] : stream_->names)
      if (accuracy.has(theirs)) map.emplace(ours, theirs);
    const std::string expected = fmt::format("expected the errors of {}; give numbers in the scene", name);
    const log::NamedColumns names = accuracy.columns(map, expected);
    log::Choice choice;
    const columns::SigmaColumns& sigma = sigma_columns();
    std::vector<log::Wanted> wanted{sigma.all};
    if (aid_.kind != Aid::Kind::velocity) wanted = {sigma.horizontal, sigma.local[2]};
    for (const log::Wanted& w : wanted) choice.data.push_back(names.get(w));
    log::add_stamps(choice, names.get(log::kTimeColumn));
    std::vector<std::string> of_file;
    const log::Table found = accuracy.read(choice, of_file);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      place_.emplace(wanted[i].name, table_.numbers.size());
      auto& column = table_.numbers.emplace_back(table_.rows, kNoNumber);
      for (std::size_t row = 0, at = 0; row < table_.rows; ++row) {
        while (at < found.rows && found.stamps[at] < table_.stamps[row]) ++at;
        if (at < found.rows && found.stamps[at] == table_.stamps[row]) column[row] = found.numbers[i][at];
      }
    }
  }

  // --- Rows ---

  [[nodiscard]] double at(std::string_view name) const {
    const auto found = place_.find(name);
    return found == place_.end() ? kNoNumber : table_.numbers[found->second][row_];
  }
  [[nodiscard]] double at(const log::Wanted& wanted) const { return at(wanted.name); }
  [[nodiscard]] Vector3d three(std::span<const log::Wanted> list) const {
    return {at(list[0]), at(list[1]), at(list[2])};
  }
  /// One of a sigma, of a variance its root.
  [[nodiscard]] double sigma_at(const log::Wanted& wanted) const {
    const double value = at(wanted);
    const auto found = place_.find(wanted.name);
    const bool is_variance = found != place_.end() && std::ranges::find(variances_, found->second) != variances_.end();
    return is_variance ? std::sqrt(value) : value;
  }

  void take_row(std::vector<Fix>& fixes) {
    if (uses(columns::kQuality)) {
      const double quality = at(columns::kQuality);
      if (!is_accepted(quality)) {
        ++without_fix_;
        return;
      }
      ++by_quality_[quality];
    }
    Fix fix = this->fix();
    fix.stamp = table_.stamps[row_];
    if (!fix.value.allFinite() || !fix.q_nb.coeffs().allFinite()) {
      ++incomplete_;
      return;
    }
    if (source_.sigma_from_file) {
      fix.sigma = sigma(fix);
      if (!(fix.sigma->allFinite() && fix.sigma->minCoeff() > 0)) {
        ++without_sigma_;
        return;
      }
    }
    fixes.push_back(std::move(fix));
  }

  [[nodiscard]] bool is_accepted(double quality) const {
    if (!source_.quality.empty()) return std::ranges::find(source_.quality, quality) != source_.quality.end();
    return quality >= stream_->least_quality && quality <= stream_->most_quality;
  }

  [[nodiscard]] Fix fix() {
    Fix fix;
    switch (aid_.kind) {
      case Aid::Kind::position:
        fix.value = position();
        break;
      case Aid::Kind::height:
        fix.value = {height(), 0, 0};
        break;
      case Aid::Kind::velocity:
        fix.value = velocity();
        break;
      case Aid::Kind::attitude:
      case Aid::Kind::rest:  // has no file
        fix.q_nb = attitude();
        break;
    }
    return fix;
  }

  [[nodiscard]] Vector3d position() {
    if (uses(columns::kEcef[0])) return three(columns::kEcef);
    if (uses(columns::kBaseline[0])) {
      const earth::Geodetic base{at(columns::kBaseline[3]), at(columns::kBaseline[4]), at(columns::kBaseline[5])};
      const Matrix3d C_enu = earth::C_e_enu(base.latitude, base.longitude);
      return earth::to_ecef(base) + C_enu * three(columns::kBaseline);
    }
    const double latitude = at(log::kPlaceColumns[0]), longitude = at(log::kPlaceColumns[1]);
    if (std::abs(latitude) > 90 * earth::kDegree)
      file_.fail_row(row_, fmt::format("found a latitude of {} deg, expected -90 to 90", latitude / earth::kDegree));
    const double h = height();
    if (!std::isfinite(latitude) || !std::isfinite(longitude) || !std::isfinite(h))
      return Vector3d::Constant(kNoNumber);
    return earth::to_ecef({latitude, longitude, h});
  }

  /// Over the ellipsoid.
  [[nodiscard]] double height() {
    const bool over_geoid = uses(columns::kHeightOverGeoid);
    const double value = over_geoid ? at(columns::kHeightOverGeoid) : at(log::kPlaceColumns[2]);
    if (source_.geoid_separation) return value + *source_.geoid_separation;
    if (!over_geoid) return value;
    const double geoid = at(columns::kGeoidHeight);
    if (std::isfinite(geoid)) least_geoid_ = std::min(least_geoid_, geoid), most_geoid_ = std::max(most_geoid_, geoid);
    return value + geoid;
  }

  [[nodiscard]] Vector3d velocity() const {
    if (uses(columns::kEcefVelocity[0])) {
      const Vector3d p_eb_e = three(columns::kEcef);
      if (!p_eb_e.allFinite()) return p_eb_e;
      const earth::Geodetic here = earth::to_geodetic(p_eb_e);
      return earth::C_e_ned(here.latitude, here.longitude).transpose() * three(columns::kEcefVelocity);
    }
    const double down = uses(columns::kUp) ? -at(columns::kUp) : at(columns::kDown);
    if (!uses(columns::kSpeed)) return {at(columns::kNorth), at(columns::kEast), down};
    const double speed = at(columns::kSpeed), course = speed == 0 ? 0 : at(columns::kCourse);  // what stands has none
    return {speed * std::cos(course), speed * std::sin(course), down};
  }

  [[nodiscard]] Eigen::Quaterniond attitude() const {
    if (uses(log::kQuaternionColumns[0])) {
      const auto& c = log::kQuaternionColumns;
      const Eigen::Quaterniond q(at(c[0]), at(c[1]), at(c[2]), at(c[3]));
      constexpr double kTolerance = 0.01;
      if (q.coeffs().allFinite() && !(std::abs(q.norm() - 1) <= kTolerance))
        file_.fail_row(row_, fmt::format("found a quaternion of length {:.6g}, expected 1 (w first)", q.norm()));
      return q.normalized();
    }
    const double yaw = uses(columns::kYawCcw)    ? -at(columns::kYawCcw)
                       : uses(columns::kHeading) ? at(columns::kHeading)
                                                 : at(log::kEulerColumns[0]);
    return earth::from_euler({yaw, at(log::kEulerColumns[1]), at(log::kEulerColumns[2])});
  }

  /// East, north, up.
  [[nodiscard]] Vector3d sigma(const Fix& fix) const {
    const columns::SigmaColumns& names = sigma_columns();
    if (aid_.kind == Aid::Kind::height)
      return Vector3d::Constant(uses(names.local[2]) ? sigma_at(names.local[2]) : sigma_at(names.all));
    if (uses(names.all)) return Vector3d::Constant(sigma_at(names.all));
    if (uses(names.horizontal)) {
      const double horizontal = sigma_at(names.horizontal);
      return {horizontal, horizontal, sigma_at(names.local[2])};
    }
    if (!uses(names.ecef[0])) return {sigma_at(names.local[0]), sigma_at(names.local[1]), sigma_at(names.local[2])};
    const auto variance = [&](std::size_t i) { return at(names.ecef[i]) * std::abs(at(names.ecef[i])); };
    Matrix3d P;
    P << variance(0), variance(3), variance(5), variance(3), variance(1), variance(4), variance(5), variance(4),
        variance(2);
    const Vector3d p_eb_e = aid_.kind == Aid::Kind::velocity ? three(columns::kEcef) : fix.value;
    const earth::Geodetic here = earth::to_geodetic(p_eb_e);
    const Matrix3d C_enu = earth::C_e_enu(here.latitude, here.longitude);
    return (C_enu.transpose() * P * C_enu).diagonal().cwiseSqrt();
  }

  // --- What a person should know ---

  void say(const std::vector<std::string>& of_file) {
    for (const std::string& note : of_file) say_once(note);
    const auto passed_over = [&](std::size_t count, std::string_view why) {
      if (count > 0)
        notes_.push_back(fmt::format("{}: {} of {} rows {} and are passed over", aid_.name, count, table_.rows, why));
    };
    passed_over(incomplete_, "have a number missing");
    passed_over(without_fix_, source_.quality.empty() ? "say that nothing was measured (their quality)"
                                                      : "are not of the quality that the scene asks for");
    passed_over(without_sigma_, "have no sigma above 0");
    say_heights();
    if (aid_.kind != Aid::Kind::position || by_quality_.empty()) return;
    std::vector<std::string> counts;
    for (const auto& [quality, count] : by_quality_) counts.push_back(fmt::format("{} in {} rows", quality, count));
    notes_.push_back(fmt::format("{}: its quality is {}", aid_.name, text::listing(counts)));
  }

  void say_heights() {
    const std::string device = device_of(aid_);
    const bool has_height = uses(columns::kHeightOverGeoid) || uses(log::kPlaceColumns[2]);
    if (source_.geoid_separation && has_height)
      say_once(fmt::format("{}: heights are over the geoid, which lies {:.6g} m over the ellipsoid, as the scene says",
                           device, *source_.geoid_separation));
    if (least_geoid_ <= most_geoid_)
      say_once(fmt::format(
          "{}: heights are over the geoid, which lies {:.6g} to {:.6g} m over the ellipsoid, as the receiver says",
          device, least_geoid_, most_geoid_));
  }

  /// Position, velocity and height of one device are read from one file.
  void say_once(const std::string& note) {
    if (std::ranges::find(notes_, note) == notes_.end()) notes_.push_back(note);
  }

  [[nodiscard]] std::string time_scale() const {
    const log::StreamInfo* stream = file_.stream();
    if (!stream) return {};
    constexpr std::array<std::string_view, 3> kScales{"GPST", "UTC", "JST"};
    return std::ranges::find(kScales, stream->clock) == kScales.end() ? std::string() : stream->clock;
  }

  const Aid& aid_;
  const AidSource& source_;
  bool is_optional_;
  std::vector<std::string>& notes_;
  log::NamedFile file_;
  log::ColumnMap map_;
  std::string expected_;
  log::NamedColumns columns_;
  const columns::FixStream* stream_;
  log::Choice choice_;
  std::map<std::string_view, std::size_t> place_;  ///< of a column by our name, among the chosen
  std::vector<std::size_t> variances_;             ///< places of those
  bool is_missing_ = false;                        ///< a column of an optional aid
  log::Table table_;
  std::size_t row_ = 0;
  std::size_t incomplete_ = 0, without_fix_ = 0, without_sigma_ = 0;  ///< rows
  std::map<double, std::size_t> by_quality_;                          ///< rows
  double least_geoid_ = HUGE_VAL, most_geoid_ = -HUGE_VAL;
};

}  // namespace

const std::vector<std::string>& aid_column_names() {
  static const std::array kOthers{columns::kHeightOverGeoid,
                                  columns::kGeoidHeight,
                                  columns::kNorth,
                                  columns::kEast,
                                  columns::kDown,
                                  columns::kUp,
                                  columns::kSpeed,
                                  columns::kCourse,
                                  columns::kHeading,
                                  columns::kYawCcw,
                                  columns::kQuality,
                                  columns::kPositionSigma.horizontal,
                                  columns::kPositionSigma.all,
                                  columns::kVelocitySigma.horizontal,
                                  columns::kVelocitySigma.all};
  static const std::vector<std::string> names =
      column_names({log::kPlaceColumns, columns::kEcef, columns::kBaseline, kOthers, columns::kEcefVelocity,
                    log::kEulerColumns, log::kQuaternionColumns, columns::kPositionSigma.local,
                    columns::kPositionSigma.ecef, columns::kVelocitySigma.local, columns::kVelocitySigma.ecef});
  return names;
}

AidFixes read_fixes(const Aid& aid, const AidSource& source, bool is_optional, std::vector<std::string>& notes) {
  return FixReader(aid, source, is_optional, notes).read();
}

}  // namespace gyrobudget::inline v0::files

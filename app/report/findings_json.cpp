// SPDX-License-Identifier: MIT
#include "findings_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <utility>

#include "scale.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Json = nlohmann::ordered_json;

/// What the record holds beside noise: of each finding its kind, size, share of the samples and first time, whether it
/// is left out of the fit and whether it spoils the numbers, and what only its kind has. Lists of outliers stop at
/// kMostOutliers, `count` does not.
class FindingList {
 public:
  FindingList(const AxisResult& axis, double rate_hz)
      : found_(*axis.findings), scale_(axis.signal), rate_hz_(rate_of(axis, rate_hz)) {}

  Json list() {
    if (found_.held) repeated_rows();
    if (found_.rounding) rounding();
    for (const auto& end : found_.saturation) saturation(end);
    if (found_.turns) turns();
    if (!found_.outliers.empty()) outliers();
    for (const auto& m : found_.motion) motion(m);
    for (const auto& s : found_.steps) step(s);
    if (found_.departure) drift();
    for (const auto& h : found_.humps) hump(h);
    for (const auto& l : found_.lines) line(l);
    return std::move(list_);
  }

 private:
  struct Does {
    bool masked = false, spoils = false;
  };

  double at(std::int64_t index) const { return static_cast<double>(index) / rate_hz_; }
  double share(std::int64_t samples) const {
    return static_cast<double>(samples) / static_cast<double>(found_.samples);
  }
  Json& add(const char* kind, double si, Json share, Json at_s, Does does) {
    list_.push_back({{"kind", kind},
                     {"size", scale_(si)},
                     {"unit", scale_.unit()},
                     {"share", std::move(share)},
                     {"at_s", std::move(at_s)},
                     {"masked", does.masked},
                     {"spoils", does.spoils}});
    return list_.back();
  }

  void repeated_rows() {
    const auto& held = *found_.held;
    list_.push_back({{"kind", "repeated_rows"},
                     {"size", held.rows_each},
                     {"unit", "1"},
                     {"share", held.share()},
                     {"at_s", nullptr},
                     {"masked", true},
                     {"spoils", false},
                     {"own_rate_hz", held.rate_hz},
                     {"white_noise_raised", held.raised}});
  }
  void rounding() {
    const auto& r = *found_.rounding;
    Json& out = add("rounding", r.step, nullptr, nullptr, {false, r.is_above_noise()});
    out["distinct_values"] = r.distinct;
    out["scatter"] = scale_(r.scatter);
    out["above_noise"] = r.is_above_noise();
  }
  void saturation(const allan::Saturation& end) {
    Json& out = add("saturation", end.value, share(end.count), at(end.first), {false, found_.saturation_spoils()});
    out["count"] = end.count;
    out["longest_s"] = at(end.longest);
  }
  void turns() {
    Json& out = add("several_sensors", found_.turns->levels, nullptr, nullptr, {false, true});
    out["sensors"] = found_.turns->sensors;
    out["noise_ratio"] = found_.turns->noises;
  }
  void outliers() {
    constexpr std::size_t kMostOutliers = 1000;
    const auto& worst = *std::ranges::max_element(found_.outliers, {}, &allan::Outlier::sigmas);
    Json& out = add(found_.has_heavy_tail() ? "heavy_tail" : "outliers", worst.distance, found_.outlier_share(),
                    at(found_.outliers.front().index), {found_.outliers_masked, found_.outliers_spoil()});
    Json list = Json::array();
    for (std::size_t i = 0; i < std::min(found_.outliers.size(), kMostOutliers); ++i) {
      const auto& o = found_.outliers[i];
      list.push_back({{"at_s", at(o.index)}, {"distance", scale_(o.distance)}, {"sigmas", o.sigmas}});
    }
    out["count"] = found_.outliers.size();
    out["list"] = list;
    out["tail"] = nullptr;
    if (const auto& tail = found_.tail)
      out["tail"] = {{"share", tail->share},
                     {"sigmas", tail->sigmas},
                     {"limit_sigmas", tail->limit},
                     {"variance_left", tail->left},
                     {"variance_left_sigma", tail->left_sigma}};
  }
  void motion(const allan::Motion& m) {
    Json& out = add("motion", m.peak, share(m.count), at(m.first), {found_.motion_masked, found_.not_at_rest()});
    out["duration_s"] = at(m.count);
    out["turned"] = scale_(m.turned);
  }
  void step(const allan::Step& s) {
    Json& out = add("step", s.size, nullptr, at(s.index), {found_.steps_masked, found_.steps_spoil()});
    out["sigmas"] = s.sigmas;
  }
  void drift() {
    const auto& d = *found_.departure;
    const bool warm_up = d.kind == allan::Departure::Kind::warm_up;
    Json& out =
        add(warm_up ? "warm_up" : "trend", d.size, nullptr, 0.0, {found_.warm_up_masked, found_.departure_spoils()});
    if (warm_up) out["time_constant_s"] = d.time_constant_s;
    out["p_value"] = d.p_value;
  }
  void hump(const allan::Hump& h) {
    Json& out = add("hump", h.amplitude, nullptr, nullptr, {});
    out["frequency_hz"] = h.frequency_hz;
    out["low_hz"] = h.low_hz;
    out["high_hz"] = h.high_hz;
    out["ratio"] = h.ratio;
  }
  void line(const allan::SpectralLine& l) {
    Json& out = add("line", l.amplitude, nullptr, nullptr, {});
    out["frequency_hz"] = l.frequency_hz;
    out["ratio"] = l.ratio;
  }

  const calibration::Findings& found_;
  Scale scale_;
  double rate_hz_;
  Json list_ = Json::array();
};

}  // namespace

void add_findings(nlohmann::ordered_json& out, const AxisResult& axis, double rate_hz) {
  out["used"] = nullptr;
  out["findings"] = nullptr;
  if (!axis.findings) return;
  const double rate = rate_of(axis, rate_hz);
  out["used"] = {{"from_s", static_cast<double>(axis.findings->first) / rate},
                 {"to_s", static_cast<double>(axis.findings->first + axis.findings->samples) / rate}};
  out["findings"] = FindingList(axis, rate_hz).list();
}

}  // namespace gyrobudget::inline v0::report

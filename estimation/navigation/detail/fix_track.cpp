// SPDX-License-Identifier: MIT
#include "fix_track.h"

#include "gyrobudget/estimation/navigation/errors.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation::detail {
namespace {

using noise::kNanosecond;

Eigen::Matrix3d C_en(const Eigen::Vector3d& p_eb_e) {
  const earth::Geodetic at = earth::to_geodetic(p_eb_e);
  return earth::C_e_ned(at.latitude, at.longitude);
}

/// Between two fixes, of which the worse counts; what one of them does not tell is the aid's.
std::optional<Eigen::Vector3d> larger(const Fix& a, const Fix& b) {
  if (!a.sigma || !b.sigma) return std::nullopt;
  return a.sigma->cwiseMax(*b.sigma);
}

}  // namespace

FixTrack::FixTrack(const Aid& aid, const std::vector<Fix>& fixes, std::int64_t origin)
    : aid_(aid), fixes_(fixes), origin_(origin) {
  for (std::size_t i = 1; i < fixes.size(); ++i) {
    if (fixes[i].stamp <= fixes[i - 1].stamp)
      throw RecordingError(
          fmt::format("{}: fix {} is not after the one before, expected times that ascend", aid.name, i));
  }
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const auto& sigma = fixes[i].sigma;
    if (sigma && !(sigma->allFinite() && sigma->minCoeff() > 0))
      throw RecordingError(fmt::format("{}: fix {} has a sigma of {}, {}, {}, expected numbers above 0", aid.name, i,
                                       (*sigma)[0], (*sigma)[1], (*sigma)[2]));
  }
}

double FixTrack::time(std::size_t i) const {
  return static_cast<double>(fixes_[i].stamp - origin_) * kNanosecond + aid_.time_tag;
}

std::size_t FixTrack::first_from(double t) const {
  const auto before = [&](const Fix& fix) {
    return static_cast<double>(fix.stamp - origin_) * kNanosecond + aid_.time_tag < t;
  };
  return static_cast<std::size_t>(std::ranges::partition_point(fixes_, before) - fixes_.begin());
}

std::optional<Fix> FixTrack::at(double t) const {
  constexpr double kSame = 1e-8;  // s: rounded stamps
  const std::size_t next = first_from(t - kSame);
  if (next == size()) return std::nullopt;
  if (time(next) <= t + kSame) return fixes_[next];
  if (next == 0) return std::nullopt;
  const double part = (t - time(next - 1)) / (time(next) - time(next - 1));
  const Fix &a = fixes_[next - 1], &b = fixes_[next];
  return Fix{a.stamp, a.value + part * (b.value - a.value), a.q_nb.slerp(part, b.q_nb), larger(a, b)};
}

std::optional<Eigen::Vector3d> position_at(const FixTrack& positions, const FixTrack& velocities, double t) {
  const std::optional<Fix> straight = positions.at(t);
  const std::size_t next = positions.first_from(t);
  if (!straight || next == 0 || next == positions.size()) {
    return straight ? std::optional(straight->value) : std::nullopt;
  }
  const double from = positions.time(next - 1), to = positions.time(next), h = to - from;
  const auto v_from = velocities.at(from), v_to = velocities.at(to);
  if (!v_from || !v_to) return straight->value;
  const Eigen::Vector3d &a = positions.fix(next - 1).value, &b = positions.fix(next).value;
  const double s = (t - from) / h;
  // Hermite's basis.
  const double a1 = s * (1 - s) * (1 - s), b1 = -s * s * (1 - s), b0 = s * s * (3 - 2 * s);
  return Eigen::Vector3d(a + b0 * (b - a) + h * a1 * to_ecef_axes(v_from->value, a) +
                         h * b1 * to_ecef_axes(v_to->value, b));
}

Eigen::Vector3d to_ecef_axes(const Eigen::Vector3d& v_n, const Eigen::Vector3d& p_eb_e) { return C_en(p_eb_e) * v_n; }

Eigen::Quaterniond to_ecef_axes(const Eigen::Quaterniond& q_nb, const Eigen::Vector3d& p_eb_e) {
  return (Eigen::Quaterniond(C_en(p_eb_e)) * q_nb).normalized();
}

}  // namespace gyrobudget::inline v0::navigation::detail

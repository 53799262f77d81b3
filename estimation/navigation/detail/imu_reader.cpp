// SPDX-License-Identifier: MIT
#include "imu_reader.h"

#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include "events.h"

namespace gyrobudget::inline v0::navigation::detail {

ImuReader::ImuReader(const ImuLog& log, std::int64_t origin, double from) : log_(log), origin_(origin), now_(from) {
  while (next_ < log_.increments.size() && stamp(next_ + 1) <= from + kSame) ++next_;
}

double ImuReader::stamp(std::size_t k) const {
  return static_cast<double>(log_.stamps[k] - origin_) * noise::kNanosecond;
}

bool ImuReader::before(double to) const { return now_ < to - kSame && next_ < log_.increments.size(); }

ImuReader::Piece ImuReader::next(double to) {
  const double end = stamp(next_ + 1);
  const bool whole = end <= to + kSame;
  const double until = whole ? end : to;
  const Piece piece{.increment = part(next_, now_, until), .dt = until - now_, .interval = next_};
  now_ = until;
  if (whole) ++next_;
  return piece;
}

// The part of an interval's increments from one time to another: all of it, or by a straight rate through the means of
// the neighbours that keeps the interval's own.
noise::ImuIncrement ImuReader::part(std::size_t k, double from, double to) const {
  const double begin = stamp(k), end = stamp(k + 1);
  if (from <= begin + kSame && to >= end - kSame) return log_.increments[k];
  const auto rates = [&](std::size_t i) {
    const double dt = stamp(i + 1) - stamp(i);
    return earth::Sensed{.f_ib_b = earth::vector(log_.increments[i].velocity) / dt,
                         .w_ib_b = earth::vector(log_.increments[i].angle) / dt};
  };
  const auto middle = [&](std::size_t i) { return (stamp(i) + stamp(i + 1)) / 2; };
  auto [f, w] = rates(k);
  const double away = (from + to) / 2 - middle(k);
  if (k > 0 && k + 1 < log_.increments.size()) {
    const auto [f_before, w_before] = rates(k - 1);
    const auto [f_after, w_after] = rates(k + 1);
    const double between = middle(k + 1) - middle(k - 1);
    f += away * (f_after - f_before) / between;
    w += away * (w_after - w_before) / between;
  }
  return {.angle = earth::array(w * (to - from)), .velocity = earth::array(f * (to - from))};
}

}  // namespace gyrobudget::inline v0::navigation::detail

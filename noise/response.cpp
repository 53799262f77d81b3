// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/detail/response.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::noise::detail {

LowPass::LowPass(FrontEnd::Kind kind, double bandwidth, double dt) : kind_(kind) {
  (void)name(kind);  // refuses what is none
  if (!(bandwidth > 0 && std::isfinite(bandwidth))) {
    throw std::invalid_argument(fmt::format("bandwidth is {}; it must be positive and finite (Hz)", bandwidth));
  }
  if (kind == FrontEnd::Kind::moving_average) {
    average_.emplace(std::max(1., kMovingAverageWidth / (bandwidth * dt)));
    return;
  }
  const double w = 2 * std::numbers::pi * bandwidth * dt;
  a_ = kind == FrontEnd::Kind::first_order ? w : w / std::numbers::sqrt2;
  decay_ = std::exp(-a_);
  const bool dead = decay_ == 0;  // whatever the angle, which may be beyond what cos takes
  cosine_ = dead ? 0 : decay_ * std::cos(a_);
  sine_ = dead ? 0 : decay_ * std::sin(a_);
  mean_ = a_ > 0 ? -std::expm1(-a_) / a_ : 1;
}

double LowPass::next(double increment) {
  if (average_) return average_->next(increment);
  if (!started_) value_ = increment;
  started_ = true;
  return kind_ == FrontEnd::Kind::first_order ? next_first_order(increment) : next_second_order(increment);
}

double LowPass::next_first_order(double u) {
  const double error = value_ - u;
  value_ = u + decay_ * error;
  return u + mean_ * error;
}

// With e = x - u, s = w/sqrt(2) and v = e'/s:  e(t) = exp(-s t) (e cos st + (v + e) sin st), v(t) = exp(-s t)
// (v cos st - (v + 2 e) sin st), and from the equation itself the integral of e is -(dv + 2 de)/(2 s).
double LowPass::next_second_order(double u) {
  const double e = value_ - u;
  const double e_end = cosine_ * e + sine_ * (speed_ + e);
  const double v_end = cosine_ * speed_ - sine_ * (speed_ + 2 * e);
  const double area = a_ > 0 ? -((v_end - speed_) + 2 * (e_end - e)) / (2 * a_) : e;
  value_ = u + e_end;
  speed_ = v_end;
  return u + area;
}

Delay::Delay(double delay, double dt) {
  constexpr double kMost = 1e7;
  const double samples = delay / dt;
  if (!(samples >= 0 && samples <= kMost)) {
    throw std::invalid_argument(fmt::format("delay is {} s; it must be from 0 to 1e7 samples of {} s", delay, dt));
  }
  const double whole = std::floor(samples);
  fraction_ = samples - whole;
  past_.resize(static_cast<std::size_t>(whole) + 2);
}

double Delay::next(double increment) {
  if (!started_) std::ranges::fill(past_, increment);
  started_ = true;
  past_[at_] = increment;
  at_ = at_ + 1 == past_.size() ? 0 : at_ + 1;  // now the oldest: one sample older than the delay's whole part
  const double older = past_[at_], younger = past_[at_ + 1 == past_.size() ? 0 : at_ + 1];
  return younger + fraction_ * (older - younger);
}

}  // namespace gyrobudget::inline v0::noise::detail

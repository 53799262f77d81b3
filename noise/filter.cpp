// SPDX-License-Identifier: MIT
#include "filter.h"

#include "gyrobudget/noise/detail/check.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <span>
#include <stdexcept>

#include "fft.h"

namespace gyrobudget::inline v0::noise {

using detail::require;
using detail::require_interval;

namespace {

constexpr double square(double x) { return x * x; }

void require_coefficients(const std::vector<double>& c, const char* what) {
  if (c.empty()) throw std::invalid_argument(fmt::format("the {} of a filter has no coefficients", what));
  for (const double value : c) require(std::isfinite(value), "a filter coefficient", value, "finite");
}

/// c_0 + c_1 z^-1 + ... by Horner's rule.
std::complex<double> polynomial(std::span<const double> c, std::complex<double> inverse_z) {
  const double x = inverse_z.real(), y = inverse_z.imag();
  double re = 0, im = 0;
  for (std::size_t j = c.size(); j-- > 0;) {
    const double next = re * x - im * y + c[j];
    im = re * y + im * x;
    re = next;
  }
  return {re, im};
}

std::vector<std::complex<double>> transform(std::span<const double> c, std::size_t points) {
  std::vector<double> padded(points);
  std::ranges::copy(c, padded.begin());
  return real_spectrum(padded);
}

/// True where a(z) has all its zeros within the unit circle: its phase then returns to zero from frequency 0 to 1/2
/// (argument principle).
bool is_stable(std::span<const std::complex<double>> denominator) {
  double turn = 0;
  for (std::size_t k = 1; k < denominator.size(); ++k) {
    turn += std::arg(denominator[k] * std::conj(denominator[k - 1]));
  }
  const bool on_circle = std::ranges::any_of(denominator, [](auto a) { return std::abs(a) == 0; });
  return !on_circle && std::abs(turn) < std::numbers::pi / 2;
}

/// Impulse response of b/a folded to `points` samples; empty where the filter is not stable.
std::vector<double> folded_response(const FilteredNoise& noise, std::size_t points) {
  const auto feedback = transform(noise.denominator, points);
  if (!is_stable(feedback)) return {};
  auto response = transform(noise.numerator, points);
  for (std::size_t k = 0; k < response.size(); ++k) response[k] /= feedback[k] * static_cast<double>(points);
  return real_signal(response);
}

/// Length without what has died away.
std::size_t living_length(std::span<const double> response) {
  constexpr double kDead = 1e-11;
  double peak = 0;
  for (const double h : response) peak = std::max(peak, std::abs(h));
  std::size_t length = response.size();
  while (length > 0 && !(std::abs(response[length - 1]) > kDead * peak)) --length;
  return length;
}

std::vector<double> impulse_response(const FilteredNoise& noise) {
  constexpr std::size_t kFewest = 4096, kMost = std::size_t{1} << 24;
  constexpr std::size_t kPerTap = 32;  // the autoregression of 1/f lives 24 times as long as it has taps
  const std::size_t taps = std::max(noise.numerator.size(), noise.denominator.size());
  if (noise.denominator.size() == 1) {
    std::vector<double> response = noise.numerator;
    for (double& h : response) h /= noise.denominator[0];
    return response;
  }
  // A response that reaches the end of its transform is not whole.
  const auto wanted = static_cast<std::int64_t>(std::clamp(kPerTap * taps, kFewest, kMost));
  for (auto points = static_cast<std::size_t>(4 * fft_length(wanted / 4));; points = std::min(4 * points, kMost)) {
    auto response = folded_response(noise, points);
    if (response.empty()) throw std::invalid_argument(fmt::format("a filter of {} coefficients is not stable", taps));
    const std::size_t length = living_length(response);
    if (length <= points / 4 * 3) {
      response.resize(length);
      return response;
    }
    if (points >= kMost) break;
  }
  throw std::invalid_argument(fmt::format(
      "a filter of {} coefficients remembers more than {} samples; so slow a noise is a GaussMarkov, one without end of memory a RateRandomWalk",
      taps, kMost / 4 * 3));
}

}  // namespace

void require_valid(const FilteredNoise& noise) {
  require(std::isfinite(noise.sigma), "driving standard deviation", noise.sigma, "finite");
  require_coefficients(noise.numerator, "numerator");
  require_coefficients(noise.denominator, "denominator");
  require(noise.denominator[0] != 0, "first coefficient of the denominator", 0, "not zero");
}

std::vector<double> fractional_difference(double power, std::int64_t taps) {
  constexpr std::int64_t kMost = 10'000'000;
  require(taps >= 0 && taps <= kMost, "filter taps", static_cast<double>(taps), "from 0 to 1e7");
  require(std::abs(power) <= 2, "power of the difference", power, "from -2 to 2");
  std::vector<double> c(static_cast<std::size_t>(taps) + 1, 1);
  for (std::size_t j = 1; j < c.size(); ++j) {
    const auto J = static_cast<double>(j);
    c[j] = c[j - 1] * (J - 1 - power) / J;
  }
  return c;
}

FilteredNoise autoregressive_flicker(double b, std::int64_t taps) {
  require(taps >= 1, "taps of an autoregression", static_cast<double>(taps), "at least 1");
  return {b, {1}, fractional_difference(0.5, taps)};
}

FilteredNoise moving_average_flicker(double b, std::int64_t taps) {
  require(taps >= 1, "taps of a moving average", static_cast<double>(taps), "at least 1");
  return {b, fractional_difference(-0.5, taps - 1), {1}};
}

double psd(const FilteredNoise& noise, double frequency_hz, double dt) {
  require_valid(noise);
  constexpr double kNyquist = 0.5 * (1 + 4 * std::numeric_limits<double>::epsilon());  // f dt may round up
  require_interval(dt);
  require(frequency_hz > 0 && frequency_hz * dt <= kNyquist, "frequency", frequency_hz, "in (0, 1/(2 dt)] (Hz)");
  const auto inverse_z = std::polar(1.0, -2 * std::numbers::pi * frequency_hz * dt);
  const double gain = std::abs(polynomial(noise.numerator, inverse_z) / polynomial(noise.denominator, inverse_z));
  return square(noise.sigma * gain) * dt;
}

FilterMoments::FilterMoments(const FilteredNoise& noise) : sigma_(noise.sigma) {
  require_valid(noise);
  steps_ = impulse_response(noise);
  double sum = 0;
  for (double& h : steps_) h = sum += h;
}

std::int64_t FilterMoments::response_length() const { return std::ssize(steps_); }

double FilterMoments::step_response(std::int64_t j) const {
  if (j < 0 || steps_.empty()) return 0;
  return steps_[static_cast<std::size_t>(std::min(j, response_length() - 1))];
}

/// sum_j weight(j) g_j^2 over 0 <= j < end, the weight being constant below 2m.
template <typename Weight>
double FilterMoments::weighted_sum(std::int64_t m, std::int64_t end, Weight weight) const {
  const auto sum_over = [&](std::int64_t first, std::int64_t last) {
    double sum = 0;
    for (std::int64_t j = first; j < std::min(last, end); ++j) {
      sum += weight(j) * square(step_response(j) - 2 * step_response(j - m) + step_response(j - 2 * m));
    }
    return sum;
  };
  const std::int64_t length = response_length();
  if (m <= length) return sum_over(0, 2 * m + length);
  // Between the responses g is flat: +-H at its end.
  const double flat = 2 * static_cast<double>(m - length) * square(step_response(length)) * weight(0);
  return sum_over(0, length) + sum_over(m, m + length) + sum_over(2 * m, 2 * m + length) + flat;
}

double FilterMoments::allan_variance(std::int64_t m) const {
  require(m >= 1, "averaging factor m", static_cast<double>(m), "at least 1 (samples)");
  const double sum = weighted_sum(m, std::numeric_limits<std::int64_t>::max(), [](std::int64_t) { return 1.; });
  return square(sigma_ / static_cast<double>(m)) * sum / 2;
}

double FilterMoments::allan_variance(std::int64_t m, std::int64_t samples) const {
  require(m >= 1 && m <= samples / 2, "averaging factor m", static_cast<double>(m),
          "from 1 to half the record (samples)");
  const double terms = static_cast<double>(samples - 2 * m + 1);
  const double sum = weighted_sum(
      m, samples, [=](std::int64_t j) { return static_cast<double>(samples - std::max(j, 2 * m - 1)) / terms; });
  return square(sigma_ / static_cast<double>(m)) * sum / 2;
}

double FilterMoments::variance() const {
  double sum = 0;
  for (std::int64_t j = 0; j < response_length(); ++j) sum += square(step_response(j) - step_response(j - 1));
  return square(sigma_) * sum;
}

}  // namespace gyrobudget::inline v0::noise

// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/lines.h"

#include "gyrobudget/noise/fft.h"

#include <algorithm>
#include <bit>
#include <boost/math/special_functions/gamma.hpp>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kFewestSamples = 1024;
constexpr std::size_t kLongestSegment = std::size_t{1} << 20;
constexpr std::size_t kFirstBin = 50;
constexpr std::size_t kLeastNeighbours = 30;
constexpr double kNeighbourhood = 0.05;
constexpr double kIndependentShare = 0.947;    // of half-overlapping Hann segments

struct Spectrum {
  std::vector<double> power;   // one-sided density, bins 0 .. L/2
  std::size_t length = 0;      // L
  double averages = 1;         // independent segments
};

double mean_of(std::span<const double> rate) {
  double sum = 0;
  std::size_t count = 0;
  for (const double y : rate) {
    if (std::isfinite(y)) sum += y, ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

Spectrum welch(std::span<const double> rate, std::size_t length, double mean, double dt) {
  Spectrum spectrum{std::vector<double>(length / 2 + 1), length, 0};
  std::vector<double> window(length);
  double energy = 0;
  for (std::size_t i = 0; i < length; ++i) {
    const double s = std::sin(std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(length));
    window[i] = s * s;
    energy += window[i] * window[i];
  }
  std::vector<double> segment(length);
  std::size_t segments = 0;
  for (std::size_t start = 0; start + length <= rate.size(); start += length / 2, ++segments) {
    for (std::size_t i = 0; i < length; ++i) {
      const double y = rate[start + i];
      segment[i] = std::isfinite(y) ? window[i] * (y - mean) : 0;
    }
    const auto bins = noise::real_spectrum(segment);
    for (std::size_t k = 0; k < spectrum.power.size(); ++k) spectrum.power[k] += std::norm(bins[k]);
  }
  for (double& p : spectrum.power) p *= 2 * dt / (energy * static_cast<double>(segments));
  spectrum.averages = std::max(1.0, kIndependentShare * static_cast<double>(segments));
  return spectrum;
}

double local_median(const Spectrum& spectrum, std::size_t k, std::vector<double>& scratch) {
  const auto half = std::max(kLeastNeighbours, static_cast<std::size_t>(kNeighbourhood * static_cast<double>(k)));
  const std::size_t low = k > half ? k - half : 1, high = std::min(k + half, spectrum.power.size() - 2);
  scratch.assign(spectrum.power.begin() + static_cast<std::ptrdiff_t>(low),
                 spectrum.power.begin() + static_cast<std::ptrdiff_t>(high) + 1);
  const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
  std::nth_element(scratch.begin(), middle, scratch.end());
  return *middle;
}

// Power of the whole peak above its surroundings: the bins around it that exceed twice the median.
double excess(const Spectrum& spectrum, std::size_t k, double median) {
  double sum = spectrum.power[k] - median;
  for (std::size_t j = k + 1; j < spectrum.power.size() && spectrum.power[j] > 2 * median; ++j) sum += spectrum.power[j] - median;
  for (std::size_t j = k - 1; j > 0 && spectrum.power[j] > 2 * median; --j) sum += spectrum.power[j] - median;
  return sum;
}

void add_lines(std::vector<SpectralLine>& lines, const Spectrum& spectrum, double dt, double false_alarm) {
  const std::size_t bins = spectrum.power.size();
  if (bins <= 2 * kFirstBin) return;
  // A bin's average over its mean is gamma distributed with `averages` degrees (pairs); the median stands for the mean.
  const double a = spectrum.averages;
  const double cut = boost::math::gamma_q_inv(a, false_alarm / static_cast<double>(bins)) / a;
  const double median_over_mean = boost::math::gamma_q_inv(a, 0.5) / a;
  const double width = 1 / (static_cast<double>(spectrum.length) * dt);
  std::vector<double> scratch;
  for (std::size_t k = kFirstBin; k + 1 < bins; ++k) {
    const double p = spectrum.power[k];
    if (p < spectrum.power[k - 1] || p <= spectrum.power[k + 1]) continue;  // peaks only
    const double median = local_median(spectrum, k, scratch);
    if (!(p * median_over_mean > cut * median)) continue;
    lines.push_back({.frequency_hz = static_cast<double>(k) * width,
                     .resolution_hz = width,
                     .amplitude = std::sqrt(2 * width * excess(spectrum, k, median)),
                     .ratio = p / median});
  }
}

// The same line seen at another segment length, or its window's side: the strongest view stays.
bool same_line(const SpectralLine& a, const SpectralLine& b) {
  return std::abs(a.frequency_hz - b.frequency_hz) <=
         std::max({4 * a.resolution_hz, 4 * b.resolution_hz, 0.01 * a.frequency_hz});
}

}  // namespace

std::vector<SpectralLine> find_lines(std::span<const double> rate, double dt, const LineOptions& options) {
  if (!(dt > 0)) throw std::invalid_argument(fmt::format("sample interval {} s is not above 0", dt));
  if (rate.size() < kFewestSamples) return {};
  const double mean = mean_of(rate);
  const std::size_t longest = std::min(kLongestSegment, std::bit_floor(rate.size()));
  constexpr int kLengths = 3;
  std::vector<SpectralLine> seen;
  for (std::size_t length = longest, i = 0; i < kLengths && length >= kFewestSamples; length /= 16, ++i) {
    add_lines(seen, welch(rate, length, mean, dt), dt, options.false_alarm / kLengths);
  }
  std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.amplitude > b.amplitude; });
  std::vector<SpectralLine> lines;
  for (const auto& line : seen) {
    const bool known = std::any_of(lines.begin(), lines.end(), [&](const auto& other) { return same_line(line, other); });
    if (!known && lines.size() < options.most) lines.push_back(line);
  }
  return lines;
}

}  // namespace gyrobudget::inline v0::allan

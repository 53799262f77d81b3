// SPDX-License-Identifier: MIT
#include "lines.h"

#include "gyrobudget/noise/fft.h"

#include <boost/math/special_functions/gamma.hpp>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kFewestSamples = 1024;
constexpr std::size_t kLongestSegment = std::size_t{1} << 17;
constexpr std::size_t kFewestSegments = 4;
constexpr std::size_t kMostSamples = std::size_t{1} << 18;  // looked at, at each of the shorter segment lengths
constexpr std::size_t kFirstBin = 50;
constexpr std::size_t kLeastBlock = 60;
constexpr double kBlockRatio = 1.1;
constexpr std::size_t kParts = 8;

struct Spectrum {
  std::vector<double> power;  // one-sided density, bins 0 .. L/2
  std::size_t length = 0;     // L
  double averages = 1;        // independent segments
};

double mean_of(std::span<const double> rate) {
  double sum = 0;
  std::size_t count = 0;
  for (const double y : rate) {
    if (std::isfinite(y)) sum += y, ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

std::vector<double> hann(std::size_t length) {
  std::vector<double> window(length);
  for (std::size_t i = 0; i < length; ++i) {
    const double s = std::sin(std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(length));
    window[i] = s * s;
  }
  return window;
}

// Sum of the periodograms of segments first, first + 1, ... before last.
template <typename Start>
std::vector<double> sum_periodograms(std::span<const double> rate, std::span<const double> window, double mean,
                                     std::size_t first, std::size_t last, const Start& start) {
  const std::size_t length = window.size();
  std::vector<double> power(length / 2 + 1), segment(length);
  for (std::size_t s = first; s < last; ++s) {
    for (std::size_t i = 0; i < length; ++i) {
      const double y = rate[start(s) + i];
      segment[i] = std::isfinite(y) ? window[i] * (y - mean) : 0;
    }
    const auto bins = noise::real_spectrum(segment);
    for (std::size_t k = 0; k < power.size(); ++k) power[k] += std::norm(bins[k]);
  }
  return power;
}

Spectrum welch(std::span<const double> rate, std::size_t length, double mean, double dt) {
  const auto window = hann(length);
  const double energy = std::inner_product(window.begin(), window.end(), window.begin(), 0.0);
  const std::size_t fit = rate.size() / length,
                    segments = std::min(fit, std::max(kFewestSegments, kMostSamples / length));
  const auto start = [&](std::size_t s) { return s * fit / segments * length; };
  // A fixed number of parts, added in order: the same bytes at any number of threads.
  const std::size_t parts = std::min(segments, kParts);
  std::vector<std::vector<double>> sums(parts);
  tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t i) {
    sums[i] = sum_periodograms(rate, window, mean, i * segments / parts, (i + 1) * segments / parts, start);
  });
  Spectrum spectrum{std::vector<double>(length / 2 + 1), length, static_cast<double>(segments)};
  for (const auto& sum : sums) {
    for (std::size_t k = 0; k < sum.size(); ++k) spectrum.power[k] += sum[k];
  }
  for (double& p : spectrum.power) p *= 2 * dt / (energy * static_cast<double>(segments));
  return spectrum;
}

// The level of the spectrum without its peaks: medians of blocks 10 % wide, joined by straight lines in log-log.
class Level {
 public:
  explicit Level(const Spectrum& spectrum) {
    const std::size_t end = spectrum.power.size() - 1;  // the last bin, Nyquist, has another law
    std::vector<double> block;
    for (std::size_t low = kFirstBin / 2; low + kLeastBlock <= end;) {
      const auto wide = static_cast<std::size_t>(kBlockRatio * static_cast<double>(low));
      const std::size_t high = std::min(std::max(wide, low + kLeastBlock), end);
      block.assign(spectrum.power.begin() + static_cast<std::ptrdiff_t>(low),
                   spectrum.power.begin() + static_cast<std::ptrdiff_t>(high));
      const auto middle = block.begin() + static_cast<std::ptrdiff_t>(block.size() / 2);
      std::nth_element(block.begin(), middle, block.end());
      log_bin_.push_back(0.5 * (std::log(static_cast<double>(low)) + std::log(static_cast<double>(high))));
      log_level_.push_back(std::log(*middle));
      low = high;
    }
  }

  [[nodiscard]] bool empty() const { return log_bin_.size() < 2; }

  [[nodiscard]] double at(std::size_t bin) const {
    const double x = std::log(static_cast<double>(bin));
    const auto above = std::upper_bound(log_bin_.begin() + 1, log_bin_.end() - 1, x) - log_bin_.begin();
    const auto i = static_cast<std::size_t>(above);
    const double share = (x - log_bin_[i - 1]) / (log_bin_[i] - log_bin_[i - 1]);
    return std::exp(log_level_[i - 1] + std::clamp(share, 0.0, 1.0) * (log_level_[i] - log_level_[i - 1]));
  }

 private:
  std::vector<double> log_bin_, log_level_;
};

// A peak above its surroundings: the bins around it that exceed twice the level.
struct Peak {
  double power = 0;     // density above the level, summed over the bins
  double centroid = 0;  // in bins
};

Peak peak_at(const Spectrum& spectrum, std::size_t k, double level) {
  std::size_t low = k, high = k;
  while (high + 1 < spectrum.power.size() && spectrum.power[high + 1] > 2 * level) ++high;
  while (low > 1 && spectrum.power[low - 1] > 2 * level) --low;
  Peak peak;
  for (std::size_t j = low; j <= high; ++j) {
    peak.power += spectrum.power[j] - level;
    peak.centroid += static_cast<double>(j) * (spectrum.power[j] - level);
  }
  peak.centroid /= peak.power;
  return peak;
}

void add_lines(std::vector<SpectralLine>& lines, const Spectrum& spectrum, double dt, double false_alarm) {
  const std::size_t bins = spectrum.power.size();
  if (bins <= 2 * kFirstBin) return;
  // A bin's average over its mean is gamma distributed with `averages` degrees (pairs); the median stands for the mean.
  const double a = spectrum.averages;
  const double cut = boost::math::gamma_q_inv(a, false_alarm / static_cast<double>(bins)) / a;
  const double median_over_mean = boost::math::gamma_q_inv(a, 0.5) / a;
  const double width = 1 / (static_cast<double>(spectrum.length) * dt);
  // A strong signal leaves rounding of about eps of itself on every bin: no line is looked for down there.
  constexpr double kRounding = 1e-28;  // (50 eps)^2
  const double rounding = kRounding * std::accumulate(spectrum.power.begin(), spectrum.power.end(), 0.0);
  const Level level(spectrum);
  if (level.empty()) return;
  for (std::size_t k = kFirstBin; k + 1 < bins; ++k) {
    const double p = spectrum.power[k];
    if (p < spectrum.power[k - 1] || p <= spectrum.power[k + 1]) continue;  // peaks only
    const double median = level.at(k);
    if (!(p * median_over_mean > cut * median) || p < rounding) continue;
    const Peak peak = peak_at(spectrum, k, median);
    lines.push_back({.frequency_hz = peak.centroid * width,
                     .resolution_hz = width,
                     .amplitude = std::sqrt(2 * width * peak.power),
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
  const std::size_t longest = std::min(kLongestSegment, std::bit_floor(rate.size() / kFewestSegments));
  constexpr std::size_t kLengths = 3, kShortestSegment = 256;
  std::vector<SpectralLine> seen;
  for (std::size_t length = longest, i = 0; i < kLengths && length >= kShortestSegment; length /= 8, ++i) {
    add_lines(seen, welch(rate, length, mean, dt), dt, options.false_alarm / kLengths);
  }
  std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.amplitude > b.amplitude; });
  std::vector<SpectralLine> lines;
  for (const auto& line : seen) {
    const auto known =
        std::find_if(lines.begin(), lines.end(), [&](const auto& other) { return same_line(line, other); });
    if (known == lines.end()) {
      lines.push_back(line);
    } else if (line.resolution_hz < known->resolution_hz) {  // the finer view knows the frequency
      known->frequency_hz = line.frequency_hz;
      known->resolution_hz = line.resolution_hz;
      known->ratio = std::max(known->ratio, line.ratio);
    }
  }
  lines.resize(std::min(lines.size(), options.most));
  return lines;
}

}  // namespace gyrobudget::inline v0::allan

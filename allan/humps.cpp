// SPDX-License-Identifier: MIT
#include "humps.h"

#include <fmt/core.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

#include "psd.h"

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kFewestSamples = 8192, kLongestSegment = 8192, kFewestSegments = 32;
constexpr double kBandsPerOctave = 8, kFirstBin = 4;
constexpr double kLeastRatio = 1.5, kStandardDeviations = 6, kLeastWidth = 1.2;
constexpr std::size_t kMost = 3;

struct Band {
  double low = 0, high = 0;  // [Hz]
  double level = 0;          // logarithm of the density
  double sigma = 0;          // of that
};

std::vector<Band> bands_of(const Spectrum& spectrum) {
  std::vector<Band> bands;
  const double ratio = std::exp2(1 / kBandsPerOctave);
  std::vector<double> bins;
  double dof = 0, low = 0;
  for (std::size_t i = 0; i < spectrum.frequency.size(); ++i) {
    const double f = spectrum.frequency[i];
    if (f < kFirstBin * spectrum.frequency.front()) continue;
    if (bins.empty()) low = f, dof = 0;
    bins.push_back(spectrum.density[i]);
    dof += spectrum.dof[i];
    const bool last = i + 1 == spectrum.frequency.size();
    if (!last && spectrum.frequency[i + 1] < low * ratio) continue;
    const auto middle = bins.begin() + static_cast<std::ptrdiff_t>(bins.size() / 2);
    std::nth_element(bins.begin(), middle, bins.end());
    // Bins next to one another share half of what they know behind a Hann window, and a median has pi/2 of the
    // variance.
    constexpr double kWiden = std::numbers::pi;
    bands.push_back({low, f, std::log(*middle), std::sqrt(2 / dof * (bins.size() > 1 ? kWiden : 1))});
    bins.clear();
  }
  if (!bands.empty()) bands.pop_back();  // it ends at half the rate, whose bin has another law
  return bands;
}

double variance_between(const Spectrum& spectrum, double low, double high) {
  double sum = 0;
  const double width = spectrum.frequency.size() > 1 ? spectrum.frequency[1] - spectrum.frequency[0] : 0;
  for (std::size_t i = 0; i < spectrum.frequency.size(); ++i)
    if (spectrum.frequency[i] >= low && spectrum.frequency[i] <= high) sum += 2 * width * spectrum.density[i];
  return sum;
}

// Of the bands [begin, end): the one that stands out most, and then on either side of it.
void look(const std::vector<Band>& bands, std::size_t begin, std::size_t end, const Spectrum& spectrum,
          std::vector<Hump>& found) {
  if (end < begin + 3) return;
  std::vector<double> right(end - begin);  // lowest from here on
  for (std::size_t i = end; i-- > begin;)
    right[i - begin] = std::min(bands[i].level, i + 1 < end ? right[i + 1 - begin] : bands[i].level);
  double left = bands[begin].level, best = 0;
  std::size_t top = begin;
  for (std::size_t i = begin; i < end; ++i) {
    left = std::min(left, bands[i].level);
    const double above = bands[i].level - std::max(left, right[i - begin]);
    if (above > best) best = above, top = i;
  }
  if (best < std::log(kLeastRatio)) return;
  const double half = bands[top].level - best / 2;
  std::size_t low = top, high = top;
  while (low > begin && bands[low - 1].level > half) --low;
  while (high + 1 < end && bands[high + 1].level > half) ++high;
  const double width = bands[high].high / bands[low].low;
  if (best > kStandardDeviations * bands[top].sigma && width > kLeastWidth) {
    found.push_back({std::sqrt(bands[top].low * bands[top].high), bands[low].low, bands[high].high, std::exp(best),
                     std::sqrt(variance_between(spectrum, bands[low].low, bands[high].high))});
  }
  look(bands, begin, low, spectrum, found);
  look(bands, high + 1, end, spectrum, found);
}

}  // namespace

std::vector<Hump> find_humps(std::span<const double> rate, double dt) {
  std::vector<Hump> found;
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("sample interval {} s is not above 0 and finite", dt));
  if (rate.size() < kFewestSamples) return found;
  const std::size_t segment = std::min(kLongestSegment, std::bit_floor(rate.size() / kFewestSegments));
  const Spectrum spectrum = welch(rate, dt, static_cast<std::int64_t>(segment));
  const std::vector<Band> bands = bands_of(spectrum);
  look(bands, 0, bands.size(), spectrum, found);
  std::ranges::sort(found, [](const Hump& a, const Hump& b) { return a.ratio > b.ratio; });
  found.resize(std::min(found.size(), kMost));
  return found;
}

}  // namespace gyrobudget::inline v0::allan

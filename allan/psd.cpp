// SPDX-License-Identifier: MIT
#include "psd.h"

#include "gyrobudget/noise/fft.h"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

constexpr std::size_t kFewestSamples = 8;

void check(std::span<const double> rate, double dt) {
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("sample interval dt is {}; it must be positive and finite (s)", dt));
  if (rate.size() < kFewestSamples) {
    throw std::invalid_argument(
        fmt::format("record has {} samples; a spectrum needs at least {}", rate.size(), kFewestSamples));
  }
}

std::size_t longest_fast(std::size_t n) {
  return static_cast<std::size_t>(noise::fft_length_within(static_cast<std::int64_t>(n)));
}

struct Existing {
  double mean = 0;
  double share = 0;  ///< of the samples
};
Existing existing(std::span<const double> rate) {
  // About the first sample, so that a large mean costs no digits.
  const auto first = std::find_if(rate.begin(), rate.end(), [](double y) { return std::isfinite(y); });
  if (first == rate.end()) return {};
  double sum = 0, count = 0;
  for (const double y : rate) {
    if (std::isfinite(y)) sum += y - *first, ++count;
  }
  return {*first + sum / count, count / static_cast<double>(rate.size())};
}

double without_mean(double sample, const Existing& facts) { return std::isfinite(sample) ? sample - facts.mean : 0; }

// ---- Welch ----

/// Sum of the periodograms of some segments, and how many there were.
struct Periodograms {
  std::vector<double> power;
  double count = 0;
  void add(const Periodograms& other) {
    power.resize(std::max(power.size(), other.power.size()));
    for (std::size_t k = 0; k < other.power.size(); ++k) power[k] += other.power[k];
    count += other.count;
  }
};

Periodograms periodograms(std::span<const double> rate, std::span<const double> window, std::size_t first,
                          std::size_t end) {
  constexpr double kLeastShare = 0.5;
  const std::size_t length = window.size();
  Periodograms sum{std::vector<double>(length / 2 + 1)};
  std::vector<double> segment(length);
  for (std::size_t s = first; s < end; ++s) {
    const auto samples = rate.subspan(s * length / 2, length);
    const Existing facts = existing(samples);
    if (facts.share < kLeastShare) continue;
    for (std::size_t i = 0; i < length; ++i) segment[i] = window[i] * without_mean(samples[i], facts);
    const auto bins = noise::real_spectrum(segment);
    for (std::size_t k = 0; k < sum.power.size(); ++k) sum.power[k] += std::norm(bins[k]) / facts.share;
    ++sum.count;
  }
  return sum;
}

}  // namespace

Spectrum welch(std::span<const double> rate, double dt, std::int64_t segment) {
  check(rate, dt);
  constexpr std::size_t kSegments = 16, kLongest = std::size_t{1} << 16;
  if (segment < 0 || (segment > 0 && static_cast<std::size_t>(segment) < kFewestSamples) ||
      static_cast<std::size_t>(segment) > rate.size()) {
    throw std::invalid_argument(fmt::format("segment is {} samples; for a record of {} it must be from {} to {}",
                                            segment, rate.size(), kFewestSamples, rate.size()));
  }
  const std::size_t wanted = segment > 0 ? static_cast<std::size_t>(segment)
                                         : std::clamp(2 * rate.size() / (kSegments + 1), kFewestSamples, kLongest);
  const std::size_t length = longest_fast(wanted), segments = (rate.size() - length) / (length / 2) + 1;

  std::vector<double> window(length);
  double energy = 0;
  for (std::size_t i = 0; i < length; ++i) {
    const double s = std::sin(std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(length));
    window[i] = s * s;
    energy += window[i] * window[i];
  }
  // A fixed number of parts, added in order: the same bytes at any number of threads.
  constexpr std::size_t kParts = 8;
  std::vector<Periodograms> parts(std::min(kParts, segments));
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    parts[i] = periodograms(rate, window, i * segments / parts.size(), (i + 1) * segments / parts.size());
  });
  Periodograms sum;
  for (const Periodograms& part : parts) sum.add(part);

  Spectrum spectrum;
  spectrum.dt = dt;
  const double spacing = 1 / (static_cast<double>(length) * dt);
  spectrum.bandwidth = (1 + 2 * (4. / 9 + 1. / 36)) * spacing;
  if (sum.count == 0) return spectrum;
  constexpr double kNeighbours = 1. / 36;  // squared correlation of segments half a length apart
  const double dof = 2 * sum.count / (1 + 2 * (1 - 1 / sum.count) * kNeighbours);
  for (std::size_t k = 2; k <= length / 2; ++k) {
    spectrum.frequency.push_back(static_cast<double>(k) * spacing);
    spectrum.density.push_back(sum.power[k] * dt / (energy * sum.count));
    spectrum.dof.push_back(k == length / 2 ? dof / 2 : dof);
  }
  return spectrum;
}

// ---- sine tapers ----

Spectrum multitaper(std::span<const double> rate, double dt, std::int64_t tapers) {
  check(rate, dt);
  if (tapers < 1 || tapers > static_cast<std::int64_t>(rate.size() / 4)) {
    throw std::invalid_argument(fmt::format("{} tapers; for a record of {} samples there must be from 1 to {}", tapers,
                                            rate.size(), rate.size() / 4));
  }
  const std::size_t length = longest_fast(2 * (rate.size() + 1)), used = length / 2 - 1;
  const auto samples = rate.first(used);
  const Existing facts = existing(samples);
  Spectrum spectrum;
  spectrum.dt = dt;
  const double spacing = 1 / (static_cast<double>(used + 1) * dt);
  spectrum.bandwidth = static_cast<double>(tapers) * spacing;
  if (facts.share == 0) return spectrum;

  std::vector<double> padded(length);
  // Tapers are zero just before the first sample: it has index 1.
  for (std::size_t j = 0; j < used; ++j) padded[j + 1] = without_mean(samples[j], facts);
  const std::vector<std::complex<double>> bins = noise::real_spectrum(padded);
  // A taper is the difference of two exponentials, so a tapered transform is the difference of two bins.
  const auto last = static_cast<std::int64_t>(bins.size()) - 1;
  const auto bin = [&](std::int64_t q) {
    if (q < 0) return std::conj(bins[static_cast<std::size_t>(-q)]);
    return q <= last ? bins[static_cast<std::size_t>(q)] : std::conj(bins[static_cast<std::size_t>(2 * last - q)]);
  };
  const auto points = static_cast<std::size_t>(last / 2);
  const double scale = dt / (2 * static_cast<double>(used + 1) * static_cast<double>(tapers) * facts.share);
  spectrum.frequency.resize(points);
  spectrum.density.resize(points);
  spectrum.dof.resize(points);
  tbb::parallel_for(std::size_t{0}, points, [&](std::size_t i) {
    const auto p = static_cast<std::int64_t>(i) + 1;
    double power = 0;
    for (std::int64_t k = 1; k <= tapers; ++k) power += std::norm(bin(2 * p - k) - bin(2 * p + k));
    spectrum.frequency[i] = static_cast<double>(p) * spacing;
    spectrum.density[i] = power * scale;
    const bool at_an_end = 2 * p <= tapers || 2 * p + tapers >= last;
    spectrum.dof[i] = static_cast<double>(at_an_end ? tapers : 2 * tapers);
  });
  return spectrum;
}

Spectrum log_binned(const Spectrum& fine, int per_decade) {
  if (per_decade < 1)
    throw std::invalid_argument(fmt::format("{} bins a decade; there must be at least 1", per_decade));
  Spectrum binned;
  binned.dt = fine.dt;
  binned.bandwidth = fine.bandwidth;
  const double spacing = fine.frequency.size() > 1 ? fine.frequency[1] - fine.frequency[0] : 1;
  const auto bin_of = [&](std::size_t i) { return std::floor(std::log10(fine.frequency[i]) * per_decade); };
  for (std::size_t i = 0; i < fine.frequency.size();) {
    double density = 0, log_frequency = 0, dof = 0, count = 0;
    for (const double bin = bin_of(i); i < fine.frequency.size() && bin_of(i) == bin; ++i, ++count) {
      density += fine.density[i];
      log_frequency += std::log(fine.frequency[i]);
      dof += fine.dof[i];
    }
    binned.frequency.push_back(std::exp(log_frequency / count));
    binned.density.push_back(density / count);
    binned.dof.push_back(dof / std::min(count, fine.bandwidth / spacing));
  }
  return binned;
}

}  // namespace gyrobudget::inline v0::allan

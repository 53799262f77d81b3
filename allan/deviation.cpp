// SPDX-License-Identifier: MIT
#include "gyrobudget/allan/deviation.h"

#include "gyrobudget/allan/detail/phase.h"
#include "gyrobudget/allan/detail/second_difference.h"

#include <fmt/core.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::allan {
namespace {

using detail::TripleSum;

// Short clusters are summed tile by tile, all factors while the tile is in cache: its prefix sums start at the tile,
// so they stay small and keep their digits where a drift makes those of the whole record huge.
constexpr std::int64_t kShort = 4096;  // the longest short cluster
constexpr std::int64_t kTile = 4 * kShort;
// Long clusters walk the record in columns of this width, m apart: two of a triple's three stretches of phase are in
// cache from the step before, so memory is read once per factor.
constexpr std::int64_t kColumn = 4096;

struct Record {
  std::span<const double> rate;
  const Mask* mask;
  Form form;

  [[nodiscard]] std::int64_t samples() const { return static_cast<std::int64_t>(rate.size()); }
  [[nodiscard]] std::int64_t first() const { return first_triple(form); }
  [[nodiscard]] std::int64_t end(std::int64_t m) const {
    return first() + complete_terms(samples(), m, form);
  }
};

/// Sum over `count` triples from the first of x.
TripleSum sum_triples(const Mask* mask, const double* x, const std::uint32_t* missing, std::int64_t count,
                      std::int64_t m) {
  const detail::SecondDifference& kernel = detail::second_difference();
  if (mask) return kernel.masked(x, missing, count, m, mask->minimum_count(m));
  return {kernel.complete(x, count, m), count};
}

/// Adds partial sums in the order of their index, which no thread decides.
class Total {
 public:
  void add(const TripleSum& part) {
    squares_.add(part.squares);
    terms_ += part.terms;
  }
  [[nodiscard]] Point point(std::int64_t m, bool masked) const {
    if (terms_ == 0) return {m, std::numeric_limits<double>::quiet_NaN(), 0};
    // Without gaps squares are of sums, with gaps of means.
    const double scale = masked ? 1 : static_cast<double>(m) * static_cast<double>(m);
    return {m, squares_.value() / (2 * scale * static_cast<double>(terms_)), terms_};
  }

 private:
  detail::CompensatedSum squares_;
  std::int64_t terms_ = 0;
};

/// Scratch of one thread.
struct Stretch {
  std::vector<double> x;
  std::vector<std::uint32_t> missing;
};

std::vector<Point> short_points(const Record& record, std::span<const std::int64_t> factors) {
  const auto [shortest, longest] = std::minmax_element(factors.begin(), factors.end());
  const std::int64_t halo = 2 * *longest, first = record.first(), end = record.end(*shortest);
  const std::int64_t tiles = (end - first + kTile - 1) / kTile;

  std::vector<TripleSum> parts(static_cast<std::size_t>(tiles) * factors.size());
  tbb::enumerable_thread_specific<Stretch> scratch;
  tbb::parallel_for(std::int64_t{0}, tiles, [&](std::int64_t tile) {
    const std::int64_t begin = first + tile * kTile;
    const std::int64_t length = std::min(kTile + halo, record.samples() - begin);
    const auto rate = record.rate.subspan(static_cast<std::size_t>(begin), static_cast<std::size_t>(length));
    Stretch& stretch = scratch.local();
    stretch.x.resize(static_cast<std::size_t>(kTile + halo + 1));
    detail::integrate_stretch(rate, stretch.x.data());
    if (record.mask) {
      stretch.missing.resize(stretch.x.size());
      detail::count_missing(rate, stretch.missing.data());
    }
    TripleSum* part = parts.data() + static_cast<std::size_t>(tile) * factors.size();
    for (const std::int64_t m : factors) {
      const std::int64_t count = std::clamp<std::int64_t>(record.end(m) - begin, 0, kTile);
      *part++ = sum_triples(record.mask, stretch.x.data(), stretch.missing.data(), count, m);
    }
  });

  std::vector<Point> points;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    Total total;
    for (std::size_t part = i; part < parts.size(); part += factors.size()) total.add(parts[part]);
    points.push_back(total.point(factors[i], record.mask != nullptr));
  }
  return points;
}

Point long_point(const Record& record, const detail::Phase& phase, std::int64_t m) {
  std::vector<TripleSum> parts(static_cast<std::size_t>((m + kColumn - 1) / kColumn));
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t column) {
    const std::int64_t left = static_cast<std::int64_t>(column) * kColumn,
                       width = std::min(kColumn, m - left);
    Total total;
    TripleSum& part = parts[column];
    for (std::int64_t k = record.first() + left; k < record.end(m); k += m) {
      const std::int64_t count = std::min(width, record.end(m) - k);
      const TripleSum step = sum_triples(record.mask, phase.x.get() + k,
                                         record.mask ? phase.missing.get() + k : nullptr, count, m);
      part.squares += step.squares;
      part.terms += step.terms;
    }
  });
  Total total;
  for (const TripleSum& part : parts) total.add(part);
  return total.point(m, record.mask != nullptr);
}

void check(std::span<const double> rate, double dt, std::span<const std::int64_t> factors,
           const DeviationOptions& options) {
  if (!(dt > 0) || !std::isfinite(dt)) {
    throw std::invalid_argument(
        fmt::format("sample interval dt is {}; it must be positive and finite (s)", dt));
  }
  if (!(options.minimum_fill > 0 && options.minimum_fill <= 1)) {
    throw std::invalid_argument(
        fmt::format("minimum fill of a cluster is {}; it must be in (0, 1]", options.minimum_fill));
  }
  const auto limit = static_cast<std::int64_t>(rate.size()) / 2;
  for (const std::int64_t m : factors) {
    if (m < 1 || m > limit) {
      throw std::invalid_argument(
          fmt::format("averaging factor is {}; for a record of {} samples it must be from 1 to {}", m,
                      rate.size(), limit));
    }
  }
}

}  // namespace

Curve overlapped_variance(std::span<const double> rate, double dt, std::span<const std::int64_t> factors,
                          const DeviationOptions& options) {
  check(rate, dt, factors, options);
  const detail::Census facts = detail::census(rate, options.minimum_fill);
  const Record record{rate, facts.mask.get(), options.form};

  std::vector<std::int64_t> short_factors;
  std::copy_if(factors.begin(), factors.end(), std::back_inserter(short_factors),
               [](std::int64_t m) { return m <= kShort; });
  std::vector<Point> from_tiles;
  if (!short_factors.empty()) from_tiles = short_points(record, short_factors);
  detail::Phase phase;
  if (short_factors.size() < factors.size()) phase = detail::integrate(rate, facts);

  Curve curve{dt, record.samples(), facts.mean, options.form, std::vector<Point>(factors.size()), facts.mask};
  auto next = from_tiles.begin();
  for (std::size_t i = 0; i < factors.size(); ++i) {
    if (factors[i] <= kShort) curve.points[i] = *next++;
  }
  tbb::parallel_for(std::size_t{0}, factors.size(), [&](std::size_t i) {
    if (factors[i] > kShort) curve.points[i] = long_point(record, phase, factors[i]);
  });
  return curve;
}

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#include "deviation.h"

#include "gyrobudget/allan/detail/second_difference.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace gyrobudget::inline v0::allan {
namespace {

using detail::TripleSum;

// The record is summed tile by tile, many factors while the tile is in cache. For short clusters the tile has prefix
// sums of its own: they start at the tile, so they stay small and keep their digits where a drift makes those of the
// whole record huge.
constexpr std::int64_t kShort = 4096;  // the longest short cluster
constexpr std::int64_t kShortTile = 4 * kShort;
constexpr std::int64_t kLongTile = 1 << 15;
constexpr std::size_t kFactorsAtOnce = 256;  // bounds the memory that partial sums take

struct MaskedSeries {
  const Series& data;
  const Mask* mask;
  Form form;

  [[nodiscard]] std::int64_t samples() const { return data.samples(); }
  [[nodiscard]] std::int64_t first() const { return first_triple(form); }
  [[nodiscard]] std::int64_t end(std::int64_t m) const { return first() + complete_terms(samples(), m, form); }
};

/// Phase and missing counts from some triple on; missing is null for a complete record.
struct Window {
  const double* x;
  const std::uint32_t* missing;
};

TripleSum sum_triples(const Mask* mask, const Window& window, std::int64_t count, std::int64_t m) {
  const detail::SecondDifference& kernel = detail::second_difference();
  if (mask) return kernel.masked(window.x, window.missing, count, m, mask->minimum_count(m));
  return {kernel.complete(window.x, count, m), count};
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

/// @param window_at makes the Window that begins at a triple and serves a tile's triples for all factors.
template <typename WindowAt>
void sum_tiles(const MaskedSeries& record, std::int64_t tile_size, WindowAt window_at, std::span<Point*> points) {
  std::int64_t end = 0;
  for (const Point* point : points) end = std::max(end, record.end(point->m));
  const std::int64_t tiles = (end - record.first() + tile_size - 1) / tile_size;

  std::vector<TripleSum> parts(static_cast<std::size_t>(tiles) * points.size());
  tbb::parallel_for(std::int64_t{0}, tiles, [&](std::int64_t tile) {
    const std::int64_t begin = record.first() + tile * tile_size;
    const Window window = window_at(begin);
    TripleSum* part = parts.data() + static_cast<std::size_t>(tile) * points.size();
    for (const Point* point : points) {
      const std::int64_t count = std::clamp<std::int64_t>(record.end(point->m) - begin, 0, tile_size);
      *part++ = sum_triples(record.mask, window, count, point->m);
    }
  });
  for (std::size_t i = 0; i < points.size(); ++i) {
    Total total;
    for (std::size_t part = i; part < parts.size(); part += points.size()) total.add(parts[part]);
    *points[i] = total.point(points[i]->m, record.mask != nullptr);
  }
}

void sum_short(const MaskedSeries& record, std::span<Point*> points) {
  std::int64_t longest = 0;
  for (const Point* point : points) longest = std::max(longest, point->m);
  const std::int64_t needed = kShortTile + 2 * longest;

  struct Scratch {
    std::vector<double> x;
    std::vector<std::uint32_t> missing;
  };
  tbb::enumerable_thread_specific<Scratch> scratch;
  const auto window_at = [&](std::int64_t begin) {
    const auto length = static_cast<std::size_t>(std::min(needed, record.samples() - begin));
    const auto rate = record.data.rate().subspan(static_cast<std::size_t>(begin), length);
    auto& [x, missing] = scratch.local();
    x.resize(static_cast<std::size_t>(needed) + 1);
    detail::integrate_stretch(rate, record.mask != nullptr, x.data());
    if (record.mask) {
      missing.resize(x.size());
      detail::count_missing(rate, missing.data());
    }
    return Window{x.data(), missing.data()};
  };
  sum_tiles(record, kShortTile, window_at, points);
}

void sum_long(const MaskedSeries& record, std::span<Point*> points) {
  const detail::Phase& phase = record.data.phase();
  const auto window_at = [&](std::int64_t begin) {
    return Window{phase.x.get() + begin, record.mask ? phase.missing.get() + begin : nullptr};
  };
  sum_tiles(record, kLongTile, window_at, points);
}

/// Calls work for at most kFactorsAtOnce points at a time.
template <typename Work>
void in_batches(std::span<Point*> points, Work work) {
  for (; !points.empty(); points = points.subspan(std::min(kFactorsAtOnce, points.size()))) {
    work(points.first(std::min(kFactorsAtOnce, points.size())));
  }
}

}  // namespace

Curve overlapped_variance(const Series& data, std::span<const std::int64_t> factors, Form form) {
  data.require_factors(factors);
  const MaskedSeries record{data, data.mask().get(), form};
  Curve curve{data.dt(), data.samples(), data.mean(), form, std::vector<Point>(factors.size()), data.mask()};
  std::vector<Point*> short_points, long_points;
  for (std::size_t i = 0; i < factors.size(); ++i) {
    curve.points[i].m = factors[i];
    (factors[i] <= kShort ? short_points : long_points).push_back(&curve.points[i]);
  }
  in_batches(short_points, [&](std::span<Point*> points) { sum_short(record, points); });
  in_batches(long_points, [&](std::span<Point*> points) { sum_long(record, points); });
  return curve;
}

Curve overlapped_variance(std::span<const double> rate, double dt, std::span<const std::int64_t> factors,
                          const DeviationOptions& options) {
  return overlapped_variance(Series(rate, dt, options.minimum_fill), factors, options.form);
}

}  // namespace gyrobudget::inline v0::allan

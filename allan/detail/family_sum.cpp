// SPDX-License-Identifier: MIT
#include "family_sum.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "family_kernel.h"
#include "lanes.h"

namespace gyrobudget::inline v0::allan::detail {
namespace {

constexpr double square(double value) { return value * value; }

/// The positions of a sum: first, first + stride, ...
struct Positions {
  std::int64_t first, stride, count;
  [[nodiscard]] std::int64_t at(std::int64_t i) const { return first + stride * i; }
  [[nodiscard]] std::int64_t last() const { return at(count - 1); }
};

/// The samples a term depends on.
struct Span {
  std::int64_t begin, end;
};

bool counts(const FamilyRecord& record, const Span& span) {
  const std::int64_t length = span.end - span.begin;
  const auto lost = static_cast<std::int32_t>(record.missing[span.end] - record.missing[span.begin]);
  constexpr double kRounding = 1e-9;  // of the product: 5 % of 20 samples is one sample
  return lost <= (1 - record.minimum_fill) * static_cast<double>(length) + kRounding;
}

/// @param squared the square of the term at a position.
/// @param span the samples of the term at a position.
template <typename Squared, typename SpanAt>
[[gnu::always_inline]] inline TermSum sum_terms(const FamilyRecord& record, const Positions& at, Squared squared,
                                                SpanAt span) {
  if (record.missing == nullptr) {
    if (at.stride == 1) {
      return {lane_sum(
                  at.count, [&](std::int64_t i) __attribute__((always_inline)) { return squared(at.first + i); }),
              at.count};
    }
    return {lane_sum(
                at.count, [&](std::int64_t i) __attribute__((always_inline)) { return squared(at.at(i)); }),
            at.count};
  }
  TermSum sum;
  sum.squares = lane_sum(at.count, [&](std::int64_t i) {
    const std::int64_t k = at.at(i);
    if (!counts(record, span(k))) return 0.;
    ++sum.terms;
    return squared(k);
  });
  return sum;
}

/// Span of a term that begins at sample k.
auto span_of(std::int64_t length) {
  return [length](std::int64_t k) { return Span{k, k + length}; };
}

// ---- Allan and Hadamard: second and third differences of the phase ----

TermSum second_differences(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  if (record.missing == nullptr && at.stride == 1)
    return {second_difference().complete(record.x + at.first, at.count, m), at.count};
  const double *x0 = record.x, *x1 = x0 + m, *x2 = x1 + m;
  return sum_terms(
      record,
      at, [=](std::int64_t k) __attribute__((always_inline)) { return square((x2[k] - x1[k]) - (x1[k] - x0[k])); },
      span_of(2 * m));
}

TermSum third_differences(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  if (record.missing == nullptr && at.stride == 1)
    return {family_kernel().third_differences(record.x + at.first, at.count, m), at.count};
  const double *x0 = record.x, *x1 = x0 + m, *x2 = x1 + m, *x3 = x2 + m;
  return sum_terms(
      record, at,
      [=](std::int64_t k) __attribute__((always_inline)) {
        return square(((x3[k] - x2[k]) - (x2[k] - x1[k])) - ((x2[k] - x1[k]) - (x1[k] - x0[k])));
      },
      span_of(3 * m));
}

// ---- Modified Allan: means over m second differences ----

/// Prefix sums of the second differences from `first` on. They are themselves differences of sums over m
/// phases, so they stay as small as the terms, where prefix sums of the phase would outgrow them.
std::unique_ptr<double[]> sums_of_second_differences(const double* x, std::int64_t m, std::int64_t first,
                                                     std::int64_t count) {
  const double *x0 = x + first, *x1 = x0 + m, *x2 = x1 + m;
  auto sums = std::make_unique_for_overwrite<double[]>(static_cast<std::size_t>(count) + 1);
  sums[0] = 0;
  constexpr std::int64_t kBlock = 8;  // four short chains of additions instead of one long
  double before = 0;
  std::int64_t i = 0;
  for (; i + 4 * kBlock <= count; i += 4 * kBlock) {
    double chain[4] = {};
    for (std::int64_t j = 0; j < kBlock; ++j) {
      for (int c = 0; c < 4; ++c) {
        const std::int64_t k = i + c * kBlock + j;
        chain[c] += (x2[k] - x1[k]) - (x1[k] - x0[k]);
        sums[k + 1] = chain[c];
      }
    }
    for (int c = 0; c < 4; ++c) {
      for (std::int64_t j = 1; j <= kBlock; ++j) sums[i + c * kBlock + j] += before;
      before += chain[c];
    }
  }
  for (; i < count; ++i) sums[i + 1] = before += (x2[i] - x1[i]) - (x1[i] - x0[i]);
  return sums;
}

TermSum modified(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  const auto sums = sums_of_second_differences(record.x, m, at.first, at.last() - at.first + m);
  const double *s0 = sums.get(), *s1 = s0 + m;
  const std::int64_t first = at.first;
  return sum_terms(
      record, at, [=](std::int64_t k) __attribute__((always_inline)) { return square(s1[k - first] - s0[k - first]); },
      span_of(3 * m - 1));
}

// ---- Total: second differences of the phase reflected about its ends ----

TermSum total(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  // Position k is the middle less 1. Where both neighbours lie inside, it is the plain second difference.
  const std::int64_t n = record.samples;
  const double* x = record.x;
  const auto left = [=](std::int64_t i) { return i >= m ? x[i - m] : 2 * x[0] - x[m - i]; };
  const auto right = [=](std::int64_t i) { return i + m <= n ? x[i + m] : 2 * x[n] - x[2 * n - i - m]; };
  const auto squared = [=](std::int64_t k) {
    const std::int64_t i = k + 1;
    return square((right(i) - x[i]) - (x[i] - left(i)));
  };
  const auto span = [=](std::int64_t k) {
    const std::int64_t i = k + 1;
    return Span{std::max<std::int64_t>(0, i - m), std::min(n, i + m)};
  };
  const auto index_of = [&](std::int64_t k) {  // of the first position at or behind k
    return std::clamp<std::int64_t>((k - at.first + at.stride - 1) / at.stride, 0, at.count);
  };
  const std::int64_t inside = index_of(m - 1), outside = std::max(inside, index_of(n - m));
  const auto part = [&](std::int64_t begin, std::int64_t end) {
    return Positions{at.at(begin), at.stride, end - begin};
  };
  const Positions middle = part(inside, outside);
  const TermSum before = sum_terms(record, part(0, inside), squared, span);
  const TermSum plain = second_differences(record, m, {middle.first - m + 1, middle.stride, middle.count});
  const TermSum after = sum_terms(record, part(outside, at.count), squared, span);
  return {before.squares + plain.squares + after.squares, before.terms + plain.terms + after.terms};
}

// ---- Modified and Hadamard total: 3m values without their slope, continued evenly to both sides ----

using Numbers = std::unique_ptr<double[]>;
Numbers numbers(std::int64_t count) {
  return std::make_unique_for_overwrite<double[]>(static_cast<std::size_t>(count));
}

TermSum hadamard_total(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  if (m == 1) return third_differences(record, 1, at);  // as Stable32 and AllanTools have it
  const Numbers scratch = numbers(3 * m + 1);
  return sum_terms(
      record, at, [&](std::int64_t k) { return family_kernel().even_continuation(record.x + k, m, scratch.get()); },
      span_of(3 * m));
}

TermSum modified_total(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  const std::int64_t length = at.last() - at.first + 3 * m;
  const Numbers p = numbers(length + 1), scratch = numbers(3 * m + 1);
  const double* x = record.x + at.first;
  const double middle = x[length / 2];  // any number near the phases: it keeps their sums small
  p[0] = 0;
  for (std::int64_t i = 0; i < length; ++i) p[i + 1] = p[i] + (x[i] - middle);
  return sum_terms(
      record, at,
      [&](std::int64_t k) { return family_kernel().even_continuation(p.get() + (k - at.first), m, scratch.get()); },
      span_of(3 * m - 1));
}

TermSum theo1(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  const Numbers weight = numbers(m / 2);
  for (std::int64_t j = 0; j < m / 2; ++j) weight[j] = 1 / static_cast<double>(j + 1);
  return sum_terms(
      record, at, [&](std::int64_t k) { return family_kernel().theo1(record.x + k, m, weight.get()); }, span_of(m));
}

// ---- Parabolic: slopes of lines fitted to the phases of two neighbouring clusters ----

/// sum_j ((m-1)/2 - j) z[k+j] of z[i] = x[i] - x[i+m], from prefix sums P of z and Q of P: it is the sum of P[k+1] ..
/// P[k+m-1] less (m-1)/2 (P[k] + P[k+m]). The sums start anew every few clusters, so they stay near their terms.
TermSum parabolic(const FamilyRecord& record, std::int64_t m, const Positions& at) {
  if (m == 1) return second_differences(record, 1, at);
  const std::int64_t most = 4 * m + 64;  // samples
  const Numbers p = numbers(most + m + 1), q = numbers(most + m + 2);
  const std::int64_t block = std::max<std::int64_t>(1, most / at.stride);
  TermSum sum;
  for (std::int64_t i = 0; i < at.count; i += block) {
    const Positions part{at.at(i), at.stride, std::min(block, at.count - i)};
    const std::int64_t first = part.first, length = part.last() - first + m;
    const double* x = record.x + first;
    p[0] = q[0] = 0;
    q[1] = 0;
    for (std::int64_t k = 0; k < length; ++k) {
      p[k + 1] = p[k] + (x[k] - x[k + m]);
      q[k + 2] = q[k + 1] + p[k + 1];
    }
    const double half = static_cast<double>(m - 1) / 2;
    const TermSum some = sum_terms(
        record, part,
        [&](std::int64_t k) {
          const std::int64_t l = k - first;
          return square((q[l + m] - q[l + 1]) - half * (p[l] + p[l + m]));
        },
        span_of(2 * m - 1));
    sum.squares += some.squares;
    sum.terms += some.terms;
  }
  return sum;
}

}  // namespace

std::int64_t family_positions(Estimator estimator, std::int64_t samples, std::int64_t m) {
  switch (estimator) {
    case Estimator::adev:
    case Estimator::oadev:
      return samples - 2 * m + 1;
    case Estimator::mdev:
    case Estimator::tdev:
    case Estimator::mtotdev:
    case Estimator::ttotdev:
      return samples - 3 * m + 2;
    case Estimator::hdev:
    case Estimator::ohdev:
    case Estimator::htotdev:
      return samples - 3 * m + 1;
    case Estimator::totdev:
      return samples - 1;
    case Estimator::theo1:
    case Estimator::theobr:
    case Estimator::theoh:
      return samples - m + 1;
    case Estimator::pdev:
      return m == 1 ? samples - 1 : samples - 2 * m + 2;
  }
  return 0;
}

std::int64_t rescaled_samples(Estimator estimator, std::int64_t samples, std::int64_t m, std::int64_t coarse) {
  const double positions = static_cast<double>(family_positions(estimator, samples, m)) * static_cast<double>(coarse) /
                           static_cast<double>(m);
  const std::int64_t beyond = -family_positions(estimator, 0, coarse);  // samples that are no positions
  return std::max<std::int64_t>(1, std::llround(positions)) + beyond;
}

std::int64_t steps_per_term(Estimator estimator, std::int64_t m) {
  switch (estimator) {
    case Estimator::mtotdev:
    case Estimator::ttotdev:
    case Estimator::htotdev:
      return 7 * m;
    case Estimator::theo1:
      return m / 2;
    default:
      return 1;
  }
}

TermSum family_sum(Estimator estimator, const FamilyRecord& record, std::int64_t m, std::int64_t first,
                   std::int64_t stride, std::int64_t count) {
  const Positions at{first, stride, count};
  switch (estimator) {
    case Estimator::adev:
    case Estimator::oadev:
      return second_differences(record, m, at);
    case Estimator::mdev:
    case Estimator::tdev:
      return modified(record, m, at);
    case Estimator::hdev:
    case Estimator::ohdev:
      return third_differences(record, m, at);
    case Estimator::totdev:
      return total(record, m, at);
    case Estimator::mtotdev:
    case Estimator::ttotdev:
      return modified_total(record, m, at);
    case Estimator::htotdev:
      return hadamard_total(record, m, at);
    case Estimator::theo1:
      return theo1(record, m, at);
    case Estimator::pdev:
      return parabolic(record, m, at);
    case Estimator::theobr:
    case Estimator::theoh:
      break;
  }
  return {};
}

double family_scale(Estimator estimator, std::int64_t m, double dt) {
  // The phase in units of dt: a difference of phases over m is a difference of means.
  const double M = static_cast<double>(m), mean = 1 / (M * M), time = M * M * dt * dt / 3;
  switch (estimator) {
    case Estimator::adev:
    case Estimator::oadev:
    case Estimator::totdev:
      return mean / 2;
    case Estimator::hdev:
    case Estimator::ohdev:
    case Estimator::htotdev:
      return mean / 6;
    case Estimator::mdev:
    case Estimator::mtotdev:
      return mean * mean / 2;
    case Estimator::tdev:
    case Estimator::ttotdev:
      return mean * mean / 2 * time;
    case Estimator::theo1:
      return mean / 0.75;
    case Estimator::pdev:
      return m == 1 ? 0.5 : 72 * mean * mean * mean;
    case Estimator::theobr:
    case Estimator::theoh:
      break;
  }
  return 1;
}

}  // namespace gyrobudget::inline v0::allan::detail

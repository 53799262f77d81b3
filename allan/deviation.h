// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/mask.h"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace gyrobudget::inline v0::allan {

/// How many terms the fully overlapped estimator has for n rate samples.
enum class Form {
  full,  ///< n - 2m + 1: the angle starts at zero before the first sample (n + 1 phase points)
  ieee,  ///< n - 2m: IEEE Std 952 and MATLAB's allanvar, whose angle starts at the first sample
};

struct DeviationOptions {
  Form form = Form::full;
  double minimum_fill = 0.95;  ///< part of a cluster's samples that must exist for it to count; 1 for strict
};

struct Point {
  std::int64_t m = 1;
  double variance = 0;      ///< Allan variance [signal^2]
  std::int64_t terms = 0;   ///< number of triples averaged; 0 where gaps leave none (variance is then NaN)
};

/// An overlapped Allan variance curve and what is needed to know its statistics.
struct Curve {
  double dt = 1;                       ///< sample interval [s]
  std::int64_t samples = 0;            ///< length of the record, missing ones included
  double mean = 0;                     ///< of the samples that exist
  Form form = Form::full;
  std::vector<Point> points;
  std::shared_ptr<const Mask> mask;    ///< null for a complete record
  [[nodiscard]] double tau(std::size_t i) const { return static_cast<double>(points[i].m) * dt; }
};

/// Fully overlapped Allan variance of rates (mean values over dt; NaN or Inf = missing sample).
[[nodiscard]] Curve overlapped_variance(std::span<const double> rate, double dt,
                                        std::span<const std::int64_t> factors, const DeviationOptions& = {});

}  // namespace gyrobudget::inline v0::allan

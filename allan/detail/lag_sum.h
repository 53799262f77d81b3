// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

#include "lag_kernel.h"

namespace gyrobudget::inline v0::allan::detail {

/// Nodes u and weights w with sum_{u = 0}^{end - 1} g(u) = sum_i w_i g(u_i).
struct LagNodes {
  std::vector<double> u;
  std::vector<double> w;
};

/// Nodes for functions that are smooth but for the lags 0, m1, m2 - m1, m2 and m1 + m2, such as products of two
/// lag_kernel and a count that is linear between them.
///
/// The kSmooth lags next to each of those are taken one by one; further away come panels of 2^k whole lags, no longer
/// than their distance, each with a Gauss rule *for sums*: kNodes real nodes that sum every polynomial of degree
/// 2 kNodes - 1 over the panel's lags exactly, be it short or long. Error for products of two kernels: below 1e-9 of
/// the sum of their absolute values.
///
/// @param end number of lags, from 0.
/// @param longest_panel bound for functions that oscillate [lags].
[[nodiscard]] LagNodes lag_nodes(const Pair&, std::int64_t end, std::int64_t longest_panel = INT64_MAX);

}  // namespace gyrobudget::inline v0::allan::detail

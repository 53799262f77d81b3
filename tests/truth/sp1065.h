// SPDX-License-Identifier: MIT
// The 1000-point test suite of W. Riley, "Handbook of Frequency Stability Analysis", NIST Special Publication 1065
// (2008), chapter 12, software validation: a generator and published results, both in the public domain.
#pragma once

#include <cstdint>
#include <vector>

namespace gyrobudget::truth {

/// n_0 = 1234567890, n_{i+1} = 16807 n_i mod 2147483647; fractional frequencies n_i / 2147483647, sample interval 1 s.
inline std::vector<double> sp1065_frequencies() {
  constexpr std::int64_t kModulus = 2147483647, kMultiplier = 16807;
  std::vector<double> values;
  for (std::int64_t n = 1234567890; values.size() < 1000; n = kMultiplier * n % kModulus) {
    values.push_back(static_cast<double>(n) / static_cast<double>(kModulus));
  }
  return values;
}

struct Sp1065Row {
  std::int64_t m;
  double normal;      ///< Allan deviation of adjacent clusters
  double overlapped;  ///< overlapped Allan deviation
};
/// Of the 1000-point test suite; seven digits as printed.
inline constexpr Sp1065Row kSp1065Results[] = {
    {1, 2.922319e-01, 2.922319e-01}, {10, 9.965736e-02, 9.159953e-02}, {100, 3.897804e-02, 3.241343e-02}};

/// The nine-point NBS data of the same chapter (from NBS Monograph 140, Annex 8.E) and its results.
inline constexpr double kNbsFrequencies[] = {892, 809, 823, 798, 671, 644, 883, 903, 677};
inline constexpr Sp1065Row kNbsResults[] = {{1, 91.22945, 91.22945}, {2, 115.8082, 85.95287}};

}  // namespace gyrobudget::truth

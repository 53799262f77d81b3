// SPDX-License-Identifier: MIT
#include "fft.h"

#include <fmt/core.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include <unsupported/Eigen/FFT>

namespace gyrobudget::inline v0::noise {
namespace {

using Transform = Eigen::FFT<double>;

void require_length(std::size_t n, std::size_t multiple_of) {
  constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<int>::max());
  if (n == 0 || n > kMost || n % multiple_of != 0) {
    throw std::invalid_argument(fmt::format("transform of {} points; the length must be a multiple of {} from {} to {}",
                                            n, multiple_of, multiple_of, kMost));
  }
}

/// Runs `use` with a transform whose tables live on for the thread's next calls of the same few small lengths;
/// those of large lengths would hold as much memory as the data.
template <typename Use>
void with_transform(std::size_t n, Use use) {
  constexpr std::size_t kLongestKept = 1 << 17, kMostKept = 8;
  constexpr auto kFlags = static_cast<Transform::Flag>(Transform::Unscaled | Transform::HalfSpectrum);
  if (n > kLongestKept) {
    Transform once(Eigen::default_fft_impl<double>{}, kFlags);
    use(once);
    return;
  }
  thread_local Transform kept(Eigen::default_fft_impl<double>{}, kFlags);
  thread_local std::vector<std::size_t> lengths;
  if (std::find(lengths.begin(), lengths.end(), n) == lengths.end()) {
    if (lengths.size() == kMostKept) kept.impl().clear(), lengths.clear();
    lengths.push_back(n);
  }
  use(kept);
}

}  // namespace

std::int64_t fft_length(std::int64_t n) {
  constexpr std::int64_t kMost = std::int64_t{1} << 60;
  if (n < 1 || n > kMost) {
    throw std::invalid_argument(fmt::format("transform length {} must be from 1 to {}", n, kMost));
  }
  std::int64_t best = kMost;
  for (std::int64_t fives = 1; fives < best; fives *= 5) {
    for (std::int64_t threes = fives; threes < best; threes *= 3) {
      std::int64_t length = threes;
      while (length < n) length *= 2;
      best = std::min(best, length);
    }
  }
  return best;
}

std::int64_t fft_length_within(std::int64_t n) {
  if (n < 4) return 0;
  std::int64_t best = 4;
  for (std::int64_t fives = 4; fives <= n; fives *= 5) {
    for (std::int64_t threes = fives; threes <= n; threes *= 3) {
      std::int64_t length = threes;
      while (2 * length <= n) length *= 2;
      best = std::max(best, length);
    }
  }
  return best;
}

void fft(std::vector<std::complex<double>>& data) {
  require_length(data.size(), 1);
  if (data.size() == 1) return;  // its own transform; Eigen's has no stage for it
  std::vector<std::complex<double>> result(data.size());
  with_transform(data.size(), [&](Transform& transform) {
    transform.fwd(result.data(), data.data(), static_cast<Eigen::Index>(data.size()));
  });
  data.swap(result);
}

std::vector<std::complex<double>> real_spectrum(std::span<const double> signal) {
  require_length(signal.size(), 4);
  std::vector<std::complex<double>> result(signal.size() / 2 + 1);
  with_transform(signal.size(), [&](Transform& transform) {
    transform.fwd(result.data(), signal.data(), static_cast<Eigen::Index>(signal.size()));
  });
  return result;
}

std::vector<double> real_signal(std::span<const std::complex<double>> spectrum) {
  const std::size_t n = spectrum.empty() ? 0 : 2 * (spectrum.size() - 1);
  require_length(n, 4);
  std::vector<double> result(n);
  with_transform(
      n, [&](Transform& transform) { transform.inv(result.data(), spectrum.data(), static_cast<Eigen::Index>(n)); });
  return result;
}

}  // namespace gyrobudget::inline v0::noise

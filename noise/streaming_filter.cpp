// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/detail/streaming_filter.h"

#include <algorithm>
#include <bit>
#include <optional>

#include "fft.h"

namespace gyrobudget::inline v0::noise::detail {
namespace {

std::vector<double> divided(std::span<const double> c, double divisor) {
  std::vector<double> result(c.begin(), c.end());
  for (double& x : result) x /= divisor;
  return result;
}

// --- Sample by sample --------------------------------------------------------------------------------------

/// Transposed direct form II: what past samples contribute to future ones is kept as sums, one per sample
/// ahead, so the work on a sample is one loop without a chain of dependent sums.
class DirectFilter final : public StreamingFilter {
 public:
  DirectFilter(std::span<const double> numerator, std::span<const double> denominator)
      : b_(divided(numerator, denominator[0])), a_(divided(denominator, denominator[0])) {
    const std::size_t taps = std::max(a_.size(), b_.size());
    a_.resize(taps);
    b_.resize(taps);
    ahead_.resize(taps);  // one more than there are sums: the last stays zero
  }
  std::size_t block_size() const override { return 1024; }
  void run(std::span<double> block) override {
    for (double& sample : block) {
      const double x = sample, y = ahead_[0] + b_[0] * x;
      for (std::size_t j = 1; j < ahead_.size(); ++j) ahead_[j - 1] = ahead_[j] + (b_[j] * x - a_[j] * y);
      sample = y;
    }
  }

 private:
  std::vector<double> b_, a_, ahead_;
};

// --- By Fourier transforms of blocks -----------------------------------------------------------------------

/// Spectrum of 2 S real points with parts apart, for loops that vectorise.
struct Spectrum {
  std::vector<double> re, im;
  explicit Spectrum(std::size_t bins) : re(bins), im(bins) {}
};

/// Spectrum of a block of S samples followed by S zeros.
Spectrum spectrum_of(std::span<const double> block, std::size_t block_size) {
  std::vector<double> padded(2 * block_size);
  std::ranges::copy(block, padded.begin());
  const auto bins = real_spectrum(padded);
  Spectrum result(bins.size());
  for (std::size_t k = 0; k < bins.size(); ++k) {
    result.re[k] = bins[k].real();
    result.im[k] = bins[k].imag();
  }
  return result;
}

std::vector<double> signal_of(const Spectrum& s) {
  std::vector<std::complex<double>> bins(s.re.size());
  for (std::size_t k = 0; k < bins.size(); ++k) bins[k] = {s.re[k], s.im[k]};
  return real_signal(bins);
}

void add_product(const Spectrum& a, const Spectrum& b, Spectrum& sum) {
  for (std::size_t k = 0; k < sum.re.size(); ++k) {
    sum.re[k] += a.re[k] * b.re[k] - a.im[k] * b.im[k];
    sum.im[k] += a.re[k] * b.im[k] + a.im[k] * b.re[k];
  }
}

/// Convolution of a stream with taps, one block at a time (partitioned overlap-save): every block of the stream
/// is transformed once, in the company of the one before it, and meets each partition of the taps as it ages.
class Convolution {
 public:
  Convolution(std::vector<double> taps, std::size_t block_size) : size_(block_size), last_(block_size + 1) {
    const double scale = 1 / static_cast<double>(2 * size_);  // of the inverse transform
    for (double& c : taps) c *= scale;
    for (std::size_t first = 0; first < taps.size(); first += size_) {
      const std::size_t count = std::min(size_, taps.size() - first);
      partitions_.push_back(spectrum_of(std::span(taps).subspan(first, count), size_));
      pairs_.emplace_back(size_ + 1);
    }
  }

  /// Contribution to the block after the last one pushed, as if it were zero itself.
  std::vector<double> ahead() const {
    Spectrum sum(size_ + 1);
    add_product(last_, partitions_[0], sum);
    for (std::size_t q = 1; q < partitions_.size(); ++q) add_product(pair_before(q - 1), partitions_[q], sum);
    return latter_half(sum);
  }
  void push(std::span<const double> block) {
    Spectrum now = spectrum_of(block, size_);
    newest_ = (newest_ + 1) % pairs_.size();
    Spectrum& pair = pairs_[newest_];
    for (std::size_t k = 0; k < now.re.size(); ++k) {  // behind the block before it: a shift by half the transform
      const double sign = k % 2 == 0 ? 1 : -1;
      pair.re[k] = last_.re[k] + sign * now.re[k];
      pair.im[k] = last_.im[k] + sign * now.im[k];
    }
    last_ = std::move(now);
  }
  /// The convolution over the last block pushed.
  std::vector<double> current() const {
    Spectrum sum(size_ + 1);
    for (std::size_t q = 0; q < partitions_.size(); ++q) add_product(pair_before(q), partitions_[q], sum);
    return latter_half(sum);
  }

 private:
  const Spectrum& pair_before(std::size_t age) const { return pairs_[(newest_ + pairs_.size() - age) % pairs_.size()]; }
  std::vector<double> latter_half(const Spectrum& sum) const {
    const auto signal = signal_of(sum);
    return {signal.begin() + static_cast<std::ptrdiff_t>(size_), signal.end()};
  }

  std::size_t size_;
  Spectrum last_;                     ///< of the last block alone
  std::vector<Spectrum> partitions_;  ///< of the taps
  std::vector<Spectrum> pairs_;       ///< ring of (block before, block)
  std::size_t newest_ = 0;
};

/// First `count` samples of the impulse response of 1 / (1 + a_1 z^-1 + ...).
std::vector<double> start_of_response(std::span<const double> a, std::size_t count) {
  std::vector<double> response(count);
  response[0] = 1;
  DirectFilter filter(std::vector<double>{1}, a.first(std::min(a.size(), count)));
  filter.run(response);
  return response;
}

/// y = (b x - (a - 1) y) block by block: what earlier blocks feed back is a convolution; within the block the
/// recursion is undone by the start of its impulse response, a convolution too.
class BlockFilter final : public StreamingFilter {
 public:
  BlockFilter(std::span<const double> numerator, std::span<const double> denominator)
      : size_(size_for(std::max(numerator.size(), denominator.size()))) {
    gain_ = numerator[0] / denominator[0];
    if (numerator.size() > 1) forward_.emplace(divided(numerator, denominator[0]), size_);
    if (denominator.size() > 1) {
      auto a = divided(denominator, denominator[0]);
      auto response = start_of_response(a, size_);
      for (double& h : response) h /= static_cast<double>(2 * size_);
      within_.emplace(spectrum_of(response, size_));
      a[0] = 0;
      back_.emplace(std::move(a), size_);
    }
  }
  std::size_t block_size() const override { return size_; }
  void run(std::span<double> block) override {
    if (forward_) {
      forward_->push(block);
      std::ranges::copy(forward_->current(), block.begin());
    } else {
      for (double& x : block) x *= gain_;
    }
    if (!back_) return;
    const auto fed_back = back_->ahead();
    for (std::size_t k = 0; k < size_; ++k) block[k] -= fed_back[k];
    Spectrum product(size_ + 1);
    add_product(spectrum_of(block, size_), *within_, product);
    const auto signal = signal_of(product);
    std::copy_n(signal.begin(), size_, block.begin());
    back_->push(block);
  }

 private:
  /// Long blocks save products of spectra, short ones stay in the cache.
  static std::size_t size_for(std::size_t taps) {
    return std::clamp(std::bit_ceil(taps / 16), std::size_t{256}, std::size_t{8192});
  }

  std::size_t size_;
  double gain_;
  std::optional<Convolution> forward_, back_;
  std::optional<Spectrum> within_;
};

}  // namespace

std::unique_ptr<StreamingFilter> make_direct_filter(std::span<const double> numerator,
                                                    std::span<const double> denominator) {
  return std::make_unique<DirectFilter>(numerator, denominator);
}

std::unique_ptr<StreamingFilter> make_block_filter(std::span<const double> numerator,
                                                   std::span<const double> denominator) {
  return std::make_unique<BlockFilter>(numerator, denominator);
}

std::unique_ptr<StreamingFilter> make_filter(std::span<const double> numerator, std::span<const double> denominator) {
  constexpr std::size_t kMostDirect = 128;  // where the two take the same time
  const bool direct = std::max(numerator.size(), denominator.size()) <= kMostDirect;
  return direct ? make_direct_filter(numerator, denominator) : make_block_filter(numerator, denominator);
}

}  // namespace gyrobudget::inline v0::noise::detail

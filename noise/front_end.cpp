// SPDX-License-Identifier: MIT
#include "front_end.h"

#include "gyrobudget/noise/detail/check.h"
#include "gyrobudget/noise/detail/response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>

namespace gyrobudget::inline v0::noise {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;
constexpr double kLowest = 1e-4, kHighest = 100;  // of bandwidth * dt
constexpr double kSampledAlike = 0.02;            // likewise

constexpr double square(double x) { return x * x; }

/// base^exponent; of a real base that is not positive the exponent is whole.
Complex power(Complex base, double exponent) {
  if (base.imag() == 0) return std::pow(base.real(), exponent);
  return std::polar(std::pow(std::abs(base), exponent), std::arg(base) * exponent);
}

/// Of the mean of K samples, K^2 times the gain: sin^2(pi K f)/sin^2(pi f).
double summing_power(double count, double cycles) {
  const double below = std::sin(pi * cycles);
  return below == 0 ? square(count) : square(std::sin(pi * count * cycles) / below);
}

/// sum_{j > h} (j - h) (K - j) over K > j, the memory of a sum of K samples.
double summing_memory(double count, double lag) {
  const double x = count - lag;
  return x > 1 ? x * (square(x) - 1) / 6 : 0;
}

/// The sum of K + p samples, the oldest with weight p in [0, 1), has the autocovariance of the sums of K and of K + 1
/// in the mixture 1 - p and p, but at lag 0, where p^2 stands for p.
struct Mixture {
  double whole, part;
  explicit Mixture(double length) : whole(std::floor(length)), part(length - whole) {}
  template <typename Of>
  [[nodiscard]] double of(Of sum) const {
    return (1 - part) * sum(whole) + part * sum(whole + 1);
  }
};

/// b0 and b1 of b0^2 + b1^2 = even, b0 b1 = odd: the first-order numerator of a spectrum, its zero inside the circle.
std::array<double, 2> spectral_factor(double even, double odd) {
  const double plus = std::sqrt(std::max(0., even + 2 * odd)), minus = std::sqrt(std::max(0., even - 2 * odd));
  return {(plus + minus) / 2, (plus - minus) / 2};
}

/// The same of the second order, n0 = b0^2 + b1^2 + b2^2, n1 = b0 b1 + b1 b2, n2 = b0 b2, up to a factor: with
/// x = z + 1/z the spectrum is n2 x^2 + n1 x + n0 - 2 n2, and each root x has one zero z inside the circle.
std::array<double, 3> spectral_factor(double n0, double n1, double n2) {
  const auto zero_of = [](Complex x) {
    const Complex root = std::sqrt(x * x - 4.), above = x + root, below = x - root;
    return 2. / (std::norm(above) > std::norm(below) ? above : below);
  };
  const Complex root = std::sqrt(Complex(square(n1) - 4 * n2 * (n0 - 2 * n2), 0));
  const Complex q = n1 < 0 ? (root - n1) / 2. : -(n1 + root) / 2.;
  if (q == 0.) return {1, 0, 0};
  const Complex near = zero_of((n0 - 2 * n2) / q), far = n2 == 0 ? Complex(0) : zero_of(q / n2);
  return {1, -(near + far).real(), (near * far).real()};
}

}  // namespace

std::string_view name(FrontEnd::Kind kind) {
  switch (kind) {
    case FrontEnd::Kind::first_order:
      return "first_order";
    case FrontEnd::Kind::second_order:
      return "second_order";
    case FrontEnd::Kind::moving_average:
      return "moving_average";
  }
  throw std::invalid_argument("a value that is no kind of front end");
}

double in_range(double bandwidth, double dt) {
  constexpr double kRounding = 1e-12;
  return std::clamp(bandwidth, kLowest * (1 + kRounding) / dt, kHighest * (1 - kRounding) / dt);
}

SampledFrontEnd::SampledFrontEnd(FrontEnd front_end, double dt) {
  detail::require_interval(dt);
  detail::require(front_end.bandwidth * dt >= kLowest && std::isfinite(front_end.bandwidth),
                  "bandwidth of the low pass times the sample interval", front_end.bandwidth * dt, "at least 1e-4");
  detail::require(front_end.oversampling >= 1 && front_end.oversampling <= FrontEnd::kMostOversampling,
                  "oversampling of the low pass", front_end.oversampling, "from 1 to 100");
  front_end.bandwidth = std::min(front_end.bandwidth, kHighest / dt);
  // A corner far below the rate makes all ways of sampling one, and leaves the difference to rounding.
  const bool decimated = front_end.sampling == FrontEnd::Sampling::bilinear && front_end.oversampling > 1 &&
                         front_end.bandwidth * dt > kSampledAlike;
  if (decimated) {
    constexpr double kNearlyNone = 0.45;  // of its own rate: at half of it it is none, and rounding is all that is left
    dt /= front_end.oversampling;
    front_end.bandwidth = std::min(front_end.bandwidth, kNearlyNone / dt);
  }
  const double corner = front_end.bandwidth * dt;
  switch (front_end.kind) {
    case FrontEnd::Kind::moving_average:
      average_ = true;
      length_ = std::max(1., kMovingAverageWidth / corner);
      return;
    case FrontEnd::Kind::first_order:
      set_first_order(front_end, dt);
      pole_ = -a_[0];
      break;
    case FrontEnd::Kind::second_order:
      set_second_order(front_end, dt);
      break;
    default:
      throw std::invalid_argument("a value that is no kind of front end");
  }
  if (decimated) decimate(front_end.oversampling);
  if (residue_ == 0.) set_residue();
  log_pole_ = pole_ == 0. ? Complex(-std::numeric_limits<double>::infinity(), 0) : std::log(pole_);
}

void SampledFrontEnd::set_first_order(const FrontEnd& front_end, double dt) {
  const double w = 2 * pi * front_end.bandwidth * dt;
  switch (front_end.sampling) {
    case FrontEnd::Sampling::analogue:
      a_[0] = -std::exp(-w), b_[0] = -std::expm1(-w);
      return;
    case FrontEnd::Sampling::bilinear: {
      // A corner from half the rate on is none.
      const double t = std::tan(pi * std::min(0.49999, front_end.bandwidth * dt));
      a_[0] = (t - 1) / (t + 1), b_[0] = b_[1] = t / (t + 1);
      return;
    }
    case FrontEnd::Sampling::held: {
      const double decay = std::exp(-w), mean = -std::expm1(-w) / w;
      a_[0] = -decay, b_[0] = 1 - mean, b_[1] = mean - decay;
      return;
    }
  }
  throw std::invalid_argument("a value that is no sampling of a front end");
}

void SampledFrontEnd::set_second_order(const FrontEnd& front_end, double dt) {
  const double s = std::numbers::sqrt2 * pi * front_end.bandwidth * dt;
  const auto set_pole = [&](Complex pole) {
    pole_ = pole;
    a_[0] = -2 * pole.real(), a_[1] = std::norm(pole);
  };
  switch (front_end.sampling) {
    case FrontEnd::Sampling::analogue: {
      // r(h) = Re[(1 - i) p^h]; its spectrum times |a|^2 has two coefficients.
      set_pole(std::polar(std::exp(-s), s));
      constexpr Complex kShape(1, -1);
      const double sum = (kShape * (1. + pole_) / (1. - pole_)).real();
      residue_ = kShape / sum * pole_ / ((1. - pole_) * (1. - pole_));
      const auto r = [&](int h) { return (kShape * std::pow(pole_, h)).real(); };
      const double outer = a_[0] * (1 + a_[1]), inner = 1 + square(a_[0]) + square(a_[1]);
      const auto b = spectral_factor(r(0) * inner + 2 * (r(1) * outer + r(2) * a_[1]),
                                     r(0) * outer + r(1) * (inner + a_[1]) + r(2) * outer + r(3) * a_[1]);
      const double gain = (b[0] + b[1]) / (1 + a_[0] + a_[1]);
      b_[0] = b[0] / gain, b_[1] = b[1] / gain;
      return;
    }
    case FrontEnd::Sampling::bilinear: {
      const double t = std::tan(pi * std::min(0.49999, front_end.bandwidth * dt));
      const Complex continuous = t / std::numbers::sqrt2 * Complex(-1, 1);
      set_pole((1. + continuous) / (1. - continuous));
      b_[0] = b_[2] = square(t) / (1 + std::numbers::sqrt2 * t + square(t)), b_[1] = 2 * b_[0];
      return;
    }
    case FrontEnd::Sampling::held: {
      set_pole(std::polar(std::exp(-s), s));
      detail::LowPass low_pass(FrontEnd::Kind::second_order, front_end.bandwidth, dt);
      (void)low_pass.next(0);
      const double h[] = {low_pass.next(1), low_pass.next(0), low_pass.next(0)};
      b_[0] = h[0], b_[1] = h[1] + a_[0] * h[0], b_[2] = h[2] + a_[0] * h[1] + a_[1] * h[0];
      return;
    }
  }
  throw std::invalid_argument("a value that is no sampling of a front end");
}

// r(h) for h >= 1 by residues of H(z) H(1/z) z^(h-1): with poles p, q it is the sum of B(p)/(p - q) H(1/p) p^(h-1) and
// the same of q, B(p)/p being b0 p + b1 where there is one pole only; a sum over h then gives the memory.
void SampledFrontEnd::set_residue() {
  const Complex p = pole_;
  const bool first_order = a_[1] == 0;  // the others have conjugate poles
  const Complex inside = first_order ? b_[0] * p + b_[1] : (b_[0] * p * p + b_[1] * p + b_[2]) / (p - std::conj(p));
  const Complex outside = (b_[0] + p * (b_[1] + p * b_[2])) / (1. + p * (a_[0] + p * a_[1]));  // H(1/p)
  residue_ = (first_order ? 1. : 2.) * inside * outside / ((1. - p) * (1. - p));
}

// r(h), h >= 1, is Re[c p^h]; so is that of every `by`-th sample, with p^by. r(0) is what is left of the filter's own
// equation times y_k. The new numerator has the spectrum of r times |a|^2, three coefficients.
void SampledFrontEnd::decimate(double by) {
  set_residue();
  if (pole_.imag() == 0 && pole_.real() <= 0) by = std::round(by);
  const Complex p = pole_, per_lag = residue_ * (1. - p) * (1. - p);  // c p^h = per_lag p^(h-1)
  const auto r = [&](double h) { return (per_lag * power(p, h - 1)).real(); };
  const double second = b_[1] - a_[0] * b_[0],
               third = b_[2] - a_[0] * second - a_[1] * b_[0];  // response to an impulse
  const double variance = b_[0] * b_[0] + b_[1] * second + b_[2] * third - a_[0] * r(1) - a_[1] * r(2);
  const bool first_order = a_[1] == 0;
  pole_ = power(p, by);
  a_[0] = first_order ? -pole_.real() : -2 * pole_.real(), a_[1] = first_order ? 0 : std::norm(pole_);
  const auto of = [&](int h) { return h == 0 ? variance : r(std::abs(h) * by); };
  const auto numerator = [&](int lag) {
    const double outer = a_[0] * (1 + a_[1]), inner = 1 + square(a_[0]) + square(a_[1]);
    return of(lag) * inner + (of(lag - 1) + of(lag + 1)) * outer + (of(lag - 2) + of(lag + 2)) * a_[1];
  };
  const auto b = spectral_factor(numerator(0), numerator(1), first_order ? 0 : numerator(2));
  const double gain = (b[0] + b[1] + b[2]) / (1 + a_[0] + a_[1]);
  for (int i = 0; i < 3; ++i) b_[i] = b[static_cast<std::size_t>(i)] / gain;
  residue_ = 0;
}

double SampledFrontEnd::power_gain(double cycles) const {
  if (average_) {
    const Mixture m(length_);
    const double power = m.of([&](double count) { return summing_power(count, cycles); }) - m.part * (1 - m.part);
    return power / square(length_);
  }
  const Complex z = std::polar(1., -2 * pi * cycles);
  return std::norm((b_[0] + z * (b_[1] + z * b_[2])) / (1. + z * (a_[0] + z * a_[1])));
}

Complex SampledFrontEnd::decayed(double lag) const {
  if (lag == 0) return 1;  // of a pole at 0 too
  return std::polar(std::exp(log_pole_.real() * lag), log_pole_.imag() * lag);
}

double SampledFrontEnd::memory(double lag) const {
  if (average_) return -Mixture(length_).of([&](double count) { return summing_memory(count, lag); }) / square(length_);
  return -(residue_ * decayed(lag)).real();
}

std::int64_t SampledFrontEnd::settling() const {
  constexpr double kLeft = 1e-16;
  if (average_) return static_cast<std::int64_t>(std::ceil(length_));
  const double radius = std::abs(pole_);
  return radius > 0 ? static_cast<std::int64_t>(std::ceil(std::log(kLeft) / std::log(radius))) + 2 : 2;
}

MovingAverage::MovingAverage(double length) : length_(length), part_(length - std::floor(length)) {
  constexpr double kLongest = 1e7;
  detail::require(length >= 1 && length <= kLongest, "length of a moving average", length, "from 1 to 1e7 samples");
  past_.resize(static_cast<std::size_t>(length) + 1);
}

double MovingAverage::next(double sample) {
  if (!started_) {
    std::ranges::fill(past_, sample);
    sum_ = sample * static_cast<double>(past_.size() - 1);
    started_ = true;
  }
  past_[oldest_] = sample;
  if (++oldest_ == past_.size()) oldest_ = 0;
  sum_ += sample - past_[oldest_];
  if (oldest_ == 0) sum_ = std::accumulate(past_.begin() + 1, past_.end(), 0.);  // rounding does not gather
  return (sum_ + part_ * past_[oldest_]) / length_;
}

FrontEndFilter::FrontEndFilter(const SampledFrontEnd& front_end) : front_end_(front_end) {
  if (front_end.average_) average_.emplace(front_end.length_);
}

void FrontEndFilter::operator()(std::span<double> samples) {
  if (samples.empty()) return;
  if (!started_) in_.fill(samples[0]), out_.fill(samples[0]), started_ = true;
  const auto& b = front_end_.b_;
  const auto& a = front_end_.a_;
  for (double& sample : samples) {
    if (average_) {
      sample = average_->next(sample);
      continue;
    }
    const double v = sample;
    sample = b[0] * v + b[1] * in_[0] + b[2] * in_[1] - a[0] * out_[0] - a[1] * out_[1];
    in_ = {v, in_[0]}, out_ = {sample, out_[0]};
  }
}

}  // namespace gyrobudget::inline v0::noise

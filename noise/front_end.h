// SPDX-License-Identifier: MIT
// The low pass between a sensor's noise and its samples, as its logs show it.
#pragma once

#include <array>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace gyrobudget::inline v0::noise {

/// A low pass of unit gain at frequency 0. Every kind has one parameter, its bandwidth:
///
///   first order     1/(1 + s/w), w = 2 pi bandwidth
///   second order    Butterworth's, 1/(1 + sqrt(2) s/w + (s/w)^2)
///   moving average  over T = 0.442946/bandwidth, the mean of L = T/dt samples; where L is not whole, the oldest one
///                   counts by what is left of L
///
/// -3 dB at the bandwidth. How a continuous filter comes to samples is `sampling`; for a bandwidth well below the rate
/// all are the same. A moving average has one only.
struct FrontEnd {
  enum class Kind { first_order, second_order, moving_average };
  enum class Sampling {
    analogue,  ///< filtered at a rate far above that of the log, then sampled: what lies above half the rate folds down
    bilinear,  ///< a digital filter by the bilinear transform, its frequency kept, at `oversampling` times the rate
    held,      ///< the filter answers to a rate that is constant over each sample; its mean over samples: Imu's (imu.h)
  };
  Kind kind = Kind::first_order;
  double bandwidth = 0;  ///< -3 dB [Hz]
  Sampling sampling = Sampling::analogue;
  /// Of a bilinear one: of so many filtered samples one is logged, 1 to kMostOversampling; more is analogue. It counts
  /// for bandwidths above 0.02 of the log's rate: below, all are the same. Between whole numbers autocovariances run
  /// smoothly, for searches; but not where the bandwidth is above a quarter of the filter's own rate.
  double oversampling = 1;
  static constexpr double kMostOversampling = 100;

  friend bool operator==(const FrontEnd&, const FrontEnd&) = default;
};

/// "first_order", "second_order", "moving_average". @throws std::invalid_argument for a value that is no Kind.
[[nodiscard]] std::string_view name(FrontEnd::Kind kind);

/// The nearest bandwidth that samples every dt [s] can show: from 1e-4/dt to 100/dt.
[[nodiscard]] double in_range(double bandwidth, double dt);

/// fc dt of a moving average over one sample, and so its bandwidth times its length.
inline constexpr double kMovingAverageWidth = 0.442946470689452;

/// A front end beside samples every dt [s]: white noise v of unit variance becomes y with
///
///   y_k + a1 y_{k-1} + a2 y_{k-2} = b0 v_k + b1 v_{k-1} + b2 v_{k-2}     (first and second order; analogue and
///                                                                         oversampled: a process of the same spectrum)
///   power gain |H(f)|^2, |H(0)| = 1
///   memory(h) = -sum_{j > h} (j - h) r(j), r the autocovariance of y
///
/// Beyond the memory of the filter all it leaves in the phase is memory(0) = -S1/2, S1 = sum |h| r(h): the Allan
/// variance of filtered white noise is N^2/dt [1/m + (6 memory(0) - 8 memory(m) + 2 memory(2m))/(2 m^2)].
/// Error of memory below 1e-11 (1 + |memory(0)|) for bandwidth * dt from 0.01 on and below 1e-8 from 1e-4 on; of the
/// gain 1e-12 from 0.01 on, 1e-5 of itself from 1e-4 on. Source: residues of the z transform (A. Oppenheim and R.
/// Schafer, Discrete-Time Signal Processing); the memory, its place in the Allan variance and the sampled spectra are
/// derived here and held by tests/noise/front_end_test.
class SampledFrontEnd {
 public:
  /// @param front_end  its bandwidth from 1e-4/dt on; above 100/dt it is taken for 100/dt, whose memory is below
  ///   a hundredth of a sample
  /// @param dt  sample interval [s]
  /// @throws std::invalid_argument for a bandwidth below this range, a dt that is not positive and finite, and values
  /// that are no Kind or Sampling.
  SampledFrontEnd(FrontEnd front_end, double dt);

  /// At a frequency of `cycles` per sample, in [0, 1/2].
  [[nodiscard]] double power_gain(double cycles) const;
  /// memory(h) at lag h >= 0; continued smoothly between whole lags (a moving average: but for its kinks).
  [[nodiscard]] double memory(double lag) const;
  /// Samples after which nothing is left of what was before: 1e-16 of it, at least 1.
  [[nodiscard]] std::int64_t settling() const;

 private:
  void set_first_order(const FrontEnd& front_end, double dt);
  void set_second_order(const FrontEnd& front_end, double dt);
  void set_residue();
  void decimate(double by);
  [[nodiscard]] std::complex<double> decayed(double lag) const;  ///< pole^lag
  friend class FrontEndFilter;

  bool average_ = false;
  double length_ = 1;                            // of a moving average, samples
  double b_[3] = {1, 0, 0}, a_[2] = {0, 0};      // the others
  std::complex<double> pole_ = 0, residue_ = 0;  // memory(h) = -Re(residue pole^h)
  std::complex<double> log_pole_ = 0;            // powers by it take a tenth of std::pow's time
};

/// The mean of the last `length` samples, at least 1; where that is not whole, the oldest one counts by what is left of
/// it. The first sample is as if it had always been.
class MovingAverage {
 public:
  /// @throws std::invalid_argument for a length below 1 or above 1e7.
  explicit MovingAverage(double length);
  [[nodiscard]] double next(double sample);

 private:
  double length_, part_;      // part_: of the oldest sample, in [0, 1)
  std::vector<double> past_;  // a ring
  std::size_t oldest_ = 0;
  double sum_ = 0;  // of all but the oldest
  bool started_ = false;
};

/// Passes samples through a front end, however they are shared out among calls. The first sample is as if it had always
/// been.
class FrontEndFilter {
 public:
  explicit FrontEndFilter(const SampledFrontEnd& front_end);
  void operator()(std::span<double> samples);

 private:
  SampledFrontEnd front_end_;
  std::optional<MovingAverage> average_;
  std::array<double, 2> in_{}, out_{};
  bool started_ = false;
};

}  // namespace gyrobudget::inline v0::noise

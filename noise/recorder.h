// SPDX-License-Identifier: MIT
// What a sensor's electronics and its recorder make of its noise: simulated records that are as spoilt as real ones.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "front_end.h"
#include "generate.h"

namespace gyrobudget::inline v0::noise {

/// In the order in which they act. Sizes are in standard deviations of the white noise of a sample as the front end
/// lets it through, called sigma here; of a sensor without white noise they are of size 0.
struct Recorder {
  std::optional<FrontEnd> front_end;  ///< of white noise; with decimation it is a bilinear one at the faster rate
  int decimation = 1;                 ///< the sensor samples so many times as fast, and one of so many is logged
  double warm_up = 0;   ///< a bias of this size [sigma] at the start, exp(-t/T) with T a twentieth of the record
  double knock = 0;     ///< half a second in the middle shakes with this amplitude [sigma], at 5 Hz
  double outliers = 0;  ///< share of samples to which normal errors of kOutlierSize sigma are added
  double rounding = 0;  ///< step of the samples [sigma]; the mean lies anywhere between two
  int held = 1;         ///< one row of so many repeats the one before it; 1: none
  double gaps = 0;      ///< share of samples that are missing, scattered

  friend bool operator==(const Recorder&, const Recorder&) = default;
};

inline constexpr double kOutlierSize = 10;

/// Makes records of a sensor behind a recorder; calls are const and safe from many threads, with the same bytes.
class RecorderGenerator {
 public:
  /// Records of `samples` rates, dt [s] apart; missing ones are NaN.
  /// @param processes  of the sensor, in front of the recorder
  /// @throws std::invalid_argument for what RecordGenerator and SampledFrontEnd refuse, sizes that are negative or not
  /// finite, shares outside [0, 1), and counts below 1 or above 1000.
  RecorderGenerator(std::span<const Process> processes, const Recorder& recorder, std::int64_t samples, double dt);

  [[nodiscard]] std::vector<double> operator()(StreamKey key) const;

  /// The noise of the log: behind the front end, its white noise as it is at low frequencies,
  ///
  ///     N^2 (1 + sum_{m=1}^{h-1} 4 sin^2(pi m/h) |H(m/h)|^2/h^2) + q^2 dt (1 + 2/h)/12,
  ///
  /// with rows held h and rounding in steps of q [signal] (its error is white for steps up to about sigma); outliers, a
  /// warm-up and a knock are no noise. Of white noise that is not filtered the sum is 2/h.
  [[nodiscard]] const std::vector<Process>& processes() const { return processes_; }
  /// Standard deviation of a sample's white noise.
  [[nodiscard]] double sigma() const { return sigma_; }

 private:
  void set_noise_of_log();
  void warm(std::span<double> record) const;
  void knock(std::span<double> record) const;
  void add_outliers(std::span<double> record, StreamKey key) const;
  void round(std::span<double> record, StreamKey key) const;
  void hold(std::span<double> record) const;
  void remove(std::span<double> record, StreamKey key) const;

  Recorder recorder_;
  double dt_;
  std::vector<Process> processes_;
  double sigma_ = 0;
  RecordGenerator generator_;
};

}  // namespace gyrobudget::inline v0::noise

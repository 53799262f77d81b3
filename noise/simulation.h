// SPDX-License-Identifier: MIT
// The log of a sensor at rest: which axes it has, what each holds, and the numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "bielas.h"
#include "generate.h"
#include "model.h"
#include "sensor.h"

namespace gyrobudget::inline v0::noise {

/// How the noise of an axis is made.
struct SimulationModel {
  enum class Kind {
    spectral,      ///< exact in distribution, the whole record in memory (RecordGenerator); the others stream
    gauss_markov,  ///< the same processes, 1/f as a sum of Gauss-Markov ones (Generator)
    jerath,        ///< model 1 of Nunes et al., see Jerath
    imu_sensor,    ///< model 2, see ImuSensor
    bielas,        ///< model 3, see Bielas
  };
  Kind kind = Kind::spectral;
  std::optional<std::int64_t> taps;  ///< jerath, imu_sensor: past samples of the 1/f filter; unset: the model's own
  bool single_sided = false;         ///< imu_sensor: its NoiseType; else double_sided
  Bielas::Bias variant = {};         ///< bielas
  /// bielas: with the sensor's rate random walk; unset: with it but for integrated_legacy, which is one itself.
  std::optional<bool> rate_random_walk;
  double correlation_time_s = 100;  ///< bielas, gauss_markov
};

/// The processes and filters that the model makes of the errors of a sensor's axis (0, 1, 2 for x, y, z) at a sample
/// interval [s]. Models 1 to 3 know N, B and K alone.
/// @throws std::invalid_argument for what the model refuses.
[[nodiscard]] Model model_of(const SimulationModel& model, const ErrorModel& errors, std::size_t axis, double dt);

/// The terms of a sensor's noise that the model leaves out, one for each process that any axis has.
[[nodiscard]] std::vector<Term> left_out(const SimulationModel& model, const ErrorModel& errors);

struct SimulationOptions {
  SimulationModel model;
  double rate_hz = 100;
  double duration_s = 0;  ///< infinite: without end
  std::uint64_t seed = 1;
  std::vector<int> axes{0, 1, 2};                      ///< which of x, y, z
  std::optional<TemperatureProfile> temperature = {};  ///< from the first sample on; unset: at the reference
};

/// One axis of a simulated sensor at rest.
struct SimulatedAxis {
  Signal signal = Signal::angular_rate;
  int axis = 0;  ///< 0, 1, 2 for x, y, z
  Model model;
  std::optional<TemperatureModel> temperature;
  /// Streams of random numbers: gyro axes are 0, 1, 2 whatever subset is asked for, accelerometer axes 3, 4, 5.
  StreamKey key;
};

/// A sensor at rest, simulated: its gyro axes, and its accelerometer axes where it has an accelerometer.
///
///     const noise::Simulation log(sensor, {.rate_hz = 100, .duration_s = 3600});
///     const std::vector<double> gyro_x = log.record(0);
class Simulation {
 public:
  /// @throws std::invalid_argument for an axis other than 0, 1 and 2, a rate that is not positive, a duration that is
  /// negative, and what model_of refuses.
  Simulation(const SensorModel& sensor, SimulationOptions options);

  [[nodiscard]] const SimulationOptions& options() const { return options_; }
  [[nodiscard]] const std::vector<SimulatedAxis>& axes() const { return axes_; }

  static constexpr std::uint64_t kEndless = std::numeric_limits<std::uint64_t>::max();
  [[nodiscard]] std::uint64_t samples() const;  ///< of each axis; kEndless without end

  /// Whether it is made in constant memory, by generator(); else by record() alone.
  [[nodiscard]] bool streams() const { return options_.model.kind != SimulationModel::Kind::spectral; }

  /// Memory at the peak, in bytes, where the records of all axes are made one after the other and kept.
  [[nodiscard]] double bytes_of_records() const;

  /// The whole record of an axis, exact in distribution.
  /// @param index into axes(). @throws std::invalid_argument for a model that streams.
  [[nodiscard]] std::vector<double> record(std::size_t index) const;

  /// The bias that the options' temperature makes of an axis; adds it to samples [signal] from sample `first` on, which
  /// record() has done. Without one it adds nothing.
  void add_temperature(std::size_t index, std::uint64_t first, std::span<double> samples) const;

  /// The temperature of samples from `first` on [degC]; the reference of the gyro where the options have none.
  void temperatures(std::uint64_t first, std::span<double> values) const;

  /// What makes the samples of an axis one by one. 1/f noise is right up to the duration; without end to the
  /// generator's own limit.
  [[nodiscard]] Generator generator(std::size_t index) const;

 private:
  SimulationOptions options_;
  std::vector<SimulatedAxis> axes_;
};

}  // namespace gyrobudget::inline v0::noise

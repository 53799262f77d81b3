// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "filter.h"
#include "process.h"

namespace gyrobudget::inline v0::noise {

/// The noise of one axis as a published simulation model makes it: a sum of independent processes and filters,
/// sampled at the interval it was written for. Jerath, ImuSensor and Bielas each give one; Generator makes its
/// samples, ModelMoments says what they hold.
///
///     const noise::Jerath jerath{.arw = 1.6e-7, .bias_instability = 8.2e-9, .rrw = 3.5e-9};
///     const noise::Model model = jerath.model(dt);
///     noise::Generator generator(model.processes, model.filters, dt, {.key = {seed, axis}});
///     const double expected = noise::ModelMoments(model, dt).allan_variance(m);
struct Model {
  std::vector<Process> processes;
  std::vector<FilteredNoise> filters;
};

/// Exact second moments of a model as it is implemented, truncation and start from rest included.
class ModelMoments {
 public:
  /// Of the model sampled every dt [s].
  /// @throws std::invalid_argument for dt not positive and finite and what FilterMoments refuses.
  ModelMoments(Model model, double dt);

  /// Two-sided power spectral density [signal^2/Hz] at a frequency in (0, 1/(2 dt)], of the stationary noise.
  [[nodiscard]] double psd(double frequency_hz) const;
  /// Allan variance [signal^2] at averaging factor m >= 1, of the stationary noise.
  [[nodiscard]] double allan_variance(std::int64_t m) const;
  /// Expectation of the overlapped estimate over the first `samples` samples of the generator, whose filters
  /// start at rest. Differs from the stationary one by what theory calls zero-start bias.
  /// @throws std::invalid_argument unless 1 <= m <= samples / 2.
  [[nodiscard]] double allan_variance(std::int64_t m, std::int64_t samples) const;

 private:
  Model model_;
  double dt_;
  std::vector<FilterMoments> filters_;
};

}  // namespace gyrobudget::inline v0::noise

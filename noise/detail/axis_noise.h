// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/normal.h"
#include "gyrobudget/noise/sensor.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "first_order.h"
#include "state_bank.h"

namespace gyrobudget::inline v0::noise::detail {

/// Samples before the first one of a scene: since power-on, and how many of the last are a calibration.
struct Epoch {
  std::uint64_t powered = 0;
  std::uint64_t calibrated = 0;
};
/// @throws std::invalid_argument as Imu has it.
[[nodiscard]] Epoch epoch_of(const ErrorModel&, double dt);

/// How far flicker is to be right.
struct FlickerBand {
  double duration = 1e4;  ///< [s], beside the epoch
  double poles_per_decade = 2;
};

/// The noise processes of one axis from a scene's start on, as rates, in tiles. Quantization is not among
/// them.
class AxisNoise {
 public:
  static constexpr std::size_t kTile = 64;
  using Tile = std::array<double, kTile>;

  /// @param which  of the triad's axes: 0, 1, 2 for x, y, z
  AxisNoise(const ErrorModel&, std::size_t which, double dt, StreamKey axis, const FlickerBand&);

  /// Their mean over the calibration, a draw of this run; 0 without one.
  [[nodiscard]] double calibrated_mean() const { return calibrated_mean_; }
  /// The next tile: what varies slowly, and white noise with the sinusoids. False where there is nothing:
  /// both tiles are then left alone.
  bool next(Tile& slow, Tile& fast);

 private:
  /// First-order states driven by one stream, less what they were at power-on.
  struct Bank {
    StateBank states;
    StreamKey key;
    double origin = 0;
  };
  struct Setting {
    double dt = 1;
    Epoch epoch;
    StreamKey axis;
  };

  void add_bank(const Setting&, char kind, std::uint64_t occurrence, std::span<const Process> states);
  /// Draws a state from power-on to the first sample. @returns how much of it is not bias: its value at
  /// power-on
  double add_state(const Setting&, Bank&, const Process&, std::span<const double> u);
  void start_white(const Setting&, double n, const std::optional<FrontEnd>& filter);
  void add_ramp(const Setting&, double r);
  void add_sinusoid(const Setting&, const Sinusoid&);

  void add_banks(Tile& slow);
  void add_white(Tile& fast);
  void add_sinusoids(Tile& fast) const;

  std::vector<Bank> banks_;
  std::vector<Sinusoid> sinusoids_;  ///< frequency in cycles per sample, within half a one
  double white_ = 0;                 ///< of a sample
  std::optional<FrontEndFilter> filter_;
  StreamKey white_key_;
  double ramp_step_ = 0, ramp_start_ = 0;
  double calibrated_mean_ = 0;
  std::uint64_t at_ = 0;         ///< samples so far
  std::vector<double> normals_;  ///< room for a tile of the largest bank
};

}  // namespace gyrobudget::inline v0::noise::detail

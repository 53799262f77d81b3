// SPDX-License-Identifier: MIT
// Inside navigation: an IMU log read up to times that need not be its stamps.
#pragma once

#include "gyrobudget/estimation/navigation/recording.h"

#include <cstddef>

namespace gyrobudget::inline v0::navigation::detail {

class ImuReader {
 public:
  /// The log must outlive it. Reading starts at `from` [s after origin].
  ImuReader(const ImuLog& log, std::int64_t origin, double from);

  [[nodiscard]] double now() const { return now_; }
  /// Time of stamp k, in the scene's time [s].
  [[nodiscard]] double stamp(std::size_t k) const;

  /// What was measured since now(), up to `to` or to the end of the interval that holds now(): it becomes now().
  struct Piece {
    noise::ImuIncrement increment;
    double dt = 0;         ///< [s]
    std::size_t interval;  ///< of the log
  };
  /// Whether there is more before `to`.
  [[nodiscard]] bool before(double to) const;
  [[nodiscard]] Piece next(double to);

 private:
  [[nodiscard]] noise::ImuIncrement part(std::size_t k, double from, double to) const;

  const ImuLog& log_;
  std::int64_t origin_;
  double now_;
  std::size_t next_ = 0;  ///< interval that is being read
};

}  // namespace gyrobudget::inline v0::navigation::detail

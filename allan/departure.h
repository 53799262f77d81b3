// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/noise/process.h"

#include <cstdint>
#include <optional>
#include <span>

#include "series.h"

namespace gyrobudget::inline v0::allan {

/// Something slow in a record that noise of the stated processes would not do.
struct Departure {
  enum class Kind {
    warm_up,  ///< a exp(-t/T) of a sensor just switched on
    trend,    ///< a straight line
    step,     ///< a jump for good
  };
  Kind kind = Kind::trend;
  double size = 0;             ///< a of the warm-up, change of the trend over the record, height of the step [signal]
  double time_constant_s = 0;  ///< T of the warm-up
  std::int64_t index = 0;      ///< first sample after the step
  double sigmas = 0;           ///< |size| in its standard deviations under the noise
  double p_value = 1;          ///< of the record without it, times the number of shapes tried
};

struct DepartureOptions {
  double false_alarm = 1e-3;  ///< probability that a record of the stated noise shows a departure
};

/// The clearest departure of a record, if any.
///
/// The means of 128 equal blocks are differenced; their covariance C under the processes is exact (Toeplitz). For each
/// shape g, exp(-t/T) with T = 1/64, 1/32, ... 1/2 of the record, the straight line, and a step at each border of
/// blocks, generalised least squares gives its size and F = (g'C^-1 z)^2/(g'C^-1 g) over the mean square that is left;
/// the shape with the largest F is the answer where its p-value times the number of shapes is below false_alarm. A
/// step is then placed where the means of the two blocks before and after differ most. F does not know how large the
/// noise is, only how it is divided among the processes, so it holds for coefficients that were fitted to the same
/// record, which a departure has raised.
///
/// This is the most powerful look for one slow departure; for several, or faster ones, see steps.h.
/// @param processes what the noise consists of; ramps and sinusoids among them are taken as noise too.
/// @return nothing where no departure is seen, processes are empty, the record is shorter than 512 samples, or a block
/// has under half of its samples.
/// @throws std::invalid_argument for a false alarm outside (0, 1) or an invalid process.
[[nodiscard]] std::optional<Departure> find_departure(const Series& record, std::span<const noise::Process> processes,
                                                      const DepartureOptions& options = {});

}  // namespace gyrobudget::inline v0::allan

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/allan/record.h"
#include "gyrobudget/noise/process.h"

#include <optional>
#include <span>

namespace gyrobudget::inline v0::allan {

/// A drift that noise of the stated processes would not make: a exp(-t/T), the warm-up of a sensor just switched on, or
/// a straight trend.
struct Drift {
  double size = 0;             ///< a of the warm-up; of a trend, the change over the record [signal]
  double time_constant_s = 0;  ///< T; infinite for a trend
  double p_value = 1;          ///< of the record without it, corrected for the shapes tried
};

struct DriftOptions {
  double false_alarm = 1e-3;  ///< probability that a record of the stated noise shows a drift
};

/// Looks for a drift in a record.
///
/// The means of 128 equal blocks are differenced; their covariance C under the processes is exact (Toeplitz). For each
/// shape g, exp(-t/T) with T = 1/64, 1/32, ... 1/2 of the record and the straight line, generalised least squares
/// gives its size and F = (g'C^-1 z)^2/(g'C^-1 g) over the mean square that is left; the shape with the largest F is the
/// answer where its p-value times the number of shapes is below false_alarm. F does not know how large the noise
/// is, only how it is divided among the processes, so it holds for coefficients that were fitted to the same record.
///
/// @param processes what the noise consists of; ramps and sinusoids among them are taken as noise too.
/// @return nothing where no drift is seen, processes are empty, the record is shorter than 512 samples, or a block has
/// under half of its samples.
/// @throws std::invalid_argument for a false alarm outside (0, 1) or an invalid process.
[[nodiscard]] std::optional<Drift> find_drift(const RateRecord&, std::span<const noise::Process> processes,
                                              const DriftOptions& = {});

}  // namespace gyrobudget::inline v0::allan

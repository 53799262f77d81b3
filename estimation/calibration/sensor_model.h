// SPDX-License-Identifier: MIT
// From a datasheet to the model that simulations, budgets and filters take.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <string>
#include <vector>

#include "several.h"

namespace gyrobudget::inline v0::calibration {

/// A coefficient is written axis by axis where the axes differ by more than their scatter: where the p-value of
/// Cochran's Q (fit/combine.h, from the 95 % intervals) is below this. So of triads whose axes are alike 1 in 100 is
/// written so, for each coefficient.
inline constexpr double kAxesDiffer = 0.01;

/// What was told of one coefficient of a triad.
struct TriadCoefficient {
  noise::Signal signal = noise::Signal::angular_rate;
  noise::Term term = noise::Term::white;
  double p_value = 1;     ///< of the axes being alike; 1 where there are not two to compare
  bool per_axis = false;  ///< written for each axis: they differ, or only some of them have the term at all
};

/// A datasheet as a sensor file has it.
struct SensorSummary {
  noise::SensorModel sensor;
  /// 95 % limits of the coefficients Q, N, B, K and R that are not resolved, by the axis itself where axes differ, by
  /// all of them together where they have one value; 0 where they are, or were not fitted.
  noise::SensorModel limits;
  std::vector<TriadCoefficient> coefficients;
  /// Axes of the sensor that the record tells nothing of ("gyro z"): they have the root mean square of the others.
  std::vector<std::string> borrowed;
  /// Triads of which no axis has its place (several sensors in one record, say): they are never written axis by axis.
  std::vector<noise::Signal> without_places;
  /// Triads whose records show a low pass that a sensor's one filter cannot be: of a kind that is not told, not on all
  /// axes, or not the same on all.
  std::vector<noise::Signal> without_filter;
};

/// One model for each triad. Of every term it has the root mean square over the axes that have an answer, as their
/// spectra add up, or each axis' own where they differ (kAxesDiffer). A Gauss-Markov process whose size or correlation
/// time differs is one for each axis; lines within 0.1 % of one frequency are one. Which axis is x, y or z is told by
/// the last letter of its name, and of three axes whose names do not tell, by their order. Values have six digits in
/// the datasheet's unit, more than any record tells, so that a file has what was computed. What depends on
/// temperature is that of each axis where a triad has three, or one that stands for all. A filter is written where all
/// axes have one of the same kind, with bandwidths within 3.3 standard deviations of their mean. Coefficients that a
/// record cannot give (fit::Status::not_quotable) are as if the axis had none. Dimensionless axes have no place in it.
/// @param sheet  its gyro axes make the gyro, its accelerometer axes the accelerometer
/// @param name   of the sensor
/// @return a gyro of zeros where no gyro axis has an answer, and no accelerometer where none of its axes has one.
[[nodiscard]] SensorSummary summarise(const Datasheet& sheet, std::string name);
/// Of the coefficients that several records gave together.
[[nodiscard]] SensorSummary summarise(const TypeDatasheet& sheet, std::string name);

/// The sensor of summarise().
[[nodiscard]] noise::SensorModel sensor_model(const Datasheet& sheet, std::string name);
[[nodiscard]] noise::SensorModel sensor_model(const TypeDatasheet& sheet, std::string name);

}  // namespace gyrobudget::inline v0::calibration

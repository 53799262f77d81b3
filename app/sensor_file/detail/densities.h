// SPDX-License-Identifier: MIT
// What estimators take of a sensor: white noise and a random walk that is never 0 where anything is known.
#pragma once

#include "gyrobudget/noise/sensor.h"

#include <cstddef>
#include <string>
#include <vector>

namespace gyrobudget::inline v0::sensor_file::detail {

/// Where a number comes from.
enum class Origin { none, limit, of_flicker, fitted };

struct Density {
  double value = 0;  ///< SI
  Origin origin = Origin::none;
  std::size_t axis = 0;
};

/// The densities of one triad, with words on each; kalibr.h has the rules. It refers to both models.
class Densities {
 public:
  Densities(const noise::ErrorModel& model, const noise::ErrorModel& limits, noise::Signal signal, double horizon_s)
      : model_(model), limits_(limits), signal_(signal), horizon_s_(horizon_s) {}

  /// "gyroscope" or "accelerometer"
  [[nodiscard]] const char* name() const;
  [[nodiscard]] bool is_gyro() const { return signal_ == noise::Signal::angular_rate; }
  [[nodiscard]] Density white(std::size_t axis) const { return of_term(noise::Term::white, axis); }
  [[nodiscard]] Density walk(std::size_t axis) const;
  /// A coefficient as it is resolved, or its limit.
  [[nodiscard]] Density of_term(noise::Term term, std::size_t axis) const;
  [[nodiscard]] Density largest_of_term(noise::Term term) const;
  /// Of the axis that has the most.
  [[nodiscard]] Density largest_white() const;
  [[nodiscard]] Density largest_walk() const;
  /// Where they come from, one sentence without its end.
  [[nodiscard]] std::string white_words(const Density& white) const { return of(white, noise::Term::white); }
  [[nodiscard]] std::string walk_words(const Density& walk) const;
  [[nodiscard]] std::string words(const Density& density, noise::Term term) const { return of(density, term); }
  /// What a form of two numbers has no place for, one sentence each.
  [[nodiscard]] std::vector<std::string> left_out(const Density& walk) const;

 private:
  [[nodiscard]] std::string quoted(double si, noise::Term term) const;
  [[nodiscard]] bool resolved(noise::Term term, std::size_t axis) const;
  [[nodiscard]] std::string of(const Density& density, noise::Term term) const;

  const noise::ErrorModel& model_;
  const noise::ErrorModel& limits_;
  noise::Signal signal_;
  double horizon_s_;
};

}  // namespace gyrobudget::inline v0::sensor_file::detail

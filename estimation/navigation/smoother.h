// SPDX-License-Identifier: MIT
// Fixed-interval smoothing: what all measurements of a run, later ones included, say of an earlier time.
//
// The modified Bryson-Frazier form (Bierman, Fixed interval smoothing with discrete measurements, Int. J.
// Control 18:65, 1973; Bierman 1977, X) needs no inverse of a covariance. A vector l and a matrix L run
// backwards, zero at the end, through what the filter did,
//   row h, S, residual r, gain k:  l <- l - h (r/S + k . l),   L <- (I - k h)^T L (I - k h) + h^T h/S
//   transition Phi:                l <- Phi^T l,               L <- Phi^T L Phi
// and at an epoch with covariance P the estimate gains -P l and the covariance loses P L P. In a closed loop
// the residuals are the same numbers, so l corrects the estimate that the filter held at that epoch.
#pragma once

#include <cstddef>
#include <vector>

#include "covariance.h"
#include "strapdown.h"

namespace gyrobudget::inline v0::navigation {

struct SmoothedEpoch;

/// What a filter did, in order. Transitions between two entries are multiplied together, so memory grows with
/// updates and epochs, not with IMU steps: 8 bytes times
///   81 + 10 n a stretch between them, 2 (9 + n) + 2 a row, (9 + n)^2 + n an epoch, n the terms.
/// An hour of 21 states with a fix of three rows and an epoch a second: 24 MB, and what the vectors hold in
/// reserve.
class FilterHistory {
 public:
  /// @param states of the filter. @throws std::invalid_argument below 9 or above kMaxStates.
  explicit FilterHistory(int states);

  // Called by the filter. Sizes must be those of the record: std::invalid_argument.
  void moved(const Transition& step);
  void updated(const MeasurementRow& row, double innovation_variance, double residual, const StateVector& gain);
  /// An epoch to be smoothed: what the filter holds at this time, after what was recorded so far.
  void keep(double time, const earth::Pose& state, const StateVector& terms, const StateMatrix& P);

  [[nodiscard]] int states() const { return states_; }
  [[nodiscard]] std::size_t epochs() const { return epochs_.size(); }
  [[nodiscard]] std::size_t bytes() const;

 private:
  friend std::vector<SmoothedEpoch> smooth(const FilterHistory& record);
  struct Epoch {
    double time;
    earth::Pose state;
    std::vector<double> terms;
  };
  enum class Kind { stretch, row, epoch };
  struct Entry {
    Kind kind;
    std::size_t at;  ///< first number; of an epoch also its index
    std::size_t index = 0;
  };
  void check(Eigen::Index states) const;
  void close_stretch();

  int states_;
  std::vector<Entry> entries_;
  std::vector<double> numbers_;
  std::vector<Epoch> epochs_;
  bool moving_ = false;
  CoreMatrix core_;  ///< of the open stretch
  Eigen::Matrix<double, kCoreStates, Eigen::Dynamic, 0, kCoreStates, kMaxErrorTerms> coupling_;
  StateVector decay_;
};

struct SmoothedEpoch {
  double time = 0;         ///< of the filter [s]
  earth::Pose state;       ///< smoothed
  StateVector terms;       ///< smoothed estimates of the terms
  StateVector correction;  ///< what smoothing added, in the order of error_state.h
  StateMatrix P;           ///< covariance of what error is left; no variance above the filter's
};

/// All epochs kept, in their order. Work: states^3 a stretch, states^2 a row, 2 states^3 an epoch. The
/// difference P - P L P loses what digits the later measurements took from P: sigmas hold to 1e-6 where they
/// shrink by less than 1e4.
[[nodiscard]] std::vector<SmoothedEpoch> smooth(const FilterHistory& record);

}  // namespace gyrobudget::inline v0::navigation

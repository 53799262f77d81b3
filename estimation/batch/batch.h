// SPDX-License-Identifier: MIT
// All of a log at once: the trajectory, the sensors' errors and the aids' that fit every fix and every increment best.
//
// A filter linearises once, about what it knew when a fix came, and a smoother keeps that linearisation. Where the
// start was far off (a heading that is wrong by tens of degrees, a lever arm or a clock that shows itself late), both
// inherit it. The batch estimate is a maximum of the posterior, found by Gauss-Newton steps with a trust region (Ceres)
// over all states together, each linearised about the whole log's answer. It is the reference by which filter and
// smoother are judged, and equals the smoother where the problem is linear. It is the maximum nearest to where the
// filter ended up: that there is no better one farther away is not proved.
//
// Unknowns are pose, velocity and the walking terms of the model at nodes: every fix, every solution, and no two nodes
// farther apart than Options::longest_interval; and once for the log the terms that do not walk. The sum is
//   |prior|^2 + sum |IMU from node to node|^2 + sum loss(|fix|^2),  each whitened by its covariance,
// with the models of error_state.h, aiding.h and strapdown.h, the same as the filter's; lever arms and time tags enter
// by what is estimated of them and not to first order alone. Between nodes the IMU is integrated once (Forster et al.,
// IEEE Trans. Robotics 33:1, 2017, with Earth's rate and gravity) and again where the unknowns have moved.
// Covariances are blocks of the inverse of the information, in time linear in the log; with a robust loss each fix
// counts in them by its weight.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

#include <string>
#include <vector>

namespace gyrobudget::inline v0::batch {

/// What a fix adds to the sum, r^2 its whitened squared length and c the scale:
///   squares  r^2                       (normal errors)
///   huber    r^2 up to r = c, then 2 c r - c^2
///   cauchy   c^2 log(1 + r^2/c^2)      (Student's t; outliers lose nearly all weight)
enum class Loss { squares, huber, cauchy };

struct Options {
  Loss loss = Loss::squares;
  double scale = 3;             ///< c, in sigmas; positive
  double longest_interval = 1;  ///< between nodes [s], positive, at most 10
  int iterations = 100;         ///< at most, of the solver after each integration of the IMU; positive
  int integrations = 10;        ///< of the IMU, at most; positive
};

/// What became of one fix.
struct FixUse {
  double time = 0;      ///< at which it held [s]
  std::size_t aid = 0;  ///< number in Scenario::aids
  int rows = 0;
  double squared = 0;  ///< whitened squared residual about the estimate: near `rows` on average
  double weight = 1;   ///< derivative of the loss: 1 for squares, near 0 for an outlier
};

struct Estimate {
  enum class Status {
    estimated,
    no_filter,      ///< there is no filter's solution to begin from: `why` has its reason
    not_converged,  ///< the sum has not settled: solutions are where it stood, without meaning
    not_observable  ///< the information is singular: no covariance exists
  };
  Status status = Status::estimated;
  std::string why;  ///< in words, unless estimated

  navigation::ErrorStateModel model;
  std::vector<navigation::SensorStates::LeftOut> left_out;  ///< by the model, and by the batch beside it
  navigation::AlignmentResult alignment;
  std::vector<navigation::Solution> solutions;  ///< at k solution_interval after the alignment and at Scenario::at
  std::vector<FixUse> fixes;                    ///< in the order of time
  double first_cost = 0;                        ///< half the sum at the filter's solution
  double cost = 0;                              ///< and at the end
  int iterations = 0;                           ///< of the solver, in sum
  int integrations = 0;                         ///< of the IMU
  std::size_t nodes = 0;
};

/// Begins where navigation::navigate's filter ends up, gated fixes included in the sum. Terms that the scene says are
/// considered are estimated, and left_out says so. The same bytes for the same input.
///
///     const batch::Estimate all = batch::estimate(scenario, recording, {.loss = batch::Loss::cauchy});
///     if (all.status == batch::Estimate::Status::estimated) use(all.solutions);
///
/// A delay tau that is estimated (time_tag_sigma) moves a fix along the node's acceleration and rate: what these change
/// by within it is left out, jerk tau^3/6. For delays above some tenths of a second give the estimate as Aid::time_tag
/// and run again.
///
/// Over gaps of the IMU log sigmas grow as the filter's do. Time and memory are linear in the log: some 50 kB a node of
/// 18 states.
/// @throws as navigation::navigate; navigation::SetupError for options out of range and more than 50000 nodes.
[[nodiscard]] Estimate estimate(const navigation::Scenario& scenario, const navigation::Recording& recording,
                                const Options& options = {});

}  // namespace gyrobudget::inline v0::batch

// SPDX-License-Identifier: MIT
// One navigator with all that is wrong with it in one run: its IMU, its start and the fixes it is given.
#pragma once

#include "gyrobudget/estimation/navigation/strapdown.h"
#include "gyrobudget/noise/imu.h"
#include "gyrobudget/noise/normal.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "error_budget.h"
#include "monte_carlo.h"
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace gyrobudget::inline v0::budget {

/// What all simulated navigators of a scene share. Time runs in samples of options.imu_interval from the scene's start
/// on, which is on the pad where it has one. It keeps what it is given; copies are cheap and share one that never
/// changes.
class SimulatedScene {
 public:
  /// The arguments are those of monte_carlo().
  /// @throws navigation::SetupError as monte_carlo().
  SimulatedScene(Timeline timeline, noise::SensorModel sensor, const InitialErrors& initial,
                 const Eigen::Matrix3d& C_el, std::optional<Design> design, MonteCarlo::AidErrors aids,
                 MonteCarlo::Options options);

  [[nodiscard]] const Timeline& timeline() const { return parts_->timeline; }
  /// Samples on the pad, at rest.
  [[nodiscard]] std::size_t pad_samples() const { return sample(0); }
  /// The sample whose end is nearest to a time of the scene [s], counted from 1; 0 is the start.
  [[nodiscard]] std::size_t sample(double time) const;
  /// When a sample ends [s].
  [[nodiscard]] double time(std::size_t sample) const;
  /// What the exact IMU sums up on the timeline, sample by sample from the scene's start.
  [[nodiscard]] const std::vector<noise::ImuIncrement>& increments() const { return parts_->increments; }

 private:
  friend class SimulatedNavigator;
  /// A part of the start that is taken from a fix.
  struct Taken {
    navigation::StartFromFix from;
    Eigen::MatrixXd root;  ///< of its white noise
    int aid = 0;
  };
  struct Vectors {
    navigation::Carrier carrier;
    std::vector<Eigen::Vector3d> unit;  ///< what a unit adds to the increment of each sample
  };
  struct Parts {
    Timeline timeline;
    noise::SensorModel sensor;
    InitialErrors initial;
    Eigen::Matrix3d C_el;
    std::optional<Design> design;
    MonteCarlo::AidErrors aids;
    MonteCarlo::Options options;
    std::vector<noise::ImuIncrement> increments;
    Eigen::MatrixXd aid_root;  ///< of the aids' initial covariance
    std::vector<Taken> taken;
    std::vector<Vectors> world;

    void add_world(const Source& source);
  };
  std::shared_ptr<const Parts> parts_;
};

/// One run of it: what the IMU senses goes, with errors, into the strapdown or the filter. The truth may be
/// that of the timeline or another one near it, as in closed loop: only times of fixes, and what errors of the
/// world do to the IMU, are the timeline's. Deterministic in (seed, run). step() and use_fixes() throw what
/// navigation::Filter and navigation::Strapdown do.
///
///     SimulatedNavigator navigator(scene, run);
///     while (more) {
///       navigator.step(exact_increment);
///       if (navigator.fix_due()) navigator.use_fixes(truth);
///     }
class SimulatedNavigator {
 public:
  /// At the scene's start, coarsely aligned where that is the scene's way.
  /// @throws what noise::Imu, navigation::Filter and navigation::Strapdown do.
  SimulatedNavigator(SimulatedScene scene, std::uint64_t run);

  /// False where the alignment on the pad found no heading: it then starts as the initial errors have it.
  [[nodiscard]] bool aligned() const { return aligned_; }
  /// One sample of the exact IMU; an alignment has measured those on the pad already.
  void step(const noise::ImuIncrement& exact);
  /// At rest to time 0, with the fixes up to there.
  void pass_pad();
  [[nodiscard]] bool fix_due() const;
  /// Takes the fixes that are due, at that truth.
  void use_fixes(const earth::Motion& truth);

  [[nodiscard]] const earth::Pose& state() const { return filter_ ? filter_->state() : strapdown_->state(); }
  [[nodiscard]] const FixCount& fixes() const { return fixes_; }  ///< so far
  [[nodiscard]] const std::optional<navigation::Filter>& filter() const { return filter_; }
  [[nodiscard]] const noise::ImuIncrement& sensed() const { return sensed_; }  ///< last
  [[nodiscard]] std::size_t samples() const { return samples_; }               ///< so far
  [[nodiscard]] Saturated saturated() const;

 private:
  // Standard normal numbers one after the other.
  class Normals {
   public:
    explicit Normals(noise::StreamKey stream) : stream_(stream) {}
    double operator()();

   private:
    noise::StreamKey stream_;
    std::array<double, 64> buffer_{};
    std::size_t next_ = buffer_.size();
    std::uint64_t drawn_ = 0;
  };

  [[nodiscard]] noise::ImuIncrement measure_imu(const noise::ImuIncrement& truth, std::size_t sample);
  /// White noise is on its fixes.
  [[nodiscard]] bool noisy(int aid) const { return parts().options.noisy_aid.value_or(aid) == aid; }
  [[nodiscard]] const SimulatedScene::Parts& parts() const { return *scene_.parts_; }
  [[nodiscard]] earth::Pose wrong_start();
  void take_start(earth::Pose& state);
  [[nodiscard]] std::optional<Eigen::Quaterniond> coarse_alignment();
  void use(const navigation::PlannedFix& planned, const earth::Motion& truth);
  void move_aids();

  SimulatedScene scene_;
  Normals start_, aids_;
  noise::Imu imu_;
  std::optional<navigation::Filter> filter_;
  std::optional<navigation::Strapdown> strapdown_;
  Eigen::VectorXd aid_terms_;
  std::vector<double> world_;             ///< sizes of the scene's vectors
  std::vector<noise::ImuIncrement> pad_;  ///< as measured, where it served the alignment
  noise::ImuIncrement sensed_;
  std::size_t samples_ = 0, next_fix_ = 0;
  FixCount fixes_;
  bool aligned_ = true;
};

}  // namespace gyrobudget::inline v0::budget

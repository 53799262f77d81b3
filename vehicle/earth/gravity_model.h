// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <string>

#include <Eigen/Core>

namespace gyrobudget::inline v0::earth {

/// A gravity field of Earth from a file the user has (egm84, egm96, egm2008, ...), read and evaluated by
/// GeographicLib. Microseconds to milliseconds a call, by the degree of the model: for set-up, truth and the
/// error of normal_gravity, not for the loop. Cheap to copy; may be called from many threads.
///
///   const earth::GravityModel egm("/usr/share/GeographicLib/gravity/egm96.egm");
///   const Eigen::Vector3d error = egm.gravity(p_eb_e) - earth::normal_gravity(p_eb_e);
class GravityModel {
 public:
  /// `path` is the .egm file; its .egm.cof stands beside it. Degree and order above `highest_degree` are left
  /// out.
  /// @throws std::invalid_argument for a name that does not end in .egm.
  /// @throws std::runtime_error with GeographicLib's message where the files cannot be read.
  explicit GravityModel(const std::string& path, int highest_degree = 100000);

  /// Pull of the mass alone, in ECEF axes [m/s^2], outside the Earth.
  [[nodiscard]] Eigen::Vector3d gravitation(const Eigen::Vector3d& p_eb_e) const;
  /// What a plumb line shows: gravitation and the model's centrifugal acceleration.
  [[nodiscard]] Eigen::Vector3d gravity(const Eigen::Vector3d& p_eb_e) const;
  [[nodiscard]] std::string description() const;  ///< of the file

 private:
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

}  // namespace gyrobudget::inline v0::earth

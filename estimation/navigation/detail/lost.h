// SPDX-License-Identifier: MIT
// Inside navigation: whether the fixes still agree with the filter, and with each other.
//
// Position, velocity and height of every aid that is used are watched. A fix disagrees where the gate refuses it or its
// NIS is beyond the point that a right one passes once in a million. The filter is lost
//   by agreement    when trials (trial.h) that started at a disagreeing fix have held for kAgreeing more that disagree
//                   with the filter and for kSpan seconds, and no fix has contradicted them;
//   by refusals     when kMany of an aid's last kWindow fixes disagree, whatever they agree with;
//   by one side     when the mean of a component's last kWindow residuals, each in sigmas that the filter expects of
//                   it, is beyond kOneSided: fixes that are used, and pull one way for good.
// False alarms, with right sigmas: by agreement (1e-6)^10 a fix; by refusals C(48, 32) 1e-192; by one side, of the
// mean of 48 white residuals of unit variance, 14 sigma. They are what the rules are for where sigmas are not right:
// an aid of which three fixes in ten are wild for themselves alone passes "by refusals" once in 6e6 windows; white
// errors three times as large as told pass "by one side" once in 1e5 windows. An aid that is wrong in the same way for
// longer than kAgreeing fixes and kSpan is believed: no filter can tell that from itself.
#pragma once

#include "gyrobudget/estimation/navigation/navigate.h"

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trial.h"

namespace gyrobudget::inline v0::navigation::detail {

class LostWatch {
 public:
  static constexpr int kAgreeing = 10;
  static constexpr double kSpan = 10;  ///< [s]
  static constexpr int kWindow = 48, kMany = 32;
  static constexpr double kOneSided = 2;
  static constexpr double kDisagrees = 1e-6;

  /// The scenario must outlive it. `start` is where the filter does.
  LostWatch(const Scenario& scenario, double start);

  /// What the filter made of a fix. True where the fix disagrees.
  bool saw(std::size_t aid, double time, const Innovation& innovation);
  /// Why the filter is lost by refusals or by one side; else nothing.
  [[nodiscard]] std::optional<std::string> lost() const;
  /// When a fix of this aid was last good [s].
  [[nodiscard]] double last_good(std::size_t aid) const { return aids_[aid].last_good; }
  /// Whether an aid's fixes have agreed for so long that what did not was an outlier.
  [[nodiscard]] bool settled(std::size_t aid) const { return aids_[aid].agreed_in_row >= kAgreeing; }
  /// Another filter takes over: the past is forgotten.
  void forget(double time);

  /// Of what kind the refusal of an aid's fix is; nothing for aids that are not watched.
  [[nodiscard]] static std::optional<Refused::Kind> watched(const Aid& aid);

 private:
  struct Watched {
    std::bitset<kWindow> disagreed;
    std::array<Eigen::Vector3d, kWindow> residuals;  ///< in sigmas that were expected
    std::int64_t seen = 0;
    int agreed_in_row = 0;
    double last_good = 0;
  };
  const Scenario& scenario_;
  NisLimit limit_{kDisagrees};
  std::vector<Watched> aids_;
};

}  // namespace gyrobudget::inline v0::navigation::detail

// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string_view>

#include "ellipsoid.h"

namespace gyrobudget::inline v0::earth {

/// A place with a name.
struct Site {
  std::string_view name;  ///< as scene files write it
  Geodetic position;
};

/// Alcantara launch centre, Brazil: 2.373 S, 44.396 W. Recalled, not surveyed: good to about 0.01 degrees,
/// with the height set to 0. Give your own Geodetic where the pad itself matters.
[[nodiscard]] const Site& alcantara();

/// All named sites.
[[nodiscard]] std::span<const Site> sites();
/// The site of that name. @throws std::invalid_argument naming those there are.
[[nodiscard]] const Site& find_site(std::string_view name);

}  // namespace gyrobudget::inline v0::earth

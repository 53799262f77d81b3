// SPDX-License-Identifier: MIT
#include "site.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

namespace gyrobudget::inline v0::earth {
namespace {

constexpr std::array kSites{Site{"alcantara", {-2.373 * kDegree, -44.396 * kDegree, 0}}};

std::string names() {
  std::string all;
  for (const Site& site : kSites) all += (all.empty() ? "" : ", ") + std::string(site.name);
  return all;
}

}  // namespace

const Site& alcantara() { return kSites.front(); }

std::span<const Site> sites() { return kSites; }

const Site& find_site(std::string_view name) {
  const auto found = std::find_if(kSites.begin(), kSites.end(), [&](const Site& s) { return s.name == name; });
  if (found == kSites.end())
    throw std::invalid_argument(fmt::format("no launch site is named '{}'; there are: {}", name, names()));
  return *found;
}

}  // namespace gyrobudget::inline v0::earth

// SPDX-License-Identifier: MIT
#include "atmosphere.h"

#include "gyrobudget/noise/constants.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gyrobudget::inline v0::flight {
namespace standard_atmosphere {
namespace {

constexpr double kGas = 8314.32 / 28.9644;  // R*/M0 of the 1976 standard, which is not today's [J/(kg K)]
constexpr double kHeatRatio = 1.4;
constexpr double kRadius = 6356766;  // r0 [m]
constexpr double kLowest = -5000;    // [m]

struct Layer {
  double from;      ///< geopotential height [m]
  double gradient;  ///< [K/m]
};
constexpr std::array<Layer, kLayers + 1> kTable{{{0, -6.5e-3},
                                                 {11000, 0},
                                                 {20000, 1e-3},
                                                 {32000, 2.8e-3},
                                                 {47000, 0},
                                                 {51000, -2.8e-3},
                                                 {71000, -2e-3},
                                                 {84852, 0}}};

struct Base {
  double temperature;
  double pressure;
};

Base within(const Base& base, const Layer& layer, double above) {
  const double temperature = base.temperature + layer.gradient * above;
  const double exponent = layer.gradient == 0 ? -noise::kStandardGravity / kGas * above / base.temperature
                                              : -noise::kStandardGravity / (kGas * layer.gradient) *
                                                    std::log(temperature / base.temperature);
  return {temperature, base.pressure * std::exp(exponent)};
}

std::array<Base, kLayers> make_bases() {
  std::array<Base, kLayers> bases{};
  bases[0] = {288.15, 101325};
  for (std::size_t k = 1; k < kLayers; ++k)
    bases[k] = within(bases[k - 1], kTable[k - 1], kTable[k].from - kTable[k - 1].from);
  return bases;
}
const std::array<Base, kLayers> kBases = make_bases();

std::array<double, kLayers + 1> make_bounds() {
  std::array<double, kLayers + 1> heights{};
  for (std::size_t k = 0; k <= kLayers; ++k) heights[k] = kRadius * kTable[k].from / (kRadius - kTable[k].from);
  return heights;
}
const std::array<double, kLayers + 1> kBounds = make_bounds();

}  // namespace

const std::array<double, kLayers + 1>& bounds() { return kBounds; }

int layer(double height) {
  int k = 0;
  while (k < kLayers && height >= kBounds[static_cast<std::size_t>(k) + 1]) ++k;
  return k;
}

Air at(double height, int layer) {
  if (layer >= kLayers) return {};
  const auto k = static_cast<std::size_t>(layer);
  const double h = std::max(height, kLowest);
  const Base air = within(kBases[k], kTable[k], kRadius * h / (kRadius + h) - kTable[k].from);
  return {air.pressure, air.pressure / (kGas * air.temperature), std::sqrt(kHeatRatio * kGas * air.temperature),
          air.temperature};
}

}  // namespace standard_atmosphere

Eigen::Vector3d Wind::at(double height) const {
  Eigen::Vector3d wind = steady + Eigen::Vector3d(east(height), north(height), 0);
  const double from_peak = height - gust.height;
  if (std::abs(from_peak) < gust.half_width)
    wind += gust.peak * ((1 + std::cos(std::numbers::pi * from_peak / gust.half_width)) / 2);
  return wind;
}

bool Wind::calm() const {
  const auto still = [](const LookupTable& table) { return table.range() == std::pair(0.0, 0.0); };
  return steady.isZero(0) && still(east) && still(north) && (gust.half_width == 0 || gust.peak.isZero(0));
}

}  // namespace gyrobudget::inline v0::flight

// SPDX-License-Identifier: MIT
#include "gravity.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::earth {
namespace {

constexpr double kA = wgs84::kEquatorialRadius;
constexpr double kE2 = wgs84::kEccentricitySquared;
constexpr double kRate2 = wgs84::kEarthRate * wgs84::kEarthRate;
constexpr double kNearest = 1e6;  // [m]; the series diverges within the focal circle, 522 km
constexpr int kHighest = 12;
constexpr int kZonals = kHighest / 2;

/// q_0 and q_0' of the ellipsoid (Heiskanen & Moritz, 2-58 and 2-67 at u = b), by their series in the second
/// eccentricity: the closed forms with atan lose six digits here.
struct Shape {
  double q0, q0_prime;
};
constexpr Shape shape() {
  constexpr double ep2 = kE2 / wgs84::kAxisRatioSquared;
  double q0 = 0;
  double q0_prime = 0;
  double power = 1;  // (-e'^2)^k
  for (int k = 0; k < 12; ++k, power *= -ep2) {
    q0 += power * 2 * (k + 1) / ((2 * k + 3) * (2 * k + 5.0));
    q0_prime += power * 6 / ((2 * k + 3) * (2 * k + 5.0));
  }
  return {q0, q0_prime};  // of q_0/e'^3 and q_0'/e'^2
}

/// m = omega^2 a^2 b/GM
constexpr double kM = kRate2 * kA * kA * wgs84::kPolarRadius / wgs84::kGM;
/// J_2 = e^2/3 (1 - 2 m e'/(15 q_0)); with q_0/e'^3 it is e^2/3 - 2 m (1 - e^2)/(45 q_0/e'^3).
constexpr double kJ2 = kE2 / 3 - 2 * kM * wgs84::kAxisRatioSquared / (45 * shape().q0);

constexpr std::array<double, kZonals> zonals() {
  std::array<double, kZonals> J{};
  double power = 1;  // (-1)^(k+1) e^(2k-2)
  for (int k = 1; k <= kZonals; ++k, power *= -kE2)
    J[static_cast<std::size_t>(k - 1)] = 3 * power * (kE2 * (1 - k) + 5 * k * kJ2) / ((2 * k + 1) * (2 * k + 3));
  return J;
}
constexpr std::array<double, kZonals> kJ = zonals();

/// One even degree of the series with the recurrence of P'_n, a Gegenbauer polynomial's:
/// (n - 1) P'_n = (2n - 1) s P'_(n-1) - n P'_(n-2), divided out beforehand.
struct Step {
  double J, odd_rise, odd_fall, even_rise, even_fall;
};

constexpr std::array<Step, kZonals> steps() {
  std::array<Step, kZonals> steps{};
  for (std::size_t k = 0; k < kZonals; ++k) {
    const double n = 2.0 * static_cast<double>(k) + 2;
    steps[k] = {kJ[k], (2 * n + 1) / n, (n + 1) / n, (2 * n + 3) / (n + 1), (n + 2) / (n + 1)};
  }
  return steps;
}
constexpr std::array<Step, kZonals> kSteps = steps();

double checked_distance(const Eigen::Vector3d& p_eb_e) {
  const double r = p_eb_e.norm();
  if (!(r >= kNearest) || !std::isfinite(r))
    throw OutsideDomain(fmt::format("distance {} m from Earth's centre must be from {} m, and finite", r, kNearest));
  return r;
}

/// Gravity on the equator or at the pole (Heiskanen & Moritz, 2-73 and 2-74), m e' q_0'/q_0 by the series.
constexpr double kMRatio = kM * shape().q0_prime / shape().q0;
constexpr double kEquatorGravity = wgs84::kGM / (kA * wgs84::kPolarRadius) * (1 - kM - kMRatio / 6);
constexpr double kPoleGravity = wgs84::kGM / (kA * kA) * (1 + kMRatio / 3);

}  // namespace

Eigen::Vector3d normal_gravitation(const Eigen::Vector3d& p_eb_e) {
  const double r = checked_distance(p_eb_e);
  const double s = p_eb_e.z() / r;
  const double ratio2 = (kA / r) * (kA / r);
  double odd = 1;       // P'_(n-1), n even
  double even = 3 * s;  // P'_n
  double power = 1;     // (a/r)^n
  double radial = 0;
  double axial = 0;
  for (const Step& step : kSteps) {
    power *= ratio2;
    odd = step.odd_rise * s * even - step.odd_fall * odd;  // P'_(n+1)
    radial += step.J * power * odd;
    axial += step.J * power * even;
    even = step.even_rise * s * odd - step.even_fall * even;  // P'_(n+2)
  }
  const double pull = wgs84::kGM / (r * r);
  Eigen::Vector3d g = p_eb_e * (-pull * (1 - radial) / r);
  g.z() -= pull * axial;
  return g;
}

Eigen::Vector3d centrifugal(const Eigen::Vector3d& p_eb_e) { return {kRate2 * p_eb_e.x(), kRate2 * p_eb_e.y(), 0}; }

Eigen::Vector3d normal_gravity(const Eigen::Vector3d& p_eb_e) {
  return normal_gravitation(p_eb_e) + centrifugal(p_eb_e);
}

Eigen::Matrix3d normal_gravity_gradient(const Eigen::Vector3d& p_eb_e) {
  const double r = checked_distance(p_eb_e);
  const Eigen::Vector3d u = p_eb_e / r;
  const double s2 = u.z() * u.z();
  const double c = 1.5 * kJ2 * (kA / r) * (kA / r);
  // g = -GM/r^2 { [1 + c (1 - 5 s^2)] u + 2 c s z^ }, differentiated.
  Eigen::Matrix3d G = (3 + 5 * c * (1 - 7 * s2)) * u * u.transpose();
  G.diagonal().array() -= 1 + c * (1 - 5 * s2);
  G.col(2) += 10 * c * u.z() * u;
  G.row(2) += 10 * c * u.z() * u.transpose();
  G(2, 2) -= 2 * c;
  G *= wgs84::kGM / (r * r * r);
  G(0, 0) += kRate2;
  G(1, 1) += kRate2;
  return G;
}

double somigliana(double latitude) {
  constexpr double k = wgs84::kPolarRadius * kPoleGravity / (kA * kEquatorGravity) - 1;
  const double s2 = std::sin(latitude) * std::sin(latitude);
  return kEquatorGravity * (1 + k * s2) / std::sqrt(1 - kE2 * s2);
}

double normal_zonal(int n) {
  if (n < 2 || n > kHighest || n % 2 != 0)
    throw std::invalid_argument(fmt::format("degree {} of a normal zonal must be even, from 2 to {}", n, kHighest));
  return kJ[static_cast<std::size_t>(n / 2 - 1)];
}

}  // namespace gyrobudget::inline v0::earth

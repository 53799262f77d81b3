// SPDX-License-Identifier: MIT
#include "dispersion.h"

#include "gyrobudget/noise/normal.h"

#include <fmt/core.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::flight {
namespace {

constexpr double kFarthest = 8.57;  // sigma that a draw reaches: noise/normal.h

// Numbers of the streams; not to be changed, or seeds no longer mean the same flights.
enum class Quantity : std::uint64_t {
  impulse,
  burn_time,
  mass,
  inertia,
  axial_drag,
  normal_force,
  pressure_ahead,
  misalignment_pitch,
  misalignment_yaw,
  wind_east,
  wind_north,
  gust,
  centre_of_mass
};

struct Named {
  const char* name;
  double Dispersion::*sigma;
  bool relative;
};
constexpr std::array kAll{Named{"impulse", &Dispersion::impulse, true},
                          Named{"burn time", &Dispersion::burn_time, true},
                          Named{"mass", &Dispersion::mass, true},
                          Named{"inertia", &Dispersion::inertia, true},
                          Named{"axial drag", &Dispersion::axial_drag, true},
                          Named{"normal force", &Dispersion::normal_force, true},
                          Named{"centre of pressure", &Dispersion::pressure_ahead, false},
                          Named{"centre of mass", &Dispersion::centre_of_mass, false},
                          Named{"thrust misalignment", &Dispersion::thrust_misalignment, false},
                          Named{"wind", &Dispersion::wind, false},
                          Named{"gust", &Dispersion::gust, false}};

class Draw {
 public:
  Draw(std::uint64_t seed, std::uint64_t run) : seed_(seed), run_(run) {}
  double operator()(Quantity quantity) const {
    double x = 0;
    const std::uint64_t stream = (std::uint64_t{'V'} << 56) | (static_cast<std::uint64_t>(quantity) << 48) | run_;
    noise::fill_normal({seed_, stream}, 0, {&x, 1});
    return x;
  }

 private:
  std::uint64_t seed_, run_;
};

}  // namespace

bool Dispersion::none() const {
  for (const Named& n : kAll)
    if (this->*n.sigma != 0) return false;
  return true;
}

void Dispersion::check(const Vehicle& vehicle) const {
  for (const Named& n : kAll) {
    const double sigma = this->*n.sigma;
    if (!(sigma >= 0) || !std::isfinite(sigma))
      throw SetupError(fmt::format("dispersion of {} is {}, expected 0 or more", n.name, sigma));
    if (n.relative && sigma * kFarthest >= 1)
      throw SetupError(
          fmt::format("dispersion of {} is {}, expected below {:.3f}: draws reach {} sigma and must stay above 0",
                      n.name, sigma, 1 / kFarthest, kFarthest));
  }
  if ((1 - kFarthest * mass) * vehicle.lift_off_mass <= vehicle.propellant)
    throw SetupError(
        fmt::format("dispersion of mass is {}: {} sigma below {} kg leave less than the propellant's {} kg", mass,
                    kFarthest, vehicle.lift_off_mass, vehicle.propellant));
}

Flight disperse(const Flight& flight, const Dispersion& dispersion, std::uint64_t seed, std::uint64_t run) {
  dispersion.check(flight.vehicle);
  const Draw draw(seed, run);
  const auto factor = [&](double sigma, Quantity q) { return sigma == 0 ? 1 : 1 + sigma * draw(q); };
  const auto offset = [&](double sigma, Quantity q) { return sigma == 0 ? 0 : sigma * draw(q); };
  Flight result = flight;
  Vehicle& v = result.vehicle;
  v.specific_impulse *= factor(dispersion.impulse, Quantity::impulse);
  v.burn_time *= factor(dispersion.burn_time, Quantity::burn_time);
  v.lift_off_mass *= factor(dispersion.mass, Quantity::mass);
  if (const double f = factor(dispersion.inertia, Quantity::inertia); f != 1)
    for (LookupTable* table : {&v.roll_inertia, &v.pitch_inertia, &v.yaw_inertia}) *table = table->scaled(f);
  if (const double f = factor(dispersion.axial_drag, Quantity::axial_drag); f != 1)
    v.axial_drag = v.axial_drag.scaled(f);
  v.normal_force_slope *= factor(dispersion.normal_force, Quantity::normal_force);
  v.pressure_ahead += offset(dispersion.pressure_ahead, Quantity::pressure_ahead);
  if (const double shift = offset(dispersion.centre_of_mass, Quantity::centre_of_mass); shift != 0)
    v.centre_of_mass = v.centre_of_mass.shifted(shift);
  result.faults.thrust_misalignment +=
      Eigen::Vector2d(offset(dispersion.thrust_misalignment, Quantity::misalignment_pitch),
                      offset(dispersion.thrust_misalignment, Quantity::misalignment_yaw));
  result.world.wind.steady +=
      Eigen::Vector3d(offset(dispersion.wind, Quantity::wind_east), offset(dispersion.wind, Quantity::wind_north), 0);
  result.world.wind.gust.peak *= factor(dispersion.gust, Quantity::gust);
  return result;
}

}  // namespace gyrobudget::inline v0::flight

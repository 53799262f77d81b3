// SPDX-License-Identifier: MIT
#include <gyrobudget/vehicle/earth/frames.h>
#include <gyrobudget/vehicle/earth/gravity.h>
#include <gyrobudget/vehicle/earth/gravity_model.h>
#include <gyrobudget/vehicle/earth/paths.h>
#include <gyrobudget/vehicle/earth/sampled.h>
#include <gyrobudget/vehicle/earth/site.h>

#include <cmath>
#include <cstdio>
#include <stdexcept>

int main() {
  using namespace gyrobudget;
  const auto pad = earth::LocalFrame::launch_plane(earth::alcantara().position, 90 * earth::kDegree);
  const double up = (pad.C_el().transpose() * earth::normal_gravity(pad.p_el_e())).z();
  bool refused = false;
  try {
    const earth::GravityModel none("none.egm");  // links GeographicLib
  } catch (const std::runtime_error&) {
    refused = true;
  }
  const double gained = earth::ascent({}).increment(0, 83).velocity[0];  // (13 + 19)/2 77 + 19/2 6
  const bool sane = refused && std::abs(gained - 1289) < 1e-9 && std::abs(up + 9.7804) < 1e-3;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

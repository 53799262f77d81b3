// SPDX-License-Identifier: MIT
#include <gyrobudget/vehicle/flight/fly.h>
#include <gyrobudget/vehicle/flight/margins.h>

#include <cstdio>

int main() {
  using namespace gyrobudget;
  const flight::Flight plan;
  flight::AttitudeControl control(plan.vehicle, plan.world.site, {});
  flight::PerfectNavigator navigator;
  const flight::FlightRecord record = flight::fly(plan, control, navigator);
  const flight::Margins margins = flight::margins(plan.vehicle, control, {10, 4e5, 1500});
  const bool sane = record.ended == flight::Ended::complete && record.end.flow.height > 20e3 && margins.stable;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

// SPDX-License-Identifier: MIT
#include <gyrobudget/estimation/navigation/alignment.h>
#include <gyrobudget/estimation/navigation/strapdown.h>
#include <gyrobudget/vehicle/earth/paths.h>

#include <cstdio>

int main() {
  using namespace gyrobudget;
  const auto imu = earth::stand({}).increments(10);
  const auto aligned = navigation::align(imu, 10, {});
  const auto truth = earth::stand({}).at(0);
  navigation::Strapdown strapdown(truth.pose);
  for (const auto& increment : imu) strapdown.step(increment, 10);
  const double moved = (strapdown.state().p_eb_e - truth.pose.p_eb_e).norm();
  const bool sane = aligned.heading_observable && moved < 0.1;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

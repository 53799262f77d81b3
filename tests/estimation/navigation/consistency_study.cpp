// SPDX-License-Identifier: MIT
// How many states 1/f noise needs: NEES and NIS of the whole filter against a truth with exact 1/f.
//   consistency_study [runs]
#include <fmt/format.h>

#include <cstdlib>

#include "consistent_runs.h"

using namespace gyrobudget::consistency;  // NOLINT

namespace {

void row(const std::string& name, const Scene& scene) {
  const Verdict v = fly(scene, 1);
  fmt::print("{:28} {:6}   {:6.3f} {:5.1f} %     {:6.3f} {:5.1f} %     {:6.3f}\n", name, scene.flicker_states,
             Verdict::mean(v.navigation), 100 * Verdict::inside(v.navigation, 9, v.runs), Verdict::mean(v.bias),
             100 * Verdict::inside(v.bias, 1, 3.0 * v.runs), Verdict::mean(v.nis));
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 100;
  if (runs < 1) {
    fmt::print(stderr, "usage: consistency_study [runs]\n");
    return 2;
  }
  fmt::print("{} runs; share of epochs inside the 95 % band of the mean over runs (bias: if axes are independent)\n\n",
             runs);
  fmt::print("{:28} {:6}   {:15}     {:15}     {}\n", "scene", "states", "NEES (9)  inside", "bias (1)  inside",
             "NIS (6)");
  for (const bool fibre : {true, false})
    for (int states = 0; states <= 3; ++states)
      row(fibre ? "fibre-optic, 600 s" : "MEMS, 600 s",
          {.sensor = fibre ? fibre_optic() : mems(), .flicker_states = states, .runs = runs});
  // A band that ends long before the scene does, and no random walk to hide it; then one that begins after the second
  // over which the bias is looked at, and one that holds both.
  const struct {
    double shortest, longest;
    int states;
  } bands[] = {{0.6, 60, 3}, {36, 3600, 3}, {1, 3600, 3}, {1, 3600, 4}};
  for (const auto& band : bands) {
    Scene scene{.sensor = mems(), .duration = 3600, .outage_from = 1800, .outage_to = 1860, .runs = runs};
    scene.flicker_states = band.states;
    scene.band = band.longest;
    scene.shortest = band.shortest;
    scene.sensor.gyro.rate_random_walk = 0;
    scene.sensor.gyro.white *= 0.1;
    scene.imu_interval = 0.05;
    row(fmt::format("quiet, 3600 s, {:g} to {:g} s", band.shortest, band.longest), scene);
  }
}

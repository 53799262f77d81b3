// SPDX-License-Identifier: MIT
// From a scene with a vehicle to where its flight ends, in closed loop on its own sensors: example_fly vlm1-mems.yaml
#include <gyrobudget/app/files/scene_file.h>
#include <gyrobudget/estimation/closed_loop/study.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  using namespace gyrobudget;
  if (argc != 2) return std::fputs("usage: example_fly vlm1-mems.yaml\n", stderr), 2;
  const files::SceneFile scene = files::read_scene(argv[1]);
  if (!scene.flight) return std::printf("%s has no flight\n", argv[1]), 1;
  const auto study =
      closed_loop::study(scene.flight->plan, scene.flight->dispersion, scene.scenario, {.runs = 20, .seed = 1});
  const auto& end = study.shown();
  std::printf("ends at %.2f s, %.1f m high, %.1f m/s\n", end.end.t, end.end.flow.height, end.end.truth.v_eb_e.norm());
  const Eigen::Vector3d sigma = study.sensors.spread(&closed_loop::Outcome::position).sigma();
  std::printf("its sensors disperse it by %.1f m downrange, %.1f m crossrange, %.1f m up\n", sigma.x(), sigma.y(),
              sigma.z());
} catch (const std::exception& error) {  // says where, what was found, what was expected, and how to mend it
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}

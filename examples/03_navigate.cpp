// SPDX-License-Identifier: MIT
// From a scene with a recorded IMU log to where the vehicle was: example_navigate drive.yaml
#include <gyrobudget/app/files/scene_file.h>
#include <gyrobudget/estimation/navigation/navigate.h>
#include <gyrobudget/vehicle/earth/frames.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  using namespace gyrobudget;
  if (argc != 2) return std::fputs("usage: example_navigate drive.yaml\n", stderr), 2;
  files::SceneFile scene = files::read_scene(argv[1]);
  const files::SceneData data = files::read_recording(scene);
  const auto run = navigation::navigate(scene.scenario, data.recording);
  if (run.solutions.empty()) return std::printf("no solution: %s\n", run.why.c_str()), 1;
  const auto& end = run.solutions.back();
  const auto place = earth::to_geodetic(end.state.p_eb_e);
  std::printf("%.7f deg, %.7f deg, %.2f m after %.1f s, known to %.2f m east, %.2f m north, %.2f m up\n",
              place.latitude / earth::kDegree, place.longitude / earth::kDegree, place.height, end.time,
              end.position_sigma.x(), end.position_sigma.y(), end.position_sigma.z());
} catch (const std::exception& error) {  // says where, what was found, what was expected, and how to mend it
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}

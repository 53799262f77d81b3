// SPDX-License-Identifier: MIT
#include <gyrobudget/app/files/scene_file.h>

#include <cstdio>
#include <fstream>

int main() {
  using namespace gyrobudget;
  std::ofstream("scene.yaml") << "trajectory: static:duration=60\n";
  const auto trajectory = files::planned_trajectory(files::read_scene("scene.yaml"));
  const bool sane = trajectory.duration() == 60;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

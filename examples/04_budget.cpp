// SPDX-License-Identifier: MIT
// From a planned scene to what each source of error costs at its end: example_budget vlm1-mems.yaml
#include <gyrobudget/app/files/scene_file.h>
#include <gyrobudget/estimation/budget/study.h>

#include <cstdio>
#include <exception>

int main(int argc, char** argv) try {
  using namespace gyrobudget;
  if (argc != 2) return std::fputs("usage: example_budget vlm1-mems.yaml\n", stderr), 2;
  const files::SceneFile scene = files::read_scene(argv[1]);
  const auto study = budget::study(scene.scenario, files::planned_trajectory(scene));
  for (std::size_t i = 0; i < study.budget.lines.size(); ++i)
    std::printf("%-28s %10.4g m\n", study.budget.lines[i].name.c_str(),
                study.axes.position_sigma(study.line(i), budget::Component::rss));
  std::printf("%-28s %10.4g m\n", "total", study.axes.position_sigma(study.total(), budget::Component::rss));
} catch (const std::exception& error) {  // says where, what was found, what was expected, and how to mend it
  return std::fprintf(stderr, "%s\n", error.what()), 3;
}

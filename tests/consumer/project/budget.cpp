// SPDX-License-Identifier: MIT
#include <gyrobudget/estimation/budget/study.h>
#include <gyrobudget/vehicle/earth/paths.h>

#include <cstdio>

int main() {
  using namespace gyrobudget;
  navigation::Scenario scenario;
  scenario.sensor.gyro.white = 1e-5;
  const auto study = budget::study(scenario, earth::ascent({}));
  const double position = study.axes.position_sigma(study.total(), budget::Component::rss);
  const bool sane = position > 0.1 && position < 100 && !study.budget.lines.empty();
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

// SPDX-License-Identifier: MIT
#include <gyrobudget/estimation/closed_loop/study.h>

#include <cstdio>

int main() {
  using namespace gyrobudget;
  const auto study = closed_loop::study({}, {}, {}, {.margins = false});
  const bool sane = study.flew_to_the_end();
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

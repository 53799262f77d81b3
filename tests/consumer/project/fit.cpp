// SPDX-License-Identifier: MIT
#include <gyrobudget/allan/factors.h>
#include <gyrobudget/estimation/fit/fit.h>
#include <gyrobudget/noise/generate.h>

#include <array>
#include <cmath>
#include <cstdio>

int main() {
  using namespace gyrobudget;
  const std::array<noise::Process, 1> white{noise::White{1}};
  const auto record = noise::generate_record(white, 10000, 1, {.seed = 1, .stream = 0});
  const auto result = fit::fit(allan::overlapped_variance(record, 1, allan::octave_factors(10000)));
  const bool sane = std::abs(result[noise::Term::white].value - 1) < 0.1;
  std::printf("%s\n", sane ? "ok" : "wrong");
  return sane ? 0 : 1;
}

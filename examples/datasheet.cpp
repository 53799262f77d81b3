// SPDX-License-Identifier: MIT
// From a record to the datasheet with the library: the code of the README, which a test keeps true.
#include <gyrobudget/allan/factors.h>
#include <gyrobudget/estimation/fit/fit.h>
#include <gyrobudget/noise/generate.h>
#include <gyrobudget/noise/sensor.h>

#include <cstdio>

using namespace gyrobudget;

int main() {
  noise::ErrorModel mems;
  mems.white = noise::parse_quantity("0.15 deg/sqrt(h)", noise::parse_unit("deg/sqrt(h)").dimension);
  mems.bias_instability = noise::parse_quantity("0.70 deg/h", noise::dimension::kAngularRate);

  const double dt = 0.1;  // 10 h at 10 Hz; your record goes here
  const auto record = noise::generate_record(mems.processes(), 360000, dt, {.seed = 1, .stream = 0});
  const auto curve = allan::overlapped_variance(record, dt, allan::octave_factors(360000));
  const fit::Result datasheet = fit::fit(curve);

  for (const auto& c : datasheet.coefficients) {
    if (!c.fitted) continue;
    const auto unit = noise::datasheet_unit(noise::Signal::angular_rate, c.term);
    std::printf("%c  %s  [%s, %s]\n", static_cast<char>(c.term), noise::quantity_text(c.value, unit, 3).c_str(),
                noise::quantity_text(c.lower, unit, 3).c_str(), noise::quantity_text(c.upper, unit, 3).c_str());
  }
}

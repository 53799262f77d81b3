// SPDX-License-Identifier: MIT
// How often a navigator is lost without being told, and how soon it is found again; minutes, so no test.
//   lost_study [runs]
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "lost_runs.h"

using namespace gyrobudget::lost;  // NOLINT

namespace {

void row(const std::string& name, const Case& c) {
  const std::vector<Run> runs = drive(c);
  const auto count = [&](auto&& is) { return std::ranges::count_if(runs, is); };
  using Status = gyrobudget::navigation::Navigation::Status;
  const double from = (c.outage > 0 ? c.outage_from + c.outage : 0) + 30;
  fmt::print("{:6} {:26} {:5} {:9} {:5} {:7} {:10} {:9.1f} %\n", c.drive.name, name,
             count([](const Run& r) { return r.found.status == Status::navigated; }),
             count([](const Run& r) { return r.found.status == Status::recovered; }),
             count([](const Run& r) { return r.found.status == Status::lost; }),
             count([](const Run& r) { return r.unsaid_at >= 0; }),
             count([](const Run& r) { return r.found_after <= 30; }), 100 * nees_inside(runs, from));
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 100;
  if (runs < 1) {
    fmt::print(stderr, "usage: lost_study [runs]\n");
    return 2;
  }
  fmt::print("{} runs\n", runs);
  fmt::print("unsaid: 6 sigma of solution and fix off for 5 s, usable and not flagged; found: for good, within 30 s\n");
  fmt::print("NEES: share of epochs from 30 s after on in the 95 % band of the mean of 9\n\n");
  fmt::print("{:6} {:26} {:5} {:9} {:5} {:7} {:10} {:9}\n", "", "", "held", "recovered", "lost", "unsaid", "found 30 s",
             "NEES");
  for (const Drive& d : {kCar, kRover, kDrone}) {
    row("no outage", {.drive = d, .after = 120, .runs = runs});
    row("outage of 60 s", {.drive = d, .outage = 60, .runs = runs});
    row("outage of 300 s", {.drive = d, .outage = 300, .runs = runs});
    row("60 s, IMU told 10 x better", {.drive = d, .outage = 60, .told = 0.1, .runs = runs});
    row("start 100 m off", {.drive = d, .after = 120, .start_error = 100, .runs = runs});
    row("start 5 km off", {.drive = d, .after = 120, .start_error = 5000, .runs = runs});
  }
}

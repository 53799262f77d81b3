// SPDX-License-Identifier: MIT
// The study of the fit's accuracy by command: fit_study [RECORDS [SAMPLES [RATE_HZ [SEED]]]], 2000 36000 1 1.
#include <fmt/core.h>

#include <cmath>
#include <cstdlib>

#include "study.h"

namespace {

using namespace gyrobudget;

// RMSE in per cent of full-covariance GLS on octaves from 10 h at 1 Hz: theory section 6, row c (400 records,
// standard error 3.5 % of each).
constexpr std::array kTheoryIfog{0.429, 60.9, 6.8}, kTheoryMems{0.415, 20.5, 13.2};

void print(const char* name, const tests::Study& study, const std::array<double, 3>& theory) {
  constexpr std::array kNames{"N", "B", "K"};
  const double error = 1.96 * std::sqrt(0.95 * 0.05 / study.records);
  fmt::print("{} ({} records; coverage is known to +-{:.3f}, RMSE to +-{:.1f} %, both 95 %)\n", name,
             study.records, error, 196 / std::sqrt(2.0 * study.records));
  fmt::print("  {:<3} {:>9} {:>9} {:>12} {:>9} {:>10} {:>11} {:>11}\n", "", "bias %", "RMSE %", "theory's %",
             "bound %", "coverage", "by status", "identified");
  for (std::size_t j = 0; j < 3; ++j) {
    const auto& c = study.coefficients[j];
    fmt::print("  {:<3} {:>9.3f} {:>9.3f} {:>12.3f} {:>9.3f} {:>10.4f} {:>11.4f} {:>11.4f}\n", kNames[j],
               100 * c.bias, 100 * c.rmse, theory[j], 100 * c.bound, c.coverage, c.coverage_by_status,
               c.identified);
  }
  fmt::print(
      "  p < 0.05 in {:.4f}, p < 0.01 in {:.4f}; taus cut in {:.4f}, not described {:.4f}, unconverged "
      "{:.4f}; "
      "{:.1f} ms a fit\n\n",
      study.p_below_5_percent, study.p_below_1_percent, study.cut, study.not_described, study.unconverged,
      1e3 * study.seconds_per_fit);
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int i, double otherwise) { return argc > i ? std::atof(argv[i]) : otherwise; };
  const int records = static_cast<int>(number(1, 2000));
  const auto samples = static_cast<std::int64_t>(number(2, 36000));
  const double dt = 1 / number(3, 1);
  const auto seed = static_cast<std::uint64_t>(number(4, 1));
  if (records < 1 || samples < 16 || !(dt > 0)) {
    fmt::print(stderr, "usage: fit_study [RECORDS [SAMPLES [RATE_HZ [SEED]]]]\n");
    return 2;
  }
  print("fibre-optic gyro", tests::run_study(tests::ifog(), records, samples, dt, seed), kTheoryIfog);
  print("MEMS gyro", tests::run_study(tests::mems(), records, samples, dt, seed), kTheoryMems);
}

// SPDX-License-Identifier: MIT
// The accuracy of every method by command: fit_study [RECORDS [SAMPLES [RATE_HZ [SEED]]]], 2000 36000 1 1.
#include "gyrobudget/estimation/fit/accuracy.h"
#include "gyrobudget/noise/process.h"

#include <fmt/core.h>

#include <cmath>
#include <cstdlib>

#include "sensors.h"

namespace {

using namespace gyrobudget;

void print(const fit::MethodAccuracy& m) {
  for (const auto& c : m.coefficients) {
    fmt::print("  {:<8}{:<3} {:>8.3f} {:>9.3f} {:>8.3f} {:>8.4f} {:>9.4f} {:>10.4f} {:>12.4f} {:>11.4f}\n",
               fit::name(m.method), static_cast<char>(c.term), 100 * c.bias, 100 * c.rmse, c.rmse / c.bound,
               c.over_likelihood, c.coverage, c.coverage_by_status, c.coverage_identified, c.identified);
  }
  fmt::print(
      "  {:<8}p < 0.05 in {:.4f}, p < 0.01 in {:.4f}; false terms {:.4f}; cut {:.4f}, not described {:.4f}, unconverged {:.4f}; {:.2f} ms a fit\n",
      "", m.p_below_5_percent, m.p_below_1_percent, m.false_terms, m.cut, m.not_described, m.unconverged,
      1e3 * m.seconds_per_fit);
}

void study(const char* name, const std::vector<noise::Process>& truth, const fit::AccuracyOptions& options) {
  const fit::Accuracy accuracy = fit::measure_accuracy(truth, options);
  fmt::print("{}: {} records of {} samples at {} Hz; coverage is known to +-{:.3f}, RMSE to +-{:.1f} %, both 95 %\n",
             name, accuracy.records, accuracy.samples, 1 / accuracy.dt,
             1.96 * std::sqrt(0.95 * 0.05 / accuracy.records), 196 / std::sqrt(2.0 * accuracy.records));
  fmt::print("  {:<11} {:>8} {:>9} {:>8} {:>8} {:>9} {:>10} {:>12} {:>11}\n", "", "bias %", "RMSE %", "/bound",
             "/likel.", "coverage", "by status", "if identif.", "identified");
  for (const auto& m : accuracy.methods) print(m);
  fmt::print("  {:.1f} ms to make a record and its curve; {:.1f} s in all\n\n", 1e3 * accuracy.seconds_per_record,
             accuracy.seconds);
}

}  // namespace

int main(int argc, char** argv) {
  const auto number = [&](int i, double otherwise) { return argc > i ? std::atof(argv[i]) : otherwise; };
  fit::AccuracyOptions options;
  options.records = static_cast<int>(number(1, 2000));
  options.samples = static_cast<std::int64_t>(number(2, 36000));
  options.dt = 1 / number(3, 1);
  options.seed = static_cast<std::uint64_t>(number(4, 1));
  options.methods.assign(fit::kMethods.begin(), fit::kMethods.end());
  if (options.records < 1 || options.samples < 16 || !(options.dt > 0)) {
    fmt::print(stderr, "usage: fit_study [RECORDS [SAMPLES [RATE_HZ [SEED]]]]\n");
    return 2;
  }
  const auto mems = tests::mems();
  study("fibre-optic gyro", tests::ifog().processes(), options);
  study("MEMS gyro", mems.processes(), options);
  study("MEMS gyro without bias instability", {noise::White{mems.n}, noise::RateRandomWalk{mems.k}}, options);
}

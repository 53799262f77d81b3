// SPDX-License-Identifier: MIT
#include "study.h"

#include "gyrobudget/allan/factors.h"
#include "gyrobudget/fit/fit.h"
#include "gyrobudget/fit/information.h"
#include "gyrobudget/noise/generate.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <vector>

namespace gyrobudget::tests {
namespace {

using noise::Term;
constexpr std::array kTerms{Term::white, Term::flicker, Term::rate_random_walk};

struct One {
  std::array<fit::Coefficient, 3> coefficients;
  double p_value = 0, seconds = 0;
  bool cut = false, described = false, converged = false;
};

One one_record(const Gyro& gyro, const allan::CurveCovariance& covariance, std::int64_t samples, double dt,
               noise::StreamKey key) {
  const auto record = noise::generate_record(gyro.processes(), samples, dt, key);
  const auto curve = allan::overlapped_variance(record, dt, covariance.factors());
  const fit::Result result = fit::fit(curve, covariance);
  One one;
  for (std::size_t j = 0; j < kTerms.size(); ++j) one.coefficients[j] = result[kTerms[j]];
  one.p_value = result.p_value;
  one.seconds = result.seconds;
  one.cut = !result.moved.empty();
  one.described = result.verdict != fit::Verdict::not_described;
  one.converged = result.converged;
  return one;
}

bool covers(const fit::Coefficient& c, double truth) {
  return c.lower <= truth && truth <= c.upper_two_sided;
}
bool covers_by_status(const fit::Coefficient& c, double truth) {
  return c.lower <= truth && truth <= c.upper;
}

}  // namespace

Study run_study(const Gyro& gyro, int records, std::int64_t samples, double dt, std::uint64_t seed) {
  const std::array truth{gyro.n, gyro.b, gyro.k};
  const allan::CurveCovariance covariance(samples, allan::octave_factors(samples), dt,
                                          {noise::White{1}, noise::Flicker{1}, noise::RateRandomWalk{1}});
  std::vector<One> all(static_cast<std::size_t>(records));
  tbb::parallel_for(std::size_t{0}, all.size(), [&](std::size_t i) {
    all[i] = one_record(gyro, covariance, samples, dt, {seed, i});
  });

  Study study;
  study.records = records;
  const double share = 1.0 / records;
  const Eigen::VectorXd bound = fit::relative_bound(gyro.processes(), samples, dt);
  for (const One& one : all) {
    for (std::size_t j = 0; j < truth.size(); ++j) {
      const fit::Coefficient& c = one.coefficients[j];
      CoefficientStudy& s = study.coefficients[j];
      const double error = c.value / truth[j] - 1;
      s.bias += share * error;
      s.rmse += share * error * error;
      s.coverage += share * covers(c, truth[j]);
      s.coverage_by_status += share * covers_by_status(c, truth[j]);
      s.identified += share * (c.status == fit::Status::identified);
    }
    study.p_below_5_percent += share * (one.p_value < 0.05);
    study.p_below_1_percent += share * (one.p_value < 0.01);
    study.cut += share * one.cut;
    study.not_described += share * !one.described;
    study.unconverged += share * !one.converged;
    study.seconds_per_fit += share * one.seconds;
  }
  for (std::size_t j = 0; j < truth.size(); ++j) {
    study.coefficients[j].rmse = std::sqrt(study.coefficients[j].rmse);
    study.coefficients[j].bound = bound(static_cast<Eigen::Index>(j));
  }
  return study;
}

}  // namespace gyrobudget::tests

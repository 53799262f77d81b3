// SPDX-License-Identifier: MIT
#include "fixtures.h"

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

namespace gyrobudget::fixtures {
namespace {

using allan::DeviationPoint;
using noise::Signal;
using noise::Term;
using report::AxisResult;
using report::LogResult;

constexpr double kDegree = std::numbers::pi / 180, kHour = 3600, kMicroG = 9.80665e-6;
constexpr double kDegPerHour = kDegree / kHour, kDegPerRootHour = kDegree / 60, kDegPerHourRootHour = kDegPerHour / 60;
constexpr double kTurn = 2.399963;  // golden angle: a wiggle without period

struct Truth {
  double n = 0, b = 0, k = 0;
  /// Asymptotes of IEEE Std 952.
  [[nodiscard]] double deviation(double tau) const {
    return std::sqrt(n * n / tau + 2 * std::numbers::ln2 / std::numbers::pi * b * b + k * k * tau / 3);
  }
};

constexpr Truth kMems = {0.15 * kDegPerRootHour, 0.70 * kDegPerHour, 4.32 * kDegPerHourRootHour};

using Disturbance = std::function<double(double tau)>;  ///< factor on the deviation
double none(double) { return 1; }

/// Degrees of freedom of the overlapped estimator for white noise (NIST SP 1065): near enough for a picture.
double degrees_of_freedom(double samples, double m) {
  const double n = samples + 1;
  const double edf = (3 * (n - 1) / (2 * m) - 2 * (n - 2) / n) * 4 * m * m / (4 * m * m + 5);
  return std::max(1.0, edf);
}

/// Quantile of chi-square over its degrees of freedom (Wilson and Hilferty).
double chi_square_ratio(double edf, double z) {
  const double a = 2 / (9 * edf);
  return std::pow(std::max(0.05, 1 - a + z * std::sqrt(a)), 3);
}

DeviationPoint point(const Truth& truth, std::int64_t samples, double rate, std::int64_t m, const Disturbance& factor) {
  constexpr double kTwoSided = 1.96;
  allan::DeviationPoint p;
  p.m = m;
  p.tau_s = static_cast<double>(m) / rate;
  p.edf = degrees_of_freedom(static_cast<double>(samples), static_cast<double>(m));
  const double wiggle = 0.8 * std::sin(kTurn * std::log2(static_cast<double>(m))) / std::sqrt(2 * p.edf);
  p.deviation = truth.deviation(p.tau_s) * factor(p.tau_s) * (1 + wiggle);
  p.lower = p.deviation / std::sqrt(chi_square_ratio(p.edf, kTwoSided));
  p.upper = p.deviation / std::sqrt(chi_square_ratio(p.edf, -kTwoSided));
  p.terms = samples - 2 * m + 1;
  return p;
}

AxisResult curve(std::string name, Signal signal, const Truth& truth, std::int64_t samples, double rate,
                 const Disturbance& factor = none) {
  AxisResult axis;
  axis.name = std::move(name);
  axis.signal = signal;
  std::int64_t last = 0;
  constexpr double kPerDecade = 14;
  for (int i = 0;; ++i) {
    const auto m = static_cast<std::int64_t>(std::llround(std::pow(10.0, i / kPerDecade)));
    if (2 * m > samples) break;
    if (m != last) axis.points.push_back(point(truth, samples, rate, m, factor));
    last = m;
  }
  return axis;
}

fit::Coefficient coefficient(Term term, double value, double relative_std) {
  fit::Coefficient c;
  c.term = term;
  c.value = value;
  c.lower = value * std::max(0.0, 1 - 2 * relative_std);
  c.upper = c.upper_two_sided = value * (1 + 2.05 * relative_std);
  c.relative_std = relative_std;
  c.boundary_test = 1 / (relative_std * relative_std);
  c.status = fit::Status::identified;
  c.fitted = true;
  return c;
}

fit::Coefficient at_zero(Term term, double upper, fit::Status status) {
  fit::Coefficient c;
  c.term = term;
  c.upper = c.upper_two_sided = upper;
  c.relative_std = std::numeric_limits<double>::infinity();
  c.status = status;
  c.fitted = true;
  return c;
}

fit::Coefficient not_fitted(Term term) {
  fit::Coefficient c;
  c.term = term;
  return c;
}

/// The fit that gave `model` back, on octaves.
fit::Result fit_of(const AxisResult& axis, const Truth& truth, const Truth& model, std::int64_t samples, double rate,
                   const Disturbance& factor = none) {
  fit::Result fit;
  fit.coefficients = {not_fitted(Term::quantization), coefficient(Term::white, model.n, 3.75e-4),
                      coefficient(Term::flicker, model.b, 0.166), coefficient(Term::rate_random_walk, model.k, 0.126),
                      not_fitted(Term::rate_ramp)};
  fit.fitted_terms = {Term::white, Term::flicker, Term::rate_random_walk};
  fit.covariance = Eigen::MatrixXd::Zero(3, 3);
  for (int i = 0; i < 3; ++i) {
    const auto& c = fit.coefficients[static_cast<std::size_t>(i) + 1];
    fit.covariance(i, i) = std::pow(c.value * c.relative_std, 2);
  }
  for (std::int64_t m = 1; 2 * m <= samples; m *= 2) {
    const allan::DeviationPoint p = point(truth, samples, rate, m, factor);
    const double expected = model.deviation(p.tau_s);
    fit.residuals.push_back(
        {m, p.tau_s, p.deviation, expected, 1 / std::sqrt(2 * p.edf), p.deviation / expected - 1, true});
  }
  fit.tau_min_s = fit.residuals.front().tau_s;
  fit.tau_max_s = fit.residuals.back().tau_s;
  fit.chi2 = 14.2;
  fit.dof = 14;
  fit.p_value = 0.4341;
  fit.verdict = fit::Verdict::described;
  fit.minimum_deviation = std::numeric_limits<double>::infinity();
  for (const allan::DeviationPoint& p : axis.points) {
    if (p.m * 10 > samples || p.deviation >= fit.minimum_deviation) continue;
    fit.minimum_deviation = p.deviation;
    fit.minimum_tau_s = p.tau_s;
  }
  fit.beta = model.n > 0 && model.k > 0 ? model.b * model.b / (model.n * model.k) : 0;
  fit.converged = true;
  fit.iterations = 9;
  fit.seconds = 0.021;
  return fit;
}

LogResult record(std::string source, double rate, std::int64_t samples) {
  LogResult result;
  result.command = "gyrobudget calibrate " + source + " --report datasheet.html";
  result.source = std::move(source);
  result.rate_hz = rate;
  result.samples = samples;
  return result;
}

void cut(fit::Result& fit, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) fit.residuals[i].used = false;
  fit.tau_min_s = fit.residuals[count].tau_s;
}

}  // namespace

LogResult mems() {
  constexpr double kRate = 100;
  constexpr std::int64_t kSamples = 3600000;
  LogResult result = record("mems_10h.csv", kRate, kSamples);
  AxisResult axis = curve("gyro_x", Signal::angular_rate, kMems, kSamples, kRate);
  axis.mean = 12.3 * kDegPerHour;
  axis.fit = fit_of(axis, kMems, kMems, kSamples, kRate);
  axis.advice = {"B is known to 17 % (one sigma). For 10 %, record 27.4 h at the same rate.",
                 "The mean of 12.3 deg/h holds the part of the Earth's rate along this axis."};
  result.axes.push_back(std::move(axis));
  return result;
}

LogResult mems_curve_only() {
  LogResult result = mems();
  result.command = "gyrobudget allan mems_10h.csv";
  result.axes.front().fit.reset();
  result.axes.front().advice.clear();
  return result;
}

LogResult not_described() {
  constexpr double kRate = 50;
  constexpr std::int64_t kSamples = 360000;
  const Disturbance hump = [](double tau) { return 1 + 4.2 * std::exp(-std::pow(std::log(tau / 3.0), 2)); };
  LogResult result = record("rlg_vehicle_counts.csv", kRate, kSamples);
  result.missing_samples = 1234;
  result.notes = {"1234 samples are not numbers (0.34 %); they were masked, and the statistics allow for it."};
  const Truth truth = {2e-3 * kDegPerRootHour, 5e-3 * kDegPerHour, 3e-2 * kDegPerHourRootHour};
  AxisResult axis = curve("rate", Signal::angular_rate, truth, kSamples, kRate, hump);
  axis.fit = fit_of(axis, truth, {3e-3 * kDegPerRootHour, 4e-2 * kDegPerHour, 2e-1 * kDegPerHourRootHour}, kSamples,
                    kRate, hump);
  axis.fit->chi2 = 41234.5;
  axis.fit->p_value = 0;
  axis.fit->worst_misfit = 2.6;
  axis.fit->worst_misfit_tau_s = 2.56;
  axis.fit->verdict = fit::Verdict::not_described;
  axis.advice = {"The record was not taken at rest, or a periodic disturbance is in it: record again on a pier."};
  result.axes.push_back(std::move(axis));
  return result;
}

LogResult accelerometer() {
  constexpr double kRate = 200;
  constexpr std::int64_t kSamples = 4320000;
  const Truth truth = {0.02 / 60, 12 * kMicroG, 20 * kMicroG / 60};
  const Disturbance filter = [](double tau) { return 1 - 0.22 * std::exp(-tau / 0.008); };
  LogResult result = record("imu.csv", kRate, kSamples);
  AxisResult axis = curve("acc_z", Signal::specific_force, truth, kSamples, kRate, filter);
  axis.mean = -9.8066;
  axis.fit = fit_of(axis, truth, truth, kSamples, kRate, filter);
  axis.fit->p_value = 8e-6;
  axis.fit->verdict = fit::Verdict::described_within;
  axis.fit->worst_misfit = 0.031;
  axis.fit->worst_misfit_tau_s = 0.04;
  axis.fit->moved = {
      {Term::white, 0.0203 / 60, truth.n}, {Term::flicker, 0, truth.b}, {Term::rate_random_walk, truth.k, truth.k}};
  cut(*axis.fit, 3);
  axis.advice = {"The output filter of the sensor shows below 0.04 s."};
  result.axes.push_back(std::move(axis));
  return result;
}

LogResult bounded() {
  constexpr double kRate = 10;
  constexpr std::int64_t kSamples = 360000;
  const Truth truth = {5.4e-4 * kDegPerRootHour, 0, 0};
  LogResult result = record("ifog.csv", kRate, kSamples);
  AxisResult axis = curve("ifog", Signal::angular_rate, truth, kSamples, kRate);
  axis.fit = fit_of(axis, truth, truth, kSamples, kRate);
  axis.fit->coefficients[2] = at_zero(Term::flicker, 1.42e-3 * kDegPerHour, fit::Status::upper_bound);
  axis.fit->coefficients[3] = at_zero(Term::rate_random_walk, 1.1e-5 * kDegPerHourRootHour, fit::Status::left_out);
  axis.fit->covariance(1, 1) = axis.fit->covariance(2, 2) = std::numeric_limits<double>::quiet_NaN();
  result.axes.push_back(std::move(axis));
  return result;
}

LogResult imu() {
  constexpr double kRate = 100;
  constexpr std::int64_t kSamples = 3600000;
  LogResult result = record("imu_six_axes.csv", kRate, kSamples);
  const std::array<const char*, 3> letters = {"x", "y", "z"};
  for (std::size_t i = 0; i < letters.size(); ++i) {
    const double scale = 1 + 0.4 * static_cast<double>(i);
    const Truth truth = {kMems.n * scale, kMems.b, kMems.k / scale};
    AxisResult axis = curve(std::string("gyro_") + letters[i], Signal::angular_rate, truth, kSamples, kRate);
    axis.fit = fit_of(axis, truth, truth, kSamples, kRate);
    result.axes.push_back(std::move(axis));
  }
  for (std::size_t i = 0; i < letters.size(); ++i) {
    const double scale = 1 + 0.3 * static_cast<double>(i);
    const Truth truth = {0.03 / 60 * scale, 15 * kMicroG, 40 * kMicroG / 60 * scale};
    AxisResult axis = curve(std::string("acc_") + letters[i], Signal::specific_force, truth, kSamples, kRate);
    axis.fit = fit_of(axis, truth, truth, kSamples, kRate);
    result.axes.push_back(std::move(axis));
  }
  return result;
}

LogResult hostile_names() {
  LogResult result = mems();
  result.source = "a</script><b>\"it's\"&`touch trap`$(touch trap).csv";
  result.command = "gyrobudget calibrate '</script><b>' {{script}} --report x.html";
  result.notes = {"<img src=x onerror=alert(1)> \\ \t tab, newline\nhere, bad UTF-8 \xff\xfe, \xe2\x80\xa8 separator"};
  result.axes.front().name = "gyro_{x}^2</script><b>'; set output '/tmp/trap'; `touch trap`";
  result.axes.front().advice = {"<script>alert(1)</script>"};
  return result;
}

}  // namespace gyrobudget::fixtures

// SPDX-License-Identifier: MIT
#include "dst.h"

#include "gyrobudget/noise/fft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::fit {
namespace {

using std::numbers::pi;

constexpr double square(double x) { return x * x; }

// int_0^inf v^2 e^-v/(a^2 + v^2) dv for a = pi k, k whole and at least 1: 1 - a f(a) with f the auxiliary function of
// the sine integral. Below k = 10 by table (quadrature), above by its asymptotic series, relative error 2e-7.
double end_integral(double k) {
  constexpr std::array kTable{0.0,
                              0.116770363125825,
                              0.0409047454207452,
                              0.0201485090692208,
                              0.0118421748920105,
                              0.00775121902017551,
                              0.00545284420255929,
                              0.00403867942014473,
                              0.00310876850797,
                              0.0024655249808617};
  if (k < static_cast<double>(kTable.size())) return kTable[static_cast<std::size_t>(k)];
  const double z = 1 / square(pi * k);
  return z * (2 - z * (24 - z * (720 - z * (40320 - z * 3628800))));
}

// (-1)^k at whole k, 0 between.
double parity(double k) {
  if (k != std::floor(k)) return 0;
  return std::fmod(k, 2) == 0 ? 1 : -1;
}

double flicker_variance(double b, double k, double n) {
  const double half = pi * k / (2 * n), s = std::sin(half), c = std::cos(half);
  const double sign = parity(k);
  const double ends = 1 + square(s) / c * std::log(std::tan(0.5 * half)) - (sign == 0 ? 0 : sign * end_integral(k));
  return 2 * square(b) * (s - ends / (pi * n));
}

double gauss_markov_variance(const noise::GaussMarkov& p, double k, double n, double dt) {
  const double a = dt / p.correlation_time, decay = -std::expm1(-a), phi = std::exp(-a);
  const double s = std::sin(pi * k / (2 * n)), sin_theta = std::sin(pi * k / n);
  const double D = square(decay) + 4 * phi * square(s);
  const double stationary = 4 * square(s) * -std::expm1(-2 * a) / D;
  const double ends = 4 / n * phi * square(decay * sin_theta / D) * (1 - parity(k) * std::exp(-a * n));
  return square(p.sigma) * (stationary - ends);
}

}  // namespace

std::vector<double> sine_transform_of_differences(std::span<const double> rate) {
  const std::size_t n = rate.size();
  const auto difference = [&](std::size_t j) { return rate[j] - rate[j - 1]; };
  const double scale = std::sqrt(2.0 / static_cast<double>(n));
  std::vector<double> mixed(n, 0.0);
  for (std::size_t j = 1; 2 * j <= n; ++j) {
    const double a = difference(j), b = difference(n - j);
    const double even = scale * std::sin(pi * static_cast<double>(j) / static_cast<double>(n)) * (a + b);
    const double odd = 0.5 * scale * (a - b);
    mixed[j] = even + odd;
    mixed[n - j] = even - odd;
  }
  const auto spectrum = noise::real_spectrum(mixed);
  std::vector<double> c(n - 1);  // c[k-1]
  double sum = 0.5 * spectrum[0].real();
  for (std::size_t k = 0; k < n / 2; ++k) {
    if (k > 0) {
      sum += spectrum[k].real();
      c[2 * k - 1] = -spectrum[k].imag();
    }
    c[2 * k] = sum;
  }
  return c;
}

double sine_variance(const noise::Process& process, double k, std::int64_t samples, double dt) {
  const auto n = static_cast<double>(samples);
  const double s2 = square(std::sin(pi * k / (2 * n)));
  switch (noise::term(process)) {
    case noise::Term::white:
      return 4 * square(noise::coefficient(process)) * s2 / dt;
    case noise::Term::rate_random_walk:
      return square(noise::coefficient(process)) * dt;
    case noise::Term::quantization:
      return 16 * square(noise::coefficient(process) / dt) * s2 * (s2 + (1 - s2) / n);
    case noise::Term::flicker:
      return flicker_variance(noise::coefficient(process), k, n);
    case noise::Term::gauss_markov:
      return gauss_markov_variance(std::get<noise::GaussMarkov>(process), k, n, dt);
    default:
      throw std::invalid_argument(
          fmt::format("term {} is a mean and has no variance", static_cast<char>(noise::term(process))));
  }
}

double sine_mean_of_ramp(std::int64_t k, std::int64_t n, double dt) {
  if (k % 2 == 0) return 0;
  const auto count = static_cast<double>(n);
  return std::sqrt(2 / count) * dt / std::tan(pi * static_cast<double>(k) / (2 * count));
}

std::array<double, 2> sine_mean_of_line(std::int64_t k, std::int64_t n, double w) {
  // Differences of e^{iwj} are 2i sin(w/2) e^{iw(j-1/2)}; sum_j e^{iaj}, j = 1 .. n-1, is a geometric series.
  using Complex = std::complex<double>;
  const auto count = static_cast<double>(n);
  const auto series = [&](double a) {
    const double below = std::sin(0.5 * a);
    const double gain = std::abs(below) < 1e-12 ? count - 1 : std::sin(0.5 * a * (count - 1)) / below;
    return std::polar(1.0, 0.5 * a * count) * gain;
  };
  const double theta = pi * static_cast<double>(k) / count;
  const Complex sines = std::polar(1.0, -0.5 * w) * (series(w + theta) - series(w - theta)) / Complex(0, 2);
  const Complex c = std::sqrt(2 / count) * Complex(0, 2 * std::sin(0.5 * w)) * sines;
  return {c.real(), c.imag()};
}

}  // namespace gyrobudget::inline v0::fit

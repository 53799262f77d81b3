// SPDX-License-Identifier: MIT
#include "lag_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <variant>

namespace gyrobudget::inline v0::allan::detail {
namespace {

using std::numbers::pi;

constexpr double square(double x) { return x * x; }
constexpr double cube(double x) { return x * x * x; }

/// The factors as numbers, and what C(u) is scaled by.
struct Lengths {
  double m1, m2, dt, scale;
  explicit Lengths(const Pair& pair)
      : m1(static_cast<double>(pair.m1)), m2(static_cast<double>(pair.m2)), dt(pair.dt), scale(1 / (2 * m1 * m2)) {}
};

/// Second difference over m2 of an even function of the lag.
template <typename Inner>
double across(const Lengths& l, double u, Inner inner) {
  return inner(u + l.m2) - 2 * inner(u) + inner(std::abs(u - l.m2));
}

template <typename Kernel>
void fill(std::span<const double> u, std::span<double> c, Kernel kernel) {
  std::transform(u.begin(), u.end(), c.begin(), kernel);
}

// Below, `inner(x)` is the second difference over m1 of R/dt^2 at lag x >= 0, less a constant that the second
// difference over m2 removes, and w = max(0, m1 - x).

// --- White: R/dt^2 = -|h| / (2 dt) ---

void kernel(const noise::White&, const Lengths& l, std::span<const double> u, std::span<double> c) {
  const auto inner = [&](double x) { return std::max(0., l.m1 - x); };
  fill(u, c, [&, scale = -l.scale / l.dt](double lag) { return scale * across(l, lag, inner); });
}

// --- White behind a filter: R/dt^2 = (memory(|h|) - |h| / 2) / dt ---

void kernel(const noise::FilteredWhite& process, const Lengths& l, std::span<const double> u, std::span<double> c) {
  const noise::SampledFrontEnd filter(process.front_end, l.dt);
  const auto inner = [&](double x) {
    const double memory = filter.memory(x + l.m1) - 2 * filter.memory(x) + filter.memory(std::abs(x - l.m1));
    return memory - std::max(0., l.m1 - x);
  };
  fill(u, c, [&, scale = l.scale / l.dt](double lag) { return scale * across(l, lag, inner); });
}

// --- Random walk: R/dt^2 = dt (|h|^3 - |h|) / 12, so that inner = dt (m1^2 x / 2 + (w^3 - w) / 6) ---

void kernel(const noise::RateRandomWalk&, const Lengths& l, std::span<const double> u, std::span<double> c) {
  const auto near = [&](double x) {
    const double w = std::max(0., l.m1 - x);
    return (cube(w) - w) / 6;
  };
  fill(u, c, [&, scale = l.scale * l.dt](double lag) {
    return scale * (square(l.m1) * std::max(0., l.m2 - lag) + across(l, lag, near));
  });
}

// --- Quantization: R/dt^2 = [h = 0] / dt^2 ---

void kernel(const noise::Quantization&, const Lengths& l, std::span<const double> u, std::span<double> c) {
  const auto inner = [&](double x) { return (x == l.m1 ? 1. : 0.) - (x == 0 ? 2. : 0.); };
  fill(u, c, [&, scale = l.scale / square(l.dt)](double lag) { return scale * across(l, lag, inner); });
}

// --- Flicker: R/dt^2 = (4 h^2 - 1) h_|h| / (4 pi) = (4 h^2 - 1) (ln h + r(h)) / (8 pi) up to a quadratic ---

/// r(x) = psi(x + 1/2) - ln x for x >= kSmooth, from the Bernoulli numbers; relative error of R below 1e-16.
double digamma_remainder(double x) {
  const double z = 1 / square(x);
  return z * (1. / 24 + z * (-7. / 960 + z * (31. / 8064 + z * (-127. / 30720))));
}

/// R at whole lags below kSmooth, where the asymptotic series does not serve.
const std::array<double, kSmooth>& flicker_table() {
  static const std::array<double, kSmooth> table = [] {
    std::array<double, kSmooth> r{};
    double shifted = -(std::numbers::egamma + 2 * std::numbers::ln2) / 2;  // h_0 less what makes ln h + r(h)
    for (std::size_t h = 0; h < r.size(); ++h) {
      const auto lag = static_cast<double>(h);
      r[h] = (4 * square(lag) - 1) * shifted / (4 * pi);
      shifted += 1 / (2 * lag + 1);
    }
    return r;
  }();
  return table;
}

double flicker_phase_covariance(double x) {
  if (x < kSmooth) return flicker_table()[static_cast<std::size_t>(x)];
  return (4 * square(x) - 1) * (std::log(x) + digamma_remainder(x)) / (8 * pi);
}

/// The second difference over m << x, part by part of 8 pi R = 4 x^2 ln x - ln x + 1/6 - 17/(240 x^2) + ...:
/// the first from its derivatives, sum_k 2 m^(2k) / (2k)! f^(2k) with (x^2 ln x)^(2k) = -2 (2k-3)! / x^(2k-2), the
/// second in closed form. Relative error below 1e-13 for x >= kFar m and x >= kFarLag.
constexpr double kFar = 16, kFarLag = 64;
double flicker_far(double m, double x) {
  const double q = square(m / x), z = 1 / square(x);
  const double first = 2 * std::log(x) + 3 - q * (1. / 6 + q * (1. / 30 + q * (1. / 84 + q / 180)));
  const double rest = z * z * (-17. / 40 * (1 + 5. / 3 * q) + 0.4534 * z);
  return square(m) * (first / (2 * pi) + rest / (8 * pi)) - std::log1p(-q) / (8 * pi);
}

/// Both second differences at once for m1, m2 << u, where the logarithms of flicker_far would cancel:
/// sum_ij 4 m1^(2i) m2^(2j) / (2i)! / (2j)! R^(2i+2j)(u). Relative error below 1e-9 for u >= kVeryFar m2, kFarLag.
constexpr double kVeryFar = 16;
double flicker_very_far(double m1, double m2, double u) {
  const double p = square(m1 / u), q = square(m2 / u), sum = p + q, z = 1 / square(u);
  const double order6 = sum / 2, order8 = 120 * ((p * p + q * q) / 360 + p * q / 144);
  const double order10 = 5040 * ((p * p * p + q * q * q) / 20160 + p * q * sum / 4320);
  const double rest = z * (-0.75 - 1.25 * sum + 1.0625 * z);
  return -square(m1 * m2 / u) / pi * (1 + order6 + order8 + order10 + rest);
}

void kernel(const noise::Flicker&, const Lengths& l, std::span<const double> u, std::span<double> c) {
  const double far = std::max(kFar * l.m1, kFarLag);
  const double very_far = std::max(kVeryFar * l.m2, kFarLag);
  const auto near = [&](double x) {
    return flicker_phase_covariance(x + l.m1) - 2 * flicker_phase_covariance(x) +
           flicker_phase_covariance(std::abs(x - l.m1));
  };
  const auto inner = [&](double x) { return x >= far ? flicker_far(l.m1, x) : near(x); };
  fill(u, c, [&](double lag) {
    return l.scale * (lag >= very_far ? flicker_very_far(l.m1, l.m2, lag) : across(l, lag, inner));
  });
}

// --- Gauss-Markov: with a = dt/Tc, phi = e^-a, b = phi/(1-phi)^2, L = 2 b (sinh a - a)
//     R/dt^2 = -L |h| / 2 - b (e^(-a|h|) - 1 + a |h|)
//     inner  = -L w - b [4 sinh^2(a m1 / 2) e^(-a x) - 2 (sinh(a w) - a w)] ---

/// sinh(z) - z for 0 <= z <= 1.
double sinh_excess(double z) {
  const double q = square(z);
  return z * q / 6 * (1 + q / 20 * (1 + q / 42 * (1 + q / 72 * (1 + q / 110 * (1 + q / 156)))));
}

/// e^(a x) times the second difference over m of e^(-a|h|), at x >= m, without overflow: (1 - e^(-a m))^2 e^(a m).
double decay_at(double a, double m, double x) { return square(std::expm1(-a * m)) * std::exp(-a * (x - m)); }

void kernel(const noise::GaussMarkov& process, const Lengths& l, std::span<const double> u, std::span<double> c) {
  const double a = l.dt / process.correlation_time, phi = std::exp(-a), b = phi / square(std::expm1(-a));
  const double L = a < 1 ? 2 * b * sinh_excess(a) : (1 - square(phi) - 2 * a * phi) / square(1 - phi);
  const double growth = 4 * square(std::sinh(a * std::min(l.m1, 1 / a) / 2));

  const auto slow = [&](double x) {  // a m1 <= 1
    const double w = std::max(0., l.m1 - x);
    return -L * w - b * (growth * std::expm1(-a * x) - 2 * sinh_excess(a * w));
  };
  const auto fast = [&](double x) {
    if (x >= l.m1) return -b * decay_at(a, l.m1, x);
    const double w = l.m1 - x;
    return -(L + 2 * a * b) * w - b * (std::exp(-a * w) - 2 * std::exp(-a * x) + std::exp(-a * (l.m1 + x)));
  };
  const double end = l.m1 + l.m2;
  const double tail = -b * square(std::expm1(-a * l.m1)) * square(std::expm1(-a * l.m2));
  fill(u, c, [&](double lag) {
    if (lag >= end) return l.scale * tail * std::exp(-a * (lag - end));
    return l.scale * (a * l.m1 <= 1 ? across(l, lag, slow) : across(l, lag, fast));
  });
}

// --- Means ---

void kernel(const noise::RateRamp&, const Lengths& l, std::span<const double>, std::span<double> c) {
  std::fill(c.begin(), c.end(), l.m1 * l.m2 * square(l.dt) / 2);
}

void kernel(const noise::Sinusoid& process, const Lengths& l, std::span<const double> u, std::span<double> c) {
  const double cycles = std::abs(std::remainder(process.frequency * l.dt, 1.0));  // per sample, as it appears
  const auto amplitude = [&](double m) {                                          // root of the Allan variance
    if (cycles == 0) return 0.;
    return square(std::sin(pi * std::remainder(cycles * m, 1.0))) / (m * std::sin(pi * cycles));
  };
  fill(u, c, [&, product = amplitude(l.m1) * amplitude(l.m2)](double lag) {
    return product * std::cos(2 * pi * std::remainder(cycles * lag, 1.0));
  });
}

}  // namespace

void lag_kernel(const noise::Process& process, const Pair& pair, std::span<const double> u, std::span<double> c) {
  std::visit([&, lengths = Lengths(pair)](const auto& p) { kernel(p, lengths, u, c); }, process);
}

bool deterministic(const noise::Process& process) {
  return std::holds_alternative<noise::RateRamp>(process) || std::holds_alternative<noise::Sinusoid>(process);
}

}  // namespace gyrobudget::inline v0::allan::detail

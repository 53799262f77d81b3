// SPDX-License-Identifier: MIT
#include "process.h"

#include "gyrobudget/noise/detail/check.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace gyrobudget::inline v0::noise {

using detail::require;
using detail::require_interval;

namespace {

using std::numbers::pi;

constexpr double square(double x) { return x * x; }

// --- Special functions ------------------------------------------------------------------------------------- --------

/// psi(n + 1/2) - ln n for n >= kAsymptotic, from the Bernoulli numbers; next term below 1e-16.
double digamma_remainder(double n) {
  const double z = 1 / square(n);
  return z * (1. / 24 + z * (-7. / 960 + z * (31. / 8064 + z * (-127. / 30720 + z * (511. / 67584)))));
}
constexpr double kAsymptotic = 16;

/// h_n = 1 + 1/3 + 1/5 + ... + 1/(2n-1), continued to real n >= 0 as (psi(n + 1/2) - psi(1/2)) / 2.
double odd_harmonic(double n) {
  double below = 0;  // h_{n+1} = h_n + 1/(2n+1) lifts small n to where the series holds
  while (n < kAsymptotic) {
    below += 1 / (2 * n + 1);
    n += 1;
  }
  constexpr double kMinusPsiHalf = std::numbers::egamma + 2 * std::numbers::ln2;
  return 0.5 * (std::log(n) + kMinusPsiHalf + digamma_remainder(n)) - below;
}

/// sum_{k >= first} weight(k) x^k / k!, divided by x^first, for 0 <= |x| <= 1.
template <typename Weight>
double exponential_tail(double x, int first, Weight weight) {
  double factor = 1;
  for (int k = 2; k <= first; ++k) factor /= k;
  double sum = 0;
  constexpr int kTerms = 24;  // 2^27 / 27! = 1e-20
  for (int k = first; k < first + kTerms; ++k) {
    sum += weight(k) * factor;
    factor *= x / (k + 1);
  }
  return sum;
}

// --- Quantization ------------------------------------------------------------------------------------------ --------

double psd_of(const Quantization& p, double f, double dt) { return 4 * square(p.q * std::sin(pi * f * dt)) / dt; }
double allan_of(const Quantization& p, double m, double dt) { return 3 * square(p.q / (m * dt)); }
double structure_of(const Quantization& p, double lag, double dt) {
  return (lag == 0 ? 0 : lag == 1 ? 6 : 4) * square(p.q / dt);  // neighbours share one reading
}
double phase_of(const Quantization& p, double lag, double) { return lag < 0.5 ? square(p.q) : 0; }

// --- White ------------------------------------------------------------------------------------------------- --------

double psd_of(const White& p, double, double) { return square(p.n); }
double allan_of(const White& p, double m, double dt) { return square(p.n) / (m * dt); }
double structure_of(const White& p, double lag, double dt) { return lag == 0 ? 0 : 2 * square(p.n) / dt; }
double phase_of(const White& p, double lag, double dt) { return -0.5 * square(p.n) * dt * lag; }

// --- White behind a filter --------------------------------------------------------------------------------- --------

double psd_of(const FilteredWhite& p, double f, double dt) {
  return square(p.n) * SampledFrontEnd(p.front_end, dt).power_gain(f * dt);
}
double allan_of(const FilteredWhite& p, double m, double dt) {
  const SampledFrontEnd filter(p.front_end, dt);
  const double memory = 6 * filter.memory(0) - 8 * filter.memory(m) + 2 * filter.memory(2 * m);
  return square(p.n) / (m * dt) * (1 + memory / (2 * m));
}
double structure_of(const FilteredWhite& p, double lag, double dt) {
  if (lag == 0) return 0;
  const SampledFrontEnd filter(p.front_end, dt);
  const double variance = 1 - 2 * (filter.memory(1) - filter.memory(0));
  const double shared = -(filter.memory(lag + 1) - 2 * filter.memory(lag) + filter.memory(lag - 1));
  return 2 * square(p.n) / dt * (variance - shared);
}
double phase_of(const FilteredWhite& p, double lag, double dt) {
  return square(p.n) * dt * (SampledFrontEnd(p.front_end, dt).memory(lag) - 0.5 * lag);
}

// --- Flicker ----------------------------------------------------------------------------------------------- --------

double psd_of(const Flicker& p, double f, double dt) { return square(p.b) * dt / (2 * std::sin(pi * f * dt)); }
double allan_of(const Flicker& p, double m, double) {
  const double h_m = odd_harmonic(m), h_2m = odd_harmonic(2 * m);
  // For long clusters the logarithms are the same but for ln 2: take the difference before rounding does.
  const double growth =
      m < kAsymptotic ? h_2m - h_m : 0.5 * (std::numbers::ln2 + digamma_remainder(2 * m) - digamma_remainder(m));
  return square(p.b) / (4 * pi) * (16 * growth + (4 * h_m - h_2m) / square(m));
}
double structure_of(const Flicker& p, double lag, double) { return 4 / pi * square(p.b) * odd_harmonic(lag); }
double phase_of(const Flicker& p, double lag, double dt) {
  return square(p.b * dt) / (4 * pi) * (4 * square(lag) - 1) * odd_harmonic(lag);
}

// --- Rate random walk -------------------------------------------------------------------------------------- --------

double psd_of(const RateRandomWalk& p, double f, double dt) { return square(p.k * dt / (2 * std::sin(pi * f * dt))); }
double allan_of(const RateRandomWalk& p, double m, double dt) { return square(p.k) * dt * (m / 3 + 1 / (6 * m)); }
double structure_of(const RateRandomWalk& p, double lag, double dt) { return square(p.k) * dt * lag; }
double phase_of(const RateRandomWalk& p, double lag, double dt) {
  return square(p.k * dt) * dt * lag * (square(lag) - 1) / 12;
}

// --- Rate ramp --------------------------------------------------------------------------------------------- --------

double psd_of(const RateRamp&, double, double) { return 0; }
double allan_of(const RateRamp& p, double m, double dt) { return 0.5 * square(p.r * m * dt); }
double structure_of(const RateRamp& p, double lag, double dt) { return square(p.r * lag * dt); }
double phase_of(const RateRamp&, double, double) { return 0; }

// --- Gauss-Markov ------------------------------------------------------------------------------------------
// ------------------------------------------------------------------------------------------------ With a =
// dt/Tc, phi = exp(-a) and x = a h the variance of the angle gathered over h samples is
//   V(h) = sigma^2 dt^2 [h (1 + phi)/(1 - phi) - 2 phi (1 - phi^h)/(1 - phi)^2]
//        = sigma^2 dt^2 [h L + h^2 P (e^-x - 1 + x)/x^2],
//   L = (1 - phi^2 - 2 a phi)/(1 - phi)^2,  P = 2 phi a^2/(1 - phi)^2,
// where every term is positive: nothing cancels however slow (white noise of the angle's rate at a ->
// infinity, a constant at a -> 0) the process is. The Allan variance is (4 V(m) - V(2m)) / (2 m^2 dt^2).

struct GaussMarkovShape {
  double a, L, P;
  GaussMarkovShape(const GaussMarkov& p, double dt) : a(dt / p.correlation_time), L(1), P(0) {
    constexpr double kWhite = 700;  // phi < 1e-304
    if (a > kWhite) return;
    const double phi = std::exp(-a), ratio = a > 0 ? a / -std::expm1(-a) : 1;
    P = 2 * phi * square(ratio);
    L = a < 1 ? P * a * exponential_tail(a, 3, [](int k) { return k % 2 == 0 ? 0. : 1.; })  // sinh(a) - a
              : (1 - square(phi) - 2 * a * phi) / square(1 - phi);
  }
};

double psd_of(const GaussMarkov& p, double f, double dt) {
  const double a = dt / p.correlation_time, decay = -std::expm1(-a), phi = std::exp(-a);
  const double s = std::sin(pi * f * dt);
  return square(p.sigma) * -std::expm1(-2 * a) * dt / (square(decay) + 4 * phi * square(s));
}
double allan_of(const GaussMarkov& p, double m, double dt) {
  const GaussMarkovShape shape(p, dt);
  if (shape.P == 0) return square(p.sigma) / m;
  const double x = shape.a * m;
  // (2x - 3 + 4 e^-x - e^-2x) / x^3
  const double curve = x < 1 ? exponential_tail(-x, 3, [](int k) { return std::ldexp(1., k) - 4; })
                             : (2 * x - 3 + 4 * std::exp(-x) - std::exp(-2 * x)) / (x * square(x));
  return square(p.sigma) * (shape.L / m + 0.5 * shape.P * x * curve);
}
double structure_of(const GaussMarkov& p, double lag, double dt) {
  return -2 * square(p.sigma) * std::expm1(-lag * dt / p.correlation_time);
}
double phase_of(const GaussMarkov& p, double lag, double dt) {
  const GaussMarkovShape shape(p, dt);
  if (shape.P == 0) return -0.5 * square(p.sigma * dt) * lag;
  const double x = shape.a * lag;
  const double curve = x < 1 ? exponential_tail(-x, 2, [](int) { return 1.; }) : (x + std::expm1(-x)) / square(x);
  return -0.5 * square(p.sigma * dt) * lag * (shape.L + lag * shape.P * curve);
}

// --- Sinusoid ---------------------------------------------------------------------------------------------- --------

/// Frequency in cycles per sample as it appears after sampling, in [-1/2, 1/2].
double aliased(const Sinusoid& p, double dt) { return std::remainder(p.frequency * dt, 1.0); }

double sin_cycles(double half_turns) { return std::sin(pi * std::remainder(half_turns, 2.0)); }

/// sin(pi c h) / sin(pi c), the gain of summing h samples.
double summing_gain(double c, double lag) { return c == 0 ? lag : sin_cycles(c * lag) / std::sin(pi * c); }

double psd_of(const Sinusoid& p, double f, double dt) {
  const bool on_line = f * dt == std::abs(aliased(p, dt)) && p.amplitude != 0;
  return on_line ? std::numeric_limits<double>::infinity() : 0;
}
double allan_of(const Sinusoid& p, double m, double dt) {
  const double c = aliased(p, dt);
  return square(p.amplitude * summing_gain(c, m) * sin_cycles(c * m) / m);
}
double structure_of(const Sinusoid& p, double lag, double dt) {
  return 2 * square(p.amplitude * sin_cycles(aliased(p, dt) * lag));
}
double phase_of(const Sinusoid& p, double lag, double dt) {
  return -0.25 * square(p.amplitude * dt * summing_gain(aliased(p, dt), lag));
}

/// Checks what every second moment relies on.
void require_sampled(const Process& process, double dt) {
  require_interval(dt);
  if (const auto* p = std::get_if<GaussMarkov>(&process)) {
    require(p->correlation_time > 0 && std::isfinite(p->correlation_time), "correlation time", p->correlation_time,
            "positive and finite (s)");
  }
}

// The member that scales each process.
double& scale(Quantization& p) { return p.q; }
double& scale(White& p) { return p.n; }
double& scale(Flicker& p) { return p.b; }
double& scale(RateRandomWalk& p) { return p.k; }
double& scale(RateRamp& p) { return p.r; }
double& scale(GaussMarkov& p) { return p.sigma; }
double& scale(Sinusoid& p) { return p.amplitude; }
double& scale(FilteredWhite& p) { return p.n; }

}  // namespace

Term term(const Process& process) {
  constexpr Term kTerms[] = {Term::quantization, Term::white,        Term::flicker,  Term::rate_random_walk,
                             Term::rate_ramp,    Term::gauss_markov, Term::sinusoid, Term::white};
  static_assert(std::size(kTerms) == std::variant_size_v<Process>);
  return kTerms[process.index()];
}

double coefficient(const Process& process) {
  return std::visit([](auto p) { return scale(p); }, process);
}

Process with_coefficient(Process process, double value) {
  std::visit([=](auto& p) { scale(p) = value; }, process);
  return process;
}

Process unit_process(Term wanted) {
  constexpr Process kZero[] = {Quantization{}, White{},       Flicker{}, RateRandomWalk{},
                               RateRamp{},     GaussMarkov{}, Sinusoid{}};
  for (const Process& p : kZero) {
    if (term(p) == wanted) return with_coefficient(p, 1);
  }
  throw std::invalid_argument(fmt::format("'{}' is no noise term; there are Q N B K R G S", static_cast<char>(wanted)));
}

double psd(const Process& process, double frequency_hz, double dt) {
  require_sampled(process, dt);
  constexpr double kNyquist = 0.5 * (1 + 4 * std::numeric_limits<double>::epsilon());  // f dt may round up
  require(frequency_hz > 0 && frequency_hz * dt <= kNyquist, "frequency", frequency_hz, "in (0, 1/(2 dt)] (Hz)");
  return std::visit([=](const auto& p) { return psd_of(p, frequency_hz, dt); }, process);
}

double allan_variance(const Process& process, std::int64_t m, double dt) {
  require_sampled(process, dt);
  require(m >= 1, "averaging factor m", static_cast<double>(m), "at least 1 (samples)");
  return std::visit([=](const auto& p) { return allan_of(p, static_cast<double>(m), dt); }, process);
}

double allan_variance(std::span<const Process> processes, std::int64_t m, double dt) {
  double sum = 0;
  for (const Process& p : processes) sum += allan_variance(p, m, dt);
  return sum;
}

double structure_function(const Process& process, std::int64_t lag, double dt) {
  require_sampled(process, dt);
  require(lag >= 0, "lag", static_cast<double>(lag), "at least 0 (samples)");
  return std::visit([=](const auto& p) { return structure_of(p, static_cast<double>(lag), dt); }, process);
}

double phase_covariance(const Process& process, double lag, double dt) {
  require_sampled(process, dt);
  require(std::isfinite(lag), "lag", lag, "finite (samples)");
  return std::visit([=](const auto& p) { return phase_of(p, std::abs(lag), dt); }, process);
}

}  // namespace gyrobudget::inline v0::noise

// SPDX-License-Identifier: MIT
#include "gyrobudget/noise/detail/axis_noise.h"

#include "gyrobudget/noise/detail/streams.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "generate.h"

namespace gyrobudget::inline v0::noise::detail {
namespace {

using std::numbers::pi;

// Streams of what is drawn at the start, apart from those that run, which have the letters of their terms.
constexpr char kWhiteStart = 'n', kFilterStart = 'f', kFlickerStart = 'b', kWalkStart = 'k', kGaussMarkovStart = 'g';

std::uint64_t whole_samples(const char* what, double time, double dt) {
  constexpr double kMost = 0x1p62;
  const double samples = std::round(time / dt);
  if (time >= 0 && samples <= kMost) return static_cast<std::uint64_t>(samples);
  throw std::invalid_argument(fmt::format("{} is {} s; it must be from 0 to 2^62 samples of {} s", what, time, dt));
}

}  // namespace

Epoch epoch_of(const ErrorModel& model, double dt) {
  Epoch epoch;
  if (model.powered_on_before) epoch.powered = whole_samples("powered_on_before", *model.powered_on_before, dt);
  if (!model.calibrated_over) return epoch;
  epoch.calibrated = whole_samples("calibrated_over", *model.calibrated_over, dt);
  if (!model.powered_on_before) epoch.powered = epoch.calibrated;
  if (epoch.calibrated == 0 || epoch.powered < epoch.calibrated) {
    throw std::invalid_argument(fmt::format(
        "calibrated_over is {} s; it must be at least a sample ({} s){}", *model.calibrated_over, dt,
        model.powered_on_before ? fmt::format(" and at most powered_on_before ({} s)", *model.powered_on_before) : ""));
  }
  return epoch;
}

// --- From power-on to the first sample ---------------------------------------------------------------------

AxisNoise::AxisNoise(const ErrorModel& model, std::size_t which, double dt, StreamKey axis, const FlickerBand& band) {
  const Setting setting{dt, epoch_of(model, dt), axis};
  if (model.white[which] != 0) start_white(setting, model.white[which], model.filter);
  if (model.bias_instability[which] != 0) {
    const double past = static_cast<double>(setting.epoch.powered) * dt;
    const auto states = flicker_approximation(Flicker{model.bias_instability[which]}, dt,
                                              std::max(dt, band.duration + past), band.poles_per_decade);
    add_bank(setting, 'B', 0, states);
  }
  if (model.rate_random_walk[which] != 0) {
    const Process walk = RateRandomWalk{model.rate_random_walk[which]};
    add_bank(setting, 'K', 0, std::span(&walk, 1));
  }
  for (std::size_t i = 0; i < model.gauss_markov.size(); ++i) {
    if (model.gauss_markov[i].sigma[which] == 0) continue;
    const Process process = model.gauss_markov[i].on(which);
    add_bank(setting, 'G', i, std::span(&process, 1));
  }
  if (model.rate_ramp[which] != 0) add_ramp(setting, model.rate_ramp[which]);
  for (const TriadSinusoid& s : model.sinusoids) {
    if (s.amplitude[which] != 0) add_sinusoid(setting, s.on(which));
  }
}

void AxisNoise::add_bank(const Setting& setting, char kind, std::uint64_t occurrence, std::span<const Process> states) {
  constexpr std::size_t kDraws = 4;  // of a state: at power-on, when the calibration begins, and its end and sum
  const char start = kind == 'B' ? kFlickerStart : kind == 'K' ? kWalkStart : kGaussMarkovStart;
  std::vector<double> u(kDraws * states.size());
  fill_normal(source_stream(setting.axis, start, occurrence), 0, u);
  Bank bank{{}, source_stream(setting.axis, kind, occurrence), 0};
  for (std::size_t i = 0; i < states.size(); ++i) {
    bank.origin += add_state(setting, bank, states[i], std::span(u).subspan(kDraws * i, kDraws));
  }
  if (setting.epoch.powered == 0) bank.origin = bank.states.sum();  // zero at the first sample to the last digit
  if (kind == 'G') bank.origin = 0;  // a Gauss-Markov process of the sensor was never zero
  if (setting.epoch.calibrated > 0) calibrated_mean_ -= bank.origin;
  normals_.resize(std::max(normals_.size(), kTile * states.size() + StateBank::kLanes));
  banks_.push_back(std::move(bank));
}

double AxisNoise::add_state(const Setting& setting, Bank& bank, const Process& process, std::span<const double> u) {
  const auto* gauss_markov = std::get_if<GaussMarkov>(&process);
  const FirstOrder step =
      gauss_markov ? FirstOrder::gauss_markov(gauss_markov->sigma, gauss_markov->correlation_time, setting.dt)
                   : FirstOrder::walk(std::get<RateRandomWalk>(process).k, setting.dt);
  const double at_power_on = gauss_markov ? gauss_markov->sigma * u[0] : 0;
  const Epoch& epoch = setting.epoch;
  double now = step.repeated(epoch.powered - epoch.calibrated).draw(at_power_on, u[1], 0).end;
  if (epoch.calibrated > 0) {
    const FirstOrder::Draw draw = step.repeated(epoch.calibrated).draw(now, u[2], u[3]);
    now = draw.end;
    calibrated_mean_ += draw.sum / static_cast<double>(epoch.calibrated);
  }
  bank.states.add(1 - step.decay, std::sqrt(step.var_end), now);
  return at_power_on;
}

void AxisNoise::start_white(const Setting& setting, double n, const std::optional<FrontEnd>& filter) {
  white_ = n / std::sqrt(setting.dt);
  white_key_ = source_stream(setting.axis, 'N');
  if (filter) {
    const SampledFrontEnd sampled(*filter, setting.dt);
    std::vector<double> before(static_cast<std::size_t>(sampled.settling()));
    fill_normal(source_stream(setting.axis, kFilterStart), 0, before);
    filter_.emplace(sampled);
    (*filter_)(before);
  }
  if (setting.epoch.calibrated == 0) return;
  double u = 0;
  fill_normal(source_stream(setting.axis, kWhiteStart), 0, std::span(&u, 1));
  calibrated_mean_ += white_ * u / std::sqrt(static_cast<double>(setting.epoch.calibrated));
}

void AxisNoise::add_ramp(const Setting& setting, double r) {
  ramp_step_ = r * setting.dt;
  ramp_start_ = ramp_step_ * static_cast<double>(setting.epoch.powered);
  if (setting.epoch.calibrated == 0) return;
  calibrated_mean_ += ramp_start_ - 0.5 * ramp_step_ * (static_cast<double>(setting.epoch.calibrated) + 1);
}

void AxisNoise::add_sinusoid(const Setting& setting, const Sinusoid& s) {
  const double cycles = std::remainder(s.frequency * setting.dt, 1.0);
  sinusoids_.push_back({s.amplitude, cycles, s.phase});
  if (setting.epoch.calibrated == 0) return;
  // The sum over n samples up to -1 is one sinusoid at their middle, with the gain sin(pi c n)/sin(pi c).
  const auto n = static_cast<double>(setting.epoch.calibrated);
  const auto half_turns = [](double c, double k) { return pi * std::remainder(c * k, 2.0); };
  const double gain = cycles == 0 ? n : std::sin(half_turns(cycles, n)) / std::sin(pi * cycles);
  calibrated_mean_ += s.amplitude * gain / n * std::sin(s.phase - half_turns(cycles, n + 1));
}

// --- From the first sample on ------------------------------------------------------------------------------

bool AxisNoise::next(Tile& slow, Tile& fast) {
  if (banks_.empty() && white_ == 0 && ramp_step_ == 0 && sinusoids_.empty()) return false;
  for (std::size_t k = 0; k < kTile; ++k) {
    slow[k] = ramp_start_ + ramp_step_ * static_cast<double>(at_ + k);
    fast[k] = 0;
  }
  add_banks(slow);
  add_white(fast);
  add_sinusoids(fast);
  at_ += kTile;
  return true;
}

void AxisNoise::add_banks(Tile& slow) {
  const Target target = best_target();
  Tile sums;
  for (Bank& bank : banks_) {
    const std::size_t stride = bank.states.size();
    fill_normal(bank.key, at_ * stride, std::span(normals_).first(kTile * stride));
    bank.states.run(target, normals_, stride, sums);
    for (std::size_t k = 0; k < kTile; ++k) slow[k] += sums[k] - bank.origin;
  }
}

void AxisNoise::add_white(Tile& fast) {
  if (white_ == 0) return;
  fill_normal(white_key_, at_, fast);
  if (filter_) (*filter_)(fast);
  for (double& y : fast) y *= white_;
}

void AxisNoise::add_sinusoids(Tile& fast) const {
  for (const Sinusoid& s : sinusoids_) {
    for (std::size_t k = 0; k < kTile; ++k) {
      const auto at = static_cast<double>(at_ + k);
      const double turn = std::fma(s.frequency, at, -std::nearbyint(s.frequency * at));  // whole turns lose no digits
      fast[k] += s.amplitude * std::sin(2 * pi * turn + s.phase);
    }
  }
}

}  // namespace gyrobudget::inline v0::noise::detail

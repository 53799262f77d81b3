// SPDX-License-Identifier: MIT
#include "sensor_states.h"

#include "gyrobudget/estimation/navigation/detail/gauss_markov.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "flicker_states.h"

namespace gyrobudget::inline v0::navigation {
namespace {

using detail::mean_exponential;
using detail::mean_variance;

constexpr double kBandDecades = 2;
constexpr double kFlatVariance = 2 * std::numbers::ln2 / std::numbers::pi;  // of flicker, over B^2

struct Triad {
  Carrier carrier;
  const noise::ErrorModel& errors;
  Epoch epoch;
  std::string name;
};

double allan_variance(const noise::GaussMarkov& process, double tau) {
  return process.sigma * process.sigma * detail::allan_variance(tau / process.correlation_time);
}

// Integral of f by midpoints in ln u.
template <typename Function>
double logarithmic_integral(Function f, double from, double to) {
  if (!(to > from)) return 0;
  constexpr int kPoints = 256;
  const double step = std::log(to / from) / kPoints;
  double sum = 0;
  for (int i = 0; i < kPoints; ++i) {
    const double u = from * std::exp((i + 0.5) * step);
    sum += f(u) * u * step;
  }
  return sum;
}

// What flicker's structure function, (2 B^2/pi) (ln(4 lag/dt) + gamma) at lags of many samples, has beyond that of
// its states: an offset from what is faster than the band, and beyond the band a gain with the lag.
class BeyondBand {
 public:
  BeyondBand(double b, std::vector<noise::GaussMarkov> states, double shortest, double longest, double dt)
      : b_(b), states_(std::move(states)), longest_(longest), dt_(dt), offset_(excess(std::sqrt(shortest * longest))) {}

  // Of Var(F(0) - F(-P)): half the offset, as the fast part of F(0) passes and that of F(-P) stays, and all the gain.
  [[nodiscard]] double against_value(double P) const { return std::max(0.0, offset_) / 2 + gain(P); }
  // Var(F(0) - mean F over [-T, 0]) = (1/T) int D(u) du - (1/T^2) int (T - u) D(u) du = (1/T^2) int u D(u) du.
  [[nodiscard]] double against_mean(double T) const {
    return logarithmic_integral([&](double u) { return u * gain(u); }, longest_, T) / (T * T);
  }

 private:
  [[nodiscard]] double gain(double lag) const { return lag > longest_ ? std::max(0.0, excess(lag) - offset_) : 0; }
  [[nodiscard]] double excess(double lag) const {
    double d = 2 * b_ * b_ / std::numbers::pi * (std::log(std::max(4 * lag / dt_, 1.0)) + std::numbers::egamma);
    for (const auto& g : states_) d -= 2 * g.sigma * g.sigma * -std::expm1(-lag / g.correlation_time);
    return d;
  }

  double b_;
  std::vector<noise::GaussMarkov> states_;
  double longest_;
  double dt_;
  double offset_;
};

class Builder {
 public:
  explicit Builder(const SensorStates::Options& options) : options_(options) {
    if (!(options.scene_length > 0) || !std::isfinite(options.scene_length))
      throw SetupError(fmt::format("scene of {} s, expected above 0 s", options.scene_length));
    if (!(options.step > 0) || !std::isfinite(options.step))
      throw SetupError(fmt::format("IMU interval of {} s, expected above 0 s", options.step));
    if (!(options.tolerance > 0)) throw SetupError(fmt::format("tolerance is {}, expected above 0", options.tolerance));
    longest_ = options.scene_length;
    const double shortest = options.shortest.value_or(longest_ * std::pow(10, -kBandDecades));
    if (!(shortest > 0 && shortest < longest_))
      throw SetupError(
          fmt::format("band of flicker from {} s to {} s, expected positive and ascending", shortest, longest_));
    shortest_ = std::max(std::min(options.step, longest_ / 2), shortest);
    result_.initial = StateMatrix::Zero(kMaxErrorTerms, kMaxErrorTerms);
  }

  void add(const Triad& triad) {
    check(triad.epoch, triad.name);
    auto& white = triad.carrier == Carrier::gyro ? result_.model.gyro_white : result_.model.accelerometer_white;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      white[static_cast<Eigen::Index>(axis)] = triad.errors.white[axis];
      const auto processes = slow_processes(triad, axis);
      add_biases(triad, axis, processes, slower_than_band(triad, axis, processes.flicker));
    }
    add_constants(triad);
    mention(triad);
  }

  [[nodiscard]] SensorStates take() {
    const auto n = static_cast<Eigen::Index>(result_.model.terms.size());
    const StateMatrix used = result_.initial.topLeftCorner(n, n);
    result_.initial = used;
    result_.model.check();
    return std::move(result_);
  }

 private:
  struct Processes {
    std::vector<noise::GaussMarkov> flicker, given;
  };

  // The fewest states whose error is hidden by all the noise there is at the scene's length.
  Processes slow_processes(const Triad& triad, std::size_t axis) const {
    Processes result;
    for (const auto& g : triad.errors.gauss_markov)
      if (g.sigma[axis] != 0) result.given.push_back(g.on(axis));
    const double N = triad.errors.white[axis], B = triad.errors.bias_instability[axis],
                 K = triad.errors.rate_random_walk[axis];
    if (B == 0) return result;
    const double T = longest_;
    const double flicker = kFlatVariance * B * B;
    double total = flicker + N * N / T + K * K * T / 3;
    for (const auto& g : result.given) total += allan_variance(g, T);
    int states = options_.flicker_states.value_or(0);
    FlickerStates fit = flicker_states(B, shortest_, longest_, states);
    const auto hidden = [&] {
      const double error = fit.worst_error;  // of the deviation; 2 error of flicker's variance, its share of the total
      return (states == 0 ? flicker / total / 2 : error * flicker / total) <= options_.tolerance;
    };
    while (!options_.flicker_states && states < 3 && !hidden()) fit = flicker_states(B, shortest_, longest_, ++states);
    result.flicker = fit.processes;
    return result;
  }

  double slower_than_band(const Triad& triad, std::size_t axis, const std::vector<noise::GaussMarkov>& states) const {
    const double b = triad.errors.bias_instability[axis];
    if (b == 0) return 0;
    const BeyondBand beyond(b, states, shortest_, longest_, options_.step);
    return triad.epoch.calibrated_over ? beyond.against_mean(*triad.epoch.calibrated_over)
                                       : beyond.against_value(triad.epoch.powered_on_before);
  }

  std::size_t add_term(ErrorTerm term, double variance) {
    const std::size_t k = result_.model.terms.size();
    if (k == kMaxErrorTerms)
      throw SetupError(fmt::format(
          "the sensor needs more than the {} states a filter holds: consider fewer Gauss-Markov terms, or leave misalignment or g-sensitivity out",
          kMaxErrorTerms));
    result_.model.terms.push_back(term);
    result_.initial(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(k)) = variance;
    return k;
  }

  void add_biases(const Triad& triad, std::size_t axis, const Processes& processes, double beyond) {
    const noise::ErrorModel& errors = triad.errors;
    const auto T = triad.epoch.calibrated_over;
    const double P = triad.epoch.powered_on_before;
    const auto of_axis = [axis](const std::optional<noise::PerAxis>& sigma) { return sigma.value_or(0)[axis]; };
    const double N = errors.white[axis], K = errors.rate_random_walk[axis], b0 = of_axis(errors.turn_on_bias);
    const double rectified = of_axis(errors.vibration_rectification) * options_.vibration * options_.vibration;
    double variance = beyond + rectified * rectified;  // no calibration at rest takes off what vibration adds
    variance += T ? K * K * *T / 3 + N * N / *T : b0 * b0 + K * K * P;
    // Correlation of the bias with each process, over sigma^2, and the variance that the epoch charges for it.
    struct Link {
      noise::GaussMarkov process;
      double correlation, charged;
    };
    std::vector<Link> links;
    for (const auto& g : processes.flicker) {
      const double tc = g.correlation_time;
      links.push_back(T ? Link{g, mean_exponential(*T / tc), mean_variance(*T / tc)} : Link{g, std::exp(-P / tc), 1});
    }
    for (const auto& g : processes.given)
      links.push_back(T ? Link{g, mean_exponential(*T / g.correlation_time), mean_variance(*T / g.correlation_time)}
                        : Link{g, 0, 0});
    for (const auto& link : links) variance += link.process.sigma * link.process.sigma * link.charged;
    if (variance == 0 && K == 0 && links.empty()) return;

    ErrorTerm term{.carrier = triad.carrier, .effect = Effect::bias, .axis = static_cast<int>(axis), .walk = K};
    const auto bias = static_cast<Eigen::Index>(add_term(term, variance));
    for (const auto& [process, correlation, charged] : links) {
      term.correlation_time = process.correlation_time;
      term.walk = process.sigma * std::sqrt(2 / process.correlation_time);
      const double sigma2 = process.sigma * process.sigma;
      const auto k = static_cast<Eigen::Index>(add_term(term, sigma2));
      result_.initial(bias, k) = result_.initial(k, bias) = -sigma2 * correlation;
    }
  }

  void add_constants(const Triad& triad) {
    const noise::ErrorModel& errors = triad.errors;
    add_constant(triad, Effect::scale_factor, errors.scale_factor, options_.scale_factor);
    add_constant(triad, Effect::misalignment, errors.misalignment, options_.misalignment);
    if (triad.carrier == Carrier::gyro)
      add_constant(triad, Effect::g_sensitivity, errors.g_sensitivity, options_.g_sensitivity);
    add_constant(triad, Effect::g2_sensitivity, errors.g2_sensitivity, options_.g_sensitivity);
  }

  void add_constant(const Triad& triad, Effect effect, const std::optional<noise::PerAxis>& sigma, Use use) {
    if (!sigma || *sigma == noise::PerAxis(0)) return;
    if (use == Use::left_out) {
      result_.left_out.push_back({fmt::format("{} {}", triad.name, word(effect)), "as asked"});
      return;
    }
    const bool own = effect != Effect::misalignment;
    const bool cross = effect == Effect::misalignment || effect == Effect::g_sensitivity;
    for (int axis = 0; axis < 3; ++axis)
      for (int input = 0; input < 3; ++input) {
        const double s = (*sigma)[static_cast<std::size_t>(axis)];
        if (axis == input ? own : cross)
          add_term({.carrier = triad.carrier,
                    .effect = effect,
                    .axis = axis,
                    .input = input,
                    .considered = use == Use::considered},
                   s * s);
      }
  }

  static std::string_view word(Effect effect) {
    switch (effect) {
      case Effect::scale_factor:
        return "scale factor";
      case Effect::misalignment:
        return "misalignment";
      case Effect::g_sensitivity:
        return "g-sensitivity";
      default:
        return "g2-sensitivity";
    }
  }

  void mention(const Triad& triad) {
    const noise::ErrorModel& errors = triad.errors;
    const auto say = [&](bool has, std::string_view what, std::string_view why) {
      if (has) result_.left_out.push_back({fmt::format("{} {}", triad.name, what), std::string(why)});
    };
    say(errors.quantization != 0, "quantization", "moves the integrated signal by no more than one step, ever");
    say(errors.rate_ramp != 0, "rate ramp", "no state: the bias follows it only as far as its random walk lets it");
    say(!errors.sinusoids.empty(), "sinusoid", "no state: bounded in the integrated signal");
    say(errors.temperature && !options_.temperature, "temperature",
        "no state: it is taken off where the log has a temperature, and nothing at the reference");
    say(errors.filter.has_value(), "filter", "a delay, not a state");
  }

  const SensorStates::Options& options_;
  double shortest_ = 0, longest_ = 0;
  SensorStates result_;
};

}  // namespace

Epoch epoch_of(const noise::ErrorModel& errors) {
  return {errors.powered_on_before.value_or(0), errors.calibrated_over};
}

void check(const Epoch& epoch, std::string_view triad) {
  if (!(epoch.powered_on_before >= 0) || !std::isfinite(epoch.powered_on_before))
    throw SetupError(
        fmt::format("{}: powered on {} s before the scene, expected 0 or more", triad, epoch.powered_on_before));
  if (epoch.calibrated_over && (!(*epoch.calibrated_over > 0) || !std::isfinite(*epoch.calibrated_over)))
    throw SetupError(fmt::format("{}: calibrated over {} s, expected above 0 s", triad, *epoch.calibrated_over));
}

SensorStates sensor_states(const noise::SensorModel& sensor, const SensorStates::Options& options) {
  Builder builder(options);
  builder.add({Carrier::gyro, sensor.gyro, options.gyro.value_or(epoch_of(sensor.gyro)), "gyro"});
  if (sensor.accelerometer)
    builder.add({Carrier::accelerometer, *sensor.accelerometer,
                 options.accelerometer.value_or(epoch_of(*sensor.accelerometer)), "accelerometer"});
  return builder.take();
}

StateMatrix initial_covariance(const CoreMatrix& core, const StateMatrix& terms) {
  const auto n = kCoreStates + terms.rows();
  if (terms.rows() != terms.cols() || n > kMaxStates)
    throw std::invalid_argument(fmt::format("covariance of {} x {} error terms, expected square with at most {}",
                                            terms.rows(), terms.cols(), kMaxErrorTerms));
  StateMatrix P = StateMatrix::Zero(n, n);
  P.topLeftCorner<kCoreStates, kCoreStates>() = core;
  P.bottomRightCorner(terms.rows(), terms.rows()) = terms;
  return P;
}

}  // namespace gyrobudget::inline v0::navigation

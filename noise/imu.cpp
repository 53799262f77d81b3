// SPDX-License-Identifier: MIT
#include "imu.h"

#include "gyrobudget/noise/detail/axis_noise.h"
#include "gyrobudget/noise/detail/check.h"
#include "gyrobudget/noise/detail/response.h"
#include "gyrobudget/noise/detail/streams.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

namespace gyrobudget::inline v0::noise {

using detail::require;
using detail::require_interval;

namespace {

constexpr std::size_t kAxes = 3;

// Streams of the constants, by digits; letters are the noise's.
constexpr char kTurnOnBias = '1', kScaleFactor = '2', kMisalignment = '3', kGSensitivity = '4', kG2Sensitivity = '5',
               kVibration = '6', kRemainder = '7';

void require_size(const char* what, double value) {
  require(value >= 0 && std::isfinite(value), what, value, "zero or positive, and finite");
}

void check(const ErrorModel& m) {
  require_size("delay", m.delay.value_or(0));
  for (const auto& [what, value] : {std::pair{"quantization", m.quantization},
                                    {"white noise", m.white},
                                    {"bias instability", m.bias_instability},
                                    {"random walk", m.rate_random_walk}}) {
    for (std::size_t axis = 0; axis < kAxes; ++axis) require_size(what, value[axis]);
  }
  for (std::size_t axis = 0; axis < kAxes; ++axis) require_size("ramp", std::abs(m.rate_ramp[axis]));
  for (const TriadGaussMarkov& g : m.gauss_markov) {
    for (std::size_t axis = 0; axis < kAxes; ++axis) require_size("sigma of a Gauss-Markov process", g.sigma[axis]);
    require(g.correlation_time > 0 && std::isfinite(g.correlation_time), "correlation time", g.correlation_time,
            "positive and finite (s)");
  }
  for (const TriadSinusoid& s : m.sinusoids) {
    for (std::size_t axis = 0; axis < kAxes; ++axis)
      require(std::isfinite(s.amplitude[axis]) && std::isfinite(s.frequency) && std::isfinite(s.phase), "a sinusoid",
              s.amplitude[axis], "finite");
  }
  for (const auto& [what, value] : {std::pair{"turn-on bias", m.turn_on_bias},
                                    {"scale factor", m.scale_factor},
                                    {"misalignment", m.misalignment},
                                    {"g-sensitivity", m.g_sensitivity},
                                    {"g^2-sensitivity", m.g2_sensitivity},
                                    {"vibration rectification", m.vibration_rectification}}) {
    for (std::size_t axis = 0; value && axis < kAxes; ++axis) require_size(what, (*value)[axis]);
  }
  require(!(m.range.value_or(0) < 0) && !std::isnan(m.range.value_or(0)), "range", m.range.value_or(0),
          "zero or positive");
}

/// Standard normal numbers for the constants of one kind, of each axis `count`.
Vector3 draw(StreamKey axis, char kind, double sigma) {
  Vector3 u{};
  fill_normal(detail::source_stream(axis, kind), 0, u);
  for (double& x : u) x *= sigma;
  return u;
}

/// What one triad of an IMU does to its increments.
class Triad {
 public:
  struct Setting {
    double dt = 1;
    double vibration = 0;
    std::array<StreamKey, kAxes> axes;
    detail::FlickerBand band;
    std::optional<TemperatureProfile> temperature = {};
  };
  Triad() = default;  // ideal
  Triad(const ErrorModel&, const Setting&);

  /// @param v true velocity increments
  [[nodiscard]] Vector3 next(const Vector3& truth, const Vector3& v);

  [[nodiscard]] const TriadConstants& constants() const { return constants_; }
  [[nodiscard]] const Vector3& bias() const { return bias_; }
  [[nodiscard]] const std::array<std::uint64_t, kAxes>& saturated() const { return saturated_; }

 private:
  struct Axis {
    detail::AxisNoise noise;
    std::optional<detail::LowPass> low_pass;
    std::optional<detail::Delay> delay;
    detail::AxisNoise::Tile slow{}, fast{};
    bool noisy = false;
    double bit = 0;        ///< of the quantization
    double remainder = 0;  ///< of it, not yet read
  };

  void draw_constants(const ErrorModel&, const Setting&);
  void start_axis(const ErrorModel&, const Setting&, std::size_t axis);
  [[nodiscard]] Vector3 sensed(const Vector3& u, const Vector3& v) const;
  [[nodiscard]] double read(std::size_t axis, double increment);
  [[nodiscard]] double saturate(std::size_t axis, double increment);
  [[nodiscard]] static double quantize(Axis&, double increment);

  bool ideal_ = true;
  bool deforms_ = false;  ///< any of s, M, G, D
  double dt_ = 1;
  TriadConstants constants_;
  Matrix3 deformation_{};  ///< s on the diagonal of M
  Vector3 constant_bias_{};
  double limit_ = std::numeric_limits<double>::infinity();
  std::vector<Axis> axes_;
  std::size_t at_ = 0;  ///< in the tiles
  Vector3 bias_{};
  std::optional<TemperatureModel> temperature_;
  std::optional<TemperatureProfile> profile_;
  Vector3 warm_bias_{};
  std::uint64_t samples_ = 0;
  std::array<std::uint64_t, kAxes> saturated_{};
};

Triad::Triad(const ErrorModel& model, const Setting& setting) : dt_(setting.dt) {
  check(model);
  draw_constants(model, setting);
  if (model.range) limit_ = *model.range * dt_;
  for (std::size_t i = 0; i < kAxes; ++i) start_axis(model, setting, i);
  const auto any = [](const Vector3& x) { return std::ranges::any_of(x, [](double y) { return y != 0; }); };
  const TriadConstants& c = constants_;
  deforms_ =
      any(c.g2_sensitivity) || std::ranges::any_of(deformation_, any) || std::ranges::any_of(c.g_sensitivity, any);
  if (model.temperature && setting.temperature) temperature_ = model.temperature, profile_ = setting.temperature;
  ideal_ = !(temperature_ || deforms_ || any(constant_bias_) || any(c.calibrated_bias) || model.range ||
             std::ranges::any_of(axes_, [](const Axis& a) { return a.noisy || a.bit != 0 || a.low_pass || a.delay; }));
}

void Triad::draw_constants(const ErrorModel& model, const Setting& setting) {
  TriadConstants& c = constants_;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const auto sigma = [&](const std::optional<PerAxis>& value) { return value ? (*value)[i] : 0; };
    const auto drawn = [&](char kind, const std::optional<PerAxis>& value) {
      return sigma(value) == 0 ? Vector3{} : draw(setting.axes[i], kind, sigma(value));
    };
    c.turn_on_bias[i] = drawn(kTurnOnBias, model.turn_on_bias)[0];
    c.scale_factor[i] = drawn(kScaleFactor, model.scale_factor)[0];
    c.misalignment[i] = drawn(kMisalignment, model.misalignment);
    c.misalignment[i][i] = 0;
    c.g_sensitivity[i] = drawn(kGSensitivity, model.g_sensitivity);
    c.g2_sensitivity[i] = drawn(kG2Sensitivity, model.g2_sensitivity)[0];
    c.vibration_bias[i] = drawn(kVibration, model.vibration_rectification)[0] * setting.vibration * setting.vibration;
    deformation_[i] = c.misalignment[i];
    deformation_[i][i] = c.scale_factor[i];
    constant_bias_[i] = c.turn_on_bias[i] + c.vibration_bias[i];
  }
}

void Triad::start_axis(const ErrorModel& model, const Setting& setting, std::size_t i) {
  axes_.push_back({detail::AxisNoise(model, i, dt_, setting.axes[i], setting.band), {}, {}, {}, {}, false, 0, 0});
  Axis& axis = axes_.back();
  axis.bit = model.quantization[i] * std::sqrt(12.0);
  if (model.filter) axis.low_pass.emplace(model.filter->kind, model.filter->bandwidth, dt_);
  if (model.delay && *model.delay != 0) axis.delay.emplace(*model.delay, dt_);
  axis.noisy = axis.noise.next(axis.slow, axis.fast);
  std::array<double, 2>
      u{};  // where between two bits the reading stands, at the first sample and before the calibration
  if (axis.bit != 0) fill_uniform(detail::source_stream(setting.axes[i], kRemainder), 0, u);
  axis.remainder = axis.bit == 0 ? 0 : axis.bit * (u[0] - 0.5);
  const auto calibrated = static_cast<double>(detail::epoch_of(model, dt_).calibrated);
  if (calibrated == 0) return;
  const double rounding = axis.bit * (u[1] - u[0]) / (calibrated * dt_);
  constants_.calibrated_bias[i] = constants_.turn_on_bias[i] + axis.noise.calibrated_mean() + rounding;
}

Vector3 Triad::next(const Vector3& truth, const Vector3& v) {
  if (ideal_) return truth;
  if (at_ == detail::AxisNoise::kTile) {
    for (Axis& a : axes_) a.noise.next(a.slow, a.fast);
    at_ = 0;
  }
  if (temperature_) {
    const double t = (static_cast<double>(samples_++) + 0.5) * dt_, degrees = profile_->at(t),
                 slope = profile_->slope(t);
    for (std::size_t i = 0; i < kAxes; ++i) warm_bias_[i] = temperature_->bias(i, degrees, slope);
  }
  Vector3 y = deforms_ ? sensed(truth, v) : truth;
  for (std::size_t i = 0; i < kAxes; ++i) y[i] = read(i, y[i]);
  ++at_;
  return y;
}

Vector3 Triad::sensed(const Vector3& u, const Vector3& v) const {
  Vector3 e = u;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Vector3 &m = deformation_[i], &g = constants_.g_sensitivity[i];
    e[i] += m[0] * u[0] + m[1] * u[1] + m[2] * u[2] + g[0] * v[0] + g[1] * v[1] + g[2] * v[2] +
            constants_.g2_sensitivity[i] * v[i] * v[i] / dt_;
  }
  return e;
}

double Triad::read(std::size_t i, double increment) {
  Axis& axis = axes_[i];
  if (axis.low_pass) increment = axis.low_pass->next(increment);
  if (axis.delay) increment = axis.delay->next(increment);
  const double bias = constant_bias_[i] + warm_bias_[i] + axis.slow[at_];
  bias_[i] = bias - constants_.calibrated_bias[i];
  const double raw = saturate(i, increment + (bias + axis.fast[at_]) * dt_);
  return quantize(axis, raw) - constants_.calibrated_bias[i] * dt_;
}

double Triad::saturate(std::size_t i, double increment) {
  if (!(std::abs(increment) > limit_)) return increment;
  ++saturated_[i];
  return std::copysign(limit_, increment);
}

double Triad::quantize(Axis& axis, double increment) {
  if (axis.bit == 0) return increment;
  const double whole = axis.bit * std::nearbyint((axis.remainder + increment) / axis.bit);
  axis.remainder += increment - whole;
  return whole;
}

// --- Models ------------------------------------------------------------------------------------------------

ErrorModel with_epoch(ErrorModel model, const Imu::Options& options) {
  if (options.powered_on_before) model.powered_on_before = options.powered_on_before;
  if (options.calibrated_over) model.calibrated_over = options.calibrated_over;
  return model;
}

Triad make_triad(const ErrorModel& model, const ErrorSources& sources, std::uint64_t first_stream, double dt,
                 ImuKey key, const Imu::Options& options) {
  Triad::Setting setting{dt, options.vibration, {}, {options.duration, options.poles_per_decade}, options.temperature};
  for (std::size_t i = 0; i < kAxes; ++i) setting.axes[i] = {key.seed, first_stream + i};
  return {with_epoch(only(model, sources), options), setting};
}

}  // namespace

ErrorModel only(const ErrorModel& model, const ErrorSources& sources) {
  ErrorModel m = model;
  const auto off = [&](ErrorSource s) { return !sources.has(s); };
  if (off(ErrorSource::turn_on_bias)) m.turn_on_bias.reset();
  if (off(ErrorSource::scale_factor)) m.scale_factor.reset();
  if (off(ErrorSource::misalignment)) m.misalignment.reset();
  if (off(ErrorSource::g_sensitivity)) m.g_sensitivity.reset();
  if (off(ErrorSource::g2_sensitivity)) m.g2_sensitivity.reset();
  if (off(ErrorSource::vibration_rectification)) m.vibration_rectification.reset();
  if (off(ErrorSource::white)) m.white = 0;
  if (off(ErrorSource::flicker)) m.bias_instability = 0;
  if (off(ErrorSource::rate_random_walk)) m.rate_random_walk = 0;
  if (off(ErrorSource::rate_ramp)) m.rate_ramp = 0;
  if (off(ErrorSource::gauss_markov)) m.gauss_markov.clear();
  if (off(ErrorSource::sinusoid)) m.sinusoids.clear();
  if (off(ErrorSource::quantization)) m.quantization = 0;
  if (off(ErrorSource::bandwidth)) m.filter.reset();
  if (off(ErrorSource::delay)) m.delay.reset();
  if (off(ErrorSource::range)) m.range.reset();
  if (off(ErrorSource::temperature)) m.temperature.reset();
  return m;
}

std::vector<ErrorSource> not_stated(const ErrorModel& model, Signal signal) {
  std::vector<ErrorSource> list;
  const auto check = [&](ErrorSource source, const std::optional<PerAxis>& value) {
    if (!value) list.push_back(source);
  };
  if (!model.calibrated_over) check(ErrorSource::turn_on_bias, model.turn_on_bias);
  check(ErrorSource::scale_factor, model.scale_factor);
  check(ErrorSource::misalignment, model.misalignment);
  if (signal == Signal::angular_rate) check(ErrorSource::g_sensitivity, model.g_sensitivity);
  return list;
}

struct Imu::State {
  Triad gyro, accelerometer;
  ImuConstants constants;
};

Imu::Imu(const SensorModel& model, double dt, ImuKey key, const Options& options) : state_(std::make_unique<State>()) {
  require_interval(dt);
  require_size("vibration level", options.vibration);
  require_size("duration", options.duration);
  constexpr std::uint64_t kStreams = 8;  // a run has six
  if (key.run >> 45 != 0) {
    throw std::invalid_argument(fmt::format("run is {}; it must be below 2^45", key.run));
  }
  const std::uint64_t first = key.run * kStreams;
  state_->gyro = make_triad(model.gyro, options.gyro, first, dt, key, options);
  if (model.accelerometer) {
    ErrorModel accelerometer = *model.accelerometer;
    accelerometer.g_sensitivity.reset();  // of an accelerometer, that is its scale factor and misalignment
    state_->accelerometer = make_triad(accelerometer, options.accelerometer, first + kAxes, dt, key, options);
  }
  state_->constants = {state_->gyro.constants(), state_->accelerometer.constants()};
}
Imu::~Imu() = default;
Imu::Imu(Imu&&) noexcept = default;
Imu& Imu::operator=(Imu&&) noexcept = default;

ImuIncrement Imu::next(const ImuIncrement& truth) {
  return {.angle = state_->gyro.next(truth.angle, truth.velocity),
          .velocity = state_->accelerometer.next(truth.velocity, truth.velocity)};
}

const ImuConstants& Imu::constants() const { return state_->constants; }
const Vector3& Imu::gyro_bias() const { return state_->gyro.bias(); }
const Vector3& Imu::accelerometer_bias() const { return state_->accelerometer.bias(); }
const std::array<std::uint64_t, 3>& Imu::gyro_saturated() const { return state_->gyro.saturated(); }
const std::array<std::uint64_t, 3>& Imu::accelerometer_saturated() const { return state_->accelerometer.saturated(); }

}  // namespace gyrobudget::inline v0::noise

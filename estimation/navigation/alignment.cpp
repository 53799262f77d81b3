// SPDX-License-Identifier: MIT
#include "alignment.h"

#include "gyrobudget/estimation/navigation/detail/gauss_markov.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sensor_states.h"

namespace gyrobudget::inline v0::navigation {
namespace {

using earth::kDegree;
using earth::wgs84::kEarthRate;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr std::size_t kParts = 6;
constexpr double kStudent = 2.570582 / 1.959964;  // t of 95 % with kParts - 1 degrees of freedom, beside normal's
constexpr double kUnknownHeading = pi * std::numbers::inv_sqrt3;  // sigma of an angle that may be any
constexpr double kSteepest = 1e-3;                                // horizontal part of a heading's axis

/// From errors of mean specific force and rate in east, north, up to psi.
struct Jacobian {
  Matrix3d force = Matrix3d::Zero();
  Matrix3d rate = Matrix3d::Zero();
};

/// Variances of the means over T, per body axis.
struct Variances {
  Vector3d bias, calibration, noise;
  Vector3d wander;  ///< by which slow errors alone make the means of the record's parts scatter
};

double squared(double x) { return x * x; }

Vector3d squares(const std::optional<noise::PerAxis>& sigma) {
  if (!sigma) return Vector3d::Zero();
  return Vector3d((*sigma)[0], (*sigma)[1], (*sigma)[2]).cwiseAbs2();
}

// How far means over T lie from where a slow process was known last: [0, T] against the value at -P, or against the
// mean over [-C, 0]. Variances beside that of the process' unit.

double moved_walk(const Epoch& epoch, double T) {
  return T / 3 + (epoch.calibrated_over ? *epoch.calibrated_over / 3 : epoch.powered_on_before);
}

double moved_gauss_markov(const Epoch& epoch, double T, double correlation_time) {
  using detail::mean_exponential, detail::mean_variance;
  const double t = T / correlation_time;
  if (!epoch.calibrated_over) return mean_variance(t);  // stationary
  const double c = *epoch.calibrated_over / correlation_time;
  return std::max(0.0, mean_variance(t) + mean_variance(c) - 2 * mean_exponential(t) * mean_exponential(c));
}

double x_log_x(double x) { return x > 0 ? x * std::log(x) : 0; }

// D(u) = (2 B^2/pi) (ln(4 u/dt) + gamma) at many samples of dt: E (y - z)^2 of two means is the mean of D between them
// less half of that within each, which is ln T - 3/2 of a mean's ln u.
double moved_flicker(const Epoch& epoch, double T, double dt) {
  constexpr double kWithin = 1.5;
  if (epoch.calibrated_over) {
    const double C = *epoch.calibrated_over, both = T + C;
    const double between = (both * x_log_x(both) - T * x_log_x(T) - C * x_log_x(C)) / (2 * T * C) - kWithin;
    return 2 / pi * (between - (std::log(T) + std::log(C)) / 2 + kWithin);
  }
  const double P = epoch.powered_on_before;
  const double between = (x_log_x(T + P) - x_log_x(P)) / T - 1;
  const double fast = std::log(4 / dt) + std::numbers::egamma;
  return 2 / pi * std::max(0.0, fast / 2 + between - (std::log(T) - kWithin) / 2);
}

// Expected scatter() of an axis by what varies slowly: means of n parts differ as D within the record does from that
// within a part.
double wander(const noise::ErrorModel& model, std::size_t axis, double T) {
  constexpr double n = kParts;
  double within = squared(model.rate_random_walk[axis]) * T / 3 * (1 - 1 / n) +
                  squared(model.bias_instability[axis]) * 2 / pi * std::log(n);
  for (const noise::TriadGaussMarkov& process : model.gauss_markov) {
    const double t = T / process.correlation_time;
    within += 2 * squared(process.sigma[axis]) * (detail::mean_variance(t / n) - detail::mean_variance(t));
  }
  return within / (2 * (n - 1));
}

/// `signal` is what the triad senses, `force` what it is under.
Variances variances(const noise::ErrorModel& model, const Vector3d& signal, const Vector3d& force, double T,
                    double interval) {
  const Epoch epoch = epoch_of(model);
  // The mean of R t from power-on, or from the middle of the calibration, to the middle of the record.
  const double ramped = T / 2 + (epoch.calibrated_over ? *epoch.calibrated_over / 2 : epoch.powered_on_before);
  Vector3d moved = squares(model.rate_random_walk) * moved_walk(epoch, T) + squares(model.rate_ramp) * squared(ramped);
  if (model.bias_instability != 0) moved += squares(model.bias_instability) * moved_flicker(epoch, T, interval);
  for (const noise::TriadGaussMarkov& process : model.gauss_markov)
    moved += squares(process.sigma) * moved_gauss_markov(epoch, T, process.correlation_time);
  const Vector3d constant =
      model.calibrated_over ? Vector3d(squares(model.white) / *model.calibrated_over) : squares(model.turn_on_bias);
  const Vector3d across = Vector3d::Constant(signal.squaredNorm()) - signal.cwiseAbs2();
  const Vector3d calibration = squares(model.scale_factor).cwiseProduct(signal.cwiseAbs2()) +
                               squares(model.misalignment).cwiseProduct(across) +
                               squares(model.g_sensitivity) * force.squaredNorm() +
                               squares(model.g2_sensitivity).cwiseProduct(force.cwiseAbs2().cwiseAbs2());
  const Vector3d noise = squares(model.white) / T + 2 / squared(T) * squares(model.quantization);
  return {constant + moved, calibration, noise, {wander(model, 0, T), wander(model, 1, T), wander(model, 2, T)}};
}

/// C_lb of east, north, up from the vertical and any vector with a part to the north.
Matrix3d axes(const Vector3d& up_b, const Vector3d& northward_b) {
  const Vector3d east = northward_b.cross(up_b).normalized();
  Matrix3d C_lb;
  C_lb << east.transpose(), up_b.cross(east).transpose(), up_b.transpose();
  return C_lb;
}

Eigen::Quaterniond north_east_down(const Matrix3d& C_enu_b) {
  Matrix3d C_nb;
  C_nb << C_enu_b.row(1), C_enu_b.row(0), -C_enu_b.row(2);
  return Eigen::Quaterniond(C_nb);
}

Matrix3d mapped(const Matrix3d& J, const Vector3d& variance) { return J * variance.asDiagonal() * J.transpose(); }

void check(const AlignmentOptions& options) {
  if (options.latitude && !(std::abs(*options.latitude) <= pi / 2))
    throw SetupError(
        fmt::format("latitude {} degrees of the alignment must be within 90", *options.latitude / kDegree));
  if (!(options.heading_limit > 0) || !std::isfinite(options.heading_limit))
    throw SetupError(fmt::format("limit {} rad of the heading must be positive, finite", options.heading_limit));
  if (!(options.interval > 0) || !std::isfinite(options.interval))
    throw SetupError(fmt::format("interval {} s of the IMU must be positive", options.interval));
  check(epoch_of(options.sensor.gyro), "gyro");
  if (options.sensor.accelerometer) check(epoch_of(*options.sensor.accelerometer), "accelerometer");
  if (!options.heading) return;
  const GivenHeading& heading = *options.heading;
  if (!std::isfinite(heading.azimuth) || !(heading.sigma >= 0) || !std::isfinite(heading.sigma))
    throw SetupError(
        fmt::format("heading {} +- {} rad must be finite, its sigma not negative", heading.azimuth, heading.sigma));
  if (!heading.axis.allFinite() || !(heading.axis.norm() > 0))
    throw SetupError("axis of the heading must be finite and not zero");
}

void check(const StaticMeans& means) {
  if (!means.f_ib_b.allFinite() || !means.w_ib_b.allFinite() || !(means.f_ib_b.norm() > 0))
    throw std::invalid_argument("mean specific force and rate must be finite, and the force not zero");
  if (!(means.duration > 0) || !std::isfinite(means.duration))
    throw std::invalid_argument(fmt::format("duration {} s of the record must be positive", means.duration));
}

/// One alignment under way.
class Aligner {
 public:
  Aligner(const StaticMeans& means, const AlignmentOptions& options, std::span<const StaticMeans> parts)
      : options_(options), parts_(parts) {
    check(means);
    check(options);
    a_.means = means;
    g_ = means.f_ib_b.norm();
    a_.up_b = means.f_ib_b / g_;
    gyro_ = variances(options.sensor.gyro, means.w_ib_b, means.f_ib_b, means.duration, options.interval);
    accelerometer_ = variances(options.sensor.accelerometer.value_or(noise::ErrorModel{}), means.f_ib_b, means.f_ib_b,
                               means.duration, options.interval);
  }

  Alignment run() {
    find_latitude();
    gyrocompass();
    if (options_.heading) use_given_heading();
    const noise::ErrorModel& gyro = options_.sensor.gyro;
    if (!gyro.turn_on_bias && !gyro.calibrated_over && !options_.heading)
      say("The gyro's file states no turn-on bias: heading's sigma leaves it out.");
    return std::move(a_);
  }

 private:
  void say(const std::string& sentence) {
    if (!a_.message.empty()) a_.message += ' ';
    a_.message += sentence;
  }

  void find_latitude() {
    const Vector3d& w = a_.means.w_ib_b;
    const double rate = w.norm();
    a_.latitude = rate > 0 ? std::asin(std::clamp(w.dot(a_.up_b) / rate, -1.0, 1.0)) : 0;
    latitude_ = options_.latitude.value_or(a_.latitude);
  }

  Matrix3d level() const {
    Matrix3d force = Matrix3d::Zero();
    force(0, 1) = -1 / g_;
    force(1, 0) = 1 / g_;
    return force;
  }

  void gyrocompass() {
    const Vector3d& w = a_.means.w_ib_b;
    const double c = kEarthRate * std::cos(latitude_);
    const Vector3d across = w - a_.up_b * a_.up_b.dot(w);
    // Where nothing is seen, any axis serves to speak of level.
    C_lb_ = axes(a_.up_b, across.norm() > 0 ? across : Vector3d(a_.up_b.unitOrthogonal()));
    Jacobian J{.force = level()};
    J.force(2, 0) = std::tan(latitude_) / g_;
    J.rate(2, 0) = -1 / c;
    account(J);
    latitude_uncertainty();
    const double sigma = a_.sigma().z();
    const double seen = across.norm() / c;
    a_.heading_observable = sigma <= options_.heading_limit && seen > 0.5 && seen < 2;
    if (a_.heading_observable) {
      a_.q_nb = north_east_down(C_lb_);
      return;
    }
    if (!(sigma <= options_.heading_limit))
      say(fmt::format(
          "Heading is not observable: its one sigma would be {:.3g} degrees, where {:.3g} are allowed (gyro bias {:.3g}, noise {:.3g}, motion {:.3g}).",
          sigma / kDegree, options_.heading_limit / kDegree, a_.parts.bias.z() / kDegree, a_.parts.noise.z() / kDegree,
          a_.parts.motion.z() / kDegree));
    else
      say(fmt::format(
          "Heading is not observable: the horizontal rate is {:.3g} deg/h where Earth's is {:.3g}; the body turns, or latitude or unit is wrong.",
          across.norm() / kDegree * 3600, c / kDegree * 3600));
    if (!options_.heading) say("Give the heading.");
    a_.parts.bias.z() = a_.parts.calibration.z() = a_.parts.noise.z() = a_.parts.motion.z() = 0;
    a_.covariance.row(2).setZero();
    a_.covariance.col(2).setZero();
    a_.covariance(2, 2) = squared(kUnknownHeading);
    a_.by_means.row(2).setZero();
    a_.gyro_bias_covariance.row(2).setZero();
    a_.accelerometer_bias_covariance.row(2).setZero();
  }

  /// psi_U = e + v/h^2 (E psi_E + N psi_N) for an axis (E, N, v) with horizontal part h.
  void use_given_heading() {
    const GivenHeading& given = *options_.heading;
    const Vector3d axis = given.axis.normalized();
    const double v = axis.dot(a_.up_b);
    const Vector3d horizontal = axis - v * a_.up_b;
    const double h = horizontal.norm();
    if (h < kSteepest) {
      say("The axis of the given heading is vertical: give that of another.");
      return;
    }
    // The axis lies at `azimuth`: north is that far to its left.
    C_lb_ = axes(a_.up_b, Eigen::AngleAxisd(given.azimuth, a_.up_b) * horizontal);
    Jacobian J{.force = level()};
    const Vector3d local = C_lb_ * axis;
    J.force.row(2) = v / (h * h) * (local.x() * J.force.row(0) + local.y() * J.force.row(1));
    account(J);
    a_.parts.heading.z() = given.sigma;
    a_.covariance(2, 2) += squared(given.sigma);
    a_.q_nb = north_east_down(C_lb_);
  }

  void account(const Jacobian& J) {
    const Matrix3d rate = J.rate * C_lb_;
    const Matrix3d force = J.force * C_lb_;
    const Matrix3d bias = mapped(rate, gyro_.bias) + mapped(force, accelerometer_.bias);
    const Matrix3d calibration = mapped(rate, gyro_.calibration) + mapped(force, accelerometer_.calibration);
    const Matrix3d noise = mapped(rate, gyro_.noise) + mapped(force, accelerometer_.noise);
    const Vector3d known =
        noise.diagonal() + (mapped(rate, gyro_.wander) + mapped(force, accelerometer_.wander)).diagonal();
    const Vector3d motion = squared(kStudent) * (scatter(rate, force) - known).cwiseMax(0);
    a_.parts = {.bias = bias.diagonal().cwiseSqrt(),
                .calibration = calibration.diagonal().cwiseSqrt(),
                .noise = noise.diagonal().cwiseSqrt(),
                .motion = motion.cwiseSqrt()};
    a_.covariance = bias + calibration + noise;
    a_.covariance.diagonal() += motion;
    a_.by_means << rate, force;
    a_.gyro_bias_covariance = rate * gyro_.bias.asDiagonal();
    a_.accelerometer_bias_covariance = force * accelerometer_.bias.asDiagonal();
    a_.gyro_bias_variance = gyro_.bias;
    a_.accelerometer_bias_variance = accelerometer_.bias;
    a_.mean_error_variance << gyro_.bias + gyro_.calibration, accelerometer_.bias + accelerometer_.calibration;
  }

  /// Variance of the mean psi over the whole record as the parts show it.
  Vector3d scatter(const Matrix3d& rate, const Matrix3d& force) const {
    Vector3d sum = Vector3d::Zero();
    for (const StaticMeans& part : parts_)
      sum += (rate * (part.w_ib_b - a_.means.w_ib_b) + force * (part.f_ib_b - a_.means.f_ib_b)).cwiseAbs2();
    return sum / (kParts * (kParts - 1));
  }

  /// sin L = u.w/|w|: dL = (cos L dw_U - sin L dw_N)/Omega - df_N/g.
  void latitude_uncertainty() {
    const double s = std::sin(a_.latitude);
    const double c = std::cos(a_.latitude);
    Eigen::RowVector3d rate(0, -s / kEarthRate, c / kEarthRate);
    Eigen::RowVector3d force(0, -1 / g_, 0);
    rate = rate * C_lb_;
    force = force * C_lb_;
    const Vector3d dw = gyro_.bias + gyro_.calibration + gyro_.noise;
    const Vector3d df = accelerometer_.bias + accelerometer_.calibration + accelerometer_.noise;
    double motion = 0;
    for (const StaticMeans& part : parts_)
      motion += squared(rate.dot(part.w_ib_b - a_.means.w_ib_b) + force.dot(part.f_ib_b - a_.means.f_ib_b));
    motion *= squared(kStudent) / (kParts * (kParts - 1));
    a_.latitude_sigma = std::sqrt(rate.cwiseAbs2().dot(dw) + force.cwiseAbs2().dot(df) + motion);
  }

  const AlignmentOptions& options_;
  std::span<const StaticMeans> parts_;
  Alignment a_;
  double g_ = 0;
  double latitude_ = 0;
  Variances gyro_, accelerometer_;
  Matrix3d C_lb_;  ///< l: east, north, up
};

StaticMeans means_of(std::span<const noise::ImuIncrement> imu, double dt) {
  const double T = dt * static_cast<double>(imu.size());
  StaticMeans means{Vector3d::Zero(), Vector3d::Zero(), T};
  for (const noise::ImuIncrement& increment : imu) {
    means.f_ib_b += earth::vector(increment.velocity);
    means.w_ib_b += earth::vector(increment.angle);
  }
  means.f_ib_b /= T;
  means.w_ib_b /= T;
  return means;
}

}  // namespace

GivenHeading heading_of(const Eigen::Quaterniond& q_nb, double sigma) {
  const Matrix3d C_nb = q_nb.toRotationMatrix();
  Eigen::Index axis = 0;
  C_nb.row(2).cwiseAbs().minCoeff(&axis);
  return {std::atan2(C_nb(1, axis), C_nb(0, axis)), sigma, Vector3d::Unit(axis)};
}

Alignment align(std::span<const noise::ImuIncrement> imu, double dt, const AlignmentOptions& options) {
  if (imu.size() < 2 * kParts)
    throw SetupError(fmt::format("{} increments are too few to align: {} at least", imu.size(), 2 * kParts));
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("interval {} s of the increments must be positive", dt));
  std::array<StaticMeans, kParts> parts;
  for (std::size_t k = 0; k < kParts; ++k) {
    const std::size_t from = k * imu.size() / kParts;
    parts[k] = means_of(imu.subspan(from, (k + 1) * imu.size() / kParts - from), dt);
  }
  AlignmentOptions sampled = options;
  sampled.interval = dt;
  return Aligner(means_of(imu, dt), sampled, parts).run();
}

Alignment align(const StaticMeans& means, const AlignmentOptions& options) { return Aligner(means, options, {}).run(); }

}  // namespace gyrobudget::inline v0::navigation

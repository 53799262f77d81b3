// SPDX-License-Identifier: MIT
#include "start.h"

#include "gyrobudget/estimation/navigation/alignment.h"
#include "gyrobudget/estimation/navigation/planned_fix.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/gravity.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "measure_fix.h"

namespace gyrobudget::inline v0::navigation::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

using noise::kNanosecond;

double log_start(const ImuLog& imu, std::int64_t origin) {
  return static_cast<double>(imu.stamps.front() - origin) * kNanosecond;
}
double log_end(const ImuLog& imu, std::int64_t origin) {
  return static_cast<double>(imu.stamps.back() - origin) * kNanosecond;
}

template <class Variant>
const FromAid* from_aid(const Variant& v) {
  return std::get_if<FromAid>(&v);
}

// --- The IMU at rest -----------------------------------------------------------------------------------------

struct AtRest {
  Quaterniond q_nb;
  Matrix3d covariance;                             ///< of psi, east, north, up
  Eigen::Matrix<double, 3, Eigen::Dynamic> cross;  ///< of psi with the model's terms
  std::string message;
};

struct Piece {
  std::span<const noise::ImuIncrement> increments;
  double seconds = 0;
};

// The samples whose middle lies in the span.
Piece piece_of(const Recording& recording, const Span& span) {
  const ImuLog& imu = recording.imu;
  std::size_t first = imu.increments.size(), last = 0;
  for (std::size_t k = 0; k < imu.increments.size(); ++k) {
    const double middle =
        static_cast<double>(imu.stamps[k] - recording.origin + (imu.stamps[k + 1] - imu.stamps[k]) / 2) * kNanosecond;
    if (middle < span.from || middle > span.to) continue;
    first = std::min(first, k);
    last = k + 1;
  }
  if (first >= last) return {};
  return {std::span(imu.increments).subspan(first, last - first),
          static_cast<double>(imu.stamps[last] - imu.stamps[first]) * kNanosecond};
}

// Mean errors of gyro x, y, z and accelerometer x, y, z over some time that come from the model's terms, as in "reads
// true + b": one step of the error model that long.
struct MeanErrors {
  Eigen::Matrix<double, 6, 1> variance;
  Eigen::Matrix<double, 6, Eigen::Dynamic> with_terms;  ///< covariance with the terms where the time ends
};

MeanErrors mean_errors(ErrorStateModel model, const StateMatrix& terms, const StepInput& over) {
  model.gyro_white.setZero();  // what it adds is no term's
  model.accelerometer_white.setZero();
  Lineariser lineariser(std::move(model));
  const Transition& step = lineariser(over);
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_terms = decltype(by_terms)::Zero(6, terms.cols());
  Eigen::VectorXd decay(terms.cols());
  for (Eigen::Index k = 0; k < terms.cols(); ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    decay[k] = term.decay;
    if (term.signal >= 0) by_terms(term.signal, k) = -term.gain;
  }
  MeanErrors result;
  result.with_terms = by_terms * terms;
  result.variance = step.input_noise + result.with_terms.cwiseProduct(by_terms).rowwise().sum();
  result.with_terms = result.with_terms * decay.asDiagonal();
  for (Eigen::Index k = 0; k < terms.cols(); ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.signal < 0) continue;
    result.with_terms(term.signal, k) -= term.spill * term.noise;
    result.variance[term.signal] += term.spill * term.spill * term.noise;
  }
  return result;
}

// psi of the alignment is J times mean errors, plus the rest. What it assumed of them beyond the terms, such as a ramp,
// stays.
void correlate(const Alignment& alignment, const MeanErrors& of_terms, AtRest& result) {
  const auto& J = alignment.by_means;
  const Eigen::Matrix<double, 6, 1> more = (of_terms.variance - alignment.mean_error_variance).cwiseMax(0);
  result.cross = J * of_terms.with_terms;
  result.covariance += J * more.asDiagonal() * J.transpose();
}

// The file's errors with the epoch that the states have.
noise::SensorModel sensor_at_epoch(const Scenario& scenario) {
  noise::SensorModel sensor = scenario.sensor;
  const auto set = [](noise::ErrorModel& errors, const std::optional<Epoch>& epoch) {
    if (!epoch) return;
    errors.powered_on_before = epoch->powered_on_before;
    errors.calibrated_over = epoch->calibrated_over;
  };
  set(sensor.gyro, scenario.states.gyro);
  if (sensor.accelerometer) set(*sensor.accelerometer, scenario.states.accelerometer);
  return sensor;
}

std::variant<NoStart, AtRest> align_at_rest(const Scenario& scenario, const Recording& recording, const Span& span,
                                            const Vector3d& p_eb_e, const ErrorStateModel& model,
                                            const StateMatrix& terms) {
  const auto& self = std::get<SelfAlignment>(scenario.alignment.attitude);
  const Piece piece = piece_of(recording, span);
  constexpr std::size_t kFewest = 12;
  if (piece.increments.size() < kFewest)
    return NoStart{Navigation::Status::no_start,
                   fmt::format("{} IMU samples from {:g} s to {:g} s, the alignment needs {}", piece.increments.size(),
                               span.from, span.to, kFewest)};
  AlignmentOptions options;
  options.sensor = sensor_at_epoch(scenario);
  options.latitude = earth::to_geodetic(p_eb_e).latitude;
  const double dt = piece.seconds / static_cast<double>(piece.increments.size());
  Alignment found = align(piece.increments, dt, options);
  if (self.heading) {
    constexpr double kNearlyUp = 0.9;
    const bool nose_up = std::abs(found.up_b.x()) > kNearlyUp;
    options.heading = GivenHeading{*self.heading, scenario.alignment.heading_sigma.value_or(0),
                                   nose_up ? Vector3d::UnitZ() : Vector3d::UnitX()};
    found = align(piece.increments, dt, options);
  }
  const double force = found.means.f_ib_b.norm(), gravity = earth::normal_gravity(p_eb_e).norm();
  // Gravity's anomalies, and what the sensor may read wrong.
  constexpr double kAnomaly = 1e-3, kSigmas = 5;
  const double of_sensor = std::sqrt(found.mean_error_variance.tail<3>().dot(found.up_b.cwiseAbs2()));
  const double may_err = kAnomaly * gravity + kSigmas * of_sensor;
  if (!(std::abs(force - gravity) < may_err)) {
    return NoStart{
        Navigation::Status::not_at_rest,
        fmt::format(
            "over the {:g} s of the alignment the mean specific force is {:.5f} m/s^2 and gravity {:.5f}, more apart than the {:.2g} m/s^2 that this sensor may be off at rest; look at units and axes of the log, or align where the body stands",
            piece.seconds, force, gravity, may_err)};
  }
  if (!found.q_nb)
    return NoStart{Navigation::Status::heading_not_observable,
                   found.message + " The alignment takes heading and heading_sigma, or the attitude of an aid."};
  AtRest result{*found.q_nb, found.covariance, {}, found.message};
  const StepInput over{span.to - span.from, p_eb_e, Matrix3d::Identity(), found.means.w_ib_b, found.means.f_ib_b};
  correlate(found, mean_errors(model, terms, over), result);
  return result;
}

// --- Putting it together -------------------------------------------------------------------------------------

Matrix3d squares(const Vector3d& sigma, const Matrix3d& axes) {
  return axes * sigma.cwiseAbs2().asDiagonal() * axes.transpose();
}

struct Place {
  Matrix3d C_enu, C_ned;
};

Place axes_at(const Vector3d& p_eb_e) {
  const earth::Geodetic at = earth::to_geodetic(p_eb_e);
  return {earth::C_e_enu(at.latitude, at.longitude), earth::C_e_ned(at.latitude, at.longitude)};
}

void say_attitude(AlignmentResult& result, const Quaterniond& q_nb, const Matrix3d& covariance_enu) {
  const earth::Euler euler = earth::to_euler(q_nb);
  result.words.push_back(fmt::format(
      "heading {:.3f} deg, pitch {:.3f} deg, roll {:.3f} deg at {:g} s; one sigma {:.3g} deg in heading, {:.3g} deg in level",
      euler.yaw / earth::kDegree, euler.pitch / earth::kDegree, euler.roll / earth::kDegree, result.to,
      std::sqrt(covariance_enu(2, 2)) / earth::kDegree,
      std::sqrt(std::max(covariance_enu(0, 0), covariance_enu(1, 1))) / earth::kDegree));
}

// The covariance of terms some time later.
StateMatrix moved_on(const std::vector<ErrorTerm>& terms, StateMatrix P, double dt) {
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double left = decay(terms[k], dt);
    P.row(i) *= left;
    P.col(i) *= left;
    P(i, i) += terms[k].walk * terms[k].walk * dt * mean_decay(terms[k], 2 * dt);
  }
  return P;
}

// The start, part by part: attitude, then velocity and position, for which a lever arm needs it, then what they have
// in common.
class Starter {
 public:
  Starter(const Scenario& scenario, const Recording& recording, const std::vector<FixTrack>& tracks, const Span& span,
          const ErrorStateModel& model, const StateMatrix& terms)
      : scenario_(scenario),
        plan_(scenario.alignment),
        recording_(recording),
        tracks_(tracks),
        span_(span),
        model_(model),
        terms_at_start_(terms),
        terms_(moved_on(model.terms, terms, span.to - span.from)) {
    result_.result.from = span.from;
    result_.result.to = span.to;
    result_.used_to.assign(scenario.aids.size(), span.to);
  }

  std::variant<NoStart, Start> operator()() {
    std::optional<NoStart> no = place();
    if (!no) no = attitude();
    if (!no) no = velocity();
    if (no) return *no;
    take_off_lever_arm();
    covariance();
    if (std::min(scenario_.until, log_end(recording_.imu, recording_.origin)) <= span_.to)
      result_.result.words.emplace_back("the log ends with the alignment: there is nothing to navigate");
    say_attitude(result_.result, Quaterniond(axes_.C_ned).conjugate() * state().q_eb,
                 axes_.C_enu.transpose() * psi_ * axes_.C_enu);
    return std::move(result_);
  }

 private:
  using Cross = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  earth::Pose& state() { return result_.result.state; }

  // What a fix says where an aid gives the quantity.
  template <typename Given>
  std::optional<Fix> fix(const Given& given) {
    const auto* from = std::get_if<FromAid>(&given);
    if (from == nullptr) return std::nullopt;
    const FixTrack& track = tracks_[from->aid];
    const std::optional<Fix> found = track.at(span_.to);
    constexpr double kSame = 1e-8;  // s: rounded stamps
    const std::size_t next = track.first_from(span_.to - kSame);
    if (found && next < track.size()) result_.used_to[from->aid] = track.time(next);
    return found;
  }
  // The aid, with the errors of the fix that the start is taken from.
  template <typename Given>
  [[nodiscard]] Aid aid_of(const Given& given) const {
    const std::size_t number = std::get<FromAid>(given).aid;
    Aid aid = scenario_.aids[number];
    aid.sigma = sigma_of(aid, tracks_[number].at(span_.to).value_or(Fix{}));
    aid.sigma_factor = 1;
    return aid;
  }

  // Where, but for the lever arm.
  std::optional<NoStart> place() {
    if (const auto* given = std::get_if<earth::Geodetic>(&plan_.position)) {
      state().p_eb_e = earth::to_ecef(*given);
    } else if (const auto found = fix(plan_.position)) {
      state().p_eb_e = found->value;
    } else {
      return NoStart{Navigation::Status::no_start,
                     "the aid that gives the position has no fix where the alignment ends"};
    }
    axes_ = axes_at(state().p_eb_e);
    return std::nullopt;
  }

  std::optional<NoStart> attitude() {
    cross_ = Cross::Zero(3, terms_.cols());
    Quaterniond q_nb = Quaterniond::Identity();
    if (std::holds_alternative<SelfAlignment>(plan_.attitude)) {
      auto aligned = align_at_rest(scenario_, recording_, span_, state().p_eb_e, model_, terms_at_start_);
      if (auto* no = std::get_if<NoStart>(&aligned)) return *no;
      const auto& at_rest = std::get<AtRest>(aligned);
      q_nb = at_rest.q_nb;
      psi_ = axes_.C_enu * at_rest.covariance * axes_.C_enu.transpose();
      cross_ = axes_.C_enu * at_rest.cross;
      if (!at_rest.message.empty()) result_.result.words.push_back(at_rest.message);
    } else {
      double sigma = 0;
      if (const auto* euler = std::get_if<earth::Euler>(&plan_.attitude)) {
        q_nb = earth::from_euler(*euler);
      } else if (const auto found = fix(plan_.attitude)) {
        q_nb = found->q_nb;
        sigma = total_sigma(aid_of(plan_.attitude)).maxCoeff();
      } else {
        return NoStart{Navigation::Status::no_start,
                       "the aid that gives the attitude has no fix where the alignment ends"};
      }
      const double level = plan_.level_sigma.value_or(sigma);
      psi_ = squares({level, level, plan_.heading_sigma.value_or(sigma)}, axes_.C_enu);
    }
    state().q_eb = to_ecef_axes(q_nb, state().p_eb_e);
    return std::nullopt;
  }

  std::optional<NoStart> velocity() {
    look_at_imu();
    if (const auto* v_n = std::get_if<Vector3d>(&plan_.velocity)) {
      state().v_eb_e = axes_.C_ned * *v_n;
    } else if (const auto found = fix(plan_.velocity)) {
      state().v_eb_e = axes_.C_ned * found->value - state().q_eb * w_eb_b_.cross(aid_of(plan_.velocity).lever_arm);
    } else {
      return NoStart{Navigation::Status::no_start,
                     "the aid that gives the velocity has no fix where the alignment ends"};
    }
    return std::nullopt;
  }

  void take_off_lever_arm() {
    if (std::holds_alternative<FromAid>(plan_.position))
      state().p_eb_e -= state().q_eb * aid_of(plan_.position).lever_arm;
  }

  // How the body turns, and what it is under, by the sample in which the start falls.
  void look_at_imu() {
    const ImuLog& imu = recording_.imu;
    const auto at = recording_.origin + std::llround(span_.to / kNanosecond);
    const auto end = std::ranges::upper_bound(imu.stamps, at);
    const auto k = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(
        end - imu.stamps.begin() - 1, 0, static_cast<std::ptrdiff_t>(imu.increments.size()) - 1));
    const double dt = static_cast<double>(imu.stamps[k + 1] - imu.stamps[k]) * kNanosecond;
    w_eb_b_ = earth::vector(imu.increments[k].angle) / dt -
              state().q_eb.conjugate() * Vector3d(0, 0, earth::wgs84::kEarthRate);
    f_ib_b_ = earth::vector(imu.increments[k].velocity) / dt;
  }

  // --- Covariance ---

  // One error with the aid's own: not where the filter never sees it, nor where the scene says how wrong the start is.
  template <typename Given>
  [[nodiscard]] bool is_the_aids(const Given& given, bool told) const {
    return std::holds_alternative<FromAid>(given) && !told && aid_of(given).used;
  }
  template <typename Given>
  [[nodiscard]] Matrix3d told(const Given& given, const std::optional<Vector3d>& sigma) const {
    const Vector3d of_aid = std::holds_alternative<FromAid>(given) ? total_sigma(aid_of(given)) : Vector3d::Zero();
    return squares(sigma.value_or(of_aid), axes_.C_enu);
  }
  template <typename Given>
  [[nodiscard]] static int number(const Given& given) {
    return static_cast<int>(std::get<FromAid>(given).aid);
  }

  void covariance() {
    const earth::Motion at = motion();
    if (is_the_aids(plan_.attitude, plan_.level_sigma || plan_.heading_sigma)) {
      const StartFromFix from =
          start_from({0, AttitudeFix{state().q_eb, aid_of(plan_.attitude).sigma, number(plan_.attitude)}}, at, model_);
      const Cross by_terms = from.by_terms.middleRows<3>(kAttitude);
      cross_ = by_terms * terms_;
      psi_ = cross_ * by_terms.transpose() + from.white.block<3, 3>(kAttitude, kAttitude);
    }
    // What the start has wrong by psi and the terms, and what is its own.
    const Eigen::Index n = terms_.cols();
    Eigen::MatrixXd joint(3 + n, 3 + n), by = Eigen::MatrixXd::Zero(kCoreStates + n, 3 + n);
    joint << psi_, cross_, cross_.transpose(), terms_;
    by.block<3, 3>(kAttitude, 0).setIdentity();
    by.bottomRightCorner(n, n).setIdentity();
    CoreMatrix own = CoreMatrix::Zero();
    const auto take = [&](const StartFromFix& from) {
      by.topLeftCorner<kCoreStates, 3>() += from.by_attitude;
      by.topRightCorner(kCoreStates, n) += from.by_terms;
      own += from.white;
    };
    if (is_the_aids(plan_.position, plan_.position_sigma.has_value())) {
      const Aid aid = aid_of(plan_.position);
      take(start_from({0, PositionFix{state().p_eb_e, aid.sigma, axes_.C_enu, aid.lever_arm, number(plan_.position)}},
                      at, model_));
    } else {
      own.block<3, 3>(kPosition, kPosition) = told(plan_.position, plan_.position_sigma);
    }
    if (is_the_aids(plan_.velocity, plan_.velocity_sigma.has_value())) {
      const Aid aid = aid_of(plan_.velocity);
      take(start_from({0, VelocityFix{state().v_eb_e, aid.sigma, axes_.C_enu, aid.lever_arm, number(plan_.velocity)}},
                      at, model_));
    } else {
      own.block<3, 3>(kVelocity, kVelocity) = told(plan_.velocity, plan_.velocity_sigma);
    }
    StateMatrix P = by * joint * by.transpose();
    P.topLeftCorner<kCoreStates, kCoreStates>() += own;
    result_.P0 = (P + P.transpose()) / 2;
    result_.result.covariance = result_.P0.topLeftCorner<kCoreStates, kCoreStates>();
  }

  [[nodiscard]] earth::Motion motion() {
    const Vector3d coriolis = 2 * Vector3d(0, 0, earth::wgs84::kEarthRate).cross(state().v_eb_e);
    return {.pose = state(),
            .a_eb_e = state().q_eb * f_ib_b_ + earth::normal_gravity(state().p_eb_e) - coriolis,
            .w_eb_b = w_eb_b_};
  }

  const Scenario& scenario_;
  const AlignmentPlan& plan_;
  const Recording& recording_;
  const std::vector<FixTrack>& tracks_;
  const Span& span_;
  const ErrorStateModel& model_;
  const StateMatrix& terms_at_start_;
  StateMatrix terms_;  ///< where the alignment ends
  Start result_;
  Place axes_;
  Matrix3d psi_;
  Cross cross_;  ///< of psi with the terms
  Vector3d w_eb_b_ = Vector3d::Zero(), f_ib_b_ = Vector3d::Zero();
};

}  // namespace

std::variant<NoStart, Span> start_span(const Scenario& scenario, const ImuLog& imu, const std::vector<FixTrack>& tracks,
                                       std::int64_t origin) {
  const AlignmentPlan& a = scenario.alignment;
  double from = std::max(a.start, log_start(imu, origin));
  std::string missing;
  const auto wait_for = [&](const FromAid* aid) {
    if (aid == nullptr) return;
    const FixTrack& track = tracks[aid->aid];
    const std::size_t first = track.first_from(from);
    if (first == track.size())
      missing = scenario.aids[aid->aid].name;
    else
      from = track.time(first);
  };
  wait_for(from_aid(a.attitude));
  wait_for(from_aid(a.velocity));
  wait_for(from_aid(a.position));
  if (!missing.empty())
    return NoStart{Navigation::Status::no_start,
                   fmt::format("{} has no fix from {:g} s on, which the alignment needs", missing, from)};
  const auto* self = std::get_if<SelfAlignment>(&a.attitude);
  const double end = std::min(scenario.until, log_end(imu, origin));
  if (from >= end)
    return NoStart{Navigation::Status::no_start,
                   fmt::format("the alignment starts at {:g} s, where the log ends at {:g} s", from, end)};
  const Span span{from, self != nullptr ? std::min(from + self->duration, end) : from};
  return span;
}

std::variant<NoStart, Start> start(const Scenario& scenario, const Recording& recording,
                                   const std::vector<FixTrack>& tracks, const Span& span, const ErrorStateModel& model,
                                   const StateMatrix& terms) {
  return Starter(scenario, recording, tracks, span, model, terms)();
}

}  // namespace gyrobudget::inline v0::navigation::detail

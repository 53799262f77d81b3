// SPDX-License-Identifier: MIT
#include "navigate.h"

#include "gyrobudget/estimation/navigation/detail/fix_track.h"
#include "gyrobudget/estimation/navigation/detail/run_parts.h"
#include "gyrobudget/estimation/navigation/detail/start.h"
#include "gyrobudget/noise/constants.h"
#include "gyrobudget/vehicle/earth/attitude.h"
#include "gyrobudget/vehicle/earth/frames.h"
#include "gyrobudget/vehicle/earth/vector.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "consistency.h"
#include "smoother.h"

namespace gyrobudget::inline v0::navigation {
namespace {

using detail::FixTrack;
using detail::kSame;
using detail::measure_fix;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// --- Checks --------------------------------------------------------------------------------------------------

void check_aid_number(const Scenario& scenario, std::size_t aid, Aid::Kind kind, const char* what) {
  if (aid >= scenario.aids.size())
    throw SetupError(fmt::format("{}: aid number {}, there are {}", what, aid, scenario.aids.size()));
  if (scenario.aids[aid].kind != kind)
    throw SetupError(fmt::format("{}: aid {} measures {}, not {}", what, scenario.aids[aid].name,
                                 name(scenario.aids[aid].kind), name(kind)));
}

void check(const Scenario& scenario, const Recording& recording) {
  if (recording.imu.increments.empty() || recording.imu.stamps.size() != recording.imu.increments.size() + 1)
    throw RecordingError(fmt::format("IMU log of {} increments and {} stamps, expected one stamp more",
                                     recording.imu.increments.size(), recording.imu.stamps.size()));
  if (recording.fixes.size() != scenario.aids.size())
    throw RecordingError(fmt::format("{} lists of fixes for {} aids", recording.fixes.size(), scenario.aids.size()));
  for (const Aid& aid : scenario.aids) navigation::check(aid);
  const AlignmentPlan& a = scenario.alignment;
  if (const auto* from = std::get_if<FromAid>(&a.position))
    check_aid_number(scenario, from->aid, Aid::Kind::position, "alignment's position");
  if (const auto* from = std::get_if<FromAid>(&a.velocity))
    check_aid_number(scenario, from->aid, Aid::Kind::velocity, "alignment's velocity");
  if (const auto* from = std::get_if<FromAid>(&a.attitude))
    check_aid_number(scenario, from->aid, Aid::Kind::attitude, "alignment's attitude");
  for (const std::size_t aid : scenario.reference) {
    if (aid >= scenario.aids.size()) check_aid_number(scenario, aid, Aid::Kind::position, "reference");
  }
  if (!(scenario.solution_interval > 0))
    throw SetupError(fmt::format("interval of solutions is {} s, expected above 0 s", scenario.solution_interval));
}

// --- The model -----------------------------------------------------------------------------------------------

SensorStates states(const Scenario& scenario, double length, double step) {
  SensorStates::Options options = scenario.states;
  options.scene_length = length;
  options.step = step;
  SensorStates result = sensor_states(scenario.sensor, options);
  std::vector<double> variances;
  for (std::size_t i = 0; i < scenario.aids.size(); ++i) {
    if (scenario.aids[i].used) {
      const AidTerms aid = aid_terms(scenario.aids[i], static_cast<int>(i));
      result.model.terms.insert(result.model.terms.end(), aid.terms.begin(), aid.terms.end());
      variances.insert(variances.end(), aid.variances.begin(), aid.variances.end());
    }
  }
  result.model.check();
  const Eigen::Index sensors = result.initial.rows(), aids = static_cast<Eigen::Index>(variances.size());
  StateMatrix all = StateMatrix::Zero(sensors + aids, sensors + aids);
  all.topLeftCorner(sensors, sensors) = result.initial;
  for (Eigen::Index i = 0; i < aids; ++i) all(sensors + i, sensors + i) = variances[static_cast<std::size_t>(i)];
  result.initial = all;
  return result;
}

// --- Measurements --------------------------------------------------------------------------------------------
}  // namespace

Measurement detail::measure_fix(const Aid& aid, int number, const Fix& fix, const Estimate& estimate,
                                const Vector3d& sigma) {
  const Vector3d& p = estimate.motion.pose.p_eb_e;
  const earth::Geodetic at = earth::to_geodetic(p);
  const Matrix3d C_enu = earth::C_e_enu(at.latitude, at.longitude);
  switch (aid.kind) {
    case Aid::Kind::position:
      return measure(PositionFix{fix.value, sigma, C_enu, aid.lever_arm, number}, estimate);
    case Aid::Kind::velocity:
    case Aid::Kind::rest:
      return measure(VelocityFix{detail::to_ecef_axes(fix.value, p), sigma, C_enu, aid.lever_arm, number}, estimate);
    case Aid::Kind::height:
      return measure(HeightFix{fix.value[0], sigma[0], number}, estimate);
    case Aid::Kind::attitude:
      return measure(AttitudeFix{detail::to_ecef_axes(fix.q_nb, p), sigma, number}, estimate);
  }
  throw std::invalid_argument("an aid of no known kind");
}

namespace {

bool in_use(const Aid& aid, double t) {
  return aid.valid.holds(t) && std::ranges::none_of(aid.outages, [&](const Span& outage) { return outage.holds(t); });
}

// --- Against a reference -------------------------------------------------------------------------------------

// Compares solutions with the reference, each quantity as its aid sees it.
class Comparison {
 public:
  Comparison(const Scenario& scenario, const std::vector<FixTrack>& tracks) : scenario_(scenario), tracks_(tracks) {
    for (const std::size_t i : scenario.reference) {
      if (tracks[i].size() == 0) continue;  // the reference does not measure it
      switch (scenario.aids[i].kind) {
        case Aid::Kind::position:
          position_ = i;
          break;
        case Aid::Kind::velocity:
          velocity_ = i;
          break;
        case Aid::Kind::attitude:
          attitude_ = i;
          break;
        case Aid::Kind::height:
        case Aid::Kind::rest:
          throw SetupError(fmt::format("reference: {} measures {}, expected position, velocity or attitude",
                                       scenario.aids[i].name, name(scenario.aids[i].kind)));
      }
    }
    summary_.has_position = position_.has_value();
    summary_.has_velocity = velocity_.has_value();
    summary_.has_attitude = attitude_.has_value();
    summary_.dof = 3 * (int{summary_.has_position} + int{summary_.has_velocity} + int{summary_.has_attitude});
  }

  void compare(const Estimate& estimate, const StateMatrix& P, double t) {
    if (summary_.dof == 0) return;
    const earth::Geodetic at = earth::to_geodetic(estimate.motion.pose.p_eb_e);
    const Matrix3d C_enu = earth::C_e_enu(at.latitude, at.longitude);
    const Matrix3d C_lb = C_enu.transpose() * estimate.motion.pose.q_eb.toRotationMatrix();
    ReferenceError e;
    e.time = t;
    Rows rows;
    if (position_ &&
        !add(position_at(t), *position_, Matrix3d::Identity(), estimate, P, rows, e.position, e.position_sigma))
      return;
    if (velocity_ && !add(tracks_[*velocity_].at(t), *velocity_, Matrix3d::Identity(), estimate, P, rows, e.velocity,
                          e.velocity_sigma))
      return;
    if (attitude_ && !add(tracks_[*attitude_].at(t), *attitude_, C_lb, estimate, P, rows, e.attitude, e.attitude_sigma))
      return;
    e.nees = nees(rows.residual, rows.H * P * rows.H.transpose());
    summary_.errors.push_back(e);
  }

  [[nodiscard]] std::optional<ReferenceSummary> finish() {
    if (summary_.dof == 0) return std::nullopt;
    const auto n = static_cast<double>(summary_.errors.size());
    if (n == 0) return std::move(summary_);
    const Band band = chi_square_mean_band(summary_.dof, 1);
    summary_.nees_low = band.lower;
    summary_.nees_high = band.upper;
    double inside = 0;
    for (const ReferenceError& e : summary_.errors) {
      summary_.position_rms += e.position.squaredNorm();
      summary_.velocity_rms += e.velocity.squaredNorm();
      summary_.attitude_rms += e.attitude.squaredNorm();
      summary_.nees_mean += e.nees;
      inside += band.holds(e.nees) ? 1 : 0;
    }
    summary_.position_rms = std::sqrt(summary_.position_rms / n);
    summary_.velocity_rms = std::sqrt(summary_.velocity_rms / n);
    summary_.attitude_rms = std::sqrt(summary_.attitude_rms / n);
    summary_.nees_mean /= n;
    summary_.nees_inside_95 = inside / n;
    return std::move(summary_);
  }

 private:
  struct Rows {
    Eigen::MatrixXd H;
    Eigen::VectorXd residual;
  };

  [[nodiscard]] std::optional<Fix> position_at(double t) const {
    const FixTrack& positions = tracks_[*position_];
    std::optional<Fix> fix = positions.at(t);
    if (!fix || !velocity_) return fix;
    if (const auto p = detail::position_at(positions, tracks_[*velocity_], t)) fix->value = *p;
    return fix;
  }

  // Three rows, turned to east, north, up.
  bool add(const std::optional<Fix>& fix, std::size_t aid, const Matrix3d& turn, const Estimate& estimate,
           const StateMatrix& P, Rows& rows, Vector3d& error, Vector3d& sigma) const {
    if (!fix) return false;
    const Measurement m = measure_fix(scenario_.aids[aid], static_cast<int>(aid), *fix, estimate, Vector3d::Ones());
    Eigen::Matrix<double, 3, Eigen::Dynamic> H(3, P.cols());
    for (int i = 0; i < 3; ++i) H.row(i) = m.row[static_cast<std::size_t>(i)].h.transpose();
    H = turn * H;
    const Vector3d residual = turn * m.residual;
    error = -residual;
    sigma = (H * P * H.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
    const Eigen::Index before = rows.residual.size();
    rows.H.conservativeResize(before + 3, P.cols());
    rows.H.bottomRows<3>() = H;
    rows.residual.conservativeResize(before + 3);
    rows.residual.tail<3>() = residual;
    return true;
  }

  const Scenario& scenario_;
  const std::vector<FixTrack>& tracks_;
  std::optional<std::size_t> position_, velocity_, attitude_;
  ReferenceSummary summary_;
};

// --- Innovations in sum --------------------------------------------------------------------------------------

class Sums {
 public:
  Sums(const Scenario& scenario, std::vector<AidSummary>& summaries) : summaries_(summaries) {
    constexpr double kInside = 0.95;
    for (std::size_t i = 0; i < scenario.aids.size(); ++i) {
      place_.push_back(summaries.size());
      if (!scenario.aids[i].used) continue;
      AidSummary s;
      s.aid = i;
      s.rows = rows(scenario.aids[i].kind);
      summaries.push_back(s);
      limit_.push_back(quantile(boost::math::chi_squared(s.rows), kInside));
    }
  }

  [[nodiscard]] AidSummary& of(std::size_t aid) { return summaries_[place_[aid]]; }

  void add(const InnovationAt& at) {
    AidSummary& s = of(at.aid);
    const Innovation& i = at.innovation;
    if (i.status == Innovation::Status::not_finite) {
      ++s.not_finite;
      return;
    }
    s.inside_95 += i.nis <= limit_[place_[at.aid]] ? 1 : 0;
    if (i.status == Innovation::Status::gated) {
      ++s.gated;
      return;
    }
    ++s.used;
    s.nis_mean += i.nis;
    s.residual_mean += i.residual;
    s.residual_rms += i.residual.cwiseAbs2();
  }

  void finish() {
    for (AidSummary& s : summaries_) {
      const auto used = static_cast<double>(s.used);
      if (s.used + s.gated > 0) s.inside_95 /= static_cast<double>(s.used + s.gated);
      if (s.used == 0) continue;
      s.nis_mean /= used;
      const Band band = chi_square_mean_band(s.rows, used);
      s.nis_low = band.lower;
      s.nis_high = band.upper;
      s.residual_mean /= used;
      s.residual_rms = (s.residual_rms / used).cwiseSqrt();
    }
  }

 private:
  std::vector<AidSummary>& summaries_;
  std::vector<std::size_t> place_;
  std::vector<double> limit_;
};

// --- The loop ------------------------------------------------------------------------------------------------

struct Event {
  double time = 0;
  std::size_t aid = 0;  ///< past the last: a solution
  std::size_t fix = 0;
};

class Runner {
 public:
  Runner(const Scenario& scenario, const Recording& recording) : scenario_(scenario), recording_(recording) {
    tracks_.reserve(scenario.aids.size());
    for (std::size_t i = 0; i < scenario.aids.size(); ++i)
      tracks_.emplace_back(scenario.aids[i], recording.fixes[i], recording.origin);
  }

  [[nodiscard]] Navigation run() {
    const auto span = detail::start_span(scenario_, recording_.imu, tracks_, recording_.origin);
    if (const auto* no = std::get_if<detail::NoStart>(&span)) return refuse(*no);
    const Span aligning = std::get<Span>(span);
    end_ = std::min(scenario_.until, stamp(recording_.imu.stamps.size() - 1));
    check_counts(aligning);
    const SensorStates sensors = states(scenario_, end_ - aligning.from, recording_.imu.typical_interval);
    const auto start = detail::start(scenario_, recording_, tracks_, aligning, sensors.model, sensors.initial);
    if (const auto* no = std::get_if<detail::NoStart>(&start)) return refuse(*no);
    const auto& begin = std::get<detail::Start>(start);
    result_.model = sensors.model;
    result_.left_out = sensors.left_out;
    result_.alignment = begin.result;
    result_.P0 = begin.P0;
    for (Eigen::Index k = kCoreStates; k < begin.P0.rows(); ++k) result_.initial.push_back(std::sqrt(begin.P0(k, k)));
    used_to_ = begin.used_to;
    Filter filter(begin.result.state, sensors.model, begin.P0, scenario_.filter);
    now_ = aligning.to;
    skip_to(now_);
    navigate(filter);
    return std::move(result_);
  }

 private:
  [[nodiscard]] Navigation refuse(const detail::NoStart& no) {
    result_.status = no.status;
    result_.why = no.why;
    return std::move(result_);
  }

  // Before memory fills.
  void check_counts(const Span& aligning) const {
    constexpr double kMost = 1e7;
    const auto require = [&](double seconds, double interval, std::string_view what) {
      if (!(seconds <= kMost * interval))
        throw SetupError(
            fmt::format("{} every {:g} s over {:g} s, expected at most {:g} in all", what, interval, seconds, kMost));
    };
    require(end_ - aligning.to, scenario_.solution_interval, "solutions");
    for (const Aid& aid : scenario_.aids)
      if (aid.used && aid.kind == Aid::Kind::rest)
        require(std::min(aid.valid.to, end_) - std::max(aid.valid.from, aligning.to), 1 / aid.rate, aid.name);
  }

  [[nodiscard]] double stamp(std::size_t k) const { return detail::stamp(recording_, k); }

  void skip_to(double t) {
    while (next_ < recording_.imu.increments.size() && stamp(next_ + 1) <= t + kSame) ++next_;
  }

  void navigate(Filter& filter) {
    Sums sums(scenario_, result_.aids);
    Comparison comparison(scenario_, tracks_);
    FilterHistory record(result_.model.states());
    std::vector<Estimate> kept;  // what of an epoch smoothing does not change
    std::vector<double> times;
    if (scenario_.smooth) filter.record(&record);
    const auto step = [&](const Event& event) {
      advance(filter, event.time);
      if (event.aid != scenario_.aids.size()) {
        use(filter, event, sums);
      } else if (scenario_.smooth) {
        const Estimate now = filter.estimate();
        filter.keep_epoch();
        kept.push_back(now);
        times.push_back(event.time);
      } else {
        filter.catch_up();
        const StateMatrix P = filter.covariance().matrix();
        solve(filter.estimate(), P, event.time);
        comparison.compare(filter.estimate(), P, event.time);
      }
    };
    as_far_as_possible([&] {
      for (const Event& event : events(sums)) step(event);
    });
    const std::vector<SmoothedEpoch> smoothed = smooth(record);
    as_far_as_possible([&] {
      for (std::size_t i = 0; i < smoothed.size(); ++i) {
        kept[i].motion.pose = smoothed[i].state;
        kept[i].terms = smoothed[i].terms.data();
        solve(kept[i], smoothed[i].P, times[i]);
        comparison.compare(kept[i], smoothed[i].P, times[i]);
      }
    });
    sums.finish();
    result_.reference = comparison.finish();
    say_outside();
  }

  // Does what it can until the solution leaves what can be computed: that is an answer. Any other exception is none.
  template <class Work>
  void as_far_as_possible(const Work& work) {
    const auto fail = [this](const std::exception& error) {
      if (result_.status == Navigation::Status::failed) return;
      result_.status = Navigation::Status::failed;
      result_.why = fmt::format("at {:g} s: {}", now_, error.what());
    };
    try {
      work();
    } catch (const earth::OutsideDomain& error) {
      fail(error);
    } catch (const Diverged& error) {
      fail(error);
    }
  }

  // Times that were asked for and have no solution.
  void say_outside() {
    std::string list;
    for (const double t : scenario_.at)
      if (!(t >= first_solution() && t <= end_)) list += fmt::format("{}{:g}", list.empty() ? "" : ", ", t);
    if (list.empty()) return;
    result_.alignment.words.push_back(
        fmt::format("no solution at {} s: solutions run from {:g} s, where the alignment ends, to {:g} s", list,
                    first_solution(), end_));
  }
  [[nodiscard]] double first_solution() const { return result_.alignment.to; }

  // All there is to do, in the order of time; aids before solutions.
  [[nodiscard]] std::vector<Event> events(Sums& sums) const {
    std::vector<Event> list;
    for (std::size_t i = 0; i < scenario_.aids.size(); ++i) {
      const Aid& aid = scenario_.aids[i];
      if (!aid.used) continue;
      const auto add = [&](double t, std::size_t fix) {
        if (t > used_to_[i] + kSame && t <= end_ + kSame && in_use(aid, t))
          list.push_back({t, i, fix});
        else
          ++sums.of(i).left_out;
      };
      if (aid.kind == Aid::Kind::rest) {
        const double from = std::max(aid.valid.from, now_), to = std::min(aid.valid.to, end_);
        for (std::int64_t k = 1; from + static_cast<double>(k) / aid.rate <= to; ++k)
          add(from + static_cast<double>(k) / aid.rate, 0);
      } else {
        for (std::size_t k = 0; k < tracks_[i].size(); ++k) add(tracks_[i].time(k), k);
      }
    }
    const std::size_t solution = scenario_.aids.size();
    const double interval = scenario_.solution_interval;
    for (std::int64_t k = 0; now_ + static_cast<double>(k) * interval <= end_ + kSame; ++k)
      list.push_back({now_ + static_cast<double>(k) * interval, solution, 0});
    for (const double t : scenario_.at) {
      const double k = std::round((t - now_) / interval);
      const bool is_one = std::abs(now_ + k * interval - t) <= kSame;
      if (t >= now_ && t <= end_ && !is_one) list.push_back({t, solution, 0});
    }
    constexpr double kTick = 1e-7;  // s: within it the order is that of the aids
    std::ranges::stable_sort(list, {}, [](const Event& e) { return std::pair(std::llround(e.time / kTick), e.aid); });
    return list;
  }

  // Propagates to a time; a step in which it falls is split.
  void advance(Filter& filter, double to) {
    while (now_ < to - kSame && next_ < recording_.imu.increments.size()) {
      const double end = stamp(next_ + 1);
      const bool whole = end <= to + kSame;
      const double until = whole ? end : to;
      filter.propagate(detail::piece(recording_, next_, now_, until), until - now_);
      ++result_.steps;
      now_ = until;
      if (whole) ++next_;
    }
  }

  void use(Filter& filter, const Event& event, Sums& sums) {
    const Aid& aid = scenario_.aids[event.aid];
    static const Fix kAtRest{};
    const Fix& fix = aid.kind == Aid::Kind::rest ? kAtRest : tracks_[event.aid].fix(event.fix);
    const Measurement m =
        measure_fix(aid, static_cast<int>(event.aid), fix, filter.estimate(), fix.sigma.value_or(aid.sigma));
    result_.innovations.push_back({event.time, event.aid, filter.update(m)});
    sums.add(result_.innovations.back());
  }

  void solve(const Estimate& estimate, const StateMatrix& P, double t) {
    result_.solutions.push_back(detail::solution(estimate, P, t));
  }

  const Scenario& scenario_;
  const Recording& recording_;
  std::vector<FixTrack> tracks_;
  Navigation result_;
  double now_ = 0, end_ = 0;
  std::vector<double> used_to_;  ///< by the start, of each aid's fixes
  std::size_t next_ = 0;         ///< interval of the IMU that is being used
};

}  // namespace

NisSummary Navigation::nis() const {
  double sum = 0, dof = 0, inside = 0, tested = 0;
  for (const AidSummary& a : aids) {
    const auto used = static_cast<double>(a.used), all = static_cast<double>(a.used + a.gated);
    sum += a.nis_mean * used;
    dof += used * a.rows;
    inside += a.inside_95 * all;
    tested += all;
  }
  return {sum / dof, inside / tested};
}

Navigation navigate(const Scenario& scenario, const Recording& recording) {
  check(scenario, recording);
  return Runner(scenario, recording).run();
}

}  // namespace gyrobudget::inline v0::navigation

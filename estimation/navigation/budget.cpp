// SPDX-License-Identifier: MIT
#include "budget.h"

#include "gyrobudget/earth/attitude.h"
#include "gyrobudget/earth/ellipsoid.h"
#include "gyrobudget/earth/gravity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d kEarthRate{0, 0, earth::wgs84::kEarthRate};
constexpr double kSameTime = 1e-9;  // [s]
constexpr double kAtRest = 1e-3;    // [m/s]
constexpr double kMostSteps = 1e6;  // 600 bytes each in the adjoint

void require(bool good, std::string_view what, double value, std::string_view expected) {
  if (!good) throw std::invalid_argument(fmt::format("{} is {}, expected {}", what, value, expected));
}

}  // namespace

// --- What is flown ------------------------------------------------------------------------------------------------

Timeline::Timeline(earth::Trajectory trajectory, std::vector<PlannedFix> fixes, const Options& options)
    : trajectory_(std::move(trajectory)),
      fixes_(std::move(fixes)),
      pad_(options.pad),
      report_(options.report) {
  require(options.step > 0 && std::isfinite(options.step), "covariance step [s]", options.step, "above 0");
  require(options.pad >= 0 && std::isfinite(options.pad), "time on the pad [s]", options.pad, "0 or more");
  if (pad_ > 0)
    require(trajectory_.at(0).v_eb_e.norm() <= kAtRest, "speed at the start [m/s], after a time on the pad",
            trajectory_.at(0).v_eb_e.norm(), fmt::format("at most {}", kAtRest));
  const auto inside = [&](double t) { return t >= start() && t <= end(); };
  for (const double t : report_) require(inside(t), "time of interest [s]", t, "within the scene");
  for (const auto& fix : fixes_) require(inside(fix.time), "time of a fix [s]", fix.time, "within the scene");
  std::stable_sort(fixes_.begin(), fixes_.end(),
                   [](const auto& a, const auto& b) { return a.time < b.time; });
  report_.push_back(end());
  std::sort(report_.begin(), report_.end());
  report_.erase(std::unique(report_.begin(), report_.end()), report_.end());
  cut(options);
}

void Timeline::cut(const Options& options) {
  require((end() - start()) / options.step <= kMostSteps, "covariance step [s]", options.step,
          fmt::format("at least {:g} of the scene's {:g} s", 1 / kMostSteps, end() - start()));
  struct Cut {
    double time;
    bool needed;
  };
  std::vector<Cut> cuts{{start(), true}, {0, true}};
  for (const double t : report_) cuts.push_back({t, true});
  for (const auto& fix : fixes_) cuts.push_back({fix.time, true});
  for (const double t : trajectory_.breaks()) cuts.push_back({t, false});
  std::ranges::sort(cuts, {}, &Cut::time);
  double from = start();
  for (const auto& [to, needed] : cuts) {
    // Breaks as dense as the knots of sampled data are none that matter: a step has the means over itself.
    if (to - from < (needed ? kSameTime : options.step / 2)) continue;
    const auto parts = static_cast<int>(std::ceil((to - from) / options.step * (1 - 1e-12)));
    for (int i = 0; i < parts; ++i)
      steps_.push_back(make_step(from + (to - from) * i / parts, from + (to - from) * (i + 1) / parts));
    from = to;
  }
}

Timeline::Step Timeline::make_step(double from, double to) const {
  Step step{from, to, {}};
  step.input.dt = to - from;
  const double middle = std::max(0.0, (from + to) / 2);
  const earth::TrajectoryPoint point = trajectory_.at(middle);
  step.input.p_eb_e = point.p_eb_e;
  step.input.C_eb = point.q_eb.toRotationMatrix();
  if (to <= 0) {  // at rest, whatever the trajectory's first instant does
    step.input.w_ib_b = step.input.C_eb.transpose() * kEarthRate;
    step.input.f_ib_b = -(step.input.C_eb.transpose() * earth::normal_gravity(point.p_eb_e));
  } else {
    const earth::ImuIncrement imu = trajectory_.increment(from, to);
    step.input.w_ib_b = imu.angle / (to - from);
    step.input.f_ib_b = imu.velocity / (to - from);
  }
  return step;
}

Timeline::Instant Timeline::at(double time) const {
  const earth::TrajectoryPoint point = trajectory_.at(std::max(0.0, time));
  Instant instant{{point.p_eb_e, point.v_eb_e, point.q_eb}, Vector3d::Zero(), Vector3d::Zero()};
  if (time < 0 || (time == 0 && pad_ > 0)) {
    instant.state.v_eb_e.setZero();
    return instant;
  }
  const Matrix3d C = point.q_eb.toRotationMatrix();
  instant.w_eb_b = point.w_ib_b - C.transpose() * kEarthRate;
  instant.a_eb_e =
      C * point.f_ib_b + earth::normal_gravity(point.p_eb_e) - 2 * kEarthRate.cross(point.v_eb_e);
  return instant;
}

// --- The filter's gains -------------------------------------------------------------------------------------------

int aid_of(const PlannedFix& planned) {
  return std::visit([](const auto& fix) { return fix.aid; }, planned.fix);
}

Measurement linearise(const PlannedFix& planned, const Timeline::Instant& at, const ErrorStateModel& model) {
  constexpr std::array<double, kMaxErrorTerms> zeros{};
  const Estimate estimate{at.state, at.w_eb_b, at.a_eb_e, &model, zeros.data()};
  return std::visit([&](const auto& fix) { return measure(fix, estimate); }, planned.fix);
}

StartFromFix start_from(const PlannedFix& planned, const Timeline::Instant& at,
                        const ErrorStateModel& model) {
  if (std::holds_alternative<HeightFix>(planned.fix))
    throw std::invalid_argument("a fix of height gives no start: position, velocity or attitude does");
  const int first = std::holds_alternative<PositionFix>(planned.fix)   ? kPosition
                    : std::holds_alternative<VelocityFix>(planned.fix) ? kVelocity
                                                                       : kAttitude;
  const Measurement rows = linearise(planned, at, model);
  StartFromFix start;
  start.by_terms.setZero(kCoreStates, static_cast<Eigen::Index>(model.terms.size()));
  for (const MeasurementRow& row : rows.row) {  // of a residual that the start makes zero
    const Vector3d axis = row.h.segment<3>(first);
    start.by_terms.middleRows<3>(first) -= axis * row.h.tail(start.by_terms.cols()).transpose();
    if (first != kAttitude)
      start.by_attitude.middleRows<3>(first) -= axis * row.h.segment<3>(kAttitude).transpose();
    start.white.block<3, 3>(first, first) += row.variance * axis * axis.transpose();
  }
  return start;
}

namespace {

class GainRun {
 public:
  GainRun(const Timeline& timeline, const Design& design)
      : timeline_(timeline), lineariser_(design.model), covariance_(design.initial, design.form) {
    for (std::size_t k = 0; k < design.model.terms.size(); ++k)
      considered_[kCoreStates + k] = design.model.terms[k].considered;
    result_.model = design.model;
    result_.alignment = design.alignment;
  }

  FrozenGains operator()() {
    now(timeline_.start());
    for (const auto& step : timeline_.steps()) {
      covariance_.propagate(lineariser_(step.input));
      now(step.to);
    }
    return std::move(result_);
  }

 private:
  void now(double time) {
    const auto& fixes = timeline_.fixes();
    while (result_.of_fix.size() < fixes.size() && fixes[result_.of_fix.size()].time <= time + kSameTime)
      use(fixes[result_.of_fix.size()]);
    const auto& report = timeline_.report();
    if (result_.claimed.size() < report.size() && report[result_.claimed.size()] <= time + kSameTime)
      result_.claimed.emplace_back(covariance_.matrix().topLeftCorner<kCoreStates, kCoreStates>());
  }

  void use(const PlannedFix& planned) {
    const Measurement measurement = linearise(planned, timeline_.at(planned.time), lineariser_.model());
    auto& gains = result_.of_fix.emplace_back();
    for (std::size_t i = 0; i < static_cast<std::size_t>(measurement.rows); ++i)
      gains.emplace_back(covariance_.update(
          measurement.row[i], {considered_.data(), static_cast<std::size_t>(covariance_.size())}));
  }

  const Timeline& timeline_;
  Lineariser lineariser_;
  Covariance covariance_;
  std::array<bool, kMaxStates> considered_{};
  FrozenGains result_;
};

}  // namespace

FrozenGains frozen_gains(const Timeline& timeline, const std::optional<Design>& design) {
  if (design) return GainRun(timeline, *design)();
  if (!timeline.fixes().empty())
    throw std::invalid_argument("the scene has fixes but no filter that would use them");
  return {};
}

// --- One source through them --------------------------------------------------------------------------------------

namespace {

using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, kMaxStates, 3>;

Columns moved(const Transition& step, const Columns& x) {
  const int n = step.size - kCoreStates;
  Eigen::Matrix<double, 6, 3> errors = Eigen::Matrix<double, 6, 3>::Zero();
  Columns y(x.rows(), 3);
  for (int k = 0; k < n; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.signal >= 0) errors.row(term.signal) += term.gain * x.row(kCoreStates + k);
    y.row(kCoreStates + k) = term.decay * x.row(kCoreStates + k);
  }
  y.topRows<kCoreStates>() = step.core * x.topRows<kCoreStates>() + step.input * errors;
  return y;
}

// The coarse alignment's part of a source: psi_0 = sum of G/pad times the mean errors of each step times its length.
class AlignedStart {
 public:
  AlignedStart(const AlignmentGain& gain, double pad, std::size_t first_term, int states)
      : gain_(gain / pad),
        first_term_(first_term),
        with_(Columns::Zero(states, 3)),
        by_start_(Columns::Zero(states, 3)) {
    by_start_.middleRows<3>(kAttitude).setIdentity();
  }

  // Before x' itself is moved by the step.
  void propagate(const Transition& step, const StateMatrix& P) {
    const Columns noise = gather(step, P);
    with_ = moved(step, with_) + noise;
    by_start_ = moved(step, by_start_);
  }

  void update(const StateVector& h, const StateVector& gain) {
    with_ -= gain * (h.transpose() * with_);
    by_start_ -= gain * (h.transpose() * by_start_);
  }

  // What E[x x^T] of x = x' + M psi_0 has beyond E[x' x'^T], once all of the pad is behind.
  [[nodiscard]] StateMatrix joining() const {
    const StateMatrix cross = by_start_ * with_.transpose();
    return cross + cross.transpose() + by_start_ * own_ * by_start_.transpose();
  }
  // Before: what the rest of the pad will add to psi_0, in one step of it.
  [[nodiscard]] StateMatrix joining(const Transition& rest, const StateMatrix& P) const {
    AlignedStart ahead = *this;
    (void)ahead.gather(rest, P);
    return ahead.joining();
  }

 private:
  // Adds the step's part of psi_0 to E[x' psi_0^T], x' at its start, and to E[psi_0 psi_0^T]; the covariance of x' at
  // its end with that part by the step's noise is returned. Estimates of a filter are not sensed.
  Columns gather(const Transition& step, const StateMatrix& P) {
    const AlignmentGain G = gain_ * step.dt;
    Columns noise = Columns::Zero(P.rows(), 3);
    Columns of_states = Columns::Zero(P.rows(), 3);  // psi_0's part by the states, transposed
    Eigen::Matrix<double, 6, 1> variance = step.input_noise;
    for (int signal = 0; signal < 6; ++signal)
      noise.topRows<kCoreStates>() +=
          step.input_noise[signal] * step.input.col(signal) * G.col(signal).transpose();
    for (Eigen::Index i = kCoreStates + static_cast<Eigen::Index>(first_term_); i < P.rows(); ++i) {
      const Transition::Term& term = step.terms[static_cast<std::size_t>(i - kCoreStates)];
      if (term.signal < 0) continue;
      const Eigen::RowVector3d by_noise = term.noise * term.spill * G.col(term.signal).transpose();
      of_states.row(i) = term.gain * G.col(term.signal).transpose();
      variance[term.signal] += term.noise * term.spill * term.spill;
      noise.row(i) += by_noise;
      noise.topRows<kCoreStates>() += term.spill * step.input.col(term.signal) * by_noise;
    }
    const Eigen::Matrix3d so_far = of_states.transpose() * with_;
    const Columns by_states = P * of_states;
    own_ += so_far + so_far.transpose() + of_states.transpose() * by_states +
            G * variance.asDiagonal() * G.transpose();
    with_ += by_states;
    return noise;
  }

  AlignmentGain gain_;
  std::size_t first_term_;
  Columns with_, by_start_;  ///< E[x' psi_0^T] and M
  Eigen::Matrix3d own_ = Eigen::Matrix3d::Zero();
};

// [p v psi | estimates of the filter | states of the source], truth minus estimate for the first, estimates
// themselves for the second: they act on the navigator as a sensor's error does, with the other sign.
class Passage {
 public:
  Passage(const Source& source, const FrozenGains& gains, const Timeline& timeline)
      : source_(source),
        estimates_(gains.model.terms.size()),
        lineariser_(joint(source, gains.model)),
        covariance_(initial()) {
    if (gains.alignment && source.sensed && timeline.start() < 0)
      start_.emplace(*gains.alignment, -timeline.start(), estimates_, covariance_.size());
  }

  void propagate(const Timeline::Step& step) {
    const Transition& transition = transition_of(step.input);
    if (start_) start_->propagate(transition, covariance_.matrix());
    covariance_.propagate(transition);
    if (!start_ || step.to < -kSameTime) return;
    covariance_.add(start_->joining());
    start_.reset();
  }

  void update(const Timeline& timeline, std::size_t fix, std::span<const Eigen::VectorXd> filter_gains) {
    const PlannedFix& planned = timeline.fixes()[fix];
    Measurement measurement = linearise(planned, timeline.at(planned.time), lineariser_.model());
    const bool own_noise = source_.aid >= 0 && source_.aid == aid_of(planned);
    const auto n = static_cast<Eigen::Index>(estimates_);
    StateVector gain = StateVector::Zero(covariance_.size());
    for (std::size_t i = 0; i < filter_gains.size(); ++i) {
      MeasurementRow& row = measurement.row[i];
      row.h.segment(kCoreStates, n) *= -1;
      if (!own_noise) row.variance = 0;
      gain.head<kCoreStates>() = filter_gains[i].head<kCoreStates>();
      gain.segment(kCoreStates, n) = -filter_gains[i].tail(n);
      covariance_.update_with(row, gain);
      if (start_) start_->update(row.h, gain);
    }
  }

  // @param next the step that follows; of interest on the pad
  [[nodiscard]] CoreMatrix core(const Timeline::Step& next) {
    StateMatrix P = covariance_.matrix();
    if (start_) {
      StepInput rest = next.input;
      rest.dt = -next.from;
      P += start_->joining(transition_of(rest), P);
    }
    return P.topLeftCorner<kCoreStates, kCoreStates>();
  }

 private:
  static ErrorStateModel joint(const Source& source, const ErrorStateModel& filter) {
    ErrorStateModel model = source.model;
    model.terms = filter.terms;
    for (auto& term : model.terms) term.walk = 0;  // what drives the true error does not drive its estimate
    model.terms.insert(model.terms.end(), source.model.terms.begin(), source.model.terms.end());
    return model;
  }

  [[nodiscard]] Covariance initial() const {
    const auto m = static_cast<Eigen::Index>(source_.model.terms.size());
    if (source_.initial.rows() != m || source_.initial.cols() != m)
      throw std::invalid_argument(fmt::format("source {}: initial covariance of {} x {} for {} terms",
                                              source_.name, source_.initial.rows(), source_.initial.cols(),
                                              m));
    const Eigen::Index crossed = source_.cross.cols();
    if (crossed != 0 && crossed != m)
      throw std::invalid_argument(
          fmt::format("source {}: covariance of the start with {} terms of {}", source_.name, crossed, m));
    const int size = lineariser_.states();
    StateMatrix P = StateMatrix::Zero(size, size);
    P.topLeftCorner<kCoreStates, kCoreStates>() = source_.core;
    P.bottomRightCorner(m, m) = source_.initial;
    P.topRightCorner(kCoreStates, crossed) = source_.cross;
    P.bottomLeftCorner(crossed, kCoreStates) = source_.cross.transpose();
    return {P, Form::joseph};
  }

  const Transition& transition_of(const StepInput& input) {
    Transition& step = transition_ = lineariser_(input);
    for (std::size_t k = 0; k < estimates_; ++k) step.terms[k].gain = -step.terms[k].gain;
    if (source_.shape) shape(input, step);
    return step;
  }

  void shape(const StepInput& input, Transition& step) const {
    for (std::size_t k = 0; k < source_.model.terms.size(); ++k) {
      const double factor = source_.shape(input, k);
      step.terms[estimates_ + k].gain *= factor;
      step.terms[estimates_ + k].spill *= factor;
    }
  }

  const Source& source_;
  std::size_t estimates_;
  Lineariser lineariser_;
  Transition transition_;
  Covariance covariance_;
  std::optional<AlignedStart> start_;  ///< until the pad ends
};

class Run {
 public:
  Run(const Timeline& timeline, std::span<const Source> sources, const FrozenGains& gains)
      : timeline_(timeline), gains_(gains) {
    passages_.reserve(sources.size());
    for (const auto& source : sources) {
      passages_.emplace_back(source, gains, timeline);
      budget_.lines.push_back({source.name, {}});
    }
    budget_.claimed = gains.claimed;
  }

  Budget operator()() {
    const auto& steps = timeline_.steps();
    report_at(timeline_.start(), steps.front());
    fixes_at(timeline_.start());
    for (std::size_t k = 0; k < steps.size(); ++k) {
      for (auto& passage : passages_) passage.propagate(steps[k]);
      fixes_at(steps[k].to);
      report_at(steps[k].to, steps[std::min(k + 1, steps.size() - 1)]);
    }
    budget_.steps = timeline_.steps().size();
    return std::move(budget_);
  }

 private:
  void fixes_at(double time) {
    for (; next_fix_ < timeline_.fixes().size() && timeline_.fixes()[next_fix_].time <= time + kSameTime;
         ++next_fix_)
      for (auto& passage : passages_) passage.update(timeline_, next_fix_, gains_.of_fix[next_fix_]);
  }

  void require_finite() const {
    if (budget_.total.back().allFinite()) return;
    throw std::invalid_argument(fmt::format(
        "errors grow beyond all numbers within {} s, as the vertical channel does without a height (by e in "
        "570 s): give the scene a height aid, or end it earlier",
        timeline_.end()));
  }

  void report_at(double time, const Timeline::Step& next) {
    const auto& report = timeline_.report();
    if (next_report_ == report.size() || report[next_report_] > time + kSameTime) return;
    budget_.times.push_back(report[next_report_++]);
    CoreMatrix total = CoreMatrix::Zero();
    for (std::size_t i = 0; i < passages_.size(); ++i) {
      budget_.lines[i].covariance.push_back(passages_[i].core(next));
      total += budget_.lines[i].covariance.back();
    }
    budget_.total.push_back(total);
    require_finite();
  }

  const Timeline& timeline_;
  const FrozenGains& gains_;
  std::vector<Passage> passages_;
  Budget budget_;
  std::size_t next_fix_ = 0, next_report_ = 0;
};

}  // namespace

Budget error_budget(const Timeline& timeline, std::span<const Source> sources,
                    const std::optional<Design>& design) {
  return error_budget(timeline, sources, frozen_gains(timeline, design));
}

Budget error_budget(const Timeline& timeline, std::span<const Source> sources, const FrozenGains& gains) {
  return Run(timeline, sources, gains)();
}

std::vector<double> fix_times(const FixPlan& plan) {
  require(plan.interval > 0 && std::isfinite(plan.interval), "interval of fixes [s]", plan.interval,
          "above 0");
  require(plan.last - plan.first <= kMostSteps * plan.interval, "number of fixes",
          (plan.last - plan.first) / plan.interval, fmt::format("at most {:g}", kMostSteps));
  std::vector<double> times;
  for (std::size_t k = 0;; ++k) {
    const double t = plan.first + static_cast<double>(k) * plan.interval;
    if (!(t <= plan.last + 1e-9 * plan.interval)) break;
    const bool out = std::any_of(plan.outages.begin(), plan.outages.end(),
                                 [t](const auto& outage) { return t >= outage.first && t <= outage.second; });
    if (!out) times.push_back(std::min(t, plan.last));
  }
  return times;
}

LocalSigmas local_sigmas(const CoreMatrix& covariance_e, const Matrix3d& C_el) {
  const auto sigmas = [&](int row) -> Vector3d {
    const Matrix3d local = C_el.transpose() * covariance_e.block<3, 3>(row, row) * C_el;
    return local.diagonal().cwiseMax(0).cwiseSqrt();
  };
  return {sigmas(kPosition), sigmas(kVelocity), sigmas(kAttitude)};
}

}  // namespace gyrobudget::inline v0::navigation

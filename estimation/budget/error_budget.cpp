// SPDX-License-Identifier: MIT
#include "error_budget.h"

#include "gyrobudget/estimation/navigation/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include <Eigen/Eigenvalues>

namespace gyrobudget::inline v0::budget {

// --- The filter's gains -------------------------------------------------------------------------------------------

namespace {

class GainRun {
 public:
  GainRun(const Timeline& timeline, const Design& design)
      : timeline_(timeline), lineariser_(design.model), covariance_(design.initial, design.form) {
    for (std::size_t k = 0; k < design.model.terms.size(); ++k)
      considered_[navigation::kCoreStates + k] = design.model.terms[k].considered;
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
    while (result_.of_fix.size() < fixes.size() && fixes[result_.of_fix.size()].time <= time + Timeline::kSameTime)
      use(fixes[result_.of_fix.size()]);
    const auto& report = timeline_.report();
    if (result_.claimed.size() < report.size() && report[result_.claimed.size()] <= time + Timeline::kSameTime)
      result_.claimed.emplace_back(
          covariance_.matrix().topLeftCorner<navigation::kCoreStates, navigation::kCoreStates>());
  }

  void use(const navigation::PlannedFix& planned) {
    const navigation::Measurement measurement =
        navigation::linearise(planned, timeline_.at(planned.time), lineariser_.model());
    auto& gains = result_.of_fix.emplace_back();
    for (std::size_t i = 0; i < static_cast<std::size_t>(measurement.rows); ++i)
      gains.emplace_back(
          covariance_.update(measurement.row[i], {considered_.data(), static_cast<std::size_t>(covariance_.size())}));
  }

  const Timeline& timeline_;
  navigation::Lineariser lineariser_;
  navigation::Covariance covariance_;
  std::array<bool, navigation::kMaxStates> considered_{};
  FrozenGains result_;
};

}  // namespace

FrozenGains frozen_gains(const Timeline& timeline, const std::optional<Design>& design) {
  if (design) return GainRun(timeline, *design)();
  if (!timeline.fixes().empty()) throw navigation::SetupError("the scene has fixes but no filter that would use them");
  return {};
}

// --- One source through them --------------------------------------------------------------------------------------

namespace {

using Columns = Eigen::Matrix<double, Eigen::Dynamic, 3, 0, navigation::kMaxStates, 3>;

Columns moved(const navigation::Transition& step, const Columns& x) {
  const int n = step.size - navigation::kCoreStates;
  Eigen::Matrix<double, 6, 3> errors = Eigen::Matrix<double, 6, 3>::Zero();
  Columns y(x.rows(), 3);
  for (int k = 0; k < n; ++k) {
    const navigation::Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.signal >= 0) errors.row(term.signal) += term.gain * x.row(navigation::kCoreStates + k);
    y.row(navigation::kCoreStates + k) = term.decay * x.row(navigation::kCoreStates + k);
  }
  y.topRows<navigation::kCoreStates>() = step.core * x.topRows<navigation::kCoreStates>() + step.input * errors;
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
    by_start_.middleRows<3>(navigation::kAttitude).setIdentity();
  }

  // Before x' itself is moved by the step.
  void propagate(const navigation::Transition& step, const navigation::StateMatrix& P) {
    const Columns noise = gather(step, P);
    with_ = moved(step, with_) + noise;
    by_start_ = moved(step, by_start_);
  }

  void update(const navigation::StateVector& h, const navigation::StateVector& gain) {
    with_ -= gain * (h.transpose() * with_);
    by_start_ -= gain * (h.transpose() * by_start_);
  }

  // What E[x x^T] of x = x' + M psi_0 has beyond E[x' x'^T], once all of the pad is behind.
  [[nodiscard]] navigation::StateMatrix joining() const {
    const navigation::StateMatrix cross = by_start_ * with_.transpose();
    return cross + cross.transpose() + by_start_ * own_ * by_start_.transpose();
  }
  // Before: what the rest of the pad will add to psi_0, in one step of it.
  [[nodiscard]] navigation::StateMatrix joining(const navigation::Transition& rest,
                                                const navigation::StateMatrix& P) const {
    AlignedStart ahead = *this;
    (void)ahead.gather(rest, P);
    return ahead.joining();
  }

 private:
  // Adds the step's part of psi_0 to E[x' psi_0^T], x' at its start, and to E[psi_0 psi_0^T]; the covariance of x' at
  // its end with that part by the step's noise is returned. Estimates of a filter are not sensed.
  Columns gather(const navigation::Transition& step, const navigation::StateMatrix& P) {
    const AlignmentGain G = gain_ * step.dt;
    Columns noise = Columns::Zero(P.rows(), 3);
    Columns of_states = Columns::Zero(P.rows(), 3);  // psi_0's part by the states, transposed
    Eigen::Matrix<double, 6, 1> variance = step.input_noise;
    for (int signal = 0; signal < 6; ++signal)
      noise.topRows<navigation::kCoreStates>() +=
          step.input_noise[signal] * step.input.col(signal) * G.col(signal).transpose();
    for (Eigen::Index i = navigation::kCoreStates + static_cast<Eigen::Index>(first_term_); i < P.rows(); ++i) {
      const navigation::Transition::Term& term = step.terms[static_cast<std::size_t>(i - navigation::kCoreStates)];
      if (term.signal < 0) continue;
      const Eigen::RowVector3d by_noise = term.noise * term.spill * G.col(term.signal).transpose();
      of_states.row(i) = term.gain * G.col(term.signal).transpose();
      variance[term.signal] += term.noise * term.spill * term.spill;
      noise.row(i) += by_noise;
      noise.topRows<navigation::kCoreStates>() += term.spill * step.input.col(term.signal) * by_noise;
    }
    const Eigen::Matrix3d so_far = of_states.transpose() * with_;
    const Columns by_states = P * of_states;
    own_ += so_far + so_far.transpose() + of_states.transpose() * by_states + G * variance.asDiagonal() * G.transpose();
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
    const navigation::Transition& transition = transition_of(step.input);
    if (start_) start_->propagate(transition, covariance_.matrix());
    covariance_.propagate(transition);
    if (!start_ || step.to < -Timeline::kSameTime) return;
    covariance_.add(start_->joining());
    start_.reset();
  }

  void update(const Timeline& timeline, std::size_t fix, std::span<const Eigen::VectorXd> filter_gains) {
    const navigation::PlannedFix& planned = timeline.fixes()[fix];
    navigation::Measurement measurement =
        navigation::linearise(planned, timeline.at(planned.time), lineariser_.model());
    const bool own_noise = source_.aid >= 0 && source_.aid == navigation::aid_of(planned);
    const auto n = static_cast<Eigen::Index>(estimates_);
    navigation::StateVector gain = navigation::StateVector::Zero(covariance_.size());
    for (std::size_t i = 0; i < filter_gains.size(); ++i) {
      navigation::MeasurementRow& row = measurement.row[i];
      row.h.segment(navigation::kCoreStates, n) *= -1;
      if (!own_noise) row.variance = 0;
      gain.head<navigation::kCoreStates>() = filter_gains[i].head<navigation::kCoreStates>();
      gain.segment(navigation::kCoreStates, n) = -filter_gains[i].tail(n);
      covariance_.update_with(row, gain);
      if (start_) start_->update(row.h, gain);
    }
  }

  // @param next the step that follows; of interest on the pad
  [[nodiscard]] navigation::CoreMatrix core(const Timeline::Step& next) {
    navigation::StateMatrix P = covariance_.matrix();
    if (start_) {
      navigation::StepInput rest = next.input;
      rest.dt = -next.from;
      P += start_->joining(transition_of(rest), P);
    }
    return without_negative(P.topLeftCorner<navigation::kCoreStates, navigation::kCoreStates>());
  }

 private:
  // Where the fixes take nearly all of a variance away, as what a bias makes of a height of 60 km, its rounding is left
  // and may be negative: none of that is an error.
  static navigation::CoreMatrix without_negative(navigation::CoreMatrix P) {
    for (int triad = 0; triad < navigation::kCoreStates; triad += 3) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(P.block<3, 3>(triad, triad));
      if (eigen.eigenvalues()[0] >= 0) continue;
      const Eigen::Vector3d variances = eigen.eigenvalues().cwiseMax(0);
      P.block<3, 3>(triad, triad) = eigen.eigenvectors() * variances.asDiagonal() * eigen.eigenvectors().transpose();
    }
    return P;
  }

  static navigation::ErrorStateModel joint(const Source& source, const navigation::ErrorStateModel& filter) {
    navigation::ErrorStateModel model = source.model;
    model.terms = filter.terms;
    for (auto& term : model.terms) term.walk = 0;  // what drives the true error does not drive its estimate
    model.terms.insert(model.terms.end(), source.model.terms.begin(), source.model.terms.end());
    return model;
  }

  [[nodiscard]] navigation::Covariance initial() const {
    const auto m = static_cast<Eigen::Index>(source_.model.terms.size());
    if (source_.initial.rows() != m || source_.initial.cols() != m)
      throw std::invalid_argument(fmt::format("source {}: initial covariance of {} x {} for {} terms", source_.name,
                                              source_.initial.rows(), source_.initial.cols(), m));
    const Eigen::Index crossed = source_.cross.cols();
    if (crossed != 0 && crossed != m)
      throw std::invalid_argument(
          fmt::format("source {}: covariance of the start with {} terms of {}", source_.name, crossed, m));
    const int size = lineariser_.states();
    navigation::StateMatrix P = navigation::StateMatrix::Zero(size, size);
    P.topLeftCorner<navigation::kCoreStates, navigation::kCoreStates>() = source_.core;
    P.bottomRightCorner(m, m) = source_.initial;
    P.topRightCorner(navigation::kCoreStates, crossed) = source_.cross;
    P.bottomLeftCorner(crossed, navigation::kCoreStates) = source_.cross.transpose();
    return {P, navigation::Form::joseph};
  }

  const navigation::Transition& transition_of(const navigation::StepInput& input) {
    navigation::Transition& step = transition_ = lineariser_(input);
    for (std::size_t k = 0; k < estimates_; ++k) step.terms[k].gain = -step.terms[k].gain;
    if (source_.shape) shape(input, step);
    return step;
  }

  void shape(const navigation::StepInput& input, navigation::Transition& step) const {
    for (std::size_t k = 0; k < source_.model.terms.size(); ++k) {
      const double factor = source_.shape(input, k);
      step.terms[estimates_ + k].gain *= factor;
      step.terms[estimates_ + k].spill *= factor;
    }
  }

  const Source& source_;
  std::size_t estimates_;
  navigation::Lineariser lineariser_;
  navigation::Transition transition_;
  navigation::Covariance covariance_;
  std::optional<AlignedStart> start_;  ///< until the pad ends
};

class Propagation {
 public:
  Propagation(const Timeline& timeline, std::span<const Source> sources, const FrozenGains& gains)
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
    for (; next_fix_ < timeline_.fixes().size() && timeline_.fixes()[next_fix_].time <= time + Timeline::kSameTime;
         ++next_fix_)
      for (auto& passage : passages_) passage.update(timeline_, next_fix_, gains_.of_fix[next_fix_]);
  }

  void require_finite() const {
    if (budget_.total.back().allFinite()) return;
    throw navigation::Diverged(fmt::format(
        "errors grow beyond all numbers within {} s, as the vertical channel does without a height (by e in 570 s): give the scene a height aid, or end it earlier",
        timeline_.end()));
  }

  void report_at(double time, const Timeline::Step& next) {
    const auto& report = timeline_.report();
    if (next_report_ == report.size() || report[next_report_] > time + Timeline::kSameTime) return;
    budget_.times.push_back(report[next_report_++]);
    navigation::CoreMatrix total = navigation::CoreMatrix::Zero();
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

Budget error_budget(const Timeline& timeline, std::span<const Source> sources, const std::optional<Design>& design) {
  return error_budget(timeline, sources, frozen_gains(timeline, design));
}

Budget error_budget(const Timeline& timeline, std::span<const Source> sources, const FrozenGains& gains) {
  return Propagation(timeline, sources, gains)();
}

}  // namespace gyrobudget::inline v0::budget

// SPDX-License-Identifier: MIT
#include "adjoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace gyrobudget::inline v0::budget {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kSameTime = 1e-9;  // [s]

using Rows =
    Eigen::Matrix<double, navigation::kCoreStates, Eigen::Dynamic, 0, navigation::kCoreStates, navigation::kMaxStates>;

// x+ = (I - k h) x + k v for [core | estimates], whose gain and row have the sign of an estimate.
void back_through_fix(const FrozenGains& gains, std::size_t index, const Timeline& timeline, Rows& lambda,
                      Eigen::Matrix<double, navigation::kCoreStates, 3>& by_row) {
  const navigation::PlannedFix& planned = timeline.fixes()[index];
  const navigation::Measurement measurement = navigation::linearise(planned, timeline.at(planned.time), gains.model);
  const auto n = static_cast<Eigen::Index>(gains.model.terms.size());
  by_row.setZero();
  for (int i = measurement.rows - 1; i >= 0; --i) {
    navigation::StateVector h = measurement.row[static_cast<std::size_t>(i)].h;
    navigation::StateVector k = gains.of_fix[index][static_cast<std::size_t>(i)];
    h.tail(n) *= -1;
    k.tail(n) *= -1;
    const Eigen::Matrix<double, navigation::kCoreStates, 1> gain = lambda * k;
    by_row.col(i) = -gain;  // x+ = x - k (h x + v): the error of a row enters with the sign of the residual
    lambda -= gain * h.transpose();
  }
}

}  // namespace

Adjoint adjoint(const Timeline& timeline, const FrozenGains& gains, double time) {
  const auto& steps = timeline.steps();
  Adjoint result;
  result.time = time;
  result.steps = static_cast<std::size_t>(
      std::count_if(steps.begin(), steps.end(), [&](const auto& s) { return s.to <= time + kSameTime; }));
  const double reached = result.steps == 0 ? timeline.start() : steps[result.steps - 1].to;
  if (!(std::abs(reached - time) <= kSameTime))
    throw std::invalid_argument(fmt::format("no step ends at {} s: make it a time of interest", time));
  const std::size_t ended = result.steps;
  if (gains.alignment)  // of the mean over the whole pad, whenever it is asked
    result.steps = std::max(result.steps, static_cast<std::size_t>(std::ranges::count_if(
                                              steps, [](const auto& s) { return s.to <= kSameTime; })));
  result.input.resize(result.steps, navigation::InputMatrix::Zero());
  const auto& fixes = timeline.fixes();
  auto fix = static_cast<std::size_t>(
      std::count_if(fixes.begin(), fixes.end(), [&](const auto& f) { return f.time <= time + kSameTime; }));
  result.fix.resize(fix);

  navigation::ErrorStateModel estimates = gains.model;  // they act as errors of the other sign and nothing drives them
  navigation::Lineariser lineariser(estimates);
  const int n = static_cast<int>(estimates.terms.size());
  Rows lambda = Rows::Zero(navigation::kCoreStates, navigation::kCoreStates + n);
  lambda.leftCols<navigation::kCoreStates>().setIdentity();
  const auto fixes_from = [&](double from) {
    for (; fix > 0 && fixes[fix - 1].time > from + kSameTime; --fix)
      back_through_fix(gains, fix - 1, timeline, lambda, result.fix[fix - 1]);
  };
  for (std::size_t k = ended; k-- > 0;) {
    fixes_from(steps[k].from);
    const navigation::Transition& step = lineariser(steps[k].input);
    const navigation::CoreMatrix core = lambda.leftCols<navigation::kCoreStates>();
    if (!core.allFinite()) {  // nor will anything be before it
      std::fill_n(result.input.begin(), k + 1,
                  navigation::InputMatrix::Constant(std::numeric_limits<double>::quiet_NaN()));
      break;
    }
    result.input[k] = core * step.input;
    lambda.leftCols<navigation::kCoreStates>() = core * step.core;
    for (int j = 0; j < n; ++j) {
      const navigation::Transition::Term& term = step.terms[static_cast<std::size_t>(j)];
      lambda.col(navigation::kCoreStates + j) *= term.decay;
      if (term.signal >= 0) lambda.col(navigation::kCoreStates + j) -= term.gain * result.input[k].col(term.signal);
    }
  }
  fixes_from(timeline.start() - 1);
  result.initial = lambda.leftCols<navigation::kCoreStates>();
  if (gains.alignment && timeline.start() < 0)
    result.through_start = result.initial.middleCols<3>(navigation::kAttitude) * *gains.alignment / -timeline.start();
  return result;
}

navigation::InputMatrix by_errors(const Adjoint& adjoint, const Timeline& timeline, std::size_t step, bool sensed) {
  const Timeline::Step& at = timeline.steps()[step];
  if (!sensed || at.to > kSameTime) return adjoint.input[step];
  return adjoint.input[step] + (at.to - at.from) * adjoint.through_start;
}

// --- Processes ----------------------------------------------------------------------------------------------------

namespace {

// Structure function at any lag [s]; below a sample it falls to zero linearly.
class Structure {
 public:
  Structure(const noise::Process& process, double dt) : process_(process), dt_(dt) {}
  [[nodiscard]] double operator()(double lag) const {
    const double samples = lag / dt_;
    const double whole = std::floor(samples);
    const double below = at(whole);
    return below + (samples - whole) * (at(whole + 1) - below);
  }
  // Mean over lags from a to b, 16 midpoints a doubling of what is beyond a sample.
  [[nodiscard]] double mean(double a, double b) const {
    const int points = 64 + static_cast<int>(16 * std::log2(1 + (b - a) / dt_));
    // Denser towards a: lag = a + (b - a) u^2.
    double sum = 0;
    for (int i = 0; i < points; ++i) {
      const double u = (i + 0.5) / points;
      sum += 2 * u * (*this)(a + (b - a) * u * u);
    }
    return sum / points;
  }

 private:
  [[nodiscard]] double at(double samples) const {
    return samples < 1 ? 0 : noise::structure_function(process_, static_cast<std::int64_t>(samples), dt_);
  }
  const noise::Process& process_;
  double dt_;
};

constexpr std::size_t kMostBlocks = 2000;

// Neighbouring steps over which a slow error is held constant.
struct Block {
  double from = 0, to = 0;
  Eigen::Matrix<double, navigation::kCoreStates, 3> by = Eigen::Matrix<double, navigation::kCoreStates, 3>::Zero();
};

std::vector<Block> blocks_of(const Adjoint& adjoint, const Timeline& timeline, int first) {
  const std::size_t together = (adjoint.steps + kMostBlocks - 1) / kMostBlocks;
  std::vector<Block> blocks;
  for (std::size_t k = 0; k < adjoint.steps; ++k) {
    const Timeline::Step& step = timeline.steps()[k];
    if (k % together == 0) blocks.push_back({step.from, step.to});
    blocks.back().to = step.to;
    blocks.back().by += by_errors(adjoint, timeline, k).middleCols<3>(first);
  }
  return blocks;
}

// Covariance of the process since its epoch, between times of blocks.
class SinceEpoch {
 public:
  SinceEpoch(const noise::Process& process, const navigation::Epoch& epoch, double dt, std::span<const Block> blocks)
      : structure_(process, dt) {
    const double start = blocks.front().from;
    for (const Block& block : blocks) {
      const double t = (block.from + block.to) / 2 - start;
      middle_.push_back(t);
      length_.push_back(block.to - block.from);
      to_epoch_.push_back(epoch.calibrated_over ? structure_.mean(t, t + *epoch.calibrated_over)
                                                : structure_(t + epoch.powered_on_before));
    }
    if (epoch.calibrated_over) within_ = mean_within(*epoch.calibrated_over);
  }
  [[nodiscard]] double operator()(std::size_t k, std::size_t l) const {
    // The mean of a concave D over all pairs within a step is near that at a third of it.
    const double lag = k == l ? length_[k] / 3 : std::abs(middle_[k] - middle_[l]);
    return (to_epoch_[k] + to_epoch_[l] - structure_(lag) - within_) / 2;
  }

 private:
  // (2/T^2) int_0^T (T - u) D(u) du
  [[nodiscard]] double mean_within(double T) const {
    constexpr int points = 512;
    double sum = 0;
    for (int i = 0; i < points; ++i) {
      const double u = (i + 0.5) / points;
      sum += 2 * u * (1 - u * u) * structure_(T * u * u);
    }
    return 2 * sum / points;
  }

  Structure structure_;
  std::vector<double> middle_, length_, to_epoch_;
  double within_ = 0;
};

Eigen::Vector3d vector(const noise::PerAxis& of) { return {of[0], of[1], of[2]}; }

navigation::CoreMatrix of_white(const Adjoint& adjoint, const Timeline& timeline, int first,
                                const noise::TriadProcess& white, const navigation::Epoch& epoch) {
  const double n = noise::coefficient(white.process);
  const Eigen::Vector3d relative = vector(white.relative);
  navigation::CoreMatrix covariance = navigation::CoreMatrix::Zero();
  Eigen::Matrix<double, navigation::kCoreStates, 3> sum = Eigen::Matrix<double, navigation::kCoreStates, 3>::Zero();
  for (std::size_t k = 0; k < adjoint.steps; ++k) {
    const Eigen::Matrix<double, navigation::kCoreStates, 3> input =
        by_errors(adjoint, timeline, k).middleCols<3>(first) * relative.asDiagonal();
    covariance += n * n / timeline.steps()[k].input.dt * input * input.transpose();
    sum += input;
  }
  if (epoch.calibrated_over) covariance += n * n / *epoch.calibrated_over * sum * sum.transpose();
  return covariance;
}

}  // namespace

navigation::CoreMatrix process_response(const Adjoint& adjoint, const Timeline& timeline, navigation::Carrier carrier,
                                        const noise::TriadProcess& triad, const navigation::Epoch& epoch,
                                        double imu_interval) {
  const noise::Process& process = triad.process;
  const noise::Term term = noise::term(process);
  if (term == noise::Term::quantization || term == noise::Term::rate_ramp || term == noise::Term::sinusoid)
    throw std::invalid_argument("quantization, ramp and sinusoid have no response by a structure function");
  if (!(imu_interval > 0) || carrier == navigation::Carrier::aid)
    throw std::invalid_argument(
        fmt::format("IMU interval is {} s, expected above 0 s, of a gyro or accelerometer", imu_interval));
  constexpr double kMostSamples = 0x1p62;
  const double longest =
      timeline.end() - timeline.start() + epoch.powered_on_before + epoch.calibrated_over.value_or(0);
  if (!(longest / imu_interval <= kMostSamples))
    throw std::invalid_argument(fmt::format("a process over {} s by samples of {} s, expected at most {:g} of them",
                                            longest, imu_interval, kMostSamples));
  const int first = carrier == navigation::Carrier::gyro ? 0 : 3;
  if (adjoint.steps == 0) return navigation::CoreMatrix::Zero();
  if (term == noise::Term::white) return of_white(adjoint, timeline, first, triad, epoch);

  // A Gauss-Markov process is stationary, not zero at power-on.
  navigation::Epoch from = epoch;
  const bool stationary = term == noise::Term::gauss_markov && !epoch.calibrated_over;
  const double variance = stationary ? std::pow(noise::coefficient(process), 2) : 0;
  const std::vector<Block> blocks = blocks_of(adjoint, timeline, first);
  const SinceEpoch since(process, from, imu_interval, blocks);
  const Structure structure(process, imu_interval);
  const auto K = static_cast<Eigen::Index>(blocks.size());
  MatrixXd R(K, K);
  for (Eigen::Index l = 0; l < K; ++l)
    for (Eigen::Index k = 0; k <= l; ++k) {
      const Block& a = blocks[static_cast<std::size_t>(k)];
      const Block& b = blocks[static_cast<std::size_t>(l)];
      const double lag = k == l ? (a.to - a.from) / 3 : (b.from + b.to - a.from - a.to) / 2;
      R(k, l) = R(l, k) =
          stationary ? variance - structure(lag) / 2 : since(static_cast<std::size_t>(k), static_cast<std::size_t>(l));
    }
  navigation::CoreMatrix covariance = navigation::CoreMatrix::Zero();
  MatrixXd column(navigation::kCoreStates, K);
  for (int axis = 0; axis < 3; ++axis) {
    for (Eigen::Index k = 0; k < K; ++k) column.col(k) = blocks[static_cast<std::size_t>(k)].by.col(axis);
    const double relative = triad.relative[static_cast<std::size_t>(axis)];
    if (relative != 0) covariance += relative * relative * (column * R * column.transpose());
  }
  return (covariance + covariance.transpose()) / 2;
}

// --- States ---------------------------------------------------------------------------------------------------------

namespace {

// The backward pass of a source's own states, on top of that of the navigator.
class States {
 public:
  States(const Adjoint& adjoint, const Timeline& timeline, const Source& source)
      : adjoint_(adjoint),
        timeline_(timeline),
        source_(source),
        lineariser_(source.model),
        by_state_(MatrixXd::Zero(navigation::kCoreStates, static_cast<Eigen::Index>(source.model.terms.size()))),
        covariance_(adjoint.initial * source.core * adjoint.initial.transpose()),
        fix_(adjoint.fix.size()) {}

  navigation::CoreMatrix operator()() {
    for (std::size_t k = adjoint_.steps; k-- > 0;) {
      fixes_after(timeline_.steps()[k].from);
      back_through_step(k);
    }
    fixes_after(timeline_.start() - 1);
    covariance_ += by_state_ * source_.initial * by_state_.transpose();
    if (source_.cross.cols() == 0) return covariance_;
    const navigation::CoreMatrix joint = adjoint_.initial * source_.cross * by_state_.transpose();
    return covariance_ + joint + joint.transpose();
  }

 private:
  void add(double variance, const Eigen::Matrix<double, navigation::kCoreStates, 1>& by) {
    if (variance != 0) covariance_ += variance * by * by.transpose();
  }

  void back_through_step(std::size_t k) {
    const navigation::StepInput& input = timeline_.steps()[k].input;
    const navigation::Transition& step = lineariser_(input);
    const navigation::InputMatrix by = by_errors(adjoint_, timeline_, k, source_.sensed);
    for (int signal = 0; signal < 6; ++signal) add(step.input_noise[signal], by.col(signal));
    for (Eigen::Index j = 0; j < by_state_.cols(); ++j) {
      const navigation::Transition::Term& term = step.terms[static_cast<std::size_t>(j)];
      Eigen::Matrix<double, navigation::kCoreStates, 1> by_signal =
          Eigen::Matrix<double, navigation::kCoreStates, 1>::Zero();
      if (term.signal >= 0) by_signal = by.col(term.signal);
      if (source_.shape) by_signal *= source_.shape(input, static_cast<std::size_t>(j));
      add(term.noise, by_signal * term.spill + by_state_.col(j));
      by_state_.col(j) = by_state_.col(j) * term.decay + by_signal * term.gain;
    }
  }

  void fixes_after(double time) {
    for (; fix_ > 0 && timeline_.fixes()[fix_ - 1].time > time + kSameTime; --fix_) {
      const navigation::PlannedFix& planned = timeline_.fixes()[fix_ - 1];
      const bool own_noise = source_.aid >= 0 && source_.aid == navigation::aid_of(planned);
      if (by_state_.cols() == 0 && !own_noise) continue;
      const navigation::Measurement rows = navigation::linearise(planned, timeline_.at(planned.time), source_.model);
      for (int r = 0; r < rows.rows; ++r) {
        const auto& row = rows.row[static_cast<std::size_t>(r)];
        by_state_ += adjoint_.fix[fix_ - 1].col(r) * row.h.tail(by_state_.cols()).transpose();
        if (own_noise) add(row.variance, adjoint_.fix[fix_ - 1].col(r));
      }
    }
  }

  const Adjoint& adjoint_;
  const Timeline& timeline_;
  const Source& source_;
  navigation::Lineariser lineariser_;
  MatrixXd by_state_;  // derivatives of [p, v, psi] by the source's states at the time reached
  navigation::CoreMatrix covariance_;
  std::size_t fix_;
};

}  // namespace

navigation::CoreMatrix state_response(const Adjoint& adjoint, const Timeline& timeline, const Source& source) {
  return States(adjoint, timeline, source)();
}

navigation::CoreMatrix response(const Adjoint& adjoint, const Timeline& timeline, const Source& source,
                                double imu_interval) {
  if (!source.slow) return state_response(adjoint, timeline, source);
  navigation::CoreMatrix covariance = navigation::CoreMatrix::Zero();
  for (const auto& process : source.slow->processes)
    covariance += process_response(adjoint, timeline, source.slow->carrier, process, source.slow->epoch, imu_interval);
  return covariance;
}

}  // namespace gyrobudget::inline v0::budget

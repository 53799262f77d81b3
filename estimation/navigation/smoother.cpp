// SPDX-License-Identifier: MIT
#include "smoother.h"

#include "gyrobudget/vehicle/earth/attitude.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace gyrobudget::inline v0::navigation {
namespace {

using ConstVector = Eigen::Map<const Eigen::VectorXd>;
using ConstMatrix = Eigen::Map<const Eigen::MatrixXd>;

void append(std::vector<double>& numbers, const double* from, Eigen::Index count) {
  numbers.insert(numbers.end(), from, from + count);
}

// l and L of the header.
struct Adjoint {
  StateVector l;
  StateMatrix L;

  explicit Adjoint(int states) : l(StateVector::Zero(states)), L(StateMatrix::Zero(states, states)) {}

  void back_over_row(const double* numbers) {
    const auto n = l.size();
    const ConstVector h(numbers, n), gain(numbers + n, n);
    const double S = numbers[2 * n], residual = numbers[2 * n + 1];
    l -= (residual / S + gain.dot(l)) * h;
    const StateVector Lk = L * gain;
    const StateVector side = Lk - (gain.dot(Lk) + 1 / S) / 2 * h;
    L -= h * side.transpose() + side * h.transpose();
  }

  void back_over_stretch(const double* numbers) {
    const auto n = l.size(), terms = n - kCoreStates;
    StateMatrix Phi = StateMatrix::Zero(n, n);
    Phi.topLeftCorner<kCoreStates, kCoreStates>() = ConstMatrix(numbers, kCoreStates, kCoreStates);
    numbers += kCoreStates * kCoreStates;
    Phi.topRightCorner(kCoreStates, terms) = ConstMatrix(numbers, kCoreStates, terms);
    numbers += kCoreStates * terms;
    Phi.diagonal().tail(terms) = ConstVector(numbers, terms);
    l = (Phi.transpose() * l).eval();
    L = (Phi.transpose() * L * Phi).eval();
    L = ((L + L.transpose()) / 2).eval();
  }
};

}  // namespace

FilterHistory::FilterHistory(int states) : states_(states) {
  if (states < kCoreStates || states > kMaxStates)
    throw std::invalid_argument(fmt::format("record of {} states, expected {} to {}", states, kCoreStates, kMaxStates));
}

void FilterHistory::check(Eigen::Index states) const {
  if (states != states_) throw std::invalid_argument(fmt::format("record of {} states is given {}", states_, states));
}

void FilterHistory::moved(const Transition& step) {
  check(step.size);
  const int terms = states_ - kCoreStates;
  if (!moving_) {
    moving_ = true;
    core_.setIdentity();
    coupling_.setZero(kCoreStates, terms);
    decay_.setOnes(terms);
  }
  core_ = step.core.lazyProduct(core_).eval();
  coupling_ = step.core.lazyProduct(coupling_).eval();
  for (int k = 0; k < terms; ++k) {
    const Transition::Term& term = step.terms[static_cast<std::size_t>(k)];
    if (term.signal >= 0) coupling_.col(k) += term.gain * decay_[k] * step.input.col(term.signal);
    decay_[k] *= term.decay;
  }
}

void FilterHistory::close_stretch() {
  if (!moving_) return;
  moving_ = false;
  entries_.push_back({Kind::stretch, numbers_.size()});
  append(numbers_, core_.data(), core_.size());
  append(numbers_, coupling_.data(), coupling_.size());
  append(numbers_, decay_.data(), decay_.size());
}

void FilterHistory::updated(const MeasurementRow& row, double innovation_variance, double residual,
                            const StateVector& gain) {
  check(row.h.size());
  check(gain.size());
  close_stretch();
  entries_.push_back({Kind::row, numbers_.size()});
  append(numbers_, row.h.data(), row.h.size());
  append(numbers_, gain.data(), gain.size());
  numbers_.push_back(innovation_variance);
  numbers_.push_back(residual);
}

void FilterHistory::keep(double time, const earth::Pose& state, const StateVector& terms, const StateMatrix& P) {
  check(P.rows());
  check(P.cols());
  check(terms.size() + kCoreStates);
  close_stretch();
  entries_.push_back({Kind::epoch, numbers_.size(), epochs_.size()});
  append(numbers_, P.data(), P.size());
  epochs_.push_back({time, state, std::vector<double>(terms.data(), terms.data() + terms.size())});
}

std::size_t FilterHistory::bytes() const {
  return numbers_.capacity() * sizeof(double) + entries_.capacity() * sizeof(Entry) +
         epochs_.capacity() * (sizeof(Epoch) + static_cast<std::size_t>(states_ - kCoreStates) * sizeof(double));
}

std::vector<SmoothedEpoch> smooth(const FilterHistory& record) {
  const int n = record.states();
  Adjoint adjoint(n);
  std::vector<SmoothedEpoch> result(record.epochs());
  for (auto entry = record.entries_.rbegin(); entry != record.entries_.rend(); ++entry) {
    const double* numbers = record.numbers_.data() + entry->at;
    if (entry->kind == FilterHistory::Kind::row) {
      adjoint.back_over_row(numbers);
      continue;
    }
    if (entry->kind == FilterHistory::Kind::stretch) {
      adjoint.back_over_stretch(numbers);
      continue;
    }
    const FilterHistory::Epoch& kept = record.epochs_[entry->index];
    const ConstMatrix P(numbers, n, n);
    SmoothedEpoch& epoch = result[entry->index];
    const StateVector x = -(P * adjoint.l);
    epoch.time = kept.time;
    epoch.correction = x;
    epoch.state = {.p_eb_e = kept.state.p_eb_e + x.segment<3>(kPosition),
                   .v_eb_e = kept.state.v_eb_e + x.segment<3>(kVelocity),
                   .q_eb = (earth::exp_rotation(x.segment<3>(kAttitude)) * kept.state.q_eb).normalized()};
    epoch.terms = ConstVector(kept.terms.data(), n - kCoreStates) + x.tail(n - kCoreStates);
    const StateMatrix less = P * adjoint.L * P;
    epoch.P = P - (less + less.transpose()) / 2;
  }
  return result;
}

}  // namespace gyrobudget::inline v0::navigation

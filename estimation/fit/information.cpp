// SPDX-License-Identifier: MIT
#include "information.h"

#include <boost/math/quadrature/gauss.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Cholesky>

namespace gyrobudget::inline v0::fit {
namespace {

// Terms summed one by one. The midpoint rule behind them is wrong by f''/24 a term, below 1e-6 of the sum.
constexpr std::int64_t kSummed = 512;
constexpr double kPanelRatio = 1.25;
constexpr double kMostSamples = 1e15;
constexpr double kFewestSamples = 16;

// d ln gain/d ln bandwidth at a frequency.
class BandwidthSlope {
 public:
  BandwidthSlope(const noise::FrontEnd& front_end, double dt)
      : dt_(dt), above_(moved(front_end, kStep), dt), below_(moved(front_end, -kStep), dt) {}
  double operator()(double f) const {
    return std::log(above_.power_gain(f * dt_) / below_.power_gain(f * dt_)) / (2 * kStep);
  }

 private:
  static constexpr double kStep = 1e-4;
  static noise::FrontEnd moved(noise::FrontEnd front_end, double by) {
    front_end.bandwidth *= std::exp(by);
    return front_end;
  }
  double dt_;
  noise::SampledFrontEnd above_, below_;
};

class Information {
 public:
  Information(std::span<const noise::Process> processes, double samples, double dt,
              std::optional<BandwidthSlope> bandwidth = {})
      : processes_(processes), samples_(samples), dt_(dt), bandwidth_(std::move(bandwidth)) {
    slope_.resize(static_cast<Eigen::Index>(processes.size() + (bandwidth_ ? 1 : 0)));
    matrix_.setZero(slope_.size(), slope_.size());
  }

  Eigen::MatrixXd compute() {
    const double last = samples_ - 1;
    const double summed = std::min(last, static_cast<double>(kSummed));
    for (double k = 1; k <= summed; ++k) add(k, 1);
    for (double low = summed + 0.5;
         low < last + 0.5;) {  // midpoint rule: the sum over a+1..b is the integral over [a, b] + 1/2
      const double high = std::min(low * kPanelRatio, last + 0.5);
      add_panel(low, high);
      low = high;
    }
    return matrix_;
  }

 private:
  // weight/2 * g g' at (real) index k.
  void add(double k, double weight) {
    const double f = k / (2 * samples_ * dt_);
    const auto count = static_cast<Eigen::Index>(processes_.size());
    auto share = slope_.head(count);
    for (Eigen::Index a = 0; a < count; ++a) share(a) = noise::psd(processes_[static_cast<std::size_t>(a)], f, dt_);
    share /= share.sum();
    if (bandwidth_) slope_(count) = (*bandwidth_)(f);
    matrix_ += 0.5 * weight * slope_ * slope_.transpose();
  }

  void add_panel(double low, double high) {
    using Rule = boost::math::quadrature::gauss<double, 10>;  // abscissas of the half interval, symmetric
    const double center = 0.5 * (low + high), half = 0.5 * (high - low);
    for (std::size_t i = 0; i < Rule::abscissa().size(); ++i) {
      const double offset = half * Rule::abscissa()[i], weight = half * Rule::weights()[i];
      add(center + offset, weight);
      add(center - offset, weight);
    }
  }

  std::span<const noise::Process> processes_;
  double samples_, dt_;
  std::optional<BandwidthSlope> bandwidth_;
  Eigen::VectorXd slope_;  // of ln S by the parameters: by ln theta that is a process' share of S
  Eigen::MatrixXd matrix_;
};

void check(std::span<const noise::Process> processes, double samples, double dt) {
  if (processes.empty()) throw std::invalid_argument("the information needs at least one process");
  if (!(samples >= 3)) throw std::invalid_argument(fmt::format("{} samples are too few; at least 3", samples));
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("sample interval {} s is not above 0", dt));
  for (const auto& process : processes) {
    const auto t = noise::term(process);
    const bool random = t != noise::Term::rate_ramp && t != noise::Term::sinusoid;
    if (!random || !(noise::coefficient(process) > 0)) {
      throw std::invalid_argument(fmt::format(
          "term {} with coefficient {}: only random processes with a coefficient above 0 have this information",
          static_cast<char>(t), noise::coefficient(process)));
    }
  }
}

Eigen::VectorXd bound(std::span<const noise::Process> processes, double samples, double dt,
                      std::optional<BandwidthSlope> bandwidth = {}) {
  const Eigen::MatrixXd information = Information(processes, samples, dt, std::move(bandwidth)).compute();
  // Unit diagonal first: the informations of N and K differ by decades.
  const Eigen::VectorXd length = information.diagonal().cwiseSqrt();
  const Eigen::MatrixXd unit = length.cwiseInverse().asDiagonal() * information * length.cwiseInverse().asDiagonal();
  const Eigen::MatrixXd inverse = unit.llt().solve(Eigen::MatrixXd::Identity(unit.rows(), unit.cols()));
  return 0.5 * inverse.diagonal().cwiseSqrt().cwiseQuotient(length).head(static_cast<Eigen::Index>(processes.size()));
}

}  // namespace

Eigen::MatrixXd fisher_information(std::span<const noise::Process> processes, std::int64_t samples, double dt) {
  check(processes, static_cast<double>(samples), dt);
  return Information(processes, static_cast<double>(samples), dt).compute();
}

Eigen::VectorXd relative_bound(std::span<const noise::Process> processes, std::int64_t samples, double dt) {
  check(processes, static_cast<double>(samples), dt);
  return bound(processes, static_cast<double>(samples), dt);
}

Eigen::VectorXd relative_bound(std::span<const noise::Process> processes, const noise::FrontEnd& of_unknown_bandwidth,
                               std::int64_t samples, double dt) {
  check(processes, static_cast<double>(samples), dt);
  return bound(processes, static_cast<double>(samples), dt, BandwidthSlope(of_unknown_bandwidth, dt));
}

double duration_for(std::span<const noise::Process> processes, std::size_t index, double relative_std, double dt) {
  check(processes, kFewestSamples, dt);
  if (index >= processes.size() || !(relative_std > 0)) {
    throw std::invalid_argument(fmt::format("relative standard deviation {} of process {} of {}: must be above 0",
                                            relative_std, index, processes.size()));
  }
  const auto enough = [&](double log_samples) {
    return bound(processes, std::floor(std::exp(log_samples)), dt)(static_cast<Eigen::Index>(index)) <= relative_std;
  };
  double low = std::log(kFewestSamples), high = std::log(kMostSamples);
  if (enough(low)) return kFewestSamples * dt;
  if (!enough(high)) return std::numeric_limits<double>::infinity();
  while (high - low > 1e-6) {
    const double middle = 0.5 * (low + high);
    (enough(middle) ? high : low) = middle;
  }
  return std::exp(high) * dt;
}

}  // namespace gyrobudget::inline v0::fit

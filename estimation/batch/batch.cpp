// SPDX-License-Identifier: MIT
#include "batch.h"

#include "gyrobudget/estimation/batch/detail/costs.h"
#include "gyrobudget/estimation/batch/detail/marginals.h"
#include "gyrobudget/estimation/batch/detail/solver.h"
#include "gyrobudget/estimation/navigation/detail/events.h"
#include "gyrobudget/estimation/navigation/detail/fix_track.h"
#include "gyrobudget/estimation/navigation/detail/runner.h"
#include "gyrobudget/estimation/navigation/detail/solution.h"
#include "gyrobudget/vehicle/earth/gravity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace gyrobudget::inline v0::batch {
namespace {

using detail::Cost;
using detail::Layout;
using detail::Node;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using navigation::kCoreStates;
using navigation::Navigation;
using navigation::Recording;
using navigation::Scenario;
using navigation::SetupError;

constexpr double kTick = 1e-7;  // s: within it times are one node
constexpr double kMostNodes = 50000;
constexpr double kSettled = 1e-3;  // of half the sum: sigmas move by 0.05 at most for what is left

void check(const Options& options) {
  const auto require = [](bool good, const char* what, double value) {
    if (!good) throw SetupError(fmt::format("{} of a batch estimate is {:g}, expected above 0", what, value));
  };
  require(options.scale > 0, "scale of the loss", options.scale);
  constexpr double kLongest = 10;  // s: gravitation is taken as straight in time from node to node
  if (!(options.longest_interval > 0 && options.longest_interval <= kLongest))
    throw SetupError(fmt::format("longest interval of a batch estimate is {:g} s, expected above 0 and at most {:g} s",
                                 options.longest_interval, kLongest));
  require(options.iterations > 0, "number of iterations", options.iterations);
  require(options.integrations > 0, "number of integrations", options.integrations);
}

// Ascending, none twice, none farther apart than `longest`.
std::vector<double> node_times(const Navigation& filtered, double longest) {
  std::vector<double> wanted;
  for (const auto& at : filtered.innovations) wanted.push_back(at.time);
  for (const auto& at : filtered.solutions) wanted.push_back(at.time);
  std::ranges::sort(wanted);
  std::vector<double> times{wanted.front()};
  for (const double t : wanted) {
    const double from = times.back(), parts = std::ceil((t - from) / longest);
    if (t - from <= kTick) continue;
    if (static_cast<double>(times.size()) + parts > kMostNodes)
      throw SetupError(fmt::format(
          "a batch estimate of more than {:g} nodes: take a shorter part of the log, fewer fixes or a longer interval of solutions",
          kMostNodes));
    for (double i = 1; i < parts; ++i) times.push_back(from + i / parts * (t - from));
    times.push_back(t);
  }
  return times;
}

std::size_t node_at(const std::vector<Node>& nodes, double t) {
  const auto at = std::ranges::lower_bound(nodes, t - 2 * kTick, {}, &Node::time);
  return static_cast<std::size_t>(std::min(at, nodes.end() - 1) - nodes.begin());
}

class Batch {
 public:
  Batch(const Scenario& scenario, const Recording& recording, const Options& options)
      : scenario_(scenario), recording_(recording), options_(options) {}

  Estimate run() {
    Scenario plain = scenario_;
    plain.smooth = false;
    plain.reference.clear();
    navigation::detail::check_input(plain, recording_);
    const Navigation filtered = navigation::detail::run(plain, recording_);
    result_.model = filtered.model;
    result_.left_out = filtered.left_out;
    result_.alignment = filtered.alignment;
    // A filter that is lost is a start all the same.
    const bool started = filtered.status == Navigation::Status::navigated ||
                         filtered.status == Navigation::Status::recovered ||
                         filtered.status == Navigation::Status::lost;
    if (!started || filtered.solutions.empty()) return stop(Estimate::Status::no_filter, filtered.why);
    for (const auto& s : filtered.solutions) solution_times_.push_back(s.time);
    const std::vector<double> times = node_times(filtered, options_.longest_interval);
    plain.at = times;
    const Layout layout(filtered.model);
    begin(layout, navigation::detail::run(plain, recording_), times);
    fixes(filtered);
    say_considered();
    return solve(layout, filtered.P0);
  }

 private:
  Estimate stop(Estimate::Status status, std::string why) {
    result_.status = status;
    result_.why = std::move(why);
    return std::move(result_);
  }

  // Where the filter was.
  void begin(const Layout& layout, const Navigation& guess, const std::vector<double>& times) {
    for (const double t : times) {
      const auto at = std::ranges::lower_bound(guess.solutions, t - 2 * kTick, {}, &navigation::Solution::time);
      const navigation::Solution& s = at == guess.solutions.end() ? guess.solutions.back() : *at;
      Node node{t, s.state, VectorXd(static_cast<Eigen::Index>(layout.chained.size()))};
      for (std::size_t i = 0; i < layout.chained.size(); ++i)
        node.chained[static_cast<Eigen::Index>(i)] = s.terms[static_cast<std::size_t>(layout.chained[i])];
      unknowns_.nodes.push_back(std::move(node));
    }
    const navigation::Solution& last = guess.solutions.back();
    unknowns_.global.resize(layout.global_size());
    for (std::size_t i = 0; i < layout.global.size(); ++i) {
      const auto k = static_cast<std::size_t>(layout.global[i]);
      const double left = navigation::decay(layout.model.terms[k], last.time - times.front());
      unknowns_.global[static_cast<Eigen::Index>(i)] = left > 0.1 ? last.terms[k] / left : 0;
    }
    result_.nodes = times.size();
  }

  // Every fix that the filter saw, those that its gate refused included.
  void fixes(const Navigation& filtered) {
    static const navigation::Fix kAtRest{};
    for (std::size_t i = 0; i < scenario_.aids.size(); ++i)
      tracks_.emplace_back(scenario_.aids[i], recording_.fixes[i], recording_.origin);
    std::int64_t not_finite = 0;
    for (const auto& at : filtered.innovations) {
      if (at.innovation.status == navigation::Innovation::Status::not_finite) {
        ++not_finite;
        continue;
      }
      const navigation::Aid& aid = scenario_.aids[at.aid];
      const bool rest = aid.kind == navigation::Aid::Kind::rest;
      const navigation::Fix& fix =
          rest ? kAtRest : tracks_[at.aid].fix(tracks_[at.aid].first_from(at.time - navigation::detail::kSame));
      used_.push_back({static_cast<int>(node_at(unknowns_.nodes, at.time)), at.aid, &fix});
      result_.fixes.push_back({at.time, at.aid, navigation::rows(aid.kind), 0, 1});
    }
    if (not_finite > 0)
      result_.left_out.push_back({fmt::format("{} fixes", not_finite), "they hold numbers that are not finite"});
  }

  void say_considered() {
    for (const auto& term : result_.model.terms)
      if (term.considered)
        result_.left_out.push_back(
            {fmt::format("consideration of {}", navigation::name(term)), "a batch estimate estimates it"});
  }

  // The terms of the sum about increments of the IMU; the fixes' are last.
  [[nodiscard]] std::vector<std::unique_ptr<Cost>> costs(const Layout& layout, const navigation::StateMatrix& P0,
                                                         const std::vector<detail::Increment>& increments) const {
    std::vector<std::unique_ptr<Cost>> list;
    const double since = unknowns_.nodes.front().time;
    list.push_back(detail::prior_cost(layout, result_.alignment.state, P0));
    for (std::size_t k = 0; k < increments.size(); ++k)
      list.push_back(detail::increment_cost(layout, static_cast<int>(k), increments[k], since));
    for (const Used& used : used_) {
      const auto k = static_cast<std::size_t>(used.node);
      const detail::Sensed sensed = increments.empty() ? detail::Sensed{}
                                    : k > 0            ? increments[k - 1].end
                                                       : increments[0].begin;
      list.push_back(detail::fix_cost(layout, used.node, sensed, scenario_.aids[used.aid], static_cast<int>(used.aid),
                                      *used.fix, since));
    }
    return list;
  }

  Estimate solve(const Layout& layout, const navigation::StateMatrix& P0) {
    const detail::Preintegrator integrate(recording_, layout, scenario_.filter.strapdown);
    bool settled = false;
    try {
      for (int i = 0; i < options_.integrations && !settled; ++i) {
        const std::vector<detail::Increment> increments = integrate(unknowns_.nodes, unknowns_.global);
        const auto list = costs(layout, P0, increments);
        const detail::Solved solved = detail::solve(layout, list, list.size() - used_.size(), options_, unknowns_);
        if (!solved.usable) return stop(Estimate::Status::not_converged, solved.why);
        if (i == 0) result_.first_cost = solved.first_cost;
        settled = solved.converged && solved.first_cost - solved.cost <= kSettled;
        result_.cost = solved.cost;
        result_.iterations += solved.iterations;
        ++result_.integrations;
        if (settled || i + 1 == options_.integrations)
          if (!conclude(layout, list))
            return stop(Estimate::Status::not_observable,
                        "the fixes and the start leave a combination of states unknown: no covariance exists");
      }
    } catch (const earth::OutsideDomain& error) {
      return stop(Estimate::Status::not_converged, error.what());
    } catch (const navigation::Diverged& error) {
      return stop(Estimate::Status::not_converged, error.what());
    }
    if (!settled)
      return stop(Estimate::Status::not_converged,
                  fmt::format("after {} integrations of the IMU the sum still falls", result_.integrations));
    return std::move(result_);
  }

  // Weights of fixes, covariances, solutions. False: singular.
  bool conclude(const Layout& layout, const std::vector<std::unique_ptr<Cost>>& list) {
    detail::Information information(unknowns_.nodes.size(), layout.node_size(), layout.global_size());
    const std::size_t first_fix = list.size() - used_.size();
    for (std::size_t i = 0; i < list.size(); ++i) {
      const detail::Linear linear = detail::linearise(*list[i], unknowns_);
      double weight = 1;
      if (i >= first_fix) {
        FixUse& use = result_.fixes[i - first_fix];
        use.squared = linear.residual.squaredNorm();
        use.weight = weight = detail::weight(options_, use.squared);
      }
      detail::add(linear, list[i]->nodes(), weight, information);
    }
    const std::vector<MatrixXd> covariances = detail::marginals(std::move(information));
    if (covariances.empty()) return false;
    for (const double t : solution_times_) {
      const std::size_t k = node_at(unknowns_.nodes, t);
      result_.solutions.push_back(solution(layout, unknowns_.nodes[k], covariances[k], t));
    }
    return true;
  }

  // Terms in the model's order; what decays of the globals does so in their sigmas too.
  [[nodiscard]] navigation::Solution solution(const Layout& layout, const Node& node, const MatrixXd& covariance,
                                              double t) const {
    const double since = unknowns_.nodes.front().time;
    const VectorXd terms = detail::terms_at(layout, node, unknowns_.global, since);
    MatrixXd T = MatrixXd::Zero(kCoreStates + terms.size(), covariance.rows());
    T.topLeftCorner<kCoreStates, kCoreStates>().setIdentity();
    for (std::size_t i = 0; i < layout.chained.size(); ++i)
      T(kCoreStates + layout.chained[i], kCoreStates + static_cast<int>(i)) = 1;
    for (std::size_t i = 0; i < layout.global.size(); ++i)
      T(kCoreStates + layout.global[i], layout.node_size() + static_cast<int>(i)) =
          navigation::decay(layout.model.terms[static_cast<std::size_t>(layout.global[i])], node.time - since);
    navigation::Estimate estimate;
    estimate.motion.pose = node.pose;
    estimate.model = &layout.model;
    estimate.terms = terms.data();
    return navigation::detail::solution(estimate, T * covariance * T.transpose(), t);
  }

  struct Used {
    int node;
    std::size_t aid;
    const navigation::Fix* fix;
  };
  const Scenario& scenario_;
  const Recording& recording_;
  Options options_;
  Estimate result_;
  std::vector<double> solution_times_;
  std::vector<navigation::detail::FixTrack> tracks_;
  std::vector<Used> used_;
  detail::Unknowns unknowns_;
};

}  // namespace

Estimate estimate(const Scenario& scenario, const Recording& recording, const Options& options) {
  check(options);
  return Batch(scenario, recording, options).run();
}

}  // namespace gyrobudget::inline v0::batch

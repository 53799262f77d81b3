// SPDX-License-Identifier: MIT
#include "runner.h"

#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <variant>

#include "comparison.h"
#include "events.h"
#include "fix_track.h"
#include "imu_reader.h"
#include "innovation_sums.h"
#include "measure_fix.h"
#include "recovery.h"
#include "solution.h"
#include "start.h"
#include "unknown_motion.h"

namespace gyrobudget::inline v0::navigation::detail {
namespace {

using noise::kNanosecond;

// An aid's terms; the error of a clock that several aids share is a term of the first.
AidTerms terms_with_clock(const std::vector<Aid>& aids, std::size_t number) {
  AidTerms result = aid_terms(aids[number], static_cast<int>(number));
  if (result.terms.empty() || result.terms.back().effect != Effect::time_tag) return result;
  if (clock_of(aids, number) != number) {
    result.terms.pop_back();
    result.variances.pop_back();
    return result;
  }
  for (std::size_t i = number + 1; i < aids.size() && clock_of(aids, i) == number; ++i)
    result.terms.back().aids = static_cast<int>(i - number) + 1;
  return result;
}

SensorStates states(const Scenario& scenario, double length, double step) {
  SensorStates::Options options = scenario.states;
  options.scene_length = length;
  options.step = step;
  SensorStates result = sensor_states(scenario.sensor, options);
  std::vector<double> variances;
  for (std::size_t i = 0; i < scenario.aids.size(); ++i) {
    if (scenario.aids[i].used) {
      const AidTerms aid = terms_with_clock(scenario.aids, i);
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

class Runner {
 public:
  Runner(const Scenario& scenario, const Recording& recording)
      : scenario_(scenario), recording_(recording), gaps_(recording.imu) {
    tracks_.reserve(scenario.aids.size());
    for (std::size_t i = 0; i < scenario.aids.size(); ++i)
      tracks_.emplace_back(scenario.aids[i], recording.fixes[i], recording.origin);
  }

  [[nodiscard]] Navigation run() {
    const auto span = start_span(scenario_, recording_.imu, tracks_, recording_.origin);
    if (const auto* no = std::get_if<NoStart>(&span)) return refuse(*no);
    const Span aligning = std::get<Span>(span);
    end_ =
        std::min(scenario_.until, static_cast<double>(recording_.imu.stamps.back() - recording_.origin) * kNanosecond);
    check_counts(aligning);
    const SensorStates sensors = states(scenario_, end_ - aligning.from, recording_.imu.typical_interval);
    const auto start = detail::start(scenario_, recording_, tracks_, aligning, sensors.model, sensors.initial);
    if (const auto* no = std::get_if<NoStart>(&start)) return refuse(*no);
    const auto& begin = std::get<Start>(start);
    result_.model = sensors.model;
    result_.left_out = sensors.left_out;
    result_.alignment = begin.result;
    result_.P0 = begin.P0;
    for (Eigen::Index k = kCoreStates; k < begin.P0.rows(); ++k) result_.initial.push_back(std::sqrt(begin.P0(k, k)));
    Filter filter(begin.result.state, sensors.model, begin.P0, scenario_.filter);
    ImuReader imu(recording_.imu, recording_.origin, aligning.to);
    navigate(filter, imu, events(scenario_, tracks_, begin.used_to, {aligning.to, end_}));
    say_outside();
    return std::move(result_);
  }

 private:
  [[nodiscard]] Navigation refuse(const NoStart& no) {
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

  // What one filter did, from its start to where another took over.
  struct Segment {
    std::unique_ptr<FilterHistory> record;
    std::vector<Estimate> kept;  ///< what of an epoch smoothing does not change
    std::vector<double> times;
  };

  void navigate(Filter& filter, ImuReader& imu, const EventList& list) {
    InnovationSums sums(scenario_, result_.aids);
    for (AidSummary& aid : result_.aids) aid.left_out = list.left_out[aid.aid];
    Comparison comparison(scenario_, tracks_);
    Recovery recovery(scenario_, imu.now());
    std::vector<Segment> segments(1);
    if (scenario_.smooth) {
      segments.back().record = std::make_unique<FilterHistory>(result_.model.states());
      filter.record(segments.back().record.get());
    }
    const auto step = [&](const Event& event) {
      advance(filter, recovery, imu, event.time);
      if (event.aid != scenario_.aids.size()) {
        use(filter, recovery, event, sums);
        if (std::optional<Trial> found = recovery.found(event.time)) take_over(filter, *found, segments);
      } else if (scenario_.smooth) {
        segments.back().kept.push_back(filter.estimate());
        segments.back().times.push_back(event.time);
        filter.keep_epoch();
      } else {
        filter.catch_up();
        solve(filter.estimate(), filter.covariance().matrix(), event.time, comparison);
      }
    };
    as_far_as_possible(imu, [&] {
      for (const Event& event : list.events) step(event);
    });
    as_far_as_possible(imu, [&] {
      for (Segment& segment : segments) solve_smoothed(segment, comparison);
    });
    sums.finish();
    result_.reference = comparison.finish();
    recovery.finish(imu.now(), result_);
    for (Solution& s : result_.solutions)
      s.lost = std::ranges::any_of(result_.lost, [&](const LostSpan& l) {
        const bool after = l.from < s.time || l.from == result_.alignment.to;  // no fix has agreed with the start
        return after && (s.time < l.to || !l.recovered);
      });
  }

  void solve(const Estimate& estimate, const StateMatrix& P, double t, Comparison& comparison) {
    result_.solutions.push_back(solution(estimate, P, t));
    comparison.compare(estimate, P, t);
  }

  void solve_smoothed(Segment& segment, Comparison& comparison) {
    if (!segment.record) return;
    const std::vector<SmoothedEpoch> smoothed = smooth(*segment.record);
    for (std::size_t i = 0; i < smoothed.size(); ++i) {
      segment.kept[i].motion.pose = smoothed[i].state;
      segment.kept[i].terms = smoothed[i].terms.data();
      solve(segment.kept[i], smoothed[i].P, segment.times[i], comparison);
    }
  }

  // A restart ends what was smoothed together: what comes after tells nothing of a filter that was wrong.
  static void take_over(Filter& filter, Trial& found, std::vector<Segment>& segments) {
    filter = found.filter;
    if (!found.record) return;
    segments.push_back({std::move(found.record), {}, {}});
  }

  // Does what it can until the solution leaves what can be computed: that is an answer. Any other exception is none.
  template <class Work>
  void as_far_as_possible(const ImuReader& imu, const Work& work) {
    const auto fail = [&](const std::exception& error) {
      if (result_.status == Navigation::Status::failed) return;
      result_.status = Navigation::Status::failed;
      result_.why = fmt::format("at {:g} s: {}", imu.now(), error.what());
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

  void advance(Filter& filter, Recovery& recovery, ImuReader& imu, double to) {
    while (imu.before(to)) {
      const ImuReader::Piece piece = imu.next(to);
      const UnknownMotion* unknown = gaps_.at(piece.interval);
      const auto propagate = [&](Filter& moved) {
        if (unknown != nullptr) moved.set_unknown_motion(unknown->rate, unknown->force);
        moved.propagate(piece.increment, piece.dt);
        if (unknown != nullptr) moved.set_unknown_motion({0, 0, 0}, {0, 0, 0});
      };
      propagate(filter);
      recovery.each(propagate);
      ++result_.steps;
    }
  }

  void use(Filter& filter, Recovery& recovery, const Event& event, InnovationSums& sums) {
    const Aid& aid = scenario_.aids[event.aid];
    static const Fix kAtRest{};
    const Fix& fix = aid.kind == Aid::Kind::rest ? kAtRest : tracks_[event.aid].fix(event.fix);
    const Measurement m = measure_fix(aid, static_cast<int>(event.aid), fix, filter.estimate(), sigma_of(aid, fix));
    result_.innovations.push_back({event.time, event.aid, filter.update(m)});
    sums.add(result_.innovations.back());
    recovery.saw(event.aid, fix, event.time, result_.innovations.back().innovation, filter);
  }

  const Scenario& scenario_;
  const Recording& recording_;
  Gaps gaps_;
  std::vector<FixTrack> tracks_;
  Navigation result_;
  double end_ = 0;
};

}  // namespace

Navigation run(const Scenario& scenario, const Recording& recording) { return Runner(scenario, recording).run(); }

}  // namespace gyrobudget::inline v0::navigation::detail

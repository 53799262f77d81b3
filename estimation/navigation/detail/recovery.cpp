// SPDX-License-Identifier: MIT
#include "recovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "measure_fix.h"

namespace gyrobudget::inline v0::navigation::detail {
namespace {

constexpr double kHolds = 30;              // s without a loss, after which a recovery has held
constexpr std::ptrdiff_t kMostInVain = 2;  // recoveries that do not hold

}  // namespace

Recovery::Recovery(const Scenario& scenario, double start) : scenario_(scenario), watch_(scenario, start) {}

void Recovery::saw(std::size_t aid, const Fix& fix, double time, const Innovation& innovation, const Filter& filter) {
  const bool watched = LostWatch::watched(scenario_.aids[aid]).has_value();
  const bool disagrees = watch_.saw(aid, time, innovation);
  try_fix(aid, fix, watched);
  if (!trials_.empty() && aid == aid_) disagreed_ += disagrees ? 1 : 0;
  if (!trials_.empty() && watch_.settled(aid_)) trials_.clear();
  if (trials_.empty() && disagrees) start(aid, fix, time, innovation, filter);
  if (const auto why = watch_.lost()) say_lost(watch_.last_good(aid), *why);
}

void Recovery::try_fix(std::size_t number, const Fix& fix, bool watched) {
  const Aid& aid = scenario_.aids[number];
  const auto update = [&](Trial& trial) {
    const Innovation innovation = trial.filter.update(
        measure_fix(aid, static_cast<int>(number), fix, trial.filter.estimate(), sigma_of(aid, fix)));
    trial.log_likelihood -= (innovation.nis + innovation.log_det) / 2;
    return watched && (innovation.status == Innovation::Status::gated || contradicted_.passed(innovation));
  };
  std::erase_if(trials_, [&](Trial& trial) {
    try {
      return update(trial);
    } catch (const Diverged&) {
      return true;
    } catch (const earth::OutsideDomain&) {
      return true;
    }
  });
}

void Recovery::start(std::size_t aid, const Fix& fix, double time, const Innovation& innovation, const Filter& filter) {
  constexpr double kShortest = 0.1;  // s
  const Refused refused{.kind = *LostWatch::watched(scenario_.aids[aid]),
                        .innovation = innovation,
                        .since = std::max(time - watch_.last_good(aid), kShortest)};
  trials_ = trials(filter, refused, scenario_.smooth);
  aid_ = aid;
  began_ = time;
  disagreed_ = 0;
  try_fix(aid, fix, true);
  for (Trial& trial : trials_) trial.log_likelihood = 0;  // they were made for this fix
}

std::optional<Trial> Recovery::found(double time) {
  if (trials_.empty() || disagreed_ < LostWatch::kAgreeing || time - began_ < LostWatch::kSpan) return std::nullopt;
  say_lost(watch_.last_good(aid_),
           fmt::format("{} fixes of {} in {:.3g} s agree with each other and not with the filter", disagreed_,
                       scenario_.aids[aid_].name, time - began_));
  if (!scenario_.recovery) {
    trials_.clear();
    return std::nullopt;
  }
  Trial best = std::move(*std::ranges::max_element(trials_, {}, &Trial::log_likelihood));
  trials_.clear();
  LostSpan& span = spans_.back();
  span.to = time;
  span.recovered = true;
  span.restarted = best.what;
  watch_.forget(time);
  return best;
}

void Recovery::say_lost(double from, std::string why) {
  if (!spans_.empty() && !spans_.back().recovered) return;
  if (!spans_.empty()) spans_.back().held = from - spans_.back().to >= kHolds;
  const double after = spans_.empty() ? from : std::max(from, spans_.back().to);
  spans_.push_back({.from = after, .to = after, .why = std::move(why), .restarted = {}});
}

void Recovery::finish(double end, Navigation& result) const {
  result.lost = spans_;
  if (!result.lost.empty() && !result.lost.back().recovered) result.lost.back().to = end;
  if (result.status != Navigation::Status::navigated) return;
  const auto set = [&](Navigation::Status status, std::string why) {
    result.status = status;
    result.why = std::move(why);
  };
  for (const AidSummary& aid : result.aids) {
    const bool watched = LostWatch::watched(scenario_.aids[aid.aid]).has_value();
    if (watched && aid.gated >= LostWatch::kAgreeing && aid.gated > aid.used)
      set(Navigation::Status::lost, fmt::format("{} of {} fixes of {} disagree with the filter", aid.gated,
                                                aid.gated + aid.used, scenario_.aids[aid.aid].name));
  }
  if (spans_.empty()) return;
  const auto in_vain = std::ranges::count_if(spans_, [](const LostSpan& span) { return !span.held; });
  const LostSpan& last = result.lost.back();
  if (!last.recovered)
    set(Navigation::Status::lost, fmt::format("lost from {:.6g} s on: {}", last.from, last.why));
  else if (in_vain >= kMostInVain)
    set(Navigation::Status::lost,
        fmt::format("lost {} times, and soon again {} times of these: {}", spans_.size(), in_vain, spans_.front().why));
  else if (result.status == Navigation::Status::navigated)
    set(Navigation::Status::recovered,
        fmt::format("lost from {:.6g} s to {:.6g} s{}: {}; found again by the fixes", spans_.front().from,
                    spans_.front().to, spans_.size() > 1 ? fmt::format(" and {} times more", spans_.size() - 1) : "",
                    spans_.front().why));
}

}  // namespace gyrobudget::inline v0::navigation::detail

// SPDX-License-Identifier: MIT
#include "selection.h"

#include "gyrobudget/estimation/fit/detail/judge.h"
#include "gyrobudget/estimation/fit/detail/likelihood.h"
#include "gyrobudget/estimation/fit/detail/sine.h"
#include "gyrobudget/estimation/fit/detail/tilt.h"
#include "gyrobudget/estimation/fit/detail/transformed.h"
#include "gyrobudget/noise/normal.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/tools/minima.hpp>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
using Terms = std::vector<Term>;
constexpr double kIndistinguishable = 2;  // in ln L
constexpr double kMuchBetter = 5;  // in ln L: what lets a Gauss-Markov process go before a term with less freedom
constexpr std::array kReplacements{Term::flicker, Term::rate_random_walk, Term::rate_ramp, Term::gauss_markov};
constexpr double kTimeRatio = 1.9952623149688795;  // 10^0.3, of the grid of correlation times

bool holds(const Terms& terms, Term t) { return std::find(terms.begin(), terms.end(), t) != terms.end(); }

Terms with(Terms terms, Term t) {
  terms.push_back(t);
  return in_order(terms);
}

Terms without(Terms terms, Term t) {
  std::erase(terms, t);
  return terms;
}

// The likelihoods of a set of terms: one, or with a Gauss-Markov process one for each correlation time of a grid. The
// grid stands for the search: data and simulated spectra are held against the same.
class Family {
 public:
  Family(const SineBins& bins, const Terms& terms, std::optional<double> known_time = {}) {
    std::vector<noise::Process> processes;
    for (const Term t : terms) {
      if (t != Term::rate_ramp && t != Term::sinusoid) processes.push_back(noise::unit_process(t));
    }
    const bool ramp = holds(terms, Term::rate_ramp);
    if (!holds(terms, Term::gauss_markov)) {
      members_.emplace_back(bins, processes, ramp);
      return;
    }
    if (known_time) {
      std::get<noise::GaussMarkov>(processes.back()).correlation_time = *known_time;
      members_.emplace_back(bins, processes, ramp);
      times_.push_back(*known_time);
      return;
    }
    const double shortest = 2 * bins.dt, longest = 0.25 * static_cast<double>(bins.samples) * bins.dt;
    for (double time = shortest; time <= longest; time *= kTimeRatio) {
      std::get<noise::GaussMarkov>(processes.back()).correlation_time = time;
      members_.emplace_back(bins, processes, ramp);
      times_.push_back(time);
    }
  }

  struct Best {
    const SineLikelihood* likelihood = nullptr;
    SineLikelihood::Point point;
    double time = 0;  // the correlation time, with a Gauss-Markov process
  };
  // Of the data.
  [[nodiscard]] Best best() const {
    Best best;
    for (std::size_t i = 0; i < members_.size(); ++i) {
      auto point = members_[i].maximise();
      if (best.likelihood && !(point.cost < best.point.cost)) continue;
      best = {&members_[i], std::move(point), times_.empty() ? 0 : times_[i]};
    }
    return best;
  }
  // The least cost of simulated data.
  [[nodiscard]] double least_cost(const Eigen::ArrayXd& power) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& member : members_) least = std::min(least, member.with_power(power).maximise().cost);
    return least;
  }

 private:
  std::vector<SineLikelihood> members_;
  std::vector<double> times_;
};

// A mean of `count` squares of independent normal numbers for each bin: by definition for few, by the cube-root
// approximation of Wilson and Hilferty (relative error 1e-4 in its quantiles) for many.
Eigen::ArrayXd mean_squares(const Eigen::ArrayXd& count, noise::StreamKey key) {
  constexpr double kFew = 30;
  const double needed = count.min(kFew).sum();
  std::vector<double> normal(static_cast<std::size_t>(needed) + static_cast<std::size_t>(count.size()));
  noise::fill_normal(key, 0, normal);
  Eigen::ArrayXd mean(count.size());
  std::size_t next = 0;
  for (Eigen::Index b = 0; b < count.size(); ++b) {
    if (count(b) > kFew) {
      const double v = 2 / (9 * count(b));
      mean(b) = std::pow(1 - v + std::sqrt(v) * normal[next++], 3);
    } else {
      double sum = 0;
      for (int i = 0; i < static_cast<int>(count(b)); ++i) sum += normal[next] * normal[next], ++next;
      mean(b) = count(b) > 0 ? sum / count(b) : 0;
    }
  }
  return mean;
}

struct Candidate {
  Term term = Term::white;
  double gain = 0, cut = 0;  // in -2 ln L
};

class Search {
 public:
  Search(const Transformed& t, std::int64_t last, const SelectionOptions& options)
      : t_(t), last_(last), options_(options), bins_(bins_of(t)) {}

  Selection run() {
    Selection s;
    s.terms = {Term::white};
    for (;; ++step_) {
      const auto list = weigh(s.terms);
      const auto chosen = choose(list);
      for (const auto& c : list) {
        const bool kept = chosen && c.term == *chosen;
        s.weighed.push_back({s.terms, c.term, 0.5 * c.gain, 0.5 * c.cut, kept});
      }
      if (!chosen) break;
      if (*chosen == Term::sinusoid) remove_line(s.terms);
      s.terms = with(s.terms, *chosen);
      if (holds(s.terms, Term::gauss_markov)) {  // what came beside it may have been part of its hump
        time_ = refined_time(s.terms);
        drop_needless(s);
      }
    }
    simplify(s);
    if (holds(s.terms, Term::gauss_markov)) s.correlation_time_s = time_;
    if (holds(s.terms, Term::sinusoid)) s.frequency_hz = frequency_;
    s.tau_min_s = options_.tau_min_s;
    return s;
  }

 private:
  [[nodiscard]] SineBins bins_of(const Transformed& t) const {
    SineBins bins(t.coefficients, t.used.count, t.dt, last_,
                  options_.front_end ? widest_bin(t.used.count) : SineBins::kAnyWidth);
    for (const TransformedStretch& other : t.others) bins.add(other.coefficients, other.used.count);
    if (options_.front_end) {
      leave_out_stop_band(bins, *options_.front_end);
      bins.gain = gain_of(bins, *options_.front_end);
    }
    return bins;
  }

  [[nodiscard]] double cost(const Terms& terms) const { return Family(bins_, terms, time_).best().point.cost; }

  [[nodiscard]] double refined_time(const Terms& terms) const {
    const double near = Family(bins_, terms).best().time;
    const auto at = [&](double log_time) { return Family(bins_, terms, std::exp(log_time)).best().point.cost; };
    std::uintmax_t budget = 40;
    const double step = std::log(kTimeRatio);
    const auto found =
        boost::math::tools::brent_find_minima(at, std::log(near) - step, std::log(near) + step, 12, budget);
    return std::exp(found.first);
  }

  [[nodiscard]] Terms open(const Terms& terms) const {
    Terms list;
    for (const Term t : in_order(options_.candidates)) {
      if (options_.front_end && t == Term::quantization) continue;
      const bool dropped = std::find(dropped_.begin(), dropped_.end(), t) != dropped_.end();
      if (!holds(terms, t) && !dropped) list.push_back(t);
    }
    return list;
  }

  // Gains of the data and the cuts they are held against.
  [[nodiscard]] std::vector<Candidate> weigh(const Terms& terms) const {
    std::vector<Candidate> list;
    const Terms candidates = open(terms);
    if (candidates.empty()) return list;
    const Family null_family(bins_, terms, time_);
    const auto null_model = null_family.best();
    const double share = options_.false_rate / static_cast<double>(candidates.size());
    std::vector<Family> families;
    std::vector<std::size_t> simulated;
    for (const Term t : candidates) {
      Candidate c{.term = t};
      if (t == Term::sinusoid) {
        c.gain = find_sine(*null_model.likelihood, null_model.point, t_.coefficients, {}).test;
        c.cut = 2 * std::log(static_cast<double>(last_) / share);
      } else {
        families.emplace_back(bins_, with(terms, t), time_);
        c.gain = null_model.point.cost - families.back().best().point.cost;
        if (t == Term::rate_ramp) {
          c.cut = boost::math::quantile(complement(boost::math::chi_squared(1), share));
          families.pop_back();
        } else {
          simulated.push_back(list.size());
        }
      }
      list.push_back(c);
    }
    const double rest = share * static_cast<double>(simulated.size());
    const auto cuts = simulate_cuts(null_family, null_model, families, rest);
    for (std::size_t i = 0; i < simulated.size(); ++i) list[simulated[i]].cut = cuts[i];
    return list;
  }

  // Cuts that a share `rate` of spectra of the null model passes in any candidate, all at one level of their own law.
  [[nodiscard]] std::vector<double> simulate_cuts(const Family& null_family, const Family::Best& null_model,
                                                  const std::vector<Family>& families, double rate) const {
    if (families.empty()) return {};
    const auto replicas = static_cast<std::size_t>(options_.replicas);
    const Eigen::ArrayXd lambda = null_model.likelihood->variance(null_model.point.theta);
    std::vector<std::vector<double>> gains(families.size(), std::vector<double>(replicas));
    tbb::parallel_for(std::size_t{0}, replicas, [&](std::size_t i) {
      const noise::StreamKey key{options_.seed, (step_ << 32U) + i};
      const Eigen::ArrayXd power = lambda * mean_squares(bins_.count, key);
      const double null_cost = null_family.least_cost(power);
      for (std::size_t f = 0; f < families.size(); ++f)
        gains[f][i] = std::max(0.0, null_cost - families[f].least_cost(power));
    });
    // Place of each gain among its like, from the top; the highest place of each spectrum decides.
    std::vector<std::size_t> highest(replicas, replicas);
    std::vector<std::vector<double>> sorted = gains;
    for (std::size_t f = 0; f < families.size(); ++f) {
      std::sort(sorted[f].begin(), sorted[f].end(), std::greater<>());
      for (std::size_t i = 0; i < replicas; ++i) {
        const auto place = std::lower_bound(sorted[f].begin(), sorted[f].end(), gains[f][i], std::greater<>());
        highest[i] = std::min(highest[i], static_cast<std::size_t>(place - sorted[f].begin()));
      }
    }
    std::sort(highest.begin(), highest.end());
    const std::size_t level = highest[static_cast<std::size_t>(rate * static_cast<double>(replicas))];
    std::vector<double> cuts;
    for (const auto& law : sorted) cuts.push_back(law[std::min(level, law.size() - 1)]);
    return cuts;
  }

  // The largest gain over its cut; ramp and Gauss-Markov process only where nothing else comes near them: a walk looks
  // like a ramp more often than sensors have one.
  [[nodiscard]] static std::optional<Term> choose(const std::vector<Candidate>& list) {
    const Candidate *best = nullptr, *ramp = nullptr, *markov = nullptr;
    for (const Candidate& c : list) {
      if (!(c.gain > c.cut)) continue;
      if (c.term == Term::gauss_markov) {
        markov = &c;
      } else if (c.term == Term::rate_ramp) {
        ramp = &c;
      } else if (!best || c.gain - c.cut > best->gain - best->cut) {
        best = &c;
      }
    }
    const auto beats = [](const Candidate* a, const Candidate* b, double by) {
      return a && (!b || a->gain - b->gain > 2 * by);
    };
    if (beats(ramp, best, kIndistinguishable)) best = ramp;
    if (beats(markov, best, kMuchBetter)) best = markov;
    return best ? std::optional(best->term) : std::nullopt;
  }

  void remove_line(const Terms& terms) {
    const Eigen::ArrayXd reference = bins_.reference;
    for (int round = 0; round < 2; ++round) {  // a strong line raises the spectrum that it is first seen against
      const Family family(bins_, terms, time_);
      const auto model = family.best();
      const Sine line = find_sine(*model.likelihood, model.point, t_.coefficients, {});
      frequency_ = line.w / (2 * std::numbers::pi * t_.dt);
      bins_ = bins_of(without_sine(t_, line));
      bins_.reference = reference;
    }
  }

  void drop_needless(Selection& s) {
    for (const Term t : {Term::quantization, Term::flicker, Term::rate_random_walk, Term::rate_ramp}) {
      if (!holds(s.terms, t)) continue;
      const Terms rest = without(s.terms, t);
      if (cost(rest) - cost(s.terms) > kBoundaryCut) continue;
      s.terms = rest;
      s.dropped.push_back(t);
    }
    dropped_ = s.dropped;
  }

  // What the record cannot tell from the chosen terms; beside a Gauss-Markov process, what would do in its place takes
  // it.
  void simplify(Selection& s) const {
    if (holds(s.terms, Term::gauss_markov)) {
      replace_gauss_markov(s);
    } else {
      find_alternative(s);
    }
  }

  void replace_gauss_markov(Selection& s) const {
    const double here = cost(s.terms);
    const Terms rest = without(s.terms, Term::gauss_markov);
    for (const Terms& instead :
         {Terms{Term::flicker}, Terms{Term::rate_random_walk}, Terms{Term::flicker, Term::rate_random_walk}}) {
      Terms other = rest;
      for (const Term t : instead) {
        if (is_candidate(t) && !holds(other, t)) other = with(other, t);
      }
      const double difference = 0.5 * (cost(other) - here);
      if (other.size() == rest.size() || difference >= kIndistinguishable) continue;
      s.alternative = Alternative{s.terms, time_, -difference};
      s.terms = other;
      std::erase_if(s.dropped, [&](Term t) { return holds(other, t); });
      return;
    }
  }

  // The best set with one term in place of another that it needs just as much.
  void find_alternative(Selection& s) const {
    const double here = cost(s.terms);
    for (const Term out : s.terms) {
      if (out == Term::white || out == Term::sinusoid) continue;
      const Terms rest = without(s.terms, out);
      for (const Term in : kReplacements) {
        if (!is_candidate(in) || holds(s.terms, in)) continue;
        // One that remembers longer than the record is a walk, always.
        if (in == Term::gauss_markov && out != Term::flicker) continue;
        const Terms other = with(rest, in);
        const auto best = Family(bins_, other).best();
        const double difference = 0.5 * (best.point.cost - here);
        const bool likelier = !s.alternative || difference < s.alternative->log_likelihood_difference;
        if (difference >= kIndistinguishable || !likelier || cost(rest) - best.point.cost < kBoundaryCut) continue;
        s.alternative = Alternative{other, std::nullopt, difference};
        if (in == Term::gauss_markov) s.alternative->correlation_time_s = best.time;
      }
    }
  }

  [[nodiscard]] bool is_candidate(Term t) const { return holds(options_.candidates, t); }

  const Transformed& t_;
  std::int64_t last_;
  const SelectionOptions& options_;
  SineBins bins_;
  Terms dropped_;
  std::optional<double> time_;       // correlation time, once a Gauss-Markov process is in
  std::optional<double> frequency_;  // of the line, once it is in
  std::uint64_t step_ = 0;
};

void check(double dt, const SelectionOptions& o) {
  if (!(dt > 0) || !std::isfinite(dt))
    throw std::invalid_argument(fmt::format("sample interval {} s must be positive and finite", dt));
  (void)with(o.candidates, Term::white);  // refuses repeats
  if (!(o.false_rate > 0 && o.false_rate <= 0.5))
    throw std::invalid_argument(fmt::format("rate {} of false terms must be in (0, 0.5]", o.false_rate));
  constexpr int kFewestReplicas = 50;
  if (o.replicas < kFewestReplicas)
    throw std::invalid_argument(fmt::format("{} replicas are too few; at least {}", o.replicas, kFewestReplicas));
}

}  // namespace

Selection choose_terms(std::span<const double> rate, double dt, const SelectionOptions& options) {
  check(dt, options);
  const Transformed t = transform_record(rate, dt);
  if (t.coefficients.empty()) return {};
  std::int64_t last = t.used.count - 1;
  if (options.tau_min_s) {
    const double k = static_cast<double>(t.used.count) * dt / *options.tau_min_s;
    last = std::clamp<std::int64_t>(std::llround(k), 1, last);
  }
  return Search(t, last, options).run();
}

}  // namespace gyrobudget::inline v0::fit

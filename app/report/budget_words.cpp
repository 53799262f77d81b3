// SPDX-License-Identifier: MIT
#include "budget_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "notes.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

std::string name_of(std::size_t axis) { return fmt::format("{} {}", kQuantities[axis / 3], kAxisNames[axis % 3]); }

std::string with_unit(double value, std::size_t axis) {
  constexpr std::array kUnits{"m", "m/s", "deg"};
  return fmt::format("{} {}", number(axis < 6 ? value : value / earth::kDegree, 3), kUnits[axis / 3]);
}

void note_runs(std::vector<std::string>& notes, const budget::Study& s) {
  if (s.runs.unaligned > 0)
    notes.push_back(
        fmt::format("{} runs of Monte Carlo found no heading on the pad and do not count: give the alignment one",
                    s.runs.unaligned));
  if (s.stopped && !s.stopped_at)
    notes.push_back(fmt::format("Monte Carlo was interrupted: {} of {} runs", s.runs.flown, s.runs.asked));
  note_refused(notes, s.runs.fixes);
  if (s.stopped_at)
    notes.push_back(fmt::format("Monte Carlo was interrupted at {}: it and the sources behind it are not compared",
                                s.budget.lines[*s.stopped_at].name));
}

}  // namespace

double position_rss(const BudgetResult& result, const navigation::CoreMatrix& P) {
  return result.study.axes.position_sigma(P, budget::Component::rss);
}

std::vector<std::string> far_words(const budget::Study& study, const budget::AllRatios& ratios) {
  std::vector<std::string> list;
  for (const auto& far : ratios.far)
    list.push_back(fmt::format("{}, {} {}", far.line ? study.budget.lines[*far.line].name : "total", name_of(far.axis),
                               number(far.ratio, 3)));
  return list;
}

std::vector<std::string> contradiction_words(const budget::Study& study) {
  std::vector<std::string> list;
  for (const auto& c : budget::contradictions(study)) {
    if (c.axis)
      list.push_back(fmt::format("{}: {} where the covariance has {}", name_of(*c.axis), with_unit(c.found, *c.axis),
                                 with_unit(c.expected, *c.axis)));
    else
      list.push_back(fmt::format("NEES: {} where a right covariance gives {}", number(c.found, 3), c.expected));
  }
  return list;
}

std::string direction_text(const budget::MonteCarlo::Nees::LeftOut& direction) {
  constexpr double kPart = 0.3;  // smaller weights are not named
  std::vector<std::size_t> order(navigation::kCoreStates);
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto weight = [&](std::size_t k) { return direction.weights[static_cast<Eigen::Index>(k)]; };
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::size_t k) { return std::abs(weight(k)); });
  std::string text;
  for (const std::size_t k : order)
    if (std::abs(weight(k)) >= kPart)
      text += fmt::format("{}{} {:.2f}", text.empty() ? "" : ", ", name_of(k), weight(k));
  return text;
}

std::string why_left_out(const budget::Negligible& source) {
  if (source.share == 0) return "has no effect in this scene";
  return fmt::format("{:.2g} of the total's variance at most", source.share);
}

std::vector<std::string> budget_notes(const BudgetResult& r) {
  const budget::Study& s = r.study;
  std::vector<std::string> notes = r.notes;
  note_scene(notes, s.no_heading, s.out_of_range);
  if (r.sensor.empty()) notes.emplace_back("the scene names no sensor file: the IMU is ideal");
  if (s.large_attitude)
    notes.push_back(fmt::format(
        "the attitude about {} has a sigma of {:.3g} deg at {:.4g} s: beyond about 5 deg linear theory fails and the covariance does not hold; --runs tells by how much",
        kAxisNames[static_cast<std::size_t>(s.large_attitude->axis)], s.large_attitude->sigma / earth::kDegree,
        s.large_attitude->time));
  note_runs(notes, s);
  return notes;
}

}  // namespace gyrobudget::inline v0::report

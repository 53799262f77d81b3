// SPDX-License-Identifier: MIT
// Error budgets for the terminal.
#include "gyrobudget/estimation/navigation/consistency.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "budget.h"
#include "budget_words.h"
#include "layout.h"
#include "sensor_words.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using budget::Component;
using budget::kBandOfOne;
using navigation::CoreMatrix;

using earth::kDegree;

std::string title(const BudgetResult& r) {
  const std::string name = r.name.empty() ? r.scene : r.name;
  std::string out = fmt::format("{}\n  one sigma at {:.6g} s; {}; {} steps of covariance\n", printable(name),
                                r.study.at, r.study.aided ? "aided, gains of the filter frozen" : "unaided strapdown",
                                count_text(static_cast<std::int64_t>(r.study.budget.steps)));
  if (r.study.flicker_states > 0) out += fmt::format("  1/f noise by {} states an axis\n", r.study.flicker_states);
  if (r.study.pad > 0)
    out += fmt::format("  aligned by itself over {} on the pad before\n", duration_text(r.study.pad));
  if (!r.sensor.empty()) out += fmt::format("  sensor: {}\n", printable(r.sensor));
  return out;
}

// Largest share first.
std::vector<std::size_t> order(const BudgetResult& r, const std::vector<double>& share) {
  std::vector<std::size_t> by_share(r.study.budget.lines.size());
  std::iota(by_share.begin(), by_share.end(), std::size_t{0});
  std::stable_sort(by_share.begin(), by_share.end(), [&](std::size_t a, std::size_t b) { return share[a] > share[b]; });
  return by_share;
}

// Position columns. In a launch to the east downrange and crossrange are east and north: they are not said twice.
std::vector<Component> components(const BudgetResult& r) {
  using enum Component;
  if (r.study.axes.C_launch.isApprox(r.study.axes.C_enu, 1e-9)) return {east, north, up, rss};
  return {east, north, up, downrange, crossrange, rss};
}

// A source that may grow a thousandfold decides nothing.
std::string factor_text(double factor) {
  constexpr double kAny = 1000;
  return factor > kAny ? "any" : fmt::format("x {}", number(factor, 3));
}

std::vector<std::string> cells(const BudgetResult& r, std::string_view name, const CoreMatrix& P, std::string share) {
  const navigation::LocalSigmas s = navigation::local_sigmas(P, r.study.axes.C_enu);
  std::vector<std::string> row{fmt::format("  {}", name)};
  for (const Component component : components(r)) row.push_back(number(r.study.axes.position_sigma(P, component), 3));
  row.push_back(number(s.velocity.norm(), 3));
  row.push_back(number(s.attitude.norm() / kDegree, 3));
  row.push_back(std::move(share));
  return row;
}

// What was asked beside the budget: for the line, or nothing for the sums.
std::vector<std::string> extra_heads(const BudgetResult& r) {
  std::vector<std::string> heads;
  if (r.study.exact) heads.emplace_back("exact");
  if (r.study.limit) heads.emplace_back("may grow");
  return heads;
}

std::vector<std::string> extra_cells(const BudgetResult& r, std::size_t line) {
  std::vector<std::string> row;
  if (r.study.exact) row.push_back(number(position_rss(r, (*r.study.exact)[line]), 3));
  if (r.study.limit) row.push_back(factor_text(r.study.limit->factors[line]));
  return row;
}

TextTable left_aligned(std::size_t columns) {
  std::vector<Align> all(columns, Align::right);
  all[0] = Align::left;
  return TextTable(all);
}

void append(std::vector<std::string>& row, std::vector<std::string> more) {
  row.insert(row.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

enum class Extras { beside, apart };
std::string table(const BudgetResult& r, Extras extras) {
  const std::vector<double> share = budget::shares(r.study.budget, r.study.at_index);
  std::vector<std::string> heads{"  source"};
  for (const Component component : components(r))
    heads.emplace_back(component == Component::east ? "east m" : to_string(component));
  for (const auto* head : {"vel m/s", "att deg", "share"}) heads.emplace_back(head);
  if (extras == Extras::beside) append(heads, extra_heads(r));
  TextTable out = left_aligned(heads.size());
  out.row(heads);
  for (const std::size_t i : order(r, share)) {
    auto row = cells(r, r.study.budget.lines[i].name, r.study.line(i), percent(share[i]));
    if (extras == Extras::beside) append(row, extra_cells(r, i));
    out.row(row);
  }
  const auto sum = [&](const char* name, const CoreMatrix& P) {
    auto row = cells(r, name, P, "");
    row.resize(heads.size());
    out.row(row);
  };
  sum("total", r.study.total());
  if (!r.study.budget.claimed.empty()) sum("claimed by the filter", r.study.claimed());
  return out.text();
}

std::string alignment_text(const BudgetResult& r) {
  if (!r.study.limit->alignment) return {};
  const budget::AlignmentTime& a = *r.study.limit->alignment;
  const std::string from = printable(duration_text(budget::kShortestAlignment)),
                    to = printable(duration_text(budget::kLongestAlignment));
  const std::string now = fmt::format("the scene's is {}", duration_text(r.study.pad));
  if (!a.met)
    return wrapped(
        fmt::format(
            "No duration of the alignment from {} to {} meets it, all else alike: {} come nearest, with {} m; {}.",
            from, to, duration_text(a.duration), number(a.sigma, 4), now),
        "  ", "  ");
  return wrapped(fmt::format("The shortest alignment that meets it, all else alike: {}, with {} m; {}.",
                             a.duration <= budget::kShortestAlignment ? from + " or less" : duration_text(a.duration),
                             number(a.sigma, 4), now),
                 "  ", "  ");
}

std::string extras_table(const BudgetResult& r) {
  std::vector<std::string> heads{"  source", "rss m"};
  append(heads, extra_heads(r));
  TextTable out = left_aligned(heads.size());
  out.row(heads);
  for (const std::size_t i : order(r, budget::shares(r.study.budget, r.study.at_index))) {
    const auto& line = r.study.budget.lines[i];
    std::vector<std::string> row{fmt::format("  {}", line.name), number(position_rss(r, r.study.line(i)), 3)};
    append(row, extra_cells(r, i));
    out.row(row);
  }
  return out.text();
}

// One table where it fits a page, else two; with what is in no line of them.
std::string tables(const BudgetResult& r) {
  constexpr std::size_t kPage = 110;
  const std::string not_in_it = wrapped(not_stated_text(r.not_stated, kThisTotal), "  ", "  ");
  const std::string one = table(r, Extras::beside);
  if (width(std::string_view(one).substr(0, one.find('\n'))) <= kPage) return one + not_in_it;
  return table(r, Extras::apart) + not_in_it + "\n" + extras_table(r);
}

std::string limit_text(const BudgetResult& r) {
  if (!r.study.limit) return {};
  return fmt::format("\n{}: {} m, {}\n", printable(r.limit), number(r.study.limit->found, 4),
                     r.study.limit->met() ? "met" : "NOT MET") +
         wrapped(
             "A source may grow by its factor, alone, before the limit is reached; x 0: the others exceed it already.",
             "  ", "  ") +
         alignment_text(r);
}

// "0.98", "1.07*" outside of its band, "<1%" of the total's variance, "2nd" where the second order may have more.
std::string ratio_text(const budget::Agreement& one, const budget::Agreement::Axis& axis,
                       const navigation::Band& band) {
  if (!axis.matters) return "<1%";
  if (!axis.first_order) return "2nd";
  return fmt::format("{:.2f}{}", axis.ratio(), one.random && !band.holds(axis.ratio()) ? "*" : "");
}

std::string total_ratios(const BudgetResult& r, const navigation::Band& band) {
  const budget::Agreement total = total_agreement(r.study);
  TextTable out = left_aligned(1 + kAxisNames.size());
  out.row({"  found over table", "east", "north", "up"});
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    std::vector<std::string> row{fmt::format("  {}", kQuantities[q])};
    for (std::size_t k = 0; k < kAxisNames.size(); ++k) row.push_back(ratio_text(total, total.axes[3 * q + k], band));
    out.row(row);
  }
  return out.text();
}

std::string nees_text(const BudgetResult& r) {
  const auto& [mean, dof, left_out] = r.study.monte_carlo->nees;
  const navigation::Band band = budget::nees_band(r.study);
  std::string out = fmt::format("  NEES {} of {}, 99 % band {} to {}\n", number(mean, 3), dof, number(band.lower, 3),
                                number(band.upper, 3));
  if (!left_out.empty())
    out += wrapped("It leaves out directions without error of first order; in units of each sigma:", "  ", "  ");
  for (const auto& direction : left_out)
    out += wrapped(fmt::format("{}: covariance {}, found {}{}", direction_text(direction), number(direction.linear, 2),
                               number(direction.found, 2), direction.found > 0.1 ? ", which is not small" : ""),
                   "  - ", "    ");
  return out;
}

std::string saturated_text(const budget::Saturated& saturated) {
  constexpr std::array kBody{"x", "y", "z"};
  std::string out;
  for (const auto& [triad, counts] :
       {std::pair{"gyro", saturated.gyro}, std::pair{"accelerometer", saturated.accelerometer}})
    for (std::size_t i = 0; i < kBody.size(); ++i)
      if (counts[i] > 0)
        out += wrapped(
            fmt::format(
                "{} {}: {} samples were cut off at its range; the covariance knows nothing of that and does not hold.",
                triad, kBody[i], count_text(static_cast<std::int64_t>(counts[i]))),
            "  ", "  ");
  return out;
}

std::string exact_ratio(const BudgetResult& r, std::size_t line) {
  const double states = position_rss(r, r.study.line(line));
  return states > 0 ? fmt::format("{:.3f}", position_rss(r, (*r.study.exact)[line]) / states) : "-";
}

// Covariance, exact integrals and flights of each source.
std::string sources_text(const BudgetResult& r) {
  if (r.study.monte_carlo->sources.empty()) return {};
  const auto agreements = source_agreements(r.study);
  const budget::AllRatios all = budget::all_ratios(r.study);
  std::string out = fmt::format("\nEach source alone, {} runs of each: sigma found over that of its covariance\n",
                                count_text(r.study.monte_carlo->runs));
  TextTable table = left_aligned(2 + (r.study.exact ? 1 : 0) + navigation::kCoreStates);
  std::vector<std::string> groups{"", "table"}, heads{"  source", "rss m"};
  if (r.study.exact) {
    groups.emplace_back("exact");
    heads.emplace_back("ratio");
  }
  for (const auto* group : {"pos.", "vel.", "att."}) {
    append(groups, {group, "", ""});
    append(heads, {"east", "north", "up"});
  }
  table.row(groups);
  table.row(heads);
  const auto add = [&](const std::string& name, const CoreMatrix& linear, const std::string& exact,
                       const std::optional<budget::Agreement>& one) {
    std::vector<std::string> row{fmt::format("  {}", name), number(position_rss(r, linear), 3)};
    if (r.study.exact) row.push_back(exact);
    if (!one) row.emplace_back("not flown");
    for (std::size_t k = 0; one && k < one->axes.size(); ++k) row.push_back(ratio_text(*one, one->axes[k], all.band));
    row.resize(heads.size());
    table.row(row);
  };
  for (const std::size_t i : order(r, budget::shares(r.study.budget, r.study.at_index))) {
    const auto& line = r.study.budget.lines[i];
    add(line.name, r.study.line(i), r.study.exact ? exact_ratio(r, i) : "", agreements[i]);
  }
  add("total", r.study.total(), "", total_agreement(r.study));
  out += table.text();
  out += wrapped(
      fmt::format(
          "{} ratios; 99 % of right ones lie in {} to {}: {} outside (*), {} by chance. All of them lie in {} to {} with 99 %: {}.",
          all.compared, number(all.band.lower, 3), number(all.band.upper, 3), all.outside,
          number(all.compared * (1 - kBandOfOne), 2), number(all.together.lower, 3), number(all.together.upper, 3),
          all.far.empty() ? "they do" : fmt::format("but for {}", fmt::join(far_words(r.study, all), "; "))),
      "  ", "  ");
  out += wrapped(
      "<1%: of the total's variance, by covariance and as found. 2nd: the covariance has less there than terms of second order may add.",
      "  ", "  ");
  return out;
}

std::string monte_carlo_text(const BudgetResult& r) {
  if (!r.study.monte_carlo) return {};
  const auto& mc = *r.study.monte_carlo;
  std::string out = fmt::format("\nMonte Carlo, {} runs of the whole chain, seed {}\n", count_text(mc.runs), mc.seed);
  const navigation::Band band = budget::ratio_band(r.study);
  out += total_ratios(r, band);
  out += fmt::format("  99 % of right ones lie in {} to {}\n", number(band.lower, 3), number(band.upper, 3));
  out += nees_text(r) + saturated_text(mc.saturated);
  if (const auto list = contradiction_words(r.study); !list.empty()) {
    out += "  The flights contradict the covariance, which does not hold:\n";
    for (const auto& one : list) out += wrapped(one, "  - ", "    ");
  }
  return out + sources_text(r);
}

std::string left_out_text(const BudgetResult& r) {
  std::string out;
  if (!r.study.left_out.empty()) {
    out += fmt::format("\nLeft out, together below {} of each total\n", percent(r.study.tolerance));
    for (const auto& l : r.study.left_out)
      out += wrapped(fmt::format("{}: {} m, {}", l.name, number(l.position, 3), why_left_out(l)), "  - ", "    ");
  }
  if (!r.study.not_modelled.empty()) {
    out += "\nNot in the linear budget\n";
    for (const auto& l : r.study.not_modelled) out += wrapped(fmt::format("{}: {}", l.what, l.why), "  - ", "    ");
  }
  const std::vector<std::string> notes = budget_notes(r);
  if (!notes.empty()) out += "\nNotes\n";
  for (const auto& note : notes) out += wrapped(printable(note), "  - ", "    ");
  return out;
}

std::string comparison(const std::vector<BudgetResult>& results) {
  std::string out = "Side by side, one sigma\n";
  std::vector<Align> columns(5, Align::right);
  columns[0] = Align::left;
  TextTable table(columns);
  table.row({"  sensor", "position rss m", "velocity m/s", "attitude deg", "largest source"});
  for (const auto& r : results) {
    const CoreMatrix& P = r.study.total();
    const auto s = navigation::local_sigmas(P, r.study.axes.C_enu);
    const auto share = budget::shares(r.study.budget, r.study.at_index);
    const auto largest = std::max_element(share.begin(), share.end()) - share.begin();
    table.row({fmt::format("  {}", printable(r.sensor.empty() ? "ideal" : r.sensor)), number(s.position.norm(), 3),
               number(s.velocity.norm(), 3), number(s.attitude.norm() / kDegree, 3),
               share.empty() ? "-" : r.study.budget.lines[static_cast<std::size_t>(largest)].name});
  }
  return out + table.text();
}

}  // namespace

std::string budget_text(const std::vector<BudgetResult>& results) {
  std::string out;
  for (const auto& r : results) {
    if (!out.empty()) out += "\n";
    out += title(r) + "\n" + tables(r) + limit_text(r) + monte_carlo_text(r) + left_out_text(r);
  }
  if (results.size() > 1) out += fmt::format("\n{}", comparison(results));
  return out;
}

}  // namespace gyrobudget::inline v0::report

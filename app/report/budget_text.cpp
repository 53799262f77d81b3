// SPDX-License-Identifier: MIT
// Error budgets for the terminal.
#include "gyrobudget/navigation/consistency.h"
#include "gyrobudget/report/budget.h"
#include "gyrobudget/report/layout.h"
#include "gyrobudget/report/words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

namespace gyrobudget::inline v0::report {
namespace {

using navigation::CoreMatrix;

constexpr double kDegree = earth::kDegree;

std::string title(const BudgetResult& r) {
  const std::string name = r.name.empty() ? r.scene : r.name;
  std::string out = fmt::format("{}\n  one sigma at {:.6g} s; {}; {} steps of covariance\n", printable(name),
                                r.at, r.aided ? "aided, gains of the filter frozen" : "unaided strapdown",
                                count_text(static_cast<std::int64_t>(r.budget.steps)));
  if (r.flicker_states > 0) out += fmt::format("  1/f noise by {} states an axis\n", r.flicker_states);
  if (r.pad > 0) out += fmt::format("  aligned by itself over {} on the pad before\n", duration_text(r.pad));
  if (!r.sensor.empty()) out += fmt::format("  sensor: {}\n", printable(r.sensor));
  return out;
}

// Largest share first.
std::vector<std::size_t> order(const BudgetResult& r, const std::vector<double>& share) {
  std::vector<std::size_t> by_share(r.budget.lines.size());
  std::iota(by_share.begin(), by_share.end(), std::size_t{0});
  std::stable_sort(by_share.begin(), by_share.end(),
                   [&](std::size_t a, std::size_t b) { return share[a] > share[b]; });
  return by_share;
}

// Position columns. In a launch to the east downrange and crossrange are east and north: they are not said twice.
std::vector<std::string> components(const BudgetResult& r) {
  if (r.C_launch.isApprox(r.C_enu, 1e-9)) return {"east", "north", "up", "rss"};
  return {"east", "north", "up", "downrange", "crossrange", "rss"};
}

// A source that may grow a thousandfold decides nothing.
std::string factor_text(double factor) {
  constexpr double kAny = 1000;
  return factor > kAny ? "any" : fmt::format("x {}", number(factor, 3));
}

std::vector<std::string> cells(const BudgetResult& r, std::string_view name, const CoreMatrix& P,
                               std::string share) {
  const navigation::LocalSigmas s = navigation::local_sigmas(P, r.C_enu);
  std::vector<std::string> row{fmt::format("  {}", name)};
  for (const auto& component : components(r)) row.push_back(number(position_sigma(r, P, component), 3));
  row.push_back(number(s.velocity.norm(), 3));
  row.push_back(number(s.attitude.norm() / kDegree, 3));
  row.push_back(std::move(share));
  return row;
}

std::string table(const BudgetResult& r) {
  const std::vector<double> share = navigation::shares(r.budget, r.at_index);
  std::vector<std::string> heads{"  source"};
  for (const auto& component : components(r)) heads.push_back(component == "east" ? "east m" : component);
  for (const auto* head : {"vel m/s", "att deg", "share"}) heads.emplace_back(head);
  if (r.exact) heads.emplace_back("exact");
  if (r.limit) heads.emplace_back("may grow");
  std::vector<Align> columns(heads.size(), Align::right);
  columns[0] = Align::left;
  Table out(columns);
  out.row(heads);
  for (const std::size_t i : order(r, share)) {
    auto row = cells(r, r.budget.lines[i].name, r.budget.lines[i].covariance[r.at_index], percent(share[i]));
    if (r.exact) row.push_back(number(position_sigma(r, (*r.exact)[i], "rss"), 3));
    if (r.limit) row.push_back(factor_text(r.limit->factors[i]));
    out.row(row);
  }
  const auto sum = [&](const char* name, const CoreMatrix& P) {
    auto row = cells(r, name, P, "");
    row.resize(columns.size());
    out.row(row);
  };
  sum("total", r.budget.total[r.at_index]);
  if (!r.budget.claimed.empty()) sum("claimed by the filter", r.budget.claimed[r.at_index]);
  return out.text();
}

std::string alignment_text(const BudgetResult& r) {
  if (!r.limit->alignment) return {};
  const navigation::AlignmentTime& a = *r.limit->alignment;
  const std::string from = printable(duration_text(navigation::kShortestAlignment)),
                    to = printable(duration_text(navigation::kLongestAlignment));
  const std::string now = fmt::format("the scene's is {}", duration_text(r.pad));
  if (!a.met)
    return wrapped(
        fmt::format("No duration of the alignment from {} to {} meets it, all else alike: {} come nearest, "
                    "with {} m; {}.",
                    from, to, duration_text(a.duration), number(a.sigma, 4), now),
        "  ", "  ");
  return wrapped(fmt::format("The shortest alignment that meets it, all else alike: {}, with {} m; {}.",
                             a.duration <= navigation::kShortestAlignment ? from + " or less"
                                                                          : duration_text(a.duration),
                             number(a.sigma, 4), now),
                 "  ", "  ");
}

std::string limit_text(const BudgetResult& r) {
  if (!r.limit) return {};
  return fmt::format("\n{}: {} m, {}\n", printable(r.limit->text), number(r.limit->found, 4),
                     r.limit->found <= r.limit->limit ? "met" : "NOT MET") +
         wrapped(
             "A source may grow by its factor, alone, before the limit is reached; x 0: the others exceed it "
             "already.",
             "  ", "  ") +
         alignment_text(r);
}

std::string monte_carlo_text(const BudgetResult& r) {
  if (!r.monte_carlo) return {};
  const auto& mc = *r.monte_carlo;
  const CoreMatrix& linear = r.budget.total[r.at_index];
  std::string out =
      fmt::format("\nMonte Carlo, {} runs of the whole chain, seed {}\n", count_text(mc.runs), mc.seed);
  const auto band = navigation::sigma_ratio_band(mc.runs, 0.99);
  out += "  sigma found over sigma of the table:";
  for (const auto* component : {"east", "north", "up"}) {
    const double ratio = position_sigma(r, mc.covariance, component) / position_sigma(r, linear, component);
    out += fmt::format(" {} {}{}", component, number(ratio, 3), band.holds(ratio) ? "" : " (outside)");
  }
  const auto nees = navigation::chi_square_mean_band(navigation::kCoreStates, mc.runs, 0.99);
  out +=
      fmt::format("\n  99 % of right ones lie in {} to {}\n", number(band.lower, 3), number(band.upper, 3));
  out += fmt::format("  NEES {} of 9, 99 % band {} to {}\n", number(mc.nees, 3), number(nees.lower, 3),
                     number(nees.upper, 3));
  if (mc.saturated > 0)
    out += wrapped(
        fmt::format("{} samples were beyond a sensor's range: linear covariance knows nothing of that.",
                    count_text(static_cast<std::int64_t>(mc.saturated))),
        "  ", "  ");
  return out;
}

std::string left_out_text(const BudgetResult& r) {
  std::string out;
  if (!r.left_out.empty()) {
    out += fmt::format("\nLeft out, together below {} of each total\n", percent(r.tolerance));
    for (const auto& l : r.left_out)
      out += wrapped(fmt::format("{}: {} m, {}", l.name, number(l.position, 3), l.why), "  - ", "    ");
  }
  if (!r.not_modelled.empty()) {
    out += "\nNot in the linear budget\n";
    for (const auto& l : r.not_modelled) out += wrapped(fmt::format("{}: {}", l.what, l.why), "  - ", "    ");
  }
  if (!r.notes.empty()) out += "\nNotes\n";
  for (const auto& note : r.notes) out += wrapped(printable(note), "  - ", "    ");
  return out;
}

std::string comparison(const std::vector<BudgetResult>& results) {
  std::string out = "Side by side, one sigma\n";
  std::vector<Align> columns(5, Align::right);
  columns[0] = Align::left;
  Table table(columns);
  table.row({"  sensor", "position rss m", "velocity m/s", "attitude deg", "largest source"});
  for (const auto& r : results) {
    const CoreMatrix& P = r.budget.total[r.at_index];
    const auto s = navigation::local_sigmas(P, r.C_enu);
    const auto share = navigation::shares(r.budget, r.at_index);
    const auto largest = std::max_element(share.begin(), share.end()) - share.begin();
    table.row({fmt::format("  {}", printable(r.sensor.empty() ? "ideal" : r.sensor)),
               number(s.position.norm(), 3), number(s.velocity.norm(), 3),
               number(s.attitude.norm() / kDegree, 3),
               share.empty() ? "-" : r.budget.lines[static_cast<std::size_t>(largest)].name});
  }
  return out + table.text();
}

}  // namespace

Eigen::Matrix<double, 3, Eigen::Dynamic> component_axes(const BudgetResult& r, std::string_view component) {
  if (component == "east") return r.C_enu.col(0);
  if (component == "north") return r.C_enu.col(1);
  if (component == "up") return r.C_enu.col(2);
  if (component == "downrange") return r.C_launch.col(0);
  if (component == "crossrange") return r.C_launch.col(1);
  if (component == "horizontal") return r.C_enu.leftCols<2>();
  if (component == "rss") return r.C_enu;
  throw std::invalid_argument(fmt::format(
      "no component '{}'; there are east, north, up, downrange, crossrange, horizontal and rss", component));
}

double position_sigma(const BudgetResult& r, const CoreMatrix& P, std::string_view component) {
  const auto axes = component_axes(r, component);
  const Eigen::Matrix3d position = P.block<3, 3>(navigation::kPosition, navigation::kPosition);
  return std::sqrt(std::max(0.0, (axes.transpose() * position * axes).trace()));
}

std::string budget_text(const std::vector<BudgetResult>& results) {
  std::string out;
  for (const auto& r : results) {
    if (!out.empty()) out += "\n";
    out += title(r) + "\n" + table(r) + limit_text(r) + monte_carlo_text(r) + left_out_text(r);
  }
  if (results.size() > 1) out += fmt::format("\n{}", comparison(results));
  return out;
}

}  // namespace gyrobudget::inline v0::report

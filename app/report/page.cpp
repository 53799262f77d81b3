// SPDX-License-Identifier: MIT
#include <algorithm>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "accuracy.h"
#include "flight_words.h"
#include "navigation.h"
#include "page_parts.h"
#include "paper.h"
#include "report.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

std::string html_escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      case '\'':
        out += "&#39;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

bool is_fitted(const LogResult& result) {
  return std::any_of(result.axes.begin(), result.axes.end(),
                     [](const AxisResult& axis) { return axis.fit.has_value(); });
}

using Slot = std::pair<std::string_view, std::string_view>;

/// The template with every {{name}} replaced, in one pass: what is put in is not looked at again.
std::string filled(std::string_view page, std::initializer_list<Slot> slots) {
  std::string out;
  for (std::size_t open = page.find("{{"); open != std::string_view::npos; open = page.find("{{")) {
    const std::size_t close = page.find("}}", open);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    const auto* slot = std::ranges::find(slots, name, &Slot::first);
    if (slot == slots.end()) throw std::logic_error("a page has a slot that nothing fills: " + std::string(name));
    out += page.substr(0, open);
    out += slot->second;
    page.remove_prefix(close + 2);
  }
  return out += page;
}

/// @param plain_text the same without scripts; title and plain text are escaped here.
std::string whole(std::string_view title, std::string_view body, std::string_view plain_text, std::string_view data,
                  std::string_view script) {
  const std::string escaped = html_escaped(title), text = html_escaped(plain_text);
  const std::string head = filled(kHeadHtml, {{"title", escaped}, {"text", text}});
  return filled(kShellHtml, {{"title", escaped},
                             {"style", kPageCss},
                             {"body", filled(body, {{"head", head}, {"title", escaped}, {"text", text}})},
                             {"data", data},
                             {"chart", kChartJs},
                             {"plot", kPlotJs},
                             {"script", script}});
}

}  // namespace

/// A "<" could close the script element the data stand in; as an escape it is the same text to every JSON reader.
std::string without_markup(const std::string& json) {
  std::string out;
  out.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

std::string page(const LogResult& result) {
  const bool fitted = is_fitted(result);
  return whole((fitted ? "Datasheet of " : "Allan deviation of ") + file_name(result.source), kPageHtml,
               fitted ? datasheet(result) : allan_table(result), page_data(result), kPageJs);
}

std::string runs_page(const RunsResult& runs) {
  const LogResult all = side_by_side(runs);
  return whole("Datasheet of " + all.source, kPageHtml, runs_datasheet(runs), page_data(all, &runs), kPageJs);
}

std::string paper_page(const Paper& paper) {
  return whole("A paper's gyro noise, published and simulated again", kPaperHtml, paper_table(paper), paper_data(paper),
               kPaperJs);
}

std::string accuracy_page(const AccuracyStudy& study) {
  return whole("How wrong the fits are: " + printable(study.sensor), kAccuracyHtml, accuracy_table(study),
               accuracy_data(study), kAccuracyJs);
}

std::string navigation_page(const NavigationResult& result) {
  const std::string& name = result.scenario.name.empty() ? result.scene : result.scenario.name;
  return whole("Navigation: " + printable(name), kNavigationHtml, navigation_text(result), navigation_data(result),
               kNavigationJs);
}

std::string budget_page(const std::vector<BudgetResult>& results) {
  const std::string& name = results[0].name.empty() ? results[0].scene : results[0].name;
  return whole("Error budget: " + printable(name), kBudgetHtml, budget_text(results), budget_data(results), kBudgetJs);
}

std::string flight_page(std::span<const FlightResult> results) {
  return whole("Flight: " + flight_title(results), kFlightHtml, flight_text(results), flight_data(results), kFlightJs);
}

std::string sweep_page(const SweepStudy& study) {
  return whole("Error against run time: " + printable(study.sensor), kSweepHtml, sweep_table(study), sweep_data(study),
               kSweepJs);
}

}  // namespace gyrobudget::inline v0::report

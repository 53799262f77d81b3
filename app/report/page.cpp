// SPDX-License-Identifier: MIT
#include "gyrobudget/report/page_parts.h"
#include "gyrobudget/report/report.h"
#include "gyrobudget/report/words.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

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
template <std::size_t kSlots>
std::string filled(std::string_view page, const std::array<Slot, kSlots>& slots) {
  std::string out;
  for (std::size_t open = page.find("{{"); open != std::string_view::npos; open = page.find("{{")) {
    const std::size_t close = page.find("}}", open);
    const std::string_view name = page.substr(open + 2, close - open - 2);
    const auto slot =
        std::find_if(slots.begin(), slots.end(), [name](const Slot& s) { return s.first == name; });
    if (slot == slots.end())
      throw std::logic_error("page.html has a slot that nothing fills: " + std::string(name));
    out += page.substr(0, open);
    out += slot->second;
    page.remove_prefix(close + 2);
  }
  return out += page;
}

}  // namespace

std::string page(const LogResult& result) {
  const bool fitted = is_fitted(result);
  const std::string title =
      html_escaped((fitted ? "Datasheet of " : "Allan deviation of ") + file_name(result.source));
  const std::string text = html_escaped(fitted ? datasheet(result) : allan_table(result));
  const std::string data = page_data(result);
  return filled(kPageHtml, std::array<Slot, 6>{{{"title", title},
                                                {"style", kPageCss},
                                                {"text", text},
                                                {"data", data},
                                                {"chart", kChartJs},
                                                {"script", kPageJs}}});
}

}  // namespace gyrobudget::inline v0::report

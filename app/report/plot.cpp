// SPDX-License-Identifier: MIT
#include "gyrobudget/app/text/output.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "curves.h"
#include "gnuplot.h"
#include "report.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using noise::Signal;
using noise::Term;

constexpr std::size_t kPlotPoints = 400;
constexpr std::size_t kMostColumns = 3;

enum class Format { svg, png, pdf };

Format format_of(const std::string& path) {
  const std::size_t dot = path.rfind('.');
  std::string ending = dot == std::string::npos ? "" : path.substr(dot);
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == ".svg") return Format::svg;
  if (ending == ".png") return Format::png;
  if (ending == ".pdf") return Format::pdf;
  throw std::invalid_argument(fmt::format(
      "'{}' is no picture that can be drawn: its ending is '{}', expected .svg, .png or .pdf", path, ending));
}

/// How a term is drawn: colours of Okabe and Ito, told apart by most colour-blind people, and dashes for print.
struct Style {
  Term term;
  std::string_view colour;
  int dash;
};
constexpr std::array<Style, 7> kStyles = {{{Term::white, "#0072b2", 2},
                                           {Term::flicker, "#009e73", 4},
                                           {Term::rate_random_walk, "#cc79a7", 5},
                                           {Term::quantization, "#e69f00", 3},
                                           {Term::rate_ramp, "#56b4e9", 3},
                                           {Term::gauss_markov, "#7a4fa3", 6},
                                           {Term::sinusoid, "#8a6d3b", 7}}};

const Style& style_of(Term term) {
  return *std::find_if(kStyles.begin(), kStyles.end(), [term](const Style& s) { return s.term == term; });
}

/// One axis ready to be drawn, numbers in datasheet units.
struct Panel {
  const AxisResult* axis = nullptr;
  AxisCurves curves;
  std::string unit;
  double to_si = 1;
};

struct Layout {
  std::size_t columns = 1;
  std::size_t rows = 1;
};

std::vector<Panel> panels_of(const LogResult& result) {
  std::vector<Panel> panels;
  for (const AxisResult& axis : result.axes) {
    // Of an axis that never varies no deviation has a place on a logarithmic scale.
    if (std::none_of(axis.points.begin(), axis.points.end(), [](const auto& p) { return p.deviation > 0; })) continue;
    const std::string unit(deviation_unit(axis));
    panels.push_back({&axis, axis_curves(axis, result.rate_hz), unit, noise::parse_unit(unit).to_si});
  }
  if (panels.empty()) throw std::invalid_argument("there is no curve to draw: the result has no axis with points");
  return panels;
}

bool comparable(const Panel& a, const Panel& b) { return a.axis->signal == b.axis->signal && a.unit == b.unit; }

/// Axes that measure the same share their range, so that panels can be compared.
void share_ranges(std::vector<Panel>& panels) {
  for (Panel& panel : panels) {
    for (const Panel& other : panels) {
      if (!comparable(other, panel)) continue;
      panel.curves.tau_low_s = std::min(panel.curves.tau_low_s, other.curves.tau_low_s);
      panel.curves.tau_high_s = std::max(panel.curves.tau_high_s, other.curves.tau_high_s);
      panel.curves.deviation_low = std::min(panel.curves.deviation_low, other.curves.deviation_low);
      panel.curves.deviation_high = std::max(panel.curves.deviation_high, other.curves.deviation_high);
    }
  }
}

Layout layout_of(std::size_t panels) {
  const std::size_t columns = panels == 4 ? 2 : std::min(panels, kMostColumns);
  return {columns, (panels + columns - 1) / columns};
}

std::string terminal(Format format, const Layout& layout) {
  const bool single = layout.columns == 1;
  const double width = single ? 900 : 560.0 * static_cast<double>(layout.columns);
  const double height = single ? 680 : 560.0 * static_cast<double>(layout.rows);
  switch (format) {
    case Format::svg:
      return fmt::format("set terminal svg enhanced dynamic size {},{} font 'sans-serif,14' background '#ffffff'\n",
                         width, height);
    case Format::png: {
      constexpr double kPixels = 2;  // for screens and slides
      return fmt::format("set terminal pngcairo enhanced size {},{} font 'sans,{}' linewidth {} pointscale {}\n",
                         kPixels * width, kPixels * height, kPixels * 10.5, kPixels, kPixels);
    }
    case Format::pdf:
      break;
  }
  constexpr double kPixelsPerInch = 100;
  return fmt::format("set terminal pdfcairo enhanced size {}in,{}in font 'sans,10.5'\n", width / kPixelsPerInch,
                     height / kPixelsPerInch);
}

constexpr std::string_view kLook = R"(
set encoding utf8
set decimalsign '.'
set logscale xy
set logscale x2
set border 15 lc rgb '#444444' lw 0.8
set grid xtics ytics mxtics mytics lt 1 lc rgb '#cfcfcf' lw 0.7, lt 1 lc rgb '#ececec' lw 0.5
set tics out nomirror textcolor rgb '#222222'
set mxtics 10
set mytics 10
set format xy '10^{%T}'
set x2tics scale 0.6 ('1 ms' 0.001, '1 s' 1, '1 min' 60, '1 h' 3600, '1 day' 86400)
set style fill solid 0.25 noborder
set xlabel 'averaging time τ [s]' offset 0,0.6
set key below center horizontal Left reverse maxcols 2 samplen 3 width -7 height 0.8
)";

std::string data_block(std::string_view name, std::size_t panel, const std::string& rows) {
  return fmt::format("${}{} << EOD\n{}EOD\n", name, panel, rows);
}

std::string point_rows(const Panel& panel) {
  std::string rows;
  for (const allan::DeviationPoint& p : thinned(panel.axis->points, kPlotPoints)) {
    if (!(p.deviation > 0)) continue;  // a log scale has no zero
    // An interval that reaches zero runs out of the picture instead.
    const double lower = p.lower > 0 ? p.lower : panel.curves.deviation_low / 10;
    fmt::format_to(std::back_inserter(rows), "{:.8g} {:.8g} {:.8g} {:.8g}\n", p.tau_s, p.deviation / panel.to_si,
                   lower / panel.to_si, p.upper / panel.to_si);
  }
  return rows;
}

std::string curve_rows(const Panel& panel) {
  std::string rows;
  const AxisCurves& c = panel.curves;
  for (std::size_t i = 0; i < c.tau_s.size(); ++i) {
    fmt::format_to(std::back_inserter(rows), "{:.8g} {:.8g}", c.tau_s[i],
                   c.model.empty() ? NAN : c.model[i] / panel.to_si);
    for (const TermCurve& t : c.terms)
      fmt::format_to(std::back_inserter(rows), " {:.8g}", t.deviation[i] / panel.to_si);
    rows += '\n';
  }
  return rows;
}

std::string mark_rows(const Panel& panel) {
  std::string rows;
  for (const Mark& m : panel.curves.marks) {
    fmt::format_to(std::back_inserter(rows), "{:.8g} {:.8g} \"{}\"\n", m.tau_s, m.deviation / panel.to_si, m.name);
  }
  return rows;
}

/// The comma-separated list after "plot", back to front.
std::vector<std::string> layers(const std::vector<Panel>& panels, std::size_t at) {
  const Panel& panel = panels[at];
  std::vector<std::string> out;
  bool first_other = true;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    if (i == at || !comparable(panels[i], panel)) continue;
    out.push_back(fmt::format("$points{} using 1:2 with lines lc rgb '#b8b8b8' lw 1 {}", i,
                              first_other ? "title 'other curves'" : "notitle"));
    first_other = false;
  }
  out.push_back(fmt::format("$points{} using 1:3:4 with filledcurves lc rgb '#7a8aa0' title '95 % interval'", at));
  for (std::size_t t = 0; t < panel.curves.terms.size(); ++t) {
    const TermCurve& curve = panel.curves.terms[t];
    const Style& style = style_of(curve.term);
    const std::string title =
        term_text(panel.axis->signal, curve, noise::datasheet_unit(panel.axis->signal, curve.term));
    out.push_back(fmt::format("$curves{} using 1:{} with lines lc rgb '{}' lw 1.6 dt {} title {} noenhanced", at, t + 3,
                              style.colour, curve.limit ? 3 : style.dash, gnuplot_string(title)));
  }
  if (!panel.curves.model.empty()) {
    out.push_back(fmt::format("$curves{} using 1:2 with lines lc rgb '#d55e00' lw 2 title 'sum of the terms'", at));
  }
  out.push_back(fmt::format("$points{} using 1:2 with points pt 7 ps 0.45 lc rgb '#1a1a1a' title 'measured'", at));
  if (!panel.curves.marks.empty()) {
    out.push_back(fmt::format("$marks{} using 1:2 with points pt 6 ps 1.5 lw 1.6 lc rgb '#000000' notitle", at));
    // The flicker floor lies under the minimum: its name goes below, the others above.
    out.push_back(
        fmt::format("$marks{} using 1:2:(strcol(3) eq 'B' ? '' : strcol(3)) with labels offset 1.3,0.8 notitle", at));
    out.push_back(
        fmt::format("$marks{} using 1:2:(strcol(3) eq 'B' ? 'B' : '') with labels offset 1.3,-0.8 notitle", at));
  }
  return out;
}

/// A gnuplot string expression of one or two lines.
std::string title_of(const Panel& panel, const LogResult& result, bool single) {
  constexpr std::size_t kLongestName = 40;
  std::string first = text::shortened(printable(curve_name(*panel.axis, result)), kLongestName), second;
  if (single) {
    first += fmt::format("  ({})", text::shortened(printable(file_name(result.source)), kLongestName));
    second = record_text(result);
  }
  if (panel.axis->fit) second += (single ? "; model: " : "model: ") + verdict_headline(*panel.axis);
  return gnuplot_string(first) + (second.empty() ? "" : " . \"\\n\" . " + gnuplot_string(second));
}

/// The averaging times that the fit did not use, shaded.
std::string unused_range(const Panel& panel) {
  if (!panel.axis->fit) return {};
  const fit::Result& fit = *panel.axis->fit;
  const auto used_from = std::find_if(fit.residuals.begin(), fit.residuals.end(), [](const auto& r) { return r.used; });
  if (used_from == fit.residuals.begin() || used_from == fit.residuals.end()) return {};
  const double edge = std::sqrt(used_from->tau_s * std::prev(used_from)->tau_s);
  return fmt::format(
      "set object 1 rectangle from graph 0, graph 0 to first {:.8g}, graph 1 behind fc rgb '#f1ede4' fs solid 1 noborder\n"
      "set label 1 'not used' at first {:.8g}, graph 0.03 right offset -0.6,0 tc rgb '#777777'\n",
      edge, edge);
}

std::string panel_script(const std::vector<Panel>& panels, std::size_t at, const LogResult& result) {
  const Panel& panel = panels[at];
  const AxisCurves& c = panel.curves;
  constexpr double kSide = 1.25;  // room beside the first and the last point
  std::string script = "unset object\nunset label\n" + unused_range(panel);
  script += fmt::format("set title {} noenhanced offset 0,-0.4\n", title_of(panel, result, panels.size() == 1));
  script += fmt::format("set ylabel {} noenhanced offset 0.6,0\n",
                        gnuplot_string(fmt::format("{} [{}]", deviation_name(panel.axis->estimator), panel.unit)));
  script += fmt::format("set xrange [{0:.8g}:{1:.8g}]\nset x2range [{0:.8g}:{1:.8g}]\nset yrange [{2:.8g}:{3:.8g}]\n",
                        c.tau_low_s / kSide, c.tau_high_s * kSide, c.deviation_low / panel.to_si,
                        c.deviation_high / panel.to_si);
  if (!panel.axis->fit) script += "set key width 1\n";  // its names are short
  const auto list = layers(panels, at);
  return script + fmt::format("plot {}\n", fmt::join(list, ", \\\n     "));
}

std::string script_for(const LogResult& result, Format format) {
  auto panels = panels_of(result);
  share_ranges(panels);
  const Layout layout = layout_of(panels.size());
  std::string script = terminal(format, layout);
  script += kLook;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    script += data_block("points", i, point_rows(panels[i])) + data_block("curves", i, curve_rows(panels[i])) +
              data_block("marks", i, mark_rows(panels[i]));
  }
  if (panels.size() > 1) script += fmt::format("set multiplot layout {},{}\n", layout.rows, layout.columns);
  for (std::size_t i = 0; i < panels.size(); ++i) script += panel_script(panels, i, result);
  return script + (panels.size() > 1 ? "unset multiplot\n" : "") + "set output\n";
}

/// A PDF tells when it was drawn; the same command shall give the same bytes.
void forget_date(std::string& pdf) {
  constexpr std::string_view kKey = "/CreationDate (D:", kEpoch = "19700101000000";
  const std::size_t at = pdf.find(kKey);
  if (at == std::string::npos || at + kKey.size() + kEpoch.size() > pdf.size()) return;
  pdf.replace(at + kKey.size(), kEpoch.size(), kEpoch);
}

}  // namespace

void write_plot(const LogResult& result, const std::string& path) {
  const Format format = format_of(path);
  std::string picture = run_gnuplot(script_for(result, format));
  if (format == Format::pdf) forget_date(picture);
  text::write_file(path, picture);
}

}  // namespace gyrobudget::inline v0::report

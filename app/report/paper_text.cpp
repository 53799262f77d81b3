// SPDX-License-Identifier: MIT
// The paper's tables and figures for the terminal, and the words that the page has too.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "layout.h"
#include "paper.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

struct Section {
  std::string_view prefix;  ///< of the rows' ids
  std::string_view title;
};

constexpr std::array kSections{
    Section{"table1.", "Table I, values recovered from simulations"},
    Section{"table2.", "Table II, errors of table I against the values fed in; the reasons are those above"},
    Section{"fig3.", "Figure 3, attitude error by angle random walk"},
    Section{"fig4.", "Figure 4, angle after 1 h of 1000 runs"},
    Section{"fig6.", "Figure 6, the simulated records"},
    Section{"fig7.", "Figure 7, their Allan deviations"},
    Section{"fig8.", "Figure 8, the trajectories"},
    Section{"fig9.", "Figure 9, how far they end from the reference"},
    Section{"fig10.", "Figure 10, attitude"},
};

/// With the digits that the paper prints.
std::string cell(double value, std::string_view unit) {
  return unit == "%" ? fmt::format("{:+.2f}", value) : number(value, 3);
}

/// Enough digits to tell the ends of the interval from the value.
std::string fitted_text(const PaperRow& row) {
  if (!row.fitted) return {};
  const PaperRow::Fitted& f = *row.fitted;
  if (f.status != fit::Status::identified) return fmt::format("below {}", cell(f.upper, row.unit));
  const double part = (f.upper - f.lower) / f.value;
  const auto digits = [&](double value) {
    return row.unit != "%" && part < 0.01 ? number(value, 4) : cell(value, row.unit);
  };
  return fmt::format("{} ({} to {})", digits(f.value), digits(f.lower), digits(f.upper));
}

std::vector<std::string> cells(const PaperRow& row) {
  return {"  " + row.what,          row.published ? cell(*row.published, row.unit) : "",
          cell(row.ours, row.unit), cell(row.theory, row.unit),
          fitted_text(row),         row.unit == "1" ? "" : row.unit};
}

/// "model 1, IFOG", and what its noise holds where a fit tells.
std::string group_text(std::span<const PaperRow> rows, const PaperRow& first, bool with_truth) {
  std::string truth;
  for (const PaperRow& row : rows) {
    if (!with_truth || row.group != first.group || !row.fitted) continue;
    truth += fmt::format("{} {} {} {}", truth.empty() ? ": its noise holds" : ",", row.what,
                         cell(row.fitted->actual, row.unit), row.unit);
  }
  return wrapped(first.group + truth, "  ", "      ");
}

std::string reason(const PaperRow& row) {
  if (!row.scatter) return row.why;
  return fmt::format("{} 95 % of such readings: {} to {}.", row.why, cell(row.scatter->low, row.unit),
                     cell(row.scatter->high, row.unit));
}

std::string section_text(std::span<const PaperRow> rows, const Section& section) {
  using enum Align;
  TextTable table({left, right, right, right, right, left});
  const bool fits = rows.front().fitted.has_value(), reasons = section.prefix != "table2.";
  table.row({"", "published", "ours", "theory", fits ? "our fit, 95 %" : "", ""});
  for (const PaperRow& row : rows) table.row(cells(row));
  const auto lines = table.lines();
  std::string out = fmt::format("{}\n\n{}\n", section.title, lines.front());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (i == 0 || rows[i].group != rows[i - 1].group) out += group_text(rows, rows[i], fits && reasons);
    out += lines[i + 1] + '\n';
    if (reasons) out += wrapped(reason(rows[i]), "        ", "        ");
  }
  return out + '\n';
}

/// The rows of a section stand together.
std::span<const PaperRow> rows_of(const Paper& paper, const Section& section) {
  const auto belongs = [&](const PaperRow& row) { return row.id.starts_with(section.prefix); };
  const auto begin = std::ranges::find_if(paper.rows, belongs);
  return {begin, std::find_if_not(begin, paper.rows.end(), belongs)};
}

std::string kilometres(const PaperHypothesis::Gyro& gyro) {
  constexpr double kNothing = 5e-7;  // half a millimetre
  if (gyro.km) return *gyro.km < kNothing ? "0" : number(*gyro.km, 3);
  return gyro.flights > 0 ? "lost" : "";
}

std::string hypotheses_text(const PaperFlight& flight) {
  if (flight.hypotheses.empty()) return {};
  using enum Align;
  TextTable table({left, right, right, right, right, right, right, left});
  table.row({"", "ideal", "IFOG", "MEMS", "  it takes: ideal", "IFOG", "MEMS", ""});
  const auto& published = flight.published_km;
  table.row({"  published", number(published[0], 3), number(published[1], 3), number(published[2], 3), "", "", "", ""});
  for (const PaperHypothesis& h : flight.hypotheses) {
    std::vector<std::string> line = {"  " + h.id};
    for (const auto& gyro : h.gyros) line.push_back(kilometres(gyro));
    for (const auto& gyro : h.gyros) line.push_back(gyro.takes ? number(*gyro.takes, 3) : "");
    line.push_back(h.takes_unit);
    table.row(line);
  }
  const auto lines = table.lines();
  std::string out =
      fmt::format("What could have made these distances: km that each hypothesis gives, by our flights\n\n{}\n{}\n",
                  lines[0], lines[1]);
  for (std::size_t i = 0; i < flight.hypotheses.size(); ++i) {
    const PaperHypothesis& h = flight.hypotheses[i];
    out += lines[i + 2] + '\n' + wrapped(fmt::format("{}. {}", h.what, h.why), "        ", "        ");
  }
  return out + '\n';
}

/// How many published values of table I are what chance makes of the theory.
std::string explained(const Paper& paper) {
  const auto rows = rows_of(paper, kSections.front());
  const auto inside = std::ranges::count_if(rows, [](const PaperRow& row) {
    return row.published && row.scatter && *row.published >= row.scatter->low && *row.published <= row.scatter->high;
  });
  return fmt::format(
      "{} of the {} published values of table I lie where 95 % of such readings lie: the reasons given explain them.",
      inside, rows.size());
}

}  // namespace

std::vector<std::string> paper_words(const Paper& paper) {
  std::vector<std::string> words = {
      explained(paper),
      "-29.46 % of ARW in model 2 is 1/sqrt 2 - 1 = -29.29 %: MATLAB's imuSensor takes the given density as double-sided unless told otherwise. The same switch makes its RRW 41 % larger.",
      "\"Bias instability\", the smallest deviation over 0.664, measures where ARW and RRW cross, sqrt(2 N K/sqrt 3)/0.664, not the flicker noise B: 122 to 377 % too high for these gyros, with any simulation and any record length. B can be told from a record only where B^2/(N K) is not small: 0.12 for the IFOG.",
      "RRW of model 3 is not the one fed in. B is integrated sample by sample and walks by 60 B sqrt(dt) deg/h/sqrt(h): -76 % at 100 Hz, another value at another rate. The reference 4.32 of the MEMS gyro is that same walk, read.",
      "One reading of RRW from 10 h scatters by 25 % (one sigma), of ARW by 0.3 %. So the 4 % and 36 % of models 1 and 2 say nothing of the models.",
      "Equation (2) gives the drift of figures 3 and 4 only where its bandwidth is the sample rate.",
      "Our fit of the same records (generalised least squares, all three terms at once) gives each coefficient with an interval that holds the truth in 95 of 100 records, and \"below\" where the record does not hold the answer, as 10 h of the IFOG do not for B.",
  };
  words.insert(words.end(), paper.flight.words.begin(), paper.flight.words.end());
  return words;
}

std::string paper_table(const Paper& paper) {
  std::string out = fmt::format(
      "Nunes et al., \"Simulation of an Interferometric Fiber Optic Gyroscope Applied to a Rocket Model\"\n"
      "Ours: records of {} at {:g} Hz, seed {}. Published: as printed; empty where the paper shows a curve only.\n"
      "Theory: what the reading is without chance. Our fit: of the record that was read, by least squares.\n\n",
      duration_text(paper.duration_s), paper.rate_hz, paper.seed);
  for (const Section& section : kSections) {
    const auto rows = rows_of(paper, section);
    if (!rows.empty()) out += section_text(rows, section);
  }
  out += hypotheses_text(paper.flight);
  out += "What the published numbers mean\n\n";
  for (const std::string& words : paper_words(paper)) out += wrapped(words, "  - ", "    ");
  return out;
}

}  // namespace gyrobudget::inline v0::report

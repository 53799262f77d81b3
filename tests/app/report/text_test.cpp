// SPDX-License-Identifier: MIT
#include "gyrobudget/app/report/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "fixtures.h"

namespace gyrobudget::report {
namespace {

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

/// The text with line breaks and indents made single blanks: what it says, not how it is broken.
std::string flowing(const std::string& text) {
  std::istringstream in(text);
  std::string out;
  for (std::string word; in >> word;) out += (out.empty() ? "" : " ") + word;
  return out;
}

std::size_t code_points(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

#define EXPECT_SAYS(text, what) \
  EXPECT_NE((text).find(what), std::string::npos) << "not said: " << (what) << "\n" << (text)

TEST(Datasheet, SaysWhatAPersonWantsFirst) {
  const std::string text = flowing(datasheet(fixtures::mems()));
  EXPECT_SAYS(text, "mems_10h.csv: 3 600 000 samples at 100 Hz, 10 h, none missing");
  EXPECT_SAYS(text, "gyro_x (mean 12.30 deg/h)");
  EXPECT_SAYS(text, "N angle random walk 0.150000 ± 0.000056 0.149887 to 0.150115 deg/sqrt(h) identified");
  EXPECT_SAYS(text, "(4.3633 ± 0.0016)e-05 (4.3601 to 4.3667)e-05 rad/sqrt(s)");
  EXPECT_SAYS(text, "B bias instability 0.70 ± 0.12 0.47 to 0.94 deg/h identified");
  EXPECT_SAYS(text, "K rate random walk 4.32 ± 0.54 3.23 to 5.44 deg/h/sqrt(h) identified");
  EXPECT_SAYS(text, "Left out (not fitted): quantization (Q), rate ramp (R).");
  EXPECT_SAYS(text, "Verdict: described.");
  EXPECT_SAYS(text, "p = 0.43");
  EXPECT_SAYS(text,
              "What follows: Values and intervals can be used as they stand, for averaging times from 0.01 s on.");
  EXPECT_SAYS(text, "For 10 %, record 27.4 h");
}

TEST(Datasheet, AnUpperLimitThatWasNotFoundIsSaidEverywhere) {
  LogResult result = fixtures::bounded();
  for (fit::Coefficient& c : result.axes.front().fit->coefficients) {
    c.upper = std::numeric_limits<double>::infinity();
  }
  result.axes.push_back(result.axes.front());
  for (const std::string& text : {datasheet(result), page(result)}) {
    EXPECT_SAYS(text, "no limit");
    EXPECT_EQ(text.find("infinit"), std::string::npos);
    EXPECT_EQ(text.find("e+3"), std::string::npos);
  }
}

TEST(Datasheet, ExplainsTheMakersBiasInstability) {
  const LogResult result = fixtures::mems();
  const std::string text = flowing(datasheet(result));
  EXPECT_SAYS(
      text,
      "Raw minimum of the curve up to a tenth of the record: 0.964 deg/h at 268.3 s. Makers often quote it, or it divided by 0.664 (1.45 deg/h)");
  EXPECT_SAYS(text, "The flicker floor alone, 0.664 B, is 0.465 deg/h.");
  EXPECT_SAYS(text, "beta = B^2/(N K) = 0.756");
}

TEST(Datasheet, ColumnsStandUnderEachOther) {
  const auto lines = lines_of(datasheet(fixtures::mems()));
  std::vector<std::size_t> starts;
  for (const std::string& line : lines) {
    for (const char* unit :
         {"  deg/sqrt(h)", "  rad/sqrt(s)", "  deg/h  ", "  rad/s", "  deg/h/sqrt(h)", "  rad/s/sqrt(s)"}) {
      const auto at = line.find(unit);
      if (at == std::string::npos || line.find("Raw") != std::string::npos) continue;
      starts.push_back(code_points(line.substr(0, at)));
      break;
    }
  }
  ASSERT_EQ(starts.size(), 6U);
  EXPECT_EQ(std::count(starts.begin(), starts.end(), starts.front()), 6);
}

TEST(Datasheet, LinesFitATerminal) {
  for (const LogResult& result : {fixtures::mems(), fixtures::not_described(), fixtures::accelerometer()}) {
    for (const std::string& line : lines_of(datasheet(result))) EXPECT_LE(code_points(line), 110U) << line;
  }
}

TEST(Datasheet, NamesBoundsAndWhatWasLeftOut) {
  const std::string text = flowing(datasheet(fixtures::bounded()));
  EXPECT_SAYS(text, "0 0 to 0.00142 deg/h upper bound: at most 0.00142 deg/h (95 %)");
  EXPECT_SAYS(text, "left out: at most 1.10e-05 deg/h/sqrt(h) (95 %)");
  EXPECT_SAYS(text, "0.664 B, is at most 0.000943 deg/h (95 %)");
}

TEST(Datasheet, RefusesWhatTheModelDoesNotDescribe) {
  const std::string text = flowing(datasheet(fixtures::not_described()));
  EXPECT_SAYS(text, "Verdict: not described.");
  EXPECT_SAYS(text, "off by up to 260 % beyond its 95 % scatter, at tau = 2.56 s");
  EXPECT_SAYS(text, "p < 1e-300");
  EXPECT_SAYS(text, "Do not quote these coefficients as a datasheet");
  EXPECT_SAYS(text, "deg/h do not quote");
  EXPECT_EQ(text.find("identified"), std::string::npos);
  EXPECT_SAYS(text, "1 234 missing (0.34 %)");
  EXPECT_SAYS(text, "they were masked, and the statistics allow for it");
}

TEST(Datasheet, TellsWhatWasCutAndWhatThatMoved) {
  const std::string text = flowing(datasheet(fixtures::accelerometer()));
  EXPECT_SAYS(text, "Verdict: described within 3.1 %.");
  EXPECT_SAYS(
      text,
      "Not used: 3 averaging times below 0.04 s, where the curve departs from the model by up to -12 % (at 0.005 s).");
  EXPECT_SAYS(text, "velocity random walk from 0.02030 to 0.02000 m/s/sqrt(h) (-1.5 %)");
  EXPECT_SAYS(text, "bias instability from 0 to 12.00 ug");
  EXPECT_SAYS(text, "(unchanged)");
  EXPECT_SAYS(text, "K acceleration random walk 20.0 ± 2.5");
}

TEST(Datasheet, SeveralAxesStartWithASummary) {
  const std::string text = datasheet(fixtures::imu());
  const std::string flow = flowing(text);
  EXPECT_SAYS(
      flow,
      "N [deg/sqrt(h)] B [deg/h] K [deg/h/sqrt(h)] verdict gyro_x 0.150000 ± 0.000056 0.70 ± 0.12 4.32 ± 0.54 described");
  EXPECT_SAYS(flow, "N [m/s/sqrt(h)] B [ug] K [ug/sqrt(h)] verdict acc_x");
  EXPECT_LT(text.find("verdict"), text.find("gyro_x  (mean"));
}

TEST(Datasheet, TheSummaryQuotesNothingThatIsNotDescribed) {
  LogResult result = fixtures::imu();
  result.axes[1].fit->verdict = fit::Verdict::not_described;
  EXPECT_SAYS(flowing(datasheet(result)), "gyro_y - - - not described");
}

TEST(Datasheet, HasNoControlCharactersOfItsOwn) {
  for (const LogResult& result : {fixtures::mems(), fixtures::imu(), fixtures::bounded(), fixtures::hostile_names()}) {
    for (const char c : datasheet(result) + allan_table(result))
      EXPECT_TRUE(c == '\n' || static_cast<unsigned char>(c) >= ' ');
  }
}

TEST(AllanTable, HasARowForEveryPoint) {
  const LogResult result = fixtures::mems_curve_only();
  const auto lines = lines_of(allan_table(result));
  const auto head = std::find_if(lines.begin(), lines.end(),
                                 [](const std::string& l) { return l.find("tau [s]") != std::string::npos; });
  ASSERT_NE(head, lines.end());
  for (const char* column : {"deviation [deg/h]", "95 % from", "to", "edf", "terms"}) EXPECT_SAYS(*head, column);
  const auto rows = static_cast<std::size_t>(lines.end() - head - 1);
  ASSERT_EQ(rows, result.axes.front().points.size());
  EXPECT_EQ(flowing(*(head + 1)), "0.01 90.00 89.92 90.08 2399999.1 3599999");
  for (auto line = head; line != lines.end(); ++line) EXPECT_EQ(line->size(), head->size()) << *line;
}

TEST(AllanTable, WorksWithoutPoints) {
  LogResult result = fixtures::mems_curve_only();
  result.axes.front().points.clear();
  EXPECT_SAYS(allan_table(result), "gyro_x");
  EXPECT_SAYS(datasheet(result), "No coefficients were fitted.");
}

}  // namespace
}  // namespace gyrobudget::report

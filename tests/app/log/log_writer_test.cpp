// SPDX-License-Identifier: MIT
#include "gyrobudget/app/log/log_writer.h"

#include "gyrobudget/app/log/log.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <span>
#include <stdexcept>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using log::LogColumn;

class LogWriter : public TemporaryFolder {};

std::vector<double> some_values(std::size_t n, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0, 1e-4);
  std::vector<double> values(n);
  for (double& v : values) v = normal(random);
  return values;
}

TEST_F(LogWriter, WritesHeaderTimeAndShortestNumbers) {
  const std::vector<LogColumn> columns = {{"gyro_x", "rad/s", {0.1, -2e-300, std::nan("")}},
                                          {"accel_x", "m/s^2", {9.80665, -0.0, 1e22}}};
  log::write_log(path("log.csv"), columns, 100, "made by a test");
  EXPECT_EQ(
      content(path("log.csv")),
      "# made by a test\ntime (s),gyro_x (rad/s),accel_x (m/s^2)\n0,0.1,9.80665\n0.01,-2e-300,-0\n0.02,nan,1e+22\n");
}

TEST_F(LogWriter, ComesBackBitForBit) {
  // More rows than one task formats, and not a multiple of them.
  const std::size_t n = 50'001;
  const std::vector<LogColumn> columns = {{"gyro_x", "rad/s", some_values(n, 1)},
                                          {"gyro_y", "rad/s", some_values(n, 2)},
                                          {"accel_z", "m/s^2", some_values(n, 3)}};
  for (const std::string name : {"log.csv", "log.csv.gz"}) {
    log::write_log(path(name), columns, 200);
    const allan::Record r = log::read_log({.path = path(name)});
    EXPECT_EQ(r.rate_hz, 200);
    EXPECT_EQ(r.samples, 50'001);
    EXPECT_EQ(r.missing_samples, 0);
    ASSERT_EQ(r.axes.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(r.axes[i].name, columns[i].name);
      EXPECT_EQ(std::memcmp(r.axes[i].rate.data(), columns[i].values.data(), n * sizeof(double)), 0);
    }
  }
  EXPECT_LT(std::filesystem::file_size(path("log.csv.gz")), std::filesystem::file_size(path("log.csv")) * 6 / 10);
}

TEST_F(LogWriter, OtherUnitsComeBackToTheLastDigits) {
  const std::vector<double> values = some_values(1000, 4);
  const LogColumn column = {"gyro_x", "deg/h", values};
  log::write_log(path("log.csv"), {&column, 1}, 3);
  const allan::Record r = log::read_log({.path = path("log.csv")});
  EXPECT_NEAR(r.rate_hz, 3, 1e-8);
  constexpr double kTwoRoundings = 2 * std::numeric_limits<double>::epsilon();
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(r.axes.at(0).rate[i], values[i], kTwoRoundings * std::abs(values[i]));
  }
}

TEST_F(LogWriter, SameBytesEachTime) {
  const LogColumn column = {"gyro_x", "rad/s", some_values(100'000, 5)};
  for (const std::string name : {"a.csv", "a.csv.gz"}) {
    log::write_log(path(name), {&column, 1}, 100);
    const std::string first = content(path(name));
    log::write_log(path(name), {&column, 1}, 100);
    EXPECT_TRUE(first == content(path(name)));
  }
}

TEST_F(LogWriter, RowsMadeOnTheWayAreTheSameBytes) {
  const std::size_t n = 40'003, skipped = 12'345;
  const std::vector<LogColumn> columns = {{"gyro_x", "deg/h", some_values(n, 7)},
                                          {"gyro_y", "rad/s", some_values(n, 8)}};
  log::write_log(path("whole.csv"), columns, 100, "c");
  const log::LogHead head{{{"gyro_x", "deg/h"}, {"gyro_y", "rad/s"}}, 100, "c", skipped};
  std::size_t at = skipped, longest = 0;
  log::write_log(path("rest.csv"), head, n - skipped, [&](std::span<const std::span<double>> out) {
    ASSERT_EQ(out.size(), 2U);
    longest = std::max(longest, out[0].size());
    for (std::size_t k = 0; k < out[0].size(); ++k, ++at) {
      for (std::size_t i = 0; i < 2; ++i) out[i][k] = columns[i].values[at];
    }
  });
  EXPECT_EQ(at, n);
  EXPECT_LE(longest, 16'384U);
  const std::string whole = content(path("whole.csv")), rest = content(path("rest.csv"));
  const std::size_t rows = rest.find('\n', rest.find('\n') + 1) + 1;  // behind comment and header
  EXPECT_EQ(rest.substr(0, rows), whole.substr(0, rows));
  EXPECT_TRUE(whole.ends_with("\n" + rest.substr(rows)));
}

TEST_F(LogWriter, FailsWithItsProducer) {
  const log::LogHead head{{{"gyro_x", "rad/s"}}, 100, "", 0};
  EXPECT_THROW(log::write_log(path("log.csv"), head, 100'000, [](auto) { throw std::runtime_error("no more"); }),
               std::runtime_error);
  EXPECT_EQ(files(), 0U);
}

TEST_F(LogWriter, FailsAsAWhole) {
  const LogColumn column = {"gyro_x", "rad/s", some_values(100'000, 6)};
  EXPECT_CONTAINS(message_of<text::OutputError>([&] {
                    log::write_log("/dev/full", {&column, 1}, 100);
                  }),
                  "No space left on device");
  EXPECT_THROW(log::write_log(path("no/such/log.csv"), {&column, 1}, 100), text::OutputError);
  EXPECT_EQ(files(), 0U);
}

TEST_F(LogWriter, RefusesWhatCouldNotBeReadBack) {
  const auto of = [&](const std::vector<LogColumn>& columns, double rate = 1, std::string_view comment = {}) {
    return message_of<std::invalid_argument>([&] { log::write_log(path("log.csv"), columns, rate, comment); });
  };
  EXPECT_CONTAINS(of({}), "at least one column");
  EXPECT_CONTAINS(of({{"a", "1", {1, 2}}, {"b", "1", {1}}}), "column 'b' has 1 values, 'a' has 2");
  EXPECT_CONTAINS(of({{"a,b", "1", {1}}}), "must not hold commas");
  EXPECT_CONTAINS(of({{"a", "frob", {1}}}), "'frob' is no known unit");
  EXPECT_CONTAINS(of({{"a", "1", {1}}}, 0), "rate_hz is 0 Hz");
  EXPECT_CONTAINS(of({{"a", "1", {1}}}, 1, "two\nlines"), "one line");
  EXPECT_EQ(files(), 0U);
}

}  // namespace
}  // namespace gyrobudget::app_tests

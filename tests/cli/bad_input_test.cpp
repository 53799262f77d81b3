// SPDX-License-Identifier: MIT
// Each bad input: the exit code, a message that names place, finding, expectation and mend, and nothing half-written.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "program.h"

namespace gyrobudget::tests {
namespace {

constexpr int kNoAnswer = 1, kUsage = 2, kBadInput = 3, kBadOutput = 4, kInterrupted = 130;

// The message must hold every one of these words.
void expect_refusal(const Outcome& run, int code, const std::vector<std::string>& words) {
  EXPECT_EQ(run.exit_code, code) << run.err;
  for (const auto& word : words)
    EXPECT_NE(run.err.find(word), std::string::npos) << "no '" << word << "' in: " << run.err;
  EXPECT_EQ(run.out, "");
}

// A log of n rows of white-looking numbers in deg/h at 10 Hz.
std::string good_log(int rows, const std::string& header = "time (s),gyro_x (deg/h)\n") {
  std::string text = header;
  unsigned state = 1;
  for (int i = 0; i < rows; ++i) {
    state = state * 1664525U + 1013904223U;
    text += fmt::format("{:.1f},{:.6f}\n", 0.1 * i, state / 4294967296.0 - 0.5);
  }
  return text;
}

std::string with_line(std::string text, int line, const std::string& replacement) {
  std::size_t start = 0;
  for (int i = 1; i < line; ++i) start = text.find('\n', start) + 1;
  const std::size_t end = text.find('\n', start);
  return text.replace(start, end - start, replacement);
}

class BadInput : public testing::Test {
 protected:
  Outcome calibrate(const std::string& log, const std::string& options = "") {
    return gyrobudget_run("calibrate '" + scratch_.file("log.csv", log) + "' " + options + " -o '" +
                          scratch_.path("sensor.yaml") + "'");
  }
  void TearDown() override { EXPECT_LE(scratch_.files(), 1U) << "something was left behind"; }
  Scratch scratch_;
};

TEST_F(BadInput, EmptyFile) { expect_refusal(calibrate(""), kBadInput, {"log.csv", "empty"}); }

TEST_F(BadInput, HeaderOnly) {
  expect_refusal(calibrate("time (s),gyro_x (deg/h)\n"), kBadInput, {"log.csv", "header"});
}

TEST_F(BadInput, OneSample) { expect_refusal(calibrate(good_log(1)), kBadInput, {"log.csv", "expected"}); }

TEST_F(BadInput, TooFewSamples) {
  expect_refusal(calibrate(good_log(15)), kBadInput, {"log.csv", "15 samples", "at least 16"});
}

TEST_F(BadInput, TextInANumberColumn) {
  expect_refusal(calibrate(with_line(good_log(100), 50, "4.8,hello")), kBadInput, {"log.csv:50:5", "hello", "number"});
}

TEST_F(BadInput, RaggedRow) {
  expect_refusal(calibrate(with_line(good_log(100), 60, "5.8")), kBadInput, {"log.csv:60", "expected"});
  expect_refusal(calibrate(with_line(good_log(100), 60, "5.8,1,2")), kBadInput, {"log.csv:60", "expected"});
}

TEST_F(BadInput, TimeJumpsBack) {
  expect_refusal(calibrate(with_line(good_log(100), 60, "1.0,0.1")), kBadInput, {"log.csv:60", "back"});
}

TEST_F(BadInput, TimeStandsStill) {
  std::string text = "time (s),gyro_x (deg/h)\n";
  for (int i = 0; i < 100; ++i) text += fmt::format("{},0.{}\n", i / 10, i);
  expect_refusal(calibrate(text), kBadInput, {"log.csv", "time"});
}

TEST_F(BadInput, MissingUnit) {
  expect_refusal(calibrate(good_log(100, "time (s),gyro_x\n")), kBadInput, {"unit", "--unit"});
}

TEST_F(BadInput, MissingRate) {
  expect_refusal(calibrate("1\n2\n3\n4\n", "--unit deg/s"), kBadInput, {"rate", "--rate"});
}

TEST_F(BadInput, RateContradictsTime) {
  expect_refusal(calibrate(good_log(100), "--rate 100"), kBadInput, {"log.csv", "100 Hz", "10"});
}

TEST_F(BadInput, UnlabelledTimeThatNoUnitFits) {
  expect_refusal(calibrate(good_log(100, "time,gyro_x (deg/h)\n"), "--rate 7"), kBadInput, {"time", "s", "ms"});
}

TEST_F(BadInput, NumberBeyondDouble) {
  expect_refusal(calibrate(with_line(good_log(100), 50, "4.8,1e999")), kBadInput, {"log.csv:50", "1e999"});
}

TEST_F(BadInput, HugeSingleLine) {
  const std::string path = scratch_.path("long.csv");
  const Outcome made = shell("head -c 1000000000 /dev/zero | tr '\\0' '7' > '" + path + "'");
  ASSERT_EQ(made.exit_code, 0);
  expect_refusal(gyrobudget_run("calibrate '" + path + "' --unit deg/s --rate 1"), kBadInput, {"long.csv", "expected"});
}

TEST_F(BadInput, Directory) {
  expect_refusal(gyrobudget_run("calibrate /"), kBadInput, {"/", "folder", "expected a file"});
}

TEST_F(BadInput, NoSuchFile) { expect_refusal(gyrobudget_run("calibrate nowhere.csv"), kBadInput, {"nowhere.csv"}); }

TEST_F(BadInput, RandomBytes) {
  std::string bytes;
  unsigned state = 7;
  for (int i = 0; i < 100000; ++i) bytes += static_cast<char>((state = state * 1664525U + 1013904223U) >> 24);
  expect_refusal(calibrate(bytes, "--unit deg/s --rate 100"), kBadInput, {"log.csv"});
}

TEST_F(BadInput, TruncatedGzip) {
  const std::string plain = scratch_.file("log.csv", good_log(10000));
  ASSERT_EQ(shell("gzip -f '" + plain + "' && truncate -s 5000 '" + plain + ".gz'").exit_code, 0);
  expect_refusal(gyrobudget_run("calibrate '" + plain + ".gz'"), kBadInput,
                 {"log.csv.gz", "stop in the middle", "zcat"});
}

TEST_F(BadInput, SensorFileWithoutUnit) {
  const std::string path = scratch_.file("s.yaml", "name: x\ngyro:\n  arw: 0.1\n");
  expect_refusal(gyrobudget_run("plan '" + path + "'"), kBadInput, {"s.yaml:3", "unit", "deg/sqrt(h)"});
}

// --- The data cannot answer: exit 1, with the verdict on stdout ------------------------------------------------------

TEST_F(BadInput, AllSamplesEqual) {
  std::string text = "gyro_x (deg/h)\n";
  for (int i = 0; i < 1000; ++i) text += "15.04\n";
  const Outcome run = gyrobudget_run("calibrate '" + scratch_.file("log.csv", text) + "' --rate 100");
  EXPECT_EQ(run.exit_code, kNoAnswer) << run.err;
  EXPECT_NE(run.out.find("equal"), std::string::npos) << run.out;
  EXPECT_EQ(run.out.find("nan"), std::string::npos) << run.out;
}

TEST_F(BadInput, NothingButQuantization) {
  // The rate of an angle encoder at rest that flips between two counts: differences of white angle noise.
  std::string text = "gyro_x (deg/h)\n";
  unsigned state = 1, last = 0;
  for (int i = 0; i < 20000; ++i) {
    state = state * 1664525U + 1013904223U;
    const unsigned angle = state >> 31;
    text += fmt::format("{}\n", static_cast<int>(angle) - static_cast<int>(last));
    last = angle;
  }
  const Outcome run = gyrobudget_run("calibrate '" + scratch_.file("log.csv", text) + "' --rate 100");
  EXPECT_EQ(run.exit_code, kNoAnswer) << run.err;
  EXPECT_NE(run.out.find("quantization"), std::string::npos) << run.out;
}

// --- Output ---------------------------------------------------------------------------------------------------------

TEST_F(BadInput, DiskFull) {
  const std::string log = scratch_.file("log.csv", good_log(1000));
  const std::string sensor = GYROBUDGET_EXAMPLES "/sensors/mems.yaml";
  // Names with the endings that the options want, all of them the full disk.
  const Scratch full;
  for (const char* name : {"page.html", "plot.svg", "plot.png", "log.csv", "log.csv.gz", "sensor.yaml"}) {
    std::filesystem::create_symlink("/dev/full", full.path(name));
  }
  const std::string calibrate = "%P calibrate '" + log + "' ", simulate = "%P simulate " + sensor + " --duration 100s ";
  for (const std::string& line :
       {calibrate + "> /dev/full", calibrate + "--json > /dev/full", "%P allan '" + log + "' > /dev/full",
        "%P allan '" + log + "' --json > /dev/full", "%P plan " + sensor + " > /dev/full", simulate + "> /dev/full",
        calibrate + "-o /dev/full", calibrate + "--kalibr /dev/full", calibrate + "--report /dev/full",
        calibrate + "-o " + full.path("sensor.yaml"), calibrate + "--report " + full.path("page.html"),
        calibrate + "--plot " + full.path("plot.svg"), calibrate + "--plot " + full.path("plot.png"),
        "%P allan '" + log + "' --report " + full.path("page.html"), simulate + "-o " + full.path("log.csv"),
        simulate + "-o " + full.path("log.csv.gz")}) {
    const Outcome run = shell(line);
    EXPECT_EQ(run.exit_code, kBadOutput) << line << '\n' << run.err;
    EXPECT_NE(run.err.find("space"), std::string::npos) << line << '\n' << run.err;
  }
  EXPECT_EQ(full.files(), 6U) << "a device was replaced, or something left beside it";
}

TEST_F(BadInput, OutputFolderMissing) {
  const std::string log = scratch_.file("log.csv", good_log(1000));
  const Outcome run = gyrobudget_run("calibrate '" + log + "' -o '" + scratch_.path("no/such/sensor.yaml") + "'");
  EXPECT_EQ(run.exit_code, kBadOutput);
  EXPECT_NE(run.err.find("no/such/sensor.yaml"), std::string::npos) << run.err;
}

// An interrupt in the middle of writing leaves nothing behind and ends with 130.
TEST_F(BadInput, InterruptWhileWriting) {
  const std::string path = scratch_.path("big.csv");
  const Outcome run =
      shell("%P simulate " GYROBUDGET_EXAMPLES "/sensors/mems.yaml --duration 1000h --model gauss-markov --quiet -o '" +
            path + "' & pid=$!; until [ -n \"$(find '" + scratch_.path("") +
            "' -type f -size +0)\" ] || ! kill -0 $pid; do sleep 0.01; done; kill -INT $pid; wait $pid");
  EXPECT_EQ(run.exit_code, kInterrupted) << run.err;
  EXPECT_EQ(scratch_.files(), 0U);
}

// The log comes from a pipe that never ends; a shell can open it for writing only once the program reads.
TEST_F(BadInput, InterruptWhileReading) {
  const Scratch inputs;
  const std::string pipe = inputs.path("log.csv");
  const Outcome run = shell("mkfifo '" + pipe + "'; %P calibrate '" + pipe + "' -o '" + scratch_.path("sensor.yaml") +
                            "' --report '" + scratch_.path("page.html") + "' & pid=$!; exec 3>'" + pipe +
                            "'; echo 'time (s),gyro_x (deg/h)' >&3; kill -INT $pid; wait $pid");
  EXPECT_EQ(run.exit_code, kInterrupted) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(scratch_.files(), 0U);
}

// --- Nothing of the user's is destroyed -----------------------------------------------------------------------------

TEST_F(BadInput, OutputsNeverReplaceTheInputOrOneAnother) {
  const std::string text = good_log(1000), log = scratch_.file("log.csv", text), page = scratch_.path("page.html");
  expect_refusal(gyrobudget_run("calibrate '" + log + "' -o '" + log + "'"), kUsage, {"-o", "input"});
  expect_refusal(gyrobudget_run("calibrate '" + log + "' -o '" + page + "' --report '" + page + "'"), kUsage,
                 {"same file"});
  expect_refusal(gyrobudget_run("calibrate '" + log + "' --json -o -"), kUsage, {"standard output"});
  expect_refusal(gyrobudget_run("calibrate '" + log + "' --plot x.txt"), kUsage, {"--plot", ".svg"});
  EXPECT_EQ(shell("cat '" + log + "'").out, text);
}

TEST_F(BadInput, MostSamplesMissing) {
  std::string text = "time (s),gyro_x (deg/h)\n";
  unsigned state = 1;
  for (int i = 0; i < 2000; ++i) {
    state = state * 1664525U + 1013904223U;
    text += fmt::format("{:.1f},{}\n", 0.1 * i, state >> 31 ? "nan" : "1.5");
  }
  expect_refusal(calibrate(text), kBadInput, {"gyro_x", "missing", "usable averaging times"});
}

TEST_F(BadInput, AKnockIsNamed) {
  const Outcome run =
      gyrobudget_run("calibrate '" + scratch_.file("log.csv", with_line(good_log(2000), 1000, "99.8,1e6")) + "'");
  EXPECT_NE(run.out.find("further from their surroundings"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("99.8 s"), std::string::npos) << run.out;
}

// --- Usage ----------------------------------------------------------------------------------------------------------

TEST_F(BadInput, UsageErrors) {
  expect_refusal(gyrobudget_run("calibrat x.csv"), kUsage, {"calibrat"});
  expect_refusal(gyrobudget_run("calibrate x.csv --rat 5"), kUsage, {"--rat", "--rate"});
  expect_refusal(gyrobudget_run("calibrate"), kUsage, {"log"});
  expect_refusal(gyrobudget_run("calibrate x.csv --terms X"), kUsage, {"X", "bias_instability"});
  expect_refusal(gyrobudget_run("allan x.csv --taus some"), kUsage, {"--taus", "octave"});
  expect_refusal(gyrobudget_run("allan x.csv --rate -3"), kUsage, {"--rate"});
  expect_refusal(gyrobudget_run("simulate x.yaml --duration 5"), kUsage, {"--duration", "unit"});
  expect_refusal(gyrobudget_run("simulate x.yaml --duration 5m"), kUsage, {"--duration"});
  expect_refusal(gyrobudget_run("plan x.yaml --want B"), kUsage, {"--want", "B=10%"});
  const Outcome bare = gyrobudget_run("");
  EXPECT_EQ(bare.exit_code, kUsage);
  EXPECT_NE(bare.err.find("calibrate"), std::string::npos);
}

TEST(BadUse, ASensorFileIsNoLog) {
  const auto outcome = gyrobudget_run("calibrate sensor.yaml");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_NE(outcome.err.find("sensor file"), std::string::npos) << outcome.err;
}

TEST(BadUse, OutputsThatCannotBeAreRefusedBeforeTheWork) {
  const Scratch scratch;
  const std::string sensor = scratch.file("s.yaml", "name: w\ngyro:\n  arw: 0.15 deg/sqrt(h)\n");
  const auto option = gyrobudget_run("simulate " + sensor + " --duration 1s --rate 10 -o -q");
  EXPECT_EQ(option.exit_code, 2) << option.err;
  const auto folder = gyrobudget_run("simulate " + sensor + " --duration 1000h --rate 100 -o /nonexistent/x.csv");
  EXPECT_EQ(folder.exit_code, 4) << folder.err;
  EXPECT_NE(folder.err.find("found no folder"), std::string::npos) << folder.err;
}

TEST(BadUse, RateAndUnitAreAskedForTogether) {
  const Scratch scratch;
  const auto outcome = gyrobudget_run("calibrate " + scratch.file("x.csv", "1\n2\n3\n4\n"));
  EXPECT_EQ(outcome.exit_code, 3);
  for (const char* part : {"--unit", "--rate"}) EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace gyrobudget::tests

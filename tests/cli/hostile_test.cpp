// SPDX-License-Identifier: MIT
// What a machine or a stranger does to the program: no room, no threads, names that a terminal obeys, pipes.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "program.h"

namespace gyrobudget::tests {
namespace {

constexpr int kDone = 0, kBadInput = 3, kBadOutput = 4;
const std::string kSensor = "gyro:\n  arw: 0.15 deg/sqrt(h)\n";

std::string log_text(const std::string& heading) {
  std::string text = "time (s)," + heading + "\n";
  std::mt19937 engine(1);
  for (int i = 0; i < 2000; ++i) text += std::to_string(0.01 * i) + "," + std::to_string(engine() % 1000) + "\n";
  return text;
}

bool has_controls(const std::string& text) {
  return std::ranges::any_of(text,
                             [](char c) { return (static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == 0x7f; });
}

TEST(Hostile, OutputToAFullDeviceIsAnError) {
  const Scratch scratch;
  const std::string sensor = scratch.file("s.yaml", kSensor), log = scratch.file("a.csv", log_text("w (deg/s)"));
  for (const std::string& words :
       {std::string("--help"), std::string("--version"), std::string("allan --help"), "allan " + log,
        "calibrate " + log + " --json", "inspect " + log, "plan " + sensor,
        "export " + sensor + " --form vins --rate 100", "simulate " + sensor + " --duration 1s --rate 10 -o -"}) {
    const Outcome run = shell("%P " + words + " >/dev/full");
    EXPECT_EQ(run.exit_code, kBadOutput) << words << run.err;
    EXPECT_NE(run.err.find("No space left"), std::string::npos) << words << run.err;
  }
}

// Stacks larger than all of the memory that the process may have: no thread can be made, also as root.
TEST(Hostile, WithoutThreadsThereIsOne) {
  const Scratch scratch;
  const std::string log = scratch.file("a.csv", log_text("w (deg/s)"));
  const std::string few = "ulimit -s 4000000 && ulimit -v 3000000 && ";
  if (shell(few + "true").exit_code != kDone) GTEST_SKIP() << "limits cannot be set here";
  for (const std::string& words : {"allan " + log, "calibrate " + log, "calibrate " + log + " --threads 7"}) {
    const Outcome run = shell("(" + few + "%P " + words + ")"), usual = gyrobudget_run(words);
    EXPECT_EQ(run.exit_code, kDone) << words << run.err;
    EXPECT_EQ(run.out, usual.out) << words;
  }
}

TEST(Hostile, NamesNeverSteerATerminal) {
  const Scratch scratch;
  const std::string bad = "a\x1b[31m\x7f\nb.csv", word = " '" + scratch.file(bad, log_text("w\x1b[5m (deg/s)")) + "'";
  const std::string sensor = scratch.path("s.yaml");
  for (const std::string& words :
       {"allan" + word, "inspect" + word, "allan --json" + word, "calibrate" + word + " -o " + sensor}) {
    const Outcome run = gyrobudget_run(words);
    EXPECT_EQ(run.exit_code, kDone) << run.err;
    EXPECT_FALSE(has_controls(run.out)) << run.out;
    EXPECT_FALSE(has_controls(run.err)) << run.err;
  }
  const Outcome written = shell("cat " + sensor);
  EXPECT_FALSE(has_controls(written.out)) << written.out;
  EXPECT_EQ(gyrobudget_run("plan " + sensor).exit_code, kDone);
  // The command that a file quotes is one that a shell takes.
  EXPECT_NE(written.out.find("$'" + scratch.path("a\\x1b[31m\\x7f\\x0ab.csv") + "'"), std::string::npos) << written.out;
  for (const std::string& words :
       {std::string("allan 'no\x1b[31m.csv'"), std::string("'al\x1b[31m'"), std::string("allan x --unit 'd\x1b[3m'")})
    EXPECT_FALSE(has_controls(gyrobudget_run(words).err)) << words;
  const std::string named = scratch.file("n.yaml", "name: \"x\\e[31m\\u0085\\u202ey\"\n" + kSensor);
  const Outcome plan = gyrobudget_run("plan " + named),
                simulated = gyrobudget_run("simulate " + named + " --duration 1s --rate 10 -o -");
  EXPECT_FALSE(has_controls(plan.out + simulated.out)) << plan.out;
  EXPECT_EQ(plan.out.find("\u202e"), std::string::npos) << plan.out;
}

TEST(Hostile, AColumnWithoutNumbersIsNoAnswer) {
  const Scratch scratch;
  std::string none = "time (s),w (deg/s)\n", half = "time (s),w (deg/s),v (deg/s)\n";
  for (int i = 0; i < 300; ++i)
    none += std::to_string(i) + ",nan\n", half += std::to_string(i) + ",nan," + std::to_string(i % 7) + "\n";
  const std::string empty = scratch.file("none.csv", none), one = scratch.file("half.csv", half);
  for (const std::string& words :
       {"allan " + empty, "allan --stream " + empty, "calibrate " + empty, "allan --stream " + one + " --column w"}) {
    const Outcome run = gyrobudget_run(words);
    EXPECT_EQ(run.exit_code, kBadInput) << words << run.out;
    EXPECT_NE(run.err.find("0 numbers"), std::string::npos) << run.err;
  }
  const Outcome run = gyrobudget_run("allan --stream --json " + one);
  EXPECT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_NE(run.out.find("left out 'w'"), std::string::npos) << run.out;
}

TEST(Hostile, APipeIsReadAsAFileIs) {
  const Scratch scratch;
  const std::string log = scratch.file("a.csv", log_text("w (deg/s)"));
  const std::string numbers = gyrobudget_run("allan " + log).out;
  const auto table_of = [](const std::string& out) {  // behind the name, before the notes
    return out.substr(out.find('\n'), out.find("How the log") - out.find('\n'));
  };
  const std::string table = table_of(numbers);
  ASSERT_FALSE(table.empty());
  for (const std::string& line : {"cat " + log + " | %P allan /dev/stdin", "%P allan /dev/stdin <" + log,
                                  "cat " + log + " | %P allan -", "gzip -c " + log + " | %P allan /dev/stdin"}) {
    const Outcome run = shell(line);
    EXPECT_EQ(run.exit_code, kDone) << line << run.err;
    EXPECT_EQ(table_of(run.out), table) << line;
  }
}

}  // namespace
}  // namespace gyrobudget::tests

// SPDX-License-Identifier: MIT
// The verb simulate with the models that stream: --skip, endless logs, constant memory, and options by model.
#include <gtest/gtest.h>

#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "program.h"

extern char** environ;

namespace gyrobudget::tests {
namespace {

const std::string kIfog = GYROBUDGET_EXAMPLES "/sensors/ifog.yaml";
const std::string kStreaming[] = {"gauss-markov",
                                  "1",
                                  "1 --taps 300",
                                  "2",
                                  "2 --noise-type single-sided --taps 500",
                                  "3",
                                  "3 --variant plain_white",
                                  "3 --variant gauss_markov --correlation-time 20s",
                                  "3 --variant flicker --rrw off"};

std::string simulate(const std::string& options) {
  const Outcome run = gyrobudget_run("simulate " + kIfog + " -q " + options);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return run.out;
}

/// Behind the comment and the header.
std::string rows(const std::string& log) { return log.substr(log.find('\n', log.find('\n') + 1) + 1); }

std::vector<double> first_column(const std::string& log) {
  std::istringstream lines(rows(log));
  std::vector<double> numbers;
  for (std::string line; std::getline(lines, line);) numbers.push_back(std::stod(line.substr(line.find(',') + 1)));
  return numbers;
}

/// Root mean square of the differences of neighbours over sqrt 2: white noise of one sample.
double sample_noise(const std::vector<double>& y) {
  double squares = 0;
  for (std::size_t k = 1; k < y.size(); ++k) squares += (y[k] - y[k - 1]) * (y[k] - y[k - 1]);
  return std::sqrt(squares / 2 / static_cast<double>(y.size() - 1));
}

/// Exit code and peak memory of one run of the program.
struct Usage {
  int exit_code = -1;
  double megabytes = 0;
};

Usage usage_of(std::vector<std::string> words) {
  words.insert(words.begin(), GYROBUDGET_PROGRAM);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  if (posix_spawn(&child, GYROBUDGET_PROGRAM, nullptr, nullptr, arguments.data(), environ) != 0) return {};
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, static_cast<double>(usage.ru_maxrss) / 1024};
}

TEST(Simulate, SkippingGivesTheTailOfTheLog) {
  for (const auto& model : kStreaming) {
    const std::string line = "--duration 100s --rate 200 --axes x,z --model " + model;
    const std::string whole = rows(simulate(line));
    for (const auto& [skip, samples] : {std::pair{"37s", 7400}, std::pair{"12345", 12345}, std::pair{"0", 0}}) {
      const std::string rest = rows(simulate(line + " --skip " + skip));
      ASSERT_GT(rest.size(), 1000U);
      EXPECT_TRUE(whole.ends_with(rest)) << model << ' ' << skip;
      EXPECT_EQ(std::count(rest.begin(), rest.end(), '\n'), 20'000 - samples) << model;
    }
  }
}

TEST(Simulate, SameBytesAtAnyThreadCount) {
  for (const auto& model : kStreaming) {
    const std::string line = "--duration 300s --model " + model;
    EXPECT_EQ(simulate(line + " --threads 1"), simulate(line + " --threads 2")) << model;
  }
}

TEST(Simulate, StreamsInConstantMemory) {
  // Three axes of 2e7 samples are 480 MB; of 2e5, 5 MB. Both must take what the program takes by itself.
  const Scratch scratch;
  const auto run = [&](const char* skip, const char* duration) {
    return usage_of({"simulate", kIfog, "-q", "--model", "2", "--rate", "100", "--duration", duration, "--skip", skip,
                     "-o", scratch.path("log.csv")});
  };
  const Usage small = run("100000", "2000s"), large = run("19900000", "200000s");
  EXPECT_EQ(small.exit_code, 0);
  EXPECT_EQ(large.exit_code, 0);
  EXPECT_LT(large.megabytes, small.megabytes + 100);
}

TEST(Simulate, AnEndlessLogRunsUntilThePipeCloses) {
  const std::string line = "simulate " + kIfog + " -q --model 3 --axes x --duration ";
  const Outcome endless = shell("%P " + line + "endless | head -n 30000 | tail -n +3");
  const Outcome whole = shell("%P " + line + "10min | head -n 30000 | tail -n +3");
  EXPECT_EQ(endless.out, whole.out);
  EXPECT_GT(endless.out.size(), 100'000U);
  EXPECT_EQ(gyrobudget_run(line + "endless -o log.csv").exit_code, 2);
}

TEST(Simulate, TheSpectralGeneratorSaysWhatItCannotDo) {
  const auto refused = [](const std::string& options) {
    const Outcome run = gyrobudget_run("simulate " + kIfog + " " + options);
    EXPECT_EQ(run.exit_code, 2) << options;
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err.find("--model gauss-markov, 1, 2 and 3"), std::string::npos) << run.err;
    return run.err;
  };
  EXPECT_NE(refused("--duration 1h --skip 10min").find("--skip"), std::string::npos);
  EXPECT_NE(refused("--duration endless").find("endless"), std::string::npos);
  // 3.6e10 samples of three columns and the transform: 14 numbers of 8 bytes.
  EXPECT_NE(refused("--duration 100000h").find("4.03e+03 GB of memory"), std::string::npos);
}

TEST(Simulate, ModelTwoKnowsItsNoiseTypes) {
  const std::string line = "--duration 200s --axes x --model 2 --noise-type ";
  const double both = sample_noise(first_column(simulate(line + "double-sided")));
  const double single = sample_noise(first_column(simulate(line + "single-sided")));
  constexpr double kWalkAndFilter = 2e-3;  // the rest of the sensor in one sample, same random numbers
  EXPECT_NEAR(both / single, std::sqrt(0.5), kWalkAndFilter);
  EXPECT_EQ(simulate("--duration 9s --model 2"), simulate("--duration 9s --model 2 --noise-type double-sided"));
}

TEST(Simulate, OptionsChangeWhatTheySay) {
  const std::string line = "--duration 50s --axes x --model ";
  EXPECT_NE(rows(simulate(line + "1")), rows(simulate(line + "1 --taps 5")));
  EXPECT_NE(rows(simulate(line + "2")), rows(simulate(line + "2 --taps 5")));
  EXPECT_EQ(rows(simulate(line + "3")), rows(simulate(line + "3 --rrw off --variant integrated_legacy")));
  EXPECT_NE(rows(simulate(line + "3")), rows(simulate(line + "3 --rrw on")));
  EXPECT_EQ(rows(simulate(line + "3 --variant flicker")), rows(simulate(line + "3 --variant flicker --rrw on")));
}

TEST(Simulate, RefusesOptionsOfOtherModels) {
  for (const char* options : {"--model spectral --taps 5", "--model 3 --taps 5", "--model 1 --noise-type single-sided",
                              "--model 2 --variant flicker", "--model gauss-markov --rrw on",
                              "--model 3 --correlation-time 5s", "--model 1 --taps 0", "--model 1 --taps many",
                              "--model 4", "--model 1 --skip 10s", "--model 1 --skip -1", "--model 1 --skip 1km"}) {
    const Outcome run = gyrobudget_run("simulate " + kIfog + " --duration 10s " + options);
    EXPECT_EQ(run.exit_code, 2) << options << run.err;
    EXPECT_EQ(run.out, "") << options;
  }
}

}  // namespace
}  // namespace gyrobudget::tests

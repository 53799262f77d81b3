// SPDX-License-Identifier: MIT
// allan: estimators, segments, binary logs and streams, as the program gives them. The numbers themselves are tested
// where they are made; here, that each option reaches them.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "../json.h"
#include "program.h"

namespace gyrobudget::tests {
namespace {

using nlohmann::json;

constexpr int kUsage = 2, kBadInput = 3, kInterrupted = 130;

json json_of(const Outcome& run) {
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return parsed<json>(run.out);
}

/// White noise of variance 1/12, the same on every machine.
std::vector<double> noise(int samples, unsigned state = 1) {
  std::vector<double> values;
  for (int i = 0; i < samples; ++i) {
    state = state * 1664525U + 1013904223U;
    values.push_back(state / 4294967296.0 - 0.5);
  }
  return values;
}

std::string csv(const std::vector<double>& values) {
  std::string text = "time (s),gyro_x (deg/h)\n";
  for (std::size_t i = 0; i < values.size(); ++i) text += fmt::format("{:.1f},{}\n", 0.1 * i, values[i]);
  return text;
}

template <class Number>
std::string raw(const std::vector<double>& values) {
  std::string bytes;
  for (const double v : values) {
    const auto number = static_cast<Number>(v);
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(Number));
  }
  return bytes;
}

constexpr const char* kBinary = " --rate 10 --unit deg/h ";

class Allan : public testing::Test {
 protected:
  [[nodiscard]] json run(const std::string& arguments) const {
    return json_of(gyrobudget_run("allan " + arguments + " --json"));
  }
  void expect_refused(const std::string& arguments, int code, const std::string& because) const {
    const Outcome outcome = gyrobudget_run("allan " + arguments);
    EXPECT_EQ(outcome.exit_code, code) << arguments;
    EXPECT_NE(outcome.err.find(because), std::string::npos) << because << " is not in: " << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
  const Scratch scratch_;
};

// --- Estimators -----------------------------------------------------------------------------------------------------

/// Plain sums of NIST SP 1065 at one m, in deg/h (time deviation: deg/h s).
double textbook(const std::vector<double>& y, std::size_t m, const std::string& estimator) {
  std::vector<double> x{0};
  for (const double v : y) x.push_back(x.back() + v);
  const auto third = estimator == "ohdev" || estimator == "hdev";
  const std::size_t step = estimator == "adev" || estimator == "hdev" ? m : 1, span = (third ? 3 : 2) * m;
  double sum = 0;
  int terms = 0;
  if (estimator == "mdev") {
    for (std::size_t j = 0; j + 3 * m <= y.size() + 1; ++j, ++terms) {
      double mean = 0;
      for (std::size_t k = j; k < j + m; ++k) mean += (x[k + 2 * m] - 2 * x[k + m] + x[k]) / m;
      sum += mean * mean;
    }
  } else {
    for (std::size_t k = 0; k + span <= y.size(); k += step, ++terms) {
      const double d =
          third ? x[k + 3 * m] - 3 * x[k + 2 * m] + 3 * x[k + m] - x[k] : x[k + 2 * m] - 2 * x[k + m] + x[k];
      sum += d * d;
    }
  }
  return std::sqrt(sum / terms / (third ? 6 : 2)) / m;
}

TEST_F(Allan, EveryEstimatorIsACurveOfItsOwnName) {
  const auto y = noise(2000);
  const auto document = run(scratch_.file("log.csv", csv(y)) + " --taus octave --estimator adev,oadev,mdev,hdev,ohdev");
  EXPECT_EQ(document["schema"], "gyrobudget.allan/1");
  EXPECT_EQ(document["estimator"], "adev");
  ASSERT_EQ(document["axes"].size(), 5U);
  for (const auto& axis : document["axes"]) {
    EXPECT_EQ(axis["name"], "gyro_x");
    EXPECT_EQ(axis["unit"], "deg/h");
    const auto& point = axis["points"][4];
    ASSERT_EQ(point["m"], 16);
    constexpr double kRounding = 1e-10;
    const double expected = textbook(y, 16, axis["estimator"]);
    EXPECT_NEAR(point["deviation"].get<double>() / expected, 1, kRounding) << axis["estimator"];
    EXPECT_LT(point["lower"], point["deviation"]);
    EXPECT_GT(point["upper"], point["deviation"]);
    EXPECT_GT(point["edf"], 10);
  }
}

TEST_F(Allan, AllOfThemHaveIntervalsAtEveryTau) {
  const auto document = run(scratch_.file("log.csv", csv(noise(600))) + " --taus octave --estimator all");
  ASSERT_EQ(document["axes"].size(), 14U);
  for (const auto& axis : document["axes"]) {
    SCOPED_TRACE(axis["estimator"]);
    EXPECT_GE(axis["points"].size(), 5U);
    for (const auto& p : axis["points"]) {
      for (const char* number : {"deviation", "lower", "upper", "edf", "bias"}) EXPECT_GT(p[number], 0) << number;
    }
  }
}

TEST_F(Allan, TimeDeviationsAreAngles) {
  const auto document = run(scratch_.file("log.csv", csv(noise(2000))) + " --taus octave --estimator mdev,tdev");
  const auto &mdev = document["axes"][0], &tdev = document["axes"][1];
  EXPECT_EQ(tdev["unit"], "arcsec");
  EXPECT_EQ(tdev["si_unit"], "rad");
  EXPECT_EQ(tdev["mean_unit"], "deg/h");
  EXPECT_EQ(tdev["mean"], mdev["mean"]);
  const auto &m = mdev["points"][3], &t = tdev["points"][3];  // 1 deg/h is 1 arcsec/s
  EXPECT_NEAR(t["deviation"].get<double>(), m["deviation"].get<double>() * 0.8 / std::sqrt(3.), 1e-12);
}

TEST_F(Allan, TotalAndTheo1ReachBeyondHalfTheRecord) {
  const auto document = run(scratch_.file("log.csv", csv(noise(1000))) + " --estimator oadev,totdev,theo1");
  const auto longest = [&](int i) { return document["axes"][i]["points"].back()["tau_s"].get<double>(); };
  EXPECT_NEAR(longest(0), 50, 1e-9);
  EXPECT_GT(longest(1), 95);
  EXPECT_NEAR(longest(2), 75, 1e-9);
}

TEST_F(Allan, AStrideIsSaidAndCostsDegreesOfFreedom) {
  const std::string log = scratch_.file("log.csv", csv(noise(4000)));
  const auto full = run(log + " --taus octave"), strided = run(log + " --taus octave --stride m/4");
  const auto &a = full["axes"][0]["points"][6], &b = strided["axes"][0]["points"][6];
  EXPECT_EQ(a["stride"], 1);
  EXPECT_EQ(b["stride"], 16);                                                 // m = 64
  EXPECT_NEAR(a["edf"].get<double>() / b["edf"].get<double>(), 1.078, 0.01);  // white noise: 7.8 %
  EXPECT_NE(gyrobudget_run("allan " + log + " --stride m/4").out.find("stride"), std::string::npos);
}

TEST_F(Allan, PicturesAndPagesTakeSeveralEstimators) {
  const std::string page = scratch_.path("page.html"), picture = scratch_.path("picture.svg");
  const Outcome outcome = gyrobudget_run("allan " + scratch_.file("log.csv", csv(noise(500))) +
                                         " --estimator mdev,tdev --report " + page + " --plot " + picture);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  std::ostringstream text;
  text << std::ifstream(page).rdbuf() << std::ifstream(picture).rdbuf();
  for (const char* part : {"gyro_x, tdev", "time deviation [arcsec]", "modified Allan deviation [deg/h]"}) {
    EXPECT_NE(text.str().find(part), std::string::npos) << part;
  }
}

TEST_F(Allan, RefusesWhatNoEstimatorIs) {
  const std::string log = scratch_.file("log.csv", csv(noise(100)));
  expect_refused(log + " --estimator foo", kUsage, "no estimator 'foo'; there are adev, oadev");
  expect_refused(log + " --estimator mdev --ieee", kUsage, "--ieee");
  expect_refused(log + " --stride m/0", kUsage, "--stride m/0");
  expect_refused(log + " --stride 7", kUsage, "--stride 7");
}

// --- Segments -------------------------------------------------------------------------------------------------------

TEST_F(Allan, SeveralLogsArePooledByDegreesOfFreedom) {
  const std::string a = scratch_.file("a.csv", csv(noise(4000, 1))), b = scratch_.file("b.csv", csv(noise(1000, 2)));
  const auto one = run(a + " --taus octave"), other = run(b + " --taus octave"),
             both = run(a + " " + b + " --taus octave");
  EXPECT_EQ(both["record"]["samples"], 5000);
  for (std::size_t i = 0; i < other["axes"][0]["points"].size(); ++i) {
    const auto &p = one["axes"][0]["points"][i], &q = other["axes"][0]["points"][i],
               &pooled = both["axes"][0]["points"][i];
    const double v = p["edf"], w = q["edf"];
    EXPECT_NEAR(pooled["edf"].get<double>(), v + w, 1e-9 * v);
    const double expected = std::sqrt(
        (v * std::pow(p["deviation"].get<double>(), 2) + w * std::pow(q["deviation"].get<double>(), 2)) / (v + w));
    EXPECT_NEAR(pooled["deviation"].get<double>() / expected, 1, 1e-9);
  }
  EXPECT_EQ(both["axes"][0]["points"].back()["m"], one["axes"][0]["points"].back()["m"]);
}

TEST_F(Allan, OnlyLikeLogsArePooled) {
  const std::string a = scratch_.file("a.csv", csv(noise(100)));
  std::string renamed = csv(noise(100));
  renamed.replace(renamed.find("gyro_x"), 6, "gyro_y");
  expect_refused(a + " " + scratch_.file("renamed.csv", renamed), kBadInput, "its columns are not those of");
  std::string slow = "time (s),gyro_x (deg/h)\n";
  for (int i = 0; i < 100; ++i) slow += fmt::format("{},{}\n", i, i % 7);
  expect_refused(a + " " + scratch_.file("slow.csv", slow), kBadInput, "its rate is 1 Hz");
  expect_refused(a + " " + a, kUsage, "twice");
}

/// A log of the noise as two power-ups, the clock of the second one ahead or started anew.
std::string csv_of_two(const std::vector<double>& values, std::size_t cut, double start) {
  std::string text = "time (s),gyro_x (deg/h)\n";
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double t = i < cut ? 0.1 * i : start + 0.1 * (i - cut);
    text += fmt::format("{:.1f},{}\n", t, values[i]);
  }
  return text;
}

TEST_F(Allan, SegmentsOfOneLogArePooledAsLogsAre) {
  const auto y = noise(5000);
  const std::string a = scratch_.file("a.csv", csv({y.begin(), y.begin() + 4000})),
                    b = scratch_.file("b.csv", csv({y.begin() + 4000, y.end()}));
  const auto logs = run(a + " " + b + " --taus octave");
  for (const double start : {1000., 0.}) {
    const auto one = run(scratch_.file("both.csv", csv_of_two(y, 4000, start)) + " --taus octave --segments 5s");
    ASSERT_EQ(one["axes"][0]["points"].size(), logs["axes"][0]["points"].size());
    for (std::size_t i = 0; i < logs["axes"][0]["points"].size(); ++i) {
      const auto &p = one["axes"][0]["points"][i], &q = logs["axes"][0]["points"][i];
      for (const char* number : {"deviation", "edf", "lower", "upper"})
        EXPECT_NEAR(p[number].get<double>() / q[number].get<double>(), 1, 1e-9) << number;
    }
    const auto& segments = one["record"]["segments"];
    ASSERT_EQ(segments.size(), 2U);
    EXPECT_EQ(segments[0]["samples"], 4000);
    EXPECT_EQ(segments[1]["first_row"], 4002);
    EXPECT_NEAR(segments[1]["start_s"].get<double>(), start, 1e-6);
    EXPECT_NEAR(segments[1]["duration_s"].get<double>(), 100, 1e-6);
    EXPECT_EQ(one["record"]["samples"], 5000);
  }
  const Outcome table = gyrobudget_run("allan " + scratch_.path("both.csv") + " --segments 5s");
  EXPECT_NE(table.out.find("2 segments of 6.67 min, 100 s"), std::string::npos) << table.out;
  expect_refused(scratch_.path("both.csv"), kBadInput, "allan --segments GAP");
  expect_refused(scratch_.path("both.csv") + " --segments 0s", kUsage, "--segments 0s: must be above 0");
  expect_refused(scratch_.path("both.csv") + " --segments 5s --stream", kUsage, "leave out --segments");
}

TEST_F(Allan, UnevenTimesAreResampledOnlyWhenAsked) {
  std::string text = "time (s),gyro_x (deg/h)\n";
  double t = 0;
  for (const double v : noise(5000)) text += fmt::format("{:.6f},{}\n", t += 0.01 + 0.2 * std::abs(v), v);
  const std::string log = scratch_.file("uneven.csv", text);
  expect_refused(log, kBadInput, "--resample HZ");
  const auto document = run(log + " --resample 4");
  EXPECT_EQ(document["record"]["rate_hz"], 4);
  EXPECT_NE(document["notes"].dump().find("resampled to 4 Hz as asked"), std::string::npos);
  expect_refused(log + " --resample 1kHz", kBadInput, "give a lower rate");
  expect_refused(log + " --resample 4 --stream", kUsage, "leave out --resample");
}

// --- Binary logs ----------------------------------------------------------------------------------------------------

TEST_F(Allan, BinaryLogsAreTheTextInOtherClothes) {
  const auto y = noise(3000);
  const auto text = run(scratch_.file("log.csv", csv(y)) + " --taus octave");
  const std::string f64 = scratch_.file("log.f64", raw<double>(y));
  for (const std::string& line : {f64 + kBinary, "- --format f64" + (kBinary + ("<" + f64)),
                                  "/dev/stdin --format f64" + (kBinary + ("<" + f64))}) {
    const auto binary = run(line + " --taus octave");
    EXPECT_EQ(binary["axes"][0]["points"], text["axes"][0]["points"]) << line;
  }
  const auto f32 = run(scratch_.file("log.f32", raw<float>(y)) + kBinary + " --taus octave");
  EXPECT_NEAR(
      f32["axes"][0]["points"][0]["deviation"].get<double>() / text["axes"][0]["points"][0]["deviation"].get<double>(),
      1, 1e-7);
}

TEST_F(Allan, SimulatedBinaryLogsReadBack) {
  const std::string sensor = GYROBUDGET_EXAMPLES "/sensors/mems.yaml";
  const auto simulate = [&](const std::string& file) {
    const std::string path = scratch_.path(file);
    const Outcome outcome = gyrobudget_run("simulate " + sensor + " --duration 30s --rate 10 --unit deg/h -o " + path);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return path;
  };
  const auto text = run(simulate("log.csv") + " --taus octave");
  const auto npy = run(simulate("log.npy") + kBinary + " --taus octave");
  const auto f64 = run(simulate("log.f64") + kBinary + "--columns 3 --taus octave");
  ASSERT_EQ(npy["axes"].size(), 3U);
  EXPECT_EQ(npy["axes"], f64["axes"]);
  EXPECT_EQ(npy["axes"][1]["name"], "column 2");
  for (std::size_t i = 0; i < 3; ++i) {
    constexpr double kLastDigit = 1e-12;
    EXPECT_NEAR(npy["axes"][i]["points"][2]["deviation"].get<double>() /
                    text["axes"][i]["points"][2]["deviation"].get<double>(),
                1, kLastDigit);
  }
  const auto one = run(simulate("log.f32") + kBinary + "--columns 3 --column 2 --taus octave");
  ASSERT_EQ(one["axes"].size(), 1U);
  EXPECT_EQ(one["axes"][0]["name"], "column 2");
  const Outcome piped =
      shell("%P simulate " + sensor +
            " --duration 60s --rate 10 --unit deg/h --format npy -o - | %P calibrate - --format npy --json" + kBinary);
  EXPECT_NE(piped.out.find("gyrobudget.calibration/1"), std::string::npos) << piped.err;
}

TEST_F(Allan, BinaryLogsNeedToBeTold) {
  const std::string log = scratch_.file("log.f64", raw<double>(noise(10)));
  expect_refused(log + " --unit deg/h", kBadInput, "--rate HZ");
  expect_refused(log + " --rate 10", kBadInput, "--unit deg/s");
  expect_refused(log + kBinary + "--columns 3", kBadInput, "a multiple of 24");
  expect_refused(log + kBinary + "--column 2", kBadInput, "no column '2'");
  expect_refused(scratch_.file("log.npy", raw<double>(noise(10))) + kBinary, kBadInput, "expected the mark of a .npy");
  const Outcome endless =
      gyrobudget_run("simulate " GYROBUDGET_EXAMPLES "/sensors/mems.yaml --duration endless --model 1 --format npy");
  EXPECT_EQ(endless.exit_code, kUsage);
  EXPECT_NE(endless.err.find("use f64"), std::string::npos) << endless.err;
}

// --- Streams --------------------------------------------------------------------------------------------------------

TEST_F(Allan, AStreamHasTheTermsOfTheWholeLogAtEveryStride) {
  const auto y = noise(20000);
  const std::string text = scratch_.file("log.csv", csv(y)), bytes = scratch_.file("log.f64", raw<double>(y));
  const auto whole = run(text + " --taus octave")["axes"][0]["points"];
  for (const std::string& line :
       {text + " --stream", "- --stream <" + text, "- --stream --format f64" + (kBinary + ("<" + bytes))}) {
    const auto document = run(line);
    EXPECT_EQ(document["record"]["samples"], 20000);
    const auto& points = document["axes"][0]["points"];
    ASSERT_EQ(points.size(), whole.size()) << line;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const int m = 1 << i, stride = m > 16 ? m / 16 : 1;
      EXPECT_EQ(points[i]["stride"], stride);
      const double ratio = points[i]["deviation"].get<double>() / whole[i]["deviation"].get<double>();
      // 0.5 % of the degrees of freedom are lost: the value moves by 0.07 of its scatter, itself 0.6 sqrt(m/n).
      const double lost = 0.042 * std::sqrt(m / 20000.0);
      EXPECT_NEAR(ratio, 1, stride == 1 ? 1e-12 : 5 * lost) << m;
      // White noise, but where few clusters make the slope uncertain.
      if (m > 256) continue;
      EXPECT_NEAR(points[i]["edf"].get<double>() / whole[i]["edf"].get<double>(), 1, 0.01) << m;
    }
  }
  const Outcome said = gyrobudget_run("allan " + text + " --stream");
  EXPECT_NE(said.out.find("every m/16 samples above m = 16"), std::string::npos) << said.out;
  EXPECT_EQ(run(text + " --stream --stride m/4")["axes"][0]["points"][4]["stride"], 4);
}

TEST_F(Allan, FollowingPrintsATableAtEachDoublingAndAtTheEnd) {
  const auto y = noise(5000);
  const std::string first = scratch_.file("first", raw<double>({y.begin(), y.begin() + 1500})),
                    rest = scratch_.file("rest", raw<double>({y.begin() + 1500, y.end()}));
  const Outcome outcome =
      shell("( cat " + first + "; sleep 0.5; cat " + rest + ") | %P allan - --follow --format f64" + kBinary);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  std::vector<std::string> tables;
  for (std::size_t at = 0; (at = outcome.out.find("standard input: ", at)) != std::string::npos; ++at) {
    tables.push_back(outcome.out.substr(at + 16, 13));
  }
  EXPECT_EQ(tables, (std::vector<std::string>{"1 500 samples", "5 000 samples"}));
  EXPECT_EQ(outcome.out.find('\x1b'), std::string::npos);  // no terminal, no control codes
}

TEST_F(Allan, AnInterruptPrintsTheLastTable) {
  const std::string log = scratch_.file("log", raw<double>(noise(3000))), table = scratch_.path("table"),
                    pipe = scratch_.path("pipe");
  // Interrupted once the first table is there, whenever that is; the pipe stays open longer.
  const Outcome outcome = shell(
      "mkfifo " + pipe + "; ( cat " + log + "; exec sleep 60 ) > " + pipe + " & writer=$!; %P allan - --follow " +
      "--format f64" + kBinary + " < " + pipe + " > " + table + " & reader=$!; until [ -s " + table +
      " ] || ! kill -0 $reader; do sleep 0.01; done; kill -INT $reader; wait $reader; code=$?; kill $writer; cat " +
      table + "; exit $code");
  EXPECT_EQ(outcome.exit_code, kInterrupted) << outcome.err;
  EXPECT_NE(outcome.out.find("3 000 samples"), std::string::npos) << outcome.out;
}

TEST_F(Allan, StreamsRefuseWhatNeedsTheWholeLog) {
  const std::string log = scratch_.file("log.csv", csv(noise(200)));
  expect_refused(log + " --stream --estimator mdev", kUsage, "the oadev only");
  expect_refused(log + " --stream --taus all", kUsage, "octaves only");
  expect_refused(log + " --follow --stride m/3", kUsage, "a power of two");
  expect_refused(log + " --stream --ieee", kUsage, "--ieee");
  expect_refused(log + " other.csv --stream", kUsage, "one log");
  expect_refused(log + " --stream --psd welch --json", kUsage, "needs the whole log");
  expect_refused(log + " --stream --input angle --unit deg", kUsage, "rates or increments");
  expect_refused("- --stream --format npy" + (kBinary + ("<" + log)), kBadInput, "expected the mark of a .npy");
  expect_refused(scratch_.file("one.f64", raw<double>({1})) + kBinary + "--stream", kBadInput, "expected at least 2");
}

// --- Other views ----------------------------------------------------------------------------------------------------

TEST_F(Allan, SpectraReadWhiteNoiseAsItsCoefficient) {
  const std::string log = scratch_.file("log.csv", csv(noise(20000)));
  for (const std::string method : {"welch", "multitaper"}) {
    const auto psd = run(log + " --taus octave --psd " + method)["axes"][0]["psd"];
    EXPECT_EQ(psd["method"], method);
    EXPECT_EQ(psd["sides"], "two-sided");
    EXPECT_EQ(psd["unit"], "deg/h/sqrt(Hz)");
    EXPECT_EQ(psd["si_unit"], "rad/sqrt(s)");
    ASSERT_GT(psd["points"].size(), 20U);
    const double density = std::sqrt(0.1 / 12);  // variance times sample interval
    int outside = 0;
    for (const auto& p : psd["points"]) {
      outside += p["lower"] > density || p["upper"] < density ? 1 : 0;
      EXPECT_LT(p["frequency_hz"], 5.001);
    }
    // 95 % intervals: of 100 independent points 16 fall outside with probability 4e-5.
    EXPECT_LT(outside, 0.16 * static_cast<double>(psd["points"].size())) << method;
  }
}

TEST_F(Allan, DeviationOverTimeShowsWhatChanges) {
  auto y = noise(12000);
  for (std::size_t i = 6000; i < y.size(); ++i) y[i] *= 3;
  const std::string log = scratch_.file("log.csv", csv(y)), page = scratch_.path("page.html");
  const auto surface = run(log + " --dynamic 100s --report " + page)["axes"][0]["dynamic"];
  EXPECT_EQ(surface["window_s"], 100);
  EXPECT_EQ(surface["unit"], "deg/h");
  const auto& rows = surface["deviation"];
  ASSERT_EQ(rows.size(), surface["time_s"].size());
  EXPECT_EQ(surface["time_s"][0], 50);
  ASSERT_EQ(rows[0].size(), surface["tau_s"].size());
  constexpr double kScatter = 0.15;  // of a ratio of deviations with about 600 degrees of freedom each: 5 sigma
  EXPECT_NEAR(rows.back()[0].get<double>() / rows[0][0].get<double>(), 3, 3 * kScatter);
  std::ostringstream text;
  text << std::ifstream(page).rdbuf();
  EXPECT_NE(text.str().find("\"dynamic\":{\"window_s\":100"), std::string::npos);
}

TEST_F(Allan, ViewsNeedAPlaceAndAWindow) {
  const std::string log = scratch_.file("log.csv", csv(noise(200)));
  expect_refused(log + " --psd welch", kUsage, "--psd goes into --report FILE.html and --json");
  expect_refused(log + " --dynamic 10s", kUsage, "--dynamic goes into");
  expect_refused(log + " --dynamic 1s --json", kUsage, "a window of 10 samples");
  expect_refused(log + " --dynamic 1h --json", kUsage, "the 200 of the record");
}

}  // namespace
}  // namespace gyrobudget::tests

// SPDX-License-Identifier: MIT
// Options of the verbs on sensor files alone: export, plan, accuracy and paper.
#include "gyrobudget/app/sensor_file/forms.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/estimation/fit/requirement.h"
#include "gyrobudget/noise/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include "options.h"
#include "values.h"

namespace gyrobudget::inline v0::cli {
namespace {

App* add_export(App& app, ExportArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand("export",
                                  "A sensor file in the form of another tool, with its units and conventions.\n\n"
                                  "  gyrobudget export sensor.yaml --form vins --rate 200\n"
                                  "  gyrobudget export sensor.yaml --form kf_gins --rate 100 -o imunoise.yaml\n");
  const auto names = sensor_file::form_names();
  verb->add_option("sensor", a.sensor, "sensor file")->required()->type_name("SENSOR");
  verb->add_option("--form", a.form, "of " + text::listing(names, "or"))->required()->type_name("NAME");
  verb->add_option("--rate", texts.rate, "of the IMU's samples, which sigmas of a sample depend on")
      ->required()
      ->type_name("HZ");
  verb->add_option("--horizon", texts.horizon,
                   "time over which a random walk stands for bias instability where no walk is resolved [100s]")
      ->type_name("TIME");
  verb->add_option("-o,--output", a.output, "- is standard output")->type_name("FILE")->capture_default_str();
  verb->footer(fmt::format("Sensor file (YAML, every value with its unit):\n\n{}", sensor_file::sensor_help()));
  add_common(*verb, a.common, false);
  return verb;
}

void finish(ExportArguments& a, const Texts& texts) {
  a.sensor_rate_hz = a.rate_hz = rate("--rate", texts.rate);
  if (!texts.horizon.empty()) a.horizon_s = duration("--horizon", texts.horizon);
}

App* add_plan(App& app, PlanArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand("plan",
                                  "How long to record for a wanted accuracy, or what accuracy a recording buys.\n\n"
                                  "  gyrobudget plan examples/sensors/mems.yaml --want B=10%\n"
                                  "  gyrobudget plan sensor.yaml --duration 2h --rate 200\n");
  verb->add_option("sensor", a.sensor, "sensor file with the expected coefficients")->required()->type_name("SENSOR");
  verb->add_option("--rate", texts.rate,
                   "sample rate, also of sigmas of a sample that a file of VINS or imu_utils gives [100 Hz; densities]")
      ->type_name("HZ");
  verb->add_option("--duration", texts.duration, "what will a record of this length buy?")->type_name("TIME");
  verb->add_option("--want", texts.wishes, "how long for this accuracy (one sigma, relative), e.g. B=10% or arw=1%")
      ->type_name("TERM=ACCURACY ...");
  add_common(*verb, a.common);
  return verb;
}

void finish(PlanArguments& a, const Texts& texts) {
  if (!texts.rate.empty()) a.sensor_rate_hz = a.rate_hz = rate("--rate", texts.rate);
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  for (const auto& text : texts.wishes) a.wishes.push_back(wish(text));
}

App* add_accuracy(App& app, AccuracyArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "accuracy",
      "How wrong the fits are: simulates records of known truth and compares.\n\n"
      "  gyrobudget accuracy examples/sensors/mems.yaml --report accuracy.html\n"
      "  gyrobudget accuracy sensor.yaml --duration 2h --rate 10 --require \"arw.rmse<1.1*crlb, coverage in 0.92..0.98\"\n"
      "  gyrobudget accuracy sensor.yaml --sweep\n");
  verb->add_option("sensor", a.sensor, "sensor file: the truth")->required()->type_name("SENSOR");
  verb->add_option("--duration", texts.duration, "length of a record [10h]")->type_name("TIME");
  verb->add_option("--rate", texts.rate,
                   "sample rate, also of sigmas of a sample that a file of VINS or imu_utils gives [1 Hz; densities]")
      ->type_name("HZ");
  verb->add_option("--records", texts.records, "how many [500; 200 for --sweep]")->type_name("N");
  verb->add_option("--methods", texts.methods, "of gls, edf, loglog, slope, visual, whittle [gls,whittle]")
      ->type_name("LIST");
  verb->add_option("--terms", texts.terms, "terms to fit, of Q,N,B,K,R [N,B,K, and Q and R where the sensor has them]")
      ->type_name("LIST");
  verb->add_option("--axis", texts.axis, "which of the sensor's two; gyro_x and so on where its axes differ")
      ->check(IsMember{{"gyro", "gyro_x", "gyro_y", "gyro_z", "accelerometer", "accelerometer_x", "accelerometer_y",
                        "accelerometer_z"}})
      ->type_name("NAME")
      ->capture_default_str();
  verb->add_option(
          "--front-end", texts.front_end,
          "what stands between the sensor and its records, which are then fitted as calibrate does: first_order:25Hz, second_order:25Hz or moving_average:25Hz (over the nearest whole number of samples) before the white noise, decimation:4 (the sensor is so many times as fast as its log), warm_up:5, knock:30 and rounding:1 (sizes and step in standard deviations of a sample), outliers:1%, held:3 (every third row repeats the one before), gaps:2% [none]")
      ->type_name("LIST");
  verb->add_option("--known", texts.known,
                   "what the fits are told of the low pass: nothing, its kind, or all [nothing]")
      ->check(IsMember{{"nothing", "kind", "all"}})
      ->type_name("WHAT");
  verb->add_option("--mask", texts.mask, "what is left out of such records: outliers, steps, warm-up, motion")
      ->check(IsMember{{"outliers", "steps", "warm-up", "motion"}})
      ->type_name("WHAT ...");
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into every output")->capture_default_str();
  verb->add_option(
          "--require", texts.require,
          "limits, [METHOD.][COEFFICIENT.]QUANTITY < NUMBER[*crlb|*likelihood] or in LOW..HIGH; quantities: rmse, bias, coverage, coverage_identified, identified, missed, false_terms, p05, p01, unconverged, seconds; exit code 1 where one is broken")
      ->type_name("LIMITS");
  verb->add_option("--report", a.report, "write a self-contained HTML page")->type_name("FILE.html");
  verb->add_flag("--sweep", a.sweep,
                 "error against run time instead: over methods, taus an octave, strides and record lengths");
  verb->add_option("--longest", a.longest, "longest record of the sweep, samples from 1e4 to 1e8 [1e7]")
      ->check(Range{1e4, 1e8})
      ->type_name("N");
  add_common(*verb, a.common);
  return verb;
}

void finish_sweep(AccuracyArguments& a, const Texts& texts) {
  for (const auto& [option, text] : {std::pair{"--methods", texts.methods}, {"--require", texts.require}}) {
    if (a.sweep && !text.empty()) {
      throw std::invalid_argument(fmt::format("{}: --sweep takes every method and has no limits", option));
    }
  }
  if (a.sweep && a.recorder) throw std::invalid_argument("--sweep has no --front-end");
  if (a.longest && !a.sweep) throw std::invalid_argument("--longest belongs to --sweep");
}

void finish_recorder(AccuracyArguments& a, const Texts& texts) {
  if (!texts.front_end.empty()) a.recorder = recorder(texts.front_end, a.rate_hz);
  if (!a.recorder && (!texts.known.empty() || !texts.mask.empty()))
    throw std::invalid_argument("--known and --mask are of records with --front-end");
  a.calibrate.terms = a.terms;
  a.calibrate.mask = masking(texts.mask);
  if (texts.known.empty() || texts.known == "nothing") return;
  if (!a.recorder->front_end) throw std::invalid_argument("--known: --front-end has no low pass that could be known");
  if (texts.known == "all")
    a.calibrate.front_end = a.recorder->front_end;
  else
    a.calibrate.front_end_kind = a.recorder->front_end->kind;
}

void finish(AccuracyArguments& a, const Texts& texts) {
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  if (!texts.rate.empty()) a.sensor_rate_hz = a.rate_hz = rate("--rate", texts.rate);
  constexpr double kFewestSamples = 16, kMostSamples = 1e8;
  const double samples = std::round(a.duration_s * a.rate_hz);
  if (!(samples >= kFewestSamples && samples <= kMostSamples)) {
    throw std::invalid_argument(
        fmt::format("{:g} s at {:g} Hz are {:.3g} samples; a record has 16 to 1e8", a.duration_s, a.rate_hz, samples));
  }
  if (!texts.records.empty()) {
    constexpr std::uint64_t kMostRecords = 10'000'000;
    const std::uint64_t records = whole_number("--records", texts.records);
    if (records < 1 || records > kMostRecords) {
      throw std::invalid_argument(fmt::format("--records {}: must be from 1 to {}", records, kMostRecords));
    }
    a.records = static_cast<int>(records);
  }
  for (const auto& name : split(texts.methods.empty() ? "gls,whittle" : texts.methods, ',')) {
    const fit::Method method = method_named(name);
    if (std::ranges::find(a.methods, method) == a.methods.end()) a.methods.push_back(method);
  }
  if (!texts.terms.empty()) a.terms = terms(texts.terms);
  if (texts.axis.starts_with("accelerometer")) a.signal = noise::Signal::specific_force;
  if (const auto at = texts.axis.find('_'); at != std::string::npos)
    a.axis = static_cast<std::size_t>(texts.axis[at + 1] - 'x');
  finish_recorder(a, texts);
  a.seed = seed(texts.seed);
  if (!texts.require.empty()) a.requirements = fit::parse_requirements(texts.require);
  finish_sweep(a, texts);
}

App* add_paper(App& app, PaperArguments& a, Texts& texts) {
  auto* verb =
      app.add_subcommand("paper",
                         "The tables and figures of Nunes et al. beside ours, and why they differ: gyro noise,\n"
                         "the first stage flown in closed loop on each gyro, and what could have made its\n"
                         "distances.\n\n"
                         "  gyrobudget paper --report paper.html\n"
                         "  gyrobudget paper --seed 7 --json\n");
  verb->add_option("--seed", texts.seed, "of the random numbers; printed into every output")->capture_default_str();
  verb->add_option("--report", a.report, "write a self-contained HTML page with the figures")->type_name("FILE.html");
  add_common(*verb, a.common);
  return verb;
}

void finish(PaperArguments& a, const Texts& texts) { a.seed = seed(texts.seed); }

}  // namespace

Verb plan_verb(App& app) { return make_verb<PlanArguments>(app, add_plan, finish); }
Verb export_verb(App& app) { return make_verb<ExportArguments>(app, add_export, finish); }
Verb accuracy_verb(App& app) { return make_verb<AccuracyArguments>(app, add_accuracy, finish); }
Verb paper_verb(App& app) { return make_verb<PaperArguments>(app, add_paper, finish); }

}  // namespace gyrobudget::inline v0::cli

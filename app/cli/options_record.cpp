// SPDX-License-Identifier: MIT
// Options of the verbs that read records: allan and calibrate.
#include "gyrobudget/allan/estimator.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "options.h"
#include "values.h"

namespace gyrobudget::inline v0::cli {
namespace {

using noise::Term;

void add_estimators(App& app, Texts& texts) {
  auto* group = app.add_option_group("Estimator");
  group
      ->add_option(
          "--estimator", texts.estimators,
          "adev, oadev, mdev, tdev, hdev, ohdev, totdev, mtotdev, ttotdev, htotdev, theo1, theobr, theoh, pdev; several with commas; or all")
      ->type_name("NAME,...")
      ->capture_default_str();
  group
      ->add_option(
          "--stride", texts.stride,
          "terms begin at every sample (1), or every m/N samples: m/16 costs white noise 0.5 % of the degrees of freedom, m/4 8 %, m 56 %; below 8 samples it is taken as 1")
      ->type_name("1|m/N|m")
      ->capture_default_str();
}

void add_segments(App& app, Texts& texts, std::string_view use) {
  app.add_option_group("Segments")
      ->add_option("--segments", texts.gap,
                   fmt::format("cut each log where more than this is missing, or time goes back, and {}", use))
      ->type_name("GAP");
}

void add_views(App& app, Texts& texts) {
  auto* group = app.add_option_group("Other views, for --report and --json");
  group
      ->add_option(
          "--psd", texts.psd,
          "root of the two-sided power spectral density, deg/h/sqrt(Hz) for a gyro, by welch or multitaper (sine tapers)")
      ->check(IsMember{{"welch", "multitaper"}})
      ->type_name("METHOD");
  group->add_option("--dynamic", texts.window, "Allan deviation over time, of windows of this length")
      ->type_name("WINDOW");
}

void finish_views(AllanArguments& a, const Texts& texts) {
  if (!texts.psd.empty()) {
    a.psd = texts.psd == "welch" ? allan::SpectrumMethod::welch : allan::SpectrumMethod::multitaper;
  }
  if (!texts.window.empty()) a.dynamic_s = duration("--dynamic", texts.window);
  const std::string option = a.psd ? "--psd" : "--dynamic";
  if (!a.psd && !a.dynamic_s) return;
  if (!a.common.json && a.pictures.report.empty())
    throw std::invalid_argument(fmt::format("{} goes into --report FILE.html and --json; give one of them", option));
  if (!a.segments.empty()) throw std::invalid_argument(fmt::format("{} looks at one log", option));
  if (a.stream)
    throw std::invalid_argument(fmt::format("{} needs the whole log; leave out --stream and --follow", option));
}

void add_streaming(App& app, AllanArguments& a) {
  auto* group = app.add_option_group("Endless logs");
  group->add_flag("--stream", a.stream, "read in constant memory: oadev at octaves, terms every m/16 samples");
  group->add_flag(
      "--follow", a.follow,
      "the same, with a table while the log grows: each second on a terminal, else at each doubling; Ctrl-C prints the last one");
}

void check_stream(const AllanArguments& a, const Texts& texts, const std::string& default_taus) {
  const std::string option = a.follow ? "--follow" : "--stream";
  const auto refuse = [&](bool wrong, const std::string& what) {
    if (wrong) throw std::invalid_argument(fmt::format("{} {}", option, what));
  };
  refuse(!a.segments.empty(), "reads one log");
  refuse(a.gap_s.has_value(), "reads one segment; leave out --segments");
  refuse(a.curve.log.resample_hz.has_value(), "cannot resample; leave out --resample");
  refuse(a.curve.log.rows.has_value(), "reads every row; leave out --rows");
  refuse(!a.curve.log.with.empty(), "reads one log; leave out --with");
  refuse(a.curve.log.topic.has_value(), "reads text and raw numbers; leave out --topic");
  refuse(a.estimators != std::vector{allan::Estimator::oadev}, "knows the oadev only; leave out --estimator");
  refuse(texts.taus != "octave" && texts.taus != default_taus, "has octaves only; leave out --taus");
  refuse(texts.ieee, "counts n - 2m + 1 terms; leave out --ieee");
  refuse((a.overlap & (a.overlap - 1)) != 0, "needs a stride of m/N with N a power of two");
}

constexpr const char* kTaus = "50";

void finish(AllanArguments& a, const Texts& texts) {
  a.curve.log.path = texts.logs.front();
  a.segments.assign(texts.logs.begin() + 1, texts.logs.end());
  finish_log(a.curve, texts);
  if (!texts.gap.empty()) a.gap_s = duration("--segments", texts.gap);
  a.estimators = estimators(texts.estimators);
  a.overlap = overlap(texts.stride);
  a.stream = a.stream || a.follow;
  if (a.stream) check_stream(a, texts, kTaus);
  finish_views(a, texts);
  const bool full = a.estimators == std::vector{allan::Estimator::oadev} && a.overlap == 0;
  if (texts.ieee && !full) {
    throw std::invalid_argument(
        "--ieee counts the terms of the oadev at every sample; leave out --estimator and --stride");
  }
}

App* add_allan(App& app, AllanArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "allan",
      "Allan deviation of a log, with degrees of freedom and 95 % intervals.\n\n"
      "  gyrobudget allan imu.csv --plot allan.svg\n"
      "  gyrobudget allan counts.txt --rate 100 --unit deg/h --scale 0.1 --estimator oadev,mdev,totdev --json\n");
  verb->add_option("log", texts.logs,
                   "CSV or text, also .gz; - is stdin. Several are power-ups of one sensor, pooled into one curve")
      ->required()
      ->type_name("LOG ...");
  add_log(*verb, a.curve, texts);
  add_segments(*verb, texts, "pool the segments into one curve: power-ups, dropped data");
  add_curve(*verb, texts, kTaus);
  add_estimators(*verb, texts);
  add_views(*verb, texts);
  add_streaming(*verb, a);
  add_pictures(*verb, a.pictures);
  add_common(*verb, a.common);
  return verb;
}

App* add_inspect(App& app, InspectArguments& a, Texts&) {
  auto* verb = app.add_subcommand("inspect",
                                  "What is in a log of any format: streams, columns, units, clocks, what is odd.\n\n"
                                  "  gyrobudget inspect walk.bag\n");
  verb->add_option("log", a.log, "a recording (ROS bag, MCAP, ULog, dataflash, MAT, HDF5, npz), a text or a .npy")
      ->required()
      ->type_name("LOG");
  add_common(*verb, a.common);
  return verb;
}

void finish(InspectArguments&, const Texts&) {}

App* add_calibrate(App& app, CalibrateArguments& a, Texts& texts) {
  auto* verb = app.add_subcommand(
      "calibrate",
      "From a static log to the datasheet: ARW, bias instability and RRW with intervals and a verdict.\n\n"
      "  gyrobudget calibrate imu.csv --report datasheet.html -o sensor.yaml\n"
      "  gyrobudget calibrate gyro.txt --rate 200 --unit deg/s --kalibr imu.yaml\n");
  verb->footer(
      "Exit code 1: an axis has no answer, or none that may be used yet (a step, knocks or a drift that the fit took\n"
      "for noise: see --mask), or --cross-check disagrees. What there is is printed and written all the same; a sensor\n"
      "file then warns at its head, and whatever reads it repeats that.");
  verb->add_option(
          "log", a.logs,
          "CSV or text, also .gz; - is stdin; several: records of one sensor type, each fitted by itself, then combined")
      ->type_name("LOG ...");
  add_log(*verb, a.curve, texts);
  verb->get_option("--rate")->description(
      "sample rate, where the log has no time column; of the record behind --curve");
  auto* fit = verb->add_option_group("Fit");
  fit->add_option(
         "--terms", texts.terms,
         "terms to fit, of Q,N,B,K,R, G (one Gauss-Markov process) and S (one sinusoid); auto: those that the record holds, by likelihood ratios; G=120s and S=0.05Hz hold its correlation time and its frequency [N,B,K, and Q where the shortest taus show quantization]")
      ->type_name("LIST|auto");
  fit->add_option(
         "--method", texts.method,
         "gls: least squares with the exact covariance; edf: each tau's own variance; loglog: no weights; slope, visual: read off the plot, to compare; whittle: likelihood of the record")
      ->check(IsMember{{"gls", "edf", "loglog", "slope", "visual", "whittle"}})
      ->capture_default_str();
  fit->add_flag("--cross-check", a.options.cross_check,
                "fit the likelihood of the record too, and say whether the two agree");
  fit->add_option(
         "--mask", texts.mask,
         "leave out of the fit what is found in the record: outliers, steps (all but the longest part without one), warm-up, motion")
      ->delimiter(',')
      ->check(IsMember{{"outliers", "steps", "warm-up", "motion"}})
      ->type_name("outliers,steps,warm-up,motion");
  fit->add_option(
         "--front-end", texts.front_end,
         "low pass between the noise and the samples: first_order, second_order or moving_average, with its bandwidth where that is known (first_order:25Hz); none [auto: found where the record shows one]")
      ->type_name("KIND[:HZ]");
  fit->add_option("--tau-min", texts.tau_min, "shortest tau to fit [start of the longest run the model describes]")
      ->type_name("TIME");
  fit->add_option("--tau-max", texts.tau_max, "longest tau to fit [all]")->type_name("TIME");
  auto* table = verb->add_option_group("Curve table instead of a log");
  auto* file = table->add_option("--curve", a.curve_file, "table of tau and deviation (CSV with units in the header)")
                   ->type_name("FILE");
  file->excludes(verb->get_option("log"));
  table->add_option("--duration", texts.duration, "length of the record behind --curve")->type_name("TIME");
  add_segments(*verb, texts, "take the segments for records of one sensor type: power-ups");
  add_curve(*verb, texts, "50");
  auto* out = verb->add_option_group("Output");
  auto* sensor =
      out->add_option(
             "-o,--output", a.output,
             "write the sensor file; one that holds more than this log tells (turn-on bias, range ...) is not overwritten")
          ->type_name("SENSOR.yaml");
  out->add_flag("--update", a.update, "put the new coefficients into that file, and keep all else that it holds")
      ->needs(sensor);
  auto* kalibr =
      out->add_option(
             "--kalibr", a.kalibr,
             "write Kalibr's imu.yaml; a walk that is not resolved is its limit, or stands for bias instability")
          ->type_name("FILE.yaml");
  out->add_option(
         "--kalibr-horizon", texts.horizon,
         "over how long that walk stands for bias instability: as long as the estimator relies on a bias [100 s]")
      ->needs(kalibr)
      ->type_name("TIME");
  out->add_option("--name", a.name, "the sensor's name in these files [of the log; with --update the file's stays]");
  add_pictures(*verb, a.pictures);
  out->add_flag("--timing", a.timing, "with --json: how long each fit took, which differs from run to run");
  add_common(*verb, a.common);
  return verb;
}

void finish(CalibrateArguments& a, const Texts& texts) {
  finish_log(a.curve, texts);
  if (a.logs.empty() == a.curve_file.empty()) {
    throw std::invalid_argument(fmt::format("calibrate needs a log (or - for stdin), or a table with --curve{}",
                                            a.curve.log.columns.empty() ? "" : "; put the log before --column"));
  }
  for (auto log = a.logs.begin(); log != a.logs.end(); ++log) {
    if (std::find(a.logs.begin(), log, *log) == log) continue;
    throw std::invalid_argument(fmt::format("{} is given twice: one record counts once", *log));
  }
  if (!a.logs.empty()) a.curve.log.path = a.logs.front();
  const bool of_samples = texts.method == "whittle" || a.options.cross_check || !texts.mask.empty();
  if (of_samples && !a.curve_file.empty())
    throw std::invalid_argument("--method whittle, --cross-check and --mask need the log, not a table (--curve)");
  if (texts.terms == "auto") {
    a.options.choose_terms = true;
  } else if (!texts.terms.empty()) {
    const ShapedTerms given = shaped_terms(texts.terms);
    a.options.terms = given.terms;
    a.options.correlation_time_s = given.correlation_time_s;
    a.options.frequency_hz = given.frequency_hz;
  }
  const auto asked = [&](Term t) {
    return a.options.terms && std::ranges::find(*a.options.terms, t) != a.options.terms->end();
  };
  const bool open_time = asked(Term::gauss_markov) && !a.options.correlation_time_s;
  const bool open_frequency = asked(Term::sinusoid) && !a.options.frequency_hz;
  if (!a.curve_file.empty() && (a.options.choose_terms || open_time || open_frequency))
    throw std::invalid_argument(
        "--terms auto, and G and S of unknown time and frequency, need the log, not a table (--curve); for a table give them: --terms N,G=120s,S=0.05Hz");
  if (!texts.front_end.empty() && texts.front_end != "none" && texts.front_end != "auto") {
    if (texts.method != "gls" && texts.method != "whittle")
      throw std::invalid_argument("--front-end needs --method gls or whittle: the others fit the noise as it stands");
    if (!a.curve_file.empty() && !front_end(texts.front_end).bandwidth)
      throw std::invalid_argument("--front-end without a bandwidth needs the log, not a table (--curve)");
  }
  if (texts.front_end == "none") {
    a.options.find_front_end = false;
  } else if (!texts.front_end.empty() && texts.front_end != "auto") {
    const GivenFrontEnd given = front_end(texts.front_end);
    if (given.bandwidth)
      a.options.front_end = noise::FrontEnd{given.kind, *given.bandwidth};
    else
      a.options.front_end_kind = given.kind;
  }
  a.options.method = *std::find_if(fit::kMethods.begin(), fit::kMethods.end(),
                                   [&](fit::Method m) { return fit::name(m) == texts.method; });
  a.options.mask = masking(texts.mask);
  if (!texts.horizon.empty()) a.kalibr_horizon_s = duration("--kalibr-horizon", texts.horizon);
  if (!texts.tau_min.empty()) a.options.tau_min_s = duration("--tau-min", texts.tau_min);
  if (!texts.tau_max.empty()) a.options.tau_max_s = duration("--tau-max", texts.tau_max);
  if (!texts.duration.empty()) a.duration_s = duration("--duration", texts.duration);
  if (!texts.gap.empty()) a.gap_s = duration("--segments", texts.gap);
  if (a.gap_s && !a.curve_file.empty())
    throw std::invalid_argument("--segments cuts a log, and a table (--curve) has nothing to cut");
  if (!a.curve_file.empty() && (texts.ieee || texts.strict_gaps || a.curve.log.scale != 1 || texts.input != "rate")) {
    throw std::invalid_argument("--curve: --ieee, --strict-gaps, --scale and --input are about logs, not tables");
  }
  if (!a.curve_file.empty() && (!a.duration_s || !a.curve.log.rate_hz)) {
    throw std::invalid_argument(
        "--curve: the statistics need the record behind the table; give its --rate and --duration");
  }
}

}  // namespace

Verb inspect_verb(App& app) { return make_verb<InspectArguments>(app, add_inspect, finish); }
Verb allan_verb(App& app) { return make_verb<AllanArguments>(app, add_allan, finish); }
Verb calibrate_verb(App& app) { return make_verb<CalibrateArguments>(app, add_calibrate, finish); }

}  // namespace gyrobudget::inline v0::cli

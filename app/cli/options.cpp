// SPDX-License-Identifier: MIT
// Options that verbs share.
#include "options.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "values.h"

namespace gyrobudget::inline v0::cli {

void add_common(App& app, Common& common, bool has_json) {
  auto* group = app.add_option_group("Common");
  if (has_json) group->add_flag("--json", common.json, "one JSON object on stdout and nothing else");
  group->add_flag("-q,--quiet", common.quiet, "no messages on stderr");
  group->add_option("--threads", common.threads, "number of threads (all cores); the result does not depend on it")
      ->check(Range{0, 4096});
}

void add_pictures(App& app, Pictures& pictures) {
  auto* group = app.add_option_group("Pictures");
  group->add_option("--report", pictures.report, "write a self-contained HTML page")->type_name("FILE.html");
  group->add_option("--plot", pictures.plot, "write the figure")->type_name("FILE.svg|.png|.pdf");
}

void add_format(App& app, Texts& texts, const std::string& help) {
  app.add_option("--format", texts.format, help)->check(IsMember{{"csv", "f32", "f64", "npy"}})->type_name("FORMAT");
}

void add_log(App& app, CurveArguments& curve, Texts& texts) {
  auto* group = app.add_option_group("Log");
  group->add_option("--rate", texts.rate, "sample rate, where the log has no time column")->type_name("HZ");
  group->add_option(
      "--unit", curve.log.unit,
      "unit of the data columns without one in the header, e.g. deg/s, rad/s, deg/h, g; 1 is dimensionless");
  group->add_option("--input", texts.input, "what a sample is: rate, increment (angle per sample) or angle")
      ->check(IsMember{{"rate", "increment", "angle"}});
  group->add_option("--scale", curve.log.scale, "units per count");
  group->add_option("--column", curve.log.columns, "names or numbers (from 1) of the columns to use")
      ->type_name("NAME|N ...");
  group->add_option("--topic", curve.log.topic, "stream of a recording, as inspect names it [the only IMU]")
      ->type_name("NAME");
  group
      ->add_option(
          "--rows,--where", texts.rows,
          "read the rows that have this number or word in a column: those of one sensor where several wrote by turns")
      ->type_name("COLUMN=VALUE");
  group
      ->add_option(
          "--time", texts.time,
          "which column is the time, in s, ms, us, ns, iso (dates, times of day), gps (week+seconds), or counter (of samples); parts of it with +; none: there is none [found by names and numbers]")
      ->type_name("COLUMN[=UNIT]");
  group
      ->add_option(
          "--with", texts.with,
          "join these text logs by time: the accelerometer of a phone beside its gyro; UNIT where its header has none")
      ->type_name("LOG[=UNIT] ...");
  add_format(
      *group, texts,
      "csv, or binary: f32, f64 (raw, little-endian), npy; needs --rate and --unit [npy by the content, f32 and f64 by the ending]");
  group->add_option("--columns", curve.log.file_columns, "numbers a sample has in a raw binary log [1]")
      ->check(Range{1, 65536})
      ->type_name("K");
  group
      ->add_option(
          "--resample", texts.resample,
          "average readings at uneven times over even intervals of this rate; only where asked for, and it is said what that does to short taus")
      ->type_name("HZ");
  group->add_flag("--strict-gaps", texts.strict_gaps,
                  "use a cluster only where none of its samples is missing (else 95 %)");
}

void add_curve(App& app, Texts& texts, const std::string& default_taus) {
  texts.taus = default_taus;
  auto* group = app.add_option_group("Curve");
  group->add_option("--taus", texts.taus, "averaging times: octave, decade, all, or a number of log-spaced ones")
      ->type_name("octave|decade|all|N")
      ->capture_default_str();
  group->add_flag("--ieee", texts.ieee, "n - 2m terms as IEEE Std 952 and MATLAB count (else n - 2m + 1)");
}

void finish_log(CurveArguments& curve, const Texts& texts) {
  if (!texts.rate.empty()) curve.log.rate_hz = rate("--rate", texts.rate);
  if (!texts.rows.empty()) curve.log.rows = rows_of(texts.rows);
  if (!texts.time.empty()) curve.log.time = time_of(texts.time);
  for (const std::string& text : texts.with) curve.log.with.push_back(with_of(text));
  if (!texts.resample.empty()) curve.log.resample_hz = rate("--resample", texts.resample);
  curve.log.input = texts.input == "angle"       ? log::Input::angle
                    : texts.input == "increment" ? log::Input::increment
                                                 : log::Input::rate;
  if (!texts.format.empty()) curve.log.format = log::format_named(texts.format);
  if (curve.log.time && curve.log.time->unit == "counter" && !curve.log.rate_hz)
    throw std::invalid_argument("--time: a counter of samples needs their --rate");
  curve.taus = taus(texts.taus);
  curve.form = texts.ieee ? allan::Form::ieee : allan::Form::full;
  curve.minimum_fill = texts.strict_gaps ? 1 : allan::kMinimumFill;
  if (curve.log.scale == 0 || !std::isfinite(curve.log.scale)) {
    throw std::invalid_argument(fmt::format("--scale {}: must be a number other than 0", curve.log.scale));
  }
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
// export: sensor file -> the form of another tool.
#include "gyrobudget/app/report/sensor_words.h"
#include "gyrobudget/app/sensor_file/forms.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/app/text/output.h"

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {

int run(const ExportArguments& a) {
  check_outputs(a.sensor, {{"--output", a.output == "-" ? "" : a.output}});
  const sensor_file::SensorFile file = sensor_file::read_sensor_file(a.sensor, {.rate_hz = a.sensor_rate_hz});
  const std::string comment = "Made by: " + a.common.command_line;
  const std::string text = sensor_file::form_text(
      a.form, file.model, {.update_rate_hz = a.rate_hz, .horizon_s = a.horizon_s, .limits = {}, .comment = comment});
  for (const auto& note : report::sensor_notes(file.warnings, file.notes, a.sensor)) say(a.common, "note: " + note);
  if (a.output == "-")
    print(text);
  else
    text::write_file(a.output, text);
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

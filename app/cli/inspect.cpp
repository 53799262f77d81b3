// SPDX-License-Identifier: MIT
// inspect: log -> what is in it.
#include "gyrobudget/app/log/inspect.h"

#include "gyrobudget/app/report/inspection.h"

#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {

int run(const InspectArguments& a) {
  const report::InspectionResult result{.command = a.common.command_line, .log = log::inspect(a.log)};
  print(a.common.json ? report::inspection_json(result) : report::inspection_text(result));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

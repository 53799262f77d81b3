// SPDX-License-Identifier: MIT
// paper: tables and figures of the source paper beside ours.
#include "gyrobudget/app/report/paper.h"

#include "gyrobudget/app/paper/study.h"

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {

int run(const PaperArguments& a) {
  check_outputs("", {{"--report", a.report}});
  say(a.common, "simulating four records of 10 h at 100 Hz and some 300 flights; this takes some seconds");
  report::Paper paper = paper::paper_study(a.seed);
  paper.command = a.common.command_line;
  print(a.common.json ? report::paper_json(paper) : report::paper_table(paper));
  if (!a.report.empty()) write_page(a.report, report::paper_page(paper), a.common);
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
// The program gyrobudget: reads the command line, runs one verb, turns exceptions into exit codes.
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/app/text/output.h"

#include <tbb/global_control.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>

#include "terminal.h"
#include "verbs.h"

namespace cli = gyrobudget::cli;
namespace text = gyrobudget::text;

namespace {

void interrupted(int) {
  if (cli::taken_by_interruption()) return;
  text::remove_unfinished_outputs();
  _exit(cli::exit_interrupted);
}

int complain(const char* message, int code) {
  std::fprintf(stderr, "gyrobudget: %s\n", message);
  return code;
}

int run(const cli::Arguments& arguments) {
  if (const auto* answered = std::get_if<cli::Answered>(&arguments)) return answered->exit_code;
  return std::visit(
      [](const auto& a) -> int {
        if constexpr (std::is_same_v<decltype(a), const cli::Answered&>) {
          return a.exit_code;
        } else {
          const auto threads = static_cast<std::size_t>(a.common.threads);
          const tbb::global_control limit(
              tbb::global_control::max_allowed_parallelism,
              threads > 0 ? threads : tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
          return cli::run(a);
        }
      },
      arguments);
}

}  // namespace

int main(int argc, char** argv) {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, interrupted);
  if (std::signal(SIGHUP, interrupted) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // nohup
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);       // output errors like any other
  try {
    return run(cli::parse_arguments(argc, argv));
  } catch (const text::InputError& error) {
    return complain(error.what(), cli::exit_bad_input);
  } catch (const text::OutputError& error) {
    return complain(error.what(), cli::exit_bad_output);
  } catch (const std::invalid_argument& error) {
    return complain(error.what(), cli::exit_usage);
  } catch (const std::bad_alloc&) {
    return complain("out of memory: the log has more numbers than fit; use fewer columns (--column) or a shorter part",
                    cli::exit_bad_input);
  } catch (const std::exception& error) {
    return complain(error.what(), cli::exit_no_answer);
  }
}

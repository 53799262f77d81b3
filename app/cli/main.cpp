// SPDX-License-Identifier: MIT
// The program gyrobudget: reads the command line, runs one verb, turns exceptions into exit codes.
#include "gyrobudget/app/text/error.h"
#include "gyrobudget/app/text/output.h"

#include <tbb/global_control.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

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
  cli::complain(std::string("gyrobudget: ") + message);
  return code;
}

/// How many threads there can be at once, up to `wanted`: this one, and those that the system gives beside it.
std::size_t threads_to_have(std::size_t wanted) {
  std::atomic<bool> done{false};
  std::vector<std::thread> others;
  try {
    while (others.size() + 1 < wanted) others.emplace_back([&] { done.wait(false); });
  } catch (const std::exception&) {  // no thread, or no memory for one
  }
  done = true;
  done.notify_all();
  for (std::thread& other : others) other.join();
  return others.size() + 1;
}

/// For the whole run: TBB asks for the threads that it may have, and ends the program where it does not get them, even
/// when a limit ends. @param asked  0 for all cores
void limit_threads(std::size_t asked) {
  using tbb::global_control;
  const auto limit = global_control::max_allowed_parallelism;
  const std::size_t wanted = asked > 0 ? asked : global_control::active_value(limit);
  static const auto* const kept = new global_control(limit, threads_to_have(wanted));
  static_cast<void>(kept);
}

int run(const cli::Arguments& arguments) {
  if (const auto* answered = std::get_if<cli::Answered>(&arguments)) return answered->exit_code;
  return std::visit(
      [](const auto& a) -> int {
        if constexpr (std::is_same_v<decltype(a), const cli::Answered&>) {
          return a.exit_code;
        } else {
          limit_threads(static_cast<std::size_t>(a.common.threads));
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

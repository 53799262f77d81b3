// SPDX-License-Identifier: MIT
// simulate: sensor file -> log of simulated noise at rest.
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/report/sensor_words.h"
#include "gyrobudget/app/report/simulation.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/noise/simulation.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <cmath>
#include <stdexcept>

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

void require_whole_record(const SimulateArguments& a, const noise::Simulation& simulation) {
  constexpr const char* kStreamingModels = "--model gauss-markov, 1, 2 and 3 make it in constant memory";
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(fmt::format("{}; {}", what, kStreamingModels));
  };
  if (std::isinf(a.duration_s)) refuse("--duration endless: --model spectral makes whole records");
  if (a.skipped > 0) refuse("--skip: --model spectral makes whole records and cannot start later");
  constexpr double kGigabyte = 1e9;
  const double needed = simulation.bytes_of_records();
  const double present = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (needed <= present) return;
  refuse(fmt::format(
      "{:.3g} samples of {} columns by --model spectral need {:.3g} GB of memory, this machine has {:.3g} GB",
      a.duration_s * a.rate_hz, simulation.axes().size(), needed / kGigabyte, present / kGigabyte));
}

// Of each sample of a whole record.
std::vector<double> temperatures(const noise::Simulation& simulation) {
  std::vector<double> list(simulation.samples());
  simulation.temperatures(0, list);
  return list;
}

void write_whole(const SimulateArguments& a, const noise::Simulation& simulation, const log::LogHead& head) {
  require_whole_record(a, simulation);
  std::vector<log::LogColumn> columns;
  for (std::size_t i = 0; i < head.columns.size(); ++i) {
    columns.push_back({head.columns[i].name, head.columns[i].unit,
                       i < simulation.axes().size() ? simulation.record(i) : temperatures(simulation)});
  }
  log::write_log(a.output, columns, head.rate_hz, head.comment, head.format);
}

// Rows are made while they are written.
void write_stream(const SimulateArguments& a, const noise::Simulation& simulation, const log::LogHead& head) {
  std::vector<noise::Generator> sources;
  for (std::size_t i = 0; i < simulation.axes().size(); ++i) sources.push_back(simulation.generator(i));
  const auto all = [&](const auto& what) { tbb::parallel_for(std::size_t{0}, sources.size(), what); };
  all([&](std::size_t i) { sources[i].skip(a.skipped); });
  std::uint64_t at = a.skipped;
  log::write_log(a.output, head, simulation.samples() - a.skipped, [&](std::span<const std::span<double>> out) {
    all([&](std::size_t i) {
      sources[i].next(out[i]);
      simulation.add_temperature(i, at, out[i]);
    });
    if (out.size() > sources.size()) simulation.temperatures(at, out.back());
    at += out.front().size();
  });
}

}  // namespace

int run(const SimulateArguments& a) {
  if (a.flight) return run_flight(a);
  if (a.output != "-") check_outputs(a.sensor, {{"-o", a.output}});
  const sensor_file::SensorFile file = sensor_file::read_sensor_file(a.sensor, {.rate_hz = a.sensor_rate_hz});
  const noise::SensorModel& sensor = file.model;
  for (const auto& note : report::sensor_notes(file.warnings, file.notes, a.sensor)) say(a.common, "note: " + note);
  for (const auto& note : report::left_out_notes(a.model, sensor, a.model_name)) say(a.common, note);
  const noise::Simulation simulation(sensor, {a.model, a.rate_hz, a.duration_s, a.seed, a.axes, a.temperature});
  const log::LogHead head =
      report::rest_head(simulation, sensor.name, a.model_name, a.unit.empty() ? "rad/s" : a.unit, a.skipped, a.format);
  simulation.streams() ? write_stream(a, simulation, head) : write_whole(a, simulation, head);
  say(a.common, fmt::format("simulated {} samples of {} axes at {} Hz ({} model, seed {}){}",
                            simulation.samples() - a.skipped, simulation.axes().size(), a.rate_hz, a.model_name, a.seed,
                            a.output == "-" ? "" : " into " + a.output));
  if (a.format != log::Format::csv) say(a.common, report::how_to_read(head));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
// simulate: sensor file -> log of simulated noise at rest.
#include "gyrobudget/app/log/log_writer.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/noise/bielas.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/imu_sensor.h"
#include "gyrobudget/noise/jerath.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "paths.h"
#include "terminal.h"
#include "verbs.h"

namespace gyrobudget::inline v0::cli {
namespace {

using Model = SimulateArguments::Model;
using noise::Term;

/// One column of the log and what fills it.
struct Channel {
  log::LogHead::Column column;
  noise::Model model;
  noise::StreamKey key;
};

// Streams of random numbers: gyro axes are 0, 1, 2 whatever subset is asked for, accelerometer axes 3, 4, 5.
std::uint64_t stream_of(const std::string& axis, bool accelerometer) {
  return static_cast<std::uint64_t>(axis.front() - 'x') + (accelerometer ? 3U : 0U);
}

noise::Model jerath(const SimulateArguments& a, const noise::ErrorModel& errors, double dt) {
  noise::Jerath model{.arw = errors.white, .bias_instability = errors.bias_instability, .rrw = errors.rate_random_walk};
  if (a.taps) model.taps = *a.taps;
  return model.model(dt);
}

noise::Model imu_sensor(const SimulateArguments& a, const noise::ErrorModel& errors, double dt) {
  using NoiseType = noise::ImuSensor::NoiseType;
  noise::ImuSensor model{.noise_density = {errors.white, 0, 0},
                         .bias_instability = {errors.bias_instability, 0, 0},
                         .random_walk = {errors.rate_random_walk, 0, 0},
                         .noise_type = a.single_sided ? NoiseType::single_sided : NoiseType::double_sided};
  if (a.taps) model.bias_instability_coefficients = noise::fractal_coefficients(*a.taps);
  return model.model(0, dt);
}

noise::Model bielas(const SimulateArguments& a, const noise::ErrorModel& errors, double dt) {
  const bool walks = a.rate_random_walk.value_or(a.variant != noise::Bielas::Bias::integrated_legacy);
  return noise::Bielas{.arw = errors.white,
                       .bias_instability = errors.bias_instability,
                       .rrw = walks ? errors.rate_random_walk : 0,
                       .bias = a.variant,
                       .correlation_time = a.correlation_time_s}
      .model(dt);
}

noise::Model model_of(const SimulateArguments& a, const noise::ErrorModel& errors) {
  const double dt = 1 / a.rate_hz;
  switch (a.model) {
    case Model::jerath:
      return jerath(a, errors, dt);
    case Model::imu_sensor:
      return imu_sensor(a, errors, dt);
    case Model::bielas:
      return bielas(a, errors, dt);
    case Model::spectral:
    case Model::gauss_markov:
      break;
  }
  return {errors.processes(), {}};
}

// Models 1 to 3 know N, B and K; what else the sensor has they leave out.
void say_what_is_left_out(const SimulateArguments& a, const noise::ErrorModel& errors) {
  if (a.model == Model::spectral || a.model == Model::gauss_markov) return;
  for (const auto& process : errors.processes()) {
    const Term term = noise::term(process);
    if (term == Term::white || term == Term::flicker || term == Term::rate_random_walk) continue;
    say(a.common, fmt::format("note: model {} has no {}; it is left out", a.model_name,
                              noise::label(noise::Signal::angular_rate, term)));
  }
}

std::vector<Channel> channels(const SimulateArguments& a, const noise::SensorModel& sensor) {
  std::vector<Channel> list;
  const auto add = [&](const noise::ErrorModel& errors, bool accelerometer, const std::string& unit) {
    say_what_is_left_out(a, errors);
    for (const auto& axis : a.axes) {
      list.push_back({{fmt::format("{}_{}", accelerometer ? "accel" : "gyro", axis), unit},
                      model_of(a, errors),
                      {a.seed, stream_of(axis, accelerometer)}});
    }
  };
  add(sensor.gyro, false, a.unit.empty() ? "rad/s" : a.unit);
  if (sensor.accelerometer) add(*sensor.accelerometer, true, "m/s^2");
  return list;
}

std::uint64_t sample_count(const SimulateArguments& a) {
  if (std::isinf(a.duration_s)) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(std::llround(a.duration_s * a.rate_hz));
}

// --- The exact generator: whole records -----------------------------------------------------------------------------

constexpr const char* kStreamingModels = "--model gauss-markov, 1, 2 and 3 make it in constant memory";

double spectral_bytes(const std::vector<Channel>& list, std::uint64_t samples) {
  constexpr double kTransform = 11;  // numbers a sample while 1/f noise is made, see RecordGenerator
  const bool flicker = std::ranges::any_of(list, [](const Channel& c) {
    return std::ranges::any_of(c.model.processes, [](const auto& p) { return noise::term(p) == Term::flicker; });
  });
  const double numbers = static_cast<double>(list.size()) + (flicker ? kTransform : 0);
  return numbers * sizeof(double) * static_cast<double>(samples);
}

void require_whole_record(const SimulateArguments& a, const std::vector<Channel>& list) {
  if (std::isinf(a.duration_s)) {
    throw std::invalid_argument(
        fmt::format("--duration endless: --model spectral makes whole records; {}", kStreamingModels));
  }
  if (a.skipped > 0) {
    throw std::invalid_argument(
        fmt::format("--skip: --model spectral makes whole records and cannot start later; {}", kStreamingModels));
  }
  constexpr double kGigabyte = 1e9;
  const double needed = spectral_bytes(list, sample_count(a));
  const double present = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  if (needed <= present) return;
  throw std::invalid_argument(fmt::format(
      "{:.3g} samples of {} columns by --model spectral need {:.3g} GB of memory, this machine has {:.3g} GB; {}",
      a.duration_s * a.rate_hz, list.size(), needed / kGigabyte, present / kGigabyte, kStreamingModels));
}

void write_whole(const SimulateArguments& a, const std::vector<Channel>& list, const log::LogHead& head) {
  require_whole_record(a, list);
  std::vector<log::LogColumn> columns;
  for (const Channel& c : list) {
    columns.push_back(
        {c.column.name, c.column.unit,
         noise::generate_record(c.model.processes, static_cast<std::int64_t>(sample_count(a)), 1 / a.rate_hz, c.key)});
  }
  log::write_log(a.output, columns, a.rate_hz, head.comment, head.format);
}

// --- The others: rows are made while they are written -----------------------------------------------------------------

std::vector<noise::Generator> generators(const SimulateArguments& a, const std::vector<Channel>& list) {
  const double dt = 1 / a.rate_hz;
  std::vector<noise::Generator> result;
  for (const Channel& c : list) {
    noise::Generator::Options options{.key = c.key};
    // An endless log keeps its 1/f noise to the default's end of the band.
    if (std::isfinite(a.duration_s)) options.longest_tau = std::max(a.duration_s, 10 * dt);
    result.emplace_back(c.model.processes, c.model.filters, dt, options);
  }
  return result;
}

void write_stream(const SimulateArguments& a, const std::vector<Channel>& list, const log::LogHead& head) {
  auto sources = generators(a, list);
  tbb::parallel_for(std::size_t{0}, sources.size(), [&](std::size_t i) { sources[i].skip(a.skipped); });
  log::write_log(a.output, head, sample_count(a) - a.skipped, [&](std::span<const std::span<double>> out) {
    tbb::parallel_for(std::size_t{0}, sources.size(), [&](std::size_t i) { sources[i].next(out[i]); });
  });
}

std::string comment(const SimulateArguments& a, const noise::SensorModel& sensor) {
  const std::string length = std::isinf(a.duration_s) ? "endless" : fmt::format("{} s", a.duration_s);
  return fmt::format("gyrobudget simulate: sensor {}, model {}, seed {}, {} Hz, {}{}", sensor.name, a.model_name,
                     a.seed, a.rate_hz, length,
                     a.skipped > 0 ? fmt::format(", without the first {} samples", a.skipped) : "");
}

// A binary log does not say what it holds.
std::string how_to_read(const SimulateArguments& a, const log::LogHead& head) {
  std::string columns;
  for (const auto& c : head.columns) {
    columns += fmt::format("{}{} ({})", columns.empty() ? "" : ", ", c.name, c.unit);
  }
  return fmt::format("each sample is {}; read it with --format {} --rate {} --unit {}{}", columns, log::name(a.format),
                     a.rate_hz, head.columns.front().unit,
                     a.format == log::Format::npy || head.columns.size() == 1
                         ? ""
                         : fmt::format(" --columns {}", head.columns.size()));
}

}  // namespace

int run(const SimulateArguments& a) {
  if (a.flight) return run_flight(a);
  if (a.output != "-") check_outputs(a.sensor, {{"-o", a.output}});
  const noise::SensorModel sensor = sensor_file::read_sensor(a.sensor);
  const auto list = channels(a, sensor);
  log::LogHead head{{}, a.rate_hz, comment(a, sensor), a.skipped, a.format};
  for (const Channel& c : list) head.columns.push_back(c.column);
  if (a.model == Model::spectral) {
    write_whole(a, list, head);
  } else {
    write_stream(a, list, head);
  }
  say(a.common,
      fmt::format("simulated {} samples of {} axes at {} Hz ({} model, seed {}){}", sample_count(a) - a.skipped,
                  list.size(), a.rate_hz, a.model_name, a.seed, a.output == "-" ? "" : " into " + a.output));
  if (a.format != log::Format::csv) say(a.common, how_to_read(a, head));
  return exit_done;
}

}  // namespace gyrobudget::inline v0::cli

// SPDX-License-Identifier: MIT
#include "entries.h"

#include "gyrobudget/app/files/scene_file.h"
#include "gyrobudget/app/files/vehicle_file.h"
#include "gyrobudget/app/log/compression.h"
#include "gyrobudget/app/log/curve_table.h"
#include "gyrobudget/app/log/formats/rosbag2.h"
#include "gyrobudget/app/log/recording.h"
#include "gyrobudget/app/sensor_file/sensor_file.h"
#include "gyrobudget/noise/units.h"

#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#if GYROBUDGET_HAS_SQLITE
#include <sqlite3.h>
#endif

#include <cmath>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "../app/log/recording_writer.h"
#include "memory_file.h"

namespace gyrobudget::fuzz {
namespace {

// --- Recordings -----------------------------------------------------------------------------------------------------

/// Every stream of a recording, with all of its fields.
void check(const log::Recording& recording) {
  for (std::size_t i = 0; i < recording.streams().size(); ++i) {
    const log::StreamInfo& info = recording.streams()[i];
    promise(info.count >= 0, "fewer rows than none");
    std::vector<std::size_t> fields(info.fields.size());
    for (std::size_t k = 0; k < fields.size(); ++k) fields[k] = k;
    try {
      const log::Rows rows = recording.read(i, fields);
      promise(rows.columns.size() == fields.size(), "a column is missing");
      promise(rows.clock.empty() == rows.stamps_ns.empty() || !rows.clock.empty(), "stamps without a clock");
      for (const auto& column : rows.columns) {
        promise(column.size() == rows.stamps_ns.size(), "a column has another length than the stamps");
        for (const double value : column) promise(!std::isinf(value), "an infinite number");
      }
    } catch (const text::InputError& error) {
      promise(error.what()[0] != '\0', "an error without a message");
    }
  }
}

/// Reads the bytes as a recording, whatever they are.
void read_recording(std::string_view bytes) {
  const MemoryFile file(bytes);
  try {
    const auto recording = log::open_recording(file.path());
    // Packed bytes are told by what they unpack to, whatever lies in them as they are.
    promise(recording || log::compression_of(bytes) != log::Compression::none || log::recorded_format(bytes).empty(),
            "what is recognised is not opened");
    if (recording) check(*recording);
  } catch (const text::InputError& error) {
    promise(!std::string_view(error.what()).empty(), "an error without a message");
  }
}

/// SQLite opens files by their names alone.
void read_database(std::string_view bytes) {
  std::string path = (std::filesystem::temp_directory_path() / "gyrobudget-fuzz-XXXXXX").string();
  const int descriptor = ::mkstemp(path.data());
  const bool written = ::write(descriptor, bytes.data(), bytes.size()) == ssize_t(bytes.size());
  ::close(descriptor);
  std::exception_ptr fault;
  try {
    promise(written, "no temporary file");
    if (const auto recording = log::open_recording(path)) check(*recording);
  } catch (const text::InputError&) {
  } catch (...) {
    fault = std::current_exception();
  }
  std::filesystem::remove(path);
  if (fault) std::rethrow_exception(fault);
}

void read_metadata(std::string_view bytes) {
  const auto files = log::rosbag2_files(bytes);
  if (!files) return;
  for (const std::string& file : *files) promise(file.size() <= bytes.size(), "a name is longer than the text");
}

std::string bag_seed(const std::string& how, bool is_closed) {
  using namespace recording_writer;
  BagWriter bag;
  bag.connection(0, "/imu", "sensor_msgs/Imu");
  for (std::uint32_t i = 0; i < 3; ++i) bag.message(0, {i, 1}, ros1_imu({i, 0}, imu_numbers(1)));
  bag.end_chunk(how);
  bag.connection(1, "/fix", "sensor_msgs/NavSatFix");
  bag.message(1, {9, 0}, ros1_fix({9, 0}, {}));
  bag.end_chunk(how);
  return is_closed ? bag.closed() : bag.killed();
}

std::string mcap_seed(const std::string& how, bool is_closed) {
  using namespace recording_writer;
  McapWriter mcap;
  mcap.declare(mcap_schema(1, "sensor_msgs/msg/Imu"));
  mcap.declare(mcap_channel(1, 1, "/imu", "cdr"));
  mcap.loose(mcap_schema(2, "sensor_msgs/NavSatFix") + mcap_channel(2, 2, "/fix", "ros1"));
  for (std::uint32_t i = 0; i < 3; ++i) mcap.message(1, i, Cdr{i == 1, i == 2}.imu({i, 0}, imu_numbers(1)));
  mcap.end_chunk(how);
  mcap.loose_message(2, 7, ros1_fix({9, 0}, {}));
  return is_closed ? mcap.closed() : mcap.cut();
}

std::string database_seed() {
#if GYROBUDGET_HAS_SQLITE
  sqlite3* database = nullptr;
  sqlite3_open(":memory:", &database);
  sqlite3_exec(
      database,
      "PRAGMA page_size = 512; CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT); CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB); INSERT INTO topics VALUES(1, '/imu', 'sensor_msgs/msg/Imu', 'cdr'); INSERT INTO messages VALUES(1, 1, 5, zeroblob(324)), (2, 1, 6, zeroblob(2000)), (3, 2, 7, x'0001')",
      nullptr, nullptr, nullptr);
  sqlite3_int64 size = 0;
  unsigned char* bytes = sqlite3_serialize(database, "main", &size, 0);
  const std::string seed(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
  sqlite3_free(bytes);
  sqlite3_close(database);
  return seed;
#else
  return std::string("SQLite format 3\0", 16);
#endif
}

// --- The others -----------------------------------------------------------------------------------------------------

void read_sensor(std::string_view bytes) {
  const MemoryFile file(bytes);
  noise::SensorModel sensor;
  try {
    sensor = sensor_file::read_sensor(file.path());
  } catch (const text::InputError&) {
    return;
  }
  // What was read can be written, and what is written can be read.
  const std::string text = sensor_file::sensor_yaml(sensor);
  const MemoryFile written(text);
  promise(sensor_file::sensor_yaml(sensor_file::read_sensor(written.path())) == text,
          "a sensor file does not come back");
}

void read_curve(std::string_view bytes) {
  if (bytes.empty()) return;
  const MemoryFile file(bytes.substr(1));
  log::CurveOptions options{.path = file.path()};
  if (bytes.front() & 1) options.unit = "deg/h";
  if (bytes.front() & 2) options.columns = {"2"};
  try {
    const allan::DeviationTable table = log::read_curve(options);
    promise(!table.columns.empty(), "a table without columns");
    for (std::size_t i = 0; i < table.tau_s.size(); ++i) {
      promise(table.tau_s[i] > (i == 0 ? 0 : table.tau_s[i - 1]), "taus do not ascend");
    }
    for (const auto& column : table.columns) {
      promise(column.deviation.size() == table.tau_s.size(), "a column has another length");
    }
  } catch (const text::InputError&) {
  }
}

// Alone: what a scene names beside itself is not there.
void read_scene(std::string_view bytes) {
  const MemoryFile file(bytes);
  try {
    const files::SceneFile scene = files::read_scene(file.path());
    promise(scene.aids.size() == scene.scenario.aids.size(), "an aid without its source");
    promise(scene.imu || !scene.trajectory.empty(), "nothing moves");
    for (const auto& aid : scene.scenario.aids) {
      for (int i = 0; i < navigation::rows(aid.kind); ++i) promise(aid.sigma[i] > 0, "a sigma is not above 0");
    }
    for (const std::size_t aid : scene.scenario.reference)
      promise(aid < scene.scenario.aids.size(), "a reference that there is not");
  } catch (const text::InputError&) {
  }
}

// Alone: what it is based on is not there.
void read_vehicle(std::string_view bytes) {
  const MemoryFile file(bytes);
  try {
    const files::VehicleFile read = files::read_vehicle(file.path());
    read.vehicle.check();
    promise(!read.numbers.empty(), "a vehicle without numbers");
    for (const files::VehicleNumber& n : read.numbers)
      promise(n.origin.has_value() == !n.reason.empty(), "an origin without its reason");
  } catch (const text::InputError&) {
  }
}

void parse_unit(std::string_view bytes) {
  try {
    const noise::Unit unit = noise::parse_unit(bytes);
    promise(std::isfinite(unit.to_si) && unit.to_si > 0, "the factor of a unit is none");
  } catch (const std::invalid_argument&) {
  }
  try {
    promise(std::isfinite(noise::parse_quantity(bytes, noise::dimension::kTime)), "a quantity is not finite");
  } catch (const std::invalid_argument&) {
  }
}

const std::vector<Entry>& other_entries() {
  static const std::vector<Entry> kEntries = {
      {"bag",
       read_recording,
       {bag_seed("none", true), bag_seed("none", false), bag_seed("lz4", true), bag_seed("bz2", false)}},
      {"mcap",
       read_recording,
       {mcap_seed("", true), mcap_seed("", false), mcap_seed("lz4", true), mcap_seed("zstd", true),
        recording_writer::pack("zstd", mcap_seed("", true))}},
      {"rosbag2", read_database, {database_seed()}},
      {"metadata",
       read_metadata,
       {"rosbag2_bagfile_information:\n  version: 5\n  relative_file_paths:\n    - \"a_0.db3\"\n    - 'b''c'\n  x: 1\n",
        "rosbag2_bagfile_information:\n  relative_file_paths: [a_0.db3, \"b\\\"c\"]\n"}},
      {"sensor",
       read_sensor,
       {"name: IFOG\ngyro:\n  arw: 5.4e-4 deg/sqrt(h)\n  bias_instability: 1.7e-3 deg/h\n  rrw: 4.32e-2 deg/h/sqrt(h)\n"
        "  gauss_markov: [{sigma: 0.1 deg/h, correlation_time: 300 s}]\n"
        "  sinusoid: [{amplitude: 2 deg/h, frequency: 50 mHz, phase: 0 deg}]\naccelerometer:\n  vrw: 0.05 m/s/sqrt(h)\n",
        "%YAML:1.0\n---\nimu0:\n  accelerometer_noise_density: 2.0e-3\n  gyroscope_noise_density: 1.7e-4\n"
        "  accelerometer_random_walk: 3e-3\n  gyroscope_random_walk: 1.9e-5\n  update_rate: 200.0\n",
        "gyr_n: 0.004\ngyr_w: 2.0e-6\nacc_n: 0.08\nacc_w: 0.00004\n",
        "type: IMU\nGyr:\n  unit: \" rad/s\"\n  avg-axis:\n    gyr_n: 1.8e-3\n    gyr_w: 2.5e-5\n"}},
      {"curve",
       read_curve,
       {with_options(0, "tau (s),adev (deg/h),lower (deg/h)\n0.01,90,80\n0.02,64.5,60\n0.04,45,40\n"),
        with_options(1, "tau adev\n1 2e-3\n2 1.5e-3\n4 1e-3\n"),
        with_options(3, "tau_s;x;y\n0,1;1,5;2\n0,2;1,25;3\n")}},
      {"scene",
       read_scene,
       {"site: alcantara\nimu: {file: a.csv, axes: [y, x, -z], columns: {gyro_x: gx (0.1 arcsec)}}\nalignment: {position_sigma: [1 m, 1 m, 2 m], velocity_sigma: 1 cm/s, attitude: self, duration: 5 min}\naids:\n  gnss: {file: g.csv, position: {sigma: 2 m, correlated: {sigma: 1 m, time: 5 min}}, velocity: 5 cm/s, outages: [[1 s, 2 s]]}\n  pad: {rest: 5 mm/s}\nreference: gnss\n",
        "site: {latitude: -2 deg, longitude: 3 deg, height: 0 m}\ntrajectory: ascent:duration=50\nfilter: {form: joseph, gate: 1e-6, order: 4}\nsolution: {rate: 10 Hz, at: [83 s]}\nuntil: 20 min\n",
        "imu: {file: -}\nalignment: {position: ins, velocity: ins, attitude: {heading: 3 deg}, level_sigma: 1 deg, heading_sigma: 1 deg, velocity_sigma: 1 m/s}\naids: {ins: {file: a, position: 1 m, attitude: {sigma: 1 deg, bias_sigma: 1 deg}}}\n"}},
      {"vehicle",
       read_vehicle,
       {std::string(files::vehicle_help()),
        "lift_off_mass: {value: 28 t, origin: sourced, reason: published}\npropellant: 12 t\nburn_time: 83 s\nspecific_impulse: 277 s\ncentre_of_mass: [[0, 7 m], [1, 10 m]]\nroll_inertia: 7e3 kg m^2\npitch_inertia: {points: [[0, 4e5 kg m^2], [0.5, 3e5 kg m^2], [1, 2e5 kg m^2]], interpolation: smooth}\nbending: none\n"}},
      {"unit",
       parse_unit,
       {"deg/sqrt(h)", "rad s^-1", "m/s^2/sqrt(Hz)", "\xc2\xb0/h/\xe2\x88\x9ah", "ug*s^(1/2)", "5.4e-4 deg/sqrt(h)",
        "300 s", "1.5 h^1/2", "(((m)))", "mrad/s", "1", "%"}}};
  return kEntries;
}

}  // namespace

const std::vector<Entry>& entries() {
  static const std::vector<Entry> kEntries = [] {
    std::vector<Entry> all = log_entries();
    for (const auto& more : {recording_entries(), other_entries(), motion_entries()})
      all.insert(all.end(), more.begin(), more.end());
    return all;
  }();
  return kEntries;
}

}  // namespace gyrobudget::fuzz

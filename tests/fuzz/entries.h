// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace gyrobudget::fuzz {

/// A reader of what strangers write. It takes any bytes: what the reader documents to throw is caught, anything else
/// leaves, and a result that breaks a promise of the reader throws std::logic_error.
struct Entry {
  std::string name;
  std::function<void(std::string_view bytes)> run;
  std::vector<std::string> seeds;  ///< inputs near which faults are likely
  int mutants = 2000;              ///< of each seed, in the ordinary suite: fewer where one costs much
};

/// What a reader promises of its results. @throws std::logic_error where it does not keep it
inline void promise(bool kept, const char* what) {
  if (!kept) throw std::logic_error(what);
}

/// The first byte chooses the options, so that a fuzzer reaches them.
[[nodiscard]] inline std::string with_options(int choice, std::string_view text) {
  return static_cast<char>(choice) + std::string(text);
}

/// All of them: the three lists below, sensor files, scenes, vehicles, tables of deviations, units, recordings of ROS.
[[nodiscard]] const std::vector<Entry>& entries();

/// Logs: text and binary, clocks, whole, in segments, resampled, as a stream, through a pipe.
[[nodiscard]] std::vector<Entry> log_entries();
/// Logs of autopilots, arrays, HDF5, and packed ones.
[[nodiscard]] std::vector<Entry> recording_entries();
/// What moves: trajectories, the logs that a scene names, the flight of a scene.
[[nodiscard]] std::vector<Entry> motion_entries();

}  // namespace gyrobudget::fuzz

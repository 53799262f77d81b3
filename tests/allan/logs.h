// SPDX-License-Identifier: MIT
// Reading the public logs and tables of the data folder (see its README for provenance).
#pragma once

#include <gtest/gtest.h>

#include <zlib.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace gyrobudget::allan {

using Columns = std::vector<std::vector<double>>;
using Rows = std::vector<std::map<std::string, std::string>>;

/// That `value` prints as `published` with `digits` significant digits.
inline void expect_printed(double value, double published, int digits) {
  const double unit = std::pow(10, std::floor(std::log10(published)) - digits + 1);
  EXPECT_NEAR(value, published, 0.501 * unit);
}

inline std::string path(const std::string& name) { return GYROBUDGET_DATA "/" + name; }

#define SKIP_WITHOUT(name) \
  if (!std::filesystem::exists(path(name))) GTEST_SKIP() << "no " << path(name) << "; set GYROBUDGET_DATA"

/// Numbers of a gzipped CSV with one header line, by column.
inline Columns read_columns(const std::string& name) {
  Columns columns;
  const gzFile file = gzopen(path(name).c_str(), "rb");
  constexpr int kLine = 4096;
  char line[kLine];
  gzgets(file, line, kLine);
  while (gzgets(file, line, kLine) != nullptr) {
    char* at = line;
    for (std::size_t c = 0;; ++c) {
      if (c == columns.size()) columns.emplace_back();
      columns[c].push_back(std::strtod(at, &at));
      if (*at++ != ',') break;
    }
  }
  gzclose(file);
  return columns;
}

inline Rows read_table(const std::string& name) {
  const auto split = [](const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
  };
  std::ifstream file(path(name));
  std::string line;
  std::getline(file, line);
  const auto header = split(line);
  Rows rows;
  while (std::getline(file, line)) {
    const auto fields = split(line);
    for (std::size_t c = 0; c < header.size() && c < fields.size(); ++c) {
      if (c == 0) rows.emplace_back();
      rows.back()[header[c]] = fields[c];
    }
  }
  return rows;
}

inline double number(const std::map<std::string, std::string>& row, const char* key) { return std::stod(row.at(key)); }

inline std::vector<double> differences(const std::vector<double>& phase) {
  std::vector<double> rate;
  for (std::size_t k = 1; k < phase.size(); ++k) rate.push_back(phase[k] - phase[k - 1]);
  return rate;
}

/// The oscillator sets as rates at 1 Hz.
inline std::map<std::string, std::vector<double>> oscillators() {
  std::map<std::string, std::vector<double>> sets;
  sets["phase_dat"] = differences(read_columns("oscillator/phase_dat.csv.gz")[0]);
  sets["tic_phase_s"] = differences(read_columns("oscillator/tic_phase_s.csv.gz")[0]);
  const Columns ocxo = read_columns("oscillator/ocxo_frequency_hz.csv.gz");
  for (const double hertz : ocxo[0]) {
    sets["ocxo_frequency_hz"].push_back(hertz / 1e7 - 1);
  }
  return sets;
}

}  // namespace gyrobudget::allan

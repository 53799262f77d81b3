// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/fit/fit.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "result.h"

// Nunes et al., "Simulation of an Interferometric Fiber Optic Gyroscope Applied to a Rocket Model": tables I and II,
// figures 3, 4, 6 and 7 of its gyros and figures 8 to 10 of its flight, ours beside the published values.
namespace gyrobudget::inline v0::report {

/// One number of the paper. Values stand in `unit`.
struct PaperRow {
  /// What our least-squares fit of the same record says in place of the reading.
  struct Fitted {
    double value = 0;
    double lower = 0;   ///< 95 %
    double upper = 0;   ///< 95 %; one-sided where zero is not excluded
    double actual = 0;  ///< what the simulated noise holds, by the definitions of IEEE Std 952
    fit::Status status = fit::Status::identified;
  };

  std::string id;     ///< "table1.model2.arw"
  std::string group;  ///< "model 2, IFOG": what several rows are of
  std::string what;   ///< "ARW"
  std::string unit;
  std::optional<double> published;  ///< empty where the paper shows a curve and no number
  double ours = 0;                  ///< from our records, read as the paper reads them
  double theory = 0;                ///< what that reading is on average, in closed form
  /// 95 % of such readings lie here.
  struct Scatter {
    double low = 0, high = 0;
  };
  std::optional<Scatter> scatter;
  std::optional<Fitted> fitted;
  std::string why;  ///< why ours, the published and the fed-in value differ
};

/// One simulated record: figures 6 and 7.
struct PaperRecord {
  std::string id;             ///< "model1"
  AxisResult axis;            ///< measured curve and our fit; name "model 1, IFOG"
  fit::Result reading;        ///< by eye
  std::vector<double> exact;  ///< the model's own Allan deviation at each of axis.points [rad/s]
  /// The record in short: extremes of each stretch of `trace_step_s` [rad/s].
  double trace_step_s = 0;
  std::vector<double> trace_low, trace_high;
};

/// One sensor's angle under white noise alone: figures 3 and 4. Angles in rad.
struct PaperDrift {
  std::string id;    ///< "mems"
  std::string name;  ///< "MEMS"
  double arw = 0;    ///< [rad/sqrt(s)]
  std::vector<double> time_s;
  std::vector<double> std;                ///< over all runs, at each time
  std::vector<std::vector<double>> runs;  ///< some of the runs, at each time
  std::vector<double> final;              ///< of every run at the last time
  double final_std_faster = 0;            ///< the same at `faster_hz`, its sigma still from 5 Hz
};

/// One flight of figures 8 to 10, at PaperFlight::time_s.
struct PaperPath {
  std::string id;    ///< "reference", "ideal", "ifog", "mems", "offset_ifog", "offset_mems"
  std::string name;  ///< "MEMS"
  std::vector<double> downrange, crossrange, up;  ///< from the pad [m]
  // From where the reference is at that time, and the ideal gyro's flight [m].
  std::vector<double> distance, from_ideal;
  /// Roll, pitch, yaw about body axes against the program [rad]: as flown, and as measured.
  std::array<std::vector<double>, 3> flown, measured;
};

/// What something supposed of the paper's flight makes of its three distances, by our own flights.
struct PaperHypothesis {
  struct Gyro {
    std::optional<double> km;         ///< root mean square over the flights that came to the end; none did: empty
    std::optional<double> theory_km;  ///< to first order, where that says anything
    int flights = 0, lost = 0;
    std::optional<double> takes;  ///< how much of it the published distance takes [takes_unit]
  };
  std::string id;             ///< "earth_rate"
  std::string what;           ///< "Earth's rate left out of the attitude"
  std::array<Gyro, 3> gyros;  ///< ideal, IFOG, MEMS
  std::string takes_unit;
  std::string why;
};

/// Figures 8 to 10.
struct PaperFlight {
  std::vector<double> time_s;
  std::vector<double> pitch;  ///< of the program [rad]
  std::vector<PaperPath> paths;
  std::vector<PaperHypothesis> hypotheses;
  std::array<double, 3> published_km{};
  std::vector<std::string> words;
};

struct Paper {
  std::string command;
  std::uint64_t seed = 0;
  double rate_hz = 0;
  double duration_s = 0;
  double bandwidth_hz = 0;  ///< of the drift study, and its sample rate
  double faster_hz = 0;     ///< the other sample rate of the drift study
  std::vector<PaperRow> rows;
  std::vector<PaperRecord> records;
  std::vector<PaperDrift> drifts;
  PaperFlight flight;
};

/// What the published numbers mean, one thing each.
[[nodiscard]] std::vector<std::string> paper_words(const Paper&);
/// Tables and words for the terminal.
[[nodiscard]] std::string paper_table(const Paper&);
/// The fields are described by schema/paper-1.schema.json, which is installed with the program.
[[nodiscard]] std::string paper_json(const Paper&);
/// One HTML page that opens offline, with the figures.
[[nodiscard]] std::string paper_page(const Paper&);

}  // namespace gyrobudget::inline v0::report

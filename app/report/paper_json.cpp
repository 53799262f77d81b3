// SPDX-License-Identifier: MIT
// The paper's rows for programs, and the data that paper.js draws.
#include "gyrobudget/noise/units.h"
#include "gyrobudget/noise/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "page_parts.h"
#include "paper.h"
#include "words.h"

namespace gyrobudget::inline v0::report {
namespace {

using Json = nlohmann::ordered_json;
using noise::Term;

Json row_json(const PaperRow& row) {
  Json out = {{"id", row.id},     {"group", row.group},
              {"what", row.what}, {"published", row.published ? Json(*row.published) : Json(nullptr)},
              {"ours", row.ours}, {"theory", row.theory}};
  if (row.scatter) {
    out["scatter_low"] = row.scatter->low;
    out["scatter_high"] = row.scatter->high;
  }
  if (row.fitted) {
    out["fitted"] = row.fitted->value;
    out["lower"] = row.fitted->lower;
    out["upper"] = row.fitted->upper;
    out["actual"] = row.fitted->actual;
    out["status"] = row.fitted->status == fit::Status::identified    ? "identified"
                    : row.fitted->status == fit::Status::upper_bound ? "upper_bound"
                                                                     : "left_out";
  }
  out["unit"] = row.unit;
  out["why"] = row.why;
  return out;
}

Json known(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// One member of each gyro, by gyro.
template <typename Member>
Json by_gyro(const PaperHypothesis& h, Member member) {
  return {{"ideal", member(h.gyros[0])}, {"ifog", member(h.gyros[1])}, {"mems", member(h.gyros[2])}};
}

Json hypothesis_json(const PaperHypothesis& h, const PaperFlight& flight) {
  using Gyro = PaperHypothesis::Gyro;
  const auto& published = flight.published_km;
  return {{"id", h.id},
          {"what", h.what},
          {"unit", "km"},
          {"published", {{"ideal", published[0]}, {"ifog", published[1]}, {"mems", published[2]}}},
          {"ours", by_gyro(h, [](const Gyro& g) { return known(g.km); })},
          {"theory", by_gyro(h, [](const Gyro& g) { return known(g.theory_km); })},
          {"flights", by_gyro(h, [](const Gyro& g) { return g.flights; })},
          {"lost", by_gyro(h, [](const Gyro& g) { return g.lost; })},
          {"takes", by_gyro(h, [](const Gyro& g) { return known(g.takes); })},
          {"takes_unit", h.takes_unit},
          {"why", h.why}};
}

Json document(const Paper& paper) {
  Json rows = Json::array(), hypotheses = Json::array();
  for (const PaperRow& row : paper.rows) rows.push_back(row_json(row));
  for (const PaperHypothesis& h : paper.flight.hypotheses) hypotheses.push_back(hypothesis_json(h, paper.flight));
  return {{"schema", "gyrobudget.paper/1"},
          {"version", kVersion},
          {"command", paper.command},
          {"seed", paper.seed},
          {"record",
           {{"samples", std::llround(paper.duration_s * paper.rate_hz)},
            {"rate_hz", paper.rate_hz},
            {"duration_s", paper.duration_s}}},
          {"rows", rows},
          {"hypotheses", hypotheses},
          {"words", paper_words(paper)}};
}

// --- The page -------------------------------------------------------------------------------------------------------

Json scaled(const std::vector<double>& si, double unit) {
  Json out = Json::array();
  constexpr int kDigits = 6;  // of a picture
  for (const double v : si) out.push_back(std::stod(fmt::format("{:.{}g}", v / unit, kDigits)));
  return out;
}

double degree() { return noise::parse_unit("deg").to_si; }
double degree_per_hour() { return noise::parse_unit("deg/h").to_si; }

/// The three points that the paper reads off the curve.
Json reading_marks(const PaperRecord& record) {
  const fit::Result& r = record.reading;
  const auto unit = [](Term term) { return noise::datasheet_unit(noise::Signal::angular_rate, term); };
  const auto mark = [&](const char* name, Term term, double tau, double deviation) {
    return Json{{"name", name},
                {"tau_s", tau},
                {"deviation", deviation / degree_per_hour()},
                {"text", fmt::format("read: {} = {}", static_cast<char>(term), in_unit(r[term].value, unit(term), 3))}};
  };
  constexpr double kWalkTau = 3;
  const double n = r[Term::white].value, k = r[Term::rate_random_walk].value;
  Json marks = {mark("N", Term::white, 1, n), mark("min", Term::flicker, r.minimum_tau_s, r.minimum_deviation)};
  // K's point at 3 s lies far below the curve; its line is drawn through where it was read.
  const double tau = record.axis.points.back().tau_s / 4;
  marks.push_back(mark("K", Term::rate_random_walk, tau, k * std::sqrt(tau / kWalkTau)));
  return marks;
}

Json drift_json(const PaperDrift& d) {
  Json runs = Json::array();
  for (const auto& run : d.runs) runs.push_back(scaled(run, degree()));
  return {{"id", d.id},
          {"name", d.name},
          {"arw", noise::from_si(d.arw, "deg/sqrt(h)")},
          {"time_s", d.time_s},
          {"std", scaled(d.std, degree())},
          {"runs", runs},
          {"final", scaled(d.final, degree())}};
}

Json trace_json(const PaperRecord& record) {
  return {{"name", record.axis.name},
          {"step_s", record.trace_step_s},
          {"low", scaled(record.trace_low, degree_per_hour())},
          {"high", scaled(record.trace_high, degree_per_hour())}};
}

Json flight_json(const PaperFlight& flight) {
  constexpr double kKilometre = 1000;
  Json paths = Json::array();
  for (const PaperPath& p : flight.paths) {
    Json path = {{"id", p.id},
                 {"name", p.name},
                 {"downrange_km", scaled(p.downrange, kKilometre)},
                 {"crossrange_km", scaled(p.crossrange, kKilometre)},
                 {"up_km", scaled(p.up, kKilometre)},
                 {"distance_km", scaled(p.distance, kKilometre)},
                 {"from_ideal_km", scaled(p.from_ideal, kKilometre)}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      path["flown_deg"].push_back(scaled(p.flown[axis], degree()));
      path["measured_deg"].push_back(scaled(p.measured[axis], degree()));
    }
    paths.push_back(path);
  }
  return {{"time_s", flight.time_s}, {"pitch_deg", scaled(flight.pitch, degree())}, {"paths", paths}};
}

LogResult as_log(const Paper& paper) {
  LogResult log;
  log.source = "simulated";
  log.command = paper.command;
  log.rate_hz = paper.rate_hz;
  log.samples = std::llround(paper.duration_s * paper.rate_hz);
  for (const PaperRecord& record : paper.records) log.axes.push_back(record.axis);
  return log;
}

}  // namespace

std::string paper_json(const Paper& paper) { return document(paper).dump(2) + "\n"; }

std::string paper_data(const Paper& paper) {
  Json data = Json::parse(page_data(as_log(paper)));
  data["paper"] = document(paper);
  Json drifts = Json::array(), traces = Json::array();
  for (const PaperDrift& d : paper.drifts) drifts.push_back(drift_json(d));
  for (std::size_t i = 0; i < paper.records.size(); ++i) {
    const PaperRecord& record = paper.records[i];
    Json& curves = data["axes"][i]["curves"];
    curves["marks"] = reading_marks(record);
    curves["exact"] = scaled(record.exact, degree_per_hour());
    traces.push_back(trace_json(record));
  }
  data["drifts"] = drifts;
  data["traces"] = traces;
  data["flight"] = flight_json(paper.flight);
  return without_markup(data.dump());
}

}  // namespace gyrobudget::inline v0::report

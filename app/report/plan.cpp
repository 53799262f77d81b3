// SPDX-License-Identifier: MIT
#include "plan.h"

#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/sensor.h"
#include "gyrobudget/noise/version.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <string>
#include <vector>

#include "json_text.h"
#include "layout.h"

namespace gyrobudget::inline v0::report {
namespace {

constexpr auto kGyro = noise::Signal::angular_rate;

std::string length(double seconds) {
  return std::isfinite(seconds) ? text::duration_text(seconds, text::DurationForm::planned) : "never";
}

std::string accuracy_text(double relative) {
  if (!std::isfinite(relative) || relative > 10) return "> 1000 %";
  return fmt::format("{}{:.3g} %", relative > fit::kBoundReached ? ">= " : "", 100 * relative);
}

std::string rows_text(const fit::Plan& plan) {
  if (plan.rows.empty()) return {};
  std::string text = fmt::format("  {:>10}", "record");
  for (const auto& t : plan.terms) text += fmt::format("  {:>18}", noise::label(kGyro, t.term));
  text += fmt::format("\n  {:>10}", "");
  for (const auto& t : plan.terms) {
    text += fmt::format("  {:>18}", noise::quantity_text(t.value, noise::datasheet_unit(kGyro, t.term), 3));
  }
  text += "\n";
  for (const auto& row : plan.rows) {
    text += fmt::format("  {:>10}", length(row.duration_s));
    for (const double x : row.relative_std) text += fmt::format("  {:>18}", accuracy_text(x));
    text += "\n";
  }
  return text + "\n";
}

std::string answers_text(const fit::Plan& plan) {
  std::string text;
  for (const auto& answer : plan.answers) {
    if (std::isfinite(answer.duration_s)) {
      text += fmt::format("{} to {:.3g} %: record {}.\n", noise::label(kGyro, answer.term), 100 * answer.relative_std,
                          length(answer.duration_s));
    } else {
      text += fmt::format("{} to {:.3g} %: no record of 1e15 samples would do.\n", noise::label(kGyro, answer.term),
                          100 * answer.relative_std);
    }
  }
  return text;
}

std::string axes_name(const fit::AxesPlan::Part& part) {
  std::vector<std::string> names;
  for (const std::size_t axis : part.axes) names.emplace_back(1, "xyz"[axis]);
  return text::listing(names);
}

nlohmann::ordered_json durations_json(const fit::Plan& plan) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& row : plan.rows) {
    nlohmann::ordered_json entry{{"duration_s", row.duration_s}};
    for (std::size_t i = 0; i < plan.terms.size(); ++i) {
      entry["relative_std"][std::string(noise::key(kGyro, plan.terms[i].term))] = number_or_null(row.relative_std[i]);
    }
    list.push_back(entry);
  }
  return list;
}

nlohmann::ordered_json answers_json(const fit::Plan& plan) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& answer : plan.answers) {
    list.push_back({{"parameter", noise::key(kGyro, answer.term)},
                    {"relative_std", answer.relative_std},
                    {"duration_s", number_or_null(answer.duration_s)},
                    {"lower_bound", answer.relative_std > fit::kBoundReached}});
  }
  return list;
}

}  // namespace

std::string plan_table(const PlanStudy& study) {
  const auto& parts = study.plan.parts;
  std::string text =
      fmt::format("{}: what a record at {:g} Hz buys (one sigma of each coefficient)\n\n", study.sensor, study.rate_hz);
  for (const auto& part : parts) {
    if (parts.size() > 1) text += fmt::format("Axis {}:\n\n", axes_name(part));
    text += rows_text(part.plan) + answers_text(part.plan);
    if (parts.size() > 1 && !part.plan.answers.empty()) text += "\n";
  }
  if (parts.size() > 1 && !study.plan.all.answers.empty()) text += "All axes:\n\n" + answers_text(study.plan.all);
  text +=
      "\nFrom the Fisher information (Cramer-Rao). The fit reaches these figures below about 10 %; above, they are lower bounds (>=).\n";
  for (const auto& note : study.notes) text += wrapped(note, "Note: ", "  ");
  return text;
}

std::string plan_json(const PlanStudy& study) {
  const auto& parts = study.plan.parts;
  nlohmann::ordered_json json;
  json["schema"] = "gyrobudget.plan/1";
  json["version"] = kVersion;
  json["command"] = study.command;
  json["sensor"] = study.sensor;
  json["rate_hz"] = study.rate_hz;
  json["durations"] = durations_json(study.plan.all);
  json["answers"] = answers_json(study.plan.all);
  json["axes"] = nlohmann::ordered_json::array();
  for (const auto& part : parts) {
    if (parts.size() > 1)
      json["axes"].push_back(
          {{"axes", axes_name(part)}, {"durations", durations_json(part.plan)}, {"answers", answers_json(part.plan)}});
  }
  json["notes"] = study.notes;
  return json.dump(2) + "\n";
}

}  // namespace gyrobudget::inline v0::report

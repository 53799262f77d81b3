// SPDX-License-Identifier: MIT
#include "sensor_merge.h"

#include "gyrobudget/app/sensor_file/detail/sensor_text.h"
#include "gyrobudget/app/text/input.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <utility>

#include "yaml_reader.h"

namespace gyrobudget::inline v0::sensor_file {
namespace {

using noise::ErrorModel;
using noise::SensorModel;
using noise::Signal;
using noise::Term;

constexpr std::array kTerms{Term::white,     Term::flicker,      Term::rate_random_walk, Term::quantization,
                            Term::rate_ramp, Term::gauss_markov, Term::sinusoid};
constexpr std::array<std::string_view, 2> kFirstOfComment{"# WARNING: ", "# Fitted by: "};
constexpr std::array kSignals{Signal::angular_rate, Signal::specific_force};

std::string section_name(Signal signal) { return signal == Signal::angular_rate ? "gyro" : "accelerometer"; }

bool has(const ErrorModel& model, Term term) {
  if (term == Term::gauss_markov) return !model.gauss_markov.empty();
  if (term == Term::sinusoid) return !model.sinusoids.empty();
  return model[term] != 0;
}

bool is_fitted(const Update& update, Signal signal, Term term) {
  return std::ranges::any_of(update.fitted, [&](const auto& f) { return f.signal == signal && f.term == term; });
}
bool is_fitted(const Update& update, Signal signal) {
  return std::ranges::find(update.fitted, signal, &Update::Fitted::signal) != update.fitted.end();
}

/// Whether the update decides over a term, or leaves the file's alone.
bool decides(const Update& update, Signal signal, Term term) {
  if (is_fitted(update, signal, term)) return true;
  return term == Term::gauss_markov &&
         (is_fitted(update, signal, Term::flicker) || is_fitted(update, signal, Term::rate_random_walk));
}

bool is_comment(std::string_view line) { return text::trim(line).starts_with('#'); }
bool is_filling(std::string_view line) { return text::trim(line).empty() || is_comment(line); }

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    lines.emplace_back(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

/// Lines of the comment that a program put at the head: [first, last); empty where there is none. What stands above its
/// first line is of somebody else.
std::pair<std::size_t, std::size_t> head_comment(const std::vector<std::string>& lines) {
  std::optional<std::size_t> first;
  for (std::size_t i = 0; i < lines.size() && is_filling(lines[i]); ++i) {
    const bool begins = std::ranges::any_of(kFirstOfComment, [&](auto word) { return lines[i].starts_with(word); });
    if (begins && !first) first = i;
    if (lines[i].find(kEndOfComment) != std::string::npos) return {first.value_or(0), i + 1};
  }
  return {0, 0};
}

/// The model of a section, whatever it is of.
const ErrorModel* section(const SensorModel& model, Signal signal) {
  if (signal == Signal::angular_rate) return &model.gyro;
  return model.accelerometer ? &*model.accelerometer : nullptr;
}

/// Changes lines of a file, from its end to its head so that numbers of lines hold.
class Edits {
 public:
  void replace(std::size_t first, std::size_t last, std::vector<std::string> by) {
    edits_.push_back({first, last, std::move(by)});
  }
  void insert(std::size_t before, std::vector<std::string> lines) { replace(before, before, std::move(lines)); }

  [[nodiscard]] std::string applied(std::vector<std::string> lines) && {
    // Of those at one line the ones that only insert come first, so that they go in last.
    std::ranges::stable_sort(edits_, {}, [](const Edit& e) { return std::pair(e.first, e.last); });
    for (auto edit = edits_.rbegin(); edit != edits_.rend(); ++edit) {
      const auto at = lines.begin() + static_cast<std::ptrdiff_t>(edit->first);
      const auto from = lines.erase(at, at + static_cast<std::ptrdiff_t>(edit->last - edit->first));
      lines.insert(from, edit->by.begin(), edit->by.end());
    }
    std::string text;
    for (const std::string& line : lines) text += line + '\n';
    return text;
  }

 private:
  struct Edit {
    std::size_t first, last;
    std::vector<std::string> by;
  };
  std::vector<Edit> edits_;
};

/// A key of a map in block style, with the lines of it and of its value: [first, last).
struct Entry {
  std::string key;
  std::size_t first, last, indent;
};

std::vector<Entry> entries_of(const YAML::Node& map, std::size_t end, const std::vector<std::string>& lines) {
  std::vector<Entry> entries;
  for (const auto& one : map) {
    const YAML::Mark mark = one.first.Mark();
    entries.push_back({one.first.Scalar(), static_cast<std::size_t>(mark.line), end,
                       static_cast<std::size_t>(std::max(mark.column, 0))});
  }
  std::ranges::sort(entries, {}, &Entry::first);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i + 1 < entries.size()) entries[i].last = entries[i + 1].first;
    while (entries[i].last > entries[i].first + 1 && is_filling(lines[entries[i].last - 1])) --entries[i].last;
  }
  return entries;
}

/// The keys of a section of the project's own writing, in their order, with the lines of each.
struct Written {
  std::string key;
  std::vector<std::string> lines;
};
std::vector<Written> written(const ErrorModel& model, Signal signal) {
  constexpr std::size_t kIndent = 2;
  std::vector<Written> keys;
  for (const std::string& line : lines_of(detail::triad_yaml(model, signal))) {
    if (!line.starts_with("  ")) continue;
    if (line[kIndent] != ' ') keys.push_back({line.substr(kIndent, line.find(':') - kIndent), {}});
    keys.back().lines.push_back(line.substr(kIndent));
  }
  return keys;
}

const Written* find(const std::vector<Written>& keys, std::string_view key) {
  const auto at = std::ranges::find(keys, key, &Written::key);
  return at == keys.end() ? nullptr : &*at;
}

std::optional<Term> term_of(std::string_view key, Signal signal) {
  const auto at = std::ranges::find(kTerms, key, [&](Term t) { return noise::key(signal, t); });
  return at == kTerms.end() ? std::nullopt : std::optional(*at);
}

class Merger {
 public:
  Merger(const std::string& path, const Update& update)
      : update_(update), name_(text::input_name(path)), text_(text::read_text(path, kLargestFile, "a sensor file")) {
    const YamlReader reader({name_, text_}, "arw: 0.15 deg/sqrt(h)", "gyro:");
    root_ = reader.root();
    if (!root_["gyro"] && !root_["accelerometer"])
      reader.fail_here(root_, "found no \"gyro:\", expected a sensor file of gyrobudget's own form to update");
    file_ = detail::read_sensor_text(name_, text_).model;
    result_.model = file_;
    lines_ = lines_of(text_);
    entries_ = entries_of(root_, lines_.size(), lines_);
  }

  Merged run() {
    if (update_.rename) result_.model.name = update_.model.name;
    for (const Signal signal : kSignals) merge_model(signal);
    const std::string whole = sensor_yaml(result_.model, update_.comment, update_.warnings);
    result_.text = edited();
    // Files are written in more ways than lines tell: what does not hold what it must is written anew.
    if (!holds(result_.text)) result_.text = whole;
    return std::move(result_);
  }

 private:
  [[nodiscard]] const ErrorModel* updated(Signal signal) const {
    return is_fitted(update_, signal) ? section(update_.model, signal) : nullptr;
  }

  /// Whether the update has its own say on a key: on the noise that was fitted, and on all else that it has.
  [[nodiscard]] bool decides_on(const std::string& key, Signal signal) const {
    if (const auto term = term_of(key, signal)) return decides(update_, signal, *term);
    return find(written(*updated(signal), signal), key) != nullptr;
  }

  /// The keys of the section as it is to be.
  [[nodiscard]] std::vector<Written> merged_keys(Signal signal) const {
    const ErrorModel* held = section(file_, signal);
    const std::vector<Written> ours = written(*updated(signal), signal);
    std::vector<Written> keys;
    if (held) {
      for (Written& key : written(*held, signal)) {
        const Written* own = decides_on(key.key, signal) ? find(ours, key.key) : &key;
        if (own) keys.push_back(*own);
      }
    }
    for (const Written& key : ours)
      if (decides_on(key.key, signal) && !find(keys, key.key)) keys.push_back(key);
    return keys;
  }

  void merge_model(Signal signal) {
    if (!updated(signal)) return;
    const bool gyro = signal == Signal::angular_rate;
    std::string text = gyro ? "gyro:\n" : "gyro: {}\naccelerometer:\n";
    for (const Written& key : merged_keys(signal))
      for (const std::string& line : indented(key.lines, "  ")) text += line + '\n';
    const SensorModel merged = detail::read_sensor_text(name_, text).model;
    if (gyro)
      result_.model.gyro = merged.gyro;
    else
      result_.model.accelerometer = merged.accelerometer;
    const ErrorModel* held = section(file_, signal);
    for (const Term term : kTerms)
      if (held && has(*held, term) && !has(*section(result_.model, signal), term))
        result_.taken.push_back(fmt::format("{}.{}", section_name(signal), noise::key(signal, term)));
  }

  [[nodiscard]] bool holds(const std::string& text) const {
    try {
      const SensorFile file = detail::read_sensor_text(name_, text);
      return sensor_yaml(file.model, {}, file.warnings) == sensor_yaml(result_.model, {}, update_.warnings);
    } catch (const text::InputError&) {
      return false;
    }
  }

  [[nodiscard]] const Entry* entry(std::string_view key) const {
    const auto at = std::ranges::find(entries_, key, &Entry::key);
    return at == entries_.end() ? nullptr : &*at;
  }

  [[nodiscard]] std::string edited() const {
    Edits edits;
    const auto [first, last] = head_comment(lines_);
    std::vector<std::string> head;
    for (const std::string& line : lines_of(update_.comment)) head.push_back(line.empty() ? "#" : "# " + line);
    edits.replace(first, last, std::move(head));
    head_keys(edits);
    for (const Signal signal : kSignals)
      if (updated(signal)) section_lines(edits, signal);
    return std::move(edits).applied(lines_);
  }

  void head_keys(Edits& edits) const {
    std::vector<std::string> lines;
    if (update_.rename) {
      if (const Entry* old = entry("name")) edits.replace(old->first, old->last, {});
      lines.push_back(fmt::format("name: {}", detail::text_yaml(update_.model.name)));
    }
    if (const Entry* old = entry("warning")) edits.replace(old->first, old->last, {});
    if (!update_.warnings.empty()) lines.emplace_back("warning:");
    for (const std::string& warning : update_.warnings)
      lines.push_back(fmt::format("  - {}", detail::text_yaml(warning)));
    const Entry* name = update_.rename ? nullptr : entry("name");
    if (!lines.empty()) edits.insert(name ? name->last : entries_.front().first, std::move(lines));
  }

  void section_lines(Edits& edits, Signal signal) const {
    const Entry* old = entry(section_name(signal));
    const ErrorModel& model = *section(result_.model, signal);
    if (!old) return edits.insert(lines_.size(), lines_of(detail::triad_yaml(model, signal)));
    const YAML::Node below = root_[section_name(signal)];
    if (!below.IsMap() || below.Style() == YAML::EmitterStyle::Flow || below.size() == 0)
      return edits.replace(old->first, old->last, lines_of(detail::triad_yaml(model, signal)));
    const std::vector<Entry> entries = entries_of(below, old->last, lines_);
    const std::string indent(entries.front().indent, ' ');
    const std::vector<Written> keys = merged_keys(signal);
    std::size_t behind = entries.front().first;  // where what the file has not goes
    for (const Entry& e : entries) {
      if (term_of(e.key, signal)) behind = e.last;
      if (!decides_on(e.key, signal)) continue;
      const Written* own = find(keys, e.key);
      edits.replace(e.first, e.last, own ? indented(own->lines, indent) : std::vector<std::string>{});
    }
    for (const Written& key : keys)
      if (decides_on(key.key, signal) && std::ranges::find(entries, key.key, &Entry::key) == entries.end())
        edits.insert(behind, indented(key.lines, indent));
  }

  static std::vector<std::string> indented(const std::vector<std::string>& lines, const std::string& by) {
    std::vector<std::string> result;
    for (const std::string& line : lines) result.push_back(by + line);
    return result;
  }

  const Update& update_;
  std::string name_, text_;
  YAML::Node root_;
  std::vector<std::string> lines_;
  std::vector<Entry> entries_;
  SensorModel file_;  ///< as it was
  Merged result_;
};

}  // namespace

std::vector<std::string> held_beyond(const std::string& path, const Update& update) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error) || std::filesystem::file_size(path, error) == 0) return {};
  const std::string read = text::read_text(path, kLargestFile, "a sensor file");
  const YamlReader reader({text::input_name(path), read}, "arw: 0.15 deg/sqrt(h)", "gyro:");
  const YAML::Node& root = reader.root();
  if (!root["gyro"] && !root["accelerometer"])
    reader.fail_here(root, "found no \"gyro:\", expected a sensor file of gyrobudget's own form");
  const std::vector<std::string> lines = lines_of(read);
  const bool written_by_program = head_comment(lines).second > 0;
  std::vector<std::string> held;
  for (const auto& one : root) {
    const std::string key = one.first.Scalar();
    const auto signal = std::ranges::find(kSignals, key, section_name);
    if (signal == kSignals.end()) {
      if (key != "name" && !(key == "warning" && written_by_program)) held.push_back(key);
      continue;
    }
    const ErrorModel* own = is_fitted(update, *signal) ? section(update.model, *signal) : nullptr;
    if (!own) {
      held.push_back(key);
      continue;
    }
    if (!one.second.IsMap()) continue;
    const auto ours = written(*own, *signal);
    for (const auto& entry : one.second) {
      const std::string name = entry.first.Scalar();
      if (find(ours, name) || (written_by_program && term_of(name, *signal))) continue;
      held.push_back(fmt::format("{}.{}", key, name));
    }
  }
  return held;
}

Merged merged(const std::string& path, const Update& update) { return Merger(path, update).run(); }

}  // namespace gyrobudget::inline v0::sensor_file

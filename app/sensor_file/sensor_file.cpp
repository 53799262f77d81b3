// SPDX-License-Identifier: MIT
#include "sensor_file.h"

#include "gyrobudget/app/sensor_file/detail/sensor_text.h"
#include "gyrobudget/app/text/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

#include "minimum.h"
#include "yaml_reader.h"

namespace gyrobudget::inline v0::sensor_file {
namespace {

using noise::Dimension;
using noise::ErrorModel;
using noise::FrontEnd;
using noise::PerAxis;
using noise::SensorModel;
using noise::Signal;
using noise::Term;
namespace dimension = noise::dimension;

// --- Keys, for reading and writing alike -----------------------------------------------------------------------------

using noise::dimension::kLength;
constexpr Term kCoefficients[] = {Term::white, Term::flicker, Term::rate_random_walk, Term::quantization,
                                  Term::rate_ramp};

/// What a static log cannot give: a member of ErrorModel, `Member` being for all axes or one for each.
template <class Member>
struct Extra {
  std::string_view key;
  std::optional<Member> ErrorModel::*member;
  std::string_view gyro_unit, accelerometer_unit;  ///< in which it is written; empty: has none of it
  bool above_zero = false;
};
constexpr Extra<PerAxis> kPerAxis[] = {
    {"turn_on_bias", &ErrorModel::turn_on_bias, "deg/h", "ug"},
    {"scale_factor", &ErrorModel::scale_factor, "ppm", "ppm"},
    {"misalignment", &ErrorModel::misalignment, "arcsec", "arcsec"},
    {"g_sensitivity", &ErrorModel::g_sensitivity, "deg/h/g", ""},
    {"g2_sensitivity", &ErrorModel::g2_sensitivity, "deg/h/g^2", "ug/g^2"},
    {"vibration_rectification", &ErrorModel::vibration_rectification, "deg/h/g^2", "ug/g^2"},
};
constexpr Extra<double> kForAll[] = {
    {"delay", &ErrorModel::delay, "ms", "ms"},
    {"range", &ErrorModel::range, "deg/s", "g"},
    {"powered_on_before", &ErrorModel::powered_on_before, "s", "s"},
    {"calibrated_over", &ErrorModel::calibrated_over, "s", "s"},
};
constexpr std::string_view kFilter = "filter", kKind = "kind", kBandwidth = "bandwidth", kFilterOrder = "filter_order",
                           kLeverArm = "lever_arm", kWarning = "warning", kIdeal = "ideal",
                           kTemperature = "temperature", kReference = "reference", kBiasStability = "bias_stability";
constexpr FrontEnd::Kind kFilterKinds[] = {FrontEnd::Kind::first_order, FrontEnd::Kind::second_order,
                                           FrontEnd::Kind::moving_average};

/// What temperature does, behind `temperature:`.
struct TemperatureKey {
  std::string_view key;
  PerAxis noise::TemperatureModel::*member;
  std::string_view gyro_unit, accelerometer_unit;
  [[nodiscard]] std::string_view unit(Signal signal) const {
    return signal == Signal::angular_rate ? gyro_unit : accelerometer_unit;
  }
};
constexpr TemperatureKey kTemperatureKeys[] = {
    {"linear", &noise::TemperatureModel::linear, "deg/h/K", "ug/K"},
    {"quadratic", &noise::TemperatureModel::quadratic, "deg/h/K^2", "ug/K^2"},
    {"rate", &noise::TemperatureModel::rate, "deg/h/(K/min)", "ug/(K/min)"},
};

template <class Member>
std::string_view unit_of(const Extra<Member>& extra, Signal signal) {
  return signal == Signal::angular_rate ? extra.gyro_unit : extra.accelerometer_unit;
}

/// One value of an entry of gauss_markov or sinusoid: its size, for all axes or one for each, or something else.
template <class Process>
struct Field {
  std::string_view key;
  PerAxis Process::*size;   ///< or null
  double Process::*member;  ///< or null
  std::string_view unit;    ///< empty: the datasheet unit of the signal
  bool above_zero;
  bool needed;
};
constexpr Field<noise::TriadGaussMarkov> kGaussMarkov[] = {
    {"sigma", &noise::TriadGaussMarkov::sigma, nullptr, "", false, true},
    {"correlation_time", nullptr, &noise::TriadGaussMarkov::correlation_time, "s", true, true},
};
constexpr Field<noise::TriadSinusoid> kSinusoid[] = {
    {"amplitude", &noise::TriadSinusoid::amplitude, nullptr, "", false, true},
    {"frequency", nullptr, &noise::TriadSinusoid::frequency, "Hz", true, true},
    {"phase", nullptr, &noise::TriadSinusoid::phase, "deg", false, false},
};

template <class Process>
std::string_view unit_of(const Field<Process>& field, Signal signal) {
  return field.unit.empty() ? noise::datasheet_unit(signal) : field.unit;
}

// --- Reading ---------------------------------------------------------------------------------------------------------

class Reader : private YamlReader {
 public:
  Reader(const std::string& path, const ReadOptions& options)
      : YamlReader(path, "a sensor file", kLine, kKey), options_(options) {}
  explicit Reader(Text text) : YamlReader(std::move(text), kLine, kKey) {}

  SensorFile read() {
    if (root()["gyro"] || root()["accelerometer"]) return own_form();
    if (root()["Gyr"]) return imu_utils_form();
    if (const YAML::Node node = with_key("gyroscope_noise_density")) return {density_form(node, kKalibr), {}, {}};
    if (const YAML::Node node = with_key("gyr_n")) return vins_form(node);
    fail_unknown_form();
  }

 private:
  using Node = YAML::Node;

  static constexpr std::string_view kLine = "arw: 0.15 deg/sqrt(h)", kKey = "gyro:";

  // --- The form of this project ---

  SensorFile own_form() const {
    SensorFile file;
    SensorModel& model = file.model;
    bool gyro = false;
    for_each(root(), "the file", [&](const Node& key, const Node& value) {
      if (key.Scalar() == "name") {
        if (!value.IsScalar()) fail_here(key, fmt::format("name: found {}, expected text", kind(value)));
        model.name = text::printable(value.Scalar());
      } else if (key.Scalar() == "gyro") {
        model.gyro = error_model(value, Signal::angular_rate, "gyro");
        gyro = true;
      } else if (key.Scalar() == "accelerometer") {
        model.accelerometer = error_model(value, Signal::specific_force, "accelerometer");
      } else if (key.Scalar() == kLeverArm) {
        model.lever_arm = three(kLeverArm, value, kLength, Sign::any);
      } else if (key.Scalar() == kWarning) {
        file.warnings = texts(value);
      } else {
        fail_unknown_key(key, "a sensor file",
                         {"name", std::string(kWarning), "gyro", "accelerometer", std::string(kLeverArm)});
      }
    });
    if (!gyro) fail_here(root(), "found no \"gyro:\", expected one; its errors stand below it");
    say_flicker("gyro", model.gyro, Signal::angular_rate, file.notes);
    if (model.accelerometer) say_flicker("accelerometer", *model.accelerometer, Signal::specific_force, file.notes);
    return file;
  }

  /// A text, or a list of them.
  std::vector<std::string> texts(const Node& value) const {
    if (!value.IsSequence()) return {text(kWarning, value)};
    std::vector<std::string> result;
    for (const Node& one : value) result.push_back(text(kWarning, one));
    return result;
  }

  static std::vector<std::string> keys(Signal signal) {
    std::vector<std::string> result;
    for (const Term t : kCoefficients) result.emplace_back(noise::key(signal, t));
    result.emplace_back(noise::key(signal, Term::gauss_markov));
    result.emplace_back(noise::key(signal, Term::sinusoid));
    for (const auto& e : kPerAxis) {
      if (!unit_of(e, signal).empty()) result.emplace_back(e.key);
    }
    for (const auto& e : kForAll) result.emplace_back(e.key);
    for (const auto key : {kFilter, kBandwidth, kFilterOrder, kTemperature, kBiasStability}) result.emplace_back(key);
    return result;
  }

  ErrorModel error_model(const Node& node, Signal signal, std::string_view where) const {
    ErrorModel model;
    // "gyro: ideal", or with nothing below it: it is known to have no error.
    if (node.IsNull() || (node.IsScalar() && node.Scalar() == kIdeal)) {
      for (const auto& e : kPerAxis)
        if (!unit_of(e, signal).empty()) model.*e.member = PerAxis(0);
      return model;
    }
    for_each(node, where, [&](const Node& key, const Node& value) {
      if (!read_entry(key.Scalar(), value, signal, model)) fail_unknown_key(key, where, keys(signal));
    });
    if (const Node bandwidth = node[std::string(kBandwidth)]) model.filter = older_filter(node, bandwidth);
    if (const Node minimum = node[std::string(kBiasStability)])
      model.bias_instability = flicker_of(minimum, node, model, signal);
    return model;
  }

  /// False where there is no such key.
  bool read_entry(const std::string& key, const Node& value, Signal signal, ErrorModel& model) const {
    for (const Term t : kCoefficients) {
      if (key != noise::key(signal, t)) continue;
      const Sign sign = t == Term::rate_ramp ? Sign::any : Sign::not_negative;
      model[t] = per_axis(key, value, noise::dimension_of(signal, t), sign);
      return true;
    }
    for (const auto& e : kPerAxis) {
      if (key != e.key || unit_of(e, signal).empty()) continue;
      model.*e.member = per_axis(key, value, noise::parse_unit(unit_of(e, signal)).dimension, Sign::not_negative);
      return true;
    }
    for (const auto& e : kForAll) {
      if (key != e.key) continue;
      model.*e.member = quantity(key, value, noise::parse_unit(unit_of(e, signal)).dimension,
                                 e.above_zero ? Sign::above_zero : Sign::not_negative);
      return true;
    }
    if (key == kBandwidth) return true;      // older_filter()
    if (key == kBiasStability) return true;  // flicker_of()
    if (key == kFilterOrder) return whole(key, value, 1, 2) > 0;
    if (key == kFilter) {
      model.filter = filter(value);
      return true;
    }
    if (key == kTemperature) {
      model.temperature = temperature(value, signal);
      return true;
    }
    if (key == noise::key(signal, Term::gauss_markov)) {
      model.gauss_markov = list<noise::TriadGaussMarkov>(key, value, kGaussMarkov, signal);
      return true;
    }
    if (key == noise::key(signal, Term::sinusoid)) {
      model.sinusoids = list<noise::TriadSinusoid>(key, value, kSinusoid, signal);
      return true;
    }
    return false;
  }

  double bandwidth(const Node& value) const {
    return quantity(kBandwidth, value, dimension::kFrequency, Sign::above_zero);
  }

  /// B of a datasheet's in-run bias stability, behind the other coefficients.
  PerAxis flicker_of(const Node& value, const Node& triad, const ErrorModel& model, Signal signal) const {
    if (triad[std::string(noise::key(signal, Term::flicker))])
      fail_here(value,
                fmt::format("{0}: found it beside {1}, expected one of the two; {0} is the minimum of the whole curve",
                            kBiasStability, noise::key(signal, Term::flicker)));
    const PerAxis minimum =
        per_axis(kBiasStability, value, noise::dimension_of(signal, Term::flicker), Sign::not_negative);
    PerAxis result(0);
    for (std::size_t i = 0; i < 3; ++i) {
      const double n = model.white[i], k = model.rate_random_walk[i];
      const std::optional<double> b = flicker_of_minimum(minimum[i], n, k);
      if (!b)
        fail_here(value,
                  fmt::format("{}: found {}, expected at least {}, where the curve of {} and {} alone has its minimum",
                              kBiasStability, kind(value),
                              noise::quantity_text(curve_minimum(n, 0, k), noise::datasheet_unit(signal), 4),
                              noise::key(signal, Term::white), noise::key(signal, Term::rate_random_walk)));
      result[i] = *b;
    }
    return result;
  }

  /// What was made of it, for people.
  void say_flicker(const char* where, const ErrorModel& model, Signal signal, std::vector<std::string>& notes) const {
    const Node triad = root()[where];
    if (!triad.IsMap() || !triad[std::string(kBiasStability)]) return;
    notes.push_back(
        fmt::format("{}: {} of {} is the minimum of the Allan deviation: beside its white noise and walk that is {} {}",
                    file_name(), kBiasStability, where, noise::key(signal, Term::flicker),
                    noise::quantity_text(model.bias_instability.largest(), noise::datasheet_unit(signal), 4)));
  }

  FrontEnd filter(const Node& node) const {
    std::optional<FrontEnd::Kind> kind;
    std::optional<double> passed;
    section(node, kFilter,
            {{std::string(kKind),
              [&](const Node& value) {
                std::vector<std::string> names;
                for (const FrontEnd::Kind k : kFilterKinds) names.emplace_back(noise::name(k));
                kind = kFilterKinds[one_of(kKind, value, names)];
              }},
             {std::string(kBandwidth), [&](const Node& value) { passed = bandwidth(value); }}});
    if (!kind) fail_here(node, "filter: found no kind, expected one: first_order, second_order or moving_average");
    if (!passed) fail_here(node, "filter: found no bandwidth, expected one, such as 25 Hz");
    return {*kind, *passed, FrontEnd::Sampling::held};
  }

  /// Of the keys bandwidth and filter_order.
  FrontEnd older_filter(const Node& triad, const Node& value) const {
    if (triad[std::string(kFilter)])
      fail_here(value, "bandwidth: found it beside filter, expected one of the two; filter has its own");
    const Node order = triad[std::string(kFilterOrder)];
    const bool second = order && whole(kFilterOrder, order, 1, 2) == 2;
    return {second ? FrontEnd::Kind::second_order : FrontEnd::Kind::first_order, bandwidth(value),
            FrontEnd::Sampling::held};
  }

  noise::TemperatureModel temperature(const Node& node, Signal signal) const {
    noise::TemperatureModel model;
    bool reference = false;
    for_each(node, kTemperature, [&](const Node& key, const Node& value) {
      if (key.Scalar() == kReference) {
        model.reference = quantity(kReference, value, dimension::kTemperature, Sign::any);
        if (const std::string unit = text::lower(value.Scalar()); unit.ends_with(" k") || unit.ends_with("kelvin"))
          fail_here(value, fmt::format("{}: found {}, expected it in degC", kReference, kind(value)));
        reference = true;
        return;
      }
      const auto* known = std::ranges::find(kTemperatureKeys, key.Scalar(), &TemperatureKey::key);
      if (known == std::end(kTemperatureKeys))
        fail_unknown_key(key, kTemperature, {std::string(kReference), "linear", "quadratic", "rate"});
      model.*known->member = per_axis(known->key, value, noise::parse_unit(known->unit(signal)).dimension, Sign::any);
    });
    if (!reference) fail_here(node, "temperature: found no reference, expected one, such as 25 degC");
    return model;
  }

  /// One quantity for each axis, in a list.
  std::array<double, 3> three(std::string_view key, const Node& value, const Dimension& expected, Sign sign) const {
    std::array<double, 3> result{};
    if (!value.IsSequence() || value.size() != result.size()) {
      fail_here(value, fmt::format("{}: found {}, expected a list of three, [x, y, z], each a number and a unit ({})",
                                   key, value.IsSequence() ? fmt::format("a list of {}", value.size()) : kind(value),
                                   noise::example_units(expected)));
    }
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = quantity(key, value[i], expected, sign);
    return result;
  }

  PerAxis per_axis(std::string_view key, const Node& value, const Dimension& expected, Sign sign) const {
    if (!value.IsSequence()) return quantity(key, value, expected, sign);
    const auto v = three(key, value, expected, sign);
    return {v[0], v[1], v[2]};
  }

  template <class Process, std::size_t n>
  std::vector<Process> list(std::string_view key, const Node& node, const Field<Process> (&fields)[n],
                            Signal signal) const {
    if (!node.IsSequence()) {
      fail_here(node, fmt::format("{}: found {}, expected a list like [{{{}: ..., {}: ...}}]", key, kind(node),
                                  fields[0].key, fields[1].key));
    }
    std::vector<Process> result;
    for (const Node& entry : node) result.push_back(process(key, entry, fields, signal));
    return result;
  }

  template <class Process, std::size_t n>
  Process process(std::string_view where, const Node& entry, const Field<Process> (&fields)[n], Signal signal) const {
    Process result;
    std::vector<std::string> known, found;
    for (const auto& field : fields) known.emplace_back(field.key);
    for_each(entry, where, [&](const Node& key, const Node& value) {
      const auto* field = std::ranges::find(fields, key.Scalar(), &Field<Process>::key);
      if (field == std::end(fields)) fail_unknown_key(key, where, known);
      const Dimension dimension = noise::parse_unit(unit_of(*field, signal)).dimension;
      if (field->size)
        result.*field->size = per_axis(field->key, value, dimension, Sign::any);
      else
        result.*field->member =
            quantity(field->key, value, dimension, field->above_zero ? Sign::above_zero : Sign::any);
      found.push_back(key.Scalar());
    });
    for (const auto& field : fields) {
      if (!field.needed || std::ranges::find(found, field.key) != found.end()) continue;
      fail_here(entry, fmt::format("{}: found no {}, expected one beside the others", where, text::quoted(field.key)));
    }
    return result;
  }

  // --- The forms of others ---

  struct DensityKeys {
    const char *gyro_white, *gyro_walk, *accelerometer_white, *accelerometer_walk;
  };
  static constexpr DensityKeys kKalibr = {"gyroscope_noise_density", "gyroscope_random_walk",
                                          "accelerometer_noise_density", "accelerometer_random_walk"};
  static constexpr DensityKeys kVins = {"gyr_n", "gyr_w", "acc_n", "acc_w"};

  /// The root, or the first entry below it (imu0), that has the key.
  Node with_key(const char* key) const {
    if (root()[key]) return root();
    for (const auto& entry : root()) {
      if (entry.second.IsMap() && entry.second[key]) return entry.second;
    }
    return Node(YAML::NodeType::Undefined);
  }

  /// The files of others hold much that is not ours to judge: other keys are passed over.
  SensorModel density_form(const Node& node, const DensityKeys& keys) const {
    SensorModel model;
    model.name = file_name();
    model.gyro.white = number(node, keys.gyro_white);
    model.gyro.rate_random_walk = number(node, keys.gyro_walk);
    if (node[keys.accelerometer_white] || node[keys.accelerometer_walk]) {
      model.accelerometer.emplace();
      model.accelerometer->white = number(node, keys.accelerometer_white);
      model.accelerometer->rate_random_walk = number(node, keys.accelerometer_walk);
    }
    return model;
  }

  /// VINS' own code takes n and w for sigmas of a sample; many who fill its file in write densities.
  SensorFile vins_form(const Node& node) const {
    SensorFile file{density_form(node, kVins), {}, {}};
    file.notes.push_back(reading(file.model.gyro.white[0], "gyr_n", "gyr_n, gyr_w, acc_n and acc_w"));
    const auto to_densities = [&](ErrorModel& errors) {
      errors.white *= of_a_sample();
      errors.rate_random_walk *= of_a_sample();
    };
    to_densities(file.model.gyro);
    if (file.model.accelerometer) to_densities(*file.model.accelerometer);
    return file;
  }

  /// From a sigma of a sample to a density; 1 where the rate is not known.
  double of_a_sample() const { return options_.rate_hz ? 1 / std::sqrt(*options_.rate_hz) : 1; }

  /// Which of the two readings was taken, what the other would be, and how to say it.
  std::string reading(double written, std::string_view key, std::string_view keys) const {
    const auto n = [](double density) { return noise::quantity_text(density, "deg/sqrt(h)", 3); };
    if (options_.rate_hz) {
      const double density = written / std::sqrt(*options_.rate_hz);
      return fmt::format(
          "{}: {} are read as sigmas of a sample at {:g} Hz, so {} is an angle random walk of {}; were they densities, as keys like Kalibr's say, it would be {}",
          file_name(), keys, *options_.rate_hz, key, n(density), n(written));
    }
    constexpr double kExample = 200;
    return fmt::format(
        "{}: {} are read as densities, so {} is an angle random walk of {}; the file does not say that they are, and were they sigmas of a sample, as VINS' code takes them, it would be {} at 200 Hz: then give their rate (--rate; in a scene 'rate:' beside the file)",
        file_name(), keys, key, n(written), n(written / std::sqrt(kExample)));
  }

  SensorFile imu_utils_form() const {
    SensorFile file;
    SensorModel& model = file.model;
    model.name = root()["name"] && root()["name"].IsScalar() ? text::printable(root()["name"].Scalar()) : file_name();
    model.gyro = imu_utils_triad(root()["Gyr"], "gyr_n", "gyr_w", dimension::kAngularRate);
    file.notes.push_back(reading(model.gyro.white.largest(), "gyr_n", root()["Acc"] ? "gyr_n and acc_n" : "gyr_n"));
    model.gyro.white *= of_a_sample();
    if (root()["Acc"]) {
      model.accelerometer = imu_utils_triad(root()["Acc"], "acc_n", "acc_w", dimension::kSpecificForce);
      model.accelerometer->white *= of_a_sample();
    }
    return file;
  }

  /// Each axis where the file has all three, else their mean.
  ErrorModel imu_utils_triad(const Node& triad, const char* white, const char* minimum, const Dimension& signal) const {
    if (!triad.IsMap()) fail_here(triad, fmt::format("found {}, expected avg-axis below it", kind(triad)));
    const double to_si = triad["unit"] ? unit_factor(triad["unit"], signal) : 1;
    constexpr std::array kNames{"x-axis", "y-axis", "z-axis"};
    const bool each = std::ranges::all_of(kNames, [&](const char* name) { return triad[name].IsDefined(); });
    ErrorModel model;
    const double flat = std::sqrt(2 * std::numbers::ln2 / std::numbers::pi);  // of the deviation of flicker with B = 1
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      const Node axis = triad[each || !triad["avg-axis"] ? kNames[each ? i : 0] : "avg-axis"];
      if (!axis || !axis.IsMap()) fail_here(triad, "found no avg-axis, expected one as imu_utils writes it");
      model.white[i] = to_si * number(axis, white);
      model.bias_instability[i] = to_si * number(axis, minimum) / flat;
    }
    return model;
  }

  double unit_factor(const Node& unit, const Dimension& expected) const {
    try {
      const noise::Unit parsed = noise::parse_unit(text::trim(unit.Scalar()));
      if (parsed.dimension == expected) return parsed.to_si;
    } catch (const std::invalid_argument&) {
    }
    fail_here(unit, fmt::format("unit: found {}, expected one like {}", kind(unit), noise::example_units(expected)));
  }

  double number(const Node& map, const char* key) const {
    const Node value = map[key];
    if (!value) fail_here(map, fmt::format("found no {}, expected one beside the others", text::quoted(key)));
    if (!value.IsScalar()) fail_here(value, fmt::format("{}: found {}, expected a number", key, kind(value)));
    const std::string_view text = text::trim(value.Scalar());
    double result = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), result);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(result)) {
      fail_here(value,
                fmt::format("{}: found {}, expected a plain number (SI, continuous time)", key, text::quoted(text)));
    }
    check_sign(key, value, result, Sign::not_negative);
    return result;
  }

  std::string file_name() const { return text::printable(name().substr(name().rfind('/') + 1)); }

  ReadOptions options_;

  [[noreturn]] void fail_unknown_form() const {
    std::vector<std::string> found;
    constexpr std::size_t kListed = 6;
    for (const auto& entry : root()) {
      if (entry.first.IsScalar() && found.size() < kListed) found.push_back(text::quoted(entry.first.Scalar()));
    }
    fail_here(
        root(),
        fmt::format(
            "found the key{} {}, expected \"gyro:\" (a sensor file), \"gyroscope_noise_density:\" (Kalibr, OpenVINS), \"gyr_n:\" (VINS) or \"Gyr:\" (imu_utils)",
            found.size() == 1 ? "" : "s", text::listing(found)));
  }
};

// --- Writing ---------------------------------------------------------------------------------------------------------

/// "5.4e-4 deg/sqrt(h)" with the fewest digits that give the same double; in SI where the unit has none that do.
std::string exact_quantity(double si, std::string_view unit, std::string_view si_unit) {
  const double to_si = noise::parse_unit(unit).to_si;
  const double value = si / to_si;
  constexpr int kDigits = 17;
  for (int digits = 1; digits <= kDigits; ++digits) {
    for (const double candidate : {value, std::nextafter(value, HUGE_VAL), std::nextafter(value, -HUGE_VAL)}) {
      const std::string text = fmt::format("{:.{}g}", candidate, digits);
      double read = 0;
      std::from_chars(text.data(), text.data() + text.size(), read);
      if (read * to_si == si) return fmt::format("{} {}", text, unit);
    }
  }
  return fmt::format("{} {}", si, si_unit);
}

/// "rad^1 s^-0.5"
std::string si_unit(const Dimension& d) {
  std::string result;
  for (const auto& [name, doubled] :
       {std::pair{"rad", d.angle}, {"m", d.length}, {"s", d.time}, {"K", d.temperature}}) {
    if (doubled != 0) result += fmt::format("{}{}^{}", result.empty() ? "" : " ", name, doubled / 2.0);
  }
  return result.empty() ? "1" : result;
}

class Writer {
 public:
  explicit Writer(std::string_view comment) {
    for (std::string_view rest = comment; !rest.empty();) {
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      text_ += fmt::format("#{}{}\n", end > 0 ? " " : "", rest.substr(0, end));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
  }

  std::string write(const SensorModel& model, std::span<const std::string> warnings) && {
    if (!model.name.empty()) text_ += fmt::format("name: {}\n", scalar(model.name));
    if (!warnings.empty()) text_ += fmt::format("{}:\n", kWarning);
    for (const std::string& warning : warnings) text_ += fmt::format("  - {}\n", scalar(warning));
    triad("gyro", model.gyro, Signal::angular_rate);
    if (model.accelerometer) triad("accelerometer", *model.accelerometer, Signal::specific_force);
    if (model.lever_arm != std::array<double, 3>{}) {
      const auto& l = model.lever_arm;
      text_ += fmt::format("{}: {}\n", kLeverArm, three({l[0], l[1], l[2]}, "m"));
    }
    return std::move(text_);
  }

  void triad(std::string_view name, const ErrorModel& model, Signal signal) {
    text_ += fmt::format("{}:\n", name);
    for (const Term t : kCoefficients) {
      const bool always = t == Term::white || t == Term::flicker || t == Term::rate_random_walk;
      if (always || model[t] != 0) line(noise::key(signal, t), per_axis(model[t], noise::datasheet_unit(signal, t)));
    }
    list(noise::key(signal, Term::gauss_markov), model.gauss_markov, kGaussMarkov, signal);
    list(noise::key(signal, Term::sinusoid), model.sinusoids, kSinusoid, signal);
    for (const auto& e : kPerAxis) {
      if (model.*e.member && !unit_of(e, signal).empty()) line(e.key, per_axis(*(model.*e.member), unit_of(e, signal)));
    }
    if (model.filter)
      line(kFilter, fmt::format("{{{}: {}, {}: {}}}", kKind, noise::name(model.filter->kind), kBandwidth,
                                quantity(model.filter->bandwidth, "Hz")));
    for (const auto& e : kForAll) {
      if (model.*e.member) line(e.key, quantity(*(model.*e.member), unit_of(e, signal)));
    }
    if (!model.temperature) return;
    text_ += fmt::format("  {}:\n    {}: {} degC\n", kTemperature, kReference, model.temperature->reference);
    for (const auto& e : kTemperatureKeys) {
      const PerAxis& value = model.temperature.value().*e.member;
      if (!(value == PerAxis())) text_ += fmt::format("    {}: {}\n", e.key, per_axis(value, e.unit(signal)));
    }
  }

  [[nodiscard]] std::string take() && { return std::move(text_); }

  /// Quoted where YAML could read something else into it.
  static std::string scalar(const std::string& text) {
    const auto plain = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == ' ' || c == '-' ||
             c == '_' || c == '.' || c == ',' || c == '(' || c == ')' || c == '/';
    };
    const bool starts_with_letter =
        !text.empty() && ((text[0] >= 'a' && text[0] <= 'z') || (text[0] >= 'A' && text[0] <= 'Z'));
    const bool ambiguous = text.find(' ') == std::string::npos && text.size() <= 5;  // yes, null, false
    if (starts_with_letter && !ambiguous && text.back() != ' ' && std::ranges::all_of(text, plain)) return text;
    std::string result = "\"";
    for (const char c : text) {
      const auto byte = static_cast<unsigned char>(c);
      if (c == '"' || c == '\\') result += '\\';
      result += byte < 0x20 || byte == 0x7f ? fmt::format("\\x{:02x}", byte) : std::string(1, c);
    }
    return result + '"';
  }

 private:
  void line(std::string_view key, const std::string& value) { text_ += fmt::format("  {}: {}\n", key, value); }

  template <class Process, std::size_t n>
  void list(std::string_view key, const std::vector<Process>& entries, const Field<Process> (&fields)[n],
            Signal signal) {
    if (entries.empty()) return;
    text_ += fmt::format("  {}:\n", key);
    for (const Process& entry : entries) {
      std::string fields_text;
      for (const auto& field : fields) {
        if (!field.needed && entry.*field.member == 0) continue;
        const auto unit = unit_of(field, signal);
        fields_text +=
            fmt::format("{}{}: {}", fields_text.empty() ? "" : ", ", field.key,
                        field.size ? per_axis(entry.*field.size, unit) : quantity(entry.*field.member, unit));
      }
      text_ += fmt::format("    - {{{}}}\n", fields_text);
    }
  }

  static std::string quantity(double si, std::string_view unit) {
    return exact_quantity(si, unit, si_unit(noise::parse_unit(unit).dimension));
  }

  static std::string three(const PerAxis& value, std::string_view unit) {
    return fmt::format("[{}, {}, {}]", quantity(value[0], unit), quantity(value[1], unit), quantity(value[2], unit));
  }
  static std::string per_axis(const PerAxis& value, std::string_view unit) {
    return value.is_uniform() ? quantity(value[0], unit) : three(value, unit);
  }

  std::string text_;
};

}  // namespace

SensorFile read_sensor_file(const std::string& path, const ReadOptions& options) {
  if (options.rate_hz && !(std::isfinite(*options.rate_hz) && *options.rate_hz > 0))
    throw std::invalid_argument(fmt::format("rate is {} Hz; it must be above 0 and finite", *options.rate_hz));
  return Reader(path, options).read();
}

SensorModel read_sensor(const std::string& path) { return read_sensor_file(path).model; }

std::string sensor_yaml(const SensorModel& model, std::string_view comment, std::span<const std::string> warnings) {
  return Writer(comment).write(model, warnings);
}

namespace detail {

SensorFile read_sensor_text(std::string name, std::string text) {
  return Reader(YamlReader::Text{std::move(name), std::move(text)}).read();
}

std::string triad_yaml(const ErrorModel& model, Signal signal) {
  Writer writer({});
  writer.triad(signal == Signal::angular_rate ? "gyro" : "accelerometer", model, signal);
  return std::move(writer).take();
}

std::string text_yaml(const std::string& text) { return Writer::scalar(text); }

}  // namespace detail

}  // namespace gyrobudget::inline v0::sensor_file

// SPDX-License-Identifier: MIT
#include "forms.h"

#include "gyrobudget/app/sensor_file/detail/densities.h"
#include "gyrobudget/app/sensor_file/minimum.h"
#include "gyrobudget/app/text/text.h"
#include "gyrobudget/noise/constants.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>

namespace gyrobudget::inline v0::sensor_file {
namespace {

using detail::Densities;
using detail::Density;
using detail::Origin;
using noise::Signal;
using noise::Term;

// --- The forms, as data ----------------------------------------------------------------------------------------------

/// What a number is made of besides the density.
struct Setting {
  double rate_hz;
  double correlation_time_s;
};

constexpr double kDegree = std::numbers::pi / 180, kHour = 3600, kMilliGal = 1e-5;

double as_it_is(double x, const Setting&) { return x; }
double of_a_sample(double x, const Setting& s) { return x * std::sqrt(s.rate_hz); }
/// EKF2 predicts at about this rate, whatever the IMU's is.
constexpr double kEkf2Rate = 100;
double of_a_prediction(double x, const Setting&) { return x * std::sqrt(kEkf2Rate); }
double squared(double x, const Setting&) { return x * x; }
double per_root_hour_deg(double x, const Setting&) { return x / kDegree * std::sqrt(kHour); }
double per_root_hour(double x, const Setting&) { return x * std::sqrt(kHour); }
double markov_deg_h(double k, const Setting& s) { return k * std::sqrt(s.correlation_time_s / 2) / kDegree * kHour; }
double markov_milli_gal(double k, const Setting& s) { return k * std::sqrt(s.correlation_time_s / 2) / kMilliGal; }

/// Simulators take bias instability itself, and then no walk that stands for it.
enum class What { white, walk, rate_random_walk, flicker };

struct Row {
  Signal signal;
  What what;
  std::string_view key, unit;
  double (*to)(double si, const Setting&);
};

constexpr Signal kGyro = Signal::angular_rate, kAccelerometer = Signal::specific_force;

/// How a form writes: {0} is the key, {1} the number or the three, parted by `separator`.
struct FormFacts {
  std::string_view name, title;
  std::string_view comment, comment_end;  ///< around a line of words
  std::string_view line;
  bool per_axis;
  std::string_view separator;   ///< between the three
  std::array<Row, 6> rows;      ///< those without a key are none
  std::string_view head, foot;  ///< {0} is the rate, {1} the correlation time [h]
};

constexpr FormFacts kForms[] = {
    {"openvins",
     "kalibr_imu_chain.yaml of OpenVINS: continuous-time densities",
     "  # ",
     "",
     "  {0}: {1}",
     false,
     "",
     {{{kGyro, What::white, "gyroscope_noise_density", "rad/s/sqrt(Hz)", as_it_is},
       {kGyro, What::walk, "gyroscope_random_walk", "rad/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::white, "accelerometer_noise_density", "m/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::walk, "accelerometer_random_walk", "m/s^3/sqrt(Hz)", as_it_is}}},
     "%YAML:1.0\nimu0:\n",
     "  T_i_b: [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n  rostopic: /imu0\n  time_offset: 0.0\n  update_rate: {0}\n"},
    {"vins",
     "VINS-Mono and VINS-Fusion: sigmas of a sample at the rate of the IMU; the mid-point covariance halves white noise, so for its exact growth multiply gyr_n and acc_n by sqrt(2)",
     "# ",
     "",
     "{0}: {1}",
     false,
     "",
     {{{kGyro, What::white, "gyr_n", "rad/s a sample", of_a_sample},
       {kGyro, What::walk, "gyr_w", "rad/s^2 a sample", of_a_sample},
       {kAccelerometer, What::white, "acc_n", "m/s^2 a sample", of_a_sample},
       {kAccelerometer, What::walk, "acc_w", "m/s^3 a sample", of_a_sample}}},
     "",
     "# at {0} Hz\n"},
    {"orb_slam3",
     "ORB-SLAM3: continuous-time densities; its code takes IMU.Frequency for them, which must be the IMU's",
     "# ",
     "",
     "{0}: {1}",
     false,
     "",
     {{{kGyro, What::white, "IMU.NoiseGyro", "rad/s/sqrt(Hz)", as_it_is},
       {kGyro, What::walk, "IMU.GyroWalk", "rad/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::white, "IMU.NoiseAcc", "m/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::walk, "IMU.AccWalk", "m/s^3/sqrt(Hz)", as_it_is}}},
     "",
     "IMU.Frequency: {0:.1f}\n"},
    {"gtsam",
     "GTSAM PreintegrationCombinedParams: variances of density",
     "// ",
     "",
     "params->{0} = gtsam::Vector3({1}).asDiagonal();",
     true,
     ", ",
     {{{kGyro, What::white, "gyroscopeCovariance", "(rad/s)^2/Hz", squared},
       {kGyro, What::walk, "biasOmegaCovariance", "(rad/s^2)^2/Hz", squared},
       {kAccelerometer, What::white, "accelerometerCovariance", "(m/s^2)^2/Hz", squared},
       {kAccelerometer, What::walk, "biasAccCovariance", "(m/s^3)^2/Hz", squared}}},
     "",
     ""},
    {"px4_sitl",
     "IMU plugin of PX4's simulation in Gazebo classic, and of RotorS",
     "<!-- ",
     " -->",
     "<{0}>{1}</{0}>",
     false,
     "",
     {{{kGyro, What::white, "gyroscopeNoiseDensity", "rad/s/sqrt(Hz)", as_it_is},
       {kGyro, What::walk, "gyroscopeRandomWalk", "rad/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::white, "accelerometerNoiseDensity", "m/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::walk, "accelerometerRandomWalk", "m/s^3/sqrt(Hz)", as_it_is}}},
     "",
     "<!-- the bias is a Gauss-Markov process: so long a time makes it a walk over any run -->\n<gyroscopeBiasCorrelationTime>1000000</gyroscopeBiasCorrelationTime>\n<accelerometerBiasCorrelationTime>1000000</accelerometerBiasCorrelationTime>\n"},
    {"kf_gins",
     "KF-GINS imunoise: its biases are Gauss-Markov processes of one time, whose driving noise is the walk",
     "  # ",
     "",
     "  {0}: [{1}]",
     true,
     ", ",
     {{{kGyro, What::white, "arw", "deg/sqrt(h)", per_root_hour_deg},
       {kGyro, What::walk, "gbstd", "deg/h", markov_deg_h},
       {kAccelerometer, What::white, "vrw", "m/s/sqrt(h)", per_root_hour},
       {kAccelerometer, What::walk, "abstd", "mGal", markov_milli_gal}}},
     "imunoise:\n",
     "  corrtime: {1}  # [h]\n"},
    {"navego",
     "NaveGo: profile of an IMU in SI",
     "% ",
     "",
     "imu.{0} = [{1}];",
     true,
     " ",
     {{{kGyro, What::white, "arw", "rad/s/sqrt(Hz)", as_it_is},
       {kGyro, What::walk, "arrw", "rad/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::white, "vrw", "m/s^2/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::walk, "vrrw", "m/s^3/sqrt(Hz)", as_it_is}}},
     "",
     "imu.freq = {0};\n"},
    {"px4_ekf2",
     "PX4's EKF2, as commands of its shell: sigmas at the 100 Hz of its prediction; EKF2 is usually tuned above them, for vibration",
     "# ",
     "",
     "param set {0} {1}",
     false,
     "",
     {{{kGyro, What::white, "EKF2_GYR_NOISE", "rad/s", of_a_prediction},
       {kGyro, What::walk, "EKF2_GYR_B_NOISE", "rad/s^2", of_a_prediction},
       {kAccelerometer, What::white, "EKF2_ACC_NOISE", "m/s^2", of_a_prediction},
       {kAccelerometer, What::walk, "EKF2_ACC_B_NOISE", "m/s^3", of_a_prediction}}},
     "",
     ""},
    {"pyins",
     "pyins.inertial_sensor.EstimationModel: continuous-time densities of each axis, in SI",
     "# ",
     "",
     "{0} = [{1}]",
     true,
     ", ",
     {{{kGyro, What::white, "gyro[\"noise\"]", "rad/sqrt(s)", as_it_is},
       {kGyro, What::walk, "gyro[\"bias_walk\"]", "rad/s/sqrt(s)", as_it_is},
       {kAccelerometer, What::white, "accel[\"noise\"]", "m/s/sqrt(s)", as_it_is},
       {kAccelerometer, What::walk, "accel[\"bias_walk\"]", "m/s^2/sqrt(s)", as_it_is}}},
     "import pyins.inertial_sensor\n\ngyro, accel = {{}}, {{}}\n",
     "gyro_model = pyins.inertial_sensor.EstimationModel(**gyro)\naccel_model = pyins.inertial_sensor.EstimationModel(**accel)\n"},
    {"matlab",
     "MATLAB imuSensor: densities are double-sided",
     "% ",
     "",
     "{0} = [{1}];",
     true,
     " ",
     {{{kGyro, What::white, "imu.Gyroscope.NoiseDensity", "rad/s/sqrt(Hz)", as_it_is},
       {kGyro, What::rate_random_walk, "imu.Gyroscope.RandomWalk", "(rad/s) sqrt(Hz)", as_it_is},
       {kAccelerometer, What::white, "imu.Accelerometer.NoiseDensity", "(m/s^2)/sqrt(Hz)", as_it_is},
       {kAccelerometer, What::rate_random_walk, "imu.Accelerometer.RandomWalk", "(m/s^2) sqrt(Hz)", as_it_is},
       {kGyro, What::flicker, "imu.Gyroscope.BiasInstability", "rad/s", as_it_is},
       {kAccelerometer, What::flicker, "imu.Accelerometer.BiasInstability", "m/s^2", as_it_is}}},
     "imu = imuSensor('accel-gyro', 'SampleRate', {0});\nimu.Gyroscope.NoiseType = 'double-sided';\nimu.Accelerometer.NoiseType = 'double-sided';\n",
     ""},
};

constexpr std::string_view kKalibr = "kalibr", kImuUtils = "imu_utils";

// --- imu_utils, whose numbers lie axis by axis -----------------------------------------------------------------------

/// gyr_n and gyr_w of one axis, or of the mean of those that are given.
void add_axis(std::string& text, std::string_view axis, std::string_view prefix, const noise::ErrorModel& errors,
              std::span<const std::size_t> axes) {
  double white = 0, minimum = 0;
  for (const std::size_t i : axes) {
    white += errors.white[i] / static_cast<double>(axes.size());
    minimum += curve_minimum(errors.white[i], errors.bias_instability[i], errors.rate_random_walk[i]) /
               static_cast<double>(axes.size());
  }
  text += fmt::format("  {}:\n", axis);
  for (const auto& [key, value] : {std::pair{'n', white}, std::pair{'w', minimum}}) {
    if (value > 0)
      text += fmt::format("    {}_{}: {:.9g}\n", prefix, key, value);
    else
      text += fmt::format("    # {}_{} is not known, and 0 would be wrong: fill it in\n", prefix, key);
  }
}

std::string imu_utils_yaml(const noise::SensorModel& model, std::string_view comment) {
  std::string text = "%YAML:1.0\n---\n";
  for (std::string_view rest = comment; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    text += fmt::format("# {}\n", rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  text +=
      "# imu_utils: gyr_n and acc_n are densities of white noise [rad/s/sqrt(Hz), m/s^2/sqrt(Hz)]\n"
      "# gyr_w and acc_w are the minimum of the Allan deviation [rad/s, m/s^2], of noise, flicker and walk together:\n"
      "#   no random walk, though VINS has it under that name; --form vins writes what VINS needs\n"
      "type: IMU\n";
  constexpr std::size_t kAll[] = {0, 1, 2};
  const auto add = [&](std::string_view section, std::string_view unit, std::string_view prefix,
                       const noise::ErrorModel& errors) {
    text += fmt::format("{}:\n  unit: \" {}\"\n", section, unit);
    add_axis(text, "avg-axis", prefix, errors, kAll);
    for (const std::size_t i : kAll) add_axis(text, fmt::format("{}-axis", "xyz"[i]), prefix, errors, {&kAll[i], 1});
  };
  add("Gyr", "rad/s", "gyr", model.gyro);
  if (model.accelerometer) add("Acc", "m/s^2", "acc", *model.accelerometer);
  return text;
}

// --- Writing ---------------------------------------------------------------------------------------------------------

class FormWriter {
 public:
  FormWriter(const FormFacts& form, const noise::SensorModel& model, const KalibrOptions& options)
      : form_(form), limits_(options.limits.value_or(noise::SensorModel{})), options_(options) {
    constexpr double kUsual = 4 * kHour, kLong = 10;
    setting_ = {options.update_rate_hz, std::max(kUsual, kLong * options.horizon_s)};
    gyro_.emplace(model.gyro, limits_.gyro, kGyro, options.horizon_s);
    if (!limits_.accelerometer) limits_.accelerometer.emplace();
    if (model.accelerometer)
      accelerometer_.emplace(*model.accelerometer, *limits_.accelerometer, kAccelerometer, options.horizon_s);
  }
  FormWriter(const FormWriter&) = delete;
  FormWriter& operator=(const FormWriter&) = delete;

  std::string write() && {
    const auto with_setting = [&](std::string_view text) {
      return fmt::format(fmt::runtime(text), setting_.rate_hz, setting_.correlation_time_s / kHour);
    };
    text_ = with_setting(form_.head);
    for (std::string_view rest = options_.comment; !rest.empty();) {
      const std::size_t end = std::min(rest.find('\n'), rest.size());
      say(std::string(rest.substr(0, end)));
      rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    say(std::string(form_.title));
    for (const Row& row : form_.rows) add(row);
    for (const auto& densities : {gyro_, accelerometer_}) {
      if (!densities) continue;
      for (const std::string& words : densities->left_out(densities->largest_walk()))
        if (!has_flicker() || words.find(noise::label(kGyro, Term::flicker)) == std::string::npos) say(words);
    }
    text_ += with_setting(form_.foot);
    return std::move(text_);
  }

 private:
  [[nodiscard]] bool has_flicker() const {
    return std::ranges::any_of(form_.rows, [](const Row& row) { return row.what == What::flicker; });
  }

  static Term term_of(What what) {
    return what == What::flicker ? Term::flicker : what == What::white ? Term::white : Term::rate_random_walk;
  }
  /// Of an axis, or of the one that has the most.
  static Density density(const Densities& of, What what, std::optional<std::size_t> axis) {
    if (what == What::walk) return axis ? of.walk(*axis) : of.largest_walk();
    return axis ? of.of_term(term_of(what), *axis) : of.largest_of_term(term_of(what));
  }
  static std::string words(const Densities& of, What what, const Density& density) {
    return what == What::walk ? of.walk_words(density) : of.words(density, term_of(what));
  }

  void say(std::string words) {
    // Where comments have an end, they are those of XML, which have no two hyphens inside.
    while (!form_.comment_end.empty() && words.find("--") != std::string::npos)
      words.replace(words.find("--"), 2, "- -");
    text_ += fmt::format("{}{}{}\n", form_.comment, words, form_.comment_end);
  }

  void add(const Row& row) {
    const std::optional<Densities>& of = row.signal == kGyro ? gyro_ : accelerometer_;
    if (row.key.empty()) return;
    const Density largest = of ? density(*of, row.what, {}) : Density{};
    if (largest.origin == Origin::none)
      return say(fmt::format("{} [{}] is not known, and 0 would be wrong: fill it in", row.key, row.unit));
    say(fmt::format("{} [{}]: {}", row.key, row.unit, words(*of, row.what, largest)));
    std::string numbers;
    for (std::size_t axis = 0; axis < (form_.per_axis ? 3U : 1U); ++axis) {
      Density one = largest;
      if (form_.per_axis) one = density(*of, row.what, axis);
      if (one.origin == Origin::none) one = largest;  // of an axis that nothing tells: as cautious as the worst
      numbers += fmt::format("{}{:.9g}", axis == 0 ? "" : form_.separator, row.to(one.value, setting_));
    }
    text_ += fmt::format(fmt::runtime(form_.line), row.key, numbers) + '\n';
  }

  const FormFacts& form_;
  noise::SensorModel limits_;
  const KalibrOptions& options_;
  Setting setting_{};
  std::optional<Densities> gyro_, accelerometer_;
  std::string text_;
};

}  // namespace

std::vector<std::string> form_names() {
  std::vector<std::string> names{std::string(kKalibr), std::string(kImuUtils)};
  for (const FormFacts& form : kForms) names.emplace_back(form.name);
  return names;
}

std::string form_text(std::string_view form, const noise::SensorModel& model, const KalibrOptions& options) {
  const std::string kalibr = kalibr_yaml(model, options);  // refuses what the options must not be
  if (form == kKalibr) return kalibr;
  if (form == kImuUtils) return imu_utils_yaml(model, options.comment);
  const auto* facts = std::ranges::find(kForms, form, &FormFacts::name);
  if (facts == std::end(kForms)) {
    const auto names = form_names();
    throw std::invalid_argument(
        fmt::format("form '{}'{}: there are {}", form, text::suggestion(form, names), text::listing(names)));
  }
  return FormWriter(*facts, model, options).write();
}

}  // namespace gyrobudget::inline v0::sensor_file

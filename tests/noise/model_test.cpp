// SPDX-License-Identifier: MIT
// The three models: samples against their exact Allan variance, the deterministic facts behind the paper's
// tables, extremes, and what the generators promise for them.
#include "gyrobudget/noise/model.h"

#include "gyrobudget/noise/bielas.h"
#include "gyrobudget/noise/generate.h"
#include "gyrobudget/noise/imu_sensor.h"
#include "gyrobudget/noise/jerath.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace gyrobudget::noise {
namespace {

using std::numbers::sqrt2;

/// A model as a function of its three coefficients and the sample interval.
struct Case {
  std::string name;
  std::function<Model(double n, double b, double k, double dt)> model;
};

Case jerath(std::string name, std::int64_t taps, Jerath::Filter filter) {
  return {std::move(name), [=](double n, double b, double k, double dt) {
            return Jerath{.arw = n, .bias_instability = b, .rrw = k, .taps = taps, .filter = filter}.model(dt);
          }};
}
Case imu(std::string name, ImuSensor::NoiseType type, const FilterCoefficients& coefficients) {
  return {std::move(name), [=](double n, double b, double k, double dt) {
            return ImuSensor{.noise_density = {0, n, 0},
                             .bias_instability = {0, b, 0},
                             .random_walk = {0, k, 0},
                             .noise_type = type,
                             .bias_instability_coefficients = coefficients}
                .model(1, dt);
          }};
}
Case bielas(std::string name, Bielas::Bias bias, bool rrw) {
  return {
      std::move(name), [=](double n, double b, double k, double dt) {
        return Bielas{.arw = n, .bias_instability = b, .rrw = rrw ? k : 0, .bias = bias, .correlation_time = 0.3}.model(
            dt);
      }};
}

const std::vector<Case> kCases = {
    jerath("JerathShortMemory", 20, Jerath::Filter::autoregressive),
    jerath("JerathWholeRecord", 3000, Jerath::Filter::autoregressive),
    jerath("JerathMovingAverage", 300, Jerath::Filter::moving_average),
    imu("ImuSensorDefault", ImuSensor::NoiseType::double_sided, {}),
    imu("ImuSensorSingleSided", ImuSensor::NoiseType::single_sided, fractal_coefficients(500)),
    imu("ImuSensorOtherPower", ImuSensor::NoiseType::single_sided, fractal_coefficients(50, 0.6)),
    bielas("BielasLegacy", Bielas::Bias::integrated_legacy, false),
    bielas("BielasPlainWhite", Bielas::Bias::plain_white, true),
    bielas("BielasGaussMarkov", Bielas::Bias::gauss_markov, true),
    bielas("BielasFlicker", Bielas::Bias::flicker, true)};

class ModelBattery : public testing::TestWithParam<Case> {};

std::vector<double> record(const Model& model, std::size_t samples, double dt, StreamKey key,
                           std::size_t chunk = std::numeric_limits<std::size_t>::max()) {
  Generator generator(model.processes, model.filters, dt, {.key = key, .longest_tau = 1e4 * dt});
  std::vector<double> y(samples);
  for (std::size_t at = 0; at < samples;) {
    const std::size_t count = std::min(chunk, samples - at);
    generator.next(std::span(y).subspan(at, count));
    at += count;
  }
  return y;
}

/// Overlapped Allan variance of a whole record.
double overlapped(const std::vector<double>& angle, std::int64_t m) {
  const auto cluster = static_cast<std::size_t>(m), terms = angle.size() - 2 * cluster;
  double sum = 0;
  for (std::size_t k = 0; k < terms; ++k) {
    const double difference = angle[k + 2 * cluster] - 2 * angle[k + cluster] + angle[k];
    sum += difference * difference;
  }
  return sum / (2 * static_cast<double>(m * m) * static_cast<double>(terms));
}

// 10 models, 3 rates and 6 clusters are 180 comparisons. A family-wise false alarm of 1e-3 takes 4.5 standard
// errors of a normal mean; 5 leaves room for Student's t with 299 degrees and the skewness of a mean of 300
// chi-squares of 7.
constexpr std::size_t kRecords = 300;
constexpr double kSigmas = 5;
constexpr double kRates[] = {1, 100, 1000};
constexpr std::int64_t kFactors[] = {1, 3, 10, 40, 100, 256};
constexpr std::size_t kSamples = 2048;

TEST_P(ModelBattery, SamplesHaveTheExactAllanVariance) {
  constexpr double kApproximation = 2 * 2e-4;  // of flicker by the endless generator
  for (const double rate : kRates) {
    const double dt = 1 / rate;
    const Model model = GetParam().model(0.05, 1, 0.3, dt);
    const ModelMoments moments(model, dt);
    std::array<double, std::size(kFactors)> sum{}, squares{};
    for (std::size_t run = 0; run < kRecords; ++run) {
      std::vector<double> angle = {0};
      for (const double y : record(model, kSamples, dt, {static_cast<std::uint64_t>(rate), run})) {
        angle.push_back(angle.back() + y);
      }
      for (std::size_t i = 0; i < std::size(kFactors); ++i) {
        const double ratio = overlapped(angle, kFactors[i]) / moments.allan_variance(kFactors[i], kSamples);
        sum[i] += ratio;
        squares[i] += ratio * ratio;
      }
    }
    for (std::size_t i = 0; i < std::size(kFactors); ++i) {
      const double mean = sum[i] / kRecords;
      const double error = std::sqrt((squares[i] / kRecords - mean * mean) / (kRecords - 1));
      EXPECT_NEAR(mean, 1, kSigmas * error + kApproximation) << rate << " Hz, m = " << kFactors[i];
      EXPECT_LT(error, 0.05) << "too few records to tell";
    }
  }
}

TEST_P(ModelBattery, BytesDoNotDependOnChunks) {
  const Model model = GetParam().model(0.05, 1, 0.3, 0.01);
  const auto whole = record(model, 5000, 0.01, {9, 1});
  for (const std::size_t chunk : {1, 7, 1000, 1024, 1025, 4999}) {
    EXPECT_EQ(whole, record(model, 5000, 0.01, {9, 1}, chunk)) << chunk;
  }
}

TEST_P(ModelBattery, SkippingLeavesTheRestAlone) {
  const Model model = GetParam().model(0.05, 1, 0.3, 0.01);
  const auto whole = record(model, 5000, 0.01, {9, 1});
  for (const std::size_t skipped : {0, 1, 1000, 1024, 4500}) {
    for (const std::size_t before : {0, 3}) {
      Generator generator(model.processes, model.filters, 0.01, {.key = {9, 1}, .longest_tau = 100});
      std::vector<double> start(before), rest(400);
      generator.next(start);
      generator.skip(skipped);
      generator.next(rest);
      EXPECT_TRUE(std::equal(rest.begin(), rest.end(), whole.begin() + static_cast<std::ptrdiff_t>(before + skipped)))
          << skipped << ' ' << before;
    }
  }
}

TEST_P(ModelBattery, Extremes) {
  for (const double dt : {1e-9, 0.01, 1e6}) {
    const Model unit = GetParam().model(1, 1, 1, dt);
    const auto y = record(unit, 3000, dt, {5, 0});
    double largest = 0;
    for (const double v : y) largest = std::max(largest, std::abs(v));
    ASSERT_TRUE(std::isfinite(largest));
    for (const double scale : {0.0, 1e-30, 1e30}) {
      const Model scaled = GetParam().model(scale, scale, scale, dt);
      const auto z = record(scaled, 3000, dt, {5, 0});
      for (std::size_t k = 0; k < z.size(); k += 13) ASSERT_NEAR(z[k], scale * y[k], scale * largest * 1e-13) << k;
      const ModelMoments moments(scaled, dt), unit_moments(unit, dt);
      for (const std::int64_t m : {1, 1000}) {
        const double expected = scale * scale * unit_moments.allan_variance(m);
        EXPECT_NEAR(moments.allan_variance(m), expected, 1e-13 * expected);
        EXPECT_NEAR(moments.psd(0.1 / dt), scale * scale * unit_moments.psd(0.1 / dt), 1e-13 * moments.psd(0.1 / dt));
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Models, ModelBattery, testing::ValuesIn(kCases),
                         [](const auto& instance) { return instance.param.name; });

// --- Facts behind the paper's tables -----------------------------------------------------------------------

constexpr double kDegree = std::numbers::pi / 180, kHour = 3600;
constexpr double kExact = 1e-12;

TEST(Models, JerathReadsWhatItIsGiven) {
  constexpr std::int64_t kFactor = 1000;
  for (const double dt : {1.0, 0.01, 0.001}) {
    const double tau = kFactor * dt;
    const auto variance = [&](const Jerath& jerath) {
      return ModelMoments(jerath.model(dt), dt).allan_variance(kFactor);
    };
    EXPECT_NEAR(variance({.arw = 2}), 4 / tau, kExact * 4 / tau);
    EXPECT_NEAR(variance({.rrw = 2}), 4 * tau / 3, 4 * tau / 3 * 1e-6);
    const double floor = std::sqrt(2 * std::numbers::ln2 / std::numbers::pi);
    EXPECT_NEAR(std::sqrt(variance({.bias_instability = 2, .taps = 10 * kFactor})), 2 * floor, 2 * floor * 1e-3);
  }
}

TEST(Models, DoubleSidedImuSensorMissesByRootTwo) {
  // Table II: -29.46 % of ARW is 1/sqrt(2) - 1, +35.74 % of RRW the scatter about sqrt(2) - 1.
  for (const double dt : {1.0, 0.01, 0.001}) {
    for (const auto& [type, arw, rrw] : {std::tuple{ImuSensor::NoiseType::double_sided, 0.70711, 1.41421},
                                         std::tuple{ImuSensor::NoiseType::single_sided, 1.0, 1.0}}) {
      ImuSensor sensor{.noise_density = {3, 0, 0}, .noise_type = type};
      const std::int64_t m = 1000;
      const double tau = static_cast<double>(m) * dt;
      EXPECT_NEAR(std::sqrt(ModelMoments(sensor.model(0, dt), dt).allan_variance(m) * tau) / 3, arw, 5e-6);
      sensor = {.random_walk = {0, 0, 3}, .noise_type = type};
      EXPECT_NEAR(std::sqrt(ModelMoments(sensor.model(2, dt), dt).allan_variance(m) * 3 / tau) / 3, rrw, 5e-6);
    }
  }
}

TEST(Models, DefaultImuSensorHasNoFloor) {
  // A first-order autoregression of 1/2: white of N = 2 B sqrt(dt) from a few samples on, whatever the noise
  // type.
  constexpr double kDt = 0.01;
  const ModelMoments moments(ImuSensor{.bias_instability = {1, 0, 0}}.model(0, kDt), kDt);
  EXPECT_NEAR(moments.allan_variance(1), 2. / 3, kExact);
  EXPECT_NEAR(moments.allan_variance(10'000) * 10'000, 4, 1e-3);
  EXPECT_NEAR(moments.psd(1e-3), 4 * kDt, 1e-6);
  const FilterCoefficients defaults, made = fractal_coefficients(1);
  EXPECT_EQ(defaults.numerator, made.numerator);
  EXPECT_EQ(defaults.denominator, made.denominator);
}

TEST(Models, LegacyBielasIsARandomWalkOfTheSampleRate) {
  const auto k_eff = [](double dt) {  // deg/h/sqrt(h), B = 1 deg/h
    const Model model = Bielas{.bias_instability = kDegree / kHour}.model(dt);
    const std::int64_t m = 100'000;
    const double tau = static_cast<double>(m) * dt;
    return std::sqrt(3 * ModelMoments(model, dt).allan_variance(m) / tau) / (kDegree / kHour / std::sqrt(kHour));
  };
  constexpr double kWhole = 2e-9;  // 60/(4 m^2), of tau/3 (1 + 1/(2 m^2))
  EXPECT_NEAR(k_eff(0.01), 6, kWhole);
  EXPECT_NEAR(k_eff(1), 60, kWhole);
  EXPECT_NEAR(k_eff(0.001), 60 * std::sqrt(0.001), kWhole);
  // Table I: 1.7e-3 and 0.70 deg/h give 1.02e-2 and 4.20, read as 1.10e-2 and 4.32.
  EXPECT_NEAR(1.7e-3 * k_eff(0.01), 1.02e-2, 1e-10);
  EXPECT_NEAR(0.70 * k_eff(0.01), 4.20, 1e-8);
}

TEST(Models, LegacyBielasInSamples) {
  // K from the variance of differences, ARW = 0: relative standard deviation sqrt(1/(2 n)) = 2.9e-4 of K.
  constexpr std::size_t kLong = 6'000'000;
  constexpr double kDt = 0.01, kBound = 0.002, kB = 1.7e-3 * kDegree / kHour;
  const auto y = record(Bielas{.bias_instability = kB}.model(kDt), kLong, kDt, {1, 0});
  double squares = 0;
  for (std::size_t k = 1; k < kLong; ++k) squares += (y[k] - y[k - 1]) * (y[k] - y[k - 1]);
  const double k_eff = std::sqrt(squares / (kLong - 1) / kDt);
  const double unit = kDegree / kHour / std::sqrt(kHour);
  EXPECT_NEAR(k_eff / unit / (60 * 1.7e-3 * std::sqrt(kDt)), 1, kBound);
}

TEST(Models, MeanOfManyRecordsIsTheTheoryOfTableOne) {
  // Four records of table I at 100 Hz, 100 seeds, 40 min; at 1 s, near the minimum and on the slope of the walk, the
  // mean is N^2/tau + (2 ln2/pi) B^2 + K^2 tau/3 within 3 standard errors: 12 comparisons, by chance one seed of 30
  // would fail.
  constexpr double kDt = 0.01, kStandardErrors = 3;
  constexpr std::size_t kLong = 240'000, kSeeds = 100;
  const double arw = kDegree / 60, bias = kDegree / kHour, rrw = bias / 60;
  struct Row {
    Model model;
    double n, b, k;      // what it reads as
    double minimum_tau;  // s
  };
  const double n = 5.4e-4 * arw, b = 1.7e-3 * bias, k = 4.32e-2 * rrw;
  const Row rows[] = {
      {Jerath{.arw = n, .bias_instability = b, .rrw = k}.model(kDt), n, b, k, 80},
      {ImuSensor{.noise_density = {n, 0, 0}, .bias_instability = {b, 0, 0}, .random_walk = {k, 0, 0}}.model(0, kDt),
       n / sqrt2, 0, k * sqrt2, 40},
      {Bielas{.arw = n, .bias_instability = b}.model(kDt), n, 0, 60 * 1.7e-3 * std::sqrt(kDt) * rrw, 300},
      {Bielas{.arw = 0.15 * arw, .bias_instability = 0.7 * bias}.model(kDt), 0.15 * arw, 0, 4.2 * rrw, 200}};
  for (const Row& row : rows) {
    const std::array<double, 3> taus = {1, row.minimum_tau, 400};
    std::array<double, 3> sum{}, squares{};
    for (std::size_t seed = 1; seed <= kSeeds; ++seed) {
      std::vector<double> angle = {0};
      for (const double y : record(row.model, kLong, kDt, {seed, 3})) angle.push_back(angle.back() + y);
      for (std::size_t i = 0; i < taus.size(); ++i) {
        const double theory = row.n * row.n / taus[i] + 2 * std::numbers::ln2 / std::numbers::pi * row.b * row.b +
                              row.k * row.k * taus[i] / 3;
        const double ratio = overlapped(angle, std::llround(taus[i] / kDt)) / theory;
        sum[i] += ratio;
        squares[i] += ratio * ratio;
      }
    }
    for (std::size_t i = 0; i < taus.size(); ++i) {
      const double mean = sum[i] / kSeeds;
      const double error = std::sqrt((squares[i] / kSeeds - mean * mean) / (kSeeds - 1));
      EXPECT_NEAR(mean, 1, kStandardErrors * error) << &row - rows << " at " << taus[i] << " s";
      EXPECT_LT(error, 0.07) << "too few records to tell";
    }
  }
}

TEST(Models, OtherReadingsOfBielas) {
  constexpr double kDt = 0.01;
  const auto allan = [](Bielas::Bias bias, std::int64_t m) {
    return ModelMoments(Bielas{.bias_instability = 2, .bias = bias, .correlation_time = 10}.model(kDt), kDt)
        .allan_variance(m);
  };
  EXPECT_NEAR(allan(Bielas::Bias::plain_white, 100), 4. / 100, kExact);
  EXPECT_NEAR(std::sqrt(allan(Bielas::Bias::gauss_markov, 1890)) / 2, 0.617, 1e-3);  // its top
  EXPECT_LT(allan(Bielas::Bias::gauss_markov, 1600), allan(Bielas::Bias::gauss_markov, 1890));
  EXPECT_LT(allan(Bielas::Bias::gauss_markov, 2200), allan(Bielas::Bias::gauss_markov, 1890));
  EXPECT_NEAR(std::sqrt(allan(Bielas::Bias::flicker, 1000)) / 2, 0.664, 1e-3);
  EXPECT_EQ(Bielas{}.model(1).processes.size(), 2u);
  EXPECT_EQ(Bielas{.rrw = 1}.model(1).processes.size(), 3u);
}

TEST(Models, FarSamplesAreStillRight) {
  // 10^9 samples into the record, where white noise jumps; the others run there in constant memory.
  constexpr std::size_t kLong = 100'000;
  Generator white(std::array<Process, 1>{White{1}}, 1, {});
  white.skip(1'000'000'000);
  std::vector<double> y(kLong), expected(kLong);
  white.next(y);
  fill_normal({1, std::uint64_t{'N'} << 48}, 1'000'000'000, expected);
  EXPECT_EQ(y, expected);
  Generator ramp(std::array<Process, 2>{RateRamp{2}, Quantization{0}}, 1, {});
  ramp.skip(1'000'000'000'000);
  ramp.next(std::span(y).first(2));
  EXPECT_EQ(y[1], 2 * (1e12 + 1));
}

// --- The triad ---------------------------------------------------------------------------------------------

TEST(ImuSensor, ReadsByItsFormula) {
  const ImuSensor sensor{.constant_bias = {0.1, 0.2, 0.3},
                         .axes_misalignment = {{{100, 2, 0}, {-1, 110, 0}, {0, 0, 100}}},
                         .temperature_bias = {0.01, 0, 0},
                         .temperature_scale_factor = {0, 0.5, 0},
                         .acceleration_bias = {0, 0, 0.001}};
  const ImuInput input{.signal = {1, 2, 3}, .acceleration = {9, 9, 10}, .temperature = 45};
  const auto reading = read(sensor, input, {1e-3, 2e-3, 3e-3});
  EXPECT_NEAR(reading[0], (1 + 0.02 * 2) + 0.1 + 1e-3 + 20 * 0.01, kExact);
  EXPECT_NEAR(reading[1], ((-0.01 + 1.1 * 2) + 0.2 + 2e-3) * (1 + 0.2 * 0.5), kExact);
  EXPECT_NEAR(reading[2], 3 + 0.3 + 3e-3 + 0.01, kExact);
  const ImuInput still{};
  EXPECT_EQ(read({}, still, {1, 2, 3}), (ImuSensor::Vector{1, 2, 3}));
}

TEST(ImuSensor, SaturatesThenRounds) {
  const ImuSensor sensor{.measurement_range = 1, .resolution = 0.3};
  const auto reading = [&](double x) { return read(sensor, {.signal = {x, x, -x}}, {}); };
  EXPECT_NEAR(reading(0.44)[0], 0.3, kExact);
  EXPECT_NEAR(reading(0.46)[0], 0.6, kExact);
  EXPECT_NEAR(reading(0.46)[2], -0.6, kExact);
  EXPECT_NEAR(reading(50)[0], 0.9, kExact) << "1 / 0.3 rounds to 3";
  EXPECT_EQ(reading(0.1)[1], 0) << "the dead zone";
  EXPECT_EQ(read({.measurement_range = 2}, {.signal = {3, -3, 1}}, {}), (ImuSensor::Vector{2, -2, 1}));
}

TEST(ImuSensor, GeneratorAddsTheNoiseOfEachAxis) {
  constexpr double kDt = 0.01;
  const ImuSensor sensor{.noise_density = {1, 2, 3}, .bias_instability = {0.1, 0, 0}, .random_walk = {0, 1, 0}};
  const std::vector<ImuInput> inputs(3000, {.signal = {10, 20, 30}});
  std::vector<ImuSensor::Vector> whole(inputs.size()), part(inputs.size());
  ImuGenerator(sensor, kDt, {7, 5}).next(inputs, whole);
  for (int axis = 0; axis < 3; ++axis) {
    const auto noise =
        record(sensor.model(axis, kDt), inputs.size(), kDt, {7, 5 | static_cast<std::uint64_t>(axis) << 46});
    const auto i = static_cast<std::size_t>(axis);
    for (std::size_t k = 0; k < noise.size(); ++k) ASSERT_NEAR(whole[k][i], inputs[k].signal[i] + noise[k], 1e-12);
  }
  ImuGenerator later(sensor, kDt, {7, 5});
  later.next(std::span(inputs).first(10), std::span(part).first(10));
  later.skip(1500);
  later.next(std::span(inputs).first(100), std::span(part).first(100));
  EXPECT_TRUE(std::equal(part.begin(), part.begin() + 100, whole.begin() + 1510));
}

TEST(ImuSensor, RoundingAddsItsWhiteNoise) {
  // Resolution q well below the noise: q^2/12 more variance a sample, nearly independent from sample to sample.
  constexpr double kQ = 1, kNoise = 1.5;
  constexpr std::size_t kLong = 200'000;
  const std::vector<ImuInput> inputs(kLong);
  std::vector<ImuSensor::Vector> readings(kLong);
  const ImuSensor sensor{
      .resolution = kQ, .noise_density = {kNoise, 0, 0}, .noise_type = ImuSensor::NoiseType::single_sided};
  ImuGenerator(sensor, 1, {1, 0}).next(inputs, readings);
  double squares = 0;
  for (const auto& y : readings) {
    squares += y[0] * y[0];
    ASSERT_EQ(y[0], std::round(y[0]));
  }
  const double expected = kNoise * kNoise + kQ * kQ / 12;
  EXPECT_NEAR(squares / kLong, expected, 5 * expected * std::sqrt(2. / kLong));
  EXPECT_GT(squares / kLong, kNoise * kNoise + 0.5 * kQ * kQ / 12) << "five standard errors above no rounding";
}

// --- Misuse ------------------------------------------------------------------------------------------------

TEST(Models, RefuseMisuse) {
  EXPECT_THROW((void)Jerath{.taps = 0}.model(1), std::invalid_argument);
  EXPECT_THROW((void)Jerath{.taps = 20'000'000}.model(1), std::invalid_argument);
  EXPECT_THROW((void)Bielas{}.model(0), std::invalid_argument);
  EXPECT_THROW((void)Bielas{.bias = static_cast<Bielas::Bias>(9)}.model(1), std::invalid_argument);
  EXPECT_THROW((void)ImuSensor{}.model(3, 1), std::invalid_argument);
  EXPECT_THROW((void)ImuSensor{}.model(0, NAN), std::invalid_argument);
  EXPECT_THROW((void)fractal_coefficients(1, 2), std::invalid_argument);
  EXPECT_THROW((void)fractal_coefficients(-1), std::invalid_argument);
  const ModelMoments moments(Jerath{.arw = 1, .taps = 5}.model(1), 1);
  EXPECT_THROW((void)moments.allan_variance(0), std::invalid_argument);
  EXPECT_THROW((void)moments.allan_variance(6, 11), std::invalid_argument);
  EXPECT_THROW((void)moments.psd(0.6), std::invalid_argument);
  EXPECT_THROW(ModelMoments({}, 0), std::invalid_argument);
  const std::array<FilteredNoise, 1> bad = {FilteredNoise{1, {1}, {0}}};
  EXPECT_THROW(Generator({}, bad, 1, {}), std::invalid_argument);
}

TEST(ImuSensor, RefusesMisuse) {
  EXPECT_THROW(ImuGenerator({}, 0, {}), std::invalid_argument);
  EXPECT_THROW(ImuGenerator({}, 1, {1, 1ULL << 46}), std::invalid_argument);
  EXPECT_THROW(ImuGenerator({.measurement_range = -1}, 1, {}), std::invalid_argument);
  EXPECT_THROW(ImuGenerator({.measurement_range = NAN}, 1, {}), std::invalid_argument);
  EXPECT_THROW(ImuGenerator({.resolution = -1}, 1, {}), std::invalid_argument);
  EXPECT_THROW(ImuGenerator({.temperature_bias = {0, NAN, 0}}, 1, {}), std::invalid_argument);
  EXPECT_THROW(ImuGenerator({.bias_instability_coefficients = {{1}, {}}}, 1, {}), std::invalid_argument);
  std::vector<ImuSensor::Vector> readings(2);
  EXPECT_THROW(ImuGenerator({}, 1, {}).next(std::vector<ImuInput>(3), readings), std::invalid_argument);
}

}  // namespace
}  // namespace gyrobudget::noise

// SPDX-License-Identifier: MIT
// Every unit that datasheets, ROS, Kalibr, EuRoC, MATLAB and gnss-ins-sim write, with its exact SI factor.
#include "gyrobudget/noise/units.h"

#include "gyrobudget/noise/process.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace gyrobudget::noise {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr long double kDeg = std::numbers::pi_v<long double> / 180;
constexpr long double kG = 9.80665L;
constexpr long double kRtHour = 60;

constexpr Dimension kArw{2, 0, -1}, kRrw{2, 0, -3}, kRamp{2, 0, -4};
constexpr Dimension kVrw{0, 2, -3}, kAccelRw{0, 2, -5};

struct Spelling {
  const char* text;
  long double si;
  Dimension dimension;
};

const std::vector<Spelling> kSpellings = {
    // angular rate
    {"rad/s", 1, dimension::kAngularRate},
    {"rad s^-1", 1, dimension::kAngularRate},
    {"rad s-1", 1, dimension::kAngularRate},
    {"rad*s^-1", 1, dimension::kAngularRate},
    {"rad.s^-1", 1, dimension::kAngularRate},
    {"m.s^-2", 1, dimension::kSpecificForce},
    {"rad·s⁻¹", 1, dimension::kAngularRate},
    {"rad/sec", 1, dimension::kAngularRate},
    {"radians/second", 1, dimension::kAngularRate},
    {"mrad/s", 1e-3L, dimension::kAngularRate},
    {"deg/s", kDeg, dimension::kAngularRate},
    {"deg/sec", kDeg, dimension::kAngularRate},
    {"degrees per second", kDeg, dimension::kAngularRate},
    {"°/s", kDeg, dimension::kAngularRate},
    {"º/s", kDeg, dimension::kAngularRate},
    {"dps", kDeg, dimension::kAngularRate},
    {"DPS", kDeg, dimension::kAngularRate},
    {"mdps", kDeg / 1000, dimension::kAngularRate},
    {"mdeg/s", kDeg / 1000, dimension::kAngularRate},
    {"deg/min", kDeg / 60, dimension::kAngularRate},
    {"deg/h", kDeg / 3600, dimension::kAngularRate},
    {"deg/hr", kDeg / 3600, dimension::kAngularRate},
    {"DEG/HR", kDeg / 3600, dimension::kAngularRate},
    {"deg/hour", kDeg / 3600, dimension::kAngularRate},
    {"deg h^-1", kDeg / 3600, dimension::kAngularRate},
    {"°/h", kDeg / 3600, dimension::kAngularRate},
    {"°/hr", kDeg / 3600, dimension::kAngularRate},
    {"dph", kDeg / 3600, dimension::kAngularRate},
    {" deg / h ", kDeg / 3600, dimension::kAngularRate},
    {"arcsec/s", kDeg / 3600, dimension::kAngularRate},
    {"rpm", kDeg * 6, dimension::kAngularRate},
    {"rev/min", kDeg * 6, dimension::kAngularRate},
    {"meru", 7.292115e-8L, dimension::kAngularRate},
    // angle random walk
    {"deg/sqrt(h)", kDeg / kRtHour, kArw},
    {"deg/sqrt(hr)", kDeg / kRtHour, kArw},
    {"deg/sqrt(hour)", kDeg / kRtHour, kArw},
    {"deg/sqrt h", kDeg / kRtHour, kArw},
    {"deg/sqrthr", kDeg / kRtHour, kArw},
    {"°/√h", kDeg / kRtHour, kArw},
    {"°/√hr", kDeg / kRtHour, kArw},
    {"°/√(h)", kDeg / kRtHour, kArw},
    {"deg/√h", kDeg / kRtHour, kArw},
    {"deg/rt-hr", kDeg / kRtHour, kArw},
    {"deg/rt hr", kDeg / kRtHour, kArw},
    {"deg/rthr", kDeg / kRtHour, kArw},
    {"deg/rt(h)", kDeg / kRtHour, kArw},
    {"deg/root-hour", kDeg / kRtHour, kArw},
    {"deg per root hour", kDeg / kRtHour, kArw},
    {"deg/h^0.5", kDeg / kRtHour, kArw},
    {"deg/h^1/2", kDeg / kRtHour, kArw},
    {"deg/h^(1/2)", kDeg / kRtHour, kArw},
    {"deg h^-1/2", kDeg / kRtHour, kArw},
    {"deg/h^½", kDeg / kRtHour, kArw},
    {"deg/h½", kDeg / kRtHour, kArw},
    {"deg/sqrt(s)", kDeg, kArw},
    {"deg/h/sqrt(Hz)", kDeg / 3600, kArw},
    {"(deg/h)/sqrt(Hz)", kDeg / 3600, kArw},
    {"(deg/h)/√Hz", kDeg / 3600, kArw},
    {"°/h/√Hz", kDeg / 3600, kArw},
    {"deg/hr/rt-Hz", kDeg / 3600, kArw},
    {"deg/s/sqrt(Hz)", kDeg, kArw},
    {"°/s/√Hz", kDeg, kArw},
    {"(°/s)/√Hz", kDeg, kArw},
    {"dps/√Hz", kDeg, kArw},
    {"dps/rtHz", kDeg, kArw},
    {"mdps/√Hz", kDeg / 1000, kArw},
    {"mdps/rtHz", kDeg / 1000, kArw},
    {"rad/s/sqrt(Hz)", 1, kArw},
    {"rad/s/√Hz", 1, kArw},
    {"(rad/s)/√Hz", 1, kArw},
    {"rad/s/Hz^0.5", 1, kArw},
    {"rad/sqrt(s)", 1, kArw},
    {"rad/√s", 1, kArw},
    {"rad s^-0.5", 1, kArw},
    {"sqrt(rad^2/s)", 1, kArw},
    // rate random walk and ramp
    {"deg/h/sqrt(h)", kDeg / 3600 / kRtHour, kRrw},
    {"deg/hr/sqrt(hr)", kDeg / 3600 / kRtHour, kRrw},
    {"°/h/√h", kDeg / 3600 / kRtHour, kRrw},
    {"deg/hr/rt-hr", kDeg / 3600 / kRtHour, kRrw},
    {"(deg/h)/√h", kDeg / 3600 / kRtHour, kRrw},
    {"deg/h^1.5", kDeg / 3600 / kRtHour, kRrw},
    {"deg/h^(3/2)", kDeg / 3600 / kRtHour, kRrw},
    {"deg/h^3/2", kDeg / 3600 / kRtHour, kRrw},
    {"deg/h/sqrt(s)", kDeg / 3600, kRrw},
    {"deg/s/sqrt(s)", kDeg, kRrw},
    {"rad/s/sqrt(s)", 1, kRrw},
    {"rad/s^2/sqrt(Hz)", 1, kRrw},
    {"rad/s²/√Hz", 1, kRrw},
    {"(rad/s)*√Hz", 1, {2, 0, -3}},
    {"deg/h/h", kDeg / 3600 / 3600, kRamp},
    {"deg/h^2", kDeg / 3600 / 3600, kRamp},
    {"deg/(h*h)", kDeg / 3600 / 3600, kRamp},
    {"rad/s^2", 1, kRamp},
    // angles
    {"rad", 1, dimension::kAngle},
    {"mrad", 1e-3L, dimension::kAngle},
    {"urad", 1e-6L, dimension::kAngle},
    {"µrad", 1e-6L, dimension::kAngle},  // U+00B5 micro sign
    {"μrad", 1e-6L, dimension::kAngle},  // U+03BC Greek mu
    {"nrad", 1e-9L, dimension::kAngle},
    {"deg", kDeg, dimension::kAngle},
    {"degrees", kDeg, dimension::kAngle},
    {"°", kDeg, dimension::kAngle},
    {"arcmin", kDeg / 60, dimension::kAngle},
    {"′", kDeg / 60, dimension::kAngle},
    {"'", kDeg / 60, dimension::kAngle},
    {"arcsec", kDeg / 3600, dimension::kAngle},
    {"arc-sec", kDeg / 3600, dimension::kAngle},
    {"arc sec", kDeg / 3600, dimension::kAngle},
    {"arcseconds", kDeg / 3600, dimension::kAngle},
    {"″", kDeg / 3600, dimension::kAngle},
    {"\"", kDeg / 3600, dimension::kAngle},
    {"''", kDeg / 3600, dimension::kAngle},
    {"mas", kDeg / 3600 / 1000, dimension::kAngle},
    // accelerometers
    {"m/s^2", 1, dimension::kSpecificForce},
    {"m/s²", 1, dimension::kSpecificForce},
    {"m/s2", 1, dimension::kSpecificForce},
    {"m/s/s", 1, dimension::kSpecificForce},
    {"m s^-2", 1, dimension::kSpecificForce},
    {"m s-2", 1, dimension::kSpecificForce},
    {"m·s⁻²", 1, dimension::kSpecificForce},
    {"m*s**-2", 1, dimension::kSpecificForce},
    {"g", kG, dimension::kSpecificForce},
    {"mg", kG / 1000, dimension::kSpecificForce},
    {"ug", kG / 1'000'000, dimension::kSpecificForce},
    {"µg", kG / 1'000'000, dimension::kSpecificForce},
    {"ng", kG / 1'000'000'000, dimension::kSpecificForce},
    {"Gal", 0.01L, dimension::kSpecificForce},
    {"mGal", 1e-5L, dimension::kSpecificForce},
    {"mgal", 1e-5L, dimension::kSpecificForce},
    {"cm/s^2", 0.01L, dimension::kSpecificForce},
    {"ft/s^2", 0.3048L, dimension::kSpecificForce},
    {"m/s/sqrt(h)", 1 / kRtHour, kVrw},
    {"m/s/sqrt(hr)", 1 / kRtHour, kVrw},
    {"m/s/√h", 1 / kRtHour, kVrw},
    {"m/s/rt-hr", 1 / kRtHour, kVrw},
    {"ft/s/√hr", 0.3048L / kRtHour, kVrw},
    {"ug/sqrt(Hz)", kG / 1'000'000, kVrw},
    {"µg/√Hz", kG / 1'000'000, kVrw},
    {"ug/rtHz", kG / 1'000'000, kVrw},
    {"mg/√Hz", kG / 1000, kVrw},
    {"m/s^2/sqrt(Hz)", 1, kVrw},
    {"(m/s^2)/√Hz", 1, kVrw},
    {"m/s^1.5", 1, kVrw},
    {"ug/sqrt(h)", kG / 1'000'000 / kRtHour, kAccelRw},
    {"m/s^3/sqrt(Hz)", 1, kAccelRw},
    {"m/s^2*sqrt(Hz)", 1, kAccelRw},
    {"ug/h", kG / 1'000'000 / 3600, {0, 2, -6}},
    {"m/s", 1, dimension::kVelocity},
    {"ft/s", 0.3048L, dimension::kVelocity},
    {"deg/h/g", kDeg / 3600 / kG, {2, -2, 2}},
    {"(deg/h)/g", kDeg / 3600 / kG, {2, -2, 2}},
    // masses, forces, moments
    {"kg", 1, dimension::kMass},
    {"t", 1000, dimension::kMass},
    {"N", 1, dimension::kForce},
    {"kN", 1000, dimension::kForce},
    {"kg m/s^2", 1, dimension::kForce},
    {"kg g", kG, dimension::kForce},
    {"N m", 1, dimension::kMoment},
    {"N*m", 1, dimension::kMoment},
    {"kNm", 1000, dimension::kMoment},
    {"kg m^2", 1, dimension::kInertia},
    {"kg·m²", 1, dimension::kInertia},
    {"m^2", 1, dimension::kArea},
    {"cm^2", 1e-4L, dimension::kArea},
    {"kPa", 1000, {0, -2, -4, 2}},
    {"N/m^2", 1, {0, -2, -4, 2}},
    {"1/rad", 1, {-2, 0, 0}},
    {"K", 1, dimension::kTemperature},
    {"°C", 1, dimension::kTemperature},
    {"deg C", 1, dimension::kTemperature},
    {"celsius", 1, dimension::kTemperature},
    {"deg/h/K", kDeg / 3600, {2, 0, -2, 0, -2}},
    {"deg/h/(K/min)", kDeg / 60, {2, 0, 0, 0, -2}},
    {"rad/m", 1, {2, -2, 0}},
    // numbers, times, frequencies
    {"1", 1, dimension::kNumber},
    {"dimensionless", 1, dimension::kNumber},
    {"%", 0.01L, dimension::kNumber},
    {"ppm", 1e-6L, dimension::kNumber},
    {"PPM", 1e-6L, dimension::kNumber},
    {"ppb", 1e-9L, dimension::kNumber},
    {"1/sqrt(Hz)", 1, {0, 0, 1}},
    {"1/√s", 1, {0, 0, -1}},
    {"s", 1, dimension::kTime},
    {"sec", 1, dimension::kTime},
    {"ms", 1e-3L, dimension::kTime},
    {"msec", 1e-3L, dimension::kTime},
    {"us", 1e-6L, dimension::kTime},
    {"µs", 1e-6L, dimension::kTime},
    {"ns", 1e-9L, dimension::kTime},
    {"min", 60, dimension::kTime},
    {"h", 3600, dimension::kTime},
    {"hr", 3600, dimension::kTime},
    {"day", 86400, dimension::kTime},
    {"Hz", 1, dimension::kFrequency},
    {"hz", 1, dimension::kFrequency},
    {"kHz", 1000, dimension::kFrequency},
    {"MHz", 1e6L, dimension::kFrequency},
    {"1/s", 1, dimension::kFrequency},
    {"s^-1", 1, dimension::kFrequency},
};

TEST(Units, EverySpellingHasItsExactFactor) {
  for (const Spelling& s : kSpellings) {
    const Unit unit = parse_unit(s.text);
    EXPECT_NEAR(unit.to_si, static_cast<double>(s.si), kEpsilon / 2 * static_cast<double>(s.si)) << s.text;
    EXPECT_EQ(unit.dimension, s.dimension) << s.text;
  }
}

TEST(Units, QuantitiesComeBackAsWritten) {
  for (const Spelling& s : kSpellings) {
    for (const char* number : {"1.234", "0.001234", "9876", "1.234e-09", "-5.670"}) {
      const std::string text = std::string(number) + " " + s.text;
      const double si = parse_quantity(text, s.dimension);
      EXPECT_NEAR(from_si(si, s.text), std::stod(number), 2 * kEpsilon * std::abs(std::stod(number))) << text;
      EXPECT_EQ(quantity_text(si, s.text), std::string(s.text) == "1" ? number : text);
    }
  }
}

TEST(Units, PrintsSignificantDigits) {
  EXPECT_EQ(quantity_text(8.24e-9, "deg/h", 3), "0.00170 deg/h");
  EXPECT_EQ(quantity_text(1000, "s", 4), "1000 s");
  EXPECT_EQ(quantity_text(1000, "s", 5), "1000.0 s");
  EXPECT_EQ(quantity_text(1000, "s", 3), "1.00e+03 s");
  EXPECT_EQ(quantity_text(1e6, "1", 1), "1e+06");
  EXPECT_EQ(quantity_text(0.2, "1", 1), "0.2");
  EXPECT_EQ(quantity_text(-0.2, "1", 2), "-0.20");
  EXPECT_EQ(quantity_text(7, "m", 1), "7 m");
  EXPECT_EQ(quantity_text(0, "deg/h"), "0 deg/h");
  EXPECT_EQ(quantity_text(-0.0, "deg/h"), "0 deg/h");
  EXPECT_EQ(quantity_text(NAN, "1"), "nan");
  EXPECT_EQ(quantity_text(INFINITY, "s"), "inf s");
  EXPECT_EQ(quantity_text(-INFINITY, "s"), "-inf s");
  EXPECT_THROW((void)quantity_text(1, "s", 0), std::invalid_argument);
  EXPECT_THROW((void)quantity_text(1, "s", 18), std::invalid_argument);
}

TEST(Units, NumberAndUnitMayTouch) {
  EXPECT_EQ(parse_quantity("5ms", dimension::kTime), 5 * 1e-3);
  EXPECT_EQ(parse_quantity("  +2 s\t", dimension::kTime), 2);
  EXPECT_EQ(parse_quantity("-2e3s", dimension::kTime), -2000);
  EXPECT_EQ(parse_quantity("20\"", dimension::kAngle), 20 * parse_unit("arcsec").to_si);
  EXPECT_EQ(parse_quantity("7 1", dimension::kNumber), 7);
  EXPECT_EQ(parse_quantity("3 1/s", dimension::kFrequency), 3);
}

// --- The three unit traps of the field ---------------------------------------------------------------------

TEST(UnitTraps, RateRandomWalkIsReadAtThreeSecondsOrThreeHours) {
  // On the +1/2 line the deviation equals K at tau = 3 of the time unit under K's root: 3 s or 3 h, a factor
  // of 60.
  const double per_hour = parse_quantity("4.32e-2 deg/h/sqrt(h)", kRrw);
  EXPECT_NEAR(from_si(per_hour, "deg/h/sqrt(s)"), 7.2e-4, 4 * kEpsilon * 7.2e-4);
  EXPECT_NEAR(per_hour, 3.490659e-9, 1e-15);
  EXPECT_NEAR(from_si(1, "deg/h/sqrt(h)") / from_si(1, "deg/h/sqrt(s)"), 60, 60 * 4 * kEpsilon);
  constexpr double kDt = 1e-3;  // fine enough for the continuous line
  constexpr double kDiscrete = 1e-7;
  const double k = 1 * parse_unit("deg/h/sqrt(s)").to_si;
  EXPECT_NEAR(from_si(std::sqrt(allan_variance(RateRandomWalk{k}, 3000, kDt)), "deg/h"), 1, kDiscrete);
}

TEST(UnitTraps, AngleRandomWalkIsTwoSided) {
  // With the two-sided density N^2 the variance of samples is N^2 fs = integral over -fs/2 .. fs/2; a
  // one-sided density of the same number would make it half as much (the sqrt 2 of double-sided simulators).
  const double n = parse_quantity("0.15 deg/sqrt(h)", kArw);
  EXPECT_NEAR(from_si(n, "deg/h/sqrt(Hz)"), 9, 9 * 4 * kEpsilon);  // factor 60, not 60 sqrt(2)
  EXPECT_NEAR(n, 4.363323e-5, 1e-11);
  constexpr double kDt = 0.01;
  const double sample_variance = allan_variance(White{n}, 1, kDt);
  EXPECT_NEAR(2 * (0.5 / kDt) * psd(White{n}, 1, kDt), sample_variance, 4 * kEpsilon * sample_variance);
  // ADEV at 1 s is N in deg/h/sqrt(Hz).
  EXPECT_NEAR(from_si(std::sqrt(allan_variance(White{n}, 100, kDt)), "deg/h"), 9, 9 * 8 * kEpsilon);
}

TEST(UnitTraps, RandomWalkUnitsTellAngleFromRate) {
  // MATLAB's RandomWalk is (rad/s)*sqrt(Hz), a rate random walk; its NoiseDensity (rad/s)/sqrt(Hz) is the
  // angle's. One sign in the unit apart, so the dimension must refuse the exchange.
  EXPECT_EQ(parse_unit("(rad/s)*sqrt(Hz)").dimension, parse_unit("rad/s/sqrt(s)").dimension);
  EXPECT_EQ(parse_unit("(rad/s)/sqrt(Hz)").dimension, parse_unit("rad/sqrt(s)").dimension);
  EXPECT_THROW((void)parse_quantity("1 (rad/s)*sqrt(Hz)", kArw), std::invalid_argument);
  EXPECT_THROW((void)parse_quantity("1 deg/h/sqrt(Hz)", kRrw), std::invalid_argument);
  EXPECT_THROW((void)parse_quantity("1 deg/h", kArw), std::invalid_argument);
  EXPECT_THROW((void)parse_quantity("1 Hz", dimension::kAngularRate),
               std::invalid_argument);  // angle is a dimension
}

// --- Refusals ----------------------------------------------------------------------------------------------

std::string refusal_of_unit(std::string_view text) {
  try {
    (void)parse_unit(text);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

std::string refusal_of_quantity(std::string_view text, const Dimension& expected) {
  try {
    (void)parse_quantity(text, expected);
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

TEST(Units, RefusalsNameTheFindingAndTheNearestSpelling) {
  EXPECT_EQ(refusal_of_unit("deg/hrr"), "unit 'deg/hrr': 'hrr' is no known unit (did you mean 'hr'?)");
  EXPECT_EQ(refusal_of_unit("deg/H"), "unit 'deg/H': 'H' is no known unit (did you mean 'h'?)");
  EXPECT_EQ(refusal_of_unit("G"), "unit 'G': 'G' is no known unit (did you mean 'g'?)");
  EXPECT_EQ(refusal_of_unit("MG"), "unit 'MG': 'MG' is no known unit (did you mean 'mg'?)");
  EXPECT_EQ(refusal_of_unit("degree/hou"), "unit 'degree/hou': 'hou' is no known unit (did you mean 'hour'?)");
  EXPECT_EQ(refusal_of_unit("furlong"), "unit 'furlong': 'furlong' is no known unit");
  EXPECT_EQ(refusal_of_unit(""), "unit '': there is no unit; write 1 for a plain number");
  EXPECT_EQ(refusal_of_unit("deg/"), "unit 'deg/': it stops where a name was expected");
  EXPECT_EQ(refusal_of_unit("deg//h"), "unit 'deg//h': found '/h' where a name was expected");
  EXPECT_EQ(refusal_of_unit("sqrt(h"), "unit 'sqrt(h': a parenthesis is not closed");
  EXPECT_EQ(refusal_of_unit("deg)"), "unit 'deg)': found ')' behind a complete unit");
  EXPECT_EQ(refusal_of_unit("s^"), "unit 's^': an exponent is missing or unreadable");
  EXPECT_EQ(refusal_of_unit("s^0.3"), "unit 's^0.3': an exponent must be a whole or half number up to 16");
  EXPECT_EQ(refusal_of_unit("s^1/0"), "unit 's^1/0': an exponent must be a whole or half number up to 16");
  EXPECT_EQ(refusal_of_unit("sqrt(sqrt(s))"), "unit 'sqrt(sqrt(s))': a fourth root is in no unit of a sensor");
  EXPECT_EQ(refusal_of_unit("((((m^16)^16)^16)^16)^16"),
            "unit '((((m^16)^16)^16)^16)^16': its size or powers are beyond reason");
  EXPECT_EQ(refusal_of_unit("counts"),
            "unit 'counts': 'counts' has no size of its own; give the size of one as a scale (--scale) and its unit");
  for (const char* raw : {"LSB", "count", "digit", "mV", "raw"}) {
    EXPECT_NE(refusal_of_unit(raw).find("--scale"), std::string::npos) << raw;
  }
}

TEST(Units, RefusesQuantitiesWithWhatWouldDo) {
  EXPECT_EQ(refusal_of_quantity("5.4e-4", kArw),
            "'5.4e-4' has no unit; expected one like deg/sqrt(h), deg/h/sqrt(Hz), rad/s/sqrt(Hz)");
  EXPECT_EQ(
      refusal_of_quantity("5.4e-4 deg/h", kArw),
      "'5.4e-4 deg/h' has a unit of the wrong kind (the kind of deg/h, deg/s, rad/s); expected one like deg/sqrt(h), deg/h/sqrt(Hz), rad/s/sqrt(Hz)");
  EXPECT_EQ(refusal_of_quantity("abc deg/h", dimension::kAngularRate),
            "'abc deg/h' does not start with a finite number; expected a number and a unit (deg/h, deg/s, rad/s)");
  for (const char* bad :
       {"", " ", "nan deg/h", "inf deg/h", "1e999 deg/h", "1e307 dps s/us", "--1 deg/h", "+-1 deg/h", "1,5 deg/h"}) {
    EXPECT_NE(refusal_of_quantity(bad, dimension::kAngularRate), "accepted") << bad;
  }
  EXPECT_EQ(example_units({4, 0, -2}), "rad^2 s^-1");
}

TEST(Units, NestingIsBoundedByLength) {
  const std::string deep(99, '('), closed(99, ')');
  EXPECT_EQ(parse_unit(deep + "s" + closed).dimension, dimension::kTime);
  EXPECT_THROW((void)parse_unit(std::string(1'000'000, '(')), std::invalid_argument);
  EXPECT_THROW((void)parse_unit(std::string(200, '(')), std::invalid_argument);
  EXPECT_LT(refusal_of_unit(std::string(1'000'000, 'x')).size(), 200u);
}

TEST(Units, AnyBytesAreReadOrRefused) {
  // Half pure bytes, half tokens of the grammar in random order, which reach much deeper.
  const std::vector<std::string> tokens = {"deg", "/",  "h", "sqrt", "(", ")",  "^", "-",   "1",  "2",
                                           "½",   "²",  "⁻", "√",    "g", "Hz", " ", "*",   "·",  "rt",
                                           "per", "16", ".", "m",    "°", "\"", "%", "arc", "sec"};
  std::mt19937_64 random(20260101);
  int accepted = 0;
  constexpr int kTrials = 40'000;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::string text;
    for (std::uint64_t length = random() % 12; length > 0; --length) {
      text += trial % 2 == 0 ? std::string(1, static_cast<char>(random())) : tokens[random() % tokens.size()];
    }
    try {
      const Unit unit = parse_unit(text);
      ++accepted;
      ASSERT_TRUE(std::isnormal(unit.to_si) && unit.to_si > 0) << text;
    } catch (const std::invalid_argument&) {
    }
    try {
      (void)parse_quantity("1 " + text, dimension::kNumber);
    } catch (const std::invalid_argument&) {
    }
  }
  EXPECT_GT(accepted, kTrials / 100);
  EXPECT_LT(accepted, kTrials / 2);
}

}  // namespace
}  // namespace gyrobudget::noise

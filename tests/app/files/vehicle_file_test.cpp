// SPDX-License-Identifier: MIT
#include "gyrobudget/app/files/vehicle_file.h"

#include "gyrobudget/vehicle/earth/ellipsoid.h"

#include <algorithm>

#include "../temporary.h"

namespace gyrobudget::app_tests {
namespace {

using earth::kDegree;
using flight::LookupTable;
using flight::Origin;
using flight::Vehicle;
using text::InputError;

const std::string kExamples = GYROBUDGET_EXAMPLES "/vehicles/";

/// What a vehicle needs and nothing more.
const std::string kLeast =
    "lift_off_mass: 2 t\npropellant: 1500 kg\nburn_time: 1 min\nspecific_impulse: 250 s\n"
    "centre_of_mass: 3 m\nroll_inertia: 300 kg m^2\npitch_inertia: [[0, 9e3 kg m^2], [1, 5e3 kg m^2]]\n";

class VehicleFile : public TemporaryFolder {
 protected:
  [[nodiscard]] files::VehicleFile read(std::string_view text) const {
    return files::read_vehicle(file("vehicle.yaml", text));
  }
  [[nodiscard]] std::string message(std::string_view text) const {
    return message_of<InputError>([&] { (void)read(text); });
  }
  /// Of a vehicle that has these lines too.
  [[nodiscard]] std::string message_with(const std::string& lines) const { return message(kLeast + lines); }
};

const files::VehicleNumber& number(const files::VehicleFile& file, std::string_view key) {
  const auto at = std::ranges::find(file.numbers, key, &files::VehicleNumber::key);
  if (at == file.numbers.end()) throw std::out_of_range(std::string(key));
  return *at;
}

/// To the last bit: the points, and values between them.
void expect_same(const LookupTable& a, const LookupTable& b, const char* what) {
  EXPECT_EQ(a.points(), b.points()) << what;
  for (double x = -0.01; x < 6; x += 0.013) ASSERT_EQ(a(x), b(x)) << what << " at " << x;
}

void expect_same(const Vehicle& a, const Vehicle& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.lift_off_mass, b.lift_off_mass);
  EXPECT_EQ(a.propellant, b.propellant);
  EXPECT_EQ(a.burn_time, b.burn_time);
  EXPECT_EQ(a.specific_impulse, b.specific_impulse);
  expect_same(a.thrust_shape, b.thrust_shape, "thrust_shape");
  EXPECT_EQ(a.exit_area, b.exit_area);
  EXPECT_EQ(a.reference_area, b.reference_area);
  expect_same(a.axial_drag, b.axial_drag, "axial_drag");
  EXPECT_EQ(a.normal_force_slope, b.normal_force_slope);
  EXPECT_EQ(a.pressure_ahead, b.pressure_ahead);
  expect_same(a.centre_of_mass, b.centre_of_mass, "centre_of_mass");
  expect_same(a.roll_inertia, b.roll_inertia, "roll_inertia");
  expect_same(a.pitch_inertia, b.pitch_inertia, "pitch_inertia");
  expect_same(a.yaw_inertia, b.yaw_inertia, "yaw_inertia");
  EXPECT_EQ(a.imu_station, b.imu_station);
  EXPECT_EQ(a.actuator.frequency, b.actuator.frequency);
  EXPECT_EQ(a.actuator.damping, b.actuator.damping);
  EXPECT_EQ(a.actuator.deflection_limit, b.actuator.deflection_limit);
  EXPECT_EQ(a.actuator.rate_limit, b.actuator.rate_limit);
  EXPECT_EQ(a.actuator.delay, b.actuator.delay);
  EXPECT_EQ(a.roll_moment_limit, b.roll_moment_limit);
  ASSERT_EQ(a.bending.has_value(), b.bending.has_value());
  if (!a.bending) return;
  expect_same(a.bending->frequency, b.bending->frequency, "bending.frequency");
  EXPECT_EQ(a.bending->damping, b.bending->damping);
  EXPECT_EQ(a.bending->gimbal_deflection, b.bending->gimbal_deflection);
  EXPECT_EQ(a.bending->slope_at_imu, b.bending->slope_at_imu);
}

TEST_F(VehicleFile, TheExampleIsTheLibrarysVlm1WithItsBending) {
  Vehicle expected = flight::vlm1();
  expected.bending.emplace();
  const files::VehicleFile file = files::read_vehicle(kExamples + "vlm1.yaml");
  expect_same(file.vehicle, expected);
  EXPECT_TRUE(file.left_out.empty());
}

TEST_F(VehicleFile, TheVehicleOfThePapersScaleIsTheLibrarysToo) {
  const files::VehicleFile file = files::read_vehicle(kExamples + "vlm1-paper.yaml");
  expect_same(file.vehicle, flight::vlm1_paper());
  ASSERT_EQ(file.left_out.size(), 1U);
  EXPECT_EQ(file.left_out[0].key, "bending");
  // What is not of the three numbers keeps what vlm1.yaml says of it.
  EXPECT_EQ(number(file, "propellant").origin, Origin::sourced);
  for (const char* chosen : {"lift_off_mass", "specific_impulse", "exit_area"}) {
    EXPECT_EQ(number(file, chosen).origin, Origin::assumed) << chosen;
    EXPECT_EQ(number(file, chosen).reason, "chosen to match the paper's scale, not data") << chosen;
  }
}

TEST_F(VehicleFile, TheExampleSaysOfEachNumberWhatTheLibrarySays) {
  const files::VehicleFile file = files::read_vehicle(kExamples + "vlm1.yaml");
  constexpr int kNumbers = 25;  // of Vehicle, Actuator and Bending together
  EXPECT_EQ(file.numbers.size(), kNumbers);
  std::size_t at = 0;
  for (const flight::Provenance& p : flight::vlm1_provenance()) {
    const std::string member(p.number);
    int found = 0;
    for (; at < file.numbers.size(); ++at, ++found) {
      const files::VehicleNumber& n = file.numbers[at];
      if (n.key != member && !n.key.starts_with(member + ".")) break;
      EXPECT_EQ(n.origin, p.origin) << n.key;
      EXPECT_EQ(n.reason, p.reason) << n.key;
      EXPECT_FALSE(n.value.empty()) << n.key;
    }
    EXPECT_GE(found, 1) << member;
  }
  EXPECT_EQ(at, file.numbers.size());
}

TEST_F(VehicleFile, TheHelpIsAVehicleWithEveryKey) {
  const files::VehicleFile file = read(files::vehicle_help());
  const Vehicle& v = file.vehicle;
  EXPECT_EQ(v.name, "sounding rocket");
  EXPECT_TRUE(file.left_out.empty());
  EXPECT_EQ(file.numbers.size(), files::read_vehicle(kExamples + "vlm1.yaml").numbers.size());
  EXPECT_EQ(v.lift_off_mass, 1200);
  EXPECT_EQ(number(file, "lift_off_mass").value, "1.2 t");
  EXPECT_EQ(number(file, "propellant").origin, Origin::derived);
  EXPECT_EQ(number(file, "burn_time").origin, std::nullopt);
  EXPECT_EQ(number(file, "burn_time").reason, "");
  expect_same(v.axial_drag, LookupTable::smooth({{0, 0.3}, {0.9, 0.4}, {1.1, 0.5}, {4, 0.2}}), "axial_drag");
  EXPECT_EQ(number(file, "axial_drag").value, "0: 0.3, 0.9: 0.4, 1.1: 0.5, 4: 0.2, smooth");
  EXPECT_EQ(number(file, "centre_of_mass").value, "0: 3 m, 1: 4 m");
  // A number of a group has the group's origin, or its own.
  EXPECT_EQ(number(file, "actuator.frequency").origin, Origin::sourced);
  EXPECT_EQ(number(file, "actuator.frequency").reason, "maker's data sheet");
  EXPECT_EQ(number(file, "actuator.delay").origin, Origin::assumed);
  EXPECT_EQ(number(file, "actuator.delay").reason, "one period of the computer");
  EXPECT_DOUBLE_EQ(v.actuator.delay, 0.01);
  ASSERT_TRUE(v.bending);
  EXPECT_EQ(v.bending->slope_at_imu, -0.9);
}

TEST_F(VehicleFile, WhatIsLeftOutIsWhatTheHelpSaysAndIsListed) {
  const files::VehicleFile file = read(kLeast);
  const Vehicle& v = file.vehicle;
  EXPECT_EQ(v.thrust_shape(0.3), 1);
  EXPECT_EQ(v.exit_area, 0);
  EXPECT_EQ(v.reference_area, 0);
  EXPECT_EQ(v.roll_moment_limit, 0);
  EXPECT_EQ(v.imu_station, 3);
  expect_same(v.yaw_inertia, v.pitch_inertia, "yaw_inertia");
  EXPECT_FALSE(v.bending);
  const flight::Actuator usual;
  EXPECT_EQ(v.actuator.frequency, usual.frequency);
  EXPECT_EQ(usual.frequency, 4);
  EXPECT_EQ(usual.damping, 0.7);
  EXPECT_EQ(usual.deflection_limit, 3 * kDegree);
  EXPECT_EQ(usual.rate_limit, 15 * kDegree);
  EXPECT_EQ(usual.delay, 0);
  EXPECT_EQ(file.numbers.size(), 7U);
  EXPECT_EQ(file.left_out.size(), 15U);
  EXPECT_EQ(file.left_out.front().key, "thrust_shape");
  EXPECT_EQ(file.left_out.front().meaning, "constant thrust");
  EXPECT_EQ(file.left_out.back().key, "bending");
  EXPECT_EQ(file.left_out.back().meaning, "rigid");
}

TEST_F(VehicleFile, OriginsHaveWords) {
  EXPECT_EQ(files::to_string(Origin::sourced), "sourced");
  EXPECT_EQ(files::to_string(Origin::derived), "derived");
  EXPECT_EQ(files::to_string(Origin::assumed), "assumed");
  EXPECT_EQ(files::to_string(std::nullopt), "not stated");
}

TEST_F(VehicleFile, AVehicleBasedOnAnotherKeepsWhatItDoesNotGive) {
  (void)file(
      "base.yaml",
      kLeast +
          "actuator: {frequency: 6 Hz, delay: 5 ms}\n"
          "bending: {frequency: 5 Hz, damping: 1 %, gimbal_deflection: 2, slope_at_imu: 1 deg/m, origin: derived, reason: beam}\n");
  const files::VehicleFile stiffer = read(
      "based_on: base.yaml\nactuator: {frequency: 9 Hz, origin: assumed, reason: study}\n"
      "pitch_inertia: 7e3 kg m^2\n");
  EXPECT_EQ(stiffer.vehicle.actuator.frequency, 9);
  EXPECT_EQ(stiffer.vehicle.actuator.delay, 5 * 0.001);
  EXPECT_EQ(number(stiffer, "actuator.frequency").origin, Origin::assumed);
  EXPECT_EQ(number(stiffer, "actuator.delay").origin, std::nullopt);
  EXPECT_EQ(stiffer.vehicle.yaw_inertia(0), 7e3);  // still as pitch
  EXPECT_EQ(number(stiffer, "bending.damping").reason, "beam");
  // A chain, and bending taken out and put back.
  (void)file("rigid.yaml", "based_on: base.yaml\nbending: none\n");
  EXPECT_FALSE(read("based_on: rigid.yaml\n").vehicle.bending);
  EXPECT_CONTAINS(
      message("based_on: rigid.yaml\nbending: {frequency: 5 Hz}\n"),
      "vehicle.yaml:2:10: found no bending.damping, bending.gimbal_deflection and no bending.slope_at_imu, which bending needs; write \"damping: 1\"");
  EXPECT_EQ(read("based_on: base.yaml\nbending: {damping: 2 %}\n").vehicle.bending->damping, 2 * 0.01);
}

TEST_F(VehicleFile, ABaseThatFailsNamesBothPlaces) {
  (void)file("base.yaml", kLeast + "exit_area: 3 m\n");
  const std::string found = message("name: x\nbased_on: base.yaml\n");
  EXPECT_CONTAINS(found, "vehicle.yaml:2:11: based_on: ");
  EXPECT_CONTAINS(found, "base.yaml:8:12: exit_area: ");
  EXPECT_CONTAINS(message("based_on: nosuch.yaml\n"), "vehicle.yaml:1:11: based_on: ");
  EXPECT_CONTAINS(message("based_on: vehicle.yaml\n"), "do they go round in a circle?");
  (void)file("good.yaml", kLeast);
  EXPECT_CONTAINS(message("name: x\nbased_on: good.yaml\nlift_off_mass: 1 t\n"),
                  "vehicle.yaml:2:11: propellant is 1500 kg, but must be");
}

TEST_F(VehicleFile, UnknownKeysGetTheNearest) {
  EXPECT_CONTAINS(message("lift_of_mass: 1 t\n"),
                  "vehicle.yaml:1:1: 'lift_of_mass' is no key of a vehicle (did you mean 'lift_off_mass'?)");
  EXPECT_CONTAINS(
      message_with("actuator: {frequancy: 4 Hz}\n"),
      "vehicle.yaml:8:12: 'frequancy' is no key of actuator (did you mean 'frequency'?); there are origin, reason, frequency, damping, deflection_limit, rate_limit and delay");
  EXPECT_CONTAINS(message("lift_off_mass: {valu: 1 t}\n"),
                  "1:17: 'valu' is no key of lift_off_mass (did you mean 'value'?)");
  EXPECT_CONTAINS(message_with("axial_drag: {point: [[0, 1]]}\n"), "(did you mean 'points'?)");
  EXPECT_CONTAINS(message("burn_time: 1 s\nburn_time: 2 s\n"), "2:1: 'burn_time' is given twice");
}

TEST_F(VehicleFile, MissingKeysAreNamedTogether) {
  EXPECT_CONTAINS(
      message("name: x\n"),
      "vehicle.yaml:1:1: found no lift_off_mass, propellant, burn_time, specific_impulse, centre_of_mass, roll_inertia and no pitch_inertia, which a vehicle needs; write \"lift_off_mass: 1 kg\"");
  EXPECT_CONTAINS(message_with("axial_drag: 0.3\n"), "8:13: axial_drag: found no \"reference_area:\", expected one");
  EXPECT_CONTAINS(message_with("normal_force_slope: 2 1/rad\n"), "found no \"reference_area:\"");
  EXPECT_CONTAINS(message("lift_off_mass: {origin: assumed, reason: x}\n"),
                  "1:16: lift_off_mass: found no \"value:\", expected one, as in {value: 1 kg, origin");
  EXPECT_CONTAINS(
      message("thrust_shape: {origin: assumed, reason: x}\n"),
      "1:15: thrust_shape: found neither \"points:\" nor \"value:\", expected one of them, as in points: [[0, 1], [1, 1]]");
}

TEST_F(VehicleFile, ValuesHaveTheirUnits) {
  EXPECT_CONTAINS(message("lift_off_mass: 28\n"), "1:16: lift_off_mass: '28' has no unit; expected one like kg, t");
  EXPECT_CONTAINS(
      message("lift_off_mass: {value: 28 m}\n"),
      "1:24: lift_off_mass: '28 m' has a unit of the wrong kind (the kind of m, cm, ft); expected one like kg, t");
  EXPECT_CONTAINS(message("lift_off_mass: 28 tt\n"), "'tt' is no known unit");
  EXPECT_CONTAINS(message("lift_off_mass: -28 t\n"), "lift_off_mass: found '-28 t', expected a value above 0");
  EXPECT_CONTAINS(message("lift_off_mass: 1e307 t\n"), "is beyond the range of numbers");
  EXPECT_CONTAINS(message("lift_off_mass: [28 t]\n"), "found a list, expected a number and a unit (kg, t)");
  EXPECT_CONTAINS(message("lift_off_mass: {value: [28 t]}\n"),
                  "lift_off_mass, value: found a list, expected one like 1 kg");
  EXPECT_CONTAINS(message("propellant: -1 kg\n"), "expected a value of 0 or more");
  EXPECT_CONTAINS(message("exit_area: 1 m\n"), "expected one like m^2");
  EXPECT_CONTAINS(message("roll_inertia: 1 kg m\n"), "expected one like kg m^2");
  EXPECT_CONTAINS(message("roll_moment_limit: 1 kN\n"), "(the kind of N, kN); expected one like N m, kN m");
  EXPECT_CONTAINS(message("normal_force_slope: 2.8\n"), "expected one like 1/rad, 1/deg");
  EXPECT_CONTAINS(message("axial_drag: much\n"),
                  "'much' does not start with a finite number; expected a number and a unit (1, %, ppm)");
  EXPECT_CONTAINS(message("actuator: {damping: -0.5}\n"), "actuator.damping: found '-0.5', expected a value");
  EXPECT_CONTAINS(message("actuator: 4 Hz\n"), "1:11: actuator: found '4 Hz', expected keys and values below it");
  EXPECT_CONTAINS(message("bending: some\n"),
                  "1:10: bending: found 'some', expected keys and values below it, or none");
}

TEST_F(VehicleFile, TablesAscendWithinTheirRange) {
  EXPECT_CONTAINS(message("thrust_shape: [[0, 1], [0.5, 2], [0.5, 1]]\n"),
                  "1:35: thrust_shape: found 0.5 behind 0.5, expected abscissae that ascend");
  EXPECT_CONTAINS(message("thrust_shape: [[0, 1], [83, 0]]\n"),
                  "1:25: thrust_shape: found '83', expected a burn fraction from 0 to 1");
  EXPECT_CONTAINS(message("centre_of_mass: [[-1, 7 m]]\n"), "found '-1', expected a propellant fraction from 0 to 1");
  EXPECT_CONTAINS(message("axial_drag: [[2000, 1]]\n"), "found '2000', expected a Mach number from 0 to 1000");
  EXPECT_CONTAINS(message("axial_drag: [[0 s, 1]]\n"), "found '0 s', expected a plain number");
  EXPECT_CONTAINS(message("centre_of_mass: [[0, 7]]\n"), "1:22: centre_of_mass: '7' has no unit");
  EXPECT_CONTAINS(
      message("centre_of_mass: [[0, 7 m, 8 m]]\n"),
      "1:18: centre_of_mass: found a list of 3, expected points of a propellant fraction and value, as in [[0, 1 m], [1, 1 m]]");
  EXPECT_CONTAINS(message("centre_of_mass: [0, 7 m]\n"), "1:18: centre_of_mass: found '0', expected points");
  EXPECT_CONTAINS(message("centre_of_mass: []\n"), "found an empty list, expected points as in [[0, 1 m]");
  EXPECT_CONTAINS(message("axial_drag: [[0, 1], [1e-320, 2]]\n"), "1:13: axial_drag: the table is too steep from 0");
  EXPECT_CONTAINS(message("centre_of_mass: {points: 7 m}\n"),
                  "centre_of_mass, points: found '7 m', expected a list like [[0, 1 m], [1, 1 m]]");
  EXPECT_CONTAINS(message("centre_of_mass: {points: [[0, 7 m]], value: 7 m}\n"),
                  "centre_of_mass: found both value and points");
  EXPECT_CONTAINS(message("axial_drag: {points: [[0, 7]], interpolation: smoth}\n"),
                  "axial_drag, interpolation: found 'smoth' (did you mean 'smooth'?), expected linear or smooth");
}

TEST_F(VehicleFile, AnOriginHasItsReason) {
  EXPECT_CONTAINS(message("burn_time: {value: 8 s, origin: sourced}\n"),
                  "1:33: burn_time: found an origin without its \"reason:\", expected both");
  EXPECT_CONTAINS(message("burn_time: {value: 8 s, reason: data sheet}\n"),
                  "found a reason without its \"origin:\" (sourced, derived or assumed), expected both");
  EXPECT_CONTAINS(message("burn_time: {value: 8 s, origin: sauced, reason: x}\n"),
                  "burn_time, origin: found 'sauced' (did you mean 'sourced'?), expected sourced, derived or assumed");
  EXPECT_CONTAINS(message("burn_time: {value: 8 s, origin: sourced, reason: \"  \"}\n"),
                  "found an empty reason, expected where its value comes from");
  EXPECT_CONTAINS(message("burn_time: {value: 8 s, origin: sourced, reason: one, two}\n"),
                  "1:55: burn_time: found 'two' without a value; a reason with a comma or colon needs quotes");
  EXPECT_CONTAINS(message("actuator: {delay: 0 s, origin: assumed}\n"),
                  "actuator: found an origin without its \"reason:\"");
}

TEST_F(VehicleFile, WhatAVehicleCannotBeHasThePlaceOfTheNumber) {
  EXPECT_CONTAINS(message_with("actuator:\n  delay: 2 s\n"),
                  "vehicle.yaml:9:10: delay of the actuator is 2 s, but must be from 0 to 1");
  EXPECT_CONTAINS(message_with("actuator: {deflection_limit: {value: 50 deg}}\n"), "8:30: deflection limit");
  EXPECT_CONTAINS(message_with("thrust_shape: [[0.1, 1], [1, 1]]\n"),
                  "8:15: first point of the thrust shape is 0.1 of burn fraction, but must be 0");
  EXPECT_CONTAINS(message_with("thrust_shape: {points: [[0, 1], [0.4, 0], [0.6, 0], [1, 1]], interpolation: smooth}\n"),
                  "8:15: least value of the thrust shape is -0.");  // between its points
  EXPECT_CONTAINS(message_with("thrust_shape: 0\n"), "8:15: mean of the thrust shape is 0");
  std::string heavy = kLeast;
  heavy.replace(heavy.find("1500 kg"), 7, "3 t    ");
  EXPECT_CONTAINS(message(heavy),
                  "vehicle.yaml:2:13: propellant is 3000 kg, but must be zero or more and less than the lift-off mass");
}

TEST_F(VehicleFile, OtherFilesAreRefused) {
  EXPECT_CONTAINS(message("- 1\n"), "found a list, expected keys like \"lift_off_mass:\"");
  EXPECT_CONTAINS(message("a: b: c\n"), "no YAML");
  EXPECT_CONTAINS(message("name: [x]\n"), "name: found a list, expected text");
  EXPECT_CONTAINS(message_of<InputError>([] { (void)files::read_vehicle("/nosuch.yaml"); }), "/nosuch.yaml");
}

}  // namespace
}  // namespace gyrobudget::app_tests

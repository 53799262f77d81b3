// SPDX-License-Identifier: MIT
// Steps per second of the navigation filter against states and form, beside the strapdown alone.
//
//   filter_benchmark                       the table of speed
//   filter_benchmark digits                what each form keeps of its digits, against a hundred of them
//   filter_benchmark steps STATES FORM N   N steps alone, for an instruction count: of two runs, the
//                                          difference over the difference in N; FORM is strapdown,
//                                          plain, joseph, square_root
//
// Alternatives take turns, so a busy machine slows all of them; a figure is the best of its turns.
#include "gyrobudget/estimation/navigation/filter.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include "../estimation/navigation/reference.h"

namespace {

namespace earth = gyrobudget::earth;
namespace navigation = gyrobudget::navigation;
namespace noise = gyrobudget::noise;
using navigation::Carrier;
using navigation::Effect;
using navigation::Form;

constexpr double kDt = 0.01;
constexpr int kStepsPerFix = 100;

/// Terms in the order in which a navigator would add them: biases, scale factors, 1/f of the gyro and of the
/// accelerometer, misalignments, g-sensitivity, more of 1/f.
std::vector<navigation::ErrorTerm> all_terms() {
  std::vector<navigation::ErrorTerm> terms;
  const auto add = [&](Carrier carrier, Effect effect, int axis, int input, double correlation_time, double walk) {
    navigation::ErrorTerm term;
    term.carrier = carrier;
    term.effect = effect;
    term.axis = axis;
    term.input = input;
    term.correlation_time = correlation_time;
    term.walk = walk;
    terms.push_back(term);
  };
  const double constant = std::numeric_limits<double>::infinity();
  for (const auto carrier : {Carrier::gyro, Carrier::accelerometer})
    for (int i = 0; i < 3; ++i) add(carrier, Effect::bias, i, 0, constant, carrier == Carrier::gyro ? 1e-9 : 1e-7);
  for (const auto carrier : {Carrier::gyro, Carrier::accelerometer})
    for (int i = 0; i < 3; ++i) add(carrier, Effect::scale_factor, i, 0, constant, 0);
  for (const double time : {5.0, 50.0})
    for (const auto carrier : {Carrier::gyro, Carrier::accelerometer})
      for (int i = 0; i < 3; ++i) add(carrier, Effect::bias, i, 0, time, carrier == Carrier::gyro ? 1e-8 : 1e-6);
  for (const auto carrier : {Carrier::gyro, Carrier::accelerometer})
    for (int i = 0; i < 6; ++i) add(carrier, Effect::misalignment, i / 2, (i / 2 + 1 + i % 2) % 3, constant, 0);
  for (int i = 0; i < 9; ++i) add(Carrier::gyro, Effect::g_sensitivity, i / 3, i % 3, constant, 0);
  for (const double time : {500.0, 5000.0, 0.5})
    for (int i = 0; i < 6; ++i)
      add(i < 3 ? Carrier::gyro : Carrier::accelerometer, Effect::bias, i % 3, 0, time, i < 3 ? 1e-9 : 1e-7);
  return terms;
}

navigation::ErrorStateModel model_of(int states) {
  navigation::ErrorStateModel model;
  model.gyro_white.setConstant(1e-6);
  model.accelerometer_white.setConstant(1e-4);
  model.terms = all_terms();
  model.terms.resize(static_cast<std::size_t>(states - navigation::kCoreStates));
  return model;
}

navigation::StateMatrix covariance_of(const navigation::ErrorStateModel& model) {
  navigation::StateVector sigma(model.states());
  sigma.segment<3>(navigation::kPosition).setConstant(10);
  sigma.segment<3>(navigation::kVelocity).setConstant(0.1);
  sigma.segment<3>(navigation::kAttitude).setConstant(1e-3);
  for (std::size_t k = 0; k < model.terms.size(); ++k) {
    const auto& term = model.terms[k];
    const bool gyro = term.carrier == Carrier::gyro;
    sigma[navigation::kCoreStates + static_cast<int>(k)] = term.effect == Effect::bias            ? (gyro ? 1e-7 : 1e-3)
                                                           : term.effect == Effect::g_sensitivity ? 1e-8
                                                                                                  : 1e-4;
  }
  return sigma.cwiseAbs2().asDiagonal();
}

struct Flight {
  earth::Trajectory path;
  std::vector<noise::ImuIncrement> imu;
  earth::Pose start;
};

Flight flight() {
  earth::Cruise cruise;
  cruise.turn_acceleration = 5;
  cruise.duration = 100;
  Flight made{earth::cruise(cruise), {}, {}};
  made.imu = made.path.increments(kDt);
  const auto at = made.path.at(0);
  made.start = at.pose;
  return made;
}

/// Takes `steps` steps with a fix of position a second, round and round the flight's record.
class Runner {
 public:
  Runner(const Flight& flight, int states, Form form) : flight_(flight), filter_(make(flight, states, form)) {}
  void run(std::int64_t steps) {
    for (std::int64_t i = 0; i < steps; ++i) {
      filter_.propagate(flight_.imu[at_], kDt);
      at_ = (at_ + 1) % flight_.imu.size();
      if (at_ % kStepsPerFix == 0)
        filter_.update(
            measure(navigation::PositionFix{filter_.state().p_eb_e, Eigen::Vector3d::Constant(1)}, filter_.estimate()));
    }
  }

 private:
  static navigation::Filter make(const Flight& flight, int states, Form form) {
    const auto model = model_of(states);
    navigation::Filter::Options options;
    options.form = form;
    return {flight.start, model, covariance_of(model), options};
  }
  const Flight& flight_;
  navigation::Filter filter_;
  std::size_t at_ = 0;
};

void run_strapdown(const Flight& flight, std::int64_t steps) {
  navigation::Strapdown strapdown(flight.start);
  std::size_t at = 0;
  for (std::int64_t i = 0; i < steps; ++i) {
    strapdown.step(flight.imu[at], kDt);
    at = (at + 1) % flight.imu.size();
  }
}

template <typename Work>
double seconds(Work work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void print_speed(const Flight& flight) {
  constexpr std::int64_t kSteps = 5000;
  constexpr int kTurns = 12;
  const std::vector<int> sizes{9, 15, 21, 27, 33, 45, 54, 63, 72};
  const std::vector<Form> forms{Form::plain, Form::joseph, Form::square_root};
  double strapdown = 1e9;
  std::vector<double> best(sizes.size() * forms.size(), 1e9);
  for (int turn = 0; turn < kTurns; ++turn) {
    strapdown = std::min(strapdown, seconds([&] { run_strapdown(flight, 10 * kSteps); }) / (10 * kSteps));
    for (std::size_t i = 0; i < best.size(); ++i) {
      Runner runner(flight, sizes[i / forms.size()], forms[i % forms.size()]);
      best[i] = std::min(best[i], seconds([&] { runner.run(kSteps); }) / kSteps);
    }
  }
  fmt::print("Thousand IMU steps a second, a position fix of three rows every {} steps, one core\n", kStepsPerFix);
  fmt::print("{:>6} {:>8} {:>8} {:>12} {:>22}\n", "states", "plain", "joseph", "square_root", "joseph / strapdown");
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double* row = &best[i * forms.size()];
    fmt::print("{:>6} {:>8.0f} {:>8.0f} {:>12.0f} {:>19.1f} x\n", sizes[i], 1e-3 / row[0], 1e-3 / row[1], 1e-3 / row[2],
               row[1] / strapdown);
  }
  fmt::print("strapdown alone {:.0f}\n", 1e-3 / strapdown);
}

/// Nanoseconds of one row's update, by form.
void print_updates() {
  constexpr int kTurns = 10, kRows = 2000;
  fmt::print("\nNanoseconds of an update by one row\n{:>6} {:>8} {:>8} {:>12}\n", "states", "plain", "joseph",
             "square_root");
  for (const int states : {9, 21, 45, 72}) {
    std::array<double, 3> best{1e9, 1e9, 1e9};
    const std::array forms{Form::plain, Form::joseph, Form::square_root};
    const auto P0 = covariance_of(model_of(states));
    const navigation::MeasurementRow row{navigation::StateVector::Unit(states, 1), 1.0};
    for (int turn = 0; turn < kTurns; ++turn)
      for (std::size_t f = 0; f < forms.size(); ++f) {
        navigation::Covariance P(P0, forms[f]);
        const double time = seconds([&] {
          for (int i = 0; i < kRows; ++i) (void)P.update(row);
        });
        best[f] = std::min(best[f], time / kRows);
      }
    fmt::print("{:>6} {:>8.0f} {:>8.0f} {:>12.0f}\n", states, 1e9 * best[0], 1e9 * best[1], 1e9 * best[2]);
  }
}

using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<100>, boost::multiprecision::et_off>;

/// Worst relative error of any sigma over ten steps with a fix of position, and another of attitude, each,
/// where the variances at the start are `ratio` times those of the fixes.
std::vector<double> lost_digits(const std::vector<Form>& forms, double ratio) {
  constexpr int kStates = 21, kFixes = 10;
  const auto model = model_of(kStates);
  navigation::StateMatrix P0 = covariance_of(model);
  navigation::StateVector fix = P0.diagonal();
  P0 *= ratio;
  gyrobudget::reference::Matrix<Real> truth(P0);
  std::vector<navigation::Covariance> ours;
  for (const Form form : forms) ours.emplace_back(P0, form);
  std::vector<double> worst(forms.size(), 0);
  navigation::Lineariser lineariser(model);
  navigation::StepInput step;
  step.dt = 0.1;
  step.p_eb_e = earth::to_ecef({0.7, 2.1, 3000});
  for (int k = 0; k < kFixes; ++k) {
    step.w_ib_b = {0.1 * k, 0.02, -0.1};
    step.f_ib_b = {0.5 * k, -1, -9.8};
    step.C_eb = Eigen::Quaterniond(1, 0.1 * k, 0.2, -0.3).normalized().toRotationMatrix();
    const auto& transition = lineariser(step);
    truth = gyrobudget::reference::propagated(truth, transition);
    for (auto& P : ours) P.propagate(transition);
    for (const int first : {navigation::kPosition, navigation::kAttitude})
      for (int i = 0; i < 3; ++i) {
        const navigation::MeasurementRow row{navigation::StateVector::Unit(kStates, first + i), fix[first + i]};
        truth = gyrobudget::reference::updated(truth, row);
        for (auto& P : ours) (void)P.update(row);
      }
    for (std::size_t f = 0; f < ours.size(); ++f)
      for (int i = 0; i < kStates; ++i) {
        const double variance = ours[f].variance(i);
        const double off = variance >= 0 ? std::abs(static_cast<double>(sqrt(Real(variance) / truth(i, i))) - 1) : 1e99;
        worst[f] = off <= worst[f] ? worst[f] : off;
      }
  }
  return worst;
}

void print_digits() {
  const std::vector<Form> forms{Form::plain, Form::joseph, Form::square_root, Form::automatic};
  fmt::print("Worst error of a sigma, of itself, by how much the variances at the start exceed those of fixes\n");
  fmt::print("{:>8} {:>10} {:>10} {:>12} {:>10}\n", "ratio", "plain", "joseph", "square_root", "automatic");
  for (int decade = 0; decade <= 36; decade += 2) {
    const auto worst = lost_digits(forms, std::pow(10, decade));
    fmt::print("{:>8} {:>10.1e} {:>10.1e} {:>12.1e} {:>10.1e}\n", fmt::format("1e{}", decade), worst[0], worst[1],
               worst[2], worst[3]);
  }
}

int run_steps(const Flight& flight, int states, std::string_view form, std::int64_t steps) {
  if (form == "strapdown") {
    run_strapdown(flight, steps);
    return 0;
  }
  Runner runner(flight, states, form == "plain" ? Form::plain : form == "joseph" ? Form::joseph : Form::square_root);
  runner.run(steps);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const Flight path = flight();
  if (argc == 5 && std::string_view(argv[1]) == "steps")
    return run_steps(path, std::stoi(argv[2]), argv[3], std::stoll(argv[4]));
  if (argc == 2 && std::string_view(argv[1]) == "digits") {
    print_digits();
    return 0;
  }
  print_speed(path);
  print_updates();
  return 0;
}

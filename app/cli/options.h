// SPDX-License-Identifier: MIT
// Inside the command line: the options of the verbs.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app.h"
#include "arguments.h"

namespace gyrobudget::inline v0::cli {

/// Options as text, before they become values with units.
struct Texts {
  std::string rate, duration, terms, tau_min, tau_max, input = "rate", method = "gls", axes = "x,y,z";
  std::string seed = "1", skip, taps, noise_type, variant, rrw, correlation_time;
  std::string records, methods, axis = "gyro", require;
  std::string estimators = "oadev", stride = "1", taus, format, psd, window, gap;
  std::string resample, rows, time, front_end, known;
  std::string trajectory, truth, fixes, attitude, flight_input, vibration, run;
  std::string at, step, limit, horizon, temperature;
  std::vector<std::string> wishes, mask, logs, with;
  bool ieee = false, strict_gaps = false;
};

/// A verb on the command line.
struct Verb {
  App* app;
  std::function<Arguments()> arguments;  ///< once it is parsed; throws std::invalid_argument
};

/// A verb that `add` declares and `finish` turns from text into values.
template <class A>
Verb make_verb(App& app, App* (*add)(App&, A&, Texts&), void (*finish)(A&, const Texts&)) {
  struct State {
    A arguments;
    Texts texts;
  };
  const auto state = std::make_shared<State>();
  return {add(app, state->arguments, state->texts), [state, finish] {
            finish(state->arguments, state->texts);
            return Arguments(state->arguments);
          }};
}

// Each adds its verb to the program.
[[nodiscard]] Verb inspect_verb(App&);
[[nodiscard]] Verb simulate_verb(App&);
[[nodiscard]] Verb allan_verb(App&);
[[nodiscard]] Verb calibrate_verb(App&);
[[nodiscard]] Verb export_verb(App&);
[[nodiscard]] Verb plan_verb(App&);
[[nodiscard]] Verb accuracy_verb(App&);
[[nodiscard]] Verb paper_verb(App&);
[[nodiscard]] Verb navigate_verb(App&);
[[nodiscard]] Verb budget_verb(App&);
[[nodiscard]] Verb fly_verb(App&);

// Options that verbs share.
void add_common(App&, Common&, bool has_json = true);
void add_pictures(App&, Pictures&);
void add_format(App&, Texts&, const std::string& help);
void add_log(App&, CurveArguments&, Texts&);
void add_curve(App&, Texts&, const std::string& default_taus);
void finish_log(CurveArguments&, const Texts&);

}  // namespace gyrobudget::inline v0::cli

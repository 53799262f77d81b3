// SPDX-License-Identifier: MIT
#include "sensor_file.h"

namespace gyrobudget::inline v0::sensor_file {

std::string_view sensor_help() {
  return R"yaml(name: IFOG, closed loop, 2018
warning: the fan was on                 # said by whoever uses the numbers; one text, or a list
gyro:                                   # or ideal: it has no error
  arw: 5.4e-4 deg/sqrt(h)               # angle random walk, N; a value is for all axes, or one for each:
  rrw: [4e-2 deg/h/sqrt(h), 4e-2 deg/h/sqrt(h), 9e-2 deg/h/sqrt(h)]   # rate random walk, K
  bias_instability: 1.7e-3 deg/h        # flicker, B of IEEE Std 952: the flat of the curve is 0.664 B
  # bias_stability: 5e-3 deg/h          # in its place: in-run bias stability, the minimum of the Allan curve; B is
  #                                     #   what gives it beside N and K: minimum^2 = 2 N K/sqrt(3) + (0.664 B)^2
  quantization: 0.1 arcsec
  rate_ramp: 1e-4 deg/h/h
  gauss_markov: [{sigma: 0.1 deg/h, correlation_time: 300 s}]
  sinusoid: [{amplitude: 2 deg/h, frequency: 50 mHz, phase: 0 deg}]
  turn_on_bias: 0.01 deg/h              # one sigma, as all that follow up to filter
  scale_factor: 10 ppm
  misalignment: 20 arcsec
  g_sensitivity: 0.1 deg/h/g            # gyros only
  g2_sensitivity: 0.02 deg/h/g^2
  vibration_rectification: 0.05 deg/h/g^2
  filter: {kind: second_order, bandwidth: 100 Hz}   # first_order, second_order or moving_average: of what is sensed
  #                                     # and of white noise; bandwidth and filter_order: 1 or 2 is an older way
  delay: 2 ms
  range: 400 deg/s
  temperature:                          # bias over it
    reference: 30 degC                  # where this bias is none
    linear: 5 deg/h/K
    quadratic: -0.1 deg/h/K^2
    rate: 20 deg/h/(K/min)              # of a change of temperature
  powered_on_before: 1 h                # the scene; its noise has run since
  calibrated_over: 10 min               # the last before the scene, whose mean is taken off
accelerometer:                          # the same, with
  vrw: 0.05 m/s/sqrt(h)                 # velocity random walk for arw
  accel_rw: 3 ug/sqrt(h)                # acceleration random walk for rrw
  bias_instability: 10 ug
lever_arm: [0.1 m, 0 m, -0.02 m]        # from the IMU to the centre of mass: forward, right, down
)yaml";
}

}  // namespace gyrobudget::inline v0::sensor_file

// SPDX-License-Identifier: MIT
#include "scene_file.h"

namespace gyrobudget::inline v0::files {

std::string_view scene_help() {
  return R"yaml(# Times are those of the IMU log's clock; where that counts from an epoch (beyond 1e6 s), after the first sample; of a
# trajectory, after its start. Paths start at the scene's folder. Leave out what the scene does not need; [in brackets] is what that means.
name: delivery drone, GNSS outage
site: alcantara               # or {latitude: -2.373 deg, longitude: -44.396 deg, height: 0 m}
azimuth: 90 deg               # of the launch plane, clockwise from north
# trajectory: ascent          # what flies where nothing was recorded: as --trajectory, a name or a CSV
flight:                       # or, in its place, what flies in closed loop: for fly; a budget takes its nominal trajectory
  vehicle: vlm1.yaml          # its keys: gyrobudget fly --help
  bending: no                 # leaves out the vehicle's bending mode [as the vehicle has it]
  pitch: [[8 s, 90 deg], [83 s, 50 deg]]   # program above the horizon, straight between [these two]
  control:                    # of attitude
    frequency: 2.5 rad/s      # of the closed loop [2.5 rad/s]
    damping: 0.7
    feedback: rate_error      # or rate, which lags a turning program [rate_error]
    least_thrust: 20 %        # of the mean: gains follow the thrust down to here [20 %]
    notch: {frequency: 7 Hz, depth: 0.05, width: 0.5}   # or none [on a bending mode below half the rate]
    rate: 100 Hz              # of control, IMU and navigation [100 Hz]
  guidance: attitude          # or trajectory: back to the nominal one too; or {frequency, damping, angle_limit}
  atmosphere: yes
  wind:                       # of the air against Earth [calm]
    east: 5 m/s
    north: 0 m/s
    shear_east: [[0 km, 0 m/s], [10 km, 30 m/s]]   # more, by height; shear_north alike
    gust: {height: 9 km, half_width: 300 m, east: 0 m/s, north: 9 m/s, up: 0 m/s}
  dispersion:                 # one sigma of what differs from vehicle to vehicle [nothing]
    impulse: 0.5 %            # so too: burn_time, mass, inertia, axial_drag, normal_force, gust
    pressure_ahead: 10 cm     # centre_of_mass alike
    thrust_misalignment: 0.05 deg
    wind: 5 m/s
  faults:                     # of the flight with sensors and of Monte Carlo, not of the nominal one [none]
    thrust_cut: 200 s
    nozzle_stuck: {at: 200 s, pitch: 1 deg, yaw: 0 deg}   # where it is then, and so much off
    thrust_misalignment: {pitch: 0 deg, yaw: 0 deg}
    dead_gyro: {axis: y, at: 200 s}
    navigation_delay: 0 s
  integrator: automatic       # or {method: fehlberg78, step: 10 ms, tolerance: 1e-9}: automatic, exact,
                              #   runge_kutta4, dormand_prince, fehlberg78, rosenbrock
imu:                          # what was recorded
  file: imu.csv               # text, or a recording: ROS bag, MCAP, ULog, dataflash, MAT, HDF5; also packed
  topic: /imu/data_raw        # of a recording: its stream, as inspect names it [the only IMU]
  epoch: 2026-03-05 09:14:22 GPST   # what instant its time 0 is, where fixes have dates and it has none
  columns:                    # where the header does not say time (s), gyro_x (deg/s) ... accel_z (g):
    time: t_s (s)             #   column of the file, and its unit where the header has none
    gyro_x: gx (0.1 arcsec)   #   rad: an increment, rad/s: a rate; a count has a factor before its unit
    accel_x: ax (125 ug*s)    #   m/s: an increment, m/s^2: a rate
  axes: [y, x, -z]            # which of its axes are forward, right, down [x, y, z]
  rate: 100 Hz                # where there is no time column
  stamp: end                  # a sample's stamp ends its interval, or is its start [end]
  samples: mean               # rates are means over that interval, or instant values [mean]
sensor:                       # or just its file; left out or ideal: no errors
  file: mems.yaml
  rate: 200 Hz                # of the samples whose sigmas a file of VINS or imu_utils gives [it gives densities]
  powered_on_before: 10 min   # 1/f noise and rate random walk have run since [as the sensor file says]
  calibrated_over: 60 s       # the mean of the last minute before the scene is taken off [as the file says]
  vibration: 0 m/s^2          # rms level, for vibration rectification
  temperature: from=20 degC,to=45 degC,time_constant=10 min   # or 35 degC, or a table of time and temperature:
                              #   what the sensor file's bias over temperature makes [at its reference]
states:                       # what the filter estimates of the sensor
  flicker: 2                  # Gauss-Markov states an axis, 0 to 6 [as tolerance asks, up to 3]
  tolerance: 1 %              # of the Allan deviation at the scene's length
  scale_factor: estimated     # or considered, or left_out; so too
  misalignment: considered
  g_sensitivity: left_out
alignment:
  start: 0 s
  position: site              # or the name of an aid, or {latitude, longitude, height}
  position_sigma: 1 m         # one for all, or [east, north, up]
  velocity: rest              # or the name of an aid, or {north: 0 m/s, east: 0 m/s, down: 0 m/s}
  velocity_sigma: 1 cm/s
  attitude: self              # levels and gyrocompasses; or an aid, or {heading, pitch, roll}
  duration: 5 min             # self: for so long at rest [60 s]
  heading: 30 deg             # self: where gyros cannot tell it; of the belly where the nose points up
  level_sigma: 0.1 deg        # not self
  heading_sigma: 1 deg
aids:
  gnss:                       # a name of yours
    file: gnss.csv            # text, a recording, RTKLIB's .pos, NMEA 0183 or gpsd's JSON
    topic: /fix               # of a recording [the only GNSS receiver]
    columns: {}               # of a text, as of the IMU: time, latitude, longitude, height, velocity_north,
                              #   velocity_east, velocity_down or velocity_up; heading or yaw (clockwise
                              #   from north) or yaw_ccw, pitch, roll; or q_w, q_x, q_y, q_z; ecef_x, _y, _z;
                              #   position_sigma (or _east, _north, _up), velocity_sigma; quality
    geoid_separation: -24.9 m # heights are over the geoid, which is so high over the ellipsoid
                              #   [they are over the ellipsoid, or the file tells the geoid]
    quality: [1, 2]           # only fixes of which the receiver says this [all that it has measured]
    rate: 1 Hz                # of simulated fixes and of rest
    lever_arm: [0.2 m, 0 m, -1 m]     # from the IMU, forward, right, down
    lever_arm_sigma: 5 cm             # estimated where not 0, as are the next and the biases
    time_tag_sigma: 5 ms
    time_tag: -20 ms                  # what is added to its stamps
    clocks: one                       # of all it measures; each: every one has a time tag of its own [one]
    from: 0 s                         # used from here
    until: 10 min                     # to here
    outages: [[60 s, 120 s]]          # but not there
    used: yes                         # no: only to compare with
    position:                         # what it measures: position, velocity, height, attitude, rest
      sigma: [2 m, 2 m, 4 m]          # white from fix to fix; position: 2 m says just that; file: that
                                      # which each fix has in its file, as in position: file
      bias_sigma: 0 m                 # a constant error; of an attitude, the mounting
      correlated: {sigma: 1 m, time: 5 min}
                                      # from, until, outages and used stand here too
    velocity: 5 cm/s
  pad:
    rest: 5 mm/s                      # zero velocity with this much sway
    until: 5 min
world:                        # for budgets: what is wrong with it, one sigma
  gravity: 30 ug              # vertical error of normal gravity [none]
  deflection: 5 arcsec        # of the vertical, each way [none]
filter:
  form: automatic             # or plain, joseph, square_root
  gate: 1e-6                  # share of right fixes that may be refused; 0: none is
  robust: none                # or {huber: 1.5}: from 1.5 sigma on a residual counts by its size, not its square; or
                              #   {student: 4}: of so many degrees of freedom [none]
  recovery: yes               # starts again from fixes that agree with each other and not with the filter [yes]
  covariance_interval: 0.1 s  # [every step]
  order: 4                    # of the strapdown's polynomial, 1 to 8
  earth_rate: yes             # no: left out of the attitude, as an error to be studied
until: 20 min
solution:
  rate: 10 Hz                 # [1 Hz]
  at: [83 s]
  smooth: no                  # yes: from all fixes, later ones too
reference: gnss               # an aid, or {file, columns} of what is only compared with
)yaml";
}

}  // namespace gyrobudget::inline v0::files

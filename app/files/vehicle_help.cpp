// SPDX-License-Identifier: MIT
#include "vehicle_file.h"

namespace gyrobudget::inline v0::files {

std::string_view vehicle_help() {
  return R"yaml(# A number is written {value: 28 t, origin: sourced, reason: where from}, a table
# {points: [[x, value], ...], origin: assumed, reason: why}; origin is sourced (published), derived (follows
# from published ones) or assumed. Just 28 t, or just the points, is read too and counts as not stated. A
# reason with a comma or colon needs quotes. Tables run straight between their points, or with
# interpolation: smooth as a cubic spline, and keep their outermost values beyond; a value in place of points
# is constant. Burn fraction is time over burn time, propellant fraction propellant used over propellant, both
# 0 to 1; stations are ahead of the gimbal. [In brackets] is what leaving a key out means; those without
# brackets are needed.
name: sounding rocket
# based_on: other.yaml        # takes over from another vehicle what is not given here [nothing]
lift_off_mass: {value: 1.2 t, origin: sourced, reason: maker's data sheet}
propellant:
  value: 800 kg
  origin: derived
  reason: lift-off mass less what is left at burnout
burn_time: 30 s
specific_impulse: 260 s       # in vacuum: mean thrust times burn time over (9.80665 m/s^2 propellant)
thrust_shape: {points: [[0, 1.1], [0.8, 1], [1, 0.2]], origin: assumed, reason: a motor alike}
                              # over burn fraction, brought to a mean of 1 [constant thrust]
exit_area: 0.05 m^2           # of the nozzle [0: no back-pressure]
reference_area: 0.2 m^2       # of the coefficients; needed with the next two
axial_drag: {points: [[0, 0.3], [0.9, 0.4], [1.1, 0.5], [4, 0.2]], interpolation: smooth}
                              # by Mach number [no drag]
normal_force_slope: 2.8 1/rad # of its coefficient by angle of attack [no normal force]
pressure_ahead: 0.5 m         # centre of pressure ahead of centre of mass; behind it, below 0 [0: at it]
centre_of_mass: [[0, 3 m], [1, 4 m]]         # station over propellant fraction: the gimbal's arm
roll_inertia: [[0, 80 kg m^2], [1, 40 kg m^2]]            # over propellant fraction, as the next two
pitch_inertia: [[0, 4000 kg m^2], [1, 2500 kg m^2]]
yaw_inertia: [[0, 4000 kg m^2], [1, 2500 kg m^2]]         # [as pitch_inertia]
imu_station: 6 m              # [where the centre of mass is at lift-off]
actuator:                     # of the nozzle; its numbers may share one origin and reason
  frequency: 4 Hz             # of its second order [4 Hz]
  damping: 0.7                # [0.7]
  deflection_limit: 3 deg     # [3 deg]
  rate_limit: 15 deg/s        # [15 deg/s]
  delay: {value: 10 ms, origin: assumed, reason: one period of the computer}    # of commands [none]
  origin: sourced
  reason: maker's data sheet
roll_moment_limit: 100 N m    # of the roll control [0: none]
bending:                      # first mode, alike in both planes, or none [rigid]
  frequency: [[0, 12 Hz], [1, 15 Hz]]        # over burn fraction
  damping: 0.5 %
  gimbal_deflection: 2        # of the mode at the gimbal, with the vehicle's mass as generalised mass
  slope_at_imu: -0.9 rad/m    # above 0 where a force that pitches the nose up turns the IMU up with the mode
  origin: assumed
  reason: free-free beam
)yaml";
}

}  // namespace gyrobudget::inline v0::files

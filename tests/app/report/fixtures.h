// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/app/report/result.h"

// Hand-made results: what allan and calibrate hand to the report, without the numerical libraries behind them.
namespace gyrobudget::fixtures {

/// A MEMS gyro: N = 0.15 deg/sqrt(h), B = 0.70 deg/h, K = 4.32 deg/h/sqrt(h); 100 Hz, 10 h. The curve is that of the
/// asymptotic closed forms with a deterministic wiggle of about one standard deviation; described, nothing cut.
report::LogResult mems();
/// The same without a fit, as `allan` gives it.
report::LogResult mems_curve_only();
/// A vehicle log in counts: a hump that no sum of the terms makes.
report::LogResult not_described();
/// An accelerometer, the first three taus cut, described within 3.1 %.
report::LogResult accelerometer();
/// A fibre-optic gyro in which B is an upper bound and K is left out at zero.
report::LogResult bounded();
/// Three gyros and three accelerometers.
report::LogResult imu();
/// Names and notes with everything that markup, JSON, gnuplot or a shell could trip over.
report::LogResult hostile_names();

}  // namespace gyrobudget::fixtures

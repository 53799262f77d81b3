// SPDX-License-Identifier: MIT
// How far calibrate() can be trusted on records as they come: behind filters, rounded, held, with gaps and outliers.
#pragma once

#include "gyrobudget/estimation/fit/accuracy.h"
#include "gyrobudget/noise/process.h"
#include "gyrobudget/noise/recorder.h"

#include <vector>

#include "calibrate.h"

namespace gyrobudget::inline v0::calibration {

/// fit::measure_accuracy of records that a recorder spoilt, each fitted as calibrate() does: what is held, rounded, out
/// of line or missing is found there, or not. A record that no datasheet can be made of counts as refused, and so does
/// one whose findings spoil its numbers, which calibrate() says: it counts as not described.
/// @param truth      processes of the sensor, in front of the recorder
/// @param recorder   what stands between them and the log
/// @param study      its `make` and `answer` are not used; its `fit` says which coefficients are compared, and is the
///   bound's: with a front_end that the fits know its bandwidth is known there too
/// @param calibrate  of every record; its method is that of the study. The front end that is `known` to the fits stands
///   here as well.
/// @throws std::invalid_argument for what fit::measure_accuracy, noise::RecorderGenerator and calibrate() refuse.
[[nodiscard]] fit::Accuracy measure_accuracy(const std::vector<noise::Process>& truth, const noise::Recorder& recorder,
                                             fit::AccuracyOptions study = {}, const Options& calibrate = {});

}  // namespace gyrobudget::inline v0::calibration

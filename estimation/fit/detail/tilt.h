// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/fit/fit.h"
#include "gyrobudget/noise/front_end.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "likelihood.h"

namespace gyrobudget::inline v0::fit {

/// A spectrum's gain that holds one unknown x: gain exp(slope x) in each bin. Behind a front end x is the logarithm of
/// its bandwidth over that of `gain`; behind an unknown one at frequencies that it mostly passes, -x the curvature of
/// its logarithm.
struct Tilt {
  Eigen::ArrayXd gain, slope;
  double x = 0;
  [[nodiscard]] Eigen::ArrayXd operator()(double at) const { return gain * (slope * at).exp(); }
};

/// Bins in which a front end's gain is smooth enough to count as one number: none is wider than this.
[[nodiscard]] std::int64_t widest_bin(std::int64_t samples);

/// Power gain of each bin, the mean over it.
[[nodiscard]] Eigen::ArrayXd gain_of(const SineBins&, const noise::FrontEnd&);
[[nodiscard]] Tilt tilt_of(const SineBins&, const noise::FrontEnd&);
/// ln gain = -x (k/last)^2.
[[nodiscard]] Tilt unknown_tilt(const SineBins&, std::int64_t last);

/// The maximum over the coefficients and the tilt. `flat` is the likelihood before any gain.
struct TiltedPoint {
  SineLikelihood::Point point;
  double x = 0;
  double deviation = 0;  ///< one sigma of x, the coefficients free; infinite where nothing is known of it
};
[[nodiscard]] TiltedPoint maximise_tilted(const SineLikelihood& flat, const Tilt&, std::optional<Held> held = {},
                                          std::optional<double> held_ramp = {},
                                          const SineLikelihood::Point* start = nullptr);

/// Fisher's information of theta where the tilt is unknown too.
[[nodiscard]] Eigen::MatrixXd information_with_tilt(const SineLikelihood& tilted, const Eigen::VectorXd& theta,
                                                    const Eigen::ArrayXd& slope);

/// Takes out the bins in which a record's ends may weigh more than a hundredth of what passes: their coefficients are
/// neither independent nor of the modelled variance.
void leave_out_stop_band(SineBins&, const noise::FrontEnd&);

/// A front end that explains a spectrum better than the others that were tried.
struct ChosenFrontEnd {
  noise::FrontEnd front_end;
  WhiteShift choice;
};

/// The front end of one of the kinds (any where empty) that explains the spectrum best, whichever way it was sampled;
/// the first of the processes is white noise. Each that was tried weighs exp(-(cost - least cost)/2) in the mean
/// (Akaike's weights: K. Burnham and D. Anderson, Model Selection and Multimodel Inference, section 4.3).
/// Looked for twice: with a floor of white noise behind it, that the stop band may hold what it will; then without a
/// floor, which would take sides with one sampling or another, and without the stop band.
[[nodiscard]] ChosenFrontEnd search_front_end(SineBins bins, std::span<const noise::Process> processes,
                                              std::optional<noise::FrontEnd::Kind> kind);

}  // namespace gyrobudget::inline v0::fit

// SPDX-License-Identifier: MIT
#pragma once

#include "gyrobudget/estimation/fit/fit.h"

#include <span>
#include <vector>

#include "profile.h"

namespace gyrobudget::inline v0::fit {

// What the curve's fit and the record's likelihood have in common.

/// The terms asked for, in the order Q N B K R G S.
/// @throws std::invalid_argument for one asked for twice, or none.
[[nodiscard]] std::vector<noise::Term> in_order(std::span<const noise::Term> asked);

/// The process of a term with coefficient 1 and the options' correlation time, frequency or front end, if
/// they have one.
[[nodiscard]] noise::Process shaped_process(noise::Term, const Options&);

/// Probability of a chi-square above `chi2`; 0 where it is below 1e-300.
[[nodiscard]] double chi_square_tail(double chi2, double dof);

/// What the tests of coefficients are held against. Where the model fails its own test, chi-square per degree of
/// freedom measures how much worse than chance it misses, and a term must be seen above that (F test, 0.1 %): a wrong
/// model must not lend significance to its smallest parts.
struct Cuts {
  double boundary = kBoundaryCut;
  double one_sided = kBoundaryCut;
  double two_sided = kIntervalCut;
};
[[nodiscard]] Cuts cuts_of(double p_value, double chi2, int dof, const Options&);

/// A coefficient from its square theta >= 0 (times `scale`), the standard deviation of theta and its test T.
[[nodiscard]] Coefficient judge(noise::Term, double theta, double deviation, double scale, const Cuts&, const HeldTest&,
                                bool intervals);

/// The search never settled: a value for what it is worth, and no limit.
[[nodiscard]] Coefficient without_answer(noise::Term, double theta, double scale);

/// A result in which nothing was fitted.
[[nodiscard]] Result no_answer(Method, std::span<const noise::Term> asked);

/// Adds to `list` coefficients of the terms Q N B K R that it lacks, as not fitted, and puts all in order.
void complete(std::vector<Coefficient>& list);

/// B^2/(N K).
void add_beta(Result&);

/// Verdict from p-value, degrees of freedom and worst misfit.
[[nodiscard]] Verdict verdict_of(const Result&, const Options&);

/// Every number of a result times `factor`, as if the record had been.
void rescale(Result&, double factor);

}  // namespace gyrobudget::inline v0::fit

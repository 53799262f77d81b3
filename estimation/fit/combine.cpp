// SPDX-License-Identifier: MIT
#include "combine.h"

#include "gyrobudget/estimation/fit/detail/judge.h"

#include <boost/math/distributions/students_t.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include <Eigen/Core>

namespace gyrobudget::inline v0::fit {
namespace {

using noise::Term;
constexpr std::array kTerms{Term::quantization, Term::white, Term::flicker, Term::rate_random_walk, Term::rate_ramp};
constexpr double kNormal95 = 1.959963984540054;

struct Sample {
  Eigen::ArrayXd value, variance;  // of squares, in units of the largest
};

double mean_square(const Sample& s, double between) {
  const Eigen::ArrayXd w = 1 / (s.variance + between);
  return (w * s.value).sum() / w.sum();
}

double weighted_squares(const Sample& s, double between) {
  return ((s.value - mean_square(s, between)).square() / (s.variance + between)).sum();
}

// Paule and Mandel: weighted_squares falls with T^2; where it starts below its degrees of freedom T^2 is 0.
double between_variance(const Sample& s) {
  const double dof = static_cast<double>(s.value.size() - 1);
  if (weighted_squares(s, 0) <= dof) return 0;
  double low = 0, high = (s.value - s.value.mean()).square().sum();
  while (weighted_squares(s, high) > dof) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-12 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (weighted_squares(s, middle) > dof ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double student95(double dof) { return boost::math::quantile(complement(boost::math::students_t(dof), 0.025)); }

double deviation_of(const Coefficient& c, double unit) {
  const auto square = [=](double x) { return (x / unit) * (x / unit); };
  if (c.lower > 0) return (square(c.upper_two_sided) - square(c.lower)) / (2 * kNormal95);
  return (square(c.upper_two_sided) - square(c.value)) / kNormal95;
}

Sample sample_of(std::span<const Coefficient> list, double unit) {
  const auto size = static_cast<Eigen::Index>(list.size());
  Sample s{Eigen::ArrayXd(size), Eigen::ArrayXd(size)};
  Eigen::ArrayXd deviation(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    const Coefficient& c = list[static_cast<std::size_t>(i)];
    s.value(i) = (c.value / unit) * (c.value / unit);
    deviation(i) = deviation_of(c, unit);
  }
  // A well-seen square scatters in proportion to the truth: take that at the common mean.
  const double mean = s.value.mean();
  for (Eigen::Index i = 0; i < size; ++i) {
    const bool proportional = list[static_cast<std::size_t>(i)].lower > 0;
    s.variance(i) = std::pow(proportional ? deviation(i) / s.value(i) * mean : deviation(i), 2);
  }
  return s;
}

Combined combine_term(Term term, std::span<const Coefficient> list) {
  Combined r{.term = term, .records = list.size()};
  double unit = 0;
  for (const auto& c : list) {
    unit = std::max(unit, c.upper_two_sided);
    r.identified += c.status == Status::identified;
  }
  if (list.size() == 1 || !(unit > 0)) {
    const Coefficient& c = list.front();
    r.value = c.value, r.lower = r.next_lower = c.lower, r.upper = r.next_upper = c.upper_two_sided;
    return r;
  }
  const Sample s = sample_of(list, unit);
  const double count = static_cast<double>(list.size());
  const double between = between_variance(s), mean = mean_square(s, between);
  const Eigen::ArrayXd w = 1 / (s.variance + between);
  const double excess = std::max(1.0, weighted_squares(s, between) / (count - 1));
  const double half = std::max(kNormal95, student95(count - 1)) * std::sqrt(excess / w.sum());
  const auto root = [=](double square) { return unit * std::sqrt(std::max(0.0, square)); };
  r.q = weighted_squares(s, 0);
  r.p_value = chi_square_tail(r.q, count - 1);
  r.value = root(mean), r.lower = root(mean - half), r.upper = root(mean + half);
  // d(c^2) = 2 c dc; with a mean at zero the spread of c is that of its root.
  r.spread = mean > std::sqrt(between) ? unit * 0.5 * std::sqrt(between / mean) : root(std::sqrt(between));
  r.next_lower = r.lower, r.next_upper = r.upper;
  if (list.size() >= 3) {
    const double next = student95(count - 2) * std::sqrt(between + 1 / w.sum());
    r.next_lower = root(mean - std::max(next, half)), r.next_upper = root(mean + std::max(next, half));
  }
  return r;
}

}  // namespace

std::vector<Combined> combine(std::span<const Result> records) {
  if (records.empty()) throw std::invalid_argument("no records to combine");
  std::vector<Combined> list;
  for (const Term t : kTerms) {
    std::vector<Coefficient> fitted;
    for (const Result& r : records) {
      const Coefficient& c = r[t];
      if (!c.fitted || c.status == Status::not_quotable) continue;
      if (std::isfinite(c.upper_two_sided) && std::isfinite(c.value)) fitted.push_back(c);
    }
    if (!fitted.empty()) list.push_back(combine_term(t, fitted));
  }
  return list;
}

}  // namespace gyrobudget::inline v0::fit

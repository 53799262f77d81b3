// SPDX-License-Identifier: MIT
#include "model.h"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::noise {

ModelMoments::ModelMoments(Model model, double dt)
    : model_(std::move(model)), dt_(dt), filters_(model_.filters.begin(), model_.filters.end()) {
  if (!(dt > 0 && std::isfinite(dt))) {
    throw std::invalid_argument(fmt::format("sample interval dt is {}; it must be positive and finite (s)", dt));
  }
}

double ModelMoments::psd(double frequency_hz) const {
  double sum = 0;
  for (const Process& p : model_.processes) sum += noise::psd(p, frequency_hz, dt_);
  for (const FilteredNoise& f : model_.filters) sum += noise::psd(f, frequency_hz, dt_);
  return sum;
}

double ModelMoments::allan_variance(std::int64_t m) const {
  double sum = noise::allan_variance(model_.processes, m, dt_);
  for (const FilterMoments& f : filters_) sum += f.allan_variance(m);
  return sum;
}

double ModelMoments::allan_variance(std::int64_t m, std::int64_t samples) const {
  if (m < 1 || m > samples / 2) {
    throw std::invalid_argument(
        fmt::format("averaging factor m is {}; it must be from 1 to half the record of {} samples", m, samples));
  }
  double sum = noise::allan_variance(model_.processes, m, dt_);  // their increments are stationary from the start
  for (const FilterMoments& f : filters_) sum += f.allan_variance(m, samples);
  return sum;
}

}  // namespace gyrobudget::inline v0::noise

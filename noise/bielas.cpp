// SPDX-License-Identifier: MIT
#include "bielas.h"

#include <fmt/core.h>

#include <cmath>
#include <stdexcept>

namespace gyrobudget::inline v0::noise {
namespace {

Process bias_process(const Bielas& m, double dt) {
  switch (m.bias) {
    case Bielas::Bias::integrated_legacy:
      return RateRandomWalk{m.bias_instability * std::sqrt(dt)};
    case Bielas::Bias::plain_white:
      return White{m.bias_instability * std::sqrt(dt)};
    case Bielas::Bias::gauss_markov:
      return GaussMarkov{m.bias_instability, m.correlation_time};
    case Bielas::Bias::flicker:
      return Flicker{m.bias_instability};
  }
  throw std::invalid_argument(fmt::format("{} is no reading of bias instability", static_cast<int>(m.bias)));
}

}  // namespace

Model Bielas::model(double dt) const {
  if (!(dt > 0 && std::isfinite(dt))) {
    throw std::invalid_argument(fmt::format("sample interval dt is {}; it must be positive and finite (s)", dt));
  }
  Model model{{White{arw}, bias_process(*this, dt)}, {}};
  if (rrw != 0) model.processes.emplace_back(RateRandomWalk{rrw});
  return model;
}

}  // namespace gyrobudget::inline v0::noise

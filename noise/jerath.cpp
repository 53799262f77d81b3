// SPDX-License-Identifier: MIT
#include "jerath.h"

namespace gyrobudget::inline v0::noise {

Model Jerath::model(double) const {
  return {{White{arw}, RateRandomWalk{rrw}},
          {filter == Filter::autoregressive ? autoregressive_flicker(bias_instability, taps)
                                            : moving_average_flicker(bias_instability, taps)}};
}

}  // namespace gyrobudget::inline v0::noise

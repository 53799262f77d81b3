// SPDX-License-Identifier: MIT
#include "gyrobudget/navigation/strapdown.h"

#include "gyrobudget/earth/paths.h"

#include <gtest/gtest.h>

namespace {
using namespace gyrobudget;
using navigation::NavigationState;
using navigation::Strapdown;

TEST(Strapdown, ascent) {
  const earth::Trajectory truth = earth::ascent({});
  const auto start = truth.at(0);
  Strapdown strapdown({start.p_eb_e, start.v_eb_e, start.q_eb});
  for (const auto& increment : truth.increments(0.01)) strapdown.step(increment, 0.01);
  EXPECT_LT((strapdown.state().p_eb_e - truth.at(83).p_eb_e).norm(), 1e-3);
}
}  // namespace

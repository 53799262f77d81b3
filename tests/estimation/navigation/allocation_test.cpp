// SPDX-License-Identifier: MIT
// The filter's loop asks the heap for nothing: malloc of this program is replaced by one that counts
// (operator new and Eigen end there).
#include "gyrobudget/estimation/navigation/filter.h"
#include "gyrobudget/vehicle/earth/paths.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || !defined(__GLIBC__)
#define GYROBUDGET_COUNTS 0  // a sanitizer brings its own malloc
#else
#define GYROBUDGET_COUNTS 1
#endif

namespace {
std::atomic<long> allocations{0};
}

#if GYROBUDGET_COUNTS
extern "C" {
void* __libc_malloc(std::size_t);                 // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void*, std::size_t);         // NOLINT(bugprone-reserved-identifier)
void* __libc_memalign(std::size_t, std::size_t);  // NOLINT(bugprone-reserved-identifier)
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
void* realloc(void* from, std::size_t size) {
  ++allocations;
  return __libc_realloc(from, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++allocations;
  return __libc_memalign(alignment, size);
}
}
#endif

using namespace gyrobudget;  // NOLINT

TEST(Allocation, TheLoopOfTheFilterAllocatesNothing) {
  if (GYROBUDGET_COUNTS == 0) GTEST_SKIP() << "malloc of this build is not ours to replace";
  EXPECT_GT((std::free(std::malloc(100)), allocations.load()), 0);  // it counts at all
  const long before_new = allocations;
  ::operator delete(::operator new(100));
  ASSERT_GT(allocations, before_new);

  earth::Cruise cruise;
  cruise.turn_acceleration = 5;
  cruise.duration = 20;
  const auto path = earth::cruise(cruise);
  const double dt = 0.01;
  const auto imu = path.increments(dt);
  const auto start = path.at(0);
  for (const int states : {9, 21, 45, 72})
    for (const auto form : {navigation::Form::plain, navigation::Form::joseph, navigation::Form::square_root})
      for (const bool considered : {false, true}) {
        navigation::ErrorStateModel model;
        for (int k = 0; k < states - navigation::kCoreStates; ++k) {
          navigation::ErrorTerm term;
          term.carrier = k % 2 == 0 ? navigation::Carrier::gyro : navigation::Carrier::accelerometer;
          term.effect = k % 3 == 0 ? navigation::Effect::scale_factor : navigation::Effect::bias;
          term.axis = k / 2 % 3;
          term.correlation_time = 100 + k;
          term.walk = 1e-9;
          term.considered = considered && k % 4 == 0;
          model.terms.push_back(term);
        }
        navigation::Filter::Options options;
        options.form = form;
        navigation::Filter filter(start.pose, model, 1e-6 * navigation::StateMatrix::Identity(states, states), options);
        const long before = allocations;
        int used = 0;
        for (std::size_t k = 0; k < imu.size(); ++k) {
          filter.propagate(imu[k], dt);
          if (k % 50 != 49) continue;
          const auto& at = filter.state();
          const Eigen::Vector3d one(1, 1, 1);
          for (const auto& z :
               {measure(navigation::PositionFix{at.p_eb_e, one}, filter.estimate()),
                measure(navigation::VelocityFix{at.v_eb_e, one}, filter.estimate()),
                measure(navigation::AttitudeFix{at.q_eb, one}, filter.estimate()),
                measure(navigation::HeightFix{earth::to_geodetic(at.p_eb_e).height, 1}, filter.estimate())})
            used += filter.update(z).status == navigation::Innovation::Status::used;
        }
        EXPECT_EQ(allocations - before, 0) << states << " states";
        EXPECT_EQ(used, 4 * static_cast<int>(imu.size()) / 50);
      }
}
